//! Rollers eliminated: what remains between a bushing and the teeth is its bore and the roller's teeth in series.
//!
//! Row of a roller with velocity w: `(M + B + T) w - C b + c s = M r`, where B is its bore, T its teeth, b the velocity of the
//! bushing, s the sprockets' coordinates and c their columns; without friction B = C. What is left has the form that teeth have
//! when bushings meet them: `held = K - C^T A C` with `A = (M + B + T)⁻¹` and K, the bore as the bushing feels it, columns
//! `C^T A c`, and on the border `-c^T A c`. Without friction a roller's turning moves nothing and is left as it is.

use pulp::Simd;

use super::blocks::{Block, Pair, Symmetric};
use super::border::Corner;
use super::contacts::{BASE, scaled};
use super::links::{Border, LinkTerms, Spatial};
use super::teeth::ToothTerms;
use crate::kernels::slopes::{RubGroup, SlopeGroup};
use crate::model::{Model, RollerModel};
use crate::vector::{
    Lanes, Mask, Numbers, Octet, PartialSums, WIDTH, load, padded_zeros, partial_load, parts, read,
    vectors, vectors_mut, write,
};

/// Eight rollers.
#[derive(Debug, Clone, Copy)]
struct RollerGroup {
    /// One where the bushing is on the front of its link, else zero.
    front_bushing: Octet,
    /// Whether anything bears on one of them.
    held: bool,
    /// A; without friction xx, yy, xy alone.
    inverse: [Octet; 6],
    /// A C: rows, then columns; without friction four entries alone.
    follow: [Octet; 9],
    /// Scratch of a solution: rollers that feel their own right-hand side only.
    free: [Octet; 3],
}

/// Rollers after elimination.
#[derive(Debug, Clone)]
pub(super) struct RollerTerms {
    mass: f64,
    inertia: f64,
    groups: Vec<RollerGroup>,
    /// A c of each coordinate on the border.
    solved: Vec<Border>,
    /// Scratch of a solution: what bushings feel, bushing k at [`BASE`] + k, the last one once more before the first.
    felt: [Numbers; 3],
    /// Scratch: velocities of fronts, of rears, the first one once more behind the last, and spins, likewise.
    ends: [Numbers; 5],
    /// Scratch: entries of the border with itself, or its right-hand sides.
    sums: Vec<PartialSums>,
}

impl RollerTerms {
    pub(super) fn new(model: &Model, rollers: &RollerModel) -> Self {
        let (n, border) = (model.links, model.wheel_coordinates());
        let none = Octet::default();
        let group = |first: usize| {
            let on_front =
                |k: usize| f64::from(u8::from(k < n && model.link_of_bushing(k % n) == k));
            RollerGroup {
                front_bushing: Octet(std::array::from_fn(|lane| on_front(first + lane))),
                held: false,
                inverse: [none; 6],
                follow: [none; 9],
                free: [none; 3],
            }
        };
        Self {
            mass: rollers.mass,
            inertia: rollers.inertia,
            groups: (0..n).step_by(WIDTH).map(group).collect(),
            solved: vec![vec![[none; 3]; n.div_ceil(WIDTH)]; border],
            felt: [(); 3].map(|()| padded_zeros(BASE + n)),
            ends: [(); 5].map(|()| padded_zeros(n + WIDTH)),
            sums: vec![PartialSums::default(); (border * border).max(1)],
        }
    }

    /// Eliminates all rollers from what teeth have added; `slopes` and `rubs` of the bores.
    #[inline(always)]
    pub(super) fn eliminate<S: Simd, const RUBBED: bool>(
        &mut self,
        simd: S,
        gamma: f64,
        (slopes, rubs): (&[SlopeGroup], &[RubGroup]),
        teeth: &mut ToothTerms,
        corner: &mut Corner,
    ) {
        let Self {
            mass,
            inertia,
            groups,
            solved,
            sums,
            ..
        } = self;
        let (mass, inertia) = (Lanes::splat(simd, *mass), Lanes::splat(simd, *inertia));
        let zero = mass.constant(0.0);
        let count = parts::<S>().len();
        let border = solved.len();
        sums.fill(PartialSums::default());
        for (number, group) in groups.iter_mut().enumerate() {
            let slopes = &slopes[number];
            let mut bound = false;
            for part in parts::<S>() {
                bound |= slopes.force.at(simd, part).exceeds(zero).any();
            }
            group.held = bound || teeth.touches(number * WIDTH);
            if !group.held {
                continue;
            }
            if bound {
                teeth.touch(number * WIDTH);
            }
            for part in parts::<S>() {
                let own = Own {
                    number,
                    part,
                    register: number * count + part,
                    mass,
                    inertia,
                    bore: bore::<S>(simd, gamma, slopes, part),
                };
                let solved = (&mut *group, &mut solved[..], &mut sums[..]);
                if RUBBED {
                    let bears = slopes.force.at(simd, part).greater(zero);
                    let rubbing = Rubbing::new(simd, gamma, &slopes.normal, &rubs[number], part);
                    own.eliminate_rubbed(simd, &rubbing.where_it(bears), teeth, solved);
                } else {
                    own.eliminate(simd, teeth, solved);
                }
            }
        }
        for above in 0..border {
            for j in above..border {
                let entry = -sums[above * border + j].total();
                corner.add(above, j, entry);
                if above < j {
                    corner.add(j, above, entry);
                }
            }
        }
    }

    /// Rollers that feel `right`, accelerations x, y and θ of all, and nothing else: what that does to the `border`, which is taken off
    /// it, and to links, a `column` of which is written.
    #[inline(always)]
    pub(super) fn solve_free<S: Simd, const RUBBED: bool>(
        &mut self,
        simd: S,
        right: &[f64],
        border: &mut [f64],
        links: &LinkTerms,
        column: &mut [[Octet; 3]],
    ) {
        let Self {
            mass,
            inertia,
            groups,
            solved,
            felt,
            sums,
            ..
        } = self;
        let (mass, inertia) = (Lanes::splat(simd, *mass), Lanes::splat(simd, *inertia));
        let zero = mass.constant(0.0);
        let n = right.len() / 3;
        let count = parts::<S>().len();
        sums.fill(PartialSums::default());
        for (number, group) in groups.iter_mut().enumerate() {
            for part in parts::<S>() {
                let i = number * count + part;
                let from = BASE + i * S::F64_LANES;
                let x = residual(simd, &right[..n], i);
                let y = residual(simd, &right[n..2 * n], i);
                let turn = residual(simd, &right[2 * n..], i);
                if !group.held {
                    write(&mut group.free, part, [x, y, turn]);
                    for felt in &mut *felt {
                        put(felt, from, zero);
                    }
                    continue;
                }
                let (x, y) = (mass * x, mass * y);
                if RUBBED {
                    let right = [x, y, inertia * turn];
                    let free = Spatial(read(simd, &group.inverse, part)).times(right);
                    write(&mut group.free, part, free);
                    let pushes = transposed_times(&read(simd, &group.follow, part), right);
                    for (felt, push) in felt.iter_mut().zip(pushes) {
                        put(felt, from, push);
                    }
                    for (solved, sum) in solved.iter().zip(&mut *sums) {
                        let [sx, sy, st] = read(simd, &solved[number], part);
                        sum.add(i, sx.mul_add(right[0], sy.mul_add(right[1], st * right[2])));
                    }
                    continue;
                }
                let [xx, yy, xy, ..] = read(simd, &group.inverse, part);
                let [free_x, free_y] = Symmetric([xx, yy, xy]).of(&Pair([x, y])).0;
                write(&mut group.free, part, [free_x, free_y, turn]);
                let [xx, xy, yx, yy, ..] = read(simd, &group.follow, part);
                let [push_x, push_y] = Block([xx, xy, yx, yy]).transposed_of(&Pair([x, y])).0;
                put(&mut felt[0], from, push_x);
                put(&mut felt[1], from, push_y);
                for (solved, sum) in solved.iter().zip(&mut *sums) {
                    let [sx, sy, _] = read(simd, &solved[number], part);
                    sum.add(i, sx.mul_add(x, sy * y));
                }
            }
        }
        for (entry, sum) in border.iter_mut().zip(&*sums) {
            *entry -= sum.total();
        }
        for felt in &mut *felt {
            felt[BASE - 1] = felt[BASE + n - 1];
        }
        links.gather_column::<S, RUBBED>(simd, felt, column);
    }

    /// Rollers that feel links, which have these velocities, and the `border` too; written to `to`.
    #[inline(always)]
    pub(super) fn solve_bound<S: Simd, const RUBBED: bool>(
        &mut self,
        simd: S,
        links: &LinkTerms,
        unknowns: &[[Octet; 3]],
        border: &[f64],
        to: &mut [f64],
    ) {
        let Self {
            groups,
            solved,
            ends,
            ..
        } = self;
        let n = to.len() / 3;
        let count = parts::<S>().len();
        links.write_ends(simd, unknowns, ends);
        for end in &mut ends[2..] {
            end[n] = end[0];
        }
        let zero = Lanes::splat(simd, 0.0);
        let [front_x, front_y, rear_x, rear_y, spin] = &*ends;
        for (number, group) in groups.iter_mut().enumerate() {
            if !group.held {
                continue;
            }
            for part in parts::<S>() {
                let from = (number * count + part) * S::F64_LANES;
                let on_front = group.front_bushing.at(simd, part).greater(zero);
                let x = on_front.select(at(simd, front_x, from), at(simd, rear_x, from + 1));
                let y = on_front.select(at(simd, front_y, from), at(simd, rear_y, from + 1));
                let mut own = read(simd, &group.free, part);
                if RUBBED {
                    let turn = on_front.select(at(simd, spin, from), at(simd, spin, from + 1));
                    let [a, b, c, d, e, f, g, h, i] = read(simd, &group.follow, part);
                    own = [
                        a.mul_add(x, b.mul_add(y, c.mul_add(turn, own[0]))),
                        d.mul_add(x, e.mul_add(y, f.mul_add(turn, own[1]))),
                        g.mul_add(x, h.mul_add(y, i.mul_add(turn, own[2]))),
                    ];
                } else {
                    let [xx, xy, yx, yy, ..] = read(simd, &group.follow, part);
                    own[0] = xx.mul_add(x, xy.mul_add(y, own[0]));
                    own[1] = yx.mul_add(x, yy.mul_add(y, own[1]));
                }
                for (solved, &moved) in solved.iter().zip(border) {
                    let moved = Lanes::splat(simd, moved);
                    let [x, y, turn] = read(simd, &solved[number], part);
                    own[0] = moved.negate_mul_add(x, own[0]);
                    own[1] = moved.negate_mul_add(y, own[1]);
                    if RUBBED {
                        own[2] = moved.negate_mul_add(turn, own[2]);
                    }
                }
                write(&mut group.free, part, own);
            }
        }
        for (axis, to) in to.chunks_exact_mut(n).enumerate() {
            super::write_octets(
                simd,
                #[inline(always)]
                |i| &groups[i].free[axis],
                to,
            );
        }
    }
}

/// A register of rollers that are being eliminated.
struct Own<S: Simd> {
    /// Number of their group, and of the register in it.
    number: usize,
    part: usize,
    /// Number of the register among all.
    register: usize,
    mass: Lanes<S>,
    inertia: Lanes<S>,
    /// B without friction.
    bore: Symmetric<S>,
}

/// Where what elimination leaves goes: the group, `A c` of every coordinate on the border, sums of the border's entries.
type Solved<'a> = (&'a mut RollerGroup, &'a mut [Border], &'a mut [PartialSums]);

/// How stiffly bores hold rollers to their bushings: xx, yy, xy.
#[inline(always)]
fn bore<S: Simd>(simd: S, gamma: f64, slopes: &SlopeGroup, part: usize) -> Symmetric<S> {
    let zero = Lanes::splat(simd, 0.0);
    let bears = slopes.force.at(simd, part).greater(zero);
    let [alpha, eta] = scaled(gamma, simd, slopes, part);
    let (alpha, eta) = (bears.select(alpha, zero), bears.select(eta, zero));
    let [nx, ny] = read(simd, &slopes.normal, part);
    Symmetric([
        alpha.mul_add(nx * nx, eta * (ny * ny)),
        alpha.mul_add(ny * ny, eta * (nx * nx)),
        (alpha - eta) * (nx * ny),
    ])
}

impl<S: Simd> Own<S> {
    /// Without friction: velocities x and y.
    #[inline(always)]
    fn eliminate(&self, simd: S, teeth: &mut ToothTerms, (group, solved, sums): Solved) {
        let Self {
            number,
            part,
            register: i,
            mass,
            bore,
            ..
        } = *self;
        let (from, border) = (BASE + i * S::F64_LANES, solved.len());
        let zero = mass.constant(0.0);
        let ToothTerms { held, column, .. } = teeth;
        let [held_xx, held_yy, held_xy] = held;
        let tooth = [
            at(simd, held_xx, from),
            at(simd, held_yy, from),
            at(simd, held_xy, from),
        ];
        let [xx, yy, xy] = tooth;
        let (xx, yy) = (mass + xx, mass + yy);
        let [bore_xx, bore_yy, bore_xy] = bore.0;
        let over = {
            let (a, d, b) = (xx + bore_xx, yy + bore_yy, xy + bore_xy);
            let over = mass.constant(1.0) / a.mul_add(d, -(b * b));
            Symmetric([d * over, a * over, -(b * over)])
        };
        let coupling = Block([bore_xx, bore_xy, bore_xy, bore_yy]);
        let follow = over.times_block(&coupling);
        // The bore and all that holds the roller in series: C A (M + T).
        let left = follow.transposed_times(&Block([xx, xy, xy, yy]));
        put(held_xx, from, left.0[0]);
        put(held_yy, from, left.0[1]);
        put(held_xy, from, left.0[2]);
        let [xx, yy, xy] = over.0;
        write(&mut group.inverse, part, [xx, yy, xy, zero, zero, zero]);
        let [xx, xy, yx, yy] = follow.0;
        let follow = [xx, xy, yx, yy, zero, zero, zero, zero, zero];
        write(&mut group.follow, part, follow);
        for j in 0..border {
            let [x, y, _] = &column[j];
            let own = Pair([at(simd, x, from), at(simd, y, from)]);
            let [moved_x, moved_y] = over.of(&own).0;
            write(&mut solved[j][number], part, [moved_x, moved_y, zero]);
            for (above, other) in column.iter().enumerate().take(j + 1) {
                let product =
                    at(simd, &other[0], from).mul_add(moved_x, at(simd, &other[1], from) * moved_y);
                sums[above * border + j].add(i, product);
            }
        }
        for (column, solved) in column.iter_mut().zip(&*solved) {
            let [x, y, _] = read(simd, &solved[number], part);
            let [x, y] = bore.of(&Pair([x, y])).0;
            put(&mut column[0], from, x);
            put(&mut column[1], from, y);
        }
    }

    /// With friction: velocities x, y and θ.
    #[inline(always)]
    fn eliminate_rubbed(
        &self,
        simd: S,
        rubbing: &Rubbing<S>,
        teeth: &mut ToothTerms,
        (group, solved, sums): Solved,
    ) {
        let Self {
            number,
            part,
            register: i,
            mass,
            inertia,
            bore,
        } = *self;
        let (from, border) = (BASE + i * S::F64_LANES, solved.len());
        let ToothTerms {
            held, spun, column, ..
        } = teeth;
        let [held_xx, held_yy, held_xy] = held;
        let tooth = [
            at(simd, held_xx, from),
            at(simd, held_yy, from),
            at(simd, held_xy, from),
        ];
        let [spun_x, spun_y, spun_own] = spun;
        let own = Spatial([
            mass + tooth[0],
            tooth[2],
            at(simd, spun_x, from),
            mass + tooth[1],
            at(simd, spun_y, from),
            inertia + at(simd, spun_own, from),
        ]);
        let inverse = own
            .plus(&rubbing.block(&bore, rubbing.of_roller, rubbing.of_roller))
            .inverse();
        let coupling = rubbing.coupling(&bore);
        let follow = times_spatial(&inverse, &coupling);
        let left = rubbing
            .block(&bore, rubbing.of_bushing, rubbing.of_bushing)
            .less_product(&coupling, &follow);
        let [xx, xy, xz, yy, yz, zz] = left.0;
        put(held_xx, from, xx);
        put(held_yy, from, yy);
        put(held_xy, from, xy);
        put(spun_x, from, xz);
        put(spun_y, from, yz);
        put(spun_own, from, zz);
        write(&mut group.inverse, part, inverse.0);
        write(&mut group.follow, part, follow);
        for j in 0..border {
            let [x, y, turn] = &column[j];
            let own = [at(simd, x, from), at(simd, y, from), at(simd, turn, from)];
            let moved = inverse.times(own);
            write(&mut solved[j][number], part, moved);
            for (above, other) in column.iter().enumerate().take(j + 1) {
                let product = at(simd, &other[0], from).mul_add(
                    moved[0],
                    at(simd, &other[1], from)
                        .mul_add(moved[1], at(simd, &other[2], from) * moved[2]),
                );
                sums[above * border + j].add(i, product);
            }
        }
        for (column, solved) in column.iter_mut().zip(&*solved) {
            let moved = read(simd, &solved[number], part);
            let felt = transposed_times(&coupling, moved);
            for (axis, felt) in felt.into_iter().enumerate() {
                put(&mut column[axis], from, felt);
            }
        }
    }
}

/// Numbers from entry `from` on.
#[inline(always)]
fn at<S: Simd>(simd: S, array: &[f64], from: usize) -> Lanes<S> {
    load(simd, &vectors::<S>(&array[from..], 1)[0])
}

/// Writes them.
#[inline(always)]
fn put<S: Simd>(array: &mut [f64], from: usize, values: Lanes<S>) {
    vectors_mut::<S>(&mut array[from..], 1)[0] = values.values();
}

/// Register `i` of an array that may end within it; zeros after that.
#[inline(always)]
fn residual<S: Simd>(simd: S, array: &[f64], i: usize) -> Lanes<S> {
    let rest = &array[(i * S::F64_LANES).min(array.len())..];
    if rest.len() >= S::F64_LANES {
        at(simd, rest, 0)
    } else {
        partial_load(simd, rest)
    }
}

/// Friction of bushings in bores: τ along `across` at the contact, which lies so far along the normal from both centres.
struct Rubbing<S: Simd> {
    tau: Lanes<S>,
    across: [Lanes<S>; 2],
    of_roller: Lanes<S>,
    of_bushing: Lanes<S>,
}

impl<S: Simd> Rubbing<S> {
    #[inline(always)]
    fn new(simd: S, gamma: f64, normal: &[Octet; 2], rubs: &RubGroup, part: usize) -> Self {
        let [nx, ny] = read(simd, normal, part);
        let [of_roller, of_bushing] = read(simd, &rubs.places, part);
        Self {
            tau: Lanes::splat(simd, gamma) * rubs.slope.at(simd, part),
            across: [-ny, nx],
            of_roller,
            of_bushing,
        }
    }

    /// None elsewhere.
    #[inline(always)]
    fn where_it(self, bears: Mask<S>) -> Self {
        let zero = self.tau.constant(0.0);
        Self {
            tau: bears.select(self.tau, zero),
            across: self.across,
            of_roller: bears.select(self.of_roller, zero),
            of_bushing: bears.select(self.of_bushing, zero),
        }
    }

    /// The bore's block of one body whose arms are `first` and `second`.
    #[inline(always)]
    fn block(&self, bore: &Symmetric<S>, first: Lanes<S>, second: Lanes<S>) -> Spatial<S> {
        let ([xx, yy, xy], [tx, ty]) = (bore.0, self.across);
        let tau = self.tau;
        Spatial([
            (tau * tx).mul_add(tx, xx),
            (tau * tx).mul_add(ty, xy),
            (tau * tx) * first,
            (tau * ty).mul_add(ty, yy),
            (tau * ty) * first,
            (tau * first) * second,
        ])
    }

    /// C: rows of the roller, columns of the bushing.
    #[inline(always)]
    fn coupling(&self, bore: &Symmetric<S>) -> [Lanes<S>; 9] {
        let ([xx, yy, xy], [tx, ty]) = (bore.0, self.across);
        let tau = self.tau;
        let (roller, bushing) = (tau * self.of_roller, tau * self.of_bushing);
        let crossed = (tau * tx).mul_add(ty, xy);
        [
            (tau * tx).mul_add(tx, xx),
            crossed,
            bushing * tx,
            crossed,
            (tau * ty).mul_add(ty, yy),
            bushing * ty,
            roller * tx,
            roller * ty,
            roller * self.of_bushing,
        ]
    }
}

/// A symmetric matrix times another one, row by row.
#[inline(always)]
fn times_spatial<S: Simd>(left: &Spatial<S>, right: &[Lanes<S>; 9]) -> [Lanes<S>; 9] {
    let [a, b, c, d, e, f, g, h, i] = *right;
    let [xx, yx, zx] = left.times([a, d, g]);
    let [xy, yy, zy] = left.times([b, e, h]);
    let [xz, yz, zz] = left.times([c, f, i]);
    [xx, xy, xz, yx, yy, yz, zx, zy, zz]
}

/// m^T v
#[inline(always)]
fn transposed_times<S: Simd>(m: &[Lanes<S>; 9], [x, y, z]: [Lanes<S>; 3]) -> [Lanes<S>; 3] {
    let [a, b, c, d, e, f, g, h, i] = *m;
    [
        a.mul_add(x, d.mul_add(y, g * z)),
        b.mul_add(x, e.mul_add(y, h * z)),
        c.mul_add(x, f.mul_add(y, i * z)),
    ]
}

impl<S: Simd> Spatial<S> {
    #[inline(always)]
    fn plus(&self, other: &Self) -> Self {
        let mut sum = *self;
        for (entry, other) in sum.0.iter_mut().zip(other.0) {
            *entry = *entry + other;
        }
        sum
    }

    /// self - left^T right, where that is symmetric.
    #[inline(always)]
    fn less_product(&self, left: &[Lanes<S>; 9], right: &[Lanes<S>; 9]) -> Self {
        let [a, b, c, d, e, f, g, h, i] = *right;
        let [xx, _, _] = transposed_times(left, [a, d, g]);
        let [xy, yy, _] = transposed_times(left, [b, e, h]);
        let [xz, yz, zz] = transposed_times(left, [c, f, i]);
        let [own_xx, own_xy, own_xz, own_yy, own_yz, own_zz] = self.0;
        Self([
            own_xx - xx,
            own_xy - xy,
            own_xz - xz,
            own_yy - yy,
            own_yz - yz,
            own_zz - zz,
        ])
    }
}

//! Elimination of the rollers: between a bushing and the teeth, the contact in the roller's bore and the roller's teeth remain in
//! series.
//!
//! Row of a roller with velocity w: `(M + B + T) w - C b + c s = M r`. B is the stiffness of its bore, T that of its teeth, and C
//! couples it with its bushing. b is the velocity of the bushing, s the sprockets' coordinates and c their columns. Without
//! friction B = C. The remainder has the form of teeth in contact with bushings: `held = K - C^T A C` with `A = (M + B + T)⁻¹`,
//! columns `C^T A c`, and `-c^T A c` on the border. K is the stiffness of the bore at the bushing. Without friction no force
//! depends on a roller's rotation, whose residual stays unchanged.

use pulp::Simd;

use super::blocks::{Block, Pair, Symmetric};
use super::border::Corner;
use super::contacts::{BASE, scaled};
use super::entries::{Entries, EntriesMut};
use super::links::{Border, LinkTerms, Spatial};
use super::teeth::ToothTerms;
use crate::chain::model::{Model, RollerModel};
use crate::chain::rhs::slopes::{FrictionGroup, SlopeGroup};
use crate::math::simd::{
    Lanes, Mask, Numbers, Octet, PartialSums, WIDTH, load, padded_zeros, parts, read, vectors,
    vectors_mut, write,
};

/// Eight rollers.
#[derive(Debug, Clone, Copy)]
struct RollerGroup {
    /// One where the bushing is on the front of its link, else zero.
    front_bushing: Octet,
    /// Whether a bushing or a tooth touches one of these rollers.
    held: bool,
    /// Whether a tooth touches one of these rollers.
    meshes: bool,
    /// A; without friction only xx, yy, xy.
    inverse: [Octet; 6],
    /// A C in row-major order; without friction only four entries.
    follow: [Octet; 9],
    /// Scratch of a solution: velocities of the rollers by their own right-hand side only.
    free: [Octet; 3],
}

/// Eliminated rollers.
#[derive(Debug, Clone)]
pub(super) struct RollerTerms {
    mass: f64,
    inertia: f64,
    groups: Vec<RollerGroup>,
    /// A c of each coordinate on the border.
    solved: Vec<Border>,
    /// Scratch of a solution: right-hand sides of the bushings, bushing k at [`BASE`] + k; a copy of the last one precedes the
    /// first.
    felt: [Numbers; 3],
    /// Scratch: velocities of fronts, of rears and angular velocities; for the last two a copy of the first one follows the last.
    ends: [Numbers; 5],
}

impl RollerTerms {
    /// Allocate the elimination of the rollers of `model`.
    pub(super) fn new(model: &Model, rollers: &RollerModel) -> Self {
        let (n, border) = (model.links, model.wheel_coordinates());
        let none = Octet::default();
        let group = |first: usize| {
            let on_front =
                |k: usize| f64::from(u8::from(k < n && model.link_of_bushing(k % n) == k));
            RollerGroup {
                front_bushing: Octet(std::array::from_fn(|lane| on_front(first + lane))),
                held: false,
                meshes: false,
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
        }
    }

    /// Eliminate all rollers from the terms of the teeth; `slopes` and `rubs` are those of the contacts in the bores.
    #[inline(always)]
    pub(super) fn eliminate<S: Simd, const RUBBED: bool>(
        &mut self,
        simd: S,
        gamma: f64,
        (slopes, rubs): (&[SlopeGroup], &[FrictionGroup]),
        teeth: &mut ToothTerms,
        corner: &mut Corner,
    ) {
        let (mass, inertia) = (
            Lanes::splat(simd, self.mass),
            Lanes::splat(simd, self.inertia),
        );
        let zero = mass.constant(0.0);
        let count = parts::<S>().len();
        for (number, group) in self.groups.iter_mut().enumerate() {
            let slopes = &slopes[number];
            let mut bound = false;
            for part in parts::<S>() {
                bound |= slopes.force.at(simd, part).exceeds(zero).any();
            }
            group.meshes = teeth.touches(number * WIDTH);
            group.held = bound || group.meshes;
            if bound {
                teeth.touch(number * WIDTH);
            }
        }
        let registers = self.groups.len() * count;
        let held = of_column_mut::<S>(&mut teeth.held, registers);
        let spun = of_column_mut::<S>(&mut teeth.spun, registers);
        let mut on_teeth = OnTeeth { simd, held, spun };
        for (number, group) in self.groups.iter_mut().enumerate() {
            if !group.held {
                continue;
            }
            let slopes = &slopes[number];
            for part in parts::<S>() {
                let i = number * count + part;
                let bore = bore::<S>(simd, gamma, slopes, part);
                if RUBBED {
                    let bears = slopes.force.at(simd, part).greater(zero);
                    let rubbing = Rubbing::new(simd, gamma, &slopes.normal, &rubs[number], part);
                    let rubbing = rubbing.where_it(bears);
                    on_teeth.eliminate_rubbed(i, [mass, inertia], &bore, &rubbing, (group, part));
                } else {
                    on_teeth.eliminate(i, mass, &bore, (group, part));
                }
            }
        }
        self.eliminate_from_border::<S, RUBBED>(simd, &mut teeth.column, corner);
    }

    /// Eliminate the rollers from the border: `A c`, the columns of the bushings `C^T A c`, and `-c^T A c` on the border.
    #[inline(always)]
    fn eliminate_from_border<S: Simd, const RUBBED: bool>(
        &mut self,
        simd: S,
        columns: &mut [[Numbers; 3]],
        corner: &mut Corner,
    ) {
        let count = parts::<S>().len();
        let registers = self.groups.len() * count;
        let Self { groups, solved, .. } = self;
        for j in 0..columns.len() {
            let solved = &mut solved[j];
            for above in 0..=j {
                let left = of_column::<S>(&columns[above], registers);
                let right = of_column::<S>(&columns[j], registers);
                let mut sum = PartialSums::default();
                for (number, group) in groups.iter().enumerate() {
                    if !group.meshes {
                        continue;
                    }
                    for part in parts::<S>() {
                        let i = number * count + part;
                        let own = |axis: usize| load(simd, &left[axis][i]);
                        if above == 0 {
                            let c = |axis: usize| load(simd, &right[axis][i]);
                            let moved = if RUBBED {
                                Spatial(read(simd, &group.inverse, part)).times([c(0), c(1), c(2)])
                            } else {
                                let [x, y] = group.alone(simd, part).of(&Pair([c(0), c(1)])).0;
                                [x, y, x.constant(0.0)]
                            };
                            write(&mut solved[number], part, moved);
                        }
                        let [x, y, turn] = read(simd, &solved[number], part);
                        let mut rest = own(1) * y;
                        if RUBBED {
                            rest = own(1).mul_add(y, own(2) * turn);
                        }
                        sum.add(i, own(0).mul_add(x, rest));
                    }
                }
                let entry = -sum.total();
                corner.add(above, j, entry);
                if above < j {
                    corner.add(j, above, entry);
                }
            }
        }
        for column in columns {
            let [x, y, turn] = of_column_mut::<S>(column, registers);
            for (number, group) in groups.iter().enumerate() {
                if !group.meshes {
                    continue;
                }
                for part in parts::<S>() {
                    let i = number * count + part;
                    let c = [load(simd, &x[i]), load(simd, &y[i])];
                    if RUBBED {
                        let c = [c[0], c[1], load(simd, &turn[i])];
                        let follow = read(simd, &group.follow, part);
                        let felt = transposed_times(&follow, c);
                        (x[i], y[i]) = (felt[0].values(), felt[1].values());
                        turn[i] = felt[2].values();
                    } else {
                        let [felt_x, felt_y] = group.follows(simd, part).transposed_of(&Pair(c)).0;
                        (x[i], y[i]) = (felt_x.values(), felt_y.values());
                    }
                }
            }
        }
    }

    /// Solve the rollers for `right`, residuals x, y and θ of all, with bushings and border at rest. Subtract c^T A M r from
    /// `border` and write the `column` of the links, gathered from C^T A M r.
    #[inline(always)]
    pub(super) fn solve_free<S: Simd, const RUBBED: bool>(
        &mut self,
        simd: S,
        right: &[f64],
        border: &mut [f64],
        links: &LinkTerms,
        column: &mut [[Octet; 3]],
    ) {
        let (mass, inertia) = (
            Lanes::splat(simd, self.mass),
            Lanes::splat(simd, self.inertia),
        );
        let zero = mass.constant(0.0);
        let n = right.len() / 3;
        let count = parts::<S>().len();
        let registers = self.groups.len() * count;
        let [felt_x, felt_y, felt_turn] = of_column_mut::<S>(&mut self.felt, registers);
        let right_x = Entries::<S>::of(simd, &right[..n]);
        let right_y = Entries::<S>::of(simd, &right[n..2 * n]);
        let right_turn = Entries::<S>::of(simd, &right[2 * n..]);
        for (number, group) in self.groups.iter_mut().enumerate() {
            for part in parts::<S>() {
                let i = number * count + part;
                if !group.held {
                    (felt_x[i], felt_y[i]) = (zero.values(), zero.values());
                    if RUBBED {
                        felt_turn[i] = zero.values();
                    }
                    continue;
                }
                let (x, y) = (mass * right_x.at(i), mass * right_y.at(i));
                if RUBBED {
                    let right = [x, y, inertia * right_turn.at(i)];
                    let free = Spatial(read(simd, &group.inverse, part)).times(right);
                    write(&mut group.free, part, free);
                    let follow = read(simd, &group.follow, part);
                    let [push_x, push_y, twist] = transposed_times(&follow, right);
                    (felt_x[i], felt_y[i]) = (push_x.values(), push_y.values());
                    felt_turn[i] = twist.values();
                } else {
                    let right = Pair([x, y]);
                    let [free_x, free_y] = group.alone(simd, part).of(&right).0;
                    group.free[0].put(part, free_x);
                    group.free[1].put(part, free_y);
                    let [push_x, push_y] = group.follows(simd, part).transposed_of(&right).0;
                    (felt_x[i], felt_y[i]) = (push_x.values(), push_y.values());
                }
            }
        }
        for (solved, entry) in self.solved.iter().zip(border) {
            let mut sum = PartialSums::default();
            for (number, (group, solved)) in self.groups.iter().zip(solved).enumerate() {
                if !group.meshes {
                    continue;
                }
                for part in parts::<S>() {
                    let i = number * count + part;
                    let (x, y) = (mass * right_x.at(i), mass * right_y.at(i));
                    let [solved_x, solved_y, solved_turn] = read(simd, solved, part);
                    let mut rest = solved_y * y;
                    if RUBBED {
                        rest = solved_y.mul_add(y, solved_turn * (inertia * right_turn.at(i)));
                    }
                    sum.add(i, solved_x.mul_add(x, rest));
                }
            }
            *entry -= sum.total();
        }
        for felt in &mut self.felt {
            felt[BASE - 1] = felt[BASE + n - 1];
        }
        links.gather_column::<S, RUBBED>(simd, &self.felt, column);
    }

    /// Solve the rollers with these velocities of the links and the `border`: w = A (M r + C b - c s). `to` holds the right-hand
    /// side of [`Self::solve_free`]; rollers without contact keep it.
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
        let registers = groups.len() * count;
        links.write_ends::<S, RUBBED>(simd, unknowns, ends);
        for end in &mut ends[2..] {
            end[n] = end[0];
        }
        let [front_x, front_y, rear_x, rear_y, spin] = &*ends;
        let fronts = [
            vectors::<S>(front_x, registers),
            vectors::<S>(front_y, registers),
            vectors::<S>(spin, registers),
        ];
        let rears = [
            vectors::<S>(&rear_x[1..], registers),
            vectors::<S>(&rear_y[1..], registers),
            vectors::<S>(&spin[1..], registers),
        ];
        let (to_x, to) = to.split_at_mut(n);
        let (to_y, to_turn) = to.split_at_mut(n);
        let mut to_x = EntriesMut::<S>::of(simd, to_x);
        let mut to_y = EntriesMut::<S>::of(simd, to_y);
        let mut to_turn = EntriesMut::<S>::of(simd, to_turn);
        let zero = Lanes::splat(simd, 0.0);
        for (number, group) in groups.iter().enumerate() {
            if !group.held {
                continue;
            }
            for part in parts::<S>() {
                let i = number * count + part;
                let on_front = group.front_bushing.at(simd, part).greater(zero);
                let [free_x, free_y, free_turn] = &group.free;
                let x = end(simd, on_front, &fronts[0][i], &rears[0][i]);
                let y = end(simd, on_front, &fronts[1][i], &rears[1][i]);
                let mut own = [free_x.at(simd, part), free_y.at(simd, part), zero];
                if RUBBED {
                    let turn = end(simd, on_front, &fronts[2][i], &rears[2][i]);
                    own[2] = free_turn.at(simd, part);
                    let [a, b, c, d, e, f, g, h, i] = read(simd, &group.follow, part);
                    own = [
                        a.mul_add(x, b.mul_add(y, c.mul_add(turn, own[0]))),
                        d.mul_add(x, e.mul_add(y, f.mul_add(turn, own[1]))),
                        g.mul_add(x, h.mul_add(y, i.mul_add(turn, own[2]))),
                    ];
                } else {
                    let [xx, xy, yx, yy] = group.follows(simd, part).0;
                    own[0] = xx.mul_add(x, xy.mul_add(y, own[0]));
                    own[1] = yx.mul_add(x, yy.mul_add(y, own[1]));
                }
                if group.meshes {
                    for (solved, &moved) in solved.iter().zip(border) {
                        let moved = Lanes::splat(simd, moved);
                        let [x, y, turn] = read(simd, &solved[number], part);
                        own[0] = moved.negate_mul_add(x, own[0]);
                        own[1] = moved.negate_mul_add(y, own[1]);
                        if RUBBED {
                            own[2] = moved.negate_mul_add(turn, own[2]);
                        }
                    }
                }
                to_x.set(i, own[0]);
                to_y.set(i, own[1]);
                if RUBBED {
                    to_turn.set(i, own[2]);
                }
            }
        }
    }
}

/// Return the value of the end that carries the bushing.
#[inline(always)]
fn end<S: Simd>(simd: S, on_front: Mask<S>, front: &S::f64s, rear: &S::f64s) -> Lanes<S> {
    on_front.select(load(simd, front), load(simd, rear))
}

/// Return the SIMD vectors of a column of the border.
#[inline(always)]
fn of_column<S: Simd>(column: &[Numbers; 3], registers: usize) -> [&[S::f64s]; 3] {
    let [x, y, turn] = column;
    [
        vectors::<S>(&x[BASE..], registers),
        vectors::<S>(&y[BASE..], registers),
        vectors::<S>(&turn[BASE..], registers),
    ]
}

/// Return the SIMD vectors of a column of the border for writing.
#[inline(always)]
fn of_column_mut<S: Simd>(column: &mut [Numbers; 3], registers: usize) -> [&mut [S::f64s]; 3] {
    let [x, y, turn] = column;
    [
        vectors_mut::<S>(&mut x[BASE..], registers),
        vectors_mut::<S>(&mut y[BASE..], registers),
        vectors_mut::<S>(&mut turn[BASE..], registers),
    ]
}

/// Stiffness of the teeth at the bushings, vector by vector. On input it acts on the rollers; on output the rollers act on the
/// bushings with it.
struct OnTeeth<'a, S: Simd> {
    simd: S,
    held: [&'a mut [S::f64s]; 3],
    spun: [&'a mut [S::f64s]; 3],
}

impl RollerGroup {
    /// Return A without friction.
    #[inline(always)]
    fn alone<S: Simd>(&self, simd: S, part: usize) -> Symmetric<S> {
        let [xx, yy, xy, ..] = &self.inverse;
        Symmetric([xx.at(simd, part), yy.at(simd, part), xy.at(simd, part)])
    }

    /// Return A C without friction.
    #[inline(always)]
    fn follows<S: Simd>(&self, simd: S, part: usize) -> Block<S> {
        let [xx, xy, yx, yy, ..] = &self.follow;
        Block([
            xx.at(simd, part),
            xy.at(simd, part),
            yx.at(simd, part),
            yy.at(simd, part),
        ])
    }
}

/// Return the stiffness of bores without friction, α n n^T + η t t^T: xx, yy, xy; zero without contact.
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

impl<S: Simd> OnTeeth<'_, S> {
    /// Eliminate vector `i` of rollers without friction: velocities x and y.
    #[inline(always)]
    fn eliminate(
        &mut self,
        i: usize,
        mass: Lanes<S>,
        bore: &Symmetric<S>,
        (group, part): (&mut RollerGroup, usize),
    ) {
        let [held_xx, held_yy, held_xy] = &mut self.held;
        let at = |array: &[S::f64s]| load(self.simd, &array[i]);
        let (xx, yy, xy) = (mass + at(held_xx), mass + at(held_yy), at(held_xy));
        let [bore_xx, bore_yy, bore_xy] = bore.0;
        let (a, d, b) = (xx + bore_xx, yy + bore_yy, xy + bore_xy);
        let over = mass.constant(1.0) / a.mul_add(d, -(b * b));
        let inverse = Symmetric([d * over, a * over, -(b * over)]);
        let follow = inverse.times_block(&Block([bore_xx, bore_xy, bore_xy, bore_yy]));
        // The bore in series with teeth and inertia, since C = B: B - B A B = C A (M + T).
        let left = follow.transposed_times(&Block([xx, xy, xy, yy]));
        held_xx[i] = left.0[0].values();
        held_yy[i] = left.0[1].values();
        held_xy[i] = left.0[2].values();
        for (octet, entry) in group.inverse.iter_mut().zip(inverse.0) {
            octet.put(part, entry);
        }
        for (octet, entry) in group.follow.iter_mut().zip(follow.0) {
            octet.put(part, entry);
        }
    }

    /// Eliminate vector `i` of rollers with friction: velocities x, y and θ.
    #[inline(always)]
    fn eliminate_rubbed(
        &mut self,
        i: usize,
        [mass, inertia]: [Lanes<S>; 2],
        bore: &Symmetric<S>,
        rubbing: &Rubbing<S>,
        (group, part): (&mut RollerGroup, usize),
    ) {
        let at = |array: &[S::f64s]| load(self.simd, &array[i]);
        let own = Spatial([
            mass + at(self.held[0]),
            at(self.held[2]),
            at(self.spun[0]),
            mass + at(self.held[1]),
            at(self.spun[1]),
            inertia + at(self.spun[2]),
        ]);
        let inverse = own
            .plus(&rubbing.block(bore, rubbing.of_roller, rubbing.of_roller))
            .inverse();
        let coupling = rubbing.coupling(bore);
        let follow = times_spatial(&inverse, &coupling);
        // held = K - C^T A C.
        let left = rubbing
            .block(bore, rubbing.of_bushing, rubbing.of_bushing)
            .less_product(&coupling, &follow);
        let [xx, xy, xz, yy, yz, zz] = left.0;
        for (array, entry) in self.held.iter_mut().zip([xx, yy, xy]) {
            array[i] = entry.values();
        }
        for (array, entry) in self.spun.iter_mut().zip([xz, yz, zz]) {
            array[i] = entry.values();
        }
        write(&mut group.inverse, part, inverse.0);
        write(&mut group.follow, part, follow);
    }
}

/// Friction of bushings in bores: τ along `across` at the contact, with its positions along the normal from both centres.
struct Rubbing<S: Simd> {
    tau: Lanes<S>,
    across: [Lanes<S>; 2],
    of_roller: Lanes<S>,
    of_bushing: Lanes<S>,
}

impl<S: Simd> Rubbing<S> {
    /// Return the friction of vector `part` of bores.
    #[inline(always)]
    fn new(simd: S, gamma: f64, normal: &[Octet; 2], rubs: &FrictionGroup, part: usize) -> Self {
        let [nx, ny] = read(simd, normal, part);
        let [of_roller, of_bushing] = read(simd, &rubs.places, part);
        Self {
            tau: Lanes::splat(simd, gamma) * rubs.slope.at(simd, part),
            across: [-ny, nx],
            of_roller,
            of_bushing,
        }
    }

    /// Return the same with zeros where no contact exists.
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

    /// Return the block of the bore on one body with arms `first` and `second`.
    ///
    /// With t = `across` and the arm a of the body: B + τ t t^T for translation, τ a t for the coupling, τ a² for rotation.
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

    /// Return C: rows of the roller, columns of the bushing.
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

/// Return a symmetric matrix times a general one, row-major.
#[inline(always)]
fn times_spatial<S: Simd>(left: &Spatial<S>, right: &[Lanes<S>; 9]) -> [Lanes<S>; 9] {
    let [a, b, c, d, e, f, g, h, i] = *right;
    let [xx, yx, zx] = left.times([a, d, g]);
    let [xy, yy, zy] = left.times([b, e, h]);
    let [xz, yz, zz] = left.times([c, f, i]);
    [xx, xy, xz, yx, yy, yz, zx, zy, zz]
}

/// Return m^T v.
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
    /// Return self + other.
    #[inline(always)]
    fn plus(&self, other: &Self) -> Self {
        let mut sum = *self;
        for (entry, other) in sum.0.iter_mut().zip(other.0) {
            *entry = *entry + other;
        }
        sum
    }

    /// Return self - left^T right, which is symmetric.
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

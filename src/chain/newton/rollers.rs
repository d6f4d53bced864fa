//! Elimination of the rollers: between a bushing and the teeth, the contact in the roller's bore and the roller's teeth remain in
//! series.
//!
//! Row of a roller with velocity w: `(M + B + T) w - C b + c s = M r`. B is the stiffness of its bore, T that of its teeth, and C
//! couples it with its bushing. b is the velocity of the bushing, s the sprockets' coordinates and c their columns. Without
//! friction B = C. The remainder has the form of teeth in contact with bushings, whose stiffness is `K - C^T A C` with `A = (M + B + T)⁻¹`,
//! columns `C^T A c`, and `-c^T A c` on the border. K is the stiffness of the bore at the bushing. Without friction no force
//! depends on a roller's rotation, whose residual stays unchanged.

use super::border::Corner;
use super::bores::{BoreFriction, bore};
use super::links::{Border, LinkTerms};
use super::ring::BASE;
use super::roller_group::{OnTeeth, RollerGroup, RollerResidual};
use super::teeth::ToothTerms;
use crate::chain::arrays::slopes::ContactSlopes;
use crate::chain::model::{Model, RollerModel};
use crate::math::simd::{
    Entries, EntriesMut, Lanes, Number, Numbers, Pack8, PartialSums, Vectors, WIDTH, load, packs,
    packs_from, padded_zeros, parts, read, rounded_part, vectors_from, vectors_from_mut, write,
};

/// Eliminated rollers.
#[derive(Debug, Clone)]
pub(super) struct RollerTerms<T: Number> {
    mass: f64,
    inertia: f64,
    groups: Vec<RollerGroup<T>>,
    /// A c of each coordinate on the border.
    solved: Vec<Border<T>>,
    /// Scratch of a solution: right-hand sides of the bushings, bushing k at [`BASE`] + k; a copy of the last one precedes the
    /// first.
    on_links: [Numbers<T>; 3],
    /// Scratch: velocities of fronts, of rears and angular velocities; for the last two a copy of the first one follows the last.
    ends: [Numbers; 5],
}

impl<T: Number> RollerTerms<T> {
    /// Allocate the elimination of the rollers of `model`.
    pub(super) fn new(model: &Model, rollers: &RollerModel) -> Self {
        let (n, border) = (model.links, model.wheel_coordinates());
        Self {
            mass: rollers.mass,
            inertia: rollers.inertia,
            groups: (0..n)
                .step_by(WIDTH)
                .map(|first| RollerGroup::new(model, first))
                .collect(),
            solved: vec![vec![[Pack8::default(); 3]; n.div_ceil(WIDTH)]; border],
            on_links: [(); 3].map(|()| padded_zeros(BASE + n)),
            ends: [(); 5].map(|()| padded_zeros(n + WIDTH)),
        }
    }

    /// Eliminate all rollers from the terms of the teeth; `bores` has the slopes of the contacts in the bores.
    #[inline(always)]
    pub(super) fn eliminate<S: Vectors<Number = T>, const FRICTION: bool>(
        &mut self,
        simd: S,
        gamma: f64,
        bores: &ContactSlopes,
        teeth: &mut ToothTerms<T>,
        corner: &mut Corner,
    ) {
        let inertias = self.inertias(simd);
        let zero = Lanes::splat(simd, 0.0);
        let count = parts::<S>().len();
        for (number, (group, slopes)) in self.groups.iter_mut().zip(&bores.normal).enumerate() {
            let mut bound = false;
            for part in parts::<S>() {
                bound |= slopes.force.rounded(simd, part).exceeds(zero).any();
            }
            bound &= gamma > 0.0; // as of the teeth
            group.meshes = teeth.touches(number * WIDTH);
            group.touches = bound || group.meshes;
            if bound {
                teeth.touch(number * WIDTH);
            }
        }
        let registers = self.groups.len() * count;
        let tooth_stiffness = of_column_mut::<S>(&mut teeth.tooth_stiffness, registers);
        let spun = of_column_mut::<S>(&mut teeth.spun, registers);
        let mut on_teeth = OnTeeth {
            simd,
            tooth_stiffness,
            spun,
        };
        for (number, (group, slopes)) in self.groups.iter_mut().zip(&bores.normal).enumerate() {
            if !group.touches {
                continue;
            }
            for part in parts::<S>() {
                let i = number * count + part;
                let bore = bore::<S>(simd, gamma, slopes, part);
                if FRICTION {
                    let bears = slopes.force.rounded(simd, part).greater(zero);
                    let friction = &bores.friction[number];
                    let friction = BoreFriction::new(simd, gamma, &slopes.normal, friction, part);
                    let friction = friction.where_it(bears);
                    on_teeth.eliminate_rubbed(i, inertias, &bore, &friction, (group, part));
                } else {
                    on_teeth.eliminate(i, inertias[0], &bore, (group, part));
                }
            }
        }
        self.eliminate_from_border::<S, FRICTION>(simd, &mut teeth.column, corner);
    }

    /// Return mass and moment of inertia of a roller in all lanes.
    #[inline(always)]
    fn inertias<S: Vectors<Number = T>>(&self, simd: S) -> [Lanes<S>; 2] {
        [
            Lanes::splat(simd, self.mass),
            Lanes::splat(simd, self.inertia),
        ]
    }

    /// Eliminate the rollers from the border: `A c`, the columns of the bushings `C^T A c`, and `-c^T A c` on the border.
    #[inline(always)]
    fn eliminate_from_border<S: Vectors<Number = T>, const FRICTION: bool>(
        &mut self,
        simd: S,
        columns: &mut [[Numbers<T>; 3]],
        corner: &mut Corner,
    ) {
        for (j, column) in columns.iter().enumerate() {
            self.solve_column::<S, FRICTION>(simd, j, column);
            for (above, left) in columns.iter().enumerate().take(j + 1) {
                let entry = -self.product::<S, FRICTION>(simd, left, j);
                corner.add(above, j, entry);
                if above < j {
                    corner.add(j, above, entry);
                }
            }
        }
        for column in columns {
            self.pass_to_bushings::<S, FRICTION>(simd, column);
        }
    }

    /// Write `A c` of column `j` of the border, c = `column`.
    #[inline(always)]
    fn solve_column<S: Vectors<Number = T>, const FRICTION: bool>(
        &mut self,
        simd: S,
        j: usize,
        column: &[Numbers<T>; 3],
    ) {
        let count = parts::<S>().len();
        let column = of_column::<S>(column, self.groups.len() * count);
        let groups = self.groups.iter().zip(&mut self.solved[j]);
        for (number, (group, solved)) in groups.enumerate() {
            if !group.meshes {
                continue;
            }
            for part in parts::<S>() {
                let c = three::<S, FRICTION>(simd, &column, number * count + part);
                write(
                    solved,
                    part,
                    group.solved_rollers::<S, FRICTION>(simd, part, c),
                );
            }
        }
    }

    /// Return the product of a column of the border with the solution of column `j`.
    #[inline(always)]
    fn product<S: Vectors<Number = T>, const FRICTION: bool>(
        &self,
        simd: S,
        left: &[Numbers<T>; 3],
        j: usize,
    ) -> f64 {
        let count = parts::<S>().len();
        let left = of_column::<S>(left, self.groups.len() * count);
        let mut sum = PartialSums::default();
        for (number, (group, solved)) in self.groups.iter().zip(&self.solved[j]).enumerate() {
            if !group.meshes {
                continue;
            }
            for part in parts::<S>() {
                let i = number * count + part;
                let own = three::<S, FRICTION>(simd, &left, i);
                sum.add(i, dot::<S, FRICTION>(own, read(simd, solved, part)));
            }
        }
        sum.total()
    }

    /// Replace a column of the border, c, by that of the bushings, `C^T A c`.
    #[inline(always)]
    fn pass_to_bushings<S: Vectors<Number = T>, const FRICTION: bool>(
        &self,
        simd: S,
        column: &mut [Numbers<T>; 3],
    ) {
        let count = parts::<S>().len();
        let mut column = of_column_mut::<S>(column, self.groups.len() * count);
        for (number, group) in self.groups.iter().enumerate() {
            if !group.meshes {
                continue;
            }
            for part in parts::<S>() {
                let i = number * count + part;
                let c = three::<S, FRICTION>(simd, &column.each_ref().map(|axis| &**axis), i);
                let on_links = group.on_links::<S, FRICTION>(simd, part, c);
                put_three::<S, FRICTION>(&mut column, i, on_links);
            }
        }
    }

    /// Solve the rollers for `right`, residuals x, y and θ of all, with bushings and border at rest. Subtract c^T A M r from
    /// `border` and write the `column` of the links, gathered from C^T A M r.
    #[inline(always)]
    pub(super) fn solve_free<S: Vectors<Number = T>, const FRICTION: bool>(
        &mut self,
        simd: S,
        right: &[f64],
        border: &mut [f64],
        links: &LinkTerms<T>,
        column: &mut [[Pack8<T>; 3]],
    ) {
        let zero = Lanes::splat(simd, 0.0);
        let n = right.len() / 3;
        let count = parts::<S>().len();
        let right = RollerResidual {
            inertias: self.inertias(simd),
            axes: [
                Entries::<S>::of(simd, &right[..n]),
                Entries::<S>::of(simd, &right[n..2 * n]),
                Entries::<S>::of(simd, &right[2 * n..]),
            ],
        };
        let mut on_links = of_column_mut::<S>(&mut self.on_links, self.groups.len() * count);
        for (number, group) in self.groups.iter_mut().enumerate() {
            for part in parts::<S>() {
                let i = number * count + part;
                if !group.touches {
                    put_three::<S, FRICTION>(&mut on_links, i, [zero; 3]);
                    continue;
                }
                let right = right.at::<FRICTION>((number, part));
                let free = group.solved_rollers::<S, FRICTION>(simd, part, right);
                write(&mut group.free, part, free);
                put_three::<S, FRICTION>(
                    &mut on_links,
                    i,
                    group.on_links::<S, FRICTION>(simd, part, right),
                );
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
                    let solved = read(simd, solved, part);
                    sum.add(
                        i,
                        dot::<S, FRICTION>(solved, right.at::<FRICTION>((number, part))),
                    );
                }
            }
            *entry -= sum.total();
        }
        for on_links in &mut self.on_links {
            on_links[BASE - 1] = on_links[BASE + n - 1];
        }
        links.gather_column::<S, FRICTION>(simd, &self.on_links, column);
    }

    /// Solve the rollers with these velocities of the links and the `border`: w = A (M r + C b - c s). `to` holds the right-hand
    /// side of [`Self::solve_free`]; rollers without contact keep it.
    #[inline(always)]
    pub(super) fn solve_bound<S: Vectors<Number = T>, const FRICTION: bool>(
        &mut self,
        simd: S,
        links: &LinkTerms<T>,
        unknowns: &[[Pack8<T>; 3]],
        border: &[f64],
        to: &mut [f64],
    ) {
        let n = to.len() / 3;
        let groups = self.groups.len();
        links.write_ends::<S, FRICTION>(simd, unknowns, &mut self.ends);
        for end in &mut self.ends[2..] {
            end[n] = end[0];
        }
        let [front_x, front_y, rear_x, rear_y, spin] = &self.ends;
        let fronts = [&front_x[..], front_y, spin].map(|axis| packs(axis, groups));
        let rears = [rear_x, rear_y, spin].map(|axis| packs_from(axis, 1, groups));
        let (to_x, to) = to.split_at_mut(n);
        let (to_y, to_turn) = to.split_at_mut(n);
        let mut to = [to_x, to_y, to_turn].map(|axis| EntriesMut::<S>::of(simd, axis));
        let zero = Lanes::splat(simd, 0.0);
        for (number, group) in self.groups.iter().enumerate() {
            if !group.touches {
                continue;
            }
            for part in parts::<S>() {
                let on_front = group.front_bushing.at(simd, part).greater(zero);
                // A closure over the axes would pass vectors through memory.
                let mut bushing = [zero; 3];
                for axis in 0..axes::<FRICTION>() {
                    let (front, rear) = (&fronts[axis][number], &rears[axis][number]);
                    let (front, rear) = (
                        rounded_part(simd, front, part),
                        rounded_part(simd, rear, part),
                    );
                    bushing[axis] = on_front.select(front, rear);
                }
                let mut own = group.bound::<S, FRICTION>(simd, part, bushing);
                if group.meshes {
                    self.take_border::<S, FRICTION>(simd, (number, part), border, &mut own);
                }
                for (to, own) in to.iter_mut().zip(own).take(axes::<FRICTION>()) {
                    to.set(number, part, own);
                }
            }
        }
    }

    /// Subtract A c s from the velocities of one vector of rollers, with the solution s of the `border`.
    #[inline(always)]
    fn take_border<S: Vectors<Number = T>, const FRICTION: bool>(
        &self,
        simd: S,
        (number, part): (usize, usize),
        border: &[f64],
        own: &mut [Lanes<S>; 3],
    ) {
        for (solved, &moved) in self.solved.iter().zip(border) {
            let moved = Lanes::splat(simd, moved);
            let solved = read(simd, &solved[number], part);
            for (own, solved) in own.iter_mut().zip(solved).take(axes::<FRICTION>()) {
                *own = moved.negate_mul_add(solved, *own);
            }
        }
    }
}

/// Return the number of velocities of a roller in the equations: x and y, and with friction θ.
#[inline(always)]
const fn axes<const FRICTION: bool>() -> usize {
    if FRICTION { 3 } else { 2 }
}

/// Return vector `i` of three arrays; without `FRICTION`, the last is zero.
#[inline(always)]
fn three<S: Vectors, const FRICTION: bool>(
    simd: S,
    [x, y, turn]: &[&[S::Vector]; 3],
    i: usize,
) -> [Lanes<S>; 3] {
    let turn = if FRICTION {
        load(simd, &turn[i])
    } else {
        Lanes::splat(simd, 0.0)
    };
    [load(simd, &x[i]), load(simd, &y[i]), turn]
}

/// Write vector `i` of three arrays; without `FRICTION`, the last is left unchanged.
#[inline(always)]
fn put_three<S: Vectors, const FRICTION: bool>(
    to: &mut [&mut [S::Vector]; 3],
    i: usize,
    values: [Lanes<S>; 3],
) {
    for (to, value) in to.iter_mut().zip(values).take(axes::<FRICTION>()) {
        to[i] = value.values();
    }
}

/// Return the product of two vectors; without `FRICTION`, their last components are zero.
#[inline(always)]
fn dot<S: Vectors, const FRICTION: bool>(left: [Lanes<S>; 3], right: [Lanes<S>; 3]) -> Lanes<S> {
    let mut rest = left[1] * right[1];
    if FRICTION {
        rest = left[1].mul_add(right[1], left[2] * right[2]);
    }
    left[0].mul_add(right[0], rest)
}

/// Return the SIMD vectors of a column of the border.
#[inline(always)]
fn of_column<S: Vectors>(column: &[Numbers<S::Number>; 3], registers: usize) -> [&[S::Vector]; 3] {
    let [x, y, turn] = column;
    [
        vectors_from::<S>(x, BASE, registers),
        vectors_from::<S>(y, BASE, registers),
        vectors_from::<S>(turn, BASE, registers),
    ]
}

/// Return the SIMD vectors of a column of the border for writing.
#[inline(always)]
fn of_column_mut<S: Vectors>(
    column: &mut [Numbers<S::Number>; 3],
    registers: usize,
) -> [&mut [S::Vector]; 3] {
    let [x, y, turn] = column;
    [
        vectors_from_mut::<S>(x, BASE, registers),
        vectors_from_mut::<S>(y, BASE, registers),
        vectors_from_mut::<S>(turn, BASE, registers),
    ]
}

//! Elimination of the links: inverse of the 3x3 block of every link, and the remaining coupling between its two hinges.
//!
//! Row of link i: `D_i w_i + F_i^T f_i - R_i^T f_(i-1) = M_i r_i`, where `f_i` is γ times the change of the force of
//! hinge i \[N s\]. F and R give
//! the velocities of the link's front and rear: `F w = (w_x + u w_θ, w_y + v w_θ)`, R with -u, -v. Row of hinge k:
//! `f_k = L_k² (F_k w_k - R_(k+1) w_(k+1))`, where L² is its stiffness. With f = L g the elimination of the links leaves the symmetric ring
//! `(1 + L_k (F_k D_k⁻¹ F_k^T + R_(k+1) D_(k+1)⁻¹ R_(k+1)^T) L_k) g_k - L_k F_k D_k⁻¹ R_k^T L_(k-1) g_(k-1) - ... = L_k (F_k w_k - R_(k+1) w_(k+1))`.
//! It has no divisions by a stiffness, which is zero in an open hinge and tiny at an onset: rounding stays small in single precision.
//! With ideal hinges L is one, and the one before L is left out.

use super::blocks::{Block, Registers, Symmetric, Vector};
use super::contacts::HingeRoots;
use super::link_group::{Bushings, LinkGroup, LinkRows, Linked};
use super::ring::{BASE, BEFORE, HingeRows, hinge_numbers, put_rows};
use super::teeth::ToothTerms;
use crate::chain::model::Model;
use crate::math::simd::{
    Lanes, Number, Numbers, Pack, Pack8, PartialSums, Vectors, WIDTH, load, packs_from,
    packs_from_mut, packs_mut, padded_zeros, part_of, parts, put_double_part, put_part, read,
    vectors, vectors_from, vectors_mut, write,
};

/// Return whether a bushing of a group of links touches a tooth; rears add the bushing before the group.
#[inline(always)]
fn touched<T: Number>(teeth: &ToothTerms<T>, links: usize, group: usize) -> bool {
    let first = group * WIDTH;
    teeth.touches(first) || teeth.touches(if first > 0 { first - 1 } else { links - 1 })
}

/// Eliminated links.
#[derive(Debug, Clone)]
pub(super) struct LinkTerms<T: Number> {
    groups: Vec<LinkGroup<T>>,
    /// Velocity of the contact points at front and rear per angular velocity of the link, x and y each \[m\]; used where there is
    /// friction.
    levers: Vec<[Pack8<T>; 4]>,
    /// `F D⁻¹ F^T`: xx, yy, xy.
    front: [Numbers<T>; 3],
    /// `R D⁻¹ R^T`: xx, yy, xy; a copy of the first link follows the last.
    rear: [Numbers<T>; 3],
    /// Scratch of an elimination: `-F D⁻¹ R^T` in row-major order, the coupling of the two hinges of a link.
    between: [Numbers<T>; 4],
    /// Scratch of a solution: velocities of rears; a copy of the first one follows the last.
    rear_velocity: [Numbers<T>; 2],
    /// Changes of hinge forces, x and y; during a solution g, and the right-hand sides of the ring; hinge k at [`BASE`] + k.
    force: [Numbers<T>; 2],
}

impl<T: Number> LinkTerms<T> {
    /// Allocate the elimination of the links of `model`.
    pub(super) fn new(model: &Model) -> Self {
        let n = model.links;
        let with_first = || padded_zeros(n + WIDTH);
        let hinges = || hinge_numbers(n);
        Self {
            groups: (0..n)
                .step_by(WIDTH)
                .map(|first| LinkGroup::new(model, first))
                .collect(),
            levers: vec![[Pack8::default(); 4]; n.div_ceil(WIDTH)],
            front: [(); 3].map(|()| padded_zeros(n)),
            rear: [(); 3].map(|()| with_first()),
            between: [(); 4].map(|()| padded_zeros(n)),
            rear_velocity: [with_first(), with_first()],
            force: [hinges(), hinges()],
        }
    }

    /// Return the changes of the hinge forces of the last solution, x and y; hinge k at [`BASE`] + k.
    pub(super) fn hinge_forces(&self) -> &[Numbers<T>; 2] {
        &self.force
    }

    /// Return the unknowns of the ring, which initially hold its right-hand sides.
    #[inline(always)]
    pub(super) fn ring_unknowns(&mut self) -> &mut [Numbers<T>; 2] {
        &mut self.force
    }
}

impl<T: Number> LinkTerms<T> {
    /// Eliminate all links and write the rows of the ring, for hinges with these roots.
    #[inline(always)]
    pub(super) fn eliminate<S: Vectors<Number = T>, const FRICTION: bool>(
        &mut self,
        simd: S,
        of: &Linked<T>,
        roots: &HingeRoots<T>,
        rows: &mut HingeRows<T>,
    ) {
        for (number, group) in self.groups.iter_mut().enumerate() {
            group.touches_teeth = touched(of.teeth, of.links, number);
        }
        let number_of_groups = self.groups.len();
        let (groups, levers) = (
            &mut self.groups[..number_of_groups],
            &mut self.levers[..number_of_groups],
        );
        let count = number_of_groups * parts::<S>().len();
        let links = LinkRows::<S>::of::<FRICTION>(of, number_of_groups);
        let spun = if FRICTION {
            Bushings::of_three(&of.teeth.spun, count)
        } else {
            [Bushings::none(); 3]
        };
        let teeth = (&Bushings::of_three(&of.teeth.tooth_stiffness, count), &spun);
        let front = three_mut::<S>(&mut self.front, count);
        let rear = three_mut::<S>(&mut self.rear, count);
        let [xx, xy, yx, yy] = &mut self.between;
        let between = [
            vectors_mut::<S>(xx, count),
            vectors_mut::<S>(xy, count),
            vectors_mut::<S>(yx, count),
            vectors_mut::<S>(yy, count),
        ];
        for number in 0..number_of_groups {
            let (group, levers) = (&mut groups[number], &mut levers[number]);
            for part in parts::<S>() {
                let place = (number, part);
                let ends = links.eliminate::<FRICTION>(simd, teeth, (group, levers), place);
                let i = number * parts::<S>().len() + part;
                for axis in 0..3 {
                    front[axis][i] = ends.front[axis].values();
                    rear[axis][i] = ends.rear[axis].values();
                }
                for entry in 0..4 {
                    between[entry][i] = ends.between[entry].values();
                }
            }
        }
        self.write_rows(simd, of.links, roots, rows);
    }

    /// Write the rows of the ring: the block of each hinge, with `R D⁻¹ R^T` of the next link, and its coupling.
    #[inline(always)]
    fn write_rows<S: Vectors<Number = T>>(
        &mut self,
        simd: S,
        links: usize,
        roots: &HingeRoots<T>,
        rows: &mut HingeRows<T>,
    ) {
        let count = self.groups.len() * parts::<S>().len();
        for rear in &mut self.rear {
            rear[links] = rear[0];
        }
        let front = three::<S>(&self.front, 0, count);
        let rear = three::<S>(&self.rear, 1, count);
        let own = three::<S>(&roots.roots, BASE, count);
        let before = three::<S>(&roots.roots, BASE - 1, count);
        let [xx, xy, yx, yy] = &self.between;
        let between = [
            vectors::<S>(xx, count),
            vectors::<S>(xy, count),
            vectors::<S>(yx, count),
            vectors::<S>(yy, count),
        ];
        let unit = Lanes::splat(simd, roots.unit);
        let rows = rows.chunks_exact_mut(S::LANES).take(count);
        for (i, rows) in rows.enumerate() {
            let root = Symmetric(three_at(simd, &own, i));
            let before = Symmetric(three_at(simd, &before, i));
            let both = Symmetric(three_at(simd, &front, i));
            let both = both.plus(Symmetric(three_at(simd, &rear, i)));
            let [xx, yy, xy] = root.between(&both).0;
            let coupling = Block([
                load(simd, &between[0][i]),
                load(simd, &between[1][i]),
                load(simd, &between[2][i]),
                load(simd, &between[3][i]),
            ]);
            let coupling = root.times_block(&coupling).times_symmetric(&before).0;
            let mut entries = [Lanes::splat(simd, 0.0); WIDTH];
            (entries[0], entries[1], entries[2]) = (unit + xx, unit + yy, xy);
            entries[BEFORE..].copy_from_slice(&coupling);
            put_rows(simd, rows, &entries);
        }
    }

    /// Solve the links for `right` without changes of the hinge forces. The velocity differences of the hinges are the ring's
    /// right-hand sides.
    #[inline(always)]
    pub(super) fn solve_free<S: Vectors<Number = T>, R: RightHand<S>, const FRICTION: bool>(
        &mut self,
        simd: S,
        links: usize,
        roots: &HingeRoots<T>,
        right: &R,
    ) {
        let count = self.groups.len();
        let (groups, levers) = (&mut self.groups[..count], &self.levers[..count]);
        {
            let [x, y] = &mut self.rear_velocity;
            let (rear_x, rear_y) = (packs_mut(x, count), packs_mut(y, count));
            for number in 0..count {
                let group = &mut groups[number];
                for part in parts::<S>() {
                    let right = right.at(simd, group, (number, part));
                    let free = group.times_inverse(simd, right, part);
                    let [x, y, turn] = free;
                    write(&mut group.free, part, free);
                    let (front, rear) = if FRICTION {
                        let [fx, fy, rx, ry] = read(simd, &levers[number], part);
                        (
                            [fx.mul_add(turn, x), fy.mul_add(turn, y)],
                            [rx.mul_add(turn, x), ry.mul_add(turn, y)],
                        )
                    } else {
                        let [u, v] = read(simd, &group.lever, part);
                        (
                            [u.mul_add(turn, x), v.mul_add(turn, y)],
                            [u.negate_mul_add(turn, x), v.negate_mul_add(turn, y)],
                        )
                    };
                    write(&mut group.front_velocity, part, front);
                    put_part(&mut rear_x[number], part, rear[0]);
                    put_part(&mut rear_y[number], part, rear[1]);
                }
            }
        }
        for rear in &mut self.rear_velocity {
            rear[links] = rear[0];
        }
        // Hinge k: L_k (F_k w_k - R_(k+1) w_(k+1)) with the free velocities.
        let [behind_x, behind_y] = &self.rear_velocity;
        let (behind_x, behind_y) = (
            packs_from(behind_x, 1, count),
            packs_from(behind_y, 1, count),
        );
        let roots = roots.packs(count);
        let [x, y] = &mut self.force;
        let (x, y) = (
            packs_from_mut(x, BASE, count),
            packs_from_mut(y, BASE, count),
        );
        for number in 0..count {
            for part in parts::<S>() {
                let [front_x, front_y] = read(simd, &groups[number].front_velocity, part);
                let closing = Vector([
                    front_x - part_of(simd, &behind_x[number], part),
                    front_y - part_of(simd, &behind_y[number], part),
                ]);
                let right = root_at(simd, &roots, (number, part)).of(&closing).0;
                put_part(&mut x[number], part, right[0]);
                put_part(&mut y[number], part, right[1]);
            }
        }
    }

    /// Replace g by the changes of the hinge forces, L g, after the solution of the ring. Copy the last hinge to the entry before the first.
    #[inline(always)]
    pub(super) fn close_ring<S: Vectors<Number = T>>(
        &mut self,
        simd: S,
        links: usize,
        roots: &HingeRoots<T>,
    ) {
        let count = self.groups.len();
        let roots = roots.packs(count);
        let [x, y] = &mut self.force;
        {
            let (x, y) = (
                packs_from_mut(x, BASE, count),
                packs_from_mut(y, BASE, count),
            );
            for number in 0..count {
                for part in parts::<S>() {
                    let (x, y) = (&mut x[number], &mut y[number]);
                    let unknowns = Vector([part_of(simd, x, part), part_of(simd, y, part)]);
                    let force = root_at(simd, &roots, (number, part)).of(&unknowns).0;
                    put_part(x, part, force[0]);
                    put_part(y, part, force[1]);
                }
            }
        }
        for force in &mut self.force {
            force[BASE - 1] = force[BASE + links - 1];
        }
    }

    /// Solve the links with the changes of the hinge forces; add their products with the border's rows to `sums`.
    #[inline(always)]
    pub(super) fn solve_bound<S: Vectors<Number = T>, const FRICTION: bool>(
        &self,
        simd: S,
        unknowns: &mut [[Pack8<T>; 3]],
        rows: &[Border<T>],
        sums: &mut [PartialSums<T>],
    ) {
        let count = self.groups.len();
        let [x, y] = &self.force;
        let (front_x, front_y) = (packs_from(x, BASE, count), packs_from(y, BASE, count));
        let (rear_x, rear_y) = (
            packs_from(x, BASE - 1, count),
            packs_from(y, BASE - 1, count),
        );
        let (groups, levers) = (&self.groups[..count], &self.levers[..count]);
        let unknowns = &mut unknowns[..count];
        for number in 0..count {
            let group = &groups[number];
            for part in parts::<S>() {
                let at = |array: &[Pack<T>]| part_of(simd, &array[number], part);
                let (front, rear) = ([at(front_x), at(front_y)], [at(rear_x), at(rear_y)]);
                // w = w_free - D⁻¹ (F^T f_i - R^T f_(i-1)).
                let turn = if FRICTION {
                    let [fx, fy, rx, ry] = read(simd, &levers[number], part);
                    let of_front = fx.mul_add(front[0], fy * front[1]);
                    of_front - rx.mul_add(rear[0], ry * rear[1])
                } else {
                    let [u, v] = read(simd, &group.lever, part);
                    u.mul_add(front[0] + rear[0], v * (front[1] + rear[1]))
                };
                let taken = [front[0] - rear[0], front[1] - rear[1], turn];
                let taken = group.times_inverse(simd, taken, part);
                let free = read(simd, &group.free, part);
                let bound = [free[0] - taken[0], free[1] - taken[1], free[2] - taken[2]];
                write(&mut unknowns[number], part, bound);
                if group.touches_teeth {
                    for (row, sum) in rows.iter().zip(&mut *sums) {
                        let [x, y, turn] = read(simd, &row[number], part);
                        let turn = turn * bound[2];
                        let product = x.mul_add(bound[0], y.mul_add(bound[1], turn));
                        sum.add_part(part, product);
                    }
                }
            }
        }
    }

    /// Write velocities of fronts, x and y, and of rears for links with these `unknowns`; with friction angular velocities too.
    #[inline(always)]
    pub(super) fn write_ends<S: Vectors<Number = T>, const FRICTION: bool>(
        &self,
        simd: S,
        unknowns: &[[Pack8<T>; 3]],
        ends: &mut [Numbers; 5],
    ) {
        let count = self.groups.len();
        let [front_x, front_y, rear_x, rear_y, spin] = ends;
        let (front_x, front_y) = (packs_mut(front_x, count), packs_mut(front_y, count));
        let (rear_x, rear_y) = (packs_mut(rear_x, count), packs_mut(rear_y, count));
        let spin = packs_mut(spin, count);
        let (groups, unknowns) = (&self.groups[..count], &unknowns[..count]);
        for number in 0..count {
            for part in parts::<S>() {
                let [x, y, turn] = read(simd, &unknowns[number], part);
                let [u, v] = read(simd, &groups[number].lever, part);
                put_double_part(&mut front_x[number], part, u.mul_add(turn, x));
                put_double_part(&mut front_y[number], part, v.mul_add(turn, y));
                put_double_part(&mut rear_x[number], part, u.negate_mul_add(turn, x));
                put_double_part(&mut rear_y[number], part, v.negate_mul_add(turn, y));
                if FRICTION {
                    put_double_part(&mut spin[number], part, turn);
                }
            }
        }
    }

    /// Gather one column of the border from bushings to links, link by link: F^T and R^T times their values. Groups that touch no teeth are
    /// left out: nothing reads them.
    #[inline(always)]
    pub(super) fn gather_column<S: Vectors<Number = T>, const FRICTION: bool>(
        &self,
        simd: S,
        from: &[Numbers<T>; 3],
        column: &mut [[Pack8<T>; 3]],
    ) {
        let count = self.groups.len();
        let parts = parts::<S>();
        let [x, y, moment] = from;
        let vectors = count * parts.len();
        let (x, y) = (Bushings::<S>::of(x, vectors), Bushings::of(y, vectors));
        let moment = if FRICTION {
            Bushings::of(moment, vectors)
        } else {
            Bushings::none()
        };
        let (groups, column) = (&self.groups[..count], &mut column[..count]);
        for number in 0..count {
            let (group, column) = (&groups[number], &mut column[number]);
            if !group.touches_teeth {
                continue;
            }
            for part in parts.clone() {
                let place = (number * parts.len() + part, part);
                let [u, v] = read(simd, &group.lever, part);
                let [front_x, rear_x] = group.of_ends(simd, &x, place);
                let [front_y, rear_y] = group.of_ends(simd, &y, place);
                let mut turn = u.mul_add(front_x - rear_x, v * (front_y - rear_y));
                if FRICTION {
                    let [front, rear] = group.of_ends(simd, &moment, place);
                    turn = turn + (front + rear);
                }
                write(column, part, [front_x + rear_x, front_y + rear_y, turn]);
            }
        }
    }
}

/// Return `count` vectors of three arrays from entry `first` on.
#[inline(always)]
fn three<S: Vectors>(
    [x, y, z]: &[Numbers<S::Number>; 3],
    first: usize,
    count: usize,
) -> [&[S::Vector]; 3] {
    [
        vectors_from::<S>(x, first, count),
        vectors_from::<S>(y, first, count),
        vectors_from::<S>(z, first, count),
    ]
}

/// Return vector `i` of three arrays.
#[inline(always)]
fn three_at<S: Vectors>(simd: S, [x, y, z]: &[&[S::Vector]; 3], i: usize) -> [Lanes<S>; 3] {
    [load(simd, &x[i]), load(simd, &y[i]), load(simd, &z[i])]
}

/// Return the first `count` vectors of three arrays, mutable.
#[inline(always)]
fn three_mut<S: Vectors>(
    [x, y, z]: &mut [Numbers<S::Number>; 3],
    count: usize,
) -> [&mut [S::Vector]; 3] {
    [
        vectors_mut::<S>(x, count),
        vectors_mut::<S>(y, count),
        vectors_mut::<S>(z, count),
    ]
}

/// Return the roots of one vector of hinges, pack and part.
#[inline(always)]
fn root_at<S: Vectors>(
    simd: S,
    [xx, yy, xy]: &[&[Pack<S::Number>]; 3],
    (number, part): (usize, usize),
) -> Symmetric<S> {
    Symmetric([
        part_of(simd, &xx[number], part),
        part_of(simd, &yy[number], part),
        part_of(simd, &xy[number], part),
    ])
}

/// Right-hand sides of the links.
pub(super) trait RightHand<S: Vectors> {
    /// Return those of vector `part` of pack `number` of links, `group`.
    fn at(&self, simd: S, group: &LinkGroup<S::Number>, place: (usize, usize)) -> [Lanes<S>; 3];
}

/// Row or column of the border: x, y and θ of the links.
pub(super) type Border<T> = Vec<[Pack8<T>; 3]>;

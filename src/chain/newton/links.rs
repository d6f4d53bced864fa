//! Elimination of the links: inverse of the 3x3 block of every link, and the remaining coupling between its two hinges.
//!
//! Row of link i: `D_i w_i + F_i^T f_i - R_i^T f_(i-1) = M_i r_i`, where `f_i` is γ times the change of the force of
//! hinge i \[N s\]. F and R give
//! the velocities of the link's front and rear: `F w = (w_x + u w_θ, w_y + v w_θ)`, R with -u, -v. Row of hinge k:
//! `P_k f_k = F_k w_k - R_(k+1) w_(k+1)`, where P is its compliance.

use pulp::Simd;

use super::contacts::{BASE, LoadedHinges};
use super::link_group::{Bushings, LinkGroup, LinkRows, Linked};
use super::ring::{HingeBlocks, coupling_registers, hinge_numbers, own_registers};
use super::teeth::ToothTerms;
use crate::chain::model::Model;
use crate::math::simd::{
    Lanes, Numbers, Octet, PartialSums, WIDTH, both, load, padded_zeros, parts, read, vectors,
    vectors_mut, write,
};

/// Return whether a bushing of a group of links touches a tooth; rears add the bushing before the group.
#[inline(always)]
fn touched(teeth: &ToothTerms, links: usize, group: usize) -> bool {
    let first = group * WIDTH;
    teeth.touches(first) || teeth.touches(if first > 0 { first - 1 } else { links - 1 })
}

/// Eliminated links.
#[derive(Debug, Clone)]
pub(super) struct LinkTerms {
    groups: Vec<LinkGroup>,
    /// Velocity of the contact points at front and rear per angular velocity of the link, x and y each \[m\]; used where there is
    /// friction.
    levers: Vec<[Octet; 4]>,
    /// `R D⁻¹ R^T`: xx, yy, xy; a copy of the first link follows the last.
    rear: [Numbers; 3],
    /// Scratch of a solution: velocities of rears; a copy of the first one follows the last.
    rear_velocity: [Numbers; 2],
    /// Scratch: changes of hinge forces, x and y; hinge k at [`BASE`] + k.
    force: [Numbers; 2],
}

impl LinkTerms {
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
            levers: vec![[Octet::default(); 4]; n.div_ceil(WIDTH)],
            rear: [(); 3].map(|()| with_first()),
            rear_velocity: [with_first(), with_first()],
            force: [hinges(), hinges()],
        }
    }

    /// Return the unknowns of the ring, which initially hold its right-hand sides.
    #[inline(always)]
    pub(super) fn ring_unknowns(&mut self) -> &mut [Numbers; 2] {
        &mut self.force
    }
}

impl LinkTerms {
    /// Eliminate all links; the result is added to the ring, which holds the hinges' compliances.
    #[inline(always)]
    pub(super) fn eliminate<S: Simd, const FRICTION: bool>(
        &mut self,
        simd: S,
        of: &Linked,
        ring: &mut HingeBlocks,
    ) {
        let count = parts::<S>().len();
        let blocks = self.groups.len() * count;
        let loaded = vectors::<S>(&of.loaded.hinges[BASE..], blocks);
        let loaded_before = vectors::<S>(&of.loaded.hinges[BASE - 1..], blocks);
        let links = LinkRows::<S>::of(of, blocks);
        {
            let [xx, yy, xy] = &mut self.rear;
            let mut rear = [xx, yy, xy].map(|axis| vectors_mut::<S>(axis, blocks));
            let teeth = (
                &Bushings::<S>::of_three(&of.teeth.tooth_stiffness, blocks),
                &Bushings::<S>::of_three(&of.teeth.spun, blocks),
            );
            let mut own = own_registers::<S>(&mut ring.own, blocks);
            let mut couplings = coupling_registers::<S>(&mut ring.before, blocks);
            let groups = self.groups.iter_mut().zip(&mut self.levers);
            for (number, (group, levers)) in groups.enumerate() {
                group.touches_teeth = touched(of.teeth, of.links, number);
                for part in parts::<S>() {
                    let i = number * count + part;
                    let ends = links.eliminate::<FRICTION>(simd, teeth, (group, levers), (i, part));
                    for (rear, entry) in rear.iter_mut().zip(ends.rear) {
                        rear[i] = entry.values();
                    }
                    let loaded = load(simd, &loaded[i]);
                    // S_k += F D⁻¹ F^T and C_k = -F D⁻¹ R^T; hinges without force stay uncoupled.
                    for (own, entry) in own.iter_mut().zip(ends.front) {
                        own[i] = loaded.mul_add(entry, load(simd, &own[i])).values();
                    }
                    let both = loaded * load(simd, &loaded_before[i]);
                    for (coupling, entry) in couplings.iter_mut().zip(ends.between) {
                        coupling[i] = (both * entry).values();
                    }
                }
            }
        }
        self.add_rears(simd, of.links, loaded, ring);
    }

    /// Add `R D⁻¹ R^T` of the next link to the block of each hinge.
    #[inline(always)]
    fn add_rears<S: Simd>(
        &mut self,
        simd: S,
        links: usize,
        loaded: &[S::f64s],
        ring: &mut HingeBlocks,
    ) {
        for array in &mut self.rear {
            array[links] = array[0];
        }
        for (own, rear) in own_registers::<S>(&mut ring.own, loaded.len())
            .into_iter()
            .zip(&self.rear)
        {
            let rear = vectors::<S>(&rear[1..], loaded.len());
            for ((own, rear), loaded) in own.iter_mut().zip(rear).zip(loaded) {
                let loaded = load(simd, loaded);
                *own = loaded.mul_add(load(simd, rear), load(simd, own)).values();
            }
        }
    }

    /// Solve the links for `right` without changes of the hinge forces. The velocity differences of the hinges are the ring's
    /// right-hand sides.
    #[inline(always)]
    pub(super) fn solve_free<S: Simd, R: RightHand<S>, const FRICTION: bool>(
        &mut self,
        simd: S,
        links: usize,
        loaded: &LoadedHinges,
        right: &R,
    ) {
        let count = parts::<S>().len();
        let blocks = self.groups.len() * count;
        {
            let [x, y] = &mut self.rear_velocity;
            let rear = [vectors_mut::<S>(x, blocks), vectors_mut::<S>(y, blocks)];
            let groups = self.groups.iter_mut().zip(&self.levers);
            for (number, (group, levers)) in groups.enumerate() {
                for part in parts::<S>() {
                    let i = number * count + part;
                    let mass = group.mass.at(simd, part);
                    let mass = [mass, mass, group.inertia.at(simd, part)];
                    let right = right.at(simd, mass, group.touches_teeth, i);
                    let free = group.times_inverse(simd, right, part);
                    let [x, y, turn] = free;
                    write(&mut group.free, part, free);
                    if FRICTION {
                        let [fx, fy, rx, ry] = read(simd, levers, part);
                        let front = [fx.mul_add(turn, x), fy.mul_add(turn, y)];
                        write(&mut group.front_velocity, part, front);
                        rear[0][i] = rx.mul_add(turn, x).values();
                        rear[1][i] = ry.mul_add(turn, y).values();
                        continue;
                    }
                    let [u, v] = read(simd, &group.lever, part);
                    let front = [u.mul_add(turn, x), v.mul_add(turn, y)];
                    write(&mut group.front_velocity, part, front);
                    rear[0][i] = u.negate_mul_add(turn, x).values();
                    rear[1][i] = v.negate_mul_add(turn, y).values();
                }
            }
        }
        for array in &mut self.rear_velocity {
            array[links] = array[0];
        }
        // Hinge k: F_k w_k - R_(k+1) w_(k+1) with the free velocities; zero for hinges without force.
        let [x, y] = &self.rear_velocity;
        let behind = [vectors::<S>(&x[1..], blocks), vectors::<S>(&y[1..], blocks)];
        let loaded = vectors::<S>(&loaded.hinges[BASE..], blocks);
        let [x, y] = &mut self.force;
        let force = [
            vectors_mut::<S>(&mut x[BASE..], blocks),
            vectors_mut::<S>(&mut y[BASE..], blocks),
        ];
        for (number, group) in self.groups.iter().enumerate() {
            for part in parts::<S>() {
                let i = number * count + part;
                let loaded = load(simd, &loaded[i]);
                let [x, y] = read(simd, &group.front_velocity, part);
                force[0][i] = (loaded * (x - load(simd, &behind[0][i]))).values();
                force[1][i] = (loaded * (y - load(simd, &behind[1][i]))).values();
            }
        }
    }

    /// Copy the last hinge to the entry before the first, after the solution of the ring.
    #[inline(always)]
    pub(super) fn close_ring(&mut self, links: usize) {
        for force in &mut self.force {
            force[BASE - 1] = force[BASE + links - 1];
        }
    }

    /// Solve the links with the changes of the hinge forces; add their products with the border's rows to `sums`.
    #[inline(always)]
    pub(super) fn solve_bound<S: Simd, const FRICTION: bool>(
        &self,
        simd: S,
        unknowns: &mut [[Octet; 3]],
        rows: &[Border],
        sums: &mut [PartialSums],
    ) {
        let count = parts::<S>().len();
        let blocks = self.groups.len() * count;
        let [x, y] = &self.force;
        let front = both::<S>(&self.force, BASE, blocks);
        let rear = [
            vectors::<S>(&x[BASE - 1..], blocks),
            vectors::<S>(&y[BASE - 1..], blocks),
        ];
        let groups = self.groups.iter().zip(&self.levers);
        for (number, ((group, levers), unknowns)) in groups.zip(unknowns).enumerate() {
            for part in parts::<S>() {
                let i = number * count + part;
                let at = |array: &[S::f64s]| load(simd, &array[i]);
                let (front, rear) = ([at(front[0]), at(front[1])], [at(rear[0]), at(rear[1])]);
                // w = w_free - D⁻¹ (F^T f_i - R^T f_(i-1)).
                let turn = if FRICTION {
                    let [fx, fy, rx, ry] = read(simd, levers, part);
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
                write(unknowns, part, bound);
                if group.touches_teeth {
                    for (row, sum) in rows.iter().zip(&mut *sums) {
                        let [x, y, turn] = read(simd, &row[number], part);
                        let turn = turn * bound[2];
                        sum.add(i, x.mul_add(bound[0], y.mul_add(bound[1], turn)));
                    }
                }
            }
        }
    }

    /// Write velocities of fronts, x and y, and of rears for links with these `unknowns`; with friction angular velocities too.
    #[inline(always)]
    pub(super) fn write_ends<S: Simd, const FRICTION: bool>(
        &self,
        simd: S,
        unknowns: &[[Octet; 3]],
        ends: &mut [Numbers; 5],
    ) {
        let count = parts::<S>().len();
        let blocks = self.groups.len() * count;
        let [front_x, front_y, rear_x, rear_y, spin] = ends;
        let (front_x, front_y) = (
            vectors_mut::<S>(front_x, blocks),
            vectors_mut::<S>(front_y, blocks),
        );
        let (rear_x, rear_y) = (
            vectors_mut::<S>(rear_x, blocks),
            vectors_mut::<S>(rear_y, blocks),
        );
        let spin = vectors_mut::<S>(spin, blocks);
        for (number, (group, unknowns)) in self.groups.iter().zip(unknowns).enumerate() {
            for part in parts::<S>() {
                let i = number * count + part;
                let [x, y, turn] = read(simd, unknowns, part);
                let [u, v] = read(simd, &group.lever, part);
                front_x[i] = u.mul_add(turn, x).values();
                front_y[i] = v.mul_add(turn, y).values();
                rear_x[i] = u.negate_mul_add(turn, x).values();
                rear_y[i] = v.negate_mul_add(turn, y).values();
                if FRICTION {
                    spin[i] = turn.values();
                }
            }
        }
    }

    /// Gather one column of the border from bushings to links, link by link: F^T and R^T times their values.
    #[inline(always)]
    pub(super) fn gather_column<S: Simd, const FRICTION: bool>(
        &self,
        simd: S,
        from: &[Numbers; 3],
        column: &mut [[Octet; 3]],
    ) {
        let from = Bushings::<S>::of_three(from, self.groups.len() * parts::<S>().len());
        for (number, (group, column)) in self.groups.iter().zip(column).enumerate() {
            if !group.touches_teeth {
                *column = [Octet::default(); 3];
                continue;
            }
            for part in parts::<S>() {
                let i = number * parts::<S>().len() + part;
                let [u, v] = read(simd, &group.lever, part);
                let [front_x, rear_x] = group.of_ends(simd, &from[0], i, part);
                let [front_y, rear_y] = group.of_ends(simd, &from[1], i, part);
                let mut turn = u.mul_add(front_x - rear_x, v * (front_y - rear_y));
                if FRICTION {
                    let [front, rear] = group.of_ends(simd, &from[2], i, part);
                    turn = turn + (front + rear);
                }
                write(column, part, [front_x + rear_x, front_y + rear_y, turn]);
            }
        }
    }
}

/// Right-hand sides of the links.
pub(super) trait RightHand<S: Simd> {
    /// Return those of vector `i` of links with masses and inertias `mass`; `touches_teeth`: whether one of their bushings touches a tooth.
    fn at(&self, simd: S, mass: [Lanes<S>; 3], touches_teeth: bool, i: usize) -> [Lanes<S>; 3];
}

/// Row or column of the border: x, y and θ of the links.
pub(super) type Border = Vec<[Octet; 3]>;

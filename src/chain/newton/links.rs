//! Elimination of the links: inverse of the 3x3 block of every link, and the remaining coupling between its two hinges.
//!
//! Row of link i: `D_i w_i + F_i^T f_i - R_i^T f_(i-1) = M_i r_i`, where `f_i` is the change of the force of hinge i. F and R give
//! the velocities of the link's front and rear: `F w = (w_x + u w_θ, w_y + v w_θ)`, R with -u, -v. Row of hinge k:
//! `P_k f_k = F_k w_k - R_(k+1) w_(k+1)`, where P is its compliance.

use pulp::Simd;

use super::contacts::{Arms, BASE, Closed};
use super::ring::{HingeBlocks, coupling_registers, hinge_numbers, own_registers};
use super::teeth::ToothTerms;
use crate::chain::model::Model;
use crate::math::simd::{
    Lanes, Numbers, Octet, PartialSums, WIDTH, both, load, padded_zeros, parts, read, vectors,
    vectors_mut, write,
};

/// Eight links. Links of the padding have mass and inertia one.
#[derive(Debug, Clone, Copy)]
struct LinkGroup {
    mass: Octet,
    inertia: Octet,
    inverse_mass: Octet,
    /// One where bushing k is on the front of link k, else zero.
    front_bushing: Octet,
    /// One where bushing k - 1 is on the rear of link k.
    rear_bushing: Octet,
    /// Whether a bushing of one of these links touches a tooth.
    held: bool,
    /// u and v: velocity of the link's front per angular velocity of the link \[m\].
    lever: [Octet; 2],
    /// Inverse of D: xx, xy, xθ, yy, yθ, θθ. Without tooth contact D is diagonal and only the last entry is used.
    inverse: [Octet; 6],
    /// Scratch of a solution: velocities of the links without changes of the hinge forces.
    free: [Octet; 3],
    /// Scratch: the corresponding velocities of their fronts.
    front_velocity: [Octet; 2],
}

impl LinkGroup {
    /// Return the constants of eight links from link `first` on.
    fn new(model: &Model, first: usize) -> Self {
        let n = model.links;
        let lay_out = |value: &dyn Fn(usize) -> f64, rest: f64| {
            let of = |i: usize| if i < n { value(i) } else { rest };
            Octet(std::array::from_fn(|lane| of(first + lane)))
        };
        let owner = |k: usize| model.link_of_bushing(k % n);
        let none = Octet::default();
        Self {
            mass: lay_out(&|i| model.mass[i], 1.0),
            inertia: lay_out(&|i| model.inertia[i], 1.0),
            inverse_mass: lay_out(&|i| 1.0 / model.mass[i], 1.0),
            front_bushing: lay_out(&|i| f64::from(owner(i) == i), 0.0),
            rear_bushing: lay_out(&|i| f64::from(owner(i + n - 1) == i), 0.0),
            held: false,
            lever: [none; 2],
            inverse: [none; 6],
            free: [none; 3],
            front_velocity: [none; 2],
        }
    }

    /// Return values of the bushings on the fronts and on the rears of vector `i` of links; zero where that end has no bushing.
    #[inline(always)]
    fn of_ends<S: Simd>(&self, simd: S, of: &Bushings<S>, i: usize, part: usize) -> [Lanes<S>; 2] {
        [
            self.front_bushing.at(simd, part) * load(simd, &of.front[i]),
            self.rear_bushing.at(simd, part) * load(simd, &of.rear[i]),
        ]
    }

    /// Return D⁻¹ times `right`.
    #[inline(always)]
    fn times_inverse<S: Simd>(&self, simd: S, right: [Lanes<S>; 3], part: usize) -> [Lanes<S>; 3] {
        if self.held {
            return Spatial(read(simd, &self.inverse, part)).times(right);
        }
        let light = self.inverse_mass.at(simd, part);
        let [x, y, turn] = right;
        [light * x, light * y, self.inverse[5].at(simd, part) * turn]
    }

    /// Return the blocks D of links whose bushings touch teeth.
    ///
    /// `D = diag(m, m, J) + F^T H_f F + R^T H_r R` with the stiffness H of the teeth at the front and the rear bushing. J is the
    /// inertia with the geometric stiffness. Friction adds the moments `spun` about the bushings.
    #[inline(always)]
    fn held_links<S: Simd, const RUBBED: bool>(
        &self,
        simd: S,
        (held, spun): (&[Bushings<S>; 3], &[Bushings<S>; 3]),
        [u, v]: [Lanes<S>; 2],
        inertia: Lanes<S>,
        (i, part): (usize, usize),
    ) -> Spatial<S> {
        let mass = self.mass.at(simd, part);
        let [front_xx, rear_xx] = self.of_ends(simd, &held[0], i, part);
        let [front_yy, rear_yy] = self.of_ends(simd, &held[1], i, part);
        let [front_xy, rear_xy] = self.of_ends(simd, &held[2], i, part);
        let (xx, yy, xy) = (front_xx + rear_xx, front_yy + rear_yy, front_xy + rear_xy);
        let (dxx, dyy, dxy) = (front_xx - rear_xx, front_yy - rear_yy, front_xy - rear_xy);
        let turned = [u.mul_add(xx, v * xy), u.mul_add(xy, v * yy)];
        let mut block = [
            mass + xx,
            xy,
            u.mul_add(dxx, v * dxy),
            mass + yy,
            u.mul_add(dxy, v * dyy),
            u.mul_add(turned[0], v.mul_add(turned[1], inertia)),
        ];
        if RUBBED {
            let [front_x, rear_x] = self.of_ends(simd, &spun[0], i, part);
            let [front_y, rear_y] = self.of_ends(simd, &spun[1], i, part);
            let [front, rear] = self.of_ends(simd, &spun[2], i, part);
            block[2] = block[2] + (front_x + rear_x);
            block[4] = block[4] + (front_y + rear_y);
            let crossed = u.mul_add(front_x - rear_x, v * (front_y - rear_y));
            block[5] = block[5] + ((crossed + crossed) + (front + rear));
        }
        Spatial(block)
    }
}

/// Array of bushings as SIMD vectors of links: bushings on their fronts, and bushings on their rears.
#[derive(Clone, Copy)]
struct Bushings<'a, S: Simd> {
    front: &'a [S::f64s],
    rear: &'a [S::f64s],
}

impl<'a, S: Simd> Bushings<'a, S> {
    /// Return the first `count` vectors; bushing k is at [`BASE`] + k.
    #[inline(always)]
    fn of(array: &'a [f64], count: usize) -> Self {
        Self {
            front: vectors::<S>(&array[BASE..], count),
            rear: vectors::<S>(&array[BASE - 1..], count),
        }
    }

    /// Return three arrays.
    #[inline(always)]
    fn of_three([x, y, z]: &'a [Numbers; 3], count: usize) -> [Self; 3] {
        [Self::of(x, count), Self::of(y, count), Self::of(z, count)]
    }
}

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

/// Symmetric 3x3 matrix: xx, xy, xz, yy, yz, zz.
#[derive(Clone, Copy)]
pub(super) struct Spatial<S: Simd>(pub(super) [Lanes<S>; 6]);

impl<S: Simd> Spatial<S> {
    /// Return the inverse: cofactors over the determinant.
    #[inline(always)]
    pub(super) fn inverse(&self) -> Self {
        let [xx, xy, xz, yy, yz, zz] = self.0;
        let a = yy.mul_add(zz, -(yz * yz));
        let b = xz.mul_add(yz, -(xy * zz));
        let c = xy.mul_add(yz, -(xz * yy));
        let over = xx.constant(1.0) / xx.mul_add(a, xy.mul_add(b, xz * c));
        Self([
            a * over,
            b * over,
            c * over,
            xx.mul_add(zz, -(xz * xz)) * over,
            xy.mul_add(xz, -(xx * yz)) * over,
            xx.mul_add(yy, -(xy * xy)) * over,
        ])
    }

    /// Return the product with a vector.
    #[inline(always)]
    pub(super) fn times(&self, [x, y, z]: [Lanes<S>; 3]) -> [Lanes<S>; 3] {
        let [xx, xy, xz, yy, yz, zz] = self.0;
        [
            xx.mul_add(x, xy.mul_add(y, xz * z)),
            xy.mul_add(x, yy.mul_add(y, yz * z)),
            xz.mul_add(x, yz.mul_add(y, zz * z)),
        ]
    }
}

/// Input of the links' elimination.
pub(super) struct Linked<'a> {
    pub(super) links: usize,
    pub(super) gamma: f64,
    /// Cosines and sines of the links.
    pub(super) direction: [&'a [f64]; 2],
    /// Half the pitch of every link \[m\].
    pub(super) arm: &'a [f64],
    /// Forces on front and rear ends, x and y \[N\].
    pub(super) front_force: [&'a [f64]; 2],
    pub(super) rear_force: [&'a [f64]; 2],
    pub(super) teeth: &'a ToothTerms,
    pub(super) closed: &'a Closed,
    pub(super) arms: &'a Arms,
}

impl LinkTerms {
    /// Eliminate all links; the result is added to the ring, which holds the hinges' compliances.
    #[inline(always)]
    pub(super) fn eliminate<S: Simd, const RUBBED: bool>(
        &mut self,
        simd: S,
        of: &Linked,
        ring: &mut HingeBlocks,
    ) {
        let n = of.links;
        let count = parts::<S>().len();
        let blocks = self.groups.len() * count;
        let of_links = |array| vectors::<S>(array, blocks);
        let [cos, sin] = of.direction.map(of_links);
        let arm = of_links(of.arm);
        let [front_x, front_y] = of.front_force.map(of_links);
        let [rear_x, rear_y] = of.rear_force.map(of_links);
        let closed = vectors::<S>(&of.closed.hinges[BASE..], blocks);
        let closed_before = vectors::<S>(&of.closed.hinges[BASE - 1..], blocks);
        let gamma_squared = Lanes::splat(simd, of.gamma * of.gamma);
        let front_arms = both::<S>(&of.arms.front, BASE, blocks);
        let rear_arms = [
            vectors::<S>(&of.arms.rear[0][BASE - 1..], blocks),
            vectors::<S>(&of.arms.rear[1][BASE - 1..], blocks),
        ];
        {
            let [xx, yy, xy] = &mut self.rear;
            let rear = [
                vectors_mut::<S>(xx, blocks),
                vectors_mut::<S>(yy, blocks),
                vectors_mut::<S>(xy, blocks),
            ];
            let teeth = (
                &Bushings::<S>::of_three(&of.teeth.held, blocks),
                &Bushings::<S>::of_three(&of.teeth.spun, blocks),
            );
            let mut own = own_registers::<S>(&mut ring.own, blocks);
            let mut couplings = coupling_registers::<S>(&mut ring.before, blocks);
            let groups = self.groups.iter_mut().zip(&mut self.levers);
            for (number, (links, levers)) in groups.enumerate() {
                links.held = touched(of.teeth, n, number);
                for part in parts::<S>() {
                    let i = number * count + part;
                    let at = |array: &[S::f64s]| load(simd, &array[i]);
                    let (arm, cos, sin) = (at(arm), at(cos), at(sin));
                    let lever = [-(arm * sin), arm * cos];
                    write(&mut links.lever, part, lever);
                    // Geometric stiffness: the moment of the end forces decreases by arm times stretching force per angle of the
                    // link.
                    let pull = [at(front_x) - at(rear_x), at(front_y) - at(rear_y)];
                    let stretch = cos.mul_add(pull[0], sin * pull[1]);
                    let inertia =
                        (gamma_squared * arm).mul_add(stretch, links.inertia.at(simd, part));
                    let mut contacts = [lever; 2];
                    if RUBBED {
                        let [u, v] = lever;
                        contacts = [
                            [u + at(front_arms[0]), v + at(front_arms[1])],
                            [at(rear_arms[0]) - u, at(rear_arms[1]) - v],
                        ];
                        let [[fx, fy], [rx, ry]] = contacts;
                        write(levers, part, [fx, fy, rx, ry]);
                    }
                    let ends = if links.held {
                        let inverse = links
                            .held_links::<S, RUBBED>(simd, teeth, lever, inertia, (i, part))
                            .inverse();
                        write(&mut links.inverse, part, inverse.0);
                        if RUBBED {
                            Ends::apart(&inverse, contacts)
                        } else {
                            Ends::of_held(&inverse, lever)
                        }
                    } else if RUBBED {
                        let turn = inertia.constant(1.0) / inertia;
                        links.inverse[5].put(part, turn);
                        Ends::apart_and_free(links.inverse_mass.at(simd, part), turn, contacts)
                    } else {
                        let turn = inertia.constant(1.0) / inertia;
                        links.inverse[5].put(part, turn);
                        Ends::of_free(links.inverse_mass.at(simd, part), turn, lever)
                    };
                    rear[0][i] = ends.rear[0].values();
                    rear[1][i] = ends.rear[1].values();
                    rear[2][i] = ends.rear[2].values();
                    let closed = at(closed);
                    // S_k += F D⁻¹ F^T and C_k = -F D⁻¹ R^T; hinges without force stay uncoupled.
                    for (own, entry) in own.iter_mut().zip(ends.front) {
                        own[i] = closed.mul_add(entry, load(simd, &own[i])).values();
                    }
                    let both = closed * at(closed_before);
                    for (coupling, entry) in couplings.iter_mut().zip(ends.between) {
                        coupling[i] = (both * entry).values();
                    }
                }
            }
        }
        self.add_rears(simd, n, closed, ring);
    }

    /// Add `R D⁻¹ R^T` of the next link to the block of each hinge.
    #[inline(always)]
    fn add_rears<S: Simd>(
        &mut self,
        simd: S,
        links: usize,
        closed: &[S::f64s],
        ring: &mut HingeBlocks,
    ) {
        for array in &mut self.rear {
            array[links] = array[0];
        }
        for (own, rear) in own_registers::<S>(&mut ring.own, closed.len())
            .into_iter()
            .zip(&self.rear)
        {
            let rear = vectors::<S>(&rear[1..], closed.len());
            for ((own, rear), closed) in own.iter_mut().zip(rear).zip(closed) {
                let closed = load(simd, closed);
                *own = closed.mul_add(load(simd, rear), load(simd, own)).values();
            }
        }
    }

    /// Solve the links for `right` without changes of the hinge forces. The velocity differences of the hinges are the ring's
    /// right-hand sides.
    #[inline(always)]
    pub(super) fn solve_free<S: Simd, R: RightHand<S>, const RUBBED: bool>(
        &mut self,
        simd: S,
        links: usize,
        closed: &Closed,
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
                    let right = right.at(simd, mass, group.held, i);
                    let free = group.times_inverse(simd, right, part);
                    let [x, y, turn] = free;
                    write(&mut group.free, part, free);
                    if RUBBED {
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
        let closed = vectors::<S>(&closed.hinges[BASE..], blocks);
        let [x, y] = &mut self.force;
        let force = [
            vectors_mut::<S>(&mut x[BASE..], blocks),
            vectors_mut::<S>(&mut y[BASE..], blocks),
        ];
        for (number, group) in self.groups.iter().enumerate() {
            for part in parts::<S>() {
                let i = number * count + part;
                let closed = load(simd, &closed[i]);
                let [x, y] = read(simd, &group.front_velocity, part);
                force[0][i] = (closed * (x - load(simd, &behind[0][i]))).values();
                force[1][i] = (closed * (y - load(simd, &behind[1][i]))).values();
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
    pub(super) fn solve_bound<S: Simd, const RUBBED: bool>(
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
                let turn = if RUBBED {
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
                if group.held {
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
    pub(super) fn write_ends<S: Simd, const RUBBED: bool>(
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
                if RUBBED {
                    spin[i] = turn.values();
                }
            }
        }
    }

    /// Gather one column of the border from bushings to links, link by link: F^T and R^T times their values.
    #[inline(always)]
    pub(super) fn gather_column<S: Simd, const RUBBED: bool>(
        &self,
        simd: S,
        from: &[Numbers; 3],
        column: &mut [[Octet; 3]],
    ) {
        let from = Bushings::<S>::of_three(from, self.groups.len() * parts::<S>().len());
        for (number, (group, column)) in self.groups.iter().zip(column).enumerate() {
            if !group.held {
                *column = [Octet::default(); 3];
                continue;
            }
            for part in parts::<S>() {
                let i = number * parts::<S>().len() + part;
                let [u, v] = read(simd, &group.lever, part);
                let [front_x, rear_x] = group.of_ends(simd, &from[0], i, part);
                let [front_y, rear_y] = group.of_ends(simd, &from[1], i, part);
                let mut turn = u.mul_add(front_x - rear_x, v * (front_y - rear_y));
                if RUBBED {
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
    /// Return those of vector `i` of links with masses and inertias `mass`, `held` by teeth or not.
    fn at(&self, simd: S, mass: [Lanes<S>; 3], held: bool, i: usize) -> [Lanes<S>; 3];
}

/// Row or column of the border: x, y and θ of the links.
pub(super) type Border = Vec<[Octet; 3]>;

/// Coupling of the two hinges of a vector of links.
struct Ends<S: Simd> {
    /// `F D⁻¹ F^T`: xx, yy, xy.
    front: [Lanes<S>; 3],
    /// `R D⁻¹ R^T`
    rear: [Lanes<S>; 3],
    /// `-F D⁻¹ R^T` in row-major order.
    between: [Lanes<S>; 4],
}

impl<S: Simd> Ends<S> {
    /// Return the coupling by links without tooth contact: D = diag(m, m, J), levers (u, v) and (-u, -v).
    #[inline(always)]
    fn of_free(light: Lanes<S>, turn: Lanes<S>, [u, v]: [Lanes<S>; 2]) -> Self {
        let (tu, tv) = (turn * u, turn * v);
        let [uu, vv, uv] = [tu * u, tv * v, tu * v];
        let own = [light + uu, light + vv, uv];
        Self {
            front: own,
            rear: own,
            between: [uu - light, uv, uv, vv - light],
        }
    }

    /// Return the coupling by links with tooth contact: D is a full matrix, levers (u, v) and (-u, -v).
    #[inline(always)]
    fn of_held(inverse: &Spatial<S>, [u, v]: [Lanes<S>; 2]) -> Self {
        let [xx, xy, xz, yy, yz, zz] = inverse.0;
        let (zu, zv) = (zz * u, zz * v);
        let [uu, vv, uv] = [zu * u, zv * v, zu * v];
        let (same_x, same_y, same_xy) = (xx + uu, yy + vv, xy + uv);
        // The products of rotation and translation have opposite signs at the two ends.
        let (x, y) = (u * xz, v * yz);
        let crossed = u.mul_add(yz, v * xz);
        let between = v.mul_add(xz, -(u * yz));
        Self {
            front: [same_x + (x + x), same_y + (y + y), same_xy + crossed],
            rear: [same_x - (x + x), same_y - (y + y), same_xy - crossed],
            between: [uu - xx, (uv - xy) + between, (uv - xy) - between, vv - yy],
        }
    }

    /// Return the coupling by links whose contacts are at `[front, rear]` from their centres, each with its own lever.
    #[inline(always)]
    fn apart(inverse: &Spatial<S>, [front, rear]: [[Lanes<S>; 2]; 2]) -> Self {
        let [xx, xy, xz, yy, yz, zz] = inverse.0;
        let ([a, b], [c, d]) = (front, rear);
        Self {
            front: Self::own(inverse, front),
            rear: Self::own(inverse, rear),
            between: [
                -((zz * a).mul_add(c, xx + (a + c) * xz)),
                -((zz * a).mul_add(d, xy + a.mul_add(yz, d * xz))),
                -((zz * b).mul_add(c, xy + b.mul_add(xz, c * yz))),
                -((zz * b).mul_add(d, yy + (b + d) * yz)),
            ],
        }
    }

    /// Return `F D⁻¹ F^T` of a contact at this lever: xx, yy, xy.
    #[inline(always)]
    fn own(inverse: &Spatial<S>, [u, v]: [Lanes<S>; 2]) -> [Lanes<S>; 3] {
        let [xx, xy, xz, yy, yz, zz] = inverse.0;
        let (x, y) = (u * xz, v * yz);
        [
            (zz * u).mul_add(u, xx + (x + x)),
            (zz * v).mul_add(v, yy + (y + y)),
            (zz * u).mul_add(v, xy + u.mul_add(yz, v * xz)),
        ]
    }

    /// Return the same for links without tooth contact.
    #[inline(always)]
    fn apart_and_free(light: Lanes<S>, turn: Lanes<S>, [front, rear]: [[Lanes<S>; 2]; 2]) -> Self {
        let zero = light.constant(0.0);
        let inverse = Spatial([light, zero, zero, light, zero, turn]);
        Self::apart(&inverse, [front, rear])
    }
}

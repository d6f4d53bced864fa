//! Elimination of the links: inverse of the 3x3 block of every link, and the remaining coupling between its two hinges.
//!
//! Row of link i: `D_i w_i + F_i^T f_i - R_i^T f_(i-1) = M_i r_i`, where `f_i` is γ times the change of the force of
//! hinge i \[N s\]. F and R give
//! the velocities of the link's front and rear: `F w = (w_x + u w_θ, w_y + v w_θ)`, R with -u, -v. Row of hinge k:
//! `P_k f_k = F_k w_k - R_(k+1) w_(k+1)`, where P is its compliance.

use pulp::Simd;

use super::contacts::LoadedHinges;
use super::link_group::{Bushings, LinkGroup, LinkRows, Linked};
use super::ring::{BASE, BEFORE, HingeBlocks, hinge_numbers, hinge_vectors, put_rows};
use super::teeth::ToothTerms;
use crate::chain::arrays::slopes::group_of;
use crate::chain::model::Model;
use crate::math::simd::{
    Entries, Lanes, Numbers, Pack, Pack8, PartialSums, WIDTH, load, packs, packs_mut, padded_zeros,
    part_of, parts, put_part, read, vectors, vectors_mut, write,
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
    levers: Vec<[Pack8; 4]>,
    /// `R D⁻¹ R^T`: xx, yy, xy; a copy of the first link follows the last.
    rear: [Numbers; 3],
    /// Scratch of an elimination: `-F D⁻¹ R^T` in row-major order, the coupling of the two hinges of a link.
    between: [Numbers; 4],
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
            levers: vec![[Pack8::default(); 4]; n.div_ceil(WIDTH)],
            rear: [(); 3].map(|()| with_first()),
            between: [(); 4].map(|()| padded_zeros(n)),
            rear_velocity: [with_first(), with_first()],
            force: [hinges(), hinges()],
        }
    }

    /// Write residuals x, y and θ of all links where [`Self::solve_free`] reads them; zero for links of the padding.
    #[inline(always)]
    pub(super) fn take_residuals<S: Simd>(&mut self, simd: S, links: usize, residuals: &[f64]) {
        let count = self.groups.len();
        let groups = &mut self.groups[..count];
        for axis in 0..3 {
            let (whole, rest) = residuals[axis * links..(axis + 1) * links].as_chunks();
            for (group, residuals) in groups.iter_mut().zip(whole) {
                for part in parts::<S>() {
                    group.free[axis].put(part, part_of(simd, residuals, part));
                }
            }
            if let Some(group) = groups.get_mut(whole.len()) {
                // As vectors: the load of a vector waits for stores of single numbers in it.
                let rest = Entries::of(simd, rest);
                for part in parts::<S>() {
                    group.free[axis].put(part, rest.at(part));
                }
            }
        }
    }

    /// Return the changes of the hinge forces of the last solution, x and y; hinge k at [`BASE`] + k.
    pub(super) fn hinge_forces(&self) -> &[Numbers; 2] {
        &self.force
    }

    /// Return the unknowns of the ring, which initially hold its right-hand sides.
    #[inline(always)]
    pub(super) fn ring_unknowns(&mut self) -> &mut [Numbers; 2] {
        &mut self.force
    }
}

impl LinkTerms {
    /// Eliminate all links and write the rows of the ring, which holds the hinges' compliances.
    #[inline(always)]
    pub(super) fn eliminate<S: Simd, const FRICTION: bool>(
        &mut self,
        simd: S,
        of: &Linked,
        ring: &mut HingeBlocks,
    ) {
        for (number, group) in self.groups.iter_mut().enumerate() {
            group.touches_teeth = touched(of.teeth, of.links, number);
        }
        let count = self.groups.len() * parts::<S>().len();
        let loaded = vectors::<S>(&of.loaded.hinges[BASE..], count);
        let loaded_before = vectors::<S>(&of.loaded.hinges[BASE - 1..], count);
        let links = LinkRows::of(of, count);
        {
            let [xx, yy, xy] = &mut self.rear;
            let rear = [
                vectors_mut::<S>(xx, count),
                vectors_mut::<S>(yy, count),
                vectors_mut::<S>(xy, count),
            ];
            let teeth = (
                &Bushings::of_three(&of.teeth.tooth_stiffness, count),
                &Bushings::of_three(&of.teeth.spun, count),
            );
            let own = hinge_vectors::<S>(&mut ring.compliance, count);
            let [xx, xy, yx, yy] = &mut self.between;
            let between = [
                vectors_mut::<S>(xx, count),
                vectors_mut::<S>(xy, count),
                vectors_mut::<S>(yx, count),
                vectors_mut::<S>(yy, count),
            ];
            for i in 0..count {
                let (group, part) = group_of::<S, _>(&mut self.groups, i);
                let (levers, _) = group_of::<S, _>(&mut self.levers, i);
                let ends = links.eliminate::<FRICTION>(simd, teeth, (group, levers), (i, part));
                for axis in 0..3 {
                    rear[axis][i] = ends.rear[axis].values();
                }
                let loaded = load(simd, &loaded[i]);
                // S_k += F D⁻¹ F^T and C_k = -F D⁻¹ R^T; hinges without force stay uncoupled.
                for axis in 0..3 {
                    let own = &mut own[axis][i];
                    *own = loaded.mul_add(ends.front[axis], load(simd, own)).values();
                }
                let both = loaded * load(simd, &loaded_before[i]);
                for entry in 0..4 {
                    between[entry][i] = (both * ends.between[entry]).values();
                }
            }
        }
        self.write_rows(simd, of.links, loaded, ring);
    }

    /// Write the rows of the ring: the block of each hinge with `R D⁻¹ R^T` of the next link, and its coupling.
    #[inline(always)]
    fn write_rows<S: Simd>(
        &mut self,
        simd: S,
        links: usize,
        loaded: &[S::f64s],
        ring: &mut HingeBlocks,
    ) {
        let count = loaded.len();
        for rear in &mut self.rear {
            rear[links] = rear[0];
        }
        let [xx, yy, xy] = &self.rear;
        let rear = [
            vectors::<S>(&xx[1..], count),
            vectors::<S>(&yy[1..], count),
            vectors::<S>(&xy[1..], count),
        ];
        let own = hinge_vectors::<S>(&mut ring.compliance, count);
        let [xx, xy, yx, yy] = &self.between;
        let between = [
            vectors::<S>(xx, count),
            vectors::<S>(xy, count),
            vectors::<S>(yx, count),
            vectors::<S>(yy, count),
        ];
        let rows = ring.rows.chunks_exact_mut(S::F64_LANES).take(count);
        for (i, rows) in rows.enumerate() {
            let loaded = load(simd, &loaded[i]);
            let mut entries = [Lanes::splat(simd, 0.0); WIDTH];
            for axis in 0..3 {
                let rear = load(simd, &rear[axis][i]);
                entries[axis] = loaded.mul_add(rear, load(simd, &own[axis][i]));
            }
            for entry in 0..4 {
                entries[BEFORE + entry] = load(simd, &between[entry][i]);
            }
            put_rows(simd, rows, &entries);
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
        // Hinge k: F_k w_k - R_(k+1) w_(k+1) with the free velocities; zero for hinges without force.
        let loaded = packs(&loaded.hinges[BASE..], count);
        for axis in 0..2 {
            let rear = &mut self.rear_velocity[axis];
            rear[links] = rear[0];
            let behind = packs(&rear[1..], count);
            let force = packs_mut(&mut self.force[axis][BASE..], count);
            for number in 0..count {
                for part in parts::<S>() {
                    let front = groups[number].front_velocity[axis].at(simd, part);
                    let closing = front - part_of(simd, &behind[number], part);
                    let loaded = part_of(simd, &loaded[number], part);
                    put_part(&mut force[number], part, loaded * closing);
                }
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
        unknowns: &mut [[Pack8; 3]],
        rows: &[Border],
        sums: &mut [PartialSums],
    ) {
        let count = self.groups.len();
        let [x, y] = &self.force;
        let (front_x, front_y) = (packs(&x[BASE..], count), packs(&y[BASE..], count));
        let (rear_x, rear_y) = (packs(&x[BASE - 1..], count), packs(&y[BASE - 1..], count));
        let (groups, levers) = (&self.groups[..count], &self.levers[..count]);
        let unknowns = &mut unknowns[..count];
        for number in 0..count {
            let group = &groups[number];
            for part in parts::<S>() {
                let at = |array: &[Pack]| part_of(simd, &array[number], part);
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
    pub(super) fn write_ends<S: Simd, const FRICTION: bool>(
        &self,
        simd: S,
        unknowns: &[[Pack8; 3]],
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
                put_part(&mut front_x[number], part, u.mul_add(turn, x));
                put_part(&mut front_y[number], part, v.mul_add(turn, y));
                put_part(&mut rear_x[number], part, u.negate_mul_add(turn, x));
                put_part(&mut rear_y[number], part, v.negate_mul_add(turn, y));
                if FRICTION {
                    put_part(&mut spin[number], part, turn);
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
        column: &mut [[Pack8; 3]],
    ) {
        let count = self.groups.len();
        let parts = parts::<S>();
        let from = Bushings::<S>::of_three(from, count * parts.len());
        let (groups, column) = (&self.groups[..count], &mut column[..count]);
        for number in 0..count {
            let (group, column) = (&groups[number], &mut column[number]);
            if !group.touches_teeth {
                *column = [Pack8::default(); 3];
                continue;
            }
            for part in parts.clone() {
                let place = (number * parts.len() + part, part);
                let [u, v] = read(simd, &group.lever, part);
                let [front_x, rear_x] = group.of_ends(simd, &from[0], place);
                let [front_y, rear_y] = group.of_ends(simd, &from[1], place);
                let mut turn = u.mul_add(front_x - rear_x, v * (front_y - rear_y));
                if FRICTION {
                    let [front, rear] = group.of_ends(simd, &from[2], place);
                    turn = turn + (front + rear);
                }
                write(column, part, [front_x + rear_x, front_y + rear_y, turn]);
            }
        }
    }
}

/// Right-hand sides of the links.
pub(super) trait RightHand<S: Simd> {
    /// Return those of vector `part` of pack `number` of links, `group`.
    fn at(&self, simd: S, group: &LinkGroup, place: (usize, usize)) -> [Lanes<S>; 3];
}

/// Row or column of the border: x, y and θ of the links.
pub(super) type Border = Vec<[Pack8; 3]>;

//! Solution of the ring with its factors: substitution in the eight parts, and cyclic reduction of their last hinges.

use pulp::Simd;

use super::super::blocks::{Block, Symmetric, Vector, from_left, from_right};
use super::{BASE, Ring, Round, gather};
use crate::math::dense::Dense;
use crate::math::simd::{Lanes, Numbers, WIDTH, parts, transposed, vectors_mut, write};

impl Round {
    /// Eliminate both neighbours at `distance` from the right-hand sides.
    #[inline(always)]
    fn reduce<S: Simd>(&self, simd: S, distance: usize, unknowns: &mut [Vector<S>; WIDTH]) {
        let left = from_left(simd, *unknowns, distance);
        let right = from_right(simd, *unknowns, distance);
        for part in parts::<S>() {
            let rest = Block::read(simd, &self.left, part).less(&unknowns[part], &left[part]);
            unknowns[part] = Block::read(simd, &self.right, part).less(&rest, &right[part]);
        }
    }
}

impl Ring {
    /// Solve in place: x and y of the unknowns of all hinges, hinge k at [`BASE`] + k.
    #[inline(always)]
    pub(in super::super) fn solve<S: Simd>(&mut self, simd: S, unknowns: &mut [Numbers; 2]) {
        if let Some(dense) = &self.dense {
            let [x, y] = unknowns;
            let hinges = BASE..BASE + self.hinges;
            return solve_short(dense, &mut x[hinges.clone()], &mut y[hinges]);
        }
        for (axis, numbers) in unknowns.iter().enumerate() {
            self.take_right_hand_side(simd, axis, numbers);
        }
        self.solve_places(simd);
        for (axis, numbers) in unknowns.iter_mut().enumerate() {
            self.give_back(simd, axis, numbers);
        }
    }

    /// Copy one axis of the right-hand sides place by place; empty first places get zero.
    #[inline(always)]
    fn take_right_hand_side<S: Simd>(&mut self, simd: S, axis: usize, from: &[f64]) {
        for part in parts::<S>() {
            let mut starts = [0; WIDTH];
            starts[..S::F64_LANES].copy_from_slice(self.starts_of::<S>(part));
            for first in self.vector_places::<S>() {
                let columns = gather(simd, &from[first..], &starts);
                let places = &mut self.unknowns[first..first + S::F64_LANES];
                for lane in 0..S::F64_LANES {
                    places[lane][axis].put(part, columns[lane]);
                }
            }
            if self.has_single_place::<S>() {
                let last = self.count - 1;
                let place = &mut self.unknowns[last][axis].0;
                for lane in 0..S::F64_LANES {
                    place[part * S::F64_LANES + lane] = from[starts[lane] + last];
                }
            }
            let all = self.have_all(simd, part);
            let first = &mut self.unknowns[0][axis];
            first.put(
                part,
                all.select(first.at(simd, part), Lanes::splat(simd, 0.0)),
            );
        }
    }

    /// Write one axis of the unknowns hinge by hinge.
    #[inline(always)]
    fn give_back<S: Simd>(&self, simd: S, axis: usize, to: &mut [f64]) {
        let lanes = S::F64_LANES;
        // The last vectors end with the last place where a part has as many places as a vector has lanes. Otherwise the next part
        // overwrites the values behind the last place.
        let most = self.count.saturating_sub(lanes);
        for part in parts::<S>() {
            let starts = self.starts_of::<S>(part);
            for place in self.vector_places::<S>() {
                let place = place.min(most);
                let mut rows = [Lanes::splat(simd, 0.0); WIDTH];
                let places = &self.unknowns[place..place + lanes];
                for lane in 0..lanes {
                    rows[lane] = places[lane][axis].at(simd, part);
                }
                let columns = transposed(simd, rows);
                for lane in 0..lanes {
                    let first = starts[lane] + place;
                    let to = &mut to[first..first + lanes];
                    vectors_mut::<S>(to, 1)[0] = columns[lane].values();
                }
            }
        }
        if self.has_single_place::<S>() {
            let last = self.count - 1;
            for (&start, &value) in self.starts.iter().zip(&self.unknowns[last][axis].0) {
                to[start + last] = value;
            }
        }
        // Empty first places have overwritten the hinges before them.
        let last = &self.unknowns[self.count - 1][axis].0;
        for part in self.full..WIDTH {
            to[self.starts[part]] = last[part - 1];
        }
        let behind = &mut to[BASE + self.hinges..BASE + self.hinges + WIDTH];
        behind.fill(0.0);
    }

    /// Solve for the unknowns, which initially hold the right-hand sides place by place.
    #[inline(always)]
    fn solve_places<S: Simd>(&mut self, simd: S) {
        let last = self.count - 1;
        let mut to_last = [Vector::zero(simd); WIDTH];
        let mut unknowns = [Vector::zero(simd); WIDTH];
        for part in parts::<S>() {
            // Forward elimination of the parts.
            let mut right = Vector::read(simd, &self.unknowns[0], part);
            for j in 0..last {
                let place = &self.places[j];
                to_last[part].add(&Block::read(simd, &place.before, part).transposed_of(&right));
                let next = Vector::read(simd, &self.unknowns[j + 1], part);
                right = Block::read(simd, &place.next, part).transposed_less(&next, &right);
                write(&mut self.unknowns[j + 1], part, right.0);
            }
            unknowns[part] = right;
        }
        let taken = from_right(simd, to_last, 1);
        for part in parts::<S>() {
            unknowns[part].subtract(&taken[part]);
        }
        // Cyclic reduction of the eight remaining rows.
        let [first, second] = &self.rounds;
        first.reduce(simd, 1, &mut unknowns);
        second.reduce(simd, 2, &mut unknowns);
        let across = from_left(simd, unknowns, WIDTH / 2);
        for part in parts::<S>() {
            let right =
                Block::read(simd, &self.opposite, part).less(&unknowns[part], &across[part]);
            unknowns[part] = Symmetric::read(simd, &self.inverse, part).of(&right);
        }
        // Back substitution: f_j = S⁻¹ r_j - `before` f_last - `next` f_(j+1), f_last of the previous part.
        let before = from_left(simd, unknowns, 1);
        for part in parts::<S>() {
            let mut next = unknowns[part];
            write(&mut self.unknowns[last], part, next.0);
            for j in (0..last).rev() {
                let place = &self.places[j];
                let right = Vector::read(simd, &self.unknowns[j], part);
                let own = Symmetric::read(simd, &place.own, part).of(&right);
                let own = Block::read(simd, &place.before, part).less(&own, &before[part]);
                next = Block::read(simd, &place.next, part).less(&own, &next);
                write(&mut self.unknowns[j], part, next.0);
            }
        }
    }
}

/// Solve a ring with fewer hinges than parts.
fn solve_short(dense: &Dense, x: &mut [f64], y: &mut [f64]) {
    let mut unknowns = [0.0; 2 * WIDTH];
    let count = x.len();
    for (pair, (x, y)) in unknowns.chunks_exact_mut(2).zip(x.iter().zip(&*y)) {
        pair.copy_from_slice(&[*x, *y]);
    }
    dense.solve(&mut unknowns[..2 * count]);
    for (pair, (x, y)) in unknowns.chunks_exact(2).zip(x.iter_mut().zip(y)) {
        (*x, *y) = (pair[0], pair[1]);
    }
}

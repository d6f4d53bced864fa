//! Solution of the ring with its factors: substitution in the eight parts, and cyclic reduction of their last hinges.

use super::super::blocks::{Block, Registers, Symmetric, Vector, from_left, from_right};
use super::{BASE, Ring, Round, gather};
use crate::math::dense::Dense;
use crate::math::simd::{
    Lanes, Number, Numbers, Vectors, WIDTH, parts, transposed, vectors_mut, write,
};

impl<T: Number> Round<T> {
    /// Eliminate both neighbours at `distance` from the right-hand sides.
    #[inline(always)]
    fn reduce<S: Vectors<Number = T>>(
        &self,
        simd: S,
        distance: usize,
        unknowns: &mut [Vector<S>; WIDTH],
    ) {
        let left = from_left(simd, *unknowns, distance);
        let right = from_right(simd, *unknowns, distance);
        for part in parts::<S>() {
            let rest = Block::read(simd, &self.left, part).less(&unknowns[part], &left[part]);
            unknowns[part] = Block::read(simd, &self.right, part).less(&rest, &right[part]);
        }
    }
}

impl<T: Number> Ring<T> {
    /// Solve in place: x and y of the unknowns of all hinges, hinge k at [`BASE`] + k.
    #[inline(always)]
    pub(in super::super) fn solve<S: Vectors<Number = T>>(
        &mut self,
        simd: S,
        unknowns: &mut [Numbers<T>; 2],
    ) {
        if let Some(dense) = &self.dense {
            let [x, y] = unknowns;
            let hinges = BASE..BASE + self.hinges;
            return solve_short(dense, &mut x[hinges.clone()], &mut y[hinges]);
        }
        self.take_right_hand_sides(simd, unknowns);
        self.solve_places(simd);
        self.give_back(simd, unknowns);
    }

    /// Copy the right-hand sides place by place; empty first places get zero.
    #[inline(always)]
    fn take_right_hand_sides<S: Vectors<Number = T>>(&mut self, simd: S, from: &[Numbers<T>; 2]) {
        // Slices of the same length: the bounds of an entry are checked once for both axes.
        let length = from[0].len();
        for part in parts::<S>() {
            for first in self.vector_places::<S>() {
                let entries = self.entries::<S>(first, part);
                let places = &mut self.unknowns[first..first + S::LANES];
                for axis in 0..2 {
                    let columns = gather(simd, &from[axis][..length], &entries);
                    for lane in 0..S::LANES {
                        places[lane][axis].put(part, columns[lane]);
                    }
                }
            }
            if self.has_single_place::<S>() {
                let last = self.count - 1;
                for lane in part * S::LANES..(part + 1) * S::LANES {
                    for axis in 0..2 {
                        let place = &mut self.unknowns[last][axis].0;
                        place[lane] = from[axis][self.starts[lane] + last];
                    }
                }
            }
            let all = self.have_all(simd, part);
            for first in &mut self.unknowns[0] {
                let some = all.select(first.at(simd, part), Lanes::splat(simd, 0.0));
                first.put(part, some);
            }
        }
    }

    /// Write the unknowns hinge by hinge.
    #[inline(always)]
    fn give_back<S: Vectors<Number = T>>(&self, simd: S, to: &mut [Numbers<T>; 2]) {
        let length = to[0].len();
        // The last vectors end with the last place where a part has as many places as a vector has lanes. Otherwise the next part
        // overwrites the values behind the last place.
        let most = self.count.saturating_sub(S::LANES);
        for part in parts::<S>() {
            for place in self.vector_places::<S>() {
                let place = place.min(most);
                let entries = self.entries::<S>(place, part);
                let places = &self.unknowns[place..place + S::LANES];
                for (axis, to) in to.iter_mut().enumerate() {
                    let to = &mut to[..length];
                    let mut rows = [Lanes::splat(simd, 0.0); WIDTH];
                    for lane in 0..S::LANES {
                        rows[lane] = places[lane][axis].at(simd, part);
                    }
                    let columns = transposed(simd, rows);
                    for lane in 0..S::LANES {
                        let to = &mut to[entries[lane]..][..S::LANES];
                        vectors_mut::<S>(to, 1)[0] = columns[lane].values();
                    }
                }
            }
        }
        let last = self.count - 1;
        for (to, unknowns) in to.iter_mut().zip(&self.unknowns[last]) {
            if self.has_single_place::<S>() {
                for (&start, &value) in self.starts.iter().zip(&unknowns.0) {
                    to[start + last] = value;
                }
            }
            // Empty first places have overwritten the hinges before them.
            for part in self.full..WIDTH {
                to[self.starts[part]] = unknowns.0[part - 1];
            }
            let behind = &mut to[BASE + self.hinges..BASE + self.hinges + WIDTH];
            behind.fill(T::default());
        }
    }

    /// Solve for the unknowns, which initially hold the right-hand sides place by place.
    #[inline(always)]
    fn solve_places<S: Vectors<Number = T>>(&mut self, simd: S) {
        let last = self.count - 1;
        // Slices with known lengths: bounds are checked once.
        let (places, kept) = (&self.places[..last], &mut self.unknowns[..=last]);
        let mut to_last = [Vector::zero(simd); WIDTH];
        let mut unknowns = [Vector::zero(simd); WIDTH];
        for part in parts::<S>() {
            // Forward elimination of the parts.
            let mut right = Vector::read(simd, &kept[0], part);
            for j in 0..last {
                let place = &places[j];
                let before = Block::read(simd, &place.before, part);
                to_last[part] = to_last[part].plus(before.transposed_of(&right));
                let next = Vector::read(simd, &kept[j + 1], part);
                right = Block::read(simd, &place.next, part).transposed_less(&next, &right);
                write(&mut kept[j + 1], part, right.0);
            }
            unknowns[part] = right;
        }
        let taken = from_right(simd, to_last, 1);
        for part in parts::<S>() {
            unknowns[part] = unknowns[part].minus(taken[part]);
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
            write(&mut kept[last], part, next.0);
            for j in (0..last).rev() {
                let place = &places[j];
                let right = Vector::read(simd, &kept[j], part);
                let own = Symmetric::read(simd, &place.own, part).of(&right);
                let own = Block::read(simd, &place.before, part).less(&own, &before[part]);
                next = Block::read(simd, &place.next, part).less(&own, &next);
                write(&mut kept[j], part, next.0);
            }
        }
    }
}

/// Solve a ring with fewer hinges than parts.
fn solve_short<T: Number>(dense: &Dense, x: &mut [T], y: &mut [T]) {
    let mut unknowns = [0.0; 2 * WIDTH];
    let count = x.len();
    for (pair, (x, y)) in unknowns.chunks_exact_mut(2).zip(x.iter().zip(&*y)) {
        pair.copy_from_slice(&[x.double(), y.double()]);
    }
    dense.solve(&mut unknowns[..2 * count]);
    for (pair, (x, y)) in unknowns.chunks_exact(2).zip(x.iter_mut().zip(y)) {
        (*x, *y) = (T::nearest(pair[0]), T::nearest(pair[1]));
    }
}

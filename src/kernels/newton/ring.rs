//! The hinges' part of Newton's matrix: a symmetric ring of 2x2 blocks, cut into eight parts that are eliminated side by side.
//!
//! Row k reads `S_k f_k + C_k f_(k-1) + C_(k+1)^T f_(k+1) = r_k`. Each place in a register has a part of the ring, hinges that
//! follow one another. All but the last hinge of each part are eliminated one after the other (S. J. Wang's partition, as for
//! tridiagonal systems); the eight that are left are a ring again, of which each round takes every other neighbour out
//! (cyclic reduction by all rows at once). Hinges that bear nothing have the block one and are coupled with none.

use pulp::Simd;

use super::blocks::{Block, Pair, Symmetric, all, from_left, from_right};
use super::dense::Dense;
use crate::vector::{Mask, Octet, WIDTH, lane_numbers, parts, write};

/// Blocks of eight hinges.
#[derive(Debug, Clone, Copy)]
pub(super) struct HingeGroup {
    /// S: xx, yy, xy.
    pub(super) own: [Octet; 3],
    /// C, which couples hinge k with hinge k - 1: rows, then columns.
    pub(super) before: [Octet; 4],
}

impl Default for HingeGroup {
    /// Hinges that bear nothing.
    fn default() -> Self {
        let (zero, one) = (Octet::of(0.0), Octet::of(1.0));
        Self {
            own: [one, one, zero],
            before: [zero; 4],
        }
    }
}

/// Room for the ring of `hinges`, and for one that is not there and bears nothing.
pub(super) fn hinge_groups(hinges: usize) -> Vec<HingeGroup> {
    vec![HingeGroup::default(); hinges / WIDTH + 1]
}

/// One hinge of each part.
#[derive(Debug, Clone, Copy, Default)]
struct Place {
    /// S, then its inverse when those before have been eliminated.
    own: [Octet; 3],
    /// C; then how the unknowns follow from those of the last hinge of the part before.
    before: [Octet; 4],
    /// How they follow from those of the next hinge.
    next: [Octet; 4],
}

/// One round of the ring of eight.
#[derive(Debug, Clone, Copy, Default)]
struct Round {
    /// How much of the row to the left each row takes.
    left: [Octet; 4],
    right: [Octet; 4],
}

/// The ring's factors.
#[derive(Debug, Clone)]
pub(super) struct Ring {
    hinges: usize,
    /// First hinge of each part. The last ones may have one hinge less than the others: their first place is empty.
    starts: [usize; WIDTH],
    /// How many parts have all places.
    full: usize,
    places: Vec<Place>,
    /// Which hinges they are; `hinges` where none.
    sources: Vec<[usize; WIDTH]>,
    /// Couplings of the second hinges of parts that have no first one, with the part before.
    direct: [Octet; 4],
    rounds: [Round; 2],
    /// The last round, of which both neighbours are one.
    opposite: [Octet; 4],
    inverse: [Octet; 3],
    /// Scratch of a solution, place by place.
    unknowns: Vec<[Octet; 2]>,
    /// Instead of all this in a chain of fewer hinges than parts.
    dense: Option<Dense>,
}

impl Ring {
    /// Room for `hinges`.
    pub(super) fn new(hinges: usize) -> Self {
        let places = hinges.div_ceil(WIDTH);
        let full = hinges - (places - 1) * WIDTH;
        let starts = std::array::from_fn(|part| part * places - part.saturating_sub(full));
        let source = |place: usize, part: usize| match place + usize::from(part < full) {
            0 => hinges,
            behind => starts[part] + behind - 1,
        };
        let sources = (0..places).map(|place| std::array::from_fn(|part| source(place, part)));
        let none = [Octet::default(); 4];
        Self {
            hinges,
            starts,
            full,
            sources: sources.collect(),
            places: vec![Place::default(); places],
            direct: none,
            rounds: [Round::default(); 2],
            opposite: none,
            inverse: [Octet::default(); 3],
            unknowns: vec![[Octet::default(); 2]; places],
            dense: (hinges < WIDTH).then(|| Dense::new(2 * hinges)),
        }
    }

    /// Takes the blocks over.
    #[inline(always)]
    fn take_in(&mut self, groups: &[HingeGroup]) {
        for (place, sources) in self.places.iter_mut().zip(&self.sources) {
            for (part, &hinge) in sources.iter().enumerate() {
                let (group, lane) = (&groups[hinge / WIDTH], hinge % WIDTH);
                for (to, from) in place.own.iter_mut().zip(&group.own) {
                    to.0[part] = from.0[lane];
                }
                for (to, from) in place.before.iter_mut().zip(&group.before) {
                    to.0[part] = from.0[lane];
                }
            }
        }
        if let Some(second) = self.places.get_mut(1) {
            for (direct, before) in self.direct.iter_mut().zip(&mut second.before) {
                for part in self.full..WIDTH {
                    direct.0[part] = std::mem::take(&mut before.0[part]);
                }
            }
        }
    }

    /// Eliminates all but the last place; what is left of that and its coupling with the part before.
    #[inline(always)]
    fn eliminate<S: Simd>(&mut self, simd: S) -> Left<S> {
        let last = self.places.len() - 1;
        let mut left = Left::nothing(simd);
        for part in parts::<S>() {
            let mut own = Symmetric::read(simd, &self.places[0].own, part);
            let mut edge = Block::read(simd, &self.places[0].before, part);
            let mut to_last = Symmetric::zero(simd);
            for j in 0..last {
                let inverse = own.inverse(&mut left.irregular);
                let coupling = Block::read(simd, &self.places[j + 1].before, part);
                let next = inverse.times_transposed(&coupling);
                let from_last = inverse.times_block(&edge);
                own = Symmetric::read(simd, &self.places[j + 1].own, part);
                own.take_off(&coupling, &next);
                to_last.add(&edge, &from_last);
                edge = if j == 0 {
                    Block::read(simd, &self.direct, part)
                } else {
                    Block::zero(simd)
                };
                edge.take_off(&coupling, &from_last);
                let place = &mut self.places[j];
                write(&mut place.own, part, inverse.0);
                write(&mut place.next, part, next.0);
                write(&mut place.before, part, from_last.0);
            }
            left.own[part] = own;
            left.edge[part] = edge;
            left.to_last[part] = to_last;
        }
        left
    }

    /// Solves the ring of the eight that are left; false when a block has no inverse.
    #[inline(always)]
    fn reduce<S: Simd>(&mut self, simd: S, left: &Left<S>) -> bool {
        let (mut own, mut coupling) = (left.own, left.edge);
        let mut irregular = left.irregular;
        let taken = from_right(simd, left.to_last, 1);
        for part in parts::<S>() {
            own[part].subtract(&taken[part]);
        }
        for (distance, round) in [1, 2].into_iter().zip(&mut self.rounds) {
            let mut inverse = [Symmetric::zero(simd); WIDTH];
            let mut follow = [Block::zero(simd); WIDTH];
            let mut taken = [Symmetric::zero(simd); WIDTH];
            for part in parts::<S>() {
                inverse[part] = own[part].inverse(&mut irregular);
                follow[part] = inverse[part].times_block(&coupling[part]);
                taken[part] = coupling[part].transposed_times(&follow[part]);
            }
            let inverse = from_left(simd, inverse, distance);
            let beyond = from_left(simd, coupling, distance);
            let follow = from_right(simd, follow, distance);
            let taken = from_right(simd, taken, distance);
            for part in parts::<S>() {
                let share = coupling[part].times_symmetric(&inverse[part]);
                own[part].subtract(&taken[part]);
                own[part].take_off(&share, &coupling[part].transposed());
                coupling[part] = share.times(&beyond[part]).negated();
                write(&mut round.left, part, share.0);
                write(&mut round.right, part, follow[part].transposed().0);
            }
        }
        let mut inverse = [Symmetric::zero(simd); WIDTH];
        for part in parts::<S>() {
            inverse[part] = own[part].inverse(&mut irregular);
        }
        let inverse = from_left(simd, inverse, WIDTH / 2);
        let across = from_left(simd, coupling, WIDTH / 2);
        for part in parts::<S>() {
            let both = coupling[part].plus(&across[part].transposed());
            let share = both.times_symmetric(&inverse[part]);
            own[part].take_off(&share, &both.transposed());
            write(&mut self.opposite, part, share.0);
            let inverse = own[part].inverse(&mut irregular);
            write(&mut self.inverse, part, inverse.0);
        }
        !irregular.any()
    }

    /// Factorises the ring of these blocks; false when one has no inverse.
    #[inline(always)]
    pub(super) fn factorise<S: Simd>(&mut self, simd: S, groups: &[HingeGroup]) -> bool {
        if let Some(dense) = &mut self.dense {
            return factorise_short(dense, self.hinges, groups);
        }
        self.take_in(groups);
        let left = self.eliminate(simd);
        self.reduce(simd, &left)
    }

    /// Solves in place: x and y of the unknowns of all hinges.
    #[inline(always)]
    pub(super) fn solve<S: Simd>(&mut self, simd: S, [x, y]: [&mut [f64]; 2]) {
        if let Some(dense) = &self.dense {
            return solve_short(dense, x, y);
        }
        for (part, &start) in self.starts.iter().enumerate() {
            let empty = usize::from(part >= self.full);
            if empty > 0 {
                self.unknowns[0][0].0[part] = 0.0;
                self.unknowns[0][1].0[part] = 0.0;
            }
            let places = &mut self.unknowns[empty..];
            let end = start + places.len();
            for (place, (x, y)) in places
                .iter_mut()
                .zip(x[start..end].iter().zip(&y[start..end]))
            {
                place[0].0[part] = *x;
                place[1].0[part] = *y;
            }
        }
        self.solve_places(simd);
        for (part, &start) in self.starts.iter().enumerate() {
            let places = &self.unknowns[usize::from(part >= self.full)..];
            let end = start + places.len();
            let (x, y) = (&mut x[start..end], &mut y[start..end]);
            for (place, (x, y)) in places.iter().zip(x.iter_mut().zip(y)) {
                *x = place[0].0[part];
                *y = place[1].0[part];
            }
        }
    }

    /// Solves for the unknowns, which hold the right-hand sides place by place.
    #[inline(always)]
    fn solve_places<S: Simd>(&mut self, simd: S) {
        let last = self.places.len() - 1;
        let mut to_last = [Pair::zero(simd); WIDTH];
        let mut unknowns = [Pair::zero(simd); WIDTH];
        for part in parts::<S>() {
            let mut right = Pair::read(simd, &self.unknowns[0], part);
            for j in 0..last {
                let place = &self.places[j];
                to_last[part].add(&Block::read(simd, &place.before, part).transposed_of(&right));
                let next = Pair::read(simd, &self.unknowns[j + 1], part);
                right = Block::read(simd, &place.next, part).transposed_less(&next, &right);
                write(&mut self.unknowns[j + 1], part, right.0);
            }
            unknowns[part] = right;
        }
        let taken = from_right(simd, to_last, 1);
        for part in parts::<S>() {
            unknowns[part].subtract(&taken[part]);
        }
        for (distance, round) in [1, 2].into_iter().zip(&self.rounds) {
            let left = from_left(simd, unknowns, distance);
            let right = from_right(simd, unknowns, distance);
            for part in parts::<S>() {
                let rest = Block::read(simd, &round.left, part).less(&unknowns[part], &left[part]);
                unknowns[part] = Block::read(simd, &round.right, part).less(&rest, &right[part]);
            }
        }
        let across = from_left(simd, unknowns, WIDTH / 2);
        for part in parts::<S>() {
            let right =
                Block::read(simd, &self.opposite, part).less(&unknowns[part], &across[part]);
            unknowns[part] = Symmetric::read(simd, &self.inverse, part).of(&right);
        }
        let before = from_left(simd, unknowns, 1);
        for part in parts::<S>() {
            let mut next = unknowns[part];
            write(&mut self.unknowns[last], part, next.0);
            for j in (0..last).rev() {
                let place = &self.places[j];
                let right = Pair::read(simd, &self.unknowns[j], part);
                let own = Symmetric::read(simd, &place.own, part).of(&right);
                let own = Block::read(simd, &place.before, part).less(&own, &before[part]);
                next = Block::read(simd, &place.next, part).less(&own, &next);
                write(&mut self.unknowns[j], part, next.0);
            }
        }
    }
}

/// What elimination leaves of the eight parts.
struct Left<S: Simd> {
    /// Blocks of their last hinges.
    own: [Symmetric<S>; WIDTH],
    /// Couplings of each with the part before.
    edge: [Block<S>; WIDTH],
    /// What each takes off the last hinge of the part before.
    to_last: [Symmetric<S>; WIDTH],
    irregular: Mask<S>,
}

impl<S: Simd> Left<S> {
    #[inline(always)]
    fn nothing(simd: S) -> Self {
        let number = lane_numbers(simd);
        Self {
            own: all(Symmetric::zero(simd)),
            edge: all(Block::zero(simd)),
            to_last: all(Symmetric::zero(simd)),
            irregular: number.less(number),
        }
    }
}

fn factorise_short(dense: &mut Dense, hinges: usize, groups: &[HingeGroup]) -> bool {
    dense.clear();
    for k in 0..hinges {
        let (group, before) = (&groups[k / WIDTH], (k + hinges - 1) % hinges);
        for (entry, (i, j)) in [(0, 0), (1, 1), (0, 1)].into_iter().enumerate() {
            let value = group.own[entry].0[k % WIDTH];
            dense.add(2 * k + i, 2 * k + j, value);
            if i != j {
                dense.add(2 * k + j, 2 * k + i, value);
            }
        }
        for (entry, octet) in group.before.iter().enumerate() {
            let value = octet.0[k % WIDTH];
            let (i, j) = (2 * k + entry / 2, 2 * before + entry % 2);
            dense.add(i, j, value);
            dense.add(j, i, value);
        }
    }
    dense.factorise()
}

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

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    use pulp::WithSimd;

    use super::*;
    use crate::vector::InstructionSet;

    struct FactoriseRing<'a> {
        ring: &'a mut Ring,
        groups: &'a [HingeGroup],
    }

    impl WithSimd for FactoriseRing<'_> {
        type Output = bool;
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> bool {
            self.ring.factorise(simd, self.groups)
        }
    }

    struct SolveRing<'a> {
        ring: &'a mut Ring,
        unknowns: [&'a mut [f64]; 2],
    }

    impl WithSimd for SolveRing<'_> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            self.ring.solve(simd, self.unknowns);
        }
    }

    proptest! {
        #[test]
        fn solutions_are_those_of_the_dense_matrix(
            n in 2usize..90,
            open in proptest::collection::vec(0u8..4, 90),
            any_open in any::<bool>(),
            numbers in proptest::collection::vec(-0.3f64..0.3, 800),
        ) {
            let closed = |k: usize| !any_open || open[k] > 0;
            let mut next = numbers.iter().copied().cycle();
            let mut groups = hinge_groups(n);
            for k in 0..n {
                let (group, lane) = (&mut groups[k / WIDTH], k % WIDTH);
                let coupled = closed(k) && closed((k + n - 1) % n);
                for (entry, octet) in group.own.iter_mut().enumerate() {
                    let one = f64::from(u8::from(entry < 2));
                    octet.0[lane] = if closed(k) { 1.5 * one + next.next().unwrap() } else { one };
                }
                for octet in &mut group.before {
                    octet.0[lane] = if coupled { next.next().unwrap() } else { 0.0 };
                }
            }
            let mut dense = DMatrix::<f64>::zeros(2 * n, 2 * n);
            for k in 0..n {
                let (group, lane) = (&groups[k / WIDTH], k % WIDTH);
                let [a, d, b] = [0, 1, 2].map(|i| group.own[i].0[lane]);
                dense[(2 * k, 2 * k)] += a;
                dense[(2 * k + 1, 2 * k + 1)] += d;
                dense[(2 * k, 2 * k + 1)] += b;
                dense[(2 * k + 1, 2 * k)] += b;
                let before = (k + n - 1) % n;
                for (i, entry) in group.before.iter().map(|octet| octet.0[lane]).enumerate() {
                    dense[(2 * k + i / 2, 2 * before + i % 2)] += entry;
                    dense[(2 * before + i % 2, 2 * k + i / 2)] += entry;
                }
            }
            let right = DVector::from_fn(2 * n, |i, _| if closed(i / 2) { 1.0 + (i % 7) as f64 } else { 0.0 });
            prop_assume!(dense.clone().cholesky().is_some());
            let mut bits: Option<Vec<f64>> = None;
            for set in InstructionSet::available() {
                let mut ring = Ring::new(n);
                let regular = set.run(FactoriseRing { ring: &mut ring, groups: &groups });
                prop_assert!(regular);
                let mut x: Vec<f64> = right.iter().step_by(2).copied().collect();
                let mut y: Vec<f64> = right.iter().skip(1).step_by(2).copied().collect();
                set.run(SolveRing { ring: &mut ring, unknowns: [&mut x, &mut y] });
                let found = DVector::from_fn(2 * n, |i, _| if i % 2 == 0 { x[i / 2] } else { y[i / 2] });
                let error = (&dense * &found - &right).amax() / found.amax().max(1e-3);
                prop_assert!(error < 1e-12, "{} {}", set.name(), error);
                if set.has_fused_multiply_add() {
                    let same = bits.get_or_insert_with(|| found.as_slice().to_vec());
                    prop_assert_eq!(&same[..], found.as_slice());
                }
            }
        }
    }

    #[test]
    fn a_block_without_an_inverse_is_reported() {
        for hinge in [0, 3, 20, 37] {
            let mut groups = hinge_groups(38);
            for wrong in [0.0, f64::NAN, -1.0] {
                groups[hinge / WIDTH].own[0].0[hinge % WIDTH] = wrong;
                for set in InstructionSet::available() {
                    let mut ring = Ring::new(38);
                    let regular = set.run(FactoriseRing {
                        ring: &mut ring,
                        groups: &groups,
                    });
                    assert!(!regular, "{hinge} {wrong} {}", set.name());
                }
            }
        }
    }
}

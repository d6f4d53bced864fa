//! The hinges' part of Newton's matrix: a symmetric ring of 2x2 blocks, cut into eight parts that are eliminated in parallel.
//!
//! Row k reads `S_k f_k + C_k f_(k-1) + C_(k+1)^T f_(k+1) = r_k`. Each SIMD lane holds one part of the ring, which consists of
//! consecutive hinges. All but the last hinge of each part are eliminated in sequence (partition method of H. H. Wang, as for
//! tridiagonal systems). The remaining eight hinges form a ring again. They are solved by parallel cyclic reduction: each round
//! eliminates both neighbours of every row and doubles their distance. Hinges without force have the identity as block and no
//! coupling.

mod solve;

use super::blocks::{Block, Registers, Symmetric, from_left, from_right};
use crate::math::dense::Dense;
use crate::math::simd::{
    Lanes, Mask, Number, Numbers, Pack8, Vectors, WIDTH, lane_numbers, load, no_lane, padded,
    padded_zeros, parts, transposed, vectors, vectors_from_mut, write,
};

/// Entry of hinge 0 in arrays with a copy of the last hinge before it.
pub(super) const BASE: usize = WIDTH;

/// S and C of each hinge: entries xx, yy and xy of S, one without use, and C in row-major order. C couples hinge k with hinge k - 1.
pub(super) type HingeRows<T> = Vec<Pack8<T>>;

/// Entry of C in a row of [`HingeRows`].
pub(super) const BEFORE: usize = 4;

/// Allocate the rows of `hinges`.
pub(super) fn hinge_rows<T: Number>(hinges: usize) -> HingeRows<T> {
    vec![Pack8::default(); padded(hinges)]
}

/// Give the rows of these ideal hinges, which have no joint, the identity as block: their coupling is zero already.
pub(super) fn give_identity<T: Number>(rows: &mut [Pack8<T>], hinges: impl Iterator<Item = usize>) {
    for k in hinges {
        [rows[k].0[0], rows[k].0[1]] = [T::nearest(1.0); 2];
    }
}

/// Write the rows of one vector of hinges from their entries.
#[inline(always)]
pub(super) fn put_rows<S: Vectors>(
    simd: S,
    rows: &mut [Pack8<S::Number>],
    entries: &[Lanes<S>; WIDTH],
) {
    let rows = &mut rows[..S::LANES];
    for part in parts::<S>() {
        let mut some = [Lanes::splat(simd, 0.0); WIDTH];
        for lane in 0..S::LANES {
            some[lane] = entries[part * S::LANES + lane];
        }
        let columns = transposed(simd, some);
        for lane in 0..S::LANES {
            rows[lane].put(part, columns[lane]);
        }
    }
}

/// Return the first `count` vectors of three arrays of hinges.
#[inline(always)]
pub(super) fn hinge_vectors<S: Vectors>(
    [xx, yy, xy]: &mut [Numbers<S::Number>; 3],
    count: usize,
) -> [&mut [S::Vector]; 3] {
    [
        vectors_from_mut::<S>(xx, BASE, count),
        vectors_from_mut::<S>(yy, BASE, count),
        vectors_from_mut::<S>(xy, BASE, count),
    ]
}

/// Allocate one number per hinge, hinge k at [`BASE`] + k, and one vector behind them.
pub(super) fn hinge_numbers<T: Number>(hinges: usize) -> Numbers<T> {
    padded_zeros(BASE + hinges + WIDTH)
}

/// One hinge of each of the eight parts.
#[derive(Debug, Clone, Copy, Default)]
struct PartBlocks<T> {
    /// S; after elimination the inverse of the reduced S.
    own: [Pack8<T>; 3],
    /// C; after elimination the coefficients of the last hinge of the previous part in the unknowns of this hinge.
    before: [Pack8<T>; 4],
    /// Coefficients of the next hinge in the unknowns of this hinge.
    next: [Pack8<T>; 4],
}

/// Factors of one round of the cyclic reduction of eight rows.
#[derive(Debug, Clone, Copy, Default)]
struct Round<T> {
    /// Factors by which the left neighbour's row is subtracted from each row.
    left: [Pack8<T>; 4],
    /// Factors by which the right neighbour's row is subtracted from each row.
    right: [Pack8<T>; 4],
}

impl<T: Number> Round<T> {
    /// Eliminate both neighbours at `distance` from every row.
    ///
    /// With C the coupling of row k with row k - d: `S_k -= C_k S_(k-d)⁻¹ C_k^T + C_(k+d)^T S_(k+d)⁻¹ C_(k+d)`, and the new coupling with
    /// row k - 2 d is `-C_k S_(k-d)⁻¹ C_(k-d)`.
    #[inline(always)]
    fn eliminate<S: Vectors<Number = T>>(
        &mut self,
        simd: S,
        distance: usize,
        (own, coupling): (&mut [Symmetric<S>; WIDTH], &mut [Block<S>; WIDTH]),
        irregular: &mut Mask<S>,
    ) {
        let mut inverse = [Symmetric::zero(simd); WIDTH];
        let mut follow = [Block::zero(simd); WIDTH];
        let mut taken = [Symmetric::zero(simd); WIDTH];
        for part in parts::<S>() {
            inverse[part] = own[part].inverse(irregular);
            follow[part] = inverse[part].times_block(&coupling[part]);
            taken[part] = coupling[part].transposed_times(&follow[part]);
        }
        let inverse = from_left(simd, inverse, distance);
        let beyond = from_left(simd, *coupling, distance);
        let follow = from_right(simd, follow, distance);
        let taken = from_right(simd, taken, distance);
        for part in parts::<S>() {
            let share = coupling[part].times_symmetric(&inverse[part]);
            own[part] = own[part].minus(taken[part]);
            own[part].sub_product(&share, &coupling[part].transposed());
            coupling[part] = share.times(&beyond[part]).negated();
            write(&mut self.left, part, share.0);
            write(&mut self.right, part, follow[part].transposed().0);
        }
    }
}

/// What the elimination of the eight parts leaves.
#[derive(Debug, Clone, Copy, Default)]
struct Left<T> {
    /// Blocks of the last hinges.
    own: [Pack8<T>; 3],
    /// Couplings of each last hinge with the last hinge of the previous part.
    edge: [Pack8<T>; 4],
    /// Blocks that each part subtracts from the last hinge of the previous part.
    to_last: [Pack8<T>; 3],
}

/// Factors of the ring.
#[derive(Debug, Clone)]
pub(super) struct Ring<T: Number> {
    hinges: usize,
    /// Entry of the first place of each part. The last parts may have one hinge less than the others. Their first place is empty,
    /// and this is the entry of the hinge before it.
    starts: [usize; WIDTH],
    /// Number of parts with all places occupied.
    full: usize,
    /// Number of places per part; `places` and `unknowns` have some more, whose values are not used.
    count: usize,
    places: Vec<PartBlocks<T>>,
    /// Couplings of the second places with the previous part, for parts with an empty first place.
    direct: [Pack8<T>; 4],
    /// Scratch of a factorisation.
    left: Left<T>,
    rounds: [Round<T>; 2],
    /// Factors of the last round, in which both neighbours are the same row.
    opposite: [Pack8<T>; 4],
    /// Inverses of the blocks after the last round.
    inverse: [Pack8<T>; 3],
    /// Scratch of a solution, place by place.
    unknowns: Vec<[Pack8<T>; 2]>,
    /// Dense matrix for a chain with fewer hinges than parts, in place of all other fields.
    dense: Option<Dense>,
}

impl<T: Number> Ring<T> {
    /// Allocate the factors for `hinges`.
    pub(super) fn new(hinges: usize) -> Self {
        let count = hinges.div_ceil(WIDTH);
        let full = hinges - (count - 1) * WIDTH;
        let start = |part: usize| BASE + part * count - (part + 1).saturating_sub(full);
        let none = [Pack8::default(); 4];
        Self {
            hinges,
            starts: std::array::from_fn(start),
            full,
            count,
            places: vec![PartBlocks::default(); count + WIDTH],
            direct: none,
            left: Left::default(),
            rounds: [Round::default(); 2],
            opposite: none,
            inverse: [Pack8::default(); 3],
            unknowns: vec![[Pack8::default(); 2]; count + WIDTH],
            dense: (hinges < WIDTH).then(|| Dense::new(2 * hinges)),
        }
    }

    /// Return whether a single place is left behind those that fill vectors: its numbers are copied one by one.
    #[inline(always)]
    fn has_single_place<S: Vectors<Number = T>>(&self) -> bool {
        S::LANES > 1 && self.count % S::LANES == 1
    }

    /// Return the first places of the vectors of one part, without a single place behind them.
    #[inline(always)]
    fn vector_places<S: Vectors<Number = T>>(&self) -> impl Iterator<Item = usize> + use<S, T> {
        let places = self.count - usize::from(self.has_single_place::<S>());
        (0..places.div_ceil(S::LANES)).map(|number| number * S::LANES)
    }

    /// Return the entries of place `place` of the parts in vector `part`, as many as a vector has lanes.
    #[inline(always)]
    fn entries<S: Vectors<Number = T>>(&self, place: usize, part: usize) -> [usize; WIDTH] {
        let mut entries = [0; WIDTH];
        for lane in 0..S::LANES {
            entries[lane] = self.starts[part * S::LANES + lane] + place;
        }
        entries
    }

    /// Return the mask of the parts in vector `part` with all places occupied.
    #[inline(always)]
    fn have_all<S: Vectors<Number = T>>(&self, simd: S, part: usize) -> Mask<S> {
        let full = self.full as f64 - (part * S::LANES) as f64;
        lane_numbers(simd).less(Lanes::splat(simd, full - 0.5))
    }

    /// Copy the blocks and transpose them: from rows of hinges to one hinge of each part.
    #[inline(always)]
    fn gather_blocks<S: Vectors<Number = T>>(&mut self, simd: S, rows: &[Pack8<T>]) {
        let count = self.count;
        for part in parts::<S>() {
            // Rows of each part: slices of a known length, so that their bounds are checked once.
            let mut of_parts = [&rows[..0]; WIDTH];
            for (lane, entry) in (0..S::LANES).zip(self.entries::<S>(0, part)) {
                of_parts[lane] = &rows[entry - BASE..entry - BASE + count];
            }
            for (j, place) in self.places[..count].iter_mut().enumerate() {
                let mut entries = [Lanes::splat(simd, 0.0); WIDTH];
                for half in parts::<S>() {
                    let mut some = [Lanes::splat(simd, 0.0); WIDTH];
                    for lane in 0..S::LANES {
                        some[lane] = of_parts[lane][j].at(simd, half);
                    }
                    let columns = transposed(simd, some);
                    for lane in 0..S::LANES {
                        entries[half * S::LANES + lane] = columns[lane];
                    }
                }
                let [xx, yy, xy, _, before @ ..] = entries;
                write(&mut place.own, part, [xx, yy, xy]);
                write(&mut place.before, part, before);
            }
        }
        if self.full < WIDTH {
            self.leave_first_places_empty(simd);
        }
    }

    /// Give empty first places the identity and couple the second place with the previous part.
    #[inline(always)]
    fn leave_first_places_empty<S: Vectors<Number = T>>(&mut self, simd: S) {
        let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
        for part in parts::<S>() {
            let all = self.have_all(simd, part);
            for (pack8, nothing) in self.places[0].own.iter_mut().zip([one, one, zero]) {
                pack8.put(part, all.select(pack8.at(simd, part), nothing));
            }
            for pack8 in &mut self.places[0].before {
                pack8.put(part, all.select(pack8.at(simd, part), zero));
            }
            for (direct, before) in self.direct.iter_mut().zip(&mut self.places[1].before) {
                let coupling = before.at(simd, part);
                direct.put(part, all.select(zero, coupling));
                before.put(part, all.select(coupling, zero));
            }
        }
    }

    /// Eliminate all but the last place of each part; mark lanes with a block that is not positive definite as `irregular`.
    #[inline(always)]
    fn eliminate<S: Vectors<Number = T>>(&mut self, simd: S, irregular: &mut Mask<S>) {
        let last = self.count - 1;
        for part in parts::<S>() {
            let places = &mut self.places[..self.count];
            // With E the coupling of place j with the last hinge of the previous part, S and E already reduced: f_j = S⁻¹ r_j - S⁻¹
            // C_(j+1)^T f_(j+1) - S⁻¹ E f_last. Hinge j + 1 gets S_(j+1) - C_(j+1) S⁻¹ C_(j+1)^T and E' = -C_(j+1) S⁻¹ E. The last
            // hinge of the previous part loses E^T S⁻¹ E. Two loops, for S and for E: one needs more registers than AVX2 has.
            let mut own = Symmetric::read(simd, &places[0].own, part);
            for j in 0..last {
                let inverse = own.inverse(irregular);
                let coupling = Block::read(simd, &places[j + 1].before, part);
                let next = inverse.times_transposed(&coupling);
                own = Symmetric::read(simd, &places[j + 1].own, part);
                own.sub_product(&coupling, &next);
                write(&mut places[j].own, part, inverse.0);
                write(&mut places[j].next, part, next.0);
            }
            let mut edge = Block::read(simd, &places[0].before, part);
            let mut to_last = Symmetric::zero(simd);
            let mut direct = Block::read(simd, &self.direct, part);
            for j in 0..last {
                let inverse = Symmetric::read(simd, &places[j].own, part);
                let coupling = Block::read(simd, &places[j + 1].before, part);
                let from_last = inverse.times_block(&edge);
                to_last.add(&edge, &from_last);
                edge = direct;
                edge.sub_product(&coupling, &from_last);
                direct = Block::zero(simd);
                write(&mut places[j].before, part, from_last.0);
            }
            write(&mut self.left.own, part, own.0);
            write(&mut self.left.edge, part, edge.0);
            write(&mut self.left.to_last, part, to_last.0);
        }
    }

    /// Factorise the ring of the eight remaining rows by parallel cyclic reduction; return false where a block is not positive
    /// definite.
    #[inline(always)]
    fn reduce<S: Vectors<Number = T>>(&mut self, simd: S, irregular: &mut Mask<S>) -> bool {
        let mut own = [Symmetric::zero(simd); WIDTH];
        let mut coupling = [Block::zero(simd); WIDTH];
        let mut to_last = [Symmetric::zero(simd); WIDTH];
        for part in parts::<S>() {
            own[part] = Symmetric::read(simd, &self.left.own, part);
            coupling[part] = Block::read(simd, &self.left.edge, part);
            to_last[part] = Symmetric::read(simd, &self.left.to_last, part);
        }
        let taken = from_right(simd, to_last, 1);
        for part in parts::<S>() {
            own[part] = own[part].minus(taken[part]);
        }
        // Two calls with constant distances: vectors are then rotated within registers.
        let [first, second] = &mut self.rounds;
        first.eliminate(simd, 1, (&mut own, &mut coupling), irregular);
        second.eliminate(simd, 2, (&mut own, &mut coupling), irregular);
        // Distance four: both neighbours are the same row, and the couplings add.
        let mut inverse = [Symmetric::zero(simd); WIDTH];
        for part in parts::<S>() {
            inverse[part] = own[part].inverse(irregular);
        }
        let inverse = from_left(simd, inverse, WIDTH / 2);
        let across = from_left(simd, coupling, WIDTH / 2);
        for part in parts::<S>() {
            let both = coupling[part].plus(across[part].transposed());
            let share = both.times_symmetric(&inverse[part]);
            own[part].sub_product(&share, &both.transposed());
            write(&mut self.opposite, part, share.0);
            let inverse = own[part].inverse(irregular);
            write(&mut self.inverse, part, inverse.0);
        }
        !irregular.any()
    }

    /// Factorise the ring of these rows; return false where a block is not positive definite.
    #[inline(always)]
    pub(super) fn factorise<S: Vectors<Number = T>>(&mut self, simd: S, rows: &[Pack8<T>]) -> bool {
        if let Some(dense) = &mut self.dense {
            return factorise_short(dense, self.hinges, rows);
        }
        self.gather_blocks(simd, rows);
        let mut irregular = no_lane(simd);
        self.eliminate(simd, &mut irregular);
        self.reduce(simd, &mut irregular)
    }
}

/// Return the vectors of an array from these entries on, transposed: one column per place, as many as a vector has lanes.
#[inline(always)]
fn gather<S: Vectors>(simd: S, from: &[S::Number], entries: &[usize; WIDTH]) -> [Lanes<S>; WIDTH] {
    let mut lanes = [Lanes::splat(simd, 0.0); WIDTH];
    for lane in 0..S::LANES {
        // With two ranges the sum of entry and width needs no check for overflow.
        let row = &from[entries[lane]..][..S::LANES];
        lanes[lane] = load(simd, &vectors::<S>(row, 1)[0]);
    }
    transposed(simd, lanes)
}

/// Factorise a ring with fewer hinges than parts as a dense matrix.
fn factorise_short<T: Number>(dense: &mut Dense, hinges: usize, rows: &[Pack8<T>]) -> bool {
    dense.clear();
    for k in 0..hinges {
        let before = (k + hinges - 1) % hinges;
        let row = rows[k].0.map(Number::double);
        let (own, coupling) = row.split_at(BEFORE);
        for (&value, (i, j)) in own.iter().zip([(0, 0), (1, 1), (0, 1)]) {
            dense.add(2 * k + i, 2 * k + j, value);
            if i != j {
                dense.add(2 * k + j, 2 * k + i, value);
            }
        }
        for (entry, &value) in coupling.iter().enumerate() {
            let (i, j) = (2 * k + entry / 2, 2 * before + entry % 2);
            dense.add(i, j, value);
            dense.add(j, i, value);
        }
    }
    dense.factorise()
}

#[cfg(test)]
mod tests;

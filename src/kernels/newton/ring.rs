//! The hinges' part of Newton's matrix: a symmetric ring of 2x2 blocks, of which hinges that bear nothing drop out.
//!
//! Row k reads `S_k q_k + C_k q_(k-1) + C_(k+1)^T q_(k+1) = r_k`. Open hinges cut the ring into pieces, and each piece is
//! eliminated from both of its ends towards its middle, two sweeps that do not wait for each other. A ring without an open
//! hinge is cut at the last one, whose two unknowns are solved for at the end.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use crate::vector::Numbers;

/// A symmetric 2x2 block: its entries on the diagonal, first and last, and the one beside it.
type Symmetric = [f64; 3];

/// Rows, then columns, of a 2x2 block.
type Block = [f64; 4];

/// The ring's blocks, an array an entry.
#[derive(Debug, Clone)]
pub(super) struct RingBlocks {
    /// S, entries as in [`Symmetric`].
    pub(super) diagonal: [Numbers; 3],
    /// C, which couples hinge k with hinge k - 1.
    pub(super) before: [Numbers; 4],
}

/// A hinge's row before elimination.
#[derive(Debug, Clone, Copy, Default)]
struct Row {
    own: Symmetric,
    /// Its coupling with the hinge before.
    before: Block,
}

/// What elimination leaves of a hinge.
#[derive(Debug, Clone, Copy, Default)]
struct Eliminated {
    /// Inverse of what is left of its block.
    inverse: Symmetric,
    /// How its unknowns follow from those of the neighbour that is eliminated next, and, transposed, how much of its row that
    /// neighbour takes.
    follow: Block,
}

/// The ring's factors. Places run along the ring from an open hinge on, so that no piece goes past the last one.
#[derive(Debug, Clone)]
pub(super) struct Ring {
    hinges: usize,
    /// Hinge of the first place.
    origin: usize,
    /// Places of the pieces between open hinges.
    pieces: Vec<Range<usize>>,
    rows: Vec<Row>,
    eliminated: Vec<Eliminated>,
    /// Only in a ring without an open hinge.
    cut: Option<Cut>,
    /// How all other unknowns follow from those of the cut, of which each has a column.
    from_cut: Vec<[[f64; 2]; 2]>,
    /// Scratch of a solution.
    unknowns: Vec<[[f64; 2]; 1]>,
}

/// The last hinge of a ring that is closed.
#[derive(Debug, Clone, Copy)]
struct Cut {
    inverse: Symmetric,
    /// Its row in the unknowns of the hinge before and of the first one.
    to_last: Block,
    to_first: Block,
}

/// a b + c, in one rounding where the machine can.
#[inline(always)]
fn fused<S: Simd>(a: f64, b: f64, c: f64) -> f64 {
    if S::IS_SCALAR {
        a * b + c
    } else {
        a.mul_add(b, c)
    }
}

#[inline(always)]
fn transposed(a: Block) -> Block {
    [a[0], a[2], a[1], a[3]]
}

/// a v
#[inline(always)]
fn times<S: Simd>(a: &Symmetric, v: [f64; 2]) -> [f64; 2] {
    [
        fused::<S>(a[0], v[0], a[2] * v[1]),
        fused::<S>(a[2], v[0], a[1] * v[1]),
    ]
}

/// w - a v
#[inline(always)]
fn less<S: Simd>(w: [f64; 2], a: &Block, v: [f64; 2]) -> [f64; 2] {
    [
        fused::<S>(-a[0], v[0], fused::<S>(-a[1], v[1], w[0])),
        fused::<S>(-a[2], v[0], fused::<S>(-a[3], v[1], w[1])),
    ]
}

impl RingBlocks {
    pub(super) fn new(hinges: usize) -> Self {
        let zeros = || crate::vector::padded_zeros(hinges);
        Self {
            diagonal: [zeros(), zeros(), zeros()],
            before: [zeros(), zeros(), zeros(), zeros()],
        }
    }
}

impl Ring {
    /// Room for `hinges`.
    pub(super) fn new(hinges: usize) -> Self {
        Self {
            hinges,
            origin: 0,
            pieces: Vec::with_capacity(hinges),
            rows: vec![Row::default(); hinges],
            eliminated: vec![Eliminated::default(); hinges],
            cut: None,
            from_cut: vec![[[0.0; 2]; 2]; hinges],
            unknowns: vec![[[0.0; 2]]; hinges],
        }
    }

    /// Finds the pieces between hinges that are open; true when none is, and the last hinge is left out.
    fn find_pieces(&mut self, force: &[f64]) -> bool {
        let n = self.hinges;
        let closed = |k: usize| force[k] > 0.0;
        self.pieces.clear();
        let Some(open) = (0..n).find(|&k| !closed(k)) else {
            self.origin = 0;
            self.pieces.push(0..n - 1);
            return true;
        };
        self.origin = open;
        let (before, after) = force[..n].split_at(open);
        let mut first = 1;
        for (place, &force) in after.iter().chain(before).enumerate() {
            if force > 0.0 {
                continue;
            }
            if first < place {
                self.pieces.push(first..place);
            }
            first = place + 1;
        }
        if first < n {
            self.pieces.push(first..n);
        }
        false
    }

    /// Takes the blocks over, place by place.
    #[inline(always)]
    fn take_rows(&mut self, blocks: &RingBlocks) {
        let (n, origin) = (self.hinges, self.origin);
        let (first, last) = self.rows.split_at_mut(n - origin);
        copy_rows(first, blocks, origin);
        copy_rows(last, blocks, 0);
    }
}

/// Rows of the hinges from `from` on.
#[inline(always)]
fn copy_rows(rows: &mut [Row], blocks: &RingBlocks, from: usize) {
    let RingBlocks {
        diagonal: [d0, d1, d2],
        before: [b0, b1, b2, b3],
    } = blocks;
    let count = rows.len();
    let part = |array: &Numbers| from..from + array[from..from + count].len();
    let (d0, d1, d2) = (&d0[part(d0)], &d1[part(d1)], &d2[part(d2)]);
    let (b0, b1, b2, b3) = (&b0[part(b0)], &b1[part(b1)], &b2[part(b2)], &b3[part(b3)]);
    let diagonal = d0.iter().zip(d1).zip(d2);
    let before = b0.iter().zip(b1).zip(b2).zip(b3);
    for ((row, ((d0, d1), d2)), (((b0, b1), b2), b3)) in rows.iter_mut().zip(diagonal).zip(before) {
        *row = Row {
            own: [*d0, *d1, *d2],
            before: [*b0, *b1, *b2, *b3],
        };
    }
}

/// Factorises the ring; false when a block has no inverse.
pub(super) struct FactoriseRing<'a> {
    pub(super) ring: &'a mut Ring,
    pub(super) blocks: &'a RingBlocks,
    /// Forces of the hinges \[N\]; those that bear none are open.
    pub(super) force: &'a [f64],
}

impl WithSimd for FactoriseRing<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> bool {
        let Self {
            ring,
            blocks,
            force,
        } = self;
        let whole = ring.find_pieces(force);
        ring.cut = None;
        if ring.pieces.is_empty() {
            return true;
        }
        ring.take_rows(blocks);
        let mut regular = true;
        for piece in &ring.pieces {
            let rows = &ring.rows[piece.clone()];
            regular &= eliminate::<S>(&mut ring.eliminated[piece.clone()], rows);
        }
        if whole {
            regular &= join_ends::<S>(ring);
        }
        regular
    }
}

/// One round of an elimination.
struct Round {
    eliminated: Eliminated,
    /// The neighbour's block without what it takes.
    left: Symmetric,
    regular: bool,
}

/// Eliminates the hinge with `own` block, whose row has the next one's unknowns with `coupling`; `next`: the next one's block.
#[inline(always)]
fn eliminate_one<S: Simd>(own: Symmetric, c: Block, next: Symmetric) -> Round {
    let [a, d, b] = own;
    let determinant = fused::<S>(a, d, -(b * b));
    let over = 1.0 / determinant;
    // The products with the adjugate do not wait for the division.
    let w = [
        fused::<S>(d, c[0], -(b * c[2])),
        fused::<S>(d, c[1], -(b * c[3])),
        fused::<S>(a, c[2], -(b * c[0])),
        fused::<S>(a, c[3], -(b * c[1])),
    ];
    let taken = [
        fused::<S>(c[0], w[0], c[2] * w[2]),
        fused::<S>(c[1], w[1], c[3] * w[3]),
        fused::<S>(c[0], w[1], c[2] * w[3]),
    ];
    Round {
        eliminated: Eliminated {
            inverse: [d * over, a * over, -b * over],
            follow: [w[0] * over, w[1] * over, w[2] * over, w[3] * over],
        },
        left: [
            fused::<S>(-taken[0], over, next[0]),
            fused::<S>(-taken[1], over, next[1]),
            fused::<S>(-taken[2], over, next[2]),
        ],
        // Also false for what is no number.
        regular: determinant > 0.0 && over > 0.0,
    }
}

/// Eliminates a piece from both ends; what is left in the middle is inverted.
#[inline(always)]
fn eliminate<S: Simd>(eliminated: &mut [Eliminated], rows: &[Row]) -> bool {
    let length = rows.len();
    let eliminated = &mut eliminated[..length];
    let (middle, sweeps) = middle(length);
    let (mut low, mut high) = (0, length - 1);
    let (mut at_low, mut at_high) = (rows[low].own, rows[high].own);
    let mut regular = true;
    for _ in 0..sweeps {
        let next = &rows[low + 1];
        let up = eliminate_one::<S>(at_low, transposed(next.before), next.own);
        let below = if low + 1 == high - 1 {
            up.left
        } else {
            rows[high - 1].own
        };
        let down = eliminate_one::<S>(at_high, rows[high].before, below);
        eliminated[low] = up.eliminated;
        eliminated[high] = down.eliminated;
        regular &= up.regular && down.regular;
        (at_low, at_high) = (up.left, down.left);
        (low, high) = (low + 1, high - 1);
    }
    if middle > sweeps {
        let up = eliminate_one::<S>(at_low, transposed(rows[high].before), at_high);
        eliminated[low] = up.eliminated;
        regular &= up.regular;
        at_high = up.left;
    }
    // After the sweeps the upper one has what both left of the middle.
    let last = eliminate_one::<S>(at_high, [0.0; 4], [0.0; 3]);
    eliminated[middle] = last.eliminated;
    regular && last.regular
}

/// The place that both sweeps of a piece end at, and how many places are swept from either end before one more of the lower
/// ones may be left.
#[inline(always)]
fn middle(length: usize) -> (usize, usize) {
    (length / 2, length - 1 - length / 2)
}

/// Solves a piece in place, for `C` right-hand sides at once.
#[inline(always)]
fn solve_piece<S: Simd, const C: usize>(eliminated: &[Eliminated], unknowns: &mut [[[f64; 2]; C]]) {
    let length = unknowns.len();
    let eliminated = &eliminated[..length];
    let (middle, sweeps) = middle(length);
    for i in 0..sweeps {
        let follow = transposed(eliminated[i].follow);
        unknowns[i + 1] = less_each::<S, C>(unknowns[i + 1], &follow, unknowns[i]);
        // The last one of these takes its part off the middle, which the other sweep has changed already.
        let j = length - 1 - i;
        let follow = transposed(eliminated[j].follow);
        unknowns[j - 1] = less_each::<S, C>(unknowns[j - 1], &follow, unknowns[j]);
    }
    if middle > sweeps {
        let follow = transposed(eliminated[sweeps].follow);
        unknowns[middle] = less_each::<S, C>(unknowns[middle], &follow, unknowns[sweeps]);
    }
    for q in &mut unknowns[middle] {
        *q = times::<S>(&eliminated[middle].inverse, *q);
    }
    for i in 1..=sweeps {
        let (k, j) = (middle - i, middle + i);
        unknowns[k] = follow_from::<S, C>(&eliminated[k], unknowns[k], unknowns[k + 1]);
        unknowns[j] = follow_from::<S, C>(&eliminated[j], unknowns[j], unknowns[j - 1]);
    }
    if middle > sweeps {
        unknowns[0] = follow_from::<S, C>(&eliminated[0], unknowns[0], unknowns[1]);
    }
}

/// w - a v for each right-hand side.
#[inline(always)]
fn less_each<S: Simd, const C: usize>(
    mut w: [[f64; 2]; C],
    a: &Block,
    v: [[f64; 2]; C],
) -> [[f64; 2]; C] {
    for (w, v) in w.iter_mut().zip(v) {
        *w = less::<S>(*w, a, v);
    }
    w
}

/// The unknowns of a hinge from its right-hand sides and its neighbour's unknowns.
#[inline(always)]
fn follow_from<S: Simd, const C: usize>(
    hinge: &Eliminated,
    mut right: [[f64; 2]; C],
    neighbour: [[f64; 2]; C],
) -> [[f64; 2]; C] {
    for right in &mut right {
        *right = times::<S>(&hinge.inverse, *right);
    }
    less_each::<S, C>(right, &hinge.follow, neighbour)
}

/// Solves for the last hinge of a ring that is closed.
#[inline(always)]
fn join_ends<S: Simd>(ring: &mut Ring) -> bool {
    let n = ring.hinges;
    let (cut, last) = (&ring.rows[n - 1], n - 2);
    let (to_last, to_first) = (cut.before, transposed(ring.rows[0].before));
    let mut left = cut.own;
    // Columns of the cut are its rows.
    let unknowns = &mut ring.from_cut[..n - 1];
    unknowns.fill([[0.0; 2]; 2]);
    for (k, row) in [(0, &to_first), (last, &to_last)] {
        for column in 0..2 {
            unknowns[k][column][0] += row[2 * column];
            unknowns[k][column][1] += row[2 * column + 1];
        }
    }
    solve_piece::<S, 2>(&ring.eliminated, unknowns);
    for (entry, (row, column)) in [(0, 0), (1, 1), (0, 1)].into_iter().enumerate() {
        let (low, high) = (unknowns[last][column], unknowns[0][column]);
        left[entry] -= to_last[2 * row] * low[0]
            + to_last[2 * row + 1] * low[1]
            + to_first[2 * row] * high[0]
            + to_first[2 * row + 1] * high[1];
    }
    let round = eliminate_one::<S>(left, [0.0; 4], [0.0; 3]);
    ring.cut = Some(Cut {
        inverse: round.eliminated.inverse,
        to_last,
        to_first,
    });
    round.regular
}

/// Solves the ring in place: normal and tangential parts of all hinges. Those of open hinges become zero.
pub(super) struct SolveRing<'a> {
    pub(super) ring: &'a mut Ring,
    pub(super) unknowns: [&'a mut [f64]; 2],
}

impl WithSimd for SolveRing<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self {
            ring,
            unknowns: [normal, tangential],
        } = self;
        let n = ring.hinges;
        let (normal, tangential) = (&mut normal[..n], &mut tangential[..n]);
        if ring.pieces.is_empty() {
            normal.fill(0.0);
            tangential.fill(0.0);
            return;
        }
        let (first, last) = ring.unknowns.split_at_mut(n - ring.origin);
        take_in(first, &normal[ring.origin..], &tangential[ring.origin..]);
        take_in(last, &normal[..ring.origin], &tangential[..ring.origin]);
        let mut solved = 0;
        for piece in &ring.pieces {
            ring.unknowns[solved..piece.start].fill([[0.0; 2]]);
            let eliminated = &ring.eliminated[piece.clone()];
            solve_piece::<S, 1>(eliminated, &mut ring.unknowns[piece.clone()]);
            solved = piece.end;
        }
        if let Some(cut) = &ring.cut {
            let unknowns = &mut ring.unknowns[..n];
            let right = less::<S>(unknowns[n - 1][0], &cut.to_last, unknowns[n - 2][0]);
            let right = less::<S>(right, &cut.to_first, unknowns[0][0]);
            let q = times::<S>(&cut.inverse, right);
            for ([unknown], [by_n, by_t]) in unknowns[..n - 1].iter_mut().zip(&ring.from_cut) {
                for part in 0..2 {
                    let left = fused::<S>(-by_n[part], q[0], unknown[part]);
                    unknown[part] = fused::<S>(-by_t[part], q[1], left);
                }
            }
            unknowns[n - 1] = [q];
        } else {
            ring.unknowns[solved..].fill([[0.0; 2]]);
        }
        let (first, last) = ring.unknowns.split_at(n - ring.origin);
        let (normal_last, normal_first) = normal.split_at_mut(ring.origin);
        let (tangential_last, tangential_first) = tangential.split_at_mut(ring.origin);
        hand_out(first, normal_first, tangential_first);
        hand_out(last, normal_last, tangential_last);
    }
}

#[inline(always)]
fn take_in(unknowns: &mut [[[f64; 2]; 1]], normal: &[f64], tangential: &[f64]) {
    for (unknown, (n, t)) in unknowns.iter_mut().zip(normal.iter().zip(tangential)) {
        *unknown = [[*n, *t]];
    }
}

#[inline(always)]
fn hand_out(unknowns: &[[[f64; 2]; 1]], normal: &mut [f64], tangential: &mut [f64]) {
    for (unknown, (n, t)) in unknowns.iter().zip(normal.iter_mut().zip(tangential)) {
        [*n, *t] = unknown[0];
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    use super::*;
    use crate::vector::InstructionSet;

    proptest! {
        #[test]
        fn solutions_are_those_of_the_dense_matrix(
            n in 3usize..40,
            open in proptest::collection::vec(0u8..4, 40),
            any_open in any::<bool>(),
            numbers in proptest::collection::vec(-0.3f64..0.3, 800),
        ) {
            let closed = |k: usize| !any_open || open[k] > 0;
            let mut next = numbers.iter().copied().cycle();
            let mut blocks = RingBlocks::new(n);
            for (i, array) in blocks.diagonal.iter_mut().chain(&mut blocks.before).enumerate() {
                let own = if i < 2 { 1.5 } else { 0.0 };
                array[..n].fill_with(|| own + next.next().unwrap());
            }
            let mut dense = DMatrix::<f64>::identity(2 * n, 2 * n);
            for k in (0..n).filter(|&k| closed(k)) {
                let [a, d, b] = [0, 1, 2].map(|i| blocks.diagonal[i][k]);
                dense[(2 * k, 2 * k)] = a;
                dense[(2 * k + 1, 2 * k + 1)] = d;
                dense[(2 * k, 2 * k + 1)] = b;
                dense[(2 * k + 1, 2 * k)] = b;
                let before = (k + n - 1) % n;
                if closed(before) {
                    for (i, entry) in blocks.before.iter().map(|array| array[k]).enumerate() {
                        dense[(2 * k + i / 2, 2 * before + i % 2)] += entry;
                        dense[(2 * before + i % 2, 2 * k + i / 2)] += entry;
                    }
                }
            }
            let right = DVector::from_fn(2 * n, |i, _| if closed(i / 2) { 1.0 + (i % 7) as f64 } else { 0.0 });
            prop_assume!(dense.clone().cholesky().is_some());
            let force: Vec<f64> = (0..n).map(|k| f64::from(u8::from(closed(k)))).collect();
            let mut bits: Option<Vec<f64>> = None;
            for set in InstructionSet::available() {
                let mut ring = Ring::new(n);
                let regular = set.run(FactoriseRing { ring: &mut ring, blocks: &blocks, force: &force });
                prop_assert!(regular);
                let mut normal: Vec<f64> = right.iter().step_by(2).copied().collect();
                let mut tangential: Vec<f64> = right.iter().skip(1).step_by(2).copied().collect();
                set.run(SolveRing { ring: &mut ring, unknowns: [&mut normal, &mut tangential] });
                let found = DVector::from_fn(2 * n, |i, _| if i % 2 == 0 { normal[i / 2] } else { tangential[i / 2] });
                let error = (&dense * &found - &right).amax() / found.amax();
                prop_assert!(error < 1e-12, "{} {}", set.name(), error);
                if set.has_fused_multiply_add() {
                    let same = bits.get_or_insert_with(|| found.as_slice().to_vec());
                    prop_assert_eq!(&same[..], found.as_slice());
                }
            }
        }
    }
}

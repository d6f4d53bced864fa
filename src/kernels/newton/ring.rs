//! The hinges' part of Newton's matrix: a symmetric ring of 2x2 blocks, of which hinges that bear nothing drop out.
//!
//! Row k reads `S_k q_k + C_k q_(k-1) + C_(k+1)^T q_(k+1) = r_k`. Open hinges cut the ring into pieces, and each piece is
//! eliminated from both of its ends towards its middle, two sweeps that do not wait for each other. A ring without an open
//! hinge is cut at the last one, whose two unknowns are solved for at the end.

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

/// What elimination leaves of a hinge.
#[derive(Debug, Clone, Copy, Default)]
struct Eliminated {
    /// Inverse of what is left of its block.
    inverse: Symmetric,
    /// How its unknowns follow from those of the neighbour that is eliminated next, and, transposed, how much of its row that
    /// neighbour takes.
    follow: Block,
}

/// A piece of the ring between two open hinges: its first hinge and how many there are.
#[derive(Debug, Clone, Copy)]
struct Piece {
    first: usize,
    length: usize,
}

/// The ring's factors.
#[derive(Debug, Clone)]
pub(super) struct Ring {
    hinges: usize,
    pieces: Vec<Piece>,
    eliminated: Vec<Eliminated>,
    /// Only in a ring without an open hinge.
    cut: Option<Cut>,
    /// How all other unknowns follow from those of the cut: two columns, each normal and tangential.
    from_cut: [[Vec<f64>; 2]; 2],
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

    /// S of hinge `k`.
    #[inline(always)]
    fn of(&self, k: usize) -> Symmetric {
        let [first, last, beside] = &self.diagonal;
        [first[k], last[k], beside[k]]
    }

    /// Row k in the unknowns of hinge k - 1.
    #[inline(always)]
    fn before(&self, k: usize) -> Block {
        let [a, b, c, d] = &self.before;
        [a[k], b[k], c[k], d[k]]
    }
}

impl Ring {
    /// Room for `hinges`.
    pub(super) fn new(hinges: usize) -> Self {
        let column = || [vec![0.0; hinges], vec![0.0; hinges]];
        Self {
            hinges,
            pieces: Vec::with_capacity(hinges),
            eliminated: vec![Eliminated::default(); hinges],
            cut: None,
            from_cut: [column(), column()],
        }
    }

    /// Finds the pieces between hinges that are open; true when none is, and the last hinge is left out.
    fn find_pieces(&mut self, closed: impl Fn(usize) -> bool) -> bool {
        let n = self.hinges;
        self.pieces.clear();
        let Some(open) = (0..n).find(|&k| !closed(k)) else {
            self.pieces.push(Piece {
                first: 0,
                length: n - 1,
            });
            return true;
        };
        let mut length = 0;
        for step in 1..=n {
            let k = if open + step < n {
                open + step
            } else {
                open + step - n
            };
            if closed(k) {
                length += 1;
            } else if length > 0 {
                let first = (k + n - length) % n;
                self.pieces.push(Piece { first, length });
                length = 0;
            }
        }
        false
    }

    /// Zeros for the hinges that are in no piece.
    #[inline(always)]
    fn open_others(&self, normal: &mut [f64], tangential: &mut [f64]) {
        let n = self.hinges;
        for (i, piece) in self.pieces.iter().enumerate() {
            let next = self.pieces[if i + 1 < self.pieces.len() { i + 1 } else { 0 }];
            let mut k = (piece.first + piece.length) % n;
            while k != next.first {
                (normal[k], tangential[k]) = (0.0, 0.0);
                k = if k + 1 < n { k + 1 } else { 0 };
            }
        }
        if self.pieces.is_empty() {
            normal.fill(0.0);
            tangential.fill(0.0);
        }
    }
}

/// Factorises the ring; false when a block has no inverse.
pub(super) struct FactoriseRing<'a, Closed> {
    pub(super) ring: &'a mut Ring,
    pub(super) blocks: &'a RingBlocks,
    /// Whether a hinge bears a force.
    pub(super) closed: Closed,
}

impl<Closed: Fn(usize) -> bool> WithSimd for FactoriseRing<'_, Closed> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> bool {
        let Self {
            ring,
            blocks,
            closed,
        } = self;
        let n = ring.hinges;
        let whole = ring.find_pieces(&closed);
        ring.cut = None;
        let mut regular = true;
        for piece in 0..ring.pieces.len() {
            regular &= eliminate::<S>(&mut ring.eliminated, blocks, ring.pieces[piece], n);
        }
        if whole {
            regular &= join_ends::<S>(ring, blocks);
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
fn eliminate<S: Simd>(
    eliminated: &mut [Eliminated],
    blocks: &RingBlocks,
    piece: Piece,
    n: usize,
) -> bool {
    let place = |offset: usize| {
        let k = piece.first + offset;
        if k < n { k } else { k - n }
    };
    let (middle, sweeps) = piece.middle();
    let (mut low, mut high) = (0, piece.length - 1);
    let (mut at_low, mut at_high) = (blocks.of(place(low)), blocks.of(place(high)));
    let mut regular = true;
    for _ in 0..sweeps {
        let (k, next) = (place(low), place(low + 1));
        let coupling = transposed(blocks.before(next));
        let up = eliminate_one::<S>(at_low, coupling, blocks.of(next));
        let (j, before) = (place(high), place(high - 1));
        let below = if low + 1 == high - 1 {
            up.left
        } else {
            blocks.of(before)
        };
        let down = eliminate_one::<S>(at_high, blocks.before(j), below);
        eliminated[k] = up.eliminated;
        eliminated[j] = down.eliminated;
        regular &= up.regular && down.regular;
        (at_low, at_high) = (up.left, down.left);
        (low, high) = (low + 1, high - 1);
    }
    if middle > sweeps {
        let (k, next) = (place(low), place(high));
        let up = eliminate_one::<S>(at_low, transposed(blocks.before(next)), at_high);
        eliminated[k] = up.eliminated;
        regular &= up.regular;
        at_high = up.left;
    }
    // After the sweeps the upper one has what both left of the middle.
    let last = eliminate_one::<S>(at_high, [0.0; 4], [0.0; 3]);
    eliminated[place(middle)] = last.eliminated;
    regular && last.regular
}

impl Piece {
    /// The hinge that both sweeps end at, counted from the first one, and how many hinges are swept from either end before one
    /// more of the lower ones may be left.
    #[inline(always)]
    fn middle(self) -> (usize, usize) {
        (self.length / 2, self.length - 1 - self.length / 2)
    }
}

/// Solves a piece in place.
#[inline(always)]
fn solve_piece<S: Simd>(
    eliminated: &[Eliminated],
    piece: Piece,
    n: usize,
    [normal, tangential]: [&mut [f64]; 2],
) {
    let place = |offset: usize| {
        let k = piece.first + offset;
        if k < n { k } else { k - n }
    };
    let (middle, sweeps) = piece.middle();
    let length = piece.length;
    let (first, last) = (place(0), place(length - 1));
    let mut up = [normal[first], tangential[first]];
    let mut down = [normal[last], tangential[last]];
    for i in 0..sweeps {
        let (k, next) = (place(i), place(i + 1));
        let own = [normal[next], tangential[next]];
        up = less::<S>(own, &transposed(eliminated[k].follow), up);
        (normal[next], tangential[next]) = (up[0], up[1]);
        // The last one of these takes its part off the middle, which the other sweep has changed already.
        let (j, before) = (place(length - 1 - i), place(length - 2 - i));
        let own = [normal[before], tangential[before]];
        down = less::<S>(own, &transposed(eliminated[j].follow), down);
        (normal[before], tangential[before]) = (down[0], down[1]);
    }
    if middle > sweeps {
        let (k, next) = (place(sweeps), place(sweeps + 1));
        let own = [normal[next], tangential[next]];
        up = less::<S>(own, &transposed(eliminated[k].follow), up);
        (normal[next], tangential[next]) = (up[0], up[1]);
    }
    let k = place(middle);
    let q = times::<S>(&eliminated[k].inverse, [normal[k], tangential[k]]);
    (normal[k], tangential[k]) = (q[0], q[1]);
    let (mut up, mut down) = (q, q);
    for i in 1..=middle {
        let k = place(middle - i);
        let own = times::<S>(&eliminated[k].inverse, [normal[k], tangential[k]]);
        up = less::<S>(own, &eliminated[k].follow, up);
        (normal[k], tangential[k]) = (up[0], up[1]);
        if middle + i < length {
            let j = place(middle + i);
            let own = times::<S>(&eliminated[j].inverse, [normal[j], tangential[j]]);
            down = less::<S>(own, &eliminated[j].follow, down);
            (normal[j], tangential[j]) = (down[0], down[1]);
        }
    }
}

/// Solves for the last hinge of a ring that is closed.
#[inline(always)]
fn join_ends<S: Simd>(ring: &mut Ring, blocks: &RingBlocks) -> bool {
    let n = ring.hinges;
    let (cut, first, last) = (n - 1, 0, n - 2);
    let (to_last, to_first) = (blocks.before(cut), transposed(blocks.before(first)));
    let mut left = blocks.of(cut);
    for (column, [normal, tangential]) in ring.from_cut.iter_mut().enumerate() {
        normal.fill(0.0);
        tangential.fill(0.0);
        // Columns of the cut are its rows.
        for (k, row) in [(first, &to_first), (last, &to_last)] {
            normal[k] += row[2 * column];
            tangential[k] += row[2 * column + 1];
        }
        solve_piece::<S>(
            &ring.eliminated,
            ring.pieces[0],
            n,
            [normal.as_mut_slice(), tangential.as_mut_slice()],
        );
        for row in 0..=column {
            let (low, high) = (&to_last[2 * row..], &to_first[2 * row..]);
            let entry = if row == column { row } else { 2 };
            left[entry] -= low[0] * normal[last]
                + low[1] * tangential[last]
                + high[0] * normal[first]
                + high[1] * tangential[first];
        }
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
    pub(super) ring: &'a Ring,
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
        for &piece in &ring.pieces {
            solve_piece::<S>(&ring.eliminated, piece, n, [&mut *normal, &mut *tangential]);
        }
        let Some(cut) = &ring.cut else {
            ring.open_others(normal, tangential);
            return;
        };
        let right = [normal[n - 1], tangential[n - 1]];
        let right = less::<S>(right, &cut.to_last, [normal[n - 2], tangential[n - 2]]);
        let right = less::<S>(right, &cut.to_first, [normal[0], tangential[0]]);
        let q = times::<S>(&cut.inverse, right);
        for k in 0..n - 1 {
            for (column, q) in ring.from_cut.iter().zip(q) {
                normal[k] = fused::<S>(-column[0][k], q, normal[k]);
                tangential[k] = fused::<S>(-column[1][k], q, tangential[k]);
            }
        }
        (normal[n - 1], tangential[n - 1]) = (q[0], q[1]);
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
                let [a, d, b] = blocks.of(k);
                dense[(2 * k, 2 * k)] = a;
                dense[(2 * k + 1, 2 * k + 1)] = d;
                dense[(2 * k, 2 * k + 1)] = b;
                dense[(2 * k + 1, 2 * k)] = b;
                let before = (k + n - 1) % n;
                if closed(before) {
                    for (i, entry) in blocks.before(k).into_iter().enumerate() {
                        dense[(2 * k + i / 2, 2 * before + i % 2)] += entry;
                        dense[(2 * before + i % 2, 2 * k + i / 2)] += entry;
                    }
                }
            }
            let right = DVector::from_fn(2 * n, |i, _| if closed(i / 2) { 1.0 + (i % 7) as f64 } else { 0.0 });
            prop_assume!(dense.clone().cholesky().is_some());
            let mut bits: Option<Vec<f64>> = None;
            for set in InstructionSet::available() {
                let mut ring = Ring::new(n);
                let regular = set.run(FactoriseRing { ring: &mut ring, blocks: &blocks, closed });
                prop_assert!(regular);
                let mut normal: Vec<f64> = right.iter().step_by(2).copied().collect();
                let mut tangential: Vec<f64> = right.iter().skip(1).step_by(2).copied().collect();
                set.run(SolveRing { ring: &ring, unknowns: [&mut normal, &mut tangential] });
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

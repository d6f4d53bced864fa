//! The hinges' part of Newton's matrix: a ring of 2x2 blocks, of which hinges that bear nothing drop out.
//!
//! Row k reads `B_k q_k + L_k q_(k-1) + U_k q_(k+1) = r_k`. Open hinges cut the ring into pieces, and each piece is eliminated
//! from both of its ends towards its middle, two sweeps that do not wait for each other. A ring without an open hinge is cut
//! at the last one, whose two unknowns are solved for at the end.

use pulp::{Simd, WithSimd};

use crate::vector::Numbers;

/// Rows, then columns, of a 2x2 block.
type Block = [f64; 4];

/// Blocks of links, from which those of the ring are added up: link i is behind hinge i and before hinge i - 1.
pub(super) struct LinkBlocks<'a> {
    /// Front end on front end: part of B of hinge i.
    pub(super) front: &'a [Numbers; 4],
    /// Rear on rear: part of B of hinge i - 1.
    pub(super) rear: &'a [Numbers; 4],
    /// Front rows, rear columns: L of hinge i.
    pub(super) front_rear: &'a [Numbers; 4],
    /// Rear rows, front columns: U of hinge i - 1.
    pub(super) rear_front: &'a [Numbers; 4],
}

/// What elimination leaves of a hinge.
#[derive(Debug, Clone, Copy, Default)]
struct Eliminated {
    /// Inverse of the block on the diagonal.
    inverse: Block,
    /// How much of its row the neighbour that is eliminated next takes off.
    carry: Block,
    /// How its unknowns follow from that neighbour's.
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
    inverse: Block,
    lower: Block,
    upper: Block,
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
fn product<S: Simd>(a: &Block, b: &Block) -> Block {
    [
        fused::<S>(a[0], b[0], a[1] * b[2]),
        fused::<S>(a[0], b[1], a[1] * b[3]),
        fused::<S>(a[2], b[0], a[3] * b[2]),
        fused::<S>(a[2], b[1], a[3] * b[3]),
    ]
}

/// a v
#[inline(always)]
fn times<S: Simd>(a: &Block, v: [f64; 2]) -> [f64; 2] {
    [
        fused::<S>(a[0], v[0], a[1] * v[1]),
        fused::<S>(a[2], v[0], a[3] * v[1]),
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

#[inline(always)]
fn block(of: &[Numbers; 4], i: usize) -> Block {
    [of[0][i], of[1][i], of[2][i], of[3][i]]
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
}

/// Factorises the ring; false when a block has no inverse.
pub(super) struct FactoriseRing<'a, Closed> {
    pub(super) ring: &'a mut Ring,
    pub(super) blocks: LinkBlocks<'a>,
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
            regular &= eliminate::<S>(&mut ring.eliminated, &blocks, ring.pieces[piece], n);
        }
        if whole {
            regular &= join_ends::<S>(ring, &blocks);
        }
        regular
    }
}

/// One round of an elimination: the inverse of what is left of a block, and what its neighbour takes of it.
struct Round {
    eliminated: Eliminated,
    /// The neighbour's block on the diagonal without it.
    left: Block,
    regular: bool,
}

/// Eliminates the hinge with `diagonal`, whose unknowns the next one's row has with `lower`, and which has the next one's
/// with `upper`; `next`: the next one's block on the diagonal.
#[inline(always)]
fn eliminate_one<S: Simd>(diagonal: &Block, lower: &Block, upper: &Block, next: &Block) -> Round {
    let determinant = fused::<S>(diagonal[0], diagonal[3], -(diagonal[1] * diagonal[2]));
    let over = 1.0 / determinant;
    // The products with the adjugate do not wait for the division.
    let adjugate = [diagonal[3], -diagonal[1], -diagonal[2], diagonal[0]];
    let carry = product::<S>(lower, &adjugate);
    let taken = product::<S>(&carry, upper);
    let follow = product::<S>(&adjugate, upper);
    let scaled = |block: Block| block.map(|entry| entry * over);
    Round {
        eliminated: Eliminated {
            inverse: scaled(adjugate),
            carry: scaled(carry),
            follow: scaled(follow),
        },
        left: std::array::from_fn(|i| fused::<S>(-taken[i], over, next[i])),
        regular: determinant != 0.0 && over.is_finite() && determinant.is_finite(),
    }
}

#[inline(always)]
fn on_diagonal(blocks: &LinkBlocks, k: usize, n: usize) -> Block {
    let next = if k + 1 < n { k + 1 } else { 0 };
    let (front, rear) = (block(blocks.front, k), block(blocks.rear, next));
    [
        1.0 + front[0] + rear[0],
        front[1] + rear[1],
        front[2] + rear[2],
        1.0 + front[3] + rear[3],
    ]
}

/// Row k, unknowns of hinge k + 1.
#[inline(always)]
fn upper(blocks: &LinkBlocks, k: usize, n: usize) -> Block {
    block(blocks.rear_front, if k + 1 < n { k + 1 } else { 0 })
}

/// Row k, unknowns of hinge k - 1.
#[inline(always)]
fn lower(blocks: &LinkBlocks, k: usize) -> Block {
    block(blocks.front_rear, k)
}

/// Eliminates a piece from both ends; what is left in the middle is inverted.
#[inline(always)]
fn eliminate<S: Simd>(
    eliminated: &mut [Eliminated],
    blocks: &LinkBlocks,
    piece: Piece,
    n: usize,
) -> bool {
    let place = |offset: usize| {
        let k = piece.first + offset;
        if k < n { k } else { k - n }
    };
    let last = piece.length - 1;
    let (mut low, mut high) = (0, last);
    let mut at_low = on_diagonal(blocks, place(low), n);
    let mut at_high = on_diagonal(blocks, place(high), n);
    let mut regular = true;
    while high - low >= 2 {
        let (k, next) = (place(low), place(low + 1));
        let up = eliminate_one::<S>(
            &at_low,
            &lower(blocks, next),
            &upper(blocks, k, n),
            &on_diagonal(blocks, next, n),
        );
        let middle = low + 1 == high - 1;
        let (j, before) = (place(high), place(high - 1));
        let below = if middle {
            up.left
        } else {
            on_diagonal(blocks, before, n)
        };
        let down = eliminate_one::<S>(
            &at_high,
            &upper(blocks, before, n),
            &lower(blocks, j),
            &below,
        );
        eliminated[k] = up.eliminated;
        eliminated[j] = down.eliminated;
        regular &= up.regular && down.regular;
        at_low = up.left;
        at_high = down.left;
        (low, high) = (low + 1, high - 1);
        if middle {
            at_low = down.left;
        }
    }
    if high == low + 1 {
        let (k, next) = (place(low), place(high));
        let up = eliminate_one::<S>(
            &at_low,
            &lower(blocks, next),
            &upper(blocks, k, n),
            &at_high,
        );
        eliminated[k] = up.eliminated;
        regular &= up.regular;
        at_low = up.left;
        low = high;
    }
    let nothing = [0.0; 4];
    let middle = eliminate_one::<S>(&at_low, &nothing, &nothing, &nothing);
    eliminated[place(low)] = middle.eliminated;
    regular && middle.regular
}

/// Number of hinges of a piece that the sweep from its first end eliminates; the middle one comes next.
#[inline(always)]
fn before_middle(length: usize) -> usize {
    length / 2
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
    let (length, middle) = (piece.length, before_middle(piece.length));
    let at = |normal: &[f64], tangential: &[f64], k: usize| [normal[k], tangential[k]];
    let mut up = at(normal, tangential, place(0));
    let mut down = at(normal, tangential, place(length - 1));
    let sweeps = length - 1 - middle;
    for i in 0..sweeps {
        let (k, next) = (place(i), place(i + 1));
        up = less::<S>(at(normal, tangential, next), &eliminated[k].carry, up);
        (normal[next], tangential[next]) = (up[0], up[1]);
        // The last one of these takes its part off the middle, which the other sweep has changed already.
        let (j, before) = (place(length - 1 - i), place(length - 2 - i));
        down = less::<S>(at(normal, tangential, before), &eliminated[j].carry, down);
        (normal[before], tangential[before]) = (down[0], down[1]);
    }
    if middle > sweeps {
        let (k, next) = (place(sweeps), place(sweeps + 1));
        let up = less::<S>(
            at(normal, tangential, next),
            &eliminated[k].carry,
            at(normal, tangential, k),
        );
        (normal[next], tangential[next]) = (up[0], up[1]);
    }
    let k = place(middle);
    let q = times::<S>(&eliminated[k].inverse, at(normal, tangential, k));
    (normal[k], tangential[k]) = (q[0], q[1]);
    let (mut up, mut down) = (q, q);
    for i in 1..=middle {
        let k = place(middle - i);
        let e = &eliminated[k];
        let own = times::<S>(&e.inverse, at(normal, tangential, k));
        up = less::<S>(own, &e.follow, up);
        (normal[k], tangential[k]) = (up[0], up[1]);
        if middle + i < length {
            let j = place(middle + i);
            let e = &eliminated[j];
            let own = times::<S>(&e.inverse, at(normal, tangential, j));
            down = less::<S>(own, &e.follow, down);
            (normal[j], tangential[j]) = (down[0], down[1]);
        }
    }
}

/// Solves for the last hinge of a ring that is closed.
#[inline(always)]
fn join_ends<S: Simd>(ring: &mut Ring, blocks: &LinkBlocks) -> bool {
    let n = ring.hinges;
    let (cut, first, last) = (n - 1, 0, n - 2);
    let (to_first, to_last) = (lower(blocks, first), upper(blocks, last, n));
    let (from_last, from_first) = (lower(blocks, cut), upper(blocks, cut, n));
    let mut left = on_diagonal(blocks, cut, n);
    for (column, [normal, tangential]) in ring.from_cut.iter_mut().enumerate() {
        normal.fill(0.0);
        tangential.fill(0.0);
        for (k, block) in [(first, &to_first), (last, &to_last)] {
            normal[k] += block[column];
            tangential[k] += block[2 + column];
        }
        solve_piece::<S>(
            &ring.eliminated,
            ring.pieces[0],
            n,
            [normal.as_mut_slice(), tangential.as_mut_slice()],
        );
        for row in 0..2 {
            let (low, high) = (&from_last[2 * row..], &from_first[2 * row..]);
            left[2 * row + column] -= low[0] * normal[last]
                + low[1] * tangential[last]
                + high[0] * normal[first]
                + high[1] * tangential[first];
        }
    }
    let nothing = [0.0; 4];
    let round = eliminate_one::<S>(&left, &nothing, &nothing, &nothing);
    ring.cut = Some(Cut {
        inverse: round.eliminated.inverse,
        lower: from_last,
        upper: from_first,
    });
    round.regular
}

/// Solves the ring in place: normal and tangential parts of all hinges. Those of open hinges stay as they are.
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
        let Some(cut) = &ring.cut else { return };
        let at = |k: usize| [normal[k], tangential[k]];
        let right = less::<S>(at(n - 1), &cut.lower, at(n - 2));
        let q = times::<S>(&cut.inverse, less::<S>(right, &cut.upper, at(0)));
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
    use crate::vector::{InstructionSet, padded_zeros};

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
            let mut blocks = || [0; 4].map(|_| {
                let mut array = padded_zeros(n);
                array[..n].fill_with(|| next.next().unwrap());
                array
            });
            let (mut front, mut rear, mut front_rear, mut rear_front) =
                (blocks(), blocks(), blocks(), blocks());
            // Rows of open hinges are those of no force.
            for k in (0..n).filter(|&k| !closed(k)) {
                for i in 0..4 {
                    front[i][k] = 0.0;
                    front_rear[i][k] = 0.0;
                    rear[i][(k + 1) % n] = 0.0;
                    rear_front[i][(k + 1) % n] = 0.0;
                }
            }
            let mut dense = DMatrix::<f64>::identity(2 * n, 2 * n);
            for k in 0..n {
                let (after, before) = ((k + 1) % n, (k + n - 1) % n);
                for i in 0..4 {
                    let (row, column) = (i / 2, i % 2);
                    dense[(2 * k + row, 2 * k + column)] += front[i][k] + rear[i][after];
                    dense[(2 * k + row, 2 * before + column)] += front_rear[i][k];
                    dense[(2 * k + row, 2 * after + column)] += rear_front[i][after];
                }
            }
            let right = DVector::from_fn(2 * n, |i, _| if closed(i / 2) { 1.0 + (i % 7) as f64 } else { 0.0 });
            let Some(expected) = dense.clone().lu().solve(&right) else { return Ok(()) };
            prop_assume!(expected.amax() < 1e3);
            let mut bits: Option<Vec<f64>> = None;
            for set in InstructionSet::available() {
                let mut ring = Ring::new(n);
                let blocks = LinkBlocks { front: &front, rear: &rear, front_rear: &front_rear, rear_front: &rear_front };
                prop_assume!(set.run(FactoriseRing { ring: &mut ring, blocks, closed }));
                let mut normal: Vec<f64> = right.iter().step_by(2).copied().collect();
                let mut tangential: Vec<f64> = right.iter().skip(1).step_by(2).copied().collect();
                set.run(SolveRing { ring: &ring, unknowns: [&mut normal, &mut tangential] });
                let found = DVector::from_fn(2 * n, |i, _| if i % 2 == 0 { normal[i / 2] } else { tangential[i / 2] });
                let error = (&dense * &found - &right).amax();
                prop_assert!(error < 1e-6, "{} {}", set.name(), error);
                if set.has_fused_multiply_add() {
                    let same = bits.get_or_insert_with(|| found.as_slice().to_vec());
                    prop_assert_eq!(&same[..], found.as_slice());
                }
            }
        }
    }
}

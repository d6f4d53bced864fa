//! Blocks of up to three unknowns: products, and inverses by cofactors or by elimination.

use pulp::Simd;

use super::{Part, Tile, ZERO};

/// Determinant over the product of the diagonal entries of a block below which it is eliminated with pivoting, not by cofactors.
///
/// Ten digits remain at this ratio. Doubled: a few more blocks are eliminated, each at ten times the cost.
const CANCELLED: f64 = 1e-6;

/// Return `from` less the product A x with the K first columns of A.
#[inline(always)]
pub(super) fn less_image<S: Simd, const K: usize>(
    simd: S,
    from: &Part,
    a: &Tile,
    x: &Part,
) -> Part {
    let mut found = *from;
    for (i, sum) in S::as_mut_simd_f64s(&mut found).0.iter_mut().enumerate() {
        for k in 0..K {
            let (column, factor) = (S::as_simd_f64s(&a[k]).0[i], simd.splat_f64s(x[k]));
            *sum = simd.negate_mul_add_e_f64s(column, factor, *sum);
        }
    }
    found
}

/// Subtract the product A B with the K first columns of A; only the first `columns` of B, two or three, are not zero.
#[inline(always)]
pub(super) fn subtract_product<S: Simd, const K: usize>(
    simd: S,
    from: &mut Tile,
    a: &Tile,
    b: &Tile,
    columns: usize,
) {
    from[0] = less_image::<S, K>(simd, &from[0], a, &b[0]);
    from[1] = less_image::<S, K>(simd, &from[1], a, &b[1]);
    if columns == 3 {
        from[2] = less_image::<S, K>(simd, &from[2], a, &b[2]);
    }
}

/// Return -A.
#[inline(always)]
#[allow(clippy::needless_range_loop)]
pub(super) fn negative(a: &Tile) -> Tile {
    let mut found = ZERO;
    for k in 0..3 {
        for r in 0..4 {
            found[k][r] = -a[k][r];
        }
    }
    found
}

/// Return the product A B of A and minus B, both with K columns.
#[inline(always)]
pub(super) fn product<S: Simd, const K: usize>(simd: S, a: &Tile, minus_b: &Tile) -> Tile {
    let mut found = ZERO;
    subtract_product::<S, K>(simd, &mut found, a, minus_b, K);
    found
}

/// Return the inverse of a block of K unknowns, two or three, whose other unknowns are decoupled; `None` if it is singular or not finite.
#[inline(always)]
pub(super) fn inverse<const K: usize>(block: &Tile) -> Option<Tile> {
    let [[a, b, ..], [c, d, ..], _] = *block;
    let mut found = *block;
    if K == 2 {
        let part = 1.0 / (a * d - b * c);
        found[0] = [part * d, -part * b, 0.0, 0.0];
        found[1] = [-part * c, part * a, 0.0, 0.0];
    } else if let Some(inverse) = inverse_by_cofactors(block) {
        found = inverse;
    } else {
        found = inverse_by_elimination(block);
    }
    // Infinities and NaN give NaN in the product.
    let mut zero = 0.0;
    for column in &found {
        zero += 0.0 * column[0] + 0.0 * column[1] + 0.0 * column[2];
    }
    (zero == 0.0).then_some(found)
}

/// Return the inverse of a full block by cofactors; `None` if the determinant loses digits by cancellation.
#[inline(always)]
fn inverse_by_cofactors(block: &Tile) -> Option<Tile> {
    let [[a, d, g, _], [b, e, h, _], [c, f, i, _]] = *block;
    let (x, y, z) = (e * i - f * h, f * g - d * i, d * h - e * g);
    let determinant = a * x + b * y + c * z;
    if determinant.abs() <= CANCELLED * (a * e * i).abs() {
        return None;
    }
    let part = 1.0 / determinant;
    let (x, y, z) = (part * x, part * y, part * z);
    let (u, v, w) = (c * h - b * i, a * i - c * g, b * g - a * h);
    let (r, s, t) = (b * f - c * e, c * d - a * f, a * e - b * d);
    Some([
        [x, y, z, 0.0],
        [part * u, part * v, part * w, 0.0],
        [part * r, part * s, part * t, 0.0],
    ])
}

/// Return the inverse of a full block by Gauss-Jordan elimination with partial pivoting; not finite if the block is singular.
///
/// Cofactors would lose the compliances of constraints that depend on each other.
#[cold]
fn inverse_by_elimination(block: &Tile) -> Tile {
    let mut m = *block;
    let mut swaps = [0; 3];
    for k in 0..3 {
        // m[c][r] is the entry of row r and column c.
        let mut pivot = k;
        for r in k + 1..3 {
            if m[k][r].abs() > m[k][pivot].abs() {
                pivot = r;
            }
        }
        swaps[k] = pivot;
        if pivot != k {
            for column in &mut m {
                column.swap(k, pivot);
            }
        }
        let part = 1.0 / m[k][k];
        let mut down = m[k];
        down[k] = 0.0;
        m[k] = [0.0; 4];
        m[k][k] = 1.0;
        for column in &mut m {
            let scaled = part * column[k];
            column[k] = 0.0;
            for r in 0..4 {
                column[r] -= scaled * down[r];
            }
            column[k] = scaled;
        }
    }
    // Exchanged rows of the matrix are exchanged columns of the inverse.
    for (k, &pivot) in swaps.iter().enumerate().rev() {
        m.swap(k, pivot);
    }
    m
}

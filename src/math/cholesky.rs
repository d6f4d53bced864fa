//! Solution of small symmetric positive definite systems by Cholesky factors.

/// Smallest ratio of a pivot to its diagonal entry that counts as positive; a smaller remainder is rounding.
const DEFINITE: f64 = 1e-13;

/// Solve A x = b for a symmetric positive definite A of `n` rows, in place; return false for any other A.
pub(crate) fn solve_positive(a: &mut [f64], n: usize, x: &mut [f64]) -> bool {
    // Factor A = L Lᵀ, column by column.
    for k in 0..n {
        let before = a[k * n + k];
        let pivot = before - dot(&a[k * n..k * n + k], &a[k * n..k * n + k]);
        if pivot.is_nan() || pivot <= DEFINITE * before.abs().max(f64::MIN_POSITIVE) {
            return false;
        }
        let root = pivot.sqrt();
        a[k * n + k] = root;
        for i in k + 1..n {
            let sum = a[i * n + k] - dot(&a[i * n..i * n + k], &a[k * n..k * n + k]);
            a[i * n + k] = sum / root;
        }
    }
    // Forward substitution, L y = b.
    for i in 0..n {
        x[i] = (x[i] - dot(&a[i * n..i * n + i], &x[..i])) / a[i * n + i];
    }
    // Back substitution, Lᵀ x = y.
    for i in (0..n).rev() {
        x[i] /= a[i * n + i];
        let known = x[i];
        for j in 0..i {
            x[j] -= a[i * n + j] * known;
        }
    }
    true
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

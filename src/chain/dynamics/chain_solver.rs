//! Linear systems in the chain's own pattern: 3x3 blocks of links, each coupled to its two neighbours around a ring, bordered
//! by the coordinates of sprockets. Solved by elimination along the ring: the work grows with the links, nothing is allocated.

use nalgebra::{Matrix3, RowVector3, Vector3};

/// The matrix, and its factors once [`Self::factorise`] has run.
#[derive(Debug, Clone)]
pub(super) struct ChainMatrix {
    /// Block of each link with itself.
    pub(super) diagonal: Vec<Matrix3<f64>>,
    /// Block (k, k + 1) of each hinge; the last one is block (n - 1, 0).
    pub(super) upper: Vec<Matrix3<f64>>,
    /// Block (k + 1, k) of each hinge; the last one is block (0, n - 1).
    pub(super) lower: Vec<Matrix3<f64>>,
    /// Columns of the border: entry `link * border + j`.
    pub(super) column: Vec<Vector3<f64>>,
    /// Rows of the border, likewise.
    pub(super) row: Vec<RowVector3<f64>>,
    /// Border with itself, row after row.
    pub(super) corner: Vec<f64>,
    /// Number of coordinates that are not those of links.
    border: usize,
    factors: Factors,
}

/// What elimination leaves. The last link joins the border: without it the ring is a band.
#[derive(Debug, Clone)]
struct Factors {
    /// Size of border and last link.
    size: usize,
    inverse: Vec<Matrix3<f64>>,
    /// inverse * upper
    next: Vec<Matrix3<f64>>,
    /// lower * inverse of the link before
    before: Vec<Matrix3<f64>>,
    /// inverse * columns: entry `link * size + j`
    column: Vec<Vector3<f64>>,
    row: Vec<RowVector3<f64>>,
    corner: Vec<f64>,
    pivots: Vec<usize>,
    /// Scratch of a solution.
    border: Vec<f64>,
}

impl ChainMatrix {
    pub(super) fn new(links: usize, border: usize) -> Self {
        let size = border + 3;
        let blocks = || vec![Matrix3::zeros(); links];
        Self {
            diagonal: blocks(),
            upper: blocks(),
            lower: blocks(),
            column: vec![Vector3::zeros(); links * border],
            row: vec![RowVector3::zeros(); links * border],
            corner: vec![0.0; border * border],
            border,
            factors: Factors {
                size,
                inverse: blocks(),
                next: blocks(),
                before: blocks(),
                column: vec![Vector3::zeros(); links * size],
                row: vec![RowVector3::zeros(); links * size],
                corner: vec![0.0; size * size],
                pivots: vec![0; size],
                border: vec![0.0; size],
            },
        }
    }

    pub(super) fn border(&self) -> usize {
        self.border
    }

    /// Factorises; false when a block has no inverse.
    pub(super) fn factorise(&mut self) -> bool {
        let (n, border) = (self.diagonal.len(), self.border);
        let last = n - 1;
        let Factors {
            size,
            inverse,
            next,
            before,
            column,
            row,
            corner,
            pivots,
            ..
        } = &mut self.factors;
        let size = *size;
        // Border: the last link's three coordinates, then the others.
        for i in 0..last {
            for j in 0..border {
                column[i * size + 3 + j] = self.column[i * border + j];
                row[i * size + 3 + j] = self.row[i * border + j];
            }
            for j in 0..3 {
                column[i * size + j] = Vector3::zeros();
                row[i * size + j] = RowVector3::zeros();
            }
        }
        for j in 0..3 {
            column[j] += self.lower[last].column(j);
            row[j] += self.upper[last].row(j);
            column[(last - 1) * size + j] += self.upper[last - 1].column(j);
            row[(last - 1) * size + j] += self.lower[last - 1].row(j);
        }
        for i in 0..size {
            for j in 0..size {
                corner[i * size + j] = match (i.checked_sub(3), j.checked_sub(3)) {
                    (None, None) => self.diagonal[last][(i, j)],
                    (None, Some(j)) => self.column[last * border + j][i],
                    (Some(i), None) => self.row[last * border + i][j],
                    (Some(i), Some(j)) => self.corner[i * border + j],
                };
            }
        }
        for i in 0..last {
            let mut block = self.diagonal[i];
            if i > 0 {
                before[i] = self.lower[i - 1] * inverse[i - 1];
                block -= before[i] * self.upper[i - 1];
                for j in 0..size {
                    // Columns of the link before already hold inverse * column.
                    let from_before = self.lower[i - 1] * column[(i - 1) * size + j];
                    column[i * size + j] -= from_before;
                    let from_before = row[(i - 1) * size + j] * next[i - 1];
                    row[i * size + j] -= from_before;
                }
            }
            let Some(inverted) = block.try_inverse() else {
                return false;
            };
            inverse[i] = inverted;
            next[i] = inverted * self.upper[i];
            for j in 0..size {
                column[i * size + j] = inverted * column[i * size + j];
            }
            for r in 0..size {
                for j in 0..size {
                    corner[r * size + j] -= (row[i * size + r] * column[i * size + j])[0];
                }
            }
        }
        eliminate(corner, pivots, size)
    }

    /// Solves for `right`, which holds all x, all y, all θ of links, then the border; overwritten by the solution.
    pub(super) fn solve(&mut self, right: &mut [f64]) {
        let n = self.diagonal.len();
        let last = n - 1;
        let Factors {
            size,
            inverse,
            next,
            before,
            column,
            row,
            corner,
            pivots,
            border,
        } = &mut self.factors;
        let size = *size;
        let get = |right: &[f64], i: usize| Vector3::new(right[i], right[n + i], right[2 * n + i]);
        let put = |right: &mut [f64], i: usize, value: Vector3<f64>| {
            (right[i], right[n + i], right[2 * n + i]) = (value.x, value.y, value.z);
        };
        border[..3].copy_from_slice(get(right, last).as_slice());
        border[3..].copy_from_slice(&right[3 * n..]);
        let mut reduced = Vector3::zeros();
        for i in 0..last {
            let mut own = get(right, i);
            if i > 0 {
                own -= before[i] * reduced;
            }
            reduced = own;
            let solved = inverse[i] * own;
            for (j, border) in border.iter_mut().enumerate() {
                *border -= (row[i * size + j] * solved)[0];
            }
            put(right, i, solved);
        }
        substitute(corner, pivots, border);
        put(right, last, Vector3::new(border[0], border[1], border[2]));
        right[3 * n..].copy_from_slice(&border[3..]);
        let mut after = Vector3::zeros();
        for i in (0..last).rev() {
            let mut own = get(right, i);
            if i + 1 < last {
                own -= next[i] * after;
            }
            for (j, border) in border.iter().enumerate() {
                own -= column[i * size + j] * *border;
            }
            after = own;
            put(right, i, own);
        }
    }
}

/// Gaussian elimination with row exchanges, in place; false when singular.
fn eliminate(matrix: &mut [f64], pivots: &mut [usize], size: usize) -> bool {
    for k in 0..size {
        let pivot = (k..size)
            .max_by(|&a, &b| {
                matrix[a * size + k]
                    .abs()
                    .total_cmp(&matrix[b * size + k].abs())
            })
            .unwrap_or(k);
        pivots[k] = pivot;
        if pivot != k {
            for j in 0..size {
                matrix.swap(k * size + j, pivot * size + j);
            }
        }
        let top = matrix[k * size + k];
        if top == 0.0 || !top.is_finite() {
            return false;
        }
        for i in k + 1..size {
            let factor = matrix[i * size + k] / top;
            matrix[i * size + k] = factor;
            for j in k + 1..size {
                matrix[i * size + j] -= factor * matrix[k * size + j];
            }
        }
    }
    true
}

/// Solves with the factors of [`eliminate`].
fn substitute(matrix: &[f64], pivots: &[usize], right: &mut [f64]) {
    let size = right.len();
    for (k, &pivot) in pivots.iter().enumerate() {
        right.swap(k, pivot);
    }
    for i in 0..size {
        for j in 0..i {
            right[i] -= matrix[i * size + j] * right[j];
        }
    }
    for i in (0..size).rev() {
        for j in i + 1..size {
            right[i] -= matrix[i * size + j] * right[j];
        }
        right[i] /= matrix[i * size + i];
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    use super::*;

    /// The same matrix without its pattern.
    fn dense(matrix: &ChainMatrix) -> DMatrix<f64> {
        let (n, m) = (matrix.diagonal.len(), matrix.border);
        let mut all = DMatrix::zeros(3 * n + m, 3 * n + m);
        let place = |link: usize, axis: usize| axis * n + link;
        for k in 0..n {
            let next = (k + 1) % n;
            for i in 0..3 {
                for j in 0..3 {
                    all[(place(k, i), place(k, j))] += matrix.diagonal[k][(i, j)];
                    all[(place(k, i), place(next, j))] += matrix.upper[k][(i, j)];
                    all[(place(next, i), place(k, j))] += matrix.lower[k][(i, j)];
                }
                for j in 0..m {
                    all[(place(k, i), 3 * n + j)] += matrix.column[k * m + j][i];
                    all[(3 * n + j, place(k, i))] += matrix.row[k * m + j][i];
                }
            }
        }
        for i in 0..m {
            for j in 0..m {
                all[(3 * n + i, 3 * n + j)] += matrix.corner[i * m + j];
            }
        }
        all
    }

    proptest! {
        #[test]
        fn solutions_are_those_of_the_dense_matrix(
            n in 3usize..14,
            m in 0usize..5,
            numbers in proptest::collection::vec(-1.0f64..1.0, 4000),
        ) {
            let mut matrix = ChainMatrix::new(n, m);
            let mut next = numbers.iter().copied().cycle();
            let mut number = || next.next().unwrap();
            for k in 0..n {
                matrix.diagonal[k] = Matrix3::from_fn(|i, j| number() + if i == j { 8.0 } else { 0.0 });
                matrix.upper[k] = Matrix3::from_fn(|_, _| number());
                matrix.lower[k] = Matrix3::from_fn(|_, _| number());
                for j in 0..m {
                    matrix.column[k * m + j] = Vector3::from_fn(|_, _| number());
                    matrix.row[k * m + j] = RowVector3::from_fn(|_, _| number());
                }
            }
            for i in 0..m * m {
                matrix.corner[i] = number();
            }
            let right = DVector::from_fn(3 * n + m, |_, _| number());
            let whole = dense(&matrix);
            let Some(expected) = whole.clone().lu().solve(&right) else { return Ok(()) };
            prop_assume!(expected.amax() < 1e3);
            prop_assert!(matrix.factorise());
            let mut found = right.as_slice().to_vec();
            matrix.solve(&mut found);
            let error = (whole * DVector::from_vec(found) - right).amax();
            prop_assert!(error < 1e-9, "{error}");
        }
    }
}

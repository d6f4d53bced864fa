//! Householder factors with column pivoting, A P = Q R, in arrays that are made once: the rank shows as it goes.

/// Factors of a matrix whose columns are given one after another.
#[derive(Debug, Clone)]
pub(crate) struct Orthogonal {
    rows: usize,
    columns: usize,
    /// Column after column; below the diagonal the reflections, above it R.
    table: Vec<f64>,
    /// Diagonal of R.
    diagonal: Vec<f64>,
    /// 2/|v|² of each reflection.
    scale: Vec<f64>,
    /// Length of each column as given.
    lengths: Vec<f64>,
    /// `order[k]` is the column that became the k-th.
    order: Vec<usize>,
    /// What was left of each column, of its length, when it was taken.
    parts: Vec<f64>,
    rank: usize,
}

/// A column counts as dependent when less than this part of its length is left of it.
pub(crate) const RANK_TOLERANCE: f64 = 1e-13;

impl Orthogonal {
    pub(crate) fn new(rows: usize, columns: usize) -> Self {
        Self {
            rows,
            columns,
            table: vec![0.0; rows * columns],
            diagonal: vec![0.0; columns],
            scale: vec![0.0; columns],
            lengths: vec![0.0; columns],
            order: (0..columns).collect(),
            parts: vec![0.0; columns],
            rank: 0,
        }
    }

    /// The matrix to be factorised, all zeros; column j is `[j * rows..]`.
    pub(crate) fn clear(&mut self) -> &mut [f64] {
        self.table.fill(0.0);
        &mut self.table
    }

    pub(crate) fn rank(&self) -> usize {
        self.rank
    }

    /// The least part of a column that the others had left when it was taken: 1 for columns across each other.
    pub(crate) fn least_part(&self) -> f64 {
        self.parts[..self.rank].iter().copied().fold(1.0, f64::min)
    }

    /// Goes on as if columns of which less than `part` was left were dependent.
    pub(crate) fn truncate(&mut self, part: f64) {
        self.rank = (0..self.rank)
            .find(|&k| self.parts[k] < part)
            .unwrap_or(self.rank);
    }

    /// The columns, independent ones first.
    pub(crate) fn order(&self) -> &[usize] {
        &self.order
    }

    /// Factorises what was written into the matrix.
    pub(crate) fn factorise(&mut self) {
        let n = self.rows;
        for j in 0..self.columns {
            self.order[j] = j;
            self.lengths[j] = norm(&self.table[j * n..(j + 1) * n]);
        }
        self.rank = 0;
        for k in 0..self.columns.min(n) {
            let left = |j: usize| norm(&self.table[j * n + k..(j + 1) * n]) / self.lengths[j];
            let (mut pivot, mut most) = (k, 0.0);
            for j in k..self.columns {
                let part = left(j);
                if part > most {
                    (pivot, most) = (j, part);
                }
            }
            if most <= RANK_TOLERANCE {
                break;
            }
            self.parts[k] = most;
            self.swap(k, pivot);
            self.reflect(k);
            self.rank += 1;
        }
    }

    fn swap(&mut self, k: usize, pivot: usize) {
        if k == pivot {
            return;
        }
        let n = self.rows;
        let (head, tail) = self.table.split_at_mut(pivot * n);
        head[k * n..(k + 1) * n].swap_with_slice(&mut tail[..n]);
        self.lengths.swap(k, pivot);
        self.order.swap(k, pivot);
    }

    /// Turns what is left of column k onto the k-th axis, and the columns after it likewise.
    fn reflect(&mut self, k: usize) {
        let n = self.rows;
        let (head, tail) = self.table.split_at_mut((k + 1) * n);
        let v = &mut head[k * n + k..];
        let alpha = -norm(v).copysign(v[0]);
        v[0] -= alpha;
        self.diagonal[k] = alpha;
        self.scale[k] = 2.0 / dot(v, v);
        for column in tail.chunks_exact_mut(n) {
            apply(v, self.scale[k], &mut column[k..]);
        }
    }

    /// x <- Qᵀ x.
    pub(crate) fn turn(&self, x: &mut [f64]) {
        for k in 0..self.rank {
            apply(self.reflection(k), self.scale[k], &mut x[k..]);
        }
    }

    /// x <- Q x.
    pub(crate) fn turn_back(&self, x: &mut [f64]) {
        for k in (0..self.rank).rev() {
            apply(self.reflection(k), self.scale[k], &mut x[k..]);
        }
    }

    fn reflection(&self, k: usize) -> &[f64] {
        &self.table[k * self.rows + k..(k + 1) * self.rows]
    }

    /// Entry of R above its diagonal: row i of the column that became the j-th.
    fn upper(&self, i: usize, j: usize) -> f64 {
        self.table[j * self.rows + i]
    }

    /// Solves Rᵀ x = b for the leading `rank` numbers, in place.
    pub(crate) fn solve_transposed(&self, x: &mut [f64]) {
        for k in 0..self.rank {
            let mut sum = x[k];
            for (i, x) in x.iter().enumerate().take(k) {
                sum -= self.upper(i, k) * x;
            }
            x[k] = sum / self.diagonal[k];
        }
    }

    /// Solves R x = b for the leading `rank` numbers, in place.
    pub(crate) fn solve(&self, x: &mut [f64]) {
        for k in (0..self.rank).rev() {
            x[k] /= self.diagonal[k];
            let known = x[k];
            for (i, x) in x.iter_mut().enumerate().take(k) {
                *x -= self.upper(i, k) * known;
            }
        }
    }

    /// The columns past the rank in terms of those before it: T of A P = A₁ [1 T], row after row.
    pub(crate) fn dependence(&self) -> Vec<f64> {
        let (r, extra) = (self.rank, self.columns - self.rank);
        let mut dependence = vec![0.0; r * extra];
        let mut column = vec![0.0; r];
        for j in 0..extra {
            for (i, x) in column.iter_mut().enumerate() {
                *x = self.upper(i, r + j);
            }
            self.solve(&mut column);
            for (i, x) in column.iter().enumerate() {
                dependence[i * extra + j] = *x;
            }
        }
        dependence
    }
}

fn apply(v: &[f64], scale: f64, x: &mut [f64]) {
    let part = scale * dot(v, x);
    for (x, v) in x.iter_mut().zip(v) {
        *x -= part * v;
    }
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(crate) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Solves A x = b for a symmetric positive definite A of `n` rows, in place; false when it is not.
pub(crate) fn solve_positive(a: &mut [f64], n: usize, x: &mut [f64]) -> bool {
    for k in 0..n {
        let before = a[k * n + k];
        let pivot = before - dot(&a[k * n..k * n + k], &a[k * n..k * n + k]);
        if pivot.is_nan() || pivot <= 1e-13 * before.abs().max(f64::MIN_POSITIVE) {
            return false;
        }
        let root = pivot.sqrt();
        a[k * n + k] = root;
        for i in k + 1..n {
            let sum = a[i * n + k] - dot(&a[i * n..i * n + k], &a[k * n..k * n + k]);
            a[i * n + k] = sum / root;
        }
    }
    for i in 0..n {
        x[i] = (x[i] - dot(&a[i * n..i * n + i], &x[..i])) / a[i * n + i];
    }
    for i in (0..n).rev() {
        x[i] /= a[i * n + i];
        let known = x[i];
        for j in 0..i {
            x[j] -= a[i * n + j] * known;
        }
    }
    true
}

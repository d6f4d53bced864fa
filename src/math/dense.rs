//! A small dense system: LU factorisation with partial pivoting.

/// Square matrix, later its factors.
#[derive(Debug, Clone)]
pub(crate) struct Dense {
    size: usize,
    /// Row-major entries; later the factors L and U with the inverses of the pivots.
    entries: Vec<f64>,
    pivots: Vec<usize>,
}

impl Dense {
    /// Allocate a matrix of `size` rows.
    pub(crate) fn new(size: usize) -> Self {
        Self {
            size,
            entries: vec![0.0; size * size],
            pivots: vec![0; size],
        }
    }

    /// Set all entries to zero.
    #[inline]
    pub(crate) fn clear(&mut self) {
        self.entries.fill(0.0);
    }

    /// Set all entries to zero but those of the diagonal.
    pub(crate) fn set_diagonal(&mut self, diagonal: &[f64]) {
        self.clear();
        for (i, &value) in diagonal.iter().enumerate() {
            self.entries[i * (self.size + 1)] = value;
        }
    }

    /// Add `value` to one entry.
    #[inline]
    pub(crate) fn add(&mut self, row: usize, column: usize, value: f64) {
        self.entries[row * self.size + column] += value;
    }

    /// Return the entries in row-major order.
    pub(crate) fn entries(&self) -> &[f64] {
        &self.entries
    }

    /// Return the diagonal entries.
    pub(crate) fn diagonal(&self) -> impl Iterator<Item = f64> {
        self.entries.iter().step_by(self.size + 1).copied()
    }

    /// Factorise P A = L U in place; return false where a pivot is zero or not finite.
    pub(crate) fn factorise(&mut self) -> bool {
        let (size, matrix) = (self.size, &mut self.entries);
        for k in 0..size {
            // Partial pivoting: the largest entry of the column.
            let pivot = (k..size)
                .max_by(|&a, &b| {
                    let entry = |row: usize| matrix[row * size + k].abs();
                    entry(a).total_cmp(&entry(b))
                })
                .unwrap_or(k);
            self.pivots[k] = pivot;
            if pivot != k {
                for j in 0..size {
                    matrix.swap(k * size + j, pivot * size + j);
                }
            }
            let over = 1.0 / matrix[k * size + k];
            if !over.is_finite() || over == 0.0 {
                return false;
            }
            matrix[k * size + k] = over;
            for i in k + 1..size {
                let factor = matrix[i * size + k] * over;
                matrix[i * size + k] = factor;
                for j in k + 1..size {
                    matrix[i * size + j] -= factor * matrix[k * size + j];
                }
            }
        }
        true
    }

    /// Solve L U x = P b in place.
    pub(crate) fn solve(&self, right: &mut [f64]) {
        let (size, matrix) = (self.size, &self.entries);
        for (k, &pivot) in self.pivots.iter().enumerate() {
            right.swap(k, pivot);
        }
        // Forward substitution with L, whose diagonal is one.
        for i in 0..size {
            for j in 0..i {
                right[i] -= matrix[i * size + j] * right[j];
            }
        }
        // Back substitution with U, whose diagonal holds inverses.
        for i in (0..size).rev() {
            for j in i + 1..size {
                right[i] -= matrix[i * size + j] * right[j];
            }
            right[i] *= matrix[i * size + i];
        }
    }
}

//! L D Lᵀ factors of a sparse symmetric matrix with known structure, in either precision; rows with vanishing pivots are omitted.

use crate::math::double_double::Number;

/// Indices of all entries, in the order of elimination.
#[derive(Debug, Clone)]
pub(crate) struct Structure {
    /// Upper triangle by columns, with the diagonal last.
    pub(crate) start: Vec<usize>,
    pub(crate) above: Vec<usize>,
    /// Columns in which each row of L has an entry, in order.
    pub(crate) pattern_start: Vec<usize>,
    pub(crate) pattern: Vec<usize>,
    /// Columns of L: their first entries, and their rows.
    pub(crate) column_start: Vec<usize>,
    pub(crate) rows: Vec<usize>,
}

impl Structure {
    /// Return the structure from the entries of the upper triangle and of the rows of L.
    pub(crate) fn new(
        (start, above): (Vec<usize>, Vec<usize>),
        (pattern_start, pattern): (Vec<usize>, Vec<usize>),
    ) -> Self {
        let m = start.len() - 1;
        let mut column_start = vec![0; m + 1];
        for &column in &pattern {
            column_start[column + 1] += 1;
        }
        for k in 0..m {
            column_start[k + 1] += column_start[k];
        }
        let mut next = column_start.clone();
        let mut rows = vec![0; pattern.len()];
        for k in 0..m {
            for &column in &pattern[pattern_start[k]..pattern_start[k + 1]] {
                rows[next[column]] = k;
                next[column] += 1;
            }
        }
        Self {
            start,
            above,
            pattern_start,
            pattern,
            column_start,
            rows,
        }
    }

    pub(crate) fn order(&self) -> usize {
        self.start.len() - 1
    }

    /// Multiply the matrix of this upper triangle by `x`.
    pub(crate) fn multiply(&self, entries: &[f64], x: &[f64], product: &mut [f64]) {
        product.fill(0.0);
        for (k, ends) in self.start.windows(2).enumerate() {
            let column = ends[0]..ends[1];
            for (&row, entry) in self.above[column.clone()].iter().zip(&entries[column]) {
                product[row] += entry * x[k];
                if row != k {
                    product[k] += entry * x[row];
                }
            }
        }
    }
}

/// Matrix and its factors.
#[derive(Debug, Clone)]
pub(crate) struct Factors<T> {
    /// Upper triangle of the matrix.
    pub(crate) entries: Vec<T>,
    /// L by columns, without its diagonal.
    pub(crate) values: Vec<T>,
    /// Inverse pivots; zero for omitted rows.
    pub(crate) inverse_pivots: Vec<T>,
    /// Number of entries computed in each column.
    filled: Vec<usize>,
    /// Work array, zero between calls.
    work: Vec<T>,
    pub(crate) rank: usize,
    /// Smallest ratio of an accepted pivot to its diagonal entry.
    pub(crate) least: f64,
}

impl<T: Number> Factors<T> {
    pub(crate) fn new(structure: &Structure) -> Self {
        let m = structure.order();
        Self {
            entries: vec![T::default(); structure.above.len()],
            values: vec![T::default(); structure.rows.len()],
            inverse_pivots: vec![T::default(); m],
            filled: vec![0; m],
            work: vec![T::default(); m],
            rank: 0,
            least: 1.0,
        }
    }

    /// Factorise, omitting rows whose pivot is below `tolerance` times the diagonal entry.
    pub(crate) fn eliminate(&mut self, structure: &Structure, tolerance: f64) {
        self.filled.fill(0);
        self.rank = 0;
        self.least = 1.0;
        for k in 0..structure.order() {
            self.eliminate_row(structure, k, tolerance);
        }
    }

    /// Compute row k of L and its pivot (up-looking factorisation).
    fn eliminate_row(&mut self, structure: &Structure, k: usize, tolerance: f64) {
        let upper = structure.start[k]..structure.start[k + 1];
        for (&row, &entry) in structure.above[upper.clone()]
            .iter()
            .zip(&self.entries[upper])
        {
            self.work[row] = entry;
        }
        let diagonal = self.work[k].rounded();
        let columns = structure.pattern_start[k]..structure.pattern_start[k + 1];
        for &column in &structure.pattern[columns] {
            let y = std::mem::take(&mut self.work[column]);
            let begin = structure.column_start[column];
            let end = begin + self.filled[column];
            self.filled[column] += 1;
            let inverse = self.inverse_pivots[column];
            if inverse.rounded() == 0.0 {
                // An omitted row contributes nothing.
                self.values[end] = T::default();
                continue;
            }
            let rows = &structure.rows[begin..end];
            // w[row] -= L[row, column] y, then L[k, column] = y/d_column and d_k -= L[k, column] y.
            for (&row, value) in rows.iter().zip(&self.values[begin..end]) {
                self.work[row] = self.work[row].less(*value, y);
            }
            let value = y.times(inverse);
            self.work[k] = self.work[k].less(value, y);
            self.values[end] = value;
        }
        let left = std::mem::take(&mut self.work[k]);
        let pivot = left.rounded();
        self.inverse_pivots[k] = T::default();
        if pivot > tolerance * diagonal {
            self.least = self.least.min(pivot / diagonal);
            self.inverse_pivots[k] = left.inverse();
            self.rank += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::double_double::Twice;

    #[test]
    fn twice_the_precision_tells_a_row_that_depends_from_one_that_nearly_does() {
        // Gram matrix of (1, 0), (1, 1e-9), (2, 1e-9): the first two differ by 1e-9, and the third is their sum.
        let vectors = [[1.0, 0.0, 0.0], [1.0, 1e-9, 0.0], [2.0, 1e-9, 0.0]];
        let upper = (vec![0, 1, 3, 6], vec![0, 0, 1, 0, 1, 2]);
        let structure = Structure::new(upper, (vec![0, 0, 1, 3], vec![0, 0, 1]));
        let mut factors = Factors::<Twice>::new(&structure);
        for column in 0..3 {
            for at in structure.start[column]..structure.start[column + 1] {
                let (a, b) = (vectors[structure.above[at]], vectors[column]);
                factors.entries[at] = Twice::meet(&a, &[1.0; 3], &b);
            }
        }
        factors.eliminate(&structure, 1e-26);
        assert_eq!(factors.rank, 2);
        assert!((factors.least / 1e-18 - 1.0).abs() < 1e-6);
        assert_eq!(factors.inverse_pivots[2].rounded(), 0.0);
    }
}

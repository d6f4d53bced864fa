//! L D Lᵀ of a sparse symmetric matrix whose structure is known, without rows whose pivot vanishes; in either precision.

use crate::math::double_double::Number;

/// Places of all numbers, in the order of elimination.
#[derive(Debug, Clone)]
pub(crate) struct Structure {
    /// Upper triangle, column after column, the diagonal last.
    pub(crate) start: Vec<usize>,
    pub(crate) above: Vec<usize>,
    /// Columns in which each row of L has an entry, in order.
    pub(crate) pattern_start: Vec<usize>,
    pub(crate) pattern: Vec<usize>,
    /// Columns of L: where they begin, and their rows.
    pub(crate) column_start: Vec<usize>,
    pub(crate) rows: Vec<usize>,
}

impl Structure {
    /// From the places of the upper triangle and those of the rows of L.
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

    /// The matrix of this upper triangle times `x`.
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

/// The matrix and its factors.
#[derive(Debug, Clone)]
pub(crate) struct Factors<T> {
    /// The upper triangle.
    pub(crate) entries: Vec<T>,
    /// L, column after column, without its diagonal.
    pub(crate) values: Vec<T>,
    /// Zero for rows that are left out.
    pub(crate) inverse_pivots: Vec<T>,
    /// How much of each column is there.
    filled: Vec<usize>,
    /// Scratch, zero between calls.
    work: Vec<T>,
    pub(crate) rank: usize,
    /// Least pivot in parts of its diagonal entry, of those that count.
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

    /// Factors without rows whose pivot is below `tolerance` of the diagonal entry.
    pub(crate) fn eliminate(&mut self, structure: &Structure, tolerance: f64) {
        self.filled.fill(0);
        self.rank = 0;
        self.least = 1.0;
        for k in 0..structure.order() {
            self.eliminate_row(structure, k, tolerance);
        }
    }

    /// Row k of L and its pivot.
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
                // What was left out takes nothing off.
                self.values[end] = T::default();
                continue;
            }
            let rows = &structure.rows[begin..end];
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
        // Gram's matrix of (1, 0), (1, 1e-9), (2, 1e-9): the second stands a billionth apart, the third is the sum of both.
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

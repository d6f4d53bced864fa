//! Null space of the multipliers of redundant constraints: which constraints are redundant, and the multipliers of least Euclidean norm.

use crate::math::dense::Dense;

/// Linearly independent vectors, each a set of multipliers in the order of elimination.
#[derive(Debug, Clone, Default)]
pub(crate) struct NullSpace {
    vectors: Vec<Vec<f64>>,
}

/// Ratio to the largest entry of its vector below which an entry counts as zero.
const ZERO: f64 = 1e-6;

impl NullSpace {
    pub(crate) fn add(&mut self, vector: Vec<f64>) {
        self.vectors.push(vector);
    }

    /// Subtract from `multipliers` their component in this space; the remainder has the same effect and the least norm.
    pub(crate) fn sub_product(&self, place: &[usize], multipliers: &mut [f64]) {
        if self.vectors.is_empty() {
            return;
        }
        // Least squares: Gram matrix times parts = projections of the multipliers.
        let mut gram = Dense::new(self.vectors.len());
        for (i, a) in self.vectors.iter().enumerate() {
            for (j, b) in self.vectors.iter().enumerate() {
                gram.add(i, j, a.iter().zip(b).map(|(a, b)| a * b).sum());
            }
        }
        let along = |vector: &Vec<f64>| {
            let terms = multipliers.iter().zip(place);
            terms.map(|(lambda, &k)| lambda * vector[k]).sum::<f64>()
        };
        let mut parts: Vec<f64> = self.vectors.iter().map(along).collect();
        if gram.factorise() {
            gram.solve(&mut parts);
            for (vector, part) in self.vectors.iter().zip(&parts) {
                for (lambda, &k) in multipliers.iter_mut().zip(place) {
                    *lambda -= part * vector[k];
                }
            }
        }
    }

    /// Return for each vector one redundant constraint, as late in the description as possible.
    pub(crate) fn last_rows(&self, place: &[usize]) -> Vec<usize> {
        let mut vectors = self.vectors.clone();
        let mut found = Vec::new();
        for row in (0..place.len()).rev() {
            let k = place[row];
            let there = |vector: &Vec<f64>| {
                let most = vector.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
                vector[k].abs() > ZERO * most
            };
            let Some(chosen) = vectors.iter().position(there) else {
                continue;
            };
            let chosen = vectors.swap_remove(chosen);
            // Eliminate this constraint from the remaining vectors.
            for vector in &mut vectors {
                let part = vector[k] / chosen[k];
                vector
                    .iter_mut()
                    .zip(&chosen)
                    .for_each(|(v, c)| *v -= part * c);
                vector[k] = 0.0;
            }
            found.push(row);
        }
        found.reverse();
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_of_rows_that_say_the_same_is_named_and_all_share_the_load() {
        // Rows 0, 1 and 3 are equal; row 2 is independent. Place and row are inverse permutations.
        let place = [3, 2, 1, 0];
        let mut space = NullSpace::default();
        space.add(vec![-1.0, 0.0, 1.0, 0.0]);
        space.add(vec![0.0, 0.0, -1.0, 1.0]);
        assert_eq!(space.last_rows(&place), [1, 3]);
        let mut multipliers = [6.0, 0.0, 5.0, 0.0];
        space.sub_product(&place, &mut multipliers);
        for (found, expected) in multipliers.iter().zip([2.0, 2.0, 5.0, 2.0]) {
            assert!((found - expected).abs() < 1e-14, "{multipliers:?}");
        }
    }
}

//! The sprockets' own coordinates on the border of Newton's matrix, and the small dense system that they leave.

use crate::model::{Model, Rotation, Support};

use super::teeth::Motion;

/// The coordinates of one sprocket: numbers `first`, `first` + 1, ... on the border.
#[derive(Debug, Clone)]
pub(super) struct SprocketMotions {
    pub(super) first: usize,
    pub(super) motions: Vec<Motion>,
}

impl SprocketMotions {
    /// Those of all sprockets.
    pub(super) fn of(model: &Model) -> Vec<Self> {
        let start = 3 * model.links;
        let mut all = Vec::with_capacity(model.sprockets.len());
        for sprocket in &model.sprockets {
            let mut found = Vec::new();
            match sprocket.support {
                Support::Fixed => {}
                Support::Slide {
                    index, direction, ..
                } => found.push((index - start, Motion::Along(direction.into()))),
                Support::Floating { x, y } => {
                    found.push((x - start, Motion::Along([1.0, 0.0])));
                    found.push((y - start, Motion::Along([0.0, 1.0])));
                }
            }
            if let Rotation::Free { index, .. } = sprocket.rotation {
                found.push((index - start, Motion::Turn));
            }
            let first = found.first().map_or(0, |(index, _)| *index);
            debug_assert!(
                found
                    .iter()
                    .enumerate()
                    .all(|(i, (index, _))| *index == first + i)
            );
            all.push(Self {
                first,
                motions: found.into_iter().map(|(_, motion)| motion).collect(),
            });
        }
        all
    }
}

/// A small dense system, solved by elimination with row exchanges.
#[derive(Debug, Clone)]
pub(super) struct Corner {
    size: usize,
    /// Row after row; then the factors, with inverses of the pivots.
    entries: Vec<f64>,
    /// Entries on the diagonal without teeth.
    own: Vec<f64>,
    pivots: Vec<usize>,
}

impl Corner {
    pub(super) fn new(size: usize) -> Self {
        Self {
            size,
            entries: vec![0.0; size * size],
            own: vec![0.0; size],
            pivots: vec![0; size],
        }
    }

    /// Masses, and the tensioner's dashpot.
    pub(super) fn start(&mut self, model: &Model, gamma: f64) {
        self.entries.fill(0.0);
        let start = 3 * model.links;
        for sprocket in &model.sprockets {
            sprocket
                .for_each_inertia(|index, inertia| self.add(index - start, index - start, inertia));
            if let Support::Slide { index, damping, .. } = sprocket.support {
                self.add(index - start, index - start, gamma * damping);
            }
        }
        for (i, own) in self.own.iter_mut().enumerate() {
            *own = self.entries[i * self.size + i];
        }
    }

    /// The greatest share of an entry on the diagonal that teeth make up.
    pub(super) fn bound_by_teeth(&self) -> f64 {
        let shares = self.own.iter().enumerate().map(|(i, own)| {
            let all = self.entries[i * self.size + i];
            (all - own).abs() / all.abs()
        });
        shares.fold(0.0, f64::max)
    }

    pub(super) fn add(&mut self, row: usize, column: usize, value: f64) {
        self.entries[row * self.size + column] += value;
    }

    /// Factorises; false when singular.
    pub(super) fn factorise(&mut self) -> bool {
        let (size, matrix) = (self.size, &mut self.entries);
        for k in 0..size {
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

    /// Solves in place.
    pub(super) fn solve(&self, right: &mut [f64]) {
        let (size, matrix) = (self.size, &self.entries);
        for (k, &pivot) in self.pivots.iter().enumerate() {
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
            right[i] *= matrix[i * size + i];
        }
    }
}

//! The solution inside the last step: the polynomial that the corrector's slopes define.

use super::MAX_ORDER;
use super::differences::Differences;

/// Weights of the last step's differences at one time; components are then summed as they are needed.
#[derive(Debug)]
pub struct DenseOutput<'a> {
    weights: [f64; MAX_ORDER + 1],
    terms: usize,
    distance: f64,
    y: &'a [f64],
    differences: &'a Differences,
}

impl<'a> DenseOutput<'a> {
    /// At `distance` \[s\] from the end of a step of `order`; negative inside the step.
    pub(super) fn new(
        distance: f64,
        order: usize,
        psi: &[f64; MAX_ORDER],
        y: &'a [f64],
        differences: &'a Differences,
    ) -> Self {
        let terms = order + 1;
        let mut weights = [0.0; MAX_ORDER + 1];
        let mut w = [0.0; MAX_ORDER + 1];
        for (i, w) in w.iter_mut().enumerate().take(terms) {
            *w = 1.0 / (i + 1) as f64;
        }
        weights[0] = 1.0;
        let mut before = 0.0;
        for j in 1..terms {
            let psi = psi[j - 1];
            let (gamma, eta) = ((distance + before) / psi, distance / psi);
            for i in 0..(terms - j) {
                w[i] = gamma * w[i] - eta * w[i + 1];
            }
            weights[j] = w[0];
            before = psi;
        }
        Self {
            weights,
            terms,
            distance,
            y,
            differences,
        }
    }

    /// One component.
    #[must_use]
    pub fn value(&self, component: usize) -> f64 {
        let sum: f64 = (0..self.terms)
            .rev()
            .map(|i| self.weights[i] * self.differences.row(i)[component])
            .sum();
        self.y[component] + self.distance * sum
    }

    /// All components.
    pub fn write(&self, y: &mut [f64]) {
        y.fill(0.0);
        for i in (0..self.terms).rev() {
            let weight = self.weights[i];
            for (y, phi) in y.iter_mut().zip(self.differences.row(i)) {
                *y += weight * phi;
            }
        }
        for (y, end) in y.iter_mut().zip(self.y) {
            *y = end + self.distance * *y;
        }
    }
}

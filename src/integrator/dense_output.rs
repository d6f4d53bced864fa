//! Dense output: the interpolating polynomial of the last step (Shampine and Gordon, subroutine INTRP).
//!
//! At order k the polynomial has degree k + 1. It meets the end of the step exactly; the start of an implicit step to about the tolerance.

use pulp::{Simd, WithSimd};

use super::differences::Differences;
use super::{Adams, MAX_ORDER};
use crate::math::simd::InstructionSet;

/// Dense output at one time: weights of the differences, from which components are computed on demand.
#[derive(Debug)]
pub struct DenseOutput<'a> {
    weights: [f64; MAX_ORDER + 1],
    terms: usize,
    distance: f64,
    y: &'a [f64],
    differences: &'a Differences,
}

impl<'a> DenseOutput<'a> {
    /// Return the dense output at `distance` \[s\] from the end of a step of `order`; negative inside the step.
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
        // Integrals of the powers: w_i = 1/i (index from 1 in INTRP).
        for (i, w) in w.iter_mut().enumerate().take(terms) {
            *w = 1.0 / (i + 1) as f64;
        }
        weights[0] = 1.0;
        // γ_j = (s + ψ_{j-1})/ψ_j, η_j = s/ψ_j with the distance s from the end.
        let factors = |j: usize| {
            let before = if j > 1 { psi[j - 2] } else { 0.0 };
            ((distance + before) / psi[j - 1], distance / psi[j - 1])
        };
        // Recursion of the integrals w of INTRP; the weight of difference j is the first entry of round j. Two rounds go through w at once.
        let mut j = 1;
        while j + 1 < terms {
            let ((gamma, eta), (next_gamma, next_eta)) = (factors(j), factors(j + 1));
            let mut here = gamma * w[0] - eta * w[1];
            weights[j] = here;
            for i in 0..(terms - j - 1) {
                let next = gamma * w[i + 1] - eta * w[i + 2];
                w[i] = next_gamma * here - next_eta * next;
                here = next;
            }
            weights[j + 1] = w[0];
            j += 2;
        }
        if j < terms {
            let (gamma, eta) = factors(j);
            weights[j] = gamma * w[0] - eta * w[1];
        }
        Self {
            weights,
            terms,
            distance,
            y,
            differences,
        }
    }

    /// Return one component.
    #[must_use]
    pub fn value(&self, component: usize) -> f64 {
        let weights = self.weights[..self.terms].iter().enumerate();
        let sum: f64 = (weights.rev())
            .map(|(i, weight)| weight * self.differences.value(i, component))
            .sum();
        // y(t) = y + s Σ weights φ.
        self.y[component] + self.distance * sum
    }

    /// Write all components.
    pub(super) fn write(&self, set: InstructionSet, y: &mut [f64]) {
        set.run(Write { dense: self, y });
    }
}

/// Kernel of [`DenseOutput::write`]: plain loops that the compiler vectorizes for the instruction set.
struct Write<'a> {
    dense: &'a DenseOutput<'a>,
    y: &'a mut [f64],
}

impl WithSimd for Write<'_> {
    type Output = ();

    #[inline(always)]
    #[allow(clippy::inline_always)] // a function that is not inlined is compiled without the kernel's instruction set
    fn with_simd<S: Simd>(self, _: S) {
        let (dense, y) = (self.dense, self.y);
        y.fill(0.0);
        for i in (0..dense.terms).rev() {
            let weight = dense.weights[i];
            match dense.differences.parts_of_row(i) {
                (row, None) => {
                    for (y, phi) in y.iter_mut().zip(row) {
                        *y += weight * phi;
                    }
                }
                (row, Some(newest)) => {
                    for ((y, phi), newest) in y.iter_mut().zip(row).zip(newest) {
                        *y += weight * (phi + newest);
                    }
                }
            }
        }
        for (y, end) in y.iter_mut().zip(dense.y) {
            *y = end + dense.distance * *y;
        }
    }
}

/// Dense output of N linear functions of the solution, whose differences are gathered once.
#[derive(Debug)]
pub(crate) struct DenseSums<'a, const N: usize> {
    adams: &'a Adams,
    /// Values at the end of the step.
    end: [f64; N],
    /// Values of each difference.
    rows: [[f64; N]; MAX_ORDER + 1],
}

impl<const N: usize> DenseSums<'_, N> {
    /// Return the values at the end of the step.
    pub(crate) fn end(&self) -> [f64; N] {
        self.end
    }

    /// Return the change of the values from the end of the step to `t`, without cancellation.
    pub(crate) fn change_at(&self, t: f64) -> [f64; N] {
        let dense = self.adams.dense(t);
        let mut change = [0.0; N];
        for (weight, row) in dense.weights[..dense.terms].iter().zip(&self.rows).rev() {
            for (change, phi) in change.iter_mut().zip(row) {
                *change += weight * phi;
            }
        }
        change.map(|change| dense.distance * change)
    }
}

impl Adams {
    /// Return the dense output of the values that `read` computes from a solution; `read` must be linear.
    pub(crate) fn dense_sums<const N: usize>(
        &self,
        read: impl Fn(&[f64]) -> [f64; N],
    ) -> DenseSums<'_, N> {
        let mut rows = [[0.0; N]; MAX_ORDER + 1];
        let newest = self.history.differences.parts_of_row(0).1.map(&read);
        for (i, sums) in rows
            .iter_mut()
            .enumerate()
            .take(self.history.last_order + 1)
        {
            let (row, unfinished) = self.history.differences.parts_of_row(i);
            *sums = read(row);
            if let (Some(_), Some(newest)) = (unfinished, newest) {
                for (sum, newest) in sums.iter_mut().zip(newest) {
                    *sum += newest;
                }
            }
        }
        DenseSums {
            adams: self,
            end: read(self.y()),
            rows,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::{OdeSystem, StepControl};

    /// y = (cos t, -sin t, 2 t).
    struct Circle;

    impl OdeSystem for Circle {
        fn dimension(&self) -> usize {
            3
        }
        fn derivative(&mut self, _t: f64, y: &[f64], dydt: &mut [f64]) {
            dydt.copy_from_slice(&[y[1], -y[0], 2.0]);
        }
    }

    #[test]
    fn all_forms_of_the_dense_output_are_the_solution_inside_the_step() {
        let control = StepControl {
            rtol: 1e-10,
            atol: 1e-10,
            max_step: 0.1,
            ..StepControl::default()
        };
        let mut adams = Adams::new(3, control);
        adams.restart(0.0, &[1.0, 0.0, 0.0]);
        for _ in 0..60 {
            adams.step(&mut Circle).unwrap();
            let size = adams.history.last_step_size;
            let sums = adams.dense_sums(|y| [y[0] + y[2], 3.0 * y[1]]);
            assert_eq!(
                sums.end(),
                [adams.y()[0] + adams.y()[2], 3.0 * adams.y()[1]]
            );
            for share in [0.0, 0.25, 0.5, 0.8, 1.0] {
                let t = adams.time() - share * size;
                let exact = [t.cos(), -t.sin(), 2.0 * t];
                let mut written = [f64::NAN; 3];
                adams.interpolate(t, &mut written);
                for (k, (written, exact)) in written.iter().zip(exact).enumerate() {
                    assert!((written - exact).abs() < 1e-8, "{k} {t}: {written} {exact}");
                    assert!((adams.dense(t).value(k) - written).abs() < 1e-13);
                }
                let [end, change] = [sums.end(), sums.change_at(t)];
                let expected = [exact[0] + exact[2], 3.0 * exact[1]];
                for k in 0..2 {
                    assert!((end[k] + change[k] - expected[k]).abs() < 4e-8, "{k} {t}");
                }
            }
        }
        assert!(adams.history.last_order > 4);
    }

    /// y = (t², 1 - 2 t²).
    struct Quadratic;

    impl OdeSystem for Quadratic {
        fn dimension(&self) -> usize {
            2
        }
        fn derivative(&mut self, t: f64, _y: &[f64], dydt: &mut [f64]) {
            dydt.copy_from_slice(&[2.0 * t, -4.0 * t]);
        }
    }

    #[test]
    fn a_quadratic_is_met_inside_the_first_steps() {
        let control = StepControl {
            rtol: 1e-3,
            atol: 1e-3,
            max_step: 0.1,
            ..StepControl::default()
        };
        let mut adams = Adams::new(2, control);
        adams.restart(0.5, &[0.25, 0.5]);
        // Two differences in a step of order one: its derivative is linear.
        for _ in 0..6 {
            adams.step(&mut Quadratic).unwrap();
            let sums = adams.dense_sums(|y| [y[0] - y[1]]);
            for share in [0.25, 0.5, 1.0] {
                let t = adams.time() - share * adams.history.last_step_size;
                let mut y = [0.0; 2];
                adams.interpolate(t, &mut y);
                assert!((y[0] - t * t).abs() < 1e-14 && (y[1] + 2.0 * t * t - 1.0).abs() < 1e-14);
                let difference = sums.end()[0] + sums.change_at(t)[0];
                assert!((difference - 3.0 * t * t + 1.0).abs() < 1e-14);
            }
        }
    }

    /// `y_i` = t^(i+1).
    struct Powers;

    impl OdeSystem for Powers {
        fn dimension(&self) -> usize {
            9
        }
        fn derivative(&mut self, t: f64, _y: &[f64], dydt: &mut [f64]) {
            for (i, rate) in (0..9).zip(dydt) {
                *rate = f64::from(i + 1) * t.powi(i);
            }
        }
    }

    #[test]
    fn the_change_inside_a_step_of_order_k_is_exact_for_polynomials_of_degree_k_plus_one() {
        let control = StepControl {
            rtol: 1e-9,
            atol: 1e-9,
            max_step: 0.1,
            ..StepControl::default()
        };
        let mut adams = Adams::new(9, control);
        adams.restart(0.0, &[0.0; 9]);
        let mut highest = 0;
        while adams.time() < 1.0 {
            adams.step(&mut Powers).unwrap();
            let (end, order) = (adams.time(), adams.history.last_order);
            highest = highest.max(order);
            for share in [0.25, 0.5, 1.0] {
                let t = end - share * adams.history.last_step_size;
                let mut y = [0.0; 9];
                adams.interpolate(t, &mut y);
                for (i, y) in y.iter().enumerate().take(order + 1) {
                    let power = (i + 1).try_into().unwrap();
                    let change = t.powi(power) - end.powi(power);
                    assert!((y - adams.y()[i] - change).abs() < 1e-13, "{order} {i}");
                }
            }
        }
        assert!(highest >= 5, "{highest}");
    }
}

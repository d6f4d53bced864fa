//! Error estimates, and the choice of the next order and step size (Shampine and Gordon, chapter 7).

use super::coefficients::Coefficients;

/// γ*_i: error constants of the Adams formulas for constant steps, index 0 for order 1; the rounded values of DE/STEP.
const GAMMA_STAR: [f64; 13] = [
    0.5, 0.0833, 0.0417, 0.0264, 0.0188, 0.0143, 0.0114, 0.009_36, 0.007_89, 0.006_79, 0.005_92,
    0.005_24, 0.004_68,
];

/// Error for which the next step size is chosen, in units of the tolerance (`P5EPS` of DE/STEP).
///
/// Half of the tolerance leaves room for the growth of the error within one step. Doubled: see docs/development/constants.md.
pub(super) const SAFE_ERROR: f64 = 0.5;

/// Factor of the error that a change of order has to gain between orders 1 and 2 (DE/STEP).
///
/// The estimates at these orders come from one difference only. Doubled: order 2 is left and order 1 is raised at equal errors.
const GAIN_AT_LOW_ORDER: f64 = 0.5;

/// Smallest and largest factor of a step size that is reduced after an accepted step (DE/STEP).
///
/// The largest one prevents changes that gain less than the restart of the coefficients costs. Doubled: no reduction at all.
const REDUCTION: [f64; 2] = [0.5, 0.9];

/// Estimated errors of a step, in units of the tolerance.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ErrorEstimate {
    /// Local error of the step itself.
    pub(super) local: f64,
    /// Errors of constant steps at orders k - 2, k - 1 and k.
    pub(super) two_below: f64,
    pub(super) one_below: f64,
    pub(super) at_order: f64,
}

impl ErrorEstimate {
    /// Return the estimates for a step of order `k` and size `h` from the `sums` of squares at orders k, k - 1 and k - 2.
    ///
    /// Local error: `h (g_{k} - g_{k+1}) |f(p) - φ*_1|`, the difference of the formulas of orders k and k + 1. Errors of constant steps:
    /// `h σ_{i+1} γ*_i |φ_{i+1}|` with the differences at the predicted value (Shampine and Gordon, chapter 7).
    pub(super) fn new(
        c: &Coefficients,
        (k, h): (usize, f64),
        norm: impl Fn(f64) -> f64,
        [at, one, two]: [f64; 3],
    ) -> Self {
        let error = |sum: f64, order: usize| h * norm(sum) * c.sigma[order] * gamma_star(order);
        Self {
            local: h * norm(at) * (c.g[k - 1] - c.g[k]),
            at_order: error(at, k),
            one_below: if k >= 2 { error(one, k - 1) } else { 0.0 },
            two_below: if k >= 3 { error(two, k - 2) } else { 0.0 },
        }
    }

    /// Return whether the error test accepts the step; false for NaN.
    pub(super) fn accepts(&self) -> bool {
        self.local <= 1.0
    }

    /// Return whether the errors of the lower orders are not larger.
    pub(super) fn prefers_lower(&self, order: usize) -> bool {
        match order {
            // There is no order below one.
            1 => false,
            // Only one estimate below order two: the lower order has to gain a factor.
            2 => self.one_below <= GAIN_AT_LOW_ORDER * self.at_order,
            // Both lower orders must be as good: one of them may be small by chance.
            _ => self.one_below <= self.at_order && self.two_below <= self.at_order,
        }
    }
}

/// Return the error constant γ* of `order`.
pub(super) fn gamma_star(order: usize) -> f64 {
    GAMMA_STAR[order - 1]
}

/// Order of the next step and the error estimate at that order.
pub(super) struct OrderChoice {
    pub(super) order: usize,
    pub(super) error: f64,
}

/// Return the best of the orders k - 1, k and k + 1.
///
/// The order falls as soon as lower orders have no larger errors. It rises only after k + 1 equal steps, because the error estimate
/// `one_above` is valid for constant steps only (Shampine and Gordon, chapter 7).
pub(super) fn choose_order(
    order: usize,
    max_order: usize,
    estimate: &ErrorEstimate,
    enough_equal_steps: bool,
    one_above: impl FnOnce() -> f64,
) -> OrderChoice {
    let keep = OrderChoice {
        order,
        error: estimate.at_order,
    };
    let lower = OrderChoice {
        order: order.saturating_sub(1),
        error: estimate.one_below,
    };
    // The test of the lower orders does not need equal steps.
    if estimate.prefers_lower(order) {
        return lower;
    }
    // The estimate one order up, h γ*_{k+1} |φ_{k+2}|, holds for equal steps only.
    if !enough_equal_steps || order >= max_order {
        return keep;
    }
    let above = one_above();
    let raise = OrderChoice {
        order: order + 1,
        error: above,
    };
    // At order one there is no estimate below; the rise has to gain a factor.
    if order == 1 {
        return if above < GAIN_AT_LOW_ORDER * estimate.at_order {
            raise
        } else {
            keep
        };
    }
    // The errors must decrease with the order up to k + 1; otherwise high differences are noise.
    if estimate.one_below <= estimate.at_order.min(above) {
        return lower;
    }
    if above < estimate.at_order {
        raise
    } else {
        keep
    }
}

/// Return the next step size: doubled, kept or reduced, for an error of [`SAFE_ERROR`] at `order`.
///
/// The error is about h^(k+1): a step may double when `error 2^(k+1)` is within the limit. A kept size keeps the coefficients.
pub(super) fn choose_step(h: f64, order: usize, error: f64) -> f64 {
    // 2^(k+1) is the growth of the error with a doubled step.
    if SAFE_ERROR >= error * f64::from(2u32 << order) {
        return 2.0 * h;
    }
    // Equal steps keep coefficients and permit a rise of the order.
    if SAFE_ERROR >= error {
        return h;
    }
    // Optimal step from error = C h^(k+1).
    let exponent = order as f64 + 1.0;
    let [smallest, largest] = REDUCTION;
    h * (SAFE_ERROR / error)
        .powf(1.0 / exponent)
        .clamp(smallest, largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(two_below: f64, one_below: f64, at_order: f64) -> ErrorEstimate {
        ErrorEstimate {
            local: at_order,
            two_below,
            one_below,
            at_order,
        }
    }

    /// The next order after `order`, of at most 12, with the errors and that of one order above.
    fn chosen(order: usize, errors: &ErrorEstimate, equal: bool, above: f64) -> (usize, f64) {
        let choice = choose_order(order, 12, errors, equal, || above);
        (choice.order, choice.error)
    }

    #[test]
    fn error_constants_are_the_differences_of_the_adams_moulton_weights() {
        // γ*_i = 1/2, 1/12, 1/24, 19/720 by the recurrence γ*_m = -Σ γ*_j/(m + 1 - j).
        let mut exact = vec![1.0f64];
        for m in 1..=13usize {
            let sum: f64 = (0..m).map(|j| exact[j] / (m + 1 - j) as f64).sum();
            exact.push(-sum);
        }
        for (order, exact) in exact.iter().enumerate().skip(1) {
            let error = gamma_star(order) / exact.abs() - 1.0;
            // The table has three digits.
            assert!(error.abs() < 5e-3, "{order}: {error}");
        }
    }

    #[test]
    fn a_step_is_accepted_up_to_its_tolerance() {
        assert!(estimate(0.0, 0.0, 1.0).accepts());
        assert!(!estimate(0.0, 0.0, 1.001).accepts());
        assert!(!estimate(0.0, 0.0, f64::NAN).accepts());
    }

    #[test]
    fn the_order_falls_where_lower_orders_are_as_good() {
        assert_eq!(chosen(4, &estimate(1.0, 0.9, 1.0), false, 0.0), (3, 0.9));
        assert_eq!(chosen(4, &estimate(1.1, 0.9, 1.0), false, 0.0), (4, 1.0));
        assert_eq!(chosen(2, &estimate(0.0, 0.5, 1.0), false, 0.0), (1, 0.5));
        assert_eq!(chosen(2, &estimate(0.0, 0.6, 1.0), false, 0.0), (2, 1.0));
        assert_eq!(chosen(1, &estimate(0.0, 0.0, 1.0), false, 0.0), (1, 1.0));
        // One estimate below may be small by chance, unless that one order up is not smaller.
        assert_eq!(chosen(4, &estimate(2.0, 0.5, 1.0), true, 0.8), (3, 0.5));
    }

    #[test]
    fn the_order_rises_after_equal_steps_where_the_error_falls() {
        let errors = estimate(4.0, 2.0, 1.0);
        assert_eq!(chosen(4, &errors, true, 0.9), (5, 0.9));
        assert_eq!(chosen(4, &errors, true, 1.0), (4, 1.0));
        assert_eq!(chosen(4, &errors, false, 0.9), (4, 1.0));
        assert_eq!(chosen(12, &errors, true, 0.9), (12, 1.0));
        assert_eq!(chosen(1, &errors, true, 0.4), (2, 0.4));
        assert_eq!(chosen(1, &errors, true, 0.5), (1, 1.0));
        assert_eq!(chosen(1, &errors, true, 0.6), (1, 1.0));
    }

    #[test]
    fn a_step_doubles_stays_or_falls_for_half_of_the_tolerance() {
        // Doubled, an error of order 3 grows by 2^4.
        assert_eq!(choose_step(0.1, 3, 0.5 / 16.0), 0.2);
        assert_eq!(choose_step(0.1, 3, 0.51 / 16.0), 0.1);
        assert_eq!(choose_step(0.1, 3, 0.5), 0.1);
        let reduced = choose_step(0.1, 3, 0.8);
        assert!((0.8 * (reduced / 0.1).powi(4) - 0.5).abs() < 1e-12);
        assert!((choose_step(0.1, 3, 0.51) - 0.09).abs() < 1e-15);
        assert!((choose_step(0.1, 3, 1e3) - 0.05).abs() < 1e-15);
    }

    #[test]
    fn estimates_are_products_of_step_size_difference_and_coefficients() {
        let mut c = Coefficients::new();
        c.g[..4].copy_from_slice(&[1.0, 0.5, 0.3, 0.2]);
        c.sigma[..4].copy_from_slice(&[1.0, 0.9, 0.7, 0.4]);
        let found = ErrorEstimate::new(&c, (3, 0.1), f64::sqrt, [4.0, 9.0, 16.0]);
        let expected = [
            0.1 * 2.0 * (0.3 - 0.2),
            0.1 * 2.0 * 0.4 * gamma_star(3),
            0.1 * 3.0 * 0.7 * gamma_star(2),
            0.1 * 4.0 * 0.9 * gamma_star(1),
        ];
        let found = [
            found.local,
            found.at_order,
            found.one_below,
            found.two_below,
        ];
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-14, "{found} {expected}");
        }
        let fifth = ErrorEstimate::new(&c, (5, 0.1), f64::sqrt, [4.0, 9.0, 16.0]);
        assert!((fifth.two_below / (0.1 * 4.0 * 0.4 * gamma_star(3)) - 1.0).abs() < 1e-14);
        // Orders below one have no estimate.
        let first = ErrorEstimate::new(&c, (1, 0.1), f64::sqrt, [4.0, 9.0, 16.0]);
        assert_eq!((first.one_below, first.two_below), (0.0, 0.0));
        let second = ErrorEstimate::new(&c, (2, 0.1), f64::sqrt, [4.0, 9.0, 16.0]);
        assert!(second.one_below > 0.0 && second.two_below == 0.0);
    }

    #[test]
    fn a_rise_from_order_one_has_to_gain_a_half_of_any_error() {
        assert_eq!(chosen(1, &estimate(0.0, 0.0, 2.0), true, 0.9), (2, 0.9));
        assert_eq!(chosen(1, &estimate(0.0, 0.0, 0.5), true, 0.3), (1, 0.5));
    }
}

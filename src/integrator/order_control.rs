//! Error estimates, and the choice of the next order and step size (Shampine and Gordon, chapter 7).

/// γ*_i: error constants of the Adams formulas for constant steps, index 0 for order 1.
const GAMMA_STAR: [f64; 13] = [
    0.5, 0.0833, 0.0417, 0.0264, 0.0188, 0.0143, 0.0114, 0.009_36, 0.007_89, 0.006_79, 0.005_92,
    0.005_24, 0.004_68,
];

/// Estimated errors of a step, in units of the tolerance.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ErrorEstimate {
    /// Of the step itself.
    pub(super) local: f64,
    /// Had the order been k - 2, k - 1, k, with constant steps.
    pub(super) two_below: f64,
    pub(super) one_below: f64,
    pub(super) at_order: f64,
}

impl ErrorEstimate {
    pub(super) fn accepts(&self) -> bool {
        self.local <= 1.0 // false for NaN
    }

    /// Whether the lower orders do no worse.
    pub(super) fn prefers_lower(&self, order: usize) -> bool {
        match order {
            1 => false,
            2 => self.one_below <= 0.5 * self.at_order,
            _ => self.one_below.max(self.two_below) <= self.at_order,
        }
    }
}

/// Error constant γ* of `order`.
pub(super) fn gamma_star(order: usize) -> f64 {
    GAMMA_STAR[order - 1]
}

/// The next order after an accepted step, and the error estimate that goes with it.
pub(super) struct OrderChoice {
    pub(super) order: usize,
    pub(super) error: f64,
}

/// Chooses among k - 1, k and k + 1; `one_above` is asked for only when it can matter.
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
    if estimate.prefers_lower(order) {
        return lower;
    }
    if !enough_equal_steps || order >= max_order {
        return keep;
    }
    let above = one_above();
    let raise = OrderChoice {
        order: order + 1,
        error: above,
    };
    if order == 1 {
        return if above < 0.5 * estimate.at_order {
            raise
        } else {
            keep
        };
    }
    if estimate.one_below <= estimate.at_order.min(above) {
        return lower;
    }
    if above < estimate.at_order {
        raise
    } else {
        keep
    }
}

/// The next step size: doubled, kept, or reduced, so that the error at `order` stays at half the tolerance.
pub(super) fn choose_step(h: f64, order: usize, error: f64) -> f64 {
    if 0.5 >= error * f64::from(2u32 << order) {
        return 2.0 * h;
    }
    if 0.5 >= error {
        return h;
    }
    let exponent = order as f64 + 1.0;
    h * (0.5 / error).powf(1.0 / exponent).clamp(0.5, 0.9)
}

//! Coefficients of the Adams formulas for variable steps (Shampine and Gordon, chapter 5; block 1 of subroutine STEP).
//!
//! Index 0 is index 1 in the book.

use serde::{Deserialize, Serialize};

use super::MAX_ORDER;

/// Initial values `v_i = 1/(i (i + 1))` of the weights.
const FIRST: [f64; MAX_ORDER] = {
    let mut first = [0.0; MAX_ORDER];
    let mut i = 0;
    while i < MAX_ORDER {
        first[i] = 1.0 / ((i + 1) * (i + 2)) as f64;
        i += 1;
    }
    first
};

/// Coefficients for one step of size h after the steps of the past.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Coefficients {
    /// `ψ_i`: sum of the last i step sizes, this one included.
    pub(super) psi: [f64; MAX_ORDER],
    /// `α_i` = `h/ψ_i`.
    alpha: [f64; MAX_ORDER],
    /// `β_i`: factors from φ to φ*, products of `ψ_j(n+1)/ψ_j(n)` for j < i.
    pub(super) beta: [f64; MAX_ORDER],
    /// `σ_i = (i - 1)! α_1 … α_{i-1}`: factors of the error estimates.
    pub(super) sigma: [f64; MAX_ORDER + 1],
    /// `g_i`: weights of the differences in the predicted value `y + h Σ g_i β_i φ_i`.
    pub(super) g: [f64; MAX_ORDER + 1],
    /// `v_i`: integrals from which `g_i` follow by recursion.
    v: [f64; MAX_ORDER],
    /// Number of equal steps (`NS` of STEP), this one included; at most one more than the last order.
    pub(super) equal_steps: usize,
}

impl Coefficients {
    pub(super) fn new() -> Self {
        let mut new = Self {
            psi: [0.0; MAX_ORDER],
            alpha: [0.0; MAX_ORDER],
            beta: [0.0; MAX_ORDER],
            sigma: [0.0; MAX_ORDER + 1],
            g: [0.0; MAX_ORDER + 1],
            v: [0.0; MAX_ORDER],
            equal_steps: 0,
        };
        new.sigma[0] = 1.0;
        new.g[0] = 1.0;
        new.g[1] = 0.5;
        new
    }

    /// Compute the coefficients for a step of size `h` at `order`, after a step of size `last_h` at `last_order`.
    ///
    /// After `NS` equal steps the first `NS` coefficients are those of constant steps: only the rest is computed.
    pub(super) fn update(&mut self, h: f64, order: usize, last_h: f64, last_order: usize) {
        // Another step size begins a new count of equal steps.
        if h.to_bits() != last_h.to_bits() {
            self.equal_steps = 0;
        }
        // The count has no effect beyond the order: it is limited, as in STEP.
        if self.equal_steps <= last_order {
            self.equal_steps += 1;
        }
        let (k, ns) = (order, self.equal_steps);
        if k < ns {
            return; // constant step size, constant or lower order: no coefficient changes
        }
        // For i ≤ NS: β = 1, α = 1/i, σ = 1, as all steps in ψ_i are equal.
        self.beta[ns - 1] = 1.0;
        self.alpha[ns - 1] = 1.0 / ns as f64;
        self.sigma[ns] = 1.0;
        let mut number = ns as f64;
        let (mut sum, mut beta, mut sigma) = (h * number, 1.0, 1.0);
        for i in ns..k.min(MAX_ORDER) {
            // ψ_{i+1}(n+1) = ψ_i(n) + h; β and σ are products of the earlier factors.
            let previous = self.psi[i - 1];
            beta = beta * sum / previous;
            (self.psi[i - 1], self.beta[i]) = (sum, beta);
            sum = previous + h;
            self.alpha[i] = h / sum;
            // σ_{i+1} = i α_i σ_i in the indices of the book.
            number += 1.0;
            sigma *= number * self.alpha[i];
            self.sigma[i + 1] = sigma;
        }
        self.psi[k - 1] = sum;
        self.update_g(k, ns, last_order);
    }

    /// Update v by one round of `v_i - α_NS v_{i+1}`, and the weights from `g_{NS+1}` on.
    fn update_g(&mut self, k: usize, ns: usize, last_order: usize) {
        // After a change of the step size v begins anew: v_i = 1/(i (i + 1)).
        if ns <= 1 {
            self.v = FIRST;
        } else {
            // The order was raised: the new last entry goes through the earlier rounds at once.
            if k > last_order {
                self.v[k - 1] = FIRST[k - 1];
                for j in 0..ns.saturating_sub(2) {
                    let i = k - 2 - j;
                    self.v[i] -= self.alpha[j + 1] * self.v[i + 1];
                }
            }
            // One more equal step: one round over all entries.
            let alpha = self.alpha[ns - 1];
            let last = k - ns + 1;
            let v = &mut self.v[..=last];
            for i in 0..last {
                v[i] -= alpha * v[i + 1];
            }
            self.g[ns] = self.v[0];
        }
        self.update_g_behind(k, ns);
    }

    /// Compute the weights after `g_{NS+1}`.
    ///
    /// Each round replaces `w_j` by `w_j - α w_{j+1}`; its first entry is the next weight. The loop runs over diagonals, so that one
    /// entry of v goes through all its rounds in registers; two diagonals share their loads.
    fn update_g_behind(&mut self, k: usize, ns: usize) {
        let count = k - ns;
        // Last entries of the earlier rounds.
        let mut rounds = [self.v[0]; MAX_ORDER];
        let rounds = &mut rounds[..=count];
        let (v, alpha, g) = (
            &self.v[1..=count],
            &self.alpha[ns..k],
            &mut self.g[ns + 1..=k],
        );
        // Entry m of v enters at round 0 and leaves at round m + 1 as the weight g.
        let mut m = 0;
        while m + 1 < count {
            let (mut w, mut after) = (v[m], v[m + 1]);
            for (before, alpha) in rounds[..=m].iter_mut().zip(&alpha[..=m]) {
                let next = *before - alpha * w;
                let next_after = w - alpha * after;
                *before = after;
                (w, after) = (next, next_after);
            }
            let last = w - alpha[m + 1] * after;
            (g[m], g[m + 1]) = (w, last);
            (rounds[m + 1], rounds[m + 2]) = (after, last);
            m += 2;
        }
        if m < count {
            let rounds = rounds[..=m].iter().zip(&alpha[..=m]);
            g[m] = rounds.fold(v[m], |w, (before, alpha)| before - alpha * w);
        }
    }

    /// Undo the change of ψ by [`Self::update`] after a rejected step (block 3 of STEP).
    pub(super) fn undo_prediction(&mut self, order: usize, h: f64) {
        // ψ_i(n) = ψ_{i+1}(n+1) - h: the inverse of the sum in update.
        for i in 1..order {
            self.psi[i - 1] = self.psi[i] - h;
        }
        self.equal_steps = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_steps_have_the_weights_of_adams_and_bashforth() {
        let exact = [1.0, 0.5, 5.0 / 12.0, 0.375, 251.0 / 720.0, 95.0 / 288.0];
        let mut c = Coefficients::new();
        let mut last = (0.0, 0);
        // The order rises to five and stays: after k + 1 equal steps no coefficient changes.
        for order in [1, 2, 3, 4, 5, 5, 5, 5, 5, 5, 5] {
            c.update(0.1, order, last.0, last.1);
            last = (0.1, order);
            for (g, exact) in c.g.iter().zip(&exact[..=order.min(c.equal_steps)]) {
                assert!((g - exact).abs() < 1e-15, "{order}: {g} {exact}");
            }
        }
        for (i, sigma) in c.sigma[..6].iter().enumerate() {
            assert!((sigma - 1.0).abs() < 1e-15, "{i}");
        }
    }

    #[test]
    fn coefficients_continued_over_equal_steps_are_those_made_from_all_step_sizes() {
        let mut c = Coefficients::new();
        let mut last = (0.0, 0);
        // Steps of three sizes; the order rises, stays, falls and rises again among equal steps.
        for (h, order) in [
            (0.1, 1),
            (0.2, 2),
            (0.2, 3),
            (0.2, 4),
            (0.2, 4),
            (0.2, 4),
            (0.2, 5),
            (0.3, 5),
            (0.3, 5),
            (0.3, 5),
            (0.3, 5),
            (0.3, 6),
            (0.3, 5),
            (0.3, 4),
            (0.3, 5),
            (0.15, 6),
            (0.15, 6),
            (0.15, 7),
            (0.15, 7),
            (0.15, 7),
        ] {
            let mut fresh = c.clone();
            c.update(h, order, last.0, last.1);
            // A last size that is none: nothing is continued.
            fresh.update(h, order, f64::NAN, last.1);
            for i in 0..=order {
                assert!((c.g[i] - fresh.g[i]).abs() < 1e-14, "{order} {i}");
                assert!(
                    (c.sigma[i] / fresh.sigma[i] - 1.0).abs() < 1e-13,
                    "{order} {i}"
                );
            }
            for i in 0..order {
                assert!((c.psi[i] - fresh.psi[i]).abs() < 1e-14, "{order} {i}");
                assert!(
                    (c.beta[i] / fresh.beta[i] - 1.0).abs() < 1e-13,
                    "{order} {i}"
                );
            }
            last = (h, order);
        }
    }

    #[test]
    fn an_undone_step_leaves_the_sums_of_the_steps_before() {
        let mut c = Coefficients::new();
        let mut last = (0.0, 0);
        for (h, order) in [(0.1, 1), (0.2, 2), (0.3, 3), (0.3, 4)] {
            c.update(h, order, last.0, last.1);
            last = (h, order);
        }
        let before = c.clone();
        c.update(0.5, 5, last.0, last.1);
        c.undo_prediction(5, 0.5);
        for (psi, before) in c.psi.iter().zip(&before.psi[..4]) {
            assert!((psi - before).abs() < 1e-15, "{psi} {before}");
        }
        assert_eq!(c.equal_steps, 0);
    }
}

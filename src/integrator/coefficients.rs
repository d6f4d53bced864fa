//! Coefficients of the Adams formulas on the steps taken so far (Shampine and Gordon, chapter 5).
//!
//! Index 0 here is index 1 in the book.

use serde::{Deserialize, Serialize};

use super::MAX_ORDER;

/// `1/(i (i + 1))`, which `v_i` begins with.
const FIRST: [f64; MAX_ORDER] = {
    let mut first = [0.0; MAX_ORDER];
    let mut i = 0;
    while i < MAX_ORDER {
        first[i] = 1.0 / ((i + 1) * (i + 2)) as f64;
        i += 1;
    }
    first
};

/// Coefficients for one step of size h from the history of steps.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Coefficients {
    /// `ψ_i`: sum of the last i steps, this one included.
    pub(super) psi: [f64; MAX_ORDER],
    /// `α_i` = `h/ψ_i`.
    alpha: [f64; MAX_ORDER],
    /// `β_i`, the factors that turn φ into φ*.
    pub(super) beta: [f64; MAX_ORDER],
    /// `σ_i`, scaled by which the differences estimate the error.
    pub(super) sigma: [f64; MAX_ORDER + 1],
    /// `g_i`, the weights of the differences in the step.
    pub(super) g: [f64; MAX_ORDER + 1],
    v: [f64; MAX_ORDER],
    /// Steps of the present size and order or lower, this one included.
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

    /// Prepares a step of size `h` at `order`, after a step of size `last_h` at `last_order`.
    pub(super) fn update(&mut self, h: f64, order: usize, last_h: f64, last_order: usize) {
        if h.to_bits() != last_h.to_bits() {
            self.equal_steps = 0;
        }
        if self.equal_steps <= last_order {
            self.equal_steps += 1;
        }
        let (k, ns) = (order, self.equal_steps);
        if k < ns {
            return; // nothing changes: constant step, constant or lower order
        }
        // Entries below ns steps_since_switch as they were.
        self.beta[ns - 1] = 1.0;
        self.alpha[ns - 1] = 1.0 / ns as f64;
        self.sigma[ns] = 1.0;
        let (mut sum, mut beta, mut sigma) = (h * ns as f64, 1.0, 1.0);
        for i in ns..k.min(MAX_ORDER) {
            let previous = self.psi[i - 1];
            beta = beta * sum / previous;
            (self.psi[i - 1], self.beta[i]) = (sum, beta);
            sum = previous + h;
            self.alpha[i] = h / sum;
            sigma *= (i + 1) as f64 * self.alpha[i];
            self.sigma[i + 1] = sigma;
        }
        self.psi[k - 1] = sum;
        self.update_g(k, ns, last_order);
    }

    fn update_g(&mut self, k: usize, ns: usize, last_order: usize) {
        if ns <= 1 {
            self.v = FIRST;
        } else {
            if k > last_order {
                self.v[k - 1] = FIRST[k - 1];
                for j in 0..ns.saturating_sub(2) {
                    let i = k - 2 - j;
                    self.v[i] -= self.alpha[j + 1] * self.v[i + 1];
                }
            }
            let alpha = self.alpha[ns - 1];
            let v = &mut self.v[..k - ns + 2];
            for i in 0..v.len() - 1 {
                v[i] -= alpha * v[i + 1];
            }
            self.g[ns] = self.v[0];
        }
        self.update_g_behind(k, ns);
    }

    /// Each round of w turns `w_j` into `w_j - α w_{j+1}`, and its first entry is the next weight. Diagonal by diagonal, an entry
    /// of v goes through all the rounds that it belongs to at once.
    fn update_g_behind(&mut self, k: usize, ns: usize) {
        // The last entries of all rounds before.
        let mut diagonal = [self.v[0]; MAX_ORDER];
        let alpha = &self.alpha[ns..k];
        for (m, g) in self.g[ns + 1..=k].iter_mut().enumerate() {
            let mut w = self.v[m + 1];
            for (before, alpha) in diagonal[..=m].iter_mut().zip(alpha) {
                let next = *before - alpha * w;
                *before = w;
                w = next;
            }
            diagonal[m + 1] = w;
            *g = w;
        }
    }

    /// Takes back what `update` did to ψ, for a step that failed.
    pub(super) fn undo_prediction(&mut self, order: usize, h: f64) {
        for i in 1..order {
            self.psi[i - 1] = self.psi[i] - h;
        }
        self.equal_steps = 0;
    }
}

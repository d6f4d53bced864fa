//! Explicit Runge-Kutta methods: the classical one with fixed steps, and embedded pairs from a tableau.

use crate::system::{Accepted, Evolving};
use crate::{Budget, Outcome};

/// An embedded pair; the caller owns the arrays.
pub(crate) struct Tableau<'a> {
    /// Stages, without the slope at the end.
    pub(crate) stages: usize,
    /// Order of the error estimate plus one.
    pub(crate) order: f64,
    pub(crate) a: &'a [f64],
    pub(crate) b: &'a [f64],
    pub(crate) c: &'a [f64],
    /// Weights of the error estimate over the stages and the slope at the end.
    pub(crate) error: &'a [f64],
    /// A second one, for estimates as in DOP853: |e5|²/sqrt(|e5|² + 0.01 |e3|²).
    pub(crate) error_3: &'a [f64],
}

/// The classical method of order 4 with steps of `h`.
pub(crate) fn rk4(
    system: &mut dyn Evolving,
    y: &mut [f64],
    h: f64,
    end: f64,
    budget: &Budget,
) -> Outcome {
    let n = y.len();
    let mut outcome = Outcome::default();
    let (mut k, mut stage, mut before) = ([(); 5].map(|()| vec![0.0; n]), vec![0.0; n], y.to_vec());
    system.derivative(0.0, y, &mut k[0]);
    outcome.evaluations = 1;
    let steps = (end / h).ceil() as u64;
    let h = end / steps as f64;
    for i in 0..steps {
        if budget.spent(&outcome) {
            return outcome.unfinished(i as f64 * h);
        }
        let t = i as f64 * h;
        for (s, share) in [(0, 0.5), (1, 0.5), (2, 1.0)] {
            for ((stage, y), k) in stage.iter_mut().zip(&*y).zip(&k[s]) {
                *stage = y + share * h * k;
            }
            system.derivative(t + share * h, &stage, &mut k[s + 1]);
        }
        before.copy_from_slice(y);
        for (j, y) in y.iter_mut().enumerate() {
            *y += h / 6.0 * (k[0][j] + 2.0 * (k[1][j] + k[2][j]) + k[3][j]);
        }
        system.derivative(t + h, y, &mut k[4]);
        outcome.evaluations += 4;
        outcome.steps += 1;
        if !y.iter().all(|y| y.is_finite()) {
            return outcome.failed(t);
        }
        let [first, .., last] = &mut k;
        let step = Accepted {
            start: t,
            end: t + h,
            y_start: &before,
            y_end: y,
            slope_start: first,
            slope_end: last,
        };
        if system.crossed(&step) {
            outcome.uncharged(|| system.remember(&step));
            system.derivative(t + h, y, last);
            outcome.evaluations += 1;
        } else {
            system.pass(&step);
        }
        std::mem::swap(first, last);
    }
    outcome.finished(end)
}

/// An embedded pair with the step size control of Hairer and Wanner's codes, without their stabilisation.
pub(crate) fn embedded(
    system: &mut dyn Evolving,
    tableau: &Tableau<'_>,
    y: &mut [f64],
    tolerance: f64,
    end: f64,
    budget: &Budget,
) -> Outcome {
    let n = y.len();
    let stages = tableau.stages;
    let inverse: Vec<f64> = system
        .scale()
        .iter()
        .map(|s| 1.0 / (tolerance * s))
        .collect();
    let watched = inverse.iter().filter(|w| **w > 0.0).count() as f64;
    let mut outcome = Outcome::default();
    let mut k: Vec<Vec<f64>> = vec![vec![0.0; n]; stages + 1];
    let (mut stage, mut before, mut new) = (vec![0.0; n], y.to_vec(), vec![0.0; n]);
    let (mut t, mut rejected) = (0.0, false);
    system.derivative(t, y, &mut k[0]);
    let mut h = first_step(system, y, &mut k, &mut stage, &inverse, tableau.order).min(end);
    outcome.evaluations = 2;
    while t < end {
        if budget.spent(&outcome) {
            return outcome.unfinished(t);
        }
        if h < 1e-15 {
            return outcome.failed(t);
        }
        h = h.min(end - t);
        for s in 1..stages {
            combine(&mut stage, y, h, &tableau.a[s * stages..s * stages + s], &k);
            system.derivative(t + tableau.c[s] * h, &stage, &mut k[s]);
        }
        combine(&mut new, y, h, &tableau.b[..stages], &k);
        system.derivative(t + h, &new, &mut k[stages]);
        outcome.evaluations += stages as u64;
        let norm = |weights: &[f64]| {
            let mut sum = 0.0;
            for (i, inverse) in inverse.iter().enumerate() {
                let error: f64 = weights.iter().zip(&k).map(|(w, k)| w * k[i]).sum();
                sum += (h * error * inverse).powi(2);
            }
            sum / watched
        };
        let mut error = norm(tableau.error).sqrt();
        if !tableau.error_3.is_empty() && error > 0.0 {
            error = error * error / (error * error + 0.01 * norm(tableau.error_3)).sqrt();
        }
        let grow = 0.9 * error.max(1e-10).powf(-1.0 / tableau.order);
        if error > 1.0 || !error.is_finite() {
            h *= if error.is_finite() {
                grow.clamp(0.2, 1.0)
            } else {
                0.1
            };
            rejected = true;
            continue;
        }
        before.copy_from_slice(y);
        y.copy_from_slice(&new);
        outcome.steps += 1;
        let step = Accepted {
            start: t,
            end: t + h,
            y_start: &before,
            y_end: y,
            slope_start: &k[0],
            slope_end: &k[stages],
        };
        let changed = system.crossed(&step);
        if changed {
            outcome.uncharged(|| system.remember(&step));
        } else {
            system.pass(&step);
        }
        k.swap(0, stages);
        t += h;
        if changed {
            system.derivative(t, y, &mut k[0]);
            outcome.evaluations += 1;
        }
        h *= grow.clamp(0.2, if rejected { 1.0 } else { 10.0 });
        rejected = false;
    }
    outcome.finished(end)
}

/// First step of Hairer and Wanner's codes (HINIT), from the slope k\[0\] and that after a trial step, which is left in k\[1\].
fn first_step(
    system: &mut dyn Evolving,
    y: &[f64],
    k: &mut [Vec<f64>],
    stage: &mut [f64],
    inverse: &[f64],
    order: f64,
) -> f64 {
    let norm = |value: &dyn Fn(usize) -> f64| {
        let squares = (inverse.iter().enumerate()).map(|(i, w)| (w * value(i)).powi(2));
        squares.sum::<f64>().sqrt()
    };
    let slope = norm(&|i| k[0][i]);
    let trial = 0.01 * norm(&|i| y[i]) / slope;
    combine(stage, y, trial, &[1.0], k);
    system.derivative(trial, stage, &mut k[1]);
    let bend = norm(&|i| k[1][i] - k[0][i]) / trial;
    (0.01 / slope.max(bend))
        .powf(1.0 / order)
        .min(100.0 * trial)
}

/// y + h Σ weight k
fn combine(out: &mut [f64], y: &[f64], h: f64, weights: &[f64], k: &[Vec<f64>]) {
    out.copy_from_slice(y);
    for (weight, k) in weights.iter().zip(k) {
        if *weight != 0.0 {
            let share = h * weight;
            for (out, k) in out.iter_mut().zip(k) {
                *out += share * k;
            }
        }
    }
}

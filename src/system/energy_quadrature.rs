//! Energy quadrature: powers integrated through each step.
//!
//! The external power is integrated as the corrector integrates forces, from the powers at the ends of steps ([`external`]). The dissipated
//! power is integrated along the path of the step by Simpson's rule with one, two or four panels: panels are halved until the estimated error
//! is accepted. Contacts begin and end within steps, and the power has a kink there; smooth steps take one evaluation. Where the powers
//! before predicted those in the middle, most steps take none. The sums are no part of the integrator's state: they do not enter its
//! error test, and cost nothing while they are off.

mod external;
mod interpolation;

use serde::{Deserialize, Serialize};

use super::PowerSum;
use crate::integrator::Step;
use external::ExternalPowers;
use interpolation::{Interpolation, Predicted};

/// Accepted error of a step, over its length and the largest power in it, or the mean power of all steps if that is larger: dissipated, or a
/// share of the external power.
///
/// With the power of the step alone, many evaluations are made in steps that contribute little (decision 22).
///
/// In smooth steps the estimate is that of one panel or of a parabola, which errs more than the sum that is added. At an onset the error can be
/// several times its estimate. Errors of steps cancel in part. On the published drive, with pretensions up to 100 N, their sum is less than a
/// tenth of the residual at the default accuracy (decision 22).
const ACCEPTED_ERROR: f64 = 1e-2;

/// Share of the external power that counts as much as dissipated power, for scenes that lose little of it: an error of 4e-5 of the external
/// power is accepted.
const EXTERNAL_SHARE: f64 = 4e-3;

/// Accepted error of powers that are predicted in the middle of a step, over the accepted one of Simpson's rule. Errors of such predictions have
/// one sign where steps are long beside the relaxation of contacts (decision 22).
const PREDICTED_SHARE: f64 = 0.25;

/// Largest number of panels of a step. A kink leaves an error that falls only with the square of their length.
const MOST_PANELS: usize = 4;

/// The sums of the energy balance, and the powers along the last step, for reports inside it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "P: PowerSum")]
pub struct EnergyQuadrature<P> {
    /// Panels of a step; 0: as many as the powers need, one to [`MOST_PANELS`].
    fineness: usize,
    /// The last step \[s\].
    start: f64,
    end: f64,
    /// Energies at its start \[J\].
    at_start: P,
    /// Energies at its end \[J\].
    at_end: P,
    /// Powers at the ends and in the middle of its panels, from start to end \[W\]. Between the ends of the step, external powers are those of
    /// the parabola with the work of the step, unless they are integrated along the path.
    powers: Vec<P>,
    /// Time \[s\] in which powers were integrated, and the integral of their [`decisive`] part \[J\].
    metered_time: f64,
    exchanged: f64,
    /// Evaluations of the right-hand side that the quadrature took.
    evaluations: u64,
    interpolation: Interpolation<P>,
    external: ExternalPowers,
}

impl<P: PowerSum> EnergyQuadrature<P> {
    pub(crate) fn new() -> Self {
        let mut quadrature = Self::default();
        quadrature.refine(0);
        quadrature
    }

    /// Divide each step into `fineness` panels from now on, a power of two; 0: as many as the powers need.
    pub(crate) fn refine(&mut self, fineness: usize) {
        self.fineness = fineness;
        let most = 2 * fineness.max(MOST_PANELS) + 1;
        self.powers.reserve(most.saturating_sub(self.powers.len()));
        self.begin(self.end, self.last_power());
    }

    /// Continue at `t` with `powers`, without a step before; the sums stay.
    pub(crate) fn begin(&mut self, t: f64, powers: P) {
        (self.start, self.end) = (t, t);
        self.at_start = self.at_end;
        self.interpolation = Interpolation::default();
        self.external = ExternalPowers::default();
        self.powers.clear();
        self.powers.resize(3, powers);
    }

    /// Discard the part of the last step after `t`.
    pub(crate) fn cut(&mut self, t: f64) {
        self.at_end = self.energies(t);
        self.end = t;
    }

    /// Return whether it can replace `other`.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.fineness == other.fineness
            && self.powers.len() == 2 * self.panels() + 1
            && self.panels().is_power_of_two()
            && self.panels() <= self.fineness.max(MOST_PANELS)
            && self.start <= self.end
    }

    /// Copy `other`, and keep the room of the powers.
    pub(crate) fn carry_on(&mut self, other: &Self) {
        let mut powers = std::mem::take(&mut self.powers);
        powers.clear();
        powers.extend_from_slice(&other.powers);
        *self = Self {
            powers,
            ..other.clone()
        };
    }

    /// Panels of a step; 0: as many as the powers need.
    pub(crate) fn fineness(&self) -> usize {
        self.fineness
    }

    /// Evaluations of the right-hand side that the quadrature took.
    pub(crate) fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// Add the energies of a step with the powers `at_end` at its end; `powers_at` evaluates powers at a part of the step and its time. Their
    /// external part is used in steps in which the external power is to be integrated `along_path`.
    pub(crate) fn add_step(
        &mut self,
        step: &Step,
        at_end: P,
        along_path: bool,
        mut powers_at: impl FnMut(f64, f64) -> P,
    ) {
        let length = step.end - step.start;
        let at_start = self.last_power();
        let mean_power = self.mean_power();
        let mut powers_at = |part: f64| {
            self.evaluations += 1;
            powers_at(part, step.start + part * length)
        };
        let last_start = (self.start < self.end).then(|| (self.start, self.powers[0]));
        let before = last_start.as_ref().map(|node| in_parts_of(step, node));
        let scale = decisive(&at_start).max(decisive(&at_end)).max(mean_power);
        let near = PREDICTED_SHARE * interpolation::ERROR_IN_THE_MIDDLE * ACCEPTED_ERROR * scale;
        let predicted = match self.interpolation.places(step) {
            Some(before) if self.fineness == 0 => {
                Predicted::new(before, [&at_start, &at_end], near)
            }
            _ => Predicted::default(),
        };
        let is_predicted = !along_path && self.interpolation.permits(&predicted);
        self.interpolation.remember(step.start, at_start);
        let mut middle = predicted.powers;
        if !is_predicted {
            middle = powers_at(0.5);
            let error = difference(&middle, &predicted.powers);
            self.interpolation.test(&predicted, error.abs() <= near);
            self.interpolation
                .remember(step.start + 0.5 * length, middle);
        }
        let external = [&at_start, &at_end].map(|powers| powers.totals()[1]);
        let external = self.external.in_the_middle(step, external);
        if !along_path {
            middle = middle.with_external(external);
        }
        let simpson = [at_start, middle, at_end];
        let accepted = || ACCEPTED_ERROR * scale.max(decisive(&middle));
        // There are always three or more.
        self.powers.truncate(simpson.len());
        self.powers.copy_from_slice(&simpson);
        let mut mean = simpson_mean(&simpson);
        let is_accurate = |before| error_of_half(simpson, before).abs() <= accepted();
        let mut accurate = is_predicted || before.is_some_and(is_accurate);
        let mut panels = 1;
        while panels < self.fineness || (self.fineness == 0 && !accurate && panels < MOST_PANELS) {
            panels *= 2;
            self.powers.resize(2 * panels + 1, at_end);
            for i in (0..panels).rev() {
                self.powers[2 * i] = self.powers[i];
                let part = (2 * i + 1) as f64 / (2 * panels) as f64;
                let mut power = powers_at(part);
                if !along_path {
                    power = power.with_external(parabola(simpson, part).totals()[1]);
                }
                self.powers[2 * i + 1] = power;
            }
            let finer = simpson_mean(&self.powers);
            // Of a smooth power, halved panels have a sixteenth of the error.
            accurate = difference(&finer, &mean).abs() / 15.0 <= accepted();
            mean = finer;
        }
        self.at_start = self.at_end;
        (self.start, self.end) = (step.start, step.end);
        self.at_end.add_scaled(length, &mean);
        self.metered_time += length;
        self.exchanged += decisive(&mean) * length;
    }

    /// Return the mean of the [`decisive`] power in all steps before \[W\].
    fn mean_power(&self) -> f64 {
        if self.metered_time > 0.0 {
            self.exchanged / self.metered_time
        } else {
            0.0
        }
    }

    /// Return the number of panels of the last step.
    fn panels(&self) -> usize {
        self.powers.len() / 2
    }

    /// Count an evaluation at the end of a step.
    pub(crate) fn count_evaluation(&mut self) {
        self.evaluations += 1;
    }

    fn last_power(&self) -> P {
        self.powers.last().copied().unwrap_or_default()
    }

    /// Return the dissipated energy and the external work at `t` inside the last step \[J\].
    pub(crate) fn energies(&self, t: f64) -> P {
        if t >= self.end || self.end <= self.start {
            let mut sum = self.at_end;
            sum.add_scaled(t - self.end, &self.last_power());
            return sum;
        }
        let mut sum = self.at_start;
        let width = (self.end - self.start) / self.panels() as f64;
        for panel in 0..self.panels() {
            let x = ((t - self.start) / width - panel as f64).clamp(0.0, 1.0);
            let powers = &self.powers[2 * panel..];
            // The integral of the parabola through the three powers from 0 to x.
            sum.add_scaled(width * x * (1.0 + x * (-1.5 + x * (2.0 / 3.0))), &powers[0]);
            sum.add_scaled(width * x * x * (2.0 - x * (4.0 / 3.0)), &powers[1]);
            sum.add_scaled(width * x * x * (-0.5 + x * (2.0 / 3.0)), &powers[2]);
        }
        sum
    }
}

/// Return powers before a step, with their place in parts of it.
fn in_parts_of<'a, P>(step: &Step, (t, powers): &'a (f64, P)) -> (f64, &'a P) {
    ((t - step.start) / (step.end - step.start), powers)
}

/// Return the power that errors are compared with \[W\].
fn decisive<P: PowerSum>(power: &P) -> f64 {
    let [dissipated, external] = power.totals();
    dissipated.abs().max(EXTERNAL_SHARE * external.abs())
}

/// Return the mean of powers at equal distances by Simpson's rule.
#[inline]
fn simpson_mean<P: PowerSum>(powers: &[P]) -> P {
    // Most steps have one panel; their sums stay in registers.
    if let [start, middle, end] = powers {
        return P::combined([(1.0 / 6.0, start), (4.0 / 6.0, middle), (1.0 / 6.0, end)]);
    }
    let (last, mut sum) = (powers.len() - 1, P::default());
    for (i, power) in powers.iter().enumerate() {
        let weight = match i {
            i if i == 0 || i == last => 1.0,
            i if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        sum.add_scaled(weight / (3 * last) as f64, power);
    }
    sum
}

/// Return the difference of dissipated powers \[W\].
fn difference<P: PowerSum>(powers: &P, others: &P) -> f64 {
    powers.totals()[0] - others.totals()[0]
}

/// Return the powers at a place of the parabola through those at the start, in the middle and at the end of a step \[parts of it\].
fn parabola<P: PowerSum>(powers: [P; 3], place: f64) -> P {
    let weights = [
        (1.0 - place) * (1.0 - 2.0 * place),
        4.0 * place * (1.0 - place),
        place * (2.0 * place - 1.0),
    ];
    P::combined([0, 1, 2].map(|i| (weights[i], &powers[i])))
}

/// Return the error of the dissipated energy by Simpson's rule in half a step, over the length of the step. It follows from the powers at a
/// `place` before the step \[parts of it\].
///
/// The cubic through all four powers differs from the parabola of Simpson's rule by c x (x - 1/2) (x - 1). Its integral over the first half
/// of the step is c/64, and that over the second half is -c/64. The rule is wrong by as much where c is not the same in both halves.
fn error_of_half<P: PowerSum>(powers: [P; 3], (place, before): (f64, &P)) -> f64 {
    let length = 64.0 * place * (place - 0.5) * (place - 1.0);
    difference(before, &parabola(powers, place)) / length
}

#[cfg(test)]
mod tests;

//! Energy dissipated and worked in: powers integrated through each step along its path, finer than the steps themselves.
//!
//! The path is the cubic through values and slopes at both ends of the step, whatever the integrator's order.

#![allow(clippy::inline_always)] // what is not inlined into a kernel does not run with its instructions

use pulp::{Simd, WithSimd};
use serde::{Deserialize, Serialize};

use super::{Dynamics, Powers};
use crate::integrator::{Adams, Step};
use crate::math::simd::{Lanes, Numbers, load, padded_zeros, vectors, vectors_mut};

/// Inner points of the Gauss-Lobatto formula of four points, as parts of a panel; the others are its ends.
const INNER: [f64; 2] = [0.276_393_202_250_021, 0.723_606_797_749_979];

/// Weights of the four points, as parts of a panel.
const WEIGHTS: [f64; 4] = [1.0 / 12.0, 5.0 / 12.0, 5.0 / 12.0, 1.0 / 12.0];

/// Points of a panel without its first one, which is the last of the panel before.
const POINTS: usize = INNER.len() + 1;

/// The two sums of the energy balance, and the powers along the last step, for reports inside it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct EnergyMeter {
    /// Panels of a step in which no contact begins or ends; others have twice as many.
    fineness: usize,
    /// Panels of the last step.
    panels: usize,
    /// The last step \[s\].
    start: f64,
    end: f64,
    /// Energies at its start \[J\].
    at_start: Powers,
    /// Energies at its end \[J\].
    at_end: Powers,
    /// Powers at the points of its panels, from start to end \[W\].
    powers: Vec<Powers>,
    /// Evaluations of the right-hand side that metering took.
    evaluations: u64,
}

impl EnergyMeter {
    pub(super) fn new() -> Self {
        let mut meter = Self::default();
        meter.refine(1);
        meter
    }

    /// Divides every step from now on into `fineness` panels, or twice as many.
    pub(super) fn refine(&mut self, fineness: usize) {
        self.fineness = fineness.max(1);
        let most = POINTS * 2 * self.fineness + 1;
        self.powers.reserve(most.saturating_sub(self.powers.len()));
        self.begin(self.end, self.last_power());
    }

    /// Goes on at `t` with `powers`, which are taken to have been the same before.
    pub(super) fn begin(&mut self, t: f64, powers: Powers) {
        (self.start, self.end) = (t, t);
        self.at_start = self.at_end;
        self.lay_out(self.fineness, powers);
    }

    /// Forgets what came after `t` inside the last step.
    pub(super) fn cut(&mut self, t: f64) {
        self.at_end = self.energies(t);
        self.end = t;
    }

    /// Makes room for the powers of a step of `panels`, the first one that of its start.
    fn lay_out(&mut self, panels: usize, at_start: Powers) {
        self.panels = panels;
        self.powers.clear();
        self.powers.resize(POINTS * panels + 1, at_start);
    }

    /// Whether it can stand in the place of `other`.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        self.fineness == other.fineness
            && self.powers.len() == POINTS * self.panels + 1
            && (self.panels == self.fineness || self.panels == 2 * self.fineness)
            && self.start <= self.end
    }

    /// Becomes what `other` is, within its own room.
    pub(super) fn carry_on(&mut self, other: &Self) {
        let mut powers = std::mem::take(&mut self.powers);
        powers.clear();
        powers.extend_from_slice(&other.powers);
        *self = Self {
            powers,
            ..other.clone()
        };
    }

    /// Panels of a step in which no contact begins or ends.
    pub(super) fn fineness(&self) -> usize {
        self.fineness
    }

    /// Evaluations of the right-hand side that metering took.
    pub(super) fn evaluations(&self) -> u64 {
        self.evaluations
    }

    fn last_power(&self) -> Powers {
        self.powers.last().copied().unwrap_or_default()
    }

    /// Energies dissipated and worked in at `t` inside the last step \[J\].
    pub(super) fn energies(&self, t: f64) -> Powers {
        if t >= self.end || self.end <= self.start {
            return self.at_end + (t - self.end) * self.last_power();
        }
        let width = (self.end - self.start) / self.panels as f64;
        let place = ((t - self.start) / width).max(0.0);
        let mut sum = self.at_start;
        for (panel, powers) in self.powers.windows(POINTS + 1).step_by(POINTS).enumerate() {
            let part = (place - panel as f64).clamp(0.0, 1.0);
            sum += width * integral_to(part, powers);
        }
        sum
    }
}

/// Integral of the cubic through the powers of a panel from its start to a `part` of it, for a panel of length one.
fn integral_to(part: f64, powers: &[Powers]) -> Powers {
    if part >= 1.0 {
        return whole(powers);
    }
    let points = [0.0, INNER[0], INNER[1], 1.0];
    // The formula's own points, moved into the part: it is exact for what is interpolated there.
    let mut sum = Powers::default();
    for (point, weight) in points.into_iter().zip(WEIGHTS) {
        let x = part * point;
        for (i, &power) in powers.iter().enumerate() {
            let others = (0..points.len()).filter(|&j| j != i);
            let basis: f64 = others
                .map(|j| (x - points[j]) / (points[i] - points[j]))
                .product();
            sum += part * weight * basis * power;
        }
    }
    sum
}

fn whole(powers: &[Powers]) -> Powers {
    let mut sum = Powers::default();
    for (&power, weight) in powers.iter().zip(WEIGHTS) {
        sum += weight * power;
    }
    sum
}

/// Values and slopes at both ends of a step: what the path inside it is interpolated from.
#[derive(Debug, Clone)]
pub(super) struct StepEnds {
    y: Numbers,
    slope: Numbers,
    end: Numbers,
    end_slope: Numbers,
}

impl StepEnds {
    pub(super) fn new(dimension: usize) -> Self {
        let zeros = || padded_zeros(dimension);
        Self {
            y: zeros(),
            slope: zeros(),
            end: zeros(),
            end_slope: zeros(),
        }
    }

    /// Takes `y` and its `slope` as the start of the next step.
    pub(super) fn begin(&mut self, y: &[f64], slope: &[f64]) {
        self.y[..y.len()].copy_from_slice(y);
        self.slope[..slope.len()].copy_from_slice(slope);
    }

    /// Makes a component of the start of the next step zero.
    pub(super) fn reset_component(&mut self, component: usize) {
        (self.y[component], self.slope[component]) = (0.0, 0.0);
    }

    /// Takes where `adams` is as the end of the step.
    fn end(&mut self, adams: &Adams) {
        let y = adams.y();
        self.end[..y.len()].copy_from_slice(y);
        adams.write_slope(&mut self.end_slope[..y.len()]);
    }

    /// The end of this step is the start of the next one.
    fn advance(&mut self) {
        std::mem::swap(&mut self.y, &mut self.end);
        std::mem::swap(&mut self.slope, &mut self.end_slope);
    }
}

/// The cubic through values and slopes at both ends of a step, at a `part` of its `length` \[s\].
struct Between<'a> {
    ends: &'a StepEnds,
    part: f64,
    length: f64,
    y: &'a mut [f64],
}

impl WithSimd for Between<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (part, rest) = (self.part, 1.0 - self.part);
        let splat = |value| Lanes::splat(simd, value);
        let from = splat((1.0 + 2.0 * part) * rest * rest);
        let from_slope = splat(self.length * part * rest * rest);
        let to_slope = splat(-self.length * part * part * rest);
        let blocks = self.y.len() / S::F64_LANES;
        let StepEnds {
            y,
            slope,
            end,
            end_slope,
        } = self.ends;
        let ends = [y, end].map(|y| vectors::<S>(y, blocks));
        let slopes = [slope, end_slope].map(|slope| vectors::<S>(slope, blocks));
        let y = vectors_mut::<S>(self.y, blocks);
        for b in 0..blocks {
            let [start, end] = ends.map(|y| load(simd, &y[b]));
            let [rise, fall] = slopes.map(|slope| load(simd, &slope[b]));
            let bend = rise.mul_add(from_slope, fall * to_slope);
            y[b] = (from.mul_add(start - end, end) + bend).values();
        }
    }
}

impl Dynamics {
    /// Keeps energy and lets its sums grow from the present state of `adams` on.
    pub fn begin_metering(&mut self, adams: &Adams) {
        self.keep_energy(true);
        self.differentiate(adams.time(), adams.y());
        self.meter.begin(adams.time(), self.powers);
        self.resume_metering(adams);
    }

    /// Takes the present state of `adams` as the start of the next step, when energy is kept.
    pub(crate) fn resume_metering(&mut self, adams: &Adams) {
        if !self.keeps_energy {
        } else if !adams.is_starting() {
            self.ends.end(adams);
            self.ends.advance();
        } else {
            // The integrator has no slope before its first step from a start.
            self.differentiate(adams.time(), adams.y());
            self.ends.begin(adams.y(), &self.slope);
        }
    }

    /// Adds the energies of the step just made, when they are kept; call after [`Self::finish_step`] and after all that looks at
    /// the contacts at the step's end, which are not the last ones evaluated any more.
    pub fn meter_step(&mut self, adams: &Adams, step: &Step) {
        if !self.keeps_energy {
            return;
        }
        let mut meter = std::mem::take(&mut self.meter);
        let mut y = std::mem::take(&mut self.inside);
        let mut slope = std::mem::take(&mut self.slope);
        self.ends.end(adams);
        let length = step.end - step.start;
        // Where a contact begins or ends, power has a kink.
        let panels = meter.fineness * (1 + usize::from(self.kernels.changed()));
        if adams.evaluation_differs_from_solution() {
            let coordinates = self.model.coordinates;
            self.accelerate(step.end, adams.y(), &mut slope[coordinates..]);
            meter.evaluations += 1;
        }
        let at_end = self.powers;
        meter.lay_out(panels, meter.last_power());
        for (i, powers) in meter.powers[1..].iter_mut().enumerate() {
            let (panel, point) = (i / POINTS, i % POINTS);
            let place = INNER.get(point).map_or(1.0, |inner| *inner) + panel as f64;
            *powers = if i + 1 == POINTS * panels {
                at_end
            } else {
                let part = place / panels as f64;
                self.kernels.instructions().run(Between {
                    ends: &self.ends,
                    part,
                    length,
                    y: &mut y,
                });
                let t = step.start + part * length;
                let coordinates = self.model.coordinates;
                self.accelerate(t, &y[..slope.len()], &mut slope[coordinates..]);
                meter.evaluations += 1;
                self.powers
            };
        }
        self.ends.advance();
        let width = length / panels as f64;
        meter.at_start = meter.at_end;
        (meter.start, meter.end) = (step.start, step.end);
        for powers in meter.powers.windows(POINTS + 1).step_by(POINTS) {
            meter.at_end += width * whole(powers);
        }
        (self.meter, self.inside, self.slope) = (meter, y, slope);
        self.powers = at_end;
    }

    /// Energies dissipated and worked in while they were kept, at `t` inside the last step \[J\].
    #[must_use]
    pub fn energies_passed(&self, t: f64) -> Powers {
        self.meter.energies(t)
    }

    /// Divides each step into `fineness` panels for metering, one at first, and those in which contacts begin or end into twice as
    /// many: what changes with it is the meter's own error.
    pub fn refine_meter(&mut self, fineness: usize) {
        self.meter.refine(fineness);
    }

    /// Evaluations of the right-hand side that metering took.
    #[must_use]
    pub fn meter_evaluations(&self) -> u64 {
        self.meter.evaluations()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A meter over one step of 0 to 2 s with `panels`, in which the power dissipated is `power`.
    fn metered(panels: usize, power: impl Fn(f64) -> f64) -> EnergyMeter {
        let mut meter = EnergyMeter::new();
        meter.refine(panels);
        meter.lay_out(panels, Powers::default());
        meter.end = 2.0;
        let width = 2.0 / panels as f64;
        for panel in 0..panels {
            for (i, part) in [0.0, INNER[0], INNER[1], 1.0].into_iter().enumerate() {
                meter.powers[POINTS * panel + i] = Powers {
                    dissipated: power(width * (panel as f64 + part)),
                    worked_in: 1.0,
                    ..Powers::default()
                };
            }
        }
        for powers in meter.powers.windows(POINTS + 1).step_by(POINTS) {
            meter.at_end += width * whole(powers);
        }
        meter
    }

    #[test]
    fn a_power_of_degree_five_is_summed_exactly() {
        for panels in [1, 3] {
            let meter = metered(panels, |t| t.powi(5));
            let exact = 2f64.powi(6) / 6.0;
            assert!((meter.energies(2.0).dissipated - exact).abs() < 1e-13 * exact);
            assert!((meter.energies(2.0).worked_in - 2.0).abs() < 1e-14);
        }
    }

    #[test]
    fn inside_a_step_the_sum_is_that_of_a_cubic() {
        for panels in [1, 3] {
            let meter = metered(panels, |t| 1.0 + t.powi(3));
            for t in [0.0f64, 0.3, 1.0, 1.7, 2.0] {
                let exact = t + t.powi(4) / 4.0;
                assert!((meter.energies(t).dissipated - exact).abs() < 1e-13, "{t}");
            }
        }
    }
}

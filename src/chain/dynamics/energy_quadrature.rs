//! Energy dissipated and external work of a drive: powers along the path of each step.
//!
//! The path is the cubic through values and slopes at both ends of the step, whatever the integrator's order.

#![allow(clippy::inline_always)] // what is not inlined into a kernel does not run with its instructions

use pulp::{Simd, WithSimd};

use super::{Dynamics, Powers};
use crate::integrator::{Adams, Step};
use crate::math::simd::{Lanes, Numbers, load, padded_zeros, vectors, vectors_mut};

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

    /// Set `y` and its derivative `slope` as the start of the next step.
    pub(super) fn begin(&mut self, y: &[f64], slope: &[f64]) {
        self.y[..y.len()].copy_from_slice(y);
        self.slope[..slope.len()].copy_from_slice(slope);
    }

    /// Set a component of the start of the next step to zero.
    pub(super) fn reset_component(&mut self, component: usize) {
        (self.y[component], self.slope[component]) = (0.0, 0.0);
    }

    /// Return the derivative of a component at the start of the step.
    #[cfg(test)]
    pub(super) fn slope(&self, component: usize) -> f64 {
        self.slope[component]
    }

    /// Set the end of the step to the present state of `adams`.
    fn end(&mut self, adams: &Adams) {
        let y = adams.y();
        self.end[..y.len()].copy_from_slice(y);
        adams.write_slope(&mut self.end_slope[..y.len()]);
    }

    /// Set the end of this step as the start of the next one.
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
    /// Divide each step into `fineness` panels from now on, a power of two; 0: as many as the powers need.
    pub(crate) fn refine_quadrature(&mut self, fineness: usize) {
        self.quadrature.refine(fineness);
    }

    /// Switch the energy quadrature on; the sums start at the present state of `adams`.
    pub(super) fn begin_energy_quadrature(&mut self, adams: &Adams) {
        self.keep_energy(true);
        self.differentiate(adams.time(), adams.y());
        self.quadrature.begin(adams.time(), self.powers);
        self.resume_energy_quadrature(adams);
    }

    /// Set the present state of `adams` as the start of the next step, while energy is kept.
    pub(super) fn resume_energy_quadrature(&mut self, adams: &Adams) {
        if !self.keeps_energy {
        } else if !adams.is_starting() {
            self.ends.end(adams);
            self.ends.advance();
        } else {
            // The integrator has no slope before its first step from a start. Powers and slopes may have jumped at an input's kink.
            self.differentiate(adams.time(), adams.y());
            self.quadrature.begin(adams.time(), self.powers);
            self.ends.begin(adams.y(), &self.slope);
        }
    }

    /// Change the powers of the last evaluation, which wrote slopes, to those at (`t`, `y`), and return them. `y` is the evaluated state after
    /// the last correction of the velocities with γ.
    pub fn correct_powers(
        &mut self,
        (t, y): (f64, &[f64]),
        (gamma, correction): (f64, &[f64]),
    ) -> Powers {
        let border = &correction[3 * self.model.links..self.model.coordinates];
        let (end, correction) = ((t, y), (gamma, border));
        self.powers = (self.kernels).corrected_powers(&self.model, &self.powers, end, correction);
        self.powers
    }

    /// Return the powers at (`t`, `y`); `rates` is scratch for the rates of bristles.
    fn powers_at(&mut self, t: f64, y: &[f64], rates: &mut [f64]) -> Powers {
        (self.kernels).powers(&self.model, &self.memory, t, y, rates)
    }

    /// Return whether the slopes of all powers are known: damped contacts of hinges and teeth alone.
    fn has_power_slopes(&self) -> bool {
        let model = &self.model;
        !model.has_moments() && model.rollers.is_none() && model.ends.is_none()
    }

    /// Add the energies of the last step, while energy is kept. Call it last: it evaluates the right-hand side inside the step, so that the
    /// contacts of the last evaluation are then not those of the step's end.
    ///
    /// [`Self::finish_step`] has stored new impact velocities: powers inside this step use them, the forces of the step used the present
    /// rates.
    pub(super) fn add_energies_of_step(&mut self, adams: &Adams, step: &Step) {
        if !self.keeps_energy {
            return;
        }
        // Evaluations inside the step come after this: the answer is that of the step's last one.
        let smooth = !self.kernels.changed();
        let mut quadrature = std::mem::take(&mut self.quadrature);
        let mut y = std::mem::take(&mut self.inside);
        let mut slope = std::mem::take(&mut self.slope);
        self.ends.end(adams);
        let length = step.end - step.start;
        let coordinates = self.model.coordinates;
        if let Some((gamma, correction)) = adams.correction_after_evaluation() {
            if smooth && self.has_power_slopes() {
                self.correct_powers((step.end, adams.y()), (gamma, correction));
            } else {
                self.powers = self.powers_at(step.end, adams.y(), &mut slope[coordinates..]);
                quadrature.count_evaluation();
            }
        }
        let at_end = self.powers;
        quadrature.add_step(step, (at_end, smooth), |part, t| {
            self.kernels.instructions().run(Between {
                ends: &self.ends,
                part,
                length,
                y: &mut y,
            });
            self.powers_at(t, &y[..slope.len()], &mut slope[coordinates..])
        });
        self.ends.advance();
        (self.quadrature, self.inside, self.slope) = (quadrature, y, slope);
        self.powers = at_end;
    }
}

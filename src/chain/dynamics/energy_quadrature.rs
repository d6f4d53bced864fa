//! Energy quadrature of a drive: dissipated energy and external work from the powers along the path of each step.
//!
//! The path is the cubic Hermite interpolant of values and slopes at both ends of the step, independent of the integrator's order
//! (decision 22).

#![allow(clippy::inline_always)] // a function that is not inlined into a kernel is not compiled for the kernel's instruction set

use pulp::{Simd, WithSimd};

use super::Dynamics;
use crate::integrator::{Adams, Step};
use crate::math::simd::{Lanes, Numbers, load, padded_zeros, vectors, vectors_mut};
use crate::system::PanelRule;

/// Highest order of a step whose powers are integrated by Simpson's rule.
///
/// Its error of order five is far below that of the trapezoidal rule. Steps of higher orders are longer and use the Gauss-Lobatto formula
/// of four points (decision 22).
const HIGHEST_ORDER_OF_SIMPSON: usize = 2;

/// Values and slopes at both ends of a step: data of the interpolation inside it.
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

    /// Set `y` and its `slope` as the start of the next step.
    pub(super) fn begin(&mut self, y: &[f64], slope: &[f64]) {
        self.y[..y.len()].copy_from_slice(y);
        self.slope[..slope.len()].copy_from_slice(slope);
    }

    /// Set a component of the start of the next step to zero.
    pub(super) fn reset_component(&mut self, component: usize) {
        (self.y[component], self.slope[component]) = (0.0, 0.0);
    }

    /// Set the present state of `adams` as the end of the step.
    fn end(&mut self, adams: &Adams) {
        let y = adams.y();
        self.end[..y.len()].copy_from_slice(y);
        adams.write_slope(&mut self.end_slope[..y.len()]);
    }

    /// Make the end of this step the start of the next one.
    fn advance(&mut self) {
        std::mem::swap(&mut self.y, &mut self.end);
        std::mem::swap(&mut self.slope, &mut self.end_slope);
    }
}

/// Kernel: cubic Hermite interpolant of a step of `length` h \[s\] at the relative position `part` p.
///
/// y = (1 + 2p)(1 - p)² (y0 - y1) + y1 + h p (1 - p)² y0' - h p² (1 - p) y1'.
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
    /// Set the number of panels in each section of a step.
    pub(crate) fn refine_quadrature(&mut self, fineness: usize) {
        self.quadrature.refine(fineness);
    }

    /// Switch energy metering on and start the energy quadrature at the present state of `adams`.
    pub(super) fn begin_energy_quadrature(&mut self, adams: &Adams) {
        self.keep_energy(true);
        self.differentiate(adams.time(), adams.y());
        self.quadrature.begin(adams.time(), self.powers);
        self.resume_energy_quadrature(adams);
    }

    /// Set the present state of `adams` as the start of the next step, with energy metering on.
    pub(super) fn resume_energy_quadrature(&mut self, adams: &Adams) {
        if !self.keeps_energy {
        } else if !adams.is_starting() {
            self.ends.end(adams);
            self.ends.advance();
        } else {
            // Before its first step after a start, the integrator has no slope.
            self.differentiate(adams.time(), adams.y());
            self.ends.begin(adams.y(), &self.slope);
        }
    }

    /// Add the energies of the last step, with energy metering on.
    ///
    /// Call after [`Self::finish_step`] and after all uses of the contacts at the end of the step: the quadrature evaluates other states.
    pub(super) fn add_energies_of_step(&mut self, adams: &Adams, step: &Step) {
        if !self.keeps_energy {
            return;
        }
        let mut quadrature = std::mem::take(&mut self.quadrature);
        let mut y = std::mem::take(&mut self.inside);
        let mut slope = std::mem::take(&mut self.slope);
        self.ends.end(adams);
        let length = step.end - step.start;
        // Power has a kink at a contact onset or end. With many contacts these times are not located for the quadrature: the step is
        // divided at its middle.
        let kinks: &[f64] = if self.kernels.changed() { &[0.5] } else { &[] };
        let rule = if step.order <= HIGHEST_ORDER_OF_SIMPSON {
            PanelRule::SIMPSON
        } else {
            PanelRule::LOBATTO
        };
        let coordinates = self.model.coordinates;
        if adams.evaluation_differs_from_solution() {
            // The last evaluation was at the predicted value: the powers at the end of the step need another one (decision 22).
            self.accelerate(step.end, adams.y(), &mut slope[coordinates..]);
            quadrature.count_evaluation();
        }
        let at_end = self.powers;
        quadrature.add_step(step, (&rule, kinks), at_end, |part, t| {
            self.kernels.instructions().run(Between {
                ends: &self.ends,
                part,
                length,
                y: &mut y,
            });
            self.accelerate(t, &y[..slope.len()], &mut slope[coordinates..]);
            self.powers
        });
        self.ends.advance();
        (self.quadrature, self.inside, self.slope) = (quadrature, y, slope);
        self.powers = at_end;
    }
}

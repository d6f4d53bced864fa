//! Energy dissipated and external work of a drive: powers along the path of each step.
//!
//! The path is the cubic through values and slopes at both ends of the step, whatever the integrator's order.

#![allow(clippy::inline_always)] // what is not inlined into a kernel does not run with its instructions

use pulp::{Simd, WithSimd};

use super::Dynamics;
use crate::chain::rhs::{Inside, PathTracer};
use crate::integrator::{Adams, Step};
use crate::math::Hermite;
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

    /// Component `i` between both ends.
    fn at(&self, cubic: &Hermite<f64>, i: usize) -> f64 {
        cubic.at([self.y[i], self.slope[i]], [self.end[i], self.end_slope[i]])
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
        let cubic = Hermite::<Lanes<S>>::new(simd, self.part, self.length);
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
            let start = [load(simd, &ends[0][b]), load(simd, &slopes[0][b])];
            let end = [load(simd, &ends[1][b]), load(simd, &slopes[1][b])];
            y[b] = cubic.at(start, end).values();
        }
    }
}

impl Dynamics {
    /// Divides each section of a step into `fineness` panels from now on, with powers from evaluations of the right-hand side.
    pub(crate) fn refine_quadrature(&mut self, fineness: usize) {
        self.quadrature.refine(fineness);
        self.tracer = None;
    }

    /// Keeps energy and lets its sums grow from the present state of `adams` on.
    pub(super) fn begin_energy_quadrature(&mut self, adams: &Adams) {
        self.keep_energy(true);
        self.differentiate(adams.time(), adams.y());
        self.quadrature.begin(adams.time(), self.powers);
        self.resume_energy_quadrature(adams);
        self.trace_start(adams.time());
    }

    /// Takes the present state of `adams` as the start of the next step, when energy is kept.
    pub(super) fn resume_energy_quadrature(&mut self, adams: &Adams) {
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

    /// Takes the contacts at the start of the next step, which begins at `t` \[s\], as those of its start.
    pub(super) fn trace_start(&mut self, t: f64) {
        if let Some(tracer) = &mut self.tracer {
            let (y, slope) = (&self.ends.y, &self.ends.slope);
            let state = (t, &y[..self.slope.len()], &slope[..self.slope.len()]);
            self.kernels
                .trace(&self.model, &self.memory.pawls, state, false, tracer);
            tracer.advance();
        }
    }

    /// Adds the energies of the step just made, when they are kept; call after [`Self::finish_step`] and after all that looks at
    /// the contacts at the step's end, which are not the last ones evaluated any more.
    pub(super) fn add_energies_of_step(&mut self, adams: &Adams, step: &Step) {
        if !self.keeps_energy {
            return;
        }
        self.ends.end(adams);
        // Contacts are many: where in the step one began or ended is not located for the quadrature.
        let kinks: &[f64] = if self.kernels.changed() { &[0.5] } else { &[] };
        if let Some(mut tracer) = self.tracer.take() {
            self.integrate_along_paths(adams, &mut tracer, step, kinks);
            self.tracer = Some(tracer);
        } else {
            self.integrate_evaluations(adams, step, kinks);
        }
        self.ends.advance();
    }

    /// Adds the energies of a step from the paths of its contacts.
    fn integrate_along_paths(
        &mut self,
        adams: &Adams,
        tracer: &mut PathTracer,
        step: &Step,
        kinks: &[f64],
    ) {
        let (model, memory, ends) = (&self.model, &self.memory, &self.ends);
        let (length, dimension) = (step.end - step.start, self.slope.len());
        let state = (
            step.end,
            &ends.end[..dimension],
            &ends.end_slope[..dimension],
        );
        let nearby = adams.evaluation_differs_from_solution();
        self.kernels
            .trace(model, &memory.pawls, state, nearby, tracer);
        let powers_at = |part: f64, t: f64| {
            let inside = Inside { part, length, t };
            let cubic = Hermite::new((), part, length);
            let value = |i: usize| (ends.at(&cubic, i), ends.at(&cubic, model.coordinates + i));
            self.kernels
                .powers_inside(model, memory, tracer, inside, value)
        };
        self.powers = powers_at(1.0, step.end);
        self.quadrature
            .add_step(step, kinks, self.powers, powers_at);
        tracer.advance();
    }

    /// Adds the energies of a step from evaluations of the right-hand side inside it.
    fn integrate_evaluations(&mut self, adams: &Adams, step: &Step, kinks: &[f64]) {
        let mut quadrature = std::mem::take(&mut self.quadrature);
        let mut y = std::mem::take(&mut self.inside);
        let mut slope = std::mem::take(&mut self.slope);
        let length = step.end - step.start;
        let coordinates = self.model.coordinates;
        let mut evaluations = 0;
        if adams.evaluation_differs_from_solution() {
            self.accelerate(step.end, adams.y(), &mut slope[coordinates..]);
            evaluations += 1;
        }
        let at_end = self.powers;
        quadrature.add_step(step, kinks, at_end, |part, t| {
            self.kernels.instructions().run(Between {
                ends: &self.ends,
                part,
                length,
                y: &mut y,
            });
            self.accelerate(t, &y[..slope.len()], &mut slope[coordinates..]);
            evaluations += 1;
            self.powers
        });
        quadrature.count_evaluations(evaluations);
        (self.quadrature, self.inside, self.slope) = (quadrature, y, slope);
        self.powers = at_end;
    }
}

//! Energy dissipated and external work of a drive: powers at the ends of each step and along its path.
//!
//! The path is the cubic through values and slopes at both ends of the step, whatever the integrator's order.

use super::Dynamics;
use crate::chain::model::{Model, Rotation};
use crate::integrator::{Adams, Step};

/// Largest difference of a prescribed speed in the middle of a step from the mean of those at its ends, over the largest of the three, with
/// which external powers at both ends are enough. In longer steps the power is bent as the speed is, which the path shows.
const STRAIGHT: f64 = 1e-3;

/// Return whether all prescribed speeds, of sprockets and of ends, are nearly straight in a step.
fn has_straight_speeds(model: &Model, step: &Step) -> bool {
    let is_straight = |speed: &dyn Fn(f64) -> f64| {
        let [start, middle, end] =
            [0.0, 0.5, 1.0].map(|part| speed(step.start + part * (step.end - step.start)));
        let largest = start.abs().max(middle.abs()).max(end.abs());
        (middle - 0.5 * (start + end)).abs() <= STRAIGHT * largest
    };
    let sprockets = model
        .sprockets
        .iter()
        .all(|sprocket| match &sprocket.rotation {
            Rotation::Prescribed(speed) => is_straight(&|t| speed.value(t)),
            Rotation::Free { .. } => true,
        });
    let mut ends = model.ends.iter().flat_map(|ends| &ends.bodies);
    sprockets
        && ends.all(|end| {
            let velocity = |t| end.given_velocity(t).unwrap_or_default();
            is_straight(&|t| velocity(t).x) && is_straight(&|t| velocity(t).y)
        })
}

impl Dynamics {
    /// Divide each step into `fineness` panels from now on, a power of two; 0: as many as the powers need.
    pub(crate) fn refine_quadrature(&mut self, fineness: usize) {
        self.quadrature.refine(fineness);
    }

    /// Switch the energy quadrature on; the sums start at `now`, the end of the last step of `adams` or a time within it.
    pub(super) fn begin_energy_quadrature(&mut self, adams: &Adams, now: f64) {
        self.keep_energy(true);
        let end = adams.time();
        self.differentiate(end, adams.y());
        let at_end = self.powers(end, adams.y());
        self.quadrature.begin(end, at_end);
        if now >= end {
            return;
        }
        // The rest of the step, along the dense output, which the rows within it use, too.
        let (model, memory, y) = (&self.model, &self.memory, &mut self.inside);
        let (dimension, rates) = (self.slope.len(), &mut self.slope[model.coordinates..]);
        let kernels = &mut self.kernels;
        let mut powers_at = |t: f64| {
            adams.interpolate(t, &mut y[..dimension]);
            kernels.powers(model, memory, t, &y[..dimension], rates)
        };
        self.quadrature.begin(now, powers_at(now));
        let rest = Step {
            start: now,
            end,
            degree: 1,
        };
        (self.quadrature).add_step(&rest, at_end, true, |_, t| powers_at(t));
    }

    /// Begin the next step with the powers at the present state of `adams`, while energy is kept: they may have jumped at a start.
    pub(super) fn resume_energy_quadrature(&mut self, adams: &Adams) {
        if self.keeps_energy && adams.is_starting() {
            self.begin_energy_quadrature(adams, adams.time());
        }
    }

    /// Change the powers of the last evaluation, which wrote slopes, and the `forces` if wanted, to those after the last correction of the
    /// velocities with γ.
    pub fn correct_powers(&mut self, correction: (f64, &[f64]), forces: bool) {
        let (kernels, model) = (&mut self.kernels, &self.model);
        if forces {
            kernels.correct_powers::<true>(model, correction);
        } else {
            kernels.correct_powers::<false>(model, correction);
        }
    }

    /// Return whether forces and powers at the end of a step follow from its last correction: those of damped contacts and of plates in series
    /// with them by their slopes, and regularised friction by its law.
    fn follows_from_correction(&self) -> bool {
        let model = &self.model;
        let bristles = model.hinges.bristles.is_some() || model.teeth.bristles.is_some();
        !bristles && model.hinges.film.is_none() && model.ends.is_none()
    }

    /// Return whether the powers at the end of a step with several corrections follow from the last one.
    pub(super) fn corrects_powers_after_several(&self) -> bool {
        let model = &self.model;
        self.follows_from_correction() && model.rollers.is_none() && !model.has_friction()
    }

    /// Find the powers at the end of the last step, where energy is kept, and change the forces of the last evaluation to those at the end
    /// where `peaks` are recorded.
    ///
    /// Both follow from the last evaluation and the correction after it. After several corrections forces are evaluated: at loose
    /// accuracies the last correction can change a force by several times its value. Powers are not, whose errors cancel in part, but where
    /// rollers are bodies or there is friction (decision 22). After a projection of ideal hinges, which moves them, both are evaluated.
    ///
    /// Call it after [`Self::finish_step`], which reads the contacts of the last evaluation. That stores new impact velocities: evaluations
    /// from here on use them, the forces of the step used the present rates.
    pub(super) fn reach_end_of_step(&mut self, adams: &Adams, step: &Step, peaks: bool) {
        let keeps = self.keeps_energy;
        let correction = adams.correction_after_evaluation();
        let first_is_last = adams.ended_with_first_correction();
        let projected = self.projects_hinges(adams);
        let forces_change = self.follows_from_correction() && first_is_last && !projected;
        let powers_change = forces_change || (self.corrects_powers_after_several() && !projected);
        let end = (step.end, adams.y());
        match correction {
            Some(correction) if (keeps && powers_change) || (peaks && forces_change) => {
                self.correct_powers(correction, peaks && forces_change);
            }
            Some(_) if keeps => {
                self.quadrature.count_evaluation();
                self.evaluate_end_of_step(end, peaks && !first_is_last);
            }
            _ => {}
        }
        if keeps {
            self.power_at_end = self.kernels.last_powers(&self.model, step.end, adams.y());
        }
        let evaluated = correction.is_none() || (keeps && !powers_change);
        if peaks && !evaluated && !forces_change {
            self.evaluate_end_of_step(end, !first_is_last);
        }
    }

    /// Evaluate forces and powers at the end of a step, (`t`, `y`). Forces of ideal hinges stay those of the last correction, unless they are to
    /// be solved for.
    fn evaluate_end_of_step(&mut self, (t, y): (f64, &[f64]), solves: bool) {
        if solves && self.model.hinges.ideal {
            // They follow from the accelerations. The next step begins with those of the last correction all the same.
            self.differentiate(t, y);
            return;
        }
        let rates = &mut self.slope[self.model.coordinates..];
        (self.kernels).powers(&self.model, &self.memory, t, y, rates);
        self.kernels.return_to_step_end();
    }

    /// Add the energies of the last step, while energy is kept. Call it last: it evaluates the right-hand side inside the step, so that the
    /// contacts of the last evaluation are then not those of the step's end.
    pub(super) fn add_energies_of_step(&mut self, adams: &Adams, step: &Step) {
        if !self.keeps_energy {
            return;
        }
        let (model, memory, y) = (&self.model, &self.memory, &mut self.inside);
        let (dimension, rates) = (self.slope.len(), &mut self.slope[model.coordinates..]);
        // `rates` is scratch for the rates of bristles.
        let kernels = &mut self.kernels;
        let along_path = !has_straight_speeds(model, step);
        (self.quadrature).add_step(step, self.power_at_end, along_path, |part, t| {
            adams.write_cubic(part, y);
            kernels.powers(model, memory, t, &y[..dimension], rates)
        });
    }
}

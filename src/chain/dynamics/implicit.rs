//! Interface of the dynamics to the implicit corrector (Newton's method).

use std::ops::Range;

use super::Dynamics;
use crate::integrator::{
    LENGTH_ERROR_OF_FULL_DEFLECTION, OdeSystem, SAFETY_AT_CONTACT_CHANGE, SPEED_PER_LENGTH,
    SecondOrderSystem,
};

/// Accuracy over the permitted error of links on ideal hinges.
///
/// An error of one link moves its whole strand, and counts more in the energies than a vibration in a clearance (decision 46). Doubled: a
/// quarter more steps, and 0.6 to 0.7 of the residual of the energy balance.
const IDEAL_HINGES: f64 = 2.0;

impl Dynamics {
    /// Allocate the arrays of the implicit corrector.
    pub fn make_room_for_newton(&mut self) {
        self.kernels.make_room_for_newton(&self.model);
    }

    /// Write the derivative with the slopes for the matrix. Unlike evaluations of the implicit corrector, this one solves for the forces of
    /// ideal hinges.
    pub(crate) fn derivative_with_slopes(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        self.make_room_for_newton();
        self.kernels.write_slopes(true);
        self.derivative(t, y, dydt);
        self.kernels.write_slopes(false);
    }

    /// Write the accelerations at an iterate of Newton's method, and the slopes of all forces if they are wanted.
    fn accelerate_iterate(&mut self, t: f64, y: &[f64], dydt: &mut [f64], with_slopes: bool) {
        self.kernels.take_hinge_forces(true);
        self.kernels.write_slopes(with_slopes);
        self.accelerate(t, y, &mut dydt[self.model.coordinates..]);
        self.kernels.write_slopes(false);
    }

    /// Factorise the matrix of the last evaluation with slopes, M - γ dQ/dv - γ² dQ/dq, which may be indefinite.
    ///
    /// Return false for a singular matrix. There is no pivoting: corrections with a nearly singular matrix may be infinite.
    pub fn factorise_indefinite(&mut self, gamma: f64) -> bool {
        self.kernels
            .factorise(&self.model, &self.memory.pawls, gamma, true)
    }
}

impl SecondOrderSystem for Dynamics {
    fn coordinates(&self) -> usize {
        self.model.coordinates
    }

    fn counted(&self) -> usize {
        2 * self.model.used_coordinates
    }

    fn accelerations(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        let with_slopes = self.keeps_energy && self.corrects_powers_after_several();
        self.accelerate_iterate(t, y, dydt, with_slopes);
    }

    fn accelerations_with_slopes(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        self.make_room_for_newton();
        // Each attempt at a step begins with the same hinge forces, whatever a rejected one has found.
        self.kernels.return_to_step_end();
        self.accelerate_iterate(t, y, dydt, true);
    }

    fn contraction_safety_factor(&self) -> f64 {
        // Without the second correction the forces of ideal hinges have an error of one sign, whose work on a load is the residual.
        let pulls_loads = self.model.hinges.ideal && self.model.ends.is_some();
        // Where the first correction has changed the slope of a film, the force after it is unknown.
        let film_changes = self.kernels.film_slopes_changed()
            || (self.kernels.changed() && self.model.hinges.film.is_some());
        if pulls_loads || film_changes {
            f64::INFINITY
        } else if self.kernels.changed() {
            SAFETY_AT_CONTACT_CHANGE
        } else {
            1.0
        }
    }

    fn local_unknowns(&self) -> Range<usize> {
        self.model.bristles.all()
    }

    fn begin_implicit_stage(&mut self, stage: Option<(&[f64], f64)>) {
        self.kernels.set_bristle_stage(stage);
    }

    fn write_local_solution(&self, velocities: &mut [f64]) {
        velocities.copy_from_slice(self.kernels.solved_bristles());
    }

    /// The matrix is multiplied by the masses; [`Self::correct`] multiplies the residual by them, too.
    fn factorise(&mut self, _y: &[f64], gamma: f64) -> bool {
        self.kernels
            .factorise(&self.model, &self.memory.pawls, gamma, false)
    }

    fn correct(&mut self, residual: &mut [f64]) {
        // The evaluation has solved for the deflections of the bristles: their corrections are zero, as those of the padding.
        let (bodies, rest) = residual.split_at_mut(self.model.body_coordinates());
        self.kernels.correct(&self.model, bodies);
        rest.fill(0.0);
    }

    fn stiffness_residual(&self) -> Option<&[f64]> {
        self.kernels.residual_of_corrected_forces()
    }

    fn scale(&self, lengths: &mut [f64]) {
        let model = &self.model;
        let n = model.links;
        lengths.fill(1.0);
        lengths[2 * n..3 * n].fill(model.half_pitch);
        if model.hinges.ideal {
            for length in &mut lengths[..3 * n] {
                *length *= IDEAL_HINGES;
            }
        }
        if let Some(rollers) = &model.rollers {
            // The effect of a roller's error on the chain is its momentum: the permitted error is that of a link times the ratio of the
            // masses, m_link/m_roller, with the mean mass of the links.
            let chain = model.ends.as_ref().map_or(n, |ends| ends.links);
            let share = rollers.mass * chain as f64 / model.chain.mass[..chain].iter().sum::<f64>();
            lengths[rollers.first..].fill(share);
            lengths[rollers.first + 2 * n..].fill(share * model.teeth.contact_radius);
        }
        // The padding has no error.
        lengths[model.used_coordinates..].fill(0.0);
        let places = &model.bristles;
        for (range, law) in [
            (places.hinges.clone(), &model.hinges.bristles),
            (places.rollers.clone(), &model.hinges.bristles),
            (places.teeth.clone(), &model.teeth.bristles),
        ] {
            if let Some(law) = law {
                // Permitted error of z, as a part of the break-away deflection: the accuracy over LENGTH_ERROR_OF_FULL_DEFLECTION.
                lengths[range]
                    .fill(SPEED_PER_LENGTH * LENGTH_ERROR_OF_FULL_DEFLECTION / law.breakaway());
            }
        }
        for sprocket in &model.sprockets {
            if let crate::chain::model::Rotation::Free { index, .. } = sprocket.rotation {
                lengths[index] = sprocket.profile.pitch_radius;
            }
        }
    }
}

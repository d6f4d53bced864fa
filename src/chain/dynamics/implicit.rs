//! What Newton's method asks of the dynamics.

use std::ops::Range;

use super::Dynamics;
use crate::integrator::{SPEED_PER_LENGTH, SecondOrderSystem};

/// The error allowed to lengths is the share of it that is allowed to bristles bent to break-away \[m\]: 1e-10 m and a
/// thousandth. What they get wrong is a force, that of their share, and not a place.
const WHOLE_DEFLECTION: f64 = 1e-7;

/// How much faster than before corrections of a step in which a contact begins or ends are taken to grow with their size. In the published
/// drive at 0, 25 and 100 N, with rollers and without, one step in a thousand of those let go by this would have been measured otherwise.
const WHERE_CHANGED: f64 = 10.0;

impl Dynamics {
    /// Makes the room that the implicit corrector needs.
    pub fn make_room_for_newton(&mut self) {
        self.kernels.make_room_for_newton(&self.model);
    }

    /// Factorises the matrix of the last evaluation with slopes, M - γ dQ/dv - γ² dQ/dq, which may be indefinite; false when it is
    /// found singular. Pivots are not exchanged: corrections of a matrix that is nearly singular may be infinite.
    pub fn factorise_indefinite(&mut self, gamma: f64) -> bool {
        self.kernels
            .factorise(&self.model, &self.memory.pawls, gamma, true)
    }
}

impl SecondOrderSystem for Dynamics {
    fn coordinates(&self) -> usize {
        self.model.coordinates
    }

    fn accelerations(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        self.accelerate(t, y, &mut dydt[self.model.coordinates..]);
    }

    fn accelerations_with_slopes(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        self.make_room_for_newton();
        self.kernels.write_slopes(true);
        self.accelerations(t, y, dydt);
        self.kernels.write_slopes(false);
    }

    fn contraction_safety_factor(&self) -> f64 {
        if self.kernels.changed() && self.oscillates_at_order_two() {
            f64::INFINITY
        } else if self.kernels.changed() {
            WHERE_CHANGED
        } else {
            1.0
        }
    }

    fn oscillates_at_order_two(&self) -> bool {
        self.model.hinge_film.is_some()
    }

    fn local_unknowns(&self) -> Range<usize> {
        self.model.bristles.all()
    }

    fn begin_implicit_stage(&mut self, step: Option<(&[f64], f64)>) {
        self.kernels.solve_for_bristles(step);
    }

    fn write_local_solution(&self, velocities: &mut [f64]) {
        velocities.copy_from_slice(self.kernels.solved_bristles());
    }

    fn factorise(&mut self, _y: &[f64], gamma: f64) -> bool {
        self.kernels
            .factorise(&self.model, &self.memory.pawls, gamma, false)
    }

    fn correct(&mut self, residual: &mut [f64]) {
        let places = self.model.bristles.all();
        if places.is_empty() {
            self.kernels.correct(&self.model, residual);
            return;
        }
        // Evaluations have solved for the bristles.
        let (bodies, bristles) = residual.split_at_mut(places.start);
        self.kernels.correct(&self.model, bodies);
        bristles.fill(0.0);
    }

    fn scale(&self, lengths: &mut [f64]) {
        let model = &self.model;
        let n = model.links;
        lengths.fill(1.0);
        lengths[2 * n..3 * n].fill(model.half_pitch);
        if let Some(rollers) = &model.rollers {
            // What a roller's error passes on is its momentum: it may be larger than a link's as the roller is lighter.
            let chain = model.ends.as_ref().map_or(n, |ends| ends.links);
            let share = rollers.mass * chain as f64 / model.mass[..chain].iter().sum::<f64>();
            lengths[rollers.first..].fill(share);
            lengths[rollers.first + 2 * n..].fill(share * model.contact_radius);
        }
        let places = &model.bristles;
        for (range, law) in [
            (places.hinges.clone(), &model.hinge_bristles),
            (places.rollers.clone(), &model.hinge_bristles),
            (places.teeth.clone(), &model.tooth_bristles),
        ] {
            if let Some(law) = law {
                lengths[range].fill(SPEED_PER_LENGTH * WHOLE_DEFLECTION / law.breakaway());
            }
        }
        for sprocket in &model.sprockets {
            if let crate::chain::model::Rotation::Free { index, .. } = sprocket.rotation {
                lengths[index] = sprocket.profile.pitch_radius;
            }
        }
    }
}

//! Matrix of the implicit corrector: the linear system of 1 - γ ∂a/∂v - γ² ∂a/∂q with its constraints.
//!
//! With corrections x of the velocities and γ x of the coordinates, the equations of motion and the constraints change by
//!
//! ```text
//! (M - γ ∂f/∂v - γ² ∂f/∂q + γ² Σ λ ∂²c/∂q²) x + Gᵀ μ = M r
//! (G + 2 γ ∂²c/∂q² v + γ² (∂(v ∂²c/∂q² v)/∂q + ∂²c/∂q² a)) x = G r
//! ```
//!
//! for a residual r of the velocities. All derivatives are exact except those of callables; the second derivative of the weight of a
//! contact that fades out is omitted.

use std::ops::Range;

use nalgebra::{DMatrix, DVectorViewMut, Dyn, LU};

use super::implicit_matrix::ImplicitMatrix;
use crate::integrator::{
    LENGTH_ERROR_OF_FULL_DEFLECTION, OdeSystem, SAFETY_AT_CONTACT_CHANGE, SPEED_PER_LENGTH,
    SecondOrderSystem,
};
use crate::multibody::constraints::relative_kinematics::{CoordinateBlock, Pair};
use crate::multibody::constraints::sparse_kkt::SparseKkt;
use crate::multibody::description::tribology::FrictionLaw;
use crate::multibody::dynamics::MechanismDynamics;
use crate::multibody::model::MechanismModel;

/// Change of a velocity for difference quotients \[m/s\]; that of an angular velocity is divided by its arm.
const CHANGE: f64 = 1e-6;

/// Largest number of coordinates for which difference quotients give the matrix near singular positions, where accelerations are
/// interpolated.
const MOST_BY_DIFFERENCES: usize = 150;

/// Write the length of each coordinate that scales it to metres: for angles, the distance of the farthest joint or contact point;
/// 1 without one.
fn write_lengths(model: &MechanismModel, lengths: &mut [f64]) {
    lengths.fill(1.0);
    for angle in lengths.iter_mut().skip(2).step_by(3) {
        *angle = 0.0;
    }
    let joints = model.equations.iter().flat_map(|e| [e.a, e.b]);
    let contacts = model.contacts.iter().flat_map(|c| [c.a, c.b]);
    for end in joints.chain(contacts) {
        if let Some(first) = model.first[end.body] {
            lengths[first + 2] = end.point.norm().max(lengths[first + 2]);
        }
    }
    for angle in lengths.iter_mut().skip(2).step_by(3) {
        if *angle == 0.0 {
            *angle = 1.0;
        }
    }
}

impl ImplicitMatrix {
    /// Add the derivatives of the forces and contacts.
    fn add_forces(&mut self, dynamics: &MechanismDynamics, gamma: f64) {
        let (model, frames) = (&*dynamics.model, &dynamics.frames);
        let (by_velocity, by_place) = (-gamma, -gamma * gamma);
        let time = dynamics.corrector.time;
        for (force, places) in model.forces.iter().zip(&self.forces) {
            let mut block = CoordinateBlock::default();
            force.add_slopes(time, frames, by_velocity, by_place, &mut block);
            self.saddle.add_pair(places, &block);
        }
        for (k, (contact, places)) in model.contacts.iter().zip(&self.contacts).enumerate() {
            if !dynamics.contacts.has_force(model, k) {
                continue;
            }
            let pair = Pair::new(contact.a, contact.b, frames, true);
            let mut block = CoordinateBlock::default();
            dynamics
                .contacts
                .visit_slopes(model, frames, k, |force, torque| {
                    pair.add(force, by_velocity, by_place, &mut block);
                    if let Some(torque) = torque {
                        pair.add_torque(torque, by_velocity, by_place, &mut block);
                    }
                });
            self.saddle.add_pair(places, &block);
        }
    }
}

impl MechanismDynamics {
    /// Assemble and factorise the sparse matrix at the last evaluation, near singular positions too; return whether it is regular.
    pub(crate) fn factorise_here(&mut self, gamma: f64) -> bool {
        let mut matrix = self.take_matrix(gamma);
        matrix.by_differences = None;
        let regular = self.linearise(&mut matrix, gamma);
        self.corrector.matrix = Some(matrix);
        regular
    }

    /// Return the matrix, for factors of a step with `gamma`, out of the corrector.
    fn take_matrix(&mut self, gamma: f64) -> Box<ImplicitMatrix> {
        self.corrector.stage.gamma = gamma;
        let taken = self.corrector.matrix.take();
        taken.unwrap_or_else(|| Box::new(ImplicitMatrix::new(&self.model)))
    }

    /// Assemble and factorise the matrix at the last evaluation; return whether it is regular.
    fn linearise(&self, matrix: &mut ImplicitMatrix, gamma: f64) -> bool {
        matrix.saddle.begin(&self.model.mass);
        matrix.add_forces(self, gamma);
        matrix.add_joints(self, gamma);
        matrix.add_pins(
            &self.model,
            &self.frames,
            &self.constraints.multipliers,
            gamma,
        );
        matrix.saddle.factorise()
    }

    /// Return the factors of the dense matrix by central differences of whole evaluations at `y`, the state of the last evaluation.
    /// `Counts::evaluations` does not count them.
    fn matrix_by_differences(&mut self, y: &[f64], gamma: f64) -> LU<f64, Dyn, Dyn> {
        let n = self.model.coordinates();
        let mut lengths = vec![1.0; n];
        write_lengths(&self.model, &mut lengths);
        let (t, mut state) = (self.corrector.time, vec![0.0; 2 * n]);
        (self.contacts.bristles).read(&self.model, y, &mut state);
        self.shift.add(t, &mut state);
        let mut matrix = DMatrix::identity(n, n);
        for i in 0..n {
            let change = CHANGE / lengths[i];
            let kept = (state[i], state[n + i]);
            // Velocities change by δ and coordinates by γ δ: column i of γ ∂a/∂v + γ² ∂a/∂q is γ (a⁺ - a⁻) / 2δ.
            let mut at = |sign: f64| {
                state[i] = kept.0 + sign * gamma * change;
                state[n + i] = kept.1 + sign * change;
                self.evaluate(t, &state);
                self.accelerations.clone()
            };
            let (up, down) = (at(1.0), at(-1.0));
            (state[i], state[n + i]) = kept;
            for (k, (up, down)) in up.iter().zip(&down).enumerate() {
                matrix[(k, i)] -= 0.5 * gamma * (up - down) / change;
            }
        }
        // Onsets, reactions and peaks are read from the last evaluation: that at `y`, not at the last changed state.
        self.evaluate(t, &state);
        matrix.lu()
    }
}

impl SecondOrderSystem for MechanismDynamics {
    fn coordinates(&self) -> usize {
        self.model.unknowns()
    }

    fn accelerations_with_slopes(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        let multipliers = &mut self.constraints.multipliers;
        (self.corrector).begin_stage(multipliers, &mut self.accelerations);
        self.derivative(t, y, dydt);
    }

    fn stiffness_residual(&self) -> Option<&[f64]> {
        self.corrector.stage.corrected_residual()
    }

    fn correct_sum_rates(&self, rates: &mut [f64]) {
        if self.corrector.stage.active {
            rates.copy_from_slice(&self.powers());
        }
    }

    fn local_unknowns(&self) -> Range<usize> {
        self.model.coordinates()..self.model.unknowns()
    }

    fn begin_implicit_stage(&mut self, step: Option<(&[f64], f64)>) {
        self.corrector.stage.active &= step.is_some();
        self.contacts.bristles.begin_implicit_stage(step);
    }

    fn write_local_solution(&self, velocities: &mut [f64]) {
        velocities.copy_from_slice(&self.contacts.bristles.deflection);
    }

    fn contraction_safety_factor(&self) -> f64 {
        let by_differences = |matrix: &ImplicitMatrix| matrix.by_differences.is_some();
        let is_exact = !self.corrector.matrix.as_deref().is_some_and(by_differences);
        // Corrections of bristles and of dependent constraints contract at another rate in each step.
        let varies = self.model.bristles > 0 || self.constraints.rank < self.constraints.rows.len();
        if !is_exact || varies || self.model.has_film() {
            return f64::INFINITY;
        }
        if self.contacts.changed(&self.model) {
            SAFETY_AT_CONTACT_CHANGE
        } else {
            1.0
        }
    }

    fn factorise(&mut self, y: &[f64], gamma: f64) -> bool {
        let kkt = self.constraints.kkt.as_ref();
        let nearness = kkt.map_or(f64::INFINITY, SparseKkt::independence);
        // Near a singular position the accelerations are interpolated, and the sparse matrix of one state does not apply.
        let singular = !self.corrector.stage.active && nearness < self.constraints.near_singular;
        if !singular || self.model.coordinates() > MOST_BY_DIFFERENCES {
            return self.factorise_here(gamma);
        }
        let mut matrix = self.take_matrix(gamma);
        let factors = self.matrix_by_differences(y, gamma);
        let regular = factors.is_invertible();
        matrix.by_differences = Some(factors);
        self.corrector.matrix = Some(matrix);
        regular
    }

    fn correct(&mut self, residual: &mut [f64]) {
        let n = self.model.coordinates();
        // Bristle deflections are local unknowns: each evaluation solves for them.
        let (residual, bristles) = residual.split_at_mut(n);
        bristles.fill(0.0);
        let Some(mut matrix) = self.corrector.matrix.take() else {
            return;
        };
        if let Some(factors) = &matrix.by_differences {
            if !factors.solve_mut(&mut DVectorViewMut::from_slice(residual, n)) {
                residual.fill(f64::NAN);
            }
            self.corrector.matrix = Some(matrix);
            return;
        }
        // Right-hand sides M r and G r of the module's equations.
        let (constraints, stage) = (&mut self.constraints, &mut self.corrector.stage);
        stage.write_lacks(constraints, residual);
        let (saddle, mass) = (&mut matrix.saddle, &self.model.mass);
        saddle.write_right(|k| mass[k] * residual[k], |i| stage.lacks[i]);
        saddle.solve();
        saddle.visit_multipliers(|i, change| stage.lacks[i] = change);
        stage.correct_reactions(constraints, &mut self.accelerations, residual);
        saddle.visit_velocities(|k, correction| residual[k] = correction);
        self.corrector.matrix = Some(matrix);
    }

    fn scale(&self, lengths: &mut [f64]) {
        let (bodies, bristles) = lengths.split_at_mut(self.model.coordinates());
        write_lengths(&self.model, bodies);
        let contacts = self.model.contacts.iter().zip(&self.model.sides_of_contact);
        for (contact, sides) in contacts {
            if let Some(FrictionLaw::LuGre(law)) = &contact.friction {
                for bristle in self.model.bristle_of_side[sides.clone()].iter().flatten() {
                    bristles[*bristle] =
                        SPEED_PER_LENGTH * LENGTH_ERROR_OF_FULL_DEFLECTION / law.breakaway();
                }
            }
        }
    }
}

//! Evaluations of the implicit corrector: the multipliers are unknowns of Newton's method beside the velocities.
//!
//! An evaluation with given multipliers λ leaves the accelerations a = M⁻¹ (f - Gᵀ λ), which violate G a = γ. The linear system of the
//! corrector then has the right-hand side h (γ - G a) + G r in the rows of the constraints, with h the factor of the accelerations in the
//! corrector's formula. Its solution has the corrections of the velocities and h Δλ. No factors of G M⁻¹ Gᵀ are needed.

use serde::{Deserialize, Serialize};

use super::implicit_matrix::ImplicitMatrix;
use crate::multibody::constraints::constraint_state::ConstraintState;
use crate::multibody::description::body::Frame;
use crate::multibody::model::MechanismModel;

/// Independence of the constraints, over the near-singular threshold, from which on multipliers are solved for by Newton's method.
///
/// Doubled: evaluations solve for the multipliers at up to twice the distance from singular positions; nothing else changes.
const WELL_CONDITIONED: f64 = 2.0;

/// Most steps from one factorisation of G M⁻¹ Gᵀ to the next, a power of two.
///
/// Doubled: where bodies turn little, a singular position is noticed up to 64 steps later, within the angle [`TURNED`].
const STEPS_PER_CHECK: u64 = 64;

/// Largest rotation between two factorisations \[rad\]: the distance of the points by which accelerations near singular positions are
/// interpolated is 0.03.
///
/// Doubled: fewer factorisations where steps are long.
const TURNED: f64 = 0.02;

/// Change of the independence until the end of the next step, over the rotation in the last step: steps at most double, and the
/// independence changes by about twice the rotation near a singular position.
///
/// Doubled: evaluations solve for the multipliers at steps half as long.
const GROWTH: f64 = 4.0;

/// Reaction forces and accelerations at the end of the last step, from which those of the next step are corrected.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct StepReactions {
    multipliers: Vec<f64>,
    accelerations: Vec<f64>,
    /// Whether the constraints are independent and far from a singular position.
    regular: bool,
}

/// Stage of the implicit corrector in progress.
#[derive(Debug, Clone, Default)]
pub(crate) struct Stage {
    /// Whether the multipliers are unknowns of Newton's method in the present evaluation.
    pub(crate) active: bool,
    /// Accelerations by the multipliers given, which violate the constraints.
    pub(crate) trial: Vec<f64>,
    /// Residual of the velocities with the corrected multipliers.
    residual: Vec<f64>,
    /// Right-hand sides of the constraints, then their solution; a work array over the coordinates.
    pub(super) lacks: Vec<f64>,
    change: Vec<f64>,
    /// Factor of the accelerations in the formula of the corrector \[s\].
    pub(super) gamma: f64,
}

impl StepReactions {
    /// Return whether the multipliers of the next implicit step are unknowns of Newton's method.
    pub(crate) fn regular(&self) -> bool {
        self.regular
    }

    /// Return whether these are the reactions of a mechanism with so many constraints and coordinates, or none.
    pub(crate) fn is_within(&self, constraints: usize, coordinates: usize) -> bool {
        !self.regular
            || self.multipliers.len() == constraints && self.accelerations.len() == coordinates
    }

    /// Keep the reactions of the step that was just made, after its projection, which has `measured` the independence of the
    /// constraints. `turned`: largest rotation of a body in the step \[rad\].
    pub(crate) fn keep(
        &mut self,
        constraints: &ConstraintState,
        accelerations: &[f64],
        turned: f64,
        measured: bool,
    ) {
        // No singular position may be reached before the next measurement.
        let reached = TURNED.max(GROWTH * turned);
        let least = WELL_CONDITIONED * constraints.near_singular + reached;
        let count = constraints.rows.len();
        let independent = constraints
            .kkt
            .as_ref()
            .is_some_and(|kkt| kkt.rank() == count && kkt.independence() > least);
        let regular = if measured { independent } else { self.regular };
        self.multipliers.clone_from(&constraints.multipliers);
        self.accelerations.clear();
        self.accelerations.extend_from_slice(accelerations);
        // The friction of pins depends on the reactions themselves.
        self.regular = regular && constraints.pin_torques.values.is_empty();
    }
}

/// Return the largest rotation of a body in a step of `length` \[s\].
pub(crate) fn largest_rotation(frames: &[Frame], length: f64) -> f64 {
    let spins = frames.iter().map(|frame| frame.spin.abs());
    length * spins.fold(0.0, f64::max)
}

/// Return whether the independence of the constraints is to be measured at the end of the last step, of `length` \[s\] and with this
/// number.
pub(crate) fn is_nearness_due(frames: &[Frame], length: f64, number: u64) -> bool {
    let turned = largest_rotation(frames, length);
    let mut steps = STEPS_PER_CHECK;
    while steps > 1 && steps as f64 * turned > TURNED {
        steps /= 2;
    }
    number.is_multiple_of(steps)
}

/// Matrix and stage of the implicit corrector, and the reactions that it begins from.
#[derive(Debug, Clone, Default)]
pub(crate) struct ImplicitCorrector {
    /// Time of the last derivative \[s\].
    pub(crate) time: f64,
    /// Matrix, once it is used.
    pub(super) matrix: Option<Box<ImplicitMatrix>>,
    pub(crate) stage: Stage,
    pub(crate) reactions: StepReactions,
}

impl ImplicitCorrector {
    /// Add to `change` the solution x of A x + Gᵀ μ = 0, G x = -`residual` with the matrix A of the last implicit step.
    pub(crate) fn correct_constraints(&mut self, residual: &[f64], change: &mut [f64]) {
        let Some(matrix) = &mut self.matrix else {
            return;
        };
        let saddle = &mut matrix.saddle;
        saddle.write_right(|_| 0.0, |i| -residual[i]);
        saddle.solve();
        saddle.visit_velocities(|k, solution| change[k] += solution);
    }

    /// Begin the first evaluation of an implicit step. It begins from the reactions kept: reports have evaluated other states since.
    pub(super) fn begin_stage(&mut self, multipliers: &mut [f64], accelerations: &mut [f64]) {
        self.stage.active = self.reactions.regular;
        if self.stage.active {
            multipliers.copy_from_slice(&self.reactions.multipliers);
            accelerations.copy_from_slice(&self.reactions.accelerations);
        }
    }

    /// Compute the accelerations by the multipliers given, from the loads on the free coordinates.
    pub(crate) fn accelerate(
        &mut self,
        model: &MechanismModel,
        constraints: &ConstraintState,
        loads: &[f64],
    ) {
        let Some(kkt) = &constraints.kkt else { return };
        let trial = &mut self.stage.trial;
        trial.clear();
        trial.extend(loads.iter().zip(&model.mass).map(|(f, m)| f / m));
        let multipliers = &constraints.multipliers;
        kkt.push(&constraints.rows, |i| -multipliers[i], trial);
    }
}

impl Stage {
    /// Write the right-hand sides of the constraints: G r, and what the accelerations of the evaluation lack to satisfy the constraints,
    /// times the factor h of the corrector. G r + h (γ - G a) = G (r - h a) + h γ.
    pub(super) fn write_lacks(&mut self, constraints: &ConstraintState, residual: &[f64]) {
        let Some(kkt) = &constraints.kkt else { return };
        let rows = &constraints.rows;
        let gamma = if self.active { self.gamma } else { 0.0 };
        self.change.clear();
        self.change.extend_from_slice(residual);
        if self.active {
            let lacking = self.change.iter_mut().zip(&self.trial);
            lacking.for_each(|(x, a)| *x -= gamma * a);
        }
        self.lacks.resize(rows.len(), 0.0);
        kkt.jacobian.multiply(rows, &self.change, &mut self.lacks);
        let lacks = self.lacks.iter_mut().zip(rows);
        lacks.for_each(|(lack, row)| *lack += gamma * row.gamma);
    }

    /// Correct multipliers and accelerations by the solution of the linear system, which has replaced `lacks`, and `residual` to that with
    /// the corrected multipliers.
    pub(super) fn correct_reactions(
        &mut self,
        constraints: &mut ConstraintState,
        accelerations: &mut [f64],
        residual: &[f64],
    ) {
        let Some(kkt) = constraints.kkt.as_ref().filter(|_| self.active) else {
            return;
        };
        let part = 1.0 / self.gamma;
        let multipliers = constraints.multipliers.iter_mut().zip(&self.lacks);
        multipliers.for_each(|(lambda, change)| *lambda += part * change);
        self.change.fill(0.0);
        kkt.push(&constraints.rows, |i| self.lacks[i], &mut self.change);
        self.residual.clear();
        let residuals = residual.iter().zip(&self.change);
        self.residual
            .extend(residuals.map(|(r, change)| r - change));
        let accelerations = accelerations.iter_mut().zip(&self.trial);
        for ((a, trial), change) in accelerations.zip(&self.change) {
            *a = trial - part * change;
        }
    }

    /// Return the residual of the velocities with the corrected multipliers; `None` where evaluations solve for the multipliers.
    pub(super) fn corrected_residual(&self) -> Option<&[f64]> {
        self.active.then_some(&self.residual[..])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_turn_at_most_by_the_angle_between_two_measurements() {
        for (turned, apart) in [
            (0.0, 64),
            (3e-4, 64),
            (4e-4, 32),
            (4.9e-3, 4),
            (9e-3, 2),
            (0.011, 1),
            (3.0, 1),
        ] {
            let frames =
                [0.1, -1.0].map(|part| Frame::new([0.0; 3], [0.0, 0.0, part * turned / 0.5]));
            let due: Vec<u64> = (100..300)
                .filter(|&number| is_nearness_due(&frames, 0.5, number))
                .collect();
            assert!(
                due.windows(2).all(|pair| pair[1] - pair[0] == apart),
                "{turned}: {due:?}"
            );
            assert!(apart == 1 || turned * apart as f64 <= TURNED);
        }
    }
}

//! Evaluations of the implicit corrector: the multipliers are unknowns of Newton's method beside the velocities.
//!
//! An evaluation with given multipliers λ leaves the accelerations a = M⁻¹ (f - Gᵀ λ), which violate G a = γ. The linear system of the
//! corrector then has the right-hand side h (γ - G a) + G r in the rows of the constraints, with h the factor of the accelerations in the
//! corrector's formula. Its solution has the corrections of the velocities and h Δλ. No factors of G M⁻¹ Gᵀ are needed.

use serde::{Deserialize, Serialize};

use super::matrix::ImplicitMatrix;
use crate::multibody::constraints::constraint_state::ConstraintState;
use crate::multibody::description::body::Frame;
use crate::multibody::model::MechanismModel;

/// Independence of the constraints, over the near-singular threshold, from which on multipliers are solved for by Newton's method.
///
/// Doubled: evaluations solve for the multipliers at up to twice the distance from singular positions; nothing else changes.
const WELL_CONDITIONED: f64 = 2.0;

/// Steps from one factorisation of G M⁻¹ Gᵀ to the next where bodies turn little.
///
/// Doubled: a singular position is noticed up to 16 steps later, within the angle [`TURNED`].
const STEPS_PER_CHECK: u64 = 16;

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
    let seldom = largest_rotation(frames, length) * STEPS_PER_CHECK as f64 <= TURNED;
    !seldom || number.is_multiple_of(STEPS_PER_CHECK)
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
        let n = change.len();
        let Some(matrix) = &mut self.matrix else {
            return;
        };
        let saddle = &mut matrix.saddle;
        (0..n).for_each(|k| saddle.set_right(k, 0.0));
        for (i, residual) in residual.iter().enumerate() {
            saddle.set_right(n + i, -residual);
        }
        saddle.solve();
        for (k, change) in change.iter_mut().enumerate() {
            *change += saddle.solution(k);
        }
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
        kkt.push(&constraints.rows, -1.0, |i| multipliers[i], trial);
    }
}

impl Stage {
    /// Return what the accelerations of the evaluation lack to satisfy constraint `i`, times the factor of the corrector.
    pub(super) fn lack(&self, constraints: &ConstraintState, i: usize) -> f64 {
        if !self.active {
            return 0.0;
        }
        let row = &constraints.rows[i];
        let kkt = constraints.kkt.as_ref();
        let along = kkt.map_or(0.0, |kkt| kkt.along(row, &self.trial));
        self.gamma * (row.gamma - along)
    }

    /// Correct multipliers and accelerations by the solution `change` of the linear system, and `residual` to that with the corrected
    /// multipliers.
    pub(super) fn correct_reactions(
        &mut self,
        constraints: &mut ConstraintState,
        accelerations: &mut [f64],
        residual: &[f64],
        change: impl Fn(usize) -> f64,
    ) {
        let Some(kkt) = constraints.kkt.as_ref().filter(|_| self.active) else {
            return;
        };
        self.residual.clear();
        self.residual.extend_from_slice(residual);
        kkt.push(&constraints.rows, -1.0, &change, &mut self.residual);
        accelerations.copy_from_slice(&self.trial);
        let part = 1.0 / self.gamma;
        kkt.push(&constraints.rows, -part, &change, accelerations);
        for (i, lambda) in constraints.multipliers.iter_mut().enumerate() {
            *lambda += part * change(i);
        }
    }

    /// Return the residual of the velocities with the corrected multipliers; `None` where evaluations solve for the multipliers.
    pub(super) fn corrected_residual(&self) -> Option<&[f64]> {
        self.active.then_some(&self.residual[..])
    }
}

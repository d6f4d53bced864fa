//! Evaluations of the implicit corrector: the multipliers are unknowns of Newton's method beside the velocities.
//!
//! An evaluation with given multipliers λ leaves the accelerations a = M⁻¹ (f - Gᵀ λ), which violate G a = γ. The linear system of the
//! corrector then has the right-hand side h (γ - G a) + G r in the rows of the constraints, with h the factor of the accelerations in the
//! corrector's formula. Its solution has the corrections of the velocities and h Δλ. No factors of G M⁻¹ Gᵀ are needed.

use serde::{Deserialize, Serialize};

use crate::multibody::dynamics::{MechanismDynamics, Stabilisation};

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
}

impl MechanismDynamics {
    /// Add to `change` the solution x of A x + Gᵀ μ = 0, G x = -`residual` with the matrix A of the last implicit step.
    pub(crate) fn correct_constraints(&mut self, residual: &[f64], change: &mut [f64]) {
        let n = change.len();
        let Some(matrix) = &mut self.corrector else {
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

    /// Return the largest rotation of a body in the last step, of `length` \[s\].
    fn turned(&self, length: f64) -> f64 {
        let spins = self.frames.iter().map(|frame| frame.spin.abs());
        length * spins.fold(0.0, f64::max)
    }

    /// Return whether the independence of the constraints is to be measured at the end of the last step, of `length` \[s\] and with this
    /// number.
    pub(crate) fn is_nearness_due(&self, length: f64, number: u64) -> bool {
        let seldom = self.turned(length) * STEPS_PER_CHECK as f64 <= TURNED;
        !seldom || number.is_multiple_of(STEPS_PER_CHECK)
    }

    /// Keep the reactions of the step that was just made, of `length` \[s\], after its projection, which has `measured` the independence of
    /// the constraints.
    pub(crate) fn keep_reactions(&mut self, length: f64, measured: bool) {
        // No singular position may be reached before the next measurement.
        let reached = TURNED.max(GROWTH * self.turned(length));
        let least = WELL_CONDITIONED * self.near_singular + reached;
        let independent = self
            .kkt
            .as_ref()
            .is_some_and(|kkt| kkt.rank() == self.rows.len() && kkt.independence() > least);
        let regular = if measured {
            independent
        } else {
            self.reactions.regular
        };
        let kept = &mut self.reactions;
        kept.multipliers.clone_from(&self.multipliers);
        kept.accelerations.clone_from(&self.accelerations);
        // The friction of pins depends on the reactions themselves.
        kept.regular = regular
            && self.model.pins.is_empty()
            && self.stabilisation == Stabilisation::Projection;
    }

    /// Begin the first evaluation of an implicit step.
    pub(super) fn begin_stage(&mut self) {
        self.stage.active = self.reactions.regular;
        if self.stage.active {
            // Reports have evaluated other states since.
            self.multipliers
                .copy_from_slice(&self.reactions.multipliers);
            self.accelerations
                .copy_from_slice(&self.reactions.accelerations);
        }
    }

    /// Compute the accelerations by the multipliers given.
    pub(crate) fn accelerate_with_reactions(&mut self) {
        let Some(kkt) = &self.kkt else { return };
        let trial = &mut self.stage.trial;
        trial.clear();
        trial.extend(self.forces.iter().zip(&self.model.mass).map(|(f, m)| f / m));
        kkt.push(&self.rows, -1.0, |i| self.multipliers[i], trial);
    }

    /// Return what the accelerations of the evaluation lack to satisfy constraint `i`, times the factor of the corrector.
    pub(super) fn lack(&self, i: usize) -> f64 {
        if !self.stage.active {
            return 0.0;
        }
        let row = &self.rows[i];
        let along = self
            .kkt
            .as_ref()
            .map_or(0.0, |kkt| kkt.along(row, &self.stage.trial));
        self.stage.gamma * (row.gamma - along)
    }

    /// Correct multipliers and accelerations by the solution `change` of the linear system, and `residual` to that with the corrected
    /// multipliers.
    pub(super) fn correct_reactions(&mut self, residual: &[f64], change: impl Fn(usize) -> f64) {
        let Some(kkt) = self.kkt.as_ref().filter(|_| self.stage.active) else {
            return;
        };
        let stage = &mut self.stage;
        stage.residual.clear();
        stage.residual.extend_from_slice(residual);
        kkt.push(&self.rows, -1.0, &change, &mut stage.residual);
        self.accelerations.copy_from_slice(&stage.trial);
        let part = 1.0 / stage.gamma;
        kkt.push(&self.rows, -part, &change, &mut self.accelerations);
        for (i, lambda) in self.multipliers.iter_mut().enumerate() {
            *lambda += part * change(i);
        }
    }

    /// Return the residual of the velocities with the corrected multipliers; `None` where evaluations solve for the multipliers.
    pub(super) fn corrected_residual(&self) -> Option<&[f64]> {
        self.stage.active.then_some(&self.stage.residual[..])
    }
}

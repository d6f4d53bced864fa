//! Detection of a start at a singular position, where branches of the motion meet and more constraints are dependent than nearby.

use super::acceleration::nearness;
use crate::multibody::assembly::projection::AtHand;
use crate::multibody::constraints::constraint_state::ConstraintState;
use crate::multibody::dynamics::MechanismDynamics;
use crate::multibody::model::MechanismModel;

/// Independence of the constraints at the start below which nearby positions are examined.
const NEAR: f64 = 1e-6;
/// Distance of the nearby positions from the start, in radians and in parts of the size.
const BESIDE: f64 = 0.01;
/// Ratio of the independence nearby to that at the start above which the start counts as singular.
const MORE: f64 = 100.0;
/// Threshold of independence at the nearby positions, above the effect of their residuals.
const TOLD: f64 = 1e-6;
/// Largest number of iterations of the projection of a nearby position.
const ITERATIONS: usize = 40;
/// Thresholds of independence for the constraints to keep, tried from the largest.
const HOLDS: [f64; 3] = [1e-2, 3e-3, 1e-3];
/// Number of nearby positions.
const TRIALS: usize = 3;
/// Angle between the sines of consecutive coordinates in the displacement of the first trial \[rad\]; a multiple of it in the others. As
/// no simple part of a turn it gives all coordinates different components.
const SINE_STEP: f64 = 1.7;
/// Smallest ratio of [`MechanismModel::least_gyration_over_arm`] that lowers the near-singular threshold, which holds for the whole mechanism:
/// rounding of accelerations near a singular position grows with the inverse cube of the threshold.
const SLENDEREST: f64 = 0.02;
/// Parts of the near-singular threshold with which a nearby position is projected, tried in this order. A constraint that is dependent at
/// the start may have little independence nearby.
const THRESHOLD_PARTS: [f64; 3] = [1.0, 0.1, 0.01];

impl MechanismDynamics {
    /// Determine the rank of the constraints near the start and the near-singular threshold. `state` is the start, which was just
    /// evaluated.
    ///
    /// Return whether the start is singular, with branches of the motion that meet there, and all initial velocities are zero.
    pub(crate) fn look_beside(&mut self, state: &[f64]) -> bool {
        let Some(kkt) = &self.constraints.kkt else {
            return false;
        };
        let (rank, independence) = (kkt.rank(), kkt.independence());
        let constraints = &mut self.constraints;
        let slenderest = self.model.least_gyration_over_arm().max(SLENDEREST);
        (constraints.rank, constraints.near_singular) =
            (rank, nearness(independence.min(slenderest)));
        if rank == constraints.rows.len() && independence > NEAR {
            return false;
        }
        // Drivers advance by the same distance as the bodies.
        let rates = self.constraints.rows.iter().map(|row| row.time_rate.abs());
        let fastest = rates.fold(0.0, f64::max);
        let delay = if fastest > 0.0 { BESIDE / fastest } else { 0.0 };
        let (n, size) = (self.model.coordinates(), self.model.size(&self.frames));
        let aside = std::mem::replace(&mut self.constraints.aside, true);
        let mut place = vec![0.0; state.len()];
        let mut change = vec![0.0; n];
        let mut along = vec![0.0; self.constraints.rows.len()];
        let mut found = (rank, false);
        for trial in 1..=TRIALS {
            // A deterministic displacement with different components in each trial.
            for (i, change) in change.iter_mut().enumerate() {
                let unit = if i % 3 == 2 { 1.0 } else { size };
                *change = BESIDE * unit * (SINE_STEP * (i + 1) as f64 * trial as f64).sin();
            }
            // The displacement is made tangential to the constraints: with residuals, redundant constraints appear to be independent.
            self.evaluate(0.0, state);
            if let Some(kkt) = &mut self.constraints.kkt {
                (kkt.jacobian).multiply(&self.constraints.rows, &change, &mut along);
                kkt.correct(&along, &mut change);
            }
            place.copy_from_slice(state);
            for (q, change) in place.iter_mut().zip(&change) {
                *q += change;
            }
            let near = self.constraints.near_singular;
            let reached = THRESHOLD_PARTS.iter().any(|part| {
                self.constraints.near_singular = part * near;
                (self.projector()).project(delay, &mut place, ITERATIONS, AtHand::Nothing)
            });
            let constraints = &mut self.constraints;
            constraints.near_singular = near;
            let Some(kkt) = constraints.kkt.as_mut().filter(|_| reached) else {
                continue;
            };
            kkt.factorise(&constraints.rows, TOLD);
            let beside = kkt.independence();
            found.0 = found.0.max(kkt.rank());
            let grown = kkt.rank() == rank && beside > MORE * independence.max(NEAR);
            if grown {
                constraints.near_singular = nearness(beside.min(slenderest));
            }
            found.1 |= kkt.rank() > rank || grown;
        }
        self.constraints.aside = aside;
        self.constraints.rank = found.0;
        self.evaluate(0.0, state);
        self.constraints.hold_by_what_holds_best();
        self.evaluate(0.0, state);
        let given = (self.model.bodies.iter()).any(|body| body.velocity != [0.0; 3]);
        found.1 && !given
    }
}

impl MechanismModel {
    /// Return the least radius of gyration of a body over the distance of one of its joints from its centre of mass, one at most.
    ///
    /// The norm of the independence is weighted by inverse masses. A body that turns easily makes the joints at its ends appear dependent to
    /// this extent, in some positions, without being near a singular one.
    fn least_gyration_over_arm(&self) -> f64 {
        let ends = (self.equations.iter()).flat_map(|equation| [&equation.a, &equation.b]);
        let free = ends.filter(|end| self.first[end.body].is_some());
        let ratios = free.map(|end| {
            let body = &self.bodies[end.body];
            (body.inertia / body.mass).sqrt() / end.point.norm()
        });
        ratios.fold(1.0, f64::min)
    }
}

impl ConstraintState {
    /// With redundant constraints, raise the near-singular threshold to the largest of [`HOLDS`] that keeps the rank.
    ///
    /// The set of constraints kept may then differ from those described first.
    fn hold_by_what_holds_best(&mut self) {
        if let Some(kkt) = self.kkt.as_mut().filter(|_| self.rank < self.rows.len()) {
            let holds = HOLDS.into_iter().find(|&part| {
                kkt.factorise(&self.rows, part);
                kkt.rank() == self.rank
            });
            self.near_singular =
                holds.map_or(self.near_singular, |part| part.max(self.near_singular));
        }
    }
}

//! Constraints and friction of pins in the matrix of the implicit corrector.

use super::matrix::ImplicitMatrix;
use super::stage::largest_rotation;
use crate::multibody::constraints::equation::{Equation, Quantity, Row};
use crate::multibody::constraints::relative_kinematics::{Block, Pair};
use crate::multibody::description::body::Frame;
use crate::multibody::dynamics::MechanismDynamics;
use crate::multibody::forces::force_slopes::add_twist;
use crate::multibody::model::MechanismModel;

/// Relative compliance of a constraint: ε over the diagonal entry of G M⁻¹ Gᵀ. It is far below the round-off of the iteration and
/// above that of the factors.
const SOFT: f64 = 1e-11;

/// Rotation 2 γ ω of the fastest body \[rad\] up to which the change of the rows of points along the correction is omitted, where
/// multipliers are unknowns of Newton's method.
///
/// The error of a correction is this part of it, across the constraints, where the projection removes it. With the rows of one state the
/// factors serve the projection without iterations.
const LITTLE_TURN: f64 = 0.01;

impl ImplicitMatrix {
    /// Add the constraints: their rows and columns, and γ² Σ λ ∂²c/∂q² (see the equations of the matrix).
    pub(super) fn add_joints(&mut self, dynamics: &MechanismDynamics, gamma: f64) {
        let (model, frames) = (&*dynamics.model, &dynamics.frames);
        let (constraints, n) = (&dynamics.constraints, model.coordinates());
        let turn = largest_rotation(frames, 2.0 * gamma);
        let rows_change = !(dynamics.corrector.stage.active && turn <= LITTLE_TURN);
        for (i, equation) in model.equations.iter().enumerate() {
            let row = &constraints.rows[i];
            let mut across = row.jacobian;
            let (pair_places, row_places) = &self.joints[i];
            let saddle = &mut self.saddle;
            let weight = gamma * gamma * constraints.multipliers[i];
            if let Quantity::Coincident(axis) = equation.quantity {
                // Only the angles enter non-linearly, each by itself.
                let bends = bends_of_point(dynamics, equation, row, axis, gamma);
                for (k, [second, change]) in bends.into_iter().enumerate() {
                    across[k][2] += if rows_change { change } else { 0.0 };
                    saddle.add_entry(pair_places[3 * k], 2, 2, weight * second);
                }
            } else if let Some(block) = bend(dynamics, equation, gamma, &mut across) {
                let block = block.map(|line| line.map(|entry| weight * entry));
                saddle.add_pair(pair_places, &block);
            }
            saddle.add_row(row_places, &row.jacobian, &across);
            let held = constraints
                .kkt
                .as_ref()
                .map_or(0.0, |kkt| kkt.diagonal(row));
            saddle.add_diagonal(n + i, -SOFT * held);
        }
    }

    /// Add the friction of pins. Corrections of the multipliers are μ = γ Δλ, so the derivatives with respect to λ enter without γ.
    pub(super) fn add_pins(
        &mut self,
        model: &MechanismModel,
        frames: &[Frame],
        multipliers: &[f64],
        gamma: f64,
    ) {
        for pin in &model.pins {
            let torque = pin.torque(frames, multipliers);
            let mut block = Block::default();
            add_twist(-gamma * torque.by_spin, &mut block);
            self.saddle.add_pair(&self.joints[pin.row].0, &block);
            for (i, slope) in torque.by_multiplier.into_iter().enumerate() {
                let places = &self.joints[pin.row + i].1;
                let down = [[0.0, 0.0, slope], [0.0, 0.0, -slope], [0.0; 3]];
                self.saddle.add_row(places, &down, &[[0.0; 3]; 3]);
            }
        }
    }
}

/// Add the derivatives of the row of a non-linear equation to `across` and return ∂²c/∂q²; `None` for a linear equation.
fn bend(
    dynamics: &MechanismDynamics,
    equation: &Equation,
    gamma: f64,
    across: &mut [[f64; 3]; 3],
) -> Option<Block> {
    let MechanismDynamics {
        model,
        frames,
        accelerations,
        ..
    } = dynamics;
    let slopes = equation.slopes(frames)?;
    let pair = Pair::new(equation.a, equation.b, frames, false);
    let [[x, y, turn], [u, v, spin]] =
        [equation.a.body, equation.b.body].map(|body| model.accelerations_of(body, accelerations));
    let acceleration = [x, y, turn, u, v, spin];
    for k in 0..6 {
        let line = slopes.second[k].iter();
        let along = |v: &[f64; 6]| line.clone().zip(v).map(|(a, b)| a * b).sum::<f64>();
        let by_rate = along(&pair.v);
        let by_place = slopes.third[k] + along(&acceleration);
        across[k / 3][k % 3] += 2.0 * gamma * by_rate + gamma * gamma * by_place;
    }
    Some(slopes.second)
}

/// Return ∂²c/∂θ² and the change of the row for the angles of both bodies of a coincident point, along one axis.
///
/// The value is the same as by [`Equation::slopes`], whose other entries are zero.
fn bends_of_point(
    dynamics: &MechanismDynamics,
    equation: &Equation,
    row: &Row,
    axis: usize,
    gamma: f64,
) -> [[f64; 2]; 2] {
    let MechanismDynamics {
        model,
        frames,
        accelerations,
        ..
    } = dynamics;
    let ends = [(equation.a, 1.0), (equation.b, -1.0)];
    let mut bends = [[0.0; 2]; 2];
    for (k, (end, sign)) in ends.into_iter().enumerate() {
        let Some(first) = model.first[end.body] else {
            continue;
        };
        let frame = &frames[end.body];
        let second = sign * frame.turned(end.point)[axis];
        // ∂(v ∂²c/∂q² v)/∂θ = -ω² ∂c/∂θ for an arm that rotates with its body.
        let third = -frame.spin * frame.spin * row.jacobian[k][2];
        let by_place = third + second * accelerations[first + 2];
        let change = 2.0 * gamma * second * frame.spin + gamma * gamma * by_place;
        bends[k] = [second, change];
    }
    bends
}

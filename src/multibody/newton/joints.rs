//! Constraints and friction of pins in the matrix of the implicit corrector.

use super::implicit_matrix::ImplicitMatrix;
use super::sparse_system::PointEntries;
use super::stage::largest_rotation;
use crate::geometry::{Vec2, turned_left};
use crate::multibody::constraints::equation::Equation;
use crate::multibody::constraints::jacobian::{Group, Point, by_body};
use crate::multibody::constraints::relative_kinematics::{CoordinateBlock, Pair};
use crate::multibody::constraints::sparse_kkt::SparseKkt;
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
        let constraints = &dynamics.constraints;
        let Some(kkt) = &constraints.kkt else { return };
        let turn = largest_rotation(&dynamics.frames, 2.0 * gamma);
        let rows_change = !(dynamics.corrector.stage.active && turn <= LITTLE_TURN);
        let mut points = 0;
        for group in &kkt.jacobian.groups {
            match *group {
                Group::Point(point) => {
                    let entries = point_entries(dynamics, kkt, &point, gamma, rows_change);
                    self.saddle.write_point(&self.points[points], &entries);
                    points += 1;
                }
                Group::Single(row) => self.add_row(dynamics, kkt, row, gamma),
            }
        }
    }

    /// Add one constraint.
    fn add_row(&mut self, dynamics: &MechanismDynamics, kkt: &SparseKkt, i: usize, gamma: f64) {
        let (row, equation) = (&dynamics.constraints.rows[i], &dynamics.model.equations[i]);
        let mut across = row.jacobian;
        let (pair_places, row_places) = &self.joints[i];
        let weight = gamma * gamma * dynamics.constraints.multipliers[i];
        if let Some(block) = bend(dynamics, equation, gamma, &mut across) {
            let block = block.map(|line| line.map(|entry| weight * entry));
            self.saddle.add_pair(pair_places, &block);
        }
        self.saddle.add_row(row_places, &row.jacobian, &across);
        self.saddle.add_compliance(i, -SOFT * kkt.diagonal(row));
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
            let mut block = CoordinateBlock::default();
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
) -> Option<CoordinateBlock> {
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

/// Return the entries of a point between free bodies; `rows_change`: see [`LITTLE_TURN`].
///
/// The values are those by [`Equation::slopes`], whose other entries are zero. Only the angles enter non-linearly, each by itself, with a
/// vector g = ∂c/∂θ of both constraints that rotates with its body: ∂²c/∂θ² is g rotated by a right angle, and ∂(v ∂²c/∂q² v)/∂θ = -ω² g.
fn point_entries(
    dynamics: &MechanismDynamics,
    kkt: &SparseKkt,
    point: &Point,
    gamma: f64,
    rows_change: bool,
) -> PointEntries {
    let constraints = &dynamics.constraints;
    let lambda = &constraints.multipliers[point.row..];
    let lambda = Vec2::new(lambda[0], lambda[1]);
    let slopes = point.slopes(&constraints.rows);
    let (mut across, mut bends, mut held) = (slopes, [0.0; 2], [0.0; 2]);
    for (k, body) in point.places.into_iter().enumerate() {
        let g = Vec2::new(slopes[0][k], slopes[1][k]);
        let second = turned_left(g);
        bends[k] = gamma * gamma * lambda.dot(&second);
        if rows_change {
            let spin = dynamics.frames[point.ends[k].body].spin;
            let by_place = dynamics.accelerations[3 * body + 2] * second - spin * spin * g;
            let change = 2.0 * gamma * spin * second + gamma * gamma * by_place;
            (across[0][k], across[1][k]) = (g.x + change.x, g.y + change.y);
        }
        // Diagonal entries of G M⁻¹ Gᵀ.
        let inverse = by_body(&kkt.inverse_mass)[body];
        (0..2).for_each(|axis| held[axis] += inverse[axis] + g[axis] * g[axis] * inverse[2]);
    }
    PointEntries {
        slopes,
        across,
        bends,
        compliances: held.map(|held| -SOFT * held),
    }
}

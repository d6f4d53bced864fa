//! Error texts of assembly: residuals by joint, and the values prescribed by drivers.

use super::approach::NEAR;
use crate::error::Error;
use crate::multibody::constraints::constraint_state::ConstraintState;
use crate::multibody::constraints::equation::{Equation, EquationRow};
use crate::multibody::description::body::Frame;
use crate::multibody::model::MechanismModel;

/// Part of the largest residual below which a joint is not listed.
const MISSED: f64 = 1e-6;

impl ConstraintState {
    /// Return the residuals of positions by joint as text, or those of velocities where positions satisfy the constraints; it tells of
    /// redundant joints, whose residuals grow in motion from the rounding of their points.
    pub(crate) fn largest_residuals(&self, model: &MechanismModel, frames: &[Frame]) -> String {
        let missed = if self.worst(model, frames) <= NEAR {
            self.rates(model, frames)
        } else {
            self.position_residuals(model)
        };
        let redundant = if self.rank < self.rows.len() {
            "; joints are redundant: their points and lengths must agree to all digits, or leave out what `check()` names"
        } else {
            ""
        };
        format!("{missed}{}{redundant}", self.asked(model, frames))
    }

    /// Return the residuals of positions by joint as text.
    fn position_residuals(&self, model: &MechanismModel) -> String {
        self.residuals(model, Equation::residual, ["m", "rad"])
    }

    /// Return the residuals of velocities by joint as text.
    fn rates(&self, model: &MechanismModel, frames: &[Frame]) -> String {
        let rate = |equation: &Equation, row: &EquationRow| equation.residual_rate(row, frames);
        self.residuals(model, rate, ["m/s", "rad/s"])
    }

    /// Return the largest residual of each joint as text, in decreasing order; at most five joints are listed.
    fn residuals(
        &self,
        model: &MechanismModel,
        of: impl Fn(&Equation, &EquationRow) -> f64,
        unit: [&str; 2],
    ) -> String {
        let mut found: Vec<(f64, String)> = Vec::new();
        for (j, joint) in model.joints.iter().enumerate() {
            let rows = model.equations.iter().zip(&self.rows);
            let worst = rows
                .filter(|(equation, _)| equation.joint == j)
                .map(|(equation, row)| {
                    (
                        of(equation, row).abs(),
                        unit[usize::from(equation.is_angle())],
                    )
                })
                .max_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((value, unit)) = worst {
                found.push((value, format!("{:?} by {value:.3e} {unit}", joint.name)));
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let least = found.first().map_or(0.0, |(most, _)| MISSED * most);
        let missed = found.into_iter().filter(|(value, _)| *value > least);
        let worst: Vec<String> = missed.take(5).map(|(_, text)| text).collect();
        worst.join(", ")
    }

    /// Return the values and rates prescribed by moving drivers as text; at most three are listed.
    pub(crate) fn asked(&self, model: &MechanismModel, frames: &[Frame]) -> String {
        let equations = model.equations.iter().zip(&self.rows);
        let driven = equations.filter_map(|(equation, row)| {
            equation.motion.as_ref().filter(|motion| motion.moves())?;
            let unit = if equation.is_angle() { "rad" } else { "m" };
            Some(format!(
                "driver {:?} prescribes {:.4e} {unit}, changing at {:.4e} {unit}/s",
                model.joints[equation.joint].name,
                equation.quantity(frames) - row.value,
                -row.time_rate
            ))
        });
        let driven: Vec<String> = driven.take(3).collect();
        if driven.is_empty() {
            return String::new();
        }
        format!(" ({})", driven.join("; "))
    }

    /// Return the error for an assembly that failed, with the residuals by joint.
    pub(crate) fn refuse(&self, model: &MechanismModel, frames: &[Frame]) -> Error {
        if self.worst(model, frames) <= NEAR {
            return Error::Impossible(format!(
                "no velocities satisfy all joints and drivers at the start; the nearest miss {}: two drivers may prescribe \
                 different speeds, or a driver may contradict the joints",
                self.rates(model, frames)
            ));
        }
        Error::Impossible(format!(
            "the mechanism cannot be assembled; the nearest positions miss {}: check lengths, angles, points and \
             units of these joints (SI: metres, radians)",
            self.position_residuals(model)
        ))
    }
}

//! Error texts of assembly: residuals by joint, and the values prescribed by drivers.

use crate::error::Error;
use crate::multibody::constraints::equation::{Equation, Row};
use crate::multibody::dynamics::MechanismDynamics;

/// Part of the largest residual below which a joint is not listed.
const MISSED: f64 = 1e-6;

impl MechanismDynamics {
    /// Return the residuals of positions by joint as text, or those of velocities where positions satisfy the constraints.
    pub(crate) fn what_misses(&self) -> String {
        let missed = if self.worst() <= 1e-9 {
            self.rates()
        } else {
            self.misses()
        };
        format!("{missed}{}", self.asked())
    }

    /// Return the residuals of positions by joint as text.
    fn misses(&self) -> String {
        self.residuals(Equation::residual, ["m", "rad"])
    }

    /// Return the residuals of velocities by joint as text.
    fn rates(&self) -> String {
        let rate = |equation: &Equation, row: &Row| equation.residual_rate(row, &self.frames);
        self.residuals(rate, ["m/s", "rad/s"])
    }

    /// Return the largest residual of each joint as text, in decreasing order; at most five joints are listed.
    fn residuals(&self, of: impl Fn(&Equation, &Row) -> f64, unit: [&str; 2]) -> String {
        let mut found: Vec<(f64, String)> = Vec::new();
        for (j, joint) in self.model.joints.iter().enumerate() {
            let rows = self.model.equations.iter().zip(&self.rows);
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
    pub(crate) fn asked(&self) -> String {
        let equations = self.model.equations.iter().zip(&self.rows);
        let driven = equations.filter_map(|(equation, row)| {
            equation.motion.as_ref().filter(|motion| motion.moves())?;
            let unit = if equation.is_angle() { "rad" } else { "m" };
            Some(format!(
                "driver {:?} prescribes {:.4e} {unit}, changing at {:.4e} {unit}/s",
                self.model.joints[equation.joint].name,
                equation.quantity(&self.frames) - row.value,
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
    pub(crate) fn refuse(&self) -> Error {
        if self.worst() <= 1e-9 {
            return Error::Impossible(format!(
                "no velocities satisfy all joints and drivers at the start; the nearest miss {}: two drivers may prescribe \
                 different speeds, or a driver may contradict the joints",
                self.rates()
            ));
        }
        Error::Impossible(format!(
            "the mechanism cannot be assembled; the nearest positions miss {}: check lengths, points and units of \
             these joints (SI: metres, radians)",
            self.misses()
        ))
    }
}

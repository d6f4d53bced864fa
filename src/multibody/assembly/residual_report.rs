//! What joints miss that cannot all hold, in words: residuals by joint, and what the drivers ask.

use crate::error::Error;
use crate::multibody::constraints::equation::{Equation, Row};
use crate::multibody::dynamics::MechanismDynamics;

/// Part of the largest residual below which a joint is not said to be missed.
const MISSED: f64 = 1e-6;

impl MechanismDynamics {
    /// What the joints miss where they cannot all hold: positions, or else velocities.
    pub(crate) fn what_misses(&self) -> String {
        let missed = if self.worst() <= 1e-9 {
            self.rates()
        } else {
            self.misses()
        };
        format!("{missed}{}", self.asked())
    }

    fn misses(&self) -> String {
        self.residuals(Equation::residual, ["m", "rad"])
    }

    fn rates(&self) -> String {
        let rate = |equation: &Equation, row: &Row| equation.residual_rate(row, &self.frames);
        self.residuals(rate, ["m/s", "rad/s"])
    }

    /// Largest residuals by joint, in words.
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

    /// What drivers ask that were to move something, in words.
    pub(crate) fn asked(&self) -> String {
        let equations = self.model.equations.iter().zip(&self.rows);
        let driven = equations.filter_map(|(equation, row)| {
            equation.motion.as_ref().filter(|motion| motion.moves())?;
            let unit = if equation.is_angle() { "rad" } else { "m" };
            Some(format!(
                "driver {:?} asks for {:.4e} {unit}, changing at {:.4e} {unit}/s",
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

    /// Why positions or velocities do not go together at the start.
    pub(crate) fn refuse(&self) -> Error {
        if self.worst() <= 1e-9 {
            return Error::Impossible(format!(
                "no velocities satisfy all joints and drivers at the start; the nearest miss {}: two drivers may ask \
                 for different speeds, or a driver may move what the joints hold",
                self.rates()
            ));
        }
        Error::Impossible(format!(
            "the mechanism does not go together; the nearest positions miss {}: check lengths, points and units of \
             these joints (SI: metres, radians)",
            self.misses()
        ))
    }
}

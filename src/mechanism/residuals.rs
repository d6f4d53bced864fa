//! How far the joints are from holding, beside the mechanism's size and speeds, and in words.

use super::dynamics::MechanismDynamics;
use super::equation::{Equation, Row};

impl MechanismDynamics {
    /// Size of the mechanism: its farthest point \[m\], and no less than the smallest radius of gyration, where all points come to
    /// lie in one place.
    pub(super) fn size(&self) -> f64 {
        let far = self.frames.iter().map(|f| f.origin.amax());
        let ends = self.model.equations.iter();
        let arms = ends.map(|e| e.a.point.amax().max(e.b.point.amax()));
        let gyration = self.model.mass.chunks_exact(3);
        let gyration = gyration.map(|body| (body[2] / body[0]).sqrt());
        let least = gyration.filter(|&radius| radius > 0.0).reduce(f64::min);
        let least = least.filter(|radius| radius.is_finite());
        let size = far.chain(arms).chain(least).fold(0.0, f64::max);
        if size > 0.0 { size } else { 1.0 }
    }

    /// Largest residual of the positions: lengths in parts of the size, angles in radians.
    pub(super) fn worst(&self) -> f64 {
        let size = self.size();
        let equations = self.model.equations.iter().zip(&self.rows);
        let parts = equations.map(|(equation, row)| {
            let unit = if equation.is_angle() { 1.0 } else { size };
            row.value.abs() / unit
        });
        parts.fold(
            0.0,
            |most: f64, part| {
                if part.is_nan() { part } else { most.max(part) }
            },
        )
    }

    /// What the joints miss where they cannot all hold: positions, or else velocities.
    pub(super) fn what_misses(&self) -> String {
        if self.worst() <= 1e-9 {
            return self.rates();
        }
        self.misses()
    }

    /// Speeds that the constraints compare; of a mechanism at rest a slow one.
    pub(super) fn speed(&self) -> f64 {
        let speeds = self
            .frames
            .iter()
            .map(|f| f.velocity.amax().max(f.spin.abs()));
        let prescribed = self.rows.iter().map(|row| row.time_rate.abs());
        speeds.chain(prescribed).fold(1e-3, f64::max)
    }

    /// What rounding leaves of residuals: a large angle is known less well.
    pub(super) fn round_off(&self) -> f64 {
        let angle = self
            .frames
            .iter()
            .map(|f| f.angle.abs())
            .fold(1.0, f64::max);
        2.0 * f64::EPSILON * angle
    }

    /// What positions miss.
    pub(super) fn misses(&self) -> String {
        self.residuals(Equation::residual, ["m", "rad"])
    }

    /// What velocities miss.
    pub(super) fn rates(&self) -> String {
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
        let worst: Vec<String> = found.into_iter().take(5).map(|(_, text)| text).collect();
        worst.join(", ")
    }
}

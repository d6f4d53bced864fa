//! Residuals of the constraints relative to the size and the speeds of the mechanism.

use crate::math::largest_magnitude;
use crate::multibody::constraints::constraint_state::ConstraintState;
use crate::multibody::description::body::Frame;
use crate::multibody::model::MechanismModel;

/// Least scale of velocity residuals \[m/s, rad/s\]: at rest it separates rounding from velocities that contradict the joints.
const LEAST_SPEED: f64 = 1e-3;

impl MechanismModel {
    /// Return the size of the mechanism \[m\]: the largest coordinate of a centre of mass or of a joint's point.
    ///
    /// It is at least the smallest radius of gyration, as all points may coincide.
    pub(crate) fn size(&self, frames: &[Frame]) -> f64 {
        let far = frames.iter().map(|f| f.origin.amax());
        let size = far.fold(self.least_size, f64::max);
        if size > 0.0 { size } else { 1.0 }
    }

    /// Return the part of the size that does not depend on the positions \[m\].
    pub(crate) fn size_of_parts(&self) -> f64 {
        let ends = self.equations.iter();
        let arms = ends.map(|e| e.a.point.amax().max(e.b.point.amax()));
        let gyration = self.mass.chunks_exact(3);
        let gyration = gyration.map(|body| (body[2] / body[0]).sqrt());
        let least = gyration.filter(|&radius| radius > 0.0).reduce(f64::min);
        let least = least.filter(|radius| radius.is_finite());
        arms.chain(least).fold(0.0, f64::max)
    }
}

impl ConstraintState {
    /// Return the largest residual of positions: lengths divided by the size, angles in radians.
    pub(crate) fn worst(&self, model: &MechanismModel, frames: &[Frame]) -> f64 {
        self.worst_beside(model, model.size(frames))
    }

    /// Return the same for a given size \[m\]; not a number where a residual is.
    pub(crate) fn worst_beside(&self, model: &MechanismModel, size: f64) -> f64 {
        let equations = model.equations.iter().zip(&self.rows);
        let part = 1.0 / size;
        largest_magnitude(equations.map(|(equation, row)| {
            let part = if equation.is_angle() { 1.0 } else { part };
            row.value * part
        }))
    }

    /// Return the scale of velocity residuals: the largest velocity component or prescribed rate, at least [`LEAST_SPEED`].
    pub(crate) fn speed(&self, frames: &[Frame]) -> f64 {
        let speeds = frames.iter().map(|f| f.velocity.amax().max(f.spin.abs()));
        let prescribed = self.rows.iter().map(|row| row.time_rate.abs());
        speeds.chain(prescribed).fold(LEAST_SPEED, f64::max)
    }
}

/// Return the round-off of relative residuals; it grows with the largest angle, whose absolute round-off is larger.
pub(super) fn round_off(frames: &[Frame]) -> f64 {
    let angles = frames.iter().map(|frame| frame.angle.abs());
    2.0 * f64::EPSILON * angles.fold(1.0, f64::max)
}

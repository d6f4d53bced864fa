//! Position and velocity of a sprocket in one evaluation.

use crate::chain::loads::SprocketKinematics;

/// Position and velocity of a sprocket.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SprocketPose {
    /// Centre \[m\].
    pub(crate) center: [f64; 2],
    /// Velocity of the centre \[m/s\].
    pub(crate) velocity: [f64; 2],
    /// Angle \[rad\].
    pub(crate) angle: f64,
    /// Angular velocity \[rad/s\].
    pub(crate) spin: f64,
    /// Cosine and sine of the angle.
    pub(crate) direction: [f64; 2],
}

impl SprocketPose {
    /// Return the same as vectors.
    pub(crate) fn kinematics(&self) -> SprocketKinematics {
        SprocketKinematics {
            center: self.center.into(),
            velocity: self.velocity.into(),
            angle: self.angle,
            spin: self.spin,
        }
    }
}

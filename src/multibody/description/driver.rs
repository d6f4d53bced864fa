//! Motion prescribed by a driver: a coordinate or its rate as a function of time.

use crate::error::{Error, Result};
use crate::math::Signal;

/// Motion of a relative coordinate prescribed by a driver.
#[derive(Debug, Clone, PartialEq)]
pub enum PrescribedMotion {
    /// The coordinate itself; its first two derivatives must be continuous.
    Position(Signal),
    /// Its rate; the initial value of the coordinate is that of the initial configuration.
    Speed(Signal),
}

impl PrescribedMotion {
    /// Return the coordinate (for a speed: its change since time zero) and its first two derivatives.
    pub(crate) fn derivatives(&self, t: f64) -> [f64; 3] {
        match self {
            Self::Position(function) => function.derivatives(t),
            Self::Speed(function) => {
                let [rate, acceleration, _] = function.derivatives(t);
                [function.integral(t), rate, acceleration]
            }
        }
    }

    /// Return whether the prescribed rate is not identically zero.
    pub(crate) fn moves(&self) -> bool {
        match self {
            Self::Position(function) => !matches!(function, Signal::Constant(_)),
            Self::Speed(function) => !matches!(function, Signal::Constant(0.0)),
        }
    }

    /// Return the longest step from `t` that skips no feature of the function of time \[s\].
    pub(crate) fn longest_step(&self, t: f64) -> f64 {
        let (Self::Position(function) | Self::Speed(function)) = self;
        function.longest_step(t)
    }

    /// Return whether the prescribed acceleration jumps at `t`, after `since` \[s\].
    pub(crate) fn jumps(&self, t: f64, since: f64) -> bool {
        matches!(self, Self::Speed(function) if function.has_corner(t, since))
    }

    /// Return `t`, or where the prescribed acceleration may jump there, a time before a jump after `since` \[s\] and behind any other.
    pub(crate) fn one_sided(&self, t: f64, since: f64) -> f64 {
        match self {
            Self::Position(_) => t,
            Self::Speed(function) => function.one_sided(t, since),
        }
    }

    /// Check every number, and that the motion has no jumps of the velocity.
    pub(crate) fn validate(&self, field: &str) -> Result<()> {
        match self {
            Self::Position(Signal::Table(_)) => Err(Error::invalid(
                field,
                "a table with corners",
                "would need an infinite force at each corner: give a spline, or the speed as a table",
            )),
            Self::Position(function) | Self::Speed(function) => function.validate(field),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_position_with_corners_is_refused() {
        let motion = PrescribedMotion::Position(Signal::ramp(0.0, 1.0, 0.0, 1.0).unwrap());
        let error = motion.validate("driver").unwrap_err();
        assert!(error.to_string().contains("spline"));
    }
}

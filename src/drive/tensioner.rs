//! A gradual tensioner: pulls a sprocket's centre along a line.

use crate::error::{Error, Result, check};
use crate::geometry::Vec2;

/// The sprocket's centre slides, pulled by a force that grows linearly and then stays, damped by a dashpot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tensioner {
    /// Which sprocket it moves, from 1.
    pub sprocket: usize,
    /// Tension it gives each strand \[N\].
    pub pretension: f64,
    /// Time in which the pull grows \[s\].
    pub ramp_time: f64,
    /// Dashpot \[N s/m\].
    pub damping: f64,
    /// Direction of the pull; `None`: away from the other sprocket.
    pub direction: Option<Vec2>,
}

impl Tensioner {
    /// Checks every field.
    ///
    /// # Errors
    /// Names the field, its value and what is allowed.
    pub fn validate(&self) -> Result<()> {
        check::not_negative("Tensioner.pretension", self.pretension, "N")?;
        check::not_negative("Tensioner.ramp_time", self.ramp_time, "s")?;
        check::not_negative("Tensioner.damping", self.damping, "N s/m")?;
        if let Some(d) = self.direction {
            let length = d.norm();
            if !(length.is_finite() && length > 0.0) {
                return Err(Error::invalid(
                    "Tensioner.direction",
                    format!("({}, {})", d.x, d.y),
                    "must be a direction: two finite numbers, not both zero",
                ));
            }
        }
        Ok(())
    }

    /// The share of the full pull at time `t` \[s\].
    #[must_use]
    pub fn ramp(&self, t: f64) -> f64 {
        if t >= self.ramp_time {
            1.0
        } else {
            (t / self.ramp_time).max(0.0)
        }
    }
}

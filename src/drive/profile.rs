//! The tooth form a user asks for.

use crate::error::{Result, check};
use crate::geometry::Seat;

/// A tooth after ANSI/ASME B29.1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AnsiTooth {
    /// Where the seating curve's centre lies.
    pub seat: Seat,
    /// Roller diameter Dr that the tooth is cut for \[m\]; `None`: the chain's bushing diameter.
    pub roller_diameter: Option<f64>,
}

impl Default for AnsiTooth {
    fn default() -> Self {
        Self {
            seat: Seat::BottomDiameter,
            roller_diameter: None,
        }
    }
}

impl AnsiTooth {
    /// Checks every field.
    ///
    /// # Errors
    /// Names the field, its value and what is allowed.
    pub fn validate(&self) -> Result<()> {
        self.roller_diameter.map_or(Ok(()), |d| {
            check::positive("AnsiTooth.roller_diameter", d, "m")
        })
    }
}

//! What the user describes: plain data in SI, validated once.

mod belt_line;
mod chain;
mod material;
mod profile;
mod rail;
mod sprocket;
mod tensioner;
mod time_table;
mod variation;

pub use belt_line::BeltLine;
pub use chain::{Chain, ClearanceHinge, Link, Roller, check_links};
pub use material::Material;
pub use profile::{AnsiTooth, CustomTooth, IsoTooth, StraightTooth, Tip, ToothForm};
pub use rail::{Arm, Mount, Rail, RailShape};
pub use sprocket::{Bearing, Faults, Motion, Sprocket};
pub use tensioner::{Tensioner, TensionerLine};
pub use time_table::TimeTable;
pub use variation::Variation;

use crate::error::{Error, Result, check};
use crate::geometry::Vec2;
use crate::geometry::belt::Side;

/// A chain drive.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// The chain.
    pub chain: Chain,
    /// The sprockets in the order in which the chain meets them, one way round or the other; the first one is the driver by custom.
    pub sprockets: Vec<Sprocket>,
    /// What tightens it, if anything does.
    pub tensioner: Option<Tensioner>,
    /// Gravity \[m/s²\].
    pub gravity: Vec2,
    /// Rails, blades and smooth idlers that the chain bears on besides.
    pub guides: Vec<Rail>,
}

impl Drive {
    /// Number of bodies: links, rollers, sprockets, guides.
    #[must_use]
    pub fn bodies(&self) -> usize {
        self.first_wheel() + self.sprockets.len() + self.guides.len()
    }

    /// Number of the first sprocket among the bodies.
    #[must_use]
    pub fn first_wheel(&self) -> usize {
        self.chain.links as usize + self.chain.rollers()
    }

    /// Checks every part and that the parts fit together.
    ///
    /// # Errors
    /// Names the field, its value and what is allowed.
    pub fn validate(&self) -> Result<()> {
        self.chain.validate()?;
        for sprocket in &self.sprockets {
            sprocket.validate()?;
            sprocket.check_against(&self.chain)?;
        }
        if self.sprockets.len() < 2 {
            return Err(Error::invalid(
                "ChainDrive.sprockets",
                format!("{} sprockets", self.sprockets.len()),
                "must be at least two",
            ));
        }
        let inside = self.sprockets.iter().filter(|s| s.side == Side::Inside);
        if inside.count() < 2 {
            return Err(Error::invalid(
                "Sprocket.side",
                "\"outside\"",
                "at least two sprockets must stand inside the chain to hold it open",
            ));
        }
        for (name, value) in [("x", self.gravity.x), ("y", self.gravity.y)] {
            check::finite(&format!("ChainDrive.gravity ({name})"), value, "m/s^2")?;
        }
        for guide in &self.guides {
            guide.validate()?;
            guide.validate_for(self.chain.contact_radius())?;
        }
        if let Some(tensioner) = &self.tensioner {
            tensioner.validate()?;
            let Some(sprocket) = self.sprockets.get(tensioner.sprocket.wrapping_sub(1)) else {
                return Err(Error::invalid(
                    "Tensioner.sprocket",
                    tensioner.sprocket,
                    format!(
                        "must be the number of a sprocket, 1 to {}",
                        self.sprockets.len()
                    ),
                ));
            };
            if sprocket.bearing == Bearing::Floating {
                return Err(Error::invalid(
                    "Tensioner.sprocket",
                    tensioner.sprocket,
                    "its sprocket has bearing=\"floating\"; a tensioner moves one with bearing=\"fixed\"",
                ));
            }
        }
        Ok(())
    }
}

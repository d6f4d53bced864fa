//! Description of a chain drive: plain data in SI units, validated once.

mod belt_line;
mod chain;
mod ends;
mod loads;
mod material;
mod open_line;
mod plates;
mod profile;
mod rail;
mod sprocket;
mod tensioner;
mod variation;

pub use belt_line::BeltLine;
pub(crate) use chain::MOST_LINKS;
pub use chain::{Chain, ClearanceHinge, Link, Roller, bushing_on_front, check_links};
pub use ends::ChainEnd;
pub(crate) use loads::MOST_CHAIN_SPEED;
pub use loads::{InputBounds, InputQuantity};
pub(crate) use loads::{sprocket_of, tensioner_force};
pub use material::Material;
pub(crate) use open_line::OpenLine;
pub use plates::{LinkStiffness, Plates};
pub use profile::{AnsiTooth, CustomTooth, IsoTooth, StraightTooth, TEETH, Tip, ToothForm};
pub use rail::{Arm, Mount, Rail, RailShape};
pub use sprocket::{Bearing, Faults, Sprocket, SprocketMotion};
pub(crate) use tensioner::STOP_STIFFNESS;
pub use tensioner::{Tensioner, TensionerLine};
pub use variation::Variation;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, check};
use crate::geometry::Vec2;
use crate::geometry::path::belt::Side;

/// Largest number of pairs of a bushing and a sprocket or guide; a pair takes 150 bytes.
const MOST_PAIRS: f64 = 1e7;

/// Kind of the hinges between the links of a chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum HingeKind {
    /// Pins with clearance in their bushings.
    #[default]
    Clearance,
    /// Joints without clearance.
    Ideal,
}

/// A chain drive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    /// The chain.
    pub chain: Chain,
    /// Sprockets in the order along the chain path, in either direction; by convention the first one is the driver.
    pub sprockets: Vec<Sprocket>,
    /// Tensioner, if any.
    pub tensioner: Option<Tensioner>,
    /// Gravity \[m/s²\].
    #[serde(with = "crate::geometry::components")]
    pub gravity: Vec2,
    /// Rails, blades and smooth idlers.
    pub guides: Vec<Rail>,
    /// Ends of an open chain, before its first link and after its last; `None` for a closed chain. An open chain may have no
    /// sprocket.
    pub ends: Option<[ChainEnd; 2]>,
    /// Kind of the hinges.
    pub hinge_kind: HingeKind,
}

impl Drive {
    /// Let the tensioner and the plungers of guides push with their full force from the beginning.
    pub(crate) fn end_ramps(&mut self) {
        if let Some(tensioner) = &mut self.tensioner {
            tensioner.ramp_time = 0.0;
        }
        for guide in &mut self.guides {
            if let Mount::Arm(arm) = &mut guide.mount {
                arm.ramp_time = 0.0;
            }
        }
    }

    /// Return the number of bodies: links, both ends of an open chain, rollers, sprockets, guides.
    #[must_use]
    pub fn bodies(&self) -> usize {
        self.first_wheel() + self.sprockets.len() + self.guides.len()
    }

    /// Return the body of the first sprocket; links, ends of an open chain and rollers precede it.
    #[must_use]
    pub fn first_wheel(&self) -> usize {
        self.hinges() + self.rollers()
    }

    /// Return the number of rollers with their own degrees of freedom: one per hinge, or none.
    #[must_use]
    pub fn rollers(&self) -> usize {
        self.chain.roller.map_or(0, |_| self.hinges())
    }

    /// Return the number of hinges: links, and both ends of an open chain, which close it to a ring.
    #[must_use]
    pub fn hinges(&self) -> usize {
        self.chain.links as usize + if self.ends.is_some() { 2 } else { 0 }
    }

    fn check_closed(&self) -> Result<()> {
        if self.sprockets.len() < 2 {
            return Err(Error::invalid(
                "ChainDrive.sprockets",
                format!("{} sprockets", self.sprockets.len()),
                "must be at least two; an open chain, with ends=, needs none",
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
        Ok(())
    }

    /// Check that all parts lie within the length of the longest chain of each other.
    fn check_extent(&self) -> Result<()> {
        let longest = f64::from(MOST_LINKS) * self.chain.pitch;
        let sprockets = self.sprockets.iter().enumerate();
        let sprockets = sprockets.map(|(i, s)| (format!("sprockets.{}.center", i + 1), s.center));
        let guides = self.guides.iter().enumerate();
        let guides = guides.map(|(i, guide)| (format!("guides.{}.center", i + 1), guide.center));
        let ends = self.ends.iter().flatten().enumerate();
        let ends =
            ends.filter_map(|(i, end)| Some((format!("ends.{}.position", i + 1), end.position()?)));
        let mut places = sprockets.chain(ends).chain(guides).peekable();
        let origin = places.peek().map_or(Vec2::zeros(), |(_, origin)| *origin);
        for (name, place) in places {
            let apart = (place - origin).norm();
            if apart > longest || apart.is_nan() {
                return Err(Error::invalid(
                    format!("ChainDrive.{name}"),
                    format!("{:?}", (place.x, place.y)),
                    format!(
                        "must lie within {longest} m of {:?}, {MOST_LINKS} pitches; lengths are in metres",
                        (origin.x, origin.y)
                    ),
                ));
            }
        }
        for (i, guide) in self.guides.iter().enumerate() {
            let field = format!("ChainDrive.guides.{}, its largest extent", i + 1);
            let extent = 2.0 * guide.profile()?.outside_radius;
            check::within(&field, extent, 0.0, longest)?;
        }
        Ok(())
    }

    fn check_pairs(&self) -> Result<()> {
        let wheels = self.sprockets.len() + self.guides.len();
        let field = "hinges times sprockets and guides of the ChainDrive";
        let pairs = self.hinges() as f64 * wheels as f64;
        check::within(field, pairs, 0.0, MOST_PAIRS)
    }

    /// Check every part and the parts against each other.
    ///
    /// # Errors
    /// When a field is out of range: names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        self.chain.validate()?;
        for sprocket in &self.sprockets {
            sprocket.validate()?;
            sprocket.check_against(&self.chain)?;
        }
        match &self.ends {
            Some(ends) => ends::check_ends(ends, &self.chain)?,
            None => self.check_closed()?,
        }
        for (name, value) in [("x", self.gravity.x), ("y", self.gravity.y)] {
            check::finite(&format!("ChainDrive.gravity ({name})"), value, "m/s^2")?;
        }
        self.check_ideal_hinges()?;
        self.check_loads()?;
        for guide in &self.guides {
            guide.validate()?;
            guide.validate_for(self.chain.contact_radius())?;
        }
        self.check_extent()?;
        self.check_pairs()?;
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

    /// Return an error for parts that need hinges with clearance.
    fn check_ideal_hinges(&self) -> Result<()> {
        if self.hinge_kind != HingeKind::Ideal {
            return Ok(());
        }
        if let Some(stiffness) = self.chain.axial_stiffness() {
            return Err(Error::invalid(
                "Chain.link_stiffness",
                format!("{stiffness} N/m in all"),
                "must be None with ideal hinges, whose links are rigid, or take hinges=\"clearance\"",
            ));
        }
        Ok(())
    }
}

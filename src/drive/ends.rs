//! The two ends of an open chain: anchored, loaded or free.

use serde::{Deserialize, Serialize};

use super::Chain;
use super::material::STEEL_DENSITY;
use crate::error::{Error, Result, check};
use crate::geometry::Vec2;
use crate::math::Signal;

/// Boundary condition of one end of an open chain; the hinge is like those of the chain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum ChainEnd {
    /// A pin at rest or with prescribed velocity.
    Anchored {
        /// Position at the start \[m\].
        #[serde(with = "crate::geometry::components")]
        position: Vec2,
        /// Velocity, x and y \[m/s\].
        velocity: [Signal; 2],
        /// Links between the pin and the first sprocket; `None`: the smallest number that fits.
        links: Option<u32>,
    },
    /// A body attached to the end.
    Loaded {
        /// Mass \[kg\].
        mass: f64,
        /// Moment of inertia about its centre of mass \[kg m²\].
        inertia: f64,
        /// Distance of the centre of mass from the pin \[m\].
        arm: f64,
        /// Position of its pin at the start \[m\]; `None`: straight below the last sprocket or the other end.
        #[serde(with = "crate::geometry::components")]
        position: Option<Vec2>,
        /// Links between it and the first sprocket.
        links: Option<u32>,
    },
    /// No body.
    Free {
        /// Position at the start \[m\]; `None`: straight below the last sprocket or the other end.
        #[serde(with = "crate::geometry::components")]
        position: Option<Vec2>,
        /// Links between it and the first sprocket.
        links: Option<u32>,
    },
}

impl ChainEnd {
    /// Return the moment of inertia of a steel ball of this mass \[kg m²\], the default of a load: J = 2/5 m r².
    #[must_use]
    pub fn ball_inertia(mass: f64) -> f64 {
        let radius = (mass / (STEEL_DENSITY * 4.0 / 3.0 * std::f64::consts::PI)).cbrt();
        0.4 * mass * radius * radius
    }

    /// Return an anchored end at rest.
    #[must_use]
    pub fn anchored(position: Vec2) -> Self {
        Self::Anchored {
            position,
            velocity: [0.0.into(), 0.0.into()],
            links: None,
        }
    }

    /// Return a loaded end with its centre of mass in the pin.
    #[must_use]
    pub fn loaded(mass: f64, inertia: f64) -> Self {
        Self::Loaded {
            mass,
            inertia,
            arm: 0.0,
            position: None,
            links: None,
        }
    }

    /// Return a free end.
    #[must_use]
    pub fn free() -> Self {
        Self::Free {
            position: None,
            links: None,
        }
    }

    /// Return the name in descriptions.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Anchored { .. } => "AnchoredEnd",
            Self::Loaded { .. } => "LoadedEnd",
            Self::Free { .. } => "FreeEnd",
        }
    }

    /// Return the position at the start \[m\], if it is given.
    #[must_use]
    pub fn position(&self) -> Option<Vec2> {
        match self {
            Self::Anchored { position, .. } => Some(*position),
            Self::Loaded { position, .. } | Self::Free { position, .. } => *position,
        }
    }

    /// Return the number of links between the end and the first sprocket, if it is given.
    #[must_use]
    pub fn links(&self) -> Option<u32> {
        match self {
            Self::Anchored { links, .. }
            | Self::Loaded { links, .. }
            | Self::Free { links, .. } => *links,
        }
    }

    /// Return the velocity at the start \[m/s\].
    #[must_use]
    pub fn velocity(&self) -> Vec2 {
        match self {
            Self::Anchored { velocity, .. } => {
                Vec2::new(velocity[0].value(0.0), velocity[1].value(0.0))
            }
            _ => Vec2::zeros(),
        }
    }

    /// Return the distance of the centre of mass from the pin \[m\].
    #[must_use]
    pub fn arm(&self) -> f64 {
        match self {
            Self::Loaded { arm, .. } => *arm,
            _ => 0.0,
        }
    }

    /// Check every field.
    ///
    /// # Errors
    /// When a field is out of range: names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        let name = self.name();
        if let Some(position) = self.position() {
            check::point(&format!("{name}.position"), position)?;
        }
        if self.links() == Some(0) {
            let expected = "must be one at least";
            return Err(Error::invalid(format!("{name}.links"), 0, expected));
        }
        if let Self::Loaded {
            mass, inertia, arm, ..
        } = self
        {
            check::positive("LoadedEnd.mass", *mass, "kg")?;
            check::positive("LoadedEnd.inertia", *inertia, "kg m^2")?;
            check::not_negative("LoadedEnd.arm", *arm, "m")?;
        }
        Ok(())
    }
}

/// Check both ends, and the chain between them.
///
/// # Errors
/// When a field is out of range: names the field, its value and the range.
pub(super) fn check_ends(ends: &[ChainEnd; 2], chain: &Chain) -> Result<()> {
    for end in ends {
        end.validate()?;
    }
    if let Some(offset) = chain.offset {
        return Err(Error::invalid(
            "Chain.offset",
            format!("a link of {} kg", offset.mass),
            "must be absent in an open chain: any number of links alternates from end to end",
        ));
    }
    let counted = ends
        .iter()
        .filter_map(ChainEnd::links)
        .map(u64::from)
        .sum::<u64>();
    if counted > u64::from(chain.links) {
        return Err(Error::invalid(
            "links of the ends",
            counted,
            format!("must be at most the chain's, {}", chain.links),
        ));
    }
    Ok(())
}

//! The two ends of an open chain: pinned, carried by a moving point, loaded, or loose.

use super::{Chain, TimeTable};
use crate::error::{Error, Result, check};
use crate::geometry::Vec2;

/// What an end of an open chain is joined to, by a hinge like those of the chain.
#[derive(Debug, Clone, PartialEq)]
pub enum ChainEnd {
    /// A pin that stands still or moves as it is told.
    Anchor {
        /// Where it is at the start \[m\].
        position: Vec2,
        /// Its velocity, x and y \[m/s\].
        velocity: [TimeTable; 2],
        /// Links between it and the first sprocket; none: as few as reach.
        links: Option<u32>,
    },
    /// A body that hangs from the chain.
    Load {
        /// Mass \[kg\].
        mass: f64,
        /// Moment of inertia about its centre of mass \[kg m²\].
        inertia: f64,
        /// From its pin to its centre of mass \[m\].
        arm: f64,
        /// Where its pin is at the start \[m\]; none: straight down from the last sprocket, or from the other end.
        position: Option<Vec2>,
        /// Links between it and the first sprocket.
        links: Option<u32>,
    },
    /// Nothing.
    Loose {
        /// Where it is at the start \[m\]; none: straight down from the last sprocket, or from the other end.
        position: Option<Vec2>,
        /// Links between it and the first sprocket.
        links: Option<u32>,
    },
}

impl ChainEnd {
    /// An anchor at rest.
    #[must_use]
    pub fn anchor(position: Vec2) -> Self {
        Self::Anchor {
            position,
            velocity: [0.0.into(), 0.0.into()],
            links: None,
        }
    }

    /// A load whose centre of mass is in its pin.
    #[must_use]
    pub fn load(mass: f64, inertia: f64) -> Self {
        Self::Load {
            mass,
            inertia,
            arm: 0.0,
            position: None,
            links: None,
        }
    }

    /// A loose end.
    #[must_use]
    pub fn loose() -> Self {
        Self::Loose {
            position: None,
            links: None,
        }
    }

    /// Its name in descriptions.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Anchor { .. } => "AnchoredEnd",
            Self::Load { .. } => "LoadedEnd",
            Self::Loose { .. } => "FreeEnd",
        }
    }

    /// Where it begins, if that is given \[m\].
    #[must_use]
    pub fn position(&self) -> Option<Vec2> {
        match self {
            Self::Anchor { position, .. } => Some(*position),
            Self::Load { position, .. } | Self::Loose { position, .. } => *position,
        }
    }

    /// How many links lie between it and the first sprocket, if that is given.
    #[must_use]
    pub fn links(&self) -> Option<u32> {
        match self {
            Self::Anchor { links, .. } | Self::Load { links, .. } | Self::Loose { links, .. } => {
                *links
            }
        }
    }

    /// Its velocity at the start \[m/s\].
    #[must_use]
    pub fn velocity(&self) -> Vec2 {
        match self {
            Self::Anchor { velocity, .. } => {
                Vec2::new(velocity[0].value(0.0), velocity[1].value(0.0))
            }
            _ => Vec2::zeros(),
        }
    }

    /// Distance of its centre of mass from its pin \[m\].
    #[must_use]
    pub fn arm(&self) -> f64 {
        match self {
            Self::Load { arm, .. } => *arm,
            _ => 0.0,
        }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// Names the field, its value and what is allowed.
    pub fn validate(&self) -> Result<()> {
        let name = self.name();
        if let Some(position) = self.position() {
            for (axis, value) in [("x", position.x), ("y", position.y)] {
                check::finite(&format!("{name}.position ({axis})"), value, "m")?;
            }
        }
        if self.links() == Some(0) {
            let expected = "must be one at least";
            return Err(Error::invalid(format!("{name}.links"), 0, expected));
        }
        if let Self::Load {
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

/// Checks two ends and that the chain suits them.
///
/// # Errors
/// Names the field, its value and what is allowed.
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

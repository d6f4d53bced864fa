//! Friction and lubricant of contacts and of the pins of revolute joints, as they are described.

use super::contact_law::ContactLaw;
use super::profile::Profile;
use crate::error::{Error, Result, check};
use crate::force_law::{Film, Friction, HingeFilm, LuGre};

/// Friction of a contact: a share of its normal force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrictionLaw {
    /// Coulomb's friction as a function of the sliding velocity.
    Coulomb(Friction),
    /// Bristles, whose deflection is an unknown of the state.
    LuGre(LuGre),
}

/// What a contact has beside its normal force; by default nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tribology {
    /// Friction of the surfaces.
    pub friction: Option<FrictionLaw>,
    /// Lubricant film between a pin and its bore.
    pub film: Option<Film>,
}

/// Friction of the pin of an ideal revolute joint: a torque of radius times share times reaction force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PinFriction {
    /// Radius of the pin \[m\].
    pub radius: f64,
    /// Share of the reaction force by the sliding velocity, radius times relative angular velocity.
    pub law: Friction,
}

impl PinFriction {
    /// Checks every number.
    ///
    /// # Errors
    /// Names `joint`, the field and what is allowed.
    pub fn validate(&self, joint: &str) -> Result<()> {
        check::positive(&format!("radius of {joint}"), self.radius, "m")?;
        self.law.check(&format!("friction of {joint}"))
    }
}

impl Tribology {
    /// Checks every number, and that a film has a bore to be in.
    ///
    /// # Errors
    /// Names `contact`, the field and what is allowed.
    pub fn validate(&self, contact: &str, profile: &Profile, law: &ContactLaw) -> Result<()> {
        match &self.friction {
            Some(FrictionLaw::Coulomb(law)) => law.check(&format!("friction of {contact}"))?,
            Some(FrictionLaw::LuGre(law)) => law.check(&format!("friction of {contact}"))?,
            None => {}
        }
        let Some(film) = &self.film else {
            return Ok(());
        };
        let field = format!("film of {contact}");
        film.check(&field)?;
        if !matches!(profile, Profile::Bore { .. }) {
            return Err(Error::invalid(
                field,
                "given",
                "must be none: only clearance joints, a pin in a bore, have a lubricant film",
            ));
        }
        if film.length.is_none() && law.length().is_none() {
            return Err(Error::invalid(
                format!("length of the {field}"),
                "none",
                "give the film a length [m]: the contact law has none",
            ));
        }
        Ok(())
    }

    /// The film between a pin and its bore.
    pub(crate) fn film_of(
        &self,
        profile: &Profile,
        pin_radius: f64,
        law: &ContactLaw,
    ) -> Option<HingeFilm> {
        let (film, Profile::Bore { radius }) = (self.film?, profile) else {
            return None;
        };
        let length = film.length.or(law.length())?;
        Some(film.between(pin_radius, radius - pin_radius, length))
    }

    /// The bristles of the surfaces, where friction is of bristles.
    pub(crate) fn bristles(&self) -> Option<LuGre> {
        match self.friction {
            Some(FrictionLaw::LuGre(law)) => Some(law),
            _ => None,
        }
    }
}

//! Description of friction and lubricant films of contacts and of friction in the pins of revolute joints.

use super::contact_law::ContactLaw;
use super::profile::Profile;
use crate::error::{Error, Result, check};
use crate::force_law::{Film, Friction, HingeFilm, LuGre};

/// Friction law of a contact: ratio of the friction force to the normal force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrictionLaw {
    /// Regularised Coulomb friction, a function of the sliding velocity.
    Coulomb(Friction),
    /// Bristle model with the deflection as an unknown of the state.
    LuGre(LuGre),
}

/// Friction and lubricant film of a contact; both are absent by default.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tribology {
    /// Friction of the surfaces.
    pub friction: Option<FrictionLaw>,
    /// Lubricant film between a pin and its bore.
    pub film: Option<Film>,
}

/// Friction of the pin of an ideal revolute joint: torque = radius · friction ratio · reaction force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PinFriction {
    /// Radius of the pin \[m\].
    pub radius: f64,
    /// Ratio of friction to reaction force by the sliding velocity, which is radius times relative angular velocity.
    pub law: Friction,
}

impl PinFriction {
    /// Check every number.
    ///
    /// # Errors
    /// An invalid value; the message has `joint`, the field and the permitted values.
    pub fn validate(&self, joint: &str) -> Result<()> {
        check::positive(&format!("radius of {joint}"), self.radius, "m")?;
        self.law.check(&format!("friction of {joint}"))
    }
}

impl Tribology {
    /// Check every number, and that a film belongs to a pin in a bore.
    ///
    /// # Errors
    /// An invalid value; the message has `contact`, the field and the permitted values.
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

    /// Return the film between a pin and its bore, if there is one.
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

    /// Return the bristle model, if it is the friction law.
    pub(crate) fn bristles(&self) -> Option<LuGre> {
        match self.friction {
            Some(FrictionLaw::LuGre(law)) => Some(law),
            _ => None,
        }
    }
}

//! Description of the contacts of a mechanism: a circle of body b and a profile of body a; a pin in a bore is a clearance joint.

use super::body::Marker;
use super::contact_law::ContactLaw;
use super::profile::Profile;
use super::tribology::Tribology;
use crate::error::{Error, Result, check};

/// A contact pair of a circle and a profile.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPair {
    /// Unique name.
    pub name: String,
    /// Origin of the profile.
    pub a: Marker,
    /// Centre of the circle.
    pub b: Marker,
    /// Profile on `a`, in the frame of `a` with the marker's point as origin.
    pub profile: Profile,
    /// Radius of the circle \[m\].
    pub radius: f64,
    /// Normal force law.
    pub law: ContactLaw,
    /// Friction and lubricant film.
    pub tribology: Tribology,
}

impl ContactPair {
    /// Check every field.
    ///
    /// # Errors
    /// An invalid value; the message has the contact, the field and the permitted values.
    pub fn validate(&self) -> Result<()> {
        let field = format!("contact {:?}", self.name);
        self.a.validate(&format!("point of {field}"))?;
        self.b.validate(&format!("point of {field}"))?;
        if self.a.body == self.b.body {
            return Err((self.a).same_body(&field, ": a body does not touch itself"));
        }
        let name = match self.profile {
            Profile::Bore { .. } => "pin_radius",
            Profile::Disc { .. } => "radius_b",
            Profile::Teeth(_) | Profile::Outline { .. } => "radius",
        };
        check::positive(&format!("{name} of {field}"), self.radius, "m")?;
        self.profile.validate(&field)?;
        if let Profile::Bore { radius } = self.profile
            && self.radius >= radius
        {
            return Err(Error::invalid(
                format!("{name} of {field}"),
                format!("{} m", self.radius),
                format!("must be below bore_radius, {radius} m: the difference is the clearance"),
            ));
        }
        self.law.validate(&field)?;
        self.tribology.validate(&field, &self.profile, &self.law)
    }
}

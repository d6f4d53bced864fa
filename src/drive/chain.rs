//! The chain: links, hinges and contact surfaces.

use serde::{Deserialize, Serialize};

use super::{LinkStiffness, Material, Variation};
use crate::error::{Error, Result, check};

/// Largest number of links: 1.3 km of a half-inch chain. Beyond this length rounding of positions exceeds the default accuracy; a run
/// takes 0.3 GB.
pub(crate) const MOST_LINKS: u32 = 100_000;

/// Mass properties of a link about its centre, midway between its hinges.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// Mass \[kg\].
    pub mass: f64,
    /// Moment of inertia \[kg m²\].
    pub inertia: f64,
}

/// A pin in a bushing with clearance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ClearanceHinge {
    /// Radius of the pin \[m\].
    pub pin_radius: f64,
    /// Radius of the bushing's bore \[m\].
    pub bore_radius: f64,
    /// Length of contact \[m\].
    pub length: f64,
}

impl ClearanceHinge {
    /// Radial clearance c \[m\].
    #[must_use]
    pub fn clearance(&self) -> f64 {
        self.bore_radius - self.pin_radius
    }
}

/// A roller on its bushing with radial play: a hollow cylinder with its own degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Roller {
    /// Outside radius, in contact with the teeth \[m\].
    pub radius: f64,
    /// Radius of its bore \[m\].
    pub bore_radius: f64,
    /// Length of contact of bushing and bore \[m\].
    pub length: f64,
    /// Mass \[kg\].
    pub mass: f64,
    /// Moment of inertia about its axis \[kg m²\].
    pub inertia: f64,
}

/// A bushing chain: inner links with two bushings alternate with outer links with two pins. In a closed chain of an odd number of
/// links the last one is an offset link: bushing at its rear, pin at its front.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Chain {
    /// Pitch: distance of the hinges of a link \[m\].
    pub pitch: f64,
    /// Number of links.
    pub links: u32,
    /// Inner links: links 1, 3, ...
    pub inner: Link,
    /// Outer links: links 2, 4, ...
    pub outer: Link,
    /// Clearance hinges.
    pub hinge: ClearanceHinge,
    /// Outside radius of the bushings \[m\].
    pub bushing_radius: f64,
    /// Length of contact between teeth and bushing or roller \[m\].
    pub tooth_contact_length: f64,
    /// Material of all contacts.
    pub material: Material,
    /// Offset link of an odd number of links; `None`: the mean of an inner and an outer link.
    pub offset: Option<Link>,
    /// Parallel strands on common pins; masses and lengths of contact are those of one.
    pub strands: u32,
    /// Deviations of the link lengths from the pitch.
    pub variation: Variation,
    /// Rollers on the bushings; they are then in contact with the teeth, and the mass of inner links excludes them.
    pub roller: Option<Roller>,
    /// Axial stiffness of the links of one strand; `None`: rigid links.
    pub link_stiffness: Option<LinkStiffness>,
    /// Attached masses in the middle of links: number of the link, from 1, and mass \[kg\] for all strands.
    pub carried: Vec<(u32, f64)>,
}

impl Chain {
    /// Check every field.
    ///
    /// # Errors
    /// When a field is out of range: names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        check::positive("Chain.pitch", self.pitch, "m")?;
        check_links("Chain.links", self.links)?;
        for (name, link) in [("inner", self.inner), ("outer", self.outer)] {
            check::positive(&format!("Chain.{name}.mass"), link.mass, "kg")?;
            check::positive(&format!("Chain.{name}.inertia"), link.inertia, "kg m^2")?;
        }
        if let Some(offset) = self.offset {
            check::positive("Chain.offset.mass", offset.mass, "kg")?;
            check::positive("Chain.offset.inertia", offset.inertia, "kg m^2")?;
            if self.links.is_multiple_of(2) {
                return Err(Error::invalid(
                    "Chain.offset",
                    format!("a link of {} kg", offset.mass),
                    format!(
                        "must be absent in a chain of {} links: only an odd number needs an offset link",
                        self.links
                    ),
                ));
            }
        }
        if !(1..=24).contains(&self.strands) {
            return Err(Error::invalid(
                "Chain.strands",
                self.strands,
                "must be between 1 and 24",
            ));
        }
        self.variation.validate(self.links)?;
        if let Some(stiffness) = &self.link_stiffness {
            stiffness.validate()?;
        }
        self.check_carried()?;
        self.hinge.validate()?;
        check::positive("Chain.bushing_radius", self.bushing_radius, "m")?;
        if self.bushing_radius <= self.hinge.bore_radius {
            return Err(Error::invalid(
                "Chain.bushing_radius",
                self.bushing_radius,
                format!(
                    "must be larger than the bore's, {} m",
                    self.hinge.bore_radius
                ),
            ));
        }
        if let Some(roller) = &self.roller {
            roller.validate()?;
            roller.check_on(self.bushing_radius, self.pitch)?;
        } else if 2.0 * self.bushing_radius >= self.pitch {
            return Err(Error::invalid(
                "Chain.bushing_radius",
                self.bushing_radius,
                format!(
                    "neighbouring bushings would overlap: must be below half the pitch, {} m",
                    0.5 * self.pitch
                ),
            ));
        }
        check::positive("Chain.tooth_contact_length", self.tooth_contact_length, "m")?;
        self.material.validate()
    }

    fn check_carried(&self) -> Result<()> {
        for (i, (number, mass)) in self.carried.iter().enumerate() {
            if !(1..=self.links).contains(number) {
                let expected = format!("must name links by their numbers, 1 to {}", self.links);
                return Err(Error::invalid("Chain.carried", number, expected));
            }
            check::positive("Chain.carried (mass)", *mass, "kg")?;
            if self.carried[..i].iter().any(|(other, _)| other == number) {
                let expected = "must name each link once";
                return Err(Error::invalid("Chain.carried", number, expected));
            }
        }
        Ok(())
    }

    /// Return link `i`, from 0, with the mass of all strands.
    #[must_use]
    pub fn link(&self, i: usize) -> Link {
        let last_of_odd = i + 1 == self.links as usize && !self.links.is_multiple_of(2);
        if !last_of_odd {
            return self.strand_link(i);
        }
        let offset = self.offset.unwrap_or(Link {
            mass: 0.5 * (self.inner.mass + self.outer.mass),
            inertia: 0.5 * (self.inner.inertia + self.outer.inertia),
        });
        self.loaded(i, offset)
    }

    /// Return link `i` of an open chain, from 0, with all strands: inner and outer links alternate to the last.
    #[must_use]
    pub fn strand_link(&self, i: usize) -> Link {
        let link = if i.is_multiple_of(2) {
            self.inner
        } else {
            self.outer
        };
        self.loaded(i, link)
    }

    /// Return link `i`, from 0, with all strands and its attached mass.
    fn loaded(&self, i: usize, link: Link) -> Link {
        let strands = f64::from(self.strands);
        let mine = self
            .carried
            .iter()
            .find(|(number, _)| *number as usize == i + 1);
        Link {
            mass: strands * link.mass + mine.map_or(0.0, |(_, mass)| *mass),
            inertia: strands * link.inertia,
        }
    }

    /// Return the outside radius in contact with the teeth: of the rollers, or of the bushings without rollers \[m\].
    #[must_use]
    pub fn contact_radius(&self) -> f64 {
        self.roller
            .map_or(self.bushing_radius, |roller| roller.radius)
    }

    /// Return the length of contact of pin and bushing over all strands \[m\].
    #[must_use]
    pub fn hinge_contact_length(&self) -> f64 {
        f64::from(self.strands) * self.hinge.length
    }

    /// Return the axial stiffness of a link over all strands \[N/m\]; `None` for rigid links.
    #[must_use]
    pub fn axial_stiffness(&self) -> Option<f64> {
        let of_one = |given: LinkStiffness| given.value(self.pitch, &self.material);
        self.link_stiffness
            .map(|given| f64::from(self.strands) * of_one(given))
    }

    /// Return the axial compliance of the two half links at a hinge \[m/N\], over all strands: that of a whole link.
    #[must_use]
    pub fn link_compliance(&self) -> Option<f64> {
        self.axial_stiffness().map(|stiffness| 1.0 / stiffness)
    }

    /// Return the length of contact of bushing and teeth over all strands \[m\].
    #[must_use]
    pub fn teeth_contact_length(&self) -> f64 {
        f64::from(self.strands) * self.tooth_contact_length
    }
}

/// Check that the number of links is within the range of memory and accuracy.
///
/// # Errors
/// Names the field, its value and the range.
pub fn check_links(field: &str, links: u32) -> Result<()> {
    if (4..=MOST_LINKS).contains(&links) {
        return Ok(());
    }
    let expected = format!(
        "must be between 4 and {MOST_LINKS}; one to three links, such as a tie bar, are bodies of a Mechanism"
    );
    Err(Error::invalid(field, links, expected))
}

impl Roller {
    /// Check every field.
    ///
    /// # Errors
    /// When a field is out of range: names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        check::positive("Roller.radius", self.radius, "m")?;
        check::positive("Roller.bore_radius", self.bore_radius, "m")?;
        check::positive("Roller.length", self.length, "m")?;
        check::positive("Roller.mass", self.mass, "kg")?;
        check::positive("Roller.inertia", self.inertia, "kg m^2")?;
        if self.radius <= self.bore_radius {
            return Err(Error::invalid(
                "Roller.radius",
                self.radius,
                format!("must be larger than its bore's, {} m", self.bore_radius),
            ));
        }
        Ok(())
    }

    /// Check that the roller fits on a bushing of this radius in a chain of this pitch \[m\].
    ///
    /// # Errors
    /// When a field is out of range: names the field, its value and the range.
    pub fn check_on(&self, bushing_radius: f64, pitch: f64) -> Result<()> {
        if self.bore_radius <= bushing_radius {
            return Err(Error::invalid(
                "Roller.bore_radius",
                self.bore_radius,
                format!(
                    "must be larger than the bushing's (Chain.bushing_radius), {bushing_radius} m"
                ),
            ));
        }
        if 2.0 * self.radius >= pitch {
            return Err(Error::invalid(
                "Roller.radius",
                self.radius,
                format!(
                    "neighbouring rollers would overlap: must be below half the pitch, {} m",
                    0.5 * pitch
                ),
            ));
        }
        Ok(())
    }

    /// Return the radial clearance on a bushing of this radius \[m\].
    #[must_use]
    pub fn clearance(&self, bushing_radius: f64) -> f64 {
        self.bore_radius - bushing_radius
    }
}

impl Link {
    /// Check every field.
    ///
    /// # Errors
    /// When a field is out of range: names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        check::positive("Link.mass", self.mass, "kg")?;
        check::positive("Link.inertia", self.inertia, "kg m^2")
    }
}

impl ClearanceHinge {
    /// Check every field.
    ///
    /// # Errors
    /// When a field is out of range: names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        check::positive("ClearanceHinge.pin_radius", self.pin_radius, "m")?;
        check::positive("ClearanceHinge.bore_radius", self.bore_radius, "m")?;
        if self.bore_radius <= self.pin_radius {
            return Err(Error::invalid(
                "ClearanceHinge.bore_radius",
                self.bore_radius,
                format!("must be larger than the pin's, {} m", self.pin_radius),
            ));
        }
        check::positive("ClearanceHinge.length", self.length, "m")
    }
}

/// Return whether link `i` (from 0) has a bushing at its front: an inner link, except the offset link of an odd number.
#[must_use]
pub fn bushing_on_front(link: usize, links: usize) -> bool {
    link.is_multiple_of(2) && (link + 1 < links || links.is_multiple_of(2))
}

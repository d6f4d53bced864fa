//! Axial stiffness of links: given, or from the cross-sections of their plates.

use serde::{Deserialize, Serialize};

use super::Material;
use crate::error::{Result, check};

/// Plates of a link as bars of the length of a pitch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Plates {
    /// Cross-section of both plates of an inner link \[m²\].
    pub inner_section: f64,
    /// Cross-section of both plates of an outer link \[m²\].
    pub outer_section: f64,
    /// Young's modulus \[Pa\]; `None`: that of the chain's material.
    pub elastic_modulus: Option<f64>,
}

/// Axial stiffness of the links of one strand.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum LinkStiffness {
    /// Stiffness \[N/m\], the mean of inner and outer links.
    Given(f64),
    /// Stiffness from the plates.
    Of(Plates),
}

impl Plates {
    /// Check every field.
    ///
    /// # Errors
    /// When a field is out of range: names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        check::positive("Plates.inner_section", self.inner_section, "m^2")?;
        check::positive("Plates.outer_section", self.outer_section, "m^2")?;
        self.elastic_modulus.map_or(Ok(()), |modulus| {
            check::positive("Plates.elastic_modulus", modulus, "Pa")
        })
    }

    /// Return the mean axial stiffness of an inner and an outer link of this pitch \[m\] \[N/m\]: the harmonic mean of
    /// E A/p of both, as they are in series.
    #[must_use]
    pub fn stiffness(&self, pitch: f64, material: &Material) -> f64 {
        let modulus = self.elastic_modulus.unwrap_or(material.elastic_modulus);
        let section = 2.0 / (1.0 / self.inner_section + 1.0 / self.outer_section);
        modulus * section / pitch
    }
}

impl LinkStiffness {
    /// Check the stiffness or the plates.
    ///
    /// # Errors
    /// When a field is out of range: names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        match self {
            Self::Given(stiffness) => check::positive("Chain.link_stiffness", *stiffness, "N/m"),
            Self::Of(plates) => plates.validate(),
        }
    }

    /// Return the stiffness \[N/m\] of links of this pitch \[m\].
    #[must_use]
    pub fn value(&self, pitch: f64, material: &Material) -> f64 {
        match self {
            Self::Given(stiffness) => *stiffness,
            Self::Of(plates) => plates.stiffness(pitch, material),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inner_and_an_outer_link_in_a_row_stretch_as_two_bars() {
        let plates = Plates {
            inner_section: 3.6e-5,
            outer_section: 3.1e-5,
            elastic_modulus: None,
        };
        let (steel, pitch) = (Material::default(), 0.0127);
        let stretch = |section: f64| pitch / (steel.elastic_modulus * section);
        let both = stretch(3.6e-5) + stretch(3.1e-5);
        let found = plates.stiffness(pitch, &steel);
        assert!((2.0 / found - both).abs() < 1e-14 * both);
        let softer = Plates {
            elastic_modulus: Some(0.5 * steel.elastic_modulus),
            ..plates
        };
        assert!((softer.stiffness(pitch, &steel) - 0.5 * found).abs() < 1e-14 * found);
    }
}

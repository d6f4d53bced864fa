//! Material of contact surfaces.

use serde::{Deserialize, Serialize};

use crate::error::{Result, check};

/// Density of steel \[kg/m³\], for the default mass of a sprocket as a disc and the default inertia of a load as a ball.
pub(super) const STEEL_DENSITY: f64 = 7850.0;

/// Elastic constants and restitution, the same for all parts of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Young's modulus E \[Pa\].
    pub elastic_modulus: f64,
    /// Poisson's ratio ν.
    pub poisson_ratio: f64,
    /// Coefficient of restitution `c_e`.
    pub restitution: f64,
}

impl Default for Material {
    /// Return steel with the values of the published drive.
    fn default() -> Self {
        Self {
            elastic_modulus: 2.07e11,
            poisson_ratio: 0.3,
            restitution: 0.71,
        }
    }
}

impl Material {
    /// Return E* \[Pa\] of two bodies of this material: E / (2 (1 - ν²)).
    #[must_use]
    pub fn contact_modulus(&self) -> f64 {
        self.elastic_modulus / (2.0 * (1.0 - self.poisson_ratio * self.poisson_ratio))
    }

    /// Return E* \[Pa\] of bodies of this material and of the `other`: 1/E* is the sum of (1 - ν²)/E.
    #[must_use]
    pub fn contact_modulus_with(&self, other: &Self) -> f64 {
        if self == other {
            return self.contact_modulus();
        }
        let compliance = |m: &Self| (1.0 - m.poisson_ratio * m.poisson_ratio) / m.elastic_modulus;
        1.0 / (compliance(self) + compliance(other))
    }

    /// Check every field.
    ///
    /// # Errors
    /// When a field is out of range: names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        check::positive("Material.elastic_modulus", self.elastic_modulus, "Pa")?;
        check::within("Material.poisson_ratio", self.poisson_ratio, 0.0, 0.5)?;
        check::within("Material.restitution", self.restitution, 0.0, 1.0)
    }
}

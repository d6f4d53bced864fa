//! Energies of a system, and the powers whose integrals close its energy balance.

use std::fmt::Debug;

use serde::Serialize;
use serde::de::DeserializeOwned;

/// Energies \[J\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// Kinetic energy of all bodies, except the rotation of a drive's sprockets of prescribed speed.
    pub kinetic: f64,
    /// Gravitational energy of all bodies that can move.
    pub gravity: f64,
    /// Elastic energy of contacts, springs and elastic parts.
    pub elastic: f64,
}

impl Energy {
    /// Return the sum.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.kinetic + self.gravity + self.elastic
    }
}

/// Powers of an energy balance \[W\], or their integrals \[J\].
pub trait PowerSum: Copy + Debug + Default + PartialEq + Serialize + DeserializeOwned {
    /// Add `factor` times all values of `other`.
    fn add_scaled(&mut self, factor: f64, other: &Self);

    /// Return the sum of values times their factors.
    #[must_use]
    fn combined<const N: usize>(terms: [(f64, &Self); N]) -> Self {
        let mut sum = Self::default();
        for (factor, values) in terms {
            sum.add_scaled(factor, values);
        }
        sum
    }

    /// Return the dissipated part and the external work.
    fn totals(&self) -> [f64; 2];

    /// Return the powers with another external power.
    #[must_use]
    fn with_external(self, external: f64) -> Self;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_total_is_the_sum_of_three_energies() {
        let energy = Energy {
            kinetic: 1.0,
            gravity: -20.0,
            elastic: 300.0,
        };
        assert_eq!(energy.total(), 281.0);
    }
}

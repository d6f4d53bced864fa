//! Energies of a system, and the powers whose integrals close its energy balance.

use std::fmt::Debug;

use serde::Serialize;
use serde::de::DeserializeOwned;

/// Energies \[J\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// Of all bodies but for the rotation of those with prescribed speed.
    pub kinetic: f64,
    /// In the field of gravity, of all bodies that can move.
    pub gravity: f64,
    /// Stored in contacts, springs and elastic parts.
    pub elastic: f64,
}

impl Energy {
    /// The sum.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.kinetic + self.gravity + self.elastic
    }
}

/// Powers of an energy balance \[W\]; integrated, energies \[J\].
pub trait PowerSum:
    Copy
    + Debug
    + Default
    + PartialEq
    + Serialize
    + DeserializeOwned
    + std::ops::Add<Output = Self>
    + std::ops::AddAssign
{
    /// All of them times `factor`.
    #[must_use]
    fn scaled(self, factor: f64) -> Self;

    /// Dissipated, and external work.
    fn totals(&self) -> [f64; 2];
}

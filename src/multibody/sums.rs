//! Energy sums of a mechanism.

use serde::{Deserialize, Serialize};

use crate::system::PowerSum;

/// Energy dissipated and external work of a mechanism \[J\], as components of the solution.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct MechanismSums {
    /// Energy dissipated in dampers and contacts, including the energy stored in bristles; [`System::without_stored`](crate::system::System::without_stored) subtracts that.
    pub dissipated: f64,
    /// Work of applied forces and drivers.
    pub external_work: f64,
}

impl PowerSum for MechanismSums {
    fn add_scaled(&mut self, factor: f64, other: &Self) {
        self.dissipated += factor * other.dissipated;
        self.external_work += factor * other.external_work;
    }

    fn totals(&self) -> [f64; 2] {
        [self.dissipated, self.external_work]
    }

    fn with_external(self, external_work: f64) -> Self {
        Self {
            external_work,
            ..self
        }
    }
}

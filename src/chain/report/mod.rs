//! Contacts and accelerations for those who read them: reports, energies, range watching, contact onsets at a start.
//!
//! The kernels evaluate once more, in arrays of their own, so that a report inside a step leaves what the step needs as it is: the
//! list of candidates and its gaps, the contacts that began or ended, and the bristles of the implicit step.

mod accelerations;
mod hinges;
mod rollers;
mod teeth;

use crate::chain::contact::Candidates;
use crate::chain::model::Model;
use crate::chain::rhs::{Kernels, ToothReadings};

pub use accelerations::Accelerations;
pub use hinges::HingeContacts;
pub use rollers::{RollerContacts, on_teeth};
pub use teeth::ToothContacts;

/// Kernels that evaluate for readers, and their scratch arrays.
#[derive(Debug, Clone)]
pub(crate) struct Reader {
    pub(crate) kernels: Kernels,
    /// State that is evaluated where none is given.
    pub(crate) state: Vec<f64>,
    /// Accelerations, coordinate by coordinate.
    pub(crate) rates: Vec<f64>,
    /// Candidates of one sprocket.
    pub(crate) readings: ToothReadings,
}

impl Reader {
    pub(crate) fn new(model: &Model) -> Self {
        Self {
            kernels: Kernels::new(model),
            state: vec![0.0; 2 * model.coordinates],
            rates: vec![0.0; model.coordinates],
            readings: ToothReadings::new(Candidates::most_slots(model)),
        }
    }
}

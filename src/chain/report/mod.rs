//! What is read of a drive: contacts and accelerations for reports, energies, range warnings and contact onsets at a start, and the
//! rows of a recording.
//!
//! The kernels evaluate once more, in arrays of their own, so that a report inside a step leaves what the step needs as it is: the
//! list of candidates and its gaps, the contacts that began or ended, and the bristles of the implicit step.

mod accelerations;
mod channels;
mod contact_rows;
mod end_rows;
mod groups;
mod hinges;
mod rollers;
mod rows;
mod teeth;

use crate::chain::contact::Candidates;
use crate::chain::model::Model;
use crate::chain::rhs::{Kernels, ToothReadings};

pub use accelerations::Accelerations;
pub(crate) use channels::channels;
pub use groups::Groups;
pub use hinges::HingeContacts;
pub use rollers::{RollerContacts, on_teeth};
pub(crate) use rows::{HINGES, ROLLERS, write_row};
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

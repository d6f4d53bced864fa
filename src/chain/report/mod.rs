//! Report quantities of a drive: contacts and accelerations for reports, and names of the recorded channels.
//!
//! Reports have separate kernels and arrays. A report inside a step therefore does not change the data of the step: candidate list and
//! gaps, contact onsets and ends, and the bristles of the implicit stage.

mod accelerations;
mod channels;
mod groups;
mod hinges;
mod output_request;
mod rollers;
mod teeth;

use crate::chain::contact::Candidates;
use crate::chain::model::Model;
use crate::chain::rhs::{Kernels, ToothReadings};

pub use accelerations::Accelerations;
pub(crate) use channels::channels;
pub use groups::Groups;
pub use hinges::HingeContacts;
pub(crate) use hinges::pairs;
pub(crate) use output_request::OutputRequest;
pub use rollers::RollerContacts;
pub use teeth::ToothContacts;

/// Kernels for reports, and their scratch arrays.
#[derive(Debug, Clone)]
pub(crate) struct ReportKernels {
    pub(crate) kernels: Kernels,
    /// State of an evaluation without a given state.
    pub(crate) state: Vec<f64>,
    /// Accelerations of all coordinates.
    pub(crate) accelerations: Vec<f64>,
    /// Tooth contacts of the candidates of one sprocket.
    pub(crate) readings: ToothReadings,
}

impl ReportKernels {
    pub(crate) fn new(model: &Model) -> Self {
        Self {
            kernels: Kernels::new(model),
            state: vec![0.0; 2 * model.coordinates],
            accelerations: vec![0.0; model.coordinates],
            readings: ToothReadings::new(Candidates::most_slots(model)),
        }
    }
}

//! Runs of mechanisms: steps, contact onsets, reports, states.

pub(crate) mod onset;
pub(crate) mod peaks;
pub(crate) mod present;
pub(crate) mod recording;
pub(crate) mod reports;
pub(crate) mod simulation;
pub(crate) mod snapshot;

pub use recording::MechanismRecording;
pub use simulation::MechanismSimulation;
pub use snapshot::MechanismSnapshot;

//! A run of a system whose kind is known only at run time.

use std::time::Duration;

use super::mechanism::MechanismSimulation;
use super::simulation::{Simulation, Statistics};
use crate::error::Result;
use crate::system::Recording;

/// Run of a chain drive or of a mechanism.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant)] // one value a run
pub enum AnySimulation {
    /// Run of a chain drive.
    Drive(Simulation),
    /// Run of a mechanism.
    Mechanism(MechanismSimulation),
}

/// Evaluates an expression with the simulation of either kind.
macro_rules! of_any {
    ($any:expr, $simulation:ident => $result:expr) => {
        match $any {
            AnySimulation::Drive($simulation) => $result,
            AnySimulation::Mechanism($simulation) => $result,
        }
    };
}

impl AnySimulation {
    /// Return the present time \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        of_any!(self, simulation => simulation.time())
    }

    /// Return the names of the bodies.
    #[must_use]
    pub fn body_names(&self) -> Vec<String> {
        match self {
            Self::Drive(simulation) => simulation.model().body_names(),
            Self::Mechanism(simulation) => simulation.model().body_names(),
        }
    }

    /// Return the positions of all bodies at the present time.
    pub fn positions(&mut self) -> Vec<[f64; 3]> {
        match self {
            Self::Drive(simulation) => simulation.motion().positions(),
            Self::Mechanism(simulation) => simulation.positions(),
        }
    }

    /// Return the velocities of all bodies at the present time.
    pub fn velocities(&mut self) -> Vec<[f64; 3]> {
        match self {
            Self::Drive(simulation) => simulation.motion().velocities(),
            Self::Mechanism(simulation) => simulation.velocities(),
        }
    }

    /// Return the run of the mechanism; none of a drive.
    #[must_use]
    pub fn mechanism(&self) -> Option<&MechanismSimulation> {
        match self {
            Self::Drive(_) => None,
            Self::Mechanism(simulation) => Some(simulation),
        }
    }

    /// Return the statistics of [`Simulation::statistics`].
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        of_any!(self, simulation => simulation.statistics())
    }

    /// Return the energy warning of [`Simulation::balance_note`].
    #[must_use]
    pub fn balance_note(&self) -> Option<&str> {
        of_any!(self, simulation => simulation.balance_note())
    }

    /// Return the law warnings of either kind.
    #[must_use]
    pub fn range_notes(&self) -> Vec<String> {
        of_any!(self, simulation => simulation.range_notes())
    }

    /// Continue the recording, as [`Simulation::record`].
    ///
    /// # Errors
    /// As of [`Simulation::record`].
    pub fn record(&mut self, budget: Duration) -> Result<bool> {
        of_any!(self, simulation => simulation.record(budget))
    }

    /// Integrate to `target`, as [`Simulation::advance`].
    ///
    /// # Errors
    /// As of [`Simulation::advance`].
    pub fn advance(&mut self, target: f64, budget: Duration) -> Result<bool> {
        of_any!(self, simulation => simulation.advance(target, budget))
    }

    /// Pause the recording after each report, as [`Simulation::pause_at_reports`].
    pub fn pause_at_reports(&mut self) {
        of_any!(self, simulation => simulation.pause_at_reports());
    }

    /// Return the active recording, as [`Simulation::recording`].
    #[must_use]
    pub fn recording(&self) -> Option<&Recording> {
        of_any!(self, simulation => simulation.recording())
    }

    /// End the recording and return it, as [`Simulation::take_recording`].
    pub fn take_recording(&mut self) -> Recording {
        of_any!(self, simulation => simulation.take_recording())
    }

    /// Remove rows of the recording and return them, as [`Simulation::take_rows`].
    pub fn take_rows(&mut self, count: usize) -> Recording {
        of_any!(self, simulation => simulation.take_rows(count))
    }

    /// Return the state as bytes.
    ///
    /// # Errors
    /// After a panic in a step.
    pub fn state(&self) -> Result<Vec<u8>> {
        of_any!(self, simulation => {
            simulation.check_intact()?;
            simulation.snapshot().to_bytes()
        })
    }

    /// Set the state from `bytes`.
    ///
    /// # Errors
    /// If `bytes` contain no state, or the state of another scene; the simulation is then unchanged.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<()> {
        of_any!(self, simulation => {
            let snapshot = super::simulation::Snapshot::from_bytes(bytes)?;
            simulation.restore(&snapshot)
        })
    }
}

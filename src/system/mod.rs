//! What a run knows of the system that it steps.
//!
//! [`System`] is implemented by the chain drive ([`crate::chain::dynamics::Dynamics`]) and by mechanisms
//! ([`crate::multibody::MechanismDynamics`]). A third kind of system needs only that. The types that pass between a system and its
//! run stand beside it: recordings, peaks, energies and their quadrature.

mod energy;
mod energy_quadrature;
mod peaks;
mod recording;

use std::fmt::Debug;
use std::sync::Arc;

use serde::Serialize;
use serde::de::DeserializeOwned;

pub use energy::{Energy, PowerSum};
pub use energy_quadrature::EnergyQuadrature;
pub(crate) use energy_quadrature::PanelRule;
pub use peaks::Peaks;
pub use recording::{Channel, Recording, Row, Values};

use crate::error::Result;
use crate::integrator::{Adams, SecondOrderSystem, Step};

/// Located events of a run so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct EventCounts {
    /// Contact onsets.
    pub onsets: u64,
    /// Onsets slower than the minimum impact velocity.
    pub onsets_at_floor: u64,
    /// Contacts that closed and opened again inside a step, within the accuracy.
    pub unseen_touches: u64,
}

/// One property by which a state is held against the simulation that it is set in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Identity {
    /// Its name in messages.
    pub field: &'static str,
    /// Its value in words.
    pub value: String,
    /// What to do where it differs.
    pub remedy: &'static str,
}

/// A system of second order that a run steps, records and restores.
///
/// A step goes: [`Self::begin_step`], the integrator's step, [`Self::write_peak_forces`], [`Self::finish_step`],
/// [`Self::longest_step`], [`Self::meter_step`].
pub trait System: SecondOrderSystem + Clone + Debug {
    /// The compiled description.
    type Model: Debug;
    /// Which groups of channels are recorded.
    type Groups: Copy + Debug + PartialEq;
    /// Powers of the energy balance.
    type Powers: PowerSum;
    /// All that an evaluation does not find anew, for states.
    type Checkpoint: Clone + Debug + Serialize + DeserializeOwned;

    /// What the system is, in states and messages.
    const KIND: &'static str;
    /// Steps between two readings of the wall clock: one where a step may take a good part of a second.
    const STEPS_BETWEEN_CLOCK_READINGS: u32;

    /// The compiled description.
    fn model(&self) -> &Arc<Self::Model>;

    /// Properties by which a state is known again, the ones that tell most first.
    fn identity(&self) -> Vec<Identity>;

    /// Prepares the next step of `adams`: ends the memory of contacts that ended in the last one.
    fn begin_step(&mut self, adams: &mut Adams);

    /// Locates the events of the step just made and corrects the state where it ends.
    ///
    /// # Errors
    /// When no state there satisfies the constraints.
    fn finish_step(&mut self, adams: &mut Adams, step: &Step) -> Result<()>;

    /// Longest step from where `adams` is \[s\], in which no event passes unseen.
    fn longest_step(&mut self, adams: &Adams) -> f64;

    /// Returns to where the step began that has failed.
    fn go_back(&mut self, _adams: &mut Adams) {}

    /// Body of a component of the state at `time` \[s\], and its largest contact force, in words.
    fn culprit(&mut self, adams: &Adams, time: f64, component: usize) -> String;

    /// The contact with the largest force at the last evaluation, in words.
    fn busiest(&self) -> String;

    /// Located events so far.
    fn event_counts(&self) -> EventCounts;

    /// Whether the energy quadrature is on; always, of a system whose solution has the sums.
    fn keeps_energy(&self) -> bool {
        true
    }

    /// Switches the energy quadrature off.
    fn stop_metering(&mut self) {}

    /// Switches the energy quadrature on, from where `adams` is.
    fn begin_metering(&mut self, _adams: &Adams) {}

    /// Takes where `adams` is as the start of the next metered step, when energy is metered.
    fn resume_metering(&mut self, _adams: &Adams) {}

    /// Adds the energies of the step just made, when they are metered.
    fn meter_step(&mut self, _adams: &Adams, _step: &Step) {}

    /// Energies dissipated and put in at `t` inside the last step, where a report was evaluated last \[J\].
    fn sums_at(&self, t: f64) -> Self::Powers;

    /// Evaluations of the right-hand side that the energy quadrature took.
    fn meter_evaluations(&self) -> u64 {
        0
    }

    /// Energies at the last evaluation.
    fn energy(&self) -> Energy;

    /// Energies where the step just made ended, where they cost next to nothing: they then count as exchanged.
    fn energy_at_step_end(&self) -> Option<Energy> {
        None
    }

    /// The part of `sums` that is lost, without what friction has stored at the last evaluation.
    fn without_stored(&self, sums: Self::Powers) -> Self::Powers {
        sums
    }

    /// Kinetic energy of bodies that move no faster than `speed` \[m/s\]: no more than that is error alone \[J\].
    fn kinetic_energy_at(&self, _speed: f64) -> f64 {
        0.0
    }

    /// What closes an energy balance that no accuracy closes, in words.
    fn energy_remedy(&self) -> Option<&'static str> {
        None
    }

    /// Whether `groups` have the energy balance.
    fn records_energy(groups: Self::Groups) -> bool;

    /// Channels of `groups`, without rows. Those of the energy balance are not among them.
    fn channels(&self, groups: Self::Groups) -> Vec<Channel>;

    /// Channels and values of what places have of the dissipated in `powers`, in the order of a row.
    fn losses(&self, _powers: &Self::Powers) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// How many contacts or joints of each kind have peaks in `groups`.
    fn peak_sizes(&self, groups: Self::Groups) -> Vec<usize>;

    /// Evaluates the right-hand side where the last step ended, for [`Self::write_peak_forces`].
    fn evaluate_step_end(&mut self, adams: &Adams);

    /// Writes the forces of a kind at the last evaluation of the right-hand side \[N\].
    fn write_peak_forces(&self, kind: usize, forces: &mut [f64]);

    /// Begins a recording of `groups`; `None`: it has ended.
    fn set_recorded(&mut self, _groups: Option<Self::Groups>) {}

    /// Evaluates what a row of `groups` needs at `t` inside the last step.
    fn evaluate_report(&mut self, adams: &Adams, t: f64, groups: Self::Groups);

    /// Writes a row of [`Self::channels`] as evaluated at `t`.
    fn write_row(&mut self, row: &mut Row, t: f64, groups: Self::Groups);

    /// All that decides, with the integrator's state, how the system goes on.
    fn checkpoint(&self) -> Self::Checkpoint;

    /// The system that `checkpoint` was taken of, where `adams` has come; `None` when it contradicts this one.
    fn restored(&self, checkpoint: &Self::Checkpoint, adams: &Adams) -> Option<Self>;
}

/// FNV-1a, 64 bits (Fowler, Noll, Vo): the same on every machine; a single byte that is changed always changes it.
#[must_use]
pub fn hash(bytes: &[u8]) -> u64 {
    let step = |hash: u64, &byte: &u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, step)
}

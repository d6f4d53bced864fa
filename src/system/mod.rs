//! Interface between a run and the system that it integrates.
//!
//! [`System`] is implemented by the chain drive ([`crate::chain::dynamics::Dynamics`]) and by mechanisms
//! ([`crate::multibody::MechanismDynamics`]). A third kind of system requires only this trait. The types exchanged by a system and its run
//! are defined here: recordings, peaks, energies and their quadrature.

mod energy;
mod energy_quadrature;
mod peaks;
mod recording;

use std::fmt::Debug;

use serde::Serialize;
use serde::de::DeserializeOwned;

pub use energy::{Energy, PowerSum};
pub use energy_quadrature::EnergyQuadrature;
pub use peaks::Peaks;
pub use recording::{Channel, Recording, Row, Values};

use crate::error::Result;
use crate::integrator::{Adams, SecondOrderSystem, Step};

/// Counts of the located events of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct EventCounts {
    /// Contact onsets.
    pub onsets: u64,
    /// Onsets at the minimum impact velocity or slower.
    pub onsets_at_minimum_velocity: u64,
    /// Contacts that began and ended within a step, with an effect below the accuracy.
    pub in_step_contacts: u64,
}

/// Property compared between a state and the simulation that it is set in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Identity {
    /// Name of the property in messages.
    pub field: &'static str,
    /// Value in words.
    pub value: String,
    /// Remedy if it differs.
    pub remedy: &'static str,
}

/// Second-order system that a run integrates, records and restores.
///
/// The order of calls in a step is: [`Self::begin_step`], the integrator's step, [`Self::energy_at_step_end`], [`Self::finish_step`],
/// [`Self::longest_step`], [`Self::reach_step_end`], [`Self::write_peak_forces`], [`Self::meter_step`].
pub trait System: SecondOrderSystem + Clone + Debug {
    /// Selected groups of channels.
    type Groups: Copy + Debug + PartialEq;
    /// Powers of the energy balance.
    type Powers: PowerSum;
    /// Part of the state that an evaluation does not recompute, for checkpoints.
    type Checkpoint: Clone + Debug + Serialize + DeserializeOwned;

    /// Kind of the system, in states and messages.
    const KIND: &'static str;
    /// Number of steps between two readings of the wall clock; one if a step may take a large part of a second.
    const STEPS_BETWEEN_CLOCK_READINGS: u32;

    /// Return the properties that identify a state, most significant first.
    fn identity(&self) -> Vec<Identity>;

    /// Prepare the next step of `adams`.
    ///
    /// A chain drive clears here the impact velocity memory of contacts that ended in the last step, because rows within that step need
    /// it; a mechanism stores the start of the step.
    fn begin_step(&mut self, adams: &mut Adams);

    /// Locate the events of the last step and correct the state at its end.
    ///
    /// # Errors
    /// If no state there satisfies the constraints.
    fn finish_step(&mut self, adams: &mut Adams, step: &Step) -> Result<()>;

    /// Return the longest step from the present state of `adams` \[s\] without a missed event.
    ///
    /// Call once between two steps: a mechanism also stores here the contact states from which the next step is screened.
    fn longest_step(&mut self, adams: &Adams) -> f64;

    /// Return to the beginning of a failed step.
    fn go_back(&mut self, _adams: &mut Adams) {}

    /// Return the body of a component of the state at `time` \[s\] and its largest contact force, in words.
    fn culprit(&mut self, adams: &Adams, time: f64, component: usize) -> String;

    /// Return the contact with the largest force at the last evaluation, in words.
    fn busiest(&self) -> String;

    /// Return the counts of located events so far.
    fn event_counts(&self) -> EventCounts;

    /// Return whether the energy quadrature is on; always true for a system whose solution includes the sums.
    fn keeps_energy(&self) -> bool {
        true
    }

    /// Switch the energy quadrature off.
    fn stop_metering(&mut self) {}

    /// Switch the energy quadrature on, from `now` within the last step of `adams`.
    fn begin_metering(&mut self, _adams: &Adams, _now: f64) {}

    /// Use the present state of `adams` as the start of the next step of the energy quadrature, if the energy quadrature is on.
    fn resume_metering(&mut self, _adams: &Adams) {}

    /// Change the forces of the last evaluation, and the powers, to those at the end of the last step, where `peaks` are recorded or the
    /// energy quadrature is on. The powers have the same bits with and without peaks.
    fn reach_step_end(&mut self, _adams: &Adams, _step: &Step, _peaks: bool) {}

    /// Add the energies of the last step, if the energy quadrature is on.
    fn meter_step(&mut self, _adams: &Adams, _step: &Step) {}

    /// Return the dissipated energies and the external work at `t` within the last step, at the last evaluated report \[J\].
    fn sums_at(&self, t: f64) -> Self::Powers;

    /// Return the number of evaluations of the right-hand side by the energy quadrature.
    fn energy_evaluations(&self) -> u64 {
        0
    }

    /// Return the energies at the last evaluation for a report.
    fn energy(&self) -> Energy;

    /// Return the energies at the last evaluation of the step, before its end is projected, if their evaluation is cheap.
    ///
    /// They are then included in the exchanged energy.
    fn energy_at_step_end(&self) -> Option<Energy> {
        None
    }

    /// Return the kinetic energy of prescribed rotations at the last evaluation that [`Self::energy`] leaves out \[J\]. Reports add it
    /// to the kinetic energy, and its change to the external work; the residual is computed without both.
    fn prescribed_energy(&self) -> f64 {
        0.0
    }

    /// Return `sums` without the energy stored by friction at the last evaluation.
    fn without_stored(&self, sums: Self::Powers) -> Self::Powers;

    /// Return the kinetic energy of bodies at `speed` \[m/s\], an upper bound on the kinetic energy caused by errors alone \[J\].
    fn kinetic_energy_at(&self, speed: f64) -> f64;

    /// Return the remedy, in words, for an energy balance that no accuracy closes.
    fn energy_remedy(&self) -> Option<&'static str> {
        None
    }

    /// Return whether `groups` include the energy balance.
    fn records_energy(groups: Self::Groups) -> bool;

    /// Return the channels of `groups` without rows, except those of the energy balance.
    fn channels(&self, groups: Self::Groups) -> Vec<Channel>;

    /// Return channels and values of the losses by location in `powers`, in the order of a row.
    fn losses(&self, _powers: &Self::Powers) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// Return the number of contacts or joints of each kind with peaks in `groups`.
    fn peak_sizes(&self, groups: Self::Groups) -> Vec<usize>;

    /// Evaluate the right-hand side at the end of the last step, for [`Self::write_peak_forces`].
    fn evaluate_step_end(&mut self, adams: &Adams);

    /// Write the forces of a kind at the last evaluation of the right-hand side \[N\].
    fn write_peak_forces(&self, kind: usize, forces: &mut [f64]);

    /// Begin a recording of `groups`; `None` ends it.
    fn set_recorded(&mut self, _groups: Option<Self::Groups>) {}

    /// Evaluate the quantities of a row of `groups` at `t` within the last step.
    fn evaluate_report(&mut self, adams: &Adams, t: f64, groups: Self::Groups);

    /// Write a row of [`Self::channels`] as evaluated at `t`.
    fn write_row(&mut self, row: &mut Row, t: f64, groups: Self::Groups);

    /// Return the checkpoint: with the integrator's state, it determines the continuation of the run.
    fn checkpoint(&self) -> Self::Checkpoint;

    /// Return the system of `checkpoint` at the present state of `adams`; `None` if the checkpoint is inconsistent with this system.
    fn restored(&self, checkpoint: &Self::Checkpoint, adams: &Adams) -> Option<Self>;
}

/// Return the FNV-1a hash of 64 bits (Fowler, Noll, Vo): equal on all machines; a change of a single byte always changes it.
#[must_use]
pub fn hash(bytes: &[u8]) -> u64 {
    let step = |hash: u64, &byte: &u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_that_the_authors_of_fnv_published() {
        for (text, expected) in [
            ("", 0xcbf2_9ce4_8422_2325),
            ("a", 0xaf63_dc4c_8601_ec8c),
            ("foobar", 0x8594_4171_f739_67e8),
        ] {
            assert_eq!(hash(text.as_bytes()), expected, "{text}");
        }
    }
}

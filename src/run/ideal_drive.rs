//! Run of a drive with ideal hinges: that of its mechanism, with the bodies, inputs and channels of the drive.

mod rows;

use std::ops::{Deref, DerefMut};
use std::sync::Arc;

pub(crate) use rows::IdealRows;

use super::MechanismSimulation;
use crate::chain::Groups;
use crate::drive::{Drive, InputQuantity};
use crate::error::Result;
use crate::integrator::StepControl;
use crate::layout::InitialConfiguration;
use crate::math::Signal;
use crate::multibody::from_drive::channels::DriveView;
use crate::multibody::from_drive::tensioner::PullLoad;
use crate::multibody::{DriveContacts, Mechanism, MechanismGroups, MechanismModel};
use crate::system::Recording;

/// Groups of channels to record of a drive with ideal hinges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct IdealGroups {
    /// Channels of a drive.
    pub drive: Groups,
    /// Joints of its mechanism, as of [`MechanismGroups`].
    pub joints: bool,
    /// Contacts of its mechanism.
    pub contacts: bool,
}

/// Run of a drive with ideal hinges.
#[derive(Debug, Clone)]
pub struct IdealDrive {
    run: MechanismSimulation,
    view: DriveView,
    /// Groups of the active recording.
    groups: IdealGroups,
}

impl Deref for IdealDrive {
    type Target = MechanismSimulation;

    fn deref(&self) -> &MechanismSimulation {
        &self.run
    }
}

impl DerefMut for IdealDrive {
    fn deref_mut(&mut self) -> &mut MechanismSimulation {
        &mut self.run
    }
}

impl IdealDrive {
    /// Return the run of `drive` from `start`, and the positions and velocities before assembly, which moves them by rounding. `None`:
    /// the generated initial configuration. `give_up` is called repeatedly during generation and assembly, and ends them with an error.
    ///
    /// # Errors
    /// If the drive, a control or the start is invalid, or a part has no counterpart in a mechanism.
    pub fn new(
        drive: &Drive,
        contacts: &DriveContacts,
        start: Option<&InitialConfiguration>,
        control: StepControl,
        give_up: &dyn Fn() -> bool,
    ) -> Result<(Self, InitialConfiguration)> {
        let generated;
        let start = if let Some(start) = start {
            start
        } else {
            (generated, _) = InitialConfiguration::generate_unless(drive, give_up)?;
            &generated
        };
        let mechanism = Mechanism::from_drive(drive, contacts, Some(start))?;
        let model = Arc::new(MechanismModel::compile(&mechanism)?);
        let run = MechanismSimulation::assemble_on(model, &start.surfaces, control, give_up)?;
        let view = DriveView::new(drive, run.model())?;
        let placed = &mechanism.bodies[..view.bodies()];
        let placed = InitialConfiguration {
            positions: placed.iter().map(|body| body.position).collect(),
            velocities: placed.iter().map(|body| body.velocity).collect(),
            ..InitialConfiguration::default()
        };
        let groups = IdealGroups::default();
        Ok((Self { run, view, groups }, placed))
    }

    /// Return the drive for the channels of its mechanism.
    #[cfg(feature = "python")]
    pub(crate) fn view(&self) -> &DriveView {
        &self.view
    }

    /// Return the names of the bodies of the drive.
    #[must_use]
    pub fn body_names(&self) -> Vec<String> {
        let mut names = self.run.model().body_names();
        names.truncate(self.view.bodies());
        names
    }

    /// Return positions (false) or velocities (true) of the bodies of the drive at the present time.
    pub fn motion(&mut self, velocities: bool) -> Vec<[f64; 3]> {
        let mut rows = self.run.motion(velocities);
        rows.truncate(self.view.bodies());
        rows
    }

    /// Return a recording of the mechanism of one row at another state of the drive; the run is unchanged. Given values replace the
    /// present ones.
    ///
    /// With given positions, no contact has an impact velocity memory.
    ///
    /// # Errors
    /// If the number of rows differs from that of the bodies, or a number is not finite.
    pub fn evaluate_elsewhere(
        &mut self,
        positions: Option<Vec<[f64; 3]>>,
        velocities: Option<Vec<[f64; 3]>>,
        time: Option<f64>,
    ) -> Result<Recording> {
        let given = positions.is_some();
        let [places, rates] = if positions.is_none() && velocities.is_none() {
            [None, None]
        } else {
            let positions = positions.unwrap_or_else(|| self.motion(false));
            let velocities = velocities.unwrap_or_else(|| self.motion(true));
            self.view.with_arm(positions, velocities)?.map(Some)
        };
        let places = places.filter(|_| given);
        (self.run).evaluate_elsewhere(places.as_deref(), rates.as_deref(), time)
    }

    /// Begin a recording at the present time.
    pub fn start_recording(&mut self, duration: f64, report_step: f64, groups: IdealGroups) {
        self.groups = groups;
        // Channels of a drive are computed from those of bodies, joints and contacts.
        let groups = MechanismGroups {
            energy: groups.drive.energy,
            ..MechanismGroups::ALL
        };
        self.run.start_recording(duration, report_step, groups);
    }

    /// Return the last row of a channel used by stop conditions; none without rows or of another channel.
    #[must_use]
    pub fn last_row(&self, name: &str) -> Option<Vec<f64>> {
        IdealRows::new(self.run.recording()?, self.run.model()).last(&self.view, name)
    }

    /// End the recording and return the channels of the drive with all rows so far.
    pub fn take_recording(&mut self) -> Recording {
        let recording = self.run.take_recording();
        self.channels(&recording)
    }

    /// Remove the first `count` rows of the active recording, or all of them, and return the channels of the drive; the recording continues.
    pub fn take_rows(&mut self, count: usize) -> Recording {
        let recording = self.run.take_rows(count);
        self.channels(&recording)
    }

    /// Return the channels of the drive from a recording of its mechanism.
    fn channels(&self, recording: &Recording) -> Recording {
        IdealRows::new(recording, self.run.model()).channels(&self.view, self.groups)
    }

    /// Set another speed, torque or tensioner force of sprocket `sprocket` (from 0) from the present time on, as of a drive with clearance.
    ///
    /// # Errors
    /// If there is no such sprocket, its motion has no such quantity, or `signal` is outside the range of a drive's description; the
    /// simulation is then unchanged.
    pub fn set_input(
        &mut self,
        sprocket: usize,
        quantity: InputQuantity,
        signal: Signal,
    ) -> Result<()> {
        let name = self.view.input(sprocket, quantity, &signal)?;
        if quantity != InputQuantity::TensionerForce {
            return self.run.set_input(&name, quantity, signal);
        }
        let (name, load) = self.view.tensioner_load(sprocket, &signal)?;
        match load {
            PullLoad::Force(x, y) => self.run.set_force(&name, [x.into(), y.into()]),
            PullLoad::Torque(torque) => {
                let quantity = InputQuantity::Torque;
                self.run.set_input(&name, quantity, torque.into())
            }
        }
    }
}

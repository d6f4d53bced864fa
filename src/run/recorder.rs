//! Chosen channels at the report times.

mod balance;
mod channels;
mod ends;
mod peaks;
mod rows;

use crate::chain::dynamics::{Dynamics, Needs, Powers, Want};
use crate::chain::model::{Model, Rotation};
use crate::geometry::Vec2;
use balance::{EnergyAtStart, dissipated_alone, write_energy};
use peaks::Peaks;
use rows::{Row, gather_by_bushing, write_hinges, write_rollers, write_sprockets, write_teeth};

pub(crate) use balance::{Balance, OpenBalance, Passed};

/// Which groups of channels are recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(clippy::struct_excessive_bools)] // independent switches
pub struct Groups {
    /// Force, penetration and eccentricity of every hinge, and of rollers on bushings, with peaks; strand tensions.
    pub hinges: bool,
    /// Deepest tooth contact of every bushing, with peaks.
    pub teeth: bool,
    /// Angle, speed, torque and centre of every sprocket.
    pub sprockets: bool,
    /// Positions and velocities of all bodies.
    pub bodies: bool,
    /// The energy balance.
    pub energy: bool,
}

/// Values of one channel, row after row.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Real numbers.
    Real(Vec<f64>),
    /// Whole numbers.
    Whole(Vec<i32>),
}

/// One recorded quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Its name.
    pub name: &'static str,
    /// Shape of one row; empty for a number.
    pub row_shape: Vec<usize>,
    /// All rows.
    pub values: Values,
}

/// What was recorded: one row of each channel at each time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recording {
    /// Report times \[s\].
    pub time: Vec<f64>,
    /// The channels.
    pub channels: Vec<Channel>,
}

/// Channels being written.
#[derive(Debug, Clone)]
pub(crate) struct Recorder {
    /// Whether the run pauses after each report.
    pub(crate) pauses: bool,
    groups: Groups,
    report_step: f64,
    begin: f64,
    end: f64,
    /// Index of the next report.
    next: u64,
    /// The energy balance at the first report.
    energy_at_start: Option<EnergyAtStart>,
    balance: Balance,
    recording: Recording,
    hinge_peaks: Peaks,
    tooth_peaks: Peaks,
    /// Of bushings in rollers, where those are bodies.
    roller_peaks: Peaks,
    tooth_forces: Vec<f64>,
}

impl Recorder {
    pub(crate) fn new(
        model: &Model,
        groups: Groups,
        begin: f64,
        duration: f64,
        report_step: f64,
    ) -> Self {
        let n = model.links;
        Self {
            pauses: false,
            groups,
            report_step,
            begin,
            end: begin + duration,
            next: 0,
            energy_at_start: None,
            balance: Balance::default(),
            recording: channels::chosen(model, groups),
            hinge_peaks: Peaks::new(n, begin),
            tooth_peaks: Peaks::new(n, begin),
            roller_peaks: Peaks::new(model.roller_count(), begin),
            tooth_forces: vec![0.0; n],
        }
    }

    /// Time of the next report \[s\]; `None` when all are made. The last one lies exactly at the end.
    pub(crate) fn next_report(&self) -> Option<f64> {
        let t = self.begin + self.next as f64 * self.report_step;
        let rounding = 1e-9 * self.report_step;
        if t < self.end - rounding {
            Some(t)
        } else if self
            .recording
            .time
            .last()
            .is_none_or(|&last| last < self.end)
        {
            Some(self.end)
        } else {
            None
        }
    }

    /// What a row needs to know of the dynamics.
    pub(crate) fn needs(&self, model: &Model) -> Needs {
        let groups = self.groups;
        // A motor's torque is what the teeth leave to it; an applied one is known without them.
        let prescribed = |rotation: &Rotation| matches!(rotation, Rotation::Prescribed(_));
        let sprocket_loads =
            groups.sprockets && model.sprockets.iter().any(|s| prescribed(&s.rotation));
        let want = |forces: bool| match (forces, groups.energy) {
            (true, _) => Want::Forces,
            (false, true) => Want::Depths,
            (false, false) => Want::Nothing,
        };
        // What bristles store goes by the normal force.
        let stored = |law: bool| groups.energy && law;
        Needs {
            hinges: want(groups.hinges || stored(model.hinge_bristles.is_some())),
            teeth: want(groups.teeth || sprocket_loads || stored(model.tooth_bristles.is_some())),
            sprocket_loads,
        }
    }

    /// The energy balance of the reports so far, when its residual is larger than it may be and the drive was not `at_rest`, with
    /// no more kinetic energy than that \[J\].
    pub(crate) fn open_balance(&self, at_rest: f64) -> Option<OpenBalance> {
        self.balance.open(at_rest)
    }

    pub(crate) fn end(&self) -> f64 {
        self.end
    }

    pub(crate) fn recording(&self) -> &Recording {
        &self.recording
    }

    /// All whole rows.
    pub(crate) fn into_recording(mut self) -> Recording {
        let rows = self.recording.time.len();
        for channel in &mut self.recording.channels {
            let numbers = rows * channel.row_shape.iter().product::<usize>();
            match &mut channel.values {
                Values::Real(values) => values.truncate(numbers),
                Values::Whole(values) => values.truncate(numbers),
            }
        }
        self.recording
    }

    /// Sets aside the forces at the end of a step, before reports inside it are evaluated.
    pub(crate) fn keep_step_forces(&mut self, dynamics: &Dynamics) {
        if self.groups.hinges {
            dynamics.write_hinge_forces(&mut self.hinge_peaks.arriving);
            dynamics.write_roller_forces(&mut self.roller_peaks.arriving);
        }
        if self.groups.teeth {
            dynamics.write_tooth_forces(&mut self.tooth_peaks.arriving);
        }
    }

    /// Takes the set-aside forces into the peaks.
    pub(crate) fn take_step_forces(&mut self, t: f64) {
        if self.groups.hinges {
            self.hinge_peaks.arrive(t);
            self.roller_peaks.arrive(t);
        }
        if self.groups.teeth {
            self.tooth_peaks.arrive(t);
        }
    }

    /// Writes a row for `dynamics` as evaluated at `t` for what [`Self::needs`] says; `sums` are its energies dissipated and worked
    /// in \[J\].
    pub(crate) fn report(&mut self, t: f64, dynamics: &Dynamics, sums: Powers) {
        let model = dynamics.model();
        let groups = self.groups;
        let energy = groups.energy.then(|| dynamics.energy());
        let first = self.recording.time.is_empty();
        let mut row = Row {
            channels: self.recording.channels.iter_mut(),
        };
        if groups.hinges {
            write_hinges(&mut row, dynamics);
            self.hinge_peaks
                .close(t, &dynamics.hinges.force, first, &mut row);
            if model.hinge_film.is_some() {
                row.real(dynamics.hinges.film.iter().map(Vec2::norm));
            }
            if let Some(ends) = &model.ends {
                ends::write(&mut row, dynamics, ends);
            }
        }
        if groups.hinges && model.rollers.is_some() {
            write_rollers(&mut row, dynamics);
            self.roller_peaks
                .close(t, &dynamics.rollers.force, first, &mut row);
        }
        if groups.teeth {
            write_teeth(&mut row, dynamics);
            gather_by_bushing(&dynamics.teeth, model.links, &mut self.tooth_forces);
            self.tooth_peaks
                .close(t, &self.tooth_forces, first, &mut row);
        }
        if groups.sprockets {
            write_sprockets(&mut row, dynamics, t);
        }
        if groups.bodies {
            row.real(dynamics.motion.positions().into_iter().flatten());
            row.real(dynamics.motion.velocities().into_iter().flatten());
        }
        if let Some(energy) = energy {
            let sums = dissipated_alone(sums, dynamics);
            let passed = write_energy(&mut row, model, energy, sums, &mut self.energy_at_start);
            self.balance.report(t, energy, passed);
        }
        // Last of all: a row that a panic has cut short does not count.
        self.recording.time.push(t);
        self.next += 1;
    }
}

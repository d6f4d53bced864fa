//! Chosen channels at the report times.

mod balance;

use crate::integrator::Adams;
use crate::system::{Channel, Peaks, PowerSum, Recording, Row, System};
use balance::{Balance, EnergyAtStart, Passed};

pub(crate) use balance::OpenBalance;

/// Channels of the energy balance, before those of losses by their place.
const ENERGIES: [&str; 6] = [
    "energy_kinetic",
    "energy_gravity",
    "energy_elastic",
    "energy_dissipated",
    "energy_external_work",
    "energy_residual",
];

/// Channels being written.
#[derive(Debug, Clone)]
pub(crate) struct Recorder<S: System> {
    /// Whether the run pauses after each report.
    pub(crate) pauses: bool,
    groups: S::Groups,
    report_step: f64,
    begin: f64,
    end: f64,
    /// Index of the next report.
    next: u64,
    /// The energy balance at the first report.
    energy_at_start: Option<EnergyAtStart<S::Powers>>,
    balance: Balance,
    recording: Recording,
    /// Of each kind of contact or joint.
    peaks: Vec<Peaks>,
}

impl<S: System> Recorder<S> {
    pub(crate) fn new(
        system: &S,
        groups: S::Groups,
        begin: f64,
        duration: f64,
        report_step: f64,
    ) -> Self {
        let mut channels = system.channels(groups);
        if S::records_energy(groups) {
            let losses = system.losses(&S::Powers::default());
            let names = ENERGIES.into_iter().chain(losses.into_iter().map(|l| l.0));
            channels.extend(names.map(|name| Channel::real(name, &[])));
        }
        let sizes = system.peak_sizes(groups).into_iter();
        Self {
            pauses: false,
            groups,
            report_step,
            begin,
            end: begin + duration,
            next: 0,
            energy_at_start: None,
            balance: Balance::default(),
            recording: Recording {
                time: Vec::new(),
                channels,
            },
            peaks: sizes.map(|count| Peaks::new(count, begin)).collect(),
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

    /// The energy balance of the reports so far, when its residual is larger than it may be and the system was not `at_rest`, with
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
        self.recording.truncate_to_whole_rows();
        self.recording
    }

    /// Whether largest forces between two reports are recorded.
    pub(crate) fn has_peaks(&self) -> bool {
        self.peaks.iter().any(|peaks| !peaks.arriving.is_empty())
    }

    /// Sets aside the forces of the last evaluation, that of the end of a step, before reports inside it are evaluated.
    pub(crate) fn keep_step_forces(&mut self, system: &S) {
        for (kind, peaks) in self.peaks.iter_mut().enumerate() {
            if !peaks.arriving.is_empty() {
                system.write_peak_forces(kind, &mut peaks.arriving);
            }
        }
    }

    /// The same, and takes in the energies there.
    pub(crate) fn keep_step_end(&mut self, system: &S) {
        self.keep_step_forces(system);
        if S::records_energy(self.groups)
            && let Some(energy) = system.energy_at_step_end()
        {
            self.balance.take_in(energy);
        }
    }

    /// Takes the set-aside forces into the peaks.
    pub(crate) fn take_step_forces(&mut self, t: f64) {
        for peaks in &mut self.peaks {
            peaks.arrive(t);
        }
    }

    /// Evaluates `system` at `t` inside the last step of `adams` and writes a row.
    pub(crate) fn report(&mut self, t: f64, system: &mut S, adams: &Adams) {
        system.evaluate_report(adams, t, self.groups);
        self.write_row(t, system);
    }

    /// Writes a row for `system` as it was evaluated last, at `t`.
    fn write_row(&mut self, t: f64, system: &mut S) {
        let mut row = Row {
            channels: self.recording.channels.iter_mut(),
            peaks: &mut self.peaks,
            time: t,
            first: self.recording.time.is_empty(),
        };
        system.write_row(&mut row, t, self.groups);
        if S::records_energy(self.groups) {
            let (energy, sums) = (system.energy(), system.sums_at(t));
            let sums = system.without_stored(sums);
            let start = self.energy_at_start.get_or_insert(EnergyAtStart {
                total: energy.total(),
                sums,
            });
            let since = sums + start.sums.scaled(-1.0);
            let [dissipated, external_work] = since.totals();
            let residual = energy.total() - start.total + dissipated - external_work;
            let stored = [energy.kinetic, energy.gravity, energy.elastic];
            let passed = [dissipated, external_work, residual];
            let losses = system.losses(&since).into_iter().map(|loss| loss.1);
            for value in stored.into_iter().chain(passed).chain(losses) {
                row.real([value]);
            }
            let passed = Passed {
                dissipated,
                external_work,
                residual,
            };
            self.balance.report(t, energy, passed);
        }
        // Last of all: a row that a panic has cut short does not count.
        self.recording.time.push(t);
        self.next += 1;
    }
}

/// A recording of one row: `system` as it was evaluated last, at `t`.
pub(crate) fn row_of<S: System>(system: &mut S, t: f64, groups: S::Groups) -> Recording {
    let mut recorder = Recorder::new(system, groups, t, 0.0, 1.0);
    recorder.write_row(t, system);
    recorder.into_recording()
}

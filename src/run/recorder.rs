//! Recorder of the selected channels at the report times.

mod balance;

use crate::integrator::{Adams, Step};
use crate::system::{Channel, Energy, Peaks, PowerSum, Recording, Row, System};
use balance::{Balance, EnergyAtStart, Passed};

pub(crate) use balance::OpenBalance;

/// Channels of the energy balance; the channels of the losses by location follow.
const ENERGIES: [&str; 6] = [
    "energy_kinetic",
    "energy_gravity",
    "energy_elastic",
    "energy_dissipated",
    "energy_external_work",
    "energy_residual",
];

/// Memory that is reserved for rows at the beginning of a run, at most \[B\]: 50,000 rows of the published drive with the default groups.
///
/// Vectors that grow from nothing copy each row once or twice. Those of longer runs do so later, doubled.
const LARGEST_ROOM: f64 = 256e6;

/// Report intervals before the end within which a report is the last one, at the end: rounding of a product of the interval.
const ROUNDING_AT_END: f64 = 1e-9;

/// Recorder of a run: channels under construction.
#[derive(Debug, Clone)]
pub(crate) struct Recorder<S: System> {
    /// True if the run pauses after each report.
    pub(crate) pauses: bool,
    groups: S::Groups,
    report_step: f64,
    begin: f64,
    end: f64,
    /// Index of the next report, and the time of the last one \[s\].
    next: u64,
    last: Option<f64>,
    /// Energies at the first report.
    energy_at_start: Option<EnergyAtStart<S::Powers>>,
    balance: Balance,
    /// Energies at the ends of steps since the last report, which the next one includes; that of the last step, and its time \[s\].
    since_report: Balance,
    step_end: Option<(f64, Energy)>,
    recording: Recording,
    /// Peaks of each kind of contact or joint.
    peaks: Vec<Peaks>,
}

impl<S: System> Recorder<S> {
    pub(crate) fn new(
        system: &S,
        groups: S::Groups,
        [begin, end]: [f64; 2],
        report_step: f64,
    ) -> Self {
        let mut channels = system.channels(groups);
        if S::records_energy(groups) {
            let losses = system.losses(&S::Powers::default());
            let names = ENERGIES.into_iter().chain(losses.into_iter().map(|l| l.0));
            channels.extend(names.map(|name| Channel::real(name, &[])));
        }
        let sizes = system.peak_sizes(groups).into_iter();
        let numbers: usize = channels.iter().map(Channel::row_length).sum();
        let most = LARGEST_ROOM / (size_of::<f64>() * numbers.max(1)) as f64;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most `most`
        let rows = ((end - begin) / report_step).min(most) as usize;
        for channel in &mut channels {
            channel.make_room(rows + 2); // the first and the last one
        }
        Self {
            pauses: false,
            groups,
            report_step,
            begin,
            end,
            next: 0,
            last: None,
            energy_at_start: None,
            balance: Balance::default(),
            since_report: Balance::default(),
            step_end: None,
            recording: Recording {
                time: Vec::new(),
                channels,
            },
            peaks: sizes.map(|count| Peaks::new(count, begin)).collect(),
        }
    }

    /// Return the time of the next report \[s\]; `None` if all are complete. The first report lies exactly at the start, the last at the end.
    pub(crate) fn next_report(&self) -> Option<f64> {
        let t = self.begin + self.next as f64 * self.report_step;
        let rounding = ROUNDING_AT_END * self.report_step;
        if self.next == 0 || t < self.end - rounding {
            Some(t)
        } else if self.last.is_none_or(|last| last < self.end) {
            Some(self.end)
        } else {
            None
        }
    }

    /// Return the energy balance of the reports so far if its residual exceeds the permitted one. A system whose kinetic energy never
    /// exceeds `at_rest` \[J\] is exempt.
    pub(crate) fn open_balance(&self, at_rest: f64) -> Option<OpenBalance> {
        self.balance.open(at_rest)
    }

    pub(crate) fn end(&self) -> f64 {
        self.end
    }

    pub(crate) fn recording(&self) -> &Recording {
        &self.recording
    }

    /// Remove the first `count` complete rows, or all of them, and return them; the recording continues.
    pub(crate) fn take_rows(&mut self, count: usize) -> Recording {
        self.recording.truncate_to_whole_rows();
        self.recording.take_front(count)
    }

    /// Return all complete rows.
    pub(crate) fn into_recording(mut self) -> Recording {
        self.recording.truncate_to_whole_rows();
        self.recording.release_room();
        self.recording
    }

    /// Return whether largest forces between two reports are recorded.
    pub(crate) fn has_peaks(&self) -> bool {
        self.peaks.iter().any(|peaks| !peaks.is_empty())
    }

    /// Store the forces at the end of a step, before reports within the step are evaluated.
    pub(crate) fn keep_step_forces(&mut self, system: &S) {
        for (kind, peaks) in self.peaks.iter_mut().enumerate() {
            if !peaks.is_empty() {
                system.write_peak_forces(kind, peaks.arriving());
            }
        }
    }

    /// Include the energies at the end of `step` in the balance at the next report from then on.
    ///
    /// The step before does not count where this one begins before its end: an input changed there, or the step failed afterwards.
    pub(crate) fn include_step_energy(&mut self, step: &Step, system: &S) {
        if S::records_energy(self.groups)
            && let Some(energy) = system.energy_at_step_end()
            && let Some((end, before)) = self.step_end.replace((step.end, energy))
            && end <= step.start
        {
            self.since_report.include(before);
        }
    }

    /// Include the stored forces in the peaks.
    pub(crate) fn take_step_forces(&mut self, t: f64) {
        for peaks in self.peaks.iter_mut().filter(|peaks| !peaks.is_empty()) {
            peaks.arrive(t);
        }
    }

    /// Evaluate `system` at `t` within the last step of `adams` and write a row.
    pub(crate) fn report(&mut self, t: f64, system: &mut S, adams: &Adams) {
        system.evaluate_report(adams, t, self.groups);
        self.write_row(t, system);
    }

    /// Write a row for the last evaluation of `system`, at `t`.
    fn write_row(&mut self, t: f64, system: &mut S) {
        let mut row = Row {
            channels: self.recording.channels.iter_mut(),
            peaks: &mut self.peaks,
            time: t,
            first: self.next == 0,
        };
        system.write_row(&mut row, t, self.groups);
        if S::records_energy(self.groups) {
            let (energy, sums) = (system.energy(), system.sums_at(t));
            let sums = system.without_stored(sums);
            let prescribed = system.prescribed_energy();
            let start = self.energy_at_start.get_or_insert(EnergyAtStart {
                total: energy.total(),
                prescribed,
                sums,
            });
            let mut since = sums;
            since.add_scaled(-1.0, &start.sums);
            // residual = (stored energy - that at the start) + dissipated - external work.
            let [dissipated, external_work] = since.totals();
            let residual = energy.total() - start.total + dissipated - external_work;
            // The residual leaves out what a prescribed rotation takes up: an inertia that keeps a speed has a rounding error of its own.
            let spun_up = prescribed - start.prescribed;
            let stored = [energy.kinetic + prescribed, energy.gravity, energy.elastic];
            let passed = [dissipated, external_work + spun_up, residual];
            let losses = system.losses(&since).into_iter().map(|loss| loss.1);
            for value in stored.into_iter().chain(passed).chain(losses) {
                row.copy(&[value]);
            }
            let passed = Passed {
                dissipated,
                external_work,
                residual,
            };
            // Only the last step may end behind this report.
            self.balance.merge(&std::mem::take(&mut self.since_report));
            if let Some((_, energy)) = self.step_end.take_if(|(end, _)| *end <= t) {
                self.balance.include(energy);
            }
            self.balance.report(t, energy, passed);
        }
        // The time is written last: a row cut short by a panic does not count.
        self.recording.time.push(t);
        self.last = Some(t);
        self.next += 1;
    }
}

/// Return a recording of one row: the last evaluation of `system`, at `t`.
pub(crate) fn row_of<S: System>(system: &mut S, t: f64, groups: S::Groups) -> Recording {
    let mut recorder = Recorder::new(system, groups, [t, t], 1.0);
    recorder.write_row(t, system);
    recorder.into_recording()
}

//! Run of any system: steps, located events, reports.

mod energy_warning;
mod snapshot;
mod wall;

use std::time::{Duration, Instant};

use energy_warning::{describe_open_balance, tighter_accuracy};
pub use snapshot::Snapshot;
use wall::Wall;

use crate::chain::dynamics::Dynamics;
use crate::error::{Error, Result, check};
use crate::integrator::{Adams, Counts, MOST_STEPS, Progress};
use crate::panics::guarded;
use crate::run::recorder::{OpenBalance, Recorder};
use crate::system::{Recording, System};

/// Simulation of a system: of a chain drive unless another system is given.
#[derive(Debug, Clone)]
pub struct Simulation<S: System = Dynamics> {
    pub(super) system: S,
    pub(super) adams: Adams,
    /// Present time of the user \[s\]; the integrator may be ahead by a fraction of a step.
    pub(super) now: f64,
    pub(super) recorder: Option<Recorder<S>>,
    wall: Wall,
    /// Warning of the first recording whose energy balance did not close.
    balance_note: Option<String>,
    progress: Progress,
    /// Panic that ended the run.
    defect: Option<Error>,
}

/// Counts of work and wall times of a run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Statistics {
    /// Steps, rejected steps, evaluations.
    pub counts: Counts,
    /// Evaluations by the energy quadrature, which the counts do not include.
    pub energy_evaluations: u64,
    /// Contact onsets.
    pub onsets: u64,
    /// Onsets at the minimum impact velocity or slower.
    pub onsets_at_minimum_velocity: u64,
    /// Contacts that began and ended within a step with an effect below the accuracy, and were not located.
    pub in_step_contacts: u64,
    /// Wall time in steps \[s\], estimated from timed steps, one of 16.
    pub wall_stepping: f64,
    /// Wall time in event location and energy quadrature \[s\], estimated likewise.
    pub wall_onsets: f64,
    /// Wall time in reports \[s\].
    pub wall_reports: f64,
}

/// Number of steps for each timed step.
const STEPS_FOR_ONE_TIMED: u32 = 16;

/// Speed that counts as rest, over the permitted error of speeds. Drives in static equilibrium move at up to 1.3 times that error. With
/// twice this value, the energy balance of drives that move at six times the error would not be checked.
const SPEEDS_AT_REST: f64 = 3.0;

/// Longest time of a run \[s\], 30 years, at whose end times are rounded to 0.1 µs. No run reaches it: a longer one is a mistake.
const LONGEST: f64 = 1e9;

impl<S: System> Simulation<S> {
    /// Return a run of `system` from the present state of `adams`.
    pub(super) fn of(system: S, adams: Adams) -> Self {
        let mut simulation = Self {
            system,
            now: adams.time(),
            adams,
            recorder: None,
            wall: Wall::default(),
            balance_note: None,
            progress: Progress::default(),
            defect: None,
        };
        simulation.limit_step();
        simulation
    }

    /// Return the present time \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.now
    }

    /// Return the integrator.
    #[must_use]
    pub fn integrator(&self) -> &Adams {
        &self.adams
    }

    /// Return the system at its last evaluation, with the impact velocity memory of its contacts.
    #[must_use]
    pub fn dynamics(&self) -> &S {
        &self.system
    }

    /// Return the counts of the integrator's work so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.adams.counts()
    }

    /// Return counts of work and wall times so far.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        let events = self.system.event_counts();
        let [wall_stepping, wall_onsets] = self.wall.steps();
        Statistics {
            counts: self.adams.counts(),
            energy_evaluations: self.system.energy_evaluations(),
            onsets: events.onsets,
            onsets_at_minimum_velocity: events.onsets_at_minimum_velocity,
            in_step_contacts: events.in_step_contacts,
            wall_stepping,
            wall_onsets,
            wall_reports: self.wall.reports.as_secs_f64(),
        }
    }

    /// Return the energy warning of the first recording that ended with too large a residual, with a remedy.
    ///
    /// The largest residual at a report may be a twentieth of the dissipated energy. That reference is at least a hundredth of the
    /// exchanged energy, and at least 2e-4 of the kinetic and elastic energy. Exchanged energy is the largest of the dissipated energy, the
    /// external work, and the ranges of kinetic, gravitational and elastic energy.
    #[must_use]
    pub fn balance_note(&self) -> Option<&str> {
        self.balance_note.as_deref()
    }

    /// Begin a recording at the present time.
    pub fn start_recording(&mut self, duration: f64, report_step: f64, groups: S::Groups) {
        self.start_recording_until(self.now + duration, report_step, groups);
    }

    /// Begin a recording at the present time that ends at exactly `end` \[s\].
    pub fn start_recording_until(&mut self, end: f64, report_step: f64, groups: S::Groups) {
        if !S::records_energy(groups) {
            self.system.stop_metering();
        } else if !self.system.keeps_energy() {
            self.system.begin_metering(&self.adams, self.now);
        }
        self.system.set_recorded(Some(groups));
        let mut recorder = Recorder::new(&self.system, groups, [self.now, end], report_step);
        if recorder.has_peaks() {
            // The present time may lie within the last step, whose end then belongs to the first interval.
            self.system.evaluate_step_end(&self.adams);
            recorder.keep_step_forces(&self.system);
        }
        self.recorder = Some(recorder);
    }

    /// End the recording and return it with all rows so far.
    pub fn take_recording(&mut self) -> Recording {
        let Some(recorder) = self.recorder.take() else {
            return Recording::default();
        };
        self.system.set_recorded(None);
        if self.balance_note.is_none() {
            let at_rest = SPEEDS_AT_REST * self.adams.control().speed_error();
            let open = recorder.open_balance(self.system.kinetic_energy_at(at_rest));
            self.balance_note = open.map(|open| self.describe_balance(&open));
        }
        recorder.into_recording()
    }

    /// Remove the first `count` rows of the active recording, or all of them, and return them; the recording continues as if they were still
    /// in it.
    pub fn take_rows(&mut self, count: usize) -> Recording {
        let recorder = self.recorder.as_mut();
        recorder.map_or_else(Recording::default, |recorder| recorder.take_rows(count))
    }

    fn describe_balance(&self, open: &OpenBalance) -> String {
        match self.system.energy_remedy() {
            Some(remedy) => describe_open_balance(open, remedy),
            None => describe_open_balance(open, &tighter_accuracy(&self.adams.control(), open)),
        }
    }

    /// Pause the recording after each report, so that its caller can inspect the state: [`record`](Self::record) then returns, and
    /// continues when called again.
    pub fn pause_at_reports(&mut self) {
        if let Some(recorder) = &mut self.recorder {
            recorder.pauses = true;
        }
    }

    /// Return the active recording, if any.
    #[must_use]
    pub fn recording(&self) -> Option<&Recording> {
        self.recorder.as_ref().map(Recorder::recording)
    }

    /// Continue the recording within `budget` of wall time; return true at its end.
    ///
    /// # Errors
    /// If the integrator cannot continue: time, step size, body and contact.
    pub fn record(&mut self, budget: Duration) -> Result<bool> {
        let Some(end) = self.recorder.as_ref().map(Recorder::end) else {
            return Ok(true);
        };
        self.advance(end, budget)
    }

    /// Integrate to exactly `target` \[s\] within `budget` of wall time; return true when it is reached.
    ///
    /// # Errors
    /// If the integrator cannot continue: time, step size, body and contact. The present time is then the end of the last accepted step.
    pub fn advance(&mut self, target: f64, budget: Duration) -> Result<bool> {
        let now = self.now;
        if target - now > LONGEST {
            let expected = format!("must be at most {LONGEST:e} s after the present time, {now} s");
            return Err(Error::invalid("t", target, expected));
        }
        if self.recorder.is_none() {
            // Without a recording the energy sums are not used, and the quadrature is switched off.
            self.system.stop_metering();
        }
        self.check_intact()?;
        let begin = Instant::now();
        let ended = guarded(|| self.advance_from(begin, target, budget));
        self.wall.runs += begin.elapsed();
        ended.unwrap_or_else(|message| {
            self.now = self.adams.time();
            let time = Some(self.now);
            self.defect = Some(Error::Panicked { time, message });
            self.check_intact().map(|()| false)
        })
    }

    /// Check that no step ended in a panic, after which the state is inconsistent.
    ///
    /// # Errors
    /// The panic that ended [`advance`](Self::advance), until another state is restored.
    pub fn check_intact(&self) -> Result<()> {
        self.defect.clone().map_or(Ok(()), Err)
    }

    fn advance_from(&mut self, begin: Instant, target: f64, budget: Duration) -> Result<bool> {
        let mut steps = 0u32;
        loop {
            if !self.report(begin, budget) {
                return Ok(false);
            }
            if target <= self.adams.time() {
                self.now = target.max(self.now);
                return Ok(true);
            }
            if steps.is_multiple_of(S::STEPS_BETWEEN_CLOCK_READINGS)
                && steps > 0
                && begin.elapsed() >= budget
            {
                self.now = self.adams.time();
                return Ok(false);
            }
            self.step(steps.is_multiple_of(STEPS_FOR_ONE_TIMED))
                .and_then(|()| self.watch_progress(target))
                .inspect_err(|_| self.now = self.adams.time())?;
            steps += 1;
        }
    }

    /// Make one step.
    ///
    /// After an error the system can return to the beginning of the step ([`System::go_back`]); a drive has changed nothing that a next
    /// attempt needs.
    fn step(&mut self, timed: bool) -> Result<()> {
        let begin = timed.then(Instant::now);
        self.system.begin_step(&mut self.adams);
        let step = self.adams.step_second_order(&mut self.system);
        let step = step.map_err(|failure| {
            let culprit = |time, component| self.system.culprit(&self.adams, time, component);
            failure.into_error(culprit)
        });
        let stepped = timed.then(Instant::now);
        let finished = step.and_then(|step| {
            if let Some(recorder) = &mut self.recorder {
                recorder.include_step_energy(&step, &self.system);
            }
            self.system
                .finish_step(&mut self.adams, &step)
                .map(|()| step)
        });
        let step = finished.inspect_err(|_| self.system.go_back(&mut self.adams))?;
        self.limit_step();
        let peaks = self
            .recorder
            .as_mut()
            .filter(|recorder| recorder.has_peaks());
        (self.system).reach_step_end(&self.adams, &step, peaks.is_some());
        if let Some(recorder) = peaks {
            recorder.keep_step_forces(&self.system);
        }
        self.system.meter_step(&self.adams, &step);
        if let (Some(begin), Some(stepped)) = (begin, stepped) {
            self.wall.include(stepped - begin, stepped.elapsed());
        }
        Ok(())
    }

    /// Limit the next step such that no event is missed.
    pub(super) fn limit_step(&mut self) {
        let longest = self.system.longest_step(&self.adams);
        self.adams.limit_step(longest);
    }

    /// Continue after a change of an input at the present time, where the integrator has restarted.
    pub(super) fn resume(&mut self) {
        self.limit_step();
        // The integrator may have gone back: its time since the window began is not that of the steps.
        self.progress = Progress::from(self.adams.counts(), self.adams.time());
        if let Some(recorder) = &mut self.recorder {
            recorder.keep_step_forces(&self.system);
        }
    }

    /// Make the reports within the last step; return false if the budget ended before the last of them, or at a pause.
    fn report(&mut self, start: Instant, budget: Duration) -> bool {
        let Self {
            recorder: Some(recorder),
            adams,
            system,
            ..
        } = self
        else {
            return true;
        };
        let end = adams.time();
        let mut paused = false;
        if recorder.next_report().is_some_and(|t| t <= end) {
            let begin = Instant::now();
            while let Some(t) = recorder.next_report().filter(|&t| t <= end) {
                recorder.report(t, system, adams);
                self.now = t;
                paused = recorder.pauses;
                if paused || start.elapsed() >= budget {
                    break;
                }
            }
            self.wall.reports += begin.elapsed();
        }
        let complete = !paused && recorder.next_report().is_none_or(|t| t > end);
        if complete {
            recorder.take_step_forces(end);
        }
        complete
    }

    /// Return an error if the remaining time to `target` \[s\] would require too many steps.
    fn watch_progress(&mut self, target: f64) -> Result<()> {
        let (counts, time) = (self.adams.counts(), self.adams.time());
        let Some(step_size) = self.progress.stalled(counts, time, target) else {
            return Ok(());
        };
        Err(Error::Standstill {
            time,
            step_size,
            most_steps: MOST_STEPS,
            culprit: self.system.busiest(),
        })
    }
}

/// Check a recording of `duration` \[s\] with the report interval `report_step` \[s\].
///
/// # Errors
/// The error has the field, its value and the permitted range.
pub fn check_reports(duration: f64, report_step: f64) -> Result<()> {
    check::positive("duration", duration, "s")?;
    if duration > LONGEST {
        let expected = format!("must be at most {LONGEST:e} s");
        return Err(Error::invalid("duration", duration, expected));
    }
    check::positive("report_step", report_step, "s")?;
    if duration / report_step > 1e9 {
        return Err(Error::invalid(
            "report_step",
            report_step,
            "gives more than 1e9 reports: make it larger, or the duration shorter",
        ));
    }
    Ok(())
}

//! A run of any system: steps, located events, reports.

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

/// A system in motion: a chain drive, unless another one is named.
#[derive(Debug, Clone)]
pub struct Simulation<S: System = Dynamics> {
    pub(super) system: S,
    pub(super) adams: Adams,
    /// Present time of the user \[s\]; the integrator may be ahead by a part of a step.
    pub(super) now: f64,
    pub(super) recorder: Option<Recorder<S>>,
    wall: Wall,
    /// The first recording whose energy balance did not close, in words.
    balance_note: Option<String>,
    progress: Progress,
    /// The panic that the run ended with.
    defect: Option<Error>,
}

/// What a run has cost so far.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Statistics {
    /// Steps, rejected steps, evaluations.
    pub counts: Counts,
    /// Evaluations of the energy quadrature, which are not among those of the counts.
    pub meter_evaluations: u64,
    /// Contact onsets.
    pub onsets: u64,
    /// Onsets slower than the minimum impact velocity.
    pub onsets_at_floor: u64,
    /// Contacts that closed and opened again inside a step, within the accuracy, and were let pass.
    pub unseen_touches: u64,
    /// Wall time in steps \[s\]; its share is that in the steps that were timed, one of 16.
    pub wall_stepping: f64,
    /// Wall time in event location and energy quadrature, likewise \[s\].
    pub wall_onsets: f64,
    /// Wall time in reports \[s\].
    pub wall_reports: f64,
}

/// A step in so many is timed.
const STEPS_FOR_ONE_TIMED: u32 = 16;

/// Speed that counts as rest, over the error allowed to speeds: drives that rest in static equilibrium move at up to 1.3 times
/// that error. At twice this number, drives that move at six times the error would not be judged by their energy.
const SPEEDS_AT_REST: f64 = 3.0;

impl<S: System> Simulation<S> {
    /// A run of `system` from where `adams` is.
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

    /// Present time \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.now
    }

    /// The integrator.
    #[must_use]
    pub fn integrator(&self) -> &Adams {
        &self.adams
    }

    /// The system as it was last evaluated, with the contacts' memory.
    #[must_use]
    pub fn dynamics(&self) -> &S {
        &self.system
    }

    /// Work of the integrator so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.adams.counts()
    }

    /// What the run has cost so far.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        let events = self.system.event_counts();
        let [wall_stepping, wall_onsets] = self.wall.steps();
        Statistics {
            counts: self.adams.counts(),
            meter_evaluations: self.system.meter_evaluations(),
            onsets: events.onsets,
            onsets_at_floor: events.onsets_at_floor,
            unseen_touches: events.unseen_touches,
            wall_stepping,
            wall_onsets,
            wall_reports: self.wall.reports.as_secs_f64(),
        }
    }

    /// The energy balance residual of the first recording that has ended with more than it may, in words, and what helps.
    ///
    /// The largest residual at a report may be a twentieth of the energy dissipated. Where less was dissipated than a hundredth of the
    /// energy exchanged, or 2e-4 of the kinetic and elastic energy, it may be a twentieth of that. Energy exchanged is the largest of
    /// the energies dissipated, of external work, and moved in and out of kinetic, gravitational and elastic energy.
    #[must_use]
    pub fn balance_note(&self) -> Option<&str> {
        self.balance_note.as_deref()
    }

    /// Begins a recording at the present time.
    pub fn start_recording(&mut self, duration: f64, report_step: f64, groups: S::Groups) {
        if !S::records_energy(groups) {
            self.system.stop_metering();
        } else if !self.system.keeps_energy() {
            self.system.begin_metering(&self.adams);
        }
        self.system.set_recorded(Some(groups));
        let mut recorder = Recorder::new(&self.system, groups, self.now, duration, report_step);
        if recorder.has_peaks() {
            // The present time may lie inside the last step, whose end then belongs to the first interval.
            self.system.evaluate_step_end(&self.adams);
            recorder.keep_step_forces(&self.system);
        }
        self.recorder = Some(recorder);
    }

    /// Ends the recording and hands it over, with all rows made so far.
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

    fn describe_balance(&self, open: &OpenBalance) -> String {
        match self.system.energy_remedy() {
            Some(remedy) => describe_open_balance(open, remedy),
            None => describe_open_balance(open, &tighter_accuracy(&self.adams.control(), open)),
        }
    }

    /// Makes the recording pause after each report, so that its caller can look at the state there: [`record`](Self::record) then
    /// returns, and goes on when it is called again.
    pub fn pause_at_reports(&mut self) {
        if let Some(recorder) = &mut self.recorder {
            recorder.pauses = true;
        }
    }

    /// The recording under way, if any.
    #[must_use]
    pub fn recording(&self) -> Option<&Recording> {
        self.recorder.as_ref().map(Recorder::recording)
    }

    /// Goes on with the recording for as long as `budget` of wall time allows; true when its end is reached.
    ///
    /// # Errors
    /// When the integrator cannot go on: time, step size, body and contact.
    pub fn record(&mut self, budget: Duration) -> Result<bool> {
        let Some(end) = self.recorder.as_ref().map(Recorder::end) else {
            return Ok(true);
        };
        self.advance(end, budget)
    }

    /// Steps to exactly `target` \[s\] for as long as `budget` of wall time allows; true when it is reached.
    ///
    /// # Errors
    /// When the integrator cannot go on: time, step size, body and contact. The run is then where the last accepted step ended.
    pub fn advance(&mut self, target: f64, budget: Duration) -> Result<bool> {
        if self.recorder.is_none() {
            // Nobody reads the sums: a run that goes on without a recording does not make them.
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

    /// After a panic in a step the state is that of no time.
    ///
    /// # Errors
    /// The panic that [`advance`](Self::advance) ended with, until another state is restored.
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

    /// Makes one step; after an error the system is where it was before.
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
                recorder.keep_step_end(&self.system);
            }
            self.system
                .finish_step(&mut self.adams, &step)
                .map(|()| step)
        });
        let step = finished.inspect_err(|_| self.system.go_back(&mut self.adams))?;
        self.limit_step();
        self.system.meter_step(&self.adams, &step);
        if let (Some(begin), Some(stepped)) = (begin, stepped) {
            self.wall.take_in(stepped - begin, stepped.elapsed());
        }
        Ok(())
    }

    /// Bounds the next step by what must not pass unseen.
    pub(super) fn limit_step(&mut self) {
        let longest = self.system.longest_step(&self.adams);
        self.adams.limit_step(longest);
    }

    /// Makes the reports that lie inside the last step; false when the budget ended before all were made, or at a pause.
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

    /// An error where the way to `target` \[s\] would take more steps than are worth waiting for.
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

/// A recording of `duration` \[s\] with rows `report_step` \[s\] apart.
///
/// # Errors
/// Names the field, its value and what is allowed.
pub fn check_reports(duration: f64, report_step: f64) -> Result<()> {
    check::positive("duration", duration, "s")?;
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

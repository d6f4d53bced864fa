//! A mechanism being run: steps, projection, what to go back to.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::recording::MechanismRecording;
use super::reports::Reports;
use crate::error::{Error, Result};
use crate::integrator::{Adams, Counts, MOST_STEPS, OdeSystem, Progress, StepControl};
use crate::multibody::assembly::placement::Assembly;
use crate::multibody::assembly::projection::AtHand;
use crate::multibody::contact::impact_memory::Memory;
use crate::multibody::dynamics::{MechanismDynamics, Stabilisation};
use crate::multibody::model::MechanismModel;
use crate::panics::guarded;

/// A mechanism in motion.
#[derive(Debug, Clone)]
pub struct MechanismSimulation {
    pub(crate) dynamics: MechanismDynamics,
    pub(crate) adams: Adams,
    assembly: Assembly,
    pub(crate) now: f64,
    /// What projections had added when the last step began, and when that was.
    pub(crate) shift_before: Vec<f64>,
    pub(crate) step_start: f64,
    pub(crate) recording: MechanismRecording,
    /// Next report, time between two, last one; none when nothing is recorded.
    pub(crate) reports: Option<Reports>,
    pub(crate) onsets: u64,
    /// The first recording whose energy balance did not close, in words.
    pub(crate) balance_note: Option<String>,
    pub(crate) progress: Progress,
    /// What to go back to when a step fails.
    accepted: Accepted,
    /// Scratch: a state.
    pub(crate) inside: Vec<f64>,
    /// The panic that the run ended with.
    pub(crate) defect: Option<Error>,
}

/// Where the last accepted step ended.
#[derive(Debug, Clone, Default)]
struct Accepted {
    time: f64,
    solution: Vec<f64>,
    memory: Vec<Memory>,
    onsets: u64,
}

/// Iterations that a projection may take in a run, where it begins near.
pub(crate) const ITERATIONS: usize = 12;

impl MechanismSimulation {
    /// A run from where the mechanism is placed, assembled.
    ///
    /// # Errors
    /// When a control does not fit or the mechanism does not go together.
    pub fn new(
        model: Arc<MechanismModel>,
        control: StepControl,
        stabilisation: Stabilisation,
    ) -> Result<Self> {
        Self::new_unless(model, control, stabilisation, &|| false)
    }

    /// The same; `give_up` is asked now and then while the mechanism is assembled, and ends that with an error.
    ///
    /// # Errors
    /// When a control does not fit or the mechanism does not go together.
    pub fn new_unless(
        model: Arc<MechanismModel>,
        control: StepControl,
        stabilisation: Stabilisation,
        give_up: &dyn Fn() -> bool,
    ) -> Result<Self> {
        control.validate()?;
        let mut dynamics = MechanismDynamics::new(model, stabilisation);
        let assembly = dynamics.assemble_unless(give_up)?;
        let mut y = dynamics.with_bristles(&assembly.state);
        y.extend([0.0, 0.0]);
        let mut adams = Adams::new(dynamics.dimension(), control);
        adams.restart(0.0, &y);
        let mut simulation = Self {
            shift_before: dynamics.shift.clone(),
            step_start: 0.0,
            now: 0.0,
            recording: MechanismRecording::default(),
            reports: None,
            onsets: 0,
            balance_note: None,
            progress: Progress::default(),
            accepted: Accepted::default(),
            inside: y,
            defect: None,
            dynamics,
            adams,
            assembly,
        };
        simulation.remember_present_contacts();
        simulation.begin_step(0.0, control.max_step);
        Ok(simulation)
    }

    /// What assembling found.
    #[must_use]
    pub fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    /// Present time \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.now
    }

    /// Work of the integrator so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.adams.counts()
    }

    /// Contacts begun so far.
    #[must_use]
    pub fn onsets(&self) -> u64 {
        self.onsets
    }

    /// The energy balance of the first recording that has ended with a larger residual than it may have, in words.
    #[must_use]
    pub fn balance_note(&self) -> Option<&str> {
        self.balance_note.as_deref()
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &Arc<MechanismModel> {
        self.dynamics.model()
    }

    /// Goes on with the recording for as long as `budget` of wall time allows; true when its end is reached.
    ///
    /// # Errors
    /// When the integrator or the joints cannot go on: time, step size and the body or joint.
    pub fn record(&mut self, budget: Duration) -> Result<bool> {
        let end = self.reports.map_or(self.now, |reports| reports.end());
        self.advance(end, budget)
    }

    /// Steps to exactly `target` \[s\] for as long as `budget` of wall time allows; true when it is reached.
    ///
    /// # Errors
    /// When the integrator or the joints cannot go on: time, step size and the body or joint.
    pub fn advance(&mut self, target: f64, budget: Duration) -> Result<bool> {
        self.check_intact()?;
        guarded(|| self.advance_for(target, budget)).unwrap_or_else(|message| {
            let time = Some(self.adams.time());
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

    fn advance_for(&mut self, target: f64, budget: Duration) -> Result<bool> {
        let begin = Instant::now();
        let mut first = true;
        loop {
            if !self.report() {
                return Ok(false);
            }
            if target <= self.adams.time() {
                self.now = target.max(self.now);
                return Ok(true);
            }
            // A step of a large mechanism takes a good part of a second.
            if !first && begin.elapsed() >= budget {
                self.now = self.adams.time();
                return Ok(false);
            }
            self.keep();
            if let Err(error) = self.step().and_then(|()| self.watch_progress(target)) {
                self.go_back();
                return Err(error);
            }
            first = false;
        }
    }

    /// Keeps what a step changes, of which the integrator's history is not worth a copy a step.
    fn keep(&mut self) {
        let accepted = &mut self.accepted;
        accepted.time = self.adams.time();
        accepted.solution.clear();
        accepted.solution.extend_from_slice(self.adams.y());
        accepted.memory.clone_from(&self.dynamics.memory);
        accepted.onsets = self.onsets;
        self.shift_before.copy_from_slice(&self.dynamics.shift);
    }

    /// Whether the circle of a contact was behind an open outline when the last step began.
    pub(crate) fn was_behind(&self, k: usize) -> bool {
        self.accepted.memory.get(k) == Some(&Memory::BEHIND)
    }

    /// Approach speed that a side of a contact remembered when the last step began.
    pub(crate) fn accepted_speed(&self, k: usize) -> f64 {
        self.accepted
            .memory
            .get(k)
            .map_or(0.0, |memory| memory.speed)
    }

    /// Forgets how the last step began.
    pub(crate) fn forget_accepted(&mut self) {
        self.accepted = Accepted::default();
    }

    /// After a step that failed: the state where the last accepted one ended, from which the integrator starts anew.
    fn go_back(&mut self) {
        let accepted = &self.accepted;
        self.adams.restart(accepted.time, &accepted.solution);
        self.dynamics.shift.copy_from_slice(&self.shift_before);
        self.dynamics.shift_time = accepted.time;
        self.dynamics.memory.clone_from(&accepted.memory);
        self.onsets = accepted.onsets;
        (self.now, self.step_start) = (accepted.time, accepted.time);
    }

    fn step(&mut self) -> Result<()> {
        // The explicit corrector ends with an evaluation where the step does.
        let at_hand = if self.adams.is_implicit() {
            AtHand::Factors
        } else {
            AtHand::Everything
        };
        let step = self.adams.step_second_order(&mut self.dynamics);
        let step = step.map_err(|failure| {
            let model = Arc::clone(self.dynamics.model());
            failure.into_error(|_, component| {
                let part = model.owner_of(component % model.unknowns());
                format!("{part}{}", self.dynamics.hardest_pressed())
            })
        })?;
        self.step_start = step.start;
        if self.reports.is_some() {
            self.recording.arrive(&self.dynamics);
        }
        self.find_onsets(step.start, step.end);
        self.unbend_parted();
        if self.dynamics.stabilisation == Stabilisation::Projection {
            self.project(step.end, at_hand)?;
        }
        // Twice the step that would be next: whether it is near to its limit is asked for, too.
        self.begin_step(step.end, 2.0 * self.adams.step_size());
        Ok(())
    }

    /// Unbends the bristles of contacts that came apart: they begin anew with the next contact. They bear nothing, and their past
    /// becomes one in which they were never bent, so that the integrator goes on.
    fn unbend_parted(&mut self) {
        if self.dynamics.model.bristles == 0 {
            return;
        }
        let (first, unknowns) = (
            self.dynamics.model.coordinates(),
            self.dynamics.model.unknowns(),
        );
        for bristle in self.dynamics.parted_bristles() {
            self.adams.reset_component(first + bristle);
            self.adams.reset_component(unknowns + first + bristle);
        }
    }

    /// Bounds the next step by what is near where everything was evaluated last; a bound above `within` is none.
    fn begin_step(&mut self, t: f64, within: f64) {
        self.dynamics.begin_screening();
        self.adams.limit_step(self.dynamics.longest_step(t, within));
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
            culprit: format!("the mechanism{}", self.dynamics.hardest_pressed()),
        })
    }

    /// Takes what the step has left on the constraints off the solution, and leaves the integrator's history as it is.
    fn project(&mut self, t: f64, at_hand: AtHand) -> Result<()> {
        if !self.dynamics.is_constrained() {
            return Ok(());
        }
        let n = self.dynamics.shift.len();
        let state = &mut self.inside[..n];
        let solution = self.adams.y();
        self.dynamics.read(solution, state);
        self.dynamics.add_shift(t, state);
        if !self.dynamics.project(t, state, ITERATIONS, at_hand) {
            let residuals = self.dynamics.what_misses();
            return Err(Error::JointsApart { time: t, residuals });
        }
        let dynamics = &mut self.dynamics;
        for (i, (shift, x)) in dynamics.shift.iter_mut().zip(state).enumerate() {
            *shift = *x - solution[dynamics.model.component(i)];
        }
        self.dynamics.shift_time = t;
        Ok(())
    }
}

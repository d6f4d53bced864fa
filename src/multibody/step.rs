//! One step of a run: what it begins with, projection where it ends, and the state inside it.

use super::MechanismDynamics;
use super::assembly::projection::AtHand;
use super::contact::impact_memory::Memory;
use super::dynamics::Stabilisation;
use super::system::MechanismSums;
use crate::error::{Error, Result};
use crate::integrator::{Adams, OdeSystem};

/// Iterations that a projection may take in a run, where it begins near.
const ITERATIONS: usize = 12;

/// Where the last step began: what to go back to when it fails, and what holds inside it.
#[derive(Debug, Clone, Default)]
pub(super) struct StepStart {
    pub(super) time: f64,
    solution: Vec<f64>,
    pub(super) shift: Vec<f64>,
    pub(super) shift_time: f64,
    pub(super) memory: Vec<Memory>,
    onsets: u64,
    /// Whether the step is made with the implicit corrector, which ends with an evaluation beside the solution.
    is_implicit: bool,
}

impl StepStart {
    /// Of a mechanism with so many coordinates and velocities, and sides of contacts, before its first step.
    pub(super) fn new(dimension: usize, sides: usize) -> Self {
        Self {
            shift: vec![0.0; dimension],
            memory: vec![Memory::default(); sides],
            ..Self::default()
        }
    }
}

impl MechanismDynamics {
    /// Keeps what a step changes. The integrator's history is not worth a copy a step.
    pub(super) fn keep_step_start(&mut self, adams: &Adams) {
        let start = &mut self.step;
        start.time = adams.time();
        start.is_implicit = adams.is_implicit();
        start.solution.clear();
        start.solution.extend_from_slice(adams.y());
        start.memory.clone_from(&self.memory);
        start.shift.clone_from(&self.shift);
        start.shift_time = self.shift_time;
        start.onsets = self.onsets;
    }

    /// Returns to where the last step began, from which the integrator starts anew.
    pub(super) fn return_to_step_start(&mut self, adams: &mut Adams) {
        let start = &self.step;
        adams.restart(start.time, &start.solution);
        self.shift.copy_from_slice(&start.shift);
        self.shift_time = start.time;
        self.memory.clone_from(&start.memory);
        self.onsets = start.onsets;
    }

    /// Whether the circle of a contact was behind an open outline when the last step began.
    fn was_behind(&self, k: usize) -> bool {
        self.step.memory.get(k) == Some(&Memory::BEHIND)
    }

    /// Initial impact velocity that a side of a contact remembered when the last step began.
    pub(super) fn speed_at_step_start(&self, k: usize) -> f64 {
        let memory = self.step.memory.get(k);
        memory.map_or(0.0, |memory| memory.speed)
    }

    /// Moves the end of the last step onto the constraints, and leaves the integrator's solution and history as they are.
    pub(super) fn project_step_end(&mut self, adams: &Adams) -> Result<()> {
        if !self.is_constrained() || self.stabilisation != Stabilisation::Projection {
            return Ok(());
        }
        // The explicit corrector ends with an evaluation where the step does.
        let at_hand = if self.step.is_implicit {
            AtHand::Factors
        } else {
            AtHand::Everything
        };
        let t = adams.time();
        let mut state = std::mem::take(&mut self.inside);
        let solution = adams.y();
        self.read(solution, &mut state);
        self.add_shift(t, &mut state);
        if !self.project(t, &mut state, ITERATIONS, at_hand) {
            let residuals = self.what_misses();
            self.inside = state;
            return Err(Error::JointsApart { time: t, residuals });
        }
        for (i, (shift, x)) in self.shift.iter_mut().zip(&state).enumerate() {
            *shift = x - solution[self.model.component(i)];
        }
        self.shift_time = t;
        self.inside = state;
        Ok(())
    }

    /// The state at `t` inside the last step: the dense output and the part of the shift that belongs there.
    pub(crate) fn state_at(&mut self, adams: &Adams, t: f64, state: &mut [f64]) {
        let (end, n) = (adams.time(), self.model.coordinates());
        let mut solution = std::mem::take(&mut self.solution);
        if t == end {
            solution.copy_from_slice(adams.y());
        } else {
            adams.interpolate(t, &mut solution);
        }
        self.read(&solution, state);
        let first = 2 * self.model.unknowns();
        self.sums = MechanismSums {
            dissipated: solution[first],
            external_work: solution[first + 1],
        };
        self.solution = solution;
        let start = self.step.time;
        let part = part_of_step(start, end, t);
        let (length, since) = (end - start, t - start);
        let (before, after) = (&self.step.shift, &self.shift);
        for (i, (x, after)) in state.iter_mut().zip(after).enumerate() {
            // The shift of coordinates grows by that of their velocities; projection has changed what it came to.
            let growth = if i < n { before[n + i] } else { 0.0 };
            let change = after - (before[i] + length * growth);
            *x += before[i] + since * growth + part * change;
        }
    }

    /// Evaluates everything at `t` inside the last step, on the constraints.
    pub(crate) fn evaluate_inside(&mut self, adams: &Adams, t: f64) {
        let mut state = std::mem::take(&mut self.inside);
        self.state_at(adams, t, &mut state);
        if self.stabilisation == Stabilisation::Projection {
            self.project(t, &mut state, ITERATIONS, AtHand::Nothing);
        }
        // What came out from behind in this step was still there before its end.
        let out = |k: usize| self.was_behind(k) && t < adams.time();
        let out: Vec<usize> = (0..self.memory.len()).filter(|&k| out(k)).collect();
        let kept: Vec<Memory> = out.iter().map(|&k| self.memory[k]).collect();
        for &k in &out {
            self.memory[k] = Memory::BEHIND;
        }
        self.evaluate(t, &state);
        for (k, memory) in out.into_iter().zip(kept) {
            self.memory[k] = memory;
        }
        self.inside = state;
    }

    /// Evaluates the right-hand side at the integrator's `y`, for what it leaves behind.
    pub(super) fn differentiate(&mut self, t: f64, y: &[f64]) {
        let mut slope = std::mem::take(&mut self.slope);
        self.derivative(t, y, &mut slope);
        self.slope = slope;
    }

    /// Body or bristle of a component of the state, and what carries the largest forces.
    pub(super) fn describe_culprit(&self, component: usize) -> String {
        let part = self.model.owner_of(component % self.model.unknowns());
        format!("{part}{}", self.hardest_pressed())
    }

    /// Unbends the bristles of contacts that came apart: they begin anew with the next contact. They bear nothing, and their past
    /// becomes one in which they were never bent, so that the integrator goes on.
    pub(super) fn unbend_parted(&self, adams: &mut Adams) {
        if self.model.bristles == 0 {
            return;
        }
        let (first, unknowns) = (self.model.coordinates(), self.model.unknowns());
        for bristle in self.parted_bristles() {
            adams.reset_component(first + bristle);
            adams.reset_component(unknowns + first + bristle);
        }
    }
}

fn part_of_step(start: f64, end: f64, t: f64) -> f64 {
    if end > start {
        ((t - start) / (end - start)).clamp(0.0, 1.0)
    } else {
        1.0
    }
}

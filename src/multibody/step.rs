//! One step of a run: its longest size, the state at its start, projection at its end, and the state within it.

use super::MechanismDynamics;
use super::assembly::projection::AtHand;
use super::contact::impact_memory::Memory;
use super::newton::stage::{is_nearness_due, largest_rotation};
use super::step_start::ITERATIONS;
use super::sums::MechanismSums;
use crate::error::{Error, Result};
use crate::integrator::{Adams, OdeSystem};

impl MechanismDynamics {
    /// Return whether an acceleration that a driver prescribes jumps at the end of the last step.
    ///
    /// A step ends at such a jump, and its last evaluation has the acceleration before it. The next step begins with the one behind it.
    pub(super) fn ends_at_jump(&self, adams: &Adams) -> bool {
        let motions = self.model.equations.iter();
        let mut motions = motions.filter_map(|equation| equation.motion.as_ref());
        motions.any(|motion| motion.jumps(adams.time(), self.step.time))
    }

    /// Restart the integrator where the last step ended at a jump of a prescribed acceleration: its history is that before the jump.
    pub(super) fn restart_behind_jump(&mut self, adams: &mut Adams) {
        if adams.is_starting() || !self.ends_at_jump(adams) {
            return;
        }
        let mut solution = std::mem::take(&mut self.work.solution);
        solution.copy_from_slice(adams.y());
        adams.restart_with_corrector(adams.time(), &solution);
        self.work.solution = solution;
    }

    /// Store the data that a step changes. The integrator's history is not copied: a return restarts the integrator.
    pub(super) fn keep_step_start(&mut self, adams: &Adams) {
        let start = &mut self.step;
        start.time = adams.time();
        self.constraints.step_start = start.time;
        start.is_implicit = adams.is_implicit();
        start.solution.clear();
        start.solution.extend_from_slice(adams.y());
        start.memory.clone_from(&self.contacts.memory);
        start.shift.clone_from(&self.shift.values);
        start.onsets = self.onsets.numbers;
    }

    /// Return to the start of the last step and restart the integrator there.
    pub(super) fn return_to_step_start(&mut self, adams: &mut Adams) {
        let start = &self.step;
        adams.restart(start.time, &start.solution);
        self.shift.values.copy_from_slice(&start.shift);
        self.shift.time = start.time;
        self.contacts.memory.clone_from(&start.memory);
        self.onsets.numbers = start.onsets;
        if let Some(onsets) = &mut self.onsets.unreported {
            onsets.retain(|onset| onset.time <= start.time);
        }
    }

    /// Project the end of the last step onto the constraints. The correction enters the shift; the integrator's solution and history
    /// remain.
    pub(super) fn project_step_end(&mut self, adams: &Adams) -> Result<()> {
        let (number, length) = (adams.counts().steps, adams.time() - self.step.time);
        // The last evaluation of the explicit corrector is at the end of the step; that of the implicit one may have no factors.
        let regular = self.corrector.reactions.regular();
        let at_hand = match (self.step.is_implicit, regular) {
            (true, true) if is_nearness_due(&self.frames, length, number) => AtHand::Nothing,
            (true, true) => AtHand::Corrector,
            (true, false) => AtHand::Factors,
            (false, _) => AtHand::Everything,
        };
        self.project_end(adams, at_hand)?;
        let turned = largest_rotation(&self.frames, length);
        let measured = at_hand != AtHand::Corrector;
        let reactions = &mut self.corrector.reactions;
        reactions.keep(&self.constraints, &self.accelerations, turned, measured);
        Ok(())
    }

    /// Project the end of the last step; `at_hand` is known of the factors there.
    fn project_end(&mut self, adams: &Adams, at_hand: AtHand) -> Result<()> {
        if !self.is_constrained() {
            return Ok(());
        }
        let t = adams.time();
        let mut state = std::mem::take(&mut self.work.inside);
        let solution = adams.y();
        (self.contacts.bristles).read(&self.model, solution, &mut state);
        self.shift.add(t, &mut state);
        if !(self.projector()).project(t, &mut state, ITERATIONS, at_hand) {
            let residuals = self
                .constraints
                .largest_residuals(&self.model, &self.frames);
            self.work.inside = state;
            return Err(Error::JointsApart { time: t, residuals });
        }
        // The new shift is the projected state less the integrator's solution.
        for (i, (shift, x)) in self.shift.values.iter_mut().zip(&state).enumerate() {
            *shift = x - solution[self.model.component(i)];
        }
        self.shift.time = t;
        self.work.inside = state;
        Ok(())
    }

    /// Write the state at `t` within the last step: the dense output plus the shift at `t`.
    pub(crate) fn state_at(&mut self, adams: &Adams, t: f64, state: &mut [f64]) {
        let (end, n) = (adams.time(), self.model.coordinates());
        let mut solution = std::mem::take(&mut self.work.solution);
        if t == end {
            solution.copy_from_slice(adams.y());
        } else {
            adams.interpolate(t, &mut solution);
        }
        (self.contacts.bristles).read(&self.model, &solution, state);
        let first = 2 * self.model.unknowns();
        self.sums = MechanismSums {
            dissipated: solution[first],
            external_work: solution[first + 1],
        };
        self.work.solution = solution;
        let start = self.step.time;
        let part = part_of_step(start, end, t);
        let (length, since) = (end - start, t - start);
        let (before, after) = (&self.step.shift, &self.shift.values);
        for (i, (x, after)) in state.iter_mut().zip(after).enumerate() {
            // The shift of coordinates grows at the rate of the shift of velocities. The correction of the projection at the step's
            // end is distributed linearly over the step.
            let growth = if i < n { before[n + i] } else { 0.0 };
            let change = after - (before[i] + length * growth);
            *x += before[i] + since * growth + part * change;
        }
    }

    /// Evaluate everything at `t` within the last step, on the constraints.
    pub(crate) fn evaluate_inside(&mut self, adams: &Adams, t: f64) {
        let mut state = std::mem::take(&mut self.work.inside);
        self.state_at(adams, t, &mut state);
        (self.projector()).project(t, &mut state, ITERATIONS, AtHand::Nothing);
        let replaced = self.restore_memory(adams, t);
        self.evaluate(t, &state);
        for (k, memory) in replaced {
            self.contacts.memory[k] = memory;
        }
        self.work.inside = state;
    }

    /// Set the memory of the contacts to that at `t` within the last step; return the sides changed, with what they had.
    pub(super) fn restore_memory(&mut self, adams: &Adams, t: f64) -> Vec<(usize, Memory)> {
        if t < adams.time() {
            self.contacts.restore_memory(&self.step.memory)
        } else {
            Vec::new()
        }
    }

    /// Evaluate the right-hand side at the integrator's `y` and discard the derivative.
    pub(super) fn differentiate(&mut self, t: f64, y: &[f64]) {
        let mut derivative = std::mem::take(&mut self.work.derivative);
        self.derivative(t, y, &mut derivative);
        self.work.derivative = derivative;
    }

    /// Return the body or bristle of a component of the state, or that it is an energy sum, and the largest forces, as text.
    pub(super) fn describe_culprit(&self, component: usize) -> String {
        let unknowns = self.model.unknowns();
        let part = if component < 2 * unknowns {
            self.model.owner_of(component % unknowns)
        } else {
            "the energy balance".into()
        };
        format!("{part}{}", self.hardest_pressed())
    }

    /// Return the longest step from `t` \[s\] within which no event is missed.
    ///
    /// Contacts: no circle may reach a profile that it is not near to, by the present velocities and accelerations. Drivers and
    /// forces: no kink and no short pulse is skipped. Bounds of contacts above `within` are returned as infinite.
    pub(crate) fn longest_step_within(&self, t: f64, within: f64) -> f64 {
        let motions = self
            .model
            .equations
            .iter()
            .filter_map(|e| e.motion.as_ref());
        let motions = motions.map(|motion| motion.longest_step(t));
        let forces = self.model.forces.iter().map(|force| force.longest_step(t));
        let longest = motions.chain(forces).fold(f64::INFINITY, f64::min);
        let bodies = &self.model.contact_bodies;
        let (model, accelerations) = (&self.model, &self.accelerations);
        let of_body = |body| model.accelerations_of(body, accelerations);
        if bodies.stay_close(&self.frames, of_body, within) {
            return longest;
        }
        let contacts = self.model.contacts.iter().zip(&self.model.sides_of_contact);
        let times = contacts.map(|(contact, sides)| {
            let side_states = &self.contacts.side_states[sides.clone()];
            let of_pair = model.accelerations_of_pair(contact, accelerations);
            contact.free_time(&self.frames, of_pair, side_states, within)
        });
        times.fold(longest, f64::min)
    }

    /// Reset the bristles of contacts that have ended, so they start undeflected at the next onset. They exert no force. The history
    /// of their components becomes zero as well, so the integrator continues without a restart.
    pub(super) fn reset_bristles_of_ended_contacts(&self, adams: &mut Adams) {
        if self.model.bristles == 0 {
            return;
        }
        let (first, unknowns) = (self.model.coordinates(), self.model.unknowns());
        for bristle in self.contacts.bristles_of_ended_contacts(&self.model) {
            adams.reset_component(first + bristle);
            adams.reset_component(unknowns + first + bristle);
        }
    }
}

/// Return the position of `t` in the step, from 0 to 1.
fn part_of_step(start: f64, end: f64, t: f64) -> f64 {
    if end > start {
        ((t - start) / (end - start)).clamp(0.0, 1.0)
    } else {
        1.0
    }
}

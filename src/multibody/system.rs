//! Implementation of the trait `System` for mechanisms: the steps and the recording of a run.

use serde::{Deserialize, Serialize};

use super::contact::contact_states::ContactEnd;
use super::contact::impact_memory::Memory;
use super::contact::onset::{OnsetNumbers, StepMotion};
use super::dynamics::MechanismDynamics;
use super::inputs::MechanismInput;
use super::newton::stage::StepReactions;
use super::report::{self, JOINTS, MechanismGroups};
use super::sums::MechanismSums;
use crate::error::Result;
use crate::integrator::{Adams, Step};
use crate::system::{Channel, Energy, EventCounts, Identity, Row, System, hash};

/// State of the dynamics that, with the integrator's state, determines the rest of a run.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct MechanismCheckpoint {
    inputs: Vec<MechanismInput>,
    shift: Vec<f64>,
    memory: Vec<Memory>,
    /// Time, shift and memory at the start of the last step.
    step_start: (f64, Vec<f64>, Vec<Memory>),
    starts: Vec<ContactEnd>,
    reactions: StepReactions,
    onsets: OnsetNumbers,
    past_ends: Vec<Option<String>>,
}

impl System for MechanismDynamics {
    type Groups = MechanismGroups;
    type Powers = MechanismSums;
    type Checkpoint = MechanismCheckpoint;

    const KIND: &'static str = "mechanism";
    /// A step of a large mechanism can take a considerable part of a second.
    const STEPS_BETWEEN_CLOCK_READINGS: u32 = 1;

    fn identity(&self) -> Vec<Identity> {
        let model = &self.inputs.compiled;
        let bodies = (&model.bodies, &model.gravity, &model.equations, &model.pins);
        let text = format!("{:?}", (bodies, &model.forces, &model.contacts));
        vec![Identity {
            field: "mechanism",
            value: format!("model {:016x}", hash(text.as_bytes())),
            remedy: "the state is of another scene; make the simulation with the same drive or mechanism, described in the same order, and start",
        }]
    }

    fn begin_step(&mut self, adams: &mut Adams) {
        self.restart_behind_jump(adams);
        self.keep_step_start(adams);
    }

    fn finish_step(&mut self, adams: &mut Adams, step: &Step) -> Result<()> {
        self.reset_bristles_of_ended_contacts(adams);
        let motion = StepMotion {
            model: &self.model,
            frames: &self.frames,
            shift: &self.shift,
            adams,
            memory_at_start: &self.step.memory,
        };
        (self.contacts).find_onsets(&motion, step, &mut self.onsets);
        self.contacts.note_ranges(&self.model);
        self.project_step_end(adams)
    }

    fn longest_step(&mut self, adams: &Adams) -> f64 {
        let accelerations = &self.accelerations;
        (self.contacts).begin_screening(&self.model, &self.frames, accelerations);
        // The bound is evaluated up to twice the next step size, as step size control also tests whether a step is close to its
        // bound.
        let within = if adams.is_starting() || self.ends_at_jump(adams) {
            adams.control().max_step
        } else {
            2.0 * adams.step_size()
        };
        self.longest_step_within(adams.time(), within)
    }

    fn go_back(&mut self, adams: &mut Adams) {
        self.return_to_step_start(adams);
    }

    fn culprit(&mut self, _adams: &Adams, _time: f64, component: usize) -> String {
        self.describe_culprit(component)
    }

    fn busiest(&self) -> String {
        format!("the mechanism{}", self.hardest_pressed())
    }

    fn event_counts(&self) -> EventCounts {
        EventCounts {
            onsets: self.onsets.numbers.all,
            onsets_at_minimum_velocity: self.onsets.numbers.at_minimum,
            ..EventCounts::default()
        }
    }

    fn sums_at(&self, _t: f64) -> MechanismSums {
        self.sums
    }

    fn energy(&self) -> Energy {
        self.energies()
    }

    fn without_stored(&self, mut sums: MechanismSums) -> MechanismSums {
        sums.dissipated -= self.loads.bristles;
        sums
    }

    fn kinetic_energy_at(&self, speed: f64) -> f64 {
        let free = self.model.bodies.iter().filter(|body| !body.fixed);
        0.5 * free.map(|body| body.mass).sum::<f64>() * speed * speed
    }

    /// Energy exchanged between two reports, as in a bounce, is included.
    fn energy_at_step_end(&self) -> Option<Energy> {
        Some(self.energies())
    }

    fn records_energy(groups: MechanismGroups) -> bool {
        groups.energy
    }

    fn channels(&self, groups: MechanismGroups) -> Vec<Channel> {
        report::channels(&self.model, groups)
    }

    fn peak_sizes(&self, groups: MechanismGroups) -> Vec<usize> {
        let of = |recorded: bool, count: usize| if recorded { count } else { 0 };
        vec![
            of(groups.joints, self.model.joints.len()),
            of(groups.contacts, self.model.contacts.len()),
        ]
    }

    fn reach_step_end(&mut self, adams: &Adams, _step: &Step, peaks: bool) {
        if peaks && adams.correction_after_evaluation().is_some() {
            self.evaluate_step_end(adams);
        }
    }

    fn evaluate_step_end(&mut self, adams: &Adams) {
        self.differentiate(adams.time(), adams.y());
    }

    fn write_peak_forces(&self, kind: usize, forces: &mut [f64]) {
        if kind == JOINTS {
            for (joint, force) in forces.iter_mut().enumerate() {
                *force = self.joint_force(joint);
            }
        } else {
            for (force, push) in forces.iter_mut().zip(self.contacts.pushes(&self.model)) {
                *force = push.norm();
            }
        }
    }

    fn set_recorded(&mut self, groups: Option<MechanismGroups>) {
        self.onsets.unreported = groups.filter(|groups| groups.contacts).map(|_| Vec::new());
    }

    fn evaluate_report(&mut self, adams: &Adams, t: f64, _groups: MechanismGroups) {
        self.evaluate_inside(adams, t);
        // Penetrations inside a step may exceed those at its ends.
        self.contacts.note_ranges(&self.model);
    }

    fn write_row(&mut self, row: &mut Row, t: f64, groups: MechanismGroups) {
        report::write_row(row, self, t, groups);
    }

    fn checkpoint(&self) -> MechanismCheckpoint {
        let start = &self.step;
        MechanismCheckpoint {
            inputs: self.inputs.set.clone(),
            shift: self.shift.values.clone(),
            memory: self.contacts.memory.clone(),
            step_start: (start.time, start.shift.clone(), start.memory.clone()),
            starts: self.contacts.starts.clone(),
            reactions: self.corrector.reactions.clone(),
            onsets: self.onsets.numbers,
            past_ends: self.contacts.past_ends.clone(),
        }
    }

    fn restored(&self, checkpoint: &MechanismCheckpoint, adams: &Adams) -> Option<Self> {
        let (time, shift, memory) = &checkpoint.step_start;
        let alike = checkpoint.shift.len() == self.shift.values.len()
            && checkpoint.memory.len() == self.contacts.memory.len()
            && shift.len() == self.shift.values.len()
            && memory.len() == self.contacts.memory.len()
            && checkpoint.starts.len() == self.contacts.starts.len()
            && checkpoint.past_ends.len() == self.contacts.past_ends.len()
            && checkpoint
                .reactions
                .is_within(self.constraints.rows.len(), self.accelerations.len());
        // A checkpoint of other sizes belongs to another mechanism.
        let mut dynamics = alike.then(|| self.clone())?;
        dynamics.replace_inputs(&checkpoint.inputs)?;
        dynamics.shift.values.clone_from(&checkpoint.shift);
        // The shift refers to the end of a step.
        dynamics.shift.time = adams.time();
        dynamics.contacts.memory.clone_from(&checkpoint.memory);
        dynamics.step.time = *time;
        dynamics.constraints.step_start = *time;
        dynamics.step.shift.clone_from(shift);
        dynamics.step.memory.clone_from(memory);
        dynamics.contacts.starts.clone_from(&checkpoint.starts);
        (dynamics.corrector.reactions).clone_from(&checkpoint.reactions);
        dynamics.onsets.numbers = checkpoint.onsets;
        (dynamics.contacts.past_ends).clone_from(&checkpoint.past_ends);
        Some(dynamics)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::multibody::{Body, Mechanism, MechanismModel};

    #[test]
    fn the_energies_of_a_mechanism_are_part_of_its_solution() {
        let mut mechanism = Mechanism::default();
        mechanism
            .bodies
            .push(Body::new("block", 2.0, 0.1).moving(3.0, 0.0, 1.0));
        let model = Arc::new(MechanismModel::compile(&mechanism).unwrap());
        let dynamics = MechanismDynamics::new(model);
        // No quadrature evaluates the right-hand side, and no energy is left out.
        assert!(dynamics.keeps_energy());
        assert_eq!(dynamics.energy_evaluations(), 0);
        assert_eq!(dynamics.prescribed_energy(), 0.0);
        // m v²/2 of the body at any speed.
        assert_eq!(dynamics.kinetic_energy_at(3.0), 9.0);
        // An error of the sums is one of no body.
        for component in 0..dynamics.model.dimension() {
            let said = dynamics.describe_culprit(component);
            let expected = if component < 6 {
                "body \"block\""
            } else {
                "the energy balance"
            };
            assert!(said.starts_with(expected), "{component}: {said}");
        }
    }
}

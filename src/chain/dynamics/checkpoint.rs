//! Checkpoint of the dynamics: all quantities of a run that an evaluation of the right-hand side does not recompute.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::contact_events::Restart;
use super::{Dynamics, Inputs, Powers};
use crate::chain::contact::{CandidatesCheckpoint, ContactId, ImpactMemory, ToothJumps};
use crate::chain::model::Input;
use crate::chain::rhs::EventScreening;
use crate::geometry::Surface;
use crate::system::EnergyQuadrature;

/// State of the dynamics that, with the state of the integrator, determines the continuation of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    inputs: Vec<Input>,
    memory: ImpactMemory,
    candidates: CandidatesCheckpoint,
    screening: EventScreening,
    fastest: f64,
    in_step_contacts: u64,
    keeps_energy: bool,
    quadrature: EnergyQuadrature<Powers>,
    ended: Vec<ContactId>,
    restarted: Vec<Restart>,
    hinge_past_range: Option<String>,
    tooth_past_range: Option<String>,
    tooth_jumps: ToothJumps,
    jumps_searched_at: u64,
    /// Forces of ideal hinges at the end of the last step; none where hinges have clearance.
    hinge_forces: Option<[Vec<f64>; 2]>,
}

impl Dynamics {
    /// Return the checkpoint of these dynamics.
    pub(super) fn to_checkpoint(&self) -> Checkpoint {
        Checkpoint {
            inputs: self.inputs.set.clone(),
            memory: self.memory.clone(),
            candidates: self.kernels.candidates.to_checkpoint(&self.model),
            screening: self.kernels.screening.clone(),
            fastest: self.events.fastest,
            in_step_contacts: self.events.in_step_contacts,
            keeps_energy: self.keeps_energy,
            quadrature: self.quadrature.clone(),
            ended: self.events.ended.clone(),
            restarted: self.events.restarted.clone(),
            hinge_past_range: self.past_ranges.hinge.clone(),
            tooth_past_range: self.past_ranges.tooth.clone(),
            tooth_jumps: self.events.jumps.clone(),
            jumps_searched_at: self.events.jumps_searched_at,
            hinge_forces: (self.kernels.ideal.as_ref()).map(|ideal| ideal.step_end().clone()),
        }
    }

    /// Return dynamics with the same compiled model and instructions, restored from `checkpoint`.
    ///
    /// `None`: the checkpoint belongs to a different model.
    pub(super) fn with_checkpoint(&self, checkpoint: &Checkpoint) -> Option<Self> {
        let compiled = &self.inputs.compiled;
        let mut dynamics = Self::new(Arc::new(compiled.with_inputs(&checkpoint.inputs)?));
        dynamics.inputs = Inputs::new(compiled);
        dynamics.inputs.set.clone_from(&checkpoint.inputs);
        dynamics.use_instructions(self.instructions());
        dynamics.quadrature.refine(self.quadrature.fineness());
        let links = self.model.links;
        let mut surfaces = checkpoint.memory.tooth_surface.iter().enumerate();
        let exists = |(pair, surface): (usize, &Surface)| {
            let sprocket = self.model.sprockets.get(pair / links);
            sprocket.is_some_and(|s| surface.index() < s.profile.surfaces().len())
        };
        let restarted = checkpoint.restarted.iter().map(|one| one.contact);
        let mut contacts = checkpoint.ended.iter().copied().chain(restarted);
        if !checkpoint.memory.is_like(&dynamics.memory)
            || !surfaces.all(exists)
            || !contacts.all(|contact| dynamics.memory.contains(contact))
            || !checkpoint.quadrature.is_like(&dynamics.quadrature)
            || !checkpoint.tooth_jumps.is_like(&dynamics.model)
            || !(checkpoint.screening).is_like(&dynamics.kernels.screening, dynamics.model.links)
        {
            return None;
        }
        dynamics.quadrature.carry_on(&checkpoint.quadrature);
        dynamics.kernels.screening.copy_from(&checkpoint.screening);
        dynamics.events.fastest = checkpoint.fastest;
        dynamics.events.in_step_contacts = checkpoint.in_step_contacts;
        dynamics.memory = checkpoint.memory.clone();
        let candidates = &mut dynamics.kernels.candidates;
        candidates.restore(&dynamics.model, &dynamics.memory, &checkpoint.candidates)?;
        dynamics.keeps_energy = checkpoint.keeps_energy;
        // The existing vectors have capacity for all pairs; a clone would not. Steps extend it without allocation.
        dynamics.events.ended.extend_from_slice(&checkpoint.ended);
        let restarted = &mut dynamics.events.restarted;
        restarted.extend_from_slice(&checkpoint.restarted);
        dynamics
            .past_ranges
            .hinge
            .clone_from(&checkpoint.hinge_past_range);
        dynamics
            .past_ranges
            .tooth
            .clone_from(&checkpoint.tooth_past_range);
        dynamics.events.jumps.clone_from(&checkpoint.tooth_jumps);
        dynamics.events.jumps_searched_at = checkpoint.jumps_searched_at;
        if let Some(ideal) = &mut dynamics.kernels.ideal {
            let forces = checkpoint.hinge_forces.as_ref()?;
            if forces.iter().any(|axis| axis.len() != links) {
                return None;
            }
            ideal.begin_from(forces);
        }
        Some(dynamics)
    }
}

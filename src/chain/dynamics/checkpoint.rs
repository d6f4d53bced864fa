//! Checkpoint of the dynamics: all quantities of a run that an evaluation of the right-hand side does not recompute.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{ContactId, Dynamics, Inputs, Powers};
use crate::chain::contact::{CandidatesCheckpoint, ImpactMemory, ToothJumps};
use crate::chain::model::Input;
use crate::chain::rhs::Watch;
use crate::geometry::Surface;
use crate::system::EnergyQuadrature;

/// State of the dynamics that, with the state of the integrator, determines the continuation of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    inputs: Vec<Input>,
    memory: ImpactMemory,
    candidates: CandidatesCheckpoint,
    watch: Watch,
    fastest: f64,
    unseen_touches: u64,
    keeps_energy: bool,
    quadrature: EnergyQuadrature<Powers>,
    parted: Vec<ContactId>,
    hinge_past_range: Option<String>,
    tooth_past_range: Option<String>,
    tooth_jumps: ToothJumps,
    jumps_looked_for: u64,
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
            watch: self.kernels.watch.clone(),
            fastest: self.events.fastest,
            unseen_touches: self.events.unseen_touches,
            keeps_energy: self.keeps_energy,
            quadrature: self.quadrature.clone(),
            parted: self.events.parted.clone(),
            hinge_past_range: self.past_ranges.hinge.clone(),
            tooth_past_range: self.past_ranges.tooth.clone(),
            tooth_jumps: self.events.jumps.clone(),
            jumps_looked_for: self.events.jumps_looked_for,
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
        let there = |pair: &ContactId| match *pair {
            ContactId::Hinge(k) => k < dynamics.memory.hinge_impact_velocity().len(),
            ContactId::Roller(k) => k < dynamics.memory.roller_impact_velocity().len(),
            ContactId::Tooth(pair) => pair < dynamics.memory.tooth_impact_velocity.len(),
        };
        let links = self.model.links;
        let mut surfaces = checkpoint.memory.tooth_surface.iter().enumerate();
        let exists = |(pair, surface): (usize, &Surface)| {
            let sprocket = self.model.sprockets.get(pair / links);
            sprocket.is_some_and(|s| surface.index() < s.profile.surfaces().len())
        };
        if !checkpoint.memory.is_like(&dynamics.memory)
            || !surfaces.all(exists)
            || !checkpoint.parted.iter().all(there)
            || !checkpoint.quadrature.is_like(&dynamics.quadrature)
            || !checkpoint.tooth_jumps.is_like(&dynamics.model)
            || !(checkpoint.watch).is_like(&dynamics.kernels.watch, dynamics.model.links)
        {
            return None;
        }
        dynamics.quadrature.carry_on(&checkpoint.quadrature);
        dynamics.kernels.watch.copy_from(&checkpoint.watch);
        dynamics.events.fastest = checkpoint.fastest;
        dynamics.events.unseen_touches = checkpoint.unseen_touches;
        dynamics.memory = checkpoint.memory.clone();
        let candidates = &mut dynamics.kernels.candidates;
        candidates.restore(&dynamics.model, &dynamics.memory, &checkpoint.candidates)?;
        dynamics.keeps_energy = checkpoint.keeps_energy;
        // The existing vector has capacity for all pairs; a clone would not. Steps extend it without allocation.
        dynamics.events.parted.extend_from_slice(&checkpoint.parted);
        dynamics
            .past_ranges
            .hinge
            .clone_from(&checkpoint.hinge_past_range);
        dynamics
            .past_ranges
            .tooth
            .clone_from(&checkpoint.tooth_past_range);
        dynamics.events.jumps.clone_from(&checkpoint.tooth_jumps);
        dynamics.events.jumps_looked_for = checkpoint.jumps_looked_for;
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

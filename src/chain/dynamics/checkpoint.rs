//! What the dynamics carry from step to step: all that an evaluation does not find anew.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::energy_quadrature::EnergyMeter;
use super::{Dynamics, Pair};
use crate::chain::contact::{CarriedCandidates, ImpactMemory, ToothJumps};
use crate::chain::model::Model;
use crate::chain::rhs::Watch;
use crate::geometry::Surface;

/// All that decides, with the integrator's state, how the dynamics go on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Carried {
    memory: ImpactMemory,
    candidates: CarriedCandidates,
    watch: Watch,
    unseen_touches: u64,
    keeps_energy: bool,
    meter: EnergyMeter,
    parted: Vec<Pair>,
    hinge_past_range: Option<String>,
    tooth_past_range: Option<String>,
    tooth_jumps: ToothJumps,
    jumps_looked_for: u64,
}

impl Dynamics {
    /// What these dynamics carry.
    pub(crate) fn carried(&self) -> Carried {
        Carried {
            memory: self.memory.clone(),
            candidates: self.kernels.candidates.carried(&self.model),
            watch: self.kernels.watch.clone(),
            unseen_touches: self.unseen_touches,
            keeps_energy: self.keeps_energy,
            meter: self.meter.clone(),
            parted: self.parted.clone(),
            hinge_past_range: self.hinge_past_range.clone(),
            tooth_past_range: self.tooth_past_range.clone(),
            tooth_jumps: self.tooth_jumps.clone(),
            jumps_looked_for: self.jumps_looked_for,
        }
    }

    /// Dynamics of `model`, which differs in its speeds and torques at most, with the same instructions, that carry `carried`; `None`
    /// when it is of no such model.
    pub(crate) fn carrying(&self, model: Arc<Model>, carried: &Carried) -> Option<Self> {
        let mut dynamics = Self::new(model);
        dynamics.use_instructions(self.instructions());
        dynamics.refine_meter(self.meter.fineness());
        let there = |pair: &Pair| match *pair {
            Pair::Hinge(k) => k < dynamics.memory.hinge_speed().len(),
            Pair::Roller(k) => k < dynamics.memory.roller_speed().len(),
            Pair::Tooth(pair) => pair < dynamics.memory.tooth_speed.len(),
        };
        let links = self.model.links;
        let mut surfaces = carried.memory.tooth_surface.iter().enumerate();
        let exists = |(pair, surface): (usize, &Surface)| {
            let sprocket = self.model.sprockets.get(pair / links);
            sprocket.is_some_and(|s| surface.index() < s.profile.surfaces().len())
        };
        if !carried.memory.is_like(&dynamics.memory)
            || !surfaces.all(exists)
            || !carried.parted.iter().all(there)
            || !carried.meter.is_like(&dynamics.meter)
            || !carried.tooth_jumps.is_like(&dynamics.model)
            || !(carried.watch).is_like(&dynamics.kernels.watch, dynamics.model.links)
        {
            return None;
        }
        dynamics.meter.carry_on(&carried.meter);
        dynamics.kernels.watch.carry_on(&carried.watch);
        dynamics.unseen_touches = carried.unseen_touches;
        dynamics.memory = carried.memory.clone();
        let candidates = &mut dynamics.kernels.candidates;
        candidates.carry_on(&dynamics.model, &dynamics.memory, &carried.candidates)?;
        dynamics.keeps_energy = carried.keeps_energy;
        // Steps put parted pairs where there is room already.
        dynamics.parted.extend_from_slice(&carried.parted);
        dynamics
            .hinge_past_range
            .clone_from(&carried.hinge_past_range);
        dynamics
            .tooth_past_range
            .clone_from(&carried.tooth_past_range);
        dynamics.tooth_jumps.clone_from(&carried.tooth_jumps);
        dynamics.jumps_looked_for = carried.jumps_looked_for;
        Some(dynamics)
    }
}

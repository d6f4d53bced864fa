//! Contact onsets, contact ends and tooth jumps of a step, found between steps.

use serde::{Deserialize, Serialize};

use super::Dynamics;
use crate::chain::contact::{
    HingePath, ImpactMemory, RollerPath, ToothJump, ToothJumps, ToothPath,
};
use crate::chain::model::Model;
use crate::geometry::Surface;
use crate::integrator::event_location::onset_in_step;
use crate::integrator::{Adams, OdeSystem, Step};

/// Contact pair: hinge, bushing and roller, or bushing and sprocket (sprocket · links + bushing).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum ContactId {
    Hinge(usize),
    Roller(usize),
    Tooth(usize),
}

/// Events of the last step.
#[derive(Debug, Clone)]
pub(super) struct ContactEvents {
    /// Pairs that ended their contact in the last step; their memory remains until the next step, for reports inside the last one.
    pub(super) parted: Vec<ContactId>,
    /// Whether event screening found a pair that may have touched or separated inside the last step.
    pub(super) event_possible: bool,
    /// Upper bound on the speeds of bushings relative to teeth at the end of the last step \[m/s\].
    pub(super) fastest: f64,
    /// Number of accepted contacts inside steps whose penetration was within the accuracy.
    pub(super) unseen_touches: u64,
    /// Seatings of the chain, and jumps over teeth.
    pub(super) jumps: ToothJumps,
    /// Number of candidate lists built at the last search for tooth jumps.
    pub(super) jumps_looked_for: u64,
    /// Scratch: tooth contacts with an onset in the last step, as (sprocket, bushing).
    pub(super) begun: Vec<(usize, usize)>,
}

impl ContactEvents {
    /// Allocate the events of `model`.
    pub(super) fn new(model: &Model) -> Self {
        let tooth_pairs = model.links * model.sprockets.len();
        Self {
            parted: Vec::with_capacity(model.links + tooth_pairs + model.roller_count()),
            event_possible: false,
            fastest: 0.0,
            unseen_touches: 0,
            jumps: ToothJumps::new(model),
            jumps_looked_for: 0,
            begun: Vec::with_capacity(tooth_pairs),
        }
    }
}

impl Dynamics {
    /// Return the hinges, and the pairs of bushing and sprocket, whose contact ended in the last step.
    ///
    /// Their memory is cleared at the beginning of the next step.
    #[must_use]
    pub fn parted(&self) -> (Vec<usize>, Vec<usize>) {
        let mut parted = (Vec::new(), Vec::new());
        for pair in &self.events.parted {
            match *pair {
                ContactId::Hinge(k) => parted.0.push(k),
                ContactId::Tooth(pair) => parted.1.push(pair),
                ContactId::Roller(_) => {}
            }
        }
        parted
    }

    /// Return the bushings whose contact with their roller ended in the last step.
    #[must_use]
    pub fn parted_rollers(&self) -> Vec<usize> {
        let roller = |pair: &ContactId| match *pair {
            ContactId::Roller(k) => Some(k),
            _ => None,
        };
        self.events.parted.iter().filter_map(roller).collect()
    }

    /// Start the memory of every pair in contact at (`t`, `y`), with its present penetration rate and its nearest surface.
    pub fn remember_present_contacts(&mut self, t: f64, y: &[f64]) {
        self.begin_present_contacts(t, y, &[]);
    }

    /// Start the memory of every pair in contact at (`t`, `y`), with its present penetration rate, for an initial configuration.
    ///
    /// `surfaces`: bushing, sprocket and surface, from 0, of tooth contacts that do not take the nearest one.
    pub(crate) fn begin_present_contacts(&mut self, t: f64, y: &[f64], surfaces: &[[usize; 3]]) {
        self.memory.clear();
        self.follow_with_pawls(y);
        self.evaluate(t, y);
        for k in 0..self.model.links {
            if self.evaluated.hinges.penetration[k] > 0.0 {
                self.memory.begin_hinge(k, self.evaluated.hinges.rate[k]);
            }
        }
        for k in 0..self.model.roller_count() {
            if self.evaluated.rollers.penetration[k] > 0.0 {
                self.memory.begin_roller(k, self.evaluated.rollers.rate[k]);
            }
        }
        for &pair in &self.evaluated.teeth.near {
            let pair = pair as usize;
            if self.evaluated.teeth.penetration[pair] > 0.0 {
                self.memory.begin_tooth(
                    pair,
                    self.evaluated.teeth.rate[pair],
                    self.evaluated.teeth.surface(pair),
                );
            }
        }
        for &[bushing, sprocket, surface] in surfaces {
            // Profiles have fewer than 256 surfaces.
            let surface = u8::try_from(surface).map_or(Surface::SEATING, Surface);
            self.memory.tooth_surface[sprocket * self.model.links + bushing] = surface;
        }
        self.kernels.candidates.invalidate();
        self.begin_watch(t, y);
        self.look_for_jumps(t);
    }

    /// Evaluate at (`t`, `y`), the start of the first step: event screening needs the gaps there.
    pub(super) fn begin_watch(&mut self, t: f64, y: &[f64]) {
        let mut derivative = std::mem::take(&mut self.slope);
        self.derivative(t, y, &mut derivative);
        self.slope = derivative;
        self.events.fastest = self.kernels.watch(&self.model, 0.0).speed;
        self.kernels.advance_watch();
    }

    /// Replace the memory of all contacts, for an integrator outside this crate. The candidate list has a copy and is built again.
    pub fn replace_memory(&mut self, memory: ImpactMemory) {
        self.memory = memory;
        self.kernels.candidates.invalidate();
    }

    /// Return bushing, sprocket and surface, from 0, of all tooth contacts with a memory.
    pub(crate) fn stored_surfaces(&self) -> Vec<[usize; 3]> {
        let (links, memory) = (self.model.links, &self.memory);
        let pairs = memory
            .tooth_impact_velocity
            .iter()
            .zip(&memory.tooth_surface);
        let live = pairs.enumerate().filter(|(_, (speed, _))| **speed > 0.0);
        live.map(|(pair, (_, surface))| [pair % links, pair / links, surface.index()])
            .collect()
    }

    /// Advance the pawls of all ratchets behind the teeth that passed in the last step, whose end is `y`.
    ///
    /// Call before the next step: reports inside the last step use the previous positions of the pawls.
    pub(crate) fn follow_with_pawls(&mut self, y: &[f64]) {
        let sprockets = self.model.sprockets.iter().zip(&mut self.memory.pawls);
        for (sprocket, pawl) in sprockets {
            if let Some((ratchet, s)) = sprocket.ratchet_at(y) {
                *pawl = ratchet.follow(*pawl, s);
            }
        }
    }

    /// Clear the memory of contacts that ended in the last step; call before the next step.
    pub fn forget_ended_contacts(&mut self) {
        for pair in self.events.parted.drain(..) {
            match pair {
                ContactId::Hinge(k) => self.memory.end_hinge(k),
                ContactId::Roller(k) => self.memory.end_roller(k),
                ContactId::Tooth(pair) => {
                    self.memory.end_tooth(pair);
                    let (s, k) = (pair / self.model.links, pair % self.model.links);
                    self.kernels
                        .candidates
                        .update_memory(&self.model, &self.memory, s, k);
                }
            }
        }
    }

    /// Locate the contact onsets of the last step and record their initial impact velocities.
    ///
    /// Call after the step, before another evaluation of the right-hand side.
    pub fn record_contact_events(&mut self, adams: &Adams, step: &Step) {
        let [hinges, rollers, teeth] = self.kernels.changes();
        if hinges {
            self.find_hinge_onsets(adams, step);
        }
        if rollers {
            self.find_roller_onsets(adams, step);
        }
        if teeth {
            self.find_tooth_onsets(adams, step);
        }
        if std::mem::take(&mut self.events.event_possible) {
            self.look_inside(adams, step);
        }
        self.kernels.advance_watch();
        self.watch_ranges(adams);
        // Steps are far shorter than a gap. After a displacement of more than half a pitch, the number of passed teeth is ambiguous.
        let farthest = self.events.fastest * (step.end - step.start);
        if farthest.is_nan() || farthest > self.model.half_pitch {
            self.events.jumps.lose_seatings();
        } else if self.events.jumps_looked_for != self.candidate_refreshes() {
            self.look_for_jumps(step.end);
        }
    }

    /// Search for tooth jumps at the last evaluation, at time `t` \[s\].
    ///
    /// A bushing that has changed gaps has moved by more than the margin of the candidate list relative to its sprocket. The search is
    /// therefore necessary only after the list was built again.
    fn look_for_jumps(&mut self, t: f64) {
        self.events.jumps_looked_for = self.candidate_refreshes();
        let jumps = &mut self.events.jumps;
        self.kernels.look_for_jumps(&self.model, t, jumps);
    }

    /// Return the tooth jumps since the start of the run, in the order of time.
    #[must_use]
    pub fn tooth_jumps(&self) -> &[ToothJump] {
        self.events.jumps.jumps()
    }

    /// Record contact onsets and ends of hinges in the last step.
    fn find_hinge_onsets(&mut self, adams: &Adams, step: &Step) {
        let model = &self.model;
        // Penetration without memory: contact onset in this step. Memory without penetration: contact end.
        for (k, &depth) in self.kernels.hinge_depths(model).iter().enumerate() {
            let touching = depth > 0.0;
            if touching == (self.memory.hinge_impact_velocity()[k] > 0.0) {
                continue;
            }
            if touching {
                let path = HingePath::new(model, adams, k);
                let (_, rate) = onset_in_step(|t| path.at(t), step.start, step.end);
                self.memory.begin_hinge(k, rate);
            } else {
                self.events.parted.push(ContactId::Hinge(k));
            }
        }
    }

    /// Record contact onsets and ends of bushings in their rollers in the last step.
    fn find_roller_onsets(&mut self, adams: &Adams, step: &Step) {
        let model = &self.model;
        for (k, &depth) in self.kernels.roller_depths(model).iter().enumerate() {
            let touching = depth > 0.0;
            if touching == (self.memory.roller_impact_velocity()[k] > 0.0) {
                continue;
            }
            if !touching {
                self.events.parted.push(ContactId::Roller(k));
            } else if let Some(path) = RollerPath::new(model, adams, k) {
                let (_, rate) = onset_in_step(|t| path.at(t), step.start, step.end);
                self.memory.begin_roller(k, rate);
            }
        }
    }

    /// Record contact onsets, with their surfaces, and contact ends of teeth in the last step.
    fn find_tooth_onsets(&mut self, adams: &Adams, step: &Step) {
        let model = &self.model;
        let mut begun = std::mem::take(&mut self.events.begun);
        let memory = &mut self.memory;
        let contacts = self.kernels.tooth_contacts(model);
        contacts.for_each(|(s, k, depth, _)| {
            let pair = s * model.links + k;
            let touching = depth > 0.0;
            if touching == (memory.tooth_impact_velocity[pair] > 0.0) {
                return;
            }
            if touching {
                let path = ToothPath::new(model, adams, k, s);
                let contact = |t| path.at(t).contact;
                let (t, rate) = onset_in_step(contact, step.start, step.end);
                memory.begin_tooth(pair, rate, path.at(t).surface);
                begun.push((s, k));
            } else {
                self.events.parted.push(ContactId::Tooth(pair));
            }
        });
        for (s, k) in begun.drain(..) {
            self.kernels
                .candidates
                .update_memory(model, &self.memory, s, k);
        }
        self.events.begun = begun;
    }
}

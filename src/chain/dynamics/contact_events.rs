//! Contact onsets, contact ends and tooth jumps of a step, found between steps.

use serde::{Deserialize, Serialize};

use super::Dynamics;
use crate::chain::contact::{ContactId, ContactPath, ImpactMemory, ToothJump, ToothJumps};
use crate::chain::model::Model;
use crate::geometry::Surface;
use crate::integrator::event_location::{onset_between, onset_in_step};
use crate::integrator::{Adams, OdeSystem, Step};

/// Contact onset located inside a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Onset {
    pub(super) contact: ContactId,
    /// Time \[s\].
    pub(super) time: f64,
    /// Penetration rate \[m/s\].
    pub(super) rate: f64,
    /// Surface of the tooth.
    pub(super) surface: Option<Surface>,
}

impl Onset {
    /// Locate the last onset of `contact` in the last step of `adams`, between the times of `step`, as [`onset_in_step`] does.
    ///
    /// `ends`: penetration \[m\] and rate \[m/s\] at both ends, where they are known. `None`: the contact does not exist.
    pub(super) fn locate(
        (model, adams, step): (&Model, &Adams, &Step),
        contact: ContactId,
        ends: Option<[[f64; 2]; 2]>,
    ) -> Option<Self> {
        let path = ContactPath::new(model, adams, contact)?;
        let [start, end] = [step.start, step.end];
        let (time, rate) = match ends {
            Some(ends) => onset_between(|t| path.at(t), [start, end], ends),
            None => onset_in_step(|t| path.at(t), start, end),
        };
        let surface = path.surface(time);
        Some(Self {
            contact,
            time,
            rate,
            surface,
        })
    }
}

/// Contact that ended and began again inside the last step: its memory before that.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Restart {
    pub(super) contact: ContactId,
    /// Time of the onset \[s\].
    pub(super) time: f64,
    /// Initial impact velocity before \[m/s\].
    pub(super) impact_velocity: f64,
    /// Surface of the tooth before.
    pub(super) surface: Option<Surface>,
}

/// Events of the last step.
#[derive(Debug, Clone)]
pub(super) struct ContactEvents {
    /// Pairs that ended their contact in the last step; their memory remains until the next step, for reports inside the last one.
    pub(super) ended: Vec<ContactId>,
    /// Pairs that ended their contact in the last step and began it again.
    pub(super) restarted: Vec<Restart>,
    /// Whether event screening found a pair that may have touched or separated inside the last step.
    pub(super) event_possible: bool,
    /// Upper bound on the speeds of bushings relative to teeth at the end of the last step \[m/s\].
    pub(super) fastest: f64,
    /// Number of accepted contacts inside steps whose penetration was within the accuracy.
    pub(super) in_step_contacts: u64,
    /// Seatings of the chain, and jumps over teeth.
    pub(super) jumps: ToothJumps,
    /// Number of candidate lists built at the last search for tooth jumps.
    pub(super) jumps_searched_at: u64,
    /// Scratch: contact onsets in the last step.
    pub(super) begun: Vec<Onset>,
}

impl ContactEvents {
    /// Allocate the events of `model`.
    pub(super) fn new(model: &Model) -> Self {
        let contacts = model.links * (1 + model.sprockets.len()) + model.roller_count();
        Self {
            ended: Vec::with_capacity(contacts),
            restarted: Vec::with_capacity(contacts),
            event_possible: false,
            fastest: 0.0,
            in_step_contacts: 0,
            jumps: ToothJumps::new(model),
            jumps_searched_at: 0,
            begun: Vec::with_capacity(contacts),
        }
    }
}

impl Dynamics {
    /// Return the pairs whose contact ended in the last step. Their memory is cleared at the beginning of the next step.
    #[must_use]
    pub fn ended_contacts(&self) -> &[ContactId] {
        &self.events.ended
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
        for contact in self.memory.contacts() {
            let (penetration, rate) = self.evaluated.penetration_and_rate(contact);
            if penetration > 0.0 {
                self.begin_evaluated_contact(contact, rate);
            }
        }
        for &[bushing, sprocket, surface] in surfaces {
            // Profiles have fewer than 256 surfaces.
            let surface = u8::try_from(surface).map_or(Surface::SEATING, Surface);
            self.memory.tooth_surface[sprocket * self.model.links + bushing] = surface;
        }
        self.kernels.candidates.invalidate();
        self.begin_screening(t, y);
        self.find_tooth_jumps(t);
    }

    /// Start the memory of a contact with the penetration rate `rate` \[m/s\], on the nearest surface of the last evaluation for a report.
    pub(super) fn begin_evaluated_contact(&mut self, contact: ContactId, rate: f64) {
        match contact {
            ContactId::Tooth(pair) => {
                let surface = self.evaluated.teeth.surface(pair);
                self.memory.begin_tooth(pair, rate, surface);
            }
            _ => self.memory.begin(contact, rate),
        }
    }

    /// Evaluate at (`t`, `y`), the start of the first step: event screening needs the gaps there.
    pub(super) fn begin_screening(&mut self, t: f64, y: &[f64]) {
        let mut derivative = std::mem::take(&mut self.slope);
        self.derivative(t, y, &mut derivative);
        self.slope = derivative;
        self.events.fastest = self.kernels.screen(&self.model, 0.0).speed;
        self.kernels.advance_screening();
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
        self.events.restarted.clear();
        for contact in self.events.ended.drain(..) {
            self.memory.end(contact);
            let candidates = &mut self.kernels.candidates;
            candidates.update_memory(&self.model, &self.memory, contact);
        }
    }

    /// Locate the contact onsets of the last step and record their initial impact velocities.
    ///
    /// Call after the step, before another evaluation of the right-hand side.
    pub fn record_contact_events(&mut self, adams: &Adams, step: &Step) {
        self.find_events_between_ends(adams, step);
        if std::mem::take(&mut self.events.event_possible) {
            self.record_in_step_events(adams, step);
        }
        self.kernels.advance_screening();
        self.note_ranges(adams);
        // Steps are far shorter than a gap. After a displacement of more than half a pitch, the number of passed teeth is ambiguous.
        let farthest = self.events.fastest * (step.end - step.start);
        if farthest.is_nan() || farthest > self.model.half_pitch {
            self.events.jumps.lose_seatings();
        } else if self.events.jumps_searched_at != self.candidate_refreshes() {
            self.find_tooth_jumps(step.end);
        }
    }

    /// Search for tooth jumps at the last evaluation, at time `t` \[s\].
    ///
    /// A bushing that has changed gaps has moved by more than the margin of the candidate list relative to its sprocket. The search is
    /// therefore necessary only after the list was built again.
    fn find_tooth_jumps(&mut self, t: f64) {
        self.events.jumps_searched_at = self.candidate_refreshes();
        let jumps = &mut self.events.jumps;
        self.kernels.find_tooth_jumps(&self.model, t, jumps);
    }

    /// Return the tooth jumps since the start of the run, in the order of time.
    #[must_use]
    pub fn tooth_jumps(&self) -> &[ToothJump] {
        self.events.jumps.jumps()
    }

    /// Record contact onsets and ends of the last step that leave a difference between its two ends.
    fn find_events_between_ends(&mut self, adams: &Adams, step: &Step) {
        let (model, memory, kernels) = (&self.model, &self.memory, &self.kernels);
        let ContactEvents { begun, ended, .. } = &mut self.events;
        // Penetration without memory: contact onset in this step. Memory without penetration: contact end.
        let mut compare = |contact, depth: f64| {
            let touching = depth > 0.0;
            if touching == memory.has(contact) {
                return;
            }
            if touching {
                begun.extend(Onset::locate((model, adams, step), contact, None));
            } else {
                ended.push(contact);
            }
        };
        let [hinges, rollers, teeth] = kernels.changes();
        if hinges {
            for (k, &depth) in kernels.hinge_depths(model).iter().enumerate() {
                compare(ContactId::Hinge(k), depth);
            }
        }
        if rollers {
            for (k, &depth) in kernels.roller_depths(model).iter().enumerate() {
                compare(ContactId::Roller(k), depth);
            }
        }
        if teeth {
            let contacts = kernels.tooth_contacts(model);
            contacts.for_each(|(s, k, depth, _)| {
                compare(ContactId::Tooth(s * model.links + k), depth);
            });
        }
        self.begin_located_contacts();
    }

    /// Record the located onsets; keep the memory of contacts that have one.
    pub(super) fn begin_located_contacts(&mut self) {
        let ContactEvents {
            begun, restarted, ..
        } = &mut self.events;
        let (memory, candidates) = (&mut self.memory, &mut self.kernels.candidates);
        for onset in begun.drain(..) {
            let contact = onset.contact;
            let impact_velocity = memory.impact_velocity(contact);
            if impact_velocity > 0.0 {
                restarted.push(Restart {
                    contact,
                    time: onset.time,
                    impact_velocity,
                    surface: memory.surface(contact),
                });
            }
            memory.begin(contact, onset.rate);
            memory.set_surface(contact, onset.surface);
            candidates.update_memory(&self.model, memory, contact);
        }
    }
}

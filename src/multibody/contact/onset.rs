//! Contact onsets and contact ends within a step, and the impact velocity memory of each side.

use super::impact_memory::{Memory, Touch};
use super::outline::Place;
use crate::integrator::event_location::first_crossing;
use crate::integrator::{Adams, Step};
use crate::multibody::description::body::Frame;
use crate::multibody::dynamics::MechanismDynamics;

/// Penetration at the onset over the penetration at the end of the step, below which the contact started at zero penetration.
/// Above it, the contact moved over from another side.
const SHALLOW: f64 = 1e-3;

/// A contact onset that is not yet in a row of the report.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Onset {
    /// Time of the onset \[s\].
    pub(crate) time: f64,
    pub(crate) contact: usize,
    /// Initial impact velocity \[m/s\].
    pub(crate) velocity: f64,
}

impl MechanismDynamics {
    /// Set the memory of all contacts present at the last evaluation, with the present penetration rate as initial impact velocity.
    pub(crate) fn remember_present_contacts(&mut self) {
        for k in 0..self.touches.len() {
            let touch = self.touches[k];
            if touch.contact.penetration > 0.0 {
                self.begin_contact(k, touch.piece, touch.contact.penetration_rate);
                self.note_place(k, touch.place);
            } else {
                self.memory[k] = self.apart(k);
            }
        }
    }

    /// Write the memory of contacts with an onset or an end within the step. The onset is a root of the dense output.
    pub(crate) fn find_onsets(&mut self, adams: &Adams, step: &Step) {
        for contact in 0..self.near.len() {
            let sides = self.model.sides_of_contact[contact].clone();
            if self.near[contact] {
                let open = self.model.contacts[contact].is_open();
                sides.for_each(|k| self.find_onset_of_side(k, open, adams, step));
            } else {
                // Circles out of reach have no memory: the reach of an open outline, which has a back, is infinite.
                self.memory[sides].fill(Memory::default());
            }
        }
    }

    fn find_onset_of_side(&mut self, k: usize, open: bool, adams: &Adams, step: &Step) {
        let touch = &self.touches[k];
        let place = touch.place;
        if touch.contact.penetration > 0.0 {
            // Penetration without memory: the contact began within the step.
            if self.memory[k].speed <= 0.0 {
                self.find_onset(k, touch.contact.penetration, adams, step);
            }
            self.note_place(k, place);
            return;
        }
        if open {
            self.memory[k] = self.apart(k);
        } else {
            self.memory[k] = Memory::default();
        }
    }

    fn find_onset(&mut self, k: usize, depth: f64, adams: &Adams, step: &Step) {
        let (t, rate) = first_crossing(|t| self.side_at(adams, k, t).contact, step.start, step.end);
        let begun = self.side_at(adams, k, t);
        if begun.contact.penetration > SHALLOW * depth
            && let Some(speed) = self.speed_beside(k)
        {
            // The contact moved over from a neighbouring side: its penetration is not zero at the crossing. It is not an onset, and the
            // impact velocity memory of that side remains valid.
            let memory = &mut self.memory[k];
            *memory = Memory {
                speed,
                piece: begun.piece,
                in_front: false,
            };
            return;
        }
        self.begin_contact(k, begun.piece, rate);
        self.onsets += 1;
        let (contact, _) = self.model.sides[k];
        if let Some(onsets) = &mut self.unreported_onsets {
            onsets.push(Onset {
                time: t,
                contact,
                velocity: rate,
            });
        }
    }

    pub(crate) fn begin_contact(&mut self, k: usize, piece: usize, rate: f64) {
        let (contact, _) = self.model.sides[k];
        self.memory[k] = self.model.contacts[contact].remember(piece, rate);
    }

    /// Record whether the circle came from the front of an open outline. Only then is it in contact at any depth. A circle that
    /// moved round the end is not in contact with the surface from behind.
    pub(crate) fn note_place(&mut self, k: usize, place: Place) {
        let memory = &mut self.memory[k];
        match place {
            Place::Front | Place::Deep => memory.in_front = true,
            Place::EndFront => memory.in_front = false,
            Place::EndBack | Place::DeepAtEnd => {}
        }
    }

    /// Return the largest initial impact velocity in the memory of the other sides of the same contact \[m/s\].
    fn speed_beside(&self, k: usize) -> Option<f64> {
        let (contact, _) = self.model.sides[k];
        let sides = self.model.sides_of_contact[contact].clone();
        let speeds = sides
            .filter(|&other| other != k)
            .map(|other| self.speed_at_step_start(other));
        speeds.reduce(f64::max).filter(|&speed| speed > 0.0)
    }

    /// Return the contact state of side `k` at time `t` \[s\] inside the last step, from the dense output.
    fn side_at(&self, adams: &Adams, k: usize, t: f64) -> Touch {
        let (contact, side) = self.model.sides[k];
        let contact = &self.model.contacts[contact];
        let dense = adams.dense(t);
        let model = &self.model;
        let n = model.coordinates();
        // The shift by projections is constant for velocities and grows linearly for positions, so that dq/dt = v.
        let (shift, since) = (&self.shift, t - self.shift_time);
        let value = |i: usize| {
            let grown = if i < n { since * shift[n + i] } else { 0.0 };
            dense.value(model.component(i)) + shift[i] + grown
        };
        let frame = |body: usize| match model.first[body] {
            None => self.frames[body],
            Some(i) => Frame::new(
                [value(i), value(i + 1), value(i + 2)],
                [value(n + i), value(n + i + 1), value(n + i + 2)],
            ),
        };
        let (fa, fb) = (frame(contact.a.body), frame(contact.b.body));
        contact.find(&fa, &fb, side, Memory::default())
    }
}

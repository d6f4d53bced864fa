//! Contacts that began or ended within a step: what each side remembers from then on.

use super::impact_memory::{Memory, Touch};
use super::outline::Place;
use crate::integrator::event_location::first_crossing;
use crate::integrator::{Adams, Step};
use crate::multibody::description::body::Frame;
use crate::multibody::dynamics::MechanismDynamics;

/// Part of the depth at the end of a step below which a contact began from nothing within it.
const SHALLOW: f64 = 1e-3;

/// An onset that no row has reported yet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Onset {
    /// When \[s\].
    pub(crate) time: f64,
    pub(crate) contact: usize,
    /// Initial impact velocity \[m/s\].
    pub(crate) velocity: f64,
}

impl MechanismDynamics {
    /// Contacts that are there at the last evaluation have begun with their present rate.
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

    /// Writes the memory of contacts that began or ended within the step; the root of the dense output says when.
    pub(crate) fn find_onsets(&mut self, adams: &Adams, step: &Step) {
        for contact in 0..self.near.len() {
            let sides = self.model.sides_of_contact[contact].clone();
            if self.near[contact] {
                let open = self.model.contacts[contact].is_open();
                sides.for_each(|k| self.find_onset_of_side(k, open, adams, step));
            } else {
                // Out of reach, where no outline has a back.
                self.memory[sides].fill(Memory::default());
            }
        }
    }

    fn find_onset_of_side(&mut self, k: usize, open: bool, adams: &Adams, step: &Step) {
        let touch = &self.touches[k];
        let place = touch.place;
        if touch.contact.penetration > 0.0 {
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
            // Rolled over from the side before, whose place on this one was in contact when it came to be.
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

    fn begin_contact(&mut self, k: usize, piece: usize, rate: f64) {
        let (contact, _) = self.model.sides[k];
        self.memory[k] = self.model.contacts[contact].remember(piece, rate);
    }

    /// What was in front of an open outline may sink in; what goes round its end does not come back through it.
    fn note_place(&mut self, k: usize, place: Place) {
        let memory = &mut self.memory[k];
        match place {
            Place::Front | Place::Deep => memory.in_front = true,
            Place::EndFront => memory.in_front = false,
            Place::EndBack | Place::DeepAtEnd => {}
        }
    }

    /// The approach speed that another side of the same contact remembers.
    fn speed_beside(&self, k: usize) -> Option<f64> {
        let (contact, _) = self.model.sides[k];
        let sides = self.model.sides_of_contact[contact].clone();
        let speeds = sides
            .filter(|&other| other != k)
            .map(|other| self.speed_at_step_start(other));
        speeds.reduce(f64::max).filter(|&speed| speed > 0.0)
    }

    /// One side of a contact at `t` inside the last step.
    fn side_at(&self, adams: &Adams, k: usize, t: f64) -> Touch {
        let (contact, side) = self.model.sides[k];
        let contact = &self.model.contacts[contact];
        let dense = adams.dense(t);
        let model = &self.model;
        let n = model.coordinates();
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

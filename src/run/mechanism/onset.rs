//! Contacts that began or ended within a step: what each side remembers from then on.

use super::simulation::MechanismSimulation;
use crate::integrator::event_location::first_crossing;
use crate::multibody::contact::impact_memory::{Memory, Touch};
use crate::multibody::contact::outline::Place;
use crate::multibody::description::body::Frame;

/// Part of the depth at the end of a step below which a contact began from nothing within it.
const SHALLOW: f64 = 1e-3;

impl MechanismSimulation {
    /// Contacts that are there from the start have begun with their present rate.
    pub(crate) fn remember_present_contacts(&mut self) {
        self.look_at(0.0);
        for k in 0..self.dynamics.touches.len() {
            let touch = self.dynamics.touches[k];
            if touch.contact.penetration > 0.0 {
                self.begin_contact(k, touch.piece, touch.contact.penetration_rate);
                self.note_place(k, touch.place);
            } else {
                self.dynamics.memory[k] = self.dynamics.apart(k);
            }
        }
    }

    /// Writes the memory of contacts that began or ended within the step; the root of the dense output says when.
    pub(crate) fn find_onsets(&mut self, start: f64, end: f64) {
        for contact in 0..self.dynamics.near.len() {
            let sides = self.dynamics.model.sides_of_contact[contact].clone();
            if self.dynamics.near[contact] {
                let open = self.dynamics.model.contacts[contact].is_open();
                sides.for_each(|k| self.find_onset_of_side(k, open, start, end));
            } else {
                // Out of reach, where no outline has a back.
                self.dynamics.memory[sides].fill(Memory::default());
            }
        }
    }

    fn find_onset_of_side(&mut self, k: usize, open: bool, start: f64, end: f64) {
        let touch = &self.dynamics.touches[k];
        let place = touch.place;
        if touch.contact.penetration > 0.0 {
            if self.dynamics.memory[k].speed <= 0.0 {
                self.find_onset(k, touch.contact.penetration, start, end);
            }
            self.note_place(k, place);
        } else if open {
            self.dynamics.memory[k] = self.dynamics.apart(k);
        } else {
            self.dynamics.memory[k] = Memory::default();
        }
    }

    fn find_onset(&mut self, k: usize, depth: f64, start: f64, end: f64) {
        let (t, rate) = first_crossing(|t| self.side_at(k, t).contact, start, end);
        let begun = self.side_at(k, t);
        if begun.contact.penetration > SHALLOW * depth
            && let Some(speed) = self.speed_beside(k)
        {
            // Rolled over from the side before, whose place on this one was in contact when it came to be.
            let memory = &mut self.dynamics.memory[k];
            *memory = Memory {
                speed,
                piece: begun.piece,
                in_front: false,
            };
            return;
        }
        self.begin_contact(k, begun.piece, rate);
        self.onsets += 1;
        if self.reports.is_some() {
            let (contact, _) = self.dynamics.model.sides[k];
            self.recording.begin_contact(t, contact, rate);
        }
    }

    fn begin_contact(&mut self, k: usize, piece: usize, rate: f64) {
        let (contact, _) = self.dynamics.model.sides[k];
        self.dynamics.memory[k] = self.dynamics.model.contacts[contact].remember(piece, rate);
    }

    /// What was in front of an open outline may sink in; what goes round its end does not come back through it.
    fn note_place(&mut self, k: usize, place: Place) {
        let memory = &mut self.dynamics.memory[k];
        match place {
            Place::Front | Place::Deep => memory.in_front = true,
            Place::EndFront => memory.in_front = false,
            Place::EndBack | Place::DeepAtEnd => {}
        }
    }

    /// The approach speed that another side of the same contact remembers.
    fn speed_beside(&self, k: usize) -> Option<f64> {
        let (contact, _) = self.dynamics.model.sides[k];
        let sides = self.dynamics.model.sides_of_contact[contact].clone();
        let speeds = sides
            .filter(|&other| other != k)
            .map(|other| self.accepted_speed(other));
        speeds.reduce(f64::max).filter(|&speed| speed > 0.0)
    }

    /// One side of a contact at `t` inside the last step.
    fn side_at(&self, k: usize, t: f64) -> Touch {
        let (contact, side) = self.dynamics.model.sides[k];
        let contact = &self.dynamics.model.contacts[contact];
        let dense = self.adams.dense(t);
        let model = &self.dynamics.model;
        let n = model.coordinates();
        let (shift, since) = (&self.dynamics.shift, t - self.dynamics.shift_time);
        let value = |i: usize| {
            let grown = if i < n { since * shift[n + i] } else { 0.0 };
            dense.value(model.component(i)) + shift[i] + grown
        };
        let frame = |body: usize| match model.first[body] {
            None => self.dynamics.frames[body],
            Some(i) => Frame::new(
                [value(i), value(i + 1), value(i + 2)],
                [value(n + i), value(n + i + 1), value(n + i + 2)],
            ),
        };
        let (fa, fb) = (frame(contact.a.body), frame(contact.b.body));
        contact.find(&fa, &fb, side, Memory::default())
    }
}

//! Contact onsets and contact ends within a step, and the impact velocity memory of each side.

use serde::{Deserialize, Serialize};

use super::contact_states::ContactStates;
use super::impact_memory::{Memory, SideState};
use super::outline::OutlinePlace;
use crate::integrator::event_location::onset_in_step;
use crate::integrator::{Adams, Step};
use crate::multibody::description::body::Frame;
use crate::multibody::frames::Shift;
use crate::multibody::model::MechanismModel;

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

/// Numbers of contact onsets.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(crate) struct OnsetNumbers {
    pub(crate) all: u64,
    /// Onsets slower than the minimum impact velocity.
    pub(crate) at_minimum: u64,
}

impl OnsetNumbers {
    fn add(&mut self, at_minimum: bool) {
        self.all += 1;
        self.at_minimum += u64::from(at_minimum);
    }

    /// Remove an onset that lies after the time to which a run returns.
    fn remove(&mut self, at_minimum: bool) {
        self.all = self.all.saturating_sub(1);
        self.at_minimum = self.at_minimum.saturating_sub(u64::from(at_minimum));
    }
}

/// Contact onsets of a run.
#[derive(Debug, Clone, Default)]
pub(crate) struct Onsets {
    pub(crate) numbers: OnsetNumbers,
    /// Onsets without a recorded row, while a recording needs them.
    pub(crate) unreported: Option<Vec<Onset>>,
}

impl Onsets {
    fn add(&mut self, onset: Onset, at_minimum: bool) {
        self.numbers.add(at_minimum);
        if let Some(onsets) = &mut self.unreported {
            onsets.push(onset);
        }
    }

    /// Return the largest initial impact velocity of each contact \[m/s\] among the onsets up to `t`, and remove these onsets.
    pub(crate) fn take_velocities(&mut self, contacts: usize, t: f64) -> Vec<f64> {
        let mut largest = vec![0.0f64; contacts];
        if let Some(onsets) = &mut self.unreported {
            onsets.retain(|onset| {
                if onset.time <= t {
                    let largest = &mut largest[onset.contact];
                    *largest = largest.max(onset.velocity);
                }
                onset.time > t
            });
        }
        largest
    }
}

/// Motion of the bodies in the last step: dense output and shift.
pub(crate) struct StepMotion<'a> {
    pub(crate) model: &'a MechanismModel,
    /// Frames of the last evaluation, for bodies that are fixed.
    pub(crate) frames: &'a [Frame],
    pub(crate) shift: &'a Shift,
    pub(crate) adams: &'a Adams,
    /// Memory of all sides at the start of the step.
    pub(crate) memory_at_start: &'a [Memory],
}

impl StepMotion<'_> {
    /// Return the contact state of side `k` at time `t` \[s\].
    fn side_at(&self, k: usize, t: f64) -> SideState {
        let model = self.model;
        let (contact, side) = model.sides[k];
        let contact = &model.contacts[contact];
        let (dense, n) = (self.adams.dense(t), model.coordinates());
        let value = |i: usize| (self.shift).shifted(i, t, dense.value(model.component(i)));
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

    /// Return the largest initial impact velocity in the memory of the other sides of the same contact \[m/s\].
    fn speed_beside(&self, k: usize) -> Option<f64> {
        let (contact, _) = self.model.sides[k];
        let sides = self.model.sides_of_contact[contact].clone();
        let others = sides.filter(|&other| other != k);
        let others = others.map(|other| self.memory_at_start[other]);
        let in_contact = others.filter(Memory::is_in_contact);
        in_contact.map(|memory| memory.speed).reduce(f64::max)
    }
}

impl ContactStates {
    /// Set the memory of all contacts present at the last evaluation, with the present penetration rate as initial impact velocity.
    pub(crate) fn remember_present(&mut self, model: &MechanismModel, frames: &[Frame]) {
        for k in 0..self.side_states.len() {
            let side_state = self.side_states[k];
            if side_state.contact.penetration > 0.0 {
                self.begin_contact(
                    model,
                    k,
                    side_state.piece,
                    side_state.contact.penetration_rate,
                );
                self.note_place(k, side_state.place);
            } else {
                self.memory[k] = self.apart(k, model, frames);
            }
        }
    }

    /// Write the memory of contacts with an onset or an end within the step. The onset is a root of the dense output.
    pub(crate) fn find_onsets(&mut self, motion: &StepMotion, step: &Step, onsets: &mut Onsets) {
        for (number, contact) in motion.model.contacts.iter().enumerate() {
            let sides = motion.model.sides_of_contact[number].clone();
            if !self.near[number] {
                // Circles out of reach have no memory: the reach of an open outline, which has a back, is infinite.
                self.memory[sides].fill(Memory::default());
                continue;
            }
            for k in sides {
                let side_state = self.side_states[k];
                if side_state.contact.penetration > 0.0 {
                    // Penetration without memory: the contact began within the step.
                    if !self.memory[k].is_in_contact() {
                        self.find_onset(k, side_state.contact.penetration, motion, step, onsets);
                    }
                    self.note_place(k, side_state.place);
                } else if contact.is_open() {
                    self.memory[k] = self.apart(k, motion.model, motion.frames);
                } else {
                    self.memory[k] = Memory::default();
                }
            }
        }
    }

    fn find_onset(
        &mut self,
        k: usize,
        depth: f64,
        motion: &StepMotion,
        step: &Step,
        onsets: &mut Onsets,
    ) {
        let (t, rate) = onset_in_step(|t| motion.side_at(k, t).contact, step.start, step.end);
        let begun = motion.side_at(k, t);
        if begun.contact.penetration > SHALLOW * depth
            && let Some(speed) = motion.speed_beside(k)
        {
            // The contact moved over from a neighbouring side: its penetration is not zero at the crossing. It is not an onset, and the
            // impact velocity memory of that side remains valid.
            self.memory[k] = Memory {
                speed,
                piece: begun.piece,
                in_front: false,
            };
            return;
        }
        self.begin_contact(motion.model, k, begun.piece, rate);
        let (contact, _) = motion.model.sides[k];
        let at_minimum = motion.model.contacts[contact].is_at_minimum(self.memory[k]);
        let onset = Onset {
            time: t,
            contact,
            velocity: rate,
        };
        onsets.add(onset, at_minimum);
    }

    fn begin_contact(&mut self, model: &MechanismModel, k: usize, piece: usize, rate: f64) {
        let (contact, _) = model.sides[k];
        self.memory[k] = model.contacts[contact].remember(piece, rate);
    }

    /// Record whether the circle came from the front of an open outline. Only then is it in contact at any depth. A circle that
    /// moved round the end is not in contact with the surface from behind.
    fn note_place(&mut self, k: usize, place: OutlinePlace) {
        let memory = &mut self.memory[k];
        match place {
            OutlinePlace::Front | OutlinePlace::Deep => memory.in_front = true,
            OutlinePlace::EndFront => memory.in_front = false,
            OutlinePlace::EndBack | OutlinePlace::DeepAtEnd => {}
        }
    }

    /// Set the memory to that at `t` within the last step, where the contacts were evaluated last.
    ///
    /// Onsets after `t` are removed, and contacts that ended after `t` continue. Bristles of open contacts are undeflected.
    pub(crate) fn roll_back(&mut self, motion: &StepMotion, t: f64, onsets: &mut Onsets) {
        let (model, at_end) = (motion.model, t == motion.adams.time());
        for k in 0..self.memory.len() {
            let (number, _) = model.sides[k];
            let contact = &model.contacts[number];
            let side_state = self.side_states[k];
            let before = motion.memory_at_start[k];
            let remembers = self.memory[k].is_in_contact();
            if side_state.contact.penetration > 0.0 {
                if !remembers && before.is_in_contact() {
                    self.memory[k] = before;
                } else if !remembers {
                    // A contact that began and ended within the step.
                    let rate = side_state.contact.penetration_rate;
                    self.begin_contact(model, k, side_state.piece, rate);
                    self.note_place(k, side_state.place);
                    let onset = Onset {
                        time: t,
                        contact: number,
                        velocity: rate,
                    };
                    onsets.add(onset, contact.is_at_minimum(self.memory[k]));
                }
                continue;
            }
            if remembers && !before.is_in_contact() {
                onsets.numbers.remove(contact.is_at_minimum(self.memory[k]));
            }
            if !at_end {
                self.memory[k] = before;
            }
            self.memory[k] = self.apart(k, model, motion.frames);
            if let Some(bristle) = model.bristle_of_side[k] {
                self.bristles.deflection[bristle] = 0.0;
            }
        }
        if let Some(onsets) = &mut onsets.unreported {
            onsets.retain(|onset| onset.time <= t);
        }
    }
}

#[cfg(test)]
mod tests;

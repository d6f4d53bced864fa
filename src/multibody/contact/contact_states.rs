//! State of all contacts of a mechanism: forces and penetrations of the last evaluation, impact velocity memory, bristles.

use serde::{Deserialize, Serialize};

use super::bristles::ContactBristles;
use super::impact_memory::{Memory, SideState};
use super::law_ranges::EndingLaw;
use crate::force_law::past_range;
use crate::geometry::Vec2;
use crate::multibody::description::body::Frame;
use crate::multibody::forces::loads::BodyLoads;
use crate::multibody::model::MechanismModel;

/// State of a contact at one end of a step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct ContactEnd {
    /// Penetration \[m\], negative when apart, and its rate \[m/s\].
    pub(super) depth: [f64; 2],
    /// Position \[m\], velocity \[m/s\] and acceleration \[m/s²\] of the circle's centre in the frame of the profile; `None` if
    /// the circle is farther away than a step may carry it, or behind the profile.
    pub(super) motion: Option<[[f64; 2]; 3]>,
}

impl ContactEnd {
    pub(crate) const FAR: Self = Self {
        depth: [f64::NEG_INFINITY, 0.0],
        motion: None,
    };
}

/// State of all contacts. The memory changes between steps only.
#[derive(Debug, Clone)]
pub(crate) struct ContactStates {
    /// State of each side of each contact at the last evaluation.
    pub(crate) side_states: Vec<SideState>,
    /// Memory of each side since its onset.
    pub(crate) memory: Vec<Memory>,
    /// Whether each contact is close enough to be evaluated; sides of others are not evaluated.
    pub(crate) near: Vec<bool>,
    /// Largest penetration of each contact that is near \[m\], and its rate \[m/s\]; an upper bound and zero for the others.
    pub(crate) deepest: Vec<[f64; 2]>,
    /// State of each contact at the start of the present step, and at the end of the last one that was screened.
    pub(crate) starts: Vec<ContactEnd>,
    pub(super) ends: Vec<ContactEnd>,
    /// Whether `ends` are those of the last evaluation.
    pub(super) screened: bool,
    pub(crate) bristles: ContactBristles,
    /// Message on the first contact past the end of each law whose range ends.
    pub(crate) past_ends: Vec<Option<String>>,
}

impl ContactStates {
    /// Return the contacts of a model, without memory.
    pub(crate) fn new(model: &MechanismModel) -> Self {
        let (sides, contacts) = (model.sides.len(), model.contacts.len());
        Self {
            side_states: vec![SideState::default(); sides],
            memory: vec![Memory::default(); sides],
            near: vec![true; contacts],
            deepest: vec![[f64::NEG_INFINITY, 0.0]; contacts],
            starts: vec![ContactEnd::FAR; contacts],
            ends: vec![ContactEnd::FAR; contacts],
            screened: false,
            bristles: ContactBristles::new(model.bristles),
            past_ends: vec![None; model.ending_laws.len()],
        }
    }

    /// Evaluate all contacts and add their loads.
    pub(crate) fn add_loads(
        &mut self,
        model: &MechanismModel,
        frames: &[Frame],
        loads: &mut BodyLoads,
    ) {
        self.bristles.begin();
        self.screened = false;
        let contacts = model.contacts.iter().zip(&model.sides_of_contact);
        let states = self.near.iter_mut().zip(&mut self.deepest);
        for ((contact, sides), (near, deepest)) in contacts.zip(states) {
            let side_states = &mut self.side_states[sides.clone()];
            let apart = contact.apart_squared(frames);
            let was_near = std::mem::replace(near, apart <= contact.reach * contact.reach);
            if *near {
                let memory = &self.memory[sides.clone()];
                *deepest = contact.add(frames, memory, loads, side_states);
                if let Some(law) = &contact.friction {
                    let numbers = &model.bristle_of_side[sides.clone()];
                    let to = (&mut *loads, &mut *side_states);
                    contact.add_friction(law, frames, numbers, &mut self.bristles, to);
                }
                if let Some(film) = &contact.film {
                    contact.add_film(film, frames, loads, &mut side_states[0]);
                }
            } else {
                *deepest = [contact.outer_depth(apart), 0.0];
                if was_near {
                    side_states.fill(SideState::default());
                }
            }
        }
    }

    /// Record the first contact past the end of each law at the last evaluation, as long as the law has none.
    pub(crate) fn note_ranges(&mut self, model: &MechanismModel) {
        for (k, law) in model.ending_laws.iter().enumerate() {
            if self.past_ends[k].is_none() {
                self.past_ends[k] = self.past_end(model, law);
            }
        }
    }

    /// Return a message on the first contact past the end of `law`.
    fn past_end(&self, model: &MechanismModel, law: &EndingLaw) -> Option<String> {
        let contacts = law.contacts.iter();
        let mut deep = contacts.filter(|&&(contact, end)| self.deepest[contact][0] > end);
        deep.find_map(|&(number, _)| {
            let contact = &model.contacts[number];
            model.sides_of_contact[number].clone().find_map(|side| {
                let state = &self.side_states[side];
                let depth = state.contact.penetration;
                let on_piece = contact.law_on(state.piece, self.memory[side]);
                let end = on_piece.elastic.range_end();
                let name = || format!("contact {:?}", model.contact_names[number]);
                (depth > end).then(|| past_range(law.law, &name(), depth, end))
            })
        })
    }

    /// Return the memory of a side without penetration: that the circle is behind an open outline, or none.
    pub(crate) fn apart(&self, k: usize, model: &MechanismModel, frames: &[Frame]) -> Memory {
        let (contact, side) = model.sides[k];
        let contact = &model.contacts[contact];
        let [fa, fb] = [contact.a.body, contact.b.body].map(|body| &frames[body]);
        contact.apart(fa, fb, side, self.memory[k])
    }

    /// Set the memory of contacts that ended in the last step, and of circles that left the back of an open outline in it, to that
    /// `at_start` of the step; return the sides changed, with what they had.
    ///
    /// The memory at the end of the step has neither. Without it, damping by the minimum impact velocity would cancel the force of
    /// rows inside the step.
    pub(crate) fn restore_memory(&mut self, at_start: &[Memory]) -> Vec<(usize, Memory)> {
        let lost = |now: &Memory, before: &Memory| {
            before.is_behind() || before.is_in_contact() && !now.is_in_contact()
        };
        let sides = self.memory.iter_mut().zip(at_start).enumerate();
        sides
            .filter(|(_, (now, before))| lost(now, before))
            .map(|(k, (now, before))| (k, std::mem::replace(now, *before)))
            .collect()
    }

    /// Return the force of each contact on its circle \[N\], with friction and film, summed over its sides.
    pub(crate) fn pushes(&self, model: &MechanismModel) -> impl Iterator<Item = Vec2> {
        let contacts = model.sides_of_contact.iter();
        contacts.map(|sides| {
            self.side_states[sides.clone()]
                .iter()
                .map(|side_state| side_state.push + side_state.friction)
                .sum()
        })
    }

    /// Return whether any side has had an onset and no contact end since.
    pub(crate) fn any_is_closed(&self) -> bool {
        self.memory.iter().any(Memory::is_in_contact)
    }

    /// Return whether a contact began or ended since the start of the step: a side with a memory was in contact then.
    pub(crate) fn changed(&self, model: &MechanismModel) -> bool {
        (model.sides_of_contact.iter())
            .zip(&self.near)
            .flat_map(|(sides, &near)| if near { sides.clone() } else { 0..0 })
            .any(|k| {
                self.memory[k].is_in_contact() != (self.side_states[k].contact.penetration > 0.0)
            })
    }

    /// Return the bristles of all sides without contact at the last evaluation.
    pub(crate) fn bristles_of_ended_contacts(
        &self,
        model: &MechanismModel,
    ) -> impl Iterator<Item = usize> {
        let sides = self.side_states.iter().zip(&model.bristle_of_side);
        sides.filter_map(|(side_state, bristle)| {
            bristle.filter(|_| side_state.contact.penetration <= 0.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{BALL, at_rest, bristled, contact, evaluated, frames, model};
    use super::*;
    use crate::multibody::description::profile::Profile;

    const IN_CONTACT: Memory = Memory {
        speed: 0.5,
        piece: 0,
        in_front: false,
    };

    /// Return a contact with a disc of 0.2 m and one with a floor, which has bristles.
    fn disc_and_floor() -> MechanismModel {
        let disc = contact(Profile::Disc { radius: 0.2 }, 0.1);
        model(vec![disc, bristled("floor")])
    }

    fn ball_at(x: f64, y: f64) -> Vec<Frame> {
        frames(&at_rest(), &[[x, y, 0.0], [0.0; 3], [0.0; 3]], 0.0)
    }

    #[test]
    fn a_circle_that_leaves_the_reach_of_a_profile_has_no_contact_and_its_outer_gap() {
        let model = disc_and_floor();
        let mut states = ContactStates::new(&model);
        let loads = evaluated(&model, &mut states, &ball_at(0.0, 0.28));
        assert!((loads.on[BALL][1] - 20.0).abs() < 1e-12);
        assert_eq!(states.near, [true, true]);
        assert!((states.deepest[0][0] - 0.02).abs() < 1e-15);
        // Exactly in reach, and beyond it.
        evaluated(&model, &mut states, &ball_at(0.0, 0.31));
        assert_eq!(states.near, [false, true]);
        assert_eq!(states.side_states[0], SideState::default());
        assert!((states.deepest[0][0] + 0.01).abs() < 1e-15 && states.deepest[0][1] == 0.0);
        assert!((states.deepest[1][0] + 0.21).abs() < 1e-15);
        let loads = evaluated(&model, &mut states, &ball_at(0.0, 5.0));
        assert_eq!(
            (loads.on[BALL], states.deepest[0][0]),
            ([0.0; 3], f64::NEG_INFINITY)
        );
    }

    #[test]
    fn a_contact_changes_where_memory_and_penetration_differ_in_reach() {
        let model = disc_and_floor();
        for (near, memory, penetration, changed) in [
            (true, Memory::default(), -0.1, false),
            (true, IN_CONTACT, 0.1, false),
            (true, Memory::default(), 0.1, true),
            (true, IN_CONTACT, -0.1, true),
            (true, Memory::BEHIND, -0.1, false),
            (true, IN_CONTACT, 0.0, true),
            (false, IN_CONTACT, -0.1, false),
        ] {
            let mut states = ContactStates::new(&model);
            states.near[0] = near;
            states.memory[0] = memory;
            states.side_states[0].contact.penetration = penetration;
            assert_eq!(
                states.changed(&model),
                changed,
                "{near} {memory:?} {penetration}"
            );
        }
    }

    #[test]
    fn inside_a_step_ended_contacts_and_backs_have_the_memory_of_its_start() {
        let model = disc_and_floor();
        let none = Memory::default();
        let other = Memory {
            speed: 0.9,
            ..IN_CONTACT
        };
        for (before, now, restored) in [
            (IN_CONTACT, none, true),
            (IN_CONTACT, other, false),
            (Memory::BEHIND, none, true),
            (Memory::BEHIND, other, true),
            (none, other, false),
            (none, none, false),
        ] {
            let mut states = ContactStates::new(&model);
            states.memory[1] = now;
            let replaced = states.restore_memory(&[none, before]);
            assert_eq!(states.memory, [none, if restored { before } else { now }]);
            assert_eq!(replaced, if restored { vec![(1, now)] } else { vec![] });
        }
    }

    #[test]
    fn bristles_of_contacts_that_are_apart_are_listed() {
        let model = disc_and_floor();
        let mut states = ContactStates::new(&model);
        for (penetration, parted) in [(-0.1, vec![0]), (0.0, vec![0]), (0.1, vec![])] {
            // The disc has no bristle.
            states.side_states[0].contact.penetration = -0.1;
            states.side_states[1].contact.penetration = penetration;
            let found: Vec<usize> = states.bristles_of_ended_contacts(&model).collect();
            assert_eq!(found, parted);
        }
    }
}

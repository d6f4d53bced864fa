//! Contact onsets and contact ends within a step, and the impact velocity memory of each side.

use serde::{Deserialize, Serialize};

use super::contact_states::ContactStates;
use super::impact_memory::{Memory, SideState};
use super::outline::Place;
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
    pub(crate) at_floor: u64,
}

impl OnsetNumbers {
    fn add(&mut self, at_floor: bool) {
        self.all += 1;
        self.at_floor += u64::from(at_floor);
    }

    /// Remove an onset that lies after the time to which a run returns.
    fn remove(&mut self, at_floor: bool) {
        self.all = self.all.saturating_sub(1);
        self.at_floor = self.at_floor.saturating_sub(u64::from(at_floor));
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
    fn add(&mut self, onset: Onset, at_floor: bool) {
        self.numbers.add(at_floor);
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
        let at_floor = motion.model.contacts[contact].is_at_floor(self.memory[k]);
        let onset = Onset {
            time: t,
            contact,
            velocity: rate,
        };
        onsets.add(onset, at_floor);
    }

    fn begin_contact(&mut self, model: &MechanismModel, k: usize, piece: usize, rate: f64) {
        let (contact, _) = model.sides[k];
        self.memory[k] = model.contacts[contact].remember(piece, rate);
    }

    /// Record whether the circle came from the front of an open outline. Only then is it in contact at any depth. A circle that
    /// moved round the end is not in contact with the surface from behind.
    fn note_place(&mut self, k: usize, place: Place) {
        let memory = &mut self.memory[k];
        match place {
            Place::Front | Place::Deep => memory.in_front = true,
            Place::EndFront => memory.in_front = false,
            Place::EndBack | Place::DeepAtEnd => {}
        }
    }

    /// Set the memory to that at `t` within the last step, where the contacts were evaluated last.
    ///
    /// Onsets after `t` are removed, and contacts that ended after `t` continue. Bristles of open contacts are undeflected.
    pub(crate) fn roll_back(&mut self, motion: &StepMotion, t: f64, onsets: &mut Onsets) {
        let (model, at_end) = (motion.model, t == motion.adams.time());
        for k in 0..self.memory.len() {
            let contact = &model.contacts[model.sides[k].0];
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
                    onsets.numbers.add(contact.is_at_floor(self.memory[k]));
                }
                continue;
            }
            if remembers && !before.is_in_contact() {
                onsets.numbers.remove(contact.is_at_floor(self.memory[k]));
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
mod tests {
    use super::super::tests::{BALL, contact, floor, mechanism, outline};
    use super::*;
    use crate::force_law::{Damping, Elastic, ForceLaw, LuGre, Regions};
    use crate::geometry::{Vec2, unit};
    use crate::integrator::{Corrector, OdeSystem, StepControl};
    use crate::multibody::description::body::Marker;
    use crate::multibody::description::contact_law::ContactLaw;
    use crate::multibody::description::profile::Profile;
    use crate::multibody::description::tribology::FrictionLaw;
    use crate::multibody::{Mechanism, MechanismDynamics};
    use crate::system::System;
    use std::sync::Arc;

    const RADIUS: f64 = 0.1;

    /// Return the dynamics of a mechanism and the integrator at the start of a run.
    fn ready(described: &Mechanism) -> (MechanismDynamics, Adams) {
        let model = Arc::new(MechanismModel::compile(described).unwrap());
        let mut dynamics = MechanismDynamics::new(model);
        let y = dynamics.assemble_for_run(&|| false).unwrap();
        let control = StepControl {
            rtol: 1e-10,
            atol: 1e-10,
            max_step: 1e-2,
            corrector: Corrector::Pece,
            ..StepControl::default()
        };
        let mut adams = Adams::new(dynamics.dimension(), control);
        adams.restart(0.0, &y);
        dynamics.evaluate_inside(&adams, 0.0);
        dynamics.remember_present_contacts();
        dynamics.onsets.unreported = Some(Vec::new());
        (dynamics, adams)
    }

    fn step(dynamics: &mut MechanismDynamics, adams: &mut Adams) -> Step {
        let longest = dynamics.longest_step(adams);
        adams.limit_step(longest);
        dynamics.begin_step(adams);
        let step = adams.step_second_order(dynamics).unwrap();
        dynamics.finish_step(adams, &step).unwrap();
        step
    }

    /// Set the memory to that at `t` in the last step.
    fn roll_back(dynamics: &mut MechanismDynamics, adams: &Adams, t: f64) {
        dynamics.evaluate_inside(adams, t);
        let motion = StepMotion {
            model: &dynamics.model,
            frames: &dynamics.frames,
            shift: &dynamics.shift,
            adams,
            memory_at_start: &dynamics.step.memory,
        };
        (dynamics.contacts).roll_back(&motion, t, &mut dynamics.onsets);
    }

    /// Return the law of surfaces with this minimum impact velocity \[m/s\].
    fn surfaces(min_approach_speed: f64) -> ContactLaw {
        ContactLaw::Surfaces {
            law: ForceLaw {
                elastic: Elastic::Linear(1e3),
                damping: Damping::LankaraniNikravesh,
                regions: Regions::Kept,
            },
            contact_modulus: 1e7,
            restitution: 0.9,
            length: 0.02,
            min_approach_speed,
        }
    }

    /// Two turning bodies with discs beside their centres of mass: those at the markers meet.
    fn meeting(law: ContactLaw) -> (Mechanism, f64, f64) {
        let mut pair = contact(Profile::Disc { radius: 0.2 }, RADIUS);
        (pair.a.point, pair.b.point) = (Vec2::new(0.05, -0.02), Vec2::new(-0.03, 0.04));
        pair.law = law;
        let (a, b) = (pair.a.point, pair.b.point);
        let mut described = mechanism(vec![pair]);
        let motions = [
            ([0.0, 0.1, 0.3], [0.2, -0.1, 2.0]),
            ([0.6, 0.2, -0.5], [-1.0, -0.3, -3.0]),
        ];
        for (body, (position, velocity)) in described.bodies.iter_mut().zip(motions) {
            (body.position, body.velocity) = (position, velocity);
        }
        // Bodies without forces: the markers run along helices.
        let marker = |(p, v): ([f64; 3], [f64; 3]), of: Vec2, t: f64| {
            let x = unit(p[2] + t * v[2]);
            Vec2::new(p[0] + t * v[0], p[1] + t * v[1]) + of.x * x + of.y * Vec2::new(-x.y, x.x)
        };
        let distance = |t: f64| (marker(motions[1], b, t) - marker(motions[0], a, t)).norm();
        let (mut low, mut high) = (0.0, 0.4);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *(if distance(middle) > 0.3 {
                &mut low
            } else {
                &mut high
            }) = middle;
        }
        let rate = (distance(low - 1e-6) - distance(low + 1e-6)) / 2e-6;
        (described, low, rate)
    }

    #[test]
    fn two_discs_touch_when_and_as_fast_as_their_free_motion_says() {
        for (floor, slow) in [(1e-3, 0), (10.0, 1)] {
            let (described, time, rate) = meeting(surfaces(floor));
            let (mut dynamics, mut adams) = ready(&described);
            assert!(dynamics.contacts.memory[0].is_empty());
            while adams.time() < time {
                assert_eq!(dynamics.onsets.numbers.all, 0);
                step(&mut dynamics, &mut adams);
            }
            let numbers = dynamics.onsets.numbers;
            assert_eq!((numbers.all, numbers.at_floor), (1, slow));
            let found = dynamics.onsets.unreported.clone().unwrap();
            assert_eq!((found.len(), found[0].contact), (1, 0));
            // The tolerances are 1e-10, and the force changes the path within the step.
            assert!((found[0].time - time).abs() < 1e-8, "{:?} {time}", found[0]);
            assert!(
                (found[0].velocity - rate).abs() < 1e-6,
                "{:?} {rate}",
                found[0]
            );
            let memory = dynamics.contacts.memory[0];
            assert_eq!(memory.speed, found[0].velocity.max(floor));
            assert!(memory.in_front);
            // The memory ends with the contact, and no other onset is counted.
            while dynamics.contacts.memory[0].is_in_contact() {
                step(&mut dynamics, &mut adams);
            }
            assert!(adams.time() > time && dynamics.contacts.memory[0].is_empty());
            assert_eq!(dynamics.onsets.numbers.all, 1);
        }
    }

    #[test]
    fn a_return_before_an_onset_takes_it_back_and_one_after_it_keeps_it() {
        for (floor, slow) in [(1e-3, 0), (10.0, 1)] {
            let (described, time, _) = meeting(surfaces(floor));
            for before in [true, false] {
                let (mut dynamics, mut adams) = ready(&described);
                let last = loop {
                    let last = step(&mut dynamics, &mut adams);
                    if last.end > time {
                        break last;
                    }
                };
                let memory = dynamics.contacts.memory[0];
                let t = if before {
                    0.5 * (last.start + time)
                } else {
                    0.5 * (time + last.end)
                };
                roll_back(&mut dynamics, &adams, t);
                let numbers = dynamics.onsets.numbers;
                let count = u64::from(!before);
                assert_eq!((numbers.all, numbers.at_floor), (count, count * slow));
                assert_eq!(
                    dynamics.onsets.unreported.unwrap().len(),
                    usize::from(!before)
                );
                let expected = if before { Memory::default() } else { memory };
                assert_eq!(dynamics.contacts.memory[0], expected);
            }
        }
    }

    #[test]
    fn a_return_into_a_contact_that_has_ended_continues_it() {
        let (described, time, _) = meeting(surfaces(1e-3));
        let run = || {
            let (mut dynamics, mut adams) = ready(&described);
            while adams.time() < time {
                step(&mut dynamics, &mut adams);
            }
            let memory = dynamics.contacts.memory[0];
            let last = loop {
                let last = step(&mut dynamics, &mut adams);
                if !dynamics.contacts.memory[0].is_in_contact() {
                    break last;
                }
            };
            (dynamics, adams, memory, last)
        };
        let (mut dynamics, adams, memory, last) = run();
        roll_back(
            &mut dynamics,
            &adams,
            last.start + 1e-9 * (last.end - last.start),
        );
        assert_eq!(dynamics.contacts.memory[0], memory);
        assert_eq!(dynamics.onsets.numbers.all, 1);
        let (mut dynamics, mut adams, _, last) = run();
        roll_back(&mut dynamics, &adams, last.end);
        assert!(dynamics.contacts.memory[0].is_empty());
        assert_eq!(dynamics.onsets.numbers.all, 1);
        // A return to a time after the contact has no part in its onset.
        let last = step(&mut dynamics, &mut adams);
        roll_back(&mut dynamics, &adams, 0.5 * (last.start + last.end));
        assert!(dynamics.contacts.memory[0].is_empty());
        assert_eq!(dynamics.onsets.numbers.all, 1);
    }

    #[test]
    fn a_return_into_a_contact_inside_a_step_counts_it() {
        // The circle is in contact at the time of the return, and neither before nor behind the step.
        for (floor, slow) in [(1e-3, 0), (10.0, 1)] {
            let mut pair = contact(self::floor(), RADIUS);
            pair.law = surfaces(floor);
            let (mut dynamics, adams) = ready(&mechanism(vec![pair]));
            let mut state = vec![0.0; 12];
            (state[4], state[10]) = (0.08, -0.3);
            dynamics.contacts.memory[0] = Memory::default();
            dynamics.evaluate(0.0, &state);
            let motion = StepMotion {
                model: &dynamics.model,
                frames: &dynamics.frames,
                shift: &dynamics.shift,
                adams: &adams,
                memory_at_start: &[Memory::default()],
            };
            (dynamics.contacts).roll_back(&motion, 0.0, &mut dynamics.onsets);
            let memory = dynamics.contacts.memory[0];
            assert!((memory.speed - f64::max(0.3, floor)).abs() < 1e-15 && memory.in_front);
            let numbers = dynamics.onsets.numbers;
            assert_eq!((numbers.all, numbers.at_floor), (1, slow));
        }
    }

    #[test]
    fn a_circle_that_comes_from_behind_passes_an_open_outline_and_has_no_onset() {
        let mut described = mechanism(vec![contact(floor(), RADIUS)]);
        described.bodies[1].position[1] = -0.3;
        described.bodies[1].velocity[1] = 1.0;
        let (mut dynamics, mut adams) = ready(&described);
        assert_eq!(dynamics.contacts.memory[0], Memory::BEHIND);
        let mut behind = 0;
        let last = loop {
            let last = step(&mut dynamics, &mut adams);
            if dynamics.contacts.memory[0].is_empty() {
                break last;
            }
            behind += 1;
        };
        // 0.4 m at 1 m/s to the place where the circle is in front, without a force.
        assert!(
            behind > 10 && last.start <= 0.4 && last.end >= 0.4,
            "{last:?}"
        );
        assert_eq!(dynamics.frames[BALL].velocity.y, 1.0);
        assert_eq!(dynamics.onsets.numbers.all, 0);
        // Back to a time before it, it is still behind; at the end of the step it is not.
        let mut other = dynamics.clone();
        roll_back(&mut other, &adams, last.end);
        assert!(other.contacts.memory[0].is_empty());
        roll_back(&mut dynamics, &adams, last.start);
        assert_eq!(dynamics.contacts.memory[0], Memory::BEHIND);
    }

    /// Return a ball of 2 kg that slides on `profile` of the ground at 1 m/s against x, at its equilibrium of 20 mm penetration.
    fn sliding(profile: Profile, (x, y): (f64, f64)) -> Mechanism {
        let mut pair = contact(profile, RADIUS);
        pair.a = Marker::new("ground", 0.0, 0.0);
        let mut described = mechanism(vec![pair]);
        described.bodies[0].fixed = true;
        described.gravity.y = -10.0;
        described.bodies[1].position = [x, y + 0.08, 0.0];
        described.bodies[1].velocity = [-1.0, 0.0, 0.0];
        described
    }

    #[test]
    fn a_contact_that_moves_to_a_neighbouring_side_keeps_its_memory_and_is_no_onset() {
        // The outline has one re-entrant corner, below. It is divided in two sides there and in the middle of its top, at x = 0.
        let top = outline(
            &[
                (-2.0, -1.0),
                (0.0, -0.5),
                (2.0, -1.0),
                (2.0, 0.0),
                (0.0, 0.0),
                (-2.0, 0.0),
            ],
            true,
        );
        let (mut dynamics, mut adams) = ready(&sliding(top, (0.05, 0.0)));
        let sides = |dynamics: &MechanismDynamics| {
            let in_contact = dynamics.contacts.memory.iter().map(Memory::is_in_contact);
            in_contact.collect::<Vec<_>>()
        };
        let first = sides(&dynamics);
        assert_eq!(first.iter().filter(|&&side| side).count(), 1);
        let k = first.iter().position(|&side| side).unwrap();
        dynamics.contacts.memory[k].speed = 0.37;
        while adams.time() < 0.1 {
            step(&mut dynamics, &mut adams);
        }
        let after = sides(&dynamics);
        assert_eq!(after, [!first[0], !first[1]]);
        let memory = dynamics.contacts.memory[1 - k];
        assert_eq!((memory.speed, memory.in_front), (0.37, true));
        assert_eq!(dynamics.onsets.numbers.all, 0);
    }

    #[test]
    fn a_side_that_is_hit_beside_another_contact_has_an_onset_of_its_own() {
        // A floor with a wall, at x = -0.5, that the ball meets at 1 m/s.
        let corner = outline(&[(1.0, 0.0), (-0.5, 0.0), (-0.5, 1.0)], false);
        let (mut dynamics, mut adams) = ready(&sliding(corner, (-0.35, 0.0)));
        let k = dynamics
            .contacts
            .memory
            .iter()
            .position(Memory::is_in_contact)
            .unwrap();
        dynamics.contacts.memory[k].speed = 7.0;
        while adams.time() < 0.06 {
            step(&mut dynamics, &mut adams);
        }
        assert_eq!(dynamics.onsets.numbers.all, 1);
        let onset = dynamics.onsets.unreported.unwrap()[0];
        assert!((onset.time - 0.05).abs() < 1e-8 && (onset.velocity - 1.0).abs() < 1e-7);
        let speeds = [k, 1 - k].map(|k| dynamics.contacts.memory[k].speed);
        assert_eq!(speeds, [7.0, onset.velocity]);
    }

    #[test]
    fn present_contacts_have_their_rate_as_impact_velocity_and_others_none() {
        let mut described = mechanism(vec![contact(floor(), RADIUS)]);
        described.bodies[1].velocity[1] = -0.3;
        for (y, speed, in_front) in [(0.08, 0.3, true), (0.12, 0.0, false), (-0.2, -1.0, false)] {
            described.bodies[1].position[1] = y;
            let memory = ready(&described).0.contacts.memory[0];
            assert_eq!((memory.speed, memory.in_front), (speed, in_front), "{y}");
        }
        // Beyond the end of the line and in front of it, the circle may pass to its back.
        described.bodies[1].position = [1.05, 0.02, 0.0];
        let memory = ready(&described).0.contacts.memory[0];
        assert!(memory.is_in_contact() && !memory.in_front);
    }

    #[test]
    fn contacts_out_of_reach_have_no_memory() {
        let mut described = mechanism(vec![contact(Profile::Disc { radius: 0.2 }, RADIUS)]);
        described.bodies[1].position[1] = 0.5;
        let (mut dynamics, mut adams) = ready(&described);
        dynamics.contacts.memory[0].speed = 0.4;
        step(&mut dynamics, &mut adams);
        assert!(dynamics.contacts.memory[0].is_empty());
    }

    #[test]
    fn a_return_undeflects_the_bristles_of_open_contacts_alone() {
        let mut pair = contact(floor(), RADIUS);
        pair.tribology.friction = Some(FrictionLaw::LuGre(LuGre {
            static_coefficient: 0.4,
            kinetic_coefficient: 0.3,
            stiffness: 1e3,
            damping: 0.0,
            viscous_coefficient: 0.0,
            stribeck_speed: 0.1,
            stribeck_exponent: 2.0,
        }));
        let mut described = mechanism(vec![pair]);
        for (y, kept) in [(0.08, 3e-5), (0.12, 0.0)] {
            described.bodies[1].position[1] = y;
            let (mut dynamics, adams) = ready(&described);
            dynamics.contacts.bristles.deflection[0] = 3e-5;
            let motion = StepMotion {
                model: &dynamics.model,
                frames: &dynamics.frames,
                shift: &dynamics.shift,
                adams: &adams,
                memory_at_start: &dynamics.step.memory,
            };
            (dynamics.contacts).roll_back(&motion, 0.0, &mut dynamics.onsets);
            assert_eq!(dynamics.contacts.bristles.deflection[0], kept);
        }
    }

    #[test]
    fn the_largest_velocities_up_to_a_report_are_taken_and_later_ones_wait() {
        let onset = |time, contact, velocity| Onset {
            time,
            contact,
            velocity,
        };
        let mut onsets = Onsets::default();
        onsets.add(onset(0.1, 0, 0.2), false);
        // Without a recording nothing is kept but the numbers.
        assert_eq!(onsets.take_velocities(2, 1.0), [0.0, 0.0]);
        onsets.unreported = Some(Vec::new());
        for (time, contact, velocity) in [
            (0.2, 0, 0.3),
            (0.3, 0, 0.5),
            (0.4, 0, 0.1),
            (0.5, 2, 0.7),
            (0.6, 0, 0.9),
        ] {
            onsets.add(onset(time, contact, velocity), time == 0.3);
        }
        assert_eq!(onsets.take_velocities(3, 0.5), [0.5, 0.0, 0.7]);
        assert_eq!(onsets.take_velocities(3, 0.6), [0.9, 0.0, 0.0]);
        assert_eq!(onsets.take_velocities(3, 9.0), [0.0; 3]);
        let mut numbers = onsets.numbers;
        assert_eq!((numbers.all, numbers.at_floor), (6, 1));
        numbers.remove(true);
        numbers.remove(false);
        assert_eq!((numbers.all, numbers.at_floor), (4, 0));
    }
}

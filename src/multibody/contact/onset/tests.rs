//! Tests of contact onsets, and of the memory of contacts along runs and returns.

use super::super::tests::{BALL, bristled, contact, floor, mechanism, outline};
use super::*;
use crate::force_law::{Damping, Elastic, ForceLaw, Regions};
use crate::geometry::{Vec2, unit};
use crate::integrator::{Corrector, OdeSystem, StepControl};
use crate::multibody::description::body::Marker;
use crate::multibody::description::contact_law::ContactLaw;
use crate::multibody::description::profile::Profile;
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
fn surfaces(min_impact_velocity: f64) -> ContactLaw {
    ContactLaw::Surfaces {
        law: ForceLaw {
            elastic: Elastic::Linear(1e3),
            damping: Damping::LankaraniNikravesh,
            regions: Regions::Kept,
        },
        contact_modulus: 1e7,
        restitution: 0.9,
        length: 0.02,
        min_impact_velocity,
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
        assert_eq!((numbers.all, numbers.at_minimum), (1, slow));
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
            assert_eq!((numbers.all, numbers.at_minimum), (count, count * slow));
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
        assert_eq!((numbers.all, numbers.at_minimum), (1, slow));
        assert_eq!(dynamics.onsets.take_velocities(1, 0.0), [0.3]);
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
    let mut described = mechanism(vec![bristled("floor")]);
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
    assert_eq!((numbers.all, numbers.at_minimum), (6, 1));
    numbers.remove(true);
    numbers.remove(false);
    assert_eq!((numbers.all, numbers.at_minimum), (4, 0));
}

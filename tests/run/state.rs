//! A state is complete: a run that is restored from it goes on to the same bits.

use std::time::Duration;

use crate::common::mechanisms::{self, bar_chain};
use crate::common::scenes::laws;
use crate::common::{advance, control, paper_drive, record, simulation, tensioner};
use rustchain::drive::{Bearing, Drive, SprocketMotion};
use rustchain::force_law::{Damping, Elastic, Regions};
use rustchain::integrator::{Corrector, StepControl};
use rustchain::{ForceLaws, Groups, Simulation, Snapshot};

const ALL: Groups = Groups {
    hinges: true,
    teeth: true,
    sprockets: true,
    bodies: true,
    energy: true,
};

fn pulled(pretension: f64) -> Drive {
    Drive {
        tensioner: (pretension > 0.0).then(|| tensioner(pretension, 0.01)),
        ..paper_drive()
    }
}

fn snapshot(drive: &Drive, laws: &ForceLaws) -> Snapshot {
    fresh(drive, laws).snapshot()
}

fn fresh(drive: &Drive, laws: &ForceLaws) -> Simulation {
    simulation(drive, laws, control(1e-5))
}

fn bytes(simulation: &Simulation) -> Vec<u8> {
    simulation.snapshot().to_bytes().unwrap()
}

/// A simulation of its own that has nothing from `simulation` but the bytes of its state.
fn successor(simulation: &Simulation, drive: &Drive, laws: &ForceLaws) -> Simulation {
    let mut successor = fresh(drive, laws);
    let snapshot = Snapshot::from_bytes(&bytes(simulation)).unwrap();
    successor.restore(&snapshot).unwrap();
    assert!(
        bytes(&successor) == bytes(simulation),
        "at {} s",
        simulation.time()
    );
    successor
}

/// Makes exactly one step.
fn step(simulation: &mut Simulation) {
    let reached = simulation.integrator().time();
    advance(simulation, reached.next_up());
}

#[test]
fn the_rest_of_a_run_is_the_same_whatever_drive_law_and_balance() {
    let floating = {
        let mut drive = paper_drive();
        drive.sprockets[1].bearing = Bearing::Floating;
        drive.sprockets[1].motion = SprocketMotion::AppliedTorque((-0.1).into());
        drive
    };
    for drive in [pulled(0.0), pulled(25.0), floating] {
        for laws in [
            laws(Elastic::Hertz, Damping::LankaraniNikravesh, Regions::Kept),
            laws(
                Elastic::EnhancedCylinder,
                Damping::LankaraniNikravesh,
                Regions::Kept,
            ),
            laws(Elastic::Johnson, Damping::None, Regions::Kept),
        ] {
            for energy in [false, true] {
                let groups = Groups { energy, ..ALL };
                let mut whole = fresh(&drive, &laws);
                let first = record(&mut whole, 5.3e-3, 1e-3, groups);
                let mut successor = successor(&whole, &drive, &laws);
                assert!(first.time.len() == 7 && whole.statistics().onsets > 0);
                let rest = record(&mut whole, 3e-3, 1.7e-5, groups);
                assert_eq!(record(&mut successor, 3e-3, 1.7e-5, groups), rest);
                assert_eq!(bytes(&successor), bytes(&whole));
            }
        }
    }
}

#[test]
fn a_run_handed_on_after_every_step_is_the_run_that_nobody_touched() {
    let (drive, laws) = (pulled(25.0), ForceLaws::default());
    let mut whole = fresh(&drive, &laws);
    let mut relay = fresh(&drive, &laws);
    // Through the first contacts, and until the list of candidates, made at the start, has been made anew.
    let (mut steps, mut onsets, mut partings, mut refreshes) = (0, 0, 0, 0);
    while whole.time() < 11e-3 {
        let before = (
            whole.statistics().onsets,
            whole.dynamics().candidate_refreshes(),
        );
        step(&mut whole);
        step(&mut relay);
        relay = successor(&relay, &drive, &laws);
        let longest = [&relay, &whole].map(|run| run.dynamics().longest_step_past_teeth());
        assert_eq!(longest[0], longest[1]);
        steps += 1;
        let dynamics = whole.dynamics();
        onsets += u32::from(whole.statistics().onsets > before.0);
        partings += u32::from(!dynamics.ended_contacts().is_empty());
        refreshes += u32::from(dynamics.candidate_refreshes() > before.1);
    }
    assert_eq!(bytes(&relay), bytes(&whole));
    assert!(
        onsets > 20 && partings > 10 && refreshes > 0,
        "{steps} steps: {onsets} with onsets, {partings} with partings, {refreshes} lists"
    );
}

#[test]
fn a_list_of_candidates_is_carried_and_not_made_anew() {
    // Made by the first evaluation, the list holds until the chain has travelled 4.5 mm.
    let (drive, laws) = (pulled(0.0), ForceLaws::default());
    let mut whole = fresh(&drive, &laws);
    advance(&mut whole, 8e-3);
    let mut successor = successor(&whole, &drive, &laws);
    let lists = whole.dynamics().candidate_refreshes();
    step(&mut successor);
    assert_eq!(successor.dynamics().candidate_refreshes(), lists);
}

#[test]
fn a_state_before_the_first_step_and_one_after_a_failure_go_on_alike() {
    // So hard that no step can follow the first contact.
    let mut drive = paper_drive();
    drive.chain.material.elastic_modulus = 1e300;
    let laws = ForceLaws::default();
    let mut whole = fresh(&drive, &laws);
    let mut relay = successor(&whole, &drive, &laws);
    let failure = whole.advance(0.01, Duration::MAX).unwrap_err();
    assert_eq!(relay.advance(0.01, Duration::MAX).unwrap_err(), failure);
    assert_eq!(bytes(&relay), bytes(&whole));
    let mut relay = successor(&whole, &drive, &laws);
    assert_eq!(
        relay.advance(0.01, Duration::MAX).unwrap_err(),
        whole.advance(0.01, Duration::MAX).unwrap_err()
    );
    assert_eq!(bytes(&relay), bytes(&whole));
}

#[test]
fn a_state_can_be_set_back() {
    let (drive, laws) = (pulled(0.0), ForceLaws::default());
    let mut simulation = fresh(&drive, &laws);
    advance(&mut simulation, 5e-3);
    let early = simulation.snapshot();
    let first = record(&mut simulation, 2e-3, 1e-4, ALL);
    let end = bytes(&simulation);
    simulation.restore(&early).unwrap();
    assert_eq!(simulation.time(), 5e-3);
    assert_eq!(record(&mut simulation, 2e-3, 1e-4, ALL), first);
    assert_eq!(bytes(&simulation), end);
}

/// What refusing says; the simulation must be what it was.
fn refusal(simulation: &mut Simulation, snapshot: &Snapshot) -> String {
    let before = bytes(simulation);
    let said = simulation.restore(snapshot).unwrap_err().to_string();
    assert_eq!(bytes(simulation), before);
    said
}

#[test]
fn a_state_of_another_scene_is_refused_with_what_differs() {
    let laws = ForceLaws::default();
    let mut own = fresh(&paper_drive(), &laws);
    advance(&mut own, 1e-3);
    let mut heavier = paper_drive();
    heavier.chain.outer.mass *= 1.0 + f64::EPSILON;
    let johnson = self::laws(Elastic::Johnson, Damping::None, Regions::Kept);
    let floor = ForceLaws {
        min_impact_velocity: 2e-3,
        ..laws
    };
    let coarse = StepControl {
        max_step: 2e-4,
        ..control(1e-5)
    };
    let with_control = |control| simulation(&paper_drive(), &laws, control).snapshot();
    for (other, said) in [
        (snapshot(&heavier, &laws), "state, drive = model"),
        (snapshot(&pulled(25.0), &laws), "state, drive = model"),
        (
            snapshot(&paper_drive(), &johnson),
            "state, hinge law = johnson, undamped",
        ),
        (
            snapshot(&paper_drive(), &floor),
            "state, min_impact_velocity = 0.002: the simulation has 0.001: make",
        ),
        (
            with_control(control(1e-6)),
            "state, Solver.rtol = 1e-6: the simulation has 1e-5",
        ),
        (with_control(coarse), "state, Solver.max_step = 2e-4"),
    ] {
        let message = refusal(&mut own, &other);
        assert!(message.contains(said), "{message}");
    }
}

#[test]
fn a_state_is_not_set_while_a_recording_is_under_way() {
    let mut simulation = fresh(&paper_drive(), &ForceLaws::default());
    let snapshot = simulation.snapshot();
    simulation.start_recording(1e-3, 1e-4, ALL);
    let message = refusal(&mut simulation, &snapshot);
    assert!(message.contains("a recording is under way"), "{message}");
    simulation.take_recording();
    simulation.restore(&snapshot).unwrap();
}

#[test]
fn bytes_that_are_not_those_of_a_state_are_refused() {
    let mut simulation = fresh(&paper_drive(), &ForceLaws::default());
    advance(&mut simulation, 5e-3);
    let whole = bytes(&simulation);
    let said = |bytes: &[u8]| <Snapshot>::from_bytes(bytes).unwrap_err().to_string();
    for place in (0..whole.len()).step_by(97).chain(0..40) {
        for change in [1, 0x80, 0xff] {
            let mut damaged = whole.clone();
            damaged[place] ^= change;
            let message = said(&damaged);
            let expected = match place {
                0..16 => "hold no state",
                16..20 => "this rustchain reads version 24",
                _ => "are damaged",
            };
            assert!(message.contains(expected), "byte {place}: {message}");
        }
    }
    for length in [0, 15, 19, 20, 27, 28, whole.len() - 1] {
        said(&whole[..length]);
    }
    assert!(said(&[&whole[..], &[0]].concat()).contains("are damaged"));
}

/// The bytes with a checksum that is right, after a change to their content.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let content = bytes.len() - 8;
    let sum = bytes[..content]
        .iter()
        .fold(0xcbf2_9ce4_8422_2325_u64, |sum, &byte| {
            (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
    bytes[content..].copy_from_slice(&sum.to_le_bytes());
    bytes
}

#[test]
fn content_that_contradicts_itself_is_refused_whatever_its_checksum() {
    let mut simulation = fresh(&paper_drive(), &ForceLaws::default());
    advance(&mut simulation, 5e-3);
    let whole = bytes(&simulation);
    assert_eq!(sealed(whole.clone()), whole);
    let now = 5e-3_f64.to_le_bytes();
    let places: Vec<usize> = (0..whole.len() - 8)
        .filter(|&i| whole[i..i + 8] == now)
        .collect();
    let [place] = places[..] else {
        panic!("the present time is at {places:?}");
    };
    for wrong in [6e-3, f64::NAN, f64::NEG_INFINITY] {
        let mut bytes = whole.clone();
        bytes[place..place + 8].copy_from_slice(&wrong.to_le_bytes());
        let snapshot = Snapshot::from_bytes(&sealed(bytes)).unwrap();
        let message = refusal(&mut simulation, &snapshot);
        assert!(message.contains("is inconsistent"), "{message}");
    }
    // Lengths, numbers of pairs, gaps and orders are all over the content: none that is wrong may end in a panic.
    let mut refused = 0;
    for place in (20..whole.len() - 8).filter(|i| i % 7 == 0 || *i > whole.len() - 3000) {
        let mut bytes = whole.clone();
        bytes[place] ^= 0x15;
        let restored = Snapshot::from_bytes(&sealed(bytes))
            .and_then(|snapshot| simulation.clone().restore(&snapshot));
        refused += u32::from(restored.is_err());
    }
    assert!(refused > 0);
}

#[test]
fn a_run_with_the_implicit_corrector_goes_on_to_the_same_bits() {
    let (drive, laws) = (
        pulled(25.0),
        laws(Elastic::Hertz, Damping::LankaraniNikravesh, Regions::Kept),
    );
    let newton = StepControl {
        corrector: Corrector::Newton,
        ..StepControl::default()
    };
    let mut run = simulation(&drive, &laws, newton);
    for stop in [1e-3, 6e-3, 6.1e-3, 0.013] {
        advance(&mut run, stop);
        let snapshot = Snapshot::from_bytes(&bytes(&run)).unwrap();
        let mut other = simulation(&drive, &laws, newton);
        other.restore(&snapshot).unwrap();
        let mut same = run.clone();
        advance(&mut same, stop + 2e-3);
        advance(&mut other, stop + 2e-3);
        assert!(bytes(&same) == bytes(&other), "at {stop} s");
        let refused = fresh(&drive, &laws).restore(&snapshot).unwrap_err();
        assert!(refused.to_string().contains("Solver.method"), "{refused}");
    }
}

#[test]
fn a_mechanism_restored_from_bytes_goes_on_to_the_same_bits_and_its_energy_costs_no_bit() {
    use rustchain::multibody::MechanismGroups;

    let mechanism = bar_chain(3, 0.3);
    let all = MechanismGroups::ALL;
    let mut whole = mechanisms::simulation(&mechanism, 1e-8);
    let mut without = mechanisms::simulation(&mechanism, 1e-8);
    let energy = MechanismGroups {
        energy: false,
        ..all
    };
    for (run, groups) in [(&mut whole, all), (&mut without, energy)] {
        run.start_recording(0.1, 3e-3, groups);
        while !run.record(Duration::MAX).unwrap() {}
        run.take_recording();
    }
    assert_eq!(whole.velocities(), without.velocities());
    assert_eq!(without.counts(), whole.counts());
    let bytes = whole.snapshot().to_bytes().unwrap();
    let mut successor = mechanisms::simulation(&mechanism, 1e-8);
    successor
        .restore(&Snapshot::from_bytes(&bytes).unwrap())
        .unwrap();
    let mut rest = [&mut whole, &mut successor].map(|run| {
        run.start_recording(0.1, 3e-3, all);
        while !run.record(Duration::MAX).unwrap() {}
        run.take_recording()
    });
    let [first, second] = &mut rest;
    assert_eq!(first, second);
    let drive = <Snapshot>::from_bytes(&bytes).unwrap_err().to_string();
    assert!(drive.contains("state, kind = mechanism"), "{drive}");
}

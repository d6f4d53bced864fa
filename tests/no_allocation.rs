//! Steps, onsets and evaluations allocate nothing: all room is made when a run is set up.
#![allow(clippy::unwrap_used)]
#![allow(unsafe_code)] // a counting allocator has to be one

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::Arc;
use std::time::Duration;

use rustchain::drive::{Drive, HingeKind};
use rustchain::force_law::{Damping, Elastic, Regions};
use rustchain::geometry::Vec2;
use rustchain::integrator::{Corrector, OdeSystem, StepControl};
use rustchain::math::simd::InstructionSet;
use rustchain::multibody::{ContactLaw, ContactPair, Marker, MechanismModel, Profile, Tribology};
use rustchain::run::MechanismSimulation;
use rustchain::{ForceLaws, Groups};

use common::mechanisms;
use common::scenes::{Scene, geared_drive, laws};

/// Counts what this thread asks for.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    // No thread-local storage any more while a thread ends.
    let _ = ALLOCATIONS.try_with(|n| n.set(n.get() + 1));
}

// SAFETY: every call is handed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn the_counter_counts() {
    let before = ALLOCATIONS.get();
    let room = vec![0u8; 100];
    assert_eq!(ALLOCATIONS.get(), before + 1);
    drop(room);
}

/// Advance a drive from 5 to 15 ms with its energies; return steps, onsets and allocations of that time.
fn ten_milliseconds(drive: &Drive, laws: &ForceLaws, corrector: Corrector) -> (u64, u64, u64) {
    let control = StepControl {
        corrector,
        accuracy: 1e-11,
        ..StepControl::default()
    };
    let mut simulation = common::simulation(drive, laws, control);
    simulation.start_recording(
        1.0,
        1.0,
        Groups {
            energy: true,
            ..Groups::default()
        },
    );
    // Past the first report, which makes the room for its row.
    simulation.advance(5e-3, Duration::MAX).unwrap();
    let begun = simulation.statistics();
    let before = ALLOCATIONS.get();
    simulation.advance(15e-3, Duration::MAX).unwrap();
    let allocations = ALLOCATIONS.get() - before;
    let done = simulation.statistics();
    let steps = done.counts.steps - begun.counts.steps;
    (steps, done.onsets - begun.onsets, allocations)
}

const CORRECTORS: [Corrector; 3] = [Corrector::Pece, Corrector::Newton, Corrector::Auto];

#[test]
fn ten_milliseconds_with_hundreds_of_onsets_allocate_nothing() {
    for elastic in LAWS {
        for regions in [Regions::Kept, Regions::Sharp] {
            let laws = laws(elastic, Damping::LankaraniNikravesh, regions);
            for corrector in CORRECTORS {
                let (steps, onsets, allocations) =
                    ten_milliseconds(&common::paper_drive(), &laws, corrector);
                assert!(steps > 1000, "{elastic:?} {corrector:?}");
                assert!(onsets > 100, "{elastic:?}");
                assert_eq!(allocations, 0, "{elastic:?} {regions:?} {corrector:?}");
            }
        }
    }
}

#[test]
fn ten_milliseconds_with_ideal_hinges_allocate_nothing() {
    let drive = Drive {
        hinge_kind: HingeKind::Ideal,
        ..common::paper_drive()
    };
    for corrector in CORRECTORS {
        let (steps, onsets, allocations) =
            ten_milliseconds(&drive, &ForceLaws::default(), corrector);
        assert!(steps > 300 && onsets > 10, "{steps} {onsets} {corrector:?}");
        assert_eq!(allocations, 0, "{corrector:?}");
    }
}

/// One law of each form.
const LAWS: [Elastic; 4] = [
    Elastic::Hertz,
    Elastic::Johnson,
    Elastic::EnhancedCylinder,
    Elastic::LiuConformal,
];

#[test]
fn evaluations_that_choose_candidates_anew_allocate_nothing_whatever_the_instructions() {
    for elastic in LAWS {
        for damping in [Damping::None, Damping::LankaraniNikravesh] {
            for regions in [Regions::Kept, Regions::Sharp] {
                let drive = geared_drive([17, 25], 60, 20.0);
                let scene = Scene::laid(&drive, &laws(elastic, damping, regions));
                for set in InstructionSet::available() {
                    let (mut dynamics, _) = scene.ready(common::control(1e-5));
                    dynamics.use_instructions(set);
                    dynamics.keep_energy(true);
                    let mut y = scene.y();
                    let mut dydt = vec![0.0; y.len()];
                    let before = ALLOCATIONS.get();
                    for _ in 0..100 {
                        // All of the chain to one side, and back.
                        for x in [2e-3, 5e-3, -7e-3] {
                            y[..60].iter_mut().for_each(|place| *place += x);
                            dynamics.derivative(0.0, &y, &mut dydt);
                        }
                    }
                    assert_eq!(ALLOCATIONS.get() - before, 0, "{} {elastic:?}", set.name());
                    assert!(dynamics.candidate_refreshes() > 100);
                }
            }
        }
    }
}

#[test]
fn steps_with_onsets_and_new_candidates_allocate_nothing_whatever_the_instructions() {
    for elastic in LAWS {
        let laws = laws(elastic, Damping::LankaraniNikravesh, Regions::Kept);
        let scene = Scene::laid(&geared_drive([17, 17], 38, 100.0), &laws);
        for set in InstructionSet::available() {
            let (mut dynamics, mut adams) = scene.ready(common::control(1e-4));
            dynamics.use_instructions(set);
            let (mut allocations, mut begun) = (0, (0, 0));
            while adams.time() < 6e-3 {
                let before = ALLOCATIONS.get();
                dynamics.forget_ended_contacts();
                let step = adams.step(&mut dynamics).unwrap();
                dynamics.record_contact_events(&adams, &step);
                // The first contact past the end of its law is put into words, once.
                if dynamics.past_range().count() == begun.0 {
                    allocations += ALLOCATIONS.get() - before;
                }
                begun = (
                    dynamics.past_range().count(),
                    dynamics.memory.counts().onsets,
                );
            }
            let refreshes = dynamics.candidate_refreshes();
            assert_eq!(allocations, 0, "{} {elastic:?}", set.name());
            assert!(refreshes > 3 && begun.1 > 100, "{refreshes} {begun:?}");
        }
    }
}

#[test]
fn steps_of_a_mechanism_allocate_nothing_after_the_first() {
    // A hung chain, dense and sparse, whose last bar falls onto a floor.
    for (bars, corrector) in [
        (5, Corrector::Pece),
        (5, Corrector::Newton),
        (60, Corrector::Pece),
        (60, Corrector::Newton),
    ] {
        let mut mechanism = mechanisms::bar_chain(bars, 0.0);
        let floor = [(1e3, -0.02), (-1e3, -0.02)].map(|(x, y)| Vec2::new(x, y));
        mechanism.contacts.push(ContactPair {
            name: "floor".into(),
            a: mechanisms::ground(0.0, 0.0),
            b: Marker::new(format!("bar {}", bars - 1), 0.5, 0.0),
            profile: Profile::polyline("floor", &floor, false).unwrap(),
            radius: 0.01,
            law: ContactLaw::Linear {
                stiffness: 1e5,
                damping: 10.0,
            },
            tribology: Tribology::default(),
        });
        let control = StepControl {
            corrector,
            accuracy: 1e-7,
            ..StepControl::default()
        };
        let model = Arc::new(MechanismModel::compile(&mechanism).unwrap());
        let mut machine = MechanismSimulation::assemble(model, control).unwrap();
        machine.advance(5e-3, Duration::MAX).unwrap();
        let (begun, before) = (machine.counts().steps, ALLOCATIONS.get());
        machine.advance(0.08, Duration::MAX).unwrap();
        let allocations = ALLOCATIONS.get() - before;
        assert!(machine.counts().steps > begun + 50 && machine.statistics().onsets > 0);
        assert_eq!(allocations, 0, "{bars} {corrector:?}");
    }
}

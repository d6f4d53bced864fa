//! Instructions of one right-hand side and of one report, scene by scene, counted by valgrind's callgrind: what a scene lacks
//! costs nothing, to the instruction.
//!
//! Every count is the difference of two runs of this program under callgrind, with and without the calls, over their number.
//! Without valgrind there is nothing to count. Valgrind has no AVX-512: the counts are those of AVX2.

#![allow(clippy::unwrap_used)] // a benchmark whose scenes cannot be built has nothing to say
#![allow(clippy::print_stdout)] // its figures

mod common;

use std::hint::black_box;
use std::process::Command;
use std::time::Duration;

use aligned_vec::AVec;
use common::{Halves, drives, laws, longer_drive, only_tried, pressed_into_seats};
use rustchain::drive::{AnsiTooth, Bearing, Drive, SprocketMotion};
use rustchain::force_law::{Damping, Elastic, Friction, LuGre, Regions, Regularization};
use rustchain::geometry::Seat;
use rustchain::integrator::OdeSystem;
use rustchain::{ForceLaws, Groups, Simulation};

/// Calls that a count is taken over.
const CALLS: usize = 1000;

/// Makes a scene.
type Build = fn() -> Simulation;

/// A scene, and the one that it must not differ from by a single instruction.
struct Scene {
    name: &'static str,
    build: Build,
    absent: Option<(&'static str, Build)>,
}

const fn scene(name: &'static str, build: Build) -> Scene {
    Scene {
        name,
        build,
        absent: None,
    }
}

/// The paper's drive pressed into its seats, with one thing changed.
fn changed(change: impl Fn(&mut Drive, &mut ForceLaws)) -> Simulation {
    let mut drive = drives::paper_drive();
    let mut laws = laws(Elastic::Hertz, Damping::LankaraniNikravesh);
    change(&mut drive, &mut laws);
    pressed_into_seats(&drive, &laws)
}

fn elastic(elastic: Elastic, damping: Damping) -> Simulation {
    changed(|_, chosen| *chosen = laws(elastic, damping))
}

const ALL: Groups = Groups {
    hinges: true,
    teeth: true,
    sprockets: true,
    bodies: true,
    energy: true,
};

/// A recording begun, and ended when `ended`.
fn recorded(ended: bool) -> Simulation {
    let mut simulation = changed(|_, _| {});
    simulation.start_recording(1.0, 1e-4, ALL);
    if ended {
        simulation.take_recording();
        simulation.advance(0.0, Duration::MAX).unwrap();
    }
    simulation
}

const COULOMB: Friction = Friction {
    coefficient: 0.1,
    regularization: Regularization::Tanh,
    speed: 1e-3,
    dead_speed: 0.0,
};

const BRISTLES: LuGre = LuGre {
    static_coefficient: 0.12,
    kinetic_coefficient: 0.1,
    stiffness: 1e5,
    damping: 0.3,
    viscous_coefficient: 0.0,
    stribeck_speed: 1e-3,
    stribeck_exponent: 2.0,
};

const SCENES: [Scene; 21] = [
    scene("lankarani-nikravesh", || changed(|_, _| {})),
    Scene {
        name: "energy balance kept",
        build: || recorded(false),
        absent: Some(("switched off again", || recorded(true))),
    },
    Scene {
        name: "no damping, hertz",
        build: || elastic(Elastic::Hertz, Damping::None),
        absent: None,
    },
    Scene {
        name: "restitution 1",
        build: || changed(|drive, _| drive.chain.material.restitution = 1.0),
        absent: Some(("hertz, no damping", || {
            elastic(Elastic::Hertz, Damping::None)
        })),
    },
    scene("damping on hinges only", || {
        changed(|_, laws| laws.tooth.damping = Damping::None)
    }),
    scene("damping on teeth only", || {
        changed(|_, laws| laws.hinge.damping = Damping::None)
    }),
    scene("johnson, no damping", || {
        elastic(Elastic::Johnson, Damping::None)
    }),
    scene("enhanced cylinder", || {
        elastic(Elastic::EnhancedCylinder, Damping::LankaraniNikravesh)
    }),
    scene("sharp regions", || {
        changed(|_, laws| laws.tooth.regions = Regions::Sharp)
    }),
    scene("tensioner", || {
        changed(|drive, _| drive.tensioner = Some(drives::tensioner(25.0, 0.0)))
    }),
    scene("floating sprocket", || {
        changed(|drive, _| drive.sprockets[1].bearing = Bearing::Floating)
    }),
    Scene {
        name: "driver free to turn",
        build: || {
            changed(|drive, _| {
                drive.sprockets[0].motion = SprocketMotion::AppliedTorque(0.0.into());
            })
        },
        absent: Some(("no torque at all", || {
            changed(|drive, _| drive.sprockets[0].motion = SprocketMotion::Free)
        })),
    },
    scene("driver turned by a torque", || {
        changed(|drive, _| drive.sprockets[0].motion = SprocketMotion::AppliedTorque(0.2.into()))
    }),
    scene("other profile on the second", || {
        changed(|drive, _| {
            let profile = AnsiTooth {
                seat: Seat::PitchCircle,
                roller_diameter: Some(7.938e-3),
                ..AnsiTooth::default()
            };
            drive.sprockets[1].profile = profile.into();
        })
    }),
    scene("100 more strand links", || {
        changed(|drive, _| *drive = longer_drive([17, 17], 138))
    }),
    scene("the same, 33 teeth", || {
        changed(|drive, _| *drive = longer_drive([33, 33], 138))
    }),
    scene("friction in hinges", || {
        changed(|_, laws| laws.hinge_friction = Some(COULOMB))
    }),
    scene("friction on teeth", || {
        changed(|_, laws| laws.tooth_friction = Some(COULOMB))
    }),
    scene("bristles in hinges", || {
        changed(|_, laws| laws.hinge_bristles = Some(BRISTLES))
    }),
    scene("bristles on teeth", || {
        changed(|_, laws| laws.tooth_bristles = Some(BRISTLES))
    }),
    scene("nothing touches", || {
        common::at_start(Elastic::Hertz, Damping::LankaraniNikravesh)
    }),
];

/// The scenes whose differences give the cost of a hinge and of a candidate.
const LONG: &str = "100 more strand links";
const LARGE: &str = "the same, 33 teeth";

const NOTHING: Groups = Groups {
    hinges: false,
    teeth: false,
    sprockets: false,
    bodies: false,
    energy: false,
};

/// Channels of a report; with the driver turned by a torque where `true`.
const REPORTS: [(&str, Groups, bool); 8] = [
    ("nothing", NOTHING, false),
    (
        "bodies",
        Groups {
            bodies: true,
            ..NOTHING
        },
        false,
    ),
    (
        "sprockets",
        Groups {
            sprockets: true,
            ..NOTHING
        },
        false,
    ),
    (
        "sprockets, none of prescribed speed",
        Groups {
            sprockets: true,
            ..NOTHING
        },
        true,
    ),
    (
        "hinges",
        Groups {
            hinges: true,
            ..NOTHING
        },
        false,
    ),
    (
        "teeth",
        Groups {
            teeth: true,
            ..NOTHING
        },
        false,
    ),
    (
        "energy",
        Groups {
            energy: true,
            ..NOTHING
        },
        false,
    ),
    ("everything", ALL, false),
];

/// What this program does when it is run under callgrind.
enum Task {
    Call(Build),
    Report(Groups, bool),
}

/// The task of this name.
fn task(name: &str) -> Task {
    if let Some(name) = name.strip_prefix("report ") {
        let (_, groups, turned) = REPORTS.iter().find(|report| report.0 == name).unwrap();
        return Task::Report(*groups, *turned);
    }
    let all = SCENES
        .iter()
        .flat_map(|scene| [Some((scene.name, scene.build)), scene.absent]);
    Task::Call(all.flatten().find(|(n, _)| *n == name).unwrap().1)
}

fn perform(name: &str, calls: usize) {
    match task(name) {
        Task::Call(build) => call(&mut build(), calls),
        Task::Report(groups, turned) => report(groups, turned, calls),
    }
}

/// Evaluates the right-hand side once, which makes the lists of candidates, and `calls` times more.
fn call(simulation: &mut Simulation, calls: usize) {
    let Halves {
        mut dynamics,
        adams,
    } = Halves::of(simulation);
    // Copying takes an instruction more or less where an array does not begin at a cache line.
    let (t, y) = (adams.time(), AVec::<f64>::from_slice(64, adams.y()));
    let mut dydt = y.clone();
    for _ in 0..=calls {
        dynamics.derivative(black_box(t), black_box(&y), &mut dydt);
    }
}

/// Makes two reports and `reports` more inside one step.
fn report(groups: Groups, turned: bool, reports: usize) {
    let mut simulation = changed(|drive, _| {
        if turned {
            drive.sprockets[0].motion = SprocketMotion::AppliedTorque(0.2.into());
        }
    });
    simulation.advance(1e-12, Duration::MAX).unwrap();
    let inside = simulation.integrator().time() - simulation.time();
    let duration = 0.9 * inside;
    let report_step = duration / (reports + 1) as f64;
    simulation.start_recording(duration, report_step, groups);
    let steps = simulation.statistics().counts.steps;
    assert!(simulation.record(Duration::MAX).unwrap());
    assert_eq!(simulation.statistics().counts.steps, steps);
    assert_eq!(simulation.take_recording().time.len(), reports + 2);
}

/// Instructions of this program with a task; `None` without valgrind.
fn instructions_of_run(name: &str, calls: usize) -> Option<u64> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe().unwrap())
        .args(["--scene", name, "--calls", &calls.to_string()])
        .output()
        .ok()?;
    let messages = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{name}: {messages}");
    let total = messages.lines().find_map(|l| l.split("Collected :").nth(1));
    Some(total.unwrap().trim().parse().unwrap())
}

/// Instructions of one call; `None` without valgrind.
///
/// The two runs read their arguments in a few instructions more or less, far less than one a call: rounded away.
fn instructions(name: &str) -> Option<f64> {
    let without = instructions_of_run(name, 0)?;
    let with = instructions_of_run(name, CALLS)?;
    Some(((with - without) as f64 / CALLS as f64).round())
}

/// Hinges and candidates of a scene.
fn size(build: Build) -> (usize, usize) {
    let Halves {
        mut dynamics,
        adams,
    } = Halves::of(&mut build());
    let mut dydt = adams.y().to_vec();
    dynamics.derivative(adams.time(), adams.y(), &mut dydt);
    (dynamics.model().links, dynamics.candidates().count())
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let value = |name: &str| {
        let at = arguments.iter().position(|a| a == name)?;
        arguments.get(at + 1)
    };
    if let (Some(name), Some(calls)) = (value("--scene"), value("--calls")) {
        perform(name, calls.parse().unwrap());
        return;
    }
    if only_tried() {
        for scene in &SCENES {
            perform(scene.name, 1);
        }
        for (name, ..) in REPORTS {
            perform(&format!("report {name}"), 1);
        }
        return;
    }
    let Some(base) = instructions(SCENES[0].name) else {
        println!("instructions: no valgrind here, nothing counted");
        return;
    };
    right_hand_sides(base);
    reports();
}

/// The table of scenes, and what a hinge and a candidate cost.
fn right_hand_sides(base: f64) {
    println!(
        "instructions of one right-hand side, AVX2; the paper's drive with every hinge and seat pressed, and one thing changed\n"
    );
    println!(
        "{:<28}{:>7}{:>11}{:>9}{:>11}  where it is absent",
        "", "hinges", "candidates", "count", "difference"
    );
    let mut slopes = Vec::new();
    for scene in &SCENES {
        let count = instructions(scene.name).unwrap();
        let (hinges, candidates) = size(scene.build);
        print!(
            "{:<28}{hinges:>7}{candidates:>11}{count:>9.0}{:>+11.0}",
            scene.name,
            count - base
        );
        if scene.name == LONG || scene.name == LARGE {
            slopes.push((hinges as f64, candidates as f64, count));
        }
        let reference = match scene.name {
            "energy balance kept" => base,
            _ => count,
        };
        if let Some((name, _)) = scene.absent {
            let difference = instructions(name).unwrap() - reference;
            print!("  {name}: {difference:+.0}");
            assert!(difference == 0.0, "{name} costs {difference} instructions");
        }
        println!();
    }
    let (base_hinges, base_candidates) = size(SCENES[0].build);
    let [(hinges, candidates, long), (_, more, large)] = slopes[..] else {
        unreachable!("two scenes give the slopes")
    };
    let per_candidate = (large - long) / (more - candidates);
    let others = per_candidate * (candidates - base_candidates as f64);
    println!(
        "\na hinge {:.1}, a candidate {per_candidate:.1} instructions",
        (long - base - others) / (hinges - base_hinges as f64)
    );
}

/// The table of reports.
fn reports() {
    println!("\ninstructions of one report, by what is recorded\n");
    for (name, ..) in REPORTS {
        let count = instructions(&format!("report {name}")).unwrap();
        println!("{name:<38}{count:>9.0}");
    }
}

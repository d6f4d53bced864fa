//! What the benchmarks share: the paper's drive at rest in its start and under way, least times, and lines of counts.
#![allow(dead_code, unreachable_pub)] // each benchmark takes what it needs
#![allow(clippy::unwrap_used)] // a benchmark whose inputs cannot be built has nothing to say

#[path = "../../tests/common/mod.rs"]
pub mod drives;

use std::sync::Arc;
use std::time::{Duration, Instant};

use criterion::Criterion;
use rustchain::chain::dynamics::Dynamics;
use rustchain::drive::{AnsiTooth, Drive};
use rustchain::force_law::{Damping, Elastic, ForceLaw};
use rustchain::geometry::Vec2;
use rustchain::integrator::{Adams, Corrector, StepControl};
use rustchain::layout::{InitialConfiguration, closing_center_distance};
use rustchain::{ForceLaws, Model, Simulation};

/// One law of each form, as users know them.
pub const LAWS: [(&str, Elastic, Damping); 4] = [
    (
        "lankarani_nikravesh",
        Elastic::Hertz,
        Damping::LankaraniNikravesh,
    ),
    ("johnson", Elastic::Johnson, Damping::None),
    (
        "enhanced_cylinder",
        Elastic::EnhancedCylinder,
        Damping::LankaraniNikravesh,
    ),
    ("liu_conformal", Elastic::LiuConformal, Damping::Flores),
];

/// The time at which the drive is under way \[s\]: the first impacts are over, and up to 7 ms every machine sees one path.
pub const UNDER_WAY: f64 = 6e-3;

/// The paper's drive at its start, where nothing touches.
pub fn at_start(elastic: Elastic, damping: Damping) -> Simulation {
    at_start_of(&drives::paper_drive(), &laws(elastic, damping))
}

/// The paper's drive with the standard's seats, pulled into all of its hinges and seats at once, up to 1 um deep.
pub fn pressed(elastic: Elastic, damping: Damping) -> Simulation {
    pressed_into_seats(&drives::paper_drive(), &laws(elastic, damping))
}

/// One law for hinges and teeth.
pub fn laws(elastic: Elastic, damping: Damping) -> ForceLaws {
    let law = ForceLaw {
        elastic,
        damping,
        ..ForceLaw::default()
    };
    ForceLaws {
        hinge: law,
        tooth: law,
        ..ForceLaws::default()
    }
}

/// The paper's drive with other sprockets and another chain, its centres as far apart as makes the chain taut.
pub fn longer_drive(teeth: [u32; 2], links: u32) -> Drive {
    let mut drive = drives::paper_drive();
    drive.chain.links = links;
    let distance = closing_center_distance(drive.chain.pitch, teeth, links).unwrap();
    for (sprocket, teeth) in drive.sprockets.iter_mut().zip(teeth) {
        sprocket.teeth = teeth;
    }
    drive.sprockets[1].center = Vec2::new(distance, 0.0);
    drive
}

/// `drive` at its start, where nothing touches.
pub fn at_start_of(drive: &Drive, laws: &ForceLaws) -> Simulation {
    let (start, _) = InitialConfiguration::generate(drive).unwrap();
    from(drive, laws, &start)
}

/// `drive`, whose sprockets lie along x and are equal, with the standard's seats and pulled into all hinges and seats.
pub fn pressed_into_seats(drive: &Drive, laws: &ForceLaws) -> Simulation {
    let mut drive = drive.clone();
    for sprocket in &mut drive.sprockets {
        sprocket.profile = AnsiTooth::default().into();
    }
    let (mut start, _) = InitialConfiguration::generate(&drive).unwrap();
    let (links, sprockets) = start.positions.split_at_mut(drive.chain.links as usize);
    let (first, last) = (sprockets[0][0], sprockets[1][0]);
    for (i, link) in links.iter_mut().enumerate() {
        let from_axis = Vec2::new(link[0] - link[0].clamp(first, last), link[1]).normalize();
        // A seat is 1 um away and a hinge has 25 um of clearance.
        let shift = if i.is_multiple_of(2) {
            -1.5e-6
        } else {
            24.5e-6
        } * from_axis;
        link[0] += shift.x;
        link[1] += shift.y;
    }
    from(&drive, laws, &start)
}

fn from(drive: &Drive, laws: &ForceLaws, start: &InitialConfiguration) -> Simulation {
    let model = Arc::new(Model::compile(drive, laws, start).unwrap());
    Simulation::new(model, start, StepControl::default()).unwrap()
}

/// The same at [`UNDER_WAY`].
pub fn under_way(elastic: Elastic, damping: Damping) -> Simulation {
    let mut simulation = at_start(elastic, damping);
    while !simulation
        .advance(UNDER_WAY, Duration::from_secs(1))
        .unwrap()
    {}
    simulation
}

/// The paper's drive with this pretension \[N\] at 8 ms, when all of it has been applied, by the implicit corrector.
pub fn tensioned(pretension: f64) -> Simulation {
    let mut drive = drives::paper_drive();
    drive.tensioner = Some(drives::tensioner(pretension, 2e-3));
    let laws = laws(Elastic::Hertz, Damping::LankaraniNikravesh);
    let (start, _) = InitialConfiguration::generate(&drive).unwrap();
    let model = Arc::new(Model::compile(&drive, &laws, &start).unwrap());
    let control = StepControl {
        corrector: Corrector::Newton,
        ..StepControl::default()
    };
    let mut simulation = Simulation::new(model, &start, control).unwrap();
    while !simulation.advance(8e-3, Duration::from_secs(1)).unwrap() {}
    simulation
}

/// The two halves of a run, which meet in a step.
#[derive(Clone)]
pub struct Halves {
    /// Contacts, forces, accelerations.
    pub dynamics: Dynamics,
    /// The integrator.
    pub adams: Adams,
}

impl Halves {
    /// Those of `simulation`.
    pub fn of(simulation: &mut Simulation) -> Self {
        Self {
            adams: simulation.integrator().clone(),
            dynamics: simulation.present().clone(),
        }
    }

    /// One step, with the search for contacts that began in it.
    pub fn step(&mut self) {
        self.dynamics.forget_ended_contacts();
        let step = self.adams.step(&mut self.dynamics).unwrap();
        self.dynamics.record_contact_events(&self.adams, &step);
    }
}

/// Pairs tested and pairs in contact at the last evaluation, as words.
pub fn contacts(dynamics: &Dynamics) -> String {
    let touching = |penetrations: &[f64]| penetrations.iter().filter(|&&depth| depth > 0.0).count();
    format!(
        "{} hinges, {} in contact; {} bushings on sprockets, {} near, {} in contact",
        dynamics.evaluated.hinges.penetration.len(),
        touching(&dynamics.evaluated.hinges.penetration),
        dynamics.evaluated.teeth.penetration.len(),
        dynamics.evaluated.teeth.near.len(),
        touching(&dynamics.evaluated.teeth.penetration),
    )
}

/// Prints the counts that belong to a benchmark beside its time.
#[allow(clippy::print_stdout)] // where criterion prints the time
pub fn print_counts(benchmark: &str, counts: &str) {
    println!("{benchmark:<50}counts: {counts}");
}

/// Batches a competitor gets in [`race`], and calls in a batch.
#[derive(Clone, Copy)]
pub struct Effort {
    pub batches: usize,
    pub calls: usize,
}

impl Effort {
    /// This effort, or once each when the benchmarks are only tried (`--test`).
    pub fn or_once(self) -> Self {
        if only_tried() {
            Self {
                batches: 1,
                calls: 1,
            }
        } else {
            self
        }
    }
}

/// Whether the benchmarks are only tried, not measured.
pub fn only_tried() -> bool {
    std::env::args().any(|argument| argument == "--test")
}

/// Least times of one call of each competitor \[ns\].
///
/// On a machine that does other things too, the least is what the code takes when it is left alone; turns keep a slow moment
/// from meeting one competitor only.
pub fn race(effort: Effort, competitors: &mut [Box<dyn FnMut() + '_>]) -> Vec<f64> {
    let mut least = vec![f64::INFINITY; competitors.len()];
    for _ in 0..effort.batches {
        for (run, least) in competitors.iter_mut().zip(&mut least) {
            let begin = Instant::now();
            for _ in 0..effort.calls {
                run();
            }
            *least = least.min(begin.elapsed().as_secs_f64() / effort.calls as f64 * 1e9);
        }
    }
    least
}

/// Criterion as every benchmark here uses it.
pub fn criterion() -> Criterion {
    Criterion::default().without_plots().configure_from_args()
}

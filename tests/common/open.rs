//! Open chains that several tests use.

use std::sync::Arc;

use rustchain::drive::{ChainEnd, Drive, SprocketMotion};
use rustchain::geometry::Vec2;
use rustchain::geometry::path::belt::Side;
use rustchain::integrator::StepControl;
use rustchain::{Equilibrium, ForceLaws, Groups, Model, Simulation};

use super::layouts::{drive_of, sprocket};

/// A chain of so many links between these ends.
pub fn strand(links: u32, ends: [ChainEnd; 2]) -> Drive {
    let mut drive = drive_of(Vec::new(), links);
    drive.ends = Some(ends);
    drive
}

/// Over a wheel of 13 teeth: pinned on its left, so many links of the slack side, a load on its right.
pub fn hoist(links: u32, slack: u32, load: f64, motion: SprocketMotion) -> Drive {
    let mut drive = drive_of(vec![sprocket(13, 0.0, 0.0, Side::Inside, motion)], links);
    drive.ends = Some([
        ChainEnd::Anchored {
            position: Vec2::new(-0.12, -0.05),
            velocity: [0.0.into(), 0.0.into()],
            links: Some(slack),
        },
        ChainEnd::Loaded {
            mass: load,
            inertia: 1e-3 * load,
            arm: 0.05,
            position: None,
            links: None,
        },
    ]);
    drive
}

/// A run that begins at rest, and how well it rests.
pub fn at_rest(drive: &Drive, laws: &ForceLaws, control: StepControl) -> (Simulation, Equilibrium) {
    let rest = Equilibrium::find(drive, laws).unwrap();
    let model = Arc::new(Model::compile(drive, laws, &rest.start).unwrap());
    (Simulation::new(model, &rest.start, control).unwrap(), rest)
}

/// Channels of hinges, teeth and bodies in a run's first row.
pub fn first_row(simulation: &mut Simulation) -> rustchain::Recording {
    let groups = Groups {
        hinges: true,
        teeth: true,
        sprockets: true,
        bodies: true,
        energy: true,
    };
    super::record(simulation, 1e-9, 1e-9, groups)
}

/// Tension of every strand in a run's first row, of so many \[N\].
pub fn tensions(simulation: &mut Simulation, strands: usize) -> Vec<f64> {
    super::channel(&first_row(simulation), "strand_tension")[..strands].to_vec()
}

/// Between two pins over two wheels, of which a tensioner lifts the second one, free to turn.
pub fn tightened(tension: f64) -> Drive {
    let mut drive = drive_of(
        vec![
            sprocket(15, 0.1, 0.12, Side::Inside, SprocketMotion::Free),
            sprocket(17, 0.25, 0.12, Side::Inside, SprocketMotion::Free),
        ],
        44,
    );
    drive.ends = Some([(0.0, 0.0), (0.36, 0.0)].map(|(x, y)| ChainEnd::anchored(Vec2::new(x, y))));
    drive.tensioner = Some(super::tensioner(tension, 0.01));
    drive
}

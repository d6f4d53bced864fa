//! A drive and motions of its bodies, for unit tests.

use crate::chain::model::{ForceLaws, Model};
use crate::drive::{
    AnsiTooth, Bearing, Chain, ClearanceHinge, Drive, Faults, HingeKind, Link, Material, Roller,
    Sprocket, SprocketMotion, Tensioner, Variation,
};
use crate::geometry::path::belt::Side;
use crate::geometry::{Seat, Vec2};
use crate::integrator::{Adams, OdeSystem, StepControl};
use crate::layout::{InitialConfiguration, closing_center_distance};

/// Return an ANSI 40 chain of 40 links round a driving sprocket of 17 teeth and a free one of 21 teeth with eccentric teeth.
pub(crate) fn drive() -> Drive {
    let link = Link {
        mass: 7e-3,
        inertia: 1.5e-7,
    };
    let (pitch, teeth, links) = (0.0127, [17, 21], 40);
    let distance = closing_center_distance(pitch, teeth, links).unwrap();
    let sprocket = |k: usize, motion: SprocketMotion| Sprocket {
        teeth: teeth[k],
        center: Vec2::new(0.1 + k as f64 * (distance - 2e-4), 0.2),
        motion,
        profile: AnsiTooth {
            seat: Seat::PitchCircle,
            ..AnsiTooth::default()
        }
        .into(),
        faults: Faults {
            eccentricity: 5e-5 * k as f64,
            eccentricity_angle: 0.7,
            ..Faults::default()
        },
        mass: None,
        inertia: None,
        initial_speed: None,
        bearing: Bearing::Fixed,
        side: Side::Inside,
        load_inertia: 0.0,
    };
    Drive {
        chain: Chain {
            pitch,
            links,
            inner: link,
            outer: link,
            hinge: ClearanceHinge {
                pin_radius: 2.22e-3,
                bore_radius: 2.245e-3,
                length: 0.011,
            },
            bushing_radius: 3.97e-3,
            tooth_contact_length: 0.007,
            material: Material::default(),
            offset: None,
            strands: 1,
            variation: Variation::default(),
            roller: None,
            link_stiffness: None,
            carried: Vec::new(),
        },
        sprockets: vec![
            sprocket(0, SprocketMotion::PrescribedSpeed(12.0.into())),
            sprocket(1, SprocketMotion::Free),
        ],
        tensioner: None,
        gravity: Vec2::new(0.0, -9.81),
        guides: Vec::new(),
        ends: None,
        hinge_kind: HingeKind::Clearance,
    }
}

/// Return the drive with rollers that are bodies of their own.
pub(crate) fn with_rollers() -> Drive {
    let mut drive = drive();
    drive.chain.roller = Some(Roller {
        radius: drive.chain.bushing_radius,
        bore_radius: 2.848e-3,
        length: 7.9e-3,
        mass: 1.5e-3,
        inertia: 1.8e-8,
    });
    drive.chain.bushing_radius = 2.798e-3;
    drive
}

/// Return the drive with its second sprocket on a slide, or on an arm about `pivot` \[m\].
pub(super) fn with_tensioner(pivot: Option<Vec2>) -> Drive {
    let tensioner = Tensioner {
        sprocket: 2,
        pretension: 50.0,
        ramp_time: 0.0,
        damping: 100.0,
        damping_back: None,
        direction: pivot.is_none().then(|| Vec2::new(0.8, 0.6)),
        stiffness: 0.0,
        travel: [f64::INFINITY; 2],
        pivot,
        arm_inertia: if pivot.is_some() { 1e-4 } else { 0.0 },
        ratchet: None,
    };
    Drive {
        tensioner: Some(tensioner),
        ..drive()
    }
}

/// Return the model of a drive and its generated initial configuration.
pub(crate) fn compiled(drive: &Drive) -> (Model, InitialConfiguration) {
    let (start, _) = InitialConfiguration::generate(drive).unwrap();
    let model = Model::compile(drive, &ForceLaws::default(), &start).unwrap();
    (model, start)
}

/// Values that follow given functions of time: the motion of bodies without forces.
struct Given {
    amplitudes: Vec<f64>,
}

impl OdeSystem for Given {
    fn dimension(&self) -> usize {
        self.amplitudes.len()
    }

    fn derivative(&mut self, t: f64, _y: &[f64], dydt: &mut [f64]) {
        for (i, (rate, amplitude)) in dydt.iter_mut().zip(&self.amplitudes).enumerate() {
            *rate = amplitude * (200.0 * t + i as f64).cos();
        }
    }
}

/// Return an integrator after a few steps in which all coordinates and velocities move independently.
///
/// `start` has coordinates and velocities. Coordinates move by about a millimetre or milliradian in a step.
pub(super) fn moved(start: &[f64]) -> (Adams, [f64; 2]) {
    let amplitudes = (0..start.len()).map(|i| 1.0 + (i as f64).sin()).collect();
    let mut system = Given { amplitudes };
    let control = StepControl {
        rtol: 1e-6,
        atol: 1e-6,
        max_step: 1e-3,
        ..StepControl::default()
    };
    let mut adams = Adams::new(start.len(), control);
    adams.restart(0.3, start);
    let mut ends = [0.0; 2];
    for _ in 0..15 {
        let step = adams.step(&mut system).unwrap();
        ends = [step.start, step.end];
    }
    (adams, ends)
}

/// Return coordinates and velocities at the time `t` \[s\] of the last step.
pub(super) fn inside(adams: &Adams, t: f64, dimension: usize) -> Vec<f64> {
    let mut y = vec![0.0; dimension];
    if t == adams.time() {
        y.copy_from_slice(adams.y());
    } else {
        adams.interpolate(t, &mut y);
    }
    y
}

//! Drives, states and random numbers for the tests of the right-hand side.

use std::sync::Arc;

use rustchain::chain::contact::ContactId;
use rustchain::chain::dynamics::Dynamics;
use rustchain::chain::motion::Motion as Motions;
use rustchain::drive::{
    AnsiTooth, Bearing, Drive, IsoTooth, SprocketMotion, StraightTooth, Tip, ToothForm,
};
use rustchain::force_law::{Damping, Elastic, ForceLaw, Regions};
use rustchain::geometry::{Damage, Seat, Surface, Vec2, unit};
use rustchain::integrator::{Adams, StepControl};
use rustchain::layout::{InitialConfiguration, closing_center_distance};
use rustchain::math::Signal;
use rustchain::{ForceLaws, Model};

/// The paper's chain round sprockets of other sizes, the first one driven at `speed` \[rad/s\].
pub fn geared_drive(teeth: [u32; 2], links: u32, speed: impl Into<Signal>) -> Drive {
    let mut drive = super::paper_drive();
    drive.chain.links = links;
    let distance = closing_center_distance(drive.chain.pitch, teeth, links).unwrap();
    for (sprocket, teeth) in drive.sprockets.iter_mut().zip(teeth) {
        sprocket.teeth = teeth;
        sprocket.mass = None;
        sprocket.inertia = None;
    }
    drive.sprockets[1].center = Vec2::new(distance, 0.0);
    drive.sprockets[0].motion = SprocketMotion::PrescribedSpeed(speed.into());
    drive
}

/// Drives whose teeth are of other forms, not whole or not concentric, and whose links differ, by number.
pub const VARIED: usize = 6;

pub fn varied_drive(number: usize) -> Drive {
    let iso = |gap: f64| {
        ToothForm::Iso(IsoTooth {
            gap,
            seat: Seat::BottomDiameter,
            roller_diameter: None,
            tip_diameter: None,
            edge_radius: None,
        })
    };
    let cut = AnsiTooth {
        tip: Tip::Cut,
        ..AnsiTooth::default()
    };
    let straight = StraightTooth {
        flank_angle: 0.35,
        seat_radius: None,
        seat: Seat::PitchCircle,
        roller_diameter: None,
        tip_diameter: None,
        edge_radius: None,
    };
    let damage = |teeth: &[(u32, f64)]| {
        let one = |&(tooth, height): &(u32, f64)| Damage { tooth, height };
        teeth.iter().map(one).collect::<Vec<_>>()
    };
    let (teeth, links) = [
        ([17, 25], 60),
        ([17, 17], 38),
        ([13, 30], 62),
        ([17, 25], 60),
        ([17, 17], 39),
        ([12, 40], 71),
    ][number];
    let mut drive = geared_drive(teeth, links, 15.0);
    let [first, second] = &mut drive.sprockets[..] else {
        unreachable!()
    };
    match number {
        0 => (first.profile, second.profile) = (iso(0.0), iso(1.0)),
        1 => (first.profile, second.profile) = (cut.into(), ToothForm::Straight(straight)),
        2 => {
            (first.profile, second.profile) = (iso(0.5), cut.into());
            first.faults.damage = damage(&[(0, 0.0), (1, 0.4), (7, 0.4)]);
            second.faults.damage = damage(&[(29, 0.7), (3, 0.02)]);
        }
        3 => {
            second.profile = iso(0.3);
            for (i, sprocket) in [first, second].into_iter().enumerate() {
                sprocket.faults.eccentricity = 2e-5;
                sprocket.faults.eccentricity_angle = 1.0 + i as f64;
                sprocket.center -= 1e-4 * i as f64 * Vec2::new(1.0, 0.0);
            }
        }
        4 => drive.chain.strands = 3,
        _ => {
            drive.chain.variation.elongation = vec![0.004];
            drive.chain.variation.pitch_spread = 1e-4;
            drive.chain.variation.seed = 5;
            let pitch = drive.chain.mean_pitch();
            let distance = closing_center_distance(pitch, teeth, links).unwrap();
            drive.sprockets[1].center.x = distance - 5e-5;
        }
    }
    drive
}

/// One law for hinges and teeth.
pub fn laws(elastic: Elastic, damping: Damping, regions: Regions) -> ForceLaws {
    let law = ForceLaw {
        elastic,
        damping,
        regions,
    };
    ForceLaws {
        hinge: law,
        tooth: law,
        ..ForceLaws::default()
    }
}

/// A model and a state of it.
#[derive(Debug, Clone)]
pub struct Scene {
    pub model: Arc<Model>,
    pub motion: Motions,
}

impl Scene {
    /// The drive as it is laid.
    pub fn laid(drive: &Drive, laws: &ForceLaws) -> Self {
        Self::of(
            drive,
            laws,
            &InitialConfiguration::generate(drive).unwrap().0,
        )
    }

    /// A closed ring of few links, seated all round one sprocket of as many teeth and beside another, floating one.
    pub fn ring(links: u32, laws: &ForceLaws) -> Self {
        let mut drive = geared_drive([links.max(5), 7], 38, 12.0);
        drive.chain.links = links;
        drive.sprockets[1].bearing = Bearing::Floating;
        let n = f64::from(links);
        let turn = 2.0 * std::f64::consts::PI / n;
        let apothem = 0.5 * drive.chain.pitch / (0.5 * turn).tan();
        let link = |i: u32| {
            let angle = turn * f64::from(i);
            let center = apothem * unit(angle);
            [center.x, center.y, angle + 0.5 * std::f64::consts::PI]
        };
        let mut positions: Vec<[f64; 3]> = (0..links).map(link).collect();
        positions.push([0.0, 0.0, 0.5 * turn]);
        positions.push([1.5 * drive.chain.pitch, 0.0, 0.1]);
        let start = InitialConfiguration {
            velocities: vec![[0.0; 3]; positions.len()],
            positions,
            ..InitialConfiguration::default()
        };
        Self::of(&drive, laws, &start)
    }

    fn of(drive: &Drive, laws: &ForceLaws, start: &InitialConfiguration) -> Self {
        let model = Arc::new(Model::compile(drive, laws, start).unwrap());
        let mut motion = Motions::new(model.bodies());
        motion.set(&start.positions, &start.velocities);
        Self { model, motion }
    }

    /// Number of y.
    pub fn dimension(&self) -> usize {
        2 * self.model.coordinates
    }

    /// The state.
    pub fn y(&self) -> Vec<f64> {
        let mut y = vec![0.0; self.dimension()];
        self.motion.write(&self.model, &mut y);
        y
    }

    /// Shakes every body by up to `shake` \[m\], and links' ends by as much against one another; velocities up to `speed` \[m/s\].
    pub fn shake(&mut self, noise: &mut Noise, shake: f64, speed: f64) {
        let (motion, p) = (&mut self.motion, 2.0 * self.model.half_pitch);
        for i in 0..motion.x.len() {
            motion.x[i] += shake * noise.sign();
            motion.y[i] += shake * noise.sign();
            motion.angle[i] += shake / p * noise.sign();
            motion.vx[i] += speed * noise.sign();
            motion.vy[i] += speed * noise.sign();
            motion.spin[i] += speed / p * noise.sign();
        }
    }

    /// Its dynamics, in which a `share` of hinges and of pairs of bushing and sprocket have a memory.
    pub fn remembering(&self, noise: &mut Noise, share: f64) -> Dynamics {
        let mut dynamics = Dynamics::new(Arc::clone(&self.model));
        let n = self.model.links;
        for k in 0..n {
            if noise.share() < share {
                dynamics.memory.begin(ContactId::Hinge(k), noise.share());
            }
        }
        for pair in 0..n * self.model.sprockets.len() {
            if noise.share() < share {
                let profile = &self.model.sprockets[pair / n].profile;
                let count = profile.surfaces().len() as u64;
                let surface = Surface(u8::try_from(noise.next() % count).unwrap());
                dynamics.memory.begin_tooth(pair, noise.share(), surface);
            }
        }
        for k in 0..self.model.roller_count() {
            if noise.share() < share {
                dynamics.memory.begin(ContactId::Roller(k), noise.share());
            }
        }
        dynamics
    }

    /// Its dynamics and an integrator at the start, as a run has them.
    pub fn ready(&self, control: StepControl) -> (Dynamics, Adams) {
        let mut dynamics = Dynamics::new(Arc::clone(&self.model));
        let y = self.y();
        dynamics.remember_present_contacts(0.0, &y);
        let mut adams = Adams::new(self.dimension(), control);
        adams.restart(0.0, &y);
        adams.limit_step(dynamics.longest_step_past_teeth());
        (dynamics, adams)
    }
}

/// Random numbers that are the same everywhere (`SplitMix64`).
pub struct Noise(pub u64);

impl Noise {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Between 0 and 1.
    pub fn share(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Between -1 and 1.
    pub fn sign(&mut self) -> f64 {
        2.0 * self.share() - 1.0
    }
}

//! Mechanisms with published or closed-form answers, shared by tests.

use std::sync::Arc;
use std::time::Duration;

use rustchain::Recording;
use rustchain::geometry::Vec2;
use rustchain::integrator::StepControl;
use rustchain::math::Signal;
use rustchain::multibody::{
    Body, ForceElement, ForceKind, Joint, JointKind, Marker, Mechanism, MechanismGroups,
    MechanismModel, PrescribedMotion, SpringLaw,
};
use rustchain::run::MechanismSimulation;

pub const GRAVITY: f64 = 9.81;

pub fn ground(x: f64, y: f64) -> Marker {
    Marker::new("ground", x, y)
}

pub fn revolute(name: &str, a: Marker, b: Marker) -> Joint {
    Joint::new(name, a, b, JointKind::Revolute)
}

/// Tolerances of `tolerance` and no limit of the step but `max_step`.
pub fn control(tolerance: f64, max_step: f64) -> StepControl {
    StepControl {
        rtol: tolerance,
        atol: tolerance,
        max_step,
        ..StepControl::default()
    }
}

pub fn simulation(mechanism: &Mechanism, tolerance: f64) -> MechanismSimulation {
    let model = Arc::new(MechanismModel::compile(mechanism).expect("a sound mechanism"));
    MechanismSimulation::assemble(model, control(tolerance, 0.05)).expect("joints that go together")
}

pub fn record(simulation: &mut MechanismSimulation, duration: f64, report_step: f64) -> Recording {
    simulation.start_recording(duration, report_step, MechanismGroups::ALL);
    while !simulation.record(Duration::MAX).expect("a run to its end") {}
    simulation.take_recording()
}

/// Rows of a recording, one after another.
pub trait Rows {
    fn positions(&self) -> &[f64];
    fn velocities(&self) -> &[f64];
    fn accelerations(&self) -> &[f64];
    fn reactions(&self) -> &[f64];
    fn contact_force(&self) -> &[f64];
    fn peak_contact_force(&self) -> &[f64];
    /// Kinetic, gravity, elastic, dissipated, external work, residual.
    fn energy(&self) -> Vec<f64>;
}

impl Rows for Recording {
    fn positions(&self) -> &[f64] {
        self.real("positions")
    }

    fn velocities(&self) -> &[f64] {
        self.real("velocities")
    }

    fn accelerations(&self) -> &[f64] {
        self.real("accelerations")
    }

    fn reactions(&self) -> &[f64] {
        self.real("joint_reaction")
    }

    fn contact_force(&self) -> &[f64] {
        self.real("contact_force")
    }

    fn peak_contact_force(&self) -> &[f64] {
        self.real("peak_contact_force")
    }

    fn energy(&self) -> Vec<f64> {
        let columns = [
            "energy_kinetic",
            "energy_gravity",
            "energy_elastic",
            "energy_dissipated",
            "energy_external_work",
            "energy_residual",
        ]
        .map(|name| self.real(name));
        (0..self.time.len())
            .flat_map(|row| columns.map(|column| column[row]))
            .collect()
    }
}

/// A rod of length `l` between two points, a uniform bar.
pub fn bar(name: &str, from: Vec2, to: Vec2, mass: f64) -> Body {
    let (middle, d) = (0.5 * (from + to), to - from);
    let inertia = mass * d.norm_squared() / 12.0;
    Body::new(name, mass, inertia).at(middle.x, middle.y, d.y.atan2(d.x))
}

/// A chain of `count` uniform bars of 1 m hanging from the origin, laid out at `angle` from the x axis.
pub fn bar_chain(count: usize, angle: f64) -> Mechanism {
    let step = Vec2::new(angle.cos(), angle.sin());
    let mut mechanism = Mechanism {
        gravity: Vec2::new(0.0, -GRAVITY),
        ..Mechanism::default()
    };
    for k in 0..count {
        let name = format!("bar {k}");
        let from = step * k as f64;
        mechanism.bodies.push(bar(&name, from, from + step, 1.0));
        let before = if k == 0 {
            ground(0.0, 0.0)
        } else {
            Marker::new(format!("bar {}", k - 1), 0.5, 0.0)
        };
        let joint = revolute(&format!("hinge {k}"), before, Marker::new(name, -0.5, 0.0));
        mechanism.joints.push(joint);
    }
    mechanism
}

/// A row of `windows` parallelograms of uniform bars, 1 m and 1 kg each, standing, its top moving at 1 m/s: every
/// quarter of a turn all bars lie in one line, where the joints lose their rank.
pub fn four_bars(windows: usize) -> Mechanism {
    let mut mechanism = Mechanism {
        gravity: Vec2::new(0.0, -GRAVITY),
        ..Mechanism::default()
    };
    for k in 0..=windows {
        let x = k as f64;
        let name = format!("post {k}");
        let post = bar(&name, Vec2::new(x, 0.0), Vec2::new(x, 1.0), 1.0).moving(0.5, 0.0, -1.0);
        mechanism.bodies.push(post);
        let foot = Marker::new(name.clone(), -0.5, 0.0);
        mechanism
            .joints
            .push(revolute(&format!("foot {k}"), ground(x, 0.0), foot));
        if k > 0 {
            let coupler = format!("coupler {k}");
            let top = bar(&coupler, Vec2::new(x - 1.0, 1.0), Vec2::new(x, 1.0), 1.0);
            mechanism.bodies.push(top.moving(1.0, 0.0, 0.0));
            for (side, post) in [(-0.5, k - 1), (0.5, k)] {
                mechanism.joints.push(revolute(
                    &format!("coupler {k} on post {post}"),
                    Marker::new(format!("post {post}"), 0.5, 0.0),
                    Marker::new(coupler.clone(), side, 0.0),
                ));
            }
        }
    }
    mechanism
}

pub const CRANK: f64 = 0.05;
pub const ROD: f64 = 0.12;

/// A crank driven at a constant speed \[rad/s\], a rod and a slider on the x axis; without gravity.
pub fn slider_crank(speed: f64) -> Mechanism {
    let (pin, slider) = (Vec2::new(CRANK, 0.0), Vec2::new(CRANK + ROD, 0.0));
    let mut crank = bar("crank", Vec2::zeros(), pin, 0.3);
    crank = crank.moving(0.0, 0.5 * CRANK * speed, speed);
    let rod = bar("rod", pin, slider, 0.21);
    let rod_spin = -speed * CRANK / ROD;
    let rod = rod.moving(0.0, 0.5 * CRANK * speed, rod_spin);
    let block = Body::new("slider", 0.14, 1e-4).at(slider.x, 0.0, 0.0);
    let along = JointKind::Prismatic {
        direction: Vec2::new(1.0, 0.0),
        angle: None,
    };
    let motor = JointKind::DrivenAngle(PrescribedMotion::Speed(Signal::Constant(speed)));
    Mechanism {
        gravity: Vec2::zeros(),
        bodies: vec![crank, rod, block],
        joints: vec![
            revolute(
                "bearing",
                ground(0.0, 0.0),
                Marker::new("crank", -0.5 * CRANK, 0.0),
            ),
            revolute(
                "crank pin",
                Marker::new("crank", 0.5 * CRANK, 0.0),
                Marker::new("rod", -0.5 * ROD, 0.0),
            ),
            revolute(
                "wrist pin",
                Marker::new("rod", 0.5 * ROD, 0.0),
                Marker::new("slider", 0.0, 0.0),
            ),
            Joint::new(
                "guide",
                ground(0.0, 0.0),
                Marker::new("slider", 0.0, 0.0),
                along,
            ),
            Joint::new(
                "motor",
                ground(0.0, 0.0),
                Marker::new("crank", 0.0, 0.0),
                motor,
            ),
        ],
        ..Mechanism::default()
    }
}

/// The angles of Andrews' squeezing mechanism at the start: β, Θ, γ, Φ, δ, Ω, ε \[rad\].
pub const ANDREWS_START: [f64; 7] = [
    -0.061_713_890_014_276_45,
    0.0,
    0.455_279_819_163_070_4,
    0.222_668_390_165_885_88,
    0.487_364_979_543_842_56,
    -0.222_668_390_165_885_88,
    1.230_547_444_549_821_2,
];

/// The same at 0.03 s, of the test set for initial value problem solvers.
pub const ANDREWS_END: [f64; 7] = [
    15.810_771_196_299_04,
    -15.756_371_059_842_98,
    0.040_822_240_130_731_01,
    -0.534_730_116_322_694_8,
    0.524_409_965_880_530_4,
    0.534_730_116_322_694_8,
    1.048_080_741_042_263,
];

/// Angles of the seven bodies from those of the problem, which are taken between neighbours.
pub fn andrews_angles([beta, theta, gamma, phi, delta, omega, epsilon]: [f64; 7]) -> [f64; 7] {
    [
        beta,
        beta + theta,
        gamma,
        phi + delta,
        delta,
        omega + epsilon,
        epsilon,
    ]
}

/// Andrews' squeezing mechanism (Schiehlen 1990; Hairer and Wanner 1996): seven bodies, a spring, a constant torque.
pub fn andrews() -> Mechanism {
    let [a1, a2, a3, a4, a5, a6, a7] = andrews_angles(ANDREWS_START);
    let (fixed_a, fixed_b, fixed_c) = ((-0.06934, -0.00227), (-0.03635, 0.03273), (0.014, 0.072));
    // Points in each body's frame, its origin at the centre of mass; K1 and K2 have their x axis along the bar,
    // K3 to K7 as the problem measures their angles.
    let crank_pin = (7e-3 - 92e-5, 0.0);
    let joint = |name: &str, a: (&str, f64, f64), b: (&str, f64, f64)| {
        revolute(name, Marker::new(a.0, a.1, a.2), Marker::new(b.0, b.1, b.2))
    };
    // K2: from the crank pin towards the common point E at -x.
    let (k2_pin, k2_end) = ((115e-4, 0.0), (115e-4 - 28e-3, 0.0));
    // K3: centre at B + sa (sin γ, -cos γ) + sb (cos γ, sin γ).
    let k3 = |x: f64, y: f64| (x - 1043e-5, y + 1874e-5);
    let (k3_b, k3_e, k3_d) = (k3(0.0, 0.0), k3(0.0, -35e-3), k3(2e-2, -18e-3));
    // K4 reaches from the end of K5 to E along -y.
    let (k4_end, k4_e) = ((0.0, 579e-5), (0.0, -1421e-5));
    let (k5_a, k5_end) = ((-2308e-5, -916e-5), (4e-2 - 2308e-5, -916e-5));
    // K6 likewise along x, on the end of K7.
    let (k6_end, k6_e) = ((-579e-5, 0.0), (1421e-5, 0.0));
    let k7 = |x: f64, y: f64| (x + 449e-5, y + 1228e-5);
    let (k7_a, k7_end) = (k7(0.0, 0.0), k7(0.0, -4e-2));
    let masses = [
        0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498,
    ];
    let inertias = [
        2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5,
    ];
    let (sin, cos) = (f64::sin, f64::cos);
    let centers = [
        (92e-5 * cos(a1), 92e-5 * sin(a1)),
        (
            7e-3 * cos(a1) - 115e-4 * cos(a2),
            7e-3 * sin(a1) - 115e-4 * sin(a2),
        ),
        (
            fixed_b.0 + 1874e-5 * sin(a3) + 1043e-5 * cos(a3),
            fixed_b.1 - 1874e-5 * cos(a3) + 1043e-5 * sin(a3),
        ),
        (
            fixed_a.0 + 4e-2 * cos(a5) + 579e-5 * sin(a4),
            fixed_a.1 + 4e-2 * sin(a5) - 579e-5 * cos(a4),
        ),
        (
            fixed_a.0 + 2308e-5 * cos(a5) - 916e-5 * sin(a5),
            fixed_a.1 + 2308e-5 * sin(a5) + 916e-5 * cos(a5),
        ),
        (
            fixed_a.0 + 4e-2 * sin(a7) + 579e-5 * cos(a6),
            fixed_a.1 - 4e-2 * cos(a7) + 579e-5 * sin(a6),
        ),
        (
            fixed_a.0 + 1228e-5 * sin(a7) - 449e-5 * cos(a7),
            fixed_a.1 - 1228e-5 * cos(a7) - 449e-5 * sin(a7),
        ),
    ];
    let angles = [a1, a2, a3, a4, a5, a6, a7];
    let body = |i: usize| {
        Body::new(format!("K{}", i + 1), masses[i], inertias[i]).at(
            centers[i].0,
            centers[i].1,
            angles[i],
        )
    };
    let at = |body: &'static str, (x, y): (f64, f64)| (body, x, y);
    let spring = ForceKind::Spring {
        law: SpringLaw::linear(4530.0, 0.0),
        rest: Some(7785e-5),
    };
    Mechanism {
        gravity: Vec2::zeros(),
        bodies: (0..7).map(body).collect(),
        joints: vec![
            joint("O", ("ground", 0.0, 0.0), ("K1", -92e-5, 0.0)),
            joint("F", at("K1", crank_pin), at("K2", k2_pin)),
            joint("E3", at("K2", k2_end), at("K3", k3_e)),
            joint("E4", at("K2", k2_end), at("K4", k4_e)),
            joint("E6", at("K2", k2_end), at("K6", k6_e)),
            joint("B", at("ground", fixed_b), at("K3", k3_b)),
            joint("G", at("K4", k4_end), at("K5", k5_end)),
            joint("A5", at("ground", fixed_a), at("K5", k5_a)),
            joint("H", at("K6", k6_end), at("K7", k7_end)),
            joint("A7", at("ground", fixed_a), at("K7", k7_a)),
        ],
        forces: vec![
            ForceElement::new(
                "spring",
                Marker::new("ground", fixed_c.0, fixed_c.1),
                Marker::new("K3", k3_d.0, k3_d.1),
                spring,
            ),
            ForceElement::new(
                "torque",
                Marker::new("ground", 0.0, 0.0),
                Marker::new("K1", 0.0, 0.0),
                ForceKind::Torque(Signal::Constant(0.033)),
            ),
        ],
        ..Mechanism::default()
    }
}

pub fn run_to(simulation: &mut MechanismSimulation, t: f64) {
    while !simulation
        .advance(t, Duration::MAX)
        .expect("a run to its end")
    {}
}

//! One mass against one pair of surfaces: what the force laws do through a whole impact, and single values of them.

use rustchain::force_law::{
    Damping, Elastic, ElasticPair, SurfacePair, damping_factor, effective_restitution,
};
use rustchain::geometry::Contact;
use rustchain::geometry::Vec2;
use rustchain::integrator::event_location::onset_in_step;
use rustchain::integrator::{Adams, OdeSystem, StepControl};

/// E* \[Pa\] of steel on steel, E = 2.07e11 Pa and ν = 0.3.
const STEEL: f64 = 2.07e11 / 1.82;

fn pin_in_bushing() -> SurfacePair {
    SurfacePair::internal(2.22e-3, 2.245e-3, 0.011, STEEL)
}

fn bushing_on_tip() -> SurfacePair {
    SurfacePair::external(3.968_75e-3, 6.582_621e-3, 0.007, STEEL)
}

fn bushing_on_flat() -> SurfacePair {
    SurfacePair::flat(3.968_75e-3, 6.582_621e-3, 0.007, STEEL)
}

/// Radii of 17 teeth for half-inch pitch: ΔR is 6.407944 mm.
fn bushing_on_working_curve() -> SurfacePair {
    SurfacePair::internal(3.968_75e-3, 10.376_694e-3, 0.007, STEEL)
}

/// All elastic laws, the linear one with the stiffness of a pin's seat.
fn laws() -> impl Iterator<Item = Elastic> {
    Elastic::ALL.into_iter().chain([Elastic::Linear(3e8)])
}

/// A mass that flies at a surface at speed one over a short gap: y = [penetration, its rate], in units of `depth` and `speed`.
struct Impact {
    pair: ElasticPair,
    lambda: f64,
    mass: f64,
    /// Speed \[m/s\] that the unit of velocity stands for.
    speed: f64,
    /// Penetration \[m\] that the unit of length stands for: where all of the kinetic energy is stored when nothing is lost.
    depth: f64,
    /// Approach speed at onset \[m/s\], once it is known.
    onset_speed: Option<f64>,
}

impl Impact {
    fn new(law: Elastic, surfaces: &SurfacePair, lambda: f64, mass: f64, speed: f64) -> Self {
        let pair = ElasticPair::prepare(law, surfaces);
        let energy = 0.5 * mass * speed * speed;
        let (mut low, mut high) = (0.0, 1e-3);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if pair.energy(middle) < energy {
                low = middle;
            } else {
                high = middle;
            }
        }
        Self {
            pair,
            lambda,
            mass,
            speed,
            depth: high,
            onset_speed: None,
        }
    }

    fn force(&self, penetration: f64, rate: f64) -> f64 {
        let onset_speed = self
            .onset_speed
            .unwrap_or_else(|| rate.max(1e-3 * self.speed));
        self.pair.force(penetration) * damping_factor(self.lambda, rate, onset_speed)
    }
}

impl OdeSystem for Impact {
    fn dimension(&self) -> usize {
        2
    }

    fn derivative(&mut self, _t: f64, y: &[f64], dydt: &mut [f64]) {
        dydt[0] = y[1];
        dydt[1] = -self.force(self.depth * y[0], self.speed * y[1]) * self.depth
            / (self.mass * self.speed * self.speed);
    }
}

/// What came of an impact.
struct Bounce {
    /// Speed of parting over speed of approach.
    restitution: f64,
    /// Time in contact \[s\].
    duration: f64,
    /// Deepest penetration \[m\].
    depth: f64,
    /// Least force in the course of the impact, at the ends of the steps \[N\].
    least_force: f64,
}

fn bounce(mut impact: Impact) -> Bounce {
    let control = StepControl {
        rtol: 1e-12,
        atol: 1e-12,
        max_step: 0.1,
        max_order: 12,
        ..StepControl::default()
    };
    let mut adams = Adams::new(2, control);
    adams.restart(0.0, &[-0.05, 1.0]);
    let (mut began, mut deepest, mut least_force) = (0.0, 0.0, f64::INFINITY);
    loop {
        let (was_inside, was_approaching) = (adams.y()[0] > 0.0, adams.y()[1] > 0.0);
        let step = adams.step(&mut impact).unwrap();
        let (y, adams) = (adams.y(), &adams);
        // When the surfaces met (sign 1) or parted (sign -1) in this step, and how fast.
        let crossing = |sign: f64| {
            let path = move |t: f64| {
                let at = adams.dense(t);
                Contact {
                    normal: Vec2::zeros(),
                    penetration: sign * at.value(0),
                    penetration_rate: sign * at.value(1),
                }
            };
            onset_in_step(path, step.start, step.end)
        };
        if !was_inside && y[0] > 0.0 {
            let (time, rate) = crossing(1.0);
            began = time;
            impact.onset_speed = Some(rate * impact.speed);
        }
        if was_approaching && y[1] <= 0.0 {
            let (mut low, mut high) = (step.start, step.end);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if adams.dense(middle).value(1) > 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            deepest = adams.dense(high).value(0);
        }
        if was_inside && y[0] <= 0.0 {
            let (time, rate) = crossing(-1.0);
            return Bounce {
                restitution: rate,
                duration: (time - began) * impact.depth / impact.speed,
                depth: deepest * impact.depth,
                least_force,
            };
        }
        if y[0] > 0.0 {
            least_force = least_force.min(impact.force(impact.depth * y[0], impact.speed * y[1]));
        }
    }
}

/// What an impact may be off by, relatively: integrated to 1e-12 it takes some tens of steps, and in the step of the onset the
/// damping does not know its speed yet. Measured: 3e-10 at most.
const CLOSE: f64 = 1e-9;

/// Masses \[kg\] and speeds \[m/s\] from a light link that creeps to a heavy body that hammers.
const CASES: [(f64, f64); 5] = [
    (1e-3, 1e-3),
    (7e-3, 0.05),
    (7e-3, 0.5),
    (7e-3, 3.0),
    (0.8, 0.2),
];

#[test]
fn lankarani_nikravesh_gives_back_the_restitution_of_its_equation() {
    for restitution in [0.1, 0.3, 0.5, 0.71, 0.9, 0.99] {
        let lambda = Damping::LankaraniNikravesh.lambda(restitution);
        let expected = effective_restitution(lambda);
        for surfaces in [
            pin_in_bushing(),
            bushing_on_working_curve(),
            bushing_on_flat(),
        ] {
            for (mass, speed) in CASES {
                let got =
                    bounce(Impact::new(Elastic::Hertz, &surfaces, lambda, mass, speed)).restitution;
                assert!(
                    (got - expected).abs() <= CLOSE,
                    "c_e {restitution}, {mass} kg, {speed} m/s: {got}"
                );
            }
        }
    }
}

#[test]
fn the_damping_gives_the_same_restitution_with_every_elastic_law() {
    let lambda = Damping::LankaraniNikravesh.lambda(0.71);
    let expected = effective_restitution(lambda);
    assert!((expected - 0.8005).abs() < 5e-5);
    for (mass, speed) in CASES {
        for surfaces in [pin_in_bushing(), bushing_on_tip()] {
            for elastic in laws() {
                let got = bounce(Impact::new(elastic, &surfaces, lambda, mass, speed)).restitution;
                assert!(
                    (got - expected).abs() <= CLOSE,
                    "{elastic:?}, {mass} kg, {speed} m/s: {got}"
                );
            }
        }
    }
}

#[test]
fn every_damping_gives_the_restitution_that_is_told_of_it() {
    for damping in Damping::ALL {
        for asked in [0.1, 0.3, 0.5, 0.71, 0.9, 0.99] {
            let lambda = damping.lambda(asked);
            let expected = effective_restitution(lambda);
            for elastic in [Elastic::Hertz, Elastic::LiuConformal] {
                let got =
                    bounce(Impact::new(elastic, &pin_in_bushing(), lambda, 0.01, 0.5)).restitution;
                assert!(
                    (got - expected).abs() <= CLOSE,
                    "{damping:?} {elastic:?}, c_e {asked}: {got}, not {expected}"
                );
            }
        }
    }
}

/// Asserts that an undamped impact gives back its speed and goes as deep as its energy allows.
fn assert_elastic(law: Elastic, surfaces: &SurfacePair) {
    for (mass, speed) in CASES {
        let impact = Impact::new(law, surfaces, 0.0, mass, speed);
        let depth = impact.depth;
        let bounce = bounce(impact);
        assert!(
            (bounce.restitution - 1.0).abs() <= CLOSE,
            "{mass} kg, {speed} m/s: {}",
            bounce.restitution
        );
        assert!(
            (bounce.depth / depth - 1.0).abs() <= CLOSE,
            "{mass} kg, {speed} m/s: {}",
            bounce.depth
        );
    }
}

#[test]
fn an_undamped_impact_keeps_its_energy() {
    for surfaces in [
        pin_in_bushing(),
        bushing_on_tip(),
        bushing_on_working_curve(),
        bushing_on_flat(),
    ] {
        for law in laws() {
            assert_elastic(law, &surfaces);
        }
    }
}

#[test]
fn an_undamped_impact_lasts_as_hertz_says() {
    // m δ'² = m v² - (4/5) K δ^2.5: depth (5 m v²/(4 K))^0.4, duration 2 δ/v times the integral of 1/sqrt(1 - u^2.5) over
    // 0..1, that is sqrt(π) Γ(7/5)/Γ(9/10).
    const TWICE_THE_INTEGRAL: f64 = 2.943_275_184_324_703;
    for surfaces in [pin_in_bushing(), bushing_on_tip()] {
        let stiffness = ElasticPair::prepare(Elastic::Hertz, &surfaces).force(1.0);
        for (mass, speed) in CASES {
            let bounce = bounce(Impact::new(Elastic::Hertz, &surfaces, 0.0, mass, speed));
            let depth = (1.25 * mass * speed * speed / stiffness).powf(0.4);
            let duration = TWICE_THE_INTEGRAL * depth / speed;
            assert!((bounce.depth / depth - 1.0).abs() <= CLOSE);
            assert!((bounce.duration / duration - 1.0).abs() <= CLOSE);
        }
    }
}

#[test]
fn an_undamped_impact_of_the_enhanced_law_lasts_as_its_power_law_says() {
    // The same with δ^1.094: 2 sqrt(π) Γ(1 + 1/2.094)/Γ(1/2 + 1/2.094).
    const TWICE_THE_INTEGRAL: f64 = 3.098_051_339_411_606;
    let surfaces = bushing_on_tip();
    let stiffness = ElasticPair::prepare(Elastic::EnhancedCylinder, &surfaces).force(1.0);
    for (mass, speed) in CASES {
        let bounce = bounce(Impact::new(
            Elastic::EnhancedCylinder,
            &surfaces,
            0.0,
            mass,
            speed,
        ));
        let depth = (0.5 * 2.094 * mass * speed * speed / stiffness).powf(1.0 / 2.094);
        let duration = TWICE_THE_INTEGRAL * depth / speed;
        assert!((bounce.depth / depth - 1.0).abs() <= CLOSE);
        assert!((bounce.duration / duration - 1.0).abs() <= CLOSE);
    }
}

#[test]
fn no_impact_is_pulled_back() {
    for restitution in [0.0, 0.1, 0.71] {
        let lambda = Damping::LankaraniNikravesh.lambda(restitution);
        for (mass, speed) in CASES {
            let bounce = bounce(Impact::new(
                Elastic::Hertz,
                &pin_in_bushing(),
                lambda,
                mass,
                speed,
            ));
            assert!(bounce.least_force >= 0.0 && bounce.restitution < 1.0);
        }
    }
}

#[test]
fn parting_faster_than_the_damping_allows_meets_no_force() {
    let lambda = Damping::LankaraniNikravesh.lambda(0.71);
    for onset_speed in [1e-3, 0.1, 2.0] {
        for rate in [-1.0 / lambda, -3.0, -1e6].map(|share| share * onset_speed) {
            assert_eq!(
                damping_factor(lambda, rate * (1.0 + 1e-15), onset_speed),
                0.0
            );
        }
        assert!(damping_factor(lambda, -0.999 / lambda * onset_speed, onset_speed) > 0.0);
        assert_eq!(damping_factor(lambda, 0.0, onset_speed), 1.0);
        assert_eq!(
            damping_factor(0.0, -1e9, onset_speed),
            1.0,
            "an elastic contact is not damped at any rate"
        );
    }
}

/// Asserts that the force of a law grows from nothing at zero penetration.
fn assert_continuous(law: Elastic, surfaces: &SurfacePair) {
    let pair = ElasticPair::prepare(law, surfaces);
    for apart in [0.0, -0.0, -1e-300, -1e-6, f64::NEG_INFINITY] {
        assert_eq!(pair.force(apart), 0.0);
        assert_eq!(pair.energy(apart), 0.0);
    }
    // Each of the laws is convex at the origin: a tenth of the penetration leaves less than a tenth of the force.
    let mut force = pair.force(1e-6);
    for decade in 7..=300 {
        let next = pair.force(10f64.powi(-decade));
        assert!(
            next >= 0.0 && next <= 0.1 * (1.0 + 1e-13) * force,
            "1e-{decade} m: {next} N after {force} N"
        );
        force = next;
    }
}

#[test]
fn the_force_of_every_law_is_continuous_at_zero_penetration() {
    for surfaces in [
        pin_in_bushing(),
        bushing_on_tip(),
        bushing_on_working_curve(),
        bushing_on_flat(),
    ] {
        for law in laws() {
            assert_continuous(law, &surfaces);
        }
    }
}

/// Asserts forces \[N\] at penetrations \[m\]; a power x^n is off by n ln x eps, here up to 25 eps, and the factors by a few.
fn assert_forces(law: Elastic, surfaces: &SurfacePair, values: &[(f64, f64)]) {
    let pair = ElasticPair::prepare(law, surfaces);
    for &(penetration, force) in values {
        let got = pair.force(penetration);
        assert!(
            (got / force - 1.0).abs() <= 40.0 * f64::EPSILON,
            "{penetration} m: {got} N, not {force} N"
        );
    }
}

#[test]
fn hertz_forces_are_those_worked_out_by_hand() {
    // (4/3) E* sqrt(R_i R_j / ΔR) δ^1.5; on the flat sqrt(R_i) is the limit.
    assert_forces(
        Elastic::Hertz,
        &pin_in_bushing(),
        &[
            (1e-8, 0.067_709_927_634_027_86),
            (1e-7, 2.141_175_915_287_039),
            (1e-6, 67.709_927_634_027_86),
        ],
    );
    assert_forces(
        Elastic::Hertz,
        &bushing_on_tip(),
        &[
            (1e-7, 0.238_621_484_964_071_96),
            (2.5e-6, 29.827_685_620_508_99),
        ],
    );
    assert_forces(
        Elastic::Hertz,
        &bushing_on_flat(),
        &[
            (1e-7, 0.302_109_627_495_916_7),
            (2.5e-6, 37.763_703_436_989_59),
        ],
    );
}

#[test]
fn johnson_forces_are_those_worked_out_by_hand() {
    // δ = f/(π L E*) [ln(4 π L E* ΔR / f) - 1] at 1 N, 50 N and 1000 N.
    assert_forces(
        Elastic::Johnson,
        &pin_in_bushing(),
        &[
            (3.022_986_794_188_951e-9, 1.0),
            (1.013_836_658_481_543_7e-7, 50.0),
            (1.265_486_412_159_229_5e-6, 1000.0),
        ],
    );
    assert_forces(
        Elastic::Johnson,
        &bushing_on_tip(),
        &[
            (6.986_602_483_710_316e-9, 1.0),
            (2.711_269_224_034_837e-7, 50.0),
            (4.224_816_169_092_183e-6, 1000.0),
        ],
    );
}

#[test]
fn enhanced_forces_are_those_worked_out_by_hand() {
    // (a ΔR + b) L E*/ΔR δ^n in mm and N/mm²: n = 1.269567 for the pin, 1.090764 on the working curve, 1.094 outside.
    assert_forces(
        Elastic::EnhancedCylinder,
        &pin_in_bushing(),
        &[
            (1e-8, 2.521_750_258_027_929_6),
            (1e-7, 46.910_412_932_765_08),
            (1e-6, 872.642_655_440_212_4),
        ],
    );
    assert_forces(
        Elastic::EnhancedCylinder,
        &bushing_on_working_curve(),
        &[
            (1e-7, 17.448_231_964_940_533),
            (1e-6, 215.038_288_253_325_96),
        ],
    );
    for surfaces in [bushing_on_tip(), bushing_on_flat()] {
        assert_forces(
            Elastic::EnhancedCylinder,
            &surfaces,
            &[
                (1e-7, 15.761_966_169_050_057),
                (1e-6, 195.708_816_659_945_14),
            ],
        );
    }
}

#[test]
fn forces_in_proportion_to_the_length_of_contact_where_the_law_has_one() {
    let long = |surfaces: SurfacePair| SurfacePair {
        length: 2.0 * surfaces.length,
        ..surfaces
    };
    let (short, long) = (bushing_on_tip(), long(bushing_on_tip()));
    let force = |law: Elastic, s: &SurfacePair| ElasticPair::prepare(law, s).force(1e-6);
    for law in Elastic::ALL {
        if law != Elastic::Hertz {
            let ratio = force(law, &long) / force(law, &short);
            assert!((ratio - 2.0).abs() <= 1e-12, "{law:?}");
        }
    }
    assert_eq!(
        force(Elastic::Hertz, &long),
        force(Elastic::Hertz, &short),
        "Hertz's law is that of spheres"
    );
}

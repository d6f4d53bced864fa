//! Orders that stability allows, the change between correctors while running, and what `accuracy` measures, on systems whose
//! rates are known.

use crate::common;
use rustchain::integrator::{Adams, Corrector, OdeSystem, SecondOrderSystem, StepControl};
use rustchain::{ForceLaws, Simulation, Snapshot};

fn control(corrector: Corrector, accuracy: f64) -> StepControl {
    StepControl {
        corrector,
        accuracy,
        max_step: f64::INFINITY,
        ..StepControl::default()
    }
}

/// Oscillators side by side, q'' = -ω² (q - c) - d(t) q', with arms; c = 1 - cos t.
#[derive(Clone)]
struct Oscillators {
    frequency: Vec<f64>,
    /// Damping rate of each, while `damped` holds.
    damping: Vec<f64>,
    damped: fn(f64) -> bool,
    arm: f64,
    factor: Vec<f64>,
    time: f64,
}

impl Oscillators {
    fn new(frequency: &[f64], damping: &[f64]) -> Self {
        Self {
            frequency: frequency.to_vec(),
            damping: damping.to_vec(),
            damped: |_| true,
            arm: 1.0,
            factor: vec![1.0; frequency.len()],
            time: 0.0,
        }
    }

    fn damping(&self, i: usize, t: f64) -> f64 {
        if (self.damped)(t) {
            self.damping[i]
        } else {
            0.0
        }
    }
}

impl OdeSystem for Oscillators {
    fn dimension(&self) -> usize {
        2 * self.frequency.len()
    }

    fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        let n = self.frequency.len();
        self.time = t;
        for i in 0..n {
            let pull = self.frequency[i].powi(2) * (y[i] - (1.0 - t.cos()) / self.arm);
            dydt[i] = y[n + i];
            dydt[n + i] = -pull - self.damping(i, t) * y[n + i];
        }
    }
}

impl SecondOrderSystem for Oscillators {
    fn coordinates(&self) -> usize {
        self.frequency.len()
    }

    fn factorise(&mut self, _y: &[f64], gamma: f64) -> bool {
        for i in 0..self.factor.len() {
            let stiffness = self.frequency[i].powi(2);
            self.factor[i] = 1.0 + gamma * self.damping(i, self.time) + gamma * gamma * stiffness;
        }
        true
    }

    fn correct(&mut self, residual: &mut [f64]) {
        for (residual, factor) in residual.iter_mut().zip(&self.factor) {
            *residual /= factor;
        }
    }

    fn scale(&self, lengths: &mut [f64]) {
        lengths.fill(self.arm);
    }
}

/// A run from rest to `end`; every step is shown to `look`: its size, its order, and whether Newton's method made it.
fn run(
    system: &mut Oscillators,
    control: StepControl,
    end: f64,
    mut look: impl FnMut(&Adams, f64, usize, bool),
) -> Adams {
    let mut adams = Adams::new(system.dimension(), control);
    adams.restart(0.0, &vec![0.0; system.dimension()]);
    while adams.time() < end {
        let implicit = adams.is_implicit();
        let step = adams.step_second_order(system).unwrap();
        let order = step.degree + usize::from(implicit);
        look(&adams, step.end - step.start, order, implicit);
    }
    adams
}

/// Evaluations, and four for every matrix.
fn cost(adams: &Adams) -> f64 {
    let counts = adams.counts();
    counts.evaluations as f64 + 4.0 * counts.jacobians as f64
}

#[test]
fn where_nothing_is_stiff_newton_takes_high_orders_and_auto_does_not_take_newton() {
    let mut smooth = Oscillators::new(&[1.0, 1.7], &[0.1, 0.0]);
    let mut highest = 0;
    let newton = run(
        &mut smooth,
        control(Corrector::Newton, 1e-9),
        30.0,
        |_, _, k, _| {
            highest = highest.max(k);
        },
    );
    let trapezoid = StepControl {
        max_order: 2,
        ..control(Corrector::Newton, 1e-9)
    };
    let trapezoid = run(&mut smooth, trapezoid, 30.0, |_, _, _, _| {});
    assert!(highest >= 6, "{highest}");
    assert!(20 * newton.counts().steps < trapezoid.counts().steps);
    let explicit = run(
        &mut smooth,
        control(Corrector::Pece, 1e-9),
        30.0,
        |_, _, _, _| {},
    );
    let auto = run(
        &mut smooth,
        control(Corrector::Auto, 1e-9),
        30.0,
        |_, _, _, _| {},
    );
    assert_eq!(auto.counts(), explicit.counts());
    assert_eq!(auto.y(), explicit.y());
}

#[test]
fn a_stiff_vibration_keeps_the_order_at_two_and_does_not_grow() {
    // The second oscillator follows its slow pull so closely that accuracy sees nothing of its own frequency.
    let frequency = 1e5;
    let mut stiff = Oscillators::new(&[1.0, frequency], &[0.0, 0.0]);
    let (mut high, mut long, mut largest) = (0, 0, 0.0f64);
    let adams = run(
        &mut stiff,
        control(Corrector::Newton, 1e-8),
        20.0,
        |adams, h, k, _| {
            if h * frequency > 10.0 {
                long += 1;
                high += u32::from(k > 2);
                largest = largest.max((adams.y()[1] - (1.0 - adams.time().cos())).abs());
            }
        },
    );
    assert!(
        long > 100 && high <= long / 20,
        "{high} of {long} long steps"
    );
    assert!(largest < 1e-6, "{largest}");
    assert!(adams.counts().steps < 100_000, "{}", adams.counts().steps);
}

#[test]
fn auto_changes_to_newton_where_dampers_are_stiff_and_back_where_they_are_gone() {
    let mut system = Oscillators::new(&[1.0, 3.0], &[0.0, 1e4]);
    system.damped = |t| (10.0..20.0).contains(&t);
    let mut shares = [(0u32, 0u32); 3];
    let auto = run(
        &mut system,
        control(Corrector::Auto, 1e-7),
        30.0,
        |adams, _, _, implicit| {
            let share =
                &mut shares[usize::from(adams.time() > 10.0) + usize::from(adams.time() > 20.0)];
            share.0 += u32::from(implicit);
            share.1 += 1;
        },
    );
    let [before, between, after] = shares.map(|(n, all)| f64::from(n) / f64::from(all));
    assert!(before == 0.0 && between > 0.5 && after < 0.5, "{shares:?}");
    let forced = |corrector| {
        cost(&run(
            &mut system.clone(),
            control(corrector, 1e-7),
            30.0,
            |_, _, _, _| {},
        ))
    };
    let best = forced(Corrector::Pece).min(forced(Corrector::Newton));
    assert!(cost(&auto) < 1.15 * best, "{} {best}", cost(&auto));
}

#[test]
fn angles_count_by_what_they_move_at_their_arms() {
    // The same motion in radians at an arm of 4 m (a power of two rounds nothing) and in metres.
    for corrector in [Corrector::Pece, Corrector::Newton, Corrector::Auto] {
        let mut metres = Oscillators::new(&[1.0, 20.0], &[0.0, 500.0]);
        let mut radians = Oscillators {
            arm: 4.0,
            ..metres.clone()
        };
        let in_metres = run(&mut metres, control(corrector, 1e-7), 5.0, |_, _, _, _| {});
        let in_radians = run(&mut radians, control(corrector, 1e-7), 5.0, |_, _, _, _| {});
        assert_eq!(in_metres.counts(), in_radians.counts(), "{corrector:?}");
        assert_eq!(in_metres.y()[0], 4.0 * in_radians.y()[0]);
    }
}

#[test]
fn the_error_falls_with_the_accuracy_whatever_the_corrector() {
    // q'' = 1 - cos t - q from rest.
    let exact = |t: f64| 1.0 - t.cos() - 0.5 * t * t.sin();
    for corrector in [Corrector::Pece, Corrector::Newton] {
        let errors = [1e-6, 1e-8, 1e-10].map(|accuracy| {
            let mut system = Oscillators::new(&[1.0], &[0.0]);
            let adams = run(
                &mut system,
                control(corrector, accuracy),
                10.0,
                |_, _, _, _| {},
            );
            (adams.y()[0] - exact(adams.time())).abs()
        });
        // Speeds, allowed 1e5/s times as much, are what is controlled here.
        for (error, accuracy) in errors.into_iter().zip([1e-6, 1e-8, 1e-10]) {
            assert!(error < 1e7 * accuracy, "{corrector:?}: {errors:?}");
        }
        assert!(errors[2] < 0.01 * errors[0], "{corrector:?}: {errors:?}");
    }
}

fn paper(pretension: f64, control: StepControl) -> Simulation {
    let mut drive = common::paper_drive();
    drive.tensioner = (pretension > 0.0).then(|| common::tensioner(pretension, 2e-3));
    common::simulation(&drive, &ForceLaws::default(), control)
}

fn of(corrector: Corrector, accuracy: f64) -> StepControl {
    StepControl {
        corrector,
        accuracy,
        ..StepControl::default()
    }
}

#[test]
fn on_the_drive_auto_costs_about_what_the_better_one_does() {
    let mean_cost = |pretension: f64, corrector| {
        let runs = [1.0, 1.01, 1.02].map(|factor| {
            let mut run = paper(pretension, of(corrector, factor * 1e-9));
            common::advance(&mut run, 0.02);
            cost(run.integrator())
        });
        runs.iter().sum::<f64>() / 3.0
    };
    for pretension in [0.0, 100.0] {
        let [explicit, implicit, auto] = [Corrector::Pece, Corrector::Newton, Corrector::Auto]
            .map(|corrector| mean_cost(pretension, corrector));
        // The paths are chaotic and short: 1.15 over longer runs.
        assert!(
            auto < 1.3 * explicit.min(implicit),
            "{pretension} N: {explicit} {implicit} {auto}"
        );
    }
}

#[test]
fn a_run_that_changes_correctors_goes_on_to_the_same_bits() {
    let bytes = |run: &Simulation| run.snapshot().to_bytes().unwrap();
    let auto = of(Corrector::Auto, 1e-9);
    let mut whole = paper(25.0, auto);
    let mut changes = 0;
    for stop in 1..=30 {
        let implicit = whole.integrator().is_implicit();
        let mut relay = paper(25.0, auto);
        relay
            .restore(&Snapshot::from_bytes(&bytes(&whole)).unwrap())
            .unwrap();
        common::advance(&mut whole, f64::from(stop) * 4e-4);
        common::advance(&mut relay, f64::from(stop) * 4e-4);
        assert!(bytes(&relay) == bytes(&whole), "stop {stop}");
        changes += u32::from(whole.integrator().is_implicit() != implicit);
    }
    assert!(changes > 0);
}

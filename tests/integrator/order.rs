//! The integrator on smooth problems with known solutions: errors that follow the tolerance, the stated order, honest counts.

use std::f64::consts::PI;

use rustchain::integrator::{Adams, OdeSystem, StepControl};

/// dy/dt = f(t, y) with its solution.
#[derive(Clone, Copy)]
struct Problem {
    name: &'static str,
    dimension: usize,
    end: f64,
    slope: fn(f64, &[f64], &mut [f64]),
    solution: fn(f64, &mut [f64]),
}

impl OdeSystem for Problem {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        (self.slope)(t, y, dydt);
    }
}

impl Problem {
    fn exact(&self, t: f64) -> Vec<f64> {
        let mut y = vec![0.0; self.dimension];
        (self.solution)(t, &mut y);
        y
    }

    /// Largest difference of any component of `y` from the solution at `t`.
    fn error(&self, t: f64, y: &[f64]) -> f64 {
        let differences = self
            .exact(t)
            .into_iter()
            .zip(y)
            .map(|(exact, y)| (exact - y).abs());
        differences.fold(0.0, f64::max)
    }
}

const OSCILLATOR: Problem = Problem {
    name: "linear oscillator, two periods",
    dimension: 2,
    end: 4.0 * PI,
    slope: |_, y, dydt| (dydt[0], dydt[1]) = (y[1], -y[0]),
    solution: |t, y| (y[0], y[1]) = (t.cos(), -t.sin()),
};

const LOGISTIC: Problem = Problem {
    name: "logistic growth",
    dimension: 1,
    end: 8.0,
    slope: |_, y, dydt| dydt[0] = y[0] * (1.0 - y[0]),
    solution: |t, y| y[0] = 1.0 / (1.0 + 9.0 * (-t).exp()),
};

const TWO_BODIES: Problem = Problem {
    name: "two bodies on a circle, two periods",
    dimension: 4,
    end: 4.0 * PI,
    slope: |_, y, dydt| {
        let cube = (y[0] * y[0] + y[1] * y[1]).powf(1.5);
        dydt[..2].copy_from_slice(&y[2..]);
        (dydt[2], dydt[3]) = (-y[0] / cube, -y[1] / cube);
    },
    solution: |t, y| y.copy_from_slice(&[t.cos(), t.sin(), -t.sin(), t.cos()]),
};

const FORCED: Problem = Problem {
    name: "nonautonomous, y' = y cos t",
    dimension: 1,
    end: 10.0,
    slope: |t, y, dydt| dydt[0] = y[0] * t.cos(),
    solution: |t, y| y[0] = t.sin().exp(),
};

const FOLLOWER: Problem = Problem {
    name: "nonautonomous, y follows a circle",
    dimension: 2,
    end: 10.0,
    slope: |t, y, dydt| {
        let (sin, cos) = t.sin_cos();
        (dydt[0], dydt[1]) = (cos - sin - y[0], sin + cos - y[1]);
    },
    solution: |t, y| (y[1], y[0]) = t.sin_cos(),
};

const PROBLEMS: [Problem; 5] = [OSCILLATOR, LOGISTIC, TWO_BODIES, FORCED, FOLLOWER];

fn control(tolerance: f64) -> StepControl {
    StepControl {
        rtol: tolerance,
        atol: tolerance,
        max_step: f64::INFINITY,
        max_order: 12,
        ..StepControl::default()
    }
}

fn started(problem: &Problem, control: StepControl) -> Adams {
    let mut adams = Adams::new(problem.dimension, control);
    adams.restart(0.0, &problem.exact(0.0));
    adams
}

/// Errors of a run: the largest at the end of a step, and inside one.
fn errors(mut problem: Problem, tolerance: f64) -> (f64, f64) {
    let mut adams = started(&problem, control(tolerance));
    let (mut at_steps, mut inside): (f64, f64) = (0.0, 0.0);
    let mut y = vec![0.0; problem.dimension];
    while adams.time() < problem.end {
        let step = adams.step(&mut problem).unwrap();
        at_steps = at_steps.max(problem.error(step.end, adams.y()));
        for share in [0.1, 0.3, 0.5, 0.7, 0.9] {
            let t = step.start + share * (step.end - step.start);
            adams.interpolate(t, &mut y);
            inside = inside.max(problem.error(t, &y));
        }
    }
    (at_steps, inside)
}

const TOLERANCES: [f64; 11] = [
    1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13,
];

#[test]
fn the_error_follows_the_tolerance_over_ten_decades() {
    // The error test is on each step; what the problem makes of the local errors is a factor of its own. The motion of two
    // bodies carries an error in speed along, so that its position drifts. Measured factors: 0.4 to 14, 0.6 to 3.0, 4 to 156,
    // 2.1 to 23 and 0.5 to 4.9.
    for (problem, lowest, highest) in [
        (OSCILLATOR, 0.1, 40.0),
        (LOGISTIC, 0.1, 10.0),
        (TWO_BODIES, 1.0, 400.0),
        (FORCED, 0.5, 60.0),
        (FOLLOWER, 0.1, 20.0),
    ] {
        for tolerance in TOLERANCES {
            let (at_steps, inside) = errors(problem, tolerance);
            let factor = at_steps / tolerance;
            assert!(
                (lowest..=highest).contains(&factor),
                "{} at {tolerance:e}: {factor} times the tolerance",
                problem.name
            );
            // Measured: 1.7 times at most, with the longest steps.
            assert!(
                inside <= 2.0 * at_steps,
                "{} at {tolerance:e}: {inside:e} inside",
                problem.name
            );
        }
    }
}

#[test]
fn every_step_costs_two_evaluations_and_every_rejected_one_a_single_one() {
    let mut rejected = 0;
    for mut problem in PROBLEMS {
        for tolerance in TOLERANCES {
            let mut adams = started(&problem, control(tolerance));
            let mut calls = 0;
            let mut counted = Counted {
                problem: &mut problem,
                calls: &mut calls,
            };
            while adams.time() < counted.problem.end {
                adams.step(&mut counted).unwrap();
            }
            let counts = adams.counts();
            // One at the start, and one that tests the first step.
            assert_eq!(counts.evaluations, 2 + 2 * counts.steps + counts.rejected);
            assert_eq!(counts.evaluations, calls);
            rejected += counts.rejected;
        }
    }
    assert!(
        rejected > 0,
        "the formula is tried with rejected steps, too"
    );
}

struct Counted<'a> {
    problem: &'a mut Problem,
    calls: &'a mut u64,
}

impl OdeSystem for Counted<'_> {
    fn dimension(&self) -> usize {
        self.problem.dimension
    }

    fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        *self.calls += 1;
        self.problem.derivative(t, y, dydt);
    }
}

/// A problem whose slopes are the solution's up to `handover`, so that a run arrives there with an exact history.
///
/// Until then the slope does not depend on y: shifting the start by the error made so far removes it.
struct Prepared {
    problem: Problem,
    handover: f64,
}

impl OdeSystem for Prepared {
    fn dimension(&self) -> usize {
        self.problem.dimension
    }

    fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        if t < self.handover {
            (self.problem.slope)(t, &self.problem.exact(t), dydt);
        } else {
            (self.problem.slope)(t, y, dydt);
        }
    }
}

/// Errors at the ends of steps and halfway, of constant steps at one order, from an exact history on.
fn fixed_order_errors(problem: Problem, order: usize, step_size: f64) -> (f64, f64) {
    const END: f64 = 6.0;
    // No error is too large and no step is too long but for `max_step`: the order climbs to the highest allowed and stays.
    let control = StepControl {
        rtol: 0.0,
        atol: 1e6,
        max_step: step_size,
        max_order: order,
        ..StepControl::default()
    };
    let lead = 20;
    let mut prepared = Prepared {
        problem,
        handover: (f64::from(lead) + 0.5) * step_size,
    };
    let mut start = problem.exact(0.0);
    let mut adams = Adams::new(problem.dimension, control);
    for pass in 0..2 {
        adams.restart(0.0, &start);
        for _ in 0..lead {
            adams.step(&mut prepared).unwrap();
        }
        let exact = problem.exact(adams.time());
        for ((start, exact), y) in start.iter_mut().zip(&exact).zip(adams.y()) {
            *start += exact - y;
        }
        // Rounding of twenty additions is left.
        assert!(pass == 0 || problem.error(adams.time(), adams.y()) < 1e-14);
    }
    let (mut at_steps, mut halfway): (f64, f64) = (0.0, 0.0);
    let mut y = vec![0.0; problem.dimension];
    while adams.time() < END {
        let step = adams.step(&mut prepared).unwrap();
        assert_eq!(step.degree, order, "{} at t = {}", problem.name, step.start);
        assert!((step.end - step.start - step_size).abs() < 1e-12);
        at_steps = at_steps.max(problem.error(step.end, adams.y()));
        let middle = 0.5 * (step.start + step.end);
        adams.interpolate(middle, &mut y);
        halfway = halfway.max(problem.error(middle, &y));
    }
    (at_steps, halfway)
}

#[test]
fn a_predictor_of_order_k_makes_a_method_of_order_k_plus_one() {
    // Halving the step divides the error by 2^(k+1), for the corrector is one order up (local extrapolation). The finest
    // pair of steps counts whose error is still well above rounding, 1e-13; there the slope rounds to the order.
    for (problem, highest) in [(OSCILLATOR, 8), (TWO_BODIES, 7), (FOLLOWER, 8)] {
        for order in 1..=highest {
            let mut step_size = 0.2;
            let mut coarse = fixed_order_errors(problem, order, step_size);
            let mut slopes = None;
            while step_size > 0.01 {
                step_size *= 0.5;
                let fine = fixed_order_errors(problem, order, step_size);
                if fine.0 < 3e-13 {
                    break;
                }
                slopes = Some(((coarse.0 / fine.0).log2(), (coarse.1 / fine.1).log2()));
                coarse = fine;
            }
            let (at_steps, halfway) = slopes.unwrap();
            let expected = order as f64 + 1.0;
            assert!(
                (at_steps - expected).abs() < 0.5,
                "{}, k = {order}: {at_steps}",
                problem.name
            );
            assert!(
                (halfway - expected).abs() < 0.5,
                "{}, k = {order}: {halfway} halfway",
                problem.name
            );
            assert!(
                coarse.1 < 1.1 * coarse.0,
                "halfway through a step the error is that at its end"
            );
        }
    }
}

#[test]
fn looking_inside_the_steps_does_not_change_them() {
    for mut problem in PROBLEMS {
        for tolerance in [1e-4, 1e-9] {
            let mut plain = started(&problem, control(tolerance));
            let mut watched = plain.clone();
            let mut y = vec![0.0; problem.dimension];
            while plain.time() < problem.end {
                let step = plain.step(&mut problem).unwrap();
                assert_eq!(watched.step(&mut problem).unwrap(), step);
                for report in 0..100 {
                    watched.interpolate(
                        step.start + f64::from(report) / 99.0 * (step.end - step.start),
                        &mut y,
                    );
                }
                assert_eq!(plain.y(), watched.y());
            }
            assert_eq!(plain.counts(), watched.counts());
        }
    }
}

#[test]
fn inside_a_step_the_solution_meets_both_its_ends() {
    for mut problem in PROBLEMS {
        let mut adams = started(&problem, control(1e-10));
        let mut y = vec![0.0; problem.dimension];
        while adams.time() < problem.end {
            let before = adams.y().to_vec();
            let step = adams.step(&mut problem).unwrap();
            adams.interpolate(step.end, &mut y);
            assert_eq!(y, adams.y());
            adams.interpolate(step.start, &mut y);
            for (y, before) in y.iter().zip(&before) {
                assert!(
                    (y - before).abs() <= 1e-9,
                    "{}: {:e}",
                    problem.name,
                    y - before
                );
            }
        }
    }
}

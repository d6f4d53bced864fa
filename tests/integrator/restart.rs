//! The integrator where the problem is not smooth: restarts after jumps, and derivatives that are no numbers.

use rustchain::integrator::{Adams, Counts, OdeSystem, Step, StepControl, StepFailure};

/// A system from a closure.
struct System<F: FnMut(f64, &[f64], &mut [f64])>(usize, F);

impl<F: FnMut(f64, &[f64], &mut [f64])> OdeSystem for System<F> {
    fn dimension(&self) -> usize {
        self.0
    }

    fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        (self.1)(t, y, dydt);
    }
}

/// A pendulum, y = [angle, speed].
fn pendulum() -> impl OdeSystem {
    System(2, |_, y: &[f64], dydt: &mut [f64]| {
        (dydt[0], dydt[1]) = (y[1], -y[0].sin());
    })
}

fn adams(dimension: usize) -> Adams {
    Adams::new(
        dimension,
        StepControl {
            rtol: 1e-9,
            atol: 1e-9,
            max_step: f64::INFINITY,
            max_order: 12,
            ..StepControl::default()
        },
    )
}

/// Orders of the next steps, where they lead, and the size chosen for the step after each.
fn steps(
    adams: &mut Adams,
    system: &mut impl OdeSystem,
    number: usize,
) -> Vec<(f64, usize, Vec<f64>)> {
    (0..number)
        .map(|_| {
            let step = adams.step(system).unwrap();
            // The size as chosen, not the difference of two rounded times.
            (adams.step_size(), step.degree, adams.y().to_vec())
        })
        .collect()
}

#[test]
fn restart_after_a_jump_repeats_the_opening_steps() {
    let start = [1.0, 0.5];
    let mut adams = adams(2);
    adams.restart(0.0, &start);
    let opening = steps(&mut adams, &mut pendulum(), 40);
    assert!(
        opening.iter().any(|(_, order, _)| *order > 6),
        "the opening reaches high orders"
    );
    // The pendulum is knocked back to where it began: an autonomous problem opens in the same way at any time.
    let jump = adams.time();
    adams.restart(jump, &start);
    assert_eq!(adams.time(), jump);
    assert_eq!(steps(&mut adams, &mut pendulum(), 40), opening);
}

#[test]
fn a_restart_forgets_the_history() {
    let start = [-0.3, 2.0];
    let mut fresh = adams(2);
    fresh.restart(5.0, &start);
    let mut used = adams(2);
    used.restart(0.0, &[1.0, 0.0]);
    let mut other = System(2, |t: f64, y: &[f64], dydt: &mut [f64]| {
        (dydt[0], dydt[1]) = (y[1] * t.cos(), 30.0 - y[0]);
    });
    steps(&mut used, &mut other, 200);
    used.restart(5.0, &start);
    assert_eq!(
        steps(&mut used, &mut pendulum(), 100),
        steps(&mut fresh, &mut pendulum(), 100)
    );
    assert_eq!(used.time(), fresh.time());
}

#[test]
fn a_restart_goes_on_counting_and_costs_two_evaluations() {
    let mut adams = adams(2);
    adams.restart(0.0, &[1.0, 0.0]);
    steps(&mut adams, &mut pendulum(), 30);
    let before = adams.counts();
    adams.restart(adams.time(), &[0.5, 0.0]);
    steps(&mut adams, &mut pendulum(), 30);
    let Counts {
        steps,
        rejected,
        evaluations,
        ..
    } = adams.counts();
    assert_eq!(steps, before.steps + 30);
    // Each start: the derivative there, and a test of the first step.
    assert_eq!(evaluations, 4 + 2 * steps + rejected);
}

#[test]
fn a_ball_that_bounces_by_restarts_rises_as_high_as_its_restitution_says() {
    // Free fall from 1 m; at each landing the run begins anew with 0.8 of the speed, turned round.
    let mut fall = System(2, |_, y: &[f64], dydt: &mut [f64]| {
        (dydt[0], dydt[1]) = (y[1], -9.81);
    });
    let mut adams = adams(2);
    adams.restart(0.0, &[1.0, 0.0]);
    let mut landings = 0;
    let mut energy = 9.81;
    while landings < 10 {
        let step = adams.step(&mut fall).unwrap();
        if adams.y()[0] > 0.0 {
            continue;
        }
        let (mut low, mut high) = (step.start, step.end);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if adams.dense(middle).value(0) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        let speed = adams.dense(low).value(1);
        adams.restart(low, &[0.0, -0.8 * speed]);
        landings += 1;
        energy *= 0.64;
        assert!(
            (0.32 * speed * speed / energy - 1.0).abs() < 1e-7,
            "landing {landings}"
        );
    }
}

/// Steps until the integrator gives up; at most `evaluations`.
fn failure(
    adams: &mut Adams,
    system: &mut impl OdeSystem,
    evaluations: u64,
) -> (StepFailure, Option<Step>) {
    let mut last = None;
    loop {
        match adams.step(system) {
            Ok(step) => last = Some(step),
            Err(failure) => {
                assert!(
                    adams.counts().evaluations <= evaluations,
                    "{:?}",
                    adams.counts()
                );
                return (failure, last);
            }
        }
        assert!(
            adams.counts().evaluations <= evaluations,
            "{:?}",
            adams.counts()
        );
    }
}

#[test]
fn a_derivative_that_becomes_no_number_is_named_with_its_time() {
    let mut system = System(3, |t: f64, y: &[f64], dydt: &mut [f64]| {
        dydt[0] = y[1];
        dydt[1] = if t > 0.7 { f64::NAN } else { -y[0] };
        dydt[2] = -y[2];
    });
    let mut adams = adams(3);
    adams.restart(0.0, &[1.0, 0.0, 1.0]);
    let (failure, _) = failure(&mut adams, &mut system, 1000);
    let StepFailure::NotFinite {
        time,
        step_size,
        component,
    } = failure
    else {
        panic!("{failure:?}");
    };
    assert!(time <= 0.7 && time > 0.7 - 1e-9, "{time}");
    assert!(step_size < 1e-9);
    assert_eq!(component, 1);
    assert!(
        adams.y().iter().all(|y| y.is_finite()),
        "the last good state is kept"
    );
}

#[test]
fn a_derivative_that_is_no_number_from_the_start_is_refused() {
    let mut system = System(2, |_, _: &[f64], dydt: &mut [f64]| {
        (dydt[0], dydt[1]) = (1.0, f64::NAN);
    });
    let mut adams = adams(2);
    adams.restart(3.0, &[0.0, 0.0]);
    let (failure, last) = failure(&mut adams, &mut system, 100);
    assert!(matches!(failure, StepFailure::NotFinite { time, component: 1, .. } if time == 3.0));
    assert_eq!(last, None);
}

#[test]
fn a_derivative_that_is_no_number_beyond_a_state_is_named_too() {
    // Torricelli's tank is empty at t = 2; below that the outflow is the root of a negative number.
    let mut system = System(2, |_, y: &[f64], dydt: &mut [f64]| {
        (dydt[0], dydt[1]) = (1.0, -y[1].sqrt());
    });
    let mut adams = adams(2);
    adams.restart(0.0, &[0.0, 1.0]);
    let (failure, _) = failure(&mut adams, &mut system, 3000);
    assert!(
        matches!(failure, StepFailure::NotFinite { time, component: 1, .. } if (time - 2.0).abs() < 1e-3),
        "{failure:?}"
    );
}

#[test]
fn an_infinite_derivative_is_named_with_its_time() {
    let mut system = System(2, |t: f64, _: &[f64], dydt: &mut [f64]| {
        (dydt[0], dydt[1]) = (if t > 1.0 { f64::INFINITY } else { 1.0 }, 0.0);
    });
    let mut adams = adams(2);
    adams.restart(0.0, &[0.0, 0.0]);
    let (failure, _) = failure(&mut adams, &mut system, 1000);
    let StepFailure::NotFinite {
        time,
        step_size,
        component,
    } = failure
    else {
        panic!("{failure:?}");
    };
    assert!(
        time <= 1.0 && time > 1.0 - 1e-9 && step_size < 1e-9,
        "{failure:?}"
    );
    assert_eq!(component, 0);
}

#[test]
fn a_pole_ends_the_run_at_the_pole() {
    // y' = y² from 1: the pole is at t = 1; beside it a harmless component.
    let mut system = System(2, |_, y: &[f64], dydt: &mut [f64]| {
        (dydt[0], dydt[1]) = (-y[0], y[1] * y[1]);
    });
    let mut adams = adams(2);
    adams.restart(0.0, &[1.0, 1.0]);
    let (failure, _) = failure(&mut adams, &mut system, 20_000);
    match failure {
        StepFailure::TooSmall {
            time, component, ..
        } => {
            assert!((time - 1.0).abs() < 1e-6, "{time}");
            assert_eq!(component, 1);
        }
        StepFailure::NotFinite { .. } | StepFailure::ToleranceTooSmall { .. } => {
            panic!("{failure:?}")
        }
    }
}

#[test]
fn a_failed_run_can_begin_anew() {
    let mut broken = System(2, |_, _: &[f64], dydt: &mut [f64]| dydt.fill(f64::NAN));
    let mut adams = adams(2);
    adams.restart(0.0, &[1.0, 0.0]);
    failure(&mut adams, &mut broken, 100);
    adams.restart(0.0, &[1.0, 0.5]);
    let mut fresh = self::adams(2);
    fresh.restart(0.0, &[1.0, 0.5]);
    assert_eq!(
        steps(&mut adams, &mut pendulum(), 50),
        steps(&mut fresh, &mut pendulum(), 50)
    );
}

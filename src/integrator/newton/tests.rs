//! Tests of implicit steps: rejections, the choice of order and step size.

use super::*;
use crate::integrator::{OdeSystem, StepControl};

/// q'' = -q, and a sum whose rate is not a number from `end` \[s\] on.
#[derive(Clone, Copy)]
struct Oscillator {
    end: f64,
    gamma: f64,
}

impl OdeSystem for Oscillator {
    fn dimension(&self) -> usize {
        3
    }
    fn controlled(&self) -> usize {
        2
    }
    fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        let power = if t < self.end { y[1] } else { f64::NAN };
        dydt.copy_from_slice(&[y[1], -y[0], power]);
    }
}

impl SecondOrderSystem for Oscillator {
    fn coordinates(&self) -> usize {
        1
    }
    fn factorise(&mut self, _y: &[f64], gamma: f64) -> bool {
        self.gamma = gamma;
        true
    }
    fn correct(&mut self, residual: &mut [f64]) {
        residual[0] /= 1.0 + self.gamma * self.gamma;
    }
    fn scale(&self, lengths: &mut [f64]) {
        lengths.fill(1.0);
    }
}

fn started(accuracy: f64, end: f64) -> (Adams, Oscillator) {
    let control = StepControl {
        accuracy,
        max_step: 0.1,
        ..StepControl::default()
    };
    let mut adams = Adams::new(3, control);
    adams.restart(0.0, &[1.0, 0.0, 0.0]);
    (adams, Oscillator { end, gamma: 0.0 })
}

#[test]
fn the_rounding_of_an_explicit_step_is_compensated_once() {
    let (mut adams, mut system) = started(1e-14, f64::INFINITY);
    for _ in 0..40 {
        adams.step_pece(&mut system).unwrap();
    }
    assert!(adams.history.differences.compensates());
    adams.step_newton(&mut system).unwrap();
    let (mut other, mut same) = (adams.clone(), system);
    other.history.differences.forget_rounding();
    for _ in 0..40 {
        adams.step_newton(&mut system).unwrap();
        other.step_newton(&mut same).unwrap();
        assert_eq!(adams.y(), other.y());
    }
}

#[test]
fn order_two_in_place_of_one_takes_the_step_size_of_its_own_error() {
    let (mut adams, mut system) = started(1e-6, f64::INFINITY);
    for _ in 0..40 {
        adams.step_newton(&mut system).unwrap();
    }
    // Order one has half of the error, but it is not taken: the step size has to follow from the error of order two.
    adams.next.steps_of_limited_growth = 0;
    (adams.history.last_order, adams.history.last_step_size) = (2, adams.next.size);
    let estimate = ErrorEstimate {
        local: 1.0,
        at_order: 1.0,
        one_below: 0.5,
        two_below: 0.0,
    };
    adams.choose_implicit_order_and_step(&estimate, Some(0.0));
    let expected = SAFETY * adams.history.last_step_size;
    assert_eq!(adams.next.order, 2);
    assert!((adams.next.size / expected - 1.0).abs() < 1e-12);
}

#[test]
fn tolerances_below_rounding_are_refused() {
    let (mut adams, mut system) = started(1e-18, f64::INFINITY);
    let failure = adams.step_newton(&mut system).unwrap_err();
    assert!(matches!(failure, StepFailure::ToleranceTooSmall { factor, .. } if factor > 1.0));
}

#[test]
fn an_error_that_is_not_a_number_makes_the_step_shorter() {
    let end = 1.0;
    let (mut adams, mut system) = started(1e-6, end);
    let failure = loop {
        if let Err(failure) = adams.step_newton(&mut system) {
            break failure;
        }
    };
    assert!((adams.time() - end).abs() < 1e-9, "{failure:?}");
}

/// One oscillator whose first evaluations are disturbed, or whose matrix is singular for some steps.
#[derive(Clone)]
struct Disturbed {
    oscillator: Oscillator,
    /// Evaluations that are disturbed from now on, and the change of the acceleration.
    evaluations: u32,
    change: f64,
    /// Matrices that are singular from now on.
    singular: u32,
    /// Steps with a hidden event from now on.
    hidden: u32,
}

impl OdeSystem for Disturbed {
    fn dimension(&self) -> usize {
        2
    }
    fn derivative(&mut self, _t: f64, y: &[f64], dydt: &mut [f64]) {
        dydt.copy_from_slice(&[y[1], -y[0]]);
        if self.evaluations > 0 {
            self.evaluations -= 1;
            dydt[1] += self.change;
        }
    }
    fn accepts_step(&mut self, _length: f64, _allowed: f64) -> bool {
        let accepts = self.hidden == 0;
        self.hidden = self.hidden.saturating_sub(1);
        accepts
    }
}

impl SecondOrderSystem for Disturbed {
    fn coordinates(&self) -> usize {
        1
    }
    fn factorise(&mut self, y: &[f64], gamma: f64) -> bool {
        if self.singular > 0 {
            self.singular -= 1;
            return false;
        }
        self.oscillator.factorise(y, gamma)
    }
    fn correct(&mut self, residual: &mut [f64]) {
        self.oscillator.correct(residual);
    }
    fn scale(&self, lengths: &mut [f64]) {
        lengths.fill(1.0);
    }
}

/// An integrator of order above two, and its system without disturbance.
fn undisturbed() -> (Adams, Disturbed) {
    let control = StepControl {
        accuracy: 1e-6,
        max_step: 0.02,
        ..StepControl::default()
    };
    let mut system = Disturbed {
        oscillator: started(1e-6, f64::INFINITY).1,
        evaluations: 0,
        change: 0.0,
        singular: 0,
        hidden: 0,
    };
    let mut adams = Adams::new(2, control);
    adams.restart(0.0, &[1.0, 0.0]);
    for _ in 0..40 {
        adams.step_newton(&mut system).unwrap();
    }
    assert!(adams.next.order > 2 && adams.next.size > 1e-3);
    (adams, system)
}

#[test]
fn three_failures_of_a_step_reduce_its_order_to_one() {
    let (adams, system) = undisturbed();
    let (order, size) = (adams.next.order, adams.next.size);
    // Matrices that are singular, and errors so far above the tolerance that the step falls by its smallest factor.
    let disturbed = |evaluations: u32, singular: u32| Disturbed {
        evaluations,
        singular,
        change: 1e15,
        ..system.clone()
    };
    let cases: [(Disturbed, i32); 7] = [
        (disturbed(0, 1), 1),
        (disturbed(0, 2), 2),
        (disturbed(0, 3), 3),
        (disturbed(1, 0), 1),
        (disturbed(2, 0), 2),
        (disturbed(3, 0), 3),
        // The first disturbed evaluation is that with the singular matrix.
        (disturbed(2, 1), 2),
    ];
    for (mut system, failures) in cases {
        let smallest = if system.singular > 0 {
            NOT_CONVERGED
        } else {
            REDUCTION_AFTER_ERROR[0]
        };
        let mixed = system.singular > 0 && system.evaluations > 0;
        let mut adams = adams.clone();
        let rejected = adams.counts.rejected;
        let step = adams.step_newton(&mut system).unwrap();
        let expected = if failures < 3 { order } else { 1 };
        assert_eq!(
            (step.degree + 1, adams.history.last_order),
            (expected, expected)
        );
        assert_eq!(
            adams.counts.rejected,
            rejected + u64::from(failures.cast_unsigned())
        );
        if !mixed {
            let factor = adams.history.last_step_size / size;
            let expected = smallest.powi(failures);
            assert!(
                (factor / expected - 1.0).abs() < 1e-14,
                "{factor} {expected}"
            );
        }
    }
}

#[test]
fn hidden_events_halve_the_step_and_keep_its_order() {
    let (mut adams, mut system) = undisturbed();
    let (order, size) = (adams.next.order, adams.next.size);
    system.hidden = 4;
    let step = adams.step_newton(&mut system).unwrap();
    assert_eq!(step.degree + 1, order);
    assert!((adams.history.last_step_size / size - 0.5f64.powi(4)).abs() < 1e-14);
}

#[test]
fn a_rejected_step_is_repeated_with_the_size_that_its_error_permits() {
    let (adams, system) = undisturbed();
    let disturbed = |change: f64| Disturbed {
        evaluations: 1,
        change,
        ..system.clone()
    };
    // The error of a first attempt, by the change of its only evaluation.
    let error = |change: f64| {
        let (mut adams, mut system) = (adams.clone(), disturbed(change));
        adams.predict_implicit(1);
        let newest_only = adams.needs_newest_difference_only(1);
        let estimate = adams.solve_corrector(&mut system, newest_only);
        estimate.unwrap().local
    };
    let unit = error(1e3) / 1e3;
    for (wanted, kept) in [(2.0, false), (6.0, false), (1e9, true)] {
        let change = wanted / unit;
        let local = error(change);
        let mut adams = adams.clone();
        let (order, size) = (adams.next.order, adams.next.size);
        adams.step_newton(&mut disturbed(change)).unwrap();
        let factor = adams.history.last_step_size / size;
        let expected = if kept {
            REDUCTION_AFTER_ERROR[0]
        } else {
            SAFETY * local.powf(-1.0 / (order as f64 + 1.0))
        };
        assert!(
            (factor / expected - 1.0).abs() < 1e-9,
            "{factor} {expected}"
        );
    }
}

/// An integrator without past behind a step of this order and a size of 1 s; its fastest rate is zero.
fn behind_step(order: usize, equal_steps: usize, max_order: usize) -> Adams {
    let control = StepControl {
        accuracy: 1e-6,
        max_step: 100.0,
        max_order,
        ..StepControl::default()
    };
    let mut adams = Adams::new(2, control);
    adams.restart(0.0, &[1.0, 0.0]);
    adams.starting = false;
    adams.next.growing = false;
    (adams.history.last_order, adams.history.last_step_size) = (order, 1.0);
    adams.history.coefficients.equal_steps = equal_steps;
    adams
}

fn errors(one_below: f64, at_order: f64) -> ErrorEstimate {
    ErrorEstimate {
        local: 0.7,
        at_order,
        one_below,
        two_below: 10.0 * at_order,
    }
}

fn chosen(mut adams: Adams, estimate: &ErrorEstimate, above: f64) -> (usize, f64) {
    adams.choose_implicit_order_and_step(estimate, Some(above));
    (adams.next.order, adams.next.size)
}

#[test]
fn orders_up_to_the_trapezoidal_rule_follow_the_error_of_the_step() {
    let estimate = ErrorEstimate {
        local: 4.0,
        ..errors(9.0, 1.0)
    };
    let size = SAFETY / 4.0f64.cbrt();
    for (order, max_order) in [(1, 12), (1, 2), (2, 2)] {
        // The order may rise by its equal steps, and errors that fall with the order permit a longer step.
        let found = chosen(behind_step(order, 5, max_order), &estimate, 0.1);
        assert_eq!(found.0, 2);
        assert!((found.1 / size - 1.0).abs() < 1e-14, "{found:?}");
    }
    let found = chosen(behind_step(1, 5, 1), &estimate, 0.1);
    assert_eq!(found, (1, SAFETY / 2.0));
}

#[test]
fn orders_inside_the_stability_region_are_chosen_as_those_of_explicit_steps() {
    // At the highest permitted order the estimate is that of the step: half of the tolerance keeps the size.
    assert_eq!(
        chosen(behind_step(3, 5, 3), &errors(9.0, 0.4), 0.0),
        (3, 1.0)
    );
    // One order up: the norm of φ_5 for an error of 1.9 tolerances.
    let above = 1.9 / gamma_star(4);
    let (order, size) = chosen(behind_step(3, 5, 12), &errors(9.0, 2.0), above);
    assert_eq!(order, 4);
    assert!((size - (0.5f64 / 1.9).powf(0.2)).abs() < 1e-14);
    let (order, _) = chosen(behind_step(3, 3, 12), &errors(9.0, 2.0), above);
    assert_eq!(order, 3);
    // The trapezoidal rule stays with its own estimate where a higher order may follow.
    let (order, size) = chosen(behind_step(2, 2, 12), &errors(9.0, 4.0), 0.0);
    assert_eq!(order, 2);
    assert!((size - SAFETY / 4.0f64.cbrt()).abs() < 1e-14);
}

#[test]
fn an_order_above_the_permitted_ones_falls_with_the_error_of_the_order_it_takes() {
    let (adams, mut system) = undisturbed();
    let mut adams = adams;
    while adams.history.last_order < 5 {
        adams.step_newton(&mut system).unwrap();
    }
    adams.control.max_order = 3;
    adams.control.max_step = f64::INFINITY;
    adams.next.growing = false;
    let norm = (adams.history).norm_of_difference(adams.instructions, &adams.norm, 3);
    // A step size at which the error of order three is 1.5 tolerances.
    let h = 1.5 / (gamma_star(3) * norm);
    adams.history.last_step_size = h;
    adams.fastest = crate::integrator::stability::FastestRate::default();
    let (order, size) = chosen(adams, &errors(9.0, 9.0), 0.0);
    assert_eq!(order, 3);
    assert!((size / h - (0.5f64 / 1.5).powf(0.25)).abs() < 1e-12);
}

#[test]
fn a_step_does_not_grow_in_four_steps_after_a_rejected_one_and_grows_slowly_in_sixty() {
    let mut adams = behind_step(2, 5, 2);
    adams.next.steps_of_limited_growth = STEPS_UNTIL_GROWTH + STEPS_OF_SLOW_GROWTH;
    let estimate = ErrorEstimate {
        local: 1e-3,
        ..errors(1.0, 1.0)
    };
    let sizes = [(); 66].map(|()| {
        adams.choose_implicit_order_and_step(&estimate, Some(0.0));
        adams.next.size
    });
    assert_eq!(sizes[..5], [1.0, 1.0, 1.0, 1.0, SLOW_GROWTH]);
    assert_eq!(
        sizes[62..],
        [
            SLOW_GROWTH,
            SLOW_GROWTH,
            LOW_ORDER_CHANGE[1],
            LOW_ORDER_CHANGE[1]
        ]
    );
}

#[test]
fn only_orders_that_stay_low_without_sums_do_without_the_derivative() {
    let needs = |order: usize, max_order: usize, rate: f64, nq: usize| {
        let control = StepControl {
            max_order,
            ..StepControl::default()
        };
        let mut adams = Adams::new(6, control);
        (adams.next.order, adams.next.size) = (order, 1.0);
        adams.fastest.record(rate);
        adams.needs_newest_difference_only(nq)
    };
    assert!(needs(1, 12, 0.0, 3));
    assert!(needs(2, 2, 0.0, 3));
    // A rate above all limits of stability, and one below them: the order may rise.
    assert!(needs(2, 12, 100.0, 3));
    assert!(!needs(2, 12, 0.0, 3));
    assert!(!needs(3, 12, 100.0, 3));
    // Two coordinates and two sums.
    assert!(!needs(1, 12, 0.0, 2));
    assert!(!needs(2, 2, 0.0, 4));
}

#[test]
fn a_step_that_cannot_be_shorter_names_the_component_with_the_largest_error() {
    let (mut adams, mut system) = undisturbed();
    system.singular = u32::MAX;
    let failure = adams.step_newton(&mut system).unwrap_err();
    assert!(
        matches!(failure, StepFailure::TooSmall { .. }),
        "{failure:?}"
    );
    // Rates of the coordinates are the velocities of the last iterate.
    assert_eq!(adams.vectors.derivative[0], adams.vectors.trial[1]);
    assert_eq!(
        adams.next.steps_of_limited_growth,
        STEPS_UNTIL_GROWTH + STEPS_OF_SLOW_GROWTH
    );
    assert!(!adams.next.growing);
}

#[test]
fn after_a_failed_step_dense_output_has_the_state_that_was_reached() {
    let (mut adams, mut system) = undisturbed();
    (system.evaluations, system.change) = (u32::MAX, f64::NAN);
    let reached = adams.y().to_vec();
    let failure = adams.step_newton(&mut system).unwrap_err();
    assert!(
        matches!(failure, StepFailure::NotFinite { .. }),
        "{failure:?}"
    );
    let mut found = vec![0.0; 2];
    adams.interpolate(adams.time(), &mut found);
    assert_eq!(found, reached);
}

#[test]
fn the_difference_above_the_order_is_formed_where_the_order_may_rise() {
    let (mut adams, mut system) = started(1e-6, f64::INFINITY);
    let mut formed = 0;
    for _ in 0..60 {
        if adams.starting {
            adams.step_newton(&mut system).unwrap();
            continue;
        }
        let (estimate, newest_only) = adams.repeat_until_accepted(&mut system).unwrap();
        let (k, h) = (adams.next.order, adams.next.size);
        let may_rise = adams.history.may_raise(k, adams.highest_order(k, h));
        let above = adams.accept_newton(newest_only);
        // The sum is the third component: with it the update is never by the newest difference alone.
        let above = above.unwrap();
        assert_eq!(above > 0.0, may_rise, "{k} {above}");
        formed += u32::from(may_rise);
        adams.choose_implicit_order_and_step(&estimate, Some(above));
    }
    assert!((5..55).contains(&formed), "{formed}");
}

#[test]
fn explicit_steps_are_considered_where_the_choice_is_automatic() {
    for corrector in [Corrector::Auto, Corrector::Newton] {
        let control = StepControl {
            corrector,
            accuracy: 1e-6,
            max_step: 1e-3,
            ..StepControl::default()
        };
        let mut system = started(1e-6, f64::INFINITY).1;
        let mut adams = Adams::new(3, control);
        adams.restart(0.0, &[1.0, 0.0, 0.0]);
        let before = adams.clone();
        adams.step_newton(&mut system).unwrap();
        // What was recorded is kept with the state.
        let unchanged = format!("{:?}", adams.switching) == format!("{:?}", before.switching);
        assert_eq!(unchanged, corrector == Corrector::Newton);
    }
}

/// q'' = f(t) - c (q' - cos t).
struct Driven {
    damping: f64,
    force: fn(f64) -> f64,
    gamma: f64,
}

impl OdeSystem for Driven {
    fn dimension(&self) -> usize {
        2
    }
    fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        let drag = self.damping * (y[1] - t.cos());
        dydt.copy_from_slice(&[y[1], (self.force)(t) - drag]);
    }
}

impl SecondOrderSystem for Driven {
    fn coordinates(&self) -> usize {
        1
    }
    fn factorise(&mut self, _y: &[f64], gamma: f64) -> bool {
        self.gamma = gamma;
        true
    }
    fn correct(&mut self, residual: &mut [f64]) {
        residual[0] /= 1.0 + self.gamma * self.damping;
    }
    fn scale(&self, lengths: &mut [f64]) {
        lengths.fill(1.0);
    }
}

/// An integrator of order two behind 40 steps, most of them of 1 ms.
fn driven(damping: f64, force: fn(f64) -> f64) -> (Adams, Driven) {
    let mut system = Driven {
        damping,
        force,
        gamma: 0.0,
    };
    let control = StepControl {
        accuracy: 1e-7,
        max_step: 1e-3,
        max_order: 2,
        ..StepControl::default()
    };
    let mut adams = Adams::new(2, control);
    adams.restart(0.0, &[0.0, 1.0]);
    for _ in 0..40 {
        adams.step_newton(&mut system).unwrap();
    }
    assert_eq!((adams.history.last_order, adams.next.size), (2, 1e-3));
    (adams, system)
}

#[test]
fn a_velocity_that_alternates_about_its_slow_motion_is_damped() {
    // The step is a thousand times the time constant: the trapezoidal rule alone leaves 0.79 of an alternation after 60 steps.
    let (mut adams, mut system) = driven(1e6, |_| 0.0);
    let mut largest = |adams: &mut Adams, steps: u32| {
        (0..steps).fold(0.0_f64, |most, _| {
            adams.step_newton(&mut system).unwrap();
            let slow = -adams.time().sin();
            most.max((adams.slopes_of_last_step()[1][1] - slow).abs())
        })
    };
    let before = largest(&mut adams, 10);
    // Half of the permitted error of a velocity.
    adams.set_component(1, adams.y()[1] + 5e-3);
    let kicked = largest(&mut adams, 2);
    assert!(kicked > 9.0 && before < 1e-2, "{kicked} {before}");
    largest(&mut adams, 30);
    let after = largest(&mut adams, 28);
    assert!(after < 1e-4 * kicked, "{after}");
}

#[test]
fn a_damped_step_is_one_of_the_modified_formula_of_crank_and_nicolson() {
    let force = |t: f64| 1e3 * t.powi(3);
    for damped in [0, 1] {
        let (mut adams, mut system) = driven(0.0, force);
        adams.alternation.damped_steps = damped;
        let (t, before) = (adams.time(), adams.y()[1]);
        adams.step_newton(&mut system).unwrap();
        let h = adams.time() - t;
        let weights = match damped {
            0 => [0.5, 0.5, 0.0],
            _ => [9.0 / 16.0, 3.0 / 8.0, 1.0 / 16.0],
        };
        let mean: f64 = (weights.into_iter().zip([t + h, t, t - h]))
            .map(|(weight, t)| weight * force(t))
            .sum();
        let found = (adams.y()[1] - before) / h;
        assert!((found - mean).abs() < 1e-9, "{found} {mean}");
    }
}

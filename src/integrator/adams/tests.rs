//! Tests of the integrator's state: what may replace it, its first step, its errors.

use super::*;

/// y' = (y₁, -y₀, 2).
struct Circle;

impl OdeSystem for Circle {
    fn dimension(&self) -> usize {
        3
    }
    fn derivative(&mut self, _t: f64, y: &[f64], dydt: &mut [f64]) {
        dydt.copy_from_slice(&[y[1], -y[0], 2.0]);
    }
}

fn by_component(tolerance: f64) -> StepControl {
    StepControl {
        rtol: tolerance,
        atol: tolerance,
        max_step: 0.5,
        ..StepControl::default()
    }
}

fn started(y: &[f64; 3]) -> Adams {
    let mut adams = Adams::new(3, by_component(1e-6));
    adams.restart(0.0, y);
    adams
}

/// Set the weights and make the start of the first step.
fn begin(adams: &mut Adams, system: &mut impl OdeSystem) {
    let state = (&adams.vectors.y[..], true);
    (adams.norm).update(adams.instructions, &adams.control, system, state);
    adams.start(system);
}

#[test]
fn an_integrator_with_other_lengths_or_no_valid_state_is_not_like_one() {
    let like = Adams::new(3, by_component(1e-6));
    let mut adams = started(&[1.0, 0.0, 0.0]);
    adams.step(&mut Circle).unwrap();
    assert!(adams.is_like(&like));
    assert!(!adams.is_like(&Adams::new(40, by_component(1e-6))));
    let refused = |change: fn(&mut Adams)| {
        let mut changed = adams.clone();
        change(&mut changed);
        !changed.is_like(&like)
    };
    assert!(refused(|adams| adams.vectors = Vectors::new(40)));
    assert!(refused(|adams| adams.norm = ErrorNorm::new(40)));
    assert!(refused(|adams| adams.history = History::new(40)));
    assert!(refused(|adams| adams.history.last_order = MAX_ORDER + 1));
    assert!(refused(
        |adams| adams.history.coefficients.equal_steps = MAX_ORDER + 2
    ));
    assert!(refused(|adams| adams.time = f64::INFINITY));
    assert!(refused(|adams| adams.vectors.y[1] = f64::NAN));
    assert!(refused(|adams| adams.next.order = 0));
    assert!(refused(|adams| adams.next.order = MAX_ORDER + 1));
    assert!(!refused(|adams| adams.next.order = MAX_ORDER));
    assert!(!refused(|adams| adams.history.last_order = MAX_ORDER));
}

#[test]
fn an_integrator_is_starting_until_its_first_step() {
    let mut adams = started(&[1.0, 0.0, 0.0]);
    assert!(adams.is_starting());
    adams.step(&mut Circle).unwrap();
    assert!(!adams.is_starting());
    adams.restart(1.0, &[0.0; 3]);
    assert!(adams.is_starting() && adams.time() == 1.0);
}

#[test]
fn the_slope_is_the_derivative_at_the_solution() {
    let mut adams = started(&[1.0, 0.0, 0.0]);
    for _ in 0..20 {
        adams.step(&mut Circle).unwrap();
        let mut exact = [0.0; 3];
        let [_, slope] = adams.slopes_of_last_step();
        Circle.derivative(adams.time(), adams.y(), &mut exact);
        for (found, exact) in slope.iter().zip(exact) {
            assert!((found - exact).abs() < 1e-13, "{found} {exact}");
        }
    }
}

#[test]
fn the_first_step_follows_the_time_scale_of_the_solution() {
    // |y|/|f| is one; zero initial values have the shortest scale.
    let size = |y: &[f64; 3]| {
        let mut adams = started(y);
        adams.control.rtol = 0.0;
        adams.control.atol = 1e9;
        adams.control.max_step = 1e9;
        begin(&mut adams, &mut Circle);
        adams.step_size()
    };
    let y = [3.0, 4.0, 12.0];
    assert!((size(&y) - 13.0 / 29.0f64.sqrt()).abs() < 1e-12);
    assert_eq!(size(&[0.0; 3]), SHORTEST_SCALE);
}

#[test]
fn sums_are_compensated_where_the_tolerance_is_less_than_a_hundred_roundings() {
    let compensates = |tolerance: f64| {
        let mut adams = started(&[3.0, 4.0, 0.0]);
        adams.control.rtol = 0.0;
        adams.control.atol = tolerance;
        begin(&mut adams, &mut Circle);
        adams.history.differences.compensates()
    };
    // Half of the tolerance over the rounding of a solution of size five.
    let limit = 2.0 * 100.0 * 2.0 * f64::EPSILON * 5.0;
    assert!(compensates(0.99 * limit));
    assert!(!compensates(1.01 * limit));
}

#[test]
fn tolerances_below_rounding_name_the_component_and_the_factor() {
    let mut adams = started(&[3.0, -4.0, 0.0]);
    adams.control.rtol = 0.0;
    // The rounding is twice the tolerance, of which half is permitted.
    adams.control.atol = ROUNDING * 5.0 / 2.0;
    adams.norm.update(
        adams.instructions,
        &adams.control,
        &Circle,
        (&adams.vectors.y, true),
    );
    let failure = adams.check_tolerances(3).unwrap_err();
    let StepFailure::ToleranceTooSmall {
        factor, component, ..
    } = failure
    else {
        panic!("{failure:?}");
    };
    assert!((factor - 4.0).abs() < 1e-12);
    assert_eq!(component, 1);
    // 3 and 4 by weights of 1 and 1/2, both far above the limit: the tolerance counts, not the value.
    let mut weighted = adams.clone();
    weighted.norm.inverse_weight[..3].copy_from_slice(&[1e18, 0.5e18, 1e18]);
    let failure = weighted.check_tolerances(3).unwrap_err();
    assert!(matches!(
        failure,
        StepFailure::ToleranceTooSmall { component: 0, .. }
    ));
    // A rounding of exactly half of the tolerance is permitted.
    let mut exact = started(&[1.0, 0.0, 0.0]);
    exact.norm.inverse_weight[..3].fill(SAFE_ERROR / ROUNDING);
    assert!(exact.check_tolerances(3).is_ok());
    // Checked again after sixteen steps only.
    adams.starting = false;
    adams.counts.steps = 15;
    assert!(adams.check_tolerances(3).is_ok());
    adams.counts.steps = 16;
    assert!(adams.check_tolerances(3).is_err());
}

#[test]
fn event_screening_may_skip_the_accuracy_but_never_less_than_a_nanometre() {
    let allowed = |accuracy: f64| {
        let control = StepControl {
            accuracy,
            ..StepControl::default()
        };
        Adams::new(3, control).allowed()
    };
    assert_eq!([1e-12, 1e-9, 1e-6].map(allowed), [1e-9, 1e-9, 1e-6]);
}

#[test]
fn a_step_lost_in_the_rounding_of_time_names_the_worst_component() {
    let mut adams = started(&[1.0, 0.0, 0.0]);
    adams.step(&mut Circle).unwrap();
    adams
        .history
        .predict(adams.instructions, &adams.next, &mut adams.vectors);
    let phi_1 = adams.history.differences.row(0).to_vec();
    let count = adams.vectors.derivative.len();
    adams.vectors.derivative.copy_from_slice(&phi_1[..count]);
    adams.vectors.derivative[2] += 1.0;
    let before = adams.clone();
    let failure = adams.undo_step(1e-30, 3).unwrap_err();
    assert!(
        matches!(failure, StepFailure::TooSmall { component: 2, .. }),
        "{failure:?}"
    );
    let mut adams = before;
    adams.vectors.derivative[1] = f64::NAN;
    let failure = adams.undo_step(1e-30, 3).unwrap_err();
    assert!(
        matches!(failure, StepFailure::NotFinite { component: 1, .. }),
        "{failure:?}"
    );
}

#[test]
fn a_component_that_is_reset_stays_at_zero_with_its_history() {
    let mut adams = started(&[1.0, 0.0, 0.0]);
    for _ in 0..5 {
        adams.step(&mut Circle).unwrap();
    }
    adams.reset_component(2);
    let [_, slope] = adams.slopes_of_last_step();
    assert_eq!((adams.y()[2], slope[2]), (0.0, 0.0));
    adams.set_component(2, 7.0);
    assert_eq!(adams.y()[2], 7.0);
    assert!(slope[0] != 0.0);
}

#[test]
fn the_first_step_without_any_slope_is_a_second_long() {
    /// y' = 0.
    struct Still;
    impl OdeSystem for Still {
        fn dimension(&self) -> usize {
            3
        }
        fn derivative(&mut self, _t: f64, _y: &[f64], dydt: &mut [f64]) {
            dydt.fill(0.0);
        }
    }
    for y in [[0.0; 3], [1.0, 0.0, 0.0]] {
        let mut adams = started(&y);
        adams.control.max_step = 1e9;
        begin(&mut adams, &mut Still);
        assert_eq!(adams.step_size(), 1.0);
    }
}

#[test]
fn what_is_set_is_what_is_in_use() {
    let mut adams = started(&[1.0, 0.0, 0.0]);
    for set in InstructionSet::available() {
        adams.use_instructions(set);
        assert_eq!(adams.instructions().name(), set.name());
    }
    adams.step(&mut Circle).unwrap();
    let shorter = 0.5 * adams.step_size();
    adams.limit_step(shorter);
    assert_eq!(adams.step_size(), shorter);
}

#[test]
fn a_correction_after_the_last_evaluation_is_that_of_the_velocities() {
    let mut adams = Adams::new(5, by_component(1e-6));
    adams.vectors.residual[..5].copy_from_slice(&[1.0, 2.0, 3.0, 4.0, 5.0]);
    assert!(adams.correction_after_evaluation().is_none());
    adams.convergence.gamma = 0.25;
    assert!(!adams.ended_with_first_correction());
    adams.convergence.unmeasured = true;
    assert!(adams.ended_with_first_correction());
    let (gamma, velocities) = adams.correction_after_evaluation().unwrap();
    assert_eq!((gamma, velocities), (0.25, &[1.0, 2.0][..]));
}

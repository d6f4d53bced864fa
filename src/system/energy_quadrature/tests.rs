//! Tests of the energy quadrature with powers of known integrals.

use super::*;

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
struct Both(f64, f64);

impl PowerSum for Both {
    fn add_scaled(&mut self, factor: f64, other: &Self) {
        self.0 += factor * other.0;
        self.1 += factor * other.1;
    }

    fn totals(&self) -> [f64; 2] {
        [self.0, self.1]
    }

    fn with_external(self, external: f64) -> Self {
        Self(self.0, external)
    }
}

/// The quadrature of `steps` steps of two seconds that end at 2 s, in which the power dissipated is `power`.
fn metered_in(steps: u32, fineness: usize, power: impl Fn(f64) -> f64) -> EnergyQuadrature<Both> {
    let begin = 2.0 - 2.0 * f64::from(steps);
    let mut quadrature = EnergyQuadrature::new();
    quadrature.refine(fineness);
    quadrature.begin(begin, Both(power(begin), 1.0));
    for i in 0..steps {
        let start = begin + 2.0 * f64::from(i);
        add(&mut quadrature, (start, start + 2.0), &power);
    }
    quadrature
}

/// Add a step, between two times, with a dissipated `power` and an external one of 1 W.
fn add(quadrature: &mut EnergyQuadrature<Both>, ends: (f64, f64), power: impl Fn(f64) -> f64) {
    let ((start, end), degree) = (ends, 1);
    let step = Step { start, end, degree };
    // The external part of powers inside the step is not used.
    quadrature.add_step(&step, Both(power(end), 1.0), false, |_, t| {
        Both(power(t), f64::NAN)
    });
}

fn metered(fineness: usize, power: impl Fn(f64) -> f64) -> EnergyQuadrature<Both> {
    metered_in(2, fineness, power)
}

#[test]
fn a_power_of_degree_three_is_summed_exactly() {
    for fineness in [0, 1, 8] {
        let quadrature = metered(fineness, |t| 9.0 + t * t + t.powi(3));
        let exact = 36.0 + 16.0 / 3.0;
        assert!((quadrature.energies(2.0).0 - exact).abs() < 1e-13);
        assert!((quadrature.energies(2.0).1 - 4.0).abs() < 1e-14);
    }
}

#[test]
fn inside_a_step_the_sum_is_that_of_a_parabola() {
    for fineness in [0, 1, 8] {
        let quadrature = metered(fineness, |t| 1.0 + t * t);
        for t in [0.0f64, 0.3, 1.0, 1.7, 2.0] {
            let exact = 2.0 + t + (t.powi(3) + 8.0) / 3.0;
            assert!((quadrature.energies(t).0 - exact).abs() < 1e-13, "{t}");
        }
    }
}

#[test]
fn halved_panels_have_a_sixteenth_of_the_error() {
    let errors = [1, 2, 4, 8].map(|panels| metered(panels, f64::exp).energies(2.0).0);
    let errors = errors.map(|energy| energy - (2f64.exp() - (-2f64).exp()));
    for pair in errors.windows(2) {
        assert!((pair[0] / pair[1] - 16.0).abs() < 2.0, "{errors:?}");
    }
}

#[test]
fn a_power_that_is_nearly_a_parabola_takes_one_evaluation() {
    let quadrature = metered(0, |t| 9.0 + t * t + 1e-2 * t.powi(3));
    // Nothing is known before the first step: it takes two panels to see that one was enough.
    assert_eq!(quadrature.evaluations(), 3 + 1);
}

#[test]
fn a_power_that_begins_within_a_step_takes_more_panels() {
    let power = |begin: f64| move |t: f64| f64::max(t - begin, 0.0).powf(1.5);
    let mut largest = [0.0f64; 2];
    for begin in [0.1, 0.5, 0.9, 1.3, 1.7] {
        // A first step without power, then one in which it begins; errors over the largest power times the length.
        let exact = f64::powf(2.0 - begin, 2.5) / 2.5;
        let scale = 2.0 * power(begin)(2.0);
        let [adapted, single] = [0, 1].map(|fineness| metered(fineness, power(begin)));
        let errors = [&adapted, &single].map(|found| (found.energies(2.0).0 - exact).abs() / scale);
        let needs_more = errors[1] > ACCEPTED_ERROR;
        assert_eq!(adapted.evaluations() > 3 + 1, needs_more, "{begin}");
        for (largest, error) in largest.iter_mut().zip(errors) {
            *largest = largest.max(error);
        }
    }
    // At a kink the error falls by less than a sixteenth when panels are halved: a few times the accepted one is left.
    assert!(largest[0] < 2.5e-2, "{largest:?}");
    assert!(largest[1] > 0.1, "{largest:?}");
}

#[test]
fn a_smooth_power_takes_an_evaluation_in_one_of_32_steps() {
    let power = |t: f64| 2.0 + (0.1 * t).sin();
    let quadrature = metered_in(1000, 0, power);
    let exact = 2.0 * 2000.0 - 10.0 * (0.2f64.cos() - 199.8f64.cos());
    assert!((quadrature.energies(2.0).0 / exact - 1.0).abs() < 1e-5);
    assert!(quadrature.evaluations() < 1000 / 32 + 10);
}

#[test]
fn the_work_is_the_integral_of_a_polynomial_through_powers_at_the_ends_of_steps() {
    let starts = [0.0, 0.7, 1.2, 2.2, 2.5];
    for degree in 0..=4 {
        for exponent in 0..=4u8 {
            let power = |t: f64| t.powi(i32::from(exponent));
            let mut quadrature = EnergyQuadrature::new();
            quadrature.begin(0.0, Both(0.0, power(0.0)));
            for (i, ends) in starts.windows(2).enumerate() {
                let [start, end] = [ends[0], ends[1]];
                let step = Step { start, end, degree };
                quadrature.add_step(&step, Both(0.0, power(end)), false, |_, _| Both(0.0, 0.0));
                // Powers before the first step are not known: a line. At degree zero the power is that at the end from the second step on.
                let exact =
                    usize::from(exponent) <= degree.max(usize::from(i == 0)).min(i + 1).min(3);
                let over = f64::from(exponent + 1);
                let work = (end * power(end) - start * power(start)) / over;
                let found = quadrature.at_end.1 - quadrature.at_start.1;
                assert_eq!(
                    (found - work).abs() < 1e-14,
                    exact,
                    "{degree} {exponent} {i}"
                );
                if degree == 0 && i > 0 {
                    assert!((found - power(end) * (end - start)).abs() < 1e-14);
                }
                assert!((quadrature.energies(end).1 - quadrature.at_end.1).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn the_work_needs_no_evaluations() {
    let external = |t: f64| 1e6 * (0.5 * std::f64::consts::PI * t).sin();
    let mut quadrature = EnergyQuadrature::new();
    quadrature.begin(0.0, Both(0.0, external(0.0)));
    let degree = 1;
    for i in 0..100 {
        let (start, end) = (1.7 * f64::from(i), 1.7 * f64::from(i + 1));
        let (step, before) = (Step { start, end, degree }, quadrature.at_end.1);
        quadrature.add_step(&step, Both(0.0, external(end)), false, |_, _| {
            Both(0.0, f64::NAN)
        });
        let work = quadrature.at_end.1 - before;
        assert!((work - 0.5 * 1.7 * (external(start) + external(end))).abs() < 1e-6);
        // In the middle of the step the power of a line is the mean of both ends.
        let half = quadrature.energies(start + 0.85).1 - before;
        let line = 0.85 * (0.75 * external(start) + 0.25 * external(end));
        assert!((half - line).abs() < 1e-6);
    }
    assert!(quadrature.evaluations() < 20);
}

#[test]
fn the_work_of_a_bent_power_is_integrated_along_the_path() {
    let external = |t: f64| t.powi(3);
    for (along_path, work) in [(true, 4.0), (false, 8.0)] {
        let mut quadrature = EnergyQuadrature::new();
        quadrature.begin(0.0, Both(1.0, external(0.0)));
        let (start, end, degree) = (0.0, 2.0, 1);
        let step = Step { start, end, degree };
        let at_end = Both(1.0, external(end));
        quadrature.add_step(&step, at_end, along_path, |_, t| Both(1.0, external(t)));
        assert!((quadrature.energies(2.0).1 - work).abs() < 1e-14);
    }
}

#[test]
fn a_quarter_of_the_accepted_error_is_that_of_predicted_powers() {
    // A vibration that is zero at the ends of the steps leaves its size in the middle, where Simpson's rule has a weight of 2/3.
    let evaluations = |part: f64| {
        let size = part * 1.5 * ACCEPTED_ERROR * 10.0;
        let power = |t: f64| 10.0 + size * (0.5 * std::f64::consts::PI * t).sin().powi(2);
        metered_in(1000, 0, power).evaluations()
    };
    // Evaluated powers are remembered. They enter the estimated error of the next steps, which exceeds the limit at a smaller size.
    assert_eq!(evaluations(0.05), 24);
    assert!(evaluations(0.1) > 900);
}

#[test]
fn a_step_after_an_evaluated_middle_is_predicted_from_it() {
    // A power of degree three that begins at 0. Powers before that would spoil the prediction in the step from 4 to 6.
    let power = |t: f64| if t < 0.0 { 0.0 } else { 1e4 + t.powi(3) };
    let mut quadrature = EnergyQuadrature::new();
    quadrature.begin(-2.0, Both(power(-2.0), 1.0));
    for start in [-2.0, 0.0, 2.0, 4.0, 6.0] {
        let before = quadrature.evaluations();
        add(&mut quadrature, (start, start + 2.0), power);
        // The step from 4 to 6 is the test that permits this.
        assert_eq!(quadrature.evaluations() == before, start == 6.0, "{start}");
    }
    let exact = 2e4 + (8f64.powi(4) - 6f64.powi(4)) / 4.0;
    assert!((quadrature.energies(8.0).0 - quadrature.energies(6.0).0 - exact).abs() < 1e-9);
}

#[test]
fn powers_before_a_cut_predict_nothing() {
    let power = |t: f64| 2.0 + (0.1 * t).sin();
    // The last step is a test, so that its middle at 1 s is remembered. It would be the middle of the next step, which begins before it with
    // another power.
    let mut quadrature = metered_in(961, 0, power);
    quadrature.cut(0.5);
    let (before, late) = (quadrature.energies(0.5).0, |t: f64| 9.0 + (0.1 * t).cos());
    quadrature.begin(0.5, Both(late(0.5), 1.0));
    let evaluations = quadrature.evaluations();
    for i in 0..4 {
        let start = 0.5 + f64::from(i);
        add(&mut quadrature, (start, start + 1.0), late);
    }
    let exact = 9.0 * 4.0 + 10.0 * (0.45f64.sin() - 0.05f64.sin());
    assert!((quadrature.energies(4.5).0 - before - exact).abs() < 1e-4);
    // Three evaluations in the first step, one in the second, and one in the third as a test. The fourth is predicted.
    assert_eq!(quadrature.evaluations() - evaluations, 3 + 1 + 1);
}

#[test]
fn a_step_has_four_panels_at_most_and_two_where_their_error_is_accepted() {
    let evaluations = |power: fn(f64) -> f64| {
        let first = metered_in(1, 0, power);
        assert!(first.panels() <= MOST_PANELS);
        first.evaluations()
    };
    // One and two panels differ by 0.2 of the largest power times the length.
    assert_eq!(evaluations(|t| if t < 1.3 { 0.0 } else { 1.0 }), 7);
    // A peak in one number: the means of one, two and four panels are 1, 4 and 1.75 W. A fifteenth of each difference is above 0.01 W.
    assert_eq!(evaluations(|t| if t == 0.5 { 10.0 } else { 1.0 }), 7);
    // The mean of t^6 from 0 to 2 is 9.14; one panel gives 11.33 and two give 9.30. A fifteenth of the difference is 0.2 % of the largest
    // power, and the whole difference 3.2 %; 0.5 % is accepted.
    assert_eq!(evaluations(|t| t.powi(6)), 3);
}

#[test]
fn behind_the_last_step_the_sum_grows_with_its_last_power() {
    let quadrature = metered(0, |t| 1.0 + t * t);
    let grown = quadrature.energies(2.5).0 - quadrature.energies(2.0).0;
    assert!((grown - 5.0 * 0.5).abs() < 1e-13, "{grown}");
}

#[test]
fn powers_are_interpolated_where_the_dissipated_one_is_smooth() {
    let predicted = |rough: f64, accepted: f64| {
        let [earliest, earlier, latest, start, end] = [-2.5, -0.7, -0.5, 0.0, 1.0]
            .map(|place| (place, Both(1.0 + rough * f64::powi(place, 4), place)));
        let before = [&earliest, &earlier, &latest].map(|(place, powers)| (*place, powers));
        Predicted::new(before, [&start.1, &end.1], accepted)
    };
    // Quartic and cubic differ by the fourth divided difference, one, times 1.2 times 1.0 times a quarter: 0.3 here.
    assert!(predicted(1.0, 0.301).is_accurate && predicted(-1.0, 0.301).is_accurate);
    assert!(!predicted(1.0, 0.299).is_accurate && !predicted(-1.0, 0.299).is_accurate);
    let found = predicted(1.0, 1.0).powers;
    assert!((found.0 - 1.0625).abs() < 1e-14 && (found.1 - 0.5).abs() < 1e-14);
}

#[test]
fn a_small_power_after_a_large_one_is_measured_by_the_mean_of_all_steps() {
    // A loss of 1 W for half of the time, then a vibration of 1 mW that the ends of steps do not show.
    let power = |t: f64| {
        if t < -998.0 {
            1.0
        } else {
            1e-3 * (0.5 * std::f64::consts::PI * t).sin().powi(2)
        }
    };
    let quadrature = metered_in(1000, 0, power);
    assert!((quadrature.mean_power() - 0.5).abs() < 1e-2);
    assert!(quadrature.evaluations() < 500);
    // Alone, it is measured by itself.
    let alone = metered_in(500, 0, |t| power(t.max(-998.0)));
    assert!(alone.evaluations() >= 500);
    assert!((alone.energies(2.0).0 / (0.5e-3 * 1000.0) - 1.0).abs() < 1e-3);
}

#[test]
fn a_power_that_its_values_at_the_ends_of_steps_do_not_show_is_evaluated_in_each_step() {
    let power = |t: f64| 1.0 + 9.0 * (0.5 * std::f64::consts::PI * t).sin().powi(2);
    let quadrature = metered_in(1000, 0, power);
    assert!((quadrature.energies(2.0).0 / (5.5 * 2000.0) - 1.0).abs() < 1e-3);
    assert!(quadrature.evaluations() >= 1000);
}

#[test]
fn inside_a_late_step_of_several_panels_the_sum_is_that_of_a_parabola() {
    let power = |t: f64| 1.0 + t * t;
    for fineness in [1, 4] {
        let mut quadrature = EnergyQuadrature::new();
        quadrature.refine(fineness);
        quadrature.begin(1.0, Both(power(1.0), 1.0));
        add(&mut quadrature, (1.0, 3.0), power);
        for t in [1.0f64, 1.3, 2.0, 2.9, 3.0] {
            let exact = t - 1.0 + (t.powi(3) - 1.0) / 3.0;
            assert!((quadrature.energies(t).0 - exact).abs() < 1e-13, "{t}");
        }
        let before = quadrature.energies(2.2);
        quadrature.cut(2.2);
        assert_eq!((quadrature.at_end, quadrature.end), (before, 2.2));
    }
}

#[test]
fn a_copy_is_equal_and_only_one_of_the_same_panels_can_replace_it() {
    let quadrature = metered(4, f64::exp);
    let mut copy = EnergyQuadrature::new();
    copy.carry_on(&quadrature);
    copy.count_evaluation();
    assert_eq!(copy.evaluations(), quadrature.evaluations() + 1);
    assert!(copy.is_like(&quadrature) && copy.fineness() == 4);
    assert_eq!(copy.energies(1.3), quadrature.energies(1.3));
    assert!(!metered(8, f64::exp).is_like(&quadrature));
    let changed = |change: fn(&mut EnergyQuadrature<Both>)| {
        let mut copy = quadrature.clone();
        change(&mut copy);
        copy.is_like(&quadrature)
    };
    assert!(!changed(|copy| copy.powers.truncate(8)));
    assert!(!changed(|copy| copy.powers.truncate(7)));
    assert!(!changed(|copy| copy.powers.resize(17, Both(0.0, 0.0))));
    assert!(!changed(|copy| copy.start = 3.0));
    assert!(changed(|copy| copy.start = copy.end));
}

#[test]
fn the_error_of_half_a_step_is_that_of_a_cubic() {
    // x³ differs from its parabola by x (x - 1/2)(x - 1), whose integral over half of the step is 1/64.
    // Where the power begins has no effect.
    let power = |x: f64| Both(5.0 + x.powi(3), 0.0);
    for place in [-0.3, -1.0, -2.5] {
        let error = error_of_half([0.0, 0.5, 1.0].map(power), (place, &power(place)));
        assert!((64.0 * error - 1.0).abs() < 1e-12, "{place}: {error}");
    }
    assert_eq!(decisive(&Both(-1e-3, 1.0)), EXTERNAL_SHARE);
    assert_eq!(decisive(&Both(1e-3, -2.0)), 2.0 * EXTERNAL_SHARE);
    assert_eq!(decisive(&Both(-3e-2, -1.0)), 0.03);
}

#[test]
fn each_passed_test_permits_twice_as_many_interpolated_steps_up_to_63() {
    let mut interpolation = Interpolation::<Both>::default();
    let predicted = |is_accurate| Predicted {
        powers: Both(1.0, 1.0),
        is_accurate,
    };
    assert!(!interpolation.permits(&predicted(true)));
    for expected in [1, 3, 7, 15, 31, 63, 63] {
        interpolation.test(&predicted(true), true);
        let free = (0..80).filter(|_| interpolation.permits(&predicted(true)));
        assert_eq!(free.count(), expected);
    }
    // Powers that are not accurate by their estimate use no permit, and their evaluation is no test.
    interpolation.test(&predicted(true), true);
    assert!(!interpolation.permits(&predicted(false)));
    interpolation.test(&predicted(false), false);
    assert!(interpolation.permits(&predicted(true)));
    interpolation.test(&predicted(true), false);
    assert!(!interpolation.permits(&predicted(true)));
}

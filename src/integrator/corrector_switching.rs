//! Corrector switching: a cost model decides between the explicit and the implicit corrector while running.
//!
//! The explicit corrector is limited by stability where contacts are stiff; the implicit one by accuracy alone, at a higher cost per
//! step. The change is made when the other corrector has been cheaper per simulated second for a number of steps (decision 21).

use super::adams::Adams;
use super::difference_kernels::DerivativeChange;
use super::order_control::gamma_star;
use super::stability::explicit_limit;
use super::step::{Step, StepFailure};
use super::weights::mean_square_factor;
use super::{Corrector, SecondOrderSystem};

/// Cost of an implicit step with one correction, in evaluations: one evaluation, a matrix and a solution.
///
/// Measured on the published drive: 1.25 times an explicit step (decision 20). A constant, not the clock: equal runs take equal steps.
const IMPLICIT_COST: f64 = 2.5;

/// Cost of an implicit step with two corrections: twice an explicit step.
const IMPLICIT_COST_OF_TWO: f64 = 4.0;

/// Cost of an explicit step: two evaluations.
const EXPLICIT_COST: f64 = 2.0;

/// Explicit step size times fastest rate where stability limits the step.
///
/// The rate that Newton's method measures may be below the largest one, so that this is below the limits of stability. Chosen with the other
/// constants of the change as the best of eleven sets (decision 21).
const EXPLICIT_REACH: f64 = 0.4;

/// Share of the stability limit from which on an explicit step counts as limited by it; one of the eleven sets of decision 21.
const NEAR_LIMIT: f64 = 0.5;

/// Highest order at which an explicit step has no advantage of its order: stability or contact onsets limit it (decision 21).
const LOW_ORDER: usize = 4;

/// Error at order two and the present step size, in the norm of the implicit corrector, below which its steps are expected to be 2.5
/// times as long.
///
/// Half of the tolerance in the explicit corrector's norm on the published drive (decision 21).
const PROFITABLE_ERROR: f64 = 0.033;

/// Error at order two, in the norm of the explicit corrector, up to which an unstable step counts in favour of the implicit one. Its third
/// difference is that of a growing vibration, not that of the motion (decision 21).
const UNSTABLE_ERROR: f64 = 0.5;

/// Ratio of costs per simulated second from which on a change pays; one of the eleven sets of decision 21.
const GAIN: f64 = 1.2;

/// Explicit steps from one check to the next: a check is a pass over all components, a tenth of the integrator's own work.
pub(super) const STEPS_PER_CHECK: u32 = 4;

impl Adams {
    /// Make one step with the corrector of [`StepControl::corrector`](super::StepControl::corrector).
    ///
    /// # Errors
    /// When the step size or the tolerances are below rounding.
    pub fn step_second_order(
        &mut self,
        system: &mut impl SecondOrderSystem,
    ) -> Result<Step, StepFailure> {
        if self.is_implicit() {
            self.step_newton(system)
        } else {
            self.step_pece(system)
        }
    }

    /// Return whether the next step uses the implicit corrector.
    #[must_use]
    pub fn is_implicit(&self) -> bool {
        match self.control.corrector {
            Corrector::Auto => self.switching.implicit,
            Corrector::Pece => false,
            Corrector::Newton => true,
        }
    }

    /// Decide after [`STEPS_PER_CHECK`] explicit steps whether the implicit corrector would be cheaper.
    ///
    /// It would be where the explicit step has a low order or is limited by stability, and the error at order two,
    /// `h γ*_2 |φ_3|`, allows a longer step.
    pub(super) fn check_switch_to_implicit(&mut self, system: &impl SecondOrderSystem) {
        // Fastest rate of the explicit steps, for the stability limit below.
        let rate = self.rate_from_slopes(system.coordinates());
        self.fastest.record_after(STEPS_PER_CHECK, rate);
        let (k, h) = (self.history.last_order, self.history.last_step_size);
        // The implicit corrector cannot exceed the longest permitted step either.
        let longest = self.next.is_near_longest(&self.control, h);
        // h ω over its limit at order k.
        let share = h * self.fastest.value() / explicit_limit(k);
        // A low order shows contact onsets in nearly every step.
        let limited = !longest && (k <= LOW_ORDER || share > NEAR_LIMIT);
        // The implicit corrector's norm is a root mean square; that in use is Euclidean.
        let factor = mean_square_factor(&self.control, system.counted()).sqrt();
        let difference = || (self.history).norm_of_difference(self.instructions, &self.norm, 2);
        // Truncation error of the trapezoidal rule for the present step size.
        let at_order_two = || factor * h * gamma_star(2) * difference();
        let profitable = if share > 1.0 {
            PROFITABLE_ERROR.max(UNSTABLE_ERROR * factor)
        } else {
            PROFITABLE_ERROR
        };
        // Below order two there is no third difference to estimate from.
        let pays = limited && (k < 2 || at_order_two() <= profitable);
        self.switching.record(pays, STEPS_PER_CHECK);
    }

    /// Decide after an implicit step whether explicit steps would be cheaper: cost per step over step size.
    pub(super) fn check_switch_to_explicit(&mut self) {
        let h = self.next.size;
        // Expected explicit step: by accuracy at most h, by stability at most a multiple of 1/ω.
        let explicit = h.min(EXPLICIT_REACH / self.fastest.value());
        let cost = if self.convergence.unmeasured {
            IMPLICIT_COST
        } else {
            IMPLICIT_COST_OF_TWO
        };
        // Simulated time per cost of both correctors; the factor prevents changes without gain.
        let pays = explicit / EXPLICIT_COST > GAIN * h / cost;
        // The first explicit step must be inside the stability region.
        if self.switching.record(pays, 1) {
            self.next.size = explicit;
            self.next.damping = 0.0;
        }
    }

    /// Return the rate |Δa|/|Δv| \[1/s\]: change of accelerations over change of velocities between the two evaluations of an explicit
    /// step.
    fn rate_from_slopes(&self, coordinates: usize) -> f64 {
        let velocities = coordinates..2 * coordinates;
        let vectors = &self.vectors;
        let [accelerations, speeds] = self.instructions.run(DerivativeChange {
            derivative: &vectors.derivative[velocities.clone()],
            at_prediction: &vectors.residual[velocities.clone()],
            ends: (
                &vectors.predicted[velocities.clone()],
                &vectors.y[velocities.clone()],
            ),
            inverse_weight: &self.norm.inverse_weight[velocities],
        });
        if speeds > 0.0 {
            (accelerations / speeds).sqrt()
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::stability::FastestRate;
    use crate::integrator::switching_evidence::SWITCH_THRESHOLD;
    use crate::integrator::{OdeSystem, StepControl};

    /// A body of mass one with a damper.
    struct Damped(f64);

    impl OdeSystem for Damped {
        fn dimension(&self) -> usize {
            2
        }
        fn derivative(&mut self, _t: f64, y: &[f64], dydt: &mut [f64]) {
            dydt.copy_from_slice(&[y[1], -self.0 * y[1]]);
        }
    }

    impl SecondOrderSystem for Damped {
        fn coordinates(&self) -> usize {
            1
        }
        fn factorise(&mut self, _y: &[f64], _gamma: f64) -> bool {
            true
        }
        fn correct(&mut self, _residual: &mut [f64]) {}
        fn scale(&self, lengths: &mut [f64]) {
            lengths.fill(1.0);
        }
    }

    /// An integrator behind some explicit steps of at most 1 s from this velocity.
    fn stepped(damping: f64, velocity: f64) -> Adams {
        let control = StepControl {
            rtol: 1e-3,
            atol: 1e-3,
            max_step: 1.0,
            corrector: Corrector::Auto,
            ..StepControl::default()
        };
        let mut adams = Adams::new(2, control);
        adams.restart(0.0, &[0.0, velocity]);
        for _ in 0..5 {
            adams.step_pece(&mut Damped(damping)).unwrap();
        }
        adams
    }

    #[test]
    fn the_rate_of_a_damper_follows_from_the_two_evaluations_of_a_step() {
        let rate = stepped(50.0, 1.0).rate_from_slopes(1);
        assert!((rate / 50.0 - 1.0).abs() < 1e-6, "{rate}");
        // Nothing changes at rest.
        assert_eq!(stepped(50.0, 0.0).rate_from_slopes(1), 0.0);
    }

    #[test]
    fn explicit_steps_pay_where_stability_allows_their_length() {
        let evidence = |unmeasured: bool, rate: f64| {
            let mut adams = stepped(1.0, 0.0);
            adams.switching.implicit = true;
            adams.switching.evidence = 10;
            adams.convergence.unmeasured = unmeasured;
            adams.next.size = 0.5;
            adams.fastest = FastestRate::default();
            adams.fastest.record(rate / 0.5);
            adams.check_switch_to_explicit();
            assert_eq!(adams.next.size, 0.5);
            adams.switching.evidence
        };
        // An explicit step of 0.4 over the rate costs 2; one of h costs 2.5 or 4 and has to gain a fifth.
        assert_eq!(
            [0.1, 0.41, 0.42].map(|rate| evidence(true, rate)),
            [11, 11, 9]
        );
        assert_eq!(
            [0.1, 0.66, 0.67].map(|rate| evidence(false, rate)),
            [11, 11, 9]
        );
        let mut adams = stepped(1.0, 0.0);
        (adams.switching.implicit, adams.switching.evidence) = (true, SWITCH_THRESHOLD - 1);
        adams.convergence.unmeasured = false;
        adams.next.size = 0.5;
        adams.fastest = FastestRate::default();
        adams.fastest.record(1.0);
        adams.check_switch_to_explicit();
        assert!(!adams.switching.implicit);
        assert_eq!(adams.next.size, EXPLICIT_REACH);
    }

    #[test]
    fn implicit_steps_pay_at_low_orders_and_near_the_limit_of_stability() {
        // At rest, where the error at order two is zero.
        let evidence = |order: usize, step: f64, rate: f64| {
            let mut adams = stepped(1.0, 0.0);
            adams.history.last_order = order;
            adams.history.last_step_size = step;
            adams.fastest = FastestRate::default();
            // It fades over the steps of a check.
            adams.fastest.record(rate / 0.95f64.powi(4) / step);
            adams.switching.evidence = 10;
            adams.check_switch_to_implicit(&Damped(1.0));
            adams.switching.evidence
        };
        assert_eq!(evidence(1, 0.4, 0.0), 14);
        assert_eq!(evidence(4, 0.4, 0.0), 14);
        assert_eq!(evidence(5, 0.4, 0.0), 6);
        let limit = 0.5 * explicit_limit(5);
        assert_eq!(evidence(5, 0.4, 1.01 * limit), 14);
        assert_eq!(evidence(5, 0.4, 0.99 * limit), 6);
        // No step may be twice as long.
        assert_eq!(evidence(4, 0.6, 0.0), 6);
    }

    #[test]
    fn the_error_at_order_two_decides_from_order_two_on() {
        let evidence_at = |order: usize, error: f64, share: f64| {
            // The rate of the damper is 50/s.
            let step = share * explicit_limit(order) / 50.0;
            let norm = error / (step * gamma_star(2));
            let mut adams = stepped(50.0, 1.0);
            let control = StepControl {
                max_step: 1e3,
                ..adams.control
            };
            adams.control = control;
            let history = &mut adams.history;
            (history.last_order, history.last_step_size) = (order, step);
            let found = history.norm_of_difference(adams.instructions, &adams.norm, 2);
            assert!(found > 0.0);
            for weight in adams.norm.inverse_weight.iter_mut() {
                *weight *= norm / found;
            }
            adams.switching.evidence = 10;
            adams.check_switch_to_implicit(&Damped(50.0));
            adams.switching.evidence
        };
        let evidence = |order: usize, error: f64| evidence_at(order, error, 0.9);
        // An error above the profitable one; below order two there is none.
        let [above, below] = [1.01, 0.99].map(|share| share * PROFITABLE_ERROR);
        assert_eq!([1, 2, 3].map(|order| evidence(order, above)), [14, 6, 6]);
        assert_eq!([1, 2, 3].map(|order| evidence(order, below)), [14; 3]);
        // Beyond the limit of stability half of the tolerance, which is by component here.
        let unstable = |error: f64| [2, 3].map(|order| evidence_at(order, error, 1.01));
        assert_eq!(unstable(1.01 * UNSTABLE_ERROR), [6; 2]);
        assert_eq!(unstable(0.99 * UNSTABLE_ERROR), [14; 2]);
    }

    #[test]
    fn the_rate_is_that_of_all_velocities() {
        let mut adams = Adams::new(6, StepControl::default());
        adams.norm.inverse_weight.fill(1.0);
        // Coordinates and padding do not count: changes of 3, 4 and 12 for changes of velocities of 1, 2 and 2.
        let vectors = &mut adams.vectors;
        vectors.derivative[..6].copy_from_slice(&[9.0, 9.0, 9.0, 3.0, 4.0, 12.0]);
        vectors.y[..6].copy_from_slice(&[9.0, 9.0, 9.0, 1.0, 2.0, 2.0]);
        assert!((adams.rate_from_slopes(3) - 13.0 / 3.0).abs() < 1e-14);
    }

    #[test]
    fn the_corrector_in_use_is_the_one_that_was_chosen_or_that_of_the_last_change() {
        let mut adams = Adams::new(2, StepControl::default());
        let mut implicit = |corrector: Corrector, switched: bool| {
            adams.control.corrector = corrector;
            adams.switching.implicit = switched;
            adams.is_implicit()
        };
        let [pece, newton, auto] = [Corrector::Pece, Corrector::Newton, Corrector::Auto]
            .map(|corrector| [false, true].map(|switched| implicit(corrector, switched)));
        assert_eq!([pece, newton, auto], [[false; 2], [true; 2], [false, true]]);
    }

    #[test]
    fn explicit_steps_are_checked_every_few_steps_where_the_choice_is_automatic() {
        let control = StepControl {
            accuracy: 1e-6,
            max_step: 1e9,
            ..StepControl::default()
        };
        for corrector in [Corrector::Auto, Corrector::Pece] {
            let mut adams = Adams::new(
                2,
                StepControl {
                    corrector,
                    ..control
                },
            );
            adams.restart(0.0, &[0.0, 1.0]);
            let mut checks = 0;
            for step in 1..=16 {
                let before = adams.switching.steps_since_switch;
                adams.step_pece(&mut Damped(1.0)).unwrap();
                if adams.switching.steps_since_switch != before {
                    assert_eq!(step % STEPS_PER_CHECK, 0);
                    checks += 1;
                }
            }
            let expected = if corrector == Corrector::Auto { 4 } else { 0 };
            assert_eq!(checks, expected);
        }
    }
}

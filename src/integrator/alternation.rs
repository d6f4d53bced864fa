//! Velocities that alternate from step to step, and the damping of the implicit corrector while one does.
//!
//! A velocity that a contact or a film damps far faster than the step returns to its slow motion at once. The trapezoidal rule makes it jump
//! to the other side of this motion, by nearly the same distance, in each step. Forces then alternate between both sides of the slow
//! one. Where they are clipped at zero, their mean is wrong and does work. A weight γ above h/2 damps the alternation, at the same
//! order (decision 19).

use pulp::{Simd, WithSimd};
use serde::{Deserialize, Serialize};

use super::slice_lanes::{At, SliceLanes, SliceLanesMut, each_vector, vector_count};
use crate::math::simd::{InstructionSet, Lanes, Numbers, Squares, padded_zeros};

/// Additional weight of the new derivative in a damped step of order two, in step sizes: γ = (1/2 + 1/16) h.
///
/// Of all A-stable formulas of this family it damps an infinitely fast component most, by a factor of three a step; for equal steps it
/// is the modified Crank-Nicolson formula of Ascher, Ruuth and Wetton (1995).
const DAMPING: f64 = 1.0 / 16.0;

/// Steps with damping after an alternation. Chosen by trial (decision 19).
const DAMPED_STEPS: u32 = 12;

/// Steps of order two from one check to the next: a check is a pass over all velocities. Ringing lasts for many steps.
const STEPS_PER_CHECK: u32 = 2;

/// Checks in a row at which a velocity alternates, from which on steps are damped.
///
/// A vibration that the steps resolve changes the sign of its acceleration's change in one step of several (decision 19).
const CHECKS: f64 = 3.0;

/// Change of a velocity in half a step, in units of its permitted error, from which on an alternation counts.
///
/// Smaller ones do no work that counts. Chosen by trial (decision 19).
const LEAST_CHANGE: f64 = 0.3;

/// Alternations of each velocity, and the damped steps that they have caused.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Alternation {
    /// Checks in a row at which a velocity alternated.
    checks: Numbers,
    steps_until_check: u32,
    pub(super) damped_steps: u32,
}

impl Alternation {
    /// Return the watch over `velocities`.
    pub(super) fn new(velocities: usize) -> Self {
        Self {
            checks: padded_zeros(velocities),
            steps_until_check: STEPS_PER_CHECK,
            damped_steps: 0,
        }
    }

    /// Return whether `other` can be replaced by this watch: as many velocities, and a valid count.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        self.checks.len() == other.checks.len()
            && (1..=STEPS_PER_CHECK).contains(&self.steps_until_check)
    }

    /// Forget all alternations: the last step had another order, or there was none.
    pub(super) fn forget(&mut self) {
        self.checks.fill(0.0);
    }

    /// Check the last step of order two, of size `h`, if it is due.
    ///
    /// `phi_2`, `newest`: φ*_2 and the newest difference of the accelerations; `inverse_weight`: of the velocities.
    pub(super) fn watch(
        &mut self,
        set: InstructionSet,
        h: f64,
        (phi_2, newest): (&[f64], &[f64]),
        inverse_weight: &[f64],
    ) {
        self.steps_until_check -= 1;
        if self.steps_until_check > 0 {
            return;
        }
        self.steps_until_check = STEPS_PER_CHECK;
        let most = set.run(CountAlternations {
            least: LEAST_CHANGE / (0.5 * h),
            phi_2,
            newest,
            inverse_weight,
            checks: &mut self.checks[..inverse_weight.len()],
        });
        if most >= CHECKS {
            self.damped_steps = DAMPED_STEPS;
        }
    }

    /// Return the additional weight of the new derivative in the next step, if that has order two.
    pub(super) fn damping_of_next_step(&mut self) -> f64 {
        if self.damped_steps == 0 {
            return 0.0;
        }
        self.damped_steps -= 1;
        DAMPING
    }
}

/// Count the checks in a row at which each acceleration has changed in two directions in the last two steps; return the largest count.
struct CountAlternations<'a> {
    /// Least change of an acceleration that counts, in units of the permitted error.
    least: f64,
    phi_2: &'a [f64],
    newest: &'a [f64],
    inverse_weight: &'a [f64],
    checks: &'a mut [f64],
}

impl WithSimd for CountAlternations<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let n = self.checks.len();
        let [zero, one, least] = [0.0, 1.0, self.least].map(|value| Lanes::splat(simd, value));
        let phi_2 = SliceLanes::<S>::new(simd, self.phi_2, n);
        let newest = SliceLanes::<S>::new(simd, self.newest, n);
        let inverse_weight = SliceLanes::<S>::new(simd, self.inverse_weight, n);
        let mut checks = SliceLanesMut::<S>::new(simd, self.checks, n);
        let mut most = zero;
        each_vector!(S, n, |at| {
            // φ*_2 is the change in the step before, times the ratio of the step sizes; with the newest difference it is that of the last step.
            let before = phi_2.get(at);
            let last = before + newest.get(at);
            let size = before.abs().min(last.abs()) * inverse_weight.get(at);
            let alternates = (before * last).less(zero).and(size.greater(least));
            let count = alternates.select(checks.get(at) + one, zero);
            most = most.max(count);
            checks.set(at, count);
        });
        most.greatest()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Velocities: whole vectors of every width and a part of one.
    const N: usize = 11;
    /// The velocity that alternates.
    const K: usize = 9;

    /// Watch steps of 2 s whose accelerations change by `changes` from step to step, in velocity K, and grow in the others; return the
    /// number of the first damped step.
    fn first_damped(set: InstructionSet, changes: impl Fn(u32) -> f64) -> Option<u32> {
        let mut alternation = Alternation::new(N);
        (1..40).find(|&step| {
            let (before, last) = (changes(step - 1), changes(step));
            let (mut phi_2, mut newest) = ([1.0; N], [1.0; N]);
            (phi_2[K], newest[K]) = (before, last - before);
            alternation.watch(set, 2.0, (&phi_2, &newest), &[1.0; N]);
            alternation.damping_of_next_step() > 0.0
        })
    }

    #[test]
    fn three_checks_with_an_alternation_above_the_limit_damp() {
        let sign = |step: u32| if step.is_multiple_of(2) { 1.0 } else { -1.0 };
        for set in InstructionSet::available() {
            assert_eq!(first_damped(set, |step| 0.31 * sign(step)), Some(6));
            assert_eq!(first_damped(set, |step| 0.29 * sign(step)), None);
            // The smaller one of two changes counts.
            let unequal = |step: u32| sign(step) * if step.is_multiple_of(2) { 9.0 } else { 0.29 };
            assert_eq!(first_damped(set, unequal), None);
            // A vibration of ten steps a period, and a change in one direction.
            assert_eq!(
                first_damped(set, |step| (0.628 * f64::from(step)).sin()),
                None
            );
            assert_eq!(first_damped(set, |_| 1.0), None);
            // Two checks with an alternation, and none at the third one.
            let short = |step: u32| if step > 4 { 1.0 } else { sign(step) };
            assert_eq!(first_damped(set, short), None);
        }
    }

    #[test]
    fn twelve_steps_are_damped_and_a_step_of_another_order_ends_the_count() {
        let set = InstructionSet::detect();
        let mut alternation = Alternation::new(1);
        let alternate = |alternation: &mut Alternation, steps: u32| {
            for _ in 0..steps {
                alternation.watch(set, 2.0, (&[1.0], &[-2.0]), &[1.0]);
            }
        };
        alternate(&mut alternation, 4);
        alternation.forget();
        alternate(&mut alternation, 4);
        assert_eq!(alternation.damping_of_next_step(), 0.0);
        alternate(&mut alternation, 2);
        let damped = (0..20).filter(|_| alternation.damping_of_next_step() == DAMPING);
        assert_eq!(damped.count(), 12);
    }
}

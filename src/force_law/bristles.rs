//! Bristle friction with sticking: the `LuGre` law.
//!
//! Canudas de Wit, Olsson, Åström and Lischinsky, "A new model for control of systems with friction", IEEE Transactions on Automatic
//! Control 40 (1995) 419. The forces are proportional to the normal force f, as in the amended form for contacts (Canudas de Wit and
//! Tsiotras, Proc. 38th IEEE Conf. on Decision and Control, 1999):
//!
//! dz/dt = s - σ₀ |s| z/g(s),   F = f (σ₀ z + σ₁(s) dz/dt + σ₂ s),   g(s) = `μ_k` + (`μ_s` - `μ_k`) exp(-(|s|/v)^α)
//!
//! With a constant σ₁ the bristles would add energy at slips above 4 g/σ₁ (Barabanov and Ortega, IEEE Transactions on Automatic Control 45
//! (2000) 675). The decreasing σ₁(s) = σ₁/(1 + σ₁ |s|/(4 g)) prevents this at all slips.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, check};
use crate::math::simd::{exp, ln_of_quotient};
use crate::math::{Real, Truth};

/// Lower bound on |s|/v in the power (|s|/v)^α: the logarithm of zero is not finite.
const LEAST_PART: f64 = 1e-300;

/// Largest break-away deflection without a warning \[m\]; larger ones exceed the usual clearances of a drive.
const SOFTEST: f64 = 1e-4;

/// Smallest break-away deflection without a warning \[m\]; steps at usual accuracies do not resolve stiffer bristles.
const STIFFEST: f64 = 1e-8;

/// Parameters of the bristles of one kind of contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LuGre {
    /// `μ_s`, static coefficient: ratio of breakaway force to normal force.
    pub static_coefficient: f64,
    /// `μ_k`, kinetic coefficient: ratio at full slip, without the viscous part.
    pub kinetic_coefficient: f64,
    /// σ₀, bristle stiffness per unit of normal force \[1/m\].
    pub stiffness: f64,
    /// σ₁, bristle damping at rest per unit of normal force \[s/m\].
    pub damping: f64,
    /// σ₂, viscous friction per unit of normal force \[s/m\].
    pub viscous_coefficient: f64,
    /// v, Stribeck speed, at which the coefficient falls \[m/s\].
    pub stribeck_speed: f64,
    /// α, Stribeck exponent, the steepness of the fall.
    pub stribeck_exponent: f64,
}

/// Friction and deflection rate of bristles under a normal force of one newton.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bent {
    /// Ratio of friction to normal force, with the sign of the slip.
    pub share: f64,
    /// dz/dt \[m/s\].
    pub rate: f64,
}

impl LuGre {
    /// Check all numbers.
    ///
    /// # Errors
    /// The error has the field, its value and the permitted range.
    pub fn check(&self, name: &str) -> Result<()> {
        let at = |field: &str| format!("{name}.{field}");
        for (field, value) in [
            ("static_coefficient", self.static_coefficient),
            ("kinetic_coefficient", self.kinetic_coefficient),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Error::invalid(
                    at(field),
                    value,
                    "must be a positive number; for no friction, leave the law out",
                ));
            }
        }
        if self.kinetic_coefficient > self.static_coefficient {
            return Err(Error::invalid(
                at("kinetic_coefficient"),
                self.kinetic_coefficient,
                format!(
                    "must be at most static_coefficient, {}; for friction that grows with the slip, give viscous_coefficient",
                    self.static_coefficient
                ),
            ));
        }
        check::positive(&at("stiffness"), self.stiffness, "1/m")?;
        check::not_negative(&at("damping"), self.damping, "s/m")?;
        check::not_negative(&at("viscous_coefficient"), self.viscous_coefficient, "s/m")?;
        check::positive(&at("stribeck_speed"), self.stribeck_speed, "m/s")?;
        if !(0.1..=10.0).contains(&self.stribeck_exponent) {
            return Err(Error::invalid(
                at("stribeck_exponent"),
                self.stribeck_exponent,
                "must be from 0.1 to 10; measured ones are 0.5 to 2",
            ));
        }
        Ok(())
    }

    /// Return the deflection at which bristles at rest break away, `μ_s`/σ₀ \[m\].
    #[must_use]
    pub fn breakaway(&self) -> f64 {
        self.static_coefficient / self.stiffness
    }

    /// Return a note on a break-away deflection outside of `STIFFEST` to `SOFTEST`, if it is.
    #[must_use]
    pub fn breakaway_note(&self) -> Option<String> {
        let found = self.breakaway();
        let what = format!(
            "bristles break away at a deflection of {found:.1e} m, static_coefficient/stiffness"
        );
        if found > SOFTEST {
            Some(format!(
                "{what}, more than {SOFTEST:.0e} m: contacts oscillate where they should stick; raise stiffness to {:.1e}/m or more",
                self.static_coefficient / SOFTEST
            ))
        } else if found < STIFFEST {
            Some(format!(
                "{what}, less than {STIFFEST:.0e} m: they shorten the steps; reduce stiffness to {:.1e}/m or less",
                self.static_coefficient / STIFFEST
            ))
        } else {
            None
        }
    }

    /// Return g, the coefficient in steady slip without its viscous part.
    #[must_use]
    pub fn coefficient(&self, slip: f64) -> f64 {
        let law = BristleLaw::new((), self);
        let [_, fallen] = law.fall_of(slip.abs());
        law.kinetic + fallen
    }

    /// Return friction and rate of bristles with the deflection `deflection` \[m\] at the slip `slip` \[m/s\].
    #[must_use]
    pub fn bent(&self, deflection: f64, slip: f64) -> Bent {
        let bristles = BristleLaw::new((), self).bend(1.0, slip, deflection, None);
        Bent {
            share: bristles.force,
            rate: bristles.rate,
        }
    }

    /// Return the deflection z = `predicted` + γ dz/dt at the end of an implicit step at the slip `slip` \[m/s\]. The second value is the
    /// slope of [`Bent::share`] with the slip while z follows the slip \[s/m\].
    #[must_use]
    pub fn solve(&self, predicted: f64, gamma: f64, slip: f64) -> (f64, f64) {
        let ahead = Ahead { predicted, gamma };
        let bristles = BristleLaw::new((), self).bend(1.0, slip, 0.0, Some(&ahead));
        (bristles.deflection, bristles.exact_slope)
    }

    /// Return the energy stored by bristles with this deflection, per newton of normal force \[J/N\].
    #[must_use]
    pub fn stored(&self, deflection: f64) -> f64 {
        0.5 * self.stiffness * deflection * deflection
    }
}

/// Data of an implicit step for the bristle deflection: z = `predicted` + γ dz/dt.
#[derive(Clone, Copy)]
pub(crate) struct Ahead<R> {
    /// Part of z that is independent of the rate at the end of the step \[m\].
    pub(crate) predicted: R,
    pub(crate) gamma: R,
}

/// Friction, rate and deflection of the bristles of a contact or of a vector of contacts.
pub(crate) struct BristleForce<R> {
    /// Friction \[N\].
    pub(crate) force: R,
    /// dz/dt \[m/s\].
    pub(crate) rate: R,
    /// z \[m\], the solution of an implicit step or the given deflection.
    pub(crate) deflection: R,
    /// Friction slope at a constant σ₁(s) while z follows the slip, not negative \[N s/m\]; zero for a given z. A chain's matrix must stay
    /// positive definite, as its blocks are factorised without pivoting.
    pub(crate) slope: R,
    /// The same with the change of σ₁(s) and its sign, for mechanisms: the LU factors of their matrix need no definite blocks.
    pub(crate) exact_slope: R,
}

/// The bristle law with precomputed constants, for one contact or a vector of contacts.
#[derive(Clone, Copy)]
pub(crate) struct BristleLaw<R> {
    /// True if α = 2, which requires no logarithm.
    squared: bool,
    kinetic: R,
    /// `μ_s` - `μ_k`.
    fall: R,
    stiffness: R,
    damping: R,
    quarter_damping: R,
    viscous: R,
    /// 1/v.
    over_speed: R,
    exponent: R,
}

impl<R: Real> BristleLaw<R> {
    #[inline(always)]
    pub(crate) fn new(context: R::Context, law: &LuGre) -> Self {
        let splat = |value| R::splat(context, value);
        Self {
            squared: law.stribeck_exponent == 2.0,
            kinetic: splat(law.kinetic_coefficient),
            fall: splat(law.static_coefficient - law.kinetic_coefficient),
            stiffness: splat(law.stiffness),
            damping: splat(law.damping),
            quarter_damping: splat(0.25 * law.damping),
            viscous: splat(law.viscous_coefficient),
            over_speed: splat(1.0 / law.stribeck_speed),
            exponent: splat(law.stribeck_exponent),
        }
    }

    /// Return (|s|/v)^α and (`μ_s` - `μ_k`) exp(-(|s|/v)^α).
    #[inline(always)]
    fn fall_of(&self, speed: R) -> [R; 2] {
        let part = speed * self.over_speed;
        let power = if self.squared {
            part * part
        } else {
            let part = part.max(speed.constant(LEAST_PART));
            exp(ln_of_quotient(part, speed.constant(1.0)) * self.exponent)
        };
        [power, self.fall * exp(-power)]
    }

    /// Return the friction of contacts with the normal force `force` and the slip `slip`. The bristle deflection is `given`, or the
    /// solution of the implicit step `ahead`.
    #[inline(always)]
    pub(crate) fn bend(
        &self,
        force: R,
        slip: R,
        given: R,
        ahead: Option<&Ahead<R>>,
    ) -> BristleForce<R> {
        let (zero, one) = (slip.constant(0.0), slip.constant(1.0));
        let speed = slip.abs();
        let [power, fallen] = self.fall_of(speed);
        let coefficient = self.kinetic + fallen;
        let over = one / coefficient;
        let relaxing = self.stiffness * speed * over;
        let damping = self.damping / self.quarter_damping.mul_add(speed * over, one);
        let (mut deflection, mut slope, mut exact_slope) = (given, zero, zero);
        // z = (predicted + γ s)/(1 + γ σ₀ |s|/g) solves z = predicted + γ dz/dt.
        if let Some(Ahead { predicted, gamma }) = ahead {
            let share = one / gamma.mul_add(relaxing, one);
            deflection = gamma.mul_add(slip, *predicted) * share;
            // σ₀ d(|s|/g)/d|s|, the change of the relaxation rate with the speed.
            let steeper =
                self.stiffness * over * over * (fallen * self.exponent).mul_add(power, coefficient);
            let against = slip.less(zero).select(-deflection, deflection);
            // d(dz/dt)/ds = (1 - σ₀ z d(|s|/g)/ds)/(1 + γ σ₀ |s|/g), because dz/ds = γ d(dz/dt)/ds.
            let of_rate = steeper.negate_mul_add(against, one) * share;
            let bent = self.stiffness.mul_add(*gamma, damping);
            let followed = force * bent.mul_add(of_rate, self.viscous);
            slope = followed.positive_part();
            // dσ₁(s)/d|s| = -σ₁(s)²/4 d(|s|/g)/d|s|; dz/dt in the direction of the slip is |s| - σ₀ |s|/g z.
            let fading = slip.constant(0.25) * damping * damping * steeper / self.stiffness;
            let along = relaxing.negate_mul_add(against, speed);
            exact_slope = (force * fading).negate_mul_add(along, followed);
        }
        // dz/dt = s - σ₀ |s|/g z, and F/f = σ₀ z + σ₁(s) dz/dt + σ₂ s.
        let rate = relaxing.negate_mul_add(deflection, slip);
        let sum = self
            .stiffness
            .mul_add(deflection, damping.mul_add(rate, self.viscous * slip));
        BristleForce {
            force: force * sum,
            rate,
            deflection,
            slope,
            exact_slope,
        }
    }
}

#[cfg(test)]
mod tests {
    use pulp::Simd;

    use super::*;
    use crate::math::simd::testing::{LaneFunction, assert_same_bits, map};
    use crate::math::simd::{InstructionSet, Lanes};

    fn laws() -> Vec<LuGre> {
        let mut laws = Vec::new();
        for (stiffness, damping) in [(1e5, 0.3), (1e4, 0.0), (3e6, 2.0)] {
            for (exponent, viscous) in [(2.0, 0.0), (0.5, 0.4), (1.0, 0.1)] {
                laws.push(LuGre {
                    static_coefficient: 0.15,
                    kinetic_coefficient: 0.1,
                    stiffness,
                    damping,
                    viscous_coefficient: viscous,
                    stribeck_speed: 1e-3,
                    stribeck_exponent: exponent,
                });
            }
        }
        laws
    }

    /// The law as printed at the head of this file.
    fn printed(law: &LuGre, z: f64, slip: f64) -> Bent {
        let fall = law.static_coefficient - law.kinetic_coefficient;
        let part = (slip.abs() / law.stribeck_speed).powf(law.stribeck_exponent);
        let g = law.kinetic_coefficient + fall * (-part).exp();
        let rate = slip - law.stiffness * slip.abs() / g * z;
        let damping = law.damping / (1.0 + law.damping * slip.abs() / (4.0 * g));
        Bent {
            share: law.stiffness * z + damping * rate + law.viscous_coefficient * slip,
            rate,
        }
    }

    struct AtTenNewton(LuGre, f64, usize);

    impl LaneFunction for AtTenNewton {
        #[inline(always)]
        fn of<S: Simd>(&self, x: Lanes<S>) -> Lanes<S> {
            let lanes = BristleLaw::new(x.simd(), &self.0);
            let bent = lanes.bend(x.constant(10.0), x, x.constant(self.1), None);
            [bent.force, bent.rate][self.2]
        }
    }

    #[test]
    fn vectors_give_the_printed_law() {
        let slips: Vec<f64> = (-60..=60).map(|i| 1e-4 * f64::from(i)).collect();
        for law in laws() {
            let z = 0.3 * law.breakaway();
            for which in 0..2 {
                let function = AtTenNewton(law, z, which);
                for set in InstructionSet::available() {
                    for (&slip, found) in slips.iter().zip(map(set, &function, &slips)) {
                        let bent = printed(&law, z, slip);
                        let expected = [10.0 * bent.share, bent.rate][which];
                        let size = [10.0 * (0.15 + law.damping * 6e-3), 0.1][which];
                        assert!(
                            (found - expected).abs() <= 16.0 * f64::EPSILON * size,
                            "{law:?}, {}, {slip}: {found} for {expected}",
                            set.name()
                        );
                    }
                }
                assert_same_bits(|set| map(set, &function, &slips));
            }
        }
    }

    /// Friction at 10 N (0) and its slope (1) at the end of an implicit step of 2 us.
    struct AheadAt(LuGre, f64, usize);

    impl LaneFunction for AheadAt {
        #[inline(always)]
        fn of<S: Simd>(&self, x: Lanes<S>) -> Lanes<S> {
            let lanes = BristleLaw::new(x.simd(), &self.0);
            let ahead = Ahead {
                predicted: x.constant(self.1),
                gamma: x.constant(2e-6),
            };
            let bent = lanes.bend(x.constant(10.0), x, x.constant(0.0), Some(&ahead));
            let wrong = bent.deflection - ahead.gamma.mul_add(bent.rate, ahead.predicted);
            [bent.force, bent.slope, wrong][self.2]
        }
    }

    #[test]
    fn implicit_steps_solve_for_the_bristles_and_know_their_slope() {
        let set = InstructionSet::detect();
        for law in laws() {
            let z = 0.4 * law.breakaway();
            for slip in [-5e-3, -4e-4, 2e-4, 1.5e-3, 0.02] {
                let wrong = map(set, &AheadAt(law, z, 2), &[slip])[0];
                assert!(
                    wrong.abs()
                        < 1e-15 * (1.0 + 1e3 * slip.abs()) * law.breakaway().max(1e-7) * 1e7
                );
                let step = 1e-7 * slip.abs();
                let ends = map(set, &AheadAt(law, z, 0), &[slip - step, slip + step]);
                let expected = (ends[1] - ends[0]) / (2.0 * step);
                let slope = map(set, &AheadAt(law, z, 1), &[slip])[0];
                // The slope neglects the change of σ₁(s) with the slip.
                let scale = 10.0 * (2e-6 * law.stiffness + law.damping + 0.4);
                assert!(
                    (slope - expected.max(0.0)).abs() < 0.05 * scale,
                    "{law:?}, {slip}: {slope} for {expected}"
                );
            }
        }
    }

    #[test]
    fn bristles_store_the_work_of_a_spring() {
        for law in laws() {
            let z = 0.4 * law.breakaway();
            assert!(
                (law.stored(z) / (0.08 * law.static_coefficient * law.breakaway()) - 1.0).abs()
                    < 1e-14
            );
        }
    }

    #[test]
    fn coefficients_are_positive_numbers() {
        for coefficient in [0.0, -0.1, f64::INFINITY, f64::NAN] {
            let law = LuGre {
                static_coefficient: coefficient,
                ..laws()[0]
            };
            assert!(law.check("friction").is_err(), "{coefficient}");
        }
        let with_kinetic = |coefficient: f64| {
            let law = LuGre {
                kinetic_coefficient: coefficient,
                ..laws()[0]
            };
            law.check("friction").is_ok()
        };
        // The kinetic one is at most the static one of 0.15.
        let kinetic = [-0.1, 0.0, 1e-300, 0.15, 0.150_001, f64::NAN].map(with_kinetic);
        assert_eq!(kinetic, [false, false, true, true, false, false]);
        assert!(laws().iter().all(|law| law.check("friction").is_ok()));
    }

    #[test]
    fn the_coefficient_falls_from_the_static_to_the_kinetic_one() {
        for law in laws() {
            assert!((law.coefficient(0.0) - 0.15).abs() < 1e-15);
            for slip in [-0.5, -1e-3, 1e-3, 1e-2] {
                // In steady slip the rate is zero at the deflection g/σ₀ of the printed law.
                let g = law.coefficient(slip);
                let rate = printed(&law, g / law.stiffness * slip.signum(), slip).rate;
                assert!(rate.abs() < 1e-14 * slip.abs(), "{law:?} {slip}: {rate}");
            }
        }
    }

    #[test]
    fn the_solution_of_an_implicit_step_and_its_slope_are_those_of_the_printed_law() {
        let gamma = 2e-6;
        for law in laws() {
            let predicted = 0.4 * law.breakaway();
            for slip in [-5e-3, -4e-4, 2e-4, 1.5e-3, 0.02] {
                let share = |slip: f64| {
                    let (z, _) = law.solve(predicted, gamma, slip);
                    let bent = printed(&law, z, slip);
                    assert!((z - predicted - gamma * bent.rate).abs() < 1e-13 * law.breakaway());
                    bent.share
                };
                let step = 1e-5 * slip.abs();
                let expected = (share(slip + step) - share(slip - step)) / (2.0 * step);
                let (_, slope) = law.solve(predicted, gamma, slip);
                // Central differences: the square of 1e-5, and rounding over 1e-5.
                let scale = gamma * law.stiffness
                    + law.damping
                    + law.viscous_coefficient
                    + share(slip).abs() / slip.abs();
                assert!(
                    (slope - expected).abs() < 1e-8 * scale,
                    "{law:?} {slip}: {slope} {expected}"
                );
            }
            // At rest the slope is that of slip in the positive direction.
            let [at_rest, behind] = [0.0, 1e-300].map(|slip| law.solve(predicted, gamma, slip).1);
            assert!(at_rest == behind || law.stribeck_exponent < 1.0);
        }
    }

    #[test]
    fn only_absurd_bristles_are_doubted() {
        let note = |stiffness| {
            LuGre {
                static_coefficient: 0.1,
                kinetic_coefficient: 0.1,
                stiffness,
                damping: 0.0,
                viscous_coefficient: 0.0,
                stribeck_speed: 1e-3,
                stribeck_exponent: 2.0,
            }
            .breakaway_note()
        };
        assert!(note(1e5).is_none());
        assert!(note(1e2).is_some_and(|note| note.contains("or more")));
        assert!(note(1e9).is_some_and(|note| note.contains("or less")));
    }
}

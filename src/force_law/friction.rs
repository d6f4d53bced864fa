//! Regularised Coulomb friction: the ratio to μ f is a function of the sliding velocity, zero at rest and one at full slip.
//!
//! The three regularisations are those compared by Marques, Flores, Pimenta Claro and Lankarani, "A survey and comparison of several
//! friction force models for dynamic analysis of multibody mechanical systems", Nonlinear Dynamics 86 (2016) 1407. None of them sticks: a
//! contact that would stick creeps, at less than the speed v₁.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, check};
use crate::math::simd::exp;
use crate::math::{Real, Truth};

/// Regularisation: ratio of friction to μ f as a function of the sliding velocity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Regularization {
    /// tanh(v/v₁): smooth everywhere.
    Tanh,
    /// 1 - exp(-3 v/v₁) up to v₁, constant 0.950 above (Threlfall, Mechanism and Machine Theory 13 (1978) 475).
    Threlfall,
    /// Zero up to v₀, then linear to one at v₁ (Ambrósio, in Virtual Nonlinear Multibody Systems, 2003).
    Ambrosio,
}

impl Regularization {
    /// All regularisations.
    pub const ALL: [Self; 3] = [Self::Tanh, Self::Threlfall, Self::Ambrosio];

    /// Return the name used in messages and descriptions.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Tanh => "tanh",
            Self::Threlfall => "threlfall",
            Self::Ambrosio => "ambrosio",
        }
    }
}

/// Coulomb friction of one kind of contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Friction {
    /// Coefficient of friction μ.
    pub coefficient: f64,
    /// Regularisation.
    pub regularization: Regularization,
    /// v₁, the sliding velocity at which friction is (nearly) full \[m/s\].
    pub speed: f64,
    /// v₀ of Ambrósio's regularisation \[m/s\]; zero with the others.
    pub dead_speed: f64,
}

impl Friction {
    /// Check all numbers.
    ///
    /// # Errors
    /// The error has the field, its value and the permitted range.
    pub fn check(&self, name: &str) -> Result<()> {
        if !(self.coefficient > 0.0 && self.coefficient.is_finite()) {
            return Err(Error::invalid(
                format!("{name}.coefficient"),
                self.coefficient,
                "must be a positive number; for no friction, leave the law out",
            ));
        }
        check::positive(&format!("{name}.speed"), self.speed, "m/s")?;
        check::not_negative(&format!("{name}.dead_speed"), self.dead_speed, "m/s")?;
        let dead = format!("{name}.dead_speed");
        match self.regularization {
            Regularization::Ambrosio if self.dead_speed >= self.speed => Err(Error::invalid(
                dead,
                format!("{} m/s", self.dead_speed),
                format!("must be less than speed, {} m/s", self.speed),
            )),
            Regularization::Tanh | Regularization::Threlfall if self.dead_speed > 0.0 => {
                Err(Error::invalid(
                    dead,
                    format!("{} m/s", self.dead_speed),
                    "belongs to regularization=\"ambrosio\": leave it at 0, or choose that",
                ))
            }
            _ => Ok(()),
        }
    }

    /// Return friction over μ f at a sliding velocity \[m/s\], with its sign, and the friction slope \[s/m\]; NaN is kept.
    #[must_use]
    pub fn share(&self, slip: f64) -> (f64, f64) {
        let [share, slope] = RegularizedFriction::new((), self).share(slip);
        (if slip.is_nan() { slip } else { share }, slope)
    }
}

/// Regularised Coulomb friction with precomputed constants, for one contact or a vector of contacts.
#[derive(Clone, Copy)]
pub(crate) struct RegularizedFriction<R> {
    regularization: Regularization,
    coefficient: R,
    dead_speed: R,
    /// 1/v₁, or 1/(v₁ - v₀).
    over: R,
}

impl<R: Real> RegularizedFriction<R> {
    #[inline(always)]
    pub(crate) fn new(context: R::Context, friction: &Friction) -> Self {
        let splat = |value| R::splat(context, value);
        Self {
            regularization: friction.regularization,
            coefficient: splat(friction.coefficient),
            dead_speed: splat(friction.dead_speed),
            over: splat(1.0 / (friction.speed - friction.dead_speed)),
        }
    }

    /// Return the result of [`Friction::share`] for a slip that is not NaN.
    #[inline(always)]
    fn share(&self, slip: R) -> [R; 2] {
        let (zero, one) = (slip.constant(0.0), slip.constant(1.0));
        let speed = slip.abs();
        let (share, slope) = match self.regularization {
            // tanh(x) = (1 - e^(-2x))/(1 + e^(-2x)), with the slope (1 - tanh²)/v₁.
            Regularization::Tanh => {
                let rest = exp(speed * self.over * slip.constant(-2.0));
                let share = (one - rest) / (one + rest);
                (share, share.negate_mul_add(share, one) * self.over)
            }
            Regularization::Threlfall => {
                let part = speed * self.over;
                let full = part.less(one).not();
                let three = slip.constant(3.0);
                let rest = exp(-(three * full.select(one, part)));
                (one - rest, full.select(zero, three * rest * self.over))
            }
            Regularization::Ambrosio => {
                let part = ((speed - self.dead_speed) * self.over).positive_part();
                let full = part.less(one).not();
                let outside = full.or(part.greater(zero).not());
                (full.select(one, part), outside.select(zero, self.over))
            }
        };
        [slip.less(zero).select(-share, share), slope]
    }

    /// Return friction \[N\] of contacts with the normal force `force` \[N\] at a sliding velocity \[m/s\], with its sign, and its slope
    /// \[N s/m\].
    #[inline(always)]
    pub(crate) fn force(&self, force: R, slip: R) -> [R; 2] {
        let most = self.coefficient * force;
        let [share, slope] = self.share(slip);
        [most * share, most * slope]
    }
}

#[cfg(test)]
mod tests {
    use pulp::Simd;

    use super::*;
    use crate::math::simd::testing::{LaneFunction, assert_same_bits, map};
    use crate::math::simd::{InstructionSet, Lanes};

    fn friction(regularization: Regularization) -> Friction {
        Friction {
            coefficient: 0.5,
            regularization,
            speed: 1e-3,
            dead_speed: if regularization == Regularization::Ambrosio {
                2e-4
            } else {
                0.0
            },
        }
    }

    #[test]
    fn friction_opposes_slip_grows_with_it_and_reaches_its_limit() {
        for regularization in Regularization::ALL {
            let law = friction(regularization);
            assert_eq!(law.share(0.0).0, 0.0);
            let mut before = 0.0;
            for i in 1..=400 {
                let (share, slope) = law.share(1e-5 * f64::from(i));
                assert!(share >= before && slope >= 0.0, "{regularization:?}");
                assert_eq!(law.share(-1e-5 * f64::from(i)), (-share, slope));
                before = share;
            }
            let limit = match regularization {
                Regularization::Threlfall => 1.0 - (-3f64).exp(),
                _ => 1.0,
            };
            assert!((law.share(1.0).0 - limit).abs() < 1e-15);
            assert!(law.share(f64::NAN).0.is_nan());
        }
    }

    #[test]
    fn slopes_are_those_of_differences() {
        for regularization in Regularization::ALL {
            let law = friction(regularization);
            for slip in [-2.3e-3, -7e-4, 1e-4, 5e-4, 9e-4, 4e-3] {
                let step = 1e-9;
                let slope = (law.share(slip + step).0 - law.share(slip - step).0) / (2.0 * step);
                assert!(
                    (law.share(slip).1 - slope).abs() < 1e-4,
                    "{regularization:?} {slip}"
                );
            }
        }
    }

    /// The printed formula.
    fn printed(law: &Friction, slip: f64) -> f64 {
        let part = slip.abs() / law.speed;
        let share = match law.regularization {
            Regularization::Tanh => part.tanh(),
            Regularization::Threlfall => 1.0 - (-3.0 * part.min(1.0)).exp(),
            Regularization::Ambrosio => {
                let band = law.speed - law.dead_speed;
                ((slip.abs() - law.dead_speed) / band).clamp(0.0, 1.0)
            }
        };
        share.copysign(slip)
    }

    struct AtTenNewton(Friction);

    impl LaneFunction for AtTenNewton {
        #[inline(always)]
        fn of<S: Simd>(&self, x: Lanes<S>) -> Lanes<S> {
            RegularizedFriction::new(x.simd(), &self.0).force(x.constant(10.0), x)[0]
        }
    }

    #[test]
    fn vectors_give_the_printed_regularisations() {
        let slips: Vec<f64> = (-60..=60).map(|i| 1e-4 * f64::from(i)).collect();
        for regularization in Regularization::ALL {
            let law = friction(regularization);
            let function = AtTenNewton(law);
            for set in InstructionSet::available() {
                for (&slip, found) in slips.iter().zip(map(set, &function, &slips)) {
                    let expected = 5.0 * printed(&law, slip);
                    // Near rest 1 - exp() cancels: the error is absolute, in units of rounding of the limit.
                    assert!(
                        (found - expected).abs() <= 8.0 * f64::EPSILON * 5.0,
                        "{regularization:?}, {}, {slip}: {found} for {expected}",
                        set.name()
                    );
                }
            }
            assert_same_bits(|set| map(set, &function, &slips));
        }
    }

    #[test]
    fn friction_and_its_slope_are_proportional_to_the_normal_force() {
        for regularization in Regularization::ALL {
            let law = friction(regularization);
            let (share, slope) = law.share(-7e-4);
            let found = RegularizedFriction::new((), &law).force(30.0, -7e-4);
            // μ f = 0.5 · 30 N
            assert!(
                (found[0] - 15.0 * share).abs() < 1e-13,
                "{regularization:?}"
            );
            assert!((found[1] - 15.0 * slope).abs() < 1e-9, "{regularization:?}");
        }
    }

    #[test]
    fn friction_without_meaning_is_refused_with_the_name_of_its_field() {
        let refused = |regularization, change: fn(&mut Friction)| {
            let mut law = friction(regularization);
            assert!(law.check("Friction").is_ok());
            change(&mut law);
            law.check("Friction").unwrap_err().to_string()
        };
        for bad in [
            refused(Regularization::Tanh, |law| law.coefficient = 0.0),
            refused(Regularization::Tanh, |law| law.coefficient = f64::INFINITY),
        ] {
            assert!(bad.starts_with("Friction.coefficient"), "{bad}");
        }
        assert!(refused(Regularization::Tanh, |law| law.speed = 0.0).contains("Friction.speed"));
        for bad in [
            refused(Regularization::Tanh, |law| law.dead_speed = 1e-5),
            refused(Regularization::Ambrosio, |law| law.dead_speed = -1e-5),
            refused(Regularization::Ambrosio, |law| law.dead_speed = law.speed),
        ] {
            assert!(bad.starts_with("Friction.dead_speed"), "{bad}");
        }
    }
}

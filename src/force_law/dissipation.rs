//! Restitution-based damping: the factor on the elastic force during compression and restitution.
//!
//! Every law here is 1 + λ δ'/δ'₀ with its own λ of the requested restitution; the laws differ in the effective restitution. The forms are
//! those of Machado, Moreira, Flores and Lankarani, "Compliant contact force models in multibody dynamics: evolution of the Hertz contact
//! theory", Mechanism and Machine Theory 53 (2012) 99. The variants have the original papers, and the forms agree with public code of
//! multibody programs. One of these programs halves Hu and Guo's λ. That λ dissipates half of the requested energy even near `c_e` = 1, in
//! contradiction to the paper; a test checks λ in that limit.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::math::Real;

/// The damping part of a force law.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Damping {
    /// No damping: the contact is elastic.
    None,
    /// 3 (1 - `c_e`)/2 (Hunt and Crossley 1975). The original law is 1 + (3/2) α δ' with a constant α of the material, so that `c_e` = 1 -
    /// α δ'₀ falls with speed. Here `c_e` is the constant.
    HuntCrossley,
    /// 3 (1 - `c_e²)/4` (Lankarani and Nikravesh 1990).
    LankaraniNikravesh,
    /// 6 (1 - `c_e`)/((2 `c_e` - 1)² + 3) (Herbert and `McWhannell` 1977).
    HerbertMcWhannell,
    /// 3 (1 - `c_e)/4` (Lee and Wang 1983). It dissipates about half of the requested energy even near `c_e` = 1.
    LeeWang,
    /// 8 (1 - `c_e`)/(5 `c_e`) (Flores, Machado, Silva and Martins 2011).
    Flores,
    /// (1 - `c_e²)/c_e` (Gonthier, `McPhee`, Lange and Piedboeuf 2004), the first approximation of their implicit equation.
    /// [`effective_restitution`] solves that equation.
    Gonthier,
    /// 3 (1 - `c_e`)/(2 `c_e`) (Hu and Guo 2015).
    HuGuo,
    /// 3 (1 - `c_e²`) exp(2 (1 - `c_e))/4` (Zhiying and Qishao 2006).
    ZhiyingQishao,
}

/// Smallest restitution permitted with the laws that divide by it; λ exceeds 100 below.
const LEAST_RESTITUTION: f64 = 0.01;

impl Damping {
    /// All laws with damping.
    pub const ALL: [Self; 8] = [
        Self::HuntCrossley,
        Self::LankaraniNikravesh,
        Self::HerbertMcWhannell,
        Self::LeeWang,
        Self::Flores,
        Self::Gonthier,
        Self::HuGuo,
        Self::ZhiyingQishao,
    ];

    /// Return the name used in messages and descriptions.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "None",
            Self::HuntCrossley => "hunt-crossley",
            Self::LankaraniNikravesh => "lankarani-nikravesh",
            Self::HerbertMcWhannell => "herbert-mcwhannell",
            Self::LeeWang => "lee-wang",
            Self::Flores => "flores",
            Self::Gonthier => "gonthier",
            Self::HuGuo => "hu-guo",
            Self::ZhiyingQishao => "zhiying-qishao",
        }
    }

    /// Return λ of the factor 1 + λ δ'/δ'₀ for the restitution coefficient `c_e`, 0 to 1.
    #[must_use]
    pub fn lambda(self, restitution: f64) -> f64 {
        let e = restitution;
        match self {
            Self::None => 0.0,
            Self::HuntCrossley => 1.5 * (1.0 - e),
            Self::LankaraniNikravesh => 0.75 * (1.0 - e * e),
            Self::HerbertMcWhannell => 6.0 * (1.0 - e) / ((2.0 * e - 1.0).powi(2) + 3.0),
            Self::LeeWang => 0.75 * (1.0 - e),
            Self::Flores => 1.6 * (1.0 - e) / e,
            Self::Gonthier => (1.0 - e * e) / e,
            Self::HuGuo => 1.5 * (1.0 - e) / e,
            Self::ZhiyingQishao => 0.75 * (1.0 - e * e) * (2.0 * (1.0 - e)).exp(),
        }
    }

    /// Check that the law has a bounded λ for this restitution.
    ///
    /// # Errors
    /// The error has `field`, the value, the permitted range and alternative laws.
    pub fn check(self, field: &str, restitution: f64) -> Result<()> {
        let divides = matches!(self, Self::Flores | Self::Gonthier | Self::HuGuo);
        if !divides || restitution >= LEAST_RESTITUTION {
            return Ok(());
        }
        Err(Error::invalid(
            field,
            restitution,
            format!(
                "must be at least {LEAST_RESTITUTION} with damping=\"{}\", which grows without limit towards 0: raise it, or \
                 choose \"hunt-crossley\", \"lankarani-nikravesh\", \"herbert-mcwhannell\" or \"zhiying-qishao\"",
                self.name()
            ),
        ))
    }
}

/// Return the factor 1 + λ δ'/δ'₀, bounded below by zero: damping causes no tensile force. NaN is kept.
#[inline(always)]
pub(super) fn factor<R: Real>(lambda: R, rate: R, inverse_impact_velocity: R) -> R {
    let one = rate.constant(1.0);
    (lambda * rate)
        .mul_add(inverse_impact_velocity, one)
        .positive_part()
}

/// Return the factor of one contact with the initial impact velocity δ'₀ = `impact_velocity` \[m/s\].
#[must_use]
pub fn damping_factor(lambda: f64, rate: f64, impact_velocity: f64) -> f64 {
    factor(lambda, rate, 1.0 / impact_velocity)
}

/// Return the effective restitution e' of a factor with `lambda` >= 0, independent of elastic law, mass and speed.
///
/// It solves λ (1 + e') = ln[(1 + λ)/(1 - λ e')] by bisection; for Lankarani-Nikravesh with `c_e` = 0.71 it is 0.8005.
#[must_use]
pub fn effective_restitution(lambda: f64) -> f64 {
    // The equation in terms of h has no cancellation: λ² h(λ) = (λ e')² h(-λ e'). The excess falls from positive at e' = 0 to negative
    // before the pole at λ e' = 1.
    let approach = logarithm_rest(lambda);
    let excess = |e: f64| approach - e * e * logarithm_rest(-lambda * e);
    let (mut low, mut high) = (0.0, 1.0f64.min(1.0 / lambda));
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if excess(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// Return h(x) = (x - ln(1 + x))/x² for x > -1; 1/2 at zero.
fn logarithm_rest(x: f64) -> f64 {
    // The closed form suffers cancellation for small |x|; 18 terms of Σ (-x)^k/(k + 2) replace it there.
    if x.abs() > 0.1 {
        return (x - x.ln_1p()) / (x * x);
    }
    (0..18)
        .rev()
        .fold(0.0, |sum, k| 1.0 / f64::from(k + 2) - x * sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damping_never_pulls() {
        assert!(damping_factor(0.4, -1.0, 1e-3).abs() < f64::EPSILON);
        assert!((damping_factor(0.4, 1e-3, 1e-3) - 1.4).abs() < 1e-15);
        assert!(damping_factor(0.4, f64::NAN, 1e-3).is_nan());
    }

    #[test]
    fn seed_restitution_gives_0_8005() {
        let lambda = Damping::LankaraniNikravesh.lambda(0.71);
        assert!((effective_restitution(lambda) - 0.8005).abs() < 5e-5);
    }

    #[test]
    fn no_damping_gives_back_all_speed() {
        assert_eq!(effective_restitution(0.0), 1.0);
        for damping in Damping::ALL {
            assert_eq!(effective_restitution(damping.lambda(1.0)), 1.0);
        }
    }

    #[test]
    fn near_one_the_loss_is_what_is_asked_but_for_three_laws() {
        // e' = 1 - 2 λ/3 + O(λ²).
        for damping in Damping::ALL {
            let share = (1.0 - effective_restitution(damping.lambda(1.0 - 1e-6))) / 1e-6;
            let expected = match damping {
                Damping::LeeWang => 0.5,
                Damping::Flores => 16.0 / 15.0,
                Damping::Gonthier => 4.0 / 3.0,
                _ => 1.0,
            };
            assert!((share - expected).abs() < 1e-5, "{damping:?} {share}");
        }
    }

    #[test]
    fn laws_that_diverge_are_refused_near_zero_with_value_and_remedy() {
        for damping in Damping::ALL {
            for asked in [0.0, 0.0099] {
                let refusal = damping.check("Material.restitution", asked);
                let finite = damping.lambda(asked) < 20.0;
                assert_eq!(refusal.is_ok(), finite, "{damping:?}");
                if let Err(error) = refusal {
                    let text = error.to_string();
                    assert!(text.starts_with(&format!("Material.restitution = {asked}: ")));
                    assert!(text.contains(damping.name()) && text.contains("hunt-crossley"));
                }
            }
            assert!(damping.check("Material.restitution", 0.01).is_ok());
            assert!(damping.lambda(0.01) < 160.0);
        }
    }

    #[test]
    fn every_law_has_its_printed_factor_at_a_restitution_of_three_tenths() {
        let expected = [
            1.5 * 0.7,
            0.75 * 0.91,
            4.2 / 3.16,
            0.525,
            11.2 / 3.0,
            0.91 / 0.3,
            3.5,
            0.6825 * 1.4f64.exp(),
        ];
        for (damping, expected) in Damping::ALL.into_iter().zip(expected) {
            let found = damping.lambda(0.3);
            assert!(
                (found / expected - 1.0).abs() < 1e-14,
                "{damping:?} {found}"
            );
        }
        assert_eq!(Damping::None.lambda(0.3), 0.0);
    }

    #[test]
    fn the_effective_restitution_solves_the_printed_equation() {
        for lambda in [0.05, 0.2, 0.9, 3.0, 20.0f64] {
            let e = effective_restitution(lambda);
            let right = (lambda.ln_1p() - (-lambda * e).ln_1p()) / (1.0 + e);
            // Near the pole at λ e' = 1 the logarithm amplifies the rounding of e'.
            assert!(
                (right / lambda - 1.0).abs() < 1e-12 / (1.0 - lambda * e),
                "{lambda}"
            );
        }
    }
}

//! Restitution-based damping: the factor on the elastic force while two surfaces approach or part.

/// The damping part of a force law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Damping {
    /// None: the contact is elastic.
    None,
    /// 1 + 3 (1 - `c_e²)/4` δ'/δ'₀ (Lankarani and Nikravesh 1990).
    LankaraniNikravesh,
}

impl Damping {
    /// λ of the factor 1 + λ δ'/δ'₀ for the restitution coefficient `c_e`.
    #[must_use]
    pub fn lambda(self, restitution: f64) -> f64 {
        match self {
            Self::None => 0.0,
            Self::LankaraniNikravesh => 0.75 * (1.0 - restitution * restitution),
        }
    }
}

/// The factor 1 + λ δ'/δ'₀, never negative: damping does not pull. Not a number stays so.
#[must_use]
#[inline]
pub fn damping_factor(lambda: f64, rate: f64, onset_speed: f64) -> f64 {
    let factor = 1.0 + lambda * rate / onset_speed;
    if factor < 0.0 { 0.0 } else { factor }
}

/// The restitution e' that a factor with `lambda` really gives, whatever the stiffness, mass and speed.
///
/// It solves λ (1 + e') = ln[(1 + λ)/(1 - λ e')]; for Lankarani-Nikravesh with `c_e` = 0.71 it is 0.8005.
#[must_use]
pub fn restitution_obtained(lambda: f64) -> f64 {
    let excess = |e: f64| lambda * (1.0 + e) - ((1.0 + lambda) / (1.0 - lambda * e)).ln();
    let (mut low, mut high) = (0.0, 1.0f64.min(1.0 / lambda));
    // The excess falls from positive at e' = 0 to negative before the pole.
    while high - low > 1e-15 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if excess(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
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
        assert!((restitution_obtained(lambda) - 0.8005).abs() < 5e-5);
    }
}

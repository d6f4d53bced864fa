//! Force laws of a single contact: numbers in, newtons out; no bodies.
//!
//! A law is an elastic part times a damping factor, f = elastic(δ) · max(0, 1 + λ δ' / δ'₀), so that any two combine. Friction is a share
//! of μ f. A lubricant film is a separate law beside it.

// A law over vectors must be inlined into the kernel that selected the instruction set.
#![allow(clippy::inline_always)]

mod bristles;
mod conformal;
mod contact_lane;
mod dissipation;
mod elastic;
mod enhanced_cylinder;
mod film;
mod friction;
mod hertz;
mod in_series;
mod line_contact;
mod logarithmic;
mod power;
#[cfg(test)]
mod testing;
mod vector_forces;

pub(crate) use bristles::{Ahead, BristleLaw};
pub use bristles::{Bent, LuGre};
pub(crate) use conformal::Conformal;
pub(crate) use contact_lane::{ContactLane, RestitutionDamping};
pub use dissipation::{Damping, damping_factor, effective_restitution};
pub(crate) use elastic::past_range;
pub(crate) use elastic::{Definition, Form};
pub use elastic::{Elastic, ElasticPair, PairTable, elastic_forces, range_note};
pub(crate) use film::FilmLaw;
pub use film::{Film, FilmForce, HingeFilm};
pub(crate) use friction::RegularizedFriction;
pub use friction::{Friction, Regularization};
pub(crate) use hertz::Hertz;
pub(crate) use in_series::depth_in_series;
pub(crate) use logarithmic::Logarithmic;
pub(crate) use power::Power;
pub use vector_forces::VectorForces;

use serde::{Deserialize, Serialize};

use crate::error::{Result, check};
use crate::geometry::{SurfaceCurve, ToothProfile};
use crate::math::Real;

/// Internal contact (a cylinder in a bore or on a concave flank) or external contact (two convex cylinders).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // the names say it
pub enum Conformity {
    Internal,
    External,
}

/// Pair of contact surfaces as needed by the force laws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePair {
    /// Internal or external contact.
    pub conformity: Conformity,
    /// ΔR \[m\]: `R_j - R_i` of internal contacts, `R_i + R_j` of external contacts.
    pub radius_difference: f64,
    /// `R_i R_j / ΔR` \[m\].
    pub effective_radius: f64,
    /// Contact length L \[m\].
    pub length: f64,
    /// E* \[Pa\]: 1/E* = (1 - `nu_i²)/E_i` + (1 - `nu_j²)/E_j`.
    pub contact_modulus: f64,
}

impl SurfacePair {
    /// Return the pair of a cylinder of radius `inner` in a bore of radius `outer`.
    #[must_use]
    pub fn internal(inner: f64, outer: f64, length: f64, contact_modulus: f64) -> Self {
        let radius_difference = outer - inner;
        Self {
            conformity: Conformity::Internal,
            radius_difference,
            effective_radius: inner * outer / radius_difference,
            length,
            contact_modulus,
        }
    }

    /// Return the pair of two convex cylinders.
    #[must_use]
    pub fn external(radius_i: f64, radius_j: f64, length: f64, contact_modulus: f64) -> Self {
        let radius_difference = radius_i + radius_j;
        Self {
            conformity: Conformity::External,
            radius_difference,
            effective_radius: radius_i * radius_j / radius_difference,
            length,
            contact_modulus,
        }
    }

    /// Return the pair of a cylinder on a flat that continues as a convex curve of `next_radius`.
    ///
    /// The flat has no radius. Hertz's law uses the limit `R_j` to infinity; laws without that limit use ΔR of the next curve.
    #[must_use]
    pub fn flat(radius: f64, next_radius: f64, length: f64, contact_modulus: f64) -> Self {
        Self {
            conformity: Conformity::External,
            radius_difference: radius + next_radius,
            effective_radius: radius,
            length,
            contact_modulus,
        }
    }
}

/// Elastic part of a force law in one of its forms, or in a form chosen at run time ([`Form`]); two constants for each pair of surfaces.
pub(crate) trait ElasticLaw: Copy {
    /// Return the elastic force \[N\] at penetrations δ >= 0 \[m\]; zero at zero; NaN is kept.
    fn elastic<R: Real>(self, pair: [R; 2], penetration: R) -> R;

    /// Return the elastic force, and the square root in it. Where a law has none, it returns the force again.
    #[inline(always)]
    fn elastic_and_root<R: Real>(self, pair: [R; 2], penetration: R) -> [R; 2] {
        [self.elastic(pair, penetration); 2]
    }

    /// Return the slope df/dδ \[N/m\] from the penetration, its force and the square root in it; zero at zero.
    fn slope<R: Real>(self, pair: [R; 2], penetration: R, force_and_root: [R; 2]) -> R;

    /// Return the energy stored at a penetration δ > 0 \[J\], the integral of the force, whose value there is `force`.
    fn stored(self, pair: &[f64; 2], penetration: f64, force: f64) -> f64;

    /// Return the penetration \[m\] at which the law's range ends.
    fn range_end(self, _pair: &[f64; 2]) -> f64 {
        f64::INFINITY
    }

    /// Return the elastic force \[N\] at any penetration \[m\]; zero for δ <= 0.
    fn force(self, pair: &[f64; 2], penetration: f64) -> f64 {
        if penetration <= 0.0 {
            return 0.0;
        }
        self.elastic(*pair, penetration)
    }

    /// Return the slope df/dδ \[N/m\]; zero for δ <= 0.
    fn stiffness(self, pair: &[f64; 2], penetration: f64) -> f64 {
        if penetration <= 0.0 {
            return 0.0;
        }
        self.slope(
            *pair,
            penetration,
            self.elastic_and_root(*pair, penetration),
        )
    }

    /// Return the energy stored at any penetration \[J\]; zero for δ <= 0.
    fn energy(self, pair: &[f64; 2], penetration: f64) -> f64 {
        if penetration <= 0.0 {
            return 0.0;
        }
        self.stored(pair, penetration, self.force(pair, penetration))
    }

    /// Return the sum of the energies stored at these penetrations \[J\].
    fn energy_of_all(self, pair: &[f64; 2], penetrations: &[f64]) -> f64 {
        let mut sum = 0.0;
        // The energies of a block may be computed side by side, their sum is one after the other.
        for block in penetrations.chunks(32) {
            let mut energies = [0.0; 32];
            for (energy, &penetration) in energies.iter_mut().zip(block) {
                *energy = self.energy(pair, penetration);
            }
            for energy in &energies[..block.len()] {
                sum += energy;
            }
        }
        sum
    }
}

/// Stiffness of a loaded contact that moves from one region of a tooth to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Regions {
    /// Stiffness of the region at contact onset, kept until contact end: the energy balance closes.
    Kept,
    /// Stiffness of the present region: the force jumps at the junctions, as in the paper.
    Sharp,
}

/// Complete normal force law.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ForceLaw {
    /// Elastic part.
    pub elastic: Elastic,
    /// Damping part.
    pub damping: Damping,
    /// Stiffness at transitions between the regions of a tooth.
    pub regions: Regions,
}

impl ForceLaw {
    /// Check the law itself, and that it applies to a material of this `restitution`, whose field is `field`.
    ///
    /// # Errors
    /// The error has the field, its value and the permitted range.
    pub fn check(&self, field: &str, restitution: f64) -> Result<()> {
        if let Elastic::Linear(stiffness) = self.elastic {
            check::positive("Linear.stiffness", stiffness, "N/m")?;
        }
        self.damping.check(field, restitution)
    }
}

impl Default for ForceLaw {
    fn default() -> Self {
        Self {
            elastic: Elastic::Hertz,
            damping: Damping::LankaraniNikravesh,
            regions: Regions::Kept,
        }
    }
}

/// Return the radius \[m\] that stands for straight surface `i` of a profile in laws that need one: that of the convex arc that continues
/// it, or the pitch radius. An arc of less than the `radius` of the cylinder is an edge, which is not a curve that continues the flat.
pub(crate) fn radius_beside_flat(profile: &ToothProfile, i: usize, radius: f64) -> f64 {
    match profile.surfaces().get(i + 1).map(|next| next.curve) {
        Some(SurfaceCurve::Convex(arc)) if arc.radius >= radius => arc.radius,
        _ => profile.pitch_radius,
    }
}

/// A cylinder of `radius` against every surface of a profile.
pub(crate) fn tooth_surfaces(
    profile: &ToothProfile,
    radius: f64,
    length: f64,
    modulus: f64,
) -> Vec<SurfacePair> {
    let surfaces = profile.surfaces();
    let pair = |(i, curve): (usize, &SurfaceCurve)| match curve {
        SurfaceCurve::Concave(arc) => SurfacePair::internal(radius, arc.radius, length, modulus),
        SurfaceCurve::Convex(arc) => SurfacePair::external(radius, arc.radius, length, modulus),
        SurfaceCurve::Straight(_) => {
            let next = radius_beside_flat(profile, i, radius);
            SurfacePair::flat(radius, next, length, modulus)
        }
    };
    let curves = surfaces.iter().map(|piece| &piece.curve);
    curves.enumerate().map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Seat;

    #[test]
    fn two_convex_cylinders_have_the_radius_of_the_sum_of_curvatures() {
        let pair = SurfacePair::external(3e-3, 6e-3, 0.01, 1e11);
        assert!((1.0 / pair.effective_radius - (1.0 / 3e-3 + 1.0 / 6e-3)).abs() < 1e-9);
        assert!((pair.radius_difference - 9e-3).abs() < 1e-17);
        let flat = SurfacePair::flat(3e-3, 6e-3, 0.01, 1e11);
        assert!((flat.radius_difference - 9e-3).abs() < 1e-17);
        assert_eq!(flat.effective_radius, 3e-3);
    }

    #[test]
    fn each_surface_of_a_tooth_has_the_pair_of_its_curve() {
        let (pitch, roller) = (12.7e-3, 7.9375e-3);
        let profile = ToothProfile::ansi(pitch, roller, 17, Seat::PitchCircle);
        let radius = 0.5 * roller;
        let pairs = tooth_surfaces(&profile, radius, 7e-3, 1e11);
        let topping = profile.ansi_curves().unwrap().topping.radius;
        for (surface, pair) in profile.surfaces().iter().zip(&pairs) {
            let expected = match surface.curve {
                SurfaceCurve::Concave(arc) => SurfacePair::internal(radius, arc.radius, 7e-3, 1e11),
                SurfaceCurve::Convex(arc) => SurfacePair::external(radius, arc.radius, 7e-3, 1e11),
                SurfaceCurve::Straight(_) => SurfacePair::flat(radius, topping, 7e-3, 1e11),
            };
            assert_eq!(*pair, expected, "{}", surface.name);
        }
        assert_eq!(pairs.len(), 4);
        // A convex curve below the cylinder's radius is an edge; the one of equal radius continues the flat.
        assert_eq!(radius_beside_flat(&profile, 2, topping), topping);
        assert_eq!(
            radius_beside_flat(&profile, 2, 1.001 * topping),
            profile.pitch_radius
        );
    }

    #[test]
    fn a_law_of_no_stiffness_or_too_little_restitution_is_refused() {
        let linear = |stiffness| ForceLaw {
            elastic: Elastic::Linear(stiffness),
            damping: Damping::HuGuo,
            ..ForceLaw::default()
        };
        assert!(linear(1e8).check("restitution", 0.5).is_ok());
        assert!(linear(0.0).check("restitution", 0.5).is_err());
        assert!(linear(1e8).check("restitution", 1e-3).is_err());
    }
}

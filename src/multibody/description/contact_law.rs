//! Normal force of one contact of a mechanism: the published laws, a linear law and the law of Hunt and Crossley.

use crate::error::{Error, Result, check};
use crate::force_law::{
    ContactLane, Elastic, ElasticPair, ForceLaw, RestitutionDamping, SurfacePair, range_note,
};

use super::outline_piece::Curvature;

/// Normal force law of a contact.
#[derive(Debug, Clone, PartialEq)]
pub enum ContactLaw {
    /// A law of cylinders with its damping; stiffness and restitution are those of the material.
    Surfaces {
        /// The law.
        law: ForceLaw,
        /// Contact modulus E* \[Pa\].
        contact_modulus: f64,
        /// Restitution coefficient.
        restitution: f64,
        /// Length of contact \[m\].
        length: f64,
        /// Minimum impact velocity: lower bound on the initial impact velocity used by the damping factor \[m/s\].
        min_impact_velocity: f64,
    },
    /// Linear law K δ + c δ', with zero as its lower bound.
    Linear {
        /// Stiffness K \[N/m\].
        stiffness: f64,
        /// Damping coefficient c \[N s/m\].
        damping: f64,
    },
    /// Law K δ^n (1 + χ δ'), with zero as its lower bound (Hunt and Crossley 1975).
    HuntCrossley {
        /// Stiffness K \[N/m^n\].
        stiffness: f64,
        /// Exponent n.
        exponent: f64,
        /// Damping coefficient χ \[s/m\].
        damping: f64,
    },
}

impl ContactLaw {
    /// Check every field.
    ///
    /// # Errors
    /// An invalid value; the message has `field`, the value and the permitted values.
    pub fn validate(&self, field: &str) -> Result<()> {
        let of = |name: &str| format!("{name} of {field}");
        match self {
            Self::Surfaces {
                law,
                contact_modulus,
                restitution,
                length,
                min_impact_velocity,
            } => {
                check::positive(&of("contact modulus"), *contact_modulus, "Pa")?;
                check::within(&of("restitution"), *restitution, 0.0, 1.0)?;
                law.check(&of("restitution"), *restitution)?;
                check::positive(&of("min_impact_velocity"), *min_impact_velocity, "m/s")?;
                check::positive(&of("length"), *length, "m")
            }
            Self::Linear { stiffness, damping } => {
                check::positive(&of("stiffness"), *stiffness, "N/m")?;
                check::not_negative(&of("damping"), *damping, "N s/m")
            }
            Self::HuntCrossley {
                stiffness,
                exponent,
                damping,
            } => {
                check::positive(&of("stiffness"), *stiffness, "N/m^n")?;
                check::within(&of("exponent"), *exponent, 1.0, 10.0)?;
                check::not_negative(&of("damping"), *damping, "s/m")
            }
        }
    }

    /// Return the length of contact \[m\], if the law has one.
    pub(crate) fn length(&self) -> Option<f64> {
        match self {
            Self::Surfaces { length, .. } => Some(*length),
            Self::Linear { .. } | Self::HuntCrossley { .. } => None,
        }
    }

    /// Return the published law of the elastic force, if it is one.
    pub(crate) fn elastic(&self) -> Option<Elastic> {
        match self {
            Self::Surfaces { law, .. } => Some(law.elastic),
            Self::Linear { .. } | Self::HuntCrossley { .. } => None,
        }
    }

    /// Return the law with the reason why it is outside its range on a surface with a `curvature` at any penetration, if it is.
    pub(crate) fn range_note(&self, radius: f64, curvature: Curvature) -> Option<String> {
        let Self::Surfaces {
            law,
            contact_modulus,
            length,
            ..
        } = self
        else {
            return None;
        };
        // Surfaces that are refused have no law.
        let pair = surfaces("", radius, curvature, *length, *contact_modulus).ok()?;
        range_note(law.elastic, &pair)
    }

    /// Return whether damping can reduce the force to zero during penetration. The elastic energy is then lost without a force, which
    /// only the powers of the energy balance include.
    pub(crate) fn may_part_under_load(&self) -> bool {
        match self {
            Self::Linear { damping, .. } | Self::HuntCrossley { damping, .. } => *damping > 0.0,
            Self::Surfaces {
                law, restitution, ..
            } => law.damping.lambda(*restitution) > 0.0,
        }
    }

    /// Return the law with its constants for a circle of `radius` \[m\] on a surface with a `curvature`.
    pub(crate) fn prepare(
        &self,
        field: &str,
        radius: f64,
        curvature: Curvature,
    ) -> Result<CompiledLaw> {
        let (elastic, damping) = match self {
            Self::Linear { stiffness, damping } => (
                ElasticPair::power(*stiffness, 1.0),
                DampingPart::Linear(*damping),
            ),
            Self::HuntCrossley {
                stiffness,
                exponent,
                damping,
            } => (
                ElasticPair::power(*stiffness, *exponent),
                DampingPart::Proportional(*damping),
            ),
            Self::Surfaces {
                law,
                contact_modulus,
                restitution,
                length,
                min_impact_velocity,
            } => {
                let pair = surfaces(field, radius, curvature, *length, *contact_modulus)?;
                let damping = RestitutionDamping {
                    lambda: law.damping.lambda(*restitution),
                    minimum: *min_impact_velocity,
                };
                (
                    ElasticPair::prepare(law.elastic, &pair),
                    DampingPart::Restitution(damping),
                )
            }
        };
        Ok(CompiledLaw { elastic, damping })
    }
}

/// Return the pair of surfaces of a circle and a surface with a curvature.
fn surfaces(
    field: &str,
    radius: f64,
    curvature: Curvature,
    length: f64,
    modulus: f64,
) -> Result<SurfacePair> {
    Ok(match curvature {
        // Laws that need a radius of the flat use that of the circle, as for two equal cylinders.
        Curvature::Flat => SurfacePair::flat(radius, radius, length, modulus),
        Curvature::FlatBefore(next) => SurfacePair::flat(radius, next, length, modulus),
        Curvature::Convex(other) => SurfacePair::external(radius, other, length, modulus),
        Curvature::Concave(other) if other > radius => {
            SurfacePair::internal(radius, other, length, modulus)
        }
        Curvature::Concave(other) => {
            return Err(Error::invalid(
                format!("radius of {field}"),
                radius,
                format!("must be below the {other} m of the surface that it is inside of"),
            ));
        }
    })
}

/// Damping of a law.
#[derive(Debug, Clone, Copy)]
enum DampingPart {
    /// Additive force c δ', with c \[N s/m\].
    Linear(f64),
    /// Factor 1 + χ δ', with χ \[s/m\].
    Proportional(f64),
    /// Factor 1 + λ δ'/δ'₀, with the initial impact velocity δ'₀.
    Restitution(RestitutionDamping<f64>),
}

/// A law with the constants of one pair of surfaces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CompiledLaw {
    pub(crate) elastic: ElasticPair,
    damping: DampingPart,
}

/// Normal force of a contact and its elastic part \[N\], and the power dissipated by damping \[W\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct ContactForce {
    pub(crate) total: f64,
    pub(crate) elastic: f64,
    pub(crate) dissipated: f64,
}

impl CompiledLaw {
    /// Return the force at penetration δ \[m\] and rate δ' \[m/s\]; `onset` is the initial impact velocity \[m/s\], zero without memory.
    pub(crate) fn force(&self, penetration: f64, rate: f64, onset: f64) -> ContactForce {
        if penetration <= 0.0 {
            return ContactForce::default();
        }
        let elastic = self.elastic.force(penetration);
        let (total, dissipated) = if let DampingPart::Linear(c) = self.damping {
            let total = (elastic + c * rate).max(0.0);
            (total, (total - elastic) * rate)
        } else {
            let contact = self.damped(elastic, rate, onset);
            (contact.force, contact.power())
        };
        ContactForce {
            total,
            elastic,
            dissipated,
        }
    }

    /// Return the contact with its damping factor.
    fn damped(&self, elastic: f64, rate: f64, onset: f64) -> ContactLane<f64> {
        let (memory, damping) = match self.damping {
            DampingPart::Linear(_) => return ContactLane::undamped(elastic),
            // λ = χ at an impact velocity of 1 m/s gives the factor 1 + χ δ'.
            DampingPart::Proportional(chi) => (
                1.0,
                RestitutionDamping {
                    lambda: chi,
                    minimum: 1.0,
                },
            ),
            DampingPart::Restitution(damping) if onset > 0.0 => (1.0 / onset, damping),
            DampingPart::Restitution(damping) => (0.0, damping),
        };
        ContactLane::damped(elastic, true, rate, memory, damping)
    }

    /// Return the force of [`Self::force`] \[N\] and its derivatives with respect to penetration \[N/m\] and rate \[N s/m\].
    pub(crate) fn slopes(&self, penetration: f64, rate: f64, onset: f64) -> [f64; 3] {
        let ContactForce { total, elastic, .. } = self.force(penetration, rate, onset);
        if total <= 0.0 {
            return [0.0; 3];
        }
        let contact = self.damped(elastic, rate, onset);
        let [stiffness, damping] = contact.slopes(self.elastic.stiffness(penetration));
        match self.damping {
            DampingPart::Linear(c) => [total, stiffness, c],
            _ => [total, stiffness, damping],
        }
    }

    /// Return the elastic energy at penetration δ \[m\].
    pub(crate) fn energy(&self, penetration: f64) -> f64 {
        self.elastic.energy(penetration)
    }

    /// Return the initial impact velocity to store for an onset at `rate` \[m/s\]. It is above zero for every law, as zero means no
    /// memory.
    pub(crate) fn onset_speed(&self, rate: f64) -> f64 {
        match self.damping {
            DampingPart::Restitution(damping) => rate.max(damping.minimum),
            _ => rate.max(f64::MIN_POSITIVE),
        }
    }

    /// Return whether a stored initial impact velocity \[m/s\] is the lower bound of the law.
    pub(crate) fn is_at_minimum(&self, onset: f64) -> bool {
        matches!(self.damping, DampingPart::Restitution(damping) if onset <= damping.minimum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force_law::tooth_surfaces;
    use crate::geometry::{Blank, Seat, ToothProfile};
    use crate::multibody::description::profile::Profile;

    #[test]
    fn the_energy_is_the_integral_of_the_elastic_force() {
        for law in [
            ContactLaw::Linear {
                stiffness: 3e6,
                damping: 0.0,
            },
            ContactLaw::HuntCrossley {
                stiffness: 4e9,
                exponent: 1.5,
                damping: 0.3,
            },
        ] {
            let pair = law.prepare("x", 0.01, Curvature::Flat).unwrap();
            let (d, h) = (2e-5, 1e-9);
            let slope = (pair.energy(d + h) - pair.energy(d - h)) / (2.0 * h);
            assert!((slope / pair.force(d, 0.0, 0.0).elastic - 1.0).abs() < 1e-7);
        }
    }

    /// Return a profile with straight flanks of a sprocket, whose edges have `edge_radius` \[m\].
    fn straight(edge_radius: f64) -> ToothProfile {
        let blank = Blank {
            pitch: 0.0127,
            roller_diameter: 0.0079,
            teeth: 19,
            seat: Seat::BottomDiameter,
            outside_radius: 0.0408,
            edge_radius,
        };
        ToothProfile::straight(&blank, 0.004, 0.3).unwrap()
    }

    #[test]
    fn teeth_have_the_stiffness_of_a_drive_beside_flats_and_edges() {
        let (radius, length, contact_modulus, depth) = (0.00395, 0.01, 1e11, 2e-6);
        for (profile, elastic) in [0.0, 2e-4, 5e-4].into_iter().flat_map(|edge_radius| {
            let profile = straight(edge_radius);
            [Elastic::Hertz, Elastic::Johnson].map(|elastic| (profile.clone(), elastic))
        }) {
            let law = ContactLaw::Surfaces {
                law: ForceLaw {
                    elastic,
                    ..ForceLaw::default()
                },
                contact_modulus,
                restitution: 0.9,
                length,
                min_impact_velocity: 1e-3,
            };
            let of_drive = tooth_surfaces(&profile, radius, length, contact_modulus);
            let curvatures = Profile::Teeth(Box::new(profile)).curvatures(radius);
            assert!(curvatures.len() >= 2 && curvatures.len() == of_drive.len());
            assert!(matches!(curvatures[1], Curvature::FlatBefore(_)));
            for (pair, curvature) in of_drive.iter().zip(curvatures) {
                let found = law.prepare("x", radius, curvature).unwrap();
                let expected = ElasticPair::prepare(elastic, pair).force(depth);
                let found = found.force(depth, 0.0, 0.0).elastic;
                // A sharp edge has no finite stiffness.
                assert!(found == expected || found.is_nan() && expected.is_nan());
                assert!(expected > 0.0 || curvature == Curvature::Convex(0.0));
            }
        }
    }

    #[test]
    fn no_law_pulls() {
        for law in [
            ContactLaw::Linear {
                stiffness: 3e6,
                damping: 1e6,
            },
            ContactLaw::HuntCrossley {
                stiffness: 4e9,
                exponent: 1.5,
                damping: 3.0,
            },
        ] {
            let pair = law.prepare("x", 0.01, Curvature::Flat).unwrap();
            assert_eq!(pair.force(1e-6, -10.0, 0.0).total, 0.0);
            assert!(pair.force(1e-6, 0.1, 0.0).total > 0.0);
        }
    }

    #[test]
    fn a_pin_must_fit_its_bore() {
        let law = ContactLaw::Surfaces {
            law: ForceLaw::default(),
            contact_modulus: 1e11,
            restitution: 0.9,
            length: 0.01,
            min_impact_velocity: 1e-3,
        };
        let error = law
            .prepare("contact \"A\"", 0.01, Curvature::Concave(0.009))
            .unwrap_err();
        assert!(error.to_string().contains("contact \"A\""));
    }
}

//! Elastic laws selected by name, and their constants for every pair of surfaces.
//!
//! A law of an existing form requires only its constants. Each kernel contains all forms and branches once per vector.

use serde::{Deserialize, Serialize};

use super::{ElasticLaw, Power, SurfacePair, conformal, enhanced_cylinder, hertz, line_contact};
use crate::math::Real;

/// Definition of an elastic law selected by name.
pub(crate) struct Definition {
    /// The name used in messages and descriptions.
    pub(crate) name: &'static str,
    /// Computes the constants of its form for one pair.
    pub(crate) prepare: fn(&SurfacePair) -> [f64; 2],
    /// Return the reason why the law is outside its range for these surfaces at any penetration, if it is.
    pub(crate) range_note: fn(&SurfacePair) -> Option<String>,
}

/// Define all laws, form by form.
macro_rules! elastic_laws {
    ($($form:ident { $($(#[$doc:meta])* $law:ident = $definition:expr;)+ })+) => {
        /// Elastic law selected by the user.
        #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
        pub enum Elastic {
            $($($(#[$doc])* $law,)+)+
            /// Constant stiffness \[N/m\], independent of the surfaces.
            Linear(f64),
        }

        impl Elastic {
            /// Laws determined by surfaces and material alone.
            pub const ALL: [Self; [$($(stringify!($law),)+)+].len()] = [$($(Self::$law,)+)+];

            /// Return the definition; none for the linear law, whose stiffness is given.
            fn definition(self) -> Option<&'static Definition> {
                match self {
                    $($(Self::$law => Some(&$definition),)+)+
                    Self::Linear(_) => None,
                }
            }

            fn form(self) -> Form {
                match self {
                    $($(Self::$law => Form::$form,)+)+
                    Self::Linear(_) => Form::Power,
                }
            }
        }

        /// Form of an elastic law.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[allow(missing_docs)] // the names are descriptive
        pub(crate) enum Form {
            $($form,)+
        }

        impl ElasticLaw for Form {
            #[inline(always)]
            fn elastic<R: Real>(self, pair: [R; 2], penetration: R) -> R {
                self.elastic_and_root(pair, penetration)[0]
            }

            #[inline(always)]
            fn elastic_and_root<R: Real>(self, pair: [R; 2], penetration: R) -> [R; 2] {
                match self {
                    $(Self::$form => super::$form.elastic_and_root(pair, penetration),)+
                }
            }

            #[inline(always)]
            fn slope<R: Real>(self, pair: [R; 2], penetration: R, force_and_root: [R; 2]) -> R {
                match self {
                    $(Self::$form => super::$form.slope(pair, penetration, force_and_root),)+
                }
            }

            fn stored(self, pair: &[f64; 2], penetration: f64, force: f64) -> f64 {
                match self {
                    $(Self::$form => super::$form.stored(pair, penetration, force),)+
                }
            }

            fn range_end(self, pair: &[f64; 2]) -> f64 {
                match self {
                    $(Self::$form => super::$form.range_end(pair),)+
                }
            }

            fn energy_of_all(self, pair: &[f64; 2], penetrations: &[f64]) -> f64 {
                match self {
                    $(Self::$form => super::$form.energy_of_all(pair, penetrations),)+
                }
            }

            fn force(self, pair: &[f64; 2], penetration: f64) -> f64 {
                match self {
                    $(Self::$form => super::$form.force(pair, penetration),)+
                }
            }

            fn stiffness(self, pair: &[f64; 2], penetration: f64) -> f64 {
                match self {
                    $(Self::$form => super::$form.stiffness(pair, penetration),)+
                }
            }
        }
    };
}

// A new law takes a file and a line here. A new form takes a name with braces around its laws.
elastic_laws! {
    Hertz {
        /// Hertz's law for spheres, as used by Lankarani and Nikravesh.
        Hertz = hertz::HERTZ;
    }
    Logarithmic {
        /// Johnson's cylinders.
        Johnson = line_contact::JOHNSON;
        /// Hertz's cylinders as two half-planes.
        HertzCylinder = line_contact::HERTZ_CYLINDER;
        /// Radzimovsky's cylinders.
        Radzimovsky = line_contact::RADZIMOVSKY;
        /// Item 78035 of the Engineering Sciences Data Unit.
        Esdu78035 = line_contact::ESDU_78035;
    }
    Power {
        /// The enhanced cylindrical law of Pereira, Ramalho and Ambrósio, coefficients of 2010.
        EnhancedCylinder = enhanced_cylinder::ENHANCED_CYLINDER;
        /// The enhanced cylindrical law with the coefficients of 2015.
        EnhancedCylinder2015 = enhanced_cylinder::ENHANCED_CYLINDER_2015;
    }
    Conformal {
        /// Liu, Zhang and Yang's conformal cylinders.
        LiuConformal = conformal::LIU_CONFORMAL;
    }
}

impl Elastic {
    /// Return the name used in messages and descriptions.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.definition().map_or("linear", |law| law.name)
    }

    /// Return true if the law's range ends at some penetration.
    #[must_use]
    pub fn has_an_end(self) -> bool {
        self.form() == Form::Logarithmic
    }

    /// Return the constants of one pair.
    fn prepare(self, surfaces: &SurfacePair) -> [f64; 2] {
        match (self, self.definition()) {
            (Self::Linear(stiffness), _) => Power::constants(stiffness, 1.0),
            (_, Some(law)) => (law.prepare)(surfaces),
            (_, None) => [0.0; 2],
        }
    }
}

/// Form and constants of all pairs of one group.
#[derive(Debug, Clone)]
pub struct PairTable {
    form: Form,
    pairs: Vec<[f64; 2]>,
}

impl PairTable {
    /// Return the constants of `law` for every pair.
    #[must_use]
    pub fn prepare(law: Elastic, surfaces: &[SurfacePair]) -> Self {
        Self {
            form: law.form(),
            pairs: surfaces.iter().map(|pair| law.prepare(pair)).collect(),
        }
    }

    /// Return the form of the law.
    pub(crate) fn form(&self) -> Form {
        self.form
    }

    /// Return the constants of every pair.
    pub(crate) fn pairs(&self) -> &[[f64; 2]] {
        &self.pairs
    }

    /// Return pair `i` alone.
    #[must_use]
    pub fn pair(&self, i: usize) -> ElasticPair {
        ElasticPair {
            form: self.form,
            constants: self.pairs[i],
        }
    }
}

/// Constants of one pair, for single forces outside the kernels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElasticPair {
    form: Form,
    constants: [f64; 2],
}

impl ElasticPair {
    /// Return the constants of `law` for one pair.
    #[must_use]
    pub fn prepare(law: Elastic, surfaces: &SurfacePair) -> Self {
        Self {
            form: law.form(),
            constants: law.prepare(surfaces),
        }
    }

    /// Return the law K δ^n, K in N/m^n.
    #[must_use]
    pub fn power(stiffness: f64, exponent: f64) -> Self {
        Self {
            form: Form::Power,
            constants: Power::constants(stiffness, exponent),
        }
    }

    /// Return the elastic force \[N\] at penetration δ \[m\]; zero for δ <= 0; NaN is kept.
    #[must_use]
    pub fn force(&self, penetration: f64) -> f64 {
        self.form.force(&self.constants, penetration)
    }

    /// Return the slope df/dδ \[N/m\]; zero for δ <= 0.
    #[must_use]
    pub fn stiffness(&self, penetration: f64) -> f64 {
        self.form.stiffness(&self.constants, penetration)
    }

    /// Return the elastic energy \[J\] at penetration δ \[m\], the integral of the force.
    #[must_use]
    pub fn energy(&self, penetration: f64) -> f64 {
        self.form.energy(&self.constants, penetration)
    }

    /// Return the sum of the elastic energies \[J\] at these penetrations \[m\].
    pub(crate) fn energy_of_all(&self, penetrations: &[f64]) -> f64 {
        self.form.energy_of_all(&self.constants, penetrations)
    }

    /// Return the penetration \[m\] at which the law's range ends.
    #[must_use]
    pub fn range_end(&self) -> f64 {
        self.form.range_end(&self.constants)
    }
}

/// Return the reason why `law` is outside its range for these surfaces at any penetration, if it is.
#[must_use]
pub fn range_note(law: Elastic, surfaces: &SurfacePair) -> Option<String> {
    law.definition().and_then(|law| (law.range_note)(surfaces))
}

/// Return the message on a contact beyond the end of its law: penetration `depth` and end of the law `end` \[m\].
pub(crate) fn past_range(law: Elastic, contact: &str, depth: f64, end: f64) -> String {
    let law = law.name();
    format!(
        "{law} law, {contact}: penetration {depth:.3e} m is past the end of the law, {end:.3e} m; \
         the force continues with the secant stiffness"
    )
}

/// Return the elastic force \[N\] of one pair at many penetrations \[m\].
#[must_use]
pub fn elastic_forces(law: Elastic, surfaces: &SurfacePair, penetrations: &[f64]) -> Vec<f64> {
    let pair = ElasticPair::prepare(law, surfaces);
    penetrations.iter().map(|&d| pair.force(d)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODULUS: f64 = 2.07e11 / 1.82;

    fn surfaces() -> [SurfacePair; 4] {
        [
            SurfacePair::internal(2.22e-3, 2.245e-3, 0.011, MODULUS),
            SurfacePair::internal(3.968_75e-3, 10.376_694e-3, 0.007, MODULUS),
            SurfacePair::external(3.968_75e-3, 6.582_621e-3, 0.007, MODULUS),
            SurfacePair::flat(3.968_75e-3, 6.582_621e-3, 0.007, MODULUS),
        ]
    }

    #[test]
    fn every_law_has_slope_and_energy_of_its_force_on_every_kind_of_pair() {
        for law in Elastic::ALL.into_iter().chain([Elastic::Linear(2e8)]) {
            for surfaces in surfaces() {
                let pair = ElasticPair::prepare(law, &surfaces);
                for d in [1e-9, 1e-7, 2.6e-6, 9e-5] {
                    let h = 1e-4 * d;
                    let slope = (pair.force(d + h) - pair.force(d - h)) / (2.0 * h);
                    let power = (pair.energy(d + h) - pair.energy(d - h)) / (2.0 * h);
                    assert!(
                        (slope / pair.stiffness(d) - 1.0).abs() < 1e-6,
                        "{law:?} {d}"
                    );
                    assert!((power / pair.force(d) - 1.0).abs() < 1e-6, "{law:?} {d}");
                }
                for apart in [0.0, -1e-6] {
                    let all = [pair.force(apart), pair.stiffness(apart), pair.energy(apart)];
                    assert_eq!(all, [0.0; 3], "{law:?}");
                }
                assert!(pair.force(f64::NAN).is_nan());
            }
        }
    }

    #[test]
    fn the_energy_of_all_is_the_sum_of_each_in_their_order() {
        for law in Elastic::ALL.into_iter().chain([Elastic::Linear(2e8)]) {
            let pair = ElasticPair::prepare(law, &surfaces()[0]);
            for count in [0, 1, 31, 32, 33, 70] {
                let depths = (0..count).map(|i| 1e-7 * f64::from(i % 7 - 2) * f64::from(i));
                let depths: Vec<f64> = depths.collect();
                let each = depths.iter().map(|&depth| pair.energy(depth));
                let sum = each.fold(0.0, |sum, energy| sum + energy);
                assert_eq!(pair.energy_of_all(&depths), sum, "{law:?} {count}");
                assert!(count < 31 || sum > 0.0);
            }
        }
    }

    #[test]
    fn only_the_logarithmic_laws_end() {
        for law in Elastic::ALL {
            let end = ElasticPair::prepare(law, &surfaces()[0]).range_end();
            assert_eq!(law.has_an_end(), end.is_finite(), "{law:?}");
        }
    }

    #[test]
    fn a_law_of_bores_says_so_outside() {
        let [pin, _, topping, _] = surfaces();
        assert!(range_note(Elastic::LiuConformal, &pin).is_none());
        assert!(range_note(Elastic::LiuConformal, &topping).is_some());
        for law in [Elastic::HertzCylinder, Elastic::Linear(1e8)] {
            assert!(range_note(law, &topping).is_none());
        }
    }

    #[test]
    fn forces_and_ends_have_the_values_of_the_printed_laws() {
        let internal = surfaces()[0];
        let found = elastic_forces(Elastic::Linear(2e8), &internal, &[-1e-6, 0.0, 1e-6]);
        assert_eq!(found[..2], [0.0; 2]);
        assert!((found[2] - 200.0).abs() < 1e-10 && found.len() == 3);
        let hertz = ElasticPair::prepare(Elastic::Hertz, &internal).force(1e-6);
        let expected = 4.0 / 3.0 * MODULUS * (internal.effective_radius * 1e-18).sqrt();
        assert!((hertz / expected - 1.0).abs() < 1e-14);
        // δ = f/A [ln(4 A ΔR/f) - 1] has its largest value 4 ΔR e^-2 at f = 4 A ΔR e^-2.
        let end = ElasticPair::prepare(Elastic::Johnson, &internal).range_end();
        let expected = 4.0 * internal.radius_difference * (-2f64).exp();
        assert!((end / expected - 1.0).abs() < 1e-14);
    }
}

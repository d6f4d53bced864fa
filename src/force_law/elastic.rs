//! The elastic laws that a user picks by name, and their constants for every pair: many laws, few forms.
//!
//! The run's loops are compiled once for each form, so that a law of a known form costs nothing but its constants.

use super::{
    Conformal, ConformalPair, ElasticLaw, EnhancedCylinder, Hertz, HertzPair, LineContact,
    LogarithmicPair, PowerPair, SurfacePair,
};

/// The elastic law a user picks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Elastic {
    /// Hertz for spheres, as Lankarani and Nikravesh use it.
    Hertz,
    /// Johnson's cylinders.
    Johnson,
    /// The enhanced cylindrical law of Pereira, Ramalho and Ambrósio, coefficients of 2010.
    EnhancedCylinder,
    /// The same with the coefficients of 2015.
    EnhancedCylinder2015,
    /// Hertz's cylinders as two half-planes.
    HertzCylinder,
    /// Radzimovsky's cylinders.
    Radzimovsky,
    /// Item 78035 of the Engineering Sciences Data Unit.
    Esdu78035,
    /// Liu, Zhang and Yang's conformal cylinders.
    LiuConformal,
    /// A constant stiffness \[N/m\], whatever the surfaces.
    Linear(f64),
}

impl Elastic {
    /// Those that surfaces and material alone decide.
    pub const ALL: [Self; 8] = [
        Self::Hertz,
        Self::Johnson,
        Self::EnhancedCylinder,
        Self::EnhancedCylinder2015,
        Self::HertzCylinder,
        Self::Radzimovsky,
        Self::Esdu78035,
        Self::LiuConformal,
    ];

    /// The name used in messages and descriptions.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Hertz => "hertz",
            Self::Johnson => "johnson",
            Self::EnhancedCylinder => "enhanced-cylinder",
            Self::EnhancedCylinder2015 => "enhanced-cylinder-2015",
            Self::HertzCylinder => "hertz-cylinder",
            Self::Radzimovsky => "radzimovsky",
            Self::Esdu78035 => "esdu-78035",
            Self::LiuConformal => "liu-conformal",
            Self::Linear(_) => "linear",
        }
    }

    /// Whether the law's range ends at some penetration.
    #[must_use]
    pub fn has_an_end(self) -> bool {
        matches!(
            self,
            Self::Johnson | Self::HertzCylinder | Self::Radzimovsky | Self::Esdu78035
        )
    }
}

/// The constants of all pairs of one group, one arm a form: one match, then a loop without any.
#[derive(Debug, Clone)]
#[allow(missing_docs)] // the names say it
pub enum PairTable {
    Hertz(Vec<HertzPair>),
    Power(Vec<PowerPair>),
    Logarithmic(Vec<LogarithmicPair>),
    Conformal(Vec<ConformalPair>),
}

impl PairTable {
    /// The constants of `law` for every pair.
    #[must_use]
    pub fn prepare(law: Elastic, surfaces: &[SurfacePair]) -> Self {
        fn each<Pair>(surfaces: &[SurfacePair], of: impl Fn(&SurfacePair) -> Pair) -> Vec<Pair> {
            surfaces.iter().map(of).collect()
        }
        let line = |law: LineContact| Self::Logarithmic(each(surfaces, |pair| law.prepare(pair)));
        let enhanced =
            |law: EnhancedCylinder| Self::Power(each(surfaces, |pair| law.prepare(pair)));
        match law {
            Elastic::Hertz => Self::Hertz(each(surfaces, Hertz::prepare)),
            Elastic::Johnson => line(LineContact::Johnson),
            Elastic::HertzCylinder => line(LineContact::HertzCylinder),
            Elastic::Radzimovsky => line(LineContact::Radzimovsky),
            Elastic::Esdu78035 => line(LineContact::Esdu78035),
            Elastic::EnhancedCylinder => enhanced(EnhancedCylinder::Of2010),
            Elastic::EnhancedCylinder2015 => enhanced(EnhancedCylinder::Of2015),
            Elastic::LiuConformal => Self::Conformal(each(surfaces, Conformal::prepare)),
            Elastic::Linear(stiffness) => Self::Power(each(surfaces, |_| PowerPair {
                stiffness,
                exponent: 1.0,
            })),
        }
    }
}

/// The constants of one pair, for single forces outside the run's loops.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)] // the names say it
pub enum ElasticPair {
    Hertz(HertzPair),
    Power(PowerPair),
    Logarithmic(LogarithmicPair),
    Conformal(ConformalPair),
}

/// Runs a generic function over the form of a law: `with_form!(PairTable, table, Law, pairs => expression)`.
macro_rules! with_form {
    ($of:ident, $value:expr, $law:ident, $pairs:ident => $body:expr) => {
        match $value {
            $crate::force_law::$of::Hertz($pairs) => {
                type $law = $crate::force_law::Hertz;
                $body
            }
            $crate::force_law::$of::Power($pairs) => {
                type $law = $crate::force_law::Power;
                $body
            }
            $crate::force_law::$of::Logarithmic($pairs) => {
                type $law = $crate::force_law::Logarithmic;
                $body
            }
            $crate::force_law::$of::Conformal($pairs) => {
                type $law = $crate::force_law::Conformal;
                $body
            }
        }
    };
}

/// Runs a generic function over the law of a table: `with_law!(table, Law, pairs => expression)`.
macro_rules! with_law {
    ($table:expr, $law:ident, $pairs:ident => $body:expr) => {
        $crate::force_law::with_form!(PairTable, $table, $law, $pairs => $body)
    };
}
pub(crate) use {with_form, with_law};

impl ElasticPair {
    /// The constants of `law` for one pair.
    #[must_use]
    pub fn prepare(law: Elastic, surfaces: &SurfacePair) -> Self {
        match PairTable::prepare(law, std::slice::from_ref(surfaces)) {
            PairTable::Hertz(pairs) => Self::Hertz(pairs[0]),
            PairTable::Power(pairs) => Self::Power(pairs[0]),
            PairTable::Logarithmic(pairs) => Self::Logarithmic(pairs[0]),
            PairTable::Conformal(pairs) => Self::Conformal(pairs[0]),
        }
    }

    /// Elastic force \[N\] at penetration δ \[m\]; zero for δ <= 0; not a number stays so.
    #[must_use]
    pub fn force(&self, penetration: f64) -> f64 {
        with_form!(ElasticPair, self, Law, pair => Law::force(pair, penetration))
    }

    /// Its slope df/dδ \[N/m\]; zero for δ <= 0.
    #[must_use]
    pub fn stiffness(&self, penetration: f64) -> f64 {
        with_form!(ElasticPair, self, Law, pair => Law::stiffness(pair, penetration))
    }

    /// Elastic energy \[J\] at penetration δ \[m\], the integral of the force.
    #[must_use]
    pub fn energy(&self, penetration: f64) -> f64 {
        with_form!(ElasticPair, self, Law, pair => Law::energy(pair, penetration))
    }

    /// Penetration \[m\] at which the law's range ends.
    #[must_use]
    pub fn range_end(&self) -> f64 {
        with_form!(ElasticPair, self, Law, pair => Law::range_end(pair))
    }
}

/// Why `law` is outside its range for these surfaces whatever the penetration, if it is.
#[must_use]
pub fn range_note(law: Elastic, surfaces: &SurfacePair) -> Option<String> {
    match law {
        Elastic::EnhancedCylinder | Elastic::EnhancedCylinder2015 => {
            EnhancedCylinder::range_note(surfaces)
        }
        Elastic::LiuConformal => Conformal::range_note(surfaces),
        _ => None,
    }
}

/// Elastic force \[N\] of one pair over many penetrations \[m\].
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
}

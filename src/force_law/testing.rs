//! Shared code of the tests of force laws: a law over a slice of penetrations.

use pulp::Simd;

use super::ElasticLaw;
use crate::math::simd::testing::{LaneFunction, assert_same_bits, map};
use crate::math::simd::{InstructionSet, Lanes};

struct Forces<Law> {
    constants: [f64; 2],
    law: Law,
}

impl<Law: ElasticLaw> LaneFunction for Forces<Law> {
    #[inline(always)]
    fn of<S: Simd>(&self, x: Lanes<S>) -> Lanes<S> {
        let constants = self.constants.map(|constant| x.constant(constant));
        self.law.elastic(constants, x)
    }
}

/// Pass (instruction set, penetration, force) of every instruction set and penetration to `check`. Assert that all sets with fused
/// multiply-add give the same bits, and that `f64` gives those of the plain set.
pub(super) fn for_each_force(
    law: impl ElasticLaw,
    pair: &[f64; 2],
    penetrations: &[f64],
    check: impl Fn(&str, f64, f64),
) {
    let forces = Forces {
        constants: *pair,
        law,
    };
    for set in InstructionSet::available() {
        for (&d, force) in penetrations.iter().zip(map(set, &forces, penetrations)) {
            check(set.name(), d, force);
            if !set.has_fused_multiply_add() {
                let scalar = law.elastic(*pair, d);
                assert!(force.is_nan() || scalar.to_bits() == force.to_bits());
            }
        }
    }
    assert_same_bits(|set| map(set, &forces, penetrations));
}

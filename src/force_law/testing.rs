//! What the tests of the vector forms share: a law over a slice of penetrations.

use std::marker::PhantomData;

use pulp::Simd;

use super::VectorLaw;
use crate::math::simd::testing::{LaneFunction, assert_same_bits, map};
use crate::math::simd::{InstructionSet, Lanes};

struct Forces<Law> {
    constants: [f64; 2],
    law: PhantomData<Law>,
}

impl<Law: VectorLaw> LaneFunction for Forces<Law> {
    #[inline(always)]
    fn of<S: Simd>(&self, x: Lanes<S>) -> Lanes<S> {
        Law::forces(self.constants.map(|constant| x.constant(constant)), x)
    }
}

/// Hands (instruction set, penetration, vector form, twin) of every instruction set and penetration to `check`, and asserts that
/// all sets with fused multiply-add give the same bits.
pub(super) fn for_each_force<Law: VectorLaw>(
    pair: &Law::Pair,
    penetrations: &[f64],
    check: impl Fn(&str, f64, f64, f64),
) {
    let forces = Forces::<Law> {
        constants: Law::constants(pair),
        law: PhantomData,
    };
    for set in InstructionSet::available() {
        for (&d, force) in penetrations.iter().zip(map(set, &forces, penetrations)) {
            check(set.name(), d, force, Law::force(pair, d));
        }
    }
    assert_same_bits(|set| map(set, &forces, penetrations));
}

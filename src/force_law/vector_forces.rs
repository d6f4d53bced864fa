//! A law over many penetrations at once, as in the kernels; for measurements and comparisons.

use pulp::{Simd, WithSimd};

use super::{Elastic, ElasticLaw, Form, PairTable, SurfacePair};
use crate::math::simd::{InstructionSet, Lanes, Numbers, load, padded_zeros, vectors, vectors_mut};

/// One law of one pair with its instruction set, penetrations and forces.
#[derive(Debug, Clone)]
pub struct VectorForces {
    table: PairTable,
    instructions: InstructionSet,
    penetrations: Numbers,
    forces: Numbers,
    count: usize,
}

impl VectorForces {
    /// Return `law` for these surfaces at penetrations >= 0 \[m\].
    #[must_use]
    pub fn new(
        law: Elastic,
        surfaces: &SurfacePair,
        penetrations: &[f64],
        instructions: InstructionSet,
    ) -> Self {
        let count = penetrations.len();
        let mut padded = padded_zeros(count);
        padded[..count].copy_from_slice(penetrations);
        Self {
            table: PairTable::prepare(law, std::slice::from_ref(surfaces)),
            instructions,
            forces: padded.clone(),
            penetrations: padded,
            count,
        }
    }

    /// Return the elastic forces \[N\].
    pub fn evaluate(&mut self) -> &[f64] {
        self.instructions.run(Evaluate {
            law: self.table.form(),
            constants: self.table.pairs()[0],
            penetrations: &self.penetrations,
            forces: &mut self.forces,
        });
        &self.forces[..self.count]
    }
}

struct Evaluate<'a> {
    law: Form,
    constants: [f64; 2],
    penetrations: &'a [f64],
    forces: &'a mut [f64],
}

impl WithSimd for Evaluate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let blocks = self.penetrations.len() / S::F64_LANES;
        let constants = self.constants.map(|value| Lanes::splat(simd, value));
        let penetrations = vectors::<S>(self.penetrations, blocks);
        for (depth, force) in penetrations
            .iter()
            .zip(vectors_mut::<S>(self.forces, blocks))
        {
            *force = self.law.elastic(constants, load(simd, depth)).values();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force_law::ElasticPair;

    #[test]
    fn every_law_is_the_same_with_every_instruction_set_and_one_by_one() {
        let surfaces = [
            SurfacePair::internal(2.22e-3, 2.245e-3, 0.011, 1.137e11),
            SurfacePair::external(3.968_75e-3, 6.582_621e-3, 0.007, 1.137e11),
            SurfacePair::flat(3.968_75e-3, 6.582_621e-3, 0.007, 1.137e11),
        ];
        let depths: Vec<f64> = (0..=200).map(|i| 1e-14 * 1.11f64.powi(i)).collect();
        for law in Elastic::ALL.into_iter().chain([Elastic::Linear(2e8)]) {
            for pair in surfaces {
                let single = ElasticPair::prepare(law, &pair);
                let end = single.range_end();
                for set in InstructionSet::available() {
                    let mut forces = VectorForces::new(law, &pair, &depths, set);
                    assert_eq!(forces.evaluate().len(), depths.len());
                    for (&d, &force) in depths.iter().zip(forces.evaluate()) {
                        // The slope grows towards the end: the bound is half of a rounding error over the root of the remaining range.
                        let left = (1.0 - d / end).abs().max(f64::EPSILON);
                        let bound = 1e-14 + 1e-16 / left.sqrt();
                        let error = (force / single.force(d) - 1.0).abs();
                        assert!(error < bound, "{law:?} {} {d:e}: {error:e}", set.name());
                    }
                }
            }
        }
    }
}

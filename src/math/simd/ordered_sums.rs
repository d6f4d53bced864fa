//! Sums over arrays in [`WIDTH`] parts, so that every width of vectors gives the same bits.

use pulp::Simd;

use super::{Lanes, WIDTH, load, vectors_mut};

/// A sum in parts, one for each place in a vector of the widest kind. Kept in memory: for loops that seldom add.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct PartialSums([f64; WIDTH]);

impl PartialSums {
    /// Adds the numbers of vector `block` of an array.
    #[inline(always)]
    pub(crate) fn add<S: Simd>(&mut self, block: usize, values: Lanes<S>) {
        let parts = WIDTH / S::F64_LANES;
        let part = &mut vectors_mut::<S>(&mut self.0, parts)[block % parts];
        *part = (values + load(values.simd(), part)).values();
    }

    /// The sum, in one order for all widths.
    pub(crate) fn total(&self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    }
}

/// Partial sums of [`Squares`]: two vectors of the widest kind, so that one sum need not wait for the other.
const SQUARES: usize = 2 * WIDTH;

/// A sum of squares in vectors, for loops that add in every round.
pub(crate) struct Squares<S: Simd>([Lanes<S>; SQUARES]);

impl<S: Simd> Squares<S> {
    /// Vectors that are added to in turns: vector `b` of an array belongs to part `b` modulo this.
    pub(crate) const PARTS: usize = SQUARES / S::F64_LANES;

    #[inline(always)]
    pub(crate) fn new(simd: S) -> Self {
        Self([Lanes::splat(simd, 0.0); SQUARES])
    }

    /// Adds the squares of the numbers of a vector that belongs to `part`.
    #[inline(always)]
    pub(crate) fn add(&mut self, part: usize, values: Lanes<S>) {
        self.0[part] = values.mul_add(values, self.0[part]);
    }

    /// The sum, in one order for all widths, that of [`PartialSums::total`]: halves are added until one number is left.
    #[inline(always)]
    pub(crate) fn total(&self) -> f64 {
        let mut sums = self.0;
        for half in [8, 4, 2, 1] {
            if half < Self::PARTS {
                for part in 0..half {
                    sums[part] = sums[part] + sums[part + half];
                }
            }
        }
        sums[0].sum()
    }
}

//! Sums over arrays in [`WIDTH`] partial sums: all vector widths give the same bits.

use pulp::Simd;

use super::{Lanes, Number, Vectors, WIDTH, part_of, parts, put_part};

/// Sum as partial sums, one for each lane of the widest vectors.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct PartialSums<T = f64>([T; WIDTH]);

impl<T: Number> PartialSums<T> {
    /// Add vector `block` of an array.
    #[inline(always)]
    pub(crate) fn add<S: Vectors<Number = T>>(&mut self, block: usize, values: Lanes<S>) {
        let turn = block % parts::<S>().len();
        // Constant indices: with a variable one, a struct that holds the sums would stay in memory with all its fields.
        for part in parts::<S>() {
            if part == turn {
                self.add_part(part, values);
            }
        }
    }

    /// Add vector `part` of a pack.
    #[inline(always)]
    pub(crate) fn add_part<S: Vectors<Number = T>>(&mut self, part: usize, values: Lanes<S>) {
        let sum = part_of(values.simd(), &self.0, part);
        put_part(&mut self.0, part, values + sum);
    }

    /// Return the sum if it is `wanted`, else zero.
    #[inline(always)]
    pub(crate) fn total_if(&self, wanted: bool) -> f64 {
        if wanted { self.total() } else { 0.0 }
    }

    /// Return the sum, in the same order for all widths.
    #[inline(always)]
    pub(crate) fn total(&self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.0.map(Number::double);
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    }
}

/// Number of partial sums of [`Squares`]: two of the widest vectors, so that consecutive additions are independent.
const SQUARES: usize = 2 * WIDTH;

/// Sum of squares kept in vectors, for loops with an addition in every iteration.
pub(crate) struct Squares<S: Simd>([Lanes<S>; SQUARES]);

impl<S: Simd> Squares<S> {
    /// Number of accumulator vectors, used in turn: vector `b` of an array belongs to accumulator `b` modulo this.
    pub(crate) const PARTS: usize = SQUARES / S::F64_LANES;

    #[inline(always)]
    pub(crate) fn new(simd: S) -> Self {
        Self([Lanes::splat(simd, 0.0); SQUARES])
    }

    /// Add the squares of a vector that belongs to accumulator `part`.
    #[inline(always)]
    pub(crate) fn add(&mut self, part: usize, values: Lanes<S>) {
        self.0[part] = values.mul_add(values, self.0[part]);
    }

    /// Return the total of one vector alone: sums with zeros are left out, which change no bit of a square.
    #[inline(always)]
    pub(crate) fn of_one(values: Lanes<S>) -> f64 {
        (values * values).sum()
    }

    /// Return the sum, in the order of [`PartialSums::total`] for all widths: halves are added until one number is left.
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

//! Arithmetic on several numbers at once, with the instruction set chosen when the program runs.
//!
//! All operations but sums are element by element and, where the machine has fused multiply-add, rounded alike for every
//! width; sums run over [`WIDTH`] partial sums whatever the width. AVX2, AVX-512 and NEON therefore give the same bits.

// A register passed to a function that is not inlined goes through memory, and its instructions are not chosen.
#![allow(clippy::inline_always)]

use aligned_vec::{AVec, ConstAlign, avec};

mod instruction_set;
mod lanes;
mod logarithm;
mod power_of_e;
mod sines;
#[cfg(test)]
pub(crate) mod testing;

pub use instruction_set::InstructionSet;
pub(crate) use lanes::{
    Lanes, Mask, both, both_mut, lane_numbers, load, partial_load, vectors, vectors_mut,
};
pub(crate) use logarithm::{ln_of_quotient, octaves_of_quotient};
pub(crate) use power_of_e::{exp_of_remainder, nearest_whole};
pub(crate) use sines::sin_cos;

/// Numbers that arrays are padded to a multiple of: those of the widest registers.
pub const WIDTH: usize = 8;

/// `length` rounded up to whole registers.
#[must_use]
pub fn padded(length: usize) -> usize {
    length.next_multiple_of(WIDTH)
}

/// Numbers that begin at a cache line, so that no register of them lies across two.
pub(crate) type Numbers = AVec<f64, ConstAlign<64>>;

/// Zeros for `length` numbers, padded.
#[must_use]
pub(crate) fn padded_zeros(length: usize) -> Numbers {
    avec![[64]| 0.0; padded(length)]
}

/// A sum in [`WIDTH`] parts, one for each place in a register of the widest kind.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct PartialSums([f64; WIDTH]);

impl PartialSums {
    /// Adds the numbers of block `block` of an array.
    #[inline(always)]
    pub(crate) fn add<S: pulp::Simd>(&mut self, block: usize, values: Lanes<S>) {
        let parts = S::as_mut_simd_f64s(&mut self.0).0;
        let part = &mut parts[block % (WIDTH / S::F64_LANES)];
        *part = (values + load(values.simd(), part)).values();
    }

    /// The sum, in one order for all widths.
    pub(crate) fn total(&self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    }
}

//! Arithmetic on several numbers at once, with the instruction set chosen when the program runs.
//!
//! All operations but sums are element by element and, where the machine has fused multiply-add, rounded alike for every
//! width; sums run over [`WIDTH`] partial sums whatever the width. AVX2, AVX-512 and NEON therefore give the same bits.

// A register passed to a function that is not inlined goes through memory, and its instructions are not chosen.
#![allow(clippy::inline_always)]

use aligned_vec::{AVec, ConstAlign, avec};

mod arc_tangent;
mod instruction_set;
mod lanes;
mod logarithm;
mod octet;
mod power_of_e;
mod sines;
mod sums;
#[cfg(test)]
pub(crate) mod testing;
mod transposition;

pub(crate) use arc_tangent::arc_tangent;
pub use instruction_set::InstructionSet;
pub(crate) use lanes::{
    Lanes, Mask, both, both_mut, lane_numbers, load, partial_load, splat_two, vectors, vectors_mut,
};
pub(crate) use logarithm::{ln_of_quotient, octaves_of_quotient};
pub(crate) use octet::{Octet, parts, read, write};
pub(crate) use power_of_e::{exp, exp_of_remainder, nearest_whole};
pub(crate) use sines::sin_cos;
pub(crate) use sums::{PartialSums, Squares};
pub(crate) use transposition::transposed;

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

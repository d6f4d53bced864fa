//! Arithmetic on several numbers at once, with the instruction set chosen when the program runs.
//!
//! All operations but sums are element by element and, where the machine has fused multiply-add, rounded alike for every
//! width; sums run over [`WIDTH`] partial sums whatever the width. AVX2, AVX-512 and NEON therefore give the same bits.

// A vector passed to a function that is not inlined goes through memory, and its instructions are not chosen.
#![allow(clippy::inline_always)]

use aligned_vec::{AVec, ConstAlign, avec};

mod atan;
mod exp;
mod instruction_set;
mod lanes;
mod ln;
mod ordered_sums;
mod pack8;
mod sin_cos;
#[cfg(test)]
pub(crate) mod testing;
mod transpose;

pub(crate) use atan::arc_tangent;
pub(super) use exp::nearest_whole;
pub(crate) use exp::{exp, exp_of_remainder};
pub use instruction_set::InstructionSet;
pub(crate) use lanes::{
    Lanes, Mask, both, both_mut, lane_numbers, load, partial_load, splat_two, vectors, vectors_mut,
};
pub(super) use ln::scaled_to;
pub(crate) use ln::{ln_of_quotient, octaves_of_quotient};
pub(crate) use ordered_sums::{PartialSums, Squares};
pub(crate) use pack8::{Octet, parts, read, write};
pub(crate) use sin_cos::sin_cos;
pub(crate) use transpose::transposed;

/// Numbers that arrays are padded to a multiple of: those of the widest vectors.
pub const WIDTH: usize = 8;

/// `length` rounded up to whole vectors.
#[must_use]
pub fn padded(length: usize) -> usize {
    length.next_multiple_of(WIDTH)
}

/// Numbers that begin at a cache line, so that no vector of them lies across two.
pub(crate) type Numbers = AVec<f64, ConstAlign<64>>;

/// Zeros for `length` numbers, padded.
#[must_use]
pub(crate) fn padded_zeros(length: usize) -> Numbers {
    avec![[64]| 0.0; padded(length)]
}

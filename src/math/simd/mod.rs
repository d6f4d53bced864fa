//! SIMD arithmetic with an instruction set selected at run time.
//!
//! All operations except sums are lane-wise. With fused multiply-add their rounding is independent of the width. Sums have [`WIDTH`]
//! partial sums at any width. AVX2, AVX-512 and NEON therefore give the same bits.

// A vector passed to a function that is not inlined goes through memory, and the function has no instruction set selected.
#![allow(clippy::inline_always)]

use aligned_vec::{AVec, ConstAlign, avec};

mod atan;
mod entries;
mod exp;
mod instruction_set;
mod lanes;
mod ln;
mod ordered_sums;
mod pack8;
mod precision;
mod rotate;
mod sin_cos;
#[cfg(test)]
pub(crate) mod testing;
mod transpose;

pub(crate) use atan::arc_tangent;
pub(crate) use entries::{Entries, EntriesMut};
pub(super) use exp::nearest_whole;
pub(crate) use exp::{exp, exp_of_remainder};
pub(crate) use instruction_set::BlockKernel;
pub use instruction_set::InstructionSet;
pub(crate) use lanes::{
    Lanes, Mask, both, both_mut, lane_numbers, load, no_lane, partial_load, splat_two, vectors,
    vectors_from, vectors_from_mut, vectors_mut,
};
pub(super) use ln::scaled_to;
pub(crate) use ln::{ln_of_quotient, octaves_of_quotient};
pub(crate) use ordered_sums::{PartialSums, Squares};
pub(crate) use pack8::{
    Pack, Pack8, fold_packs, packs, packs_from, packs_from_mut, packs_mut, part_of, parts,
    put_double_part, put_part, read, read_rounded, rounded_part, write,
};
pub(crate) use precision::{Number, Vectors};
pub(crate) use rotate::rotated;
pub(crate) use sin_cos::{sin_cos, write_sin_cos};
pub(crate) use transpose::transposed;

/// Number of lanes of the widest vectors; array lengths are padded to a multiple of it.
pub const WIDTH: usize = 8;

/// Return `length` rounded up to whole vectors.
#[must_use]
pub fn padded(length: usize) -> usize {
    length.next_multiple_of(WIDTH)
}

/// Numbers aligned to a cache line, so that no vector crosses a cache line.
pub(crate) type Numbers<T = f64> = AVec<T, ConstAlign<64>>;

/// Return zeros for `length` numbers, padded.
#[must_use]
pub(crate) fn padded_zeros<T: Number>(length: usize) -> Numbers<T> {
    avec![[64]| T::default(); padded(length)]
}

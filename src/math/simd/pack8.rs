//! Packs of eight numbers, as wide as the widest vectors, for arrays of structures with several quantities.
//!
//! Arrays are read as packs, too: a pack has a constant length, so that its vectors are read without a check of bounds.

use pulp::Simd;

use super::{Lanes, WIDTH, load, vectors, vectors_mut};

/// Eight numbers of an array, from any entry on.
pub(crate) type Pack = [f64; WIDTH];

/// Return the first `count` packs of an array.
#[inline(always)]
pub(crate) fn packs(array: &[f64], count: usize) -> &[Pack] {
    &array.as_chunks().0[..count]
}

/// Return the first `count` packs of an array, mutable.
#[inline(always)]
pub(crate) fn packs_mut(array: &mut [f64], count: usize) -> &mut [Pack] {
    &mut array.as_chunks_mut().0[..count]
}

/// Load vector `part` of a pack.
#[inline(always)]
pub(crate) fn part_of<S: Simd>(simd: S, pack: &Pack, part: usize) -> Lanes<S> {
    load(simd, &vectors::<S>(pack, WIDTH / S::F64_LANES)[part])
}

/// Store vector `part` of a pack.
#[inline(always)]
pub(crate) fn put_part<S: Simd>(pack: &mut Pack, part: usize, values: Lanes<S>) {
    vectors_mut::<S>(pack, WIDTH / S::F64_LANES)[part] = values.values();
}

/// Eight numbers aligned to a cache line.
#[derive(Debug, Clone, Copy, Default)]
#[repr(align(64))]
pub(crate) struct Pack8(pub(crate) Pack);

impl Pack8 {
    /// Load vector `part`.
    #[inline(always)]
    pub(crate) fn at<S: Simd>(&self, simd: S, part: usize) -> Lanes<S> {
        part_of(simd, &self.0, part)
    }

    /// Store vector `part`.
    #[inline(always)]
    pub(crate) fn put<S: Simd>(&mut self, part: usize, values: Lanes<S>) {
        put_part(&mut self.0, part, values);
    }
}

/// Return the indices of the vectors of a pack.
#[inline(always)]
pub(crate) fn parts<S: Simd>() -> std::ops::Range<usize> {
    0..WIDTH / S::F64_LANES
}

/// Load vector `part` of each pack.
#[inline(always)]
pub(crate) fn read<S: Simd, const N: usize>(
    simd: S,
    packs8: &[Pack8; N],
    part: usize,
) -> [Lanes<S>; N] {
    let mut values = [Lanes::splat(simd, 0.0); N];
    for (value, pack8) in values.iter_mut().zip(packs8) {
        *value = pack8.at(simd, part);
    }
    values
}

/// Store vector `part` of each pack.
#[inline(always)]
pub(crate) fn write<S: Simd, const N: usize>(
    packs8: &mut [Pack8; N],
    part: usize,
    values: [Lanes<S>; N],
) {
    for (pack8, values) in packs8.iter_mut().zip(values) {
        pack8.put(part, values);
    }
}

//! Packs of eight numbers, as wide as the widest vectors, for arrays of structures with several quantities.

use pulp::Simd;

use super::{Lanes, WIDTH, load, vectors, vectors_mut};

/// Eight numbers aligned to a cache line.
#[derive(Debug, Clone, Copy, Default)]
#[repr(align(64))]
pub(crate) struct Octet(pub(crate) [f64; WIDTH]);

impl Octet {
    /// Load vector `part`.
    #[inline(always)]
    pub(crate) fn at<S: Simd>(&self, simd: S, part: usize) -> Lanes<S> {
        load(simd, &vectors::<S>(&self.0, WIDTH / S::F64_LANES)[part])
    }

    /// Store vector `part`.
    #[inline(always)]
    pub(crate) fn put<S: Simd>(&mut self, part: usize, values: Lanes<S>) {
        vectors_mut::<S>(&mut self.0, WIDTH / S::F64_LANES)[part] = values.values();
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
    octets: &[Octet; N],
    part: usize,
) -> [Lanes<S>; N] {
    let mut values = [Lanes::splat(simd, 0.0); N];
    for (value, octet) in values.iter_mut().zip(octets) {
        *value = octet.at(simd, part);
    }
    values
}

/// Store vector `part` of each pack.
#[inline(always)]
pub(crate) fn write<S: Simd, const N: usize>(
    octets: &mut [Octet; N],
    part: usize,
    values: [Lanes<S>; N],
) {
    for (octet, values) in octets.iter_mut().zip(values) {
        octet.put(part, values);
    }
}

//! SIMD vectors of arrays that may be unaligned and end within a vector.

use pulp::Simd;

use super::{Lanes, load, partial_load};

/// SIMD vectors of an array to read; lanes behind its end are zero.
pub(crate) struct Entries<'a, S: Simd> {
    whole: &'a [S::f64s],
    last: Lanes<S>,
}

impl<'a, S: Simd> Entries<'a, S> {
    /// Return the vectors of `array`.
    #[inline(always)]
    pub(crate) fn of(simd: S, array: &'a [f64]) -> Self {
        let (whole, rest) = S::as_simd_f64s(array);
        Self {
            whole,
            last: partial_load(simd, rest),
        }
    }

    /// Return vector `i`.
    #[inline(always)]
    pub(crate) fn at(&self, i: usize) -> Lanes<S> {
        match self.whole.get(i) {
            Some(values) => load(self.last.simd(), values),
            None if i == self.whole.len() => self.last,
            None => self.last.constant(0.0),
        }
    }
}

/// SIMD vectors of an array to write; lanes behind its end are dropped.
pub(crate) struct EntriesMut<'a, S: Simd> {
    simd: S,
    whole: &'a mut [S::f64s],
    rest: &'a mut [f64],
}

impl<'a, S: Simd> EntriesMut<'a, S> {
    /// Return the vectors of `array` for writing.
    #[inline(always)]
    pub(crate) fn of(simd: S, array: &'a mut [f64]) -> Self {
        let (whole, rest) = S::as_mut_simd_f64s(array);
        Self { simd, whole, rest }
    }

    /// Write vector `i`.
    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, values: Lanes<S>) {
        let behind = self.whole.len();
        if let Some(to) = self.whole.get_mut(i) {
            *to = values.values();
        } else if i == behind {
            self.simd.partial_store_f64s(self.rest, values.values());
        }
    }
}

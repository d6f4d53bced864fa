//! Registers of a part of a padded array: velocities begin behind the coordinates, anywhere beside a cache line, and end before
//! the sums, so that their last register is partly filled.

use pulp::Simd;

use crate::vector::{Lanes, load, partial_load};

/// An array that may end within a register; zeros behind its end.
pub(super) struct Column<'a, S: Simd> {
    simd: S,
    whole: &'a [S::f64s],
    rest: &'a [f64],
}

impl<'a, S: Simd> Column<'a, S> {
    #[inline(always)]
    pub(super) fn new(simd: S, values: &'a [f64]) -> Self {
        let (whole, rest) = S::as_simd_f64s(values);
        Self { simd, whole, rest }
    }

    #[inline(always)]
    pub(super) fn get(&self, block: usize) -> Lanes<S> {
        match self.whole.get(block) {
            Some(values) => load(self.simd, values),
            None => partial_load(self.simd, self.rest),
        }
    }
}

/// The same to write to.
pub(super) struct ColumnMut<'a, S: Simd> {
    simd: S,
    whole: &'a mut [S::f64s],
    rest: &'a mut [f64],
}

impl<'a, S: Simd> ColumnMut<'a, S> {
    #[inline(always)]
    pub(super) fn new(simd: S, values: &'a mut [f64]) -> Self {
        let (whole, rest) = S::as_mut_simd_f64s(values);
        Self { simd, whole, rest }
    }

    #[inline(always)]
    pub(super) fn get(&self, block: usize) -> Lanes<S> {
        match self.whole.get(block) {
            Some(values) => load(self.simd, values),
            None => partial_load(self.simd, self.rest),
        }
    }

    #[inline(always)]
    pub(super) fn set(&mut self, block: usize, values: Lanes<S>) {
        match self.whole.get_mut(block) {
            Some(place) => *place = values.values(),
            None => self.simd.partial_store_f64s(self.rest, values.values()),
        }
    }
}

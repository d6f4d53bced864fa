//! Registers of a part of a padded array: velocities begin behind the coordinates, anywhere beside a cache line, and end before
//! the sums, so that their last register may be partly filled.

use pulp::Simd;

use crate::math::simd::{Lanes, load, partial_load, vectors, vectors_mut};

/// Calls `$whole` for every whole register of `$length` numbers, and `$rest` for one partly filled behind them; both get
/// the part of a sum that the register belongs to, a constant where the loop is unrolled.
macro_rules! each_register {
    ($simd:ty, $length:expr, |$part:ident, $block:ident| $whole:expr, $rest:expr) => {
        let (whole, rest) = registers::<$simd>($length);
        let parts = Squares::<$simd>::PARTS;
        for group in (0..whole).step_by(parts) {
            for $part in 0..parts {
                let $block = group + $part;
                if $block < whole {
                    $whole;
                }
            }
        }
        if rest > 0 {
            for $part in 0..parts {
                if $part == whole % parts {
                    $rest;
                }
            }
        }
    };
}
pub(super) use each_register;

/// Whole registers in `length` numbers, and numbers in the register after them.
#[inline(always)]
pub(super) fn registers<S: Simd>(length: usize) -> (usize, usize) {
    (length / S::F64_LANES, length % S::F64_LANES)
}

/// An array of `length` numbers that may end within a register; zeros behind its end.
pub(super) struct SliceLanes<'a, S: Simd> {
    simd: S,
    whole: &'a [S::f64s],
    rest: &'a [f64],
}

impl<'a, S: Simd> SliceLanes<'a, S> {
    #[inline(always)]
    pub(super) fn new(simd: S, values: &'a [f64], length: usize) -> Self {
        let (whole, rest) = registers::<S>(length);
        Self {
            simd,
            whole: vectors::<S>(values, whole),
            rest: &values[length - rest..length],
        }
    }

    /// A whole register.
    #[inline(always)]
    pub(super) fn get(&self, block: usize) -> Lanes<S> {
        load(self.simd, &self.whole[block])
    }

    /// The last register, partly filled.
    #[inline(always)]
    pub(super) fn rest(&self) -> Lanes<S> {
        partial_load(self.simd, self.rest)
    }
}

/// The same to write to.
pub(super) struct SliceLanesMut<'a, S: Simd> {
    simd: S,
    whole: &'a mut [S::f64s],
    rest: &'a mut [f64],
}

impl<'a, S: Simd> SliceLanesMut<'a, S> {
    #[inline(always)]
    pub(super) fn new(simd: S, values: &'a mut [f64], length: usize) -> Self {
        let (whole, rest) = registers::<S>(length);
        let (before, behind) = values[..length].split_at_mut(length - rest);
        Self {
            simd,
            whole: vectors_mut::<S>(before, whole),
            rest: behind,
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, block: usize) -> Lanes<S> {
        load(self.simd, &self.whole[block])
    }

    #[inline(always)]
    pub(super) fn rest(&self) -> Lanes<S> {
        partial_load(self.simd, self.rest)
    }

    #[inline(always)]
    pub(super) fn set(&mut self, block: usize, values: Lanes<S>) {
        self.whole[block] = values.values();
    }

    #[inline(always)]
    pub(super) fn set_rest(&mut self, values: Lanes<S>) {
        self.simd.partial_store_f64s(self.rest, values.values());
    }
}

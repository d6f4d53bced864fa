//! SIMD vectors of a part of a padded array, whose last vector may be partly filled.
//!
//! Velocities follow the coordinates at any offset from a cache line, and sums follow the velocities.

use pulp::Simd;

use crate::math::simd::{Lanes, load, partial_load, vectors, vectors_mut};

/// Position of a vector in a slice.
#[derive(Clone, Copy)]
pub(super) enum At {
    /// A whole vector.
    Whole(usize),
    /// The partly filled vector at the end.
    Rest,
}

/// Run `$each` for every vector of `$length` numbers at `$at`; the partly filled one comes last.
///
/// With `$part` the vectors belong to alternating parts of a sum, constants in the unrolled loop.
macro_rules! each_vector {
    ($simd:ty, $length:expr, |$at:ident| $each:expr) => {
        let (whole, rest) = vector_count::<$simd>($length);
        for block in 0..whole {
            let $at = At::Whole(block);
            $each;
        }
        if rest > 0 {
            let $at = At::Rest;
            $each;
        }
    };
    ($simd:ty, $length:expr, |$part:ident, $at:ident| $each:expr) => {
        let (whole, rest) = vector_count::<$simd>($length);
        let parts = Squares::<$simd>::PARTS;
        for group in (0..whole).step_by(parts) {
            for $part in 0..parts {
                let $at = At::Whole(group + $part);
                if group + $part < whole {
                    $each;
                }
            }
        }
        if rest > 0 {
            for $part in 0..parts {
                if $part == whole % parts {
                    let $at = At::Rest;
                    $each;
                }
            }
        }
    };
}
pub(super) use each_vector;

/// Return the number of whole vectors in `length` numbers, and the numbers in the vector after them.
#[inline(always)]
pub(super) fn vector_count<S: Simd>(length: usize) -> (usize, usize) {
    (length / S::F64_LANES, length % S::F64_LANES)
}

/// A slice of `length` numbers as SIMD vectors; zeros after its end.
pub(super) struct SliceLanes<'a, S: Simd> {
    simd: S,
    whole: &'a [S::f64s],
    rest: &'a [f64],
}

impl<'a, S: Simd> SliceLanes<'a, S> {
    #[inline(always)]
    pub(super) fn new(simd: S, values: &'a [f64], length: usize) -> Self {
        let (whole, rest) = vector_count::<S>(length);
        Self {
            simd,
            whole: vectors::<S>(values, whole),
            rest: &values[length - rest..length],
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, at: At) -> Lanes<S> {
        match at {
            At::Whole(block) => load(self.simd, &self.whole[block]),
            At::Rest => partial_load(self.simd, self.rest),
        }
    }
}

/// A mutable slice as SIMD vectors.
pub(super) struct SliceLanesMut<'a, S: Simd> {
    simd: S,
    whole: &'a mut [S::f64s],
    rest: &'a mut [f64],
}

impl<'a, S: Simd> SliceLanesMut<'a, S> {
    #[inline(always)]
    pub(super) fn new(simd: S, values: &'a mut [f64], length: usize) -> Self {
        let (whole, rest) = vector_count::<S>(length);
        let (before, behind) = values[..length].split_at_mut(length - rest);
        Self {
            simd,
            whole: vectors_mut::<S>(before, whole),
            rest: behind,
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, at: At) -> Lanes<S> {
        match at {
            At::Whole(block) => load(self.simd, &self.whole[block]),
            At::Rest => partial_load(self.simd, self.rest),
        }
    }

    #[inline(always)]
    pub(super) fn set(&mut self, at: At, values: Lanes<S>) {
        match at {
            At::Whole(block) => self.whole[block] = values.values(),
            At::Rest => self.simd.partial_store_f64s(self.rest, values.values()),
        }
    }
}

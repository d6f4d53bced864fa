//! SIMD vectors of a part of a padded array, whose last vector may be partly filled.
//!
//! Velocities of mechanisms follow the coordinates at any offset from a cache line, and sums follow the velocities. A slice is read in groups of a
//! constant length: their vectors need no check of bounds.

use pulp::Simd;

use crate::math::simd::{Lanes, Squares, load, partial_load, vectors, vectors_mut};

/// Numbers of a group: one vector for each accumulator of [`Squares`].
const GROUP: usize = Squares::<pulp::Scalar>::PARTS;

/// Position of a vector in a slice.
#[derive(Clone, Copy)]
pub(super) enum At {
    /// A vector of a group.
    Group(usize, usize),
    /// A whole vector behind the last group.
    Behind(usize),
    /// The partly filled vector at the end.
    Rest,
}

/// Run `$each` for every vector of `$length` numbers at `$at`; the partly filled one comes last.
///
/// With `$part` the vectors belong to alternating parts of a sum, constants in the unrolled loop.
macro_rules! each_vector {
    ($simd:ty, $length:expr, |$at:ident| $each:expr) => {
        let (groups, behind, rest) = vector_count::<$simd>($length);
        for group in 0..groups {
            for part in 0..Squares::<$simd>::PARTS {
                let $at = At::Group(group, part);
                $each;
            }
        }
        for part in 0..behind {
            let $at = At::Behind(part);
            $each;
        }
        if rest > 0 {
            let $at = At::Rest;
            $each;
        }
    };
    ($simd:ty, $length:expr, |$part:ident, $at:ident| $each:expr) => {
        let (groups, behind, rest) = vector_count::<$simd>($length);
        for group in 0..groups {
            for $part in 0..Squares::<$simd>::PARTS {
                let $at = At::Group(group, $part);
                $each;
            }
        }
        for $part in 0..Squares::<$simd>::PARTS {
            if $part < behind {
                let $at = At::Behind($part);
                $each;
            }
        }
        for $part in 0..Squares::<$simd>::PARTS {
            if $part == behind && rest > 0 {
                let $at = At::Rest;
                $each;
            }
        }
    };
}
pub(super) use each_vector;

/// Return the number of groups in `length` numbers, of whole vectors behind them, and of numbers in the vector after these.
#[inline(always)]
pub(super) fn vector_count<S: Simd>(length: usize) -> (usize, usize, usize) {
    let behind = length % GROUP;
    (length / GROUP, behind / S::F64_LANES, behind % S::F64_LANES)
}

/// A slice of `length` numbers as SIMD vectors; zeros after its end.
pub(super) struct SliceLanes<'a, S: Simd> {
    simd: S,
    groups: &'a [[f64; GROUP]],
    behind: &'a [S::f64s],
    rest: &'a [f64],
}

impl<'a, S: Simd> SliceLanes<'a, S> {
    #[inline(always)]
    pub(super) fn new(simd: S, values: &'a [f64], length: usize) -> Self {
        let (groups, behind) = values[..length].as_chunks();
        let (behind, rest) = S::as_simd_f64s(behind);
        Self {
            simd,
            groups,
            behind,
            rest,
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, at: At) -> Lanes<S> {
        match at {
            At::Group(group, part) => load(self.simd, &in_group::<S>(&self.groups[group])[part]),
            At::Behind(part) => load(self.simd, &self.behind[part]),
            At::Rest => partial_load(self.simd, self.rest),
        }
    }
}

/// A mutable slice as SIMD vectors.
pub(super) struct SliceLanesMut<'a, S: Simd> {
    simd: S,
    groups: &'a mut [[f64; GROUP]],
    behind: &'a mut [S::f64s],
    rest: &'a mut [f64],
}

impl<'a, S: Simd> SliceLanesMut<'a, S> {
    #[inline(always)]
    pub(super) fn new(simd: S, values: &'a mut [f64], length: usize) -> Self {
        let (groups, behind) = values[..length].as_chunks_mut();
        let (behind, rest) = S::as_mut_simd_f64s(behind);
        Self {
            simd,
            groups,
            behind,
            rest,
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, at: At) -> Lanes<S> {
        match at {
            At::Group(group, part) => load(self.simd, &in_group::<S>(&self.groups[group])[part]),
            At::Behind(part) => load(self.simd, &self.behind[part]),
            At::Rest => partial_load(self.simd, self.rest),
        }
    }

    #[inline(always)]
    pub(super) fn set(&mut self, at: At, values: Lanes<S>) {
        let values = values.values();
        match at {
            At::Group(group, part) => {
                let group = &mut self.groups[group];
                vectors_mut::<S>(group, Squares::<S>::PARTS)[part] = values;
            }
            At::Behind(part) => self.behind[part] = values,
            At::Rest => self.simd.partial_store_f64s(self.rest, values),
        }
    }
}

/// Return the vectors of a group.
#[inline(always)]
fn in_group<S: Simd>(group: &[f64; GROUP]) -> &[S::f64s] {
    vectors::<S>(group, Squares::<S>::PARTS)
}

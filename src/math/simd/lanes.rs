//! SIMD vector of numbers with arithmetic operators.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Number, Numbers, Vectors, WIDTH};

/// Vector of as many numbers as the lanes of `S`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lanes<S: Vectors> {
    simd: S,
    values: S::Vector,
}

/// Mask: true or false for each lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mask<S: Vectors> {
    simd: S,
    values: S::Mask,
}

/// Load one vector of an array.
#[inline(always)]
pub(crate) fn load<S: Vectors>(simd: S, values: &S::Vector) -> Lanes<S> {
    Lanes {
        simd,
        values: *values,
    }
}

/// Load `slice`, which may be shorter than a vector; the remaining lanes are zero.
#[inline(always)]
pub(crate) fn partial_load<S: Vectors>(simd: S, slice: &[S::Number]) -> Lanes<S> {
    Lanes {
        simd,
        values: simd.load_some(slice),
    }
}

/// Return the first `count` vectors of an array.
#[inline(always)]
pub(crate) fn vectors<S: Vectors>(slice: &[S::Number], count: usize) -> &[S::Vector] {
    vectors_from::<S>(slice, 0, count)
}

/// Return `count` vectors of an array from entry `first` on. (The end is the same number for all arrays of a loop: each needs one comparison.)
#[inline(always)]
pub(crate) fn vectors_from<S: Vectors>(
    slice: &[S::Number],
    first: usize,
    count: usize,
) -> &[S::Vector] {
    &S::whole(&slice[first..first + count * S::LANES]).0[..count]
}

/// Return the first `count` vectors of an array, mutable.
#[inline(always)]
pub(crate) fn vectors_mut<S: Vectors>(slice: &mut [S::Number], count: usize) -> &mut [S::Vector] {
    vectors_from_mut::<S>(slice, 0, count)
}

/// Return `count` vectors of an array from entry `first` on, mutable.
#[inline(always)]
pub(crate) fn vectors_from_mut<S: Vectors>(
    slice: &mut [S::Number],
    first: usize,
    count: usize,
) -> &mut [S::Vector] {
    &mut S::whole_mut(&mut slice[first..first + count * S::LANES]).0[..count]
}

/// Return `count` vectors of an x array and of a y array, from entry `first` on.
#[inline(always)]
pub(crate) fn both<S: Vectors>(
    arrays: &[Numbers<S::Number>; 2],
    first: usize,
    count: usize,
) -> [&[S::Vector]; 2] {
    [
        vectors_from::<S>(&arrays[0], first, count),
        vectors_from::<S>(&arrays[1], first, count),
    ]
}

/// Return `count` vectors of an x array and of a y array, from entry `first` on, mutable.
#[inline(always)]
pub(crate) fn both_mut<S: Vectors>(
    arrays: &mut [Numbers<S::Number>; 2],
    first: usize,
    count: usize,
) -> [&mut [S::Vector]; 2] {
    let [x, y] = arrays;
    [
        vectors_from_mut::<S>(x, first, count),
        vectors_from_mut::<S>(y, first, count),
    ]
}

/// Return two vectors, each with one number in all lanes. (A closure in `map` is not always inlined, and then loses its instruction set.)
#[inline(always)]
pub(crate) fn splat_two<S: Vectors>(simd: S, [x, y]: [f64; 2]) -> [Lanes<S>; 2] {
    [Lanes::splat(simd, x), Lanes::splat(simd, y)]
}

/// Return a vector of the lane numbers 0, 1, 2, ...
#[inline(always)]
pub(crate) fn lane_numbers<S: Vectors>(simd: S) -> Lanes<S> {
    const NUMBERS: [f64; WIDTH] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    Lanes::new(simd, simd.load_doubles(&NUMBERS, 0))
}

/// Return a mask that is false in all lanes.
#[inline(always)]
pub(crate) fn no_lane<S: Vectors>(simd: S) -> Mask<S> {
    let zero = Lanes::splat(simd, 0.0);
    zero.less(zero)
}

impl<S: Vectors> Lanes<S> {
    /// Return the same number in all lanes.
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: f64) -> Self {
        Self {
            simd,
            values: simd.splat(value),
        }
    }

    /// Return the lanes of a raw vector.
    #[inline(always)]
    pub(crate) fn new(simd: S, values: S::Vector) -> Self {
        Self { simd, values }
    }

    /// Return the raw vector, for storage.
    #[inline(always)]
    pub(crate) fn values(self) -> S::Vector {
        self.values
    }

    /// Return the instruction set.
    #[inline(always)]
    pub(crate) fn simd(self) -> S {
        self.simd
    }

    /// Return another constant of the same width.
    #[inline(always)]
    pub(crate) fn constant(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    /// Return self * factor + addend, with a single rounding if the machine has fused multiply-add.
    #[inline(always)]
    pub(crate) fn mul_add(self, factor: Self, addend: Self) -> Self {
        self.with(self.simd.mul_add(self.values, factor.values, addend.values))
    }

    /// Return addend - self * factor, with the same rounding.
    #[inline(always)]
    pub(crate) fn negate_mul_add(self, factor: Self, addend: Self) -> Self {
        self.with(
            self.simd
                .negate_mul_add(self.values, factor.values, addend.values),
        )
    }

    /// Return the square root.
    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        self.with(self.simd.sqrt(self.values))
    }

    /// Return the absolute value.
    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        self.with(self.simd.abs(self.values))
    }

    /// Return max(self, 0); NaN is kept.
    #[inline(always)]
    pub(crate) fn positive_part(self) -> Self {
        let zero = self.constant(0.0);
        if cfg!(target_arch = "x86_64") && S::LANES > 1 {
            // This instruction returns its second operand where either is NaN or both are zero.
            return zero.max(self);
        }
        self.less(zero).select(zero, self)
    }

    /// Return the larger number; undefined if one is NaN.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        self.with(self.simd.max(self.values, other.values))
    }

    /// Return the smaller number; undefined if one is NaN.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        self.with(self.simd.min(self.values, other.values))
    }

    /// Return the largest of all lanes.
    #[inline(always)]
    pub(crate) fn greatest(self) -> f64 {
        self.simd.greatest(self.values)
    }

    /// Return the sum of all lanes: halves are added until one number is left.
    #[inline(always)]
    pub(crate) fn sum(self) -> f64 {
        self.simd.sum(self.values)
    }

    /// Shift `count` numbers down by one lane and put `next` after them; the remaining lanes are zero.
    #[inline(always)]
    pub(crate) fn followed_by(self, next: f64, count: usize) -> Self {
        if S::LANES == WIDTH {
            let lane = lane_numbers(self.simd);
            let last = lane.greater(self.constant(count as f64 - 1.5));
            let turned = last.select(self.constant(next), self.turned());
            return lane
                .less(self.constant(count as f64 - 0.5))
                .select(turned, self.constant(0.0));
        }
        let mut numbers = [S::Number::default(); WIDTH];
        vectors_mut::<S>(&mut numbers, 1)[0] = self.values;
        numbers[count] = Number::nearest(next);
        load(self.simd, &vectors::<S>(&numbers[1..], 1)[0])
    }

    /// Shift all lanes down by one; the last lane, marked by `last`, becomes the first lane of `next`.
    #[inline(always)]
    pub(crate) fn moved_on(self, next: Self, last: Mask<S>) -> Self {
        last.select(next.turned(), self.turned())
    }

    /// Rotate all lanes down by one; the first becomes the last.
    #[inline(always)]
    fn turned(self) -> Self {
        self.with(self.simd.rotate(self.values, 1))
    }

    /// Rotate all lanes down by `distance`.
    #[inline(always)]
    pub(crate) fn turned_by(self, distance: usize) -> Self {
        self.with(self.simd.rotate(self.values, distance))
    }

    /// Return self > other.
    #[inline(always)]
    pub(crate) fn greater(self, other: Self) -> Mask<S> {
        self.mask(self.simd.greater(self.values, other.values))
    }

    /// Return self < other.
    #[inline(always)]
    pub(crate) fn less(self, other: Self) -> Mask<S> {
        self.mask(self.simd.less(self.values, other.values))
    }

    /// Return true for self > other and for NaN.
    #[inline(always)]
    pub(crate) fn exceeds(self, other: Self) -> Mask<S> {
        let within = self.simd.at_most(self.values, other.values);
        self.mask(self.simd.not(within))
    }

    #[inline(always)]
    fn with(self, values: S::Vector) -> Self {
        Self { values, ..self }
    }

    #[inline(always)]
    fn mask(self, values: S::Mask) -> Mask<S> {
        Mask {
            simd: self.simd,
            values,
        }
    }
}

impl<S: Vectors> Mask<S> {
    /// Return `yes` where true and `no` where false.
    #[inline(always)]
    pub(crate) fn select(self, yes: Lanes<S>, no: Lanes<S>) -> Lanes<S> {
        yes.with(self.simd.select(self.values, yes.values, no.values))
    }

    /// Select two vectors.
    #[inline(always)]
    pub(crate) fn select_two(self, yes: [Lanes<S>; 2], no: [Lanes<S>; 2]) -> [Lanes<S>; 2] {
        [self.select(yes[0], no[0]), self.select(yes[1], no[1])]
    }

    /// Return whether any lane is true.
    #[inline(always)]
    pub(crate) fn any(self) -> bool {
        self.simd.first_true(self.values) < S::LANES
    }

    /// Return the conjunction.
    #[inline(always)]
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            values: self.simd.both(self.values, other.values),
            ..self
        }
    }

    /// Return the disjunction.
    #[inline(always)]
    pub(crate) fn or(self, other: Self) -> Self {
        Self {
            values: self.simd.either(self.values, other.values),
            ..self
        }
    }

    /// Return the exclusive disjunction.
    #[inline(always)]
    pub(crate) fn differs(self, other: Self) -> Self {
        Self {
            values: self.simd.differ(self.values, other.values),
            ..self
        }
    }

    /// Return the negation.
    #[inline(always)]
    pub(crate) fn not(self) -> Self {
        Self {
            values: self.simd.not(self.values),
            ..self
        }
    }
}

/// Implement an operator by the operation of all lanes.
macro_rules! operator {
    ($($operator:ident, $method:ident;)*) => {$(
        impl<S: Vectors> $operator for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.with(self.simd.$method(self.values, other.values))
            }
        }
    )*};
}

operator! {
    Add, add;
    Sub, sub;
    Mul, mul;
    Div, div;
}

impl<S: Vectors> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.with(self.simd.negate(self.values))
    }
}

#[cfg(test)]
mod tests {
    use pulp::{Simd, WithSimd};

    use super::*;
    use crate::math::simd::{InstructionSet, Pack, put_double_part, rounded_part};

    struct PositivePart<'a, T>(&'a mut Pack, std::marker::PhantomData<T>);

    impl<T: Number> WithSimd for PositivePart<'_, T> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let simd = T::vectors(simd);
            for part in crate::math::simd::parts::<T::Vectors<S>>() {
                let values = rounded_part(simd, self.0, part);
                put_double_part(self.0, part, values.positive_part());
            }
        }
    }

    fn assert_positive_part<T: Number>() {
        let given = [
            f64::NAN,
            -1.0,
            -0.0,
            0.0,
            1.0,
            f64::NEG_INFINITY,
            f64::INFINITY,
            -f64::NAN,
        ];
        for set in InstructionSet::available() {
            let mut found = given;
            T::run(set, PositivePart(&mut found, std::marker::PhantomData::<T>));
            for (x, y) in given.into_iter().zip(found) {
                let expected = if x < 0.0 { 0.0 } else { x };
                let what = format!("{} {x} {y}", set.name());
                assert_eq!(y.is_nan(), x.is_nan(), "{what}");
                assert!(x.is_nan() || y.to_bits() == expected.to_bits(), "{what}");
            }
        }
    }

    #[test]
    fn positive_parts_keep_nan_and_the_sign_of_zero_in_both_precisions() {
        assert_positive_part::<f64>();
        assert_positive_part::<f32>();
    }
}

//! Operations of real numbers: a formula over [`Real`] runs on one number and on a SIMD vector.
//!
//! `f64` rounds as the plain instruction set does, without fused multiply-add, so that both give the same bits.

// A function that is not inlined into a kernel is compiled without its instruction set.
#![allow(clippy::inline_always)]

use std::ops::{Add, Div, Mul, Neg, Sub};

use pulp::{Scalar, Simd};

use super::simd::{Lanes, Mask, nearest_whole, scaled_to};

/// A number, or a vector of numbers with lane-wise operations.
pub(crate) trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Mask, the result of a comparison.
    type Mask: Truth<Self>;

    /// Context required to make a constant: the instruction set of a vector.
    type Context: Copy;

    /// Return the same number in all lanes.
    fn splat(context: Self::Context, value: f64) -> Self;

    /// Return another constant of the same width.
    fn constant(self, value: f64) -> Self;

    /// Return self * factor + addend, with a single rounding if the instruction set has it.
    fn mul_add(self, factor: Self, addend: Self) -> Self;

    /// Return addend - self * factor, with the same rounding.
    fn negate_mul_add(self, factor: Self, addend: Self) -> Self;

    /// Return the square root.
    fn sqrt(self) -> Self;

    /// Return the absolute value.
    fn abs(self) -> Self;

    /// Return max(self, 0); NaN is kept.
    fn positive_part(self) -> Self;

    /// Return the larger number; undefined if one is NaN.
    fn max(self, other: Self) -> Self;

    /// Return self > other.
    fn greater(self, other: Self) -> Self::Mask;

    /// Return self < other.
    fn less(self, other: Self) -> Self::Mask;

    /// Return true for self > other and for NaN.
    fn exceeds(self, other: Self) -> Self::Mask;

    /// Return the nearest integer k, and 2^k if that is a normal number.
    fn nearest_whole(self) -> (Self, Self);

    /// Return (k, 2^k self) such that 2^k self lies between 2/3 and 3/2 of `other`; both are positive normal numbers.
    fn scaled_to(self, other: Self) -> (Self, Self);
}

/// Result of a lane-wise comparison of [`Real`] numbers.
pub(crate) trait Truth<R>: Copy {
    /// Return `yes` where true and `no` where false.
    fn select(self, yes: R, no: R) -> R;

    /// Return the conjunction.
    fn and(self, other: Self) -> Self;

    /// Return the disjunction.
    fn or(self, other: Self) -> Self;

    /// Return the negation.
    fn not(self) -> Self;

    /// Return whether any lane is true.
    fn any(self) -> bool;
}

impl Real for f64 {
    type Mask = bool;
    type Context = ();

    #[inline(always)]
    fn splat((): (), value: f64) -> f64 {
        value
    }

    #[inline(always)]
    fn constant(self, value: f64) -> f64 {
        value
    }

    #[inline(always)]
    #[allow(clippy::suboptimal_flops)] // without the instruction, a fused product is a slow library call
    fn mul_add(self, factor: f64, addend: f64) -> f64 {
        self * factor + addend
    }

    #[inline(always)]
    #[allow(clippy::suboptimal_flops)]
    fn negate_mul_add(self, factor: f64, addend: f64) -> f64 {
        addend - self * factor
    }

    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }

    #[inline(always)]
    fn positive_part(self) -> f64 {
        if self < 0.0 { 0.0 } else { self }
    }

    #[inline(always)]
    fn max(self, other: f64) -> f64 {
        f64::max(self, other)
    }

    #[inline(always)]
    fn greater(self, other: f64) -> bool {
        self > other
    }

    #[inline(always)]
    fn less(self, other: f64) -> bool {
        self < other
    }

    #[inline(always)]
    #[allow(clippy::neg_cmp_op_on_partial_ord)] // true for NaN
    fn exceeds(self, other: f64) -> bool {
        !(self <= other)
    }

    #[inline(always)]
    fn nearest_whole(self) -> (f64, f64) {
        let (whole, power) = nearest_whole(Lanes::splat(Scalar, self));
        (whole.values(), power.values())
    }

    #[inline(always)]
    fn scaled_to(self, other: f64) -> (f64, f64) {
        let (octaves, scaled) = scaled_to(Lanes::splat(Scalar, self), Lanes::splat(Scalar, other));
        (octaves.values(), scaled.values())
    }
}

impl Truth<f64> for bool {
    #[inline(always)]
    fn select(self, yes: f64, no: f64) -> f64 {
        if self { yes } else { no }
    }

    #[inline(always)]
    fn and(self, other: bool) -> bool {
        self & other
    }

    #[inline(always)]
    fn or(self, other: bool) -> bool {
        self | other
    }

    #[inline(always)]
    fn not(self) -> bool {
        !self
    }

    #[inline(always)]
    fn any(self) -> bool {
        self
    }
}

/// Delegates to the type's own methods of the same names.
macro_rules! own {
    ($of:ident: $($name:ident($($argument:ident: $type:ty),*) -> $result:ty;)+) => {
        $(
            #[inline(always)]
            fn $name(self, $($argument: $type),*) -> $result {
                $of::$name(self, $($argument),*)
            }
        )+
    };
}

impl<S: Simd> Real for Lanes<S> {
    type Mask = Mask<S>;
    type Context = S;

    #[inline(always)]
    fn splat(simd: S, value: f64) -> Self {
        Lanes::splat(simd, value)
    }

    own! {
        Lanes:
        constant(value: f64) -> Self;
        mul_add(factor: Self, addend: Self) -> Self;
        negate_mul_add(factor: Self, addend: Self) -> Self;
        sqrt() -> Self;
        abs() -> Self;
        positive_part() -> Self;
        max(other: Self) -> Self;
        greater(other: Self) -> Mask<S>;
        less(other: Self) -> Mask<S>;
        exceeds(other: Self) -> Mask<S>;
    }

    #[inline(always)]
    fn nearest_whole(self) -> (Self, Self) {
        nearest_whole(self)
    }

    #[inline(always)]
    fn scaled_to(self, other: Self) -> (Self, Self) {
        scaled_to(self, other)
    }
}

impl<S: Simd> Truth<Lanes<S>> for Mask<S> {
    own! {
        Mask:
        select(yes: Lanes<S>, no: Lanes<S>) -> Lanes<S>;
        and(other: Self) -> Self;
        or(other: Self) -> Self;
        not() -> Self;
        any() -> bool;
    }
}

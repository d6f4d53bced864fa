//! What a formula needs of its numbers: written once over [`Real`], it runs on one number and on a SIMD vector of them.
//!
//! `f64` rounds as the plain instruction set does, without fused multiply-add, so that both give the same bits.

// What is not inlined into a kernel does not run with its instructions.
#![allow(clippy::inline_always)]

use std::ops::{Add, Div, Mul, Neg, Sub};

use pulp::{Scalar, Simd};

use super::simd::{Lanes, Mask, nearest_whole, scaled_to};

/// A number, or several side by side on which every operation acts element by element.
pub(crate) trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Truth of a comparison.
    type Mask: Truth<Self>;

    /// What a constant is made with: the instruction set of a vector.
    type Context: Copy;

    /// The same number everywhere.
    fn splat(context: Self::Context, value: f64) -> Self;

    /// Another constant of the same width.
    fn constant(self, value: f64) -> Self;

    /// self * factor + addend, in one rounding where the instruction set has it.
    fn mul_add(self, factor: Self, addend: Self) -> Self;

    /// addend - self * factor, likewise.
    fn negate_mul_add(self, factor: Self, addend: Self) -> Self;

    /// Square root.
    fn sqrt(self) -> Self;

    /// Absolute value.
    fn abs(self) -> Self;

    /// The number where it is not negative, zero where it is; not a number stays so.
    fn positive_part(self) -> Self;

    /// The greater one; undefined where one is not a number.
    fn max(self, other: Self) -> Self;

    /// self > other
    fn greater(self, other: Self) -> Self::Mask;

    /// self < other
    fn less(self, other: Self) -> Self::Mask;

    /// Not self <= other: greater, or not a number.
    fn exceeds(self, other: Self) -> Self::Mask;

    /// The nearest whole number k, and 2^k if that is a normal number.
    fn nearest_whole(self) -> (Self, Self);

    /// (k, 2^k self) such that 2^k self lies between 2/3 and 3/2 of `other`; both are positive normal numbers.
    fn scaled_to(self, other: Self) -> (Self, Self);
}

/// Truth of a comparison of [`Real`] numbers, element by element.
pub(crate) trait Truth<R>: Copy {
    /// `yes` where true, `no` where false.
    fn select(self, yes: R, no: R) -> R;

    /// Both.
    fn and(self, other: Self) -> Self;

    /// One of them, or both.
    fn or(self, other: Self) -> Self;

    /// The opposite.
    fn not(self) -> Self;

    /// Whether any is true.
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
    #[allow(clippy::suboptimal_flops)] // without the instruction a fused product is a call of many
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
    #[allow(clippy::neg_cmp_op_on_partial_ord)] // true of what is not a number
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

/// Methods that a type has already.
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

//! One vector of numbers, with the operators of a number.

use std::ops::{Add, Div, Mul, Neg, Sub};

use pulp::Simd;

use super::{Numbers, WIDTH};

/// As many numbers as a vector of `S` holds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lanes<S: Simd> {
    simd: S,
    values: S::f64s,
}

/// True or false for each of them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mask<S: Simd> {
    simd: S,
    values: S::m64s,
}

/// The numbers of one vector of an array.
#[inline(always)]
pub(crate) fn load<S: Simd>(simd: S, values: &S::f64s) -> Lanes<S> {
    Lanes {
        simd,
        values: *values,
    }
}

/// The numbers of `slice`, which may be fewer than a vector holds; zeros after them.
#[inline(always)]
pub(crate) fn partial_load<S: Simd>(simd: S, slice: &[f64]) -> Lanes<S> {
    Lanes {
        simd,
        values: simd.partial_load_f64s(slice),
    }
}

/// The first `count` vectors of an array.
#[inline(always)]
pub(crate) fn vectors<S: Simd>(slice: &[f64], count: usize) -> &[S::f64s] {
    &S::as_simd_f64s(slice).0[..count]
}

/// The same to write to.
#[inline(always)]
pub(crate) fn vectors_mut<S: Simd>(slice: &mut [f64], count: usize) -> &mut [S::f64s] {
    &mut S::as_mut_simd_f64s(slice).0[..count]
}

/// `count` vectors of an array of x and of one of y, from entry `first` on.
#[inline(always)]
pub(crate) fn both<S: Simd>(arrays: &[Numbers; 2], first: usize, count: usize) -> [&[S::f64s]; 2] {
    [
        vectors::<S>(&arrays[0][first..], count),
        vectors::<S>(&arrays[1][first..], count),
    ]
}

/// The same to write to.
#[inline(always)]
pub(crate) fn both_mut<S: Simd>(
    arrays: &mut [Numbers; 2],
    first: usize,
    count: usize,
) -> [&mut [S::f64s]; 2] {
    let [x, y] = arrays;
    [
        vectors_mut::<S>(&mut x[first..], count),
        vectors_mut::<S>(&mut y[first..], count),
    ]
}

/// Two numbers, each everywhere in its vector. (What `map` calls is not always inlined, and then loses its instructions.)
#[inline(always)]
pub(crate) fn splat_two<S: Simd>(simd: S, [x, y]: [f64; 2]) -> [Lanes<S>; 2] {
    [Lanes::splat(simd, x), Lanes::splat(simd, y)]
}

/// 0, 1, 2, ... in a vector.
#[inline(always)]
pub(crate) fn lane_numbers<S: Simd>(simd: S) -> Lanes<S> {
    const NUMBERS: [f64; WIDTH] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    load(simd, &vectors::<S>(&NUMBERS, 1)[0])
}

impl<S: Simd> Lanes<S> {
    /// The same number everywhere.
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: f64) -> Self {
        Self {
            simd,
            values: simd.splat_f64s(value),
        }
    }

    /// From a vector.
    #[inline(always)]
    pub(crate) fn new(simd: S, values: S::f64s) -> Self {
        Self { simd, values }
    }

    /// The vector, to be stored.
    #[inline(always)]
    pub(crate) fn values(self) -> S::f64s {
        self.values
    }

    /// The instructions.
    #[inline(always)]
    pub(crate) fn simd(self) -> S {
        self.simd
    }

    /// Another constant of the same width.
    #[inline(always)]
    pub(crate) fn constant(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    /// self * factor + addend, in one rounding where the machine can.
    #[inline(always)]
    pub(crate) fn mul_add(self, factor: Self, addend: Self) -> Self {
        self.with(
            self.simd
                .mul_add_e_f64s(self.values, factor.values, addend.values),
        )
    }

    /// addend - self * factor, likewise.
    #[inline(always)]
    pub(crate) fn negate_mul_add(self, factor: Self, addend: Self) -> Self {
        self.with(
            self.simd
                .negate_mul_add_e_f64s(self.values, factor.values, addend.values),
        )
    }

    /// Square root.
    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        self.with(self.simd.sqrt_f64s(self.values))
    }

    /// Absolute value.
    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        let magnitude = self.simd.splat_f64s(f64::from_bits(!(1 << 63)));
        self.with(self.simd.and_f64s(magnitude, self.values))
    }

    /// The number where it is not negative, zero where it is; not a number stays so.
    #[inline(always)]
    pub(crate) fn positive_part(self) -> Self {
        let zero = self.constant(0.0);
        self.less(zero).select(zero, self)
    }

    /// The greater one; of no use where one is not a number.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        self.with(self.simd.max_f64s(self.values, other.values))
    }

    /// The greatest of all.
    #[inline(always)]
    pub(crate) fn greatest(self) -> f64 {
        self.simd.reduce_max_f64s(self.values)
    }

    /// The sum of all: halves are added until one number is left.
    #[inline(always)]
    pub(crate) fn sum(self) -> f64 {
        self.simd.reduce_sum_f64s(self.values)
    }

    /// The second to the last of `count` numbers, moved to the first place, and `next` behind them; zeros behind that.
    #[inline(always)]
    pub(crate) fn followed_by(self, next: f64, count: usize) -> Self {
        if S::F64_LANES == WIDTH {
            let lane = lane_numbers(self.simd);
            let last = lane.greater(self.constant(count as f64 - 1.5));
            let turned = last.select(self.constant(next), self.turned());
            return lane
                .less(self.constant(count as f64 - 0.5))
                .select(turned, self.constant(0.0));
        }
        let mut numbers = [0.0; 2 * WIDTH];
        vectors_mut::<S>(&mut numbers, 1)[0] = self.values;
        numbers[count] = next;
        load(self.simd, &vectors::<S>(&numbers[1..], 1)[0])
    }

    /// The second and all after it, moved to the first place, and in the last place, which `last` is true for, the first
    /// of `next`.
    #[inline(always)]
    pub(crate) fn moved_on(self, next: Self, last: Mask<S>) -> Self {
        last.select(next.turned(), self.turned())
    }

    /// The second and all after it, moved to the first place, and the first in the last.
    #[inline(always)]
    fn turned(self) -> Self {
        self.with(self.simd.rotate_left_f64s(self.values, 1))
    }

    /// The number `distance` places on, the first ones behind the last.
    #[inline(always)]
    pub(crate) fn turned_by(self, distance: usize) -> Self {
        self.with(self.simd.rotate_left_f64s(self.values, distance))
    }

    /// self > other
    #[inline(always)]
    pub(crate) fn greater(self, other: Self) -> Mask<S> {
        self.mask(self.simd.greater_than_f64s(self.values, other.values))
    }

    /// self < other
    #[inline(always)]
    pub(crate) fn less(self, other: Self) -> Mask<S> {
        self.mask(self.simd.less_than_f64s(self.values, other.values))
    }

    /// Not self <= other: greater, or not a number.
    #[inline(always)]
    pub(crate) fn exceeds(self, other: Self) -> Mask<S> {
        let within = self.simd.less_than_or_equal_f64s(self.values, other.values);
        self.mask(self.simd.not_m64s(within))
    }

    #[inline(always)]
    fn with(self, values: S::f64s) -> Self {
        Self { values, ..self }
    }

    #[inline(always)]
    fn mask(self, values: S::m64s) -> Mask<S> {
        Mask {
            simd: self.simd,
            values,
        }
    }
}

impl<S: Simd> Mask<S> {
    /// `yes` where true, `no` where false.
    #[inline(always)]
    pub(crate) fn select(self, yes: Lanes<S>, no: Lanes<S>) -> Lanes<S> {
        yes.with(self.simd.select_f64s(self.values, yes.values, no.values))
    }

    /// The same for two.
    #[inline(always)]
    pub(crate) fn select_two(self, yes: [Lanes<S>; 2], no: [Lanes<S>; 2]) -> [Lanes<S>; 2] {
        [self.select(yes[0], no[0]), self.select(yes[1], no[1])]
    }

    /// Whether any is true.
    #[inline(always)]
    pub(crate) fn any(self) -> bool {
        self.simd.first_true_m64s(self.values) < S::F64_LANES
    }

    /// Both.
    #[inline(always)]
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            values: self.simd.and_m64s(self.values, other.values),
            ..self
        }
    }

    /// One of them, or both.
    #[inline(always)]
    pub(crate) fn or(self, other: Self) -> Self {
        Self {
            values: self.simd.or_m64s(self.values, other.values),
            ..self
        }
    }

    /// One of them, not both.
    #[inline(always)]
    pub(crate) fn differs(self, other: Self) -> Self {
        Self {
            values: self.simd.xor_m64s(self.values, other.values),
            ..self
        }
    }

    /// The other way round.
    #[inline(always)]
    pub(crate) fn not(self) -> Self {
        Self {
            values: self.simd.not_m64s(self.values),
            ..self
        }
    }
}

impl<S: Simd> Add for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(self.simd.add_f64s(self.values, other.values))
    }
}

impl<S: Simd> Sub for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(self.simd.sub_f64s(self.values, other.values))
    }
}

impl<S: Simd> Mul for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(self.simd.mul_f64s(self.values, other.values))
    }
}

impl<S: Simd> Div for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.with(self.simd.div_f64s(self.values, other.values))
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        // Written out: pulp's own is not always inlined into a kernel, and then it runs without its instructions.
        self.with(self.simd.xor_f64s(self.values, self.simd.splat_f64s(-0.0)))
    }
}

//! Vectors of numbers of one precision, with the operations of an instruction set.

#[cfg(target_arch = "x86_64")]
use std::any::Any;
#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::__m256;
use std::fmt::Debug;

use bytemuck::Pod;
#[cfg(target_arch = "x86_64")]
use pulp::x86::V3;
use pulp::{Simd, WithSimd};

use super::{InstructionSet, Pack, WIDTH};

/// Number in a vector: of double or of single precision.
pub(crate) trait Number: Pod + Debug + Default + Send + Sync {
    /// Vectors of this number with instruction set `S`.
    type Vectors<S: Simd>: Vectors<Number = Self>;

    /// Return the operations on vectors of this number.
    fn vectors<S: Simd>(simd: S) -> Self::Vectors<S>;

    /// Run a kernel whose vectors are of this number. Vectors have at most as many numbers as a pack.
    fn run<Kernel: WithSimd>(instructions: InstructionSet, kernel: Kernel) -> Kernel::Output;

    /// Return the nearest number.
    fn nearest(value: f64) -> Self;

    /// Return the number in double precision.
    fn double(self) -> f64;
}

/// Operations on vectors of one precision. An instruction set itself stands for vectors of double precision.
pub(crate) trait Vectors: Copy + Debug + 'static {
    /// Number in each lane.
    type Number: Number;
    /// Vector.
    type Vector: Pod + Debug;
    /// True or false in each lane.
    type Mask: Copy + Debug;
    /// Instruction set.
    type Instructions: Simd;
    /// Numbers in a vector.
    const LANES: usize;

    /// Return the instruction set.
    fn instructions(self) -> Self::Instructions;
    /// Return the same number in all lanes.
    fn splat(self, value: f64) -> Self::Vector;
    /// Return a + b.
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Return a - b.
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Return a b.
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Return a / b.
    fn div(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Return a b + c.
    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    /// Return c - a b.
    fn negate_mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
    /// Return the square root.
    fn sqrt(self, a: Self::Vector) -> Self::Vector;
    /// Return the larger number.
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Return the smaller number.
    fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Return -a.
    fn negate(self, a: Self::Vector) -> Self::Vector;
    /// Return |a|.
    fn abs(self, a: Self::Vector) -> Self::Vector;
    /// Return the largest of all lanes.
    fn greatest(self, a: Self::Vector) -> f64;
    /// Return the sum of all lanes: halves are added until one number is left.
    fn sum(self, a: Self::Vector) -> f64;
    /// Rotate all lanes down by `distance`.
    fn rotate(self, a: Self::Vector, distance: usize) -> Self::Vector;
    /// Return a > b.
    fn greater(self, a: Self::Vector, b: Self::Vector) -> Self::Mask;
    /// Return a < b.
    fn less(self, a: Self::Vector, b: Self::Vector) -> Self::Mask;
    /// Return a <= b.
    fn at_most(self, a: Self::Vector, b: Self::Vector) -> Self::Mask;
    /// Return `yes` where true and `no` where false.
    fn select(self, mask: Self::Mask, yes: Self::Vector, no: Self::Vector) -> Self::Vector;
    /// Return the number of the first lane that is true.
    fn first_true(self, mask: Self::Mask) -> usize;
    /// Return the conjunction.
    fn both(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Return the disjunction.
    fn either(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Return the exclusive disjunction.
    fn differ(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Return the negation.
    fn not(self, a: Self::Mask) -> Self::Mask;
    /// Return whole vectors of an array, and the numbers behind them.
    fn whole(array: &[Self::Number]) -> (&[Self::Vector], &[Self::Number]);
    /// Return whole vectors of an array, mutable, and the numbers behind them.
    fn whole_mut(array: &mut [Self::Number]) -> (&mut [Self::Vector], &mut [Self::Number]);
    /// Load numbers that may be fewer than lanes; the remaining lanes are zero.
    fn load_some(self, numbers: &[Self::Number]) -> Self::Vector;
    /// Load vector `part` of a pack of doubles, rounded.
    fn load_doubles(self, pack: &Pack, part: usize) -> Self::Vector;
    /// Store vector `part` of a pack of doubles.
    fn store_doubles(self, pack: &mut Pack, part: usize, values: Self::Vector);
    /// Return the vector with zeros in the place of numbers whose products with others may be subnormal.
    fn without_tiny(self, a: Self::Vector) -> Self::Vector;
}

/// Size below which a number of single precision counts as zero in residuals.
///
/// Numbers below 1.2e-38 are subnormal. Operations on such numbers are slow on processors by Intel.
const TINY: f64 = 1e-24;

/// Vectors of single precision with instruction set `S`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Single<S: Simd>(S);

impl Number for f64 {
    type Vectors<S: Simd> = S;

    #[inline(always)]
    fn vectors<S: Simd>(simd: S) -> S {
        simd
    }

    #[inline(always)]
    fn run<Kernel: WithSimd>(instructions: InstructionSet, kernel: Kernel) -> Kernel::Output {
        instructions.run(kernel)
    }

    #[inline(always)]
    fn nearest(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn double(self) -> f64 {
        self
    }
}

impl Number for f32 {
    type Vectors<S: Simd> = Single<S>;

    #[inline(always)]
    fn vectors<S: Simd>(simd: S) -> Single<S> {
        Single(simd)
    }

    #[inline(always)]
    fn run<Kernel: WithSimd>(instructions: InstructionSet, kernel: Kernel) -> Kernel::Output {
        instructions.run_half_as_wide(kernel)
    }

    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)] // rounded on purpose
    fn nearest(value: f64) -> Self {
        value as Self
    }

    #[inline(always)]
    fn double(self) -> f64 {
        f64::from(self)
    }
}

/// Implement operations of [`Vectors`] by those of an instruction set.
macro_rules! operations {
    ($simd:expr, $self:ident; $($name:ident($($argument:ident: $kind:ident),*) -> $result:ty = $operation:ident;)*) => {$(
        #[inline(always)]
        fn $name($self, $($argument: Self::$kind),*) -> $result {
            $simd.$operation($($argument),*)
        }
    )*};
}

impl<S: Simd> Vectors for S {
    type Number = f64;
    type Vector = S::f64s;
    type Mask = S::m64s;
    type Instructions = S;
    const LANES: usize = S::F64_LANES;

    operations! { self, self;
        add(a: Vector, b: Vector) -> Self::Vector = add_f64s;
        sub(a: Vector, b: Vector) -> Self::Vector = sub_f64s;
        mul(a: Vector, b: Vector) -> Self::Vector = mul_f64s;
        div(a: Vector, b: Vector) -> Self::Vector = div_f64s;
        mul_add(a: Vector, b: Vector, c: Vector) -> Self::Vector = mul_add_e_f64s;
        negate_mul_add(a: Vector, b: Vector, c: Vector) -> Self::Vector = negate_mul_add_e_f64s;
        sqrt(a: Vector) -> Self::Vector = sqrt_f64s;
        max(a: Vector, b: Vector) -> Self::Vector = max_f64s;
        min(a: Vector, b: Vector) -> Self::Vector = min_f64s;
        greatest(a: Vector) -> f64 = reduce_max_f64s;
        sum(a: Vector) -> f64 = reduce_sum_f64s;
        greater(a: Vector, b: Vector) -> Self::Mask = greater_than_f64s;
        less(a: Vector, b: Vector) -> Self::Mask = less_than_f64s;
        at_most(a: Vector, b: Vector) -> Self::Mask = less_than_or_equal_f64s;
        select(mask: Mask, yes: Vector, no: Vector) -> Self::Vector = select_f64s;
        first_true(mask: Mask) -> usize = first_true_m64s;
        both(a: Mask, b: Mask) -> Self::Mask = and_m64s;
        either(a: Mask, b: Mask) -> Self::Mask = or_m64s;
        differ(a: Mask, b: Mask) -> Self::Mask = xor_m64s;
        not(a: Mask) -> Self::Mask = not_m64s;
    }

    #[inline(always)]
    fn instructions(self) -> S {
        self
    }

    #[inline(always)]
    fn splat(self, value: f64) -> S::f64s {
        self.splat_f64s(value)
    }

    #[inline(always)]
    fn negate(self, a: S::f64s) -> S::f64s {
        // Written out, because pulp's own operation is not always inlined into a kernel and then loses its instruction set.
        self.xor_f64s(a, self.splat_f64s(-0.0))
    }

    #[inline(always)]
    fn abs(self, a: S::f64s) -> S::f64s {
        self.and_f64s(self.splat_f64s(f64::from_bits(!(1 << 63))), a)
    }

    #[inline(always)]
    fn rotate(self, a: S::f64s, distance: usize) -> S::f64s {
        self.rotate_left_f64s(a, distance)
    }

    #[inline(always)]
    fn whole(array: &[f64]) -> (&[S::f64s], &[f64]) {
        S::as_simd_f64s(array)
    }

    #[inline(always)]
    fn whole_mut(array: &mut [f64]) -> (&mut [S::f64s], &mut [f64]) {
        S::as_mut_simd_f64s(array)
    }

    #[inline(always)]
    fn load_some(self, numbers: &[f64]) -> S::f64s {
        self.partial_load_f64s(numbers)
    }

    #[inline(always)]
    fn load_doubles(self, pack: &Pack, part: usize) -> S::f64s {
        Self::whole(pack).0[part]
    }

    #[inline(always)]
    fn store_doubles(self, pack: &mut Pack, part: usize, values: S::f64s) {
        Self::whole_mut(pack).0[part] = values;
    }

    #[inline(always)]
    fn without_tiny(self, a: S::f64s) -> S::f64s {
        a
    }
}

impl<S: Simd> Vectors for Single<S> {
    type Number = f32;
    type Vector = S::f32s;
    type Mask = S::m32s;
    type Instructions = S;
    const LANES: usize = S::F32_LANES;

    operations! { self.0, self;
        add(a: Vector, b: Vector) -> Self::Vector = add_f32s;
        sub(a: Vector, b: Vector) -> Self::Vector = sub_f32s;
        mul(a: Vector, b: Vector) -> Self::Vector = mul_f32s;
        div(a: Vector, b: Vector) -> Self::Vector = div_f32s;
        mul_add(a: Vector, b: Vector, c: Vector) -> Self::Vector = mul_add_e_f32s;
        negate_mul_add(a: Vector, b: Vector, c: Vector) -> Self::Vector = negate_mul_add_e_f32s;
        sqrt(a: Vector) -> Self::Vector = sqrt_f32s;
        max(a: Vector, b: Vector) -> Self::Vector = max_f32s;
        min(a: Vector, b: Vector) -> Self::Vector = min_f32s;
        greater(a: Vector, b: Vector) -> Self::Mask = greater_than_f32s;
        less(a: Vector, b: Vector) -> Self::Mask = less_than_f32s;
        at_most(a: Vector, b: Vector) -> Self::Mask = less_than_or_equal_f32s;
        select(mask: Mask, yes: Vector, no: Vector) -> Self::Vector = select_f32s;
        first_true(mask: Mask) -> usize = first_true_m32s;
        both(a: Mask, b: Mask) -> Self::Mask = and_m32s;
        either(a: Mask, b: Mask) -> Self::Mask = or_m32s;
        differ(a: Mask, b: Mask) -> Self::Mask = xor_m32s;
        not(a: Mask) -> Self::Mask = not_m32s;
    }

    #[inline(always)]
    fn instructions(self) -> S {
        self.0
    }

    #[inline(always)]
    fn splat(self, value: f64) -> S::f32s {
        self.0.splat_f32s(f32::nearest(value))
    }

    #[inline(always)]
    fn negate(self, a: S::f32s) -> S::f32s {
        self.0.xor_f32s(a, self.0.splat_f32s(-0.0))
    }

    #[inline(always)]
    fn abs(self, a: S::f32s) -> S::f32s {
        self.0
            .and_f32s(self.0.splat_f32s(f32::from_bits(!(1 << 31))), a)
    }

    #[inline(always)]
    fn greatest(self, a: S::f32s) -> f64 {
        self.0.reduce_max_f32s(a).double()
    }

    #[inline(always)]
    fn sum(self, a: S::f32s) -> f64 {
        self.0.reduce_sum_f32s(a).double()
    }

    #[inline(always)]
    fn rotate(self, a: S::f32s, distance: usize) -> S::f32s {
        #[cfg(target_arch = "x86_64")]
        if let Some(v3) = avx2(self.0) {
            // One instruction; pulp's own operation has several.
            let order = bytemuck::cast(TURNED[distance % WIDTH]);
            let turned = v3.avx2._mm256_permutevar8x32_ps(bytemuck::cast(a), order);
            return bytemuck::cast(turned);
        }
        self.0.rotate_left_f32s(a, distance)
    }

    #[inline(always)]
    fn whole(array: &[f32]) -> (&[S::f32s], &[f32]) {
        S::as_simd_f32s(array)
    }

    #[inline(always)]
    fn whole_mut(array: &mut [f32]) -> (&mut [S::f32s], &mut [f32]) {
        S::as_mut_simd_f32s(array)
    }

    #[inline(always)]
    fn load_some(self, numbers: &[f32]) -> S::f32s {
        self.0.partial_load_f32s(numbers)
    }

    #[inline(always)]
    fn load_doubles(self, pack: &Pack, part: usize) -> S::f32s {
        #[cfg(target_arch = "x86_64")]
        if let Some(v3) = avx2(self.0) {
            let half = |i: usize| v3.avx._mm256_cvtpd_ps(bytemuck::cast(V3::whole(pack).0[i]));
            return bytemuck::cast(v3.avx._mm256_set_m128(half(1), half(0)));
        }
        let mut singles = [0.0f32; WIDTH];
        for (single, &number) in singles.iter_mut().zip(pack) {
            *single = f32::nearest(number);
        }
        Self::whole(&singles).0[part]
    }

    #[inline(always)]
    fn store_doubles(self, pack: &mut Pack, part: usize, values: S::f32s) {
        #[cfg(target_arch = "x86_64")]
        if let Some(v3) = avx2(self.0) {
            let values: __m256 = bytemuck::cast(values);
            let low = v3.avx._mm256_castps256_ps128(values);
            let high = v3.avx._mm256_extractf128_ps::<1>(values);
            let halves = V3::whole_mut(pack).0;
            halves[0] = bytemuck::cast(v3.avx._mm256_cvtps_pd(low));
            halves[1] = bytemuck::cast(v3.avx._mm256_cvtps_pd(high));
            return;
        }
        let values = [values];
        let singles: &[f32] = bytemuck::cast_slice(&values);
        for (number, single) in pack[part * Self::LANES..].iter_mut().zip(singles) {
            *number = single.double();
        }
    }

    #[inline(always)]
    fn without_tiny(self, a: S::f32s) -> S::f32s {
        let tiny = self.less(self.abs(a), self.splat(TINY));
        self.select(tiny, self.splat(0.0), a)
    }
}

/// Lanes of eight numbers rotated down by 0 to 7.
#[cfg(target_arch = "x86_64")]
const TURNED: [[u32; WIDTH]; WIDTH] = [
    [0, 1, 2, 3, 4, 5, 6, 7],
    [1, 2, 3, 4, 5, 6, 7, 0],
    [2, 3, 4, 5, 6, 7, 0, 1],
    [3, 4, 5, 6, 7, 0, 1, 2],
    [4, 5, 6, 7, 0, 1, 2, 3],
    [5, 6, 7, 0, 1, 2, 3, 4],
    [6, 7, 0, 1, 2, 3, 4, 5],
    [7, 0, 1, 2, 3, 4, 5, 6],
];

/// Return the instructions of AVX2 if `simd` is that set.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn avx2<S: Simd>(simd: S) -> Option<V3> {
    let any: &dyn Any = &simd;
    any.downcast_ref().copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::simd::{Entries, parts, put_double_part, rounded_part};

    struct Copy<'a, T>(&'a Pack, &'a mut Pack, std::marker::PhantomData<T>);

    impl<T: Number> WithSimd for Copy<'_, T> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let simd = T::vectors(simd);
            for part in parts::<T::Vectors<S>>() {
                put_double_part(self.1, part, rounded_part(simd, self.0, part));
            }
        }
    }

    fn assert_rounded<T: Number>() {
        let from = [
            0.1,
            -1.0 / 3.0,
            1e-50,
            1e30,
            -0.0,
            7.0,
            f64::EPSILON,
            1.0 + 1e-9,
        ];
        for set in InstructionSet::available() {
            let mut to = [f64::NAN; WIDTH];
            T::run(set, Copy::<T>(&from, &mut to, std::marker::PhantomData));
            assert_eq!(to, from.map(|x| T::nearest(x).double()), "{}", set.name());
        }
    }

    /// Writes all vectors of an array without its tiny numbers.
    struct WithoutTiny<'a, T>(&'a [f64], &'a mut Pack, std::marker::PhantomData<T>);

    impl<T: Number> WithSimd for WithoutTiny<'_, T> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let entries = Entries::of(T::vectors(simd), self.0);
            for part in parts::<T::Vectors<S>>() {
                put_double_part(self.1, part, entries.at(0, part));
            }
        }
    }

    fn without_tiny<T: Number>(set: InstructionSet, from: &[f64]) -> Pack {
        let mut to = [f64::NAN; WIDTH];
        T::run(
            set,
            WithoutTiny::<T>(from, &mut to, std::marker::PhantomData),
        );
        to
    }

    #[test]
    fn tiny_entries_of_single_precision_are_zero() {
        let all = [1e-40, -9e-25, 1.5e-24, -2.0, 0.0, f64::NAN, -1e-300, 1e24];
        let kept = [0.0, 0.0, 1.5e-24, -2.0, 0.0, f64::NAN, 0.0, 1e24];
        let same = |a: &[f64], b: &[f64]| {
            let pairs = a.iter().zip(b);
            pairs.fold(true, |same, (a, b)| {
                same && (a == b || a.is_nan() && b.is_nan())
            })
        };
        for set in InstructionSet::available() {
            let single = kept.map(|x| f32::nearest(x).double());
            assert!(
                same(&without_tiny::<f32>(set, &all), &single),
                "{}",
                set.name()
            );
            assert!(
                same(&without_tiny::<f64>(set, &all), &all),
                "{}",
                set.name()
            );
            // The last vector of an array ends within it.
            let rest = without_tiny::<f32>(set, &all[..5]);
            assert!(same(&rest[..5], &single[..5]), "{}", set.name());
            assert_eq!(rest[5..], [0.0; 3]);
        }
    }

    #[test]
    fn doubles_are_read_rounded_and_written_at_every_width() {
        assert_rounded::<f64>();
        assert_rounded::<f32>();
    }
}

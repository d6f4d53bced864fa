//! Natural logarithm of numbers, and of quotients without a division.
//!
//! a/b = 2^k (1 + s)/(1 - s) with s = (a - 2^k b)/(a + 2^k b) and |s| < 0.202. The difference is exact, so that quotients near 1 have no
//! cancellation. The series in s² is a minimax fit with a relative error of 2e-17.

use pulp::{Simd, cast};

use super::Lanes;
use crate::math::Real;

/// ln 2 to 32 bits, whose products with exponents are exact, and the remainder.
pub(super) const LN_2: [f64; 2] = [
    f64::from_bits(0x3FE6_2E42_FEE0_0000),
    f64::from_bits(0x3DEA_39EF_3579_3C76),
];

/// Coefficients of (ln((1 + s)/(1 - s)) - 2s)/s³ in powers of s².
const SERIES: [f64; 7] = [
    0.666_666_666_666_728,
    0.399_999_999_961_139_6,
    0.285_714_294_038_433_35,
    0.222_221_378_032_944_14,
    0.181_863_846_601_881_3,
    0.152_496_165_821_431_22,
    0.153_726_396_891_824_32,
];

/// Return ln x of positive normal numbers up to 2^1022 to 2.1 units in the last place; infinity and NaN are kept.
///
/// The result is undefined for zero, subnormal, negative and larger numbers. The force laws use its parts; tests use the whole function.
#[cfg(test)]
#[inline(always)]
pub(crate) fn ln<R: Real>(x: R) -> R {
    let logarithm = ln_of_quotient(x, x.constant(1.0));
    crate::math::Truth::select(x.exceeds(x.constant(f64::MAX)), x, logarithm)
}

/// Return ln(a/b) of numbers from 2^-1021 to 2^1022, to 2.5 units in the last place also near 1.
#[inline(always)]
pub(crate) fn ln_of_quotient<R: Real>(a: R, b: R) -> R {
    let (k, rest) = octaves_of_quotient(a, b);
    let [head, tail] = LN_2.map(|part| k.constant(part));
    k.mul_add(head, k.mul_add(tail, rest))
}

/// Return (k, r) of ln(a/b) = k ln 2 + r, k an integer and |r| < 0.41, for numbers as in [`ln_of_quotient`].
#[inline(always)]
pub(crate) fn octaves_of_quotient<R: Real>(a: R, b: R) -> (R, R) {
    let (k, b) = b.scaled_to(a);
    let s = (a - b) / (a + b);
    let z = s * s;
    let [c0, c1, c2, c3, c4, c5, c6] = SERIES.map(|coefficient| s.constant(coefficient));
    // Estrin's scheme for the series in s².
    let z2 = z * z;
    let (low, middle) = (c1.mul_add(z, c0), c3.mul_add(z, c2));
    let high = c6.mul_add(z2, c5.mul_add(z, c4));
    let series = high.mul_add(z2, middle).mul_add(z2, low);
    (k, (s * z).mul_add(series, s + s))
}

/// Return (k, 2^k b) such that 2^k b lies between 2/3 and 3/2 of a.
#[inline(always)]
pub(in crate::math) fn scaled_to<S: Simd>(b: Lanes<S>, a: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    let simd = b.simd();
    let (a_bits, b_bits) = (
        simd.transmute_u64s_f64s(a.values()),
        simd.transmute_u64s_f64s(b.values()),
    );
    // The bits of a number approximate its binary logarithm in units of 2^-52; k is the difference, rounded.
    let difference = simd.sub_u64s(a_bits, b_bits);
    let exponent = simd.and_u64s(
        simd.add_u64s(difference, simd.splat_u64s(1 << 51)),
        simd.splat_u64s(0xFFF << 52),
    );
    let scaled = simd.transmute_f64s_u64s(simd.add_u64s(b_bits, exponent));

    // k + 2048 is in the upper half, from bit 20. It is moved to the lower half of the number 2^32, whose last bit has the value 2^-20.
    let biased = simd.xor_u64s(exponent, simd.splat_u64s(1 << 63));
    let halves_swapped: S::u64s = cast(simd.swap_re_im_c32s(cast(biased)));
    let base = (1u64 << 32) as f64;
    let sum = simd.or_u64s(halves_swapped, simd.splat_u64s(base.to_bits()));
    let k = Lanes::new(simd, simd.transmute_f64s_u64s(sum)) - b.constant(base + 2048.0);
    (k, Lanes::new(simd, scaled))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::math::simd::testing::{LaneFunction, assert_near};

    struct Logarithm;
    struct QuotientBy(f64);

    impl LaneFunction for Logarithm {
        #[inline(always)]
        fn of<S: Simd>(&self, x: Lanes<S>) -> Lanes<S> {
            ln(x)
        }
    }

    impl LaneFunction for QuotientBy {
        #[inline(always)]
        fn of<S: Simd>(&self, x: Lanes<S>) -> Lanes<S> {
            ln_of_quotient(x, x.constant(self.0))
        }
    }

    #[test]
    fn ends_of_the_range() {
        let xs = [
            f64::MIN_POSITIVE,
            2f64.powi(1022),
            f64::INFINITY,
            f64::NAN,
            1.0,
            1.0f64.next_up(),
            1.0f64.next_down(),
            1.5,
            1.5f64.next_down(),
            0.75,
            0.75f64.next_down(),
        ];
        assert_near(&Logarithm, &xs, 3, f64::ln);
    }

    proptest! {
        #[test]
        fn of_any_positive_number(
            exponents in proptest::collection::vec(-708.0..709.0f64, 64),
            near_one in proptest::collection::vec(0.5..2.0f64, 64),
        ) {
            let xs: Vec<f64> = exponents.iter().map(|e| e.exp()).collect();
            assert_near(&Logarithm, &xs, 3, f64::ln);
            assert_near(&Logarithm, &near_one, 3, f64::ln);
        }

        #[test]
        fn of_quotients_near_one(divisor in 1e-6..1e-5f64, parts in proptest::collection::vec(1e-16..0.3f64, 64)) {
            let xs: Vec<f64> = parts.iter().map(|part| divisor * (1.0 - part)).collect();
            // The difference is exact: the argument of ln_1p has a single rounding error.
            assert_near(&QuotientBy(divisor), &xs, 4, |x| ((x - divisor) / divisor).ln_1p());
        }
    }
}

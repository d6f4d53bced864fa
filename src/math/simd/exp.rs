//! Exponential.
//!
//! x = k ln 2 + r with k the nearest integer; e^r is a minimax polynomial on |r| <= ln(2)/2 with a relative error of 4e-18.

use pulp::Simd;

use super::Lanes;
use super::ln::LN_2;
use crate::math::{Real, Truth};

/// Coefficients of (e^r - 1 - r)/r² in powers of r.
const SERIES: [f64; 10] = [
    0.500_000_000_000_001_1,
    0.166_666_666_666_664_13,
    0.041_666_666_666_530_03,
    0.008_333_333_333_494_711,
    0.001_388_888_894_366_882_9,
    0.000_198_412_695_061_355_66,
    2.480_149_305_397_194_4e-5,
    2.755_758_667_778_224_7e-6,
    2.763_026_591_200_797e-7,
    2.499_999_557_077_961e-8,
];

/// Return e^x of any number to 1 unit in the last place; NaN is kept.
#[inline(always)]
pub(crate) fn exp<R: Real>(x: R) -> R {
    // The result is zero or infinite beyond these limits without further checks.
    let (least, greatest) = (x.constant(-746.0), x.constant(710.0));
    let x = x.less(least).select(least, x);
    let x = x.greater(greatest).select(greatest, x);
    let (k, _) = (x * x.constant(std::f64::consts::LOG2_E)).nearest_whole();
    let [head, tail] = [x.constant(LN_2[0]), x.constant(LN_2[1])];
    let r = k.negate_mul_add(tail, k.negate_mul_add(head, x));
    // 2^k is computed as two factors: it may lie outside the normal numbers where e^x does not.
    let (first, first_power) = (k * x.constant(0.5)).nearest_whole();
    let (_, second_power) = (k - first).nearest_whole();
    exp_of_remainder(r) * first_power * second_power
}

/// Return the nearest integer k, and 2^k if that is a normal number.
#[inline(always)]
pub(in crate::math) fn nearest_whole<S: Simd>(x: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    let simd = x.simd();
    // The addition of 1.5 2^52 rounds to an integer, whose last bits are those of the sum.
    let magic = x.constant(1.5 * (1u64 << 52) as f64);
    let shifted = x + magic;
    let bits = simd.transmute_u64s_f64s(shifted.values());
    // The low bits of k, shifted by 52, are added to the exponent of 1.0.
    let exponent = simd.mul_u64s(bits, simd.splat_u64s(1 << 52));
    let power = simd.add_u64s(exponent, simd.splat_u64s(1.0f64.to_bits()));
    (
        shifted - magic,
        Lanes::new(simd, simd.transmute_f64s_u64s(power)),
    )
}

/// Return e^r for |r| <= ln(2)/2.
#[inline(always)]
pub(crate) fn exp_of_remainder<R: Real>(r: R) -> R {
    // Estrin's scheme: independent products shorten the chain of dependent operations.
    let [a, b, c, d, e, f, g, h, i, j] = SERIES.map(|coefficient| r.constant(coefficient));
    let r2 = r * r;
    let r4 = r2 * r2;
    let (ab, cd, ef) = (b.mul_add(r, a), d.mul_add(r, c), f.mul_add(r, e));
    let (gh, ij) = (h.mul_add(r, g), j.mul_add(r, i));
    let (abcd, efgh) = (cd.mul_add(r2, ab), gh.mul_add(r2, ef));
    let series = ij.mul_add(r4, efgh).mul_add(r4, abcd);
    series.mul_add(r2, r) + r.constant(1.0)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::math::simd::testing::{LaneFunction, assert_near};

    struct Exponential;

    impl LaneFunction for Exponential {
        #[inline(always)]
        fn of<S: Simd>(&self, x: Lanes<S>) -> Lanes<S> {
            exp(x)
        }
    }

    #[test]
    fn ends_of_the_range() {
        let xs = [
            0.0,
            -0.0,
            5e-324,
            -5e-324,
            709.7,
            709.78,
            709.79,
            1e4,
            f64::INFINITY,
            -700.0,
            -708.5,
            -745.1,
            -745.2,
            -1e4,
            f64::NEG_INFINITY,
            f64::NAN,
            f64::from_bits(0x7FF8_0000_0000_0FFF),
        ];
        assert_near(&Exponential, &xs, 2, f64::exp);
    }

    proptest! {
        #[test]
        fn of_any_number(
            moderate in proptest::collection::vec(-2.0..2.0f64, 64),
            far in proptest::collection::vec(-750.0..715.0f64, 64),
        ) {
            assert_near(&Exponential, &moderate, 2, f64::exp);
            assert_near(&Exponential, &far, 2, f64::exp);
        }
    }
}

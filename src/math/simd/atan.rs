//! Arc tangent.
//!
//! The argument is reduced by an angle of 0, π/4 or π/2 to |x| <= 0.66. The rational form of S. L. Moshier's Cephes library has a relative
//! error of 2e-17 there.

use crate::math::{Real, Truth};

/// Numerator of (arctan x - x)/x³ in powers of x², highest first.
const ABOVE: [f64; 5] = [
    -8.750_608_600_031_904e-1,
    -1.615_753_718_733_365e1,
    -7.500_855_792_314_705e1,
    -1.228_866_684_490_136_1e2,
    -6.485_021_904_942_025e1,
];

/// Denominator, whose highest coefficient is one.
const BELOW: [f64; 5] = [
    2.485_846_490_142_306_3e1,
    1.650_270_098_316_988_5e2,
    4.328_810_604_912_903e2,
    4.853_903_996_359_137e2,
    1.945_506_571_482_614e2,
];

/// tan(3π/8); a larger argument is reduced by π/2.
const STEEP: f64 = std::f64::consts::SQRT_2 + 1.0;

/// A larger argument is reduced by π/4.
const FLAT: f64 = 0.66;

/// Difference between π/2 and its nearest `f64`.
const REST: f64 = 6.123_233_995_736_766e-17;

/// Return arctan x of any number to 2 units in the last place; NaN is kept.
#[inline(always)]
pub(crate) fn arc_tangent<R: Real>(x: R) -> R {
    let (zero, one) = (x.constant(0.0), x.constant(1.0));
    let size = x.abs();
    // |x| is replaced by -1/|x| above tan(3π/8), with the angle π/2, and by (|x| - 1)/(|x| + 1) above 0.66, with π/4.
    let steep = size.greater(x.constant(STEEP));
    let turned = size.greater(x.constant(FLAT));
    let above = steep.select(-one, turned.select(size - one, size));
    let below = steep.select(size, turned.select(size + one, one));
    let start = steep.select(
        x.constant(std::f64::consts::FRAC_PI_2),
        turned.select(x.constant(std::f64::consts::FRAC_PI_4), zero),
    );
    let rest = steep.select(
        x.constant(REST),
        turned.select(x.constant(0.5 * REST), zero),
    );
    let x_turned = above / below;
    let z = x_turned * x_turned;
    let [a, b, c, d, e] = ABOVE.map(|coefficient| x.constant(coefficient));
    let above = a.mul_add(z, b).mul_add(z, c).mul_add(z, d).mul_add(z, e);
    let [a, b, c, d, e] = BELOW.map(|coefficient| x.constant(coefficient));
    let below = (z + a)
        .mul_add(z, b)
        .mul_add(z, c)
        .mul_add(z, d)
        .mul_add(z, e);
    let series = z * above / below;
    let angle = start + (x_turned.mul_add(series, x_turned) + rest);
    x.less(zero).select(-angle, angle)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use pulp::Simd;

    use super::*;
    use crate::math::simd::Lanes;
    use crate::math::simd::testing::{LaneFunction, assert_near};

    struct ArcTangent;

    impl LaneFunction for ArcTangent {
        #[inline(always)]
        fn of<S: Simd>(&self, x: Lanes<S>) -> Lanes<S> {
            arc_tangent(x)
        }
    }

    #[test]
    fn ends_of_the_range() {
        let xs = [
            0.0,
            5e-324,
            1e-9,
            FLAT,
            FLAT.next_up(),
            1.0,
            STEEP,
            STEEP.next_up(),
            -3.0,
            1e300,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NAN,
        ];
        assert_near(&ArcTangent, &xs, 2, f64::atan);
    }

    proptest! {
        #[test]
        fn of_any_number(
            moderate in proptest::collection::vec(-4.0..4.0f64, 64),
            exponents in proptest::collection::vec(-40.0..40.0f64, 64),
        ) {
            let far: Vec<f64> = exponents.iter().map(|e| e.exp()).collect();
            assert_near(&ArcTangent, &moderate, 2, f64::atan);
            assert_near(&ArcTangent, &far, 2, f64::atan);
        }
    }
}

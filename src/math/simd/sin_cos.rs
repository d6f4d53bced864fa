//! Sine and cosine of a vector of angles.
//!
//! x = k π/2 + r with k the nearest integer. π/2 is split into parts such that for |x| up to 10^6 every difference with cancellation is
//! exact. The error of r is therefore half a unit in the last place, also near multiples of π/2. The polynomials on |r| <= π/4 are those of
//! fdlibm's `k_sin.c` and `k_cos.c`.

use std::hint::black_box;

use pulp::Simd;

use super::{Lanes, Pack8, load, partial_load, read, vectors_mut};

/// Largest |x| of the vector code; larger angles are evaluated one by one by std.
const LIMIT: f64 = 1e6;

/// π/2 in three parts of 53 bits, for products rounded together with the difference (fused multiply-add).
const HALF_PI: [f64; 3] = [
    std::f64::consts::FRAC_PI_2,
    f64::from_bits(0x3C91_A626_3314_5C06),
    f64::from_bits(0x394C_1CD1_2902_4E08),
];

/// π/2 for products rounded separately: bits down to 2^-32, down to 2^-53, the next 33 bits, and the remainder.
const HALF_PI_IN_SHORT_PARTS: [f64; 4] = [
    f64::from_bits(0x3FF9_21FB_5440_0000),
    f64::from_bits(0x3DD0_B460_0000_0000),
    f64::from_bits(0x3C91_A626_3310_0000),
    f64::from_bits(0x3A71_701B_839A_2520),
];

/// Coefficients of (sin r - r)/r³ in powers of r².
const SINE: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];

/// Coefficients of (cos r - 1 + r²/2)/r⁴ in powers of r².
const COSINE: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// Constants of [`of_moderate`], each a whole pack.
struct Constants {
    two_over_pi: Pack8,
    half_pi: [Pack8; HALF_PI.len()],
    sine: [Pack8; SINE.len()],
    cosine: [Pack8; COSINE.len()],
}

static CONSTANTS: Constants = Constants {
    two_over_pi: Pack8::all(std::f64::consts::FRAC_2_PI),
    half_pi: packs_of(HALF_PI),
    sine: packs_of(SINE),
    cosine: packs_of(COSINE),
};

/// Return a pack of each number.
const fn packs_of<const N: usize>(numbers: [f64; N]) -> [Pack8; N] {
    let mut packs = [Pack8::all(0.0); N];
    let mut i = 0;
    while i < N {
        packs[i] = Pack8::all(numbers[i]);
        i += 1;
    }
    packs
}

/// Return the constants.
///
/// Arithmetic reads them from memory. Without `black_box` each number would be copied to all lanes in every turn of a loop.
#[inline(always)]
fn constants() -> &'static Constants {
    black_box(&CONSTANTS)
}

/// Return (sin x, cos x) of angles \[rad\] of any size, to 1.5 units in the last place; NaN where x is not finite.
///
/// The sine of -0 is 0.
#[inline(always)]
pub(crate) fn sin_cos<S: Simd>(x: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    let (mut sine, mut cosine) = of_moderate(x, constants());
    if x.abs().exceeds(x.constant(LIMIT)).any() {
        let (mut sines, mut cosines) = ([sine.values()], [cosine.values()]);
        replace_the_others(
            bytemuck::cast_slice(&[x.values()]),
            bytemuck::cast_slice_mut(&mut sines),
            bytemuck::cast_slice_mut(&mut cosines),
        );
        sine = Lanes::new(x.simd(), sines[0]);
        cosine = Lanes::new(x.simd(), cosines[0]);
    }
    (sine, cosine)
}

/// Write cosines and sines of `angles`, whose last vector may be partly filled; the other arrays have a whole vector there.
#[inline(always)]
pub(crate) fn write_sin_cos<S: Simd>(simd: S, angles: &[f64], cos: &mut [f64], sin: &mut [f64]) {
    let (whole, rest) = S::as_simd_f64s(angles);
    let blocks = whole.len() + usize::from(!rest.is_empty());
    let mut largest = Lanes::splat(simd, 0.0);
    let constants = constants();
    {
        let (cos, sin) = (vectors_mut::<S>(cos, blocks), vectors_mut::<S>(sin, blocks));
        // No closure for both kinds of vectors: it would lose the instruction set.
        for i in 0..blocks {
            let x = match whole.get(i) {
                Some(x) => load(simd, x),
                None => partial_load(simd, rest),
            };
            let (s, c) = of_moderate(x, constants);
            (cos[i], sin[i]) = (c.values(), s.values());
            // The maximum drops NaN or keeps it: its sine and cosine are NaN already.
            largest = x.abs().max(largest);
        }
    }
    if largest.exceeds(largest.constant(LIMIT)).any() {
        replace_the_others(angles, sin, cos);
    }
}

/// Return (sin x, cos x) for |x| up to [`LIMIT`].
#[inline(always)]
fn of_moderate<S: Simd>(x: Lanes<S>, constants: &Constants) -> (Lanes<S>, Lanes<S>) {
    let simd = x.simd();
    // The addition of 1.5 2^52 rounds to an integer, whose last bits are those of the sum.
    let magic = x.constant(1.5 * (1u64 << 52) as f64);
    let shifted = x.mul_add(constants.two_over_pi.at(simd, 0), magic);
    let k = shifted - magic;
    let less = |r: Lanes<S>, part| k.negate_mul_add(part, r);
    let r = if S::IS_SCALAR {
        let parts = HALF_PI_IN_SHORT_PARTS.map(|part| x.constant(part));
        parts.into_iter().fold(x, less)
    } else {
        read(simd, &constants.half_pi, 0).into_iter().fold(x, less)
    };
    let z = r * r;
    let sine = (r * z).mul_add(polynomial(z, read(simd, &constants.sine, 0)), r);
    let cosine = polynomial(z, read(simd, &constants.cosine, 0))
        .mul_add(z, x.constant(-0.5))
        .mul_add(z, x.constant(1.0));

    // Odd multiples of π/2 exchange sine and cosine; bit 1 of k, and of k + 1, gives the signs.
    let quadrant = simd.transmute_u64s_f64s(shifted.values());
    let one = simd.splat_u64s(1);
    let odd = simd.equal_u64s(simd.and_u64s(quadrant, one), one);
    let next = simd.add_u64s(quadrant, one);
    let swapped = simd.select_f64s(odd, cosine.values(), sine.values());
    let other = simd.select_f64s(odd, sine.values(), cosine.values());
    (
        with_sign(Lanes::new(simd, swapped), quadrant),
        with_sign(Lanes::new(simd, other), next),
    )
}

/// Change the sign where bit 1 of `quadrant` is set.
#[inline(always)]
fn with_sign<S: Simd>(value: Lanes<S>, quadrant: S::u64s) -> Lanes<S> {
    let simd = value.simd();
    let second_bit_on_top = simd.mul_u64s(quadrant, simd.splat_u64s(1 << 62));
    let sign = simd.and_u64s(second_bit_on_top, simd.splat_u64s(1 << 63));
    let bits = simd.xor_u64s(simd.transmute_u64s_f64s(value.values()), sign);
    Lanes::new(simd, simd.transmute_f64s_u64s(bits))
}

/// Return the polynomial with these coefficients in powers of z, by Horner's scheme.
#[inline(always)]
fn polynomial<S: Simd>(z: Lanes<S>, [a, b, c, d, e, f]: [Lanes<S>; 6]) -> Lanes<S> {
    f.mul_add(z, e)
        .mul_add(z, d)
        .mul_add(z, c)
        .mul_add(z, b)
        .mul_add(z, a)
}

/// Replace the results by those of std where |x| exceeds [`LIMIT`] or x is NaN.
#[cold]
fn replace_the_others(xs: &[f64], sines: &mut [f64], cosines: &mut [f64]) {
    for ((&x, sine), cosine) in xs.iter().zip(sines).zip(cosines) {
        let within = x.abs() <= LIMIT;
        if !within {
            (*sine, *cosine) = x.sin_cos();
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::math::simd::testing::{LaneFunction, assert_near, map, ulps};
    use crate::math::simd::{InstructionSet, padded_zeros};
    use pulp::WithSimd;

    struct Sine;
    struct Cosine;

    impl LaneFunction for Sine {
        #[inline(always)]
        fn of<S: Simd>(&self, x: Lanes<S>) -> Lanes<S> {
            sin_cos(x).0
        }
    }

    impl LaneFunction for Cosine {
        #[inline(always)]
        fn of<S: Simd>(&self, x: Lanes<S>) -> Lanes<S> {
            sin_cos(x).1
        }
    }

    /// The kernel of arrays.
    struct Write<'a>(&'a [f64], [&'a mut [f64]; 2]);

    impl WithSimd for Write<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let [cos, sin] = self.1;
            write_sin_cos(simd, self.0, cos, sin);
        }
    }

    /// The error of std itself is below 1 unit. Arrays have the numbers of vectors.
    fn assert_as_std(xs: &[f64]) {
        assert_near(&Sine, xs, 2, f64::sin);
        assert_near(&Cosine, xs, 2, f64::cos);
        for set in InstructionSet::available() {
            let (mut cos, mut sin) = (padded_zeros(xs.len()), padded_zeros(xs.len()));
            set.run(Write(xs, [&mut cos, &mut sin]));
            let (cosines, sines) = (map(set, &Cosine, xs), map(set, &Sine, xs));
            for (i, x) in xs.iter().enumerate() {
                assert_eq!(ulps(cos[i], cosines[i]), 0, "cos {x}");
                assert_eq!(ulps(sin[i], sines[i]), 0, "sin {x}");
            }
        }
    }

    #[test]
    fn multiples_of_an_eighth_of_a_turn_and_their_neighbours() {
        let near = |k: i32| {
            let x = f64::from(k) * std::f64::consts::FRAC_PI_4;
            [x.next_down(), x, x.next_up()]
        };
        assert_as_std(&(-2000..2000).flat_map(near).collect::<Vec<_>>());
        assert_as_std(
            &(0..1_273_000)
                .step_by(997)
                .flat_map(near)
                .collect::<Vec<_>>(),
        );
    }

    #[test]
    fn ends_of_the_range_and_what_is_not_finite() {
        let xs = [
            0.0,
            5e-324,
            1e-310,
            LIMIT,
            LIMIT.next_up(),
            1e22,
            f64::MAX,
            f64::INFINITY,
            f64::NAN,
        ];
        assert_as_std(&xs);
        assert_as_std(&xs.map(|x| -x));
    }

    proptest! {
        #[test]
        fn any_angle(
            turns in proptest::collection::vec(-10.0..10.0f64, 64),
            far in proptest::collection::vec(-LIMIT..LIMIT, 64),
            any in proptest::collection::vec(proptest::num::f64::ANY, 16),
        ) {
            assert_as_std(&turns);
            assert_as_std(&far);
            assert_as_std(&any);
        }
    }
}

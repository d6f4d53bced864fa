//! Shared code of the tests of vector functions: a function over a slice, and distances in units in the last place.

use pulp::{Simd, WithSimd};

use super::{InstructionSet, Lanes, padded_zeros, vectors, vectors_mut};

/// Function of one vector.
pub(crate) trait LaneFunction {
    fn of<S: Simd>(&self, x: Lanes<S>) -> Lanes<S>;
}

struct Map<'a, F> {
    function: &'a F,
    from: &'a [f64],
    to: &'a mut [f64],
}

impl<F: LaneFunction> WithSimd for Map<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let blocks = self.from.len() / S::F64_LANES;
        let from = vectors::<S>(self.from, blocks);
        for (x, y) in from.iter().zip(vectors_mut::<S>(self.to, blocks)) {
            *y = self.function.of(Lanes::new(simd, *x)).values();
        }
    }
}

/// Apply the function to every number of a slice, with these instructions.
pub(crate) fn map(set: InstructionSet, function: &impl LaneFunction, xs: &[f64]) -> Vec<f64> {
    let mut from = padded_zeros(xs.len());
    from[..xs.len()].copy_from_slice(xs);
    let mut to = from.clone();
    set.run(Map {
        function,
        from: &from,
        to: &mut to,
    });
    to[..xs.len()].to_vec()
}

/// Assert that every instruction set agrees with `reference` to `bound` units in the last place, and that all those with fused multiply-add
/// give the same bits.
pub(crate) fn assert_near(
    function: &impl LaneFunction,
    xs: &[f64],
    bound: u64,
    reference: impl Fn(f64) -> f64,
) {
    for set in InstructionSet::available() {
        for (&x, y) in xs.iter().zip(map(set, function, xs)) {
            let expected = reference(x);
            let distance = ulps(y, expected);
            assert!(
                distance <= bound,
                "{} at {x:e}: {y:e}, not {expected:e}: {distance} ulps",
                set.name()
            );
        }
    }
    assert_same_bits(|set| map(set, function, xs));
}

/// Assert that all instruction sets with fused multiply-add give the same bits.
pub(crate) fn assert_same_bits(run: impl Fn(InstructionSet) -> Vec<f64>) {
    let fused = InstructionSet::available()
        .into_iter()
        .filter(|set| set.has_fused_multiply_add());
    let results: Vec<Vec<u64>> = fused
        .map(|set| run(set).into_iter().map(f64::to_bits).collect())
        .collect();
    assert!(results.windows(2).all(|pair| pair[0] == pair[1]));
}

/// Return the number of representable steps between two numbers; zero between two NaN.
pub(crate) fn ulps(a: f64, b: f64) -> u64 {
    if a.is_nan() || b.is_nan() {
        return if a.is_nan() && b.is_nan() {
            0
        } else {
            u64::MAX
        };
    }
    let place = |x: f64| {
        let (middle, magnitude) = (1u64 << 63, x.abs().to_bits());
        if x < 0.0 {
            middle - magnitude
        } else {
            middle + magnitude
        }
    };
    place(a).abs_diff(place(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_count_across_zero() {
        assert_eq!(ulps(1.0, 1.0 + f64::EPSILON), 1);
        assert_eq!(ulps(-5e-324, 5e-324), 2);
        assert_eq!(ulps(0.0, -0.0), 0);
        assert_eq!(ulps(f64::NAN, 1.0), u64::MAX);
    }
}

//! Rotation of eight numbers, which are in one vector or in several.

#[cfg(target_arch = "x86_64")]
use std::any::Any;

use super::{Lanes, Vectors, WIDTH, load, parts, vectors, vectors_mut};

/// Return the eight numbers of the first vectors rotated to the left: entry k holds the value of entry k + `distance`, cyclically. Further
/// vectors have no meaning.
#[inline(always)]
pub(crate) fn rotated<S: Vectors>(
    simd: S,
    numbers: [Lanes<S>; WIDTH],
    distance: usize,
) -> [Lanes<S>; WIDTH] {
    let mut rotated = numbers;
    if S::LANES == WIDTH {
        rotated[0] = numbers[0].turned_by(distance);
        return rotated;
    }
    #[cfg(target_arch = "x86_64")]
    {
        let any: &dyn Any = &simd;
        if let Some(&instructions) = any.downcast_ref::<pulp::x86::V3>() {
            (rotated[0], rotated[1]) = two_vectors(instructions, numbers[0], numbers[1], distance);
            return rotated;
        }
    }
    // Two copies in sequence make every vector of the rotated numbers contiguous in memory.
    let count = WIDTH / S::LANES;
    let mut twice = [S::Number::default(); 2 * WIDTH];
    let copies = vectors_mut::<S>(&mut twice, 2 * count);
    for part in parts::<S>() {
        copies[part] = numbers[part].values();
        copies[part + count] = numbers[part].values();
    }
    for part in parts::<S>() {
        let from = &twice[distance + part * S::LANES..];
        rotated[part] = load(simd, &vectors::<S>(from, 1)[0]);
    }
    rotated
}

/// Rotate two vectors of four lanes without memory: a load of numbers from two stores has to wait for both.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn two_vectors<S: Vectors>(
    instructions: pulp::x86::V3,
    low: Lanes<S>,
    high: Lanes<S>,
    distance: usize,
) -> (Lanes<S>, Lanes<S>) {
    use std::arch::x86_64::__m256d;
    /// Selects the last half of one vector, then the first half of another.
    const LAST_AND_FIRST: i32 = 0b0010_0001;
    /// Selects in each half the second number of one vector, then the first number of another.
    const SECOND_AND_FIRST: i32 = 0b0101;

    let avx = instructions.avx;
    let of = |lanes: Lanes<S>| bytemuck::cast::<S::Vector, __m256d>(lanes.values());
    let back = |values| Lanes::new(low.simd(), bytemuck::cast::<__m256d, S::Vector>(values));
    let (low, high) = if distance % WIDTH < WIDTH / 2 {
        (of(low), of(high))
    } else {
        (of(high), of(low))
    };
    // Numbers 2 to 5, and 6, 7, 0 and 1.
    let inner = avx._mm256_permute2f128_pd::<LAST_AND_FIRST>(low, high);
    let outer = avx._mm256_permute2f128_pd::<LAST_AND_FIRST>(high, low);
    let (low, high) = match distance % (WIDTH / 2) {
        0 => (low, high),
        1 => (
            avx._mm256_shuffle_pd::<SECOND_AND_FIRST>(low, inner),
            avx._mm256_shuffle_pd::<SECOND_AND_FIRST>(high, outer),
        ),
        2 => (inner, outer),
        _ => (
            avx._mm256_shuffle_pd::<SECOND_AND_FIRST>(inner, high),
            avx._mm256_shuffle_pd::<SECOND_AND_FIRST>(outer, low),
        ),
    };
    (back(low), back(high))
}

#[cfg(test)]
mod tests {
    use pulp::{Simd, WithSimd};

    use super::*;
    use crate::math::simd::{InstructionSet, Number};

    struct Rotate<'a, T>(&'a mut [T; WIDTH], usize);

    impl<T: Number> Rotate<'_, T> {
        #[inline(always)]
        fn run<S: Vectors<Number = T>>(self, simd: S) {
            let mut numbers = [Lanes::splat(simd, 0.0); WIDTH];
            for part in parts::<S>() {
                numbers[part] = load(simd, &vectors::<S>(self.0, WIDTH / S::LANES)[part]);
            }
            let rotated = rotated(simd, numbers, self.1);
            let to = vectors_mut::<S>(self.0, WIDTH / S::LANES);
            for part in parts::<S>() {
                to[part] = rotated[part].values();
            }
        }
    }

    impl<T: Number> WithSimd for Rotate<'_, T> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            self.run(T::vectors(simd));
        }
    }

    fn assert_entries_move<T: Number + PartialEq>() {
        for set in InstructionSet::available() {
            for distance in 0..WIDTH {
                let mut numbers: [T; WIDTH] = std::array::from_fn(|k| T::nearest(k as f64));
                T::run(set, Rotate(&mut numbers, distance));
                for (k, &number) in numbers.iter().enumerate() {
                    let expected = T::nearest(((k + distance) % WIDTH) as f64);
                    assert_eq!(number, expected, "{} by {distance}", set.name());
                }
            }
        }
    }

    #[test]
    fn entries_move_to_the_left_by_every_distance_at_every_width_in_both_precisions() {
        assert_entries_move::<f64>();
        assert_entries_move::<f32>();
    }
}

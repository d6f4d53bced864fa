//! Packs of eight numbers, as wide as the widest vectors, for arrays of structures with several quantities.
//!
//! Arrays are read as packs, too: a pack has a constant length, so that its vectors are read without a check of bounds.

use super::{Lanes, Number, Vectors, WIDTH, load, vectors, vectors_mut};

/// Eight numbers of an array, from any entry on.
pub(crate) type Pack<T = f64> = [T; WIDTH];

/// Return the first `count` packs of an array.
#[inline(always)]
pub(crate) fn packs<T>(array: &[T], count: usize) -> &[Pack<T>] {
    packs_from(array, 0, count)
}

/// Return `count` packs of an array from entry `first` on.
#[inline(always)]
pub(crate) fn packs_from<T>(array: &[T], first: usize, count: usize) -> &[Pack<T>] {
    &array[first..first + count * WIDTH].as_chunks().0[..count]
}

/// Return the first `count` packs of an array, mutable.
#[inline(always)]
pub(crate) fn packs_mut<T>(array: &mut [T], count: usize) -> &mut [Pack<T>] {
    packs_from_mut(array, 0, count)
}

/// Return `count` packs of an array from entry `first` on, mutable.
#[inline(always)]
pub(crate) fn packs_from_mut<T>(array: &mut [T], first: usize, count: usize) -> &mut [Pack<T>] {
    &mut array[first..first + count * WIDTH].as_chunks_mut().0[..count]
}

/// Load vector `part` of a pack.
#[inline(always)]
pub(crate) fn part_of<S: Vectors>(simd: S, pack: &Pack<S::Number>, part: usize) -> Lanes<S> {
    load(simd, &vectors::<S>(pack, WIDTH / S::LANES)[part])
}

/// Store vector `part` of a pack.
#[inline(always)]
pub(crate) fn put_part<S: Vectors>(pack: &mut Pack<S::Number>, part: usize, values: Lanes<S>) {
    vectors_mut::<S>(pack, WIDTH / S::LANES)[part] = values.values();
}

/// Add the numbers behind the first `length` of an array, in `count` packs, to those first ones.
#[inline(always)]
pub(crate) fn fold_packs<S: Vectors>(
    simd: S,
    array: &mut [S::Number],
    length: usize,
    count: usize,
) {
    let (own, behind) = array.split_at_mut(length);
    let (places, last) = own.as_chunks_mut();
    let behind = packs(behind, count);
    for (place, behind) in places.iter_mut().zip(behind) {
        for part in parts::<S>() {
            let sum = part_of(simd, place, part) + part_of(simd, behind, part);
            put_part(place, part, sum);
        }
    }
    if let Some(behind) = behind.get(places.len()) {
        for (place, behind) in last.iter_mut().zip(behind) {
            *place = Number::nearest(place.double() + behind.double());
        }
    }
}

/// Eight numbers aligned to a cache line.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(align(64))]
pub(crate) struct Pack8<T = f64>(pub(crate) Pack<T>);

impl<T> Pack8<T> {
    /// Load vector `part`.
    #[inline(always)]
    pub(crate) fn at<S: Vectors<Number = T>>(&self, simd: S, part: usize) -> Lanes<S> {
        part_of(simd, &self.0, part)
    }

    /// Store vector `part`.
    #[inline(always)]
    pub(crate) fn put<S: Vectors<Number = T>>(&mut self, part: usize, values: Lanes<S>) {
        put_part(&mut self.0, part, values);
    }
}

impl Pack8 {
    /// Return the same number eight times. (Arithmetic reads such a constant from memory; a single number is first copied to all lanes.)
    pub(crate) const fn all(value: f64) -> Self {
        Self([value; WIDTH])
    }

    /// Load vector `part`, rounded to the precision of `S`.
    #[inline(always)]
    pub(crate) fn rounded<S: Vectors>(&self, simd: S, part: usize) -> Lanes<S> {
        rounded_part(simd, &self.0, part)
    }
}

/// Load vector `part` of a pack of doubles, rounded to the precision of `S`.
#[inline(always)]
pub(crate) fn rounded_part<S: Vectors>(simd: S, pack: &Pack, part: usize) -> Lanes<S> {
    Lanes::new(simd, simd.load_doubles(pack, part))
}

/// Store vector `part` of a pack of doubles.
#[inline(always)]
pub(crate) fn put_double_part<S: Vectors>(pack: &mut Pack, part: usize, values: Lanes<S>) {
    values.simd().store_doubles(pack, part, values.values());
}

/// Return the indices of the vectors of a pack.
#[inline(always)]
pub(crate) fn parts<S: Vectors>() -> std::ops::Range<usize> {
    0..WIDTH / S::LANES
}

/// Load vector `part` of each pack.
#[inline(always)]
pub(crate) fn read<S: Vectors, const N: usize>(
    simd: S,
    packs8: &[Pack8<S::Number>; N],
    part: usize,
) -> [Lanes<S>; N] {
    let mut values = [Lanes::splat(simd, 0.0); N];
    for (value, pack8) in values.iter_mut().zip(packs8) {
        *value = pack8.at(simd, part);
    }
    values
}

/// Load vector `part` of each pack of doubles, rounded to the precision of `S`.
#[inline(always)]
pub(crate) fn read_rounded<S: Vectors, const N: usize>(
    simd: S,
    packs8: &[Pack8; N],
    part: usize,
) -> [Lanes<S>; N] {
    let mut values = [Lanes::splat(simd, 0.0); N];
    for (value, pack8) in values.iter_mut().zip(packs8) {
        *value = pack8.rounded(simd, part);
    }
    values
}

/// Store vector `part` of each pack.
#[inline(always)]
pub(crate) fn write<S: Vectors, const N: usize>(
    packs8: &mut [Pack8<S::Number>; N],
    part: usize,
    values: [Lanes<S>; N],
) {
    for (pack8, values) in packs8.iter_mut().zip(values) {
        pack8.put(part, values);
    }
}

#[cfg(test)]
mod tests {
    use pulp::{Simd, WithSimd};

    use super::*;
    use crate::math::simd::InstructionSet;

    struct Fold<'a>(&'a mut [f64], usize, usize);

    impl WithSimd for Fold<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            fold_packs(simd, self.0, self.1, self.2);
        }
    }

    #[test]
    fn what_stands_behind_an_array_is_added_to_its_first_numbers() {
        // More packs behind than before: the last numbers before have no whole pack.
        for (length, count) in [(3, 1), (8, 1), (11, 2), (16, 2), (36, 1), (20, 0)] {
            let folded = length.min(count * WIDTH);
            for set in InstructionSet::available() {
                let from: Vec<f64> = (0..length + count * WIDTH).map(|i| i as f64).collect();
                let mut array = from.clone();
                set.run(Fold(&mut array, length, count));
                for i in 0..from.len() {
                    let added = if i < folded { from[length + i] } else { 0.0 };
                    assert_eq!(array[i], from[i] + added, "{length} {count} {i}");
                }
            }
        }
    }
}

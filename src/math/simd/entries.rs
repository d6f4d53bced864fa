//! SIMD vectors of arrays of doubles that may be unaligned and end within a vector, in the precision of the vectors.

use pulp::Simd;

use super::{Lanes, Pack, Vectors, WIDTH, put_double_part};

/// SIMD vectors of an array to read; lanes behind its end are zero, and so are tiny numbers in single precision.
pub(crate) struct Entries<'a, S: Vectors> {
    simd: S,
    whole: &'a [Pack],
    last: Pack,
}

impl<'a, S: Vectors> Entries<'a, S> {
    /// Return the vectors of `array`.
    #[inline(always)]
    pub(crate) fn of(simd: S, array: &'a [f64]) -> Self {
        let (whole, rest) = array.as_chunks();
        let mut last = [0.0; WIDTH];
        copy_some(simd.instructions(), rest, &mut last[..rest.len()]);
        Self { simd, whole, last }
    }

    /// Return vector `part` of pack `number`, without tiny numbers.
    ///
    /// The residual of a body in free flight is what rounding left of it in the last step. In single precision that is some 1e-7 of the
    /// residual before, so that it passes through all magnitudes.
    #[inline(always)]
    pub(crate) fn at(&self, number: usize, part: usize) -> Lanes<S> {
        let pack = match self.whole.get(number) {
            Some(pack) => pack,
            None if number == self.whole.len() => &self.last,
            None => return Lanes::splat(self.simd, 0.0),
        };
        let values = self.simd.load_doubles(pack, part);
        Lanes::new(self.simd, self.simd.without_tiny(values))
    }
}

/// SIMD vectors of an array to write; lanes behind its end are dropped.
pub(crate) struct EntriesMut<'a, S: Vectors> {
    simd: S,
    whole: &'a mut [Pack],
    rest: &'a mut [f64],
}

impl<'a, S: Vectors> EntriesMut<'a, S> {
    /// Return the vectors of `array` for writing.
    #[inline(always)]
    pub(crate) fn of(simd: S, array: &'a mut [f64]) -> Self {
        let (whole, rest) = array.as_chunks_mut();
        Self { simd, whole, rest }
    }

    /// Write vector `part` of pack `number`.
    #[inline(always)]
    pub(crate) fn set(&mut self, number: usize, part: usize, values: Lanes<S>) {
        let behind = self.whole.len();
        let first = part * S::LANES;
        if let Some(pack) = self.whole.get_mut(number) {
            put_double_part(pack, part, values);
        } else if number == behind && first < self.rest.len() {
            let mut pack = [0.0; WIDTH];
            put_double_part(&mut pack, part, values);
            let length = self.rest.len().min(first + S::LANES) - first;
            let to = &mut self.rest[first..][..length];
            copy_some(self.simd.instructions(), &pack[first..][..length], to);
        }
    }
}

/// Copy an array of the same length by vectors: the load of a vector would wait for stores of single numbers in it.
#[inline(always)]
fn copy_some<S: Simd>(simd: S, from: &[f64], to: &mut [f64]) {
    let ((from, from_rest), (to, to_rest)) = (S::as_simd_f64s(from), S::as_mut_simd_f64s(to));
    for (from, to) in from.iter().zip(to) {
        *to = *from;
    }
    if !from_rest.is_empty() {
        simd.partial_store_f64s(to_rest, simd.partial_load_f64s(from_rest));
    }
}

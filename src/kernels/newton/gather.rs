//! What belongs to bushings found from their links, what bushings leave brought to the links again, and products of columns.

use pulp::{Simd, WithSimd};

use super::links::{LinkInertia, at, put, touched};
use super::teeth::{Levers, ToothTerms};
use crate::vector::{Lanes, Numbers, PartialSums};

/// Levers of all bushings.
pub(super) struct FindLevers<'a> {
    pub(super) links: usize,
    pub(super) overhang: usize,
    /// One where bushing k is on the front of link k, else zero.
    pub(super) on_front: &'a [f64],
    /// Half the pitch of every link \[m\].
    pub(super) arm: &'a [f64],
    /// Cosines and sines of the links, the first once more behind the last.
    pub(super) direction: [&'a [f64]; 2],
    pub(super) levers: &'a mut Levers,
}

impl WithSimd for FindLevers<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let blocks = self.links.div_ceil(S::F64_LANES);
        let zero = Lanes::splat(simd, 0.0);
        for i in 0..blocks {
            let on_front = at(simd, self.on_front, i).greater(zero);
            let arm = at(simd, self.arm, i);
            let arm = on_front.select(arm, -arm);
            for (lever, array) in self.levers.iter_mut().zip(self.direction) {
                let own = on_front.select(at(simd, array, i), at(simd, &array[1..], i));
                put(lever, i, arm * own);
            }
        }
        for array in self.levers {
            array.copy_within(..self.overhang, self.links);
        }
    }
}

/// What bushings leave for one coordinate on the border, link by link.
pub(super) struct GatherColumn<'a> {
    pub(super) links: usize,
    pub(super) inertia: &'a LinkInertia,
    pub(super) teeth: &'a ToothTerms,
    /// Number of the coordinate.
    pub(super) coordinate: usize,
    pub(super) column: &'a mut [Numbers; 3],
}

impl WithSimd for GatherColumn<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.links;
        let from = &self.teeth.column[self.coordinate];
        for i in 0..n.div_ceil(S::F64_LANES) {
            let touches = touched::<S>(self.teeth, n, i);
            for (from, to) in from.iter().zip(&mut *self.column) {
                let entry = if touches {
                    self.inertia.of_link(simd, from, n, i)
                } else {
                    Lanes::splat(simd, 0.0)
                };
                put(to, i, entry);
            }
        }
    }
}

/// Sum of the products of two groups of link entries.
pub(super) struct Along<'a> {
    pub(super) links: usize,
    pub(super) row: &'a [Numbers; 3],
    pub(super) column: &'a [Numbers; 3],
}

impl WithSimd for Along<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let blocks = self.links.div_ceil(S::F64_LANES);
        let mut sum = PartialSums::default();
        for i in 0..blocks {
            let mut products = Lanes::splat(simd, 0.0);
            for (row, column) in self.row.iter().zip(self.column) {
                products = at(simd, row, i).mul_add(at(simd, column, i), products);
            }
            sum.add(i, products);
        }
        sum.total()
    }
}

/// Takes `factor` times one group of link entries off another.
pub(super) struct Take<'a> {
    pub(super) links: usize,
    pub(super) factor: f64,
    pub(super) column: &'a [Numbers; 3],
    pub(super) from: &'a mut [Numbers; 3],
}

impl WithSimd for Take<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let blocks = self.links.div_ceil(S::F64_LANES);
        let factor = Lanes::splat(simd, self.factor);
        for (column, from) in self.column.iter().zip(self.from) {
            for i in 0..blocks {
                let rest = factor.negate_mul_add(at(simd, column, i), at(simd, from, i));
                put(from, i, rest);
            }
        }
    }
}

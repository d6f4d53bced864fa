//! What belongs to bushings found from their links, and what bushings leave brought to the links again.

use pulp::{Simd, WithSimd};

use super::links::{LinkInertia, load_before};
use super::teeth::BushingLevers;
use crate::vector::{Lanes, Numbers, load, vectors, vectors_mut};

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
    /// Angular speeds, likewise \[rad/s\].
    pub(super) spin: &'a [f64],
    pub(super) levers: &'a mut BushingLevers,
}

impl WithSimd for FindLevers<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let blocks = self.links.div_ceil(S::F64_LANES);
        let zero = Lanes::splat(simd, 0.0);
        let here = |array: &[f64], i: usize| load(simd, &vectors::<S>(array, blocks)[i]);
        let [x, y] = &mut self.levers.along;
        for i in 0..blocks {
            let on_front = here(self.on_front, i).greater(zero);
            let arm = here(self.arm, i);
            let arm = on_front.select(arm, -arm);
            let own = |array: &[f64]| on_front.select(here(array, i), here(&array[1..], i));
            let (cos, sin, spin) = (
                own(self.direction[0]),
                own(self.direction[1]),
                own(self.spin),
            );
            vectors_mut::<S>(x, blocks)[i] = (arm * cos).values();
            vectors_mut::<S>(y, blocks)[i] = (arm * sin).values();
            vectors_mut::<S>(&mut self.levers.spin, blocks)[i] = spin.values();
        }
        for array in [x, y, &mut self.levers.spin] {
            array.copy_within(..self.overhang, self.links);
        }
    }
}

/// What bushings leave for one coordinate on the border, link by link.
pub(super) struct GatherBorder<'a> {
    pub(super) links: usize,
    pub(super) inertia: &'a LinkInertia,
    /// Of bushings.
    pub(super) from: &'a [Numbers; 3],
    /// Of links.
    pub(super) to: &'a mut [Numbers; 3],
}

impl WithSimd for GatherBorder<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let blocks = self.links.div_ceil(S::F64_LANES);
        for (from, to) in self.from.iter().zip(self.to) {
            for i in 0..blocks {
                let here = load(simd, &vectors::<S>(from, blocks)[i]);
                let before = load_before(simd, from, self.links, i);
                vectors_mut::<S>(to, blocks)[i] = self.inertia.of_link(simd, i, here, before).values();
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
        let mut sum = crate::vector::PartialSums::default();
        for i in 0..blocks {
            let mut products = Lanes::splat(simd, 0.0);
            for (row, column) in self.row.iter().zip(self.column) {
                let (row, column) = (
                    load(simd, &vectors::<S>(row, blocks)[i]),
                    load(simd, &vectors::<S>(column, blocks)[i]),
                );
                products = row.mul_add(column, products);
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
            let from = vectors_mut::<S>(from, blocks);
            for (column, from) in vectors::<S>(column, blocks).iter().zip(from) {
                *from = factor
                    .negate_mul_add(load(simd, column), load(simd, from))
                    .values();
            }
        }
    }
}

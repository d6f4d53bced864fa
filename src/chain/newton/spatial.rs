//! Symmetric 3x3 blocks of links and rollers: velocities x, y and θ, in the lanes of a SIMD vector.

use crate::math::simd::{Lanes, Vectors};

/// Symmetric 3x3 matrix: xx, xy, xz, yy, yz, zz.
#[derive(Clone, Copy)]
pub(super) struct Spatial<S: Vectors>(pub(super) [Lanes<S>; 6]);

impl<S: Vectors> Spatial<S> {
    /// Return the inverse: cofactors over the determinant.
    #[inline(always)]
    pub(super) fn inverse(&self) -> Self {
        let [xx, xy, xz, yy, yz, zz] = self.0;
        let a = yy.mul_add(zz, -(yz * yz));
        let b = xz.mul_add(yz, -(xy * zz));
        let c = xy.mul_add(yz, -(xz * yy));
        let over = xx.constant(1.0) / xx.mul_add(a, xy.mul_add(b, xz * c));
        Self([
            a * over,
            b * over,
            c * over,
            xx.mul_add(zz, -(xz * xz)) * over,
            xy.mul_add(xz, -(xx * yz)) * over,
            xx.mul_add(yy, -(xy * xy)) * over,
        ])
    }

    /// Return the product with a vector.
    #[inline(always)]
    pub(super) fn times(&self, [x, y, z]: [Lanes<S>; 3]) -> [Lanes<S>; 3] {
        let [xx, xy, xz, yy, yz, zz] = self.0;
        [
            xx.mul_add(x, xy.mul_add(y, xz * z)),
            xy.mul_add(x, yy.mul_add(y, yz * z)),
            xz.mul_add(x, yz.mul_add(y, zz * z)),
        ]
    }

    /// Return the product with a general matrix, row-major.
    #[inline(always)]
    pub(super) fn times_general(&self, right: &[Lanes<S>; 9]) -> [Lanes<S>; 9] {
        let [a, b, c, d, e, f, g, h, i] = *right;
        let [xx, yx, zx] = self.times([a, d, g]);
        let [xy, yy, zy] = self.times([b, e, h]);
        let [xz, yz, zz] = self.times([c, f, i]);
        [xx, xy, xz, yx, yy, yz, zx, zy, zz]
    }

    /// Return self + other.
    #[inline(always)]
    pub(super) fn plus(&self, other: &Self) -> Self {
        let mut sum = *self;
        for (entry, other) in sum.0.iter_mut().zip(other.0) {
            *entry = *entry + other;
        }
        sum
    }

    /// Return self - left^T right, which is symmetric.
    #[inline(always)]
    pub(super) fn less_product(&self, left: &[Lanes<S>; 9], right: &[Lanes<S>; 9]) -> Self {
        let [a, b, c, d, e, f, g, h, i] = *right;
        let [xx, _, _] = transposed_times(left, [a, d, g]);
        let [xy, yy, _] = transposed_times(left, [b, e, h]);
        let [xz, yz, zz] = transposed_times(left, [c, f, i]);
        let [own_xx, own_xy, own_xz, own_yy, own_yz, own_zz] = self.0;
        Self([
            own_xx - xx,
            own_xy - xy,
            own_xz - xz,
            own_yy - yy,
            own_yz - yz,
            own_zz - zz,
        ])
    }
}

/// Return m^T v.
#[inline(always)]
pub(super) fn transposed_times<S: Vectors>(
    m: &[Lanes<S>; 9],
    [x, y, z]: [Lanes<S>; 3],
) -> [Lanes<S>; 3] {
    let [a, b, c, d, e, f, g, h, i] = *m;
    [
        a.mul_add(x, d.mul_add(y, g * z)),
        b.mul_add(x, e.mul_add(y, h * z)),
        c.mul_add(x, f.mul_add(y, i * z)),
    ]
}

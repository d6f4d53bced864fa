//! Coupling of the two hinges of a link after its elimination: products of the inverse of its block with the levers of its ends.

use super::spatial::Spatial;
use crate::math::simd::{Lanes, Vectors};

/// Coupling of the two hinges of a vector of links.
pub(super) struct HingeCoupling<S: Vectors> {
    /// `F D⁻¹ F^T`: xx, yy, xy.
    pub(super) front: [Lanes<S>; 3],
    /// `R D⁻¹ R^T`
    pub(super) rear: [Lanes<S>; 3],
    /// `-F D⁻¹ R^T` in row-major order.
    pub(super) between: [Lanes<S>; 4],
}

impl<S: Vectors> HingeCoupling<S> {
    /// Return the coupling by links without tooth contact: D = diag(m, m, J), levers (u, v) and (-u, -v).
    #[inline(always)]
    pub(super) fn of_free(light: Lanes<S>, turn: Lanes<S>, [u, v]: [Lanes<S>; 2]) -> Self {
        let (tu, tv) = (turn * u, turn * v);
        let [uu, vv, uv] = [tu * u, tv * v, tu * v];
        let own = [light + uu, light + vv, uv];
        Self {
            front: own,
            rear: own,
            between: [uu - light, uv, uv, vv - light],
        }
    }

    /// Return the coupling by links with tooth contact: D is a full matrix, levers (u, v) and (-u, -v).
    #[inline(always)]
    pub(super) fn of_held(inverse: &Spatial<S>, [u, v]: [Lanes<S>; 2]) -> Self {
        let [xx, xy, xz, yy, yz, zz] = inverse.0;
        let (zu, zv) = (zz * u, zz * v);
        let [uu, vv, uv] = [zu * u, zv * v, zu * v];
        let (same_x, same_y, same_xy) = (xx + uu, yy + vv, xy + uv);
        // The products of rotation and translation have opposite signs at the two ends.
        let (x, y) = (u * xz, v * yz);
        let crossed = u.mul_add(yz, v * xz);
        let between = v.mul_add(xz, -(u * yz));
        Self {
            front: [same_x + (x + x), same_y + (y + y), same_xy + crossed],
            rear: [same_x - (x + x), same_y - (y + y), same_xy - crossed],
            between: [uu - xx, (uv - xy) + between, (uv - xy) - between, vv - yy],
        }
    }

    /// Return the coupling by links whose contacts are at `[front, rear]` from their centres, each with its own lever.
    #[inline(always)]
    pub(super) fn apart(inverse: &Spatial<S>, [front, rear]: [[Lanes<S>; 2]; 2]) -> Self {
        let [xx, xy, xz, yy, yz, zz] = inverse.0;
        let ([a, b], [c, d]) = (front, rear);
        Self {
            front: Self::own(inverse, front),
            rear: Self::own(inverse, rear),
            between: [
                -((zz * a).mul_add(c, xx + (a + c) * xz)),
                -((zz * a).mul_add(d, xy + a.mul_add(yz, d * xz))),
                -((zz * b).mul_add(c, xy + b.mul_add(xz, c * yz))),
                -((zz * b).mul_add(d, yy + (b + d) * yz)),
            ],
        }
    }

    /// Return `F D⁻¹ F^T` of a contact at this lever: xx, yy, xy.
    #[inline(always)]
    fn own(inverse: &Spatial<S>, [u, v]: [Lanes<S>; 2]) -> [Lanes<S>; 3] {
        let [xx, xy, xz, yy, yz, zz] = inverse.0;
        let (x, y) = (u * xz, v * yz);
        [
            (zz * u).mul_add(u, xx + (x + x)),
            (zz * v).mul_add(v, yy + (y + y)),
            (zz * u).mul_add(v, xy + u.mul_add(yz, v * xz)),
        ]
    }

    /// Return the same for links without tooth contact.
    #[inline(always)]
    pub(super) fn apart_and_free(
        light: Lanes<S>,
        turn: Lanes<S>,
        [front, rear]: [[Lanes<S>; 2]; 2],
    ) -> Self {
        let zero = light.constant(0.0);
        let inverse = Spatial([light, zero, zero, light, zero, turn]);
        Self::apart(&inverse, [front, rear])
    }
}

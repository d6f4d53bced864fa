//! Slopes of contact forces scaled for the matrix of one step: what a change of velocities by one does to the force at its end.
//!
//! A velocity changed by w has moved its coordinate by γ w. The force -f n of a contact then changes, in its own frame of n
//! and t, by -(α n·w, η t·w), with α = γ² k + γ d and η = γ² f κ: k, d slopes with penetration and its rate, κ the curvature.
//!
//! Two terms are left out, which keeps the matrix symmetric: a contact that slips by s across turns its rate by d κ s, and an
//! end takes its velocity along when its body turns. Both are damping times an angle that is turned in a step, γ κ s and γ ω,
//! which Newton's method corrects at that rate.

use pulp::{Simd, WithSimd};

use super::links::at;
use crate::kernels::slopes::ContactSlopes;
use crate::vector::{Lanes, Numbers, WIDTH, both, padded_zeros, vectors_mut};

/// α and η of a register of contacts with stiffness, damping and curvature.
#[inline(always)]
pub(super) fn scaled<S: Simd>(
    gamma: f64,
    [stiffness, damping, curvature]: [Lanes<S>; 3],
    force: Lanes<S>,
) -> [Lanes<S>; 2] {
    let (gamma, gamma_squared) = (force.constant(gamma), force.constant(gamma * gamma));
    [
        gamma_squared.mul_add(stiffness, gamma * damping),
        gamma_squared * force * curvature,
    ]
}

/// Entry of hinge 0 in arrays that have the last hinge before it.
pub(super) const BASE: usize = WIDTH;

/// Hinges of one matrix.
#[derive(Debug, Clone)]
pub(super) struct HingeTerms {
    /// n, x and y; hinge k at entry [`BASE`] + k, and the last one once more before the first.
    pub(super) normal: [Numbers; 2],
    /// 1/α and 1/η of hinge k; 1 where it is open.
    pub(super) softness: [Numbers; 2],
}

impl HingeTerms {
    pub(super) fn new(hinges: usize) -> Self {
        let with_last = || padded_zeros(BASE + hinges);
        let zeros = || padded_zeros(hinges);
        Self {
            normal: [with_last(), with_last()],
            softness: [zeros(), zeros()],
        }
    }
}

/// Fills the terms of all hinges.
pub(super) struct ScaleHinges<'a> {
    pub(super) hinges: usize,
    pub(super) gamma: f64,
    pub(super) slopes: &'a ContactSlopes,
    pub(super) force: &'a [f64],
    pub(super) terms: &'a mut HingeTerms,
}

impl WithSimd for ScaleHinges<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            hinges,
            gamma,
            slopes,
            force,
            terms,
        } = self;
        let blocks = hinges.div_ceil(S::F64_LANES);
        let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
        let normal = both::<S>(&slopes.normal, 0, blocks);
        let [x, y] = &mut terms.normal;
        let x = vectors_mut::<S>(&mut x[BASE..], blocks);
        let y = vectors_mut::<S>(&mut y[BASE..], blocks);
        let [along, across] = &mut terms.softness;
        let along = vectors_mut::<S>(along, blocks);
        let across = vectors_mut::<S>(across, blocks);
        for i in 0..blocks {
            let slopes = [
                at(simd, &slopes.stiffness, i),
                at(simd, &slopes.damping, i),
                at(simd, &slopes.curvature, i),
            ];
            let force = at(simd, force, i);
            let [alpha, eta] = scaled(gamma, slopes, force);
            let closed = force.greater(zero);
            (x[i], y[i]) = (normal[0][i], normal[1][i]);
            along[i] = (one / closed.select(alpha, one)).values();
            across[i] = (one / closed.select(eta, one)).values();
        }
        for array in &mut terms.normal {
            array[BASE - 1] = array[BASE + hinges - 1];
        }
    }
}

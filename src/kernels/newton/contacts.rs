//! Slopes of contact forces scaled for the matrix of one step: what a change of velocities by one does to the force at its end.
//!
//! A velocity changed by w has moved its coordinate by γ w. The force -f n of a contact then changes, in its own frame of n
//! and t, by -(α n·w, η t·w), with α = γ² k + γ d and η = γ² f κ: k, d slopes with penetration and its rate, κ the curvature.
//!
//! Two terms are left out, which keeps the matrix symmetric: a contact that slips by s across turns its rate by d κ s, and an
//! end takes its velocity along when its body turns. Both are damping times an angle that is turned in a step, γ κ s and γ ω,
//! which Newton's method corrects at that rate.

use pulp::Simd;

use super::ring::HingeGroup;
use crate::kernels::slopes::SlopeGroup;
use crate::vector::{Lanes, Numbers, WIDTH, padded_zeros, parts, vectors_mut, write};

/// α and η of register `part` of these contacts.
#[inline(always)]
pub(super) fn scaled<S: Simd>(
    gamma: f64,
    simd: S,
    slopes: &SlopeGroup,
    part: usize,
) -> [Lanes<S>; 2] {
    let gamma_squared = Lanes::splat(simd, gamma * gamma);
    let damping = Lanes::splat(simd, gamma) * slopes.damping.at(simd, part);
    let turn = slopes.force.at(simd, part) * slopes.curvature.at(simd, part);
    [
        gamma_squared.mul_add(slopes.stiffness.at(simd, part), damping),
        gamma_squared * turn,
    ]
}

/// Entry of hinge 0 in arrays that have the last hinge before it.
pub(super) const BASE: usize = WIDTH;

/// Least α \[kg\]: a contact that has only just begun is taken for no softer.
const LEAST: f64 = 1e-20;

/// Least η over α. Across its normal a contact is the softer the less deep it is; below this share nothing moves for it.
const LEAST_SHARE: f64 = 1e-10;

/// Which hinges bear something: one, or zero; the last one once more before the first, which is at entry [`BASE`].
#[derive(Debug, Clone)]
pub(super) struct Closed {
    pub(super) hinges: Numbers,
    /// Whether any does.
    pub(super) any: bool,
}

impl Closed {
    pub(super) fn new(hinges: usize) -> Self {
        Self {
            hinges: padded_zeros(BASE + hinges),
            any: false,
        }
    }
}

/// Begins the ring's blocks with the compliance of each hinge, n n^T/α + t t^T/η; one for hinges that bear nothing.
#[inline(always)]
pub(super) fn soften_hinges<S: Simd>(
    simd: S,
    gamma: f64,
    slopes: &[SlopeGroup],
    closed: &mut Closed,
    groups: &mut [HingeGroup],
) {
    let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
    let (least, least_share) = (one.constant(LEAST), one.constant(LEAST_SHARE));
    closed.any = false;
    let bearing = vectors_mut::<S>(
        &mut closed.hinges[BASE..],
        slopes.len() * WIDTH / S::F64_LANES,
    );
    let count = parts::<S>().len();
    for ((slopes, group), bearing) in slopes
        .iter()
        .zip(groups)
        .zip(bearing.chunks_exact_mut(count))
    {
        for part in parts::<S>() {
            let bears = slopes.force.at(simd, part).greater(zero);
            bearing[part] = bears.select(one, zero).values();
            if !bears.any() {
                write(&mut group.own, part, [one, one, zero]);
                continue;
            }
            closed.any = true;
            let [alpha, eta] = scaled(gamma, simd, slopes, part);
            let alpha = bears.select(alpha.max(least), one);
            let eta = bears.select(eta.max(alpha * least_share), one);
            let over = one / (alpha * eta);
            let (along, across) = (eta * over, alpha * over);
            let (nx, ny) = (
                slopes.normal[0].at(simd, part),
                slopes.normal[1].at(simd, part),
            );
            let own = [
                bears.select(along.mul_add(nx * nx, across * (ny * ny)), one),
                bears.select(along.mul_add(ny * ny, across * (nx * nx)), one),
                (along - across) * (nx * ny),
            ];
            write(&mut group.own, part, own);
        }
    }
}

impl Closed {
    /// Puts the last hinge before the first as well.
    #[inline(always)]
    pub(super) fn close(&mut self, hinges: usize) {
        self.hinges[BASE - 1] = self.hinges[BASE + hinges - 1];
    }
}

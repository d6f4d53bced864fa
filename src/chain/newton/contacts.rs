//! Slopes of contact forces scaled for the matrix of one step: what a change of velocities by one does to the force at its end.
//!
//! A velocity changed by w has moved its coordinate by γ w. The force -f n of a contact then changes, in its own frame of n
//! and t, by -(α n·w, η t·w), with α = γ² k + γ d and η = γ² f κ: k, d slopes with penetration and its rate, κ the curvature.
//!
//! Two terms are left out, which keeps the matrix symmetric: a contact that slips by s across turns its rate by d κ s, and an
//! end takes its velocity along when its body turns. Both are damping times an angle that is turned in a step, γ κ s and γ ω,
//! which Newton's method corrects at that rate.
//!
//! Friction adds τ = γ times its slope with the slip, along t at the point of contact: w then is the velocity of the points
//! there, whose arms from the ends' centres lie along n and do not change n·w. The turn of n, η, does not feel the bodies' own
//! turning; η and τ together act as η + τ does at arms shortened to their share τ/(η + τ). Left out is how friction changes with
//! the normal force, μ α, which is not symmetric.

use pulp::Simd;

use super::ring::{HingeBlocks, own_registers};
use crate::chain::rhs::slopes::{FrictionGroup, SlopeGroup};
use crate::math::simd::{Lanes, Numbers, WIDTH, padded_zeros, parts, read, vectors_mut};

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
pub(super) const LEAST: f64 = 1e-20;

/// Least η over α. Across its normal a contact is the softer the less deep it is; below this share nothing moves for it.
pub(super) const LEAST_SHARE: f64 = 1e-10;

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

/// Where hinges with friction have their contacts, seen from the ends' centres, along t and in their share \[m\]: hinge k at
/// [`BASE`] + k, the last one once more before the first.
#[derive(Debug, Clone)]
pub(super) struct Arms {
    /// From fronts, x and y.
    pub(super) front: [Numbers; 2],
    /// From rears.
    pub(super) rear: [Numbers; 2],
}

impl Arms {
    pub(super) fn new(hinges: usize) -> Self {
        let zeros = || padded_zeros(BASE + hinges);
        Self {
            front: [zeros(), zeros()],
            rear: [zeros(), zeros()],
        }
    }

    /// Puts the last hinge before the first as well.
    #[inline(always)]
    pub(super) fn close(&mut self, hinges: usize) {
        for array in self.front.iter_mut().chain(&mut self.rear) {
            array[BASE - 1] = array[BASE + hinges - 1];
        }
    }

    /// Writes those of register `i` of hinges.
    #[inline(always)]
    pub(super) fn put<S: Simd>(
        &mut self,
        i: usize,
        [nx, ny]: [Lanes<S>; 2],
        share: Lanes<S>,
        [front, rear]: [Lanes<S>; 2],
    ) {
        let from = BASE + i * S::F64_LANES;
        let (front, rear) = (share * front, share * rear);
        let [x, y] = &mut self.front;
        vectors_mut::<S>(&mut x[from..], 1)[0] = (-(front * ny)).values();
        vectors_mut::<S>(&mut y[from..], 1)[0] = (front * nx).values();
        let [x, y] = &mut self.rear;
        vectors_mut::<S>(&mut x[from..], 1)[0] = (-(rear * ny)).values();
        vectors_mut::<S>(&mut y[from..], 1)[0] = (rear * nx).values();
    }
}

/// Friction of hinges, where there is any.
pub(super) struct Rubbing<'a> {
    pub(super) slopes: &'a [FrictionGroup],
    pub(super) arms: &'a mut Arms,
}

/// Begins the ring's blocks with the compliance of each hinge, n n^T/α + t t^T/η; one for hinges that bear nothing. `RUBBED`: with
/// friction, η + τ in the place of η.
#[inline(always)]
pub(super) fn soften_hinges<S: Simd, const RUBBED: bool>(
    simd: S,
    gamma: f64,
    slopes: &[SlopeGroup],
    closed: &mut Closed,
    blocks: &mut HingeBlocks,
    mut rubbing: Option<Rubbing>,
) {
    let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
    let (least, least_share) = (one.constant(LEAST), one.constant(LEAST_SHARE));
    closed.any = false;
    let count = parts::<S>().len();
    let bearing = vectors_mut::<S>(&mut closed.hinges[BASE..], slopes.len() * count);
    let mut own = own_registers::<S>(&mut blocks.own, slopes.len() * count);
    for (number, slopes) in slopes.iter().enumerate() {
        for part in parts::<S>() {
            let i = number * count + part;
            let bears = slopes.force.at(simd, part).greater(zero);
            bearing[i] = bears.select(one, zero).values();
            if !bears.any() {
                for (own, entry) in own.iter_mut().zip([one, one, zero]) {
                    own[i] = entry.values();
                }
                if RUBBED && let Some(Rubbing { arms, .. }) = &mut rubbing {
                    arms.put(i, [zero; 2], zero, [zero; 2]);
                }
                continue;
            }
            closed.any = true;
            let [alpha, eta] = scaled(gamma, simd, slopes, part);
            let alpha = bears.select(alpha.max(least), one);
            let mut eta = bears.select(eta.max(alpha * least_share), one);
            let (nx, ny) = (
                slopes.normal[0].at(simd, part),
                slopes.normal[1].at(simd, part),
            );
            if RUBBED && let Some(Rubbing { slopes, arms }) = &mut rubbing {
                let rubs = &slopes[number];
                let tau = Lanes::splat(simd, gamma) * rubs.slope.at(simd, part);
                let both = eta + tau;
                let places = read(simd, &rubs.places, part);
                arms.put(i, [nx, ny], tau / both, places);
                eta = both;
            }
            let over = one / (alpha * eta);
            let (along, across) = (eta * over, alpha * over);
            let entries = [
                bears.select(along.mul_add(nx * nx, across * (ny * ny)), one),
                bears.select(along.mul_add(ny * ny, across * (nx * nx)), one),
                (along - across) * (nx * ny),
            ];
            for (own, entry) in own.iter_mut().zip(entries) {
                own[i] = entry.values();
            }
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

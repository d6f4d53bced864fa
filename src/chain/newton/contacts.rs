//! Slopes of contact forces for the matrix of one step: γ times the change of the force per unit change of the velocities \[kg\].
//!
//! A change w of a velocity changes its coordinate by γ w. The force -f n of a contact then changes by δF, with
//! γ δF = -(α n·w, η t·w) in its own frame of n and t. Here α = γ² k + γ d and η = γ² f κ. k and d are the slopes of f with penetration and penetration rate; κ is
//! the curvature.
//!
//! Two terms are neglected, which keeps the matrix symmetric. A contact that slides across with s changes its rate by d κ s. A body
//! that rotates with ω changes the direction of its ends' velocity. Both terms are damping times an angle turned in a step, γ κ s
//! and γ ω. Newton's method corrects them with that convergence rate.
//!
//! Friction adds τ, γ times its slope with the sliding velocity, along t at the point of contact. There w is the velocity of the
//! contact points. Their arms from the ends' centres are parallel to n and do not change n·w. η, the turn of n, does not depend on
//! the rotation of the bodies. η and τ together act as η + τ at arms multiplied by τ/(η + τ). The change of friction with the
//! normal force, μ α, is neglected: it is not symmetric.

use pulp::Simd;

use super::ring::{BASE, HingeBlocks, hinge_vectors};
use crate::chain::arrays::slopes::{ContactSlopes, SlopeGroup};
use crate::math::simd::{Lanes, Numbers, padded_zeros, parts, read, vectors_mut};

/// Return α and η of vector `part` of these contacts.
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

/// Lower bound of α \[kg\]. It limits the compliance of a contact at its onset.
pub(super) const LEAST: f64 = 1e-20;

/// Lower bound of η/α. The stiffness across the normal decreases with the penetration. Below this share it has no effect on the
/// motion.
pub(super) const LEAST_SHARE: f64 = 1e-10;

/// Flags of the hinges that transmit force: one or zero. A copy of the last one precedes the first, which is at entry [`BASE`].
#[derive(Debug, Clone)]
pub(super) struct LoadedHinges {
    pub(super) hinges: Numbers,
    /// Whether any hinge transmits force.
    pub(super) any: bool,
}

impl LoadedHinges {
    /// Allocate the flags of `hinges`.
    pub(super) fn new(hinges: usize) -> Self {
        Self {
            hinges: padded_zeros(BASE + hinges),
            any: false,
        }
    }
}

/// Arms of the contact points of hinges with friction from the centres of the ends, along t, times τ/(η + τ) \[m\]. Hinge k is at
/// [`BASE`] + k; a copy of the last one precedes the first.
#[derive(Debug, Clone)]
pub(super) struct FrictionArms {
    /// Arms from fronts, x and y.
    pub(super) front: [Numbers; 2],
    /// Arms from rears, x and y.
    pub(super) rear: [Numbers; 2],
}

impl FrictionArms {
    /// Allocate the arms of `hinges`.
    pub(super) fn new(hinges: usize) -> Self {
        let zeros = || padded_zeros(BASE + hinges);
        Self {
            front: [zeros(), zeros()],
            rear: [zeros(), zeros()],
        }
    }

    /// Copy the last hinge to the entry before the first.
    #[inline(always)]
    pub(super) fn repeat_last(&mut self, hinges: usize) {
        for array in self.front.iter_mut().chain(&mut self.rear) {
            array[BASE - 1] = array[BASE + hinges - 1];
        }
    }

    /// Write the arms of vector `i` of hinges: position along n times `share`, in the direction t = (-ny, nx).
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

/// Initialise the ring's blocks with the compliance of each hinge, n n^T/α + t t^T/η. Hinges without force get the identity.
/// `FRICTION`: with friction, η + τ in the place of η; only then `arms` are written.
#[inline(always)]
pub(super) fn assemble_compliance<S: Simd, const FRICTION: bool>(
    simd: S,
    gamma: f64,
    hinges: &ContactSlopes,
    loaded: &mut LoadedHinges,
    blocks: &mut HingeBlocks,
    arms: &mut FrictionArms,
) {
    let slopes = &hinges.normal;
    let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
    let (least, least_share) = (one.constant(LEAST), one.constant(LEAST_SHARE));
    loaded.any = false;
    let groups = slopes.len();
    let count = groups * parts::<S>().len();
    let bearing = vectors_mut::<S>(&mut loaded.hinges[BASE..], count);
    let [own_xx, own_yy, own_xy] = hinge_vectors::<S>(&mut blocks.compliance, count);
    for number in 0..groups {
        let slopes = &slopes[number];
        for part in parts::<S>() {
            let i = number * parts::<S>().len() + part;
            let bears = slopes.force.at(simd, part).greater(zero);
            bearing[i] = bears.select(one, zero).values();
            if !bears.any() {
                own_xx[i] = one.values();
                own_yy[i] = one.values();
                own_xy[i] = zero.values();
                if FRICTION {
                    arms.put(i, [zero; 2], zero, [zero; 2]);
                }
                continue;
            }
            loaded.any = true;
            let [alpha, eta] = scaled(gamma, simd, slopes, part);
            let alpha = bears.select(alpha.max(least), one);
            let mut eta = bears.select(eta.max(alpha * least_share), one);
            let (nx, ny) = (
                slopes.normal[0].at(simd, part),
                slopes.normal[1].at(simd, part),
            );
            if FRICTION {
                let friction = &hinges.friction[number];
                let tau = Lanes::splat(simd, gamma) * friction.slope.at(simd, part);
                let both = eta + tau;
                let places = read(simd, &friction.places, part);
                arms.put(i, [nx, ny], tau / both, places);
                eta = both;
            }
            // n n^T/α + t t^T/η with t = (-ny, nx): along = 1/α, across = 1/η.
            let over = one / (alpha * eta);
            let (along, across) = (eta * over, alpha * over);
            let xx = along.mul_add(nx * nx, across * (ny * ny));
            let yy = along.mul_add(ny * ny, across * (nx * nx));
            own_xx[i] = bears.select(xx, one).values();
            own_yy[i] = bears.select(yy, one).values();
            own_xy[i] = ((along - across) * (nx * ny)).values();
        }
    }
}

/// Initialise the ring's blocks for ideal hinges, which have no compliance.
pub(super) fn assemble_ideal(hinges: usize, loaded: &mut LoadedHinges, blocks: &mut HingeBlocks) {
    loaded.any = true;
    loaded.hinges[BASE..].fill(0.0);
    loaded.hinges[BASE..][..hinges].fill(1.0);
    for (own, behind) in blocks.compliance.iter_mut().zip([1.0, 1.0, 0.0]) {
        own[BASE..].fill(behind);
        own[BASE..][..hinges].fill(0.0);
    }
}

impl LoadedHinges {
    /// Copy the last hinge to the entry before the first.
    #[inline(always)]
    pub(super) fn repeat_last(&mut self, hinges: usize) {
        self.hinges[BASE - 1] = self.hinges[BASE + hinges - 1];
    }
}

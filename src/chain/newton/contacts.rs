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

use super::ring::{BASE, hinge_numbers, hinge_vectors};
use crate::chain::arrays::slopes::{ContactSlopes, SlopeGroup};
use crate::math::simd::{
    Lanes, Number, Numbers, Pack, Vectors, packs_from, padded_zeros, parts, read_rounded,
    vectors_mut,
};

/// Return α and η of vector `part` of these contacts.
#[inline(always)]
pub(super) fn scaled<S: Vectors>(
    gamma: f64,
    simd: S,
    slopes: &SlopeGroup,
    part: usize,
) -> [Lanes<S>; 2] {
    let gamma_squared = Lanes::splat(simd, gamma * gamma);
    let damping = Lanes::splat(simd, gamma) * slopes.damping.rounded(simd, part);
    let turn = slopes.force.rounded(simd, part) * slopes.curvature.rounded(simd, part);
    [
        gamma_squared.mul_add(slopes.stiffness.rounded(simd, part), damping),
        gamma_squared * turn,
    ]
}

/// Lower bound of a divisor, by which zero over zero becomes zero \[kg\]. It is far below the stiffness of a contact that has any effect.
pub(super) const LEAST: f64 = 1e-20;

/// Square roots L of the stiffness of the hinges, L² = α n n^T + η t t^T: xx, yy, xy; zero where no force is transmitted. Hinge k is at
/// [`BASE`] + k; a copy of the last one precedes the first.
#[derive(Debug, Clone)]
pub(super) struct HingeRoots<T: Number> {
    pub(super) roots: [Numbers<T>; 3],
    /// Whether any hinge transmits force.
    pub(super) any: bool,
    /// The diagonal of the ring without links: one, or zero where hinges are ideal.
    pub(super) unit: f64,
}

impl<T: Number> HingeRoots<T> {
    /// Allocate the roots of `hinges`.
    pub(super) fn new(hinges: usize) -> Self {
        Self {
            roots: [(); 3].map(|()| hinge_numbers(hinges)),
            any: false,
            unit: 1.0,
        }
    }

    /// Give ideal hinges the root one: they have no compliance. `open` hinges have the root zero.
    pub(super) fn assemble_ideal(&mut self, hinges: usize, open: impl Iterator<Item = usize>) {
        (self.any, self.unit) = (true, 0.0);
        for (roots, value) in self.roots.iter_mut().zip([1.0, 1.0, 0.0]) {
            roots[BASE..][..hinges].fill(T::nearest(value));
        }
        for k in open {
            for roots in &mut self.roots {
                roots[BASE + k] = T::default();
            }
        }
    }

    /// Return the first `count` packs of hinges: xx, yy, xy.
    #[inline(always)]
    pub(super) fn packs(&self, count: usize) -> [&[Pack<T>]; 3] {
        let [xx, yy, xy] = &self.roots;
        [
            packs_from(xx, BASE, count),
            packs_from(yy, BASE, count),
            packs_from(xy, BASE, count),
        ]
    }

    /// Copy the last hinge to the entry before the first.
    #[inline(always)]
    pub(super) fn repeat_last(&mut self, hinges: usize) {
        for roots in &mut self.roots {
            roots[BASE - 1] = roots[BASE + hinges - 1];
        }
    }
}

/// Arms of the contact points of hinges with friction from the centres of the ends, along t, times τ/(η + τ) \[m\]. Hinge k is at
/// [`BASE`] + k; a copy of the last one precedes the first.
#[derive(Debug, Clone)]
pub(super) struct FrictionArms<T: Number> {
    /// Arms from fronts, x and y.
    pub(super) front: [Numbers<T>; 2],
    /// Arms from rears, x and y.
    pub(super) rear: [Numbers<T>; 2],
}

impl<T: Number> FrictionArms<T> {
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
    pub(super) fn put<S: Vectors<Number = T>>(
        &mut self,
        i: usize,
        [nx, ny]: [Lanes<S>; 2],
        share: Lanes<S>,
        [front, rear]: [Lanes<S>; 2],
    ) {
        let from = BASE + i * S::LANES;
        let (front, rear) = (share * front, share * rear);
        let [x, y] = &mut self.front;
        vectors_mut::<S>(&mut x[from..], 1)[0] = (-(front * ny)).values();
        vectors_mut::<S>(&mut y[from..], 1)[0] = (front * nx).values();
        let [x, y] = &mut self.rear;
        vectors_mut::<S>(&mut x[from..], 1)[0] = (-(rear * ny)).values();
        vectors_mut::<S>(&mut y[from..], 1)[0] = (rear * nx).values();
    }
}

/// Write the roots of the stiffness of each hinge; zero for hinges without force. `FRICTION`: with friction, η + τ in the place of η; only
/// then `arms` are written.
#[inline(always)]
pub(super) fn assemble_roots<S: Vectors, const FRICTION: bool>(
    simd: S,
    gamma: f64,
    hinges: &ContactSlopes,
    to: &mut HingeRoots<S::Number>,
    arms: &mut FrictionArms<S::Number>,
) {
    let slopes = &hinges.normal;
    let zero = Lanes::splat(simd, 0.0);
    to.any = false;
    let groups = slopes.len();
    let [root_xx, root_yy, root_xy] =
        hinge_vectors::<S>(&mut to.roots, groups * parts::<S>().len());
    for number in 0..groups {
        let slopes = &slopes[number];
        for part in parts::<S>() {
            let i = number * parts::<S>().len() + part;
            let bears = slopes.force.rounded(simd, part).greater(zero);
            if !bears.any() {
                root_xx[i] = zero.values();
                root_yy[i] = zero.values();
                root_xy[i] = zero.values();
                if FRICTION {
                    arms.put(i, [zero; 2], zero, [zero; 2]);
                }
                continue;
            }
            to.any = true;
            let [alpha, mut eta] = scaled(gamma, simd, slopes, part);
            let [nx, ny] = read_rounded(simd, &slopes.normal, part);
            if FRICTION {
                let friction = &hinges.friction[number];
                let tau = Lanes::splat(simd, gamma) * friction.slope.rounded(simd, part);
                eta = eta + tau;
                let places = read_rounded(simd, &friction.places, part);
                arms.put(i, [nx, ny], tau / eta.max(zero.constant(LEAST)), places);
            }
            // √α n n^T + √η t t^T = √η + (√α - √η) n n^T
            let along = bears.select(alpha.positive_part(), zero).sqrt();
            let across = bears.select(eta.positive_part(), zero).sqrt();
            let more = along - across;
            root_xx[i] = (more * nx).mul_add(nx, across).values();
            root_yy[i] = (more * ny).mul_add(ny, across).values();
            root_xy[i] = ((more * nx) * ny).values();
        }
    }
}

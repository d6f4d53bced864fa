//! Slopes of contact forces scaled for the matrix of one step: what a change of velocities by one does to the force at its end.
//!
//! A velocity changed by w has moved its coordinate by γ w. The force -f n of a contact then changes, in its own frame of n
//! and t, by -(α n·w + β t·w, η t·w), with α = γ² k + γ d, β = γ² d (κ slip), η = γ² f κ: k, d slopes with penetration and
//! its rate, κ the curvature, slip the speed across.

use pulp::{Simd, WithSimd};

use crate::kernels::slopes::ContactSlopes;
use crate::vector::{Lanes, Numbers, WIDTH, both, load, padded_zeros, vectors, vectors_mut};

/// α, β, η and γ² d of a register of contacts.
#[derive(Clone, Copy)]
pub(super) struct Scaled<S: Simd> {
    pub(super) alpha: Lanes<S>,
    pub(super) beta: Lanes<S>,
    pub(super) eta: Lanes<S>,
    pub(super) damping: Lanes<S>,
}

/// The same of the slopes `[k, d, κ, slip]` and of the force; `spin`: of the frame in which a bushing slips, 1/s.
#[inline(always)]
pub(super) fn scaled<S: Simd>(
    gamma: f64,
    [stiffness, damping, curvature, slip]: [Lanes<S>; 4],
    force: Lanes<S>,
    spin: Lanes<S>,
) -> Scaled<S> {
    let gamma_squared = force.constant(gamma * gamma);
    let d = gamma_squared * damping;
    Scaled {
        alpha: gamma_squared.mul_add(stiffness, force.constant(gamma) * damping),
        beta: d * curvature.mul_add(slip, spin),
        eta: gamma_squared * force * curvature,
        damping: d,
    }
}

/// Entry of hinge 0 in arrays that have the last hinge before it.
pub(super) const BASE: usize = WIDTH;

/// Hinges of one matrix: hinge k at entry [`BASE`] + k, and the last one once more before the first.
#[derive(Debug, Clone)]
pub(super) struct HingeTerms {
    pub(super) normal: [Numbers; 2],
    pub(super) alpha: Numbers,
    pub(super) beta: Numbers,
    pub(super) eta: Numbers,
    pub(super) damping: Numbers,
}

impl HingeTerms {
    pub(super) fn new(hinges: usize) -> Self {
        let zeros = || padded_zeros(BASE + hinges);
        Self {
            normal: [zeros(), zeros()],
            alpha: zeros(),
            beta: zeros(),
            eta: zeros(),
            damping: zeros(),
        }
    }

    /// Whether hinge `k` bears a force that changes.
    #[inline(always)]
    pub(super) fn is_closed(&self, k: usize) -> bool {
        self.alpha[BASE + k] != 0.0 || self.eta[BASE + k] != 0.0
    }

    fn all(&mut self) -> [&mut Numbers; 6] {
        let [x, y] = &mut self.normal;
        let rest = [
            &mut self.alpha,
            &mut self.beta,
            &mut self.eta,
            &mut self.damping,
        ];
        let [alpha, beta, eta, damping] = rest;
        [x, y, alpha, beta, eta, damping]
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
        let zero = Lanes::splat(simd, 0.0);
        let at = |array: &[f64], i: usize| load(simd, &vectors::<S>(array, blocks)[i]);
        let normal = both::<S>(&slopes.normal, 0, blocks);
        let [x, y, alpha, beta, eta, damping] = terms
            .all()
            .map(|array| vectors_mut::<S>(&mut array[BASE..], blocks));
        for i in 0..blocks {
            let slopes = [
                at(&slopes.stiffness, i),
                at(&slopes.damping, i),
                at(&slopes.curvature, i),
                at(&slopes.slip, i),
            ];
            let hinge = scaled(gamma, slopes, at(force, i), zero);
            (x[i], y[i]) = (normal[0][i], normal[1][i]);
            alpha[i] = hinge.alpha.values();
            beta[i] = hinge.beta.values();
            eta[i] = hinge.eta.values();
            damping[i] = hinge.damping.values();
        }
        for array in terms.all() {
            array[BASE - 1] = array[BASE + hinges - 1];
        }
    }
}

//! How contact forces change, as an evaluation leaves it for Newton's matrix: one number a quantity and contact.
//!
//! With the normal n, the direction t left of it and the offset e of the two points that a contact is between, the force is
//! -f n, and its change has two parts: that of f, by penetration n·de and rate, and that of n, which turns by κ t·de.

use pulp::Simd;

use crate::force_law::VectorLaw;
use crate::vector::{Lanes, Mask, Numbers, both_mut, padded_zeros, vectors_mut};

/// Slopes of the forces of some contacts; all zero where a contact bears nothing.
#[derive(Debug, Clone)]
pub(super) struct ContactSlopes {
    /// n, x and y.
    pub(super) normal: [Numbers; 2],
    /// Slope of the force with penetration \[N/m\].
    pub(super) stiffness: Numbers,
    /// Slope with the rate of penetration \[N s/m\].
    pub(super) damping: Numbers,
    /// κ, how far the normal turns for a length moved across it \[1/m\].
    pub(super) curvature: Numbers,
    /// Speed across the normal, along t \[m/s\]: of the one point seen from the other, or of a bushing seen from its sprocket.
    pub(super) slip: Numbers,
}

impl ContactSlopes {
    /// Room for `contacts`.
    pub(super) fn new(contacts: usize) -> Self {
        let zeros = || padded_zeros(contacts);
        Self {
            normal: [zeros(), zeros()],
            stiffness: zeros(),
            damping: zeros(),
            curvature: zeros(),
            slip: zeros(),
        }
    }

    /// `blocks` registers from contact `first` on.
    #[inline(always)]
    pub(super) fn registers<S: Simd>(
        &mut self,
        first: usize,
        blocks: usize,
    ) -> SlopeRegisters<'_, S> {
        SlopeRegisters {
            normal: both_mut::<S>(&mut self.normal, first, blocks),
            stiffness: vectors_mut::<S>(&mut self.stiffness[first..], blocks),
            damping: vectors_mut::<S>(&mut self.damping[first..], blocks),
            curvature: vectors_mut::<S>(&mut self.curvature[first..], blocks),
            slip: vectors_mut::<S>(&mut self.slip[first..], blocks),
        }
    }
}

/// The same arrays as registers.
pub(super) struct SlopeRegisters<'a, S: Simd> {
    normal: [&'a mut [S::f64s]; 2],
    stiffness: &'a mut [S::f64s],
    damping: &'a mut [S::f64s],
    curvature: &'a mut [S::f64s],
    slip: &'a mut [S::f64s],
}

/// A register of contacts as an evaluation knows them.
pub(super) struct Touch<S: Simd> {
    pub(super) normal: [Lanes<S>; 2],
    pub(super) curvature: Lanes<S>,
    /// Velocity whose part across the normal is the slip.
    pub(super) velocity: [Lanes<S>; 2],
    pub(super) depth: Lanes<S>,
    /// Elastic part of the force.
    pub(super) elastic: Lanes<S>,
}

/// The damping factor 1 + λ rate/onset of a register of contacts, and what it came from.
pub(super) struct Damped<S: Simd> {
    pub(super) lambda: Lanes<S>,
    pub(super) rate: Lanes<S>,
    pub(super) inverse_onset: Lanes<S>,
    /// Not negative.
    pub(super) factor: Lanes<S>,
    pub(super) remembered: Mask<S>,
    pub(super) floor: Lanes<S>,
}

impl<S: Simd> SlopeRegisters<'_, S> {
    /// Contacts that bear nothing.
    #[inline(always)]
    pub(super) fn put_nothing(&mut self, i: usize, zero: Lanes<S>) {
        self.put(i, [zero; 6]);
    }

    /// Contacts with the damping factor, where there is one.
    #[inline(always)]
    pub(super) fn put_touch<L: VectorLaw>(
        &mut self,
        i: usize,
        constants: [Lanes<S>; 2],
        touch: &Touch<S>,
        damped: Option<&Damped<S>>,
    ) {
        let zero = touch.depth.constant(0.0);
        let [nx, ny] = touch.normal;
        let [vx, vy] = touch.velocity;
        let mut stiffness = L::slopes(constants, touch.depth, touch.elastic);
        let mut damping = zero;
        if let Some(d) = damped {
            stiffness = stiffness * d.factor;
            // Without memory the present rate is the onset speed and the factor a constant, above the floor.
            let fresh_and_fast = d.remembered.not().and(d.rate.greater(d.floor));
            let gone = fresh_and_fast.or(d.factor.greater(zero).not());
            damping = gone.select(zero, touch.elastic * d.lambda * d.inverse_onset);
        }
        let slip = nx.mul_add(vy, -(ny * vx));
        self.put(i, [nx, ny, stiffness, damping, touch.curvature, slip]);
    }

    #[inline(always)]
    fn put(&mut self, i: usize, [nx, ny, stiffness, damping, curvature, slip]: [Lanes<S>; 6]) {
        self.normal[0][i] = nx.values();
        self.normal[1][i] = ny.values();
        self.stiffness[i] = stiffness.values();
        self.damping[i] = damping.values();
        self.curvature[i] = curvature.values();
        self.slip[i] = slip.values();
    }
}

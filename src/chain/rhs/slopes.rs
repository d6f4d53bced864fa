//! How contact forces change, as an evaluation leaves it for Newton's matrix.
//!
//! With the normal n, the direction t left of it and the offset e of the two points that a contact is between, the force is
//! -f n, and its change has two parts: that of f, by penetration n·de and rate, and that of n, which turns by κ t·de.

use pulp::Simd;

use crate::math::simd::{Lanes, Octet, WIDTH};

/// Slopes of the forces of eight contacts; all zero where a contact bears nothing.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SlopeGroup {
    /// n, x and y.
    pub(crate) normal: [Octet; 2],
    /// The force \[N\].
    pub(crate) force: Octet,
    /// Its slope with penetration \[N/m\].
    pub(crate) stiffness: Octet,
    /// Its slope with the rate of penetration \[N s/m\].
    pub(crate) damping: Octet,
    /// κ, how far the normal turns for a length moved across it \[1/m\].
    pub(crate) curvature: Octet,
}

/// Room for `contacts`.
pub(crate) fn slope_groups(contacts: usize) -> Vec<SlopeGroup> {
    vec![SlopeGroup::default(); contacts.div_ceil(WIDTH)]
}

/// How friction of eight contacts changes with their slip, and where it acts.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FrictionGroup {
    /// Slope of the friction with the slip \[N s/m\].
    pub(crate) slope: Octet,
    /// Where a hinge's contact lies along the normal, seen from the centres of its front and rear ends \[m\].
    pub(crate) places: [Octet; 2],
}

/// How the films of eight hinges change, along their eccentricities, across, and both; all zero where there is none.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FilmGroup {
    /// Direction of the eccentricity, x and y.
    pub(crate) normal: [Octet; 2],
    /// Slopes with the velocity \[N s/m\].
    pub(crate) damping: [Octet; 3],
    /// With the eccentricity \[N/m\].
    pub(crate) stiffness: [Octet; 3],
}

/// The group that vector `i` of contacts is in, and its number there.
#[inline(always)]
pub(crate) fn group_of<S: Simd, T>(groups: &mut [T], i: usize) -> (&mut T, usize) {
    let parts = WIDTH / S::F64_LANES;
    (&mut groups[i / parts], i % parts)
}

impl SlopeGroup {
    /// Writes vector `part`: n, the force, its slopes with penetration and rate, κ.
    #[inline(always)]
    pub(super) fn put<S: Simd>(
        &mut self,
        part: usize,
        [nx, ny, force, stiffness, damping, curvature]: [Lanes<S>; 6],
    ) {
        self.normal[0].put(part, nx);
        self.normal[1].put(part, ny);
        self.force.put(part, force);
        self.stiffness.put(part, stiffness);
        self.damping.put(part, damping);
        self.curvature.put(part, curvature);
    }
}

//! Ends of links: positions and velocities, one SIMD vector of links at a time.

use pulp::Simd;

use crate::math::simd::{Lanes, Mask, load, partial_load, vectors};

/// Quantities of links from a first link on, such as x, y \[m\], dx/dt, dy/dt \[m/s\] and dθ/dt \[rad/s\].
pub(crate) struct Links<'a, S: Simd, const N: usize>([&'a [S::f64s]; N]);

impl<'a, S: Simd, const N: usize> Links<'a, S, N> {
    /// Return `blocks` vectors from link `first` on.
    #[inline(always)]
    pub(crate) fn of(links: [&'a [f64]; N], first: usize, blocks: usize) -> Self {
        let mut all: [&'a [S::f64s]; N] = [&[]; N];
        for (vectors_of, array) in all.iter_mut().zip(links) {
            *vectors_of = vectors::<S>(&array[first..], blocks);
        }
        Self(all)
    }

    /// Return vector `i` of links.
    #[inline(always)]
    pub(crate) fn at(&self, simd: S, i: usize) -> [Lanes<S>; N] {
        let mut all = [Lanes::splat(simd, 0.0); N];
        for (lanes, array) in all.iter_mut().zip(self.0) {
            *lanes = load(simd, &array[i]);
        }
        all
    }
}

/// Return the last vector of links, from link `from` on; lanes behind the last link are zero.
#[inline(always)]
pub(crate) fn last_links<S: Simd, const N: usize>(
    simd: S,
    links: [&[f64]; N],
    from: usize,
) -> [Lanes<S>; N] {
    let mut all = [Lanes::splat(simd, 0.0); N];
    for (lanes, array) in all.iter_mut().zip(links) {
        *lanes = partial_load(simd, &array[from..]);
    }
    all
}

/// Return the vector that begins one link later; its last entry is the first link of the chain.
#[inline(always)]
pub(crate) fn behind_last<S: Simd, const N: usize>(
    links: [&[f64]; N],
    last: [Lanes<S>; N],
    from: usize,
) -> [Lanes<S>; N] {
    let mut all = last;
    for (lanes, array) in all.iter_mut().zip(links) {
        *lanes = lanes.followed_by(array[0], array.len() - from);
    }
    all
}

/// Positions of ends along their links, and directions of the links, from a first link on.
pub(crate) struct Arms<'a, S: Simd> {
    arm: &'a [S::f64s],
    cos: &'a [S::f64s],
    sin: &'a [S::f64s],
}

impl<'a, S: Simd> Arms<'a, S> {
    /// Return `blocks` vectors; the directions begin with link `first`.
    #[inline(always)]
    pub(crate) fn of(
        arm: &'a [f64],
        [cos, sin]: [&'a [f64]; 2],
        first: usize,
        blocks: usize,
    ) -> Self {
        Self {
            arm: vectors::<S>(arm, blocks),
            cos: vectors::<S>(&cos[first..], blocks),
            sin: vectors::<S>(&sin[first..], blocks),
        }
    }

    /// Return arm, cosine and sine of vector `i` of links.
    #[inline(always)]
    pub(crate) fn at(&self, simd: S, i: usize) -> [Lanes<S>; 3] {
        [
            load(simd, &self.arm[i]),
            load(simd, &self.cos[i]),
            load(simd, &self.sin[i]),
        ]
    }
}

/// One end of each link of a SIMD vector.
#[derive(Clone, Copy)]
pub(crate) struct End<S: Simd> {
    pub(crate) x: Lanes<S>,
    pub(crate) y: Lanes<S>,
    pub(crate) vx: Lanes<S>,
    pub(crate) vy: Lanes<S>,
    /// Angular velocity of the link \[rad/s\].
    pub(crate) spin: Lanes<S>,
}

impl<S: Simd> End<S> {
    /// Return `here` shifted by one lane, with the first lane of `next` in the last lane.
    #[inline(always)]
    pub(crate) fn moved_on(here: &Self, next: &Self, last_lane: Mask<S>) -> Self {
        let mut moved = *next;
        moved.x = here.x.moved_on(next.x, last_lane);
        moved.y = here.y.moved_on(next.y, last_lane);
        moved.vx = here.vx.moved_on(next.vx, last_lane);
        moved.vy = here.vy.moved_on(next.vy, last_lane);
        moved.spin = here.spin.moved_on(next.spin, last_lane);
        moved
    }

    /// Return the ends at `arm` from the centres: x + arm (cos, sin), with velocity v + arm dθ/dt (-sin, cos).
    #[inline(always)]
    pub(crate) fn new([x, y, vx, vy, spin]: [Lanes<S>; 5], [arm, cos, sin]: [Lanes<S>; 3]) -> Self {
        let turn = arm * spin;
        Self {
            x: arm.mul_add(cos, x),
            y: arm.mul_add(sin, y),
            vx: turn.negate_mul_add(sin, vx),
            vy: turn.mul_add(cos, vy),
            spin,
        }
    }
}

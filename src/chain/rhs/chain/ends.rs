//! Ends of links: positions and velocities, one SIMD vector of links at a time.

use pulp::Simd;

use crate::math::simd::{Lanes, Mask, load, partial_load, vectors, vectors_from};

/// x, y \[m\], dx/dt, dy/dt \[m/s\] and dθ/dt \[rad/s\] of links, from a first link on.
pub(super) struct Links<'a, S: Simd>([&'a [S::f64s]; 5]);

impl<'a, S: Simd> Links<'a, S> {
    /// Return `blocks` vectors from link `first` on.
    #[inline(always)]
    pub(super) fn of([x, y, vx, vy, spin]: [&'a [f64]; 5], first: usize, blocks: usize) -> Self {
        Self([
            vectors_from::<S>(x, first, blocks),
            vectors_from::<S>(y, first, blocks),
            vectors_from::<S>(vx, first, blocks),
            vectors_from::<S>(vy, first, blocks),
            vectors_from::<S>(spin, first, blocks),
        ])
    }

    /// Return vector `i` of links.
    #[inline(always)]
    pub(super) fn at(&self, simd: S, i: usize) -> [Lanes<S>; 5] {
        let [x, y, vx, vy, spin] = self.0;
        [
            load(simd, &x[i]),
            load(simd, &y[i]),
            load(simd, &vx[i]),
            load(simd, &vy[i]),
            load(simd, &spin[i]),
        ]
    }
}

/// Return the last vector of links, from link `from` on; lanes behind the last link are zero.
#[inline(always)]
pub(super) fn last_links<S: Simd>(simd: S, links: [&[f64]; 5], from: usize) -> [Lanes<S>; 5] {
    let [x, y, vx, vy, spin] = links;
    [
        partial_load(simd, &x[from..]),
        partial_load(simd, &y[from..]),
        partial_load(simd, &vx[from..]),
        partial_load(simd, &vy[from..]),
        partial_load(simd, &spin[from..]),
    ]
}

/// Return the vector that begins one link later; its last entry is the first link of the chain.
#[inline(always)]
pub(super) fn behind_last<S: Simd>(
    links: [&[f64]; 5],
    last: [Lanes<S>; 5],
    from: usize,
) -> [Lanes<S>; 5] {
    let [x, y, vx, vy, spin] = links;
    let count = x.len() - from;
    [
        last[0].followed_by(x[0], count),
        last[1].followed_by(y[0], count),
        last[2].followed_by(vx[0], count),
        last[3].followed_by(vy[0], count),
        last[4].followed_by(spin[0], count),
    ]
}

/// Positions of ends along their links, and directions of the links, from a first link on.
pub(super) struct Arms<'a, S: Simd> {
    arm: &'a [S::f64s],
    cos: &'a [S::f64s],
    sin: &'a [S::f64s],
}

impl<'a, S: Simd> Arms<'a, S> {
    /// Return `blocks` vectors; the directions begin with link `first`.
    #[inline(always)]
    pub(super) fn of(
        arm: &'a [f64],
        [cos, sin]: [&'a [f64]; 2],
        first: usize,
        blocks: usize,
    ) -> Self {
        Self {
            arm: vectors::<S>(arm, blocks),
            cos: vectors_from::<S>(cos, first, blocks),
            sin: vectors_from::<S>(sin, first, blocks),
        }
    }

    /// Return arm, cosine and sine of vector `i` of links.
    #[inline(always)]
    pub(super) fn at(&self, simd: S, i: usize) -> [Lanes<S>; 3] {
        [
            load(simd, &self.arm[i]),
            load(simd, &self.cos[i]),
            load(simd, &self.sin[i]),
        ]
    }
}

/// One end of each link of a SIMD vector.
#[derive(Clone, Copy)]
pub(super) struct LinkEnd<S: Simd> {
    pub(super) x: Lanes<S>,
    pub(super) y: Lanes<S>,
    pub(super) vx: Lanes<S>,
    pub(super) vy: Lanes<S>,
    /// Angular velocity of the link \[rad/s\].
    pub(super) spin: Lanes<S>,
}

impl<S: Simd> LinkEnd<S> {
    /// Return `here` shifted by one lane, with the first lane of `next` in the last lane.
    #[inline(always)]
    pub(super) fn moved_on(here: &Self, next: &Self, last_lane: Mask<S>) -> Self {
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
    pub(super) fn new([x, y, vx, vy, spin]: [Lanes<S>; 5], [arm, cos, sin]: [Lanes<S>; 3]) -> Self {
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

//! Tooth gap for a SIMD vector of bushings: interface between tooth forms and the loops over a sprocket's candidates.

use pulp::Simd;

use crate::math::simd::{Lanes, Mask};

/// Bushings in the coordinate frames of their gaps.
pub(crate) struct InGap<S: Simd> {
    /// v, radially outward through the gap; u is v turned clockwise.
    pub(crate) direction: [Lanes<S>; 2],
    /// v in the frame of the sprocket.
    pub(crate) gap: [Lanes<S>; 2],
    /// Position along u \[m\].
    pub(crate) u: Lanes<S>,
    /// Position along v, from the centre of the teeth \[m\].
    pub(crate) outward: Lanes<S>,
}

impl<S: Simd> InGap<S> {
    /// Return bushings at `arm` from the centre of the teeth. The sprocket's angle is `direction`, and the gaps are at `gap` in its
    /// frame; both are cosine and sine.
    #[inline(always)]
    pub(crate) fn new(
        [arm_x, arm_y]: [Lanes<S>; 2],
        [cos, sin]: [Lanes<S>; 2],
        [gap_cos, gap_sin]: [Lanes<S>; 2],
    ) -> Self {
        let vx = cos.mul_add(gap_cos, -(sin * gap_sin));
        let vy = sin.mul_add(gap_cos, cos * gap_sin);
        Self {
            direction: [vx, vy],
            gap: [gap_cos, gap_sin],
            u: arm_x.mul_add(vy, -(arm_y * vx)),
            outward: arm_x.mul_add(vx, arm_y * vy),
        }
    }

    /// Return the bushings on the left of their gaps.
    #[inline(always)]
    pub(crate) fn on_left(&self) -> Mask<S> {
        self.u.less(self.u.constant(0.0))
    }

    /// Return a direction (u as on the right flank, v) in the frame of the scene; `left` selects left flanks.
    #[inline(always)]
    pub(crate) fn to_scene(&self, left: Mask<S>, [u, v]: [Lanes<S>; 2]) -> [Lanes<S>; 2] {
        let u = left.select(-u, u);
        let [vx, vy] = self.direction;
        [u.mul_add(vy, v * vx), v.mul_add(vy, -(u * vx))]
    }

    /// Return velocities in the frame of the scene as (u as on the right flank, v).
    #[inline(always)]
    pub(crate) fn in_gap(&self, left: Mask<S>, [x, y]: [Lanes<S>; 2]) -> [Lanes<S>; 2] {
        let [vx, vy] = self.direction;
        let outward = x.mul_add(vx, y * vy);
        let right = x.mul_add(vy, -(y * vx));
        [left.select(-right, right), outward]
    }
}

/// Tooth form with its constants for SIMD vectors; each form has its own instance of a loop.
pub(crate) trait Gap<S: Simd> {
    /// Nearest surface of each bushing.
    type Nearest;

    /// Return bushings at `arm` from the centre of a sprocket with angle `direction`, in gaps at `gap` in its frame; both are
    /// cosine and sine.
    fn place(&self, arm: [Lanes<S>; 2], direction: [Lanes<S>; 2], gap: [Lanes<S>; 2]) -> InGap<S>;

    /// Return cosine and sine of half the angle between adjacent gaps.
    fn half_gap(&self) -> [Lanes<S>; 2];

    /// Return the nearest surface of each bushing.
    fn nearest(&self, place: &InGap<S>) -> Self::Nearest;

    /// Return the bushings that overlap their nearest surface.
    fn near(&self, surface: &Self::Nearest) -> Mask<S>;

    /// Return the penetration, its direction of growth in the frame of the scene, and the curvature: rotation of that direction per
    /// displacement across it \[1/m\].
    fn depth(
        &self,
        surface: &Self::Nearest,
        place: &InGap<S>,
    ) -> (Lanes<S>, [Lanes<S>; 2], Lanes<S>);

    /// Return the gap as defined in [event screening](super::event_screening), and its rate for bushings with `velocity` relative to the
    /// sprocket.
    fn gap_and_rate(
        &self,
        surface: &Self::Nearest,
        place: &InGap<S>,
        velocity: [Lanes<S>; 2],
    ) -> [Lanes<S>; 2];

    /// Return the numbers of the surfaces, and the mask of left flanks.
    fn surface(&self, surface: &Self::Nearest, place: &InGap<S>) -> (Lanes<S>, Mask<S>);

    /// Return the law constants of the surfaces.
    fn law_constants(&self, surface: &Self::Nearest) -> [Lanes<S>; 2];

    /// Return the bushings that are nearer to an adjacent gap.
    #[inline(always)]
    fn left(&self, place: &InGap<S>) -> Mask<S> {
        let [cos, sin] = self.half_gap();
        // Angle to the middle of the gap above half a pitch: |u|/v > tan(half).
        (place.u.abs() * cos).greater(place.outward * sin)
    }
}

/// Constants of a tooth form, from which its [`Gap`] is made.
pub(crate) trait GapConstants {
    /// Tooth form with its constants for SIMD vectors.
    type Of<'a, S: Simd>: Gap<S>
    where
        Self: 'a;

    /// Return the gap for the instruction set `simd`.
    fn gap<S: Simd>(&self, simd: S) -> Self::Of<'_, S>;
}

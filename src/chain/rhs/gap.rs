//! A tooth gap over a vector of bushings: what the loops over a sprocket's candidates ask of its tooth form.

use pulp::Simd;

use super::ansi_gap::AnsiGap;
use super::surface_table::SurfaceTable;
use crate::chain::model::Model;
use crate::force_law::Regions;
use crate::geometry::Vec2;
use crate::math::simd::{Lanes, Mask};

/// The teeth of a sprocket in numbers, with the law constants of every surface.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ToothConstants {
    pub(crate) form: Form,
    /// Whether a contact keeps the stiffness that it began with.
    pub(crate) keeps_stiffness: bool,
}

/// The forms that have loops of their own.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Form {
    /// The four surfaces of a whole ANSI tooth.
    Ansi(AnsiGap),
    /// Any surfaces, damaged and eccentric teeth.
    Table(SurfaceTable),
}

impl ToothConstants {
    pub(crate) fn new(model: &Model, s: usize) -> Self {
        let sprocket = &model.sprockets[s];
        let plain = sprocket.offset == Vec2::zeros() && sprocket.profile.damaged().next().is_none();
        let form = match sprocket.profile.ansi_curves().filter(|_| plain) {
            Some(curves) => Form::Ansi(AnsiGap::new(model, s, curves)),
            None => Form::Table(SurfaceTable::new(model, s)),
        };
        Self {
            form,
            keeps_stiffness: model.tooth_law.regions == Regions::Kept,
        }
    }
}

/// Bushings in the frames of their gaps.
pub(crate) struct InGap<S: Simd> {
    /// v, radially outward through the gap; u is v turned clockwise.
    pub(crate) direction: [Lanes<S>; 2],
    /// v in the sprocket's own frame.
    pub(crate) gap: [Lanes<S>; 2],
    /// Along u \[m\].
    pub(crate) u: Lanes<S>,
    /// Along v, from the teeth's centre \[m\].
    pub(crate) outward: Lanes<S>,
}

impl<S: Simd> InGap<S> {
    /// Bushings at `arm` from the centre of the teeth of a sprocket that has turned to `direction`, in gaps at `gap` in its own
    /// frame.
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

    /// Bushings on the left of their gaps.
    #[inline(always)]
    pub(crate) fn on_left(&self) -> Mask<S> {
        self.u.less(self.u.constant(0.0))
    }

    /// A direction (u as on the right flank, v) in the frame of the scene, where `left` that of the left flank.
    #[inline(always)]
    pub(crate) fn to_scene(&self, left: Mask<S>, [u, v]: [Lanes<S>; 2]) -> [Lanes<S>; 2] {
        let u = left.select(-u, u);
        let [vx, vy] = self.direction;
        [u.mul_add(vy, v * vx), v.mul_add(vy, -(u * vx))]
    }

    /// Velocities in the frame of the scene as (u as on the right flank, v).
    #[inline(always)]
    pub(crate) fn in_gap(&self, left: Mask<S>, [x, y]: [Lanes<S>; 2]) -> [Lanes<S>; 2] {
        let [vx, vy] = self.direction;
        let outward = x.mul_add(vx, y * vy);
        let right = x.mul_add(vy, -(y * vx));
        [left.select(-right, right), outward]
    }
}

/// A tooth form with its constants at hand; one loop for each.
pub(crate) trait Gap<S: Simd> {
    /// The surface nearest to each bushing.
    type Nearest;

    /// Bushings at `arm` from the centre of a sprocket that has turned to `direction`, in gaps at `gap` in its own frame.
    fn place(&self, arm: [Lanes<S>; 2], direction: [Lanes<S>; 2], gap: [Lanes<S>; 2]) -> InGap<S>;

    /// Cosine and sine of half the angle from gap to gap.
    fn half_gap(&self) -> [f64; 2];

    /// The surface nearest to bushings.
    fn nearest(&self, place: &InGap<S>) -> Self::Nearest;

    /// Bushings within touch of it.
    fn near(&self, surface: &Self::Nearest) -> Mask<S>;

    /// Depth, the direction in which it grows, and how far that direction turns for a length moved across it \[1/m\].
    fn depth(
        &self,
        surface: &Self::Nearest,
        place: &InGap<S>,
    ) -> (Lanes<S>, [Lanes<S>; 2], Lanes<S>);

    /// The gap as [`watch`](super::event_screening) has it, and its rate for bushings that move at `velocity` seen from the sprocket.
    fn gap_and_rate(
        &self,
        surface: &Self::Nearest,
        place: &InGap<S>,
        velocity: [Lanes<S>; 2],
    ) -> [Lanes<S>; 2];

    /// Numbers of the surfaces, and which of them are on left flanks.
    fn surface(&self, surface: &Self::Nearest, place: &InGap<S>) -> (Lanes<S>, Mask<S>);

    /// Law constants of the surfaces.
    fn law_constants(&self, surface: &Self::Nearest) -> [Lanes<S>; 2];

    /// Bushings that are nearer to a neighbouring gap.
    #[inline(always)]
    fn left(&self, place: &InGap<S>) -> Mask<S> {
        let [cos, sin] = self.half_gap();
        let (cos, sin) = (place.u.constant(cos), place.u.constant(sin));
        (place.u.abs() * cos).greater(place.outward * sin)
    }
}

/// The constants of a form, from which its gap is made.
pub(crate) trait GapConstants {
    /// The form with its constants at hand.
    type Of<'a, S: Simd>: Gap<S>
    where
        Self: 'a;

    /// With the instructions `simd`.
    fn gap<S: Simd>(&self, simd: S) -> Self::Of<'_, S>;
}

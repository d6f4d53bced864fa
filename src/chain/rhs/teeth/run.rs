//! Arrays of one run of candidates in SIMD vectors: successive bushings in successive slots.

use pulp::Simd;
use pulp::bytemuck::{cast_slice, cast_slice_mut};

use crate::chain::arrays::layout::{ChainArrays, FIRST, LinkConstants};
use crate::chain::arrays::pose::SprocketPose;
use crate::chain::arrays::slopes::{ContactSlopes, FrictionGroup, SlopeGroup, group_of};
use crate::chain::contact::{BushingRun, SprocketCandidates, gap_of};
use crate::chain::model::SprocketModel;
use crate::chain::rhs::bristles::BristleLanes;
use crate::geometry::Vec2;
use crate::math::simd::{Lanes, Numbers, both, both_mut, vectors_from, vectors_from_mut};

/// Arrays of one run in SIMD vectors; numbers of gaps bushing by bushing.
pub(super) struct RunOfBushings<'a, S: Simd> {
    pub(super) bushing: [&'a [S::f64s]; 2],
    pub(super) velocity: [&'a [S::f64s]; 2],
    pub(super) on_front: &'a [S::f64s],
    pub(super) inverse_impact_velocity: &'a [S::f64s],
    pub(super) kept_constants: [&'a [S::f64s]; 2],
    pub(super) depth: &'a mut [S::f64s],
    pub(super) force: &'a mut [S::f64s],
    pub(super) front_force: [&'a mut [S::f64s]; 2],
    pub(super) rear_force: [&'a mut [S::f64s]; 2],
    pub(super) slopes: Option<&'a mut [SlopeGroup]>,
    pub(super) friction_arrays: FrictionArrays<'a, S>,
    gap: &'a mut [u32],
    pub(super) gap_cos: &'a mut [S::f64s],
    pub(super) gap_sin: &'a mut [S::f64s],
    /// Signed depths and their rates for the event screening.
    pub(super) ends: [&'a mut [S::f64s]; 2],
}

/// Arrays of one run that friction reads and writes; empty without friction.
pub(super) struct FrictionArrays<'a, S: Simd> {
    pub(super) spin: &'a [S::f64s],
    /// Moments on front and rear ends \[N m\].
    pub(super) moments: [&'a mut [S::f64s]; 2],
    pub(super) friction: &'a mut [S::f64s],
    pub(super) slopes: Option<&'a mut [FrictionGroup]>,
    /// `Some` for `BRISTLED`.
    pub(super) bristles: Option<BristleLanes<'a, S>>,
}

impl<'a, S: Simd> RunOfBushings<'a, S> {
    /// Return the arrays of run `number` of the candidates. `FRICTION`: with those of friction.
    #[inline(always)]
    pub(super) fn of<const FRICTION: bool>(
        number: usize,
        links: &'a LinkConstants,
        arrays: &'a mut ChainArrays,
        candidates: &'a mut SprocketCandidates,
        slopes: Option<&'a mut ContactSlopes>,
        ends: &'a mut [Numbers; 2],
    ) -> Self {
        let BushingRun {
            first,
            length,
            slot,
        } = candidates.runs[number];
        let blocks = length.div_ceil(S::F64_LANES);
        let (slopes, friction_slopes) = slopes.map(|slopes| slopes.at_slot(slot)).unzip();
        let mut friction_arrays = FrictionArrays::<S> {
            spin: &[],
            moments: [&mut [], &mut []],
            friction: &mut [],
            slopes: None,
            bristles: None,
        };
        if FRICTION {
            friction_arrays.spin = vectors_from::<S>(&arrays.bushing_spin, first, blocks);
            friction_arrays.moments = [
                vectors_from_mut::<S>(&mut arrays.front_moment, first, blocks),
                vectors_from_mut::<S>(&mut arrays.rear_moment, FIRST + 1 + first, blocks),
            ];
            friction_arrays.friction =
                vectors_from_mut::<S>(&mut candidates.friction, slot, blocks);
            friction_arrays.slopes = friction_slopes;
        }
        Self {
            bushing: both::<S>(&arrays.bushing, first, blocks),
            velocity: both::<S>(&arrays.bushing_velocity, first, blocks),
            on_front: vectors_from::<S>(&links.bushing_on_front, first, blocks),
            inverse_impact_velocity: vectors_from::<S>(
                &candidates.inverse_impact_velocity,
                slot,
                blocks,
            ),
            kept_constants: both::<S>(&candidates.kept_constants, slot, blocks),
            depth: vectors_from_mut::<S>(&mut candidates.depth, slot, blocks),
            force: vectors_from_mut::<S>(&mut candidates.force, slot, blocks),
            front_force: both_mut::<S>(&mut arrays.front_force, first, blocks),
            rear_force: both_mut::<S>(&mut arrays.rear_force, FIRST + 1 + first, blocks),
            slopes,
            friction_arrays,
            gap: &mut candidates.gap[slot..],
            gap_cos: vectors_from_mut::<S>(&mut candidates.gap_cos, slot, blocks),
            gap_sin: vectors_from_mut::<S>(&mut candidates.gap_sin, slot, blocks),
            ends: both_mut::<S>(ends, slot, blocks),
        }
    }

    /// Write zero for the slopes of vector `b`, if they are requested.
    #[inline(always)]
    pub(super) fn clear_slopes(&mut self, b: usize, zero: Lanes<S>) {
        if let Some(slopes) = &mut self.slopes {
            let (group, part) = group_of::<S, _>(slopes, b);
            group.put(part, [zero; 6]);
        }
        if let Some(slopes) = &mut self.friction_arrays.slopes {
            let (group, part) = group_of::<S, _>(slopes, b);
            group.slope.put(part, zero);
        }
    }

    /// Assign the nearest gap to each bushing of vector `b` of a run of `length` bushings.
    #[inline(always)]
    pub(super) fn assign_gaps(
        &mut self,
        sprocket: &SprocketModel,
        pose: &SprocketPose,
        b: usize,
        length: usize,
    ) {
        for j in (0..length).skip(b * S::F64_LANES).take(S::F64_LANES) {
            let [x, y] = self.bushing.map(|axis| cast_slice::<_, f64>(axis)[j]);
            let number = gap_of(
                sprocket,
                Vec2::new(x, y) - Vec2::from(pose.center),
                pose.direction,
            );
            self.gap[j] = number;
            let (cos, sin) = sprocket.gap_directions[number as usize];
            cast_slice_mut(self.gap_cos)[j] = cos;
            cast_slice_mut(self.gap_sin)[j] = sin;
        }
    }
}

//! Contact quantities for reports: signed penetrations, rates, normals and surfaces of all candidates on teeth.
//!
//! A time step needs only penetration and force of a tooth contact. The other quantities are evaluated here with the same tooth
//! forms.

use pulp::{Simd, WithSimd};

use super::gap::{Gap, GapConstants};
use super::tooth_constants::GapForm;
use super::{Kernels, on_teeth};
use crate::chain::arrays::layout::ChainArrays;
use crate::chain::arrays::pose::SprocketPose;
use crate::chain::contact::{ImpactMemory, SprocketCandidates};
use crate::chain::loads::SprocketLoad;
use crate::chain::model::Model;
use crate::chain::motion::Motion;
use crate::geometry::Vec2;
use crate::math::simd::{
    Lanes, Numbers, both, both_mut, load, padded_zeros, splat_two, vectors_from, vectors_from_mut,
};

/// Contact quantities of the candidates of one sprocket, slot by slot.
#[derive(Debug, Clone)]
pub(crate) struct ToothReadings {
    /// Penetration \[m\]; negative without contact, -inf out of reach of the teeth.
    pub(crate) penetration: Numbers,
    /// Penetration rate \[m/s\].
    pub(crate) rate: Numbers,
    /// Force of the sprocket on the bushing, x and y \[N\]: -normal force · n - friction · n turned left, with the direction n of
    /// growing penetration.
    pub(crate) on_bushing: [Numbers; 2],
    /// Number of the nearest surface.
    pub(crate) surface: Numbers,
    /// One on a left flank, zero on a right one.
    pub(crate) left: Numbers,
}

impl ToothReadings {
    /// Allocate `slots` candidates.
    pub(crate) fn new(slots: usize) -> Self {
        let zeros = || padded_zeros(slots);
        Self {
            penetration: zeros(),
            rate: zeros(),
            on_bushing: [zeros(), zeros()],
            surface: zeros(),
            left: zeros(),
        }
    }
}

/// Kernel that evaluates the candidates of one sprocket at the last evaluation.
pub(super) struct ReadTeeth<'a, C> {
    pub(super) constants: &'a C,
    pub(super) pose: &'a SprocketPose,
    pub(super) arrays: &'a ChainArrays,
    pub(super) candidates: &'a SprocketCandidates,
    /// Distance from the sprocket's centre out of which nothing touches its teeth \[m\].
    pub(super) reach: f64,
    pub(super) readings: &'a mut ToothReadings,
}

impl<C: GapConstants> WithSimd for ReadTeeth<'_, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let splat = |value| Lanes::splat(simd, value);
        let (zero, one) = (splat(0.0), splat(1.0));
        let (reach_squared, out_of_reach) =
            (splat(self.reach * self.reach), splat(f64::NEG_INFINITY));
        let gaps = self.constants.gap(simd);
        let center = splat_two(simd, self.pose.center);
        let own = splat_two(simd, self.pose.velocity);
        let direction = splat_two(simd, self.pose.direction);
        let spin = splat(self.pose.spin);
        for run in &self.candidates.runs {
            let (slot, blocks) = (run.slot, run.length.div_ceil(S::F64_LANES));
            let bushing = both::<S>(&self.arrays.bushing, run.first, blocks);
            let velocity = both::<S>(&self.arrays.bushing_velocity, run.first, blocks);
            let gap_cos = vectors_from::<S>(&self.candidates.gap_cos, slot, blocks);
            let gap_sin = vectors_from::<S>(&self.candidates.gap_sin, slot, blocks);
            let depth = vectors_from::<S>(&self.candidates.depth, slot, blocks);
            let readings = &mut *self.readings;
            let penetration = vectors_from_mut::<S>(&mut readings.penetration, slot, blocks);
            let rate = vectors_from_mut::<S>(&mut readings.rate, slot, blocks);
            let force = vectors_from::<S>(&self.candidates.force, slot, blocks);
            let friction = vectors_from::<S>(&self.candidates.friction, slot, blocks);
            let on_bushing = both_mut::<S>(&mut readings.on_bushing, slot, blocks);
            let number = vectors_from_mut::<S>(&mut readings.surface, slot, blocks);
            let on_left = vectors_from_mut::<S>(&mut readings.left, slot, blocks);
            for b in 0..blocks {
                let at = |array: &[S::f64s]| load(simd, &array[b]);
                let [x, y] = [at(bushing[0]) - center[0], at(bushing[1]) - center[1]];
                let place = gaps.place([x, y], direction, [at(gap_cos), at(gap_sin)]);
                let surface = gaps.nearest(&place);
                let (found, [nx, ny], _) = gaps.depth(&surface, &place);
                // Without contact in the last evaluation, a positive penetration is a rounding error and is set to zero.
                let apart = -(-found).positive_part();
                let depth = at(depth);
                let far = (x * x + y * y).greater(reach_squared);
                let signed = depth.exceeds(zero).select(depth, apart);
                penetration[b] = far.select(out_of_reach, signed).values();
                let vx = spin.mul_add(y, at(velocity[0]) - own[0]);
                let vy = spin.negate_mul_add(x, at(velocity[1]) - own[1]);
                rate[b] = nx.mul_add(vx, ny * vy).values();
                let (force, friction) = (at(force), at(friction));
                on_bushing[0][b] = (friction * ny - force * nx).values();
                on_bushing[1][b] = (-(force * ny) - friction * nx).values();
                let (which, left) = gaps.surface(&surface, &place);
                number[b] = which.values();
                on_left[b] = left.select(one, zero).values();
            }
        }
    }
}

impl Kernels {
    /// Evaluate with the sprockets at the positions of `motion` and everything else at `y`; write accelerations into `rates`.
    pub(crate) fn evaluate_placed(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        (motion, t): (&Motion, f64),
        y: &[f64],
        rates: &mut [f64],
    ) {
        self.place_sprockets_as(model, motion);
        self.write_gaps(false);
        self.accelerate_placed(model, memory, t, y, rates);
    }

    /// Evaluate contacts without accelerations: hinges and rollers, and on request `teeth`.
    pub(crate) fn evaluate_contacts(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        motion: &Motion,
        (y, rates): (&[f64], &mut [f64]),
        teeth: bool,
    ) {
        self.place_sprockets_as(model, motion);
        self.keep_powers(false);
        self.write_gaps(false);
        let moved_squared = self.evaluate_joints(model, memory, y, rates);
        if teeth {
            self.evaluate_all_teeth(model, memory, (y, moved_squared), rates);
        }
        self.put_bristles(model, rates);
    }

    /// Write positions and velocities of the sprockets from `motion`.
    fn place_sprockets_as(&mut self, model: &Model, motion: &Motion) {
        let angles = self.chain.sprocket_angle.iter_mut();
        for (s, (pose, angle)) in self.poses.iter_mut().zip(angles).enumerate() {
            let body = model.wheel_body(s);
            *pose = SprocketPose {
                center: [motion.x[body], motion.y[body]],
                velocity: [motion.vx[body], motion.vy[body]],
                angle: motion.angle[body],
                spin: motion.spin[body],
                direction: [1.0, 0.0],
            };
            *angle = pose.angle;
        }
    }

    /// Return the arrays of links and hinges of the last evaluation.
    pub(crate) fn chain(&self) -> &ChainArrays {
        &self.chain
    }

    /// Return the arrays of the rollers of the last evaluation.
    pub(crate) fn rollers(&self) -> Option<&ChainArrays> {
        self.rollers.as_ref().map(|rollers| &rollers.arrays)
    }

    /// Return force and moment of the chain on every sprocket at the last evaluation.
    pub(crate) fn sprocket_loads(&self) -> &[SprocketLoad] {
        &self.loads
    }

    /// Return the force of the chain on both ends of an open chain at the last evaluation \[N\].
    pub(crate) fn forces_on_ends(&self, model: &Model) -> Option<[Vec2; 2]> {
        model.ends.as_ref().map(|ends| self.on_ends(ends))
    }

    /// Write the contact quantities of the candidates of sprocket `s` at the last evaluation into `readings`.
    pub(crate) fn read_teeth(
        &self,
        model: &Model,
        s: usize,
        readings: &mut ToothReadings,
    ) -> &SprocketCandidates {
        let candidates = &self.candidates.sprockets[s];
        macro_rules! read {
            ($constants:expr) => {
                self.instructions.run(ReadTeeth {
                    constants: $constants,
                    pose: &self.poses[s],
                    arrays: on_teeth(&self.chain, self.rollers.as_deref()),
                    candidates,
                    reach: model.sprockets[s].reach,
                    readings,
                })
            };
        }
        match &self.teeth[self.kind[s]].form {
            GapForm::Ansi(gap) => read!(&**gap),
            GapForm::Table(gap) => read!(gap),
        }
        candidates
    }
}

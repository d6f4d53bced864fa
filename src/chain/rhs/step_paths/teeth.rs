//! Kernel of the teeth: penetrations of the candidates of one sprocket at the end of a step, with their derivatives.

use pulp::{Simd, WithSimd};

use super::{BodyMotion, Ends};
use crate::chain::contact::SprocketCandidates;
use crate::chain::rhs::gap::{Gap, GapConstants};
use crate::chain::rhs::pose::SprocketPose;
use crate::math::simd::{
    Lanes, Numbers, both, both_mut, lane_numbers, load, splat_two, vectors, vectors_mut,
};

/// Kernel of the candidates of one sprocket.
pub(super) struct TraceTeeth<'a, C> {
    pub(super) constants: &'a C,
    pub(super) pose: &'a SprocketPose,
    /// Acceleration of the sprocket's centre \[m/s²\], and d²θ/dt² \[rad/s²\].
    pub(super) acceleration: [f64; 2],
    pub(super) spin_rate: f64,
    /// Bushings or rollers.
    pub(super) bodies: &'a BodyMotion,
    /// Their radius, where teeth have friction.
    pub(super) friction_radius: Option<f64>,
    pub(super) candidates: &'a SprocketCandidates,
    pub(super) ends: &'a mut Ends,
    /// Law constants of the surfaces.
    pub(super) law: &'a mut [Numbers; 2],
}

impl<C: GapConstants> WithSimd for TraceTeeth<'_, C> {
    type Output = ();

    #[allow(clippy::too_many_lines)] // a line for each of many fields
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let splat = |value| Lanes::splat(simd, value);
        let (zero, one) = (splat(0.0), splat(1.0));
        let gaps = self.constants.gap(simd);
        let center = splat_two(simd, self.pose.center);
        let own = splat_two(simd, self.pose.velocity);
        let own_acceleration = splat_two(simd, self.acceleration);
        let direction = splat_two(simd, self.pose.direction);
        let (spin, spin_rate) = (splat(self.pose.spin), splat(self.spin_rate));
        let (twice, squared) = (spin + spin, spin * spin);
        let Ends {
            penetration: [depth, rate, acceleration],
            lever: [lever, lever_rate],
            surface: number,
            slip: [slip, slip_rate],
            friction_lever,
        } = self.ends;
        for run in &self.candidates.runs {
            let (slot, blocks) = (run.slot, run.length.div_ceil(S::F64_LANES));
            let place = both::<S>(&self.bodies.place, run.first, blocks);
            let velocity = both::<S>(&self.bodies.velocity, run.first, blocks);
            let accelerations = both::<S>(&self.bodies.acceleration, run.first, blocks);
            let spins = both::<S>(&self.bodies.spin, run.first, blocks);
            let gap_cos = vectors::<S>(&self.candidates.gap_cos[slot..], blocks);
            let gap_sin = vectors::<S>(&self.candidates.gap_sin[slot..], blocks);
            let law = both_mut::<S>(self.law, slot, blocks);
            let depth = vectors_mut::<S>(&mut depth[slot..], blocks);
            let rate_at = vectors_mut::<S>(&mut rate[slot..], blocks);
            let acceleration = vectors_mut::<S>(&mut acceleration[slot..], blocks);
            let lever = vectors_mut::<S>(&mut lever[slot..], blocks);
            let lever_rate = vectors_mut::<S>(&mut lever_rate[slot..], blocks);
            let number = vectors_mut::<S>(&mut number[slot..], blocks);
            for b in 0..blocks {
                let at = |array: &[S::f64s]| load(simd, &array[b]);
                let left = splat((run.length - b * S::F64_LANES) as f64);
                let valid = lane_numbers(simd).less(left);
                let [x, y] = [at(place[0]) - center[0], at(place[1]) - center[1]];
                // Velocity and acceleration relative to the rotating sprocket, with its Coriolis and centrifugal terms.
                let vx = spin.mul_add(y, at(velocity[0]) - own[0]);
                let vy = spin.negate_mul_add(x, at(velocity[1]) - own[1]);
                let ax = spin_rate.mul_add(y, at(accelerations[0]) - own_acceleration[0]);
                let ax = twice.mul_add(vy, squared.mul_add(x, ax));
                let ay = spin_rate.negate_mul_add(x, at(accelerations[1]) - own_acceleration[1]);
                let ay = twice.negate_mul_add(vx, squared.mul_add(y, ay));
                let place = gaps.place([x, y], direction, [at(gap_cos), at(gap_sin)]);
                let surface = gaps.nearest(&place);
                let (found, [nx, ny], curvature) = gaps.depth(&surface, &place);
                let rate = nx.mul_add(vx, ny * vy);
                let across = nx.mul_add(vy, -(ny * vx));
                // The normal turns at κ t · v: d²δ/dt² = n · a + κ (t · v)².
                let turning = curvature * across;
                let towards = turning.mul_add(across, nx.mul_add(ax, ny * ay));
                depth[b] = valid.select(found, zero).values();
                rate_at[b] = valid.select(rate, zero).values();
                acceleration[b] = valid.select(towards, zero).values();
                // Lever arm l = r × n of the force, with dl/dt = κ (t · v) r · n - t · v.
                let radial = x.mul_add(nx, y * ny);
                let arm = x.mul_add(ny, -(y * nx));
                let arm_rate = turning.mul_add(radial, -across);
                lever[b] = valid.select(arm, zero).values();
                lever_rate[b] = valid.select(arm_rate, zero).values();
                let (which, _) = gaps.surface(&surface, &place);
                number[b] = valid.select(which, zero).values();
                let [first, second] = gaps.law_constants(&surface);
                law[0][b] = valid.select(first, one).values();
                law[1][b] = valid.select(second, one).values();
                if let Some(radius) = self.friction_radius {
                    let radius = splat(radius);
                    let sliding = radius.mul_add(at(spins[0]) - spin, across);
                    let across_rate = nx.mul_add(ay, -(ny * ax)) - turning * rate;
                    let sliding_rate = radius.mul_add(at(spins[1]) - spin_rate, across_rate);
                    let put = |array: &mut Numbers, value: Lanes<S>| {
                        vectors_mut::<S>(&mut array[slot..], blocks)[b] =
                            valid.select(value, zero).values();
                    };
                    put(slip, sliding);
                    put(slip_rate, sliding_rate);
                    put(friction_lever, radial + radius);
                }
            }
        }
    }
}

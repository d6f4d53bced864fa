//! Contacts between the candidates of one sprocket and its teeth: surface, penetration, force.

mod run;

use pulp::{Simd, WithSimd};

use super::bristles::Bristling;
use super::gap::{Gap, GapConstants, InGap};
use crate::chain::arrays::layout::{ChainArrays, LinkConstants};
use crate::chain::arrays::pose::SprocketPose;
use crate::chain::arrays::slopes::{ContactSlopes, group_of};
use crate::chain::contact::{BushingRun, SprocketCandidates};
use crate::chain::model::SprocketModel;
use crate::force_law::{
    ContactLane, ElasticLaw, Form, Friction, RegularizedFriction, RestitutionDamping,
};
use crate::math::simd::{
    Lanes, Mask, Numbers, PartialSums, WIDTH, lane_numbers, load, no_lane, splat_two,
};
use run::RunOfBushings;

/// Loads of the chain on a sprocket, and the other results of the loop over its teeth.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct TeethFound {
    /// Force on the sprocket \[N\].
    pub(crate) force: [f64; 2],
    /// Moment about its centre \[N m\].
    pub(crate) moment: f64,
    /// Whether the contact state of a candidate differs from the impact velocity memory: contact without memory, or memory without
    /// contact.
    pub(crate) changed: bool,
    /// Power dissipated by damping \[W\], if requested.
    pub(crate) dissipated: f64,
    /// Power dissipated by friction \[W\], if requested.
    pub(crate) friction_power: f64,
}

/// Friction on teeth.
#[derive(Clone, Copy)]
pub(crate) struct ToothFriction<'a> {
    pub(crate) law: &'a Friction,
    pub(crate) bushing_radius: f64,
}

/// Kernel of the candidates of one sprocket; constant parameters as of `EvaluateHinges`.
pub(crate) struct EvaluateTeeth<
    'a,
    C,
    const DAMPED: bool,
    const FRICTION: bool,
    const BRISTLED: bool,
> {
    /// Form of the elastic law.
    pub(crate) form: Form,
    pub(crate) sprocket: &'a SprocketModel,
    pub(crate) constants: &'a C,
    /// Whether a contact keeps the stiffness of its onset.
    pub(crate) keeps_stiffness: bool,
    pub(crate) pose: &'a SprocketPose,
    pub(crate) lambda: f64,
    pub(crate) minimum: f64,
    pub(crate) links: &'a LinkConstants,
    pub(crate) arrays: &'a mut ChainArrays,
    pub(crate) candidates: &'a mut SprocketCandidates,
    /// Whether the dissipated powers and their slopes are requested.
    pub(crate) powers: bool,
    /// Output for the slopes of the forces and of friction, slot by slot, if requested.
    pub(crate) slopes: Option<&'a mut ContactSlopes>,
    /// Signed depths and their rates for the event screening, slot by slot, and whether to write them.
    pub(crate) ends: &'a mut [Numbers; 2],
    pub(crate) writes_ends: bool,
    /// Friction for `FRICTION`.
    pub(crate) friction: Option<ToothFriction<'a>>,
    /// Bristles for `BRISTLED`, slot by slot.
    pub(crate) bristles: Option<Bristling<'a>>,
}

impl<C: GapConstants, const DAMPED: bool, const FRICTION: bool, const BRISTLED: bool> WithSimd
    for EvaluateTeeth<'_, C, DAMPED, FRICTION, BRISTLED>
{
    type Output = TeethFound;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> TeethFound {
        let splat = |value| Lanes::splat(simd, value);
        let mut teeth = Teeth::<S, C::Of<'_, S>, DAMPED, FRICTION, BRISTLED> {
            form: self.form,
            gap: self.constants.gap(simd),
            center: splat_two(simd, self.pose.center),
            velocity: splat_two(simd, self.pose.velocity),
            direction: splat_two(simd, self.pose.direction),
            spin: splat(self.pose.spin),
            damping: RestitutionDamping {
                lambda: splat(self.lambda),
                minimum: splat(self.minimum),
            },
            keeps_stiffness: self.keeps_stiffness,
            powers: self.powers,
            writes_ends: self.writes_ends,
            changed: no_lane(simd),
            sums: [PartialSums::default(); 4],
            friction_power: PartialSums::default(),
            regularized: None,
        };
        if FRICTION
            && !BRISTLED
            && let Some(friction) = &self.friction
        {
            teeth.regularized = Some((
                RegularizedFriction::new(simd, friction.law),
                splat(friction.bushing_radius),
            ));
        }
        for number in 0..self.candidates.runs.len() {
            let BushingRun { length, slot, .. } = self.candidates.runs[number];
            let mut run = RunOfBushings::<S>::of::<FRICTION>(
                number,
                self.links,
                &mut *self.arrays,
                &mut *self.candidates,
                self.slopes.as_deref_mut(),
                &mut *self.ends,
            );
            if BRISTLED && let Some(bristles) = &mut self.bristles {
                run.friction_arrays.bristles = Some(bristles.lanes(simd, slot, run.depth.len()));
            }
            let mut left = splat(length as f64);
            for b in 0..length.div_ceil(S::F64_LANES) {
                let valid = lane_numbers(simd).less(left);
                left = left - splat(S::F64_LANES as f64);
                let arm = teeth.arm(b, &run);
                let mut place = teeth.place(b, arm, &run);
                // Some bushing is nearer to an adjacent gap: assign the gaps of this vector again.
                if teeth.gap.left(&place).and(valid).any() {
                    run.assign_gaps(self.sprocket, self.pose, b, length);
                    place = teeth.place(b, arm, &run);
                }
                teeth.touch(b, arm, &place, valid, &mut run);
            }
            // Newton's matrix reads whole groups.
            for b in length.div_ceil(S::F64_LANES)..length.next_multiple_of(WIDTH) / S::F64_LANES {
                run.clear_slopes(b, splat(0.0));
            }
        }
        let [x, y, moment, dissipated] = &teeth.sums;
        TeethFound {
            force: [x.total(), y.total()],
            moment: moment.total(),
            changed: teeth.changed.any(),
            dissipated: dissipated.total_if(self.powers && DAMPED),
            friction_power: teeth.friction_power.total_if(self.powers && FRICTION),
        }
    }
}

/// Teeth of a sprocket in SIMD vectors, and sums over their contacts.
struct Teeth<S: Simd, G, const DAMPED: bool, const FRICTION: bool, const BRISTLED: bool> {
    form: Form,
    gap: G,
    center: [Lanes<S>; 2],
    velocity: [Lanes<S>; 2],
    direction: [Lanes<S>; 2],
    spin: Lanes<S>,
    damping: RestitutionDamping<Lanes<S>>,
    keeps_stiffness: bool,
    /// Whether powers are requested.
    powers: bool,
    writes_ends: bool,
    /// Candidates whose contact state differs from the impact velocity memory.
    changed: Mask<S>,
    /// Force x, y \[N\], moment \[N m\], power dissipated \[W\].
    sums: [PartialSums; 4],
    /// Power dissipated by friction \[W\].
    friction_power: PartialSums,
    /// Friction and the bushings' radius; `Some` for `FRICTION` without bristles.
    regularized: Option<(RegularizedFriction<Lanes<S>>, Lanes<S>)>,
}

impl<S: Simd, G: Gap<S>, const DAMPED: bool, const FRICTION: bool, const BRISTLED: bool>
    Teeth<S, G, DAMPED, FRICTION, BRISTLED>
{
    /// Return the positions of bushings relative to the sprocket's centre \[m\].
    #[inline(always)]
    fn arm(&self, b: usize, run: &RunOfBushings<S>) -> [Lanes<S>; 2] {
        let simd = self.spin.simd();
        [
            load(simd, &run.bushing[0][b]) - self.center[0],
            load(simd, &run.bushing[1][b]) - self.center[1],
        ]
    }

    /// Return the bushings in the frames of the gaps of the last evaluation.
    #[inline(always)]
    fn place(&self, b: usize, arm: [Lanes<S>; 2], run: &RunOfBushings<S>) -> InGap<S> {
        let simd = self.spin.simd();
        let gap = [load(simd, &run.gap_cos[b]), load(simd, &run.gap_sin[b])];
        self.gap.place(arm, self.direction, gap)
    }

    /// Evaluate one vector of bushings: penetration, force, and the loads on links and sprocket.
    #[inline(always)]
    fn touch(
        &mut self,
        b: usize,
        [arm_x, arm_y]: [Lanes<S>; 2],
        place: &InGap<S>,
        valid: Mask<S>,
        run: &mut RunOfBushings<S>,
    ) {
        let at = |array: &[S::f64s]| load(arm_x.simd(), &array[b]);
        let zero = arm_x.constant(0.0);
        let surface = self.gap.nearest(place);
        // Every surface is fixed in the sprocket. The velocity of the sprocket's point at the bushing's centre gives the penetration
        // rate on every surface.
        let vx = self
            .spin
            .mul_add(arm_y, at(run.velocity[0]) - self.velocity[0]);
        let vy = self
            .spin
            .negate_mul_add(arm_x, at(run.velocity[1]) - self.velocity[1]);
        if self.writes_ends {
            let [found, change] = self.gap.gap_and_rate(&surface, place, [vx, vy]);
            run.ends[0][b] = found.values();
            // A rate of zero: no event behind the last bushing of the run.
            run.ends[1][b] = valid.select(change, zero).values();
        }
        let near = self.gap.near(&surface).and(valid);
        let inverse_impact_velocity = at(run.inverse_impact_velocity);
        let remembered = inverse_impact_velocity.greater(zero);
        if !near.any() {
            self.changed = self.changed.or(remembered);
            self.write_apart(b, zero, run);
            return;
        }
        let (depth, [nx, ny], curvature) = self.gap.depth(&surface, place);
        let depth = near.select(depth.positive_part(), zero);
        let touching = depth.exceeds(zero);
        self.changed = self.changed.or(touching.differs(remembered));

        let mut law_constants = self.gap.law_constants(&surface);
        if self.keeps_stiffness {
            law_constants[0] = remembered.select(at(run.kept_constants[0]), law_constants[0]);
            law_constants[1] = remembered.select(at(run.kept_constants[1]), law_constants[1]);
        }
        let [elastic, root] = self.form.elastic_and_root(law_constants, depth);
        let mut across = zero;
        let contact = if DAMPED {
            if FRICTION {
                across = nx.mul_add(vy, -(ny * vx));
            }
            let rate = nx.mul_add(vx, ny * vy);
            ContactLane::damped(
                elastic,
                touching,
                rate,
                inverse_impact_velocity,
                self.damping,
            )
        } else {
            ContactLane::undamped(elastic)
        };
        let force = contact.force;
        if DAMPED && self.powers {
            self.sums[3].add(b, contact.power());
        }
        if let Some(slopes) = &mut run.slopes {
            let alone = self.form.slope(law_constants, depth, [elastic, root]);
            let [stiffness, damping] = contact.slopes(alone);
            let entries = [nx, ny, force, stiffness, damping, curvature];
            let (group, part) = group_of::<S, _>(slopes, b);
            group.put(part, entries);
            if self.powers {
                let power = contact.power_slopes(alone, [stiffness, damping]);
                group.put_power(part, power);
            }
        }
        run.depth[b] = depth.values();
        run.force[b] = force.values();
        self.push(b, [arm_x, arm_y], [nx, ny], [force, across], run);
    }

    /// Write `zero` for a vector of bushings without contact.
    #[inline(always)]
    fn write_apart(&self, b: usize, zero: Lanes<S>, run: &mut RunOfBushings<S>) {
        run.depth[b] = zero.values();
        run.force[b] = zero.values();
        run.clear_slopes(b, zero);
        if self.powers
            && let Some(slopes) = &mut run.slopes
        {
            let (group, part) = group_of::<S, _>(slopes, b);
            group.put_power(part, [zero; 2]);
        }
        if FRICTION {
            run.friction_arrays.friction[b] = zero.values();
        }
        if BRISTLED && let Some(bristles) = &mut run.friction_arrays.bristles {
            bristles.clear_rates(b);
        }
    }

    /// Add the forces of a vector of bushings to links and sprocket; `across`: sliding velocity of the bushings' centres.
    #[inline(always)]
    fn push(
        &mut self,
        b: usize,
        [arm_x, arm_y]: [Lanes<S>; 2],
        [nx, ny]: [Lanes<S>; 2],
        [force, across]: [Lanes<S>; 2],
        run: &mut RunOfBushings<S>,
    ) {
        let at = |array: &[S::f64s]| load(arm_x.simd(), &array[b]);
        let zero = force.constant(0.0);
        let (mut push_x, mut push_y) = (force * nx, force * ny);
        let mut spun = zero;
        if FRICTION {
            let friction;
            [friction, spun] = self.slide(b, force, across, run);
            push_x = push_x - friction * ny;
            push_y = friction.mul_add(nx, push_y);
        }
        self.sums[0].add(b, push_x);
        self.sums[1].add(b, push_y);
        // Moment about the sprocket's centre: arm × force.
        let mut moment = arm_x.mul_add(push_y, -(arm_y * push_x));
        if FRICTION {
            moment = moment + spun;
        }
        self.sums[2].add(b, moment);
        let on_front = at(run.on_front).greater(zero);
        let (front_x, front_y) = (on_front.select(push_x, zero), on_front.select(push_y, zero));
        run.front_force[0][b] = (at(run.front_force[0]) - front_x).values();
        run.front_force[1][b] = (at(run.front_force[1]) - front_y).values();
        run.rear_force[0][b] = (at(run.rear_force[0]) - (push_x - front_x)).values();
        run.rear_force[1][b] = (at(run.rear_force[1]) - (push_y - front_y)).values();
    }

    /// Return the friction on the sprocket \[N\] for bushings whose centres slide with `across`, and its moment about a bushing \[N
    /// m\]. The bushings receive the opposite moment.
    #[inline(always)]
    fn slide(
        &mut self,
        b: usize,
        force: Lanes<S>,
        across: Lanes<S>,
        run: &mut RunOfBushings<S>,
    ) -> [Lanes<S>; 2] {
        let simd = force.simd();
        let zero = force.constant(0.0);
        let radius = if BRISTLED {
            let bristles = run.friction_arrays.bristles.as_ref();
            bristles.map(|bristles| bristles.radius)
        } else {
            self.regularized.map(|(_, radius)| radius)
        };
        let Some(radius) = radius else {
            return [zero; 2];
        };
        // The contact point is the bushing's outermost point: sliding velocity = across + radius (ω_bushing - ω_sprocket).
        let spin = load(simd, &run.friction_arrays.spin[b]);
        let slip = radius.mul_add(spin - self.spin, across);
        let [friction, slope] =
            if BRISTLED && let Some(bristles) = &mut run.friction_arrays.bristles {
                let touching = load(simd, &run.depth[b]).exceeds(zero);
                bristles.bend(b, touching, force, slip)
            } else if let Some((friction, _)) = &self.regularized {
                friction.force(force, slip)
            } else {
                [zero; 2]
            };
        if self.powers {
            self.friction_power.add(b, friction * slip);
        }
        run.friction_arrays.friction[b] = friction.values();
        if let Some(slopes) = &mut run.friction_arrays.slopes {
            let (group, part) = group_of::<S, _>(slopes, b);
            group.slope.put(part, slope);
            group.slip.put(part, slip);
        }
        let moment = radius * friction;
        let on_front = load(simd, &run.on_front[b]).greater(zero);
        let front = on_front.select(moment, zero);
        let [fronts, rears] = &mut run.friction_arrays.moments;
        fronts[b] = (load(simd, &fronts[b]) - front).values();
        rears[b] = (load(simd, &rears[b]) - (moment - front)).values();
        [friction, moment]
    }
}

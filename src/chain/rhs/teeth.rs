//! Contacts between the candidates of one sprocket and its teeth: surface, penetration, force.

use std::marker::PhantomData;

use pulp::{Simd, WithSimd};

use super::bristles::{BristleLanes, Bristling};
use super::gap::{Gap, GapConstants, InGap};
use super::layout::{ChainArrays, FIRST, LinkConstants};
use super::slopes::{FrictionGroup, SlopeGroup, group_of};
use crate::chain::contact::{Run, SprocketCandidates, gap_of};
use crate::chain::dynamics::Moves;
use crate::chain::model::SprocketModel;
use crate::force_law::{
    ContactLane, ElasticLaw, Friction, RegularizedFriction, RestitutionDamping,
};
use crate::geometry::Vec2;
use crate::math::simd::{
    Lanes, Mask, PartialSums, WIDTH, both, both_mut, lane_numbers, load, splat_two, vectors,
    vectors_mut,
};

/// Position and velocity of a sprocket.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SprocketPose {
    /// Centre \[m\].
    pub(crate) center: [f64; 2],
    /// Velocity of the centre \[m/s\].
    pub(crate) velocity: [f64; 2],
    /// Angle \[rad\].
    pub(crate) angle: f64,
    /// Angular velocity \[rad/s\].
    pub(crate) spin: f64,
    /// Cosine and sine of the angle.
    pub(crate) direction: [f64; 2],
}

impl SprocketPose {
    /// Return the same as the type of the scalar code.
    pub(crate) fn moves(&self) -> Moves {
        Moves {
            center: self.center.into(),
            velocity: self.velocity.into(),
            angle: self.angle,
            spin: self.spin,
        }
    }
}

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
    pub(crate) rubbed: f64,
}

/// Friction on teeth.
#[derive(Clone, Copy)]
pub(crate) struct ToothFriction<'a> {
    pub(crate) law: &'a Friction,
    pub(crate) bushing_radius: f64,
}

/// Kernel of the candidates of one sprocket, one instance per contact law; constant parameters as of `JoinChain`.
pub(crate) struct TouchTeeth<
    'a,
    C,
    L,
    const DAMPED: bool,
    const RUBBED: bool,
    const BRISTLED: bool,
    const ENERGY: bool,
> {
    pub(crate) law: PhantomData<L>,
    pub(crate) sprocket: &'a SprocketModel,
    pub(crate) constants: &'a C,
    /// Whether a contact keeps the stiffness of its onset.
    pub(crate) keeps_stiffness: bool,
    pub(crate) pose: &'a SprocketPose,
    pub(crate) lambda: f64,
    pub(crate) floor: f64,
    pub(crate) links: &'a LinkConstants,
    pub(crate) arrays: &'a mut ChainArrays,
    pub(crate) candidates: &'a mut SprocketCandidates,
    /// Output for the slopes of the forces, slot by slot, if requested.
    pub(crate) slopes: Option<&'a mut [SlopeGroup]>,
    /// Output for the slopes of friction, if requested.
    pub(crate) rubs: Option<&'a mut [FrictionGroup]>,
    /// Friction for `RUBBED`.
    pub(crate) friction: Option<ToothFriction<'a>>,
    /// Bristles for `BRISTLED`, slot by slot.
    pub(crate) bristles: Option<Bristling<'a>>,
}

impl<
    C: GapConstants,
    L: ElasticLaw,
    const DAMPED: bool,
    const RUBBED: bool,
    const BRISTLED: bool,
    const ENERGY: bool,
> WithSimd for TouchTeeth<'_, C, L, DAMPED, RUBBED, BRISTLED, ENERGY>
{
    type Output = TeethFound;

    #[allow(clippy::too_many_lines)] // a line for each of many fields
    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> TeethFound {
        let splat = |value| Lanes::splat(simd, value);
        let mut teeth = Teeth::<S, C::Of<'_, S>, L, DAMPED, RUBBED, BRISTLED, ENERGY> {
            law: PhantomData,
            gap: self.constants.gap(simd),
            center: splat_two(simd, self.pose.center),
            velocity: splat_two(simd, self.pose.velocity),
            direction: splat_two(simd, self.pose.direction),
            spin: splat(self.pose.spin),
            damping: RestitutionDamping {
                lambda: splat(self.lambda),
                floor: splat(self.floor),
            },
            keeps_stiffness: self.keeps_stiffness,
            changed: false,
            sums: [PartialSums::default(); 4],
            rubbed: PartialSums::default(),
            rubbing: None,
        };
        if RUBBED
            && !BRISTLED
            && let Some(friction) = &self.friction
        {
            teeth.rubbing = Some((
                RegularizedFriction::new(simd, friction.law),
                splat(friction.bushing_radius),
            ));
        }
        let SprocketCandidates {
            runs,
            gap,
            gap_cos,
            gap_sin,
            inverse_onset,
            kept_constants,
            depth,
            force,
            friction,
        } = self.candidates;
        let slopes = &mut self.slopes;
        let mut rubs = if RUBBED { self.rubs } else { None };
        let ChainArrays {
            front_force,
            rear_force,
            bushing,
            bushing_velocity,
            front_moment,
            rear_moment,
            bushing_spin,
            ..
        } = self.arrays;
        for &Run {
            first,
            length,
            slot,
        } in &*runs
        {
            let blocks = length.div_ceil(S::F64_LANES);
            let mut run = RunOfBushings::<S> {
                bushing: both::<S>(bushing, first, blocks),
                velocity: both::<S>(bushing_velocity, first, blocks),
                on_front: vectors::<S>(&self.links.bushing_on_front[first..], blocks),
                inverse_onset: vectors::<S>(&inverse_onset[slot..], blocks),
                kept_constants: both::<S>(kept_constants, slot, blocks),
                depth: vectors_mut::<S>(&mut depth[slot..], blocks),
                force: vectors_mut::<S>(&mut force[slot..], blocks),
                front_force: both_mut::<S>(front_force, first, blocks),
                rear_force: both_mut::<S>(rear_force, FIRST + 1 + first, blocks),
                slopes: slopes.as_mut().map(|slopes| &mut slopes[slot / WIDTH..]),
                rubbed: RubbedRun::none(),
            };
            if RUBBED {
                let moments = [
                    &mut front_moment[first..],
                    &mut rear_moment[FIRST + 1 + first..],
                ];
                let slopes = rubs.as_mut().map(|rubs| &mut rubs[slot / WIDTH..]);
                run.rubbed = RubbedRun::of(&bushing_spin[first..], moments, slopes, blocks);
                run.rubbed.friction = vectors_mut::<S>(&mut friction[slot..], blocks);
            }
            if BRISTLED && let Some(bristles) = &mut self.bristles {
                run.rubbed.bristles = Some(bristles.lanes(simd, slot, blocks));
            }
            let (gap_cos, gap_sin) = (&mut gap_cos[slot..], &mut gap_sin[slot..]);
            for b in 0..blocks {
                let from = b * S::F64_LANES;
                let valid = lane_numbers(simd).less(splat((length - from) as f64));
                let arm = teeth.arm(b, &run);
                let mut place = teeth.place(b, arm, gap_cos, gap_sin);
                // Some bushing is nearer to an adjacent gap: assign the gaps of this vector again.
                if teeth.gap.left(&place).and(valid).any() {
                    for j in from..length.min(from + S::F64_LANES) {
                        let arm = Vec2::new(bushing[0][first + j], bushing[1][first + j])
                            - Vec2::from(self.pose.center);
                        let number = gap_of(self.sprocket, arm, self.pose.direction);
                        gap[slot + j] = number;
                        (gap_cos[j], gap_sin[j]) = self.sprocket.gap_directions[number as usize];
                    }
                    place = teeth.place(b, arm, gap_cos, gap_sin);
                }
                teeth.touch(b, arm, &place, valid, &mut run);
            }
        }
        let [x, y, moment, dissipated] = &teeth.sums;
        TeethFound {
            force: [x.total(), y.total()],
            moment: moment.total(),
            changed: teeth.changed,
            dissipated: dissipated.total(),
            rubbed: teeth.lost_to_friction(),
        }
    }
}

/// Arrays of one run in SIMD vectors.
struct RunOfBushings<'a, S: Simd> {
    bushing: [&'a [S::f64s]; 2],
    velocity: [&'a [S::f64s]; 2],
    on_front: &'a [S::f64s],
    inverse_onset: &'a [S::f64s],
    kept_constants: [&'a [S::f64s]; 2],
    depth: &'a mut [S::f64s],
    force: &'a mut [S::f64s],
    front_force: [&'a mut [S::f64s]; 2],
    rear_force: [&'a mut [S::f64s]; 2],
    slopes: Option<&'a mut [SlopeGroup]>,
    rubbed: RubbedRun<'a, S>,
}

/// Arrays of one run that friction reads and writes.
struct RubbedRun<'a, S: Simd> {
    spin: &'a [S::f64s],
    /// Moments on front and rear ends \[N m\].
    moments: [&'a mut [S::f64s]; 2],
    friction: &'a mut [S::f64s],
    slopes: Option<&'a mut [FrictionGroup]>,
    /// `Some` for `BRISTLED`.
    bristles: Option<BristleLanes<'a, S>>,
}

impl<'a, S: Simd> RubbedRun<'a, S> {
    /// Return the arrays from these bushings and ends on.
    #[inline(always)]
    fn of(
        spin: &'a [f64],
        [front, rear]: [&'a mut [f64]; 2],
        slopes: Option<&'a mut [FrictionGroup]>,
        blocks: usize,
    ) -> Self {
        Self {
            spin: vectors::<S>(spin, blocks),
            moments: [
                vectors_mut::<S>(front, blocks),
                vectors_mut::<S>(rear, blocks),
            ],
            friction: &mut [],
            slopes,
            bristles: None,
        }
    }

    /// Return empty arrays, for loops without friction.
    #[inline(always)]
    fn none() -> Self {
        Self {
            spin: &[],
            moments: [&mut [], &mut []],
            friction: &mut [],
            slopes: None,
            bristles: None,
        }
    }
}

/// Teeth of a sprocket in SIMD vectors, and sums over their contacts.
struct Teeth<
    S: Simd,
    G,
    L,
    const DAMPED: bool,
    const RUBBED: bool,
    const BRISTLED: bool,
    const ENERGY: bool,
> {
    law: PhantomData<L>,
    gap: G,
    center: [Lanes<S>; 2],
    velocity: [Lanes<S>; 2],
    direction: [Lanes<S>; 2],
    spin: Lanes<S>,
    damping: RestitutionDamping<Lanes<S>>,
    keeps_stiffness: bool,
    changed: bool,
    /// Force x, y \[N\], moment \[N m\], power dissipated \[W\].
    sums: [PartialSums; 4],
    /// Power dissipated by friction \[W\].
    rubbed: PartialSums,
    /// Friction and the bushings' radius; `Some` for `RUBBED` without bristles.
    rubbing: Option<(RegularizedFriction<Lanes<S>>, Lanes<S>)>,
}

impl<
    S: Simd,
    G: Gap<S>,
    L: ElasticLaw,
    const DAMPED: bool,
    const RUBBED: bool,
    const BRISTLED: bool,
    const ENERGY: bool,
> Teeth<S, G, L, DAMPED, RUBBED, BRISTLED, ENERGY>
{
    /// Return the power dissipated by friction \[W\], if requested.
    #[inline(always)]
    fn lost_to_friction(&self) -> f64 {
        if RUBBED && ENERGY {
            self.rubbed.total()
        } else {
            0.0
        }
    }

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
    fn place(&self, b: usize, arm: [Lanes<S>; 2], gap_cos: &[f64], gap_sin: &[f64]) -> InGap<S> {
        let simd = self.spin.simd();
        let gap = [
            load(simd, &vectors::<S>(gap_cos, b + 1)[b]),
            load(simd, &vectors::<S>(gap_sin, b + 1)[b]),
        ];
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
        let near = self.gap.near(&surface).and(valid);
        let inverse_onset = at(run.inverse_onset);
        let remembered = inverse_onset.greater(zero);
        if !near.any() {
            run.depth[b] = zero.values();
            run.force[b] = zero.values();
            if let Some(slopes) = &mut run.slopes {
                let (group, part) = group_of::<S, _>(slopes, b);
                group.put(part, [zero; 6]);
            }
            if RUBBED {
                run.rubbed.friction[b] = zero.values();
                if let Some(rubs) = &mut run.rubbed.slopes {
                    let (group, part) = group_of::<S, _>(rubs, b);
                    group.slope.put(part, zero);
                }
            }
            if BRISTLED && let Some(bristles) = &mut run.rubbed.bristles {
                bristles.rest(b);
            }
            self.changed |= remembered.any();
            return;
        }
        let (depth, [nx, ny], curvature) = self.gap.depth(&surface, place);
        let depth = near.select(depth.positive_part(), zero);
        let touching = depth.exceeds(zero);
        self.changed |= touching.differs(remembered).any();

        let mut pair = self.gap.law_constants(&surface);
        if self.keeps_stiffness {
            pair[0] = remembered.select(at(run.kept_constants[0]), pair[0]);
            pair[1] = remembered.select(at(run.kept_constants[1]), pair[1]);
        }
        let elastic = L::elastic(pair, depth);
        let mut across = zero;
        let contact = if DAMPED {
            // Every surface is fixed in the sprocket. The velocity of the sprocket's point at the bushing's centre gives the
            // penetration rate on every surface.
            let vx = self
                .spin
                .mul_add(arm_y, at(run.velocity[0]) - self.velocity[0]);
            let vy = self
                .spin
                .negate_mul_add(arm_x, at(run.velocity[1]) - self.velocity[1]);
            if RUBBED {
                across = nx.mul_add(vy, -(ny * vx));
            }
            let rate = nx.mul_add(vx, ny * vy);
            ContactLane::damped(elastic, touching, rate, inverse_onset, self.damping)
        } else {
            ContactLane::undamped(elastic)
        };
        let force = contact.force;
        if DAMPED && ENERGY {
            self.sums[3].add(b, contact.power());
        }
        if let Some(slopes) = &mut run.slopes {
            let [stiffness, damping] = contact.slopes(L::slope(pair, depth, elastic));
            let (group, part) = group_of::<S, _>(slopes, b);
            group.put(part, [nx, ny, force, stiffness, damping, curvature]);
        }
        run.depth[b] = depth.values();
        run.force[b] = force.values();
        self.push(b, [arm_x, arm_y], [nx, ny], [force, across], run);
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
        if RUBBED {
            let rub;
            [rub, spun] = self.slide(b, force, across, run);
            push_x = push_x - rub * ny;
            push_y = rub.mul_add(nx, push_y);
        }
        self.sums[0].add(b, push_x);
        self.sums[1].add(b, push_y);
        // Moment about the sprocket's centre: arm × force.
        let mut moment = arm_x.mul_add(push_y, -(arm_y * push_x));
        if RUBBED {
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
            let bristles = run.rubbed.bristles.as_ref();
            bristles.map(|bristles| bristles.radius)
        } else {
            self.rubbing.map(|(_, radius)| radius)
        };
        let Some(radius) = radius else {
            return [zero; 2];
        };
        // The contact point is the bushing's outermost point: sliding velocity = across + radius (ω_bushing - ω_sprocket).
        let spin = load(simd, &run.rubbed.spin[b]);
        let slip = radius.mul_add(spin - self.spin, across);
        let [rub, slope] = if BRISTLED && let Some(bristles) = &mut run.rubbed.bristles {
            let touching = load(simd, &run.depth[b]).exceeds(zero);
            bristles.bend(b, touching, force, slip)
        } else if let Some((friction, _)) = &self.rubbing {
            friction.force(force, slip)
        } else {
            [zero; 2]
        };
        if ENERGY {
            self.rubbed.add(b, rub * slip);
        }
        run.rubbed.friction[b] = rub.values();
        if let Some(slopes) = &mut run.rubbed.slopes {
            let (group, part) = group_of::<S, _>(slopes, b);
            group.slope.put(part, slope);
        }
        let moment = radius * rub;
        let on_front = load(simd, &run.on_front[b]).greater(zero);
        let front = on_front.select(moment, zero);
        let [fronts, rears] = &mut run.rubbed.moments;
        fronts[b] = (load(simd, &fronts[b]) - front).values();
        rears[b] = (load(simd, &rears[b]) - (moment - front)).values();
        [rub, moment]
    }
}

//! The chain in one pass: directions and ends of the links, hinges between them, and where the bushings are.

mod rollers;

use std::marker::PhantomData;

use pulp::{Simd, WithSimd};

use super::bristles::{BristleLanes, Bristling};
use super::layout::{ChainArrays, FIRST, LinkConstants};
use super::slopes::{Damped, FilmGroup, RubGroup, SlopeGroup, Touch, group_of};
use crate::force_law::{
    FilmLanes, Friction, FrictionLanes, HingeFilm, VectorLaw, depths_in_series,
};
use crate::vector::{
    Lanes, Mask, Numbers, PartialSums, WIDTH, both, both_mut, lane_numbers, load, partial_load,
    sin_cos, splat_two, vectors, vectors_mut, write,
};

pub(super) use rollers::{JoinRollers, Rollers};

/// What the chain found besides its forces.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ChainFound {
    /// Largest squared distance of a bushing from its reference \[m²\].
    pub(super) moved_squared: f64,
    /// Whether a hinge touches that has no memory, or has one and does not touch.
    pub(super) changed: bool,
    /// Power dissipated by damping \[W\], when asked for.
    pub(super) dissipated: f64,
    /// Power dissipated by friction \[W\], likewise.
    pub(super) rubbed: f64,
    /// Power dissipated by lubricant, likewise.
    pub(super) sheared: f64,
}

/// Friction in hinges, where there is any.
#[derive(Clone, Copy)]
pub(super) struct HingeFriction<'a> {
    pub(super) law: &'a Friction,
    pub(super) pin_radius: f64,
}

/// Lubricant in hinges, where there is any.
pub(super) struct FilledHinges<'a> {
    pub(super) film: &'a HingeFilm,
    /// Where its slopes go when they are asked for.
    pub(super) slopes: Option<&'a mut [FilmGroup]>,
}

/// One law, one loop. `DAMPED`: with the damping factor; `RUBBED`: with friction; `BRISTLED`: of bristles; `EXTRA`: with lubricant, elastic plates and friction, those
/// that there are; `ENERGY`: with the power that they dissipate.
pub(super) struct JoinChain<
    'a,
    L,
    const DAMPED: bool,
    const RUBBED: bool,
    const BRISTLED: bool,
    const EXTRA: bool,
    const ENERGY: bool,
> {
    pub(super) law: PhantomData<L>,
    pub(super) law_constants: [f64; 2],
    pub(super) clearance: f64,
    pub(super) lambda: f64,
    pub(super) floor: f64,
    /// x, y \[m\] and θ \[rad\] of the links.
    pub(super) places: [&'a [f64]; 3],
    /// Their rates.
    pub(super) speeds: [&'a [f64]; 3],
    /// 1/onset speed of every hinge \[s/m\]; zero without memory.
    pub(super) inverse_onset: &'a [f64],
    /// Where the bushings were when the candidates were chosen, x and y \[m\].
    pub(super) reference: &'a [Numbers; 2],
    /// How many bushings are needed again behind the last one.
    pub(super) overhang: usize,
    pub(super) constants: &'a LinkConstants,
    pub(super) arrays: &'a mut ChainArrays,
    /// Where the slopes of the forces go when they are asked for.
    pub(super) slopes: Option<&'a mut [SlopeGroup]>,
    /// Those of friction.
    pub(super) rubs: Option<&'a mut [RubGroup]>,
    /// What `RUBBED` needs.
    pub(super) friction: Option<HingeFriction<'a>>,
    /// What `BRISTLED` needs.
    pub(super) bristles: Option<Bristling<'a>>,
    /// What `EXTRA` needs.
    pub(super) lubricant: Option<FilledHinges<'a>>,
    /// What the plates give way by \[m/N\].
    pub(super) compliance: Option<f64>,
}

impl<
    L: VectorLaw,
    const DAMPED: bool,
    const RUBBED: bool,
    const BRISTLED: bool,
    const EXTRA: bool,
    const ENERGY: bool,
> WithSimd for JoinChain<'_, L, DAMPED, RUBBED, BRISTLED, EXTRA, ENERGY>
{
    type Output = ChainFound;

    #[allow(clippy::too_many_lines)] // a line for each of many fields
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> ChainFound {
        let n = self.places[0].len();
        let blocks = n.div_ceil(S::F64_LANES);
        let whole = blocks - 1;
        let splat = |value| Lanes::splat(simd, value);
        let arrays = self.arrays;
        point::<S>(simd, self.places[2], &mut arrays.cos, &mut arrays.sin);
        point_sprockets::<S>(simd, arrays);
        let mut hinges = Hinges::<S, L, DAMPED, RUBBED, BRISTLED, EXTRA, ENERGY> {
            law: PhantomData,
            law_constants: splat_two(simd, self.law_constants),
            clearance: splat(self.clearance),
            lambda: splat(self.lambda),
            floor: splat(self.floor),
            clearance_squared: vectors::<S>(&self.constants.clearance_squared, blocks),
            onset: vectors::<S>(self.inverse_onset, blocks),
            on_front: vectors::<S>(&self.constants.bushing_on_front, blocks),
            there: vectors::<S>(&self.constants.there, blocks),
            reference: both::<S>(self.reference, 0, blocks),
            depth: vectors_mut::<S>(&mut arrays.depth, blocks),
            force: vectors_mut::<S>(&mut arrays.force, blocks),
            distance_squared: vectors_mut::<S>(&mut arrays.distance_squared, blocks),
            along: vectors_mut::<S>(&mut arrays.along, blocks),
            moments: [&mut [], &mut []],
            front_force: both_mut::<S>(&mut arrays.front_force, 0, blocks),
            rear_force: both_mut::<S>(&mut arrays.rear_force, FIRST + 1, blocks),
            bushing: both_mut::<S>(&mut arrays.bushing, 0, blocks),
            bushing_velocity: both_mut::<S>(&mut arrays.bushing_velocity, 0, blocks),
            moved_squared: splat(0.0),
            changed: false,
            power: PartialSums::default(),
            rubbed: PartialSums::default(),
            slopes: self.slopes,
            rubs: None,
            rubbing: None,
            bristles: None,
            sheared: PartialSums::default(),
            film_slopes: None,
            film: None,
            compliance: None,
        };
        if RUBBED {
            hinges.moments = [
                vectors_mut::<S>(&mut arrays.front_moment, blocks),
                vectors_mut::<S>(&mut arrays.rear_moment[FIRST + 1..], blocks),
            ];
        }
        if BRISTLED && let Some(bristles) = self.bristles {
            hinges.bristles = Some(bristles.into_lanes(simd, blocks));
        }
        hinges.lay_in(self.friction, self.rubs, self.lubricant, self.compliance);
        let [x, y, _] = self.places;
        let [vx, vy, spin] = self.speeds;
        let links = [x, y, vx, vy, spin];
        let last = last_links(simd, links, whole * S::F64_LANES);
        let direction = [&arrays.cos[..], &arrays.sin[..]];
        let fronts = Links::<S>::of(links, 0, whole);
        let front_arms = Arms::<S>::of(&self.constants.front_arm, direction, 0, blocks);
        let rear_arms = Arms::<S>::of(&self.constants.rear_arm, direction, 1, blocks);
        if S::F64_LANES == WIDTH {
            // Wide registers that do not begin at a cache line are slow to load: the rear ends are moved on by one link.
            let last_lane = lane_numbers(simd).greater(splat(WIDTH as f64 - 1.5));
            let here = if whole > 0 { fronts.at(simd, 0) } else { last };
            let [arm, cos, sin] = front_arms.at(simd, 0);
            let mut front = End::new(here, [arm, cos, sin]);
            let mut rear = End::new(here, [-arm, cos, sin]);
            for i in 0..whole {
                let next = if i + 1 < whole {
                    fronts.at(simd, i + 1)
                } else {
                    last
                };
                let [arm, cos, sin] = front_arms.at(simd, i + 1);
                let next_rear = End::new(next, [-arm, cos, sin]);
                hinges.join(i, &front, &End::moved_on(&rear, &next_rear, last_lane));
                front = End::new(next, [arm, cos, sin]);
                rear = next_rear;
            }
            let behind = behind_last(links, last, whole * S::F64_LANES);
            let rear = End::new(behind, rear_arms.at(simd, whole));
            hinges.join(whole, &front, &rear);
        } else {
            let rears = Links::<S>::of(links, 1, whole);
            for i in 0..whole {
                let front = End::new(fronts.at(simd, i), front_arms.at(simd, i));
                let rear = End::new(rears.at(simd, i), rear_arms.at(simd, i));
                hinges.join(i, &front, &rear);
            }
            let front = End::new(last, front_arms.at(simd, whole));
            let behind = behind_last(links, last, whole * S::F64_LANES);
            let rear = End::new(behind, rear_arms.at(simd, whole));
            hinges.join(whole, &front, &rear);
        }

        let found = ChainFound {
            moved_squared: hinges.moved_squared.greatest(),
            changed: hinges.changed,
            dissipated: hinges.power.total(),
            rubbed: hinges.lost_to_friction(),
            sheared: hinges.lost_to_lubricant(),
        };
        RepeatBushings {
            links: n,
            overhang: self.overhang,
            arrays,
        }
        .with_simd(simd);
        found
    }
}

/// Cosines and sines of the links' angles; the first once more behind the last.
#[inline(always)]
fn point<S: Simd>(simd: S, angle: &[f64], cos: &mut [f64], sin: &mut [f64]) {
    let n = angle.len();
    let (whole, rest) = S::as_simd_f64s(angle);
    let blocks = whole.len() + usize::from(!rest.is_empty());
    {
        let (cos, sin) = (vectors_mut::<S>(cos, blocks), vectors_mut::<S>(sin, blocks));
        for (i, angle) in whole.iter().enumerate() {
            let (s, c) = sin_cos(load(simd, angle));
            (cos[i], sin[i]) = (c.values(), s.values());
        }
        if !rest.is_empty() {
            let (s, c) = sin_cos(partial_load(simd, rest));
            (cos[blocks - 1], sin[blocks - 1]) = (c.values(), s.values());
        }
    }
    cos[n] = cos[0];
    sin[n] = sin[0];
}

/// The same of the sprockets.
#[inline(always)]
fn point_sprockets<S: Simd>(simd: S, arrays: &mut ChainArrays) {
    let blocks = arrays.sprocket_angle.len() / S::F64_LANES;
    let angle = vectors::<S>(&arrays.sprocket_angle, blocks);
    let cos = vectors_mut::<S>(&mut arrays.sprocket_cos, blocks);
    let sin = vectors_mut::<S>(&mut arrays.sprocket_sin, blocks);
    for i in 0..blocks {
        let (s, c) = sin_cos(load(simd, &angle[i]));
        (cos[i], sin[i]) = (c.values(), s.values());
    }
}

/// x, y \[m\], dx/dt, dy/dt \[m/s\] and dθ/dt \[rad/s\] of links, from one of them on.
struct Links<'a, S: Simd>([&'a [S::f64s]; 5]);

impl<'a, S: Simd> Links<'a, S> {
    #[inline(always)]
    fn of([x, y, vx, vy, spin]: [&'a [f64]; 5], first: usize, blocks: usize) -> Self {
        Self([
            vectors::<S>(&x[first..], blocks),
            vectors::<S>(&y[first..], blocks),
            vectors::<S>(&vx[first..], blocks),
            vectors::<S>(&vy[first..], blocks),
            vectors::<S>(&spin[first..], blocks),
        ])
    }

    #[inline(always)]
    fn at(&self, simd: S, i: usize) -> [Lanes<S>; 5] {
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

/// The last register of links, from link `from` on.
#[inline(always)]
fn last_links<S: Simd>(simd: S, links: [&[f64]; 5], from: usize) -> [Lanes<S>; 5] {
    let [x, y, vx, vy, spin] = links;
    [
        partial_load(simd, &x[from..]),
        partial_load(simd, &y[from..]),
        partial_load(simd, &vx[from..]),
        partial_load(simd, &vy[from..]),
        partial_load(simd, &spin[from..]),
    ]
}

/// The register that begins one link later and ends with the first link of all.
#[inline(always)]
fn behind_last<S: Simd>(links: [&[f64]; 5], last: [Lanes<S>; 5], from: usize) -> [Lanes<S>; 5] {
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

/// Where ends are along their links, and directions of the links, from one of them on.
struct Arms<'a, S: Simd> {
    arm: &'a [S::f64s],
    cos: &'a [S::f64s],
    sin: &'a [S::f64s],
}

impl<'a, S: Simd> Arms<'a, S> {
    #[inline(always)]
    fn of(arm: &'a [f64], [cos, sin]: [&'a [f64]; 2], first: usize, blocks: usize) -> Self {
        Self {
            arm: vectors::<S>(arm, blocks),
            cos: vectors::<S>(&cos[first..], blocks),
            sin: vectors::<S>(&sin[first..], blocks),
        }
    }

    #[inline(always)]
    fn at(&self, simd: S, i: usize) -> [Lanes<S>; 3] {
        [
            load(simd, &self.arm[i]),
            load(simd, &self.cos[i]),
            load(simd, &self.sin[i]),
        ]
    }
}

/// One end of a register of links.
#[derive(Clone, Copy)]
struct End<S: Simd> {
    x: Lanes<S>,
    y: Lanes<S>,
    vx: Lanes<S>,
    vy: Lanes<S>,
    /// Angular speed of the link.
    spin: Lanes<S>,
}

impl<S: Simd> End<S> {
    /// All but the first of `here` and the first of `next`.
    #[inline(always)]
    fn moved_on(here: &Self, next: &Self, last_lane: Mask<S>) -> Self {
        let mut moved = *next;
        moved.x = here.x.moved_on(next.x, last_lane);
        moved.y = here.y.moved_on(next.y, last_lane);
        moved.vx = here.vx.moved_on(next.vx, last_lane);
        moved.vy = here.vy.moved_on(next.vy, last_lane);
        moved.spin = here.spin.moved_on(next.spin, last_lane);
        moved
    }

    #[inline(always)]
    fn new([x, y, vx, vy, spin]: [Lanes<S>; 5], [arm, cos, sin]: [Lanes<S>; 3]) -> Self {
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

/// The hinges as registers.
struct Hinges<
    'a,
    S: Simd,
    L,
    const DAMPED: bool,
    const RUBBED: bool,
    const BRISTLED: bool,
    const EXTRA: bool,
    const ENERGY: bool,
> {
    law: PhantomData<L>,
    law_constants: [Lanes<S>; 2],
    clearance: Lanes<S>,
    lambda: Lanes<S>,
    floor: Lanes<S>,
    /// Infinite where an open chain is open.
    clearance_squared: &'a [S::f64s],
    onset: &'a [S::f64s],
    on_front: &'a [S::f64s],
    there: &'a [S::f64s],
    reference: [&'a [S::f64s]; 2],
    depth: &'a mut [S::f64s],
    force: &'a mut [S::f64s],
    distance_squared: &'a mut [S::f64s],
    along: &'a mut [S::f64s],
    front_force: [&'a mut [S::f64s]; 2],
    rear_force: [&'a mut [S::f64s]; 2],
    bushing: [&'a mut [S::f64s]; 2],
    bushing_velocity: [&'a mut [S::f64s]; 2],
    moved_squared: Lanes<S>,
    changed: bool,
    power: PartialSums,
    /// Power dissipated by friction.
    rubbed: PartialSums,
    slopes: Option<&'a mut [SlopeGroup]>,
    rubs: Option<&'a mut [RubGroup]>,
    /// Friction and the pins' radius; some where `RUBBED`.
    rubbing: Option<(FrictionLanes<S>, Lanes<S>)>,
    /// Some where `BRISTLED`.
    bristles: Option<BristleLanes<'a, S>>,
    /// On fronts and rears.
    moments: [&'a mut [S::f64s]; 2],
    /// Power dissipated by lubricant.
    sheared: PartialSums,
    film_slopes: Option<&'a mut [FilmGroup]>,
    /// Some where `EXTRA` and lubricant.
    film: Option<FilmLanes<S>>,
    /// Some where `EXTRA` and elastic plates.
    compliance: Option<Lanes<S>>,
}

impl<
    'a,
    S: Simd,
    L: VectorLaw,
    const DAMPED: bool,
    const RUBBED: bool,
    const BRISTLED: bool,
    const EXTRA: bool,
    const ENERGY: bool,
> Hinges<'a, S, L, DAMPED, RUBBED, BRISTLED, EXTRA, ENERGY>
{
    /// Takes friction and lubricant, where there are any, and the places for their slopes.
    #[inline(always)]
    fn lay_in(
        &mut self,
        friction: Option<HingeFriction>,
        rubs: Option<&'a mut [RubGroup]>,
        lubricant: Option<FilledHinges<'a>>,
        compliance: Option<f64>,
    ) {
        let simd = self.clearance.simd();
        if EXTRA && let Some(compliance) = compliance {
            self.compliance = Some(Lanes::splat(simd, compliance));
        }
        if EXTRA && let Some(lubricant) = lubricant {
            self.film = Some(FilmLanes::new(simd, lubricant.film));
            self.film_slopes = lubricant.slopes;
        }
        if BRISTLED {
            self.rubs = rubs;
        } else if RUBBED && let Some(friction) = friction {
            self.rubs = rubs;
            self.rubbing = Some((
                FrictionLanes::new(simd, friction.law),
                Lanes::splat(simd, friction.pin_radius),
            ));
        }
    }

    /// Power dissipated by friction, when asked for \[W\].
    #[inline(always)]
    fn lost_to_friction(&self) -> f64 {
        if RUBBED && ENERGY {
            self.rubbed.total()
        } else {
            0.0
        }
    }

    /// Power dissipated by lubricant, when asked for \[W\].
    #[inline(always)]
    fn lost_to_lubricant(&self) -> f64 {
        if EXTRA && ENERGY {
            self.sheared.total()
        } else {
            0.0
        }
    }

    /// One register of hinges.
    #[inline(always)]
    fn join(&mut self, i: usize, front: &End<S>, rear: &End<S>) {
        let simd = self.clearance.simd();
        let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
        self.place_bushings(i, front, rear);
        let (ex, ey) = (front.x - rear.x, front.y - rear.y);
        let distance_squared = ex.mul_add(ex, ey * ey);
        let velocity = [front.vx - rear.vx, front.vy - rear.vy];
        self.distance_squared[i] = distance_squared.values();
        self.along[i] = ex.mul_add(velocity[0], ey * velocity[1]).values();
        let near = distance_squared.exceeds(load(simd, &self.clearance_squared[i]));
        let inverse_onset = load(simd, &self.onset[i]);
        let remembered = inverse_onset.greater(zero);
        if !near.any() {
            self.put(i, [zero; 4]);
            if EXTRA {
                self.fill(i, [front, rear], [ex, ey], velocity, distance_squared);
            }
            if let Some(slopes) = &mut self.slopes {
                let (group, part) = group_of::<S, _>(slopes, i);
                group.put_nothing(part, zero);
            }
            if RUBBED && let Some(rubs) = &mut self.rubs {
                let (group, part) = group_of::<S, _>(rubs, i);
                group.slope.put(part, zero);
            }
            if BRISTLED && let Some(bristles) = &mut self.bristles {
                bristles.rest(i);
            }
            self.changed |= remembered.any();
            return;
        }
        let distance = distance_squared.sqrt();
        let inverse_distance = near.select(one / distance, zero);
        let depth = near.select((distance - self.clearance).positive_part(), zero);
        let (nx, ny) = (ex * inverse_distance, ey * inverse_distance);
        let touching = depth.exceeds(zero);
        self.changed |= touching.differs(remembered).any();
        let mut pressed = depth;
        if EXTRA && let Some(compliance) = self.compliance {
            pressed = depths_in_series::<S, L>(self.law_constants, compliance, depth);
        }
        let elastic = L::forces(self.law_constants, pressed);
        let mut force = elastic;
        let touch = Touch {
            normal: [nx, ny],
            curvature: inverse_distance,
            depth: pressed,
            elastic,
        };
        if DAMPED {
            let rate = nx.mul_add(velocity[0], ny * velocity[1]);
            let mut inverse_onset = inverse_onset;
            if touching.and(remembered.not()).any() {
                inverse_onset = remembered.select(inverse_onset, one / self.floor.max(rate));
            }
            let factor = (self.lambda * rate)
                .mul_add(inverse_onset, one)
                .positive_part();
            force = elastic * factor;
            if ENERGY {
                self.power.add(i, (force - elastic) * rate);
            }
            if let Some(slopes) = &mut self.slopes {
                let damped = Damped {
                    lambda: self.lambda,
                    rate,
                    inverse_onset,
                    factor,
                    remembered,
                    floor: self.floor,
                };
                let (group, part) = group_of::<S, _>(slopes, i);
                group.put_touch::<S, L>(part, self.law_constants, &touch, Some(&damped));
            }
        } else if let Some(slopes) = &mut self.slopes {
            let (group, part) = group_of::<S, _>(slopes, i);
            group.put_touch::<S, L>(part, self.law_constants, &touch, None);
        }
        if EXTRA
            && let Some(compliance) = self.compliance
            && let Some(slopes) = &mut self.slopes
        {
            let (group, part) = group_of::<S, _>(slopes, i);
            let alone = L::slopes(self.law_constants, pressed, elastic);
            let stiffness = group.stiffness.at(simd, part) / compliance.mul_add(alone, one);
            group.stiffness.put(part, stiffness);
        }
        let mut pull = [force * nx, force * ny];
        if RUBBED {
            let touch = Touch { depth, ..touch };
            pull = self.rub(i, [front, rear], &touch, velocity, force);
        }
        self.put(i, [depth, force, pull[0], pull[1]]);
        if EXTRA {
            self.fill(i, [front, rear], [ex, ey], velocity, distance_squared);
        }
    }

    /// Adds the film to the forces and moments of these hinges.
    #[inline(always)]
    fn fill(
        &mut self,
        i: usize,
        [front, rear]: [&End<S>; 2],
        [ex, ey]: [Lanes<S>; 2],
        velocity: [Lanes<S>; 2],
        distance_squared: Lanes<S>,
    ) {
        let simd = self.clearance.simd();
        let splat = |value| Lanes::splat(simd, value);
        let (zero, one, half) = (splat(0.0), splat(1.0), splat(0.5));
        let Some(film) = self.film else { return };
        let distance = distance_squared.sqrt();
        // In the middle any direction will do.
        let apart = distance.greater(zero);
        let over_distance = one / apart.select(distance, one);
        let (nx, ny) = (
            apart.select(ex * over_distance, one),
            apart.select(ey * over_distance, zero),
        );
        let along = nx.mul_add(velocity[0], ny * velocity[1]);
        let mean_spin = half * (front.spin + rear.spin);
        let across = nx.mul_add(velocity[1], -(ny * velocity[0]));
        let across = mean_spin.negate_mul_add(distance, across);
        let turning = rear.spin - front.spin;
        let there = load(simd, &self.there[i]);
        let filled = film.at(distance, [along, across], there);
        let [push, drag] = filled.force;
        let shear = filled.shear * turning;
        if ENERGY {
            let pressed = push.mul_add(along, drag * across);
            self.sheared.add(i, shear.mul_add(turning, -pressed));
        }
        let force = [push.mul_add(nx, -(drag * ny)), push.mul_add(ny, drag * nx)];
        for (axis, force) in force.into_iter().enumerate() {
            let front = &mut self.front_force[axis][i];
            *front = (load(simd, front) + force).values();
            let rear = &mut self.rear_force[axis][i];
            *rear = (load(simd, rear) - force).values();
        }
        // Half of what the forces' distance leaves goes to each end.
        let lever = half * distance * drag;
        let moments = [shear - lever, -(shear + lever)];
        for (all, moment) in self.moments.iter_mut().zip(moments) {
            all[i] = (load(simd, &all[i]) + moment).values();
        }
        if let Some(groups) = &mut self.film_slopes {
            let slopes = film.slopes(&filled);
            let (group, part) = group_of::<S, _>(groups, i);
            write(&mut group.normal, part, [nx, ny]);
            write(&mut group.damping, part, slopes.damping);
            write(&mut group.stiffness, part, slopes.stiffness);
        }
    }

    /// The force on the rear ends with friction, of which the moments are written.
    #[inline(always)]
    fn rub(
        &mut self,
        i: usize,
        [front, rear]: [&End<S>; 2],
        touch: &Touch<S>,
        velocity: [Lanes<S>; 2],
        force: Lanes<S>,
    ) -> [Lanes<S>; 2] {
        let simd = force.simd();
        let zero = force.constant(0.0);
        let [nx, ny] = touch.normal;
        let radius = if BRISTLED {
            self.bristles.as_ref().map(|bristles| bristles.radius)
        } else {
            self.rubbing.map(|(_, radius)| radius)
        };
        let Some(pin_radius) = radius else {
            return [force * nx, force * ny];
        };
        // The contact is the pin's outermost point: beyond the pin as the bushing sees it, whichever link has the pin.
        let on_front = load(simd, &self.on_front[i]).greater(zero);
        let distance = touch.depth + self.clearance;
        let from_front = on_front.select(-(pin_radius + distance), pin_radius);
        let from_rear = from_front + distance;
        let across = nx.mul_add(velocity[1], -(ny * velocity[0]));
        let turning = from_front.mul_add(front.spin, -(from_rear * rear.spin));
        let slip = across + turning;
        let [rub, slope] = if BRISTLED && let Some(bristles) = &mut self.bristles {
            bristles.bend(i, touch.depth.exceeds(zero), force, slip)
        } else if let Some((friction, _)) = &self.rubbing {
            friction.force(force, slip)
        } else {
            [zero; 2]
        };
        if ENERGY {
            self.rubbed.add(i, rub * slip);
        }
        self.moments[0][i] = (-(from_front * rub)).values();
        self.moments[1][i] = (from_rear * rub).values();
        if let Some(rubs) = &mut self.rubs {
            let (group, part) = group_of::<S, _>(rubs, i);
            group.slope.put(part, slope);
            group.places[0].put(part, from_front);
            group.places[1].put(part, from_rear);
        }
        [force.mul_add(nx, -(rub * ny)), force.mul_add(ny, rub * nx)]
    }

    /// Depth, force, and its direction as it acts on the rear ends.
    #[inline(always)]
    fn put(&mut self, i: usize, [depth, force, x, y]: [Lanes<S>; 4]) {
        self.depth[i] = depth.values();
        self.force[i] = force.values();
        self.front_force[0][i] = (-x).values();
        self.front_force[1][i] = (-y).values();
        self.rear_force[0][i] = x.values();
        self.rear_force[1][i] = y.values();
    }

    /// The bushings of these hinges, and how far they have moved from their references.
    #[inline(always)]
    fn place_bushings(&mut self, i: usize, front: &End<S>, rear: &End<S>) {
        let simd = self.clearance.simd();
        let on_front = load(simd, &self.on_front[i]).greater(Lanes::splat(simd, 0.0));
        let x = on_front.select(front.x, rear.x);
        let y = on_front.select(front.y, rear.y);
        self.bushing[0][i] = x.values();
        self.bushing[1][i] = y.values();
        let dx = x - load(simd, &self.reference[0][i]);
        let dy = y - load(simd, &self.reference[1][i]);
        self.moved_squared = self.moved_squared.max(dx.mul_add(dx, dy * dy));
        self.bushing_velocity[0][i] = on_front.select(front.vx, rear.vx).values();
        self.bushing_velocity[1][i] = on_front.select(front.vy, rear.vy).values();
    }
}

/// Writes the first bushings once more behind the last one, and zeros where teeth will add their forces.
pub(super) struct RepeatBushings<'a> {
    pub(super) links: usize,
    pub(super) overhang: usize,
    pub(super) arrays: &'a mut ChainArrays,
}

impl WithSimd for RepeatBushings<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (n, overhang) = (self.links, self.overhang);
        let ChainArrays {
            front_force,
            rear_force,
            bushing,
            bushing_velocity,
            ..
        } = self.arrays;
        for array in bushing.iter_mut().chain(bushing_velocity) {
            repeat::<S>(array, n, overhang);
        }
        for (array, first) in front_force
            .iter_mut()
            .map(|array| (array, 0))
            .chain(rear_force.iter_mut().map(|array| (array, FIRST + 1)))
        {
            for from in (0..overhang).step_by(S::F64_LANES) {
                vectors_mut::<S>(&mut array[first + n + from..], 1)[0] =
                    Lanes::splat(simd, 0.0).values();
            }
        }
    }
}

/// Copies the first `overhang` entries behind entry `n`.
#[inline(always)]
fn repeat<S: Simd>(array: &mut [f64], n: usize, overhang: usize) {
    for from in (0..overhang).step_by(S::F64_LANES) {
        let values = vectors::<S>(&array[from..], 1)[0];
        vectors_mut::<S>(&mut array[n + from..], 1)[0] = values;
    }
}

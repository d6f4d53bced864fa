//! Rollers on their bushings: the hinges' loop once more, between bushings, which are known, and rollers.
//!
//! Rollers have arrays like the chain's own: their centres stand in the place of the bushings', and the forces on them in the
//! place of those on front ends. Teeth, candidates and watches read and write these as they would the chain's.

use std::marker::PhantomData;

use pulp::{Simd, WithSimd};

use super::{ChainFound, End, HingeFriction, Hinges, RepeatBushings};
use crate::force_law::{FrictionLanes, VectorLaw};
use crate::kernels::bristles::Bristling;
use crate::kernels::layout::{ChainArrays, FIRST, LinkConstants};
use crate::kernels::slopes::{RubGroup, SlopeGroup};
use crate::model::Model;
use crate::vector::{
    Lanes, Numbers, PartialSums, both, both_mut, lane_numbers, load, partial_load, splat_two,
    vectors, vectors_mut,
};

/// What the kernels have of rollers.
#[derive(Debug, Clone)]
pub(in crate::kernels) struct Rollers {
    /// To the teeth every roller is on a front.
    pub(in crate::kernels) constants: LinkConstants,
    /// Rollers in the place of bushings.
    pub(in crate::kernels) arrays: ChainArrays,
}

impl Rollers {
    /// Arrays for the rollers of `model`, where they are bodies.
    pub(in crate::kernels) fn of(model: &Model) -> Option<Self> {
        model.rollers.as_ref().map(|rollers| {
            let mut constants = LinkConstants::new(model);
            constants.bushing_on_front.fill(1.0);
            constants
                .clearance_squared
                .fill(rollers.clearance * rollers.clearance);
            Self {
                constants,
                arrays: ChainArrays::new(model),
            }
        })
    }
}

/// One law, one loop; see the hinges.
pub(in crate::kernels) struct JoinRollers<
    'a,
    L,
    const DAMPED: bool,
    const RUBBED: bool,
    const BRISTLED: bool,
    const ENERGY: bool,
> {
    pub(in crate::kernels) law: PhantomData<L>,
    pub(in crate::kernels) law_constants: [f64; 2],
    pub(in crate::kernels) clearance: f64,
    pub(in crate::kernels) lambda: f64,
    pub(in crate::kernels) floor: f64,
    /// x and y \[m\] of the rollers.
    pub(in crate::kernels) places: [&'a [f64]; 2],
    /// Their rates, and that of θ.
    pub(in crate::kernels) speeds: [&'a [f64]; 3],
    /// 1/onset speed of every one \[s/m\]; zero without memory.
    pub(in crate::kernels) inverse_onset: &'a [f64],
    /// Where the rollers were when the candidates were chosen, x and y \[m\].
    pub(in crate::kernels) reference: &'a [Numbers; 2],
    /// How many rollers are needed again behind the last one.
    pub(in crate::kernels) overhang: usize,
    pub(in crate::kernels) links: &'a LinkConstants,
    /// The chain, whose bushings are read and whose ends get the forces on them.
    pub(in crate::kernels) chain: &'a mut ChainArrays,
    pub(in crate::kernels) rollers: &'a mut Rollers,
    /// Where the slopes of the forces go when they are asked for.
    pub(in crate::kernels) slopes: Option<&'a mut [SlopeGroup]>,
    /// Those of friction.
    pub(in crate::kernels) rubs: Option<&'a mut [RubGroup]>,
    /// What `RUBBED` needs; the bushings are the pins here.
    pub(in crate::kernels) friction: Option<HingeFriction<'a>>,
    /// What `BRISTLED` needs.
    pub(in crate::kernels) bristles: Option<Bristling<'a>>,
}

impl<L: VectorLaw, const DAMPED: bool, const RUBBED: bool, const BRISTLED: bool, const ENERGY: bool>
    WithSimd for JoinRollers<'_, L, DAMPED, RUBBED, BRISTLED, ENERGY>
{
    type Output = ChainFound;

    #[allow(clippy::too_many_lines)] // a line for each of many fields
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> ChainFound {
        let n = self.places[0].len();
        let blocks = n.div_ceil(S::F64_LANES);
        let splat = |value| Lanes::splat(simd, value);
        let Rollers { constants, arrays } = self.rollers;
        let mut joints = Hinges::<S, L, DAMPED, RUBBED, BRISTLED, false, ENERGY> {
            law: PhantomData,
            law_constants: splat_two(simd, self.law_constants),
            clearance: splat(self.clearance),
            clearance_squared: vectors::<S>(&constants.clearance_squared, blocks),
            there: vectors::<S>(&constants.there, blocks),
            lambda: splat(self.lambda),
            floor: splat(self.floor),
            onset: vectors::<S>(self.inverse_onset, blocks),
            on_front: vectors::<S>(&constants.bushing_on_front, blocks),
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
        let rubs = RUBBED && (BRISTLED || self.friction.is_some());
        if rubs {
            joints.moments = [
                vectors_mut::<S>(&mut arrays.front_moment, blocks),
                vectors_mut::<S>(&mut arrays.rear_moment[FIRST + 1..], blocks),
            ];
            joints.rubs = self.rubs;
        }
        if BRISTLED && let Some(bristles) = self.bristles {
            joints.bristles = Some(bristles.into_lanes(simd, blocks));
        } else if RUBBED && let Some(friction) = &self.friction {
            joints.rubbing = Some((
                FrictionLanes::new(simd, friction.law),
                splat(friction.pin_radius),
            ));
        }
        let [x, y] = self.places;
        let [vx, vy, spin] = self.speeds;
        let place = both::<S>(&self.chain.bushing, 0, blocks);
        let velocity = both::<S>(&self.chain.bushing_velocity, 0, blocks);
        let turning = vectors::<S>(&self.chain.bushing_spin, blocks);
        let zero = splat(0.0);
        for i in 0..blocks {
            let from = i * S::F64_LANES;
            let (there, last) = (
                lane_numbers(simd).less(splat((n - from) as f64)),
                i + 1 == blocks,
            );
            let of_roller = |array: &[f64]| {
                if last {
                    partial_load(simd, &array[from..])
                } else {
                    load(simd, &vectors::<S>(&array[from..], 1)[0])
                }
            };
            // Behind the last bushing stands the first one again, or what was there once.
            let of_bushing = |array: &[S::f64s]| {
                let value = load(simd, &array[i]);
                if last {
                    there.select(value, zero)
                } else {
                    value
                }
            };
            let roller = End {
                x: of_roller(x),
                y: of_roller(y),
                vx: of_roller(vx),
                vy: of_roller(vy),
                spin: if RUBBED { of_roller(spin) } else { zero },
            };
            let bushing = End {
                x: of_bushing(place[0]),
                y: of_bushing(place[1]),
                vx: of_bushing(velocity[0]),
                vy: of_bushing(velocity[1]),
                spin: if RUBBED { of_bushing(turning) } else { zero },
            };
            joints.join(i, &roller, &bushing);
        }
        let found = ChainFound {
            moved_squared: joints.moved_squared.greatest(),
            changed: joints.changed,
            dissipated: joints.power.total(),
            rubbed: joints.lost_to_friction(),
            sheared: 0.0,
        };
        RepeatBushings {
            links: n,
            overhang: self.overhang,
            arrays,
        }
        .with_simd(simd);
        press_bushings(simd, blocks, self.links, arrays, self.chain, rubs);
        found
    }
}

/// Gives the ends of links what rollers do to their bushings.
#[inline(always)]
fn press_bushings<S: Simd>(
    simd: S,
    blocks: usize,
    links: &LinkConstants,
    rollers: &ChainArrays,
    chain: &mut ChainArrays,
    moments: bool,
) {
    let on_front = vectors::<S>(&links.bushing_on_front, blocks);
    let ChainArrays {
        front_force,
        rear_force,
        front_moment,
        rear_moment,
        ..
    } = chain;
    for (axis, from) in rollers.rear_force.iter().enumerate() {
        let (front, rear) = (&mut front_force[axis], &mut rear_force[axis]);
        add_to_ends::<S>(simd, on_front, &from[FIRST + 1..], front, rear);
    }
    if moments {
        let from = &rollers.rear_moment[FIRST + 1..];
        add_to_ends::<S>(simd, on_front, from, front_moment, rear_moment);
    }
}

/// Adds what bushings feel to the ends that they are on.
#[inline(always)]
fn add_to_ends<S: Simd>(
    simd: S,
    on_front: &[S::f64s],
    from: &[f64],
    front: &mut [f64],
    rear: &mut [f64],
) {
    let blocks = on_front.len();
    let zero = Lanes::splat(simd, 0.0);
    let from = vectors::<S>(from, blocks);
    let front = vectors_mut::<S>(front, blocks);
    let rear = vectors_mut::<S>(&mut rear[FIRST + 1..], blocks);
    for i in 0..blocks {
        let at = |array: &[S::f64s]| load(simd, &array[i]);
        let felt = at(from);
        let on_front = at(on_front).greater(zero).select(felt, zero);
        let (fronts, rears) = (at(front) + on_front, at(rear) + (felt - on_front));
        (front[i], rear[i]) = (fronts.values(), rears.values());
    }
}

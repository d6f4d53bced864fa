//! Rollers on their bushings: the hinges' loop once more, between bushings, which are known, and rollers.
//!
//! Rollers have arrays like the chain's own: their centres stand in the place of the bushings', and the forces on them in the
//! place of those on front ends. Teeth, candidates and watches read and write these as they would the chain's.

use std::marker::PhantomData;

use pulp::{Simd, WithSimd};

use super::ends::End;
use super::hinges::{Hinges, Joints};
use super::{ChainFound, RepeatBushings};
use crate::force_law::VectorLaw;
use crate::kernels::layout::{ChainArrays, FIRST, LinkConstants};
use crate::model::Model;
use crate::vector::{Lanes, both, lane_numbers, load, partial_load, vectors, vectors_mut};

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
            // Without a bushing there is nothing to touch.
            for k in (0..model.links).filter(|&k| !model.bushing_is_there(k)) {
                constants.clearance_squared[k] = f64::INFINITY;
            }
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
    pub(in crate::kernels) bores: Joints<'a>,
    /// x and y \[m\] of the rollers.
    pub(in crate::kernels) places: [&'a [f64]; 2],
    /// Their rates, and that of θ.
    pub(in crate::kernels) speeds: [&'a [f64]; 3],
    /// How many rollers are needed again behind the last one.
    pub(in crate::kernels) overhang: usize,
    pub(in crate::kernels) links: &'a LinkConstants,
    /// The chain, whose bushings are read and whose ends get the forces on them.
    pub(in crate::kernels) chain: &'a mut ChainArrays,
    pub(in crate::kernels) rollers: &'a mut Rollers,
}

impl<L: VectorLaw, const DAMPED: bool, const RUBBED: bool, const BRISTLED: bool, const ENERGY: bool>
    WithSimd for JoinRollers<'_, L, DAMPED, RUBBED, BRISTLED, ENERGY>
{
    type Output = ChainFound;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> ChainFound {
        let n = self.places[0].len();
        let blocks = n.div_ceil(S::F64_LANES);
        let splat = |value| Lanes::splat(simd, value);
        let Rollers { constants, arrays } = self.rollers;
        let moments = RUBBED && (BRISTLED || self.bores.friction.is_some());
        let (mut joints, _) = Hinges::<S, L, DAMPED, RUBBED, BRISTLED, false, ENERGY>::new(
            simd, self.bores, constants, arrays, blocks,
        );
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
        let found = joints.found();
        RepeatBushings {
            links: n,
            overhang: self.overhang,
            arrays,
        }
        .with_simd(simd);
        press_bushings(simd, blocks, self.links, arrays, self.chain, moments);
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

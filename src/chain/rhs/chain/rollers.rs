//! Rollers on their bushings: the loop of the hinges, with bushings in known positions and rollers as the two bodies.
//!
//! Rollers have the same arrays as the chain. Their centres replace those of the bushings, and the forces on them replace those on
//! front ends. Teeth, candidates and event screening use both kinds of arrays in the same way.

use pulp::{Simd, WithSimd};

use super::ends::LinkEnd;
use super::hinges::{Hinges, Joints};
use super::{ChainFound, RepeatBushings};
use crate::chain::arrays::layout::{ChainArrays, FIRST, LinkConstants};
use crate::chain::model::Model;
use crate::math::simd::{
    Entries, Lanes, Mask, both, both_mut, lane_numbers, load, parts, vectors, vectors_from_mut,
    vectors_mut,
};

/// Rollers in the kernels.
#[derive(Debug, Clone)]
pub(crate) struct Rollers {
    /// Constants for the teeth: every roller counts as a bushing on the front of a link.
    pub(crate) constants: LinkConstants,
    /// Arrays with rollers in the place of bushings.
    pub(crate) arrays: ChainArrays,
}

impl Rollers {
    /// Allocate the arrays for the rollers of `model`, where they are bodies.
    pub(crate) fn of(model: &Model) -> Option<Self> {
        model.rollers.as_ref().map(|rollers| {
            let mut constants = LinkConstants::new(model);
            constants.bushing_on_front.fill(1.0);
            constants
                .clearance_squared
                .fill(rollers.clearance * rollers.clearance);
            // A missing bushing has an infinite clearance: no contact occurs.
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

/// Kernel of the rollers; parameters as of `EvaluateHinges`.
pub(crate) struct EvaluateRollers<
    'a,
    const DAMPED: bool,
    const FRICTION: bool,
    const BRISTLED: bool,
> {
    pub(crate) bores: Joints<'a>,
    /// x and y \[m\] of the rollers.
    pub(crate) places: [&'a [f64]; 2],
    /// Rates of these coordinates, and that of θ.
    pub(crate) speeds: [&'a [f64]; 3],
    /// Number of rollers copied behind the last one.
    pub(crate) overhang: usize,
    pub(crate) links: &'a LinkConstants,
    /// Chain: its bushings are read, and the forces on them are added to the ends of its links.
    pub(crate) chain: &'a mut ChainArrays,
    pub(crate) rollers: &'a mut Rollers,
}

impl<const DAMPED: bool, const FRICTION: bool, const BRISTLED: bool> WithSimd
    for EvaluateRollers<'_, DAMPED, FRICTION, BRISTLED>
{
    type Output = ChainFound;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> ChainFound {
        let n = self.places[0].len();
        let blocks = n.div_ceil(S::F64_LANES);
        let splat = |value| Lanes::splat(simd, value);
        let Rollers { constants, arrays } = self.rollers;
        let moments = FRICTION && (BRISTLED || self.bores.friction.is_some());
        let (mut joints, _) = Hinges::<S, DAMPED, FRICTION, BRISTLED, false>::new(
            simd, self.bores, constants, arrays, blocks,
        );
        let ChainArrays {
            bushing,
            bushing_velocity,
            bushing_spin,
            front_force,
            rear_force,
            front_moment,
            rear_moment,
            ..
        } = self.chain;
        let mut pressed = PressedEnds {
            on_front: vectors::<S>(&self.links.bushing_on_front, blocks),
            front_force: both_mut::<S>(front_force, 0, blocks),
            rear_force: both_mut::<S>(rear_force, FIRST + 1, blocks),
            front_moment: vectors_mut::<S>(front_moment, blocks),
            rear_moment: vectors_from_mut::<S>(rear_moment, FIRST + 1, blocks),
        };
        let [x, y] = self.places.map(|axis| Entries::<S>::of(simd, axis));
        let [vx, vy, spin] = self.speeds.map(|axis| Entries::<S>::of(simd, axis));
        let place = both::<S>(bushing, 0, blocks);
        let velocity = both::<S>(bushing_velocity, 0, blocks);
        let turning = vectors::<S>(bushing_spin, blocks);
        let zero = splat(0.0);
        let there = lane_numbers(simd).less(splat((n - (blocks - 1) * S::F64_LANES) as f64));
        for i in 0..blocks {
            // Lanes behind the last bushing hold copies or old values: they are set to zero, as those of the rollers.
            let of_bushing = |array: &[S::f64s]| {
                let value = load(simd, &array[i]);
                if i + 1 < blocks {
                    value
                } else {
                    there.select(value, zero)
                }
            };
            let (number, part) = (i / parts::<S>().len(), i % parts::<S>().len());
            let of_roller = |array: &Entries<S>| array.at(number, part);
            let roller = LinkEnd {
                x: of_roller(&x),
                y: of_roller(&y),
                vx: of_roller(&vx),
                vy: of_roller(&vy),
                spin: if FRICTION { of_roller(&spin) } else { zero },
            };
            let bushing = LinkEnd {
                x: of_bushing(place[0]),
                y: of_bushing(place[1]),
                vx: of_bushing(velocity[0]),
                vy: of_bushing(velocity[1]),
                spin: if FRICTION { of_bushing(turning) } else { zero },
            };
            if joints.evaluate(i, &roller, &bushing) {
                let touching = load(simd, &joints.depth[i]).greater(zero);
                let [felt_x, felt_y] = &joints.rear_force;
                let felt = [load(simd, &felt_x[i]), load(simd, &felt_y[i])];
                pressed.push(i, touching, felt);
                if moments {
                    pressed.twist(i, touching, load(simd, &joints.moments[1][i]));
                }
            }
        }
        let found = joints.found();
        if self.overhang > 0 {
            RepeatBushings {
                links: n,
                overhang: self.overhang,
                arrays,
            }
            .with_simd(simd);
        }
        found
    }
}

/// Forces and moments on the ends of links, to which those of rollers on their bushings are added.
struct PressedEnds<'a, S: Simd> {
    on_front: &'a [S::f64s],
    front_force: [&'a mut [S::f64s]; 2],
    rear_force: [&'a mut [S::f64s]; 2],
    front_moment: &'a mut [S::f64s],
    rear_moment: &'a mut [S::f64s],
}

impl<S: Simd> PressedEnds<'_, S> {
    /// Add forces on vector `i` of bushings to the ends that carry them.
    #[inline(always)]
    fn push(&mut self, i: usize, touching: Mask<S>, [x, y]: [Lanes<S>; 2]) {
        let on_front = load(x.simd(), &self.on_front[i]).greater(x.constant(0.0));
        let (front, rear) = (touching.and(on_front), touching.and(on_front.not()));
        add(front, x, &mut self.front_force[0][i]);
        add(front, y, &mut self.front_force[1][i]);
        add(rear, x, &mut self.rear_force[0][i]);
        add(rear, y, &mut self.rear_force[1][i]);
    }

    /// Add moments on vector `i` of bushings to the ends that carry them.
    #[inline(always)]
    fn twist(&mut self, i: usize, touching: Mask<S>, felt: Lanes<S>) {
        let on_front = load(felt.simd(), &self.on_front[i]).greater(felt.constant(0.0));
        add(touching.and(on_front), felt, &mut self.front_moment[i]);
        add(touching.and(on_front.not()), felt, &mut self.rear_moment[i]);
    }
}

/// Add `felt` in the lanes of `acts` only: other lanes keep even the sign of a zero, so that no result depends on the lanes of a
/// vector.
#[inline(always)]
fn add<S: Simd>(acts: Mask<S>, felt: Lanes<S>, to: &mut S::f64s) {
    let before = load(felt.simd(), to);
    *to = acts.select(before + felt, before).values();
}

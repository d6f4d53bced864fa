//! The chain in one pass: directions and ends of the links, hinges between them, and centres of the bushings.

mod ends;
mod hinges;
mod losses;
mod rollers;

use std::marker::PhantomData;

use pulp::{Simd, WithSimd};

use super::layout::{ChainArrays, FIRST, LinkConstants};
use crate::force_law::ElasticLaw;
use crate::math::simd::{
    Lanes, WIDTH, lane_numbers, load, packs, packs_mut, part_of, partial_load, parts, put_part,
    sin_cos, vectors, vectors_mut,
};
use ends::{Arms, End, Links, behind_last, last_links};
use hinges::Hinges;

pub(crate) use hinges::Joints;
pub(crate) use losses::{HingeFriction, Lubricant};
pub(crate) use rollers::{EvaluateRollers, Rollers};

/// Results of the chain's loop besides its forces.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ChainFound {
    /// Largest squared distance of a bushing from its reference \[m²\].
    pub(crate) moved_squared: f64,
    /// Largest squared speed of a bushing \[m²/s²\].
    pub(crate) speed_squared: f64,
    /// Whether the contact state of a hinge differs from the impact velocity memory: contact without memory, or memory without
    /// contact.
    pub(crate) changed: bool,
    /// Power dissipated by damping \[W\], if requested.
    pub(crate) dissipated: f64,
    /// Power dissipated by friction \[W\], if requested.
    pub(crate) friction_power: f64,
    /// Power dissipated by lubricant \[W\], if requested.
    pub(crate) film_power: f64,
}

/// Kernel of the chain, one instance per contact law. `DAMPED`: with the damping factor; `FRICTION`: with friction; `BRISTLED`:
/// friction by bristles; `EXTRA`: with lubricant, elastic plates and friction, as far as the model has them.
pub(crate) struct EvaluateHinges<
    'a,
    L,
    const DAMPED: bool,
    const FRICTION: bool,
    const BRISTLED: bool,
    const EXTRA: bool,
> {
    pub(crate) law: PhantomData<L>,
    pub(crate) hinges: Joints<'a>,
    /// x, y \[m\] and θ \[rad\] of the links.
    pub(crate) places: [&'a [f64]; 3],
    /// Rates of these coordinates.
    pub(crate) speeds: [&'a [f64]; 3],
    /// Number of bushings copied behind the last one.
    pub(crate) overhang: usize,
    pub(crate) constants: &'a LinkConstants,
    pub(crate) arrays: &'a mut ChainArrays,
    /// Lubricant for `EXTRA`.
    pub(crate) lubricant: Option<Lubricant<'a>>,
    /// Compliance of the plates at each hinge \[m/N\].
    pub(crate) compliance: Option<&'a [f64]>,
}

impl<
    L: ElasticLaw,
    const DAMPED: bool,
    const FRICTION: bool,
    const BRISTLED: bool,
    const EXTRA: bool,
> WithSimd for EvaluateHinges<'_, L, DAMPED, FRICTION, BRISTLED, EXTRA>
{
    type Output = ChainFound;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> ChainFound {
        let n = self.places[0].len();
        let blocks = n.div_ceil(S::F64_LANES);
        let whole = blocks - 1;
        let splat = |value| Lanes::splat(simd, value);
        let arrays = self.arrays;
        write_directions::<S>(simd, self.places[2], &mut arrays.cos, &mut arrays.sin);
        write_sprocket_directions::<S>(simd, arrays);
        let (mut hinges, direction) = Hinges::<S, L, DAMPED, FRICTION, BRISTLED, EXTRA>::new(
            simd,
            self.hinges,
            self.constants,
            arrays,
            blocks,
        );
        hinges.attach_optional_forces(self.lubricant, self.compliance);
        let [x, y, _] = self.places;
        let [vx, vy, spin] = self.speeds;
        let links = [x, y, vx, vy, spin];
        let last = last_links(simd, links, whole * S::F64_LANES);
        let fronts = Links::<S>::of(links, 0, whole);
        let front_arms = Arms::<S>::of(&self.constants.front_arm, direction, 0, blocks);
        let rear_arms = Arms::<S>::of(&self.constants.rear_arm, direction, 1, blocks);
        if S::F64_LANES == WIDTH {
            // Unaligned loads of wide vectors are slow: rear ends are shifted by one lane instead. Hinge k joins the front of link
            // k to the rear of link k + 1.
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
                hinges.evaluate(i, &front, &End::moved_on(&rear, &next_rear, last_lane));
                front = End::new(next, [arm, cos, sin]);
                rear = next_rear;
            }
            let behind = behind_last(links, last, whole * S::F64_LANES);
            let rear = End::new(behind, rear_arms.at(simd, whole));
            hinges.evaluate(whole, &front, &rear);
        } else {
            let rears = Links::<S>::of(links, 1, whole);
            for i in 0..whole {
                let front = End::new(fronts.at(simd, i), front_arms.at(simd, i));
                let rear = End::new(rears.at(simd, i), rear_arms.at(simd, i));
                hinges.evaluate(i, &front, &rear);
            }
            let front = End::new(last, front_arms.at(simd, whole));
            let behind = behind_last(links, last, whole * S::F64_LANES);
            let rear = End::new(behind, rear_arms.at(simd, whole));
            hinges.evaluate(whole, &front, &rear);
        }

        let found = hinges.found();
        RepeatBushings {
            links: n,
            overhang: self.overhang,
            arrays,
        }
        .with_simd(simd);
        found
    }
}

/// Write cosines and sines of the links' angles; a copy of the first follows the last.
#[inline(always)]
fn write_directions<S: Simd>(simd: S, angle: &[f64], cos: &mut [f64], sin: &mut [f64]) {
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

/// Write cosines and sines of the sprockets' angles.
#[inline(always)]
fn write_sprocket_directions<S: Simd>(simd: S, arrays: &mut ChainArrays) {
    let blocks = arrays.sprocket_angle.len() / S::F64_LANES;
    let angle = vectors::<S>(&arrays.sprocket_angle, blocks);
    let cos = vectors_mut::<S>(&mut arrays.sprocket_cos, blocks);
    let sin = vectors_mut::<S>(&mut arrays.sprocket_sin, blocks);
    for i in 0..blocks {
        let (s, c) = sin_cos(load(simd, &angle[i]));
        (cos[i], sin[i]) = (c.values(), s.values());
    }
}

/// Kernel that copies the first bushings behind the last one, and writes zeros where teeth add their forces.
pub(crate) struct RepeatBushings<'a> {
    pub(crate) links: usize,
    pub(crate) overhang: usize,
    pub(crate) arrays: &'a mut ChainArrays,
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
        let count = overhang.div_ceil(WIDTH);
        let [x, y] = bushing;
        let [vx, vy] = bushing_velocity;
        for array in [x, y, vx, vy] {
            repeat(simd, array, n, count);
        }
        let zero = Lanes::splat(simd, 0.0);
        let [front_x, front_y] = front_force;
        let [rear_x, rear_y] = rear_force;
        for (array, first) in [
            (front_x, 0),
            (front_y, 0),
            (rear_x, FIRST + 1),
            (rear_y, FIRST + 1),
        ] {
            for pack in packs_mut(&mut array[first + n..], count) {
                for part in parts::<S>() {
                    put_part(pack, part, zero);
                }
            }
        }
    }
}

/// Copy the first packs behind entry `n`.
#[inline(always)]
fn repeat<S: Simd>(simd: S, array: &mut [f64], n: usize, count: usize) {
    for number in 0..count {
        let from = packs(&array[number * WIDTH..], 1)[0];
        let to = &mut packs_mut(&mut array[n + number * WIDTH..], 1)[0];
        for part in parts::<S>() {
            put_part(to, part, part_of(simd, &from, part));
        }
    }
}

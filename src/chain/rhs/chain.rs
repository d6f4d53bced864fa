//! The chain in one pass: directions and ends of the links, hinges between them, and centres of the bushings.

mod ends;
mod hinges;
mod losses;
mod rollers;

use pulp::{Simd, WithSimd};

use crate::chain::arrays::layout::{ChainArrays, FIRST, LinkConstants};
use crate::math::simd::{
    Lanes, Pack, WIDTH, lane_numbers, packs, packs_from_mut, packs_mut, write_sin_cos,
};
use ends::{Arms, LinkEnd, Links, behind_last, last_links};
use hinges::Hinges;

pub(crate) use hinges::{HingeFriction, Joints, Lubricant};
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

/// Kernel of the chain. `DAMPED`: with the damping factor; `FRICTION`: with friction; `BRISTLED`:
/// friction by bristles; `EXTRA`: with lubricant, elastic plates and friction, as far as the model has them.
pub(crate) struct EvaluateHinges<
    'a,
    const DAMPED: bool,
    const FRICTION: bool,
    const BRISTLED: bool,
    const EXTRA: bool,
> {
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

impl<const DAMPED: bool, const FRICTION: bool, const BRISTLED: bool, const EXTRA: bool> WithSimd
    for EvaluateHinges<'_, DAMPED, FRICTION, BRISTLED, EXTRA>
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
        let (mut hinges, direction) = Hinges::<S, DAMPED, FRICTION, BRISTLED, EXTRA>::new(
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
            let mut front = LinkEnd::new(here, [arm, cos, sin]);
            let mut rear = LinkEnd::new(here, [-arm, cos, sin]);
            for i in 0..whole {
                let next = if i + 1 < whole {
                    fronts.at(simd, i + 1)
                } else {
                    last
                };
                let [arm, cos, sin] = front_arms.at(simd, i + 1);
                let next_rear = LinkEnd::new(next, [-arm, cos, sin]);
                hinges.evaluate(i, &front, &LinkEnd::moved_on(&rear, &next_rear, last_lane));
                front = LinkEnd::new(next, [arm, cos, sin]);
                rear = next_rear;
            }
            let behind = behind_last(links, last, whole * S::F64_LANES);
            let rear = LinkEnd::new(behind, rear_arms.at(simd, whole));
            hinges.evaluate(whole, &front, &rear);
        } else {
            let rears = Links::<S>::of(links, 1, whole);
            for i in 0..whole {
                let front = LinkEnd::new(fronts.at(simd, i), front_arms.at(simd, i));
                let rear = LinkEnd::new(rears.at(simd, i), rear_arms.at(simd, i));
                hinges.evaluate(i, &front, &rear);
            }
            let front = LinkEnd::new(last, front_arms.at(simd, whole));
            let behind = behind_last(links, last, whole * S::F64_LANES);
            let rear = LinkEnd::new(behind, rear_arms.at(simd, whole));
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

/// Kernel that writes cosines and sines of these angles; a copy of the first follows the last.
pub(crate) struct WriteDirections<'a> {
    pub(crate) angle: &'a [f64],
    pub(crate) cos: &'a mut [f64],
    pub(crate) sin: &'a mut [f64],
}

impl WithSimd for WriteDirections<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        write_directions::<S>(simd, self.angle, self.cos, self.sin);
    }
}

/// Write cosines and sines of the links' angles; a copy of the first follows the last.
#[inline(always)]
fn write_directions<S: Simd>(simd: S, angle: &[f64], cos: &mut [f64], sin: &mut [f64]) {
    let n = angle.len();
    write_sin_cos(simd, angle, cos, sin);
    cos[n] = cos[0];
    sin[n] = sin[0];
}

/// Write cosines and sines of the sprockets' angles.
#[inline(always)]
fn write_sprocket_directions<S: Simd>(simd: S, arrays: &mut ChainArrays) {
    let whole = arrays.sprockets.next_multiple_of(S::F64_LANES);
    let (cos, sin) = (&mut arrays.sprocket_cos, &mut arrays.sprocket_sin);
    write_sin_cos(simd, &arrays.sprocket_angle[..whole], cos, sin);
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
    fn with_simd<S: Simd>(self, _simd: S) {
        let n = self.links;
        let count = self.overhang.div_ceil(WIDTH);
        let ChainArrays {
            front_force: [front_x, front_y],
            rear_force: [rear_x, rear_y],
            bushing: [x, y],
            bushing_velocity: [vx, vy],
            ..
        } = self.arrays;
        let (rear_x, rear_y) = (&mut rear_x[FIRST + 1..], &mut rear_y[FIRST + 1..]);
        // Packs that do not overlap their copies: all of them, unless nearly the whole chain is copied.
        let whole = count.min(n / WIDTH);
        {
            let [(x, to_x), (y, to_y), (vx, to_vx), (vy, to_vy)] = [
                first_packs(x, n, whole),
                first_packs(y, n, whole),
                first_packs(vx, n, whole),
                first_packs(vy, n, whole),
            ];
            let [to_front_x, to_front_y, to_rear_x, to_rear_y] = [
                packs_from_mut(front_x, n, whole),
                packs_from_mut(front_y, n, whole),
                packs_from_mut(rear_x, n, whole),
                packs_from_mut(rear_y, n, whole),
            ];
            for i in 0..whole {
                (to_x[i], to_y[i], to_vx[i], to_vy[i]) = (x[i], y[i], vx[i], vy[i]);
                (to_front_x[i], to_front_y[i]) = ([0.0; WIDTH], [0.0; WIDTH]);
                (to_rear_x[i], to_rear_y[i]) = ([0.0; WIDTH], [0.0; WIDTH]);
            }
        }
        for i in whole * WIDTH..count * WIDTH {
            for array in [&mut *x, y, vx, vy] {
                array[n + i] = array[i];
            }
            for array in [&mut **front_x, front_y, rear_x, rear_y] {
                array[n + i] = 0.0;
            }
        }
    }
}

/// Return the first `count` packs of an array, and those behind entry `n`.
#[inline(always)]
fn first_packs(array: &mut [f64], n: usize, count: usize) -> (&[Pack], &mut [Pack]) {
    let (first, behind) = array.split_at_mut(n);
    (packs(first, count), packs_mut(behind, count))
}

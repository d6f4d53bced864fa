//! Bushings without hinges: centres and velocities of a sprocket's candidates, for its teeth alone.

use pulp::{Simd, WithSimd};

use super::ends::LinkEnd;
use super::{RepeatBushings, write_sprocket_directions};
use crate::chain::arrays::layout::{ChainArrays, LinkConstants};
use crate::chain::contact::SprocketCandidates;
use crate::math::simd::{Lanes, both_mut, load, partial_load, sin_cos, vectors, vectors_from};

/// Kernel that writes the directions of all sprockets, and places the candidates of one of them, as `EvaluateHinges` does.
pub(crate) struct PlaceBushings<'a> {
    pub(crate) candidates: &'a SprocketCandidates,
    /// x, y \[m\] and θ \[rad\] of the links, and the rates of these coordinates.
    pub(crate) links: [&'a [f64]; 6],
    /// Number of bushings copied behind the last one.
    pub(crate) overhang: usize,
    pub(crate) constants: &'a LinkConstants,
    pub(crate) arrays: &'a mut ChainArrays,
}

impl WithSimd for PlaceBushings<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.links[0].len();
        let blocks = n.div_ceil(S::F64_LANES);
        let whole = blocks - 1;
        let arrays = self.arrays;
        write_sprocket_directions::<S>(simd, arrays);
        let here = self.links.map(|array| vectors::<S>(array, whole));
        let next = self.links.map(|array| vectors_from::<S>(array, 1, whole));
        let on_front = vectors::<S>(&self.constants.bushing_on_front, blocks);
        let front_arm = vectors::<S>(&self.constants.front_arm, blocks);
        let rear_arm = vectors::<S>(&self.constants.rear_arm, blocks);
        let [x, y] = both_mut::<S>(&mut arrays.bushing, 0, blocks);
        let [vx, vy] = both_mut::<S>(&mut arrays.bushing_velocity, 0, blocks);
        for (first, slots) in self.candidates.pieces(n) {
            for i in first / S::F64_LANES..(first + slots.len()).div_ceil(S::F64_LANES) {
                let on_front = load(simd, &on_front[i]).greater(Lanes::splat(simd, 0.0));
                // Bushing k is on the front of link k or on the rear of link k + 1.
                let link = [0, 1, 2, 3, 4, 5].map(|which: usize| {
                    let (front, rear) = if i < whole {
                        (load(simd, &here[which][i]), load(simd, &next[which][i]))
                    } else {
                        let rest = &self.links[which][whole * S::F64_LANES..];
                        let last = partial_load(simd, rest);
                        (last, last.followed_by(self.links[which][0], rest.len()))
                    };
                    on_front.select(front, rear)
                });
                let arm = on_front.select(load(simd, &front_arm[i]), load(simd, &rear_arm[i]));
                let [place_x, place_y, angle, speed_x, speed_y, spin] = link;
                let (sin, cos) = sin_cos(angle);
                let end = LinkEnd::new([place_x, place_y, speed_x, speed_y, spin], [arm, cos, sin]);
                (x[i], y[i]) = (end.x.values(), end.y.values());
                (vx[i], vy[i]) = (end.vx.values(), end.vy.values());
            }
        }
        RepeatBushings {
            links: n,
            overhang: self.overhang,
            arrays,
        }
        .with_simd(simd);
    }
}

//! Gap of an undamaged ANSI tooth for a SIMD vector of bushings: nearest of the four surfaces, penetration and its direction of
//! growth.

use pulp::Simd;

use super::gap::{Gap, GapConstants, InGap};
use crate::chain::contact::surface_constants;
use crate::chain::model::Model;
use crate::geometry::{AnsiCurves, Surface, ToothProfile, Vec2};
use crate::math::simd::{Lanes, Mask, Pack8, read};

/// Dimensions of a tooth gap and the constants of its four surfaces, each for all lanes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AnsiGap {
    seat_center_radius: Pack8,
    seat_end_tangent: [Pack8; 2],
    working_center: [Pack8; 2],
    flat_start: [Pack8; 2],
    flat_tangent: [Pack8; 2],
    flat_normal: [Pack8; 2],
    flat_length: Pack8,
    topping_center: [Pack8; 2],
    /// D of seat, working curve and tip: distance of the centres at which bushing and curve touch \[m\].
    touch: [Pack8; 3],
    bushing_radius: Pack8,
    /// 1/(2 D) of seat and working curve, and -1/(2 D) of the tip, which is convex \[1/m\].
    half_over_touch: [Pack8; 3],
    /// Cosine and sine of half the angle between adjacent gaps.
    half_gap: [Pack8; 2],
    /// Constants of the contact law: [constant][surface].
    law: [[Pack8; 4]; 2],
}

impl AnsiGap {
    /// Return the gap of sprocket `s`.
    pub(crate) fn new(model: &Model, s: usize, curves: &AnsiCurves) -> Self {
        let law = Surface::ANSI.map(|surface| surface_constants(model, s, surface));
        Self::of(
            &model.sprockets[s].profile,
            curves,
            model.teeth.contact_radius,
            law,
        )
    }

    /// Return the gap for cylinders of `radius` on `profile`, with the law constants of the four surfaces.
    fn of(profile: &ToothProfile, curves: &AnsiCurves, radius: f64, law: [[f64; 2]; 4]) -> Self {
        let all = Pack8::all;
        let pair = |v: Vec2| [all(v.x), all(v.y)];
        let (sin, cos) = (0.5 * profile.gap_angle()).sin_cos();
        let touch = [
            curves.seating.radius - radius,
            curves.working.radius - radius,
            curves.topping.radius + radius,
        ];
        Self {
            seat_center_radius: all(profile.seat_center_radius),
            seat_end_tangent: pair(curves.seat_end_tangent),
            working_center: pair(curves.working.center),
            flat_start: pair(curves.flat.start),
            flat_tangent: pair(curves.flat.tangent),
            flat_normal: pair(curves.flat.normal),
            flat_length: all(curves.flat.length),
            topping_center: pair(curves.topping.center),
            touch: touch.map(all),
            bushing_radius: all(radius),
            half_over_touch: [
                all(0.5 / touch[0]),
                all(0.5 / touch[1]),
                all(-0.5 / touch[2]),
            ],
            half_gap: [all(cos), all(sin)],
            law: [0, 1].map(|i| law.map(|constants| all(constants[i]))),
        }
    }
}

/// Gap with its constants for SIMD vectors.
pub(crate) struct AnsiVectors<'a, S: Simd> {
    simd: S,
    constants: &'a AnsiGap,
}

/// Nearest surface of each bushing, position relative to its centre of curvature, and whether bushing and surface overlap.
pub(crate) struct NearestOfFour<S: Simd> {
    seating: Mask<S>,
    working: Mask<S>,
    topping: Mask<S>,
    /// Position of the bushing relative to the centre of curvature; u as on the right flank, v \[m\].
    offset: [Lanes<S>; 2],
    distance_squared: Lanes<S>,
    /// Distance of the centres at which bushing and curve touch \[m\].
    touch: Lanes<S>,
    /// Bushings nearest to the flat, and the penetration there \[m\].
    flat: Option<(Mask<S>, Lanes<S>)>,
    near: Mask<S>,
}

impl GapConstants for AnsiGap {
    type Of<'a, S: Simd> = AnsiVectors<'a, S>;

    #[inline(always)]
    fn gap<S: Simd>(&self, simd: S) -> AnsiVectors<'_, S> {
        AnsiVectors {
            simd,
            constants: self,
        }
    }
}

impl<S: Simd> AnsiVectors<'_, S> {
    /// Return a vector with `value` in all lanes.
    #[inline(always)]
    fn splat(&self, value: f64) -> Lanes<S> {
        Lanes::splat(self.simd, value)
    }

    /// Return a constant of the gap.
    #[inline(always)]
    fn at(&self, constant: &Pack8) -> Lanes<S> {
        constant.at(self.simd, 0)
    }
}

impl<S: Simd> Gap<S> for AnsiVectors<'_, S> {
    type Nearest = NearestOfFour<S>;

    #[inline(always)]
    fn place(&self, arm: [Lanes<S>; 2], direction: [Lanes<S>; 2], gap: [Lanes<S>; 2]) -> InGap<S> {
        InGap::new(arm, direction, gap)
    }

    #[inline(always)]
    fn half_gap(&self) -> [Lanes<S>; 2] {
        read(self.simd, &self.constants.half_gap, 0)
    }

    #[inline(always)]
    fn near(&self, surface: &NearestOfFour<S>) -> Mask<S> {
        surface.near
    }

    #[inline(always)]
    fn nearest(&self, place: &InGap<S>) -> NearestOfFour<S> {
        let c = self.constants;
        let zero = self.splat(0.0);
        let right = place.u.abs();
        let v = place.outward - self.at(&c.seat_center_radius);
        let seating = right
            .mul_add(
                self.at(&c.seat_end_tangent[0]),
                v * self.at(&c.seat_end_tangent[1]),
            )
            .less(zero);
        let from_start = [
            right - self.at(&c.flat_start[0]),
            v - self.at(&c.flat_start[1]),
        ];
        let along = from_start[0].mul_add(
            self.at(&c.flat_tangent[0]),
            from_start[1] * self.at(&c.flat_tangent[1]),
        );
        let working = along.less(zero);
        let topping = along.greater(self.at(&c.flat_length)).and(seating.not());
        let curves = |work, top| working.select(self.at(work), self.at(top));
        let center = |axis: usize| {
            let curve = curves(&c.working_center[axis], &c.topping_center[axis]);
            seating.select(zero, curve)
        };
        let offset = [right - center(0), v - center(1)];
        let [seat, work, top] = &c.touch;
        let touch = seating.select(self.at(seat), curves(work, top));
        let distance_squared = offset[0].mul_add(offset[0], offset[1] * offset[1]);
        // Overlap, without a square root: d > D for the concave curves, d < D for the convex topping curve.
        let beyond = distance_squared - touch * touch;
        let near = topping.select(-beyond, beyond).exceeds(zero);
        let flat = seating.or(working).or(topping).not();
        if !flat.any() {
            return NearestOfFour {
                seating,
                working,
                topping,
                offset,
                distance_squared,
                touch,
                flat: None,
                near,
            };
        }
        // Flat: penetration = (distance of the centre from the line) + radius, along the normal into the material.
        let depth = from_start[0].mul_add(
            self.at(&c.flat_normal[0]),
            from_start[1] * self.at(&c.flat_normal[1]),
        ) + self.at(&c.bushing_radius);
        let near = flat.and(depth.exceeds(zero)).or(flat.not().and(near));
        NearestOfFour {
            seating,
            working,
            topping,
            offset,
            distance_squared,
            touch,
            flat: Some((flat, depth)),
            near,
        }
    }

    #[inline(always)]
    fn depth(
        &self,
        surface: &NearestOfFour<S>,
        place: &InGap<S>,
    ) -> (Lanes<S>, [Lanes<S>; 2], Lanes<S>) {
        let zero = self.splat(0.0);
        let distance = surface.distance_squared.sqrt();
        let inverse = distance
            .exceeds(zero)
            .select(self.splat(1.0) / distance, zero);
        // Curves: penetration = ±(d - D), normal = ±offset/d, curvature = ±1/d; the minus sign holds for the convex topping curve.
        let outside = |value: Lanes<S>| surface.topping.select(-value, value);
        let inverse = outside(inverse);
        let mut curvature = inverse;
        let mut depth = outside(distance - surface.touch);
        let mut normal_u = surface.offset[0] * inverse;
        let mut normal_v = surface.offset[1] * inverse;
        if let Some((flat, flat_depth)) = surface.flat {
            let [flat_u, flat_v] = read(self.simd, &self.constants.flat_normal, 0);
            depth = flat.select(flat_depth, depth);
            curvature = flat.select(zero, curvature);
            normal_u = flat.select(flat_u, normal_u);
            normal_v = flat.select(flat_v, normal_v);
        }
        (
            depth,
            place.to_scene(place.on_left(), [normal_u, normal_v]),
            curvature,
        )
    }

    #[inline(always)]
    fn gap_and_rate(
        &self,
        surface: &NearestOfFour<S>,
        place: &InGap<S>,
        velocity: [Lanes<S>; 2],
    ) -> [Lanes<S>; 2] {
        let [seat, work, top] = &self.constants.half_over_touch;
        let (seating, working) = (surface.seating, surface.working);
        let rest = working.select(self.at(work), self.at(top));
        let scale = seating.select(self.at(seat), rest);
        let [right, outward] = place.in_gap(place.on_left(), velocity);
        let touch = surface.touch;
        // Gap ±(d² - D²)/(2 D) and its rate ±(offset · velocity)/D.
        let mut gap = (surface.distance_squared - touch * touch) * scale;
        let mut rate =
            surface.offset[0].mul_add(right, surface.offset[1] * outward) * (scale + scale);
        if let Some((flat, depth)) = surface.flat {
            let [flat_u, flat_v] = read(self.simd, &self.constants.flat_normal, 0);
            let on_flat = right.mul_add(flat_u, outward * flat_v);
            gap = flat.select(depth, gap);
            rate = flat.select(on_flat, rate);
        }
        [gap, rate]
    }

    #[inline(always)]
    fn surface(&self, surface: &NearestOfFour<S>, place: &InGap<S>) -> (Lanes<S>, Mask<S>) {
        let numbers = Surface::ANSI.map(|surface| Pack8::all(f64::from(surface.0)));
        (self.of_surface(&numbers, surface), place.on_left())
    }

    #[inline(always)]
    fn law_constants(&self, surface: &NearestOfFour<S>) -> [Lanes<S>; 2] {
        let [first, second] = &self.constants.law;
        [
            self.of_surface(first, surface),
            self.of_surface(second, surface),
        ]
    }
}

impl<S: Simd> AnsiVectors<'_, S> {
    /// Return the entry of each bushing's surface from an array ordered seating, working, flat, topping.
    #[inline(always)]
    fn of_surface(
        &self,
        [seat, work, flat, top]: &[Pack8; 4],
        surface: &NearestOfFour<S>,
    ) -> Lanes<S> {
        let rest = surface.topping.select(self.at(top), self.at(flat));
        let rest = surface.working.select(self.at(work), rest);
        surface.seating.select(self.at(seat), rest)
    }
}

#[cfg(test)]
mod tests {
    use pulp::WithSimd;

    use super::*;
    use crate::geometry::Seat;
    use crate::math::simd::InstructionSet;

    const RADIUS: f64 = 3.968_75e-3;

    fn profile(teeth: u32, seat: Seat) -> ToothProfile {
        ToothProfile::ansi(0.0127, 2.0 * RADIUS, teeth, seat)
    }

    /// Kernel for one point: surface, penetration, normal (u, v), and whether bushing and surface overlap.
    struct At<'a>(&'a AnsiGap, Vec2);

    impl WithSimd for At<'_> {
        type Output = (Surface, f64, Vec2, bool);

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let splat = |value| Lanes::splat(simd, value);
            let gap = self.0.gap(simd);
            let along_x = [splat(1.0), splat(0.0)];
            // v along x, so that u is along -y.
            let place = InGap::new([splat(self.1.y), splat(-self.1.x)], along_x, along_x);
            let surface = gap.nearest(&place);
            let (depth, [x, y], _) = gap.depth(&surface, &place);
            let number = gap.law_constants(&surface)[0].greatest();
            let surface_of = |s: &Surface| f64::from(s.0) == number;
            (
                Surface::ANSI.into_iter().find(surface_of).unwrap(),
                depth.greatest(),
                Vec2::new(-y.greatest(), x.greatest()),
                gap.near(&surface).any(),
            )
        }
    }

    /// Return points (u, outward) of both flanks: on the middle of the gap and on the normals at the junctions, and a few units of
    /// rounding beside them.
    fn points(profile: &ToothProfile) -> Vec<Vec2> {
        let c = profile.ansi_curves().unwrap();
        let [x, y] = [c.seat_end_tangent.x, c.seat_end_tangent.y];
        let normals = [
            (Vec2::zeros(), Vec2::new(y, -x)),
            (c.flat.start, c.flat.normal),
            (c.flat.end(), c.flat.normal),
            (Vec2::zeros(), Vec2::new(0.0, -1.0)),
        ];
        let mut points = Vec::new();
        for (foot, normal) in normals {
            for i in -400..=100 {
                let mut point = foot + 1e-5 * f64::from(i) * normal;
                point.y += profile.seat_center_radius;
                for beside in -3..=3 {
                    let u = point.x + f64::from(beside) * f64::EPSILON * RADIUS;
                    points.extend([Vec2::new(u, point.y), Vec2::new(-u, point.y)]);
                }
            }
        }
        points
    }

    /// Compare with the scalar reference implementation at the same point: penetrations to 2 units of rounding of the distance of
    /// centres, normals to 4.
    #[test]
    fn a_point_on_every_surface_and_junction_has_the_depth_and_normal_of_the_twin() {
        let law = [0.0, 1.0, 2.0, 3.0].map(|number| [number, 0.0]);
        let mut seen = [0; 4];
        for teeth in [6, 9, 17, 60, 150] {
            for seat in [Seat::BottomDiameter, Seat::PitchCircle] {
                let profile = profile(teeth, seat);
                let curves = profile.ansi_curves().unwrap();
                let constants = AnsiGap::of(&profile, curves, RADIUS, law);
                for point in points(&profile) {
                    let in_gap = point - Vec2::new(0.0, profile.seat_center_radius);
                    let twin = profile.contact(in_gap, RADIUS);
                    seen[twin.surface.index()] += 1;
                    for set in InstructionSet::available() {
                        let (surface, depth, normal, near) = set.run(At(&constants, point));
                        let what =
                            format!("{} {teeth} teeth at {in_gap:?}: {surface:?}", set.name());
                        // On a junction either of the two surfaces is nearest; they have a common normal there.
                        let same = profile.contact_with(surface, in_gap, RADIUS);
                        assert!(surface.0.abs_diff(twin.surface.0) <= 1, "{what}");
                        assert!(
                            (same.penetration - twin.penetration).abs() < 1e-17,
                            "{what}"
                        );
                        let size = 4.0 * RADIUS;
                        let off = (depth - same.penetration).abs();
                        assert!(off <= 2.0 * f64::EPSILON * size, "{what}: {off:e}");
                        let distance = (in_gap.norm() > 1e-4) || surface != Surface::SEATING;
                        let turned = (normal - same.normal).amax();
                        assert!(
                            turned <= 4.0 * f64::EPSILON || !distance,
                            "{what}: {turned:e}"
                        );
                        assert!(near || depth <= 0.0, "{what}: {depth:e} unseen");
                        assert!(!near || depth >= 0.0, "{what}: {depth:e}");
                    }
                }
            }
        }
        assert!(seen.iter().all(|&count| count > 1000), "{seen:?}");
    }
}

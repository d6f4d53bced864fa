//! Path of a circle's centre within one step in the frame of the profile, and bounds of the penetration along it.

use crate::geometry::Vec2;

/// Penetration (or gap) \[m\] below which a contact (or separation) that begins and ends within a step is neglected. The contact
/// force of a steel pin of 10 mm is then below 0.01 N. A tenth of it doubles the evaluations along a grazing path.
pub(crate) const UNSEEN: f64 = 1e-9;

/// Position \[m\], velocity \[m/s\] and acceleration \[m/s²\] of a circle's centre at one end of a step.
pub(crate) type PointMotion = [Vec2; 3];

/// Polynomial path of fifth order through position, velocity and acceleration at both ends, as control points of a Bézier curve.
///
/// Differences of the control points bound its derivatives. The parameter is the time over the length of the step. The error is
/// h⁶/46080 of the sixth derivative: 3.4e-7 radii for a point on a circle that turns by half a radian in a step of h.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactPath([Vec2; 6]);

/// Penetration of a circle of `radius` \[m\] by the position of its centre \[m\], positive in contact.
pub(crate) struct Depth<F> {
    pub(crate) radius: f64,
    pub(crate) at: F,
}

impl ContactPath {
    /// Return the path through both ends of a step of `length` \[s\].
    pub(crate) fn through([p, v, a]: PointMotion, [q, w, b]: PointMotion, length: f64) -> Self {
        // Control points of a Bézier curve of degree 5: P₁ = p + v h/5, P₂ = p + 2 v h/5 + a h²/20, and mirrored at the other end.
        let (first, second) = (length / 5.0, length * length / 20.0);
        Self([
            p,
            p + first * v,
            p + 2.0 * first * v + second * a,
            q - 2.0 * first * w + second * b,
            q - first * w,
            q,
        ])
    }

    /// Return the position at the parameter `part`, from 0 to 1.
    pub(crate) fn at(&self, part: f64) -> Vec2 {
        self.split(part).0.0[5]
    }

    /// Return the paths before and after the parameter `part` (de Casteljau's algorithm).
    fn split(&self, part: f64) -> (Self, Self) {
        let mut points = self.0;
        let (mut before, mut after) = (*self, *self);
        for k in 0..6 {
            before.0[k] = points[0];
            after.0[5 - k] = points[5 - k];
            for i in 0..5 - k {
                points[i] += part * (points[i + 1] - points[i]);
            }
        }
        (before, after)
    }

    /// Return an upper bound of the velocity: 5 max |`P_(i+1)` - `P_i`| \[m per step\].
    fn speed(&self) -> f64 {
        let sides = self.0.windows(2).map(|pair| (pair[1] - pair[0]).norm());
        5.0 * sides.fold(0.0, f64::max)
    }

    /// Return an upper bound of the acceleration: 20 max |`P_(i+2)` - 2 `P_(i+1)` + `P_i`| \[m per step²\].
    fn acceleration(&self) -> f64 {
        let bends = (self.0.windows(3)).map(|three| (three[2] - 2.0 * three[1] + three[0]).norm());
        20.0 * bends.fold(0.0, f64::max)
    }

    /// Return the displacement below which the path is a point \[m\]: its control points are rounded.
    fn rounding(&self) -> f64 {
        let largest = self.0.iter().fold(0.0, |most: f64, p| most.max(p.amax()));
        64.0 * f64::EPSILON * largest
    }

    /// Return whether the penetration exceeds `level` along the path; it does not at both ends, where it is `start` and `end`.
    ///
    /// The second derivative of the distance d from any closed set is at most 1/d across the direction to the set. With velocity v
    /// and acceleration a, the second derivative of the penetration of a circle of radius R is at least -(|a| + v²/R). The penetration
    /// exceeds the chord between its ends by at most an eighth of that bound. A path whose bound exceeds the level is halved.
    pub(crate) fn rises_above<F: Fn(Vec2) -> f64>(
        &self,
        level: f64,
        [start, end]: [f64; 2],
        depth: &Depth<F>,
    ) -> bool {
        let curvature = self.acceleration() + self.speed().powi(2) / depth.radius;
        let highest = start.max(end) + 0.125 * curvature;
        if !highest.is_finite() || highest <= level || self.speed() <= self.rounding() {
            return false;
        }
        let (before, after) = self.split(0.5);
        let middle = (depth.at)(after.0[0]);
        middle > level
            || before.rises_above(level, [start, middle], depth)
            || after.rises_above(level, [middle, end], depth)
    }

    /// Return whether a contact that ends along the path begins again before the path's end, where the penetration is `end`.
    ///
    /// Bisection for the contact end. A half with contact at both ends is searched for a separation, one without for a contact.
    pub(crate) fn touches_again<F: Fn(Vec2) -> f64>(&self, end: f64, depth: &Depth<F>) -> bool {
        let (mut path, mut end) = (*self, end);
        // The bound of the velocity is also that of the displacement along the rest of the path, whose length is one.
        while path.speed() > UNSEEN.max(path.rounding()) {
            let (before, after) = path.split(0.5);
            let middle = (depth.at)(after.0[0]);
            if middle > 0.0 {
                if before.parts(depth) {
                    return true;
                }
                path = after;
            } else {
                if after.rises_above(UNSEEN, [middle, end], depth) {
                    return true;
                }
                (path, end) = (before, middle);
            }
        }
        false
    }

    /// Return whether a path with contact at both ends has a separation. The path is halved towards its beginning, where the present
    /// contact would end.
    fn parts<F: Fn(Vec2) -> f64>(&self, depth: &Depth<F>) -> bool {
        let mut path = *self;
        while path.speed() > UNSEEN.max(path.rounding()) {
            let (before, after) = path.split(0.5);
            if (depth.at)(after.0[0]) < -UNSEEN {
                return true;
            }
            path = before;
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn a_search_far_from_the_origin_ends_at_the_rounding_of_coordinates() {
        let far = 1e7;
        let depth = Depth {
            radius: 1.0,
            at: |p: Vec2| (p.x - far).abs() - 0.5,
        };
        let motion = |x: f64| {
            [
                Vec2::new(far + x, far + x),
                Vec2::new(1.0, 1.0),
                Vec2::zeros(),
            ]
        };
        let path = ContactPath::through(motion(0.6), motion(0.4), 0.1);
        assert!(!path.touches_again((depth.at)(path.0[5]), &depth));
        assert!(path.rounding() < 1e-6);
    }

    /// Return the path of a throw from `start` under a downward acceleration, for a time of one second.
    fn thrown(start: Vec2, velocity: Vec2, acceleration: f64) -> ContactPath {
        let a = Vec2::new(0.0, -acceleration);
        let end = start + velocity + 0.5 * a;
        ContactPath::through([start, velocity, a], [end, velocity + a, a], 1.0)
    }

    /// Return the penetration of a circle of radius 1 in a bore of radius 1.5.
    fn in_bore(place: Vec2) -> f64 {
        place.norm() - 0.5
    }

    #[test]
    fn a_path_meets_what_it_was_laid_through() {
        let path = thrown(Vec2::new(0.1, -0.2), Vec2::new(0.3, 2.0), 4.0);
        for part in [0.0, 0.2, 0.7, 1.0] {
            let exact = Vec2::new(0.1 + 0.3 * part, -0.2 + 2.0 * part - 2.0 * part * part);
            assert!((path.at(part) - exact).norm() < 1e-15);
        }
    }

    #[test]
    fn an_arch_through_the_wall_is_found_however_little_it_is_in_it() {
        for excess in [1e-1, 1e-3, 1e-5, 1e-8] {
            for sign in [1.0, -1.0] {
                // The highest point is y = 0.5 ± excess.
                let top: f64 = 0.5 + sign * excess;
                let path = thrown(Vec2::zeros(), Vec2::new(0.0, 4.0 * top), 8.0 * top);
                let asked = Cell::new(0);
                let depth = Depth {
                    radius: 1.0,
                    at: |place| {
                        asked.set(asked.get() + 1);
                        in_bore(place)
                    },
                };
                let end = in_bore(path.at(1.0));
                let found = path.rises_above(UNSEEN, [-0.5, end], &depth);
                assert_eq!(found, sign > 0.0, "{excess}");
                assert!(asked.get() < 40, "{excess}: {}", asked.get());
            }
        }
    }

    #[test]
    fn a_second_touch_after_the_end_of_a_contact_is_found() {
        let depth = Depth {
            radius: 1.0,
            at: in_bore,
        };
        for (top, again) in [(0.6, true), (0.4, false)] {
            // The path runs from the lower wall over its highest point `top` back to the middle.
            let speed = |rise: f64, g: f64| (2.0 * g * rise).sqrt();
            let g = (speed(top + 0.51, 1.0) + speed(top, 1.0)).powi(2);
            let path = thrown(
                Vec2::new(0.0, -0.51),
                Vec2::new(0.0, speed(top + 0.51, g)),
                g,
            );
            let end = in_bore(path.at(1.0));
            assert!(end < -0.49);
            assert_eq!(path.touches_again(end, &depth), again);
        }
    }
    /// Return the path of x = t⁵ - t², y = 2 + t⁴ over a step from `start` \[s\] of `length` \[s\].
    fn quintic(start: f64, length: f64) -> (ContactPath, impl Fn(f64) -> Vec2) {
        let place = |t: f64| Vec2::new(t.powi(5) - t * t, 2.0 + t.powi(4));
        let motion = |t: f64| {
            [
                place(t),
                Vec2::new(5.0 * t.powi(4) - 2.0 * t, 4.0 * t.powi(3)),
                Vec2::new(20.0 * t.powi(3) - 2.0, 12.0 * t * t),
            ]
        };
        let path = ContactPath::through(motion(start), motion(start + length), length);
        (path, move |part: f64| place(start + part * length))
    }

    #[test]
    fn a_polynomial_of_fifth_order_is_its_own_path_and_both_halves_are_parts_of_it() {
        let (path, exact) = quintic(-0.4, 1.3);
        for cut in [0.0, 0.3, 0.5, 1.0] {
            let (before, after) = path.split(cut);
            for part in [0.0, 0.25, 0.6, 1.0] {
                // Rounding of about ten operations with numbers below 4.
                assert!((path.at(part) - exact(part)).norm() < 1e-14);
                assert!((before.at(part) - exact(part * cut)).norm() < 1e-14);
                assert!((after.at(part) - exact(cut + part * (1.0 - cut))).norm() < 1e-14);
            }
        }
    }

    #[test]
    fn bounds_of_velocity_and_acceleration_hold_and_are_reached_by_constant_ones() {
        let (path, exact) = quintic(-0.4, 1.3);
        let h = 1e-4;
        for k in 1..1000 {
            let part = f64::from(k) * 1e-3;
            let [before, here, after] = [-h, 0.0, h].map(|step| exact(part + step));
            let speed = (after - before).norm() / (2.0 * h);
            let acceleration = (after - 2.0 * here + before).norm() / (h * h);
            // Errors of the differences are of the order h² and of rounding over h².
            assert!(speed < path.speed() + 1e-5, "{part}");
            assert!(acceleration < path.acceleration() + 1e-4, "{part}");
        }
        let (v, a, length) = (Vec2::new(3.0, 4.0), Vec2::new(-6.0, 8.0), 0.5);
        let steady = [Vec2::new(0.1, -0.7), Vec2::new(0.1, -0.7) + length * v];
        let path = ContactPath::through(
            [steady[0], v, Vec2::zeros()],
            [steady[1], v, Vec2::zeros()],
            length,
        );
        // 5 m/s over half a second.
        assert!((path.speed() - 2.5).abs() < 1e-14 && path.acceleration() < 1e-13);
        let end = [
            steady[0] + length * v + 0.5 * length * length * a,
            v + length * a,
            a,
        ];
        let path = ContactPath::through([steady[0], v, a], end, length);
        // 10 m/s² over half a second, squared.
        assert!((path.acceleration() - 2.5).abs() < 1e-13);
    }

    #[test]
    fn a_path_is_a_point_only_below_a_few_roundings_of_its_farthest_coordinate() {
        for farthest in [1e7, 3.0, 1e-3] {
            let place = Vec2::new(-farthest, 0.1 * farthest);
            let motion = [place, Vec2::zeros(), Vec2::zeros()];
            let rounding = ContactPath::through(motion, motion, 1.0).rounding();
            // Each of six halvings of a control point adds half a unit in the last place.
            let unit = f64::EPSILON * farthest;
            assert!(rounding > 3.0 * unit && rounding < 200.0 * unit);
        }
    }

    /// Return the path along x from 0 to `length` in one second, at constant velocity and height `y`.
    fn straight(length: f64, y: f64) -> ContactPath {
        let v = Vec2::new(length, 0.0);
        let at = |x: f64| [Vec2::new(x, y), v, Vec2::zeros()];
        ContactPath::through(at(0.0), at(length), 1.0)
    }

    #[test]
    fn a_small_circle_that_passes_a_point_is_found_by_the_curvature_of_its_distance() {
        // A point obstacle is at distance R - 1e-7 from the line. Halvings of the path do not meet the nearest place.
        let (radius, length) = (0.01, 0.004);
        for (near, excess) in [(0.3, 1e-7), (0.62, 1e-7), (0.62, -1e-7)] {
            let corner = Vec2::new(near * length, radius - excess);
            let depth = Depth {
                radius,
                at: |place: Vec2| radius - (place - corner).norm(),
            };
            let path = straight(length, 0.0);
            let ends = [0.0, 1.0].map(|part| (depth.at)(path.at(part)));
            assert!(ends[0].max(ends[1]) < -1e-5);
            assert_eq!(path.rises_above(UNSEEN, ends, &depth), excess > 0.0);
            assert!(!path.rises_above(1.1e-7, ends, &depth));
        }
    }

    #[test]
    fn a_path_at_an_undefined_state_has_no_contact() {
        let depth = Depth {
            radius: 1.0,
            at: |_: Vec2| f64::NAN,
        };
        let nowhere = [Vec2::repeat(f64::NAN); 3];
        let here = [Vec2::zeros(); 3];
        let path = ContactPath::through(here, nowhere, 1.0);
        assert!(!path.rises_above(UNSEEN, [-0.1, f64::NAN], &depth));
    }

    #[test]
    fn a_second_obstacle_is_met_again_wherever_it_stands() {
        // A circle of radius 0.1 leaves a point at x = 0 and passes another one, which is nearer than its radius.
        let second = |x: f64| Depth {
            radius: 0.1,
            at: move |place: Vec2| 0.1 - place.norm().min((place.x - x).hypot(0.03)),
        };
        for k in 0..48 {
            let x = 0.3 + 0.0125 * f64::from(k);
            let (path, depth) = (straight(1.0, 0.0), second(x));
            let end = (depth.at)(path.at(1.0));
            assert!(end < 0.0 && path.touches_again(end, &depth), "{x}");
        }
        // A point out of reach of the path: the contact has only ended.
        let alone = second(1e3);
        assert!(!straight(1.0, 0.0).touches_again(-0.9, &alone));
    }

    #[test]
    fn a_separation_below_the_neglected_one_is_none() {
        let path = straight(1.0, 0.0);
        for (dip, parts) in [(0.5, false), (-0.5, false), (-2.0, true)] {
            // In contact up to 0.6, except for the penetration `dip` about 0.125, where the first half is cut twice.
            let depth = Depth {
                radius: 0.1,
                at: |place: Vec2| match place.x {
                    x if (x - 0.125).abs() < 0.01 => dip * UNSEEN,
                    x if x < 0.6 => 0.01,
                    _ => -0.01,
                },
            };
            assert_eq!(path.touches_again(-0.01, &depth), parts, "{dip}");
            let half = path.split(0.5).0;
            assert_eq!(half.parts(&depth), parts, "{dip}");
        }
    }
}

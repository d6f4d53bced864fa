//! The path of a circle's centre within one step, seen from the profile: what the depth does between its ends.

use crate::geometry::Vec2;

/// Depth \[m\] of a contact that opens and closes again within a step, or the reverse, below which it counts as none: a steel
/// pin of 10 mm presses with less than 0.01 N there. A tenth of it doubles the depths evaluated along a grazing path.
pub(crate) const UNSEEN: f64 = 1e-9;

/// Place \[m\], velocity \[m/s\] and acceleration \[m/s²\] of a centre at one end of a step.
pub(crate) type Motion = [Vec2; 3];

/// A path of fifth order through place, velocity and acceleration at both ends, as the control points of a Bézier curve: differences
/// of these bound its derivatives. Times and derivatives are in parts of its length. Its error, h⁶/46080 of the sixth derivative, is
/// 2e-8 radii where a body turns by half a radian in a step of h.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactPath([Vec2; 6]);

/// Depth of a contact by place \[m\], positive where the circle of `radius` touches.
pub(crate) struct Depth<F> {
    pub(crate) radius: f64,
    pub(crate) at: F,
}

impl ContactPath {
    /// Through both ends of a step of `length` \[s\].
    pub(crate) fn through([p, v, a]: Motion, [q, w, b]: Motion, length: f64) -> Self {
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

    /// The place at a part of its length.
    pub(crate) fn at(&self, part: f64) -> Vec2 {
        self.split(part).0.0[5]
    }

    /// The paths before and after a part of its length (de Casteljau).
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

    /// Bound of its velocity.
    fn speed(&self) -> f64 {
        let sides = self.0.windows(2).map(|pair| (pair[1] - pair[0]).norm());
        5.0 * sides.fold(0.0, f64::max)
    }

    /// Bound of its acceleration.
    fn acceleration(&self) -> f64 {
        let bends = (self.0.windows(3)).map(|three| (three[2] - 2.0 * three[1] + three[0]).norm());
        20.0 * bends.fold(0.0, f64::max)
    }

    /// Whether the depth is above `level` somewhere, with the depths at both ends, neither of them above it.
    ///
    /// The distance d from any closed set curves upwards by no more than 1/d across the direction to it. So with velocity v and
    /// acceleration a, the depth of a circle of radius R curves downwards by no more than |a| + v²/R, and is above the chord of
    /// its ends by no more than an eighth of that. A path whose bound is above the level is halved.
    pub(crate) fn rises_above<F: Fn(Vec2) -> f64>(
        &self,
        level: f64,
        [start, end]: [f64; 2],
        depth: &Depth<F>,
    ) -> bool {
        let curvature = self.acceleration() + self.speed().powi(2) / depth.radius;
        let highest = start.max(end) + 0.125 * curvature;
        if !highest.is_finite() || highest <= level {
            return false;
        }
        let (before, after) = self.split(0.5);
        let middle = (depth.at)(after.0[0]);
        middle > level
            || before.rises_above(level, [start, middle], depth)
            || after.rises_above(level, [middle, end], depth)
    }

    /// Whether a contact that ends along it, apart with the depth `end`, begins anew before its end.
    pub(crate) fn touches_again<F: Fn(Vec2) -> f64>(&self, end: f64, depth: &Depth<F>) -> bool {
        let (mut path, mut end) = (*self, end);
        while path.speed() > UNSEEN {
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

    /// Whether a contact is apart at some place of a path that begins and ends in touch; looked for near the beginning, where the
    /// contact ends that was there.
    fn parts<F: Fn(Vec2) -> f64>(&self, depth: &Depth<F>) -> bool {
        let mut path = *self;
        while path.speed() > UNSEEN {
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

    /// A path thrown up from `start` under a downward acceleration, over a time of one second.
    fn thrown(start: Vec2, velocity: Vec2, acceleration: f64) -> ContactPath {
        let a = Vec2::new(0.0, -acceleration);
        let end = start + velocity + 0.5 * a;
        ContactPath::through([start, velocity, a], [end, velocity + a, a], 1.0)
    }

    /// Depth of a circle of radius 1 in a bore of radius 1.5.
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
                // Highest at y = 0.5 ± excess, where it has turned.
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
            // From the lower wall, over its highest place at `top`, back to the middle.
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
}

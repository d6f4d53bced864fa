//! Event location: time and initial impact velocity of a contact onset within the last step, as a root of the dense output.

use crate::geometry::Contact;

/// Share of the step below which a correction of the root is the last one.
///
/// Newton's method converges quadratically: the next correction is about the square, 1e-14, which is rounding.
const SETTLED: f64 = 1e-7;

/// Iterations after which the bracket is the result; bisection alone reaches rounding in 53. Doubled: no change.
const MAX_ITERATIONS: u32 = 100;

/// Share of the step below which a correction of the first guess is the last one.
///
/// The interpolant itself is no more accurate in most steps. Doubled: at most one evaluation more per onset.
const GUESS_SETTLED: f64 = 1e-4;

/// Newton steps of the first guess on the cubic, which cost no evaluation of the contact.
const GUESS_ITERATIONS: u32 = 4;

/// Return the time in (`start`, `end`] of the last crossing of the penetration from negative to positive, and the penetration rate
/// there.
///
/// `contact` returns penetration and rate of the pair at a time of the last step. The pair is in contact at `end`. If it is also in
/// contact at `start` and the cubic shows no separation, `start` is returned.
pub fn onset_in_step(contact: impl Fn(f64) -> Contact, start: f64, end: f64) -> (f64, f64) {
    let ends = [
        penetration_and_rate(&contact, start),
        penetration_and_rate(&contact, end),
    ];
    onset_between(contact, [start, end], ends)
}

/// Return the same from known penetrations \[m\] and rates \[m/s\] at both ends.
///
/// Newton's method from the root of the cubic Hermite interpolant, safeguarded by bisection. Where the cubic is negative inside the
/// step, the last crossing is returned: the onset of the contact that exists at the end.
pub fn onset_between(
    contact: impl Fn(f64) -> Contact,
    [start, end]: [f64; 2],
    [at_start, at_end]: [[f64; 2]; 2],
) -> (f64, f64) {
    let length = end - start;
    let cubic = Cubic::through(at_start, at_end, length);
    let apart = cubic.lowest_inside();
    if at_start[0] >= 0.0 && apart.is_none() {
        // The dense output is discontinuous between two steps, by about the tolerance.
        return (start, at_start[1]);
    }
    if at_end[0] <= 0.0 {
        // After an implicit step the penetration at the end is that of the last evaluation, which differs by about the tolerance.
        return (end, at_end[1]);
    }
    // The bracket begins at the last minimum below zero: the root after it is the onset.
    let mut low = start + apart.unwrap_or(0.0) * length;
    let mut high = end;
    let mut t = start + cubic.upward_root(apart.unwrap_or(0.0)) * length;
    let mut last = (end, at_end[1]);
    for _ in 0..MAX_ITERATIONS {
        let [value, rate] = penetration_and_rate(&contact, t);
        // Newton's method on the dense output.
        let correction = -value / rate;
        if rate > 0.0 && correction.abs() <= SETTLED * length {
            // Linear extrapolation of the rate to the root.
            let slope = if t == last.0 {
                0.0
            } else {
                (rate - last.1) / (t - last.0)
            };
            let root = (t + correction).clamp(start, end);
            return (root, rate + slope * (root - t));
        }
        if value > 0.0 {
            high = t;
        } else {
            low = t;
        }
        last = (t, rate);
        let newton = t + correction;
        // Bisection where Newton's step leaves the bracket.
        t = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        if t <= low || t >= high {
            break;
        }
    }
    last
}

/// Return the penetration \[m\], negative when apart, and its rate \[m/s\].
fn penetration_and_rate(contact: &impl Fn(f64) -> Contact, t: f64) -> [f64; 2] {
    let found = contact(t);
    [found.penetration, found.penetration_rate]
}

/// Cubic Hermite interpolant of a penetration over a step, which goes from 0 to 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cubic([f64; 4]);

impl Cubic {
    /// Return the interpolant of penetrations \[m\] and rates \[m/s\] at the ends of a step of `length` \[s\].
    pub(crate) fn through([d0, r0]: [f64; 2], [d1, r1]: [f64; 2], length: f64) -> Self {
        let (rise, from, to) = (d1 - d0, r0 * length, r1 * length);
        Self([
            d0,
            from,
            3.0 * rise - 2.0 * from - to,
            from + to - 2.0 * rise,
        ])
    }

    fn value(&self, x: f64) -> f64 {
        let [a, b, c, d] = self.0;
        a + x * (b + x * (c + x * d))
    }

    fn slope(&self, x: f64) -> f64 {
        let [_, b, c, d] = self.0;
        b + x * (2.0 * c + x * 3.0 * d)
    }

    /// Return the position of the minimum inside the step, if its value is negative.
    pub(crate) fn lowest_inside(&self) -> Option<f64> {
        self.minimum_inside().filter(|&x| self.value(x) < 0.0)
    }

    /// Return the position of the minimum inside the step: a root of the quadratic derivative, in the form without cancellation.
    fn minimum_inside(&self) -> Option<f64> {
        let [_, b, c, d] = self.0;
        // p'(x) = b + 2 c x + 3 d x² = 0 with p'' > 0; NaN without extremum.
        let root = (c * c - 3.0 * b * d).sqrt();
        let x = if c > 0.0 {
            -b / (c + root)
        } else {
            (root - c) / (3.0 * d)
        };
        (x > 0.0 && x < 1.0).then_some(x)
    }

    /// Return the value of the maximum inside the step.
    pub(crate) fn highest_inside(&self) -> Option<f64> {
        let mirrored = Self(self.0.map(|coefficient| -coefficient));
        mirrored.minimum_inside().map(|x| self.value(x))
    }

    /// Return an approximate root between `low`, where the value is not positive, and 1.
    ///
    /// Four safeguarded Newton steps: the root is a first guess only.
    fn upward_root(&self, mut low: f64) -> f64 {
        let mut high = 1.0;
        let (below, above) = (self.value(low), self.value(high));
        let mut x = low + (high - low) * below / (below - above);
        if !(x > low && x < high) {
            return 0.5 * (low + high);
        }
        for _ in 0..GUESS_ITERATIONS {
            let value = self.value(x);
            if value > 0.0 {
                high = x;
            } else {
                low = x;
            }
            let newton = x - value / self.slope(x);
            let settled = (newton - x).abs() < GUESS_SETTLED;
            x = if newton > low && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
            if settled {
                break;
            }
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;
    use crate::geometry::Vec2;

    /// Return time and rate of the onset of a penetration, and the number of its evaluations.
    fn crossing(depth: impl Fn(f64) -> [f64; 2], start: f64, end: f64) -> ([f64; 2], u32) {
        let asked = Cell::new(0);
        let contact = |t| {
            asked.set(asked.get() + 1);
            let [penetration, penetration_rate] = depth(t);
            Contact {
                normal: Vec2::zeros(),
                penetration,
                penetration_rate,
            }
        };
        let (t, rate) = onset_in_step(contact, start, end);
        ([t, rate], asked.get())
    }

    #[test]
    fn a_crossing_is_found_to_rounding_in_few_evaluations() {
        for part in [1e-6, 0.01, 0.3, 0.5, 0.9, 1.0 - 1e-9] {
            // Through zero at `part` of the step, with a rate that doubles in it.
            let depth = |t: f64| [(t - part).exp() - 1.0, (t - part).exp()];
            let ([t, rate], asked) = crossing(depth, 0.0, 1.0);
            assert!((t - part).abs() < 4e-15, "{part}: {t}");
            assert!((rate - 1.0).abs() < 1e-10, "{part}: {rate}");
            assert!(asked <= 5, "{part}: {asked}");
        }
    }

    #[test]
    fn a_grazing_crossing_is_found() {
        let depth = |t: f64| [(t - 0.7).powi(3), 3.0 * (t - 0.7).powi(2)];
        let ([t, rate], _) = crossing(depth, 0.0, 1.0);
        assert!((t - 0.7).abs() < 1e-5 && rate < 1e-9, "{t} {rate}");
    }

    #[test]
    fn of_two_crossings_the_last_one_counts() {
        // Apart, touching from 0.1 on, apart from 0.2 on, touching from 0.8 on.
        let root = |t: f64| [t - 0.1, t - 0.2, t - 0.8];
        let depth = |t: f64| {
            let [a, b, c] = root(t);
            [a * b * c, a * b + a * c + b * c]
        };
        for start in [0.0, 0.15] {
            let ([t, rate], _) = crossing(depth, start, 1.0);
            assert!(
                (t - 0.8).abs() < 1e-12 && (rate - 0.42).abs() < 1e-9,
                "{t} {rate}"
            );
        }
    }

    #[test]
    fn the_onset_of_a_pair_in_contact_at_the_start_is_the_start() {
        let ([t, rate], _) = crossing(|t| [1e-12 + t, 1.0], 0.0, 1.0);
        assert_eq!([t, rate], [0.0, 1.0]);
    }

    /// The cubic `a + b t + c t² + d t³` over the step from `start` of `length`.
    fn interpolant([a, b, c, d]: [f64; 4], start: f64, length: f64) -> Cubic {
        let at = |t: f64| {
            [
                a + t * (b + t * (c + t * d)),
                b + t * (2.0 * c + t * 3.0 * d),
            ]
        };
        Cubic::through(at(start), at(start + length), length)
    }

    #[test]
    fn the_interpolant_of_a_cubic_is_that_cubic() {
        let (start, length) = (0.3, 0.5);
        let cubic = interpolant([0.7, -1.1, 0.4, 2.3], start, length);
        for x in [0.0, 0.2, 0.6, 1.0] {
            let t: f64 = start + x * length;
            let value = 0.7 - 1.1 * t + 0.4 * t * t + 2.3 * t.powi(3);
            let slope = length * (-1.1 + 0.8 * t + 6.9 * t * t);
            assert!((cubic.value(x) - value).abs() < 1e-14, "{x}");
            assert!((cubic.slope(x) - slope).abs() < 1e-13, "{x}");
        }
    }

    #[test]
    fn extrema_inside_the_step_are_found_for_both_signs_of_the_curvature() {
        // p' = ±3 (x - 0.25)(x - 0.9): the minimum is the second extremum, then the first one.
        let value = |x: f64| x.powi(3) - 1.725 * x * x + 0.675 * x;
        let rising = |a: f64| interpolant([a, 0.675, -1.725, 1.0], 0.0, 1.0);
        let falling = |a: f64| interpolant([a, -0.675, 1.725, -1.0], 0.0, 1.0);
        assert!((rising(0.0).minimum_inside().unwrap() - 0.9).abs() < 1e-14);
        assert!((falling(0.0).minimum_inside().unwrap() - 0.25).abs() < 1e-14);
        assert!((rising(0.3).highest_inside().unwrap() - 0.3 - value(0.25)).abs() < 1e-14);
        assert!((falling(0.3).highest_inside().unwrap() - 0.3 + value(0.9)).abs() < 1e-14);
        // Only a minimum below zero is a separation.
        assert!(falling(value(0.25) + 1e-6).lowest_inside().is_none());
        assert!(falling(value(0.25) - 1e-6).lowest_inside().is_some());
        // Extrema at -0.1 and 1.2 are outside.
        assert!(
            interpolant([0.0, -0.36, -1.65, 1.0], 0.0, 1.0)
                .minimum_inside()
                .is_none()
        );
    }

    #[test]
    fn the_first_guess_is_a_root_of_the_interpolant() {
        // (t - 0.1)(t - 0.2)(t - 0.8), negative between the last two roots.
        let cubic = interpolant([-0.016, 0.26, -1.1, 1.0], 0.0, 1.0);
        let low = cubic.lowest_inside().unwrap();
        assert!((cubic.upward_root(low) - 0.8).abs() < 1e-3);
        assert!(
            (interpolant([-0.09, 0.0, 1.0, 0.0], 0.0, 1.0).upward_root(0.0) - 0.3).abs() < 1e-3
        );
    }

    #[test]
    fn a_crossing_in_a_late_short_step_is_found_in_few_evaluations() {
        for part in [0.02, 0.4, 0.93] {
            let root = 10.0 + 0.25 * part;
            let depth = |t: f64| [(t - root).exp() - 1.0, (t - root).exp()];
            let ([t, rate], asked) = crossing(depth, 10.0, 10.25);
            assert!(
                (t - root).abs() < 1e-14 && (rate - 1.0).abs() < 1e-10,
                "{part}: {t}"
            );
            assert!(asked <= 4, "{part}: {asked}");
        }
        // Apart again inside the late step: the last crossing counts.
        let depth = |t: f64| {
            let x = 4.0 * (t - 10.0);
            let [a, b, c] = [x - 0.1, x - 0.2, x - 0.8];
            [a * b * c, 4.0 * (a * b + a * c + b * c)]
        };
        let ([t, rate], _) = crossing(depth, 10.0375, 10.25);
        assert!(
            (t - 10.2).abs() < 1e-12 && (rate - 1.68).abs() < 1e-7,
            "{t} {rate}"
        );
    }

    #[test]
    fn bisection_finds_a_crossing_at_which_newtons_method_leaves_the_step() {
        let depth = |t: f64| {
            let x = 200.0 * (t - 0.77);
            [x.atan(), 200.0 / (1.0 + x * x)]
        };
        let ([t, rate], asked) = crossing(depth, 0.0, 1.0);
        assert!((t - 0.77).abs() < 1e-12, "{t}");
        assert!((rate - 200.0).abs() < 1e-3 && asked < 30, "{rate} {asked}");
    }

    #[test]
    fn bisection_stays_behind_the_minimum_of_the_interpolant() {
        // In contact at the start, apart, and in contact from about 0.6 on with a rate that is small soon after it: Newton's steps leave
        // the bracket, whose lower end is the minimum. A bracket from the start or before would contain the first contact, too.
        let depth = |t: f64| {
            let (x, fading) = (100.0 * (t - 10.6), 6.0 * ((10.0 - t) / 0.15).exp());
            [x.atan() + fading, 100.0 / (1.0 + x * x) - fading / 0.15]
        };
        let ([t, _], asked) = crossing(depth, 10.0, 11.0);
        assert!((10.59..10.6).contains(&t) && asked < 15, "{t} {asked}");
        assert!(depth(t)[0].abs() < 1e-10);
    }

    #[test]
    fn bisection_of_a_jump_ends_at_rounding() {
        let depth = |t: f64| [if t < 0.3 { -1.0 } else { 1.0 }, 0.0];
        let ([t, _], asked) = crossing(depth, 0.0, 1.0);
        assert!((t - 0.3).abs() <= f64::EPSILON, "{t}");
        // Both ends, the guess, and 54 halvings: the rounding of 0.3 is 2^-54.
        assert!(asked <= 3 + 54, "{asked}");
    }

    #[test]
    fn extrema_are_independent_of_the_scale_of_the_penetration() {
        for scale in [1.0, 3.0, 0.2] {
            let coefficients = [-0.1, -0.675, 1.725, -1.0].map(|value| scale * value);
            let extrema = [1.0, -1.0].map(|sign| {
                let cubic = interpolant(coefficients.map(|value| sign * value), 0.0, 1.0);
                cubic.minimum_inside().unwrap()
            });
            assert!((extrema[0] - 0.25).abs() < 1e-14 && (extrema[1] - 0.9).abs() < 1e-14);
        }
        // (x - 1/2)² - 1/8, whose third difference is zero.
        let parabola = interpolant([0.125, -1.0, 1.0, 0.0], 0.0, 1.0);
        assert_eq!(parabola.lowest_inside(), Some(0.5));
    }

    #[test]
    fn a_minimum_of_zero_and_one_at_an_end_of_the_step_are_no_separation() {
        // (x - 1/2)², x² - 1 and (x - 1)² - 1, whose minima are exact.
        let touching = interpolant([0.25, -1.0, 1.0, 0.0], 0.0, 1.0);
        assert_eq!(touching.minimum_inside(), Some(0.5));
        assert_eq!(touching.lowest_inside(), None);
        let at_start = interpolant([-1.0, 0.0, 1.0, 0.0], 0.0, 1.0);
        let at_end = interpolant([0.0, -2.0, 1.0, 0.0], 0.0, 1.0);
        assert_eq!([at_start, at_end].map(|c| c.minimum_inside()), [None; 2]);
    }

    #[test]
    fn the_first_guess_is_the_middle_where_the_value_is_zero_at_the_low_end() {
        // t (t - 0.25)(t + 1)
        let cubic = interpolant([0.0, -0.25, 0.75, 1.0], 0.0, 1.0);
        assert_eq!(cubic.upward_root(0.0), 0.5);
        assert_eq!(cubic.upward_root(0.25), 0.625);
    }

    #[test]
    fn the_first_guess_is_inside_the_bracket_of_any_crossing() {
        let rates = [-3000.0, -300.0, -5.0, 0.0, 5.0, 300.0, 3000.0];
        for above in [1e-3, 1.0, 20.0, 1e3] {
            for first in rates {
                for rate in rates {
                    let cubic = Cubic::through([-1.0, first], [above, rate], 1.0);
                    let low = cubic.lowest_inside().unwrap_or(0.0);
                    let guess = cubic.upward_root(low);
                    assert!(
                        guess > low && guess < 1.0,
                        "{above} {first} {rate}: {guess}"
                    );
                }
            }
        }
    }

    #[test]
    fn an_exact_zero_at_which_a_contact_ends_is_no_onset() {
        // The ends are those of a cubic with its root in the middle: bisection of the rest gives a first guess of 3/4, where contact ends.
        let depth = |t: f64| {
            if t == 0.0 || t == 1.0 {
                return [2.0 * t - 1.0, 3.0];
            }
            let [a, b, c] = [t - 0.6, t - 0.75, t - 0.9];
            [a * b * c, a * b + a * c + b * c]
        };
        let ([t, rate], _) = crossing(depth, 0.0, 1.0);
        assert!(
            (t - 0.9).abs() < 1e-12 && (rate - 0.045).abs() < 1e-9,
            "{t} {rate}"
        );
    }
}

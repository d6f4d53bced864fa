//! Hanging chain: the exact polygon of rigid links between two points, without friction, in static equilibrium.
//!
//! Each link is loaded by the tensions T at its ends and by its weight in the middle. Without moment about its middle it lies along
//! the mean of both, `T₀ - (W + w/2) d` with the tension `T₀` at the first end, the weight W of the links before it, its own w and
//! the direction d of gravity. The links then reach from one point to the other: two equations for `T₀`, the gradient of a convex
//! function, which Newton's method solves to round-off.

use nalgebra::Matrix2;

use crate::geometry::Vec2;

/// Permitted misfit of the ends, over the length of all links: rounding of a sum of vectors.
const FITTING: f64 = 1e-15;
/// Largest misfit at the end of the iteration where rounding prevents a smaller one, over the length of all links.
const LARGEST_MISFIT: f64 = 1e-11;
/// Slack, over the length, below which links count as taut: they lie on a straight line.
const TAUT: f64 = 1e-12;
/// Least horizontal span of the catenary of the first guess, over its length: ends above each other have a finite ratio.
const LEAST_SPAN: f64 = 1e-6;
/// Relative correction of its parameter at which Newton's method ends: rounding.
const SETTLED: f64 = 1e-14;
/// Least part of its parameter that remains in one correction: it stays positive.
const LEAST_PART: f64 = 0.1;

/// One link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HangingLink {
    /// Distance of its ends \[m\].
    pub length: f64,
    /// Weight, in its middle \[N\].
    pub weight: f64,
}

/// Links in static equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct Hanging {
    /// Both ends of every link, one more than links \[m\].
    pub points: Vec<Vec2>,
    /// Tension at each end, along the chain \[N\]; infinite for taut links.
    pub tensions: Vec<Vec2>,
}

/// Return the links that hang between `from` and `to` \[m\], with gravity along the unit vector `down`. `None` where they are
/// too short, or where the horizontal distance is so small that a link would be in compression.
#[must_use]
pub fn hang(from: Vec2, to: Vec2, down: Vec2, links: &[HangingLink]) -> Option<Hanging> {
    let length: f64 = links.iter().map(|link| link.length).sum();
    let weight: f64 = links.iter().map(|link| link.weight).sum();
    let reach = to - from;
    let distance = reach.norm();
    if distance > length * (1.0 + TAUT) {
        return None;
    }
    if distance >= length * (1.0 - TAUT) {
        return Some(taut(from, reach / distance, links));
    }
    let mut tension = first_guess(reach, down, length, weight);
    let mut misfit = misfit_of(tension, reach, down, links);
    for _ in 0..200 {
        if misfit.0.norm() <= FITTING * length {
            break;
        }
        let Some(step) = misfit.1.try_inverse().map(|inverse| inverse * misfit.0) else {
            break;
        };
        // The step, or the largest half, quarter and so on of it, that lowers the misfit.
        let better = (0..20).find_map(|halvings| {
            let next = tension - 0.5_f64.powi(halvings) * step;
            let found = misfit_of(next, reach, down, links);
            (found.0.norm() < misfit.0.norm()).then_some((next, found))
        });
        let Some((next, found)) = better else { break };
        (tension, misfit) = (next, found);
    }
    (misfit.0.norm() <= LARGEST_MISFIT * length).then(|| lay(from, tension, down, links))
}

/// Return the misfit at the second end \[m\] and its derivative by the tension at the first end.
fn misfit_of(
    tension: Vec2,
    reach: Vec2,
    down: Vec2,
    links: &[HangingLink],
) -> (Vec2, Matrix2<f64>) {
    let (mut misfit, mut slope) = (-reach, Matrix2::zeros());
    let mut pull = tension;
    for link in links {
        let middle = pull - 0.5 * link.weight * down;
        let size = middle.norm();
        let along = middle / size;
        misfit += link.length * along;
        slope += (Matrix2::identity() - along * along.transpose()) * (link.length / size);
        pull -= link.weight * down;
    }
    (misfit, slope)
}

fn lay(from: Vec2, tension: Vec2, down: Vec2, links: &[HangingLink]) -> Hanging {
    let mut hanging = Hanging {
        points: vec![from],
        tensions: vec![tension],
    };
    let (mut point, mut pull) = (from, tension);
    for link in links {
        point += link.length * (pull - 0.5 * link.weight * down).normalize();
        pull -= link.weight * down;
        hanging.points.push(point);
        hanging.tensions.push(pull);
    }
    hanging
}

fn taut(from: Vec2, along: Vec2, links: &[HangingLink]) -> Hanging {
    let mut points = vec![from];
    let mut point = from;
    for link in links {
        point += link.length * along;
        points.push(point);
    }
    Hanging {
        tensions: vec![Vec2::repeat(f64::INFINITY); points.len()],
        points,
    }
}

/// Return the tension at the first end of a heavy string (catenary) of that length and weight.
fn first_guess(reach: Vec2, down: Vec2, length: f64, weight: f64) -> Vec2 {
    let rise = -reach.dot(&down);
    let across = reach + rise * down;
    let span = across.norm().max(LEAST_SPAN * length);
    let sideways = if across.norm() > 0.0 {
        across.normalize()
    } else {
        Vec2::new(down.y, -down.x)
    };
    // sinh(x)/x is the ratio of arc length, without its rise, to span.
    let ratio = (length * length - rise * rise).sqrt() / span;
    let mut x = if ratio < 3.0 {
        (6.0 * (ratio - 1.0)).sqrt()
    } else {
        (2.0 * ratio * (2.0 * ratio).ln()).ln()
    };
    for _ in 0..30 {
        let (value, slope) = (x.sinh() - ratio * x, x.cosh() - ratio);
        let step = value / slope;
        if step.abs() < SETTLED * x {
            break;
        }
        x = (x - step).max(LEAST_PART * x);
    }
    let per_meter = weight / length;
    let upward = 0.5 * (per_meter * rise / x.tanh() - weight);
    per_meter * span / (2.0 * x) * sideways - upward * down
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    // Ends are reached to 1e-11 of the length at worst, and mostly to 1e-15; bounds of 1e-11 to 1e-9 permit this error and what a
    // tension changes with it.
    /// Unequal links that weigh 2 N or 3 N and a quarter.
    fn links(count: usize) -> Vec<HangingLink> {
        let link = |i: usize| HangingLink {
            length: if i.is_multiple_of(2) { 0.1 } else { 0.11 },
            weight: if i.is_multiple_of(2) { 2.0 } else { 3.25 },
        };
        (0..count).map(link).collect()
    }

    proptest! {
        #[test]
        fn links_reach_and_no_moment_is_left_on_any(
            count in 3usize..200,
            share in 0.05f64..0.9999,
            angle in -1.3f64..1.3,
        ) {
            let links = links(count);
            let length: f64 = links.iter().map(|l| l.length).sum();
            let to = share * length * Vec2::new(angle.cos(), angle.sin());
            let down = Vec2::new(0.0, -1.0);
            let Some(found) = hang(Vec2::zeros(), to, down, &links) else {
                // Ends nearer, sideways, than a link may leave it to push; hardly farther ones pull next to nothing. No others fail.
                prop_assert!(to.x < 1.01 * 0.11, "{count} {to}");
                return Ok(());
            };
            prop_assert!((found.points[count] - to).norm() < 1e-11 * length);
            for (i, link) in links.iter().enumerate() {
                let along = found.points[i + 1] - found.points[i];
                prop_assert!((along.norm() - link.length).abs() < 1e-14 * length);
                let pull = found.tensions[i] + found.tensions[i + 1];
                let moment = along.perp(&pull);
                let weighs = 3.25 * count as f64;
                prop_assert!(moment.abs() < 1e-12 * pull.norm() * length, "{moment}");
                let weight = found.tensions[i + 1] - found.tensions[i] + link.weight * down;
                prop_assert!(weight.norm() < 1e-12 * (weighs + pull.norm()));
            }
        }
    }

    #[test]
    fn many_light_links_hang_on_the_catenary() {
        // y = a cosh(x/a) with a = 0.5 over a span of 1: arc 2 a sinh(1), sag a (cosh(1) - 1), both of textbooks.
        let a: f64 = 0.5;
        let count: usize = 2000;
        let length = 2.0 * a * 1.0_f64.sinh() / count as f64;
        let links = vec![
            HangingLink {
                length,
                weight: 1.0
            };
            count
        ];
        let found = hang(
            Vec2::zeros(),
            Vec2::new(1.0, 0.0),
            Vec2::new(0.0, -1.0),
            &links,
        )
        .unwrap();
        let sag = -found.points[count / 2].y;
        assert!((sag - a * (1.0_f64.cosh() - 1.0)).abs() < 1e-6, "{sag}");
        // H = w a, with a link's weight over its length.
        assert!((found.tensions[0].x * length - a).abs() < 1e-6);
    }

    #[test]
    fn links_that_do_not_reach_do_not_hang() {
        let to = Vec2::new(1.2, 0.0);
        assert!(hang(Vec2::zeros(), to, -Vec2::y(), &links(10)).is_none());
        let just = Vec2::new(1.05, 0.0);
        let found = hang(Vec2::zeros(), just, -Vec2::y(), &links(10)).unwrap();
        assert!(found.points.iter().all(|p| p.y == 0.0));
    }

    #[test]
    fn two_equal_links_hang_as_a_triangle_with_the_horizontal_tension_of_their_slope() {
        // At the angle a, each link has the moments w/2 and H tan(a) at its ends: H = w / (2 tan a).
        for angle in [0.01, 0.3, 1.0, 1.5_f64] {
            let link = HangingLink {
                length: 0.5,
                weight: 3.0,
            };
            let to = Vec2::new(angle.cos(), 0.0);
            let found = hang(Vec2::zeros(), to, -Vec2::y(), &[link; 2]).unwrap();
            let pull = 1.5 / angle.tan();
            let middle = 0.5 * Vec2::new(angle.cos(), -angle.sin());
            assert!((found.points[1] - middle).norm() < 1e-11, "{angle}");
            for (tension, upward) in found.tensions.iter().zip([-3.0, 0.0, 3.0]) {
                let expected = Vec2::new(pull, upward);
                assert!(
                    (tension - expected).norm() < 1e-9 * expected.norm(),
                    "{angle}"
                );
            }
        }
    }

    #[test]
    fn the_shape_does_not_depend_on_the_frame_nor_on_units_of_length_and_force() {
        let links = links(21);
        let to = Vec2::new(1.3, 0.4);
        let found = hang(Vec2::zeros(), to, -Vec2::y(), &links).unwrap();
        for (angle, unit) in [(0.7, 1.0), (-2.0_f64, 1e6), (0.0, 1e-6)] {
            let turn = |v: Vec2| {
                let (sin, cos) = angle.sin_cos();
                Vec2::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y)
            };
            let heavy: Vec<_> = links
                .iter()
                .map(|link| HangingLink {
                    weight: 1e3 * link.weight,
                    length: unit * link.length,
                })
                .collect();
            let from = unit * Vec2::new(5.0, -3.0);
            let to = from + unit * turn(to);
            let turned = hang(from, to, turn(-Vec2::y()), &heavy).unwrap();
            for (a, b) in found.points.iter().zip(&turned.points) {
                assert!((unit * turn(*a) + from - b).norm() < 1e-10 * unit);
            }
            for (a, b) in found.tensions.iter().zip(&turned.tensions) {
                assert!((1e3 * turn(*a) - b).norm() < 1e-8 * b.norm());
            }
        }
    }

    #[test]
    fn links_between_ends_upright_over_each_other_would_be_in_compression() {
        let links = [HangingLink {
            length: 0.5,
            weight: 1.0,
        }; 4];
        assert_eq!(
            hang(Vec2::zeros(), Vec2::new(0.0, 0.3), -Vec2::y(), &links),
            None
        );
        // All on one straight line they hang at their full length.
        let found = hang(Vec2::zeros(), Vec2::new(0.0, -2.0), -Vec2::y(), &links).unwrap();
        assert_eq!(found.points[3], Vec2::new(0.0, -1.5));
    }

    #[test]
    fn links_are_taut_within_1e_12_of_their_length_and_none_are_longer() {
        let links = [HangingLink {
            length: 2.0,
            weight: 1.0,
        }; 5];
        let at = |distance: f64| hang(Vec2::zeros(), Vec2::new(distance, 0.0), -Vec2::y(), &links);
        for excess in [-4e-12, 0.0, 4e-12] {
            let found = at(10.0 + excess).unwrap();
            assert!(
                found
                    .tensions
                    .iter()
                    .all(|t| t.x == f64::INFINITY && t.y == f64::INFINITY)
            );
            let places: Vec<_> = found.points.iter().map(|p| p.x).collect();
            assert_eq!(places, [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        }
        assert_eq!(at(10.0 + 2e-11), None);
        // Nearly taut, they pull with a finite force.
        let near = at(10.0 - 1e-9).unwrap();
        assert!(near.tensions.iter().all(|t| t.x.is_finite() && t.x > 1e3));
    }

    #[test]
    fn the_first_guess_is_the_tension_of_the_heavy_string() {
        // y = a cosh((x - x0)/a): horizontal q a, and q a sinh in the vertical direction; q is the weight of a metre.
        let (a, q) = (0.4_f64, 2.5);
        for (span, lowest) in [
            (0.3, 0.1),
            (1.0, 0.5),
            (1.0, -0.4),
            (1.0, 1.3),
            (3.0, 1.0),
            (6.0, 3.0),
            (12.8, 6.4),
        ] {
            let at = |x: f64| (x - lowest) / a;
            let length = a * (at(span).sinh() - at(0.0).sinh());
            let rise = a * (at(span).cosh() - at(0.0).cosh());
            for angle in [0.0, 2.5_f64] {
                let side = Vec2::new(angle.cos(), angle.sin());
                let up = Vec2::new(-angle.sin(), angle.cos());
                for side in [side, -side] {
                    let guess = first_guess(span * side + rise * up, -up, length, q * length);
                    let expected = q * a * (side + at(0.0).sinh() * up);
                    let error = (guess - expected).norm() / expected.norm();
                    assert!(error < 1e-9, "{span} {lowest}: {guess} {expected}");
                }
            }
        }
    }

    #[test]
    fn the_derivative_of_the_misfit_is_its_difference_quotient() {
        let links = links(5);
        let (reach, down) = (Vec2::new(0.3, -0.1), Vec2::new(0.6, -0.8));
        let tension = Vec2::new(4.0, -2.0);
        let at = |tension: Vec2| misfit_of(tension, reach, down, &links);
        let step = 1e-5;
        for (column, along) in [Vec2::x(), Vec2::y()].into_iter().enumerate() {
            let difference = at(tension + step * along).0 - at(tension - step * along).0;
            let slope = difference / (2.0 * step);
            assert!((at(tension).1.column(column) - slope).norm() < 1e-10);
        }
        let laid = lay(Vec2::zeros(), tension, down, &links);
        assert!((laid.points[5] - reach - at(tension).0).norm() < 1e-15);
    }

    #[test]
    fn a_chain_whose_ends_coincide_hangs_folded_in_its_middle() {
        let links = [HangingLink {
            length: 0.5,
            weight: 1.0,
        }; 4];
        for down in [-Vec2::y(), Vec2::new(0.6, -0.8)] {
            let found = hang(Vec2::zeros(), Vec2::zeros(), down, &links).unwrap();
            for (point, depth) in found.points.iter().zip([0.0, 0.5, 1.0, 0.5, 0.0]) {
                assert!((point - depth * down).norm() < 1e-9, "{found:?}");
            }
            // Each half bears its own weight; the hinge at the bottom bears up to half a link's.
            assert!((found.tensions[0] - 2.0 * down).norm() <= 0.5 + 1e-9);
            // The guess across the direction of gravity does not change the part along it.
            let guess = first_guess(Vec2::zeros(), down, 2.0, 4.0);
            assert!((guess.dot(&down) - 2.0).abs() < 1e-14 && guess.perp(&down) != 0.0);
        }
    }

    #[test]
    fn the_first_guess_of_a_nearly_taut_string_is_that_of_a_parabola() {
        // Length s (1 + x²/6) over a span s, H = q s/2x; x is 1e-16/1e-12 of itself uncertain.
        for (span, excess) in [(3.0, 1e-12_f64), (0.02, 1e-12), (3.0, 1e-4)] {
            let length = span * (1.0 + excess);
            let guess = first_guess(Vec2::new(span, 0.0), -Vec2::y(), length, 2.5 * length);
            let expected = 2.5 * span / (2.0 * (6.0 * excess).sqrt());
            assert!(
                (guess.x / expected - 1.0).abs() < 1e-3,
                "{guess} {expected}"
            );
            assert!((guess.y + 1.25 * length).abs() < 1e-9);
        }
    }

    #[test]
    fn the_limit_of_taut_links_is_permitted() {
        let links = [HangingLink {
            length: 0.25,
            weight: 1.0,
        }; 4];
        let at = |distance: f64| hang(Vec2::zeros(), Vec2::new(distance, 0.0), -Vec2::y(), &links);
        assert!(at(1.0 + TAUT).is_some() && at(1.0 + 2.0 * TAUT).is_none());
    }
}

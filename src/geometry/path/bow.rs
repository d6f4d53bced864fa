//! Slack strand between two sprockets: a circular arc of equal links.

use std::f64::consts::PI;

use crate::geometry::{Vec2, turned_left};
use crate::math::bisected;

/// Slack of a strand, over its span, below which it counts as straight: rounding of its length.
const STRAIGHT: f64 = 1e-11;

/// A strand's hinges between its ends: evenly on the straight line, or on a circular arc of equal links when slack.
pub(crate) struct Bow {
    span: f64,
    links: u32,
    pitch: f64,
    /// Angle that one link subtends \[rad\]; 0 for the straight strand.
    link_angle: f64,
}

impl Bow {
    pub(crate) fn new(span: f64, links: u32, pitch: f64) -> Self {
        let n = f64::from(links);
        let mut bow = Self {
            span,
            links,
            pitch,
            link_angle: 0.0,
        };
        if n * pitch - span < STRAIGHT * span {
            return bow;
        }
        // span / pitch = sin(n g / 2) / sin(g / 2) falls from n to 0 over 0 < g < 2 pi / n.
        let [low, high] = bisected([0.0, 2.0 * PI / n], 200, |angle| {
            (0.5 * n * angle).sin() * pitch > span * (0.5 * angle).sin()
        });
        bow.link_angle = 0.5 * (low + high);
        bow
    }

    /// Largest distance of a hinge's circle from the straight line \[m\].
    pub(crate) fn height(&self) -> f64 {
        if self.link_angle == 0.0 {
            return 0.0;
        }
        let half = 0.5 * f64::from(self.links) * self.link_angle;
        0.5 * self.pitch / (0.5 * self.link_angle).sin() * (1.0 - half.cos())
    }

    /// Hinge `index` of the strand; the bow goes to the right of the path, which is outward.
    pub(crate) fn point(&self, from: Vec2, to: Vec2, index: u32) -> Vec2 {
        let (i, n) = (f64::from(index), f64::from(self.links));
        if self.link_angle == 0.0 {
            return from + (i / n) * (to - from);
        }
        let e = (to - from) / self.span;
        let right = -turned_left(e);
        let radius = 0.5 * self.pitch / (0.5 * self.link_angle).sin();
        let half = 0.5 * n * self.link_angle;
        let angle = i * self.link_angle - half;
        from + (0.5 * self.span + radius * angle.sin()) * e
            + radius * (angle.cos() - half.cos()) * right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hinges_of_a_slack_strand_lie_on_a_circle_outside_its_straight_line() {
        let pitch = 0.5;
        // Links and the angle of each: from a flat bow to nearly a whole circle.
        for (links, angle) in [(7_u32, 0.01), (7, 0.2), (7, 0.44), (7, 0.8), (9, 0.667)] {
            // A chord of one pitch under this angle, and the chord of all links, of the textbook.
            let radius = 0.5 * pitch / (0.5_f64 * angle).sin();
            let half = 0.5 * f64::from(links) * angle;
            let span = 2.0 * radius * half.sin();
            let bow = Bow::new(span, links, pitch);
            // The span changes by half its curvature with the angle: 1e-16 becomes 1e-13 in a flat bow.
            let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
            assert!(close(bow.height(), radius * (1.0 - half.cos())), "{angle}");
            let (from, to) = (Vec2::new(2.0, 1.0), Vec2::new(2.0, 1.0 + span));
            // The path leads up, so that its right is +x.
            let center = Vec2::new(2.0 - radius * half.cos(), 1.0 + 0.5 * span);
            for index in 0..=links {
                let hinge = bow.point(from, to, index);
                let turn = f64::from(index) * angle - half;
                let expected = center + radius * Vec2::new(turn.cos(), turn.sin());
                assert!((hinge - expected).norm() < 1e-12, "{angle} {index}");
            }
        }
    }

    #[test]
    fn hinges_of_a_taut_strand_divide_its_straight_line() {
        let bow = Bow::new(2.0, 4, 0.5);
        assert_eq!(bow.height(), 0.0);
        let (from, to) = (Vec2::new(1.0, 3.0), Vec2::new(1.0, 5.0));
        for index in 0..=4 {
            let expected = Vec2::new(1.0, 3.0 + 0.5 * f64::from(index));
            assert_eq!(bow.point(from, to, index), expected);
        }
    }

    #[test]
    fn a_strand_is_straight_up_to_a_slack_of_1e_11_of_its_span() {
        // A flat bow is sqrt(3 L s/8) high, with the slack s of a span L.
        for span in [0.05, 20.0] {
            let of = |slack: f64| Bow::new(span, 10, 0.1 * span * (1.0 + slack)).height();
            assert_eq!(of(5e-12), 0.0);
            for slack in [2e-11, 1e-9_f64] {
                // Half a rounding error of the sum over the slack.
                let close = 1e-5 + 1e-16 / slack * 20.0;
                let expected = span * (0.375 * slack).sqrt();
                // Ten links are a polygon in the arc: (1 - 1/n²) of the slack of the arc is theirs.
                let expected = expected * (1.0_f64 - 0.01).sqrt().recip();
                let found = of(slack);
                assert!(
                    (found / expected - 1.0).abs() < close,
                    "{span} {slack}: {found} {expected}"
                );
            }
        }
    }
}

//! Slack strand between two sprockets: a circular arc of equal links.

use std::f64::consts::PI;

use crate::geometry::{Vec2, turned_left};

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
        if n * pitch - span < 1e-11 * span {
            return bow;
        }
        // span / pitch = sin(n g / 2) / sin(g / 2) falls from n to 0 over 0 < g < 2 pi / n.
        let (mut low, mut high) = (0.0, 2.0 * PI / n);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if (0.5 * n * middle).sin() * pitch > span * (0.5 * middle).sin() {
                low = middle;
            } else {
                high = middle;
            }
        }
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

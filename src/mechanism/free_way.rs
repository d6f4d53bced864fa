//! How far a circle may move before its contact has to be looked at again, and how fast it does: what limits a step.

use super::body::Frame;
use super::outline::Place;
use super::touch::CompiledContact;
use crate::geometry::{Vec2, turned_left};

/// Part of its radius that a circle near a profile may move by in one step: none passes through another unseen.
const FARTHEST: f64 = 0.25;

impl CompiledContact {
    /// How far the circle may move along the profile \[m\] before its distance has to be looked at again: its gap, and
    /// where that is small a part of its radius.
    pub(super) fn free_way(&self, frames: &[Frame]) -> f64 {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let apart = (fb.place(self.b.point) - fa.place(self.a.point)).norm();
        let mut gap = f64::INFINITY;
        if apart > self.reach {
            gap = apart - self.reach;
        } else {
            self.bearings(self.local(fa, fb), |bearing, _| {
                if bearing.place == Place::Deep && self.is_open() {
                    gap = gap.min(-bearing.distance - self.radius);
                } else if bearing.weight > 0.0 && bearing.place != Place::DeepAtEnd {
                    gap = gap.min(bearing.distance - self.radius);
                }
            });
        }
        gap.max(FARTHEST * self.radius)
    }

    /// Speed \[m/s\] and acceleration \[m/s²\] of the circle's centre as seen from the profile, of bodies that accelerate so.
    pub(super) fn relative_motion(&self, frames: &[Frame], rates: [[f64; 3]; 2]) -> (f64, f64) {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let center = fb.place(self.b.point);
        let speed = (fb.velocity_at(center) - fa.velocity_at(center)).norm();
        let accelerated = |frame: &Frame, [x, y, spin]: [f64; 3]| {
            let arm = center - frame.origin;
            Vec2::new(x, y) + spin * turned_left(arm) - frame.spin * frame.spin * arm
        };
        let acceleration = accelerated(fb, rates[1]) - accelerated(fa, rates[0]);
        (speed, acceleration.norm())
    }
}

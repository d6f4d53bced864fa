//! How far a circle may move before its contact has to be looked at again, and how fast it does: what limits a step.

use super::contact_state::CompiledContact;
use super::impact_memory::Touch;
use super::outline::Place;
use crate::geometry::{Vec2, turned_left};
use crate::multibody::description::body::Frame;

/// Part of its radius within which a circle counts as near a profile: from farther away no step carries it there, and from nearer
/// by no more than that, along a path that is screened for contacts.
pub(crate) const FARTHEST: f64 = 0.25;

impl CompiledContact {
    /// Time \[s\] in which the circle cannot move, by its speed and acceleration relative to the profile, through its gap or,
    /// where that is less, a part of its radius; infinite where it is longer than `within`. `touches`: as evaluated last.
    pub(crate) fn free_time(
        &self,
        frames: &[Frame],
        rates: [[f64; 3]; 2],
        touches: &[Touch],
        within: f64,
    ) -> f64 {
        let (speed, acceleration) = self.relative_motion(frames, rates);
        let least = FARTHEST * self.radius;
        // A sum of two components is no less than the vector's length.
        let farthest = within * (speed.abs().sum() + 0.5 * within * acceleration.abs().sum());
        if farthest < least {
            return f64::INFINITY;
        }
        let way = self.gap(frames, touches).max(least);
        let (speed, acceleration) = (speed.norm(), acceleration.norm());
        // The root of way = speed t + acceleration t²/2.
        2.0 * way / (speed + (speed * speed + 2.0 * acceleration * way).sqrt())
    }

    /// Gap of the circle \[m\].
    fn gap(&self, frames: &[Frame], touches: &[Touch]) -> f64 {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let apart = (fb.place(self.b.point) - fa.place(self.a.point)).norm();
        if apart > self.reach {
            return apart - self.reach;
        }
        if !self.is_open() {
            let depths = touches.iter().map(|touch| touch.contact.penetration);
            return -depths.fold(f64::NEG_INFINITY, f64::max);
        }
        // Of what bears nowhere yet, too: an open outline has a back.
        let mut gap = f64::INFINITY;
        self.bearings(self.local(fa, fb), |bearing, _| {
            if bearing.place == Place::Deep {
                gap = gap.min(-bearing.distance - self.radius);
            } else if bearing.weight > 0.0 && bearing.place != Place::DeepAtEnd {
                gap = gap.min(bearing.distance - self.radius);
            }
        });
        gap
    }

    /// Velocity \[m/s\] and acceleration \[m/s²\] of the circle's centre as seen from the profile, of bodies that accelerate so.
    pub(crate) fn relative_motion(&self, frames: &[Frame], rates: [[f64; 3]; 2]) -> (Vec2, Vec2) {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let center = fb.place(self.b.point);
        let speed = fb.velocity_at(center) - fa.velocity_at(center);
        let accelerated = |frame: &Frame, [x, y, spin]: [f64; 3]| {
            let arm = center - frame.origin;
            Vec2::new(x, y) + spin * turned_left(arm) - frame.spin * frame.spin * arm
        };
        let acceleration = accelerated(fb, rates[1]) - accelerated(fa, rates[0]);
        (speed, acceleration)
    }
}

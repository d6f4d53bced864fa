//! Bound of the step size by the gap and the relative motion of the circle of a contact.

use super::contact_state::CompiledContact;
use super::impact_memory::Touch;
use super::outline::Place;
use crate::geometry::{Vec2, turned_left};
use crate::multibody::description::body::Frame;

/// Gap of a circle below which it is near a profile, over its radius. No step carries a circle to the profile from a larger gap.
/// From a smaller gap no step carries it farther than this length, and the path is screened for contacts.
pub(crate) const FARTHEST: f64 = 0.25;

impl CompiledContact {
    /// Return the time \[s\] in which the circle moves through its gap, or through [`FARTHEST`] radii if the gap is smaller.
    ///
    /// Speed and acceleration are relative to the profile. The time is infinite if it is clearly longer than `within` \[s\].
    /// `touches` are those of the last evaluation.
    pub(crate) fn free_time(
        &self,
        frames: &[Frame],
        rates: [[f64; 3]; 2],
        touches: &[Touch],
        within: f64,
    ) -> f64 {
        let (speed, acceleration) = self.relative_motion(frames, rates);
        let least = FARTHEST * self.radius;
        // The sum of the absolute components is an upper bound of the norm, without square roots.
        let farthest = within * (speed.abs().sum() + 0.5 * within * acceleration.abs().sum());
        if farthest < least {
            return f64::INFINITY;
        }
        let way = self.gap(frames, touches).max(least);
        let (speed, acceleration) = (speed.norm(), acceleration.norm());
        // Root t of s = v t + a t²/2 in a form without cancellation: t = 2 s/(v + √(v² + 2 a s)).
        2.0 * way / (speed + (speed * speed + 2.0 * acceleration * way).sqrt())
    }

    /// Return the gap between circle and profile \[m\]; negative in contact.
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
        // An open outline has a back: points without a force limit the step too, and behind the surface the gap is that to the back.
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

    /// Return velocity \[m/s\] and acceleration \[m/s²\] of the circle's centre relative to the material point of the profile's body
    /// at the same place. `rates` are the accelerations of bodies a and b \[m/s², m/s², rad/s²\].
    pub(crate) fn relative_motion(&self, frames: &[Frame], rates: [[f64; 3]; 2]) -> (Vec2, Vec2) {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let center = fb.place(self.b.point);
        let speed = fb.velocity_at(center) - fa.velocity_at(center);
        // a + α × r - ω² r of a body at the centre of the circle.
        let accelerated = |frame: &Frame, [x, y, spin]: [f64; 3]| {
            let arm = center - frame.origin;
            Vec2::new(x, y) + spin * turned_left(arm) - frame.spin * frame.spin * arm
        };
        let acceleration = accelerated(fb, rates[1]) - accelerated(fa, rates[0]);
        (speed, acceleration)
    }
}

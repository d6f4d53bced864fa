//! Bound of the step size by the gap and the relative motion of the circle of a contact.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::SQRT_2;

use super::compiled_contact::{CompiledContact, FARTHEST};
use super::impact_memory::SideState;
use super::outline::OutlinePlace;
use crate::geometry::{Vec2, turned_left};
use crate::multibody::description::body::Frame;

/// Bodies of all contacts, for one bound of their relative motions.
#[derive(Debug, Clone, Default)]
pub(crate) struct ContactBodies {
    /// Bodies of profiles.
    profiles: Vec<usize>,
    /// Bodies of circles, with the distance of their farthest circle from the centre of mass \[m\].
    circles: Vec<(usize, f64)>,
    least_radius: f64,
}

impl ContactBodies {
    /// Return the bodies of `contacts`.
    pub(crate) fn of(contacts: &[CompiledContact]) -> Self {
        let mut profiles = BTreeSet::new();
        let mut circles = BTreeMap::new();
        for contact in contacts {
            profiles.insert(contact.a.body);
            let arm: &mut f64 = circles.entry(contact.b.body).or_default();
            *arm = arm.max(contact.b.point.norm());
        }
        let radii = contacts.iter().map(|contact| contact.radius);
        Self {
            profiles: profiles.into_iter().collect(),
            circles: circles.into_iter().collect(),
            least_radius: radii.fold(f64::INFINITY, f64::min),
        }
    }

    /// Return whether no circle moves by [`FARTHEST`] radii relative to its profile within a time \[s\], by the present velocities and
    /// accelerations. `accelerations` returns those of a body.
    ///
    /// The bound is that of [`CompiledContact::free_time`] with the largest motion of any profile and of any circle.
    pub(crate) fn stay_close(
        &self,
        frames: &[Frame],
        accelerations: impl Fn(usize) -> [f64; 3],
        within: f64,
    ) -> bool {
        let far = |body: &usize| frames[*body].origin.abs().sum();
        let of_circles = self.circles.iter().map(|(body, arm)| far(body) + arm);
        let far_circle = of_circles.fold(0.0, f64::max);
        // Largest displacement by one body at a distance from its centre of mass. √2: sums of absolute components exceed norms by
        // that factor.
        let displacement = |body: usize, distance: f64| {
            let (frame, [x, y, spin]) = (&frames[body], accelerations(body));
            let arm = SQRT_2 * distance;
            let speed = frame.velocity.abs().sum() + frame.spin.abs() * arm;
            let turning = (spin.abs() + frame.spin * frame.spin) * arm;
            within * (speed + 0.5 * within * (x.abs() + y.abs() + turning))
        };
        let profiles = self.profiles.iter();
        let profiles = profiles.map(|body| displacement(*body, far(body) + far_circle));
        let circles = self.circles.iter();
        let circles = circles.map(|&(body, arm)| displacement(body, arm));
        let farthest = profiles.fold(0.0, f64::max) + circles.fold(0.0, f64::max);
        farthest < FARTHEST * self.least_radius
    }
}

impl CompiledContact {
    /// Return the time \[s\] in which the circle moves through its gap, or through [`FARTHEST`] radii if the gap is smaller.
    ///
    /// Speed and acceleration are relative to the profile. The time is infinite if it is clearly longer than `within` \[s\].
    /// `side_states` are those of the last evaluation.
    pub(crate) fn free_time(
        &self,
        frames: &[Frame],
        accelerations: [[f64; 3]; 2],
        side_states: &[SideState],
        within: f64,
    ) -> f64 {
        let (speed, acceleration) = self.relative_motion(frames, accelerations);
        let least = FARTHEST * self.radius;
        // The sum of the absolute components is an upper bound of the norm, without square roots.
        let farthest = within * (speed.abs().sum() + 0.5 * within * acceleration.abs().sum());
        if farthest < least {
            return f64::INFINITY;
        }
        let way = self.gap(frames, side_states).max(least);
        let (speed, acceleration) = (speed.norm(), acceleration.norm());
        // Root t of s = v t + a t²/2 in a form without cancellation: t = 2 s/(v + √(v² + 2 a s)).
        2.0 * way / (speed + (speed * speed + 2.0 * acceleration * way).sqrt())
    }

    /// Return the gap between circle and profile \[m\]; negative in contact.
    fn gap(&self, frames: &[Frame], side_states: &[SideState]) -> f64 {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let apart = self.apart_squared(frames).sqrt();
        if apart > self.reach {
            return apart - self.reach;
        }
        if !self.is_open() {
            let depths = side_states
                .iter()
                .map(|side_state| side_state.contact.penetration);
            return -depths.fold(f64::NEG_INFINITY, f64::max);
        }
        // An open outline has a back: points without a force limit the step too, and behind the surface the gap is that to the back.
        let mut gap = f64::INFINITY;
        self.contact_points(self.local(fa, fb), |candidate, _| {
            if candidate.place == OutlinePlace::Deep {
                gap = gap.min(-candidate.distance - self.radius);
            } else if candidate.weight > 0.0 && candidate.place != OutlinePlace::DeepAtEnd {
                gap = gap.min(candidate.distance - self.radius);
            }
        });
        gap
    }

    /// Return velocity \[m/s\] and acceleration \[m/s²\] of the circle's centre relative to the material point of the profile's body
    /// at the same place. `accelerations` are those of bodies a and b \[m/s², m/s², rad/s²\].
    pub(crate) fn relative_motion(
        &self,
        frames: &[Frame],
        accelerations: [[f64; 3]; 2],
    ) -> (Vec2, Vec2) {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let center = fb.place(self.b.point);
        // a + α × r - ω² r of a body at the centre of the circle.
        let accelerated = |frame: &Frame, [x, y, spin]: [f64; 3]| {
            let arm = center - frame.origin;
            Vec2::new(x, y) + spin * turned_left(arm) - frame.spin * frame.spin * arm
        };
        let acceleration = accelerated(fb, accelerations[1]) - accelerated(fa, accelerations[0]);
        (self.approach(fa, fb), acceleration)
    }
}

#[cfg(test)]
mod tests;

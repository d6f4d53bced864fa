//! Screening of a step for contacts that begin and end within it, which neither of its ends shows.

use serde::{Deserialize, Serialize};

use super::contact_path::{ContactPath, Depth, Motion, UNSEEN};
use super::contact_state::CompiledContact;
use super::impact_memory::Memory;
use super::step_bound::FARTHEST;
use crate::geometry::{Vec2, turned_left};
use crate::integrator::event_location::Cubic;
use crate::multibody::description::body::Frame;
use crate::multibody::dynamics::MechanismDynamics;

/// A contact at one end of a step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct ContactEnd {
    /// Depth \[m\], negative when apart, and its rate \[m/s\].
    depth: [f64; 2],
    /// Place \[m\], velocity \[m/s\] and acceleration \[m/s²\] of the circle's centre, seen from the profile; none where it is
    /// farther away than a step may carry it, or behind the profile.
    motion: Option<[[f64; 2]; 3]>,
}

impl ContactEnd {
    pub(crate) const FAR: Self = Self {
        depth: [f64::NEG_INFINITY, 0.0],
        motion: None,
    };
}

impl MechanismDynamics {
    /// Writes how all contacts are where the next step begins, which is where everything was evaluated last.
    pub(crate) fn begin_screening(&mut self) {
        let mut starts = std::mem::take(&mut self.starts);
        for (k, start) in starts.iter_mut().enumerate() {
            *start = self.contact_end(k);
        }
        self.starts = starts;
    }

    /// Whether a contact begins and ends, or ends and begins anew, within the step of `length` \[s\] that was evaluated last.
    pub(crate) fn passes_contact(&self, length: f64) -> bool {
        (0..self.starts.len()).any(|k| {
            let (start, end) = (&self.starts[k], self.contact_end(k));
            let Some(path) = path_between(start, &end, length) else {
                return false;
            };
            let contact = &self.model.contacts[k];
            let memory = &self.memory[self.model.sides_of_contact[k].clone()];
            let depth = Depth {
                radius: contact.radius,
                at: |place| contact.depth_at(place, memory),
            };
            // What is far away is at least so far.
            let least = -FARTHEST * contact.radius;
            let depths = [start.depth[0].max(least), end.depth[0].max(least)];
            match depths.map(|depth| depth > 0.0) {
                // On its way out at the end, it was deeper within.
                [false, _] => path.rises_above(depths[1].max(0.0) + UNSEEN, depths, &depth),
                [true, false] => path.touches_again(depths[1], &depth),
                [true, true] => Cubic::through(start.depth, end.depth, length)
                    .lowest_inside()
                    .is_some_and(|part| (depth.at)(path.at(part)) < -UNSEEN),
            }
        })
    }

    /// How contact `k` is where everything was evaluated last.
    fn contact_end(&self, k: usize) -> ContactEnd {
        let contact = &self.model.contacts[k];
        let mut depth = self.deepest[k];
        if !self.near[k] {
            depth = [contact.outer_depth(&self.frames), 0.0];
        }
        if depth[0] <= -FARTHEST * contact.radius {
            return ContactEnd::FAR;
        }
        let (fa, fb) = (&self.frames[contact.a.body], &self.frames[contact.b.body]);
        let (speed, acceleration) = contact.relative_motion(&self.frames, self.rates_of(contact));
        // The frame of the profile turns.
        let acceleration = acceleration - 2.0 * fa.spin * turned_left(speed);
        let motion = [
            contact.local(fa, fb),
            fa.into_local(speed),
            fa.into_local(acceleration),
        ];
        ContactEnd {
            depth,
            motion: Some(motion.map(Into::into)),
        }
    }
}

/// The path of a circle in a step of `length` \[s\]; none where it is far at both ends. From or to far away it goes with the
/// acceleration of its other end.
fn path_between(start: &ContactEnd, end: &ContactEnd, length: f64) -> Option<ContactPath> {
    let motion = |end: &ContactEnd| end.motion.map(|motion| motion.map(Vec2::from));
    let (start, end) = match (motion(start), motion(end)) {
        (Some(start), Some(end)) => (start, end),
        (Some(start), None) => (start, continued(start, length)),
        (None, Some(end)) => (continued(end, -length), end),
        (None, None) => return None,
    };
    Some(ContactPath::through(start, end, length))
}

/// A motion after a time \[s\] of constant acceleration.
fn continued([place, velocity, acceleration]: Motion, time: f64) -> Motion {
    let faster = velocity + time * acceleration;
    [
        place + 0.5 * time * (velocity + faster),
        faster,
        acceleration,
    ]
}

impl CompiledContact {
    /// Depth \[m\] of a circle that is out of reach: no less than how far it is from the circle that holds the profile; -∞ where that is
    /// more than a step may carry it.
    fn outer_depth(&self, frames: &[Frame]) -> f64 {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let apart = (fb.place(self.b.point) - fa.place(self.a.point)).norm_squared();
        if apart >= (self.reach + FARTHEST * self.radius).powi(2) {
            f64::NEG_INFINITY
        } else {
            self.reach - apart.sqrt()
        }
    }

    /// Depth \[m\] of the circle around a place in the frame of the profile, negative when apart, with what its sides remember.
    fn depth_at(&self, place: Vec2, memory: &[Memory]) -> f64 {
        let mut depth = f64::NEG_INFINITY;
        self.bearings(place, |bearing, _| {
            if bearing.weight > 0.0 && self.bears(bearing, memory[bearing.side]) {
                depth = depth.max(self.radius - bearing.distance);
            }
        });
        depth.max(-self.radius)
    }
}

//! Screening of a step for contacts that begin and end within it, which neither of its ends shows.

use serde::{Deserialize, Serialize};

use super::contact_path::{ContactPath, Depth, Motion, UNSEEN};
use super::dynamics::MechanismDynamics;
use super::free_way::FARTHEST;
use super::memory::Memory;
use super::touch::CompiledContact;
use crate::contact::Cubic;
use crate::geometry::{Vec2, turned_left};

/// A contact at one end of a step, seen from the profile.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct ContactEnd {
    /// Place \[m\], velocity \[m/s\] and acceleration \[m/s²\] of the circle's centre.
    motion: [[f64; 2]; 3],
    /// Depth \[m\], negative when apart, and its rate \[m/s\].
    depth: [f64; 2],
}

impl ContactEnd {
    fn motion(&self) -> Motion {
        self.motion.map(Vec2::from)
    }

    /// Whether the circle is farther from the profile than a step may carry it, or behind it.
    fn is_far(&self, contact: &CompiledContact) -> bool {
        self.depth[0] <= -FARTHEST * contact.radius
    }
}

impl MechanismDynamics {
    /// Writes how all contacts are where the next step begins, which is where everything was evaluated last.
    pub(super) fn begin_screening(&mut self) {
        let mut starts = std::mem::take(&mut self.starts);
        for (k, start) in starts.iter_mut().enumerate() {
            *start = self.contact_end(k);
        }
        self.starts = starts;
    }

    /// Whether a contact begins and ends, or ends and begins anew, within the step of `length` \[s\] that was evaluated last.
    pub(super) fn passes_contact(&self, length: f64) -> bool {
        (0..self.starts.len()).any(|k| {
            let (contact, start, end) = (
                &self.model.contacts[k],
                &self.starts[k],
                self.contact_end(k),
            );
            if start.is_far(contact) && end.is_far(contact) {
                return false;
            }
            let memory = &self.memory[self.model.sides_of_contact[k].clone()];
            let path = ContactPath::through(start.motion(), end.motion(), length);
            let depth = Depth {
                radius: contact.radius,
                at: |place| contact.depth_at(place, memory),
            };
            let depths = [start.depth[0], end.depth[0]];
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

    fn contact_end(&self, k: usize) -> ContactEnd {
        let contact = &self.model.contacts[k];
        let (fa, fb) = (&self.frames[contact.a.body], &self.frames[contact.b.body]);
        let place = contact.local(fa, fb);
        let mut depth = [f64::NEG_INFINITY, 0.0];
        for touch in &self.touches[self.model.sides_of_contact[k].clone()] {
            if touch.contact.penetration > depth[0] {
                depth = [touch.contact.penetration, touch.contact.penetration_rate];
            }
        }
        if !self.near[k] {
            depth[0] = contact.reach - place.norm();
        } else if depth[0] == f64::NEG_INFINITY {
            // What bears nowhere is behind the profile, or farther away than forces look for.
            depth[0] = -contact.radius;
        }
        let (speed, acceleration) = contact.relative_motion(&self.frames, self.rates_of(contact));
        // The frame of the profile turns.
        let acceleration = acceleration - 2.0 * fa.spin * turned_left(speed);
        let motion = [place, fa.into_local(speed), fa.into_local(acceleration)];
        ContactEnd {
            motion: motion.map(Into::into),
            depth,
        }
    }
}

impl CompiledContact {
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

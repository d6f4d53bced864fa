//! Event screening: search of a step for contacts that begin and end within it and are visible at neither of its ends.

use super::compiled_contact::{CompiledContact, FARTHEST};
use super::contact_path::{ContactPath, Depth, PointMotion, UNSEEN};
use super::contact_states::{ContactEnd, ContactStates};
use super::impact_memory::Memory;
use crate::geometry::{Vec2, turned_left};
use crate::integrator::event_location::Cubic;
use crate::multibody::description::body::Frame;
use crate::multibody::model::MechanismModel;

impl ContactStates {
    /// Write the state of all contacts at the start of the next step, which is the state of the last evaluation.
    pub(crate) fn begin_screening(
        &mut self,
        model: &MechanismModel,
        frames: &[Frame],
        accelerations: &[f64],
    ) {
        // The end of a step that has been accepted; the projection moves it by far less than what the screening neglects.
        if !self.screened {
            self.find_ends(model, frames, accelerations);
        }
        std::mem::swap(&mut self.starts, &mut self.ends);
        self.screened = false;
    }

    /// Write the state of all contacts at the last evaluation.
    fn find_ends(&mut self, model: &MechanismModel, frames: &[Frame], accelerations: &[f64]) {
        let contacts = model.contacts.iter().zip(&self.deepest);
        for (end, (contact, depth)) in self.ends.iter_mut().zip(contacts) {
            *end = contact.end_of_step(*depth, model, frames, accelerations);
        }
        self.screened = true;
    }

    /// Return whether a contact begins and ends, or ends and begins again, within the last evaluated step of `length` \[s\].
    pub(crate) fn passes_contact(
        &mut self,
        model: &MechanismModel,
        frames: &[Frame],
        accelerations: &[f64],
        length: f64,
    ) -> bool {
        self.find_ends(model, frames, accelerations);
        let mut ends = self.starts.iter().zip(&self.ends).enumerate();
        ends.any(|(k, (start, end))| {
            let Some(path) = path_between(start, end, length) else {
                return false;
            };
            let contact = &model.contacts[k];
            let memory = &self.memory[model.sides_of_contact[k].clone()];
            let depth = Depth {
                radius: contact.radius,
                at: |place| contact.depth_at(place, memory),
            };
            let depths = [start.depth[0], end.depth[0]];
            match depths.map(|depth| depth > 0.0) {
                // Apart at the start: a penetration above that at the end belongs to a contact that has ended or is ending.
                [false, _] => path.rises_above(depths[1].max(0.0) + UNSEEN, depths, &depth),
                [true, false] => path.touches_again(depths[1], &depth),
                [true, true] => Cubic::through(start.depth, end.depth, length)
                    .lowest_inside()
                    .is_some_and(|part| (depth.at)(path.at(part)) < -UNSEEN),
            }
        })
    }
}

/// Return the path of a circle's centre in a step of `length` \[s\], or `None` if the circle is far away at both ends. If it is far
/// away at one end, the path has the constant acceleration of the other end.
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

/// Return a motion after a `time` \[s\] of constant acceleration.
fn continued([place, velocity, acceleration]: PointMotion, time: f64) -> PointMotion {
    let faster = velocity + time * acceleration;
    [
        place + 0.5 * time * (velocity + faster),
        faster,
        acceleration,
    ]
}

impl CompiledContact {
    /// Return the state at the last evaluation; `depth`: penetration \[m\] and its rate \[m/s\].
    #[inline]
    fn end_of_step(
        &self,
        depth: [f64; 2],
        model: &MechanismModel,
        frames: &[Frame],
        accelerations: &[f64],
    ) -> ContactEnd {
        if depth[0] <= -FARTHEST * self.radius {
            return ContactEnd::FAR;
        }
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let of_bodies = model.accelerations_of_pair(self, accelerations);
        let (speed, acceleration) = self.relative_motion(frames, of_bodies);
        // Coriolis term of the rotating frame of the profile; the other terms of that frame are in the acceleration.
        let acceleration = acceleration - 2.0 * fa.spin * turned_left(speed);
        let motion = [
            self.local(fa, fb),
            fa.into_local(speed),
            fa.into_local(acceleration),
        ];
        ContactEnd {
            depth,
            motion: Some(motion.map(Into::into)),
        }
    }

    /// Return an upper bound of the penetration \[m\] of a circle out of reach, from the circle that encloses the profile. It is -∞ if
    /// the gap is larger than a step may carry the circle. `apart` is the square of the distance of both markers \[m²\].
    pub(crate) fn outer_depth(&self, apart: f64) -> f64 {
        if apart >= (self.reach + FARTHEST * self.radius).powi(2) {
            f64::NEG_INFINITY
        } else {
            self.reach - apart.sqrt()
        }
    }

    /// Return the penetration \[m\] of the circle around `place` in the frame of the profile, negative when apart. `memory` is that of
    /// the contact's sides.
    fn depth_at(&self, place: Vec2, memory: &[Memory]) -> f64 {
        let mut depth = f64::NEG_INFINITY;
        self.contact_points(place, |candidate, _| {
            if candidate.weight > 0.0 && self.may_carry_force(candidate, memory[candidate.side]) {
                depth = depth.max(self.radius - candidate.distance);
            }
        });
        depth.max(-self.radius)
    }
}

#[cfg(test)]
mod tests;

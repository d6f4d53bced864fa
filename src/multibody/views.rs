//! What can be read of a mechanism's equations where they were evaluated last: the system itself, energies and forces.

use super::dynamics::MechanismDynamics;
use crate::geometry::Vec2;

impl MechanismDynamics {
    /// Accelerations of the bodies that are not held, three a body.
    #[must_use]
    pub fn accelerations(&self) -> &[f64] {
        &self.accelerations
    }

    /// Multiplier of each constraint equation.
    #[must_use]
    pub fn multipliers(&self) -> &[f64] {
        &self.multipliers
    }

    /// Entries (constraint, coordinate, value) of the Jacobian at the last state.
    #[must_use]
    pub fn jacobian(&self) -> Vec<(usize, usize, f64)> {
        let mut entries = Vec::new();
        for (i, row) in self.rows.iter().enumerate() {
            for (body, part) in row.bodies.iter().zip(&row.jacobian) {
                if let Some(first) = self.model.first[*body] {
                    entries.extend((0..3).map(|k| (i, first + k, part[k])));
                }
            }
        }
        entries.retain(|entry| entry.2 != 0.0);
        entries
    }

    /// Right-hand sides γ of the constraints at the last state.
    #[must_use]
    pub fn gamma(&self) -> Vec<f64> {
        self.rows.iter().map(|row| row.gamma).collect()
    }

    /// Mass or moment of inertia of each coordinate, and the load on it at the last state.
    #[must_use]
    pub fn masses_and_loads(&self) -> (&[f64], &[f64]) {
        let loads = if self.model.pins.is_empty() {
            &self.forces
        } else {
            &self.pin_torques.loads
        };
        (&self.model.mass, loads)
    }

    /// Force of each contact on its circle, of all sides, friction and film together \[N\].
    pub(crate) fn pushes(&self) -> impl Iterator<Item = Vec2> {
        let contacts = self.model.sides_of_contact.iter();
        contacts.map(|sides| {
            self.touches[sides.clone()]
                .iter()
                .map(|touch| touch.push + touch.friction)
                .sum()
        })
    }

    /// Kinetic energy and potential energy of gravity \[J\].
    #[must_use]
    pub(crate) fn energy(&self) -> (f64, f64) {
        let mut energy = (0.0, 0.0);
        for (frame, body) in self.frames.iter().zip(&self.model.bodies) {
            if !body.fixed {
                energy.0 += 0.5 * body.mass * frame.velocity.norm_squared()
                    + 0.5 * body.inertia * frame.spin * frame.spin;
                energy.1 -= body.mass * self.model.gravity.dot(&frame.origin);
            }
        }
        energy
    }

    /// Force and torque of a joint on its body b, about the joint's point b \[N, N, N m\].
    #[must_use]
    pub(crate) fn reaction(&self, joint: usize) -> [f64; 3] {
        let mut load = [0.0; 3];
        for i in self.model.equations_of_joint[joint].clone() {
            let end = self.model.equations[i].b;
            let arm = self.frames[end.body].turned(end.point);
            let [x, y, torque] = self.rows[i].jacobian[1].map(|j| -self.multipliers[i] * j);
            load[0] += x;
            load[1] += y;
            load[2] += torque - (arm.x * y - arm.y * x);
        }
        for (pin, torque) in self.model.pins.iter().zip(&self.pin_torques.values) {
            if pin.joint == joint {
                load[2] += torque;
            }
        }
        load
    }

    /// The joint and the contact that carry most and what drivers ask, in words for the end of an error's sentence; empty without either.
    pub(crate) fn hardest_pressed(&self) -> String {
        let joints = (0..self.model.joints.len()).map(|joint| {
            let [x, y, torque] = self.reaction(joint);
            (x.hypot(y).max(torque.abs()), joint)
        });
        let joint = joints
            .filter(|j| j.0.is_finite())
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let contacts = self.pushes().map(|push| push.norm()).enumerate();
        let contact = contacts
            .filter(|c| c.1 > 0.0)
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let joint = joint.map_or(String::new(), |(load, joint)| {
            let name = &self.model.joints[joint].name;
            format!(", joint {name:?} with a load of {load:.1e} N or N m")
        });
        let contact = contact.map_or(String::new(), |(contact, force)| {
            let name = &self.model.contact_names[contact];
            format!(", contact {name:?} with {force:.1e} N")
        });
        let locked = if self.pin_torques.locked {
            ", where the friction of a revolute joint locks itself: its coefficient times its radius is too large for the distance to the next joint"
        } else {
            ""
        };
        joint + &contact + locked + &self.asked()
    }
}

//! Quantities of a mechanism at the last evaluation: matrices of its equations, energies and forces.

use super::contact::impact_memory::Memory;
use super::description::body::Frame;
use super::dynamics::MechanismDynamics;
use crate::integrator::Adams;
use crate::system::Energy;

/// Load of a joint beyond that of any machine \[N, N m\]: the greatest presses have 1e9. At a dead point loads grow without bound.
const JAMMED: f64 = 1e15;

impl MechanismDynamics {
    /// Return the accelerations of the bodies that are not fixed, three per body.
    #[must_use]
    pub fn accelerations(&self) -> &[f64] {
        &self.accelerations
    }

    /// Return the multiplier of each constraint equation.
    #[must_use]
    pub fn multipliers(&self) -> &[f64] {
        &self.constraints.multipliers
    }

    /// Return the non-zero entries (constraint, coordinate, value) of the Jacobian at the last state.
    #[must_use]
    pub fn jacobian(&self) -> Vec<(usize, usize, f64)> {
        self.constraints.jacobian()
    }

    /// Return the right-hand sides γ of the constraints at the last state.
    #[must_use]
    pub fn gamma(&self) -> Vec<f64> {
        self.constraints.rows.iter().map(|row| row.gamma).collect()
    }

    /// Return the mass or moment of inertia of each coordinate, and the load on it at the last state, friction of pins included.
    #[must_use]
    pub fn masses_and_loads(&self) -> (&[f64], &[f64]) {
        let loads = if self.model.pins.is_empty() {
            &self.loads.free
        } else {
            &self.constraints.pin_torques.loads
        };
        (&self.model.mass, loads)
    }

    /// Return kinetic, elastic and gravitational energy at the last evaluation.
    #[must_use]
    pub(crate) fn energies(&self) -> Energy {
        let mut energy = Energy {
            elastic: self.loads.elastic + self.loads.bristles,
            ..Energy::default()
        };
        for (frame, body) in self.frames.iter().zip(&self.model.bodies) {
            if !body.fixed {
                energy.kinetic += 0.5 * body.mass * frame.velocity.norm_squared()
                    + 0.5 * body.inertia * frame.spin * frame.spin;
                energy.gravity -= body.mass * self.model.gravity.dot(&frame.origin);
            }
        }
        energy
    }

    /// Return the force of each contact on its circle \[N\].
    #[must_use]
    pub fn contact_forces(&self) -> Vec<[f64; 2]> {
        self.contacts
            .pushes(&self.model)
            .map(<[f64; 2]>::from)
            .collect()
    }

    /// Return the positions of all bodies but the ground at the last evaluation.
    pub(crate) fn positions(&self) -> Vec<[f64; 3]> {
        self.frames[1..].iter().map(Frame::position).collect()
    }

    /// Return the velocities of all bodies but the ground at the last evaluation.
    pub(crate) fn velocities(&self) -> Vec<[f64; 3]> {
        self.frames[1..].iter().map(Frame::rates).collect()
    }

    /// Return the largest residual of positions and of velocities at the end of the last step.
    pub(crate) fn drift(&mut self, adams: &Adams) -> [f64; 2] {
        let t = adams.time();
        let mut state = vec![0.0; 2 * self.model.coordinates()];
        self.state_at(adams, t, &mut state);
        self.place(t, &state);
        let (rows, frames) = (&self.constraints.rows, &self.frames);
        [
            rows.iter().map(|row| row.value.abs()).fold(0.0, f64::max),
            rows.iter()
                .map(|row| row.rate(frames).abs())
                .fold(0.0, f64::max),
        ]
    }

    /// Evaluate everything at time `t` at the last state, which is that at `now` in the last step, with other positions and velocities.
    /// Given positions clear the memory of all contacts; without them, it becomes that at `now`.
    pub(crate) fn evaluate_with(
        &mut self,
        (adams, now): (&Adams, f64),
        positions: Option<&[[f64; 3]]>,
        velocities: Option<&[[f64; 3]]>,
        t: f64,
    ) {
        self.restore_memory(adams, now);
        let mut state = self.model.read_state(&self.frames);
        let n = self.model.coordinates();
        for (given, begin) in [(positions, 0), (velocities, n)] {
            for (row, first) in given.unwrap_or(&[]).iter().zip(&self.model.first[1..]) {
                if let Some(i) = *first {
                    state[begin + i..begin + i + 3].copy_from_slice(row);
                }
            }
        }
        if positions.is_some() {
            self.contacts.memory.fill(Memory::default());
            self.contacts.bristles.deflection.fill(0.0);
        }
        self.evaluate(t, &state);
    }

    /// Return the magnitude of a joint's force \[N\].
    pub(crate) fn joint_force(&self, joint: usize) -> f64 {
        let [x, y, _] = self.reaction(joint);
        (x * x + y * y).sqrt()
    }

    /// Return force and torque of a joint on its body b, about the joint's point b \[N, N, N m\].
    pub(crate) fn reaction(&self, joint: usize) -> [f64; 3] {
        self.constraints.reaction(&self.model, &self.frames, joint)
    }

    /// Return the joint and the contact with the largest loads and the values prescribed by drivers, as text at the end of an error
    /// message. The text is empty without either.
    pub(crate) fn hardest_pressed(&self) -> String {
        let joints = (0..self.model.joints.len()).map(|joint| {
            let [x, y, torque] = self.reaction(joint);
            ((x * x + y * y).sqrt().max(torque.abs()), joint)
        });
        let joint = joints
            .filter(|j| j.0.is_finite())
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let contacts = self
            .contacts
            .pushes(&self.model)
            .map(|push| push.norm())
            .enumerate();
        let contact = contacts
            .filter(|c| c.1 > 0.0)
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let asked = self.constraints.asked(&self.model, &self.frames);
        let dead_point = match joint {
            Some((load, _)) if load > JAMMED && !asked.is_empty() => {
                ", beyond what any part bears: no positions of the joints may follow the drivers further, as at a dead point of a linkage"
            }
            _ => "",
        };
        let joint = joint.map_or(String::new(), |(load, joint)| {
            let name = &self.model.joints[joint].name;
            format!(", joint {name:?} with a load of {load:.1e} N or N m")
        });
        let contact = contact.map_or(String::new(), |(contact, force)| {
            let name = &self.model.contact_names[contact];
            format!(", contact {name:?} with {force:.1e} N")
        });
        let locked = if self.constraints.pin_torques.locked {
            ", where the friction of a revolute joint locks itself: its coefficient times its radius is too large for the distance to the next joint"
        } else {
            ""
        };
        joint + dead_point + &contact + locked + &asked
    }
}

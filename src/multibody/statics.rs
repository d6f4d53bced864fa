//! Statics of a mechanism: drivers held, loads of the first instant, forces and displacements of an iteration to equilibrium.

use super::assembly::projection::AtHand;
use super::contact::compiled_contact::CompiledContact;
use super::description::driver::PrescribedMotion;
use super::description::force_element::ForceKind;
use super::dynamics::MechanismDynamics;
use super::forces::loads::BodyLoads;
use super::model::MechanismModel;
use super::step_start::ITERATIONS;
use crate::error::{Error, Result, check};
use crate::math::Signal;

/// Difference of two positions over their size, or 1 m or 1 rad where that is more, below which they are the same but for rounding.
const SAME_PLACE: f64 = 1e-9;

impl MechanismModel {
    /// Return whether a contact or pin has friction, or a contact a lubricant film, which a model at rest leaves out.
    pub(crate) fn has_friction(&self) -> bool {
        let resists =
            |contact: &CompiledContact| contact.friction.is_some() || contact.film.is_some();
        self.contacts.iter().any(resists) || !self.pins.is_empty() || self.bristles > 0
    }

    /// Return the model with its drivers held at their initial positions, and torques over speed at the initial speeds.
    ///
    /// Nothing slides at rest: friction and lubricant films carry no load.
    #[must_use]
    pub(crate) fn held(mut self) -> Self {
        for motion in self.equations.iter_mut().filter_map(|e| e.motion.as_mut()) {
            let [place, _, _] = motion.derivatives(0.0);
            *motion = PrescribedMotion::Position(place.into());
        }
        let frames = self.start_frames();
        for force in &mut self.forces {
            if matches!(force.kind, ForceKind::TorqueBySpeed(_)) {
                force.kind = ForceKind::Torque(force.torque(0.0, &frames).into());
            }
        }
        for contact in &mut self.contacts {
            (contact.friction, contact.film) = (None, None);
        }
        self.bristle_of_side.fill(None);
        self.bristles = 0;
        self.pins.clear();
        self
    }

    /// Return the model with its bodies at other positions and velocities. Lengths and angles that are not described remain those of the
    /// described positions; speeds of drivers are integrated from the new ones.
    ///
    /// # Errors
    /// If there is not one row for each body, a number is not finite, the position of a fixed body is not the described one, or it has a
    /// velocity.
    pub(crate) fn placed(
        mut self,
        positions: &[[f64; 3]],
        velocities: &[[f64; 3]],
    ) -> Result<Self> {
        let bodies = self.bodies.len() - 1;
        for (field, rows) in [("positions", positions), ("velocities", velocities)] {
            check::rows(field, rows, bodies)?;
        }
        let rows = positions.iter().zip(velocities);
        for (body, (position, velocity)) in self.bodies[1..].iter_mut().zip(rows) {
            let same = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME_PLACE * (1.0 + b.abs());
            if body.fixed && !position.iter().zip(&body.position).all(same) {
                return Err(Error::invalid(
                    format!("positions of {:?}", body.name),
                    format!("{position:?}"),
                    format!("must be {:?}, where the body is fixed", body.position),
                ));
            }
            (body.position, body.velocity) = (*position, *velocity);
            body.validate()?;
        }
        // A speed is integrated from the place where the bodies are.
        let frames = self.start_frames();
        for equation in &mut self.equations {
            if matches!(equation.motion, Some(PrescribedMotion::Speed(_))) {
                let place = equation.quantity(&frames);
                if (place - equation.offset).abs() > SAME_PLACE * (1.0 + place.abs()) {
                    equation.offset = place;
                }
            }
        }
        Ok(self)
    }
}

impl MechanismDynamics {
    /// Return the size of a load on a body \[N\], whose moment is divided by the length of the body's angle; zero on a fixed body.
    fn size_of_load(&self, lengths: &[f64], body: usize, load: [f64; 3]) -> f64 {
        self.model.first[body].map_or(0.0, |i| {
            load[0].hypot(load[1]).max(load[2].abs() / lengths[i + 2])
        })
    }

    /// Return of each body the largest load by its weight, a force element or a contact at the last evaluation \[N\], zero where it is
    /// fixed; moments of force elements are divided by the `lengths` of the angles.
    pub(crate) fn loads_by_body(&self, lengths: &[f64]) -> Vec<f64> {
        let model = &self.model;
        let weight = model.gravity.norm();
        let mut largest: Vec<f64> = model.bodies.iter().map(|body| body.mass * weight).collect();
        let mut loads = BodyLoads::new(model.bodies.len(), 0);
        for force in &model.forces {
            for body in [force.a.body, force.b.body] {
                loads.on[body] = [0.0; 3];
            }
            force.add(0.0, &self.frames, &mut loads);
            for body in [force.a.body, force.b.body] {
                largest[body] = largest[body].max(self.size_of_load(lengths, body, loads.on[body]));
            }
        }
        for (contact, push) in model.contacts.iter().zip(self.contacts.pushes(model)) {
            for body in [contact.a.body, contact.b.body] {
                largest[body] = largest[body].max(push.norm());
            }
        }
        let fixed = largest.iter_mut().zip(&model.first);
        fixed.for_each(|(load, first)| *load = first.map_or(0.0, |_| *load));
        largest
    }

    /// Return of each body the largest reaction of a constraint at the last evaluation \[N\], as of [`Self::loads_by_body`].
    pub(crate) fn reactions_by_body(&self, lengths: &[f64]) -> Vec<f64> {
        let constraints = &self.constraints;
        let mut largest: Vec<f64> = vec![0.0; self.model.bodies.len()];
        for (row, lambda) in constraints.rows.iter().zip(&constraints.multipliers) {
            for (&body, part) in row.bodies.iter().zip(&row.jacobian) {
                let load = part.map(|part| lambda * part);
                largest[body] = largest[body].max(self.size_of_load(lengths, body, load));
            }
        }
        largest
    }

    /// Return the name of a force element that is zero at the first instant and not later.
    pub(crate) fn load_that_grows(&self) -> Option<&str> {
        let grows = |signal: &Signal| signal.value(0.0) == 0.0 && !signal.is_zero();
        let force = self.model.forces.iter().find(|force| match &force.kind {
            ForceKind::Force { x, y, .. } => {
                x.value(0.0) == 0.0 && y.value(0.0) == 0.0 && (grows(x) || grows(y))
            }
            ForceKind::Torque(torque) => grows(torque),
            _ => false,
        })?;
        Some(&force.name)
    }

    /// Return of each contact the speed of the circle relative to the profile \[m/s\], a lower bound of the gap \[m\], and the clearance in
    /// a bore or a quarter of the circle's radius elsewhere \[m\], at the last evaluation and the present velocities.
    pub(crate) fn contact_moves(&self) -> impl Iterator<Item = [f64; 3]> {
        let contacts = self.model.contacts.iter().zip(&self.contacts.deepest);
        contacts.map(|(contact, [depth, _])| {
            let frames = [contact.a.body, contact.b.body].map(|body| &self.frames[body]);
            let speed = contact.approach(frames[0], frames[1]).norm();
            [speed, -depth, contact.play()]
        })
    }

    /// Project positions near the last evaluation onto the constraints; return whether the remaining residual is accepted.
    ///
    /// The change is that of the matrix of the last step, in which contacts are stiff.
    pub(crate) fn project_at_rest(&mut self, state: &mut [f64]) -> bool {
        self.projector()
            .project(0.0, state, ITERATIONS, AtHand::Corrector)
    }

    /// Return contact, side and piece of the profile, from 0, of all sides with a memory.
    pub(crate) fn stored_surfaces(&self) -> Vec<[usize; 3]> {
        let sides = self.model.sides.iter().zip(&self.contacts.memory);
        let live = sides.filter(|(_, memory)| memory.is_in_contact());
        live.map(|(&(contact, side), memory)| [contact, side, memory.piece])
            .collect()
    }

    /// Change the pieces of the memory to those of a static equilibrium: `surfaces` as of [`Self::stored_surfaces`].
    ///
    /// # Errors
    /// If there is no such contact, side or piece.
    pub(crate) fn store_surfaces(&mut self, surfaces: &[[usize; 3]]) -> Result<()> {
        for &[contact, side, piece] in surfaces {
            let sides = self.model.sides_of_contact.get(contact);
            let k = sides.and_then(|sides| sides.clone().nth(side));
            let exists = |k: &usize| {
                piece < self.model.contacts[contact].pieces() && *k < self.contacts.memory.len()
            };
            let Some(k) = k.filter(exists) else {
                return Err(Error::invalid(
                    "surfaces",
                    format!("({contact}, {side}, {piece})"),
                    "must have a contact, a side and a piece of its profile, each counted from 0",
                ));
            };
            let memory = &mut self.contacts.memory[k];
            if memory.is_in_contact() {
                memory.piece = piece;
            }
        }
        Ok(())
    }
}

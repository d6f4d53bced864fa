//! Derivatives of contact forces with respect to position and velocity of the circle, for the implicit corrector.

use nalgebra::Matrix2;

use super::compiled_contact::CompiledContact;
use super::contact_states::ContactStates;
use super::impact_memory::{Memory, SideState};
use crate::multibody::constraints::relative_kinematics::{PairForce, PairTorque};
use crate::multibody::description::body::Frame;
use crate::multibody::model::MechanismModel;

impl CompiledContact {
    /// Call `visit` with the side and the force slopes of each contact point that has a force.
    ///
    /// The force on the circle is F = w f n - E ∇w, with outward normal n and weight w. The penetration rate is δ' = -n·v. The
    /// derivatives are ∂δ/∂x = -n, ∂n/∂x = b (1 - n nᵀ) and ∂f/∂x = -k n - c (∂n/∂x v). Here b is the rotation of the normal.
    pub(crate) fn slopes(
        &self,
        frames: &[Frame],
        memory: &[Memory],
        mut visit: impl FnMut(usize, &PairForce),
    ) {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let approach = self.approach(fa, fb);
        let local = self.local(fa, fb);
        self.contact_points(local, |candidate, _| {
            let memory = memory[candidate.side];
            let depth = self.radius - candidate.distance;
            if depth <= 0.0 || !self.may_carry_force(candidate, memory) {
                return;
            }
            let n = fa.turned(candidate.outward);
            let gradient = fa.turned(candidate.weight_gradient);
            let (law, rate) = (self.pair(candidate, memory), -n.dot(&approach));
            let [force, stiffness, damping] = law.slopes(depth, rate, memory.speed);
            let elastic = law.force(depth, rate, memory.speed).elastic;
            let energy = law.energy(depth);
            let w = candidate.weight;
            let bend = match self.outline {
                Some(_) => candidate.bend,
                None => self.profile().bend(local, self.radius, candidate.outward),
            };
            let across = bend * (Matrix2::identity() - n * n.transpose());
            // The second derivative of the weight is neglected.
            let along = -stiffness * n - damping * (across * approach);
            let slopes = PairForce {
                force: w * force * n - energy * gradient,
                by_place: w * (n * along.transpose() + force * across)
                    + force * n * gradient.transpose()
                    + elastic * gradient * n.transpose(),
                by_velocity: -w * damping * (n * n.transpose()),
            };
            visit(candidate.side, &slopes);
        });
    }
}

impl ContactStates {
    /// Return whether contact `k` may have a force: contacts without penetration and film have none.
    pub(crate) fn has_force(&self, model: &MechanismModel, k: usize) -> bool {
        let side_states = &self.side_states[model.sides_of_contact[k].clone()];
        let apart = |side_state: &SideState| side_state.contact.penetration <= 0.0;
        model.contacts[k].film.is_some() || !side_states.iter().all(apart)
    }

    /// Call `visit` with the derivatives of the normal force at each contact point of contact `k`, then with those of the friction of
    /// each side and of the film, which have a torque.
    pub(crate) fn visit_slopes(
        &self,
        model: &MechanismModel,
        frames: &[Frame],
        k: usize,
        mut visit: impl FnMut(&PairForce, Option<&PairTorque>),
    ) {
        let (contact, sides) = (&model.contacts[k], &model.sides_of_contact[k]);
        let memory = &self.memory[sides.clone()];
        contact.slopes(frames, memory, |_, force| visit(force, None));
        if let Some(law) = &contact.friction {
            for k in sides.clone().filter(|&k| self.side_states[k].force > 0.0) {
                let mut push = PairForce::default();
                contact.slopes(frames, memory, |side, part| {
                    if sides.start + side == k {
                        push.add(part);
                    }
                });
                let bent = model.bristle_of_side[k].map(|i| self.bristles.bent(i));
                let (force, torque) = contact.friction_slopes(law, frames, &push, bent);
                visit(&force, Some(&torque));
            }
        }
        if let Some(film) = &contact.film {
            let (force, torque) = contact.film_slopes(film, frames);
            visit(&force, Some(&torque));
        }
    }
}

#[cfg(test)]
mod tests;

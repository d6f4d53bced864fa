//! Derivatives of contact forces with respect to position and velocity of the circle, for the implicit corrector.

use nalgebra::Matrix2;

use super::compiled_contact::CompiledContact;
use super::contact_states::ContactStates;
use super::impact_memory::{Memory, SideState};
use crate::geometry::Vec2;
use crate::multibody::constraints::relative_kinematics::{PairForce, PairTorque};
use crate::multibody::description::body::Frame;
use crate::multibody::description::contact_law::CompiledLaw;
use crate::multibody::model::MechanismModel;

/// A contact point with a force: penetration and its rate, the elastic law, and the rotation b of the normal per displacement.
struct Pressed<'a> {
    depth: f64,
    rate: f64,
    law: &'a CompiledLaw,
    bend: f64,
    normal: Vec2,
    approach: Vec2,
}

impl Pressed<'_> {
    /// Return the normal force f n with its derivatives: ∂δ/∂x = -n, ∂n/∂x = b (1 - n nᵀ) and ∂f/∂x = -k n - c (∂n/∂x v).
    fn slopes(&self, memory: Memory) -> PairForce {
        let n = self.normal;
        let [force, stiffness, damping] = self.law.slopes(self.depth, self.rate, memory.speed);
        let across = self.bend * (Matrix2::identity() - n * n.transpose());
        let along = -stiffness * n - damping * (across * self.approach);
        PairForce {
            force: force * n,
            by_place: n * along.transpose() + force * across,
            by_velocity: -damping * (n * n.transpose()),
        }
    }
}

impl CompiledContact {
    /// Call `visit` with the side and the force slopes of each contact point that has a force, and those of the part of the force that has
    /// friction. `side_states` and `memory` are those of the sides, evaluated at these frames.
    ///
    /// The force on the circle is F = w f n - E ∇w, with outward normal n and weight w. Between two sides only its first term has friction.
    /// The penetration rate is δ' = -n·v.
    pub(crate) fn slopes(
        &self,
        frames: &[Frame],
        (side_states, memory): (&[SideState], &[Memory]),
        mut visit: impl FnMut(usize, &PairForce, &PairForce),
    ) {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let approach = self.approach(fa, fb);
        let Some(outline) = &self.outline else {
            // The only contact point is that of the evaluation.
            let (found, memory) = (&side_states[0], memory[0]);
            if found.contact.penetration > 0.0 {
                let depth = found.contact.penetration;
                let pressed = Pressed {
                    depth,
                    rate: found.contact.penetration_rate,
                    law: self.law_on(found.piece, memory),
                    bend: self.profile().bend(found.piece, self.radius - depth),
                    normal: -found.contact.normal,
                    approach,
                };
                let slopes = pressed.slopes(memory);
                visit(0, &slopes, &slopes);
            }
            return;
        };
        outline.contact_points(self.local(fa, fb), self.radius, |candidate| {
            let memory = memory[candidate.side];
            let depth = self.radius - candidate.distance;
            if depth <= 0.0 || !self.may_carry_force(candidate, memory) {
                return;
            }
            let n = fa.turned(candidate.outward);
            let gradient = fa.turned(candidate.weight_gradient);
            let (law, rate) = (self.law_on(candidate.piece, memory), -n.dot(&approach));
            let pressed = Pressed {
                depth,
                rate,
                law,
                bend: candidate.bend,
                normal: n,
                approach,
            };
            let pushed = pressed.slopes(memory);
            let elastic = law.force(depth, rate, memory.speed).elastic;
            let (w, energy) = (candidate.weight, law.energy(depth));
            let mut pressing = PairForce {
                force: w * pushed.force,
                by_place: w * pushed.by_place + pushed.force * gradient.transpose(),
                by_velocity: w * pushed.by_velocity,
            };
            // The second derivative of the weight is neglected.
            let whole = PairForce {
                force: pressing.force - energy * gradient,
                by_place: pressing.by_place + elastic * gradient * n.transpose(),
                ..pressing
            };
            if !candidate.is_between() {
                pressing = whole;
            }
            visit(candidate.side, &whole, &pressing);
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
        let states = (
            &self.side_states[sides.clone()],
            &self.memory[sides.clone()],
        );
        contact.slopes(frames, states, |_, force, _| visit(force, None));
        if let Some(law) = &contact.friction {
            for k in sides.clone().filter(|&k| self.side_states[k].force > 0.0) {
                let mut pressing = PairForce::default();
                contact.slopes(frames, states, |side, _, part| {
                    if sides.start + side == k {
                        pressing.add(part);
                    }
                });
                if pressing.force == Vec2::zeros() {
                    continue;
                }
                let inward = self.side_states[k].contact.normal;
                let bent = model.bristle_of_side[k].map(|i| self.bristles.bent(i));
                let (force, torque) =
                    contact.friction_slopes(law, frames, (&pressing, inward), bent);
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

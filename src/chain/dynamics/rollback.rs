//! Rollback to a time inside the last step, for a change of speed or torque inputs.

use std::sync::Arc;

use super::Dynamics;
use super::contact_events::Restart;
use crate::chain::contact::ContactId;
use crate::chain::model::Model;

impl Dynamics {
    /// Continue at (`t`, `y`) inside the last step with `model`, which may differ in its inputs of speed and torque only.
    ///
    /// Contact onsets after `t` are removed, contacts that ended after `t` continue, and the energy sums are those at `t`.
    pub(crate) fn roll_back(&mut self, model: Arc<Model>, t: f64, y: &[f64]) {
        self.quadrature.cut(t);
        self.model = model;
        self.evaluate(t, y);
        for contact in self.memory.contacts() {
            let (penetration, rate) = self.evaluated.penetration_and_rate(contact);
            let (touching, remembered) = (penetration > 0.0, self.memory.has(contact));
            let restart = self.restart_after(contact, t);
            if !touching && remembered {
                // The onset of a contact that ended in the last step was before the step.
                if self.events.ended.contains(&contact) {
                    self.memory.end(contact);
                } else {
                    self.memory.take_back_onset(contact, 0.0);
                }
            } else if touching && !remembered {
                self.begin_evaluated_contact(contact, rate);
            } else if let Some(restart) = restart.filter(|_| touching) {
                let speed = restart.impact_velocity;
                self.memory.take_back_onset(contact, speed);
                self.memory.set_surface(contact, restart.surface);
            }
        }
        self.events.ended.clear();
        self.events.restarted.clear();
        self.events.jumps.remove_after(&self.model, t);
        self.kernels.candidates.invalidate();
        self.begin_screening(t, y);
        self.kernels.end_step();
        if self.keeps_energy {
            self.quadrature.begin(t, self.powers(t, y));
        }
    }

    /// Return the memory of a contact before its end and second onset in the last step, if the onset was after `t` \[s\].
    fn restart_after(&self, contact: ContactId, t: f64) -> Option<Restart> {
        let restarted = self.events.restarted.iter();
        (restarted.copied()).find(|restart| restart.contact == contact && restart.time > t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::contact::tests::{compiled, drive};
    use crate::chain::dynamics::contact_events::Onset;
    use crate::chain::motion::Motion;
    use crate::geometry::Surface;

    /// Return dynamics with a hinge in contact, its state, and that hinge.
    fn touching_hinge() -> (Dynamics, Vec<f64>, ContactId) {
        let (model, start) = compiled(&drive());
        let mut motion = Motion::new(model.bodies());
        motion.set(&start.positions, &start.velocities);
        let mut y = vec![0.0; 2 * model.coordinates];
        motion.write(&model, &mut y);
        // A link between the sprockets moves by twice the clearance: one of its hinges is then in contact, whatever the start.
        y[5] += 2.0 * model.hinges.clearance;
        let mut dynamics = Dynamics::new(Arc::new(model));
        dynamics.remember_present_contacts(0.0, &y);
        let mut contacts = dynamics.memory.contacts();
        let hinge = contacts.find(|&contact| dynamics.memory.has(contact));
        let hinge = hinge.unwrap();
        assert!(matches!(hinge, ContactId::Hinge(_)));
        (dynamics, y, hinge)
    }

    #[test]
    fn a_contact_that_restarted_behind_the_time_has_its_former_memory() {
        // The sprockets turn by nothing meanwhile.
        let (restarted_at, before, after) = (0.7e-12, 0.3, 2.0);
        for (t, expected, fewer) in [(0.5e-12, before, 1), (0.9e-12, after, 0)] {
            let (mut dynamics, y, contact) = touching_hinge();
            dynamics.memory.begin(contact, before);
            dynamics.events.begun.push(Onset {
                contact,
                time: restarted_at,
                rate: after,
                surface: None::<Surface>,
            });
            dynamics.begin_located_contacts();
            assert_eq!(dynamics.memory.impact_velocity(contact), after);
            let onsets = dynamics.memory.counts().onsets;
            dynamics.roll_back(Arc::clone(&dynamics.model), t, &y);
            assert_eq!(dynamics.memory.impact_velocity(contact), expected);
            assert_eq!(dynamics.memory.counts().onsets, onsets - fewer);
        }
    }

    #[test]
    fn a_contact_that_is_open_at_the_time_has_none_and_keeps_the_count_of_an_onset_before_the_step()
    {
        for ended in [false, true] {
            let (mut dynamics, mut y, contact) = touching_hinge();
            y[5] -= 2.0 * dynamics.model.hinges.clearance;
            if ended {
                dynamics.events.ended.push(contact);
            }
            let onsets = dynamics.memory.counts().onsets;
            dynamics.roll_back(Arc::clone(&dynamics.model), 0.5e-12, &y);
            assert!(!dynamics.memory.has(contact));
            assert!(dynamics.memory.counts().onsets <= onsets - u64::from(!ended));
        }
    }
}

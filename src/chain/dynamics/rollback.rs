//! Rollback to a time inside the last step, for a change of speed or torque inputs.

use std::sync::Arc;

use super::{ContactId, Dynamics};
use crate::chain::model::Model;

impl Dynamics {
    /// Continue at (`t`, `y`) inside the last step with `model`, which may differ in its inputs of speed and torque only.
    ///
    /// Contact onsets after `t` are removed, contacts that ended after `t` continue, and the energy sums are those at `t`.
    pub(crate) fn turn_back(&mut self, model: Arc<Model>, t: f64, y: &[f64]) {
        self.quadrature.cut(t);
        self.model = model;
        self.evaluate(t, y);
        for k in 0..self.model.links {
            let touching = self.evaluated.hinges.penetration[k] > 0.0;
            let speed = self.memory.hinge_impact_velocity()[k];
            if touching && speed == 0.0 {
                self.memory.begin_hinge(k, self.evaluated.hinges.rate[k]);
            } else if !touching && speed > 0.0 {
                self.memory.end_hinge(k);
                self.forget_onset(ContactId::Hinge(k), speed);
            }
        }
        for k in 0..self.model.roller_count() {
            let touching = self.evaluated.rollers.penetration[k] > 0.0;
            let speed = self.memory.roller_impact_velocity()[k];
            if touching && speed == 0.0 {
                self.memory.begin_roller(k, self.evaluated.rollers.rate[k]);
            } else if !touching && speed > 0.0 {
                self.memory.end_roller(k);
                self.forget_onset(ContactId::Roller(k), speed);
            }
        }
        for pair in 0..self.memory.tooth_impact_velocity.len() {
            let touching = self.evaluated.teeth.penetration[pair] > 0.0;
            let speed = self.memory.tooth_impact_velocity[pair];
            if touching && speed == 0.0 {
                let (rate, surface) = (
                    self.evaluated.teeth.rate[pair],
                    self.evaluated.teeth.surface(pair),
                );
                self.memory.begin_tooth(pair, rate, surface);
            } else if !touching && speed > 0.0 {
                self.memory.end_tooth(pair);
                self.forget_onset(ContactId::Tooth(pair), speed);
            }
        }
        self.events.parted.clear();
        self.events.jumps.remove_after(&self.model, t);
        self.kernels.candidates.invalidate();
        self.begin_watch(t, y);
        self.kernels.end_step();
        if self.keeps_energy {
            self.quadrature.begin(t, self.powers(t));
        }
    }

    /// Remove the onset of an open pair from the counts, unless the pair ended in the last step: that onset was before the step.
    fn forget_onset(&mut self, pair: ContactId, speed: f64) {
        if !self.events.parted.contains(&pair) {
            self.memory.uncount(speed);
        }
    }
}

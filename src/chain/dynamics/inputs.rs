//! Inputs of speed and torque during a run: the integrator restarts at the present time, inside its last step.

use std::sync::Arc;

use super::Dynamics;
use crate::chain::model::{Input, Model};
use crate::drive::InputQuantity;
use crate::error::Result;
use crate::integrator::Adams;
use crate::math::Signal;
use crate::system::System;

/// Shortest step to a kink of an input \[s\]; a nearer kink counts as reached. Doubled or halved, the measured scenes give equal runs.
const SHORTEST_TO_KINK: f64 = 1e-10;

/// Compiled model, and the inputs set since the start of the run.
#[derive(Debug, Clone)]
pub(super) struct Inputs {
    pub(super) compiled: Arc<Model>,
    /// Inputs of speed or torque, at most one per sprocket.
    pub(super) set: Vec<Input>,
    /// Time of the next kink of an input \[s\]; -inf before its first evaluation.
    kink: f64,
    /// Longest step until then that resolves the inputs \[s\].
    between: f64,
}

impl Inputs {
    pub(super) fn new(compiled: &Arc<Model>) -> Self {
        Self {
            compiled: Arc::clone(compiled),
            set: Vec::new(),
            kink: f64::NEG_INFINITY,
            between: f64::INFINITY,
        }
    }
}

impl Dynamics {
    /// Change the speed or torque of `sprocket` (from 0) from time `t` \[s\] on, inside the last step of `adams`.
    ///
    /// Return false if the sprocket already has this input.
    ///
    /// The solution beyond `t` is computed again. Positions and velocities are continuous, except the speed of a sprocket with a new
    /// prescribed speed. Contacts keep their memory, and the energy balance continues.
    ///
    /// # Errors
    /// When there is no such sprocket, its motion has no such quantity, or `signal` exceeds the bounds of a drive; the dynamics are then
    /// unchanged.
    pub(crate) fn set_input(
        &mut self,
        (sprocket, quantity): (usize, InputQuantity),
        signal: Signal,
        t: f64,
        adams: &mut Adams,
    ) -> Result<bool> {
        let Some(input) = self.model.input(sprocket, quantity, signal, t)? else {
            return Ok(false);
        };
        let Some(model) = self.model.with_inputs(std::slice::from_ref(&input)) else {
            return Ok(false);
        };
        self.inputs.set.retain(|other| !input.replaces(other));
        self.inputs.set.push(input);
        let mut y = vec![0.0; adams.y().len()];
        adams.interpolate(t, &mut y);
        self.unbend_open(t, &mut y);
        self.roll_back(Arc::new(model), t, &y);
        adams.restart_with_corrector(t, &y);
        self.inputs.kink = f64::NEG_INFINITY;
        Ok(true)
    }

    /// Return the longest step from `t` that resolves the inputs and ends at their next kink at the latest \[s\].
    pub(super) fn longest_step_of_inputs(&mut self, t: f64) -> f64 {
        // A kink reached to within rounding counts as past.
        let now = t + SHORTEST_TO_KINK;
        if self.inputs.kink <= now {
            self.inputs.kink = self.model.next_kink(now);
            self.inputs.between = self.model.longest_step_between_kinks(now);
        }
        (self.inputs.kink - t).min(self.inputs.between)
    }

    /// Restart the integrator at a row of an end's velocity table, where the acceleration of an anchored end is discontinuous.
    ///
    /// The end is set to its prescribed position and velocity. Between two rows its path is exact; without the correction, the error of a
    /// step that ends just before the row would remain as a constant velocity error. A row belongs to the step that ends at it or just before it. A
    /// step that ends behind a row has passed it, however short the step is.
    pub(super) fn restart_at_kink_of_end(&mut self, adams: &mut Adams) {
        // Before the clone: its counter is atomic, and waits for all stores of the step before.
        if self.model.ends.is_none() {
            return;
        }
        let model = Arc::clone(&self.model);
        let Some(ends) = &model.ends else { return };
        let t = adams.time();
        let row = ends.next_knot(t * (1.0 - 2.0 * f64::EPSILON));
        if row - t > SHORTEST_TO_KINK || t <= 0.0 {
            return;
        }
        let (n, coordinates) = (model.links, model.coordinates);
        let y = &mut self.inside;
        adams.interpolate(t, y);
        for end in &ends.bodies {
            if let Some((place, velocity)) = end.given_motion(row) {
                let i = end.body;
                (y[i], y[n + i]) = (place.x, place.y);
                y[coordinates + i] = velocity.x;
                y[coordinates + n + i] = velocity.y;
            }
        }
        adams.restart_with_corrector(row, &y[..2 * coordinates]);
        self.kernels.begin_step(row);
        let longest = System::longest_step(self, adams);
        adams.limit_step(longest);
        // The next step is metered from this motion, and with the slope behind the row.
        self.resume_energy_quadrature(adams);
    }

    /// Set ends with varying acceleration to their prescribed positions and velocities: the errors of the steps would accumulate.
    pub(super) fn place_ends_on_their_curves(&self, adams: &mut Adams) {
        let Some(ends) = &self.model.ends else { return };
        let (n, coordinates) = (self.model.links, self.model.coordinates);
        for end in ends.bodies.iter().filter(|end| end.follows_a_curve()) {
            let Some((place, velocity)) = end.given_motion(adams.time()) else {
                continue;
            };
            let (x, y) = (end.body, n + end.body);
            adams.set_component(x, place.x);
            adams.set_component(y, place.y);
            adams.set_component(coordinates + x, velocity.x);
            adams.set_component(coordinates + y, velocity.y);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::contact::tests::drive;
    use crate::chain::model::ForceLaws;
    use crate::chain::motion::Motion;
    use crate::drive::{Chain, ChainEnd, Drive};
    use crate::geometry::Vec2;
    use crate::integrator::{OdeSystem, StepControl};
    use crate::layout::InitialConfiguration;
    use crate::math::Table;
    use crate::system::System;

    /// Six links between two anchored ends, one of which has a velocity table of `rows`.
    fn moved_strand(rows: &[(f64, f64)]) -> Drive {
        let x = Table::new("velocity", "m/s", rows).unwrap();
        let anchor = |position, x: Signal| ChainEnd::Anchored {
            position,
            velocity: [x, 0.0.into()],
            links: None,
        };
        let closed = drive();
        Drive {
            chain: Chain {
                links: 6,
                ..closed.chain
            },
            sprockets: Vec::new(),
            ends: Some([
                anchor(Vec2::zeros(), x.into()),
                anchor(Vec2::new(0.06, 0.0), 0.0.into()),
            ]),
            ..closed
        }
    }

    #[test]
    fn a_step_behind_a_row_is_metered_with_the_acceleration_behind_it() {
        let row = 1e-3;
        let drive = moved_strand(&[(0.0, 0.0), (row, 0.0), (2.0 * row, 10.0)]);
        let laws = ForceLaws::default();
        let (start, _) = InitialConfiguration::generate(&drive).unwrap();
        let model = Arc::new(Model::compile(&drive, &laws, &start).unwrap());
        let mut dynamics = Dynamics::new(model);
        let mut y = vec![0.0; dynamics.dimension()];
        let mut motion = Motion::new(dynamics.model.bodies());
        motion.set(&start.positions, &start.velocities);
        motion.write(&dynamics.model, &mut y);
        dynamics.begin_present_contacts(0.0, &y, &start.surfaces);
        let mut adams = Adams::new(y.len(), StepControl::default());
        adams.restart(0.0, &y);
        dynamics.begin_energy_quadrature(&adams, 0.0);
        while adams.time() < row {
            dynamics.begin_step(&mut adams);
            let longest = dynamics.longest_step(&adams);
            adams.limit_step(longest);
            let step = adams.step_second_order(&mut dynamics).unwrap();
            dynamics.finish_step(&mut adams, &step).unwrap();
            dynamics.reach_step_end(&adams, &step, false);
            dynamics.meter_step(&adams, &step);
        }
        dynamics.begin_step(&mut adams);
        adams.step_second_order(&mut dynamics).unwrap();
        let end = dynamics.model.ends.as_ref().unwrap().bodies[0].body;
        let [before, _] = adams.slopes_of_last_step();
        let acceleration = before[dynamics.model.coordinates + end];
        assert!((acceleration - 10.0 / row).abs() < 1e-6, "{acceleration}");
    }
}

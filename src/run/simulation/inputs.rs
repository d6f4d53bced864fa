//! Speeds and torques set while a drive runs: the integrator goes back to the present time and starts from there.

use std::sync::Arc;

use super::Simulation;
use crate::chain::model::Quantity;
use crate::error::Result;
use crate::math::Signal;

impl Simulation {
    /// Lets sprocket `sprocket` (from 0) have another speed or torque from the present time on.
    ///
    /// What the integrator had made beyond the present time is made anew. Positions do not jump, nor do velocities but that of the
    /// sprocket whose speed is set; contacts keep their memory and the energy balance goes on.
    ///
    /// # Errors
    /// When there is no such sprocket, its motion has no such quantity, or `signal` is beyond what a drive may be described with; the simulation is then what it was.
    pub fn set_input(&mut self, sprocket: usize, quantity: Quantity, signal: Signal) -> Result<()> {
        let Some(input) = self.model().input(sprocket, quantity, signal, self.now)? else {
            return Ok(());
        };
        let Some(model) = self.model().with_inputs(std::slice::from_ref(&input)) else {
            return Ok(());
        };
        self.inputs.retain(|other| other.sprocket() != sprocket);
        self.inputs.push(input);
        self.adams.interpolate(self.now, &mut self.inside);
        self.dynamics.unbend_open(self.now, &mut self.inside);
        self.dynamics
            .turn_back(Arc::new(model), self.now, &self.inside);
        self.adams.restart_with_corrector(self.now, &self.inside);
        self.kink = f64::NEG_INFINITY;
        self.limit_step();
        if let Some(recorder) = &mut self.recorder {
            recorder.keep_step_forces(&self.dynamics);
        }
        Ok(())
    }
}

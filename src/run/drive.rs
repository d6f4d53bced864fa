//! Runs of chain drives.

use std::sync::Arc;

use super::simulation::Simulation;
use crate::chain::contact::ToothJump;
use crate::chain::dynamics::{Dynamics, check_start};
use crate::chain::model::{Model, Quantity};
use crate::chain::motion::Motion;
use crate::error::Result;
use crate::integrator::{Adams, Corrector, OdeSystem, StepControl};
use crate::layout::InitialConfiguration;
use crate::math::Signal;

impl Simulation<Dynamics> {
    /// A run of `model` from `start` at time zero.
    ///
    /// # Errors
    /// When a control or the start does not fit.
    pub fn new(
        model: Arc<Model>,
        start: &InitialConfiguration,
        control: StepControl,
    ) -> Result<Self> {
        control.validate()?;
        check_start(&model, start)?;
        let mut dynamics = Dynamics::new(model);
        let dimension = dynamics.dimension();
        let mut y = vec![0.0; dimension];
        let mut motion = Motion::new(dynamics.model().bodies());
        motion.set(&start.positions, &start.velocities);
        motion.write(dynamics.model(), &mut y);
        dynamics.remember_present_contacts(0.0, &y);
        dynamics.check_joints()?;
        if control.corrector != Corrector::Pece {
            // Makes the room for the matrix, which a run that changes correctors would otherwise make under way.
            dynamics.make_room_for_newton();
        }
        let mut adams = Adams::new(dimension, control);
        adams.restart(0.0, &y);
        Ok(Self::of(dynamics, adams))
    }

    /// Divides each step into `fineness` panels for the energy quadrature, one at first, and of those in which contacts begin or end each
    /// half: what changes with it is the quadrature's own error.
    pub fn refine_meter(&mut self, fineness: usize) {
        self.system.refine_quadrature(fineness);
    }

    /// The model, with the speeds and torques that hold now.
    #[must_use]
    pub fn model(&self) -> &Arc<Model> {
        self.system.model()
    }

    /// The state at the present time.
    fn state(&self) -> Vec<f64> {
        let mut y = vec![0.0; self.system.dimension()];
        self.adams.interpolate(self.now, &mut y);
        y
    }

    /// The dynamics, evaluated at the present time.
    pub fn present(&mut self) -> &Dynamics {
        self.system.evaluate(self.now, &self.state());
        &self.system
    }

    /// Positions and velocities of all bodies at the present time.
    #[must_use]
    pub fn motion(&self) -> Motion {
        let mut motion = Motion::new(self.model().bodies());
        motion.read(self.model(), self.now, &self.state());
        motion
    }

    /// Teeth that the chain has jumped up to the present time, in the order of time.
    #[must_use]
    pub fn tooth_jumps(&self) -> &[ToothJump] {
        let jumps = self.system.tooth_jumps();
        // The integrator may be ahead of the present time.
        &jumps[..jumps.partition_point(|jump| jump.time <= self.now)]
    }

    /// Which laws left their range, a line each.
    #[must_use]
    pub fn range_notes(&self) -> Vec<String> {
        let model = self.model().range_notes.iter();
        model.chain(self.system.past_range()).cloned().collect()
    }

    /// Dynamics evaluated at other positions and velocities, or another time, without touching the run.
    ///
    /// Positions that are just given have no contact memory.
    #[must_use]
    pub fn evaluate_elsewhere(
        &self,
        positions: Option<&[[f64; 3]]>,
        velocities: Option<&[[f64; 3]]>,
        time: Option<f64>,
    ) -> Dynamics {
        let mut dynamics = self.system.clone();
        if positions.is_some() {
            dynamics.memory.clear();
            dynamics.bristles.clear();
        } else {
            dynamics.bristles.read(self.model(), &self.state());
        }
        let present = self.motion();
        let (present_positions, present_velocities) = (present.positions(), present.velocities());
        dynamics.motion.set(
            positions.unwrap_or(&present_positions),
            velocities.unwrap_or(&present_velocities),
        );
        dynamics.evaluate_motion(time.unwrap_or(self.now));
        dynamics
    }

    /// Lets sprocket `sprocket` (from 0) have another speed or torque from the present time on.
    ///
    /// What the integrator had made beyond the present time is made anew. Positions do not jump, nor do velocities but that of the
    /// sprocket whose speed is set; contacts keep their memory and the energy balance goes on.
    ///
    /// # Errors
    /// When there is no such sprocket, its motion has no such quantity, or `signal` is beyond what a drive may be described with; the simulation is then what it was.
    pub fn set_input(&mut self, sprocket: usize, quantity: Quantity, signal: Signal) -> Result<()> {
        let input = (sprocket, quantity);
        let changed = self
            .system
            .set_input(input, signal, self.now, &mut self.adams)?;
        if changed {
            self.limit_step();
            if let Some(recorder) = &mut self.recorder {
                recorder.keep_step_forces(&self.system);
            }
        }
        Ok(())
    }
}

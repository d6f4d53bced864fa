//! Runs of chain drives.

use std::sync::Arc;

use super::simulation::Simulation;
use crate::chain::contact::ToothJump;
use crate::chain::dynamics::{Dynamics, check_start};
use crate::chain::model::Model;
use crate::chain::motion::Motion;
use crate::drive::InputQuantity;
use crate::error::Result;
use crate::integrator::{Adams, Corrector, OdeSystem, StepControl};
use crate::layout::InitialConfiguration;
use crate::math::Signal;
use crate::math::simd::InstructionSet;

/// Return the control of a run of `model`: an evaluation of ideal hinges solves a linear system, so that explicit steps, which have two,
/// are never cheaper than implicit ones.
fn control_for(model: &Model, control: StepControl) -> StepControl {
    let corrector = match control.corrector {
        Corrector::Auto if model.hinges.ideal => Corrector::Newton,
        corrector => corrector,
    };
    StepControl {
        corrector,
        ..control
    }
}

impl Simulation<Dynamics> {
    /// Return a run of `model` from `start` at time zero.
    ///
    /// # Errors
    /// If a control or the start is invalid.
    pub fn new(
        model: Arc<Model>,
        start: &InitialConfiguration,
        control: StepControl,
    ) -> Result<Self> {
        control.validate()?;
        check_start(&model, start)?;
        let control = control_for(&model, control);
        let mut dynamics = Dynamics::new(model);
        let dimension = dynamics.dimension();
        let mut y = vec![0.0; dimension];
        let mut motion = Motion::new(dynamics.model().bodies());
        motion.set(&start.positions, &start.velocities);
        motion.write(dynamics.model(), &mut y);
        dynamics.close_ideal_hinges(0.0, &mut y);
        dynamics.begin_present_contacts(0.0, &y, &start.surfaces);
        dynamics.check_joints()?;
        if control.corrector != Corrector::Pece {
            // Allocates the matrix now; a run that switches correctors would otherwise allocate during its steps.
            dynamics.make_room_for_newton();
        }
        let mut adams = Adams::new(dimension, control);
        adams.restart(0.0, &y);
        if dynamics.memory.has_any() || dynamics.model().hinges.film.is_some() {
            // Closed contacts and films are stiff.
            adams.begin_implicit();
        }
        Ok(Self::of(dynamics, adams))
    }

    /// Divide each step into `fineness` panels of the energy quadrature, a power of two. 0, the default: as many as the powers need, one to
    /// four. The change of the result with `fineness` is the error of the quadrature.
    pub fn refine_meter(&mut self, fineness: usize) {
        self.system.refine_quadrature(fineness);
    }

    /// Select an instruction set instead of the widest one of this machine.
    pub fn use_instructions(&mut self, instructions: InstructionSet) {
        self.system.use_instructions(instructions);
        self.adams.use_instructions(instructions);
    }

    /// Return the model with the present speeds and torques.
    #[must_use]
    pub fn model(&self) -> &Arc<Model> {
        self.system.model()
    }

    /// Return the state at the present time.
    fn state(&self) -> Vec<f64> {
        let mut y = vec![0.0; self.system.dimension()];
        self.adams.interpolate(self.now, &mut y);
        y
    }

    /// Return the dynamics, evaluated at the present time.
    pub fn present(&mut self) -> &Dynamics {
        self.system.evaluate(self.now, &self.state());
        &self.system
    }

    /// Return positions and velocities of all bodies at the present time.
    #[must_use]
    pub fn motion(&self) -> Motion {
        let mut motion = Motion::new(self.model().bodies());
        motion.read(self.model(), self.now, &self.state());
        motion
    }

    /// Return the tooth jumps up to the present time, in the order of time.
    #[must_use]
    pub fn tooth_jumps(&self) -> &[ToothJump] {
        let jumps = self.system.tooth_jumps();
        // The integrator may be ahead of the present time.
        &jumps[..jumps.partition_point(|jump| jump.time <= self.now)]
    }

    /// Return the law warnings, one line per law that left its range.
    #[must_use]
    pub fn range_notes(&self) -> Vec<String> {
        let model = self.model().range_notes.iter();
        model.chain(self.system.past_range()).cloned().collect()
    }

    /// Return the dynamics evaluated at other positions, velocities or time; the run is unchanged.
    ///
    /// Given positions have no impact velocity memory.
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
            dynamics.evaluated.bristles.clear();
        } else {
            dynamics
                .evaluated
                .bristles
                .read(self.model(), &self.state());
        }
        let present = self.motion();
        let (present_positions, present_velocities) = (present.positions(), present.velocities());
        dynamics.evaluated.motion.set(
            positions.unwrap_or(&present_positions),
            velocities.unwrap_or(&present_velocities),
        );
        dynamics.evaluate_motion(time.unwrap_or(self.now));
        dynamics
    }

    /// Set another speed or torque of sprocket `sprocket` (from 0) from the present time on.
    ///
    /// The integrator discards its steps beyond the present time and continues from there. Positions are continuous, and so are velocities
    /// except that of the sprocket whose speed is set. Contacts keep their impact velocity memory and the energy balance continues.
    ///
    /// # Errors
    /// If there is no such sprocket, its motion has no such quantity, or `signal` is outside the range of a drive's description; the
    /// simulation is then unchanged.
    pub fn set_input(
        &mut self,
        sprocket: usize,
        quantity: InputQuantity,
        signal: Signal,
    ) -> Result<()> {
        let input = (sprocket, quantity);
        let changed = self
            .system
            .set_input(input, signal, self.now, &mut self.adams)?;
        if changed {
            self.resume();
        }
        Ok(())
    }
}

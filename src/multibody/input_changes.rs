//! Change of an input of a mechanism during a run.

use std::sync::Arc;

use super::assembly::projection::AtHand;
use super::contact::onset::StepMotion;
use super::dynamics::MechanismDynamics;
use super::inputs::MechanismInput;
use super::newton::stage::StepReactions;
use super::step_start::ITERATIONS;
use crate::drive::InputQuantity;
use crate::error::{Error, Result};
use crate::integrator::Adams;
use crate::math::Signal;

impl MechanismDynamics {
    /// Change the speed of the driver or the torque `name` from time `t` \[s\] on, inside the last step of `adams`.
    ///
    /// Return false if it already has this input. The solution beyond `t` is computed again. Positions and the impact velocity memory are
    /// continuous. A jump of a speed acts as an impulse of the drivers: velocities change by the least amount, weighted by mass, that
    /// satisfies the constraints. With workless joints, the change of kinetic energy is the work of the drivers, and external work
    /// includes it.
    ///
    /// # Errors
    /// When there is no such driver or torque, a number of `signal` is not finite, or no velocities satisfy the constraints; the dynamics
    /// are then unchanged.
    pub(crate) fn set_input(
        &mut self,
        name: &str,
        quantity: InputQuantity,
        signal: Signal,
        t: f64,
        adams: &mut Adams,
    ) -> Result<bool> {
        match self.model.input(name, quantity, signal, t)? {
            Some(input) => self.apply(name, input, t, adams),
            None => Ok(false),
        }
    }

    /// Change what `input` replaces, of the part `name`, from time `t` \[s\] on.
    fn apply(
        &mut self,
        name: &str,
        input: MechanismInput,
        t: f64,
        adams: &mut Adams,
    ) -> Result<bool> {
        self.evaluate_inside(adams, t);
        let mut state = self.work.inside.clone();
        let mut replaced = input.clone();
        // A clone where the model is shared, as the compiled one is; otherwise the model itself.
        let fits = Arc::make_mut(&mut self.model).exchange(&mut replaced);
        debug_assert!(fits.is_some(), "the input is of this model");
        let bent = self.contacts.bristles.deflection.clone();
        let jumps = matches!(input, MechanismInput::Speed { .. });
        if jumps && !(self.projector()).project(t, &mut state, ITERATIONS, AtHand::Nothing) {
            let residuals = self
                .constraints
                .largest_residuals(&self.model, &self.frames);
            Arc::make_mut(&mut self.model).exchange(&mut replaced);
            return Err(Error::invalid(
                "driver",
                format!("{name:?}"),
                format!("expected a speed that the other joints and drivers permit: {residuals}"),
            ));
        }
        self.sums.external_work +=
            self.model.kinetic_energy(&state) - self.model.kinetic_energy(&self.work.inside);
        self.contacts.bristles.deflection = bent;
        let motion = StepMotion {
            model: &self.model,
            frames: &self.frames,
            shift: &self.shift,
            adams,
            memory_at_start: &self.step.memory,
        };
        self.contacts.roll_back(&motion, t, &mut self.onsets);
        self.shift.clear(t);
        let y = self.solution_of(&state);
        adams.restart_with_corrector(t, &y);
        self.keep_step_start(adams);
        self.differentiate(t, &y);
        // The kept reactions are those of the old input: the next step solves for its own, as the first one of a run does.
        self.corrector.reactions = StepReactions::default();
        self.inputs.set.retain(|set| set.target() != input.target());
        self.inputs.set.push(input);
        Ok(true)
    }

    /// Replace all inputs, as of a checkpoint; `None` for inputs of another model.
    pub(super) fn replace_inputs(&mut self, inputs: &[MechanismInput]) -> Option<()> {
        self.model = Arc::clone(&self.inputs.compiled);
        for input in inputs {
            Arc::make_mut(&mut self.model).exchange(&mut input.clone())?;
        }
        self.inputs.set = inputs.to_vec();
        Some(())
    }
}

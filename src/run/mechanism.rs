//! Runs of mechanisms.

use std::sync::Arc;

use super::recorder::row_of;
use super::simulation::Simulation;
use crate::drive::InputQuantity;
use crate::error::{Result, check};
use crate::integrator::{Adams, OdeSystem, StepControl};
use crate::layout::InitialConfiguration;
use crate::math::Signal;
use crate::multibody::{Assembly, MechanismDynamics, MechanismGroups, MechanismModel};
use crate::system::Recording;

/// Simulation of a mechanism.
pub type MechanismSimulation = Simulation<MechanismDynamics>;

impl Simulation<MechanismDynamics> {
    /// Return a run from the assembled placement of the mechanism.
    ///
    /// # Errors
    /// If a control is invalid or the mechanism cannot be assembled.
    pub fn assemble(model: Arc<MechanismModel>, control: StepControl) -> Result<Self> {
        Self::assemble_unless(model, control, &|| false)
    }

    /// Return a run from the assembled placement; `give_up` is called repeatedly during assembly and ends it with an error.
    ///
    /// # Errors
    /// If a control is invalid or the mechanism cannot be assembled.
    pub fn assemble_unless(
        model: Arc<MechanismModel>,
        control: StepControl,
        give_up: &dyn Fn() -> bool,
    ) -> Result<Self> {
        Self::assemble_on(model, &[], control, give_up)
    }

    /// Return a run as of [`Self::assemble_unless`] that begins at `start`, such as that of an [`Equilibrium`](crate::Equilibrium). Lengths
    /// and angles that are not described remain those of the described positions.
    ///
    /// # Errors
    /// As of [`Self::assemble_unless`], or if there is not one row for each body, or a surface does not exist.
    pub fn assemble_from(
        model: MechanismModel,
        start: &InitialConfiguration,
        control: StepControl,
        give_up: &dyn Fn() -> bool,
    ) -> Result<Self> {
        let model = model.placed(&start.positions, &start.velocities)?;
        let model = Arc::new(model);
        Self::assemble_on(model, &start.surfaces, control, give_up)
    }

    /// Return a run as of [`Self::assemble_unless`]; `surfaces`: contact, side and piece of its profile, from 0, of contacts that do not
    /// begin on the nearest piece.
    pub(crate) fn assemble_on(
        model: Arc<MechanismModel>,
        surfaces: &[[usize; 3]],
        control: StepControl,
        give_up: &dyn Fn() -> bool,
    ) -> Result<Self> {
        control.validate()?;
        let mut dynamics = MechanismDynamics::new(model);
        let y = dynamics.assemble_for_run(give_up)?;
        let mut adams = Adams::new(dynamics.dimension(), control);
        adams.restart(0.0, &y);
        dynamics.evaluate_inside(&adams, 0.0);
        dynamics.remember_present_contacts();
        dynamics.store_surfaces(surfaces)?;
        if dynamics.contacts.any_is_closed() || dynamics.model().has_film() {
            // Closed contacts and films are stiff.
            adams.begin_implicit();
        }
        Ok(Self::of(dynamics, adams))
    }

    /// Return the result of the assembly.
    #[must_use]
    pub fn assembly(&self) -> &Assembly {
        self.system.assembly()
    }

    /// Return the model.
    #[must_use]
    pub fn model(&self) -> &Arc<MechanismModel> {
        self.system.model()
    }

    /// Return the law warnings: laws and bristles outside their range, and the first contact past the end of each law.
    #[must_use]
    pub fn range_notes(&self) -> Vec<String> {
        let model = self.model().range_notes.iter();
        let past_ends = self.system.contacts.past_ends.iter().flatten();
        model.chain(past_ends).cloned().collect()
    }

    /// Return the dynamics, evaluated at the present time.
    pub fn present(&mut self) -> &MechanismDynamics {
        self.system.evaluate_inside(&self.adams, self.now);
        &self.system
    }

    /// Return a recording of the present time alone.
    pub fn row(&mut self) -> Recording {
        self.system.evaluate_inside(&self.adams, self.now);
        row_of(&mut self.system, self.now, MechanismGroups::ALL)
    }

    /// Return the positions of all bodies at the present time, without the ground.
    pub fn positions(&mut self) -> Vec<[f64; 3]> {
        self.present().positions()
    }

    /// Return the velocities of all bodies at the present time, without the ground.
    pub fn velocities(&mut self) -> Vec<[f64; 3]> {
        self.present().velocities()
    }

    /// Return the largest residuals of positions and of velocities at the end of the last step.
    pub fn drift(&mut self) -> [f64; 2] {
        self.system.drift(&self.adams)
    }

    /// Set another speed of the driver `part`, or another torque of the force element `part`, from the present time on.
    ///
    /// The integrator discards its steps beyond the present time and continues from there. Positions are continuous. A jump of a speed acts
    /// as an impulse, whose work is external work. Contacts keep their impact velocity memory and the energy balance continues.
    ///
    /// # Errors
    /// If there is no such part, a number of `signal` is not finite, or the other joints and drivers do not permit the speed; the
    /// simulation is then unchanged.
    pub fn set_input(&mut self, part: &str, quantity: InputQuantity, signal: Signal) -> Result<()> {
        let (now, adams) = (self.now, &mut self.adams);
        if self.system.set_input(part, quantity, signal, now, adams)? {
            self.resume();
        }
        Ok(())
    }

    /// Return a recording of one row at another state; the run is unchanged. Given values replace the present ones.
    ///
    /// Rows have three numbers per body, without the ground; held bodies keep their positions. The state is used as given, on the
    /// constraints or not. With given positions, no contact has an impact velocity memory.
    ///
    /// # Errors
    /// If the number of rows differs from that of the bodies, or a number is not finite.
    pub fn evaluate_elsewhere(
        &mut self,
        positions: Option<&[[f64; 3]]>,
        velocities: Option<&[[f64; 3]]>,
        time: Option<f64>,
    ) -> Result<Recording> {
        let names = self.model().body_names();
        for (field, rows) in [("positions", positions), ("velocities", velocities)] {
            rows.map_or(Ok(()), |rows| check::finite_rows(field, rows, &names))?;
        }
        self.system.evaluate_inside(&self.adams, self.now);
        let mut dynamics = self.system.clone();
        let time = time.unwrap_or(self.now);
        dynamics.evaluate_with((&self.adams, self.now), positions, velocities, time);
        Ok(row_of(&mut dynamics, time, MechanismGroups::ALL))
    }
}

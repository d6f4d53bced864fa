//! Runs of mechanisms.

use std::sync::Arc;

use super::recorder::row_of;
use super::simulation::Simulation;
use crate::error::{Error, Result};
use crate::integrator::{Adams, OdeSystem, StepControl};
use crate::multibody::{
    Assembly, Body, MechanismDynamics, MechanismGroups, MechanismModel, Stabilisation,
};
use crate::system::Recording;

/// A mechanism in motion.
pub type MechanismSimulation = Simulation<MechanismDynamics>;

impl Simulation<MechanismDynamics> {
    /// A run from where the mechanism is placed, assembled.
    ///
    /// # Errors
    /// When a control does not fit or the mechanism does not go together.
    pub fn assemble(
        model: Arc<MechanismModel>,
        control: StepControl,
        stabilisation: Stabilisation,
    ) -> Result<Self> {
        Self::assemble_unless(model, control, stabilisation, &|| false)
    }

    /// The same; `give_up` is asked now and then while the mechanism is assembled, and ends that with an error.
    ///
    /// # Errors
    /// When a control does not fit or the mechanism does not go together.
    pub fn assemble_unless(
        model: Arc<MechanismModel>,
        control: StepControl,
        stabilisation: Stabilisation,
        give_up: &dyn Fn() -> bool,
    ) -> Result<Self> {
        control.validate()?;
        let mut dynamics = MechanismDynamics::new(model, stabilisation);
        let y = dynamics.assemble_for_run(give_up)?;
        let mut adams = Adams::new(dynamics.dimension(), control);
        adams.restart(0.0, &y);
        dynamics.evaluate_inside(&adams, 0.0);
        dynamics.remember_present_contacts();
        Ok(Self::of(dynamics, adams))
    }

    /// What assembling found.
    #[must_use]
    pub fn assembly(&self) -> &Assembly {
        self.system.assembly()
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &Arc<MechanismModel> {
        self.system.model()
    }

    /// Contact onsets so far.
    #[must_use]
    pub fn onsets(&self) -> u64 {
        self.statistics().onsets
    }

    /// The dynamics at the present time, evaluated.
    pub fn present(&mut self) -> &MechanismDynamics {
        self.system.evaluate_inside(&self.adams, self.now);
        &self.system
    }

    /// A recording of the present time alone.
    pub fn row(&mut self) -> Recording {
        self.system.evaluate_inside(&self.adams, self.now);
        row_of(&mut self.system, self.now, MechanismGroups::ALL)
    }

    /// Positions (false) or velocities (true) of all bodies at the present time, ground left out.
    pub fn motion(&mut self, velocities: bool) -> Vec<[f64; 3]> {
        self.present().motion(velocities)
    }

    /// Largest residual of positions and of velocities where the last step ended.
    pub fn drift(&mut self) -> [f64; 2] {
        self.system.drift(&self.adams)
    }

    /// A recording of one row at another state; the run stays as it is. What is given replaces the present value.
    ///
    /// Three numbers a body, the ground left out; bodies that are held stay where they are. The state is taken as it is, on
    /// the constraints or not. With positions given, no contact has a memory.
    ///
    /// # Errors
    /// When there are not as many rows as bodies, or a number is not finite.
    pub fn evaluate_elsewhere(
        &mut self,
        positions: Option<&[[f64; 3]]>,
        velocities: Option<&[[f64; 3]]>,
        time: Option<f64>,
    ) -> Result<Recording> {
        for (field, rows) in [("positions", positions), ("velocities", velocities)] {
            check_rows(&self.model().bodies()[1..], field, rows)?;
        }
        self.system.evaluate_inside(&self.adams, self.now);
        let mut dynamics = self.system.clone();
        let time = time.unwrap_or(self.now);
        dynamics.evaluate_with(positions, velocities, time);
        Ok(row_of(&mut dynamics, time, MechanismGroups::ALL))
    }
}

/// One row of finite numbers for each body.
fn check_rows(bodies: &[Body], field: &str, rows: Option<&[[f64; 3]]>) -> Result<()> {
    let Some(rows) = rows else { return Ok(()) };
    if rows.len() != bodies.len() {
        return Err(Error::invalid(
            field,
            format!("{} rows", rows.len()),
            format!(
                "needs one row (3 numbers) for each of the {} bodies",
                bodies.len()
            ),
        ));
    }
    for (body, row) in bodies.iter().zip(rows) {
        if let Some(bad) = row.iter().find(|value| !value.is_finite()) {
            let field = format!("{field} of {}", body.name);
            return Err(Error::invalid(field, bad, "must be finite numbers"));
        }
    }
    Ok(())
}

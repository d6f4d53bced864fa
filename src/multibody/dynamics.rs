//! Equations of motion of a mechanism as a first-order system: coordinates, velocities, two energy sums.

use std::sync::Arc;

use super::assembly::outcome::Assembly;
use super::assembly::projection::Projector;
use super::constraints::constraint_state::ConstraintState;
use super::contact::contact_states::ContactStates;
use super::contact::onset::Onsets;
use super::description::body::Frame;
use super::forces::loads::BodyLoads;
use super::frames::Shift;
use super::inputs::MechanismInputs;
use super::model::MechanismModel;
use super::newton::stage::ImplicitCorrector;
use super::step_start::StepStart;
use super::sums::MechanismSums;
use crate::error::Result;
use crate::integrator::OdeSystem;
use crate::system::PowerSum;

/// Right-hand side of the equations of motion. Its contact memory changes between steps only.
///
/// The solution is y = [q, Z, v, z, energy dissipated, external work] with the deflections z of bristles and their unused integrals Z. It
/// differs from the state by a `Shift`, so the integrator's solution and history are not modified by projections.
#[derive(Debug, Clone)]
pub struct MechanismDynamics {
    pub(crate) model: Arc<MechanismModel>,
    pub(crate) frames: Vec<Frame>,
    pub(crate) loads: BodyLoads,
    pub(crate) contacts: ContactStates,
    pub(crate) constraints: ConstraintState,
    pub(crate) accelerations: Vec<f64>,
    pub(crate) shift: Shift,
    pub(crate) corrector: ImplicitCorrector,
    /// Start of the last step of a run.
    pub(super) step: StepStart,
    pub(super) onsets: Onsets,
    /// Energy dissipated and external work at the last state read.
    pub(crate) sums: MechanismSums,
    assembly: Arc<Assembly>,
    /// Compiled model and the inputs set during the run.
    pub(super) inputs: MechanismInputs,
    pub(super) work: WorkArrays,
}

/// Work arrays of a run.
#[derive(Debug, Clone)]
pub(super) struct WorkArrays {
    /// State of an evaluation, with its shift.
    shifted: Vec<f64>,
    /// State within a step, and the integrator's solution there.
    pub(super) inside: Vec<f64>,
    pub(super) solution: Vec<f64>,
    /// Derivative of the integrator's solution.
    pub(super) derivative: Vec<f64>,
}

impl MechanismDynamics {
    /// Return the equations of a model, without contact memory.
    #[must_use]
    pub fn new(model: Arc<MechanismModel>) -> Self {
        let n = model.coordinates();
        Self {
            frames: model.start_frames(),
            loads: BodyLoads::new(model.bodies.len(), n),
            contacts: ContactStates::new(&model),
            constraints: ConstraintState::new(&model),
            accelerations: vec![0.0; n],
            shift: Shift::new(n),
            corrector: ImplicitCorrector::default(),
            step: StepStart::new(2 * n, model.sides.len()),
            onsets: Onsets::default(),
            sums: MechanismSums::default(),
            assembly: Arc::default(),
            inputs: MechanismInputs::new(&model),
            work: WorkArrays {
                shifted: vec![0.0; 2 * n],
                inside: vec![0.0; 2 * n],
                solution: vec![0.0; model.dimension()],
                derivative: vec![0.0; model.dimension()],
            },
            model,
        }
    }

    /// Return the model.
    #[must_use]
    pub fn model(&self) -> &Arc<MechanismModel> {
        &self.model
    }

    /// Assemble the mechanism for a run and return the integrator's state.
    ///
    /// # Errors
    /// When no positions or velocities satisfy the constraints.
    pub(crate) fn assemble_for_run(&mut self, give_up: &dyn Fn() -> bool) -> Result<Vec<f64>> {
        let assembly = self.assemble_unless(give_up)?;
        let state = self.solution_of(&assembly.state);
        self.assembly = Arc::new(assembly);
        Ok(state)
    }

    /// Return the result of the assembly.
    #[must_use]
    pub fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    /// Return whether the mechanism has constraints.
    #[must_use]
    pub fn is_constrained(&self) -> bool {
        self.constraints.kkt.is_some()
    }

    /// Return the parts that a projection onto the constraints uses.
    pub(crate) fn projector(&mut self) -> Projector<'_> {
        Projector {
            model: &self.model,
            frames: &mut self.frames,
            constraints: &mut self.constraints,
            corrector: &mut self.corrector,
            give_up: &|| false,
        }
    }

    /// Set the body frames to a state without a shift and evaluate the constraint equations there.
    pub(crate) fn place(&mut self, t: f64, state: &[f64]) {
        self.projector().place(t, state);
    }

    /// Sum all loads at the body frames.
    fn find_loads(&mut self, t: f64) {
        let (model, loads) = (&*self.model, &mut self.loads);
        loads.clear();
        for (load, body) in loads.on.iter_mut().zip(&model.bodies) {
            load[0] = body.mass * model.gravity.x;
            load[1] = body.mass * model.gravity.y;
        }
        for force in &model.forces {
            force.add(t, &self.frames, loads);
        }
        self.contacts.add_loads(model, &self.frames, loads);
        loads.gather_free(&model.first);
    }

    /// Compute accelerations and multipliers at the body frames.
    pub(crate) fn accelerate(&mut self, t: f64) {
        self.find_loads(t);
        let (model, constraints) = (&*self.model, &mut self.constraints);
        if constraints.kkt.is_none() {
            let free = self.accelerations.iter_mut().zip(&self.loads.free);
            free.zip(&model.mass).for_each(|((a, f), m)| *a = f / m);
            return;
        }
        constraints.find_rows(model, t, &self.frames);
        if self.corrector.stage.active {
            self.corrector
                .accelerate(model, constraints, &self.loads.free);
            return;
        }
        // A redundant constraint depends on the others only where all joints are satisfied, which a state within a step is not
        // exactly. Nearly dependent constraints are therefore left out, as long as the rank is that away from singular positions.
        if !self.constraints.hold() {
            if !self.constraints.aside && self.accelerate_across(t) {
                self.add_pin_losses();
                return;
            }
            self.constraints.factorise_whole();
        }
        let (frames, free) = (&self.frames, &self.loads.free);
        let accelerations = &mut self.accelerations;
        if !(self.constraints).solve(&self.model, frames, free, accelerations) {
            accelerations.fill(f64::NAN);
        }
        self.add_pin_losses();
    }

    /// Add the power dissipated by the friction of pins, at the multipliers of the last evaluation.
    fn add_pin_losses(&mut self) {
        self.loads.dissipated += self.constraints.pin_losses(&self.model, &self.frames);
    }

    /// Return the power dissipated, including that stored in bristles, and the power of applied forces and drivers at the last
    /// evaluation \[W\].
    pub(crate) fn powers(&self) -> [f64; 2] {
        [
            self.loads.dissipated,
            self.loads.external_work + self.constraints.driver_power(),
        ]
    }

    /// Set the memory of all contacts present at the last evaluation, with the present penetration rate as initial impact velocity.
    pub(crate) fn remember_present_contacts(&mut self) {
        self.contacts.remember_present(&self.model, &self.frames);
    }

    /// Evaluate everything at positions and velocities, without a shift.
    pub(crate) fn evaluate(&mut self, t: f64, state: &[f64]) {
        self.model.place(&mut self.frames, state);
        self.accelerate(t);
    }

    /// Return the integrator's state for [q, v] with the present deflections and energy sums.
    pub(crate) fn solution_of(&self, state: &[f64]) -> Vec<f64> {
        let (q, v) = state.split_at(self.model.coordinates());
        let unused = vec![0.0; self.model.bristles];
        [
            q,
            &unused,
            v,
            &self.contacts.bristles.deflection,
            &self.sums.totals(),
        ]
        .concat()
    }
}

impl OdeSystem for MechanismDynamics {
    /// Return whether event screening finds no contact skipped within the step. The error allowed is not used: the energy that a
    /// contact stores or dissipates is not of the order of its penetration.
    fn accepts_step(&mut self, length: f64, _allowed: f64) -> bool {
        let accelerations = &self.accelerations;
        !(self.contacts).passes_contact(&self.model, &self.frames, accelerations, length)
    }

    fn dimension(&self) -> usize {
        self.model.dimension()
    }

    /// Return the number of components under error control. It includes the energy sums where damping can reduce a contact force to
    /// zero before the surfaces separate: the stored energy is then lost without a force, which only the sums show.
    fn controlled(&self) -> usize {
        let sums = if self.model.watches_energy { 2 } else { 0 };
        2 * self.model.unknowns() + sums
    }

    fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        let (n, unknowns) = (self.model.coordinates(), self.model.unknowns());
        let mut shifted = std::mem::take(&mut self.work.shifted);
        self.contacts.bristles.read(&self.model, y, &mut shifted);
        self.shift.add(t, &mut shifted);
        self.corrector.time = t;
        self.evaluate(t, &shifted);
        // dq/dt = v of the integrator's own solution, without the shift: see `Shift`.
        dydt[..unknowns].copy_from_slice(&y[unknowns..2 * unknowns]);
        let accelerations = if self.corrector.stage.active {
            &self.corrector.stage.trial
        } else {
            &self.accelerations
        };
        dydt[unknowns..unknowns + n].copy_from_slice(accelerations);
        dydt[unknowns + n..2 * unknowns].copy_from_slice(&self.contacts.bristles.rate);
        let powers = self.powers();
        dydt[2 * unknowns..].copy_from_slice(&powers);
        self.work.shifted = shifted;
    }
}

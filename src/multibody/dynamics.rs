//! Equations of motion of a mechanism as a first-order system: coordinates, velocities, two energy sums.

use std::sync::Arc;

use super::assembly::placement::Assembly;
use super::constraints::equation::Row;
use super::constraints::pin_friction::PinTorques;
use super::constraints::sparse_kkt::SparseKkt;
use super::contact::bristles::Bristles;
use super::contact::event_screening::ContactEnd;
use super::contact::impact_memory::{Memory, Touch};
use super::contact::onset::Onset;
use super::description::body::Frame;
use super::forces::loads::Loads;
use super::inputs::Inputs;
use super::model::MechanismModel;
use super::newton::matrix::ImplicitMatrix;
use super::newton::stage::{Stage, StepReactions};
use super::step::StepStart;
use super::system::MechanismSums;
use crate::error::Result;
use crate::integrator::OdeSystem;

/// Stabilisation of the constraints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stabilisation {
    /// Positions and velocities are projected onto the constraints after every step, to round-off.
    Projection,
    /// Residuals decay as a critically damped oscillator of this angular frequency \[rad/s\] (Baumgarte 1972), for comparison. At 0
    /// the drift of the integration formulas is visible.
    Baumgarte(f64),
}

/// Right-hand side of the equations of motion. Its contact memory changes between steps only.
///
/// The solution is y = [q, v, energy dissipated, external work], with the deflections of bristles after q and their rates after v. It
/// differs from the state by a `shift`, the sum of the corrections of all projections, so the integrator's solution and history are
/// not modified.
///
/// During a step the shift of velocities is constant and that of coordinates grows at its rate. Thus dq/dt = v holds in the
/// integrator's solution as in the state, and an implicit corrector can compute coordinates from velocities.
#[derive(Debug, Clone)]
pub struct MechanismDynamics {
    pub(crate) model: Arc<MechanismModel>,
    pub(crate) frames: Vec<Frame>,
    pub(crate) loads: Loads,
    pub(crate) rows: Vec<Row>,
    /// Factors of the constraints; `None` without constraints.
    pub(crate) kkt: Option<SparseKkt>,
    pub(crate) accelerations: Vec<f64>,
    pub(crate) multipliers: Vec<f64>,
    /// State of each side of each contact, and its memory since the onset.
    pub(crate) touches: Vec<Touch>,
    pub(crate) memory: Vec<Memory>,
    /// Whether each contact is close enough to be evaluated; sides of others are not evaluated.
    pub(crate) near: Vec<bool>,
    /// Largest penetration of each contact that is near \[m\], and its rate \[m/s\]; an upper bound and zero for the others.
    pub(crate) deepest: Vec<[f64; 2]>,
    /// State of each contact at the start of the present step.
    pub(crate) starts: Vec<ContactEnd>,
    pub(crate) bristles: Bristles,
    pub(crate) pin_torques: PinTorques,
    pub(crate) shift: Vec<f64>,
    /// Time at which the shift of coordinates has the stored value \[s\].
    pub(crate) shift_time: f64,
    pub(crate) stabilisation: Stabilisation,
    /// Independence of the constraints below which a position counts as near-singular.
    pub(crate) near_singular: f64,
    /// Number of independent constraints away from singular positions.
    pub(crate) rank: usize,
    /// Whether the evaluation is at an interpolation point or a trial position, where no interpolation takes place.
    pub(crate) aside: bool,
    /// Time of the last derivative \[s\].
    pub(crate) time: f64,
    /// Matrix of the implicit corrector, once it is used.
    pub(crate) corrector: Option<Box<ImplicitMatrix>>,
    /// Stage of the implicit corrector, and the reactions that it begins from.
    pub(crate) stage: Stage,
    pub(crate) reactions: StepReactions,
    /// Work arrays of projections: residuals, changes.
    pub(crate) projecting: [Vec<f64>; 2],
    /// Work array: loads on the free coordinates.
    pub(crate) forces: Vec<f64>,
    /// Work array: the state with its shift.
    shifted: Vec<f64>,
    /// Start of the last step of a run.
    pub(super) step: StepStart,
    /// Number of contact onsets.
    pub(super) onsets: u64,
    /// Onsets without a recorded row, while a recording needs them.
    pub(super) unreported_onsets: Option<Vec<Onset>>,
    /// Energy dissipated and external work at the last state read.
    pub(crate) sums: MechanismSums,
    assembly: Arc<Assembly>,
    /// Compiled model and the inputs set during the run.
    pub(super) inputs: Inputs,
    /// Work arrays: a state within a step, the integrator's solution there, and a derivative.
    pub(super) inside: Vec<f64>,
    pub(super) solution: Vec<f64>,
    pub(super) slope: Vec<f64>,
}

/// With redundant constraints: independence below which a constraint is always left out, over the near-singular threshold.
const FAINT: f64 = 0.1;

impl MechanismDynamics {
    /// Return the equations of a model, without contact memory.
    #[must_use]
    pub fn new(model: Arc<MechanismModel>, stabilisation: Stabilisation) -> Self {
        let (n, m, bodies) = (model.coordinates(), model.constraints(), model.bodies.len());
        Self {
            frames: model.start_frames(),
            loads: Loads::new(bodies),
            rows: vec![Row::default(); m],
            kkt: (m > 0).then(|| SparseKkt::of(&model)),
            accelerations: vec![0.0; n],
            multipliers: vec![0.0; m],
            touches: vec![Touch::default(); model.sides.len()],
            memory: vec![Memory::default(); model.sides.len()],
            near: vec![true; model.contacts.len()],
            deepest: vec![[f64::NEG_INFINITY, 0.0]; model.contacts.len()],
            starts: vec![ContactEnd::FAR; model.contacts.len()],
            bristles: Bristles::new(model.bristles),
            pin_torques: PinTorques::new(model.pins.len(), n),
            shift: vec![0.0; 2 * n],
            shift_time: 0.0,
            stabilisation,
            near_singular: 0.0,
            rank: 0,
            aside: false,
            time: 0.0,
            corrector: None,
            stage: Stage::default(),
            reactions: StepReactions::default(),
            projecting: [vec![0.0; m], vec![0.0; n]],
            forces: vec![0.0; n],
            shifted: vec![0.0; 2 * n],
            step: StepStart::new(2 * n, model.sides.len()),
            onsets: 0,
            unreported_onsets: None,
            sums: MechanismSums::default(),
            assembly: Arc::default(),
            inside: vec![0.0; 2 * n],
            solution: vec![0.0; model.dimension()],
            slope: vec![0.0; model.dimension()],
            inputs: Inputs::new(&model),
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
        self.kkt.is_some()
    }

    /// Sum all loads at the body frames.
    fn find_loads(&mut self, t: f64) {
        self.loads.clear();
        self.bristles.begin();
        let model = &self.model;
        for (load, body) in self.loads.on.iter_mut().zip(&model.bodies) {
            load[0] = body.mass * model.gravity.x;
            load[1] = body.mass * model.gravity.y;
        }
        for force in &model.forces {
            force.add(t, &self.frames, &mut self.loads);
        }
        let contacts = model.contacts.iter().zip(&model.sides_of_contact);
        let states = self.near.iter_mut().zip(&mut self.deepest);
        for ((contact, sides), (near, deepest)) in contacts.zip(states) {
            let touches = &mut self.touches[sides.clone()];
            let apart = contact.apart_squared(&self.frames);
            let was_near = std::mem::replace(near, apart <= contact.reach * contact.reach);
            if *near {
                let memory = &self.memory[sides.clone()];
                *deepest = contact.add(&self.frames, memory, &mut self.loads, touches);
                if let Some(law) = &contact.friction {
                    let numbers = &model.bristle_of_side[sides.clone()];
                    let to = (&mut self.loads, &mut *touches);
                    contact.add_friction(law, &self.frames, numbers, &mut self.bristles, to);
                }
                if let Some(film) = &contact.film {
                    contact.add_film(film, &self.frames, &mut self.loads, &mut touches[0]);
                }
            } else {
                *deepest = [contact.outer_depth(apart), 0.0];
                if was_near {
                    touches.fill(Touch::default());
                }
            }
        }
    }

    /// Compute accelerations and multipliers at the body frames.
    pub(crate) fn accelerate(&mut self, t: f64) {
        self.find_loads(t);
        for (load, first) in self.loads.on.iter().zip(&self.model.first) {
            if let Some(i) = *first {
                self.forces[i..i + 3].copy_from_slice(load);
            }
        }
        if self.kkt.is_none() {
            let free = self.accelerations.iter_mut().zip(&self.forces);
            free.zip(&self.model.mass)
                .for_each(|((a, f), m)| *a = f / m);
            return;
        }
        self.find_rows(t);
        // G a = γ - 2 w c' - w² c.
        if let Stabilisation::Baumgarte(frequency) = self.stabilisation {
            for row in &mut self.rows {
                let rate = row.rate(&self.frames);
                row.gamma -= 2.0 * frequency * rate + frequency * frequency * row.value;
            }
        }
        if self.stage.active {
            self.accelerate_with_reactions();
            return;
        }
        if self.kkt.is_some() {
            // A redundant constraint depends on the others only where all joints are satisfied, which a state within a step is not
            // exactly. Nearly dependent constraints are therefore left out, as long as the rank is that away from singular positions.
            if !self.hold() {
                if !self.aside && self.accelerate_across(t) {
                    self.loads.dissipated += self.pin_losses();
                    return;
                }
                self.factorise_whole();
            }
        }
        if !self.solve_constrained() {
            self.accelerations.fill(f64::NAN);
        }
        self.loads.dissipated += self.pin_losses();
    }

    /// Return the independence below which a constraint is always left out: zero without redundant constraints, a part of the
    /// near-singular threshold with them. Residuals of joints make redundant constraints appear independent to about that extent.
    pub(crate) fn faint(&self) -> f64 {
        if self.rank < self.rows.len() {
            FAINT * self.near_singular
        } else {
            0.0
        }
    }

    /// Factorise without nearly dependent constraints. Return whether the rank is that away from singular positions.
    fn hold(&mut self) -> bool {
        let (part, faint) = (self.near_singular, self.faint());
        let Some(kkt) = &mut self.kkt else {
            return true;
        };
        kkt.factorise(&self.rows, part);
        if kkt.rank() < self.rank && faint > 0.0 {
            // Many joints together may have little independence without being singular.
            kkt.factorise(&self.rows, faint);
        }
        kkt.rank() >= self.rank
    }

    /// Factorise all constraints except those always left out.
    pub(crate) fn factorise_whole(&mut self) {
        let part = self.faint();
        if let Some(kkt) = &mut self.kkt {
            kkt.factorise(&self.rows, part);
        }
    }

    /// Return the memory of a side without penetration: that the circle is behind an open outline, or none.
    pub(crate) fn apart(&self, k: usize) -> Memory {
        let (contact, side) = self.model.sides[k];
        let contact = &self.model.contacts[contact];
        let frames = [contact.a.body, contact.b.body].map(|body| &self.frames[body]);
        contact.apart(frames[0], frames[1], side, self.memory[k])
    }

    /// Return the power dissipated, including that stored in bristles, and the power of applied forces and drivers at the last
    /// evaluation \[W\].
    pub(crate) fn powers(&self) -> [f64; 2] {
        [
            self.loads.dissipated,
            self.loads.worked_in + self.driver_power(),
        ]
    }

    /// Return the power of the drivers \[W\]: Σ λ ∂c/∂t.
    fn driver_power(&self) -> f64 {
        let rows = self.rows.iter().zip(&self.multipliers);
        rows.map(|(row, lambda)| lambda * row.time_rate).sum()
    }

    /// Evaluate everything at positions and velocities, without a shift.
    pub(crate) fn evaluate(&mut self, t: f64, state: &[f64]) {
        self.place(state);
        self.accelerate(t);
    }
}

impl OdeSystem for MechanismDynamics {
    /// Return whether event screening finds no contact skipped within the step. The error allowed is not used: the energy that a
    /// contact stores or dissipates is not of the order of its penetration.
    fn accepts_step(&mut self, length: f64, _allowed: f64) -> bool {
        !self.passes_contact(length)
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
        let mut shifted = std::mem::take(&mut self.shifted);
        self.read(y, &mut shifted);
        self.add_shift(t, &mut shifted);
        self.time = t;
        self.evaluate(t, &shifted);
        // dq/dt = v of the integrator's own solution, without the shift: see the type's description.
        dydt[..unknowns].copy_from_slice(&y[unknowns..2 * unknowns]);
        let accelerations = if self.stage.active {
            &self.stage.trial
        } else {
            &self.accelerations
        };
        dydt[unknowns..unknowns + n].copy_from_slice(accelerations);
        dydt[unknowns + n..2 * unknowns].copy_from_slice(&self.bristles.rate);
        let powers = self.powers();
        dydt[2 * unknowns..].copy_from_slice(&powers);
        self.shifted = shifted;
    }
}

//! The equations of motion of a mechanism as a system of first order: coordinates, velocities, two sums of energy.

use std::sync::Arc;

use super::assembly::placement::Assembly;
use super::constraints::equation::Row;
use super::constraints::pin_friction::PinTorques;
use super::constraints::sparse_kkt::SparseKkt;
use super::contact::bristles::Bristles;
use super::contact::contact_state::CompiledContact;
use super::contact::event_screening::ContactEnd;
use super::contact::impact_memory::{Memory, Touch};
use super::contact::onset::Onset;
use super::description::body::Frame;
use super::forces::loads::Loads;
use super::model::MechanismModel;
use super::newton::matrix::ImplicitMatrix;
use super::step::StepStart;
use super::system::MechanismSums;
use crate::error::Result;
use crate::geometry::Vec2;
use crate::integrator::OdeSystem;

/// How positions and velocities are kept on the constraints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stabilisation {
    /// Projected after every step, to round-off.
    Projection,
    /// Pulled back by a damped oscillator of this angular frequency \[rad/s\] (Baumgarte 1972), for comparison; at 0 the drift of the
    /// formulas shows.
    Baumgarte(f64),
}

/// The right-hand side; its memory changes between steps only.
///
/// The solution is y = [q, v, energy dissipated, external work], with the bristles of contacts behind q and v, less a `shift`, which
/// holds what projections have added: the integrator's own solution and its history stay as they are. During a step the shift of velocities is constant and that of
/// coordinates grows by it, so that dq/dt = v holds within the integrator's solution as it does within the state: an implicit
/// corrector takes coordinates from velocities without asking.
#[derive(Debug, Clone)]
pub struct MechanismDynamics {
    pub(crate) model: Arc<MechanismModel>,
    pub(crate) frames: Vec<Frame>,
    pub(crate) loads: Loads,
    pub(crate) rows: Vec<Row>,
    /// Present when there are constraints.
    pub(crate) kkt: Option<SparseKkt>,
    pub(crate) accelerations: Vec<f64>,
    pub(crate) multipliers: Vec<f64>,
    /// What happens on each side of each contact, and what it remembers.
    pub(crate) touches: Vec<Touch>,
    pub(crate) memory: Vec<Memory>,
    /// Whether each contact is near enough to bear: what is not leaves its sides alone.
    pub(crate) near: Vec<bool>,
    /// Largest depth \[m\] of each contact that is near, and its rate \[m/s\].
    pub(crate) deepest: Vec<[f64; 2]>,
    /// How each contact is where the step under way began.
    pub(crate) starts: Vec<ContactEnd>,
    pub(crate) bristles: Bristles,
    pub(crate) pin_torques: PinTorques,
    pub(crate) shift: Vec<f64>,
    /// When the shift of coordinates was what it says \[s\].
    pub(crate) shift_time: f64,
    pub(crate) stabilisation: Stabilisation,
    /// Below this, the constraints count as near a singular position.
    pub(crate) near_singular: f64,
    /// How many constraints are independent away from singular positions.
    pub(crate) rank: usize,
    /// Whether a place beside is looked at for what holds here: it does not ask for its own sides.
    pub(crate) aside: bool,
    /// Time of the last derivative \[s\].
    pub(crate) time: f64,
    /// The implicit corrector's matrix, once it is used.
    pub(crate) corrector: Option<Box<ImplicitMatrix>>,
    /// Scratch of projections: residuals, changes.
    pub(crate) projecting: [Vec<f64>; 2],
    /// Scratch: loads of the free coordinates.
    pub(crate) forces: Vec<f64>,
    /// Scratch: the state with its shift.
    shifted: Vec<f64>,
    /// Where the last step of a run began.
    pub(super) step: StepStart,
    /// Contact onsets so far.
    pub(super) onsets: u64,
    /// Those that no row has reported, while a recording asks for them.
    pub(super) unreported_onsets: Option<Vec<Onset>>,
    /// Energies dissipated and put in where the state was read last.
    pub(super) sums: MechanismSums,
    assembly: Arc<Assembly>,
    /// Scratch: a state inside a step, the integrator's solution there, and a derivative.
    pub(super) inside: Vec<f64>,
    pub(super) solution: Vec<f64>,
    pub(super) slope: Vec<f64>,
}

/// Where some constraints are redundant, part of the independence near singular positions below which nothing counts.
const FAINT: f64 = 0.1;

impl MechanismDynamics {
    /// The equations of a model, with no contact remembered.
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
            model,
        }
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &Arc<MechanismModel> {
        &self.model
    }

    /// Assembles the mechanism for a run; returns the integrator's state.
    ///
    /// # Errors
    /// When it does not go together.
    pub(crate) fn assemble_for_run(&mut self, give_up: &dyn Fn() -> bool) -> Result<Vec<f64>> {
        let assembly = self.assemble_unless(give_up)?;
        let state = self.with_bristles(&assembly.state);
        self.assembly = Arc::new(assembly);
        Ok(state)
    }

    /// What assembling found.
    #[must_use]
    pub fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    /// Whether there is a constrained system to solve at all.
    #[must_use]
    pub fn is_constrained(&self) -> bool {
        self.kkt.is_some()
    }

    /// Reads positions and velocities (q, then v), without a shift.
    pub(crate) fn place(&mut self, state: &[f64]) {
        let n = self.model.coordinates();
        for (frame, first) in self.frames.iter_mut().zip(&self.model.first) {
            if let Some(i) = *first {
                *frame = Frame::new(
                    [state[i], state[i + 1], state[i + 2]],
                    [state[n + i], state[n + i + 1], state[n + i + 2]],
                );
            }
        }
    }

    /// Reads velocities alone, of bodies that are where they were.
    pub(crate) fn move_with(&mut self, state: &[f64]) {
        let n = self.model.coordinates();
        for (frame, first) in self.frames.iter_mut().zip(&self.model.first) {
            if let Some(i) = *first {
                frame.velocity = Vec2::new(state[n + i], state[n + i + 1]);
                frame.spin = state[n + i + 2];
            }
        }
    }

    /// Evaluates the constraint equations where the bodies are.
    pub(crate) fn find_rows(&mut self, t: f64) {
        for (row, equation) in self.rows.iter_mut().zip(&self.model.equations) {
            *row = equation.evaluate(t, &self.frames);
        }
    }

    /// Gathers all loads where the bodies are.
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
            let was_near = std::mem::replace(near, contact.is_near(&self.frames));
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
            } else if was_near {
                touches.fill(Touch::default());
            }
        }
    }

    /// Accelerations and multipliers where the bodies are.
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
        if let Stabilisation::Baumgarte(frequency) = self.stabilisation {
            for row in &mut self.rows {
                let rate = row.rate(&self.frames);
                row.gamma -= 2.0 * frequency * rate + frequency * frequency * row.value;
            }
        }
        if self.kkt.is_some() {
            // What is redundant depends on the rest only where all joints hold, which no state within a step is quite: so
            // it is what is nearly dependent that is left out, while enough is left.
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

    /// Independence below which nothing counts: that of rounding, or, where some constraints are redundant, what these seem
    /// to have where joints do not quite hold.
    pub(crate) fn faint(&self) -> f64 {
        if self.rank < self.rows.len() {
            FAINT * self.near_singular
        } else {
            0.0
        }
    }

    /// Factors of constraints that have a hold; whether they are as many as away from singular positions.
    fn hold(&mut self) -> bool {
        let (part, faint) = (self.near_singular, self.faint());
        let Some(kkt) = &mut self.kkt else {
            return true;
        };
        kkt.factorise(&self.rows, part);
        if kkt.rank() < self.rank && faint > 0.0 {
            // Many joints together may hold weakly without being singular.
            kkt.factorise(&self.rows, faint);
        }
        kkt.rank() >= self.rank
    }

    /// Factors of all constraints that count.
    pub(crate) fn factorise_whole(&mut self) {
        let part = self.faint();
        if let Some(kkt) = &mut self.kkt {
            kkt.factorise(&self.rows, part);
        }
    }

    /// Time from `t` on \[s\] in which nothing passes unseen: no circle a profile that it is not near to, from where the bodies
    /// are by their speeds and accelerations; no bend of a driver or of a force, nor a change that would be over at once. What is longer than `within`
    /// is not told from what is without limit.
    pub(crate) fn longest_step_within(&self, t: f64, within: f64) -> f64 {
        let motions = self
            .model
            .equations
            .iter()
            .filter_map(|e| e.motion.as_ref());
        let motions = motions.map(|motion| motion.longest_step(t));
        let forces = self.model.forces.iter().map(|force| force.longest_step(t));
        let longest = motions.chain(forces).fold(f64::INFINITY, f64::min);
        let contacts = self.model.contacts.iter().zip(&self.model.sides_of_contact);
        let times = contacts.map(|(contact, sides)| {
            let touches = &self.touches[sides.clone()];
            contact.free_time(&self.frames, self.rates_of(contact), touches, within)
        });
        times.fold(longest, f64::min)
    }

    /// Accelerations of the two bodies of a contact.
    pub(crate) fn rates_of(&self, contact: &CompiledContact) -> [[f64; 3]; 2] {
        [contact.a.body, contact.b.body].map(|body| match self.model.first[body] {
            None => [0.0; 3],
            Some(i) => [0, 1, 2].map(|k| self.accelerations[i + k]),
        })
    }

    /// What a side without penetration remembers: that the circle is behind it, or nothing.
    pub(crate) fn apart(&self, k: usize) -> Memory {
        let (contact, side) = self.model.sides[k];
        let contact = &self.model.contacts[contact];
        let frames = [contact.a.body, contact.b.body].map(|body| &self.frames[body]);
        contact.apart(frames[0], frames[1], side, self.memory[k])
    }

    /// Power dissipated, with the work that bristles store, and power of applied forces and drivers at the last evaluation \[W\].
    fn powers(&self) -> [f64; 2] {
        [
            self.loads.dissipated,
            self.loads.worked_in + self.driver_power(),
        ]
    }

    /// Work that the drivers do: power of the multipliers along the prescribed motions \[W\].
    fn driver_power(&self) -> f64 {
        let rows = self.rows.iter().zip(&self.multipliers);
        rows.map(|(row, lambda)| lambda * row.time_rate).sum()
    }

    /// Adds the shift at `t` to the integrator's coordinates and velocities.
    pub(crate) fn add_shift(&self, t: f64, state: &mut [f64]) {
        let n = self.model.coordinates();
        let since = t - self.shift_time;
        let (shift_q, shift_v) = self.shift.split_at(n);
        let (q, v) = state.split_at_mut(n);
        for (((q, v), place), rate) in q.iter_mut().zip(v).zip(shift_q).zip(shift_v) {
            *q += place + since * rate;
            *v += rate;
        }
    }

    /// Evaluates everything at positions and velocities, without a shift.
    pub(crate) fn evaluate(&mut self, t: f64, state: &[f64]) {
        self.place(state);
        self.accelerate(t);
    }
}

impl OdeSystem for MechanismDynamics {
    /// What is allowed does not go with the accuracy: energy that a contact keeps or loses is not of the order of its depth.
    fn accepts_step(&mut self, length: f64, _allowed: f64) -> bool {
        !self.passes_contact(length)
    }

    fn dimension(&self) -> usize {
        self.model.dimension()
    }

    /// A damped contact that lets go loses the energy that it stores without a force: only the sums show it.
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
        dydt[..unknowns].copy_from_slice(&y[unknowns..2 * unknowns]);
        dydt[unknowns..unknowns + n].copy_from_slice(&self.accelerations);
        dydt[unknowns + n..2 * unknowns].copy_from_slice(&self.bristles.rate);
        let powers = self.powers();
        dydt[2 * unknowns..].copy_from_slice(&powers);
        self.shifted = shifted;
    }
}

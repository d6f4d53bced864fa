//! Equations of motion: contacts -> forces -> accelerations.
//!
//! Accelerations are forces divided by masses, and the only linear system is that of the implicit corrector. Ideal hinges, whose forces
//! are unknowns, use its factors (`chain/rhs/ideal_hinges.rs`).

mod bristles;
mod checkpoint;
mod contact_events;
mod contact_forces;
mod energy;
mod energy_quadrature;
mod evaluation;
mod implicit;
mod in_step_events;
mod inputs;
mod law_ranges;
mod rollback;
mod rows;
mod start_checks;
mod system;

use std::cmp::Ordering;
use std::sync::Arc;

pub use bristles::{Bristles, Stored};
pub use checkpoint::Checkpoint;
use contact_events::ContactEvents;
pub use evaluation::Evaluation;
use inputs::Inputs;
use law_ranges::PastRanges;
#[cfg(feature = "python")]
pub(crate) use start_checks::check_rows;
pub(crate) use start_checks::check_start;

use crate::chain::contact::ImpactMemory;
pub use crate::chain::loads::SprocketLoad;
use crate::chain::model::Model;
pub use crate::chain::powers::{Losses, Powers};
use crate::chain::report::ReportKernels;
use crate::chain::rhs::Kernels;
use crate::integrator::OdeSystem;
use crate::math::simd::{InstructionSet, padded};
pub use crate::system::Energy;
use crate::system::EnergyQuadrature;

/// Dynamics of a drive: right-hand side for the integrator, and the impact velocity memory of its contacts.
///
/// State: y = [q, dq/dt].
#[derive(Debug, Clone)]
pub struct Dynamics {
    model: Arc<Model>,
    /// Impact velocity memory of the contacts; written between steps only.
    pub memory: ImpactMemory,
    /// Results of the last evaluation for a report.
    pub evaluated: Evaluation,
    kernels: Kernels,
    /// Kernels for reports, separate from those of the steps.
    reader: Box<ReportKernels>,
    keeps_energy: bool,
    /// Powers at the end of the last step, where energy is kept.
    power_at_end: Powers,
    quadrature: EnergyQuadrature<Powers>,
    inputs: Inputs,
    events: ContactEvents,
    past_ranges: PastRanges,
    /// Scratch: derivative of the state.
    slope: Vec<f64>,
    /// Scratch: largest tooth force of every bushing, for rows.
    tooth_forces: Vec<f64>,
    /// Scratch: state inside a step, padded.
    inside: Vec<f64>,
}

/// Most iterations of Newton's method to close ideal hinges at a start. They converge quadratically.
const MOST_CLOSINGS: u32 = 50;

/// Distance of the ends of a closed ideal hinge, over half the pitch: iterations go on to rounding, where they stagnate.
const CLOSED: f64 = 1e-9;

impl Dynamics {
    /// Create the dynamics of `model`.
    #[must_use]
    pub fn new(model: Arc<Model>) -> Self {
        let (links, sprockets) = (model.links, model.sprockets.len());
        Self {
            memory: ImpactMemory::new(
                links,
                model.roller_count(),
                links * sprockets,
                model.min_impact_velocity,
            ),
            evaluated: Evaluation::new(&model),
            kernels: Kernels::new(&model),
            reader: Box::new(ReportKernels::new(&model)),
            keeps_energy: false,
            power_at_end: Powers::default(),
            quadrature: EnergyQuadrature::new(),
            inputs: Inputs::new(&model),
            events: ContactEvents::new(&model),
            past_ranges: PastRanges::default(),
            slope: vec![0.0; 2 * model.coordinates],
            tooth_forces: vec![0.0; links],
            inside: vec![0.0; padded(2 * model.coordinates)],
            model,
        }
    }

    /// Return the model.
    #[must_use]
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// Switch energy metering on or off: powers, and with them the sums of the energy balance.
    pub fn keep_energy(&mut self, keep: bool) {
        self.keeps_energy = keep;
    }

    /// Return the powers at (`t`, `y`) after an evaluation of the right-hand side there, with energy metering.
    #[must_use]
    pub fn powers(&self, t: f64, y: &[f64]) -> Powers {
        self.kernels.last_powers(&self.model, t, y)
    }

    /// Return the energies at the last evaluation.
    #[must_use]
    pub fn energy(&self) -> Energy {
        energy::energy(self)
    }

    /// Write the accelerations at (`t`, `y`) of all coordinates.
    fn accelerate(&mut self, t: f64, y: &[f64], accelerations: &mut [f64]) {
        let (kernels, model, memory) = (&mut self.kernels, &self.model, &self.memory);
        accelerations[model.used_coordinates..model.coordinates].fill(0.0);
        kernels.keep_powers(self.keeps_energy);
        kernels.accelerations(model, memory, t, y, accelerations);
    }

    /// Evaluate the right-hand side at (`t`, `y`) outside of a step and discard the derivative.
    ///
    /// The results are penetrations and forces of contacts, and the powers with energy metering on.
    pub(crate) fn differentiate(&mut self, t: f64, y: &[f64]) {
        let mut derivative = std::mem::take(&mut self.slope);
        let writes_gaps = self.kernels.write_gaps(false);
        self.derivative(t, y, &mut derivative);
        self.kernels.write_gaps(writes_gaps);
        self.slope = derivative;
    }

    /// Move the links, and change their velocities, to close ideal hinges: the least changes, weighted by mass.
    pub(crate) fn close_ideal_hinges(&mut self, t: f64, y: &mut [f64]) {
        if !self.model.hinges.ideal {
            return;
        }
        let mut before = f64::INFINITY;
        for _ in 0..MOST_CLOSINGS {
            self.differentiate(t, y);
            let open = self.kernels.project_hinges(&self.model, y);
            if open < CLOSED * self.model.half_pitch && open >= 0.5 * before {
                break;
            }
            before = open;
        }
        self.differentiate(t, y);
        self.kernels.end_step();
    }

    /// Close ideal hinges that a small move has opened, by the last matrix; return false where this does not converge.
    pub(crate) fn close_ideal_hinges_nearby(&mut self, y: &mut [f64]) -> bool {
        let mut before = f64::INFINITY;
        loop {
            let open = self.kernels.project_hinges(&self.model, y);
            if open <= CLOSED * self.model.half_pitch {
                return true;
            }
            // An offset that is not a number is not below the one before.
            if open.partial_cmp(&before) != Some(Ordering::Less) {
                return false;
            }
            before = open;
        }
    }

    /// Select an instruction set instead of the widest one of this machine.
    pub fn use_instructions(&mut self, instructions: InstructionSet) {
        self.kernels.use_instructions(instructions);
        self.reader.kernels.use_instructions(instructions);
    }

    /// Return the instruction set in use.
    #[must_use]
    pub fn instructions(&self) -> InstructionSet {
        self.kernels.instructions()
    }
}

impl OdeSystem for Dynamics {
    /// Screen the step for contact events; reject it if a contact that is open at both ends was deeper inside than `allowed` \[m\].
    fn accepts_step(&mut self, length: f64, allowed: f64) -> bool {
        let screened = self.kernels.screen(&self.model, length);
        (self.events.event_possible, self.events.fastest) =
            (screened.event_possible, screened.speed);
        let accepts = !screened.event_possible || self.deepest_in_step_contact(length) <= allowed;
        // An explicit step evaluates its solution after this: what is screened is the end of the step.
        self.kernels.write_gaps(!accepts);
        accepts
    }

    fn dimension(&self) -> usize {
        2 * self.model.coordinates
    }

    fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        let nq = self.model.coordinates;
        let (rates, accelerations) = dydt.split_at_mut(nq);
        rates.copy_from_slice(&y[nq..2 * nq]);
        self.kernels.take_hinge_forces(false);
        self.accelerate(t, y, accelerations);
    }
}

//! Evaluations for reports: motion of all bodies, contacts, bristles and accelerations at one instant.

use super::{Bristles, Dynamics, Powers};
use crate::chain::contact::ContactId;
use crate::chain::model::Model;
use crate::chain::motion::Motion;
use crate::chain::report::{
    Accelerations, HingeContacts, OutputRequest, ReportKernels, RollerContacts, ToothContacts,
};

/// Results of the last evaluation for a report.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// Motion of all bodies.
    pub motion: Motion,
    /// Hinges.
    pub hinges: HingeContacts,
    /// Rollers on their bushings.
    pub rollers: RollerContacts,
    /// Teeth.
    pub teeth: ToothContacts,
    /// Bristles.
    pub bristles: Bristles,
    /// Accelerations of all bodies.
    pub accelerations: Accelerations,
}

impl Evaluation {
    /// Return penetration \[m\] and penetration rate \[m/s\] of a contact. The rate is valid for teeth within reach only.
    pub(super) fn penetration_and_rate(&self, contact: ContactId) -> (f64, f64) {
        let (penetration, rate, i) = match contact {
            ContactId::Hinge(k) => (&self.hinges.penetration, &self.hinges.rate, k),
            ContactId::Roller(k) => (&self.rollers.penetration, &self.rollers.rate, k),
            ContactId::Tooth(pair) => (&self.teeth.penetration, &self.teeth.rate, pair),
        };
        (penetration[i], rate[i])
    }

    /// Allocate the results for `model`.
    pub(super) fn new(model: &Model) -> Self {
        let (links, sprockets) = (model.links, model.sprockets.len());
        Self {
            motion: Motion::new(model.bodies()),
            hinges: HingeContacts::new(links),
            rollers: RollerContacts::new(model.roller_count()),
            teeth: ToothContacts::new(links, sprockets),
            bristles: Bristles::of(model),
            accelerations: Accelerations::new(model.bodies(), sprockets),
        }
    }
}

impl Dynamics {
    /// Evaluate contacts, forces and accelerations at (`t`, `y`), and return the powers.
    pub fn evaluate(&mut self, t: f64, y: &[f64]) -> Powers {
        self.evaluated.motion.read(&self.model, t, y);
        self.evaluated.bristles.read(&self.model, y);
        self.reader.state.copy_from_slice(y);
        self.evaluate_state(t)
    }

    /// Evaluate the same for the present motion and bristles.
    pub fn evaluate_motion(&mut self, t: f64) -> Powers {
        self.evaluated
            .motion
            .write(&self.model, &mut self.reader.state);
        self.evaluated
            .bristles
            .write(&self.model, &mut self.reader.state);
        self.evaluate_state(t)
    }

    /// Evaluate the reader's state with a new candidate list, valid for any positions of the bodies.
    fn evaluate_state(&mut self, t: f64) -> Powers {
        let ReportKernels {
            kernels,
            state,
            accelerations,
            ..
        } = &mut *self.reader;
        let (model, memory, place) = (&self.model, &self.memory, (&self.evaluated.motion, t));
        kernels.candidates.invalidate();
        kernels.keep_powers(self.keeps_energy);
        kernels.evaluate_placed(model, memory, place, state, accelerations);
        let powers = (self.keeps_energy).then(|| kernels.last_powers(model, t, state));
        self.evaluated.accelerations.on_ends = kernels.forces_on_ends(model).unwrap_or_default();
        self.evaluated
            .accelerations
            .chain
            .copy_from_slice(kernels.sprocket_loads());
        self.evaluated.accelerations.read(
            model,
            &self.evaluated.motion,
            accelerations,
            &memory.pawls,
            t,
        );
        self.read_hinges();
        self.read_teeth();
        powers.unwrap_or_default()
    }

    /// Evaluate the outputs of `request` at (`t`, `y`). Other outputs are undefined afterwards.
    pub(crate) fn evaluate_for(&mut self, request: OutputRequest, t: f64, y: &[f64]) {
        self.evaluated.motion.read(&self.model, t, y);
        if !request.hinges && !request.teeth {
            return;
        }
        self.evaluated.bristles.read(&self.model, y);
        let ReportKernels {
            kernels,
            accelerations,
            ..
        } = &mut *self.reader;
        if request.teeth {
            kernels.candidates.copy(&self.kernels.candidates);
        }
        let (model, memory, motion) = (&self.model, &self.memory, &self.evaluated.motion);
        if request.hinges && model.hinges.ideal {
            // Forces of ideal hinges follow from the accelerations.
            kernels.keep_powers(false);
            kernels.evaluate_placed(model, memory, (motion, t), y, accelerations);
        } else {
            kernels.evaluate_contacts(model, memory, motion, (y, accelerations), request.teeth);
        }
        if request.sprocket_loads {
            self.evaluated
                .accelerations
                .chain
                .copy_from_slice(kernels.sprocket_loads());
        }
        if request.hinges {
            self.read_hinges();
        }
        if request.teeth {
            self.read_teeth();
        }
    }

    /// Copy hinges, rollers and bristles from the last evaluation of the reader.
    fn read_hinges(&mut self) {
        let (model, kernels) = (&self.model, &self.reader.kernels);
        let chain = kernels.chain();
        self.evaluated.motion.cos[..model.links].copy_from_slice(&chain.cos[..model.links]);
        self.evaluated.motion.sin[..model.links].copy_from_slice(&chain.sin[..model.links]);
        let instructions = kernels.instructions();
        self.evaluated
            .hinges
            .read(model, &self.evaluated.motion, chain, instructions);
        if let Some(ideal) = &kernels.ideal {
            self.evaluated.hinges.take_forces(&ideal.force);
        }
        self.evaluated.rollers.read(
            model,
            &self.evaluated.motion,
            &self.evaluated.hinges,
            kernels.rollers(),
            instructions,
        );
        let accelerations = &self.reader.accelerations[model.bristles.all()];
        self.evaluated.bristles.rate.copy_from_slice(accelerations);
    }

    /// Copy the tooth contacts from the last evaluation of the reader.
    fn read_teeth(&mut self) {
        let ReportKernels {
            kernels, readings, ..
        } = &mut *self.reader;
        self.evaluated.teeth.clear();
        for s in 0..self.model.sprockets.len() {
            let candidates = kernels.read_teeth(&self.model, s, readings);
            self.evaluated
                .teeth
                .read(&self.model, s, candidates, readings);
        }
    }
}

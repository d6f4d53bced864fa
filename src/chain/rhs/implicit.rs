//! Implicit steps: slopes for Newton's matrix, its factors and corrections, and bristles as local unknowns.

use super::{Kernels, on_teeth};
use crate::chain::model::Model;
use crate::chain::newton::{CorrectedRollers, Evaluated, NewtonMatrix, PowerChange};

impl Kernels {
    /// Allocate Newton's matrix.
    pub(crate) fn make_room_for_newton(&mut self, model: &Model) {
        if self.newton.is_none() {
            self.newton = Some(Box::new(NewtonMatrix::new(model)));
        }
    }

    /// Switch on or off the slopes of all forces, which [`Self::factorise`] needs, for the next evaluations.
    pub(crate) fn write_slopes(&mut self, write: bool) {
        self.writes_slopes = write;
    }

    /// Factorise Newton's matrix of the last evaluation, which must have written slopes. Return false where it is singular, or not
    /// definite and not allowed to be `indefinite`.
    pub(crate) fn factorise(
        &mut self,
        model: &Model,
        pawls: &[f64],
        gamma: f64,
        indefinite: bool,
    ) -> bool {
        let Some(mut newton) = self.newton.take() else {
            return false;
        };
        let factorised = newton.factorise(model, &self.evaluated(pawls, indefinite), gamma);
        if let Some(ideal) = &mut self.ideal {
            ideal.gamma = gamma;
        }
        self.newton = Some(newton);
        factorised
    }

    /// Return the data of the last evaluation that Newton's matrix uses.
    fn evaluated<'a>(&'a self, pawls: &'a [f64], indefinite: bool) -> Evaluated<'a> {
        Evaluated {
            instructions: self.instructions,
            chain: &self.chain,
            on_teeth: on_teeth(&self.chain, self.rollers.as_deref()),
            candidates: &self.candidates,
            poses: &self.poses,
            pawls,
            indefinite,
        }
    }

    /// Change losses of the last evaluation and moments on the sprockets, and with `FORCES` normal forces, to those after a
    /// `correction` of all velocities with γ.
    pub(crate) fn correct_powers<const FORCES: bool>(
        &mut self,
        model: &Model,
        correction: (f64, &[f64]),
    ) {
        if model.has_friction() {
            self.correct_powers_of::<FORCES, true>(model, correction);
        } else {
            self.correct_powers_of::<FORCES, false>(model, correction);
        }
    }

    /// The same with or without friction.
    fn correct_powers_of<const FORCES: bool, const FRICTION: bool>(
        &mut self,
        model: &Model,
        (gamma, correction): (f64, &[f64]),
    ) {
        let Some(newton) = &mut self.newton else {
            return;
        };
        let n = model.links;
        newton.write_corrected_ends::<FRICTION>(n, self.instructions);
        let bodies = model.rollers.as_ref().zip(self.rollers.as_deref_mut());
        let rollers = bodies.map(|(of, rollers)| CorrectedRollers {
            arrays: &mut rollers.arrays,
            correction: [0, n, 2 * n].map(|axis| &correction[of.first + axis..][..n]),
        });
        let border = &correction[3 * n..][..model.wheel_coordinates()];
        let change = self.instructions.run(PowerChange::<FORCES, FRICTION> {
            matrix: newton,
            links: n,
            gamma,
            constants: &self.links,
            chain: &mut self.chain,
            rollers,
            overhang: self.candidates.overhang,
            friction: [&model.hinges.friction, &model.teeth.friction].map(Option::as_ref),
            bushing_radius: model.teeth.contact_radius,
            candidates: &mut self.candidates.sprockets,
            poses: &self.poses,
            border,
            loads: &mut self.loads,
        });
        self.losses.hinge_contact += change.hinge_contact;
        self.losses.hinge_friction += change.hinge_friction;
        self.losses.roller_contact += change.roller_contact;
        self.losses.roller_friction += change.roller_friction;
        self.losses.tooth_contact += change.tooth_contact;
        self.losses.tooth_friction += change.tooth_friction;
    }

    /// Overwrite a residual of the velocities with the correction, the solution with the last matrix.
    pub(crate) fn correct(&mut self, model: &Model, residual: &mut [f64]) {
        if self.ideal.is_some() {
            self.correct_with_hinge_forces(model, residual);
        } else if let Some(newton) = &mut self.newton {
            newton.correct(model, self.instructions, residual, None);
        }
    }

    /// Return whether the last correction has changed the slopes of a film.
    pub(crate) fn film_slopes_changed(&self) -> bool {
        (self.newton.as_ref()).is_some_and(|newton| newton.film_slopes_changed)
    }

    /// Take the forces of ideal hinges as given in the next evaluations, or solve for them.
    pub(crate) fn take_hinge_forces(&mut self, take: bool) {
        if let Some(ideal) = &mut self.ideal {
            ideal.takes_forces = take;
        }
    }

    /// Return the residual of the velocities with the corrected forces of ideal hinges.
    pub(crate) fn residual_of_corrected_forces(&self) -> Option<&[f64]> {
        self.ideal.as_ref().map(|ideal| &ideal.residual[..])
    }

    /// Start or end an implicit step for bristles. With predicted deflections and γ, evaluations solve for the deflections; with
    /// `None` they use those of the state.
    pub(crate) fn set_bristle_stage(&mut self, stage: Option<(&[f64], f64)>) {
        match (&mut self.bristles, stage) {
            (Some(bristles), Some((predicted, gamma))) => {
                bristles.begin_implicit_stage(predicted, gamma);
            }
            (Some(bristles), None) => bristles.end_implicit_stage(),
            (None, _) => {}
        }
    }

    /// Return the deflections of the bristles that the last evaluation of an implicit step solved for \[m\].
    pub(crate) fn solved_bristles(&self) -> &[f64] {
        (self.bristles.as_ref()).map_or(&[], |bristles| bristles.solved())
    }
}

//! Loops over hinges, rollers and teeth: their input, and the loop instance for the options of a model.

use super::bristles::{BristleState, Bristling, ContactKind};
use super::chain::{
    ChainFound, EvaluateHinges, EvaluateRollers, HingeFriction, Joints, Lubricant, RepeatBushings,
};
use super::teeth::{EvaluateTeeth, TeethFound, ToothFriction};
use super::tooth_constants::{GapForm, ToothConstants};
use super::{Kernels, on_teeth};
use crate::chain::arrays::slopes::Slopes;
use crate::chain::contact::ImpactMemory;
use crate::chain::model::{Model, RollerModel};
use crate::chain::newton::NewtonMatrix;
use crate::force_law::LuGre;
use crate::geometry::Vec2;

/// Return the slopes to write, if an evaluation shall write them.
fn requested(newton: &mut Option<Box<NewtonMatrix>>, writes: bool) -> Option<&mut Slopes> {
    newton
        .as_mut()
        .filter(|_| writes)
        .map(|newton| &mut newton.slopes)
}

/// Return the arrays and the law of the bristles of a loop, where its contacts have any.
fn bristling<'a>(
    state: Option<&'a mut BristleState>,
    (place, law): (ContactKind, Option<&'a LuGre>),
    radius: f64,
) -> Option<Bristling<'a>> {
    state
        .zip(law)
        .map(|(state, law)| state.lend(place, law, radius))
}

impl Kernels {
    /// Evaluate the hinges with the loop instance for the options of `model`.
    pub(super) fn evaluate_hinges(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        y: &[f64],
    ) -> ChainFound {
        let law = &model.hinges.law;
        let n = model.links;
        let (q, v) = y.split_at(model.coordinates);
        let slopes = requested(&mut self.newton, self.writes_slopes);
        let (slopes, film_slopes) = slopes
            .map(|slopes| (&mut slopes.hinges, &mut slopes.films[..]))
            .unzip();
        let lubricant = model.hinges.film.as_ref().map(|film| Lubricant {
            film,
            slopes: film_slopes,
        });
        let friction = model.hinges.friction.as_ref().map(|law| HingeFriction {
            law,
            pin_radius: model.hinges.pin_radius,
        });
        let bristles = bristling(
            self.bristles.as_deref_mut(),
            (ContactKind::Hinges, model.hinges.bristles.as_ref()),
            model.hinges.pin_radius,
        );
        let has_friction = friction.is_some();
        let hinges = Joints {
            form: law.pairs.form(),
            law_constants: law.pairs.pairs()[0],
            clearance: model.hinges.clearance,
            lambda: law.lambda,
            minimum: model.min_impact_velocity,
            inverse_impact_velocity: memory.hinge_inverse_impact_velocity(),
            reference: &self.candidates.reference,
            powers: self.keeps_powers,
            slopes,
            friction,
            bristles,
        };
        macro_rules! join {
            ($damped:literal, $friction:literal, $bristled:literal, $extra:literal) => {
                self.instructions
                    .run(EvaluateHinges::<$damped, $friction, $bristled, $extra> {
                        hinges,
                        places: [&q[..n], &q[n..2 * n], &q[2 * n..3 * n]],
                        speeds: [&v[..n], &v[n..2 * n], &v[2 * n..3 * n]],
                        overhang: self.candidates.overhang,
                        constants: &self.links,
                        arrays: &mut self.chain,
                        lubricant,
                        compliance: self.links.compliance.as_deref(),
                    })
            };
        }
        if model.hinges.bristles.is_some() {
            join!(true, true, true, true)
        } else if model.hinges.has_film_or_compliance() {
            join!(true, true, false, true)
        } else if has_friction {
            join!(true, true, false, false)
        } else if law.lambda > 0.0 {
            join!(true, false, false, false)
        } else {
            join!(false, false, false, false)
        }
    }

    /// Evaluate the rollers on their bushings with the loop instance for the options of `model`.
    pub(super) fn evaluate_rollers(
        &mut self,
        model: &Model,
        of: &RollerModel,
        memory: &ImpactMemory,
        y: &[f64],
    ) -> ChainFound {
        let Some(rollers) = &mut self.rollers else {
            return ChainFound::default();
        };
        let n = model.links;
        let (q, v) = y.split_at(model.coordinates);
        let (q, v) = (&q[of.first..], &v[of.first..]);
        let slopes = requested(&mut self.newton, self.writes_slopes);
        let slopes = slopes.map(|slopes| &mut slopes.rollers);
        let friction = model.hinges.friction.as_ref().map(|law| HingeFriction {
            law,
            pin_radius: of.bushing_radius,
        });
        let bristles = bristling(
            self.bristles.as_deref_mut(),
            (ContactKind::Rollers, model.hinges.bristles.as_ref()),
            of.bushing_radius,
        );
        let has_friction = friction.is_some();
        let bores = Joints {
            form: of.law.pairs.form(),
            law_constants: of.law.pairs.pairs()[0],
            clearance: of.clearance,
            lambda: of.law.lambda,
            minimum: model.min_impact_velocity,
            inverse_impact_velocity: memory.roller_inverse_impact_velocity(),
            reference: &self.candidates.reference,
            powers: self.keeps_powers,
            slopes,
            friction,
            bristles,
        };
        macro_rules! join {
            ($damped:literal, $friction:literal, $bristled:literal) => {
                self.instructions
                    .run(EvaluateRollers::<$damped, $friction, $bristled> {
                        bores,
                        places: [&q[..n], &q[n..2 * n]],
                        speeds: [&v[..n], &v[n..2 * n], &v[2 * n..3 * n]],
                        overhang: self.candidates.overhang,
                        links: &self.links,
                        chain: &mut self.chain,
                        rollers,
                    })
            };
        }
        if model.hinges.bristles.is_some() {
            join!(true, true, true)
        } else if has_friction {
            join!(true, true, false)
        } else if of.law.lambda > 0.0 {
            join!(true, false, false)
        } else {
            join!(false, false, false)
        }
    }

    /// Refresh the list of candidates where a displacement since its last refresh exceeds the permitted one.
    pub(super) fn choose_candidates(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        moved_squared: f64,
    ) {
        let poses = &self.poses;
        let center = |s: usize| Vec2::from(poses[s].center);
        if !self.candidates.hold(moved_squared, center) {
            let frames = poses
                .iter()
                .map(|pose| (Vec2::from(pose.center), pose.direction));
            let [x, y] = &on_teeth(&self.chain, self.rollers.as_deref()).bushing;
            self.candidates.refresh(model, memory, [x, y], frames);
            let rollers = self.rollers.as_mut().map(|rollers| &mut rollers.arrays);
            for arrays in std::iter::once(&mut self.chain).chain(rollers) {
                arrays.clear_repeated(model.links);
                self.instructions.run(RepeatBushings {
                    links: model.links,
                    overhang: self.candidates.overhang,
                    arrays,
                });
            }
        }
    }

    /// Evaluate the teeth of sprocket `s` with the loop instance for its tooth form and the options of `model`.
    pub(super) fn evaluate_teeth(&mut self, model: &Model, s: usize) -> TeethFound {
        let law = &model.teeth.law;
        let slopes = requested(&mut self.newton, self.writes_slopes);
        let slopes = slopes.map(|slopes| &mut slopes.teeth[s]);
        let friction = model.teeth.friction.as_ref().map(|law| ToothFriction {
            law,
            bushing_radius: model.teeth.contact_radius,
        });
        let bristles = bristling(
            self.bristles.as_deref_mut(),
            (ContactKind::Teeth, model.teeth.bristles.as_ref()),
            model.teeth.contact_radius,
        );
        let (links, arrays) = match &mut self.rollers {
            Some(rollers) => (&rollers.constants, &mut rollers.arrays),
            None => (&self.links, &mut self.chain),
        };
        let ToothConstants {
            form,
            keeps_stiffness,
        } = &self.teeth[self.kind[s]];
        let keeps_stiffness = *keeps_stiffness;
        macro_rules! touch {
            ($constants:expr, $damped:literal, $friction:literal, $bristled:literal) => {
                self.instructions
                    .run(EvaluateTeeth::<_, $damped, $friction, $bristled> {
                        form: law.pairs.form(),
                        sprocket: &model.sprockets[s],
                        constants: $constants,
                        keeps_stiffness,
                        pose: &self.poses[s],
                        lambda: law.lambda,
                        minimum: model.min_impact_velocity,
                        links,
                        arrays,
                        candidates: &mut self.candidates.sprockets[s],
                        powers: self.keeps_powers,
                        slopes,
                        ends: self.screening.tooth_ends(s),
                        writes_ends: self.writes_gaps,
                        friction,
                        bristles,
                    })
            };
        }
        let bristled = model.teeth.bristles.is_some();
        match form {
            GapForm::Ansi(gap) if bristled => touch!(&**gap, true, true, true),
            GapForm::Ansi(gap) if friction.is_some() => touch!(&**gap, true, true, false),
            GapForm::Ansi(gap) if law.lambda > 0.0 => touch!(&**gap, true, false, false),
            GapForm::Ansi(gap) => touch!(&**gap, false, false, false),
            GapForm::Table(gap) if bristled => touch!(gap, true, true, true),
            GapForm::Table(gap) if friction.is_some() => touch!(gap, true, true, false),
            GapForm::Table(gap) if law.lambda > 0.0 => touch!(gap, true, false, false),
            GapForm::Table(gap) => touch!(gap, false, false, false),
        }
    }
}

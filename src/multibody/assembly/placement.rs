//! Assembly: the nearest positions and velocities, weighted by mass, that satisfy the constraints.

use super::changes::Changes;
use super::outcome::Assembly;
use super::projection::{AtHand, Projector};
use super::start_warnings::loose_parts;
use crate::error::{Error, Result, listed};
use crate::multibody::constraints::sparse_kkt::SparseKkt;
use crate::multibody::description::body::Frame;
use crate::multibody::dynamics::MechanismDynamics;
use crate::multibody::model::MechanismModel;

/// Largest number of Newton iterations of the projection that ends the assembly.
const MOST_ITERATIONS: usize = 100;

impl MechanismDynamics {
    /// Assemble the mechanism from the positions and velocities described.
    ///
    /// # Errors
    /// When no positions or velocities satisfy all constraints; the error contains the residuals by joint.
    pub fn assemble(&mut self) -> Result<Assembly> {
        self.assemble_unless(&|| false)
    }

    /// Assemble as in [`Self::assemble`]. Where `give_up` returns true, assembly ends with an error that contains the residuals by
    /// joint.
    pub(crate) fn assemble_unless(&mut self, give_up: &dyn Fn() -> bool) -> Result<Assembly> {
        let n = self.model.coordinates();
        let mut state = vec![0.0; 2 * n];
        for (body, first) in self.model.bodies.iter().zip(&self.model.first) {
            if let Some(i) = *first {
                state[i..i + 3].copy_from_slice(&body.position);
                state[n + i..n + i + 3].copy_from_slice(&body.velocity);
            }
        }
        let placed = state.clone();
        let mut projector = Projector {
            give_up,
            ..self.projector()
        };
        if !projector.approach(0.0, &mut state)
            || !projector.project(0.0, &mut state, MOST_ITERATIONS, AtHand::Nothing)
        {
            return Err(self.constraints.refuse(&self.model, &self.frames));
        }
        self.evaluate(0.0, &state);
        check_starts(&self.model, &self.frames)?;
        let changes = Changes::between(&placed, &state);
        let rank = self.constraints.kkt.as_ref().map_or(0, SparseKkt::rank);
        let redundant = self.constraints.redundant(&self.model);
        let between = self.look_beside(&state);
        let mut assembly = Assembly {
            moved: changes.moved,
            turned: changes.turned,
            velocity_change: changes.velocity,
            spin_change: changes.spin,
            degrees_of_freedom: n - rank,
            redundant,
            warnings: Vec::new(),
            state,
        };
        assembly.warnings = self.warnings(&assembly, between);
        Ok(assembly)
    }

    /// Return all warnings on the assembly. `between`: the start is at a singular position where branches of the motion meet.
    fn warnings(&self, assembly: &Assembly, between: bool) -> Vec<String> {
        let mut warnings = Vec::new();
        warnings.extend(self.model.far_moves(&self.frames, &assembly.state));
        if between {
            warnings.push(
                "the mechanism starts in a singular position, such as all bars in one line, from which two motions are possible: \
                 without velocities it starts between them; give the bodies velocities, or another position"
                    .to_string(),
            );
        }
        // At a singular position further constraints are dependent, but only there; they are not reported as redundant.
        if !between {
            warnings.extend(told_redundant(&assembly.redundant));
        }
        let memory = &self.contacts.memory;
        warnings.extend(self.model.pressed_starts(&self.frames, memory));
        warnings.extend(self.model.starts_behind(&self.frames));
        warnings.extend(loose_parts(&self.model));
        warnings
    }
}

/// Return an error where the centre of a circle is inside material at the start.
fn check_starts(model: &MechanismModel, frames: &[Frame]) -> Result<()> {
    for (contact, name) in model.contacts.iter().zip(&model.contact_names) {
        let depth = contact.center_depth(frames);
        if depth > 0.0 {
            let hole = if contact.is_hole() {
                " (the points of its outline run clockwise, so that the material lies outside of them: reverse \
                 their order if it is to lie inside)"
            } else {
                ""
            };
            return Err(Error::invalid(
                format!("start of contact {name:?}"),
                format!("{depth:.3e} m"),
                format!(
                    "is the penetration of the centre of the circle, of radius {} m, into the material{hole}: place the \
                     bodies so that they touch at most at their surfaces",
                    contact.radius
                ),
            ));
        }
    }
    Ok(())
}

/// Return one message for all joints with redundant constraints. `names` has one entry per equation.
fn told_redundant(names: &[String]) -> Option<String> {
    let mut joints: Vec<&str> = Vec::new();
    for name in names {
        if !joints.contains(&name.as_str()) {
            joints.push(name);
        }
    }
    match joints[..] {
        [] => None,
        [joint] => Some(format!(
            "joint {joint:?} is redundant; its reaction is that of least norm"
        )),
        _ => Some(format!(
            "joints {} are redundant ({} equations); their reactions are those of least norm",
            listed(joints),
            names.len()
        )),
    }
}

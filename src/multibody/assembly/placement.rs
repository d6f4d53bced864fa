//! Assembly and projection: the nearest positions and velocities, weighed by mass, that satisfy the constraints.

use super::changes::Changes;
use super::projection::AtHand;
use super::start_warnings::loose_parts;
use crate::error::{Error, Result};
use crate::multibody::constraints::sparse_kkt::SparseKkt;
use crate::multibody::dynamics::MechanismDynamics;

/// What assembling a mechanism found.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Assembly {
    /// Positions and velocities (q, then v) that satisfy the constraints, three a body that is not held.
    pub state: Vec<f64>,
    /// Farthest that a body had to be moved \[m\].
    pub moved: f64,
    /// Farthest that a body had to be turned \[rad\].
    pub turned: f64,
    /// Largest change of a body's velocity \[m/s\].
    pub velocity_change: f64,
    /// Largest change of its rate of turning \[rad/s\].
    pub spin_change: f64,
    /// Motions that the constraints leave, drivers counted among these.
    pub degrees_of_freedom: usize,
    /// Constraints that the others imply at the start, by joint.
    pub redundant: Vec<String>,
    /// What is worth a second look.
    pub warnings: Vec<String>,
}

const MOST_ITERATIONS: usize = 100;

impl MechanismDynamics {
    /// Brings the mechanism together from where it is placed.
    ///
    /// # Errors
    /// When no positions or velocities satisfy all constraints: with the residuals by joint.
    pub fn assemble(&mut self) -> Result<Assembly> {
        self.assemble_unless(&|| false)
    }

    /// The same; `give_up` is asked now and then, and ends it with what the joints miss by then.
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
        if !self.approach(0.0, &mut state, give_up)
            || !self.project(0.0, &mut state, MOST_ITERATIONS, AtHand::Nothing)
        {
            return Err(self.refuse());
        }
        self.evaluate(0.0, &state);
        self.check_starts()?;
        let changes = Changes::between(&placed, &state);
        let rank = self.kkt.as_ref().map_or(0, SparseKkt::rank);
        let redundant = self.redundant();
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

    /// No circle begins with its centre in material.
    fn check_starts(&self) -> Result<()> {
        for (contact, name) in self.model.contacts.iter().zip(&self.model.contact_names) {
            let depth = contact.center_depth(&self.frames);
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
                        "is how deep the centre of the circle, of radius {} m, lies in the material{hole}: place the \
                         bodies so that they touch at most at their surfaces",
                        contact.radius
                    ),
                ));
            }
        }
        Ok(())
    }

    /// Constraints that those before them imply, in the order in which they were described.
    fn redundant(&mut self) -> Vec<String> {
        let Some(kkt) = self.kkt.as_mut().filter(|kkt| kkt.rank() < self.rows.len()) else {
            return Vec::new();
        };
        let joint = |row: usize| self.model.equations[row].joint;
        let name = |row: usize| self.model.joints[joint(row)].name.clone();
        kkt.dependent().into_iter().map(name).collect()
    }

    fn warnings(&self, assembly: &Assembly, between: bool) -> Vec<String> {
        let mut warnings = Vec::new();
        warnings.extend(self.far_moves(&assembly.state));
        if between {
            warnings.push(
                "the mechanism is placed in a singular position, such as with all bars in one line, where two ways of \
                 moving meet: without velocities that say which is meant it begins between them; give the bodies \
                 velocities, or place it beside"
                    .to_string(),
            );
        }
        // There, and there alone, one more seems to hold what others hold.
        if !between {
            warnings.extend(told_redundant(&assembly.redundant));
        }
        warnings.extend(self.pressed_starts());
        warnings.extend(self.starts_behind());
        warnings.extend(loose_parts(&self.model));
        warnings
    }
}

/// One message for all joints that hold something others hold already; `names` has one entry an equation.
fn told_redundant(names: &[String]) -> Option<String> {
    let mut joints: Vec<String> = Vec::new();
    for name in names {
        let quoted = format!("{name:?}");
        if !joints.contains(&quoted) {
            joints.push(quoted);
        }
    }
    let last = joints.pop()?;
    if joints.is_empty() {
        return Some(format!(
            "joint {last} holds something that others hold already; its reaction is shared in the least way"
        ));
    }
    Some(format!(
        "joints {} and {last} hold something that others hold already ({} equations); their reactions are shared in the \
         least way",
        joints.join(", "),
        names.len()
    ))
}

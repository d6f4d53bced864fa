//! Static equilibrium of a drive or a mechanism: at rest with motors held, all loads applied and the tensioner at full force.
//!
//! Newton's method on the forces, from rest in every iteration: a step of backward Euler of length γ, (M - γ² K) Δq = γ² Q. For long γ this
//! is Newton's step; for short γ it is a slow motion along the forces. γ grows while the forces decrease. No hinge opens or turns by more
//! than a fraction of its clearance in one iteration, because its contact normal would change.

mod held_drive;
mod refusal;
mod resting_drive;
mod resting_mechanism;
mod settling;
mod velocities;

use std::sync::Arc;

use crate::chain::model::{ForceLaws, Model};
use crate::drive::Drive;
use crate::error::{Error, Result};
use crate::layout::{InitialConfiguration, Layout};
use crate::multibody::{Mechanism, MechanismModel};
use held_drive::{held, lay_taut};
use resting_drive::RestingDrive;
use resting_mechanism::RestingMechanism;
use settling::{Resting, Settled, settle};

/// Drive or mechanism in static equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium {
    /// Positions in equilibrium, the surfaces of its contacts, and velocities with which the run continues from there.
    pub start: InitialConfiguration,
    /// Largest unbalanced force on a body \[N\]; moments of links are divided by half the pitch, those of bodies of mechanisms by the
    /// distance of their farthest joint or contact.
    pub residual: f64,
    /// Largest contact force; of a mechanism without contact, its largest weight or force element \[N\].
    pub largest_force: f64,
    /// Number of iterations.
    pub iterations: u32,
}

impl Equilibrium {
    /// Find the static equilibrium of `drive` from its generated configuration.
    ///
    /// # Errors
    /// If the layout of the chain fails, or there is no equilibrium because nothing holds a torque, with the remaining force.
    pub fn find(drive: &Drive, laws: &ForceLaws) -> Result<Self> {
        Self::find_unless(drive, laws, &|| false)
    }

    /// Find the static equilibrium; `give_up` is called before each iteration and ends the search with the remaining force.
    ///
    /// # Errors
    /// As of [`Self::find`].
    pub fn find_unless(
        drive: &Drive,
        laws: &ForceLaws,
        give_up: &dyn Fn() -> bool,
    ) -> Result<Self> {
        let (laid, layout) = lay_taut(drive, give_up)?;
        let at_rest = still(&laid);
        // Nothing slides at rest: friction that does not stick, and a lubricant film, carry no load.
        let frictionless = ForceLaws {
            hinge_friction: None,
            tooth_friction: None,
            hinge_bristles: None,
            tooth_bristles: None,
            hinge_film: None,
            ..*laws
        };
        let model = Model::compile(&held(drive, &layout), &frictionless, &at_rest)?;
        let mut resting = RestingDrive::new(Arc::new(model), &at_rest, frictionless != *laws);
        let causes = |_: &_| refusal::causes(drive, &layout);
        let settled = rest("drive", &mut resting, give_up, causes)?;
        let mut start = moved(drive, (laid, &layout), resting.body_positions())?;
        resting.move_along_contacts(&mut start);
        start.surfaces = resting.dynamics.stored_surfaces();
        Ok(Self::of(start, &settled))
    }

    /// Find the static equilibrium of `mechanism` from its described positions, with its drivers at their initial positions; `give_up` as
    /// of [`Self::find_unless`]. The velocities are those described.
    ///
    /// # Errors
    /// If the mechanism is invalid or cannot be assembled, or there is no equilibrium because nothing holds a load, with the remaining
    /// force and the body.
    pub fn of_mechanism(mechanism: &Mechanism, give_up: &dyn Fn() -> bool) -> Result<Self> {
        let model = MechanismModel::compile(mechanism)?;
        let mut resting = RestingMechanism::assemble(model, give_up)?;
        let settled = rest("mechanism", &mut resting, give_up, RestingMechanism::causes)?;
        if let Some(why) = resting.singular() {
            return Err(Error::Impossible(format!("start=\"static\": {why}")));
        }
        let start = InitialConfiguration {
            positions: resting.dynamics.positions(),
            velocities: mechanism.bodies.iter().map(|body| body.velocity).collect(),
            surfaces: resting.dynamics.stored_surfaces(),
        };
        Ok(Self::of(start, &settled))
    }

    fn of(start: InitialConfiguration, settled: &Settled) -> Self {
        Self {
            start,
            residual: settled.residual,
            largest_force: settled.largest_force,
            iterations: settled.iterations,
        }
    }
}

/// Return the configuration without velocities.
fn still(laid: &InitialConfiguration) -> InitialConfiguration {
    InitialConfiguration {
        positions: laid.positions.clone(),
        velocities: vec![[0.0; 3]; laid.velocities.len()],
        surfaces: Vec::new(),
    }
}

/// Return the start of a drive at `positions`, with the velocities of its layout.
fn moved(
    drive: &Drive,
    (laid, layout): (InitialConfiguration, &Layout),
    positions: Vec<[f64; 3]>,
) -> Result<InitialConfiguration> {
    if let Some(why) = refusal::slid(drive, layout, &laid.positions, &positions) {
        return Err(Error::Impossible(format!("start=\"static\": {why}")));
    }
    let rollers = drive.chain.roller.is_some();
    Ok(if drive.ends.is_some() {
        InitialConfiguration { positions, ..laid }
    } else {
        laid.moved_to(positions, layout, &drive.chain.link_pitches(), rollers)
    })
}

/// Iterate `system` to equilibrium.
///
/// # Errors
/// The remaining force and the `causes`, if it does not come to rest.
fn rest<S: Resting>(
    what: &str,
    system: &mut S,
    give_up: &dyn Fn() -> bool,
    causes: impl FnOnce(&S) -> String,
) -> Result<Settled> {
    settle(system, give_up).map_err(|failed| {
        let Settled {
            residual,
            largest_force,
            iterations,
        } = failed;
        let friction = if system.leaves_friction_out() {
            "; friction is left out here: what it alone holds slides"
        } else {
            ""
        };
        Error::Impossible(format!(
            "start=\"static\": the {what} does not come to rest: {residual:.3e} N are left unbalanced after {iterations} iterations, \
             beside forces of {largest_force:.3e} N; {}{friction}",
            causes(system)
        ))
    })
}

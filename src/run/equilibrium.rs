//! Static equilibrium of a drive: links at rest with motors held, all loads applied and the tensioner at full force.
//!
//! Newton's method on the forces, from rest in every iteration: a step of backward Euler of length γ, (M - γ² K) Δq = γ² Q. For long γ this
//! is Newton's step; for short γ it is a slow motion along the forces. γ grows while the forces decrease. No hinge opens or turns by more
//! than a fraction of its clearance in one iteration, because its contact normal would change.

mod held_drive;
mod refusal;
mod settling;
mod velocities;

use std::sync::Arc;

use crate::chain::model::{ForceLaws, Model};
use crate::drive::Drive;
use crate::error::{Error, Result};
use crate::layout::InitialConfiguration;
use held_drive::{held, lay_taut};
use settling::Settling;

/// Drive in static equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium {
    /// Positions in equilibrium, the surfaces of its contacts, and velocities with which the run continues from there.
    pub start: InitialConfiguration,
    /// Largest unbalanced force on a body \[N\]; moments of links are divided by half the pitch.
    pub residual: f64,
    /// Largest contact force \[N\].
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
        let at_rest = InitialConfiguration {
            positions: laid.positions.clone(),
            velocities: vec![[0.0; 3]; laid.velocities.len()],
            ..InitialConfiguration::default()
        };
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
        let model = Arc::new(model);
        let mut settling = Settling::new(model, &at_rest);
        let residual = settling.settle(give_up).map_err(|residual| {
            Error::Impossible(format!(
                "start=\"static\": the drive does not come to rest: {residual:.3e} N are left unbalanced after {} iterations, beside \
                 contacts of {:.3e} N; {}",
                settling.iterations,
                settling.largest_force(),
                refusal::causes(drive, &layout)
            ))
        })?;
        let largest_force = settling.largest_force();
        let positions = settling.places.positions();
        if let Some(why) = refusal::slid(drive, &layout, &laid.positions, &positions) {
            return Err(Error::Impossible(format!("start=\"static\": {why}")));
        }
        let mut start = if drive.ends.is_some() {
            InitialConfiguration { positions, ..laid }
        } else {
            laid.moved_to(
                positions,
                &layout,
                &drive.chain.link_pitches(),
                drive.chain.roller.is_some(),
            )
        };
        settling.move_along_contacts(&mut start);
        start.surfaces = settling.dynamics.stored_surfaces();
        Ok(Self {
            start,
            residual,
            largest_force,
            iterations: settling.iterations,
        })
    }
}

//! Force laws of a run and their checks.

use serde::{Deserialize, Serialize};

use super::bristles::BristlePlaces;
use super::coordinates::Coordinates;
use crate::error::{Error, Result, check};
use crate::force_law::{Film, ForceLaw, Friction, LuGre};

/// Default of the minimum impact velocity \[m/s\].
const DEFAULT_MIN_IMPACT_VELOCITY: f64 = 1e-3;

/// Force laws of a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ForceLaws {
    /// Normal force of pins in bushings.
    pub hinge: ForceLaw,
    /// Normal force of bushings on teeth.
    pub tooth: ForceLaw,
    /// Friction of pins in bushings; `None`: no friction.
    pub hinge_friction: Option<Friction>,
    /// Friction of bushings on teeth; `None`: no friction.
    pub tooth_friction: Option<Friction>,
    /// Bristle friction of pins in bushings, instead of `hinge_friction`; `None`: no bristles.
    pub hinge_bristles: Option<LuGre>,
    /// Bristle friction of bushings on teeth, instead of `tooth_friction`; `None`: no bristles.
    pub tooth_bristles: Option<LuGre>,
    /// Lubricant film between pins and bushings; `None`: no film.
    pub hinge_film: Option<Film>,
    /// Minimum impact velocity \[m/s\].
    pub min_impact_velocity: f64,
}

impl ForceLaws {
    /// Check all laws, for the coefficient of restitution `restitution`.
    pub(super) fn check(&self, restitution: f64) -> Result<()> {
        check::positive("min_impact_velocity", self.min_impact_velocity, "m/s")?;
        for (friction, name) in [
            (&self.hinge_friction, "hinge_friction"),
            (&self.tooth_friction, "tooth_friction"),
        ] {
            friction
                .as_ref()
                .map_or(Ok(()), |friction| friction.check(name))?;
        }
        for (friction, bristles, place) in [
            (&self.hinge_friction, &self.hinge_bristles, "hinge"),
            (&self.tooth_friction, &self.tooth_bristles, "tooth"),
        ] {
            let Some(law) = bristles else { continue };
            law.check(&format!("{place}_bristles"))?;
            if let Some(friction) = friction {
                return Err(Error::invalid(
                    format!("{place}_friction"),
                    friction.coefficient,
                    format!(
                        "must be absent where there are {place}_bristles: a contact has one friction"
                    ),
                ));
            }
        }
        if let Some(film) = &self.hinge_film {
            film.check("hinge_film")?;
        }
        self.hinge.check("Material.restitution", restitution)?;
        self.tooth.check("Material.restitution", restitution)
    }

    /// Allocate the coordinates of the bristles for the given numbers of hinges, rollers, and sprockets with guides.
    pub(super) fn place_bristles(
        &self,
        coordinates: &mut Coordinates,
        [hinges, rollers, wheels]: [usize; 3],
    ) -> BristlePlaces {
        let many = |law: Option<LuGre>, count: usize| law.map_or(0, |_| count);
        let in_hinges = |count: usize| many(self.hinge_bristles, count);
        let counts = [
            in_hinges(hinges),
            in_hinges(rollers),
            many(self.tooth_bristles, hinges * wheels),
        ];
        let places = BristlePlaces::from(coordinates.0, counts);
        coordinates.0 = places.all().end;
        places
    }
}

impl Default for ForceLaws {
    fn default() -> Self {
        Self {
            hinge: ForceLaw::default(),
            tooth: ForceLaw::default(),
            hinge_friction: None,
            tooth_friction: None,
            hinge_bristles: None,
            tooth_bristles: None,
            hinge_film: None,
            min_impact_velocity: DEFAULT_MIN_IMPACT_VELOCITY,
        }
    }
}

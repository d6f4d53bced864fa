//! Groups of recorded channels.

use crate::chain::dynamics::{Needs, Want};
use crate::chain::model::{Model, Rotation};

/// Selection of the recorded groups of channels of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(clippy::struct_excessive_bools)] // independent switches
pub struct Groups {
    /// Force, penetration and eccentricity of every hinge, and of rollers on bushings, with peaks; strand tensions.
    pub hinges: bool,
    /// Tooth contact with the largest penetration of every bushing, with peaks.
    pub teeth: bool,
    /// Angle, speed, torque and centre of every sprocket.
    pub sprockets: bool,
    /// Positions and velocities of all bodies.
    pub bodies: bool,
    /// Energy balance.
    pub energy: bool,
}

impl Groups {
    /// Return the outputs of the dynamics of `model` that a row of these groups requires.
    pub(crate) fn needs(self, model: &Model) -> Needs {
        // The torque of a prescribed speed follows from the tooth forces; an applied torque is independent of them.
        let prescribed = |rotation: &Rotation| matches!(rotation, Rotation::Prescribed(_));
        let sprocket_loads =
            self.sprockets && model.sprockets.iter().any(|s| prescribed(&s.rotation));
        let want = |forces: bool| match (forces, self.energy) {
            (true, _) => Want::Forces,
            (false, true) => Want::Depths,
            (false, false) => Want::Nothing,
        };
        // The energy stored in bristles is proportional to the normal force.
        let stored = |law: bool| self.energy && law;
        Needs {
            hinges: want(self.hinges || stored(model.hinges.bristles.is_some())),
            teeth: want(self.teeth || sprocket_loads || stored(model.teeth.bristles.is_some())),
            sprocket_loads,
        }
    }
}

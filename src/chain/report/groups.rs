//! Groups of recorded channels.

use super::output_request::OutputRequest;
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
    pub(crate) fn request(self, model: &Model) -> OutputRequest {
        // The torque of a prescribed speed follows from the tooth forces; an applied torque is independent of them.
        let prescribed = |rotation: &Rotation| matches!(rotation, Rotation::Prescribed(_));
        let sprocket_loads =
            self.sprockets && model.sprockets.iter().any(|s| prescribed(&s.rotation));
        // The elastic energy needs the penetrations of all contacts, the energy stored in bristles their forces.
        OutputRequest {
            hinges: self.hinges || self.energy,
            teeth: self.teeth || sprocket_loads || self.energy || self.hinges && model.hinges.ideal,
            sprocket_loads,
        }
    }
}

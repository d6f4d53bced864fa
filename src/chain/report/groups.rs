//! Groups of channels that are recorded together.

use crate::chain::dynamics::{Needs, Want};
use crate::chain::model::{Model, Rotation};

/// Which groups of channels of a drive are recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(clippy::struct_excessive_bools)] // independent switches
pub struct Groups {
    /// Force, penetration and eccentricity of every hinge, and of rollers on bushings, with peaks; strand tensions.
    pub hinges: bool,
    /// Deepest tooth contact of every bushing, with peaks.
    pub teeth: bool,
    /// Angle, speed, torque and centre of every sprocket.
    pub sprockets: bool,
    /// Positions and velocities of all bodies.
    pub bodies: bool,
    /// The energy balance.
    pub energy: bool,
}

impl Groups {
    /// What a row of these groups needs to know of the dynamics of `model`.
    pub(crate) fn needs(self, model: &Model) -> Needs {
        // A motor's torque is what the teeth leave to it; an applied one is known without them.
        let prescribed = |rotation: &Rotation| matches!(rotation, Rotation::Prescribed(_));
        let sprocket_loads =
            self.sprockets && model.sprockets.iter().any(|s| prescribed(&s.rotation));
        let want = |forces: bool| match (forces, self.energy) {
            (true, _) => Want::Forces,
            (false, true) => Want::Depths,
            (false, false) => Want::Nothing,
        };
        // What bristles store goes by the normal force.
        let stored = |law: bool| self.energy && law;
        Needs {
            hinges: want(self.hinges || stored(model.hinge_bristles.is_some())),
            teeth: want(self.teeth || sprocket_loads || stored(model.tooth_bristles.is_some())),
            sprocket_loads,
        }
    }
}

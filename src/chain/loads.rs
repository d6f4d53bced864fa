//! Load of the chain on a sprocket, acceleration of the sprocket, and power of its motor, torque and tensioner.

use crate::chain::model::{Rotation, SprocketModel, Support};
use crate::chain::motion::Motion;
use crate::geometry::{Vec2, turned_left};

/// Resultant load of the chain on a sprocket.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SprocketLoad {
    /// Force \[N\].
    pub force: Vec2,
    /// Moment about the sprocket's centre \[N m\].
    pub moment: f64,
}

/// Centre \[m\], velocity of the centre \[m/s\], angle \[rad\] and angular speed \[rad/s\] of a sprocket.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SprocketKinematics {
    pub(crate) center: Vec2,
    pub(crate) velocity: Vec2,
    pub(crate) angle: f64,
    pub(crate) spin: f64,
}

impl SprocketKinematics {
    /// Return the motion of a body.
    pub(crate) fn of(motion: &Motion, body: usize) -> Self {
        Self {
            center: Vec2::new(motion.x[body], motion.y[body]),
            velocity: Vec2::new(motion.vx[body], motion.vy[body]),
            angle: motion.angle[body],
            spin: motion.spin[body],
        }
    }
}

/// Return the acceleration of a sprocket's centre \[m/s²\] and of its angle \[rad/s²\], for a pawl at `pawl` and time `t` \[s\].
pub(crate) fn sprocket_acceleration(
    sprocket: &SprocketModel,
    gravity: Vec2,
    moves: &SprocketKinematics,
    chain: &SprocketLoad,
    pawl: f64,
    t: f64,
) -> (Vec2, f64) {
    let center = match sprocket.support {
        Support::Fixed => Vec2::zeros(),
        Support::Slide { guide, .. } => {
            let (s, tangent) = sprocket.slide_at(moves.center).unwrap_or_default();
            let speed = moves.velocity.dot(&tangent);
            // (m + m_arm) s'' = (F + m g) · t + pull - d s' + spring and stops; acceleration s'' t + κ s'² n on a path of curvature κ.
            let along = chain.force.dot(&tangent) + sprocket.pull(t) - guide.dashpot(speed) * speed
                + guide.force(s, pawl);
            let mass = sprocket.mass + guide.extra_mass;
            let weight = gravity.dot(&tangent) * (sprocket.mass / mass);
            let bend = guide.curvature * speed * speed;
            (along / mass + weight) * tangent + bend * turned_left(tangent)
        }
        Support::Floating { .. } => chain.force / sprocket.mass + gravity,
    };
    let angle = match &sprocket.rotation {
        Rotation::Prescribed(speed) => speed.slope(t),
        Rotation::Free { .. } => {
            let held = sprocket.swing.map_or(0.0, |swing| {
                swing.force(moves.angle - sprocket.phase, pawl)
                    - swing.dashpot(moves.spin) * moves.spin
            });
            (chain.moment + sprocket.applied_torque(t, moves.spin) + held) / sprocket.inertia
        }
    };
    (center, angle)
}

/// Return the power dissipated in a sprocket's dashpots, and the external power of its motor, applied torque and tensioner \[W\]. `speeds`
/// are the rates of all coordinates, and `prescribed` is the angular velocity where it is prescribed.
///
/// A sprocket with prescribed speed is a support: its own kinetic energy is not part of the balance. Its external work is here the work of
/// its teeth on the chain; reports add the change of that energy.
pub(crate) fn outside_powers(
    sprocket: &SprocketModel,
    chain: &SprocketLoad,
    (speeds, prescribed): (&[f64], f64),
    t: f64,
) -> [f64; 2] {
    let mut dissipated = 0.0;
    let mut external = match &sprocket.rotation {
        Rotation::Prescribed(_) => -chain.moment * prescribed,
        Rotation::Free { index, .. } => {
            let spin = speeds[*index];
            if let Some(swing) = sprocket.swing {
                dissipated += swing.dashpot(spin) * spin * spin;
            }
            sprocket.applied_torque(t, spin) * spin
        }
    };
    if let Support::Slide { index, guide, .. } = sprocket.support {
        // Along the path of the slide.
        let speed = speeds[index];
        external += sprocket.pull(t) * speed;
        dissipated += guide.dashpot(speed) * speed * speed;
    }
    [dissipated, external]
}

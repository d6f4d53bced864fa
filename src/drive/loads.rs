//! Bounds of what a chain may be loaded by: far above what breaks any, they refuse a slip of units before a run crawls under it.

use super::{ChainEnd, Drive, Motion, Mount};
use crate::error::{Error, Result};

/// Largest force on a chain over the square of its pitch \[Pa\]. Roller chains of ISO 606 break at 1e8 Pa; under a hundred times
/// that a default run needs some 1e6 steps per simulated second, under ten thousand times 1e8.
const MOST_PRESSURE: f64 = 1e10;

impl Drive {
    /// Refuses pretension, torques, plungers' forces and weights that no chain of this pitch could bear.
    pub(super) fn check_loads(&self) -> Result<()> {
        let pitch = self.chain.pitch;
        let most = MOST_PRESSURE * pitch * pitch * f64::from(self.chain.strands);
        let refuse = |field: String, value: f64, most: f64, unit: &str| {
            if value.abs() <= most {
                return Ok(());
            }
            let expected = format!(
                "expected at most {most:.1e} {unit}, about 100 times what breaks a chain of {:.4} mm pitch; check the unit",
                1e3 * pitch
            );
            Err(Error::invalid(field, value, expected))
        };
        if let Some(tensioner) = &self.tensioner {
            let field = "Tensioner.pretension".to_string();
            refuse(field, tensioner.pretension, most, "N")?;
        }
        for (i, sprocket) in self.sprockets.iter().enumerate() {
            let radius = f64::from(sprocket.teeth) * pitch / std::f64::consts::TAU;
            let torque = match &sprocket.motion {
                Motion::AppliedTorque(torque) => torque.largest(),
                Motion::TorqueCurve { torque, curve } => torque.largest().max(curve.largest()),
                Motion::PrescribedSpeed(_) | Motion::Free => continue,
            };
            let field = format!("ChainDrive.sprockets[{i}].motion.torque");
            refuse(field, torque, most * radius, "N m")?;
        }
        for (i, guide) in self.guides.iter().enumerate() {
            if let Mount::Arm(arm) = &guide.mount {
                refuse(
                    format!("ChainDrive.guides[{i}].mount.force"),
                    arm.force,
                    most,
                    "N",
                )?;
            }
        }
        let [inner, outer] = [0, 1].map(|i| self.chain.strand_link(i).mass);
        let chain = f64::from(self.chain.links) * inner.max(outer);
        let loads = self.ends.iter().flatten().map(|end| match end {
            ChainEnd::Load { mass, .. } => *mass,
            _ => 0.0,
        });
        let heaviest = loads.fold(chain, f64::max);
        let gravity = self.gravity.norm();
        refuse(
            "ChainDrive.gravity".to_string(),
            gravity,
            most / heaviest,
            "m/s^2",
        )
    }
}

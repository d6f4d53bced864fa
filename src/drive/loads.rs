//! Bounds of loads and speeds, far above the breaking load of any chain: they find errors of units before a run becomes
//! slow by them.

use serde::{Deserialize, Serialize};

use super::{Chain, ChainEnd, Drive, Mount, SprocketMotion};
use crate::error::{Error, Result, check};
use crate::geometry::path::wrap::pitch_radius;
use crate::math::Signal;

/// Largest force on a chain over the square of its pitch \[Pa\]. Roller chains of ISO 606 break at 1e8 Pa. With a hundred times that
/// a default run needs some 1e6 steps per simulated second, with ten thousand times 1e8.
const MOST_PRESSURE: f64 = 1e10;

/// Largest speed of a chain \[m/s\]. Roller chains run below 40 m/s. At 1000 m/s the centrifugal tension,
/// mass per length times the square of the speed, is some 40 times the breaking load.
pub(crate) const MOST_CHAIN_SPEED: f64 = 1e3;

/// Quantity that a run can set: of a sprocket, or of a driver or torque of a mechanism.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum InputQuantity {
    /// Prescribed speed \[rad/s\]; \[m/s\] of a driver along a line.
    Speed,
    /// Torque as a function of time \[N m\]; a curve over the speed remains unchanged.
    Torque,
    /// Constant force of the tensioner on the sprocket's centre along its direction \[N\]; its ramp has then ended.
    TensionerForce,
}

/// Largest speed, torque and tensioner force of a sprocket, in a description and in a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InputBounds {
    /// Pitch of the chain \[m\].
    pitch: f64,
    /// Largest speed \[rad/s\].
    speed: f64,
    /// Largest torque \[N m\].
    torque: f64,
    /// Largest force of a tensioner \[N\].
    force: f64,
}

impl InputBounds {
    /// Return the bounds of a sprocket with this number of teeth.
    pub(crate) fn of(chain: &Chain, teeth: u32) -> Self {
        let radius = pitch_radius(chain.pitch, teeth);
        Self {
            pitch: chain.pitch,
            speed: MOST_CHAIN_SPEED / radius,
            torque: most_force(chain) * radius,
            force: most_force(chain),
        }
    }

    /// Check a speed against the bound; `field` is its name in messages.
    pub(crate) fn check_speed(&self, field: &str, speed: f64) -> Result<()> {
        if speed.abs() <= self.speed {
            return Ok(());
        }
        let expected = format!(
            "expected at most {:.1e} rad/s, a chain speed of {MOST_CHAIN_SPEED} m/s where real chains run below 40 m/s; check the \
             unit",
            self.speed
        );
        Err(Error::invalid(field, speed, expected))
    }

    /// Check a torque against the bound; `field` is its name in messages.
    pub(crate) fn check_torque(&self, field: &str, torque: f64) -> Result<()> {
        refuse_above(self.torque, self.pitch, "N m", field, torque)
    }

    /// Check `signal` as a new speed or torque of the sprocket `name` during a run. `driven`: its speed is prescribed.
    pub(crate) fn check_input(
        &self,
        name: &str,
        driven: bool,
        quantity: InputQuantity,
        signal: &Signal,
    ) -> Result<()> {
        match (quantity, driven) {
            (InputQuantity::Speed, true) => {
                self.check_speed(&format!("speed of {name}"), signal.largest())
            }
            (InputQuantity::Torque, false) => {
                self.check_torque(&format!("torque of {name}"), signal.largest())
            }
            (InputQuantity::TensionerForce, _) => {
                let force = signal.range()[0];
                check::not_negative("force", force, "N")?;
                let (pitch, most) = (self.pitch, self.force);
                refuse_above(most, pitch, "N", "force of the tensioner", signal.largest())
            }
            (InputQuantity::Torque, true) => Err(Error::invalid(
                "sprocket",
                name,
                "turns at a prescribed speed: describe it with AppliedTorque or Free to set its torque",
            )),
            (InputQuantity::Speed, false) => Err(Error::invalid(
                "sprocket",
                name,
                "has a speed that follows from torque and chain: describe it with PrescribedSpeed to set its speed",
            )),
        }
    }
}

/// Return the force \[N\] that `signal` sets on the tensioner of the sprocket `name`.
///
/// # Errors
/// If the sprocket has none, or the force is a function of time.
pub(crate) fn tensioner_force(name: &str, has_tensioner: bool, signal: &Signal) -> Result<f64> {
    if !has_tensioner {
        let expected = "has no tensioner: describe one with ChainDrive.tensioner to set its force";
        return Err(Error::invalid("sprocket", name, expected));
    }
    let Signal::Constant(force) = *signal else {
        let expected = "must be a number in N; set it again at each time at which it changes";
        return Err(Error::invalid("force", "function of time", expected));
    };
    Ok(force)
}

/// Return sprocket `number` (from 0) of all sprockets of a drive, for an input.
///
/// # Errors
/// If there is no such sprocket.
pub(crate) fn sprocket_of<T>(sprockets: &[T], number: usize) -> Result<&T> {
    sprockets.get(number).ok_or_else(|| {
        let last = sprockets.len();
        let expected =
            format!("is not a sprocket of this drive; expected sprocket_1 to sprocket_{last}");
        let name = format!("sprocket_{}", number.saturating_add(1));
        Error::invalid("sprocket", name, expected)
    })
}

/// Return the largest force on a chain \[N\].
fn most_force(chain: &Chain) -> f64 {
    MOST_PRESSURE * chain.pitch * chain.pitch * f64::from(chain.strands)
}

fn refuse_above(most: f64, pitch: f64, unit: &str, field: &str, value: f64) -> Result<()> {
    if value.abs() <= most {
        return Ok(());
    }
    let expected = format!(
        "expected at most {most:.1e} {unit}, about 100 times what breaks a chain of {:.4} mm pitch; check the unit",
        1e3 * pitch
    );
    Err(Error::invalid(field, value, expected))
}

impl Drive {
    /// Check pretension, torques, plunger forces, weights and speeds against the bounds for a chain of this pitch.
    pub(super) fn check_loads(&self) -> Result<()> {
        let pitch = self.chain.pitch;
        let most = most_force(&self.chain);
        if let Some(tensioner) = &self.tensioner {
            let pretension = tensioner.pretension;
            refuse_above(most, pitch, "N", "Tensioner.pretension", pretension)?;
        }
        self.check_motions()?;
        for (i, guide) in self.guides.iter().enumerate() {
            if let Mount::Arm(arm) = &guide.mount {
                let field = format!("ChainDrive.guides.{}.arm.force", i + 1);
                refuse_above(most, pitch, "N", &field, arm.force)?;
            }
        }
        self.check_end_speeds()?;
        self.check_weights()
    }

    fn check_motions(&self) -> Result<()> {
        for (i, sprocket) in self.sprockets.iter().enumerate() {
            let bounds = InputBounds::of(&self.chain, sprocket.teeth);
            let motion =
                |quantity: &str| format!("ChainDrive.sprockets.{}.motion.{quantity}", i + 1);
            match &sprocket.motion {
                SprocketMotion::PrescribedSpeed(speed) => {
                    bounds.check_speed(&motion("speed"), speed.largest())?;
                }
                SprocketMotion::AppliedTorque(torque) => {
                    bounds.check_torque(&motion("torque"), torque.largest())?;
                }
                SprocketMotion::TorqueCurve { torque, curve } => {
                    bounds.check_torque(&motion("torque"), torque.largest())?;
                    bounds.check_torque(&motion("curve (torque)"), curve.largest())?;
                    bounds.check_speed(&motion("curve (speed)"), curve.farthest())?;
                }
                SprocketMotion::Free => {}
            }
            if let Some(speed) = sprocket.initial_speed {
                let field = format!("ChainDrive.sprockets.{}.initial_speed", i + 1);
                bounds.check_speed(&field, speed)?;
            }
        }
        Ok(())
    }

    fn check_end_speeds(&self) -> Result<()> {
        for (i, end) in self.ends.iter().flatten().enumerate() {
            let ChainEnd::Anchored { velocity, .. } = end else {
                continue;
            };
            let speed = velocity.iter().map(Signal::largest).fold(0.0, f64::max);
            if speed > MOST_CHAIN_SPEED {
                let expected = format!(
                    "expected at most {MOST_CHAIN_SPEED} m/s where real chains run below 40 m/s; check the unit"
                );
                let field = format!("ChainDrive.ends.{}.velocity", i + 1);
                return Err(Error::invalid(field, speed, expected));
            }
        }
        Ok(())
    }

    /// Check gravity by the weight of the chain, of attached masses and of loaded ends.
    fn check_weights(&self) -> Result<()> {
        let Chain {
            pitch,
            inner,
            outer,
            carried,
            ..
        } = &self.chain;
        let most = most_force(&self.chain);
        let gravity = self.gravity.norm();
        let links = f64::from(self.chain.links) * f64::from(self.chain.strands);
        let own = links * inner.mass.max(outer.mass);
        refuse_above(most / own, *pitch, "m/s^2", "ChainDrive.gravity", gravity)?;
        let heaviest = most / gravity;
        let unit = format!("kg under {gravity:.4} m/s^2");
        let together = carried.iter().map(|(_, mass)| mass).sum();
        refuse_above(
            heaviest,
            *pitch,
            &unit,
            "Chain.carried (sum of masses)",
            together,
        )?;
        for (i, end) in self.ends.iter().flatten().enumerate() {
            if let ChainEnd::Loaded { mass, .. } = end {
                let field = format!("ChainDrive.ends.{}.mass", i + 1);
                refuse_above(heaviest, *pitch, &unit, &field, *mass)?;
            }
        }
        Ok(())
    }
}

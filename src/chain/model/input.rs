//! Speed and torque inputs that replace those of the description during a run.

use serde::{Deserialize, Serialize};

use super::{Model, Rotation};
use crate::error::{Error, Result};
use crate::math::Signal;

/// Input quantity of a sprocket.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Quantity {
    /// Prescribed speed \[rad/s\].
    Speed,
    /// Torque as a function of time \[N m\]; a curve over the speed remains unchanged.
    Torque,
}

/// Input of one sprocket from a given time on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Input {
    sprocket: usize,
    quantity: Quantity,
    signal: Signal,
    /// Angle at time zero for which the angle is continuous at the time of the input \[rad\]; used for prescribed speeds.
    phase: f64,
}

impl Input {
    /// Return the number of the sprocket, from 0.
    #[must_use]
    pub fn sprocket(&self) -> usize {
        self.sprocket
    }
}

impl Model {
    /// Return the input that changes the speed or torque of `sprocket` (from 0) from `t` \[s\] on; its angle is continuous.
    ///
    /// `None`: the sprocket already has this input.
    ///
    /// # Errors
    /// When there is no such sprocket, its motion has no such quantity, or `signal` exceeds the bounds of a drive.
    pub fn input(
        &self,
        sprocket: usize,
        quantity: Quantity,
        signal: Signal,
        t: f64,
    ) -> Result<Option<Input>> {
        let name = format!("sprocket_{}", sprocket + 1);
        let toothed = &self.sprockets[..self.toothed()];
        let Some(found) = toothed.get(sprocket) else {
            let last = toothed.len();
            let expected =
                format!("is no sprocket of this drive: take sprocket_1 to sprocket_{last}");
            return Err(Error::invalid("sprocket", name, expected));
        };
        let phase = match (&found.rotation, quantity) {
            (Rotation::Prescribed(speed), Quantity::Speed) => {
                if *speed == signal {
                    return Ok(None);
                }
                found.phase + speed.integral(t) - signal.integral(t)
            }
            (Rotation::Free { torque, .. }, Quantity::Torque) => {
                let same = match torque {
                    Some(torque) => *torque == signal,
                    None => signal.is_zero(),
                };
                if same {
                    return Ok(None);
                }
                found.phase
            }
            (Rotation::Prescribed(_), Quantity::Torque) => {
                let expected = "turns at a prescribed speed: describe it with AppliedTorque or Free to set its torque";
                return Err(Error::invalid("sprocket", name, expected));
            }
            (Rotation::Free { .. }, Quantity::Speed) => {
                let expected = "turns as torque and chain make it: describe it with PrescribedSpeed to set its speed";
                return Err(Error::invalid("sprocket", name, expected));
            }
        };
        if let Some(bounds) = &found.input_bounds {
            match quantity {
                Quantity::Speed => {
                    bounds.check_speed(&format!("speed of {name}"), signal.largest())?;
                }
                Quantity::Torque => {
                    bounds.check_torque(&format!("torque of {name}"), signal.largest())?;
                }
            }
        }
        Ok(Some(Input {
            sprocket,
            quantity,
            signal,
            phase,
        }))
    }

    /// Return the model with `inputs` instead of its compiled ones; `None` for inputs of another model.
    #[must_use]
    pub fn with_inputs(&self, inputs: &[Input]) -> Option<Self> {
        let mut model = self.clone();
        for input in inputs {
            let sprocket = model.sprockets.get_mut(input.sprocket)?;
            match (&mut sprocket.rotation, input.quantity) {
                (Rotation::Prescribed(speed), Quantity::Speed) => {
                    speed.clone_from(&input.signal);
                    sprocket.phase = input.phase;
                }
                (Rotation::Free { torque, .. }, Quantity::Torque) => {
                    *torque = (!input.signal.is_zero()).then(|| input.signal.clone());
                }
                _ => return None,
            }
        }
        Some(model)
    }
}

//! Speed and torque inputs that replace those of the description during a run.

use serde::{Deserialize, Serialize};

use super::{Model, Rotation};
use crate::drive::{InputQuantity, sprocket_of};
use crate::error::Result;
use crate::math::Signal;

/// Input of one sprocket from a given time on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Input {
    sprocket: usize,
    quantity: InputQuantity,
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
        quantity: InputQuantity,
        signal: Signal,
        t: f64,
    ) -> Result<Option<Input>> {
        let found = sprocket_of(&self.sprockets[..self.toothed()], sprocket)?;
        if let Some(bounds) = &found.input_bounds {
            let driven = matches!(found.rotation, Rotation::Prescribed(_));
            let name = format!("sprocket_{}", sprocket + 1);
            bounds.check_input(&name, driven, quantity, &signal)?;
        }
        let (same, phase) = match &found.rotation {
            Rotation::Prescribed(speed) => {
                let phase = found.phase + speed.integral(t) - signal.integral(t);
                (*speed == signal, phase)
            }
            Rotation::Free { torque, .. } => {
                let same = match torque {
                    Some(torque) => *torque == signal,
                    None => signal.is_zero(),
                };
                (same, found.phase)
            }
        };
        if same {
            return Ok(None);
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
                (Rotation::Prescribed(speed), InputQuantity::Speed) => {
                    speed.clone_from(&input.signal);
                    sprocket.phase = input.phase;
                }
                (Rotation::Free { torque, .. }, InputQuantity::Torque) => {
                    *torque = (!input.signal.is_zero()).then(|| input.signal.clone());
                }
                _ => return None,
            }
        }
        Some(model)
    }
}

//! Inputs of speed, torque and tensioner force that replace those of the description during a run.

use serde::{Deserialize, Serialize};

use super::Model;
use super::sprocket::{Rotation, SprocketModel, Support};
use crate::drive::{InputQuantity, sprocket_of, tensioner_force};
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
    /// Return whether this input sets the same quantity of the same sprocket as `other`.
    pub(crate) fn replaces(&self, other: &Self) -> bool {
        (self.sprocket, self.quantity) == (other.sprocket, other.quantity)
    }
}

impl SprocketModel {
    /// Return the value of an input quantity at `t` \[s\], of the tensioner's force that after its ramp; `None` if the sprocket does not
    /// have the quantity.
    fn input_value(&self, quantity: InputQuantity, t: f64) -> Option<f64> {
        match (quantity, &self.rotation, &self.support) {
            (InputQuantity::Speed, Rotation::Prescribed(speed), _) => Some(speed.value(t)),
            (InputQuantity::Torque, Rotation::Free { torque, .. }, _) => {
                Some(torque.as_ref().map_or(0.0, |torque| torque.value(t)))
            }
            (InputQuantity::TensionerForce, _, Support::Slide { pull, .. }) => Some(*pull),
            _ => None,
        }
    }

    /// Return whether the tensioner of the sprocket called `name` already has the constant `force` at `t` \[s\], behind its ramp.
    fn has_force(&self, name: &str, force: &Signal, t: f64) -> Result<bool> {
        let present = match self.support {
            Support::Slide {
                pull, ramp_time, ..
            } => Some((pull, ramp_time)),
            _ => None,
        };
        let force = tensioner_force(name, present.is_some(), force)?;
        Ok(present.is_some_and(|(pull, ramp_time)| t >= ramp_time && force == pull))
    }
}

impl Model {
    /// Return the value of an input quantity of `sprocket` (from 0) at `t` \[s\], of the tensioner's force that after its ramp; `None` if
    /// there is no such quantity.
    #[must_use]
    pub fn input_value(&self, sprocket: usize, quantity: InputQuantity, t: f64) -> Option<f64> {
        let toothed = &self.sprockets[..self.toothed()];
        toothed.get(sprocket)?.input_value(quantity, t)
    }

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
        let name = format!("sprocket_{}", sprocket + 1);
        if let Some(bounds) = &found.input_bounds {
            let driven = matches!(found.rotation, Rotation::Prescribed(_));
            bounds.check_input(&name, driven, quantity, &signal)?;
        }
        let (same, phase) = match &found.rotation {
            _ if quantity == InputQuantity::TensionerForce => {
                (found.has_force(&name, &signal, t)?, found.phase)
            }
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
            if input.quantity == InputQuantity::TensionerForce {
                let Support::Slide {
                    pull, ramp_time, ..
                } = &mut sprocket.support
                else {
                    return None;
                };
                (*pull, *ramp_time) = (input.signal.value(0.0), 0.0);
                continue;
            }
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

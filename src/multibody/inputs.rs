//! Inputs of a mechanism during a run: the speed of a driver or an applied torque, set at a time inside the integrator's last step.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::constraints::equation::Equation;
use super::description::driver::PrescribedMotion;
use super::description::force_element::{Force, ForceKind};
use super::description::joint::Joint;
use super::model::MechanismModel;
use crate::drive::InputQuantity;
use crate::error::{Error, Result, listed};
use crate::math::Signal;

/// Speed of a driver or torque of a force element that replaces the one described.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) enum MechanismInput {
    /// Speed of a driver.
    Speed {
        equation: usize,
        signal: Signal,
        /// Offset of the equation for which its coordinate is continuous at the time of the input.
        offset: f64,
    },
    /// Torque of a force element.
    Torque { force: usize, signal: Signal },
}

impl MechanismInput {
    /// Return the equation or the force element that the input replaces a part of.
    pub(super) fn target(&self) -> (InputQuantity, usize) {
        match self {
            Self::Speed { equation, .. } => (InputQuantity::Speed, *equation),
            Self::Torque { force, .. } => (InputQuantity::Torque, *force),
        }
    }
}

/// Compiled model, and the inputs set since the start of the run.
#[derive(Debug, Clone)]
pub(super) struct MechanismInputs {
    pub(super) compiled: Arc<MechanismModel>,
    /// At most one input for each driver and each torque.
    pub(super) set: Vec<MechanismInput>,
}

impl MechanismInputs {
    pub(super) fn new(compiled: &Arc<MechanismModel>) -> Self {
        Self {
            compiled: Arc::clone(compiled),
            set: Vec::new(),
        }
    }
}

impl MechanismModel {
    /// Return the input of the driver or torque `name` from `t` \[s\] on; `None`: it already has this input.
    pub(super) fn input(
        &self,
        name: &str,
        quantity: InputQuantity,
        signal: Signal,
        t: f64,
    ) -> Result<Option<MechanismInput>> {
        match quantity {
            InputQuantity::Speed => {
                signal.validate(&format!("speed of {name:?}"))?;
                let (equation, present, offset) = self.driver(name)?;
                let offset = offset + present.integral(t) - signal.integral(t);
                Ok((*present != signal).then_some(MechanismInput::Speed {
                    equation,
                    signal,
                    offset,
                }))
            }
            InputQuantity::Torque => {
                signal.validate(&format!("torque of {name:?}"))?;
                let (force, present) = self.torque(name)?;
                Ok((*present != signal).then_some(MechanismInput::Torque { force, signal }))
            }
            InputQuantity::TensionerForce => {
                let expected = "must be of a drive: a mechanism has none";
                Err(Error::invalid("force of the tensioner", name, expected))
            }
        }
    }

    /// Return the driver `name`: the number of its equation, its speed and its offset.
    fn driver(&self, name: &str) -> Result<(usize, &Signal, f64)> {
        let driver = |joint: usize| {
            let equation = self.equations_of_joint[joint].start;
            let Equation { motion, offset, .. } = &self.equations[equation];
            motion.as_ref().map(|motion| (equation, motion, *offset))
        };
        let Some(joint) = self.joints.iter().position(|joint| joint.name == name) else {
            let drivers = self.joints.iter().enumerate();
            let drivers = drivers.filter(|(number, _)| driver(*number).is_some());
            let known = drivers.map(|(_, Joint { name, .. })| name.as_str());
            return Err(unknown("driver", name, known));
        };
        match driver(joint) {
            Some((equation, PrescribedMotion::Speed(speed), offset)) => {
                Ok((equation, speed, offset))
            }
            Some((_, PrescribedMotion::Position(_), _)) => Err(Error::invalid(
                "driver",
                format!("{name:?}"),
                "prescribes a coordinate: describe it with speed=... to set its speed",
            )),
            None => Err(Error::invalid(
                "driver",
                format!("{name:?}"),
                "is a joint without prescribed motion: describe a driver with speed=... to set its speed",
            )),
        }
    }

    /// Return the number of the force element `name` and its torque.
    fn torque(&self, name: &str) -> Result<(usize, &Signal)> {
        let torque = |force: &Force| matches!(force.kind, ForceKind::Torque(_));
        let Some(number) = self.forces.iter().position(|force| force.name == name) else {
            let torques = self.forces.iter().filter(|&force| torque(force));
            let known = torques.map(|force| force.name.as_str());
            return Err(unknown("torque", name, known));
        };
        match &self.forces[number].kind {
            ForceKind::Torque(signal) => Ok((number, signal)),
            _ => Err(Error::invalid(
                "torque",
                format!("{name:?}"),
                "is another kind of force element: describe it with add_torque(..., torque=...) to set its torque",
            )),
        }
    }

    /// Exchange the part of the model that `input` replaces with that of `input`; `None` for an input of another model.
    pub(super) fn exchange(&mut self, input: &mut MechanismInput) -> Option<()> {
        match input {
            MechanismInput::Speed {
                equation,
                signal,
                offset,
            } => {
                let equation = self.equations.get_mut(*equation)?;
                let Some(PrescribedMotion::Speed(present)) = &mut equation.motion else {
                    return None;
                };
                std::mem::swap(present, signal);
                std::mem::swap(&mut equation.offset, offset);
            }
            MechanismInput::Torque { force, signal } => {
                let ForceKind::Torque(present) = &mut self.forces.get_mut(*force)?.kind else {
                    return None;
                };
                std::mem::swap(present, signal);
            }
        }
        Some(())
    }

    /// Return the kinetic energy at positions and velocities (q, then v) \[J\].
    pub(super) fn kinetic_energy(&self, state: &[f64]) -> f64 {
        let velocities = &state[self.coordinates()..];
        let energies = self.mass.iter().zip(velocities).map(|(m, v)| m * v * v);
        0.5 * energies.sum::<f64>()
    }
}

/// Return the error for a name that no driver or torque has.
fn unknown<'a>(kind: &str, name: &str, known: impl Iterator<Item = &'a str>) -> Error {
    let known = listed(known);
    let expected = if known.is_empty() {
        format!("the mechanism has no {kind}")
    } else {
        format!("is no {kind} of this mechanism; there are {known}")
    };
    Error::invalid(kind, format!("{name:?}"), expected)
}

//! Revolute joint with friction: its friction torque at given reactions.

use super::equation::Equation;
use crate::force_law::Friction;
use crate::multibody::description::body::Frame;
use crate::multibody::description::tribology::PinFriction;

/// A revolute joint with friction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pin {
    pub(crate) joint: usize,
    /// Number of the first of the two equations of the joint.
    pub(crate) row: usize,
    pub(super) bodies: [usize; 2],
    radius: f64,
    law: Friction,
}

/// Torque of a pin on body b, and its derivatives.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PinTorque {
    pub(crate) value: f64,
    /// Derivative with respect to the angular velocity of b relative to a \[N m s\].
    pub(crate) by_spin: f64,
    /// Derivatives with respect to the two multipliers \[m\].
    pub(crate) by_multiplier: [f64; 2],
}

/// Friction of all pins at the last evaluation.
#[derive(Debug, Clone, Default)]
pub(crate) struct PinTorques {
    /// Torque of each pin on its body b \[N m\].
    pub(crate) values: Vec<f64>,
    /// Loads on the free coordinates, with these torques.
    pub(crate) loads: Vec<f64>,
    /// Whether the last iteration with finite values did not converge.
    pub(crate) locked: bool,
}

impl PinTorques {
    /// Return zero torques of `pins` pins.
    pub(crate) fn new(pins: usize, coordinates: usize) -> Self {
        Self {
            values: vec![0.0; pins],
            loads: vec![0.0; if pins > 0 { coordinates } else { 0 }],
            locked: false,
        }
    }
}

impl Pin {
    /// Return the pin of a revolute joint, whose two equations begin at `row`.
    pub(crate) fn new(
        joint: usize,
        friction: PinFriction,
        row: usize,
        equations: &[Equation],
    ) -> Self {
        Self {
            joint,
            row,
            bodies: [equations[row].a.body, equations[row].b.body],
            radius: friction.radius,
            law: friction.law,
        }
    }

    /// Return the angular velocity of b relative to a \[rad/s\].
    pub(super) fn spin(&self, frames: &[Frame]) -> f64 {
        frames[self.bodies[1]].spin - frames[self.bodies[0]].spin
    }

    /// Return the torque at given multipliers, with its derivatives.
    pub(crate) fn torque(&self, frames: &[Frame], multipliers: &[f64]) -> PinTorque {
        let [x, y] = [multipliers[self.row], multipliers[self.row + 1]];
        // τ = -μ r |λ| h(r ω); the two multipliers of a revolute joint are the components of its reaction.
        let force = (x * x + y * y).sqrt();
        let (share, slope) = self.law.share(self.radius * self.spin(frames));
        let arm = self.law.coefficient * self.radius;
        let by_force = -arm * share;
        let along = if force > 0.0 { by_force / force } else { 0.0 };
        PinTorque {
            value: by_force * force,
            by_spin: -arm * force * slope * self.radius,
            by_multiplier: [along * x, along * y],
        }
    }
}

//! Friction torque in the pins of ideal revolute joints: τ = -μ r |R| h(r ω) on body b, R being the joint's reaction.
//!
//! The reaction depends on the torque through the equations of motion, which are linear in the torque. Both are found by a
//! fixed-point iteration over right-hand sides with the available factors of the constraints. The iteration starts from zero torque,
//! so an evaluation depends on its state alone. Its contraction constant is about μ r over the distance to the next joint. Where this
//! exceeds one, the pin is self-locking under any load, and no solution exists.

use super::constraint_state::ConstraintState;
use super::equation::Equation;
use crate::force_law::Friction;
use crate::multibody::description::body::Frame;
use crate::multibody::description::tribology::PinFriction;
use crate::multibody::model::MechanismModel;

/// Convergence tolerance: change of the torques in the last iteration over the largest torque. It is a few units of round-off, as the
/// error test of the integrator takes differences of the accelerations.
const CONVERGED: f64 = 1e-14;

/// Number of iterations after which a pin counts as locked. It suffices for a contraction constant of 0.7; twice as many would for
/// 0.84.
const MOST_ITERATIONS: usize = 90;

/// A revolute joint with friction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pin {
    pub(crate) joint: usize,
    /// Number of the first of the two equations of the joint.
    pub(crate) row: usize,
    bodies: [usize; 2],
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
    fn spin(&self, frames: &[Frame]) -> f64 {
        frames[self.bodies[1]].spin - frames[self.bodies[0]].spin
    }

    /// Return the torque at given multipliers, with its derivatives.
    pub(crate) fn torque(&self, frames: &[Frame], multipliers: &[f64]) -> PinTorque {
        let [x, y] = [multipliers[self.row], multipliers[self.row + 1]];
        // τ = -μ r |λ| h(r ω); the two multipliers of a revolute joint are the components of its reaction.
        let force = x.hypot(y);
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

impl ConstraintState {
    /// Solve for accelerations and multipliers with the available factors and the loads on the free coordinates, with the friction of
    /// pins. Return false when a pin is self-locking or values are not finite.
    pub(crate) fn solve(
        &mut self,
        model: &MechanismModel,
        frames: &[Frame],
        loads: &[f64],
        accelerations: &mut [f64],
    ) -> bool {
        let Some(kkt) = &mut self.kkt else {
            return false;
        };
        let (pins, multipliers) = (&model.pins, &mut self.multipliers);
        if pins.is_empty() {
            kkt.solve(loads, &self.rows, accelerations, multipliers);
            return true;
        }
        let torques = &mut self.pin_torques;
        // Fixed-point iteration: solve with the present torques, then update these from the multipliers.
        torques.values.fill(0.0);
        for _ in 0..MOST_ITERATIONS {
            torques.loads.copy_from_slice(loads);
            for (pin, torque) in pins.iter().zip(&torques.values) {
                for (body, sign) in pin.bodies.iter().zip([-1.0, 1.0]) {
                    if let Some(first) = model.first[*body] {
                        torques.loads[first + 2] += sign * torque;
                    }
                }
            }
            kkt.solve(&torques.loads, &self.rows, accelerations, multipliers);
            let (mut change, mut largest, mut finite) = (0.0, 0.0, true);
            for (pin, torque) in pins.iter().zip(&mut torques.values) {
                let found = pin.torque(frames, multipliers).value;
                change = f64::max(change, (found - *torque).abs());
                largest = f64::max(largest, found.abs());
                finite &= found.is_finite();
                *torque = found;
            }
            if !finite {
                return false;
            }
            if change <= CONVERGED * largest {
                torques.locked = false;
                return true;
            }
        }
        torques.locked = true;
        false
    }

    /// Return the power dissipated by the friction of pins at the multipliers of the last evaluation \[W\].
    pub(crate) fn pin_losses(&mut self, model: &MechanismModel, frames: &[Frame]) -> f64 {
        let pins = model.pins.iter().zip(&mut self.pin_torques.values);
        let losses = pins.map(|(pin, torque)| {
            *torque = pin.torque(frames, &self.multipliers).value;
            -*torque * pin.spin(frames)
        });
        losses.sum()
    }
}

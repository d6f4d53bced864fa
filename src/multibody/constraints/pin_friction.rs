//! Friction torque in the pins of ideal revolute joints: τ = -μ r |R| h(r ω) on body b, R being the joint's reaction.
//!
//! The reaction depends on the torque through the equations of motion, which are linear in the torque. Both are found by a
//! fixed-point iteration over right-hand sides with the available factors of the constraints. The iteration starts from zero torque,
//! so an evaluation depends on its state alone. Its contraction constant is about μ r over the distance to the next joint. Where this
//! exceeds one, the pin is self-locking under any load, and no solution exists.

use super::constraint_state::ConstraintState;
use crate::multibody::description::body::Frame;
use crate::multibody::model::MechanismModel;

/// Convergence tolerance: change of the torques in the last iteration over the largest torque. It is a few units of round-off, as the
/// error test of the integrator takes differences of the accelerations.
const CONVERGED: f64 = 1e-14;

/// Number of iterations after which a pin counts as locked. It suffices for a contraction constant of 0.7; twice as many would for
/// 0.84.
const MOST_ITERATIONS: usize = 90;

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

//! Speeds and torques set while a drive runs: the integrator goes back to the present time and starts from there.

use std::sync::Arc;

use super::Dynamics;
use crate::chain::model::{Input, Model, Quantity};
use crate::error::Result;
use crate::integrator::Adams;
use crate::math::Signal;

/// A kink nearer than this is not stepped to \[s\].
const SHORTEST_TO_KINK: f64 = 1e-10;

/// The model as it was compiled, and what was set since.
#[derive(Debug, Clone)]
pub(super) struct Inputs {
    pub(super) compiled: Arc<Model>,
    /// Speeds and torques, one a sprocket.
    pub(super) set: Vec<Input>,
    /// Next kink of a speed or torque \[s\], once it is known.
    kink: f64,
}

impl Inputs {
    pub(super) fn new(compiled: &Arc<Model>) -> Self {
        Self {
            compiled: Arc::clone(compiled),
            set: Vec::new(),
            kink: f64::NEG_INFINITY,
        }
    }
}

impl Dynamics {
    /// Lets sprocket `sprocket` (from 0) have another speed or torque from time `t` on, which lies inside the last step of `adams`; false
    /// where it has it already.
    ///
    /// What the integrator had made beyond that time is made anew. Positions do not jump, nor do velocities but that of the
    /// sprocket whose speed is set; contacts keep their memory and the energy balance goes on.
    ///
    /// # Errors
    /// When there is no such sprocket, its motion has no such quantity, or `signal` is beyond what a drive may be described with; the
    /// dynamics are then what they were.
    pub(crate) fn set_input(
        &mut self,
        (sprocket, quantity): (usize, Quantity),
        signal: Signal,
        t: f64,
        adams: &mut Adams,
    ) -> Result<bool> {
        let Some(input) = self.model.input(sprocket, quantity, signal, t)? else {
            return Ok(false);
        };
        let Some(model) = self.model.with_inputs(std::slice::from_ref(&input)) else {
            return Ok(false);
        };
        self.inputs.set.retain(|other| other.sprocket() != sprocket);
        self.inputs.set.push(input);
        let mut y = vec![0.0; adams.y().len()];
        adams.interpolate(t, &mut y);
        self.unbend_open(t, &mut y);
        self.turn_back(Arc::new(model), t, &y);
        adams.restart_with_corrector(t, &y);
        self.inputs.kink = f64::NEG_INFINITY;
        Ok(true)
    }

    /// Time from `t` \[s\] to the next kink of a speed or torque, where steps end.
    pub(super) fn time_to_kink(&mut self, t: f64) -> f64 {
        // A kink that was met but for rounding is behind.
        if self.inputs.kink <= t + SHORTEST_TO_KINK {
            self.inputs.kink = self.model.next_kink(t + SHORTEST_TO_KINK);
        }
        self.inputs.kink - t
    }

    /// At a row of the velocity of an open chain's end, where its acceleration jumps: forgets the history, and puts the end where it
    /// should be. Its path is exact between two rows; what the step that ends there misses would be a velocity for good. A row is met by
    /// the step that ends at it or just before: those that end behind it have it behind them, however short they are.
    pub(super) fn restart_at_kink_of_end(&mut self, adams: &mut Adams) {
        let model = Arc::clone(&self.model);
        let Some(ends) = &model.ends else { return };
        let t = adams.time();
        let row = ends.next_knot(t * (1.0 - 2.0 * f64::EPSILON));
        if row - t > SHORTEST_TO_KINK || t <= 0.0 {
            return;
        }
        let (n, coordinates) = (model.links, model.coordinates);
        let y = &mut self.inside;
        adams.interpolate(t, y);
        for end in &ends.bodies {
            if let Some((place, velocity)) = end.given_motion(row) {
                let i = end.body;
                (y[i], y[n + i]) = (place.x, place.y);
                y[coordinates + i] = velocity.x;
                y[coordinates + n + i] = velocity.y;
            }
        }
        adams.restart_with_corrector(row, &y[..2 * coordinates]);
        let longest = self.longest_step().min(self.time_to_kink(row));
        adams.limit_step(longest);
    }

    /// Puts ends whose acceleration changes where they should be: what steps miss of their paths would add up.
    pub(super) fn place_ends_on_their_curves(&self, adams: &mut Adams) {
        let Some(ends) = &self.model.ends else { return };
        let (n, coordinates) = (self.model.links, self.model.coordinates);
        for end in ends.bodies.iter().filter(|end| end.follows_a_curve()) {
            let Some((place, velocity)) = end.given_motion(adams.time()) else {
                continue;
            };
            let (x, y) = (end.body, n + end.body);
            adams.set_component(x, place.x);
            adams.set_component(y, place.y);
            adams.set_component(coordinates + x, velocity.x);
            adams.set_component(coordinates + y, velocity.y);
        }
    }
}

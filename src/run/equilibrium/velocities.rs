//! Velocities of a start in static equilibrium: motion along the loaded contacts.

use std::sync::Arc;

use super::resting_drive::RestingDrive;
use super::settling::Resting;
use crate::chain::model::Rotation;
use crate::chain::motion::Motion;
use crate::integrator::SecondOrderSystem;
use crate::layout::InitialConfiguration;

/// γ of the adjustment of velocities to the contacts \[s\]: links follow their contacts in less time, shafts in more.
const TRAVEL_GAMMA: f64 = 1e-3;
/// Number of rounds of this adjustment.
const TRAVEL_ROUNDS: u32 = 10;
/// Displacement of the bodies along their velocities for differences of the forces \[m\].
const SMALL_MOVE: f64 = 1e-10;

/// Return the largest component of the velocities of the centres of mass \[m/s\].
fn fastest(velocities: &[[f64; 3]]) -> f64 {
    let components = velocities.iter().flat_map(|[x, y, _]| [x, y]);
    components.fold(0.0, |most: f64, v| most.max(v.abs()))
}

impl RestingDrive {
    /// Change the velocities of a start at these positions until no loaded contact is approached and no link is stretched.
    ///
    /// K is the slope of the forces with all positions and with the motors' angles. The change -(M + γ² K)⁻¹ γ² K v removes from v what the
    /// contacts would remove within γ. The matrix includes the dashpots, so that several rounds are needed. Masses that respond more
    /// slowly, such as a load, keep their speed.
    pub(super) fn move_along_contacts(&mut self, start: &mut InitialConfiguration) {
        for _ in 0..TRAVEL_ROUNDS {
            let fastest = fastest(&start.velocities);
            if fastest == 0.0 || !self.take_out_approaches(start, SMALL_MOVE / fastest) {
                return;
            }
        }
    }

    /// Perform one round, with positions after `moment` \[s\]; return false for a singular matrix, or where ideal hinges do not close.
    fn take_out_approaches(&mut self, start: &mut InitialConfiguration, moment: f64) -> bool {
        let model = Arc::clone(self.dynamics.model());
        let coordinates = model.coordinates;
        let moved: Vec<[f64; 3]> = (start.positions.iter().zip(&start.velocities))
            .map(|(q, v)| [0, 1, 2].map(|i| q[i] + moment * v[i]))
            .collect();
        let mut rates = self.accelerations_at(&moved);
        let here = self.accelerations_at(&start.positions);
        for (rate, here) in rates.iter_mut().zip(here) {
            *rate = (*rate - here) * TRAVEL_GAMMA * TRAVEL_GAMMA / moment;
        }
        // The matrix is assembled from the last evaluation.
        self.unbalanced();
        if !self.dynamics.factorise_indefinite(TRAVEL_GAMMA) {
            return false;
        }
        self.dynamics.correct(&mut rates);
        self.places.set(&start.positions, &start.velocities);
        let mut y = self.y.clone();
        self.places.write(&model, &mut y);
        for (v, change) in y[coordinates..].iter_mut().zip(&rates) {
            *v += change;
        }
        if !self.dynamics.close_ideal_hinges_nearby(&mut y) {
            return false;
        }
        self.places.read(&model, 0.0, &y);
        let before = std::mem::replace(&mut start.velocities, self.places.velocities());
        for (s, sprocket) in model.sprockets.iter().enumerate() {
            if matches!(sprocket.rotation, Rotation::Prescribed(_)) {
                let body = model.wheel_body(s);
                start.velocities[body][2] = before[body][2];
            }
        }
        true
    }

    /// Return the accelerations of all coordinates at these positions, at rest.
    fn accelerations_at(&mut self, positions: &[[f64; 3]]) -> Vec<f64> {
        let model = Arc::clone(self.dynamics.model());
        let coordinates = model.coordinates;
        let still = vec![[0.0; 3]; positions.len()];
        self.dynamics.evaluated.motion.set(positions, &still);
        self.dynamics.evaluate_motion(0.0);
        let found = &self.dynamics.evaluated.accelerations;
        let mut bodies = Motion::new(model.bodies());
        let rates: Vec<[f64; 3]> = (0..model.bodies())
            .map(|i| [found.x[i], found.y[i], found.angle[i]])
            .collect();
        // The same transformation applies to velocities and accelerations of bodies at rest.
        bodies.set(positions, &rates);
        let mut y = vec![0.0; 2 * coordinates];
        bodies.write(&model, &mut y);
        y.split_off(coordinates)
    }
}

//! Whether a mechanism is placed where two ways of going on meet: joints that hold independently beside it do not do so there.

use super::dynamics::MechanismDynamics;
use super::projection::AtHand;

/// Independence of the constraints below which the start is looked at.
const NEAR: f64 = 1e-6;
/// How far beside the start it is looked, in radians and parts of the size.
const BESIDE: f64 = 0.01;
/// Independence there, over that at the start, that tells the one from the other.
const MORE: f64 = 100.0;
const ITERATIONS: usize = 40;
const TRIALS: usize = 3;

impl MechanismDynamics {
    /// Whether the start in `state`, which was just evaluated, is such a place, and no velocity was given to choose a way.
    pub(super) fn starts_between_branches(&mut self, state: &[f64]) -> bool {
        let Some(kkt) = &self.kkt else {
            return false;
        };
        let (rank, independence) = (kkt.rank(), kkt.independence());
        let given = (self.model.bodies.iter()).any(|body| body.velocity != [0.0; 3]);
        if given || (rank == self.rows.len() && independence > NEAR) {
            return false;
        }
        // Drivers go on, too.
        let rates = self.rows.iter().map(|row| row.time_rate.abs());
        let fastest = rates.fold(0.0, f64::max);
        let delay = if fastest > 0.0 { BESIDE / fastest } else { 0.0 };
        let (n, size) = (self.model.coordinates(), self.size());
        let near = std::mem::replace(&mut self.near_singular, 0.0);
        let mut place = vec![0.0; state.len()];
        let found = (1..=TRIALS).any(|trial| {
            place.copy_from_slice(state);
            for (i, q) in place[..n].iter_mut().enumerate() {
                let unit = if i % 3 == 2 { 1.0 } else { size };
                *q += BESIDE * unit * (1.7 * (i + 1) as f64 * trial as f64).sin();
            }
            let reached = self.project(delay, &mut place, ITERATIONS, AtHand::Nothing);
            let Some(kkt) = self.kkt.as_mut().filter(|_| reached) else {
                return false;
            };
            kkt.factorise(&self.rows);
            let beside = kkt.independence();
            kkt.rank() > rank || (kkt.rank() == rank && beside > MORE * independence.max(NEAR))
        });
        self.near_singular = near;
        self.evaluate(0.0, state);
        found
    }
}

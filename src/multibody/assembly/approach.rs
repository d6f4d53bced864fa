//! Assembly from far away: damped least squares towards the nearest positions that satisfy the constraints.

use nalgebra::{DMatrix, DVector};

use crate::multibody::dynamics::MechanismDynamics;

/// Above this, a body is not where Newton's method may begin.
const FAR: f64 = 1e-3;
/// Below this, Newton's method does the rest.
const NEAR: f64 = 1e-9;
/// From so many constraints on the full matrix is too much; Newton's method is left alone.
const MOST_ROWS: usize = 600;
/// Farthest that a body turns in one iteration \[rad\].
const MOST_TURN: f64 = 0.5;
/// Turn of the bodies that leaves a position in which all corrections are across the constraints \[rad\].
const NUDGE: f64 = 0.1;
const MOST_ITERATIONS: usize = 300;
const MOST_TRIALS: usize = 24;

impl MechanismDynamics {
    /// Brings positions that are far from the constraints near to them; false where the nearest ones miss.
    ///
    /// The rows are then those of the nearest positions, and `state` holds these. `give_up` is asked before each iteration.
    pub(crate) fn approach(
        &mut self,
        t: f64,
        state: &mut [f64],
        give_up: &dyn Fn() -> bool,
    ) -> bool {
        self.place(state);
        self.find_rows(t);
        if self.worst() <= FAR || self.rows.len() > MOST_ROWS {
            return true;
        }
        let placed = state.to_vec();
        if self.descend(t, state, give_up) {
            return true;
        }
        let mut nudged = placed;
        for (k, angle) in nudged[..self.model.coordinates()]
            .iter_mut()
            .skip(2)
            .step_by(3)
            .enumerate()
        {
            *angle += if k % 2 == 0 { NUDGE } else { -NUDGE };
        }
        let missed = self.worst();
        let arrived = self.descend(t, &mut nudged, give_up);
        if arrived || self.worst() < missed {
            state.copy_from_slice(&nudged);
        }
        self.place(state);
        self.find_rows(t);
        arrived
    }

    /// Levenberg's iterations (1944), weighed by mass, with limited turns: the sum of squares falls with each.
    fn descend(&mut self, t: f64, state: &mut [f64], give_up: &dyn Fn() -> bool) -> bool {
        let n = self.model.coordinates();
        self.place(state);
        self.find_rows(t);
        let size = self.size();
        let mut damping = 1e-3;
        let mut miss = self.scaled_residuals(size);
        for _ in 0..MOST_ITERATIONS {
            if self.worst() <= NEAR {
                return true;
            }
            let jacobian = self.scaled_jacobian(size);
            let mut weighed = jacobian.clone();
            for (mut column, mass) in weighed.column_iter_mut().zip(&self.model.mass) {
                column *= 1.0 / mass;
            }
            let square = &weighed * jacobian.transpose();
            let scale = square.diagonal().amax();
            let before = miss.norm();
            let mut fallen = false;
            for _ in 0..MOST_TRIALS {
                if give_up() {
                    break;
                }
                let mut damped = square.clone();
                for i in 0..damped.nrows() {
                    damped[(i, i)] += damping * scale;
                }
                damping *= 10.0;
                let Some(factors) = damped.cholesky() else {
                    continue;
                };
                let change = weighed.tr_mul(&factors.solve(&miss));
                let turn =
                    (change.iter().skip(2).step_by(3)).fold(0.0, |most: f64, c| most.max(c.abs()));
                let part = if turn > MOST_TURN {
                    MOST_TURN / turn
                } else {
                    1.0
                };
                let mut trial = state.to_vec();
                for (q, c) in trial[..n].iter_mut().zip(&change) {
                    *q -= part * c;
                }
                self.place(&trial);
                self.find_rows(t);
                let found = self.scaled_residuals(size);
                if found.norm() < before {
                    fallen = found.norm() < before * (1.0 - 1e-9);
                    state.copy_from_slice(&trial);
                    miss = found;
                    damping = (damping * 1e-2).max(1e-14);
                    break;
                }
            }
            if !fallen {
                break;
            }
        }
        self.place(state);
        self.find_rows(t);
        // Where solutions meet, the last digits come slowly.
        self.worst() <= 1e3 * NEAR
    }

    /// Residuals, lengths in parts of the size.
    fn scaled_residuals(&self, size: f64) -> DVector<f64> {
        let values = self.rows.iter().enumerate();
        let values = values.map(|(i, row)| row.value / self.unit(i, size));
        DVector::from_iterator(self.rows.len(), values)
    }

    fn scaled_jacobian(&self, size: f64) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.rows.len(), self.model.coordinates());
        for (i, k, value) in self.jacobian() {
            matrix[(i, k)] += value / self.unit(i, size);
        }
        matrix
    }

    fn unit(&self, equation: usize, size: f64) -> f64 {
        if self.model.equations[equation].is_angle() {
            1.0
        } else {
            size
        }
    }
}

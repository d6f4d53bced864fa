//! Assembly from distant positions: damped least squares (Levenberg) towards the nearest positions that satisfy the constraints.

use nalgebra::{DMatrix, DVector};

use super::projection::Projector;
use crate::geometry::unit;

/// Scaled residual of positions above which damped least squares precede Newton's iterations.
const FAR: f64 = 1e-3;
/// Scaled residual of positions at which damped least squares end and Newton's iterations take over. Up to this, error texts name the
/// residuals of velocities.
pub(super) const NEAR: f64 = 1e-9;
/// The same that is accepted after the last iteration: where solutions coincide, convergence is slow.
const NEAR_AT_LAST: f64 = 1e3 * NEAR;
/// Largest number of constraints with damped least squares, whose matrix is dense. Larger mechanisms use Newton's iterations alone.
const MOST_ROWS: usize = 600;
/// Largest rotation of a body in one iteration \[rad\].
const MOST_TURN: f64 = 0.5;
/// Displacement over the size of the mechanism, and rotation of alternating sign \[rad\], of the bodies where the iterations stagnate. They
/// leave positions at which all corrections are perpendicular to the constraints.
const NUDGE: f64 = 0.1;
/// Angle between the displacements of two successive bodies \[rad\], the golden angle: no two of them are parallel, and few in line with a
/// constraint.
const NUDGE_TURN: f64 = 2.399_963_229_728_653;
/// Largest number of iterations of damped least squares.
const MOST_ITERATIONS: usize = 300;
/// Largest number of damping factors tried in one iteration.
const MOST_TRIALS: usize = 24;
/// Damping factor of the first trial, over the largest diagonal entry.
const FIRST_DAMPING: f64 = 1e-3;
/// Ratio of a damping factor to that of the trial before.
const DAMPING_GROWTH: f64 = 10.0;
/// Factor of the damping after an accepted trial, whose own growth precedes it: one accepted at the first trial divides it by 10.
const DAMPING_REDUCTION: f64 = 1e-2;
/// Least damping factor. It separates damping from rounding of the diagonal entries, some 1e-16 of them.
const LEAST_DAMPING: f64 = 1e-14;
/// Relative decrease of the residual below which the iterations count as stagnant.
const LEAST_DECREASE: f64 = 1e-9;

impl Projector<'_> {
    /// Move distant positions close to the constraints. Return false where the positions of least residual do not satisfy them.
    ///
    /// Afterwards `state` and the constraint rows are those of the positions found.
    pub(crate) fn approach(&mut self, t: f64, state: &mut [f64]) -> bool {
        self.place(t, state);
        if self.worst() <= FAR || self.constraints.rows.len() > MOST_ROWS {
            return true;
        }
        let placed = state.to_vec();
        if self.descend(t, state) {
            return true;
        }
        let mut nudged = placed;
        let size = self.model.size(self.frames);
        let bodies = nudged[..self.model.coordinates()].chunks_exact_mut(3);
        for (k, body) in (1_u32..).zip(bodies) {
            let shift = NUDGE * size * unit(f64::from(k) * NUDGE_TURN);
            let turn = if k % 2 == 1 { NUDGE } else { -NUDGE };
            for (coordinate, change) in body.iter_mut().zip([shift.x, shift.y, turn]) {
                *coordinate += change;
            }
        }
        let missed = self.worst();
        let arrived = self.descend(t, &mut nudged);
        if arrived || self.worst() < missed {
            state.copy_from_slice(&nudged);
        }
        self.place(t, state);
        arrived
    }

    /// Run Levenberg's iterations (1944), weighted by mass and with limited rotations. The sum of squared residuals decreases in
    /// each.
    fn descend(&mut self, t: f64, state: &mut [f64]) -> bool {
        let n = self.model.coordinates();
        self.place(t, state);
        let size = self.model.size(self.frames);
        let mut damping = FIRST_DAMPING;
        let mut miss = self.scaled_residuals(size);
        for _ in 0..MOST_ITERATIONS {
            if self.worst() <= NEAR {
                return true;
            }
            // Δq = -M⁻¹ Gᵀ (G M⁻¹ Gᵀ + μ s I)⁻¹ c, where s is the largest diagonal entry and μ the damping factor.
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
                if (self.give_up)() {
                    break;
                }
                let mut damped = square.clone();
                for i in 0..damped.nrows() {
                    damped[(i, i)] += damping * scale;
                }
                damping *= DAMPING_GROWTH;
                let Some(factors) = damped.cholesky() else {
                    continue;
                };
                let change = weighed.tr_mul(&factors.solve(&miss));
                let turn =
                    (change.iter().skip(2).step_by(3)).fold(0.0, |most: f64, c| most.max(c.abs()));
                // The whole correction is scaled down where a body would turn by more than the limit.
                let part = if turn > MOST_TURN {
                    MOST_TURN / turn
                } else {
                    1.0
                };
                let mut trial = state.to_vec();
                for (q, c) in trial[..n].iter_mut().zip(&change) {
                    *q -= part * c;
                }
                self.place(t, &trial);
                let found = self.scaled_residuals(size);
                if found.norm() < before {
                    fallen = found.norm() < before * (1.0 - LEAST_DECREASE);
                    state.copy_from_slice(&trial);
                    miss = found;
                    damping = (damping * DAMPING_REDUCTION).max(LEAST_DAMPING);
                    break;
                }
            }
            if !fallen {
                break;
            }
        }
        self.place(t, state);
        self.worst() <= NEAR_AT_LAST
    }

    /// Return the residuals, with lengths divided by the size.
    fn scaled_residuals(&self, size: f64) -> DVector<f64> {
        let values = self.constraints.rows.iter().enumerate();
        let values = values.map(|(i, row)| row.value / self.unit(i, size));
        DVector::from_iterator(self.constraints.rows.len(), values)
    }

    /// Return the Jacobian of the scaled residuals.
    fn scaled_jacobian(&self, size: f64) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.constraints.rows.len(), self.model.coordinates());
        for (i, k, value) in self.constraints.jacobian() {
            matrix[(i, k)] += value / self.unit(i, size);
        }
        matrix
    }

    /// Return the scale of a residual: 1 rad for an angle, the size for a length.
    fn unit(&self, equation: usize, size: f64) -> f64 {
        if self.model.equations[equation].is_angle() {
            1.0
        } else {
            size
        }
    }
}

//! Positions, then velocities, back onto the constraints: the least change, weighed by mass.

use super::constrained::Constrained;
use super::dynamics::MechanismDynamics;

impl MechanismDynamics {
    /// Moves `state` (q, then v) onto the constraints at time `t`: positions, then velocities.
    ///
    /// Returns whether what is left is round-off.
    pub(super) fn project(&mut self, t: f64, state: &mut [f64], iterations: usize) -> bool {
        let Some(mut kkt) = self.kkt.take() else {
            return true;
        };
        let n = self.model.coordinates();
        let [mut residual, mut change] = std::mem::take(&mut self.projecting);
        let mut done = false;
        let mut before = f64::INFINITY;
        for iteration in 0..iterations {
            self.place(state);
            self.find_rows(t);
            for (r, row) in residual.iter_mut().zip(&self.rows) {
                *r = row.value;
            }
            let worst = self.worst();
            if worst <= self.round_off() || (worst < 1e-11 && worst >= 0.5 * before) {
                done = true;
                break;
            }
            if worst.is_nan() {
                break;
            }
            // While it converges fast, the factors at hand do.
            if iteration == 0 || worst > 0.05 * before {
                kkt.factorise(&self.rows);
                kkt.truncate(self.near_singular);
            }
            before = worst;
            change.fill(0.0);
            kkt.correct(&self.rows, &residual, &mut change);
            state[..n]
                .iter_mut()
                .zip(&change)
                .for_each(|(q, c)| *q += c);
        }
        if done {
            kkt.factorise(&self.rows);
            kkt.truncate(self.near_singular);
            done = self.project_velocities(&mut kkt, state, &mut residual, &mut change);
        }
        self.kkt = Some(kkt);
        self.projecting = [residual, change];
        done
    }

    fn project_velocities(
        &mut self,
        kkt: &mut Constrained,
        state: &mut [f64],
        residual: &mut [f64],
        change: &mut [f64],
    ) -> bool {
        let n = self.model.coordinates();
        let mut worst = f64::INFINITY;
        for _ in 0..3 {
            self.place(state);
            for (r, row) in residual.iter_mut().zip(&self.rows) {
                *r = row.rate(&self.frames);
            }
            let now = largest(residual);
            if now <= f64::EPSILON * self.speed() || now >= worst {
                break;
            }
            worst = now;
            change.fill(0.0);
            kkt.correct(&self.rows, residual, change);
            state[n..2 * n]
                .iter_mut()
                .zip(&*change)
                .for_each(|(v, c)| *v += c);
        }
        self.place(state);
        let left = self.rows.iter().map(|row| row.rate(&self.frames).abs());
        left.fold(0.0, f64::max) <= 1e-9 * self.speed()
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most: f64, v| {
        if v.is_nan() {
            f64::NAN
        } else {
            most.max(v.abs())
        }
    })
}

//! Positions, then velocities, back onto the constraints: the least change, weighed by mass.

use super::constrained::Constrained;
use super::dynamics::MechanismDynamics;

/// Residual of positions, in parts of the size, that may be left where it does not fall; of velocities, in parts of the largest;
/// and of both where they are known from both sides of a singular position.
const LEFT: f64 = 1e-11;
const LEFT_OF_VELOCITIES: f64 = 1e-9;
const LEFT_ACROSS: f64 = 1e-8;

/// How a projection ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Projected {
    There,
    Missed,
    /// Something has next to no hold there, and is missed.
    MissedNearSingular,
}

impl MechanismDynamics {
    /// Moves `state` (q, then v) onto the constraints at time `t`: positions, then velocities.
    ///
    /// Returns whether what is left is round-off; near a singular position, what both sides leave.
    pub(super) fn project(&mut self, t: f64, state: &mut [f64], iterations: usize) -> bool {
        match self.project_here(t, state, iterations, LEFT) {
            Projected::There => true,
            Projected::Missed => false,
            // What has no hold here is held on both sides.
            Projected::MissedNearSingular => {
                self.project_across(t, state)
                    && self.project_here(t, state, iterations, LEFT_ACROSS) == Projected::There
            }
        }
    }

    /// The same from here alone; `left`: see [`LEFT`].
    fn project_here(
        &mut self,
        t: f64,
        state: &mut [f64],
        iterations: usize,
        left: f64,
    ) -> Projected {
        let Some(mut kkt) = self.kkt.take() else {
            return Projected::There;
        };
        let n = self.model.coordinates();
        let [mut residual, mut change] = std::mem::take(&mut self.projecting);
        let (mut done, mut near) = (false, false);
        let mut before = f64::INFINITY;
        for iteration in 0..iterations {
            self.place(state);
            self.find_rows(t);
            for (r, row) in residual.iter_mut().zip(&self.rows) {
                *r = row.value;
            }
            let worst = self.worst();
            if worst <= self.round_off() || (worst < left && worst >= 0.5 * before) {
                done = true;
                break;
            }
            if worst.is_nan() {
                break;
            }
            // While it converges fast, the factors at hand do.
            if iteration == 0 || worst > 0.05 * before {
                near = self.factorise_held(&mut kkt);
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
            near = self.factorise_held(&mut kkt);
            let left = left.max(LEFT_OF_VELOCITIES);
            done = self.project_velocities(&mut kkt, state, [&mut residual, &mut change], left);
        }
        self.kkt = Some(kkt);
        self.projecting = [residual, change];
        match (done, near) {
            (true, _) => Projected::There,
            (false, true) => Projected::MissedNearSingular,
            (false, false) => Projected::Missed,
        }
    }

    /// Factors where the bodies are, of what has a hold; whether something has next to none.
    fn factorise_held(&self, kkt: &mut Constrained) -> bool {
        kkt.factorise(&self.rows);
        let near = kkt.independence() < self.near_singular;
        kkt.truncate(self.near_singular);
        near
    }

    fn project_velocities(
        &mut self,
        kkt: &mut Constrained,
        state: &mut [f64],
        [residual, change]: [&mut [f64]; 2],
        left: f64,
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
        let rates = self.rows.iter().map(|row| row.rate(&self.frames).abs());
        rates.fold(0.0, f64::max) <= left * self.speed()
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

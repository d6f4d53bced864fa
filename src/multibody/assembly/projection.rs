//! Projection of positions, then velocities, onto the constraints: the least change, weighted by mass.

use super::residuals::largest;
use crate::multibody::constraints::sparse_kkt::SparseKkt;
use crate::multibody::dynamics::MechanismDynamics;

/// Relative residual of positions that is accepted where Newton's iterations stagnate. Positions are scaled by the size.
const LEFT: f64 = 1e-11;
/// Relative residual of velocities that is accepted; velocities are scaled by the largest.
const LEFT_OF_VELOCITIES: f64 = 1e-9;
/// The same of positions and velocities interpolated across a singular position.
const LEFT_ACROSS: f64 = 1e-8;

/// Convergence rate above which the factors of a nearby state are recomputed.
const SLOW: f64 = 0.05;
/// Multiple of round-off below which the convergence rate is not evaluated, since round-off dominates it.
const TELLING: f64 = 64.0;

/// Outcome of a projection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Projected {
    There,
    Missed,
    /// The residual remains, and fewer constraints are independent than away from singular positions.
    MissedNearSingular,
}

/// Data available at the start of a projection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AtHand {
    Nothing,
    /// Factors of a state that differs by a correction of the step.
    Factors,
    /// Factors of the implicit corrector at such a state.
    Corrector,
    /// Body frames, constraint rows and factors of the same state.
    Everything,
}

/// Factors used in a projection, with their status.
struct Held {
    kkt: SparseKkt,
    /// Whether they are those of the present state.
    fresh: bool,
    /// Whether the factors of the implicit corrector are used in their place.
    by_corrector: bool,
    /// Whether fewer constraints are independent than away from singular positions.
    near: bool,
}

impl MechanismDynamics {
    /// Project `state` (q, then v) onto the constraints at time `t`: positions, then velocities.
    ///
    /// Return whether the remaining residual is accepted. Near a singular position the state is interpolated from both sides of it.
    pub(crate) fn project(
        &mut self,
        t: f64,
        state: &mut [f64],
        iterations: usize,
        at_hand: AtHand,
    ) -> bool {
        match self.project_here(t, state, iterations, LEFT, at_hand) {
            Projected::There => true,
            Projected::Missed => false,
            Projected::MissedNearSingular if self.aside => false,
            // The direction without an independent constraint is determined on both sides.
            Projected::MissedNearSingular => {
                self.project_across(t, state)
                    && self.project_here(t, state, iterations, LEFT_ACROSS, AtHand::Nothing)
                        == Projected::There
            }
        }
    }

    /// Project from the present state without interpolation; `left`: see [`LEFT`].
    fn project_here(
        &mut self,
        t: f64,
        state: &mut [f64],
        iterations: usize,
        left: f64,
        at_hand: AtHand,
    ) -> Projected {
        let Some(kkt) = self.kkt.take() else {
            return Projected::There;
        };
        // Factors with constraints left out near a singular position hold for one state only.
        let by_corrector = at_hand == AtHand::Corrector;
        let known =
            by_corrector || at_hand != AtHand::Nothing && kkt.independence() >= self.near_singular;
        let mut held = Held {
            kkt,
            fresh: known && at_hand == AtHand::Everything,
            by_corrector,
            near: false,
        };
        let [mut residual, mut change] = std::mem::take(&mut self.projecting);
        if at_hand != AtHand::Everything {
            if at_hand == AtHand::Nothing {
                self.place(state);
            } else {
                // The frames are those of the state of the factors.
                self.place_nearby(state);
            }
            self.find_rows(t);
        }
        let with = [&mut residual[..], &mut change[..]];
        let mut done =
            self.project_positions(&mut held, (t, state), with, (iterations, left, known));
        if done {
            if !known {
                self.factorise_held(&mut held);
            }
            let left = left.max(LEFT_OF_VELOCITIES);
            let with = [&mut residual[..], &mut change[..]];
            done = self.project_velocities(&mut held, state, with, left);
            if !done && !held.fresh {
                // Factors of a nearby state do not reach full accuracy.
                self.factorise_held(&mut held);
                let with = [&mut residual[..], &mut change[..]];
                done = self.project_velocities(&mut held, state, with, left);
            }
        }
        self.kkt = Some(held.kkt);
        self.projecting = [residual, change];
        match (done, held.near) {
            (true, _) => Projected::There,
            (false, true) => Projected::MissedNearSingular,
            (false, false) => Projected::Missed,
        }
    }

    /// Project the positions, whose rows are evaluated; return whether the residual is below `left` and no longer halves. `known`: factors exist.
    fn project_positions(
        &mut self,
        held: &mut Held,
        (t, state): (f64, &mut [f64]),
        [residual, change]: [&mut [f64]; 2],
        (iterations, left, known): (usize, f64, bool),
    ) -> bool {
        let (n, size) = (self.model.coordinates(), self.size());
        let mut before = f64::INFINITY;
        for iteration in 0..iterations {
            for (r, row) in residual.iter_mut().zip(&self.rows) {
                *r = row.value;
            }
            // Iterations end at round-off, or where the residual is below `left` and no longer halves.
            let (worst, round_off) = (self.worst_beside(size), self.round_off());
            if worst <= round_off || (worst < left && worst >= 0.5 * before) {
                return true;
            }
            if worst.is_nan() {
                return false;
            }
            // Newton's iterations keep the factors while convergence is fast.
            let slow = worst > SLOW * before && worst > TELLING * round_off;
            if slow || iteration == 0 && !known {
                self.factorise_held(held);
            }
            before = worst;
            change.fill(0.0);
            self.correct_by(held, residual, change);
            state[..n]
                .iter_mut()
                .zip(&*change)
                .for_each(|(q, c)| *q += c);
            held.fresh = false;
            self.place_nearby(state);
            self.find_rows(t);
        }
        false
    }

    /// Add to `change` a change of coordinates that removes `residual`: the least one, weighted by mass, or by the matrix of the implicit
    /// corrector, in which contacts are stiff.
    fn correct_by(&mut self, held: &mut Held, residual: &[f64], change: &mut [f64]) {
        if held.by_corrector {
            self.correct_constraints(residual, change);
        } else {
            held.kkt.correct(residual, change);
        }
    }

    /// Factorise at the present state, without nearly dependent constraints.
    fn factorise_held(&self, held: &mut Held) {
        let faint = self.faint();
        // Interpolation points and trial positions keep nearly dependent constraints.
        let part = if self.aside {
            faint
        } else {
            self.near_singular
        };
        held.kkt.factorise(&self.rows, part);
        held.near = held.kkt.rank() < self.rank;
        if held.near && 0.0 < faint && faint < part {
            held.kkt.factorise(&self.rows, faint);
        }
        (held.fresh, held.by_corrector) = (true, false);
    }

    /// Project the velocities; return whether the remaining residual is at most `left` times the largest speed.
    fn project_velocities(
        &mut self,
        held: &mut Held,
        state: &mut [f64],
        [residual, change]: [&mut [f64]; 2],
        left: f64,
    ) -> bool {
        let n = self.model.coordinates();
        let speed = self.speed();
        let round_off = f64::EPSILON * speed;
        let mut before = f64::INFINITY;
        // The velocity equation G v + ∂c/∂t = 0 is linear, so one correction suffices with exact factors. Further ones reduce
        // round-off and the error of factors of a nearby state.
        for _ in 0..4 {
            for (r, row) in residual.iter_mut().zip(&self.rows) {
                *r = row.rate(&self.frames);
            }
            let worst = largest(residual.iter().copied());
            if worst <= round_off {
                return true;
            }
            if worst >= before {
                break;
            }
            if !held.fresh && worst > SLOW * before && worst > TELLING * round_off {
                self.factorise_held(held);
            }
            before = worst;
            change.fill(0.0);
            self.correct_by(held, residual, change);
            state[n..2 * n]
                .iter_mut()
                .zip(&*change)
                .for_each(|(v, c)| *v += c);
            self.move_with(state);
        }
        largest(self.rows.iter().map(|row| row.rate(&self.frames))) <= left * speed
    }
}

//! Projection of positions, then velocities, onto the constraints: the least change, weighted by mass.

use super::residuals::round_off;
use crate::math::largest_magnitude;
use crate::multibody::constraints::constraint_state::ConstraintState;
use crate::multibody::constraints::sparse_kkt::SparseKkt;
use crate::multibody::description::body::Frame;
use crate::multibody::model::MechanismModel;
use crate::multibody::newton::stage::ImplicitCorrector;

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

/// Parts of the dynamics that a projection onto the constraints uses: it changes the frames, the rows and the factors.
pub(crate) struct Projector<'a> {
    pub(crate) model: &'a MechanismModel,
    pub(crate) frames: &'a mut [Frame],
    pub(crate) constraints: &'a mut ConstraintState,
    pub(crate) corrector: &'a mut ImplicitCorrector,
    /// Whether to end the search for positions; evaluated before each iteration.
    pub(crate) give_up: &'a dyn Fn() -> bool,
}

impl Projector<'_> {
    /// Set the body frames to a state without a shift and evaluate the constraint equations there.
    pub(crate) fn place(&mut self, t: f64, state: &[f64]) {
        self.model.place(self.frames, state);
        self.find_rows(t);
    }

    /// Evaluate the constraint equations at the body frames.
    pub(crate) fn find_rows(&mut self, t: f64) {
        self.constraints.find_rows(self.model, t, self.frames);
    }

    /// Return the largest residual of positions.
    pub(super) fn worst(&self) -> f64 {
        self.constraints.worst(self.model, self.frames)
    }

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
            Projected::MissedNearSingular if self.constraints.aside => false,
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
        let Some(kkt) = self.constraints.kkt.take() else {
            return Projected::There;
        };
        // Factors with constraints left out near a singular position hold for one state only.
        let by_corrector = at_hand == AtHand::Corrector;
        let known = by_corrector
            || at_hand != AtHand::Nothing && kkt.independence() >= self.constraints.near_singular;
        let mut held = Held {
            kkt,
            fresh: known && at_hand == AtHand::Everything,
            by_corrector,
            near: false,
        };
        let [mut residual, mut change] = std::mem::take(&mut self.constraints.projecting);
        if at_hand != AtHand::Everything {
            if at_hand == AtHand::Nothing {
                self.model.place(self.frames, state);
            } else {
                // The frames are those of the state of the factors.
                self.model.place_nearby(self.frames, state);
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
        self.constraints.kkt = Some(held.kkt);
        self.constraints.projecting = [residual, change];
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
        let (n, size) = (self.model.coordinates(), self.model.size(self.frames));
        let mut before = f64::INFINITY;
        for iteration in 0..iterations {
            for (r, row) in residual.iter_mut().zip(&self.constraints.rows) {
                *r = row.value;
            }
            // Iterations end at round-off, or where the residual is below `left` and no longer halves.
            let (worst, round_off) = (
                self.constraints.worst_beside(self.model, size),
                round_off(self.frames),
            );
            if worst <= round_off || (worst < left && worst >= 0.5 * before) {
                return true;
            }
            if worst.is_nan() || (self.give_up)() {
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
            self.model.place_nearby(self.frames, state);
            self.find_rows(t);
        }
        false
    }

    /// Add to `change` a change of coordinates that removes `residual`: the least one, weighted by mass, or by the matrix of the implicit
    /// corrector, in which contacts are stiff.
    fn correct_by(&mut self, held: &mut Held, residual: &[f64], change: &mut [f64]) {
        if held.by_corrector {
            self.corrector.correct_constraints(residual, change);
        } else {
            held.kkt.correct(residual, change);
        }
    }

    /// Factorise at the present state, without nearly dependent constraints.
    fn factorise_held(&self, held: &mut Held) {
        let faint = self.constraints.faint();
        // Interpolation points and trial positions keep nearly dependent constraints.
        let part = if self.constraints.aside {
            faint
        } else {
            self.constraints.near_singular
        };
        held.kkt.factorise(&self.constraints.rows, part);
        held.near = held.kkt.rank() < self.constraints.rank;
        if held.near && 0.0 < faint && faint < part {
            held.kkt.factorise(&self.constraints.rows, faint);
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
        let speed = self.constraints.speed(self.frames);
        let round_off = f64::EPSILON * speed;
        let mut before = f64::INFINITY;
        // The velocity equation G v + ∂c/∂t = 0 is linear, so one correction suffices with exact factors. Further ones reduce
        // round-off and the error of factors of a nearby state.
        for corrections in 0..=4 {
            (held.kkt.jacobian).multiply(&self.constraints.rows, &state[n..2 * n], residual);
            let rates = residual.iter_mut().zip(&self.constraints.rows);
            rates.for_each(|(rate, row)| *rate += row.time_rate);
            let worst = largest_magnitude(residual.iter().copied());
            let last = corrections == 4 || worst >= before;
            if worst <= round_off || last {
                self.model.move_with(self.frames, state);
                return worst <= round_off.max(left * speed);
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
        }
        false
    }
}

//! Positions, then velocities, back onto the constraints: the least change, weighed by mass.

use crate::multibody::constraints::sparse_kkt::SparseKkt;
use crate::multibody::dynamics::MechanismDynamics;

/// Residual of positions, in parts of the size, that may be left where it does not fall; of velocities, in parts of the largest;
/// and of both where they are known from both sides of a singular position.
const LEFT: f64 = 1e-11;
const LEFT_OF_VELOCITIES: f64 = 1e-9;
const LEFT_ACROSS: f64 = 1e-8;

/// A rate of convergence above which factors of a state beside are made anew, and the multiple of round-off down to which it
/// tells something.
const SLOW: f64 = 0.05;
const TELLING: f64 = 64.0;

/// How a projection ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Projected {
    There,
    Missed,
    /// Something has next to no hold there, and is missed.
    MissedNearSingular,
}

/// What a projection begins with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AtHand {
    Nothing,
    /// Factors of a state a step's correction beside.
    Factors,
    /// Bodies, equations and factors of the very state.
    Everything,
}

/// The factors a projection uses, and what is known of them.
struct Held {
    kkt: SparseKkt,
    /// Whether they are of the state as it is.
    fresh: bool,
    /// Whether something has next to no hold.
    near: bool,
}

impl MechanismDynamics {
    /// Moves `state` (q, then v) onto the constraints at time `t`: positions, then velocities.
    ///
    /// Returns whether what is left is round-off; near a singular position, what both sides leave.
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
            // What has no hold here is held on both sides.
            Projected::MissedNearSingular => {
                self.project_across(t, state)
                    && self.project_here(t, state, iterations, LEFT_ACROSS, AtHand::Nothing)
                        == Projected::There
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
        at_hand: AtHand,
    ) -> Projected {
        let Some(kkt) = self.kkt.take() else {
            return Projected::There;
        };
        // Factors that are cut for want of a hold are of one state only.
        let known = at_hand != AtHand::Nothing && kkt.independence() >= self.near_singular;
        let mut held = Held {
            kkt,
            fresh: known && at_hand == AtHand::Everything,
            near: false,
        };
        let n = self.model.coordinates();
        let [mut residual, mut change] = std::mem::take(&mut self.projecting);
        if at_hand != AtHand::Everything {
            self.place(state);
            self.find_rows(t);
        }
        let (size, mut done) = (self.size(), false);
        let mut before = f64::INFINITY;
        for iteration in 0..iterations {
            for (r, row) in residual.iter_mut().zip(&self.rows) {
                *r = row.value;
            }
            let (worst, round_off) = (self.worst_beside(size), self.round_off());
            if worst <= round_off || (worst < left && worst >= 0.5 * before) {
                done = true;
                break;
            }
            if worst.is_nan() {
                break;
            }
            // While it converges fast, the factors at hand do.
            let slow = worst > SLOW * before && worst > TELLING * round_off;
            if slow || iteration == 0 && !known {
                self.factorise_held(&mut held);
            }
            before = worst;
            change.fill(0.0);
            held.kkt.correct(&residual, &mut change);
            state[..n]
                .iter_mut()
                .zip(&change)
                .for_each(|(q, c)| *q += c);
            held.fresh = false;
            self.place(state);
            self.find_rows(t);
        }
        if done {
            if !known {
                self.factorise_held(&mut held);
            }
            let left = left.max(LEFT_OF_VELOCITIES);
            let with = [&mut residual[..], &mut change[..]];
            done = self.project_velocities(&mut held, state, with, left);
            if !done && !held.fresh {
                // Factors of a state beside do not give every digit.
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

    /// Factors where the bodies are, of what has a hold.
    fn factorise_held(&self, held: &mut Held) {
        let faint = self.faint();
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
        held.fresh = true;
    }

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
        for _ in 0..4 {
            for (r, row) in residual.iter_mut().zip(&self.rows) {
                *r = row.rate(&self.frames);
            }
            let worst = largest(residual);
            if worst <= round_off || worst >= before {
                break;
            }
            if !held.fresh && worst > SLOW * before && worst > TELLING * round_off {
                self.factorise_held(held);
            }
            before = worst;
            change.fill(0.0);
            held.kkt.correct(residual, change);
            state[n..2 * n]
                .iter_mut()
                .zip(&*change)
                .for_each(|(v, c)| *v += c);
            self.move_with(state);
        }
        let rates = self.rows.iter().map(|row| row.rate(&self.frames).abs());
        rates.fold(0.0, f64::max) <= left * speed
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

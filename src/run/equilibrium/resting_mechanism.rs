//! Mechanism whose positions are iterated to static equilibrium, with its constraints satisfied after every iteration.
//!
//! The step of backward Euler has the multipliers of the constraints as further unknowns: with the accelerations a from rest,
//! (M - γ ∂f/∂v - γ² ∂f/∂q + γ² Σ λ ∂²c/∂q²) Δq + Gᵀ μ = γ² M a and G Δq = 0. The positions are then projected onto the constraints.

use std::sync::Arc;

use super::settling::Resting;
use crate::error::Result;
use crate::integrator::SecondOrderSystem;
use crate::math::largest_magnitude;
use crate::multibody::{MechanismDynamics, MechanismModel};

/// Longest γ \[s\]. A pendulum of 25 m converges by a factor of 40 in one iteration.
const LONGEST_GAMMA: f64 = 10.0;
/// Largest displacement of a centre of mass in one iteration, over the size of the mechanism.
const LARGEST_MOVE: f64 = 0.05;
/// Largest rotation in one iteration \[rad\].
const LARGEST_TURN: f64 = 0.1;
/// Largest displacement of the circle of a contact in one iteration, over its clearance in a bore or a quarter of its radius elsewhere; a
/// gap is closed by half of it in addition.
const CONTACT_SHARE: f64 = 0.2;
/// The same in the second attempt.
const SHORT_CONTACT_SHARE: f64 = 0.02;
/// Ratio of unbalanced forces from which on a step of the second attempt is taken back: its circles were pressed too deep.
const MOST_GROWTH: f64 = 10.0;
/// Maximum number of iterations. A disc that 100 rad of a torsion spring hold takes 1020.
const MOST_ITERATIONS: u32 = 20_000;
/// Rotation or displacement, in sizes of the mechanism, from which on a body without equilibrium counts as moved without end.
const FAR: f64 = 10.0;
/// Displacement that counts as rounding, in roundings of the positions.
const ROUNDINGS: f64 = 4.0;
/// Ratio of the largest reaction of a joint to the largest load from which on a position counts as singular. A toggle at 0.001° has 3e4, a
/// straight chain of two to twenty bars between fixed points 1e6 to 4e6, by rounding.
const SINGULAR: f64 = 1e5;

/// Mechanism at rest.
pub(super) struct RestingMechanism {
    pub(super) dynamics: MechanismDynamics,
    /// Positions, then velocities of zero.
    state: Vec<f64>,
    /// Positions of the assembly.
    begin: Vec<f64>,
    /// Length of each coordinate: 1 for a displacement, that of the farthest joint or contact point for an angle \[m\].
    lengths: Vec<f64>,
    /// Size of the assembled mechanism \[m\].
    size: f64,
    /// True if the described mechanism has friction, which this one leaves out.
    frictional: bool,
}

impl RestingMechanism {
    /// Assemble `model` with its drivers held.
    pub(super) fn assemble(model: MechanismModel, give_up: &dyn Fn() -> bool) -> Result<Self> {
        let frictional = model.has_friction();
        let mut dynamics = MechanismDynamics::new(Arc::new(model.held()));
        let mut state = dynamics.assemble_unless(give_up)?.state;
        let n = state.len() / 2;
        state[n..].fill(0.0);
        let mut lengths = vec![1.0; n];
        dynamics.scale(&mut lengths);
        dynamics.evaluate(0.0, &state);
        dynamics.remember_present_contacts();
        Ok(Self {
            size: dynamics.model.size(&dynamics.frames),
            begin: state[..n].to_vec(),
            dynamics,
            state,
            lengths,
            frictional,
        })
    }

    fn largest_contact_force(&self) -> f64 {
        let forces = self.dynamics.contact_forces().into_iter();
        forces.fold(0.0, |most: f64, [x, y]| most.max(x.hypot(y)))
    }

    /// Return what is known of a mechanism without equilibrium: the body with the largest unbalanced force, and the one that has moved
    /// farthest.
    pub(super) fn causes(&self) -> String {
        let n = self.begin.len();
        let name = |i: usize| &self.dynamics.model.bodies[self.dynamics.model.body_of(i)].name;
        let largest =
            |value: &dyn Fn(usize) -> f64| (0..n).max_by(|&i, &j| value(i).total_cmp(&value(j)));
        let moved = |i: usize| {
            let unit = if i % 3 == 2 { 1.0 } else { self.size };
            (self.state[i] - self.begin[i]).abs() / unit
        };
        let remedy = "give it a spring, a stop, a joint or a driver that holds it";
        match largest(&moved).filter(|&i| moved(i) > FAR) {
            Some(i) if i % 3 == 2 => format!(
                "nothing holds body {:?}, which has turned by {:.1} rad: {remedy}",
                name(i),
                self.state[i] - self.begin[i]
            ),
            Some(i) => format!(
                "nothing holds body {:?}, which has moved by {:.3e} m: {remedy}",
                name(i),
                self.state[i] - self.begin[i]
            ),
            None => {
                let left = largest(&|i| self.force(i)).map_or(String::new(), |i| {
                    format!("the largest force is left on body {:?}", name(i))
                });
                format!("{left}: {}", self.remedy())
            }
        }
    }

    /// Return the remedy for a mechanism that no body has left.
    fn remedy(&self) -> String {
        if let Some(force) = self.dynamics.load_that_grows() {
            return format!(
                "force {force:?} is zero at t = 0 and grows later, and the loads here are those of t = 0: give it its value from the \
                 beginning, a Tensioner by ramp_time = 0"
            );
        }
        self.singular()
            .unwrap_or_else(|| "begin nearer to rest".to_string())
    }

    /// Return a description of a singular position, where reactions exceed all loads.
    pub(super) fn singular(&self) -> Option<String> {
        let load = self.reference_force();
        let reaction = largest_magnitude(self.dynamics.reactions_by_body(&self.lengths));
        (load > 0.0 && reaction > SINGULAR * load).then(|| {
            format!(
                "joints bear {reaction:.1e} N under loads of {load:.1e} N, as in a stretched chain of bars, where no finite force is \
                 in balance: give it slack"
            )
        })
    }

    /// Assemble and factorise the matrix of a step of length `gamma` \[s\] at the last evaluation; return whether it is regular.
    pub(super) fn factorise(&mut self, gamma: f64) -> bool {
        // At rest the constraints change with the displacement alone: without accelerations the matrix has G in their rows.
        let still = vec![0.0; self.begin.len()];
        let rates = std::mem::replace(&mut self.dynamics.accelerations, still);
        let regular = self.dynamics.factorise_here(gamma);
        self.dynamics.accelerations = rates;
        regular
    }

    /// Return the unbalanced force of a coordinate at the last evaluation \[N\]; that of an angle is the moment over its length.
    fn force(&self, i: usize) -> f64 {
        (self.dynamics.model.mass[i] * self.dynamics.accelerations[i]).abs() / self.lengths[i]
    }
}

impl Resting for RestingMechanism {
    fn longest_gamma(&self) -> f64 {
        LONGEST_GAMMA
    }

    fn most_iterations(&self) -> u32 {
        MOST_ITERATIONS
    }

    fn positions(&self) -> &[f64] {
        &self.state[..self.begin.len()]
    }

    fn place(&mut self, positions: &[f64]) {
        self.state[..positions.len()].copy_from_slice(positions);
        self.dynamics.evaluate(0.0, &self.state);
    }

    fn unbalanced(&mut self) -> f64 {
        self.dynamics.evaluate(0.0, &self.state);
        largest_magnitude((0..self.begin.len()).map(|i| self.force(i)))
    }

    fn reference_force(&self) -> f64 {
        largest_magnitude(self.dynamics.loads_by_body(&self.lengths))
    }

    /// Reactions count up to the largest load: they grow without limit near a singular position.
    fn is_balanced_by_body(&self, tolerance: f64) -> bool {
        let loads = self.dynamics.loads_by_body(&self.lengths);
        let reactions = self.dynamics.reactions_by_body(&self.lengths);
        let most = largest_magnitude(loads.iter().copied());
        let own = loads.iter().zip(&reactions);
        let own = own.map(|(load, reaction)| load.max(reaction.min(most)));
        let mut bodies = self.dynamics.model.first.iter().zip(own);
        bodies.all(|(first, own)| {
            first.is_none_or(|i| (i..i + 3).all(|i| self.force(i) <= tolerance * own))
        })
    }

    /// Rotations are compared with a radian, displacements with the size of the mechanism, each with the largest position.
    fn is_rounding(&self, step: &[f64]) -> bool {
        let farthest = |first: usize, least: f64| {
            let rows = self.state[..step.len()].chunks_exact(3);
            let parts = rows.flat_map(|row| if first == 2 { &row[2..] } else { &row[..2] });
            parts.fold(least, |most: f64, q| most.max(q.abs()))
        };
        let (displacement, rotation) = (farthest(0, self.size), farthest(2, 1.0));
        step.chunks_exact(3).all(|step| {
            step[0].hypot(step[1]) <= ROUNDINGS * f64::EPSILON * displacement
                && step[2].abs() <= ROUNDINGS * f64::EPSILON * rotation
        })
    }

    /// Return the largest contact force at the last evaluation \[N\]; without contact, the largest weight or force element.
    fn largest_force(&self) -> f64 {
        let contact = self.largest_contact_force();
        if contact > 0.0 {
            contact
        } else {
            self.reference_force()
        }
    }

    fn leaves_friction_out(&self) -> bool {
        self.frictional
    }

    fn store_surfaces(&mut self) {
        self.dynamics.remember_present_contacts();
    }

    fn find_step(&mut self, gamma: f64, step: &mut [f64]) -> bool {
        let rates = step.iter_mut().zip(&self.dynamics.accelerations);
        rates.for_each(|(step, rate)| *step = gamma * rate);
        let regular = self.factorise(gamma);
        if regular {
            self.dynamics.correct(step);
            for step in step {
                *step *= gamma;
            }
        }
        regular
    }

    fn follows_forces(&self, step: &[f64]) -> bool {
        let model = &self.dynamics.model;
        let forces = model.mass.iter().zip(&self.dynamics.accelerations);
        let work = forces.zip(step).map(|((m, a), step)| m * a * step);
        work.sum::<f64>() > 0.0
    }

    fn most_growth(&self) -> f64 {
        MOST_GROWTH
    }

    fn excess(&mut self, step: &[f64], second: bool) -> f64 {
        let n = step.len();
        let coordinates = step.chunks_exact(3);
        let mut excess = coordinates.fold(0.0, |most: f64, step| {
            let moved = step[0].hypot(step[1]) / (LARGEST_MOVE * self.size);
            most.max(moved).max(step[2].abs() / LARGEST_TURN)
        });
        let share = if second {
            SHORT_CONTACT_SHARE
        } else {
            CONTACT_SHARE
        };
        let mut moving = self.state.clone();
        moving[n..].copy_from_slice(step);
        let dynamics = &mut self.dynamics;
        dynamics.model.move_with(&mut dynamics.frames, &moving);
        for [moved, gap, play] in dynamics.contact_moves() {
            excess = excess.max(moved / (0.5 * gap.max(0.0) + share * play));
        }
        dynamics.model.move_with(&mut dynamics.frames, &self.state);
        excess
    }

    fn move_by(&mut self, share: f64, step: &[f64]) -> bool {
        let before = self.state.clone();
        for (q, step) in self.state.iter_mut().zip(step) {
            *q += share * step;
        }
        let there = self.dynamics.project_at_rest(&mut self.state);
        if !there {
            self.state = before;
            self.dynamics.evaluate(0.0, &self.state);
        }
        there
    }
}

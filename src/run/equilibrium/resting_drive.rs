//! Drive whose positions are iterated to static equilibrium.

use std::sync::Arc;

use super::settling::Resting;
use crate::chain::dynamics::Dynamics;
use crate::chain::model::{Model, Rotation, SprocketModel};
use crate::chain::motion::Motion;
use crate::geometry::{Vec2, turned_left, unit};
use crate::integrator::SecondOrderSystem;
use crate::layout::InitialConfiguration;
use crate::math::largest_magnitude;

/// Longest γ over the pitch \[s/m\]: 64 ms at half an inch. The elimination of the links divides by their masses. Its rounding error grows
/// with the fourth power of γ over the period of a link on its contacts, which is proportional to the pitch. In a drive of half an inch
/// corrections have a relative error of a thousandth at 0.1 s, and are useless from 0.6 s on.
const LONGEST_GAMMA_PER_PITCH: f64 = 5.0;
/// Largest relative displacement of the two link ends in a hinge in one iteration, over the hinge clearance.
const HINGE_SHARE: f64 = 0.2;
/// Largest displacement of any coordinate in one iteration, in pitches.
const LARGEST_MOVE: f64 = 0.02;
/// Largest displacement in the second attempt, in pitches: one or two hinge clearances, so that no bushing moves into the middle of a
/// tooth.
const SHORT_MOVE: f64 = 0.002;
/// Least force that unbalanced forces are compared with \[N\]: a drive without any load has no force of its own.
const LEAST_FORCE: f64 = 1e-6;
/// Maximum number of iterations. Of 61 random tensioned drives, those whose strands weigh four to eleven times their tension pull the
/// tensioner far back and need most, 52,000 to 68,000. With twice this number a refusal takes twice as long.
const MOST_ITERATIONS: u32 = 100_000;

/// Return the length that converts a coordinate of a sprocket to a displacement: the pitch radius for an angle \[m\], 1 for a length.
fn arm(sprocket: &SprocketModel, index: usize) -> f64 {
    match sprocket.rotation {
        Rotation::Free { index: own, .. } if own == index => sprocket.profile.pitch_radius,
        _ => 1.0,
    }
}

/// Return the largest external force \[N\]: weight of a link, force of a tensioner, torque over a pitch radius; at least [`LEAST_FORCE`].
fn applied_force(model: &Model) -> f64 {
    let moved = (0..model.links).filter(|&i| !model.is_held(i));
    let heaviest = moved.fold(0.0, |most: f64, i| most.max(model.chain.mass[i]));
    let outside = model.sprockets.iter().map(|sprocket| {
        let torque = sprocket.applied_torque(0.0, 0.0) / sprocket.profile.pitch_radius;
        sprocket.pull(0.0).abs().max(torque.abs())
    });
    outside.fold((model.gravity.norm() * heaviest).max(LEAST_FORCE), f64::max)
}

/// Drive at rest.
pub(super) struct RestingDrive {
    pub(super) dynamics: Dynamics,
    pub(super) places: Motion,
    pub(super) y: Vec<f64>,
    rates: Vec<f64>,
    /// Largest external force \[N\].
    applied: f64,
    frictional: bool,
}

impl RestingDrive {
    /// `frictional`: the drive has friction, which `model` leaves out.
    pub(super) fn new(model: Arc<Model>, start: &InitialConfiguration, frictional: bool) -> Self {
        let mut places = Motion::new(model.bodies());
        places.set(&start.positions, &start.velocities);
        let mut y = vec![0.0; 2 * model.coordinates];
        places.write(&model, &mut y);
        let applied = applied_force(&model);
        let mut dynamics = Dynamics::new(model);
        dynamics.close_ideal_hinges(0.0, &mut y);
        Self {
            applied,
            frictional,
            dynamics,
            places,
            rates: vec![0.0; y.len()],
            y,
        }
    }

    /// Return the positions of all bodies.
    pub(super) fn body_positions(&mut self) -> Vec<[f64; 3]> {
        self.places.read(self.dynamics.model(), 0.0, &self.y);
        self.places.positions()
    }
}

impl Resting for RestingDrive {
    fn longest_gamma(&self) -> f64 {
        LONGEST_GAMMA_PER_PITCH * 2.0 * self.dynamics.model().half_pitch
    }

    fn most_iterations(&self) -> u32 {
        MOST_ITERATIONS
    }

    fn positions(&self) -> &[f64] {
        &self.y[..self.dynamics.model().coordinates]
    }

    fn place(&mut self, positions: &[f64]) {
        self.y[..positions.len()].copy_from_slice(positions);
    }

    /// Moments of links are divided by half the pitch.
    fn unbalanced(&mut self) -> f64 {
        self.dynamics
            .derivative_with_slopes(0.0, &self.y, &mut self.rates);
        let model = self.dynamics.model();
        let (n, accelerations) = (model.links, &self.rates[model.coordinates..]);
        let mut forces = Vec::with_capacity(5 * n);
        for i in 0..n {
            forces.push(model.chain.mass[i] * accelerations[i].abs());
            forces.push(model.chain.mass[i] * accelerations[n + i].abs());
            forces.push(model.chain.inertia[i] * accelerations[2 * n + i].abs() / model.half_pitch);
        }
        if let Some(rollers) = &model.rollers {
            // Without friction no torque acts on the rollers.
            let accelerations = &accelerations[rollers.first..][..2 * n];
            forces.extend(accelerations.iter().map(|a| rollers.mass * a.abs()));
        }
        for sprocket in &model.sprockets {
            sprocket.for_each_inertia(|index, inertia| {
                forces.push(inertia * accelerations[index].abs() / arm(sprocket, index));
            });
        }
        largest_magnitude(forces)
    }

    fn reference_force(&self) -> f64 {
        self.applied.max(self.largest_force())
    }

    fn largest_force(&self) -> f64 {
        let hinges = self.dynamics.hinge_contacts().map(|(_, force)| force);
        let rollers = self.dynamics.roller_contacts().map(|(_, force)| force);
        let teeth = self.dynamics.candidates().map(|(_, _, _, force)| force);
        hinges.chain(rollers).chain(teeth).fold(0.0, f64::max)
    }

    fn leaves_friction_out(&self) -> bool {
        self.frictional
    }

    fn store_surfaces(&mut self) {
        self.dynamics.remember_present_contacts(0.0, &self.y);
    }

    fn find_step(&mut self, gamma: f64, step: &mut [f64]) -> bool {
        // Velocity of one step from rest, γ Q/M; the matrix turns it into the backward Euler step.
        for (step, acceleration) in step.iter_mut().zip(&self.rates[self.y.len() / 2..]) {
            *step = gamma * acceleration;
        }
        if !self.dynamics.factorise_indefinite(gamma) {
            return false;
        }
        self.dynamics.correct(step);
        for step in step {
            *step *= gamma;
        }
        true
    }

    fn excess(&mut self, step: &[f64], second: bool) -> f64 {
        let largest_move = if second { SHORT_MOVE } else { LARGEST_MOVE };
        let model = self.dynamics.model();
        let n = model.links;
        let ends = |i: usize| {
            let along = model.chain.arms[i] * turned_left(unit(self.y[2 * n + i]));
            let (center, turn) = (Vec2::new(step[i], step[n + i]), step[2 * n + i] * along);
            [center - turn, center + turn]
        };
        let mut excess: f64 = 0.0;
        for i in 0..n {
            let ([_, front], [rear, _]) = (ends(i), ends((i + 1) % n));
            let moved = |end: Vec2| end.norm() / (largest_move * 2.0 * model.half_pitch);
            // An open hinge has no clearance to keep: its two ends move independently. Ideal hinges are closed after the move.
            let joined = if model.hinge_is_open(i) {
                moved(rear)
            } else if model.hinges.ideal {
                0.0
            } else {
                (front - rear).norm() / (HINGE_SHARE * model.hinges.clearance)
            };
            excess = excess.max(joined).max(moved(front));
            if let Some(rollers) = &model.rollers
                && model.bushing_is_there(i)
            {
                let roller = Vec2::new(step[rollers.first + i], step[rollers.first + n + i]);
                let bushing = if model.link_of_bushing(i) == i {
                    front
                } else {
                    rear
                };
                let apart = (roller - bushing).norm() / (HINGE_SHARE * rollers.clearance);
                excess = excess.max(apart);
            }
        }
        for sprocket in &model.sprockets {
            sprocket.for_each_inertia(|index, _| {
                let moved = step[index].abs() * arm(sprocket, index);
                excess = excess.max(moved / (largest_move * 2.0 * model.half_pitch));
            });
        }
        excess
    }

    fn move_by(&mut self, share: f64, step: &[f64]) -> bool {
        let before = self.y.clone();
        for (q, step) in self.y.iter_mut().zip(step) {
            *q += share * step;
        }
        let closed = self.dynamics.close_ideal_hinges_nearby(&mut self.y);
        if !closed {
            self.y = before;
        }
        closed
    }
}

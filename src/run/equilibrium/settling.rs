//! Newton's method on the forces of a drive at rest, with a step γ that grows while they decrease.

use std::sync::Arc;

use crate::chain::dynamics::Dynamics;
use crate::chain::model::{Model, Rotation, SprocketModel};
use crate::chain::motion::Motion as Places;
use crate::geometry::{Vec2, turned_left, unit};
use crate::integrator::SecondOrderSystem;
use crate::layout::InitialConfiguration;

/// First γ \[s\]: a link falls by 10 nm.
const FIRST_GAMMA: f64 = 3e-5;
/// Longest γ over the pitch \[s/m\]: 64 ms at half an inch. The elimination of the links divides by their masses. Its rounding error grows
/// with the fourth power of γ over the period of a link on its contacts, which is proportional to the pitch. In a drive of half an inch
/// corrections have a relative error of a thousandth at 0.1 s, and are useless from 0.6 s on.
const LONGEST_GAMMA_PER_PITCH: f64 = 5.0;
/// Shortest γ \[s\].
const SHORTEST_GAMMA: f64 = 1e-6;
/// Number of iterations between updates of the tooth surface stored for each contact. The force jumps where two surfaces of different
/// stiffness meet, and no equilibrium may exist until one of them is kept.
const BETWEEN_MEMORIES: u32 = 500;
/// Maximum number of renewals of an equilibrium because contacts are on other surfaces than the stored ones. A contact at the junction of
/// two surfaces may alternate between them without end.
const MOST_RENEWALS: u32 = 4;
/// Largest relative displacement of the two link ends in a hinge in one iteration, over the hinge clearance.
const HINGE_SHARE: f64 = 0.2;
/// Largest displacement of any coordinate in one iteration, in pitches.
const LARGEST_MOVE: f64 = 0.02;
/// Largest displacement in the second attempt, in pitches: one or two hinge clearances, so that no bushing moves into the middle of a
/// tooth.
const SHORT_MOVE: f64 = 0.002;
/// Number of iterations after which the second attempt begins, from the start.
const FIRST_TRY: u32 = 1500;
/// Tolerated unbalanced force, over the largest contact force or external force.
const TOLERANCE: f64 = 1e-7;
/// Fraction of the tolerance that refinement aims at. Sagging strands are soft: a force of 1e-7 of their tension moves a link by more than
/// its contacts do.
const SOUGHT: f64 = 0.1;
/// Maximum number of refinement iterations; rounding may prevent their success.
const MOST_REFINEMENTS: u32 = 50;
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

/// Return the largest external force \[N\]: weight of a link, force of a tensioner, torque over a pitch radius; at least a micronewton.
fn applied_force(model: &Model) -> f64 {
    let moved = (0..model.links).filter(|&i| !model.is_held(i));
    let heaviest = moved.fold(0.0, |most: f64, i| most.max(model.chain.mass[i]));
    let outside = model.sprockets.iter().map(|sprocket| {
        let torque = sprocket.applied_torque(0.0, 0.0) / sprocket.profile.pitch_radius;
        sprocket.pull(0.0).abs().max(torque.abs())
    });
    outside.fold((model.gravity.norm() * heaviest).max(1e-6), f64::max)
}

/// Iteration of the positions to static equilibrium.
pub(super) struct Settling {
    pub(super) dynamics: Dynamics,
    pub(super) places: Places,
    pub(super) y: Vec<f64>,
    rates: Vec<f64>,
    pub(super) iterations: u32,
    /// Largest displacement of any coordinate in one iteration, in pitches.
    largest_move: f64,
}

impl Settling {
    pub(super) fn new(model: Arc<Model>, start: &InitialConfiguration) -> Self {
        let mut places = Places::new(model.bodies());
        places.set(&start.positions, &start.velocities);
        let mut y = vec![0.0; 2 * model.coordinates];
        places.write(&model, &mut y);
        Self {
            dynamics: Dynamics::new(model),
            places,
            rates: vec![0.0; y.len()],
            y,
            iterations: 0,
            largest_move: LARGEST_MOVE,
        }
    }

    /// Evaluate the accelerations at the present positions; return the largest unbalanced force \[N\].
    pub(super) fn unbalanced(&mut self) -> f64 {
        self.dynamics
            .accelerations_with_slopes(0.0, &self.y, &mut self.rates);
        let model = self.dynamics.model();
        let (n, accelerations) = (model.links, &self.rates[model.coordinates..]);
        let mut largest: f64 = 0.0;
        for i in 0..n {
            largest = largest
                .max(model.chain.mass[i] * accelerations[i].abs())
                .max(model.chain.mass[i] * accelerations[n + i].abs())
                .max(model.chain.inertia[i] * accelerations[2 * n + i].abs() / model.half_pitch);
        }
        if let Some(rollers) = &model.rollers {
            // Without friction no torque acts on the rollers.
            for acceleration in &accelerations[rollers.first..][..2 * n] {
                largest = largest.max(rollers.mass * acceleration.abs());
            }
        }
        for sprocket in &model.sprockets {
            sprocket.for_each_inertia(|index, inertia| {
                let force = inertia * accelerations[index].abs() / arm(sprocket, index);
                largest = largest.max(force);
            });
        }
        largest
    }

    pub(super) fn largest_force(&self) -> f64 {
        let hinges = self.dynamics.hinge_contacts().map(|(_, force)| force);
        let rollers = self.dynamics.roller_contacts().map(|(_, force)| force);
        let teeth = self.dynamics.candidates().map(|(_, _, _, force)| force);
        hinges.chain(rollers).chain(teeth).fold(0.0, f64::max)
    }

    /// Iterate the positions to equilibrium; return the remaining unbalanced force \[N\], as an error if the iteration ends before.
    pub(super) fn settle(&mut self, give_up: &dyn Fn() -> bool) -> std::result::Result<f64, f64> {
        let model = self.dynamics.model();
        let coordinates = model.coordinates;
        let applied = applied_force(model);
        let mut gamma = FIRST_GAMMA;
        let longest = LONGEST_GAMMA_PER_PITCH * 2.0 * model.half_pitch;
        let mut residual = self.unbalanced();
        let mut step = vec![0.0; coordinates];
        let begin = self.y.clone();
        let (mut renewals, mut refinements) = (0, 0);
        loop {
            let allowed = TOLERANCE * applied.max(self.largest_force());
            let refines = residual <= allowed
                && residual > SOUGHT * allowed
                && refinements < MOST_REFINEMENTS
                && self.iterations < MOST_ITERATIONS;
            refinements += u32::from(refines);
            if residual <= allowed && !refines {
                // The forces are in balance on the stored surfaces, which may differ from the present ones.
                let remembers = renewals < MOST_RENEWALS;
                if remembers {
                    renewals += 1;
                    self.dynamics.remember_present_contacts(0.0, &self.y);
                    residual = self.unbalanced();
                }
                if !remembers || residual <= TOLERANCE * applied.max(self.largest_force()) {
                    self.places.read(self.dynamics.model(), 0.0, &self.y);
                    return Ok(residual);
                }
            }
            if self.iterations == MOST_ITERATIONS || !residual.is_finite() || give_up() {
                return Err(residual);
            }
            self.iterations += 1;
            if self.iterations == FIRST_TRY && !refines {
                // After bushings have been thrown from tooth to tooth, no equilibrium is near any more.
                self.y.copy_from_slice(&begin);
                self.largest_move = SHORT_MOVE;
                gamma = FIRST_GAMMA;
            }
            if self.iterations == FIRST_TRY || self.iterations.is_multiple_of(BETWEEN_MEMORIES) {
                self.dynamics.remember_present_contacts(0.0, &self.y);
                residual = self.unbalanced();
            }
            // Velocity of one step from rest, γ Q/M; the matrix turns it into the backward Euler step.
            for (step, acceleration) in step.iter_mut().zip(&self.rates[coordinates..]) {
                *step = gamma * acceleration;
            }
            // A singular matrix or a step that is not finite: γ is reduced and the iteration repeated. Here γ may fall below the shortest
            // one of other steps: the matrix tends to that of the masses, which is regular, and the next step may return to it.
            if !self.dynamics.factorise_indefinite(gamma) {
                gamma *= 0.25;
                continue;
            }
            self.dynamics.correct(&mut step);
            if !step.iter().all(|step| step.is_finite()) {
                gamma *= 0.25;
                continue;
            }
            for step in &mut step {
                *step *= gamma;
            }
            // The step is shortened to the largest permitted displacement.
            let share = (1.0 / self.excess(&step)).min(1.0);
            for (q, step) in self.y.iter_mut().zip(&step) {
                *q += share * step;
            }
            let before = residual;
            residual = self.unbalanced();
            // γ grows after a full step with less than 1.2 times the residual. It shrinks after a step limited to less than a tenth, or
            // with more than twice the residual.
            gamma = if share == 1.0 && residual < 1.2 * before {
                (1.5 * gamma).min(longest)
            } else if share < 0.1 || residual > 2.0 * before {
                (0.6 * gamma).max(SHORTEST_GAMMA)
            } else {
                gamma
            };
        }
    }

    /// Return the ratio of the step to the largest permitted step.
    fn excess(&self, step: &[f64]) -> f64 {
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
            let apart = (front - rear).norm() / (HINGE_SHARE * model.hinges.clearance);
            let moved = front.norm() / (self.largest_move * 2.0 * model.half_pitch);
            excess = excess.max(apart).max(moved);
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
                excess = excess.max(moved / (self.largest_move * 2.0 * model.half_pitch));
            });
        }
        excess
    }
}

//! Laws that all forces obey: momentum, and Newton's matrix as their derivative.

use rustchain::Simulation;
use rustchain::dynamics::{Dynamics, Losses};
use rustchain::geometry::Vec2;
use rustchain::integrator::{OdeSystem, SecondOrderSystem};

/// The largest of all, whatever its sign.
pub fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |a: f64, b| a.max(b.abs()))
}

/// What is lost now and where; asserts that all forces and moments of the drive are those between its bodies.
pub fn keeps_momentum(run: &Simulation) -> Losses {
    let (t, y) = (run.integrator().time(), run.integrator().y().to_vec());
    let mut dynamics = run.dynamics().clone();
    dynamics.keep_energy(true);
    let powers = dynamics.evaluate(t, &y);
    let (model, motion) = (dynamics.model().clone(), &dynamics.motion);
    let found = &dynamics.accelerations;
    let (mut force, mut moment, mut size) = (Vec2::zeros(), 0.0, 0.0);
    for body in 0..model.links + 2 {
        let (mass, inertia) = if body < model.links {
            (model.mass[body], model.inertia[body])
        } else {
            let sprocket = &model.sprockets[body - model.links];
            (sprocket.mass, sprocket.inertia)
        };
        let own = mass * Vec2::new(found.x[body], found.y[body]);
        let place = Vec2::new(motion.x[body], motion.y[body]);
        force += own;
        moment += place.perp(&own) + inertia * found.angle[body];
        size += own.norm();
    }
    // Lengths are of a tenth of a metre; the pin's radius is two millimetres.
    assert!(force.norm() <= 1e-13 * size, "{force} of {size}");
    assert!(moment.abs() <= 1e-14 * size, "{moment} of {size}");
    powers.losses
}

/// What a correction lacks: the residual that is left by it over the one before, as norms, for random residuals.
pub fn lacks(dynamics: &mut Dynamics, t: f64, y: &[f64], gamma: f64) -> f64 {
    let nq = dynamics.model().coordinates;
    let n = dynamics.model().links;
    let rollers = dynamics
        .model()
        .rollers
        .as_ref()
        .map_or(nq, |of| of.first + 2 * n);
    let turns = move |i: usize| (2 * n..3 * n).contains(&i) || i >= rollers;
    let mut slope = vec![0.0; y.len()];
    let mut worst: f64 = 0.0;
    for seed in 0..4 {
        let residual: Vec<f64> = (0..nq)
            .map(|i| {
                let entry = ((i * 37 + seed * 101) % 17) as f64 / 17.0 - 0.5;
                if turns(i) { 300.0 * entry } else { entry }
            })
            .collect();
        dynamics.accelerations_with_slopes(t, y, &mut slope);
        assert!(dynamics.factorise(y, gamma));
        let mut first = residual.clone();
        dynamics.correct(&mut first);
        // The residual that is left, corrected: how far the first correction was off.
        let step = 1e-7 / (gamma * largest(&first).max(1e-300));
        let mut at = |sign: f64| {
            let mut z = y.to_vec();
            for i in 0..nq {
                z[i] += sign * step * gamma * gamma * first[i];
                z[nq + i] += sign * step * gamma * first[i];
            }
            let mut slope = vec![0.0; y.len()];
            dynamics.derivative(t, &z, &mut slope);
            slope
        };
        let (up, down) = (at(1.0), at(-1.0));
        let mut left: Vec<f64> = (0..nq)
            .map(|i| residual[i] - first[i] + (up[nq + i] - down[nq + i]) / (2.0 * step))
            .collect();
        dynamics.correct(&mut left);
        let norm = |x: &[f64]| {
            let weight = |i: usize| {
                if turns(i) { 6e-3 } else { 1.0 }
            };
            let squares = x.iter().enumerate().map(|(i, x)| (x * weight(i)).powi(2));
            squares.sum::<f64>().sqrt()
        };
        worst = worst.max(norm(&left) / norm(&first));
    }
    worst
}

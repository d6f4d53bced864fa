//! Ideal hinges: joints without clearance, whose forces are the multipliers of their constraints.
//!
//! Hinge k holds the front of link k on the rear of link k + 1: g = 0 for the offset g of the two points, which gives G v = 0 for the
//! velocities and G a + c = 0 for the accelerations. The forces are unknowns:
//!
//! - An evaluation of the implicit corrector takes the forces of the evaluation before. Its accelerations a lack G a + c. Newton's method
//!   corrects velocities and forces together; its matrix is that of hinges with clearance, with zero compliance.
//! - Any other evaluation solves for the forces by the same matrix with γ = 0, in which only inertias are left.
//!
//! After every fourth step positions and velocities are projected onto the constraints by the least change, weighted by the last matrix.

use pulp::{Simd, WithSimd};

use super::Kernels;
use super::chain::WriteDirections;
use crate::chain::arrays::layout::{ChainArrays, FIRST, LinkConstants};
use crate::chain::model::Model;
use crate::math::simd::{Numbers, WIDTH, padded_zeros};

/// Forces of the ideal hinges of a chain, and scratch for their constraints.
#[derive(Debug, Clone)]
pub(crate) struct IdealHinges {
    /// Force on the front of every link at the last evaluation or correction, x and y \[N\]; the rear of the next link has the opposite one.
    pub(crate) force: [Vec<f64>; 2],
    /// Force at the end of the last step, with which the next step begins.
    step_end: [Vec<f64>; 2],
    /// Whether evaluations take the forces as given; otherwise they solve for them.
    pub(super) takes_forces: bool,
    /// γ of the factors of the implicit corrector.
    pub(super) gamma: f64,
    /// Accelerations of the links at the last evaluation, or of the formula at the last correction: x, y and angle.
    trial: Vec<f64>,
    /// Angular velocities of the links at the last evaluation \[rad/s\].
    spin: Vec<f64>,
    /// Hinges without a joint: the open ones of an open chain.
    open: Vec<usize>,
    /// Scratch: right-hand sides of the constraints.
    lack: [Numbers; 2],
    /// Scratch: directions of the links, cosines and sines.
    direction: [Numbers; 2],
    /// Scratch: fronts, x and y, and rears; a copy of the first rear follows the last.
    ends: [Numbers; 4],
    /// Scratch: correction of all coordinates but the bristles'.
    change: Vec<f64>,
    /// Residual of the velocities with the corrected forces.
    pub(super) residual: Vec<f64>,
}

impl IdealHinges {
    /// Return the ideal hinges of `model`; none where its hinges have clearance.
    pub(super) fn of(model: &Model) -> Option<Self> {
        let n = model.links;
        let zeros = || [vec![0.0; n], vec![0.0; n]];
        let padded = || [padded_zeros(n), padded_zeros(n)];
        model.hinges.ideal.then(|| Self {
            force: zeros(),
            step_end: zeros(),
            takes_forces: false,
            gamma: 0.0,
            trial: vec![0.0; 3 * n],
            spin: vec![0.0; n],
            open: model.open_hinges().collect(),
            lack: padded(),
            direction: [padded_zeros(n + WIDTH), padded_zeros(n + WIDTH)],
            ends: [(); 4].map(|()| padded_zeros(n + WIDTH)),
            change: vec![0.0; model.body_coordinates()],
            residual: vec![0.0; model.coordinates],
        })
    }

    /// Return the forces at the end of the last step, which belong to the state of a run.
    pub(crate) fn step_end(&self) -> &[Vec<f64>; 2] {
        &self.step_end
    }

    /// Begin from these forces of all hinges.
    pub(crate) fn begin_from(&mut self, forces: &[Vec<f64>; 2]) {
        self.force.clone_from(forces);
        self.step_end.clone_from(forces);
    }

    /// Correct the forces on the links by the `changes` of a solution: the geometric stiffness in the matrix follows from these forces.
    fn correct_links(changes: [&[f64]; 2], chain: &mut ChainArrays) {
        for (axis, change) in changes.into_iter().enumerate() {
            let n = change.len() - 1;
            let (front, rear) = (&mut chain.front_force[axis], &mut chain.rear_force[axis]);
            for (force, change) in front.iter_mut().zip(&change[1..]) {
                *force -= change;
            }
            for (force, change) in rear[FIRST..].iter_mut().zip(&change[..n]) {
                *force += change;
            }
        }
    }

    /// Write the forces on the links, which have none of other hinges.
    fn push(&self, chain: &mut ChainArrays) {
        for (axis, force) in self.force.iter().enumerate() {
            let n = force.len();
            chain.front_force[axis][..n].copy_from_slice(force);
            let rear = &mut chain.rear_force[axis][FIRST + 1..][..n];
            for (rear, force) in rear.iter_mut().zip(force) {
                *rear = -force;
            }
        }
    }
}

/// What the offsets at the hinges are those of; see [`WriteOffsets`].
#[derive(Clone, Copy)]
enum Level {
    Positions,
    Velocities,
    Accelerations,
}

/// Kernel that writes the offset of the two ends at each hinge, front minus rear, or its first or second derivative: plain loops that the
/// compiler vectorizes for the instruction set.
///
/// An end at r from the centre x of its link is at x + r, and moves with v + ω × r and a + α × r - ω² r.
struct WriteOffsets<'a> {
    level: Level,
    /// Factor of the offsets.
    scale: f64,
    /// x, y and angle of the links, or their derivatives.
    of_links: [&'a [f64]; 3],
    /// ω of the links, for accelerations \[rad/s\].
    spin: &'a [f64],
    direction: [&'a [f64]; 2],
    arm: &'a [f64],
    ends: &'a mut [Numbers; 4],
    offset: &'a mut [Numbers; 2],
    /// Hinges without a joint, whose offset is written as zero.
    open: &'a [usize],
}

impl WithSimd for WriteOffsets<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        // r times `along` plus the turned r times `across` of the angle's derivative.
        let (square, along, across) = match self.level {
            Level::Positions => (0.0, 1.0, 0.0),
            Level::Velocities => (0.0, 0.0, 1.0),
            Level::Accelerations => (-1.0, 0.0, 1.0),
        };
        let [x, y, turn] = self.of_links;
        let n = x.len();
        let (y, turn, spin, arm) = (&y[..n], &turn[..n], &self.spin[..n], &self.arm[..n]);
        let [cos, sin] = self.direction.map(|of| &of[..n]);
        let [front_x, front_y, rear_x, rear_y] = self.ends;
        {
            let (front_x, front_y) = (&mut front_x[..n], &mut front_y[..n]);
            let (rear_x, rear_y) = (&mut rear_x[..n], &mut rear_y[..n]);
            for k in 0..n {
                let (u, v) = (arm[k] * cos[k], arm[k] * sin[k]);
                let factor = square * spin[k] * spin[k] + along;
                let turn = across * turn[k];
                let (dx, dy) = (factor * u - turn * v, factor * v + turn * u);
                front_x[k] = x[k] + dx;
                front_y[k] = y[k] + dy;
                rear_x[k] = x[k] - dx;
                rear_y[k] = y[k] - dy;
            }
        }
        (rear_x[n], rear_y[n]) = (rear_x[0], rear_y[0]);
        let scale = self.scale;
        let [offset_x, offset_y] = self.offset;
        let (offset_x, offset_y) = (&mut offset_x[..n], &mut offset_y[..n]);
        let (front_x, front_y) = (&front_x[..n], &front_y[..n]);
        let (rear_x, rear_y) = (&rear_x[1..=n], &rear_y[1..=n]);
        for k in 0..n {
            offset_x[k] = scale * (front_x[k] - rear_x[k]);
            offset_y[k] = scale * (front_y[k] - rear_y[k]);
        }
        for &k in self.open {
            (offset_x[k], offset_y[k]) = (0.0, 0.0);
        }
    }
}

/// Kernel that corrects the forces of the hinges by -`change`/γ, and `residual` to that with the corrected forces.
struct TakeForces<'a> {
    gamma: f64,
    /// γ times the changes, those on fronts with opposite sign; that of the last hinge precedes the first.
    change: [&'a [f64]; 2],
    force: &'a mut [Vec<f64>; 2],
    residual: &'a mut [f64],
    direction: [&'a [f64]; 2],
    constants: &'a LinkConstants,
}

impl WithSimd for TakeForces<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let n = self.force[0].len();
        let over = 1.0 / self.gamma;
        for (force, change) in self.force.iter_mut().zip(self.change) {
            for (force, change) in force.iter_mut().zip(&change[1..=n]) {
                *force -= over * change;
            }
        }
        let [x, y, turn] = of_links_mut(self.residual, n);
        let LinkConstants {
            front_arm,
            inverse_mass,
            inverse_inertia,
            ..
        } = self.constants;
        let (arm, light) = (&front_arm[..n], &inverse_mass[..n]);
        let turns = &inverse_inertia[..n];
        let [cos, sin] = self.direction.map(|of| &of[..n]);
        // The change of a hinge acts on the front of its link, and with opposite sign on the rear of the next one.
        let [(front_x, rear_x), (front_y, rear_y)] =
            self.change.map(|change| (&change[1..=n], &change[..n]));
        for k in 0..n {
            x[k] -= light[k] * (front_x[k] - rear_x[k]);
            y[k] -= light[k] * (front_y[k] - rear_y[k]);
            let lever = cos[k] * (front_y[k] + rear_y[k]) - sin[k] * (front_x[k] + rear_x[k]);
            turn[k] -= turns[k] * (arm[k] * lever);
        }
    }
}

/// Kernel that adds `factor` times `change` to `to`, vectorized by the compiler.
struct AddScaled<'a> {
    to: &'a mut [f64],
    factor: f64,
    change: &'a [f64],
}

impl WithSimd for AddScaled<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (to, change) in self.to.iter_mut().zip(self.change) {
            *to += self.factor * change;
        }
    }
}

impl Kernels {
    /// Return to the forces of ideal hinges at the end of the last step: evaluations outside of the steps change them.
    pub(crate) fn return_to_step_end(&mut self) {
        if let Some(ideal) = self.ideal.as_deref_mut() {
            for (force, kept) in ideal.force.iter_mut().zip(&ideal.step_end) {
                force.copy_from_slice(kept);
            }
        }
    }

    /// Keep the forces of ideal hinges as those at the end of the last step.
    pub(crate) fn end_step(&mut self) {
        if let Some(ideal) = self.ideal.as_deref_mut() {
            for (kept, force) in ideal.step_end.iter_mut().zip(&ideal.force) {
                kept.copy_from_slice(force);
            }
        }
    }

    /// Add the forces of ideal hinges to the links. An evaluation that solves for them begins without any, so that its result depends on
    /// the state alone.
    pub(super) fn push_by_hinges(&mut self) {
        if let Some(ideal) = self.ideal.as_deref_mut() {
            if !ideal.takes_forces {
                for force in &mut ideal.force {
                    force.fill(0.0);
                }
            }
            ideal.push(&mut self.chain);
        }
    }

    /// Solve for the forces of the hinges unless they are given, and keep the accelerations.
    pub(super) fn close_hinges(
        &mut self,
        model: &Model,
        pawls: &[f64],
        (t, y): (f64, &[f64]),
        accelerations: &mut [f64],
    ) {
        let Some(mut ideal) = self.ideal.take() else {
            return;
        };
        let n = model.links;
        (ideal.spin).copy_from_slice(&y[model.coordinates + 2 * n..][..n]);
        if !ideal.takes_forces {
            self.instructions.run(WriteOffsets {
                level: Level::Accelerations,
                scale: 1.0,
                of_links: of_links(accelerations, n),
                spin: &ideal.spin,
                direction: [&self.chain.cos, &self.chain.sin],
                arm: &self.links.front_arm,
                ends: &mut ideal.ends,
                offset: &mut ideal.lack,
                open: &ideal.open,
            });
            self.factorise(model, pawls, 0.0, true);
            if let Some(newton) = &mut self.newton {
                newton.close(model, self.instructions, &mut ideal.change, &ideal.lack);
                let changes = newton.changes_of_hinge_forces();
                for (to, change) in ideal.force.iter_mut().zip(changes) {
                    let (factor, change) = (-1.0, &change[1..]);
                    self.instructions.run(AddScaled { to, factor, change });
                }
                IdealHinges::correct_links(changes, &mut self.chain);
                self.instructions.run(AddScaled {
                    to: accelerations,
                    factor: 1.0,
                    change: &ideal.change,
                });
            }
            if let Some(ends) = &model.ends {
                // The matrix has a large mass in the place of a prescribed motion, which the forces have changed by 1e-20 of them.
                self.move_ends(ends, t, accelerations);
            }
        }
        ideal.trial.copy_from_slice(&accelerations[..3 * n]);
        self.ideal = Some(ideal);
    }

    /// Overwrite a residual of the velocities with the correction, and correct the forces of ideal hinges with them.
    pub(super) fn correct_with_hinge_forces(&mut self, model: &Model, residual: &mut [f64]) {
        let (Some(ideal), Some(newton)) = (&mut self.ideal, &mut self.newton) else {
            return;
        };
        let ideal = &mut **ideal;
        let n = model.links;
        let direction = [&self.chain.cos[..n], &self.chain.sin[..n]];
        // The accelerations of the formula are those of the evaluation less residual/γ.
        self.instructions.run(AddScaled {
            to: &mut ideal.trial,
            factor: -1.0 / ideal.gamma,
            change: residual,
        });
        self.instructions.run(WriteOffsets {
            level: Level::Accelerations,
            scale: ideal.gamma,
            of_links: of_links(&ideal.trial, n),
            spin: &ideal.spin,
            direction,
            arm: &self.links.front_arm,
            ends: &mut ideal.ends,
            offset: &mut ideal.lack,
            open: &ideal.open,
        });
        ideal.residual[..residual.len()].copy_from_slice(residual);
        newton.correct(model, self.instructions, residual, Some(&ideal.lack));
        self.instructions.run(TakeForces {
            gamma: ideal.gamma,
            change: newton.changes_of_hinge_forces(),
            force: &mut ideal.force,
            residual: &mut ideal.residual,
            direction,
            constants: &self.links,
        });
    }

    /// Project positions and velocities in `y`, the end of a step, onto the constraints by the last matrix; return the largest offset of
    /// two ends before \[m\].
    pub(crate) fn project_hinges(&mut self, model: &Model, y: &mut [f64]) -> f64 {
        let (Some(ideal), Some(newton)) = (&mut self.ideal, &mut self.newton) else {
            return 0.0;
        };
        let ideal = &mut **ideal;
        let n = model.links;
        let (q, v) = y.split_at_mut(model.coordinates);
        let v = &mut v[..model.coordinates];
        let [cos, sin] = &mut ideal.direction;
        let angle = &q[2 * n..3 * n];
        self.instructions.run(WriteDirections { angle, cos, sin });
        let direction = [&ideal.direction[0][..n], &ideal.direction[1][..n]];
        let mut worst = 0.0f64;
        for (level, coordinates) in [(Level::Positions, q), (Level::Velocities, v)] {
            self.instructions.run(WriteOffsets {
                level,
                scale: 1.0,
                of_links: of_links(coordinates, n),
                spin: &ideal.direction[0],
                direction,
                arm: &self.links.front_arm,
                ends: &mut ideal.ends,
                offset: &mut ideal.lack,
                open: &ideal.open,
            });
            if let Level::Positions = level {
                let all = ideal.lack.iter().flat_map(|lack| lack[..n].iter());
                worst = all.fold(0.0, |worst, lack| lack.abs().max(worst));
            }
            newton.close(model, self.instructions, &mut ideal.change, &ideal.lack);
            self.instructions.run(AddScaled {
                to: coordinates,
                factor: 1.0,
                change: &ideal.change,
            });
        }
        worst
    }
}

/// Return x, y and angle of the links among all coordinates.
fn of_links(coordinates: &[f64], links: usize) -> [&[f64]; 3] {
    [0, 1, 2].map(|axis| &coordinates[axis * links..(axis + 1) * links])
}

/// Return the same to write.
fn of_links_mut(coordinates: &mut [f64], links: usize) -> [&mut [f64]; 3] {
    let (x, rest) = coordinates.split_at_mut(links);
    let (y, rest) = rest.split_at_mut(links);
    [x, y, &mut rest[..links]]
}

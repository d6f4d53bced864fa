//! Coordinates of the sprockets on the border of Newton's matrix, and the small dense system of the border.

use super::tooth_motion::BorderMotion;
use crate::chain::arrays::pose::SprocketPose;
use crate::chain::model::{Model, Rotation, SprocketModel, Support};
use crate::math::dense::Dense;

/// Coordinates of one sprocket: numbers `first`, `first` + 1, ... on the border.
#[derive(Debug, Clone)]
pub(super) struct SprocketMotions {
    pub(super) first: usize,
    pub(super) motions: Vec<BorderMotion>,
}

impl SprocketMotions {
    /// Return the coordinates of all sprockets of `model`.
    pub(super) fn of(model: &Model) -> Vec<Self> {
        let start = 3 * model.links;
        let mut all = Vec::with_capacity(model.sprockets.len());
        for sprocket in &model.sprockets {
            let mut found = Vec::new();
            match sprocket.support {
                Support::Fixed => {}
                Support::Slide {
                    index, direction, ..
                } => found.push((index - start, BorderMotion::Along(direction.into()))),
                Support::Floating { x, y } => {
                    found.push((x - start, BorderMotion::Along([1.0, 0.0])));
                    found.push((y - start, BorderMotion::Along([0.0, 1.0])));
                }
            }
            if let Rotation::Free { index, .. } = sprocket.rotation {
                found.push((index - start, BorderMotion::Turn));
            }
            let first = found.first().map_or(0, |(index, _)| *index);
            debug_assert!(
                found
                    .iter()
                    .enumerate()
                    .all(|(i, (index, _))| *index == first + i)
            );
            all.push(Self {
                first,
                motions: found.into_iter().map(|(_, motion)| motion).collect(),
            });
        }
        all
    }

    /// Update the direction of a slide to the tangent of its guide path at the sprocket's centre.
    pub(super) fn follow(&mut self, sprocket: &SprocketModel, pose: &SprocketPose) {
        if let (Some(BorderMotion::Along(way)), Some((_, tangent))) = (
            self.motions.first_mut(),
            sprocket.slide_at(pose.center.into()),
        ) {
            *way = tangent.into();
        }
    }
}

/// Diagonal block of the border's coordinates.
#[derive(Debug, Clone)]
pub(super) struct Corner {
    matrix: Dense,
    /// Inverse in row-major order, for sizes up to 2x2.
    inverse: [f64; 4],
    /// Mass or moment of inertia of each coordinate.
    inertias: Vec<f64>,
    /// Diagonal entries without teeth.
    own: Vec<f64>,
}

impl Corner {
    /// Allocate the block of the coordinates of `model`.
    pub(super) fn of(model: &Model) -> Self {
        let mut inertias = vec![0.0; model.wheel_coordinates()];
        for sprocket in &model.sprockets {
            sprocket.for_each_inertia(|index, inertia| {
                inertias[index - 3 * model.links] = inertia;
            });
        }
        Self::new(inertias)
    }

    /// Allocate a block of coordinates with these masses and moments of inertia.
    fn new(inertias: Vec<f64>) -> Self {
        Self {
            matrix: Dense::new(inertias.len()),
            inverse: [0.0; 4],
            own: inertias.clone(),
            inertias,
        }
    }

    /// Multiply residuals by masses and moments of inertia.
    pub(super) fn weigh(&self, residuals: &mut [f64]) {
        for (residual, inertia) in residuals.iter_mut().zip(&self.inertias) {
            *residual *= inertia;
        }
    }

    /// Assemble masses, and dashpots, springs and stops of tensioners and arms. A dashpot with two rates enters with the larger
    /// one.
    pub(super) fn start(
        &mut self,
        model: &Model,
        (poses, pawls): (&[SprocketPose], &[f64]),
        gamma: f64,
    ) {
        let start = 3 * model.links;
        self.own.copy_from_slice(&self.inertias);
        for ((sprocket, pose), &pawl) in model.sprockets.iter().zip(poses).zip(pawls) {
            // A = M - γ dQ/dv - γ² dQ/dq for a force -d v - k q: γ d + γ² k.
            if let Support::Slide {
                index,
                damping,
                guide,
                ..
            } = sprocket.support
            {
                let (s, _) = sprocket.slide_at(pose.center.into()).unwrap_or_default();
                self.own[index - start] += gamma * (damping + gamma * guide.stiffness_at(s, pawl));
            }
            if let (Some(swing), Rotation::Free { index, .. }) =
                (sprocket.swing, &sprocket.rotation)
            {
                let [back, forth] = swing.dashpots;
                let stiffness = swing.stiffness_at(pose.angle - sprocket.phase, pawl);
                self.own[*index - start] += gamma * (back.max(forth) + gamma * stiffness);
            }
        }
        self.matrix.set_diagonal(&self.own);
    }

    /// Return whether teeth contribute less than this share to each diagonal entry.
    pub(super) fn is_bound_weakly(&self, share: f64) -> bool {
        let mut entries = self.own.iter().zip(self.matrix.diagonal());
        entries.all(|(own, all)| (all - own).abs() < share * all.abs())
    }

    /// Add `value` to one entry.
    pub(super) fn add(&mut self, row: usize, column: usize, value: f64) {
        self.matrix.add(row, column, value);
    }

    /// Factorise; return false where the block is singular. Sizes up to 2x2 use the closed-form inverse.
    pub(super) fn factorise(&mut self) -> bool {
        match *self.matrix.entries() {
            [a] => {
                let over = 1.0 / a;
                self.inverse[0] = over;
                over != 0.0 && over.is_finite()
            }
            [a, b, c, d] => {
                let over = 1.0 / (a * d - b * c);
                self.inverse = [d * over, -b * over, -c * over, a * over];
                over != 0.0 && over.is_finite()
            }
            _ => self.matrix.factorise(),
        }
    }

    /// Solve in place.
    pub(super) fn solve(&self, right: &mut [f64]) {
        let [a, b, c, d] = self.inverse;
        match right {
            [x] => *x *= a,
            [x, y] => (*x, *y) = (a * *x + b * *y, c * *x + d * *y),
            _ => self.matrix.solve(right),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_diagonal_entry_without_a_finite_inverse_is_refused_at_any_size() {
        for size in 1..=4 {
            for (wrong, regular) in [
                (2.0, true),
                (0.0, false),
                (f64::INFINITY, false),
                (f64::NAN, false),
            ] {
                let mut corner = Corner::new(vec![1.0; size]);
                for i in 0..size {
                    corner.add(i, i, if i == 0 { wrong } else { 1.0 });
                }
                assert_eq!(corner.factorise(), regular, "size {size}, entry {wrong}");
            }
        }
    }
}

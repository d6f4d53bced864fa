//! Rollers in the exact matrix: eliminated one by one, for each is coupled with its own link and the border only.

use nalgebra::{Matrix3, Vector3};

use super::chain_solver::ChainMatrix;
use super::jacobian::{Lever, PointForce, block};
use crate::chain::model::RollerModel;

/// Blocks of all rollers, and what elimination leaves.
pub(super) struct RollerMatrix {
    first: usize,
    /// Blocks of rollers with themselves and with the border.
    own: ChainMatrix,
    /// The link that each roller's bushing is on.
    links: Vec<usize>,
    /// Rows of that link, columns of the roller.
    to_link: Vec<Matrix3<f64>>,
    /// Rows of the roller, columns of that link.
    from_link: Vec<Matrix3<f64>>,
    inverse: Vec<Matrix3<f64>>,
}

impl RollerMatrix {
    /// Masses alone.
    pub(super) fn new(rollers: &RollerModel, links: Vec<usize>, border: usize) -> Self {
        let n = links.len();
        let mut own = ChainMatrix::new(n, border);
        for block in &mut own.diagonal {
            *block =
                Matrix3::from_diagonal(&Vector3::new(rollers.mass, rollers.mass, rollers.inertia));
        }
        Self {
            first: rollers.first,
            own,
            links,
            to_link: vec![Matrix3::zeros(); n],
            from_link: vec![Matrix3::zeros(); n],
            inverse: vec![Matrix3::zeros(); n],
        }
    }

    /// Adds roller `k` on its bushing, both with these levers.
    pub(super) fn add_joint(
        &mut self,
        chain: &mut ChainMatrix,
        k: usize,
        force: &PointForce,
        bushing: &[Lever; 3],
        roller: &[Lever; 3],
    ) {
        chain.add_body(self.links[k], force, bushing);
        self.own.add_body(k, force, roller);
        self.to_link[k] += block(force, bushing, roller);
        self.from_link[k] += block(force, roller, bushing);
    }

    /// Adds roller `k` on a sprocket with these coordinates.
    pub(super) fn add_tooth(
        &mut self,
        k: usize,
        force: &PointForce,
        roller: &[Lever; 3],
        sprocket: &[(usize, Lever)],
    ) {
        self.own.add_tooth(k, force, roller, sprocket);
    }

    /// Takes the rollers out of the chain's matrix; false when a block has no inverse.
    pub(super) fn eliminate(&mut self, chain: &mut ChainMatrix) -> bool {
        let m = chain.border();
        for (entry, own) in chain.corner.iter_mut().zip(&self.own.corner) {
            *entry += own;
        }
        for (k, &link) in self.links.iter().enumerate() {
            let Some(inverse) = self.own.diagonal[k].try_inverse() else {
                return false;
            };
            let follows = inverse * self.from_link[k];
            chain.diagonal[link] -= self.to_link[k] * follows;
            for j in 0..m {
                let column = inverse * self.own.column[k * m + j];
                chain.column[link * m + j] -= self.to_link[k] * column;
                chain.row[link * m + j] -= self.own.row[k * m + j] * follows;
                for i in 0..m {
                    chain.corner[i * m + j] -= (self.own.row[k * m + i] * column)[0];
                }
            }
            self.inverse[k] = inverse;
        }
        true
    }

    /// Solves for `right`, which holds links, border and rollers, with the chain's factors.
    pub(super) fn solve(&self, chain: &mut ChainMatrix, right: &mut [f64]) {
        let (n, m) = (self.links.len(), chain.border());
        let (rest, rollers) = right.split_at_mut(self.first);
        let of = |right: &[f64], i: usize| Vector3::new(right[i], right[n + i], right[2 * n + i]);
        for (k, &link) in self.links.iter().enumerate() {
            let free = self.inverse[k] * of(rollers, k);
            let felt = self.to_link[k] * free;
            for axis in 0..3 {
                rest[axis * n + link] -= felt[axis];
            }
            for j in 0..m {
                rest[3 * n + j] -= (self.own.row[k * m + j] * free)[0];
            }
        }
        chain.solve(rest);
        for (k, &link) in self.links.iter().enumerate() {
            let mut own = of(rollers, k) - self.from_link[k] * of(rest, link);
            for j in 0..m {
                own -= self.own.column[k * m + j] * rest[3 * n + j];
            }
            let solved = self.inverse[k] * own;
            for axis in 0..3 {
                rollers[axis * n + k] = solved[axis];
            }
        }
    }
}

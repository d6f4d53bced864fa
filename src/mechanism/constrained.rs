//! Which factors the constrained equations are solved by: dense ones that know all, or sparse ones for large mechanisms.

use super::equation::Row;
use super::kkt::Kkt;
use super::model::MechanismModel;
use super::sparse::SparseKkt;

/// Factors of the constrained equations at one state.
#[derive(Debug, Clone)]
pub(super) enum Constrained {
    Dense(Kkt),
    Sparse(SparseKkt),
}

/// From so many constraints on, and with mass everywhere, the factors are sparse.
const SPARSE_FROM: usize = 64;

impl Constrained {
    pub(super) fn new(model: &MechanismModel) -> Self {
        let rows = model.constraints();
        if rows >= SPARSE_FROM && model.mass.iter().all(|&m| m > 0.0) {
            let bodies = model.equations.iter();
            let bodies: Vec<_> = bodies.map(|e| [e.a.body, e.b.body, e.carrier]).collect();
            return Self::Sparse(SparseKkt::new(&model.mass, &model.first, &bodies));
        }
        Self::Dense(Kkt::new(&model.mass, &model.first, rows))
    }

    /// Number of independent constraints at the state of the last factors.
    pub(super) fn rank(&self) -> usize {
        match self {
            Self::Dense(kkt) => kkt.rank(),
            Self::Sparse(kkt) => kkt.rank(),
        }
    }

    /// How independent the constraints are: the least part of a row that those before it leave.
    pub(super) fn independence(&self) -> f64 {
        match self {
            Self::Dense(kkt) => kkt.independence(),
            Self::Sparse(kkt) => kkt.independence(),
        }
    }

    /// Leaves out what is less independent than `part`, until the next factors.
    pub(super) fn truncate(&mut self, part: f64) {
        match self {
            Self::Dense(kkt) => kkt.truncate(part),
            Self::Sparse(kkt) => kkt.truncate(part),
        }
    }

    pub(super) fn factorise(&mut self, rows: &[Row]) {
        match self {
            Self::Dense(kkt) => kkt.factorise(rows),
            Self::Sparse(kkt) => kkt.factorise(rows),
        }
    }

    /// Accelerations and multipliers; false when a motion has no mass.
    pub(super) fn solve(
        &mut self,
        forces: &[f64],
        rows: &[Row],
        accelerations: &mut [f64],
        multipliers: &mut [f64],
    ) -> bool {
        match self {
            Self::Dense(kkt) => kkt.solve(forces, rows, accelerations, multipliers),
            Self::Sparse(kkt) => {
                kkt.solve(forces, rows, accelerations, multipliers);
                true
            }
        }
    }

    /// Adds to `change` the least change (weighed by mass) of coordinates that takes `residual` off the constraints.
    pub(super) fn correct(&mut self, rows: &[Row], residual: &[f64], change: &mut [f64]) {
        match self {
            Self::Dense(kkt) => kkt.correct(residual, change),
            Self::Sparse(kkt) => kkt.correct(rows, residual, change),
        }
    }
}

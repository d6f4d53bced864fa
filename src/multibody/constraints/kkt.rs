//! Which factors the constrained equations are solved by: sparse ones, or dense ones where bodies have no mass.

use super::dense_kkt::Kkt;
use super::equation::Row;
use super::sparse_kkt::SparseKkt;
use crate::multibody::model::MechanismModel;

/// Factors of the constrained equations at one state.
#[derive(Debug, Clone)]
pub(crate) enum Constrained {
    Dense(Kkt),
    Sparse(SparseKkt),
}

impl Constrained {
    pub(crate) fn new(model: &MechanismModel) -> Self {
        if model.mass.iter().all(|&m| m > 0.0) {
            let bodies = model.equations.iter();
            let bodies: Vec<_> = bodies.map(|e| [e.a.body, e.b.body, e.carrier]).collect();
            return Self::Sparse(SparseKkt::new(&model.mass, &model.first, &bodies));
        }
        Self::Dense(Kkt::new(&model.mass, &model.first, model.constraints()))
    }

    /// Number of independent constraints at the state of the last factors.
    pub(crate) fn rank(&self) -> usize {
        match self {
            Self::Dense(kkt) => kkt.rank(),
            Self::Sparse(kkt) => kkt.rank(),
        }
    }

    /// How independent the constraints are: the least part of a row that those before it leave.
    pub(crate) fn independence(&self) -> f64 {
        match self {
            Self::Dense(kkt) => kkt.independence(),
            Self::Sparse(kkt) => kkt.independence(),
        }
    }

    /// Factors without constraints of which the others leave less than `part`.
    pub(crate) fn factorise(&mut self, rows: &[Row], part: f64) {
        match self {
            Self::Dense(kkt) => kkt.factorise(rows, part),
            Self::Sparse(kkt) => kkt.factorise(rows, part),
        }
    }

    /// Constraints that those described before them imply.
    pub(crate) fn dependent(&mut self) -> Vec<usize> {
        match self {
            Self::Dense(kkt) => kkt.dependent(),
            Self::Sparse(kkt) => kkt.dependent(),
        }
    }

    /// Accelerations and multipliers; false when a motion has no mass.
    pub(crate) fn solve(
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
    pub(crate) fn correct(&mut self, residual: &[f64], change: &mut [f64]) {
        match self {
            Self::Dense(kkt) => kkt.correct(residual, change),
            Self::Sparse(kkt) => kkt.correct(residual, change),
        }
    }
}

//! Sparse solution of the constrained equations of motion: S λ = G M⁻¹ f - γ with S = G M⁻¹ Gᵀ.
//!
//! The order of elimination (least degree first) and the places of all entries are determined once. The cost of a state is
//! proportional to the number of operations on these entries; for a chain of hinges, open or closed, it is constant per link. A
//! constraint whose pivot vanishes depends on others and is left out; `null_space.rs` then distributes the multipliers. The pivots of
//! S are squares of the independence of constraints. Nearly dependent constraints are therefore eliminated in double-double
//! precision.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::equation::EquationRow;
use super::jacobian::{Jacobian, by_body};
use crate::math::double_double::{Number, Twice};
use crate::math::sparse_kkt::ldlt::{Factors, Structure};
use crate::math::sparse_kkt::null_space::NullSpace;
use crate::math::sparse_kkt::symbolic::{
    Tie, least_degree_order, patterns, rows_on_bodies, upper_triangle,
};
use crate::multibody::model::MechanismModel;

/// Factors L D Lᵀ of S, with work arrays.
#[derive(Debug, Clone)]
pub(crate) struct SparseKkt {
    pub(crate) inverse_mass: Vec<f64>,
    pub(crate) jacobian: Arc<Jacobian>,
    /// Place of each constraint in the order of elimination.
    place: Vec<usize>,
    /// Products of rows of G that contribute to the entries of S.
    meetings: Vec<Meeting>,
    structure: Structure,
    factors: Factors<f64>,
    /// Constraint rows of the factors.
    factorised: Vec<EquationRow>,
    /// Factors in double-double precision, once they are needed.
    twice: Option<Box<Factors<Twice>>>,
    /// Multipliers without effect on the motion, where constraints were left out; `None` until they are needed.
    null_space: Option<NullSpace>,
    right: Vec<f64>,
    /// Work array: G times the accelerations.
    product: Vec<f64>,
}

/// Contribution of two constraints on the same body to an entry of S.
#[derive(Debug, Clone, Copy)]
struct Meeting {
    rows: [usize; 2],
    parts: [usize; 2],
    /// First coordinate of the body.
    first: usize,
    entry: usize,
}

/// Independence below which a constraint counts as dependent; it exceeds the round-off of points that many joints constrain together.
const DEPENDENT: f64 = 1e-10;

/// Pivot over its diagonal entry below which round-off makes the pivot inaccurate.
const ROUNDED: f64 = 1e-6;

impl SparseKkt {
    /// Return the factors for the constraints of `model`; all masses must be above zero.
    pub(crate) fn new(model: &MechanismModel, jacobian: Arc<Jacobian>) -> Self {
        let bodies = model.equations.iter();
        let bodies: Vec<_> = bodies.map(|e| [e.a.body, e.b.body, e.carrier]).collect();
        let (m, first) = (bodies.len(), &model.first);
        let on_body = rows_on_bodies(first, &bodies);
        // Two constraints have an entry in S where they act on a common body.
        let mut neighbours = vec![BTreeSet::new(); m];
        for rows in &on_body {
            for &(i, _) in rows {
                neighbours[i].extend(rows.iter().map(|&(j, _)| j).filter(|&j| j != i));
            }
        }
        let order = least_degree_order(neighbours.clone(), m, Tie::Described);
        let mut place = vec![0; m];
        for (k, &row) in order.iter().enumerate() {
            place[row] = k;
        }
        let (start, above) = upper_triangle(&order, &place, &neighbours);
        let mut meetings = Vec::new();
        for (rows, first) in on_body.iter().zip(first) {
            let Some(first) = *first else { continue };
            for &(i, part_i) in rows {
                for &(j, part_j) in rows {
                    if place[i] <= place[j] {
                        let column = start[place[j]]..start[place[j] + 1];
                        let found = above[column.clone()].binary_search(&place[i]);
                        meetings.push(Meeting {
                            rows: [i, j],
                            parts: [part_i, part_j],
                            first,
                            entry: column.start + found.unwrap_or(0),
                        });
                    }
                }
            }
        }
        let pattern = patterns(&start, &above);
        let structure = Structure::new((start, above), pattern);
        Self {
            inverse_mass: model.mass.iter().map(|m| 1.0 / m).collect(),
            jacobian,
            place,
            meetings,
            factors: Factors::new(&structure),
            structure,
            factorised: vec![EquationRow::default(); m],
            twice: None,
            null_space: None,
            right: vec![0.0; m],
            product: vec![0.0; m],
        }
    }

    /// Return the number of independent constraints.
    pub(crate) fn rank(&self) -> usize {
        self.factors.rank
    }

    /// Return the independence of the constraints: the least norm, in parts, of what remains of one after those eliminated before it.
    pub(crate) fn independence(&self) -> f64 {
        self.factors.least.sqrt()
    }

    /// Return the constraints that depend on those described before them.
    pub(crate) fn dependent(&mut self) -> Vec<usize> {
        self.find_null_space();
        let space = self.null_space.as_ref();
        space.map_or_else(Vec::new, |space| space.last_rows(&self.place))
    }

    /// Assemble and factorise S, without constraints whose independence is below `part`.
    pub(crate) fn factorise(&mut self, rows: &[EquationRow], part: f64) {
        self.null_space = None;
        self.factorised.copy_from_slice(rows);
        let entries = &mut self.factors.entries;
        gather(&self.meetings, &self.inverse_mass, rows, entries);
        self.factors
            .eliminate(&self.structure, (part * part).max(DEPENDENT * DEPENDENT));
        // Pivots are squares of the independence, so a threshold below √ROUNDED is not resolved in double precision.
        let certain = self.rank() == rows.len() && self.factors.least > ROUNDED;
        if part * part < ROUNDED && !certain {
            self.factorise_twice(rows, part.max(DEPENDENT));
        }
    }

    /// Factorise in double-double precision.
    fn factorise_twice(&mut self, rows: &[EquationRow], part: f64) {
        let taken = self.twice.take();
        let mut twice = taken.unwrap_or_else(|| Box::new(Factors::new(&self.structure)));
        gather(&self.meetings, &self.inverse_mass, rows, &mut twice.entries);
        twice.eliminate(&self.structure, part * part);
        let factors = &mut self.factors;
        let numbers = factors.values.iter_mut().zip(&twice.values);
        numbers.for_each(|(value, twice)| *value = twice.rounded());
        let pivots = factors.inverse_pivots.iter_mut().zip(&twice.inverse_pivots);
        pivots.for_each(|(pivot, twice)| *pivot = twice.rounded());
        (factors.rank, factors.least) = (twice.rank, twice.least);
        self.twice = Some(twice);
    }

    /// Compute the multipliers without effect on the motion: one vector for each constraint k left out.
    ///
    /// Lᵀ n = `e_k`. One refinement subtracts the solution x of S x = S n over the constraints that are kept.
    fn find_null_space(&mut self) {
        if self.null_space.is_some() {
            return;
        }
        let mut space = NullSpace::default();
        let m = self.structure.order();
        for k in 0..m {
            if self.factors.inverse_pivots[k] > 0.0 {
                continue;
            }
            let mut n = vec![0.0; m];
            n[k] = 1.0;
            let (structure, factors) = (&self.structure, &self.factors);
            for i in (0..k).rev().filter(|&i| factors.inverse_pivots[i] > 0.0) {
                let column = structure.column_start[i]..structure.column_start[i + 1];
                let below = structure.rows[column.clone()].iter();
                let terms = below.zip(&factors.values[column]);
                n[i] = -terms.map(|(&row, value)| value * n[row]).sum::<f64>();
            }
            // With inaccurate pivots the refinement would increase the error.
            if factors.least > ROUNDED {
                structure.multiply(&factors.entries, &n, &mut self.right);
                self.solve_factors();
                let taken = self.right.iter().zip(&self.factors.inverse_pivots);
                for (n, (taken, &pivot)) in n.iter_mut().zip(taken) {
                    if pivot > 0.0 {
                        *n -= taken;
                    }
                }
            }
            space.add(n);
        }
        self.null_space = Some(space);
    }

    /// Solve S x = b in place, in the order of elimination.
    fn solve_factors(&mut self) {
        let (x, structure, factors) = (&mut self.right, &self.structure, &self.factors);
        // L y = b, then D z = y, then Lᵀ x = z; a constraint left out has the inverse pivot 0 and the solution 0.
        for k in 0..x.len() {
            let known = x[k];
            let column = structure.column_start[k]..structure.column_start[k + 1];
            let rows = structure.rows[column.clone()].iter();
            for (&row, value) in rows.zip(&factors.values[column]) {
                x[row] -= value * known;
            }
        }
        for (x, pivot) in x.iter_mut().zip(&factors.inverse_pivots) {
            *x *= pivot;
        }
        for k in (0..x.len()).rev() {
            let column = structure.column_start[k]..structure.column_start[k + 1];
            let rows = structure.rows[column.clone()].iter();
            let below = rows.zip(&factors.values[column]);
            let sum: f64 = below.map(|(&row, value)| value * x[row]).sum();
            if factors.inverse_pivots[k] > 0.0 {
                x[k] -= sum;
            }
        }
    }

    /// Return the diagonal entry of G M⁻¹ Gᵀ of one row.
    pub(crate) fn diagonal(&self, row: &EquationRow) -> f64 {
        let squares = self.jacobian.parts(row).map(|(first, part)| {
            let inverse = by_body(&self.inverse_mass)[first / 3];
            (0..3).map(|k| part[k] * part[k] * inverse[k]).sum::<f64>()
        });
        squares.sum()
    }

    /// Add M⁻¹ Gᵀ λ to `x`.
    pub(crate) fn push(&self, rows: &[EquationRow], lambda: impl Fn(usize) -> f64, x: &mut [f64]) {
        (self.jacobian).add_transposed(rows, lambda, &self.inverse_mass, x);
    }

    /// Solve M a + Gᵀ λ = f, G a = γ for accelerations and multipliers, with iterative refinement.
    pub(crate) fn solve(
        &mut self,
        forces: &[f64],
        rows: &[EquationRow],
        accelerations: &mut [f64],
        multipliers: &mut [f64],
    ) {
        for ((a, f), inverse) in accelerations.iter_mut().zip(forces).zip(&self.inverse_mass) {
            *a = f * inverse;
        }
        multipliers.fill(0.0);
        // Each pass solves S Δλ = G a - γ and subtracts M⁻¹ Gᵀ Δλ from a. Passes after the first reduce the round-off of the one
        // before.
        let passes = if self.factors.least > ROUNDED { 2 } else { 3 };
        for _ in 0..passes {
            (self.jacobian).multiply(rows, accelerations, &mut self.product);
            let lacks = self.product.iter().zip(rows);
            for ((along, row), &place) in lacks.zip(&self.place) {
                self.right[place] = along - row.gamma;
            }
            self.solve_factors();
            self.push(rows, |i| -self.right[self.place[i]], accelerations);
            for (lambda, &place) in multipliers.iter_mut().zip(&self.place) {
                *lambda += self.right[place];
            }
        }
        if self.rank() < rows.len() {
            self.find_null_space();
        }
        if let Some(space) = &self.null_space {
            space.sub_product(&self.place, multipliers);
        }
    }

    /// Add to `change` the least change of coordinates, weighted by mass, that removes `residual` from the constraints as factorised.
    ///
    /// The rows of the factorised state are used. S of one state with G of another would give too large a change where the inertia of
    /// bodies is small beside their mass.
    pub(crate) fn correct(&mut self, residual: &[f64], change: &mut [f64]) {
        for (residual, &place) in residual.iter().zip(&self.place) {
            self.right[place] = *residual;
        }
        self.solve_factors();
        let rows = &self.factorised;
        self.push(rows, |i| -self.right[self.place[i]], change);
    }
}

/// Assemble S: each entry is a sum of products `g_i` M⁻¹ `g_j`ᵀ over the common bodies of two constraints.
fn gather<T: Number>(
    meetings: &[Meeting],
    inverse_mass: &[f64],
    rows: &[EquationRow],
    entries: &mut [T],
) {
    entries.fill(T::default());
    for meeting in meetings {
        let ([i, j], [part_i, part_j]) = (meeting.rows, meeting.parts);
        let [a, b] = [&rows[i].jacobian[part_i], &rows[j].jacobian[part_j]];
        let weights = &inverse_mass[meeting.first..meeting.first + 3];
        entries[meeting.entry] = entries[meeting.entry].plus(T::meet(a, weights, b));
    }
}

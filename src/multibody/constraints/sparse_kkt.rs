//! The constrained equations of motion: S λ = G M⁻¹ f - γ with S = G M⁻¹ Gᵀ, as sparse as the joints are connected.
//!
//! The order of elimination (least degree first) and the places of all numbers are found once; each state then costs what
//! they ask for: for a chain of hinges, open or closed, a fixed number of operations a link. A constraint whose pivot
//! vanishes depends on others and is left out; `null_space.rs` then shares the multipliers out. S squares how near to
//! dependence constraints are, so where that is near it is eliminated in twice the precision.

use std::collections::BTreeSet;

use super::equation::Row;
use crate::math::double_double::{Number, Twice};
use crate::math::sparse_kkt::ldlt::{Factors, Structure};
use crate::math::sparse_kkt::null_space::NullSpace;
use crate::math::sparse_kkt::symbolic::{
    least_degree_order, patterns, rows_on_bodies, upper_triangle,
};
use crate::multibody::model::MechanismModel;

/// Factors L D Lᵀ of S, and room to solve.
#[derive(Debug, Clone)]
pub(crate) struct SparseKkt {
    inverse_mass: Vec<f64>,
    first: Vec<Option<usize>>,
    /// Place of each constraint in the order of elimination.
    place: Vec<usize>,
    /// Which rows of G meet in which entry of S.
    meetings: Vec<Meeting>,
    structure: Structure,
    factors: Factors<f64>,
    /// The constraints that the factors are of.
    factorised: Vec<Row>,
    /// Those of twice the precision, once they are needed.
    twice: Option<Box<Factors<Twice>>>,
    /// Multipliers that do nothing, where constraints were left out; `None` until they are asked for.
    null_space: Option<NullSpace>,
    right: Vec<f64>,
}

#[derive(Debug, Clone, Copy)]
struct Meeting {
    rows: [usize; 2],
    parts: [usize; 2],
    /// First coordinate of the body.
    first: usize,
    entry: usize,
}

/// A constraint counts as dependent when the others leave less than this part of it: more than rounding of places that
/// many joints hold together.
const DEPENDENT: f64 = 1e-10;

/// Pivots below this part of their diagonal entry are rounded too much to go by.
const ROUNDED: f64 = 1e-6;

impl SparseKkt {
    /// For the constraints of `model`.
    pub(crate) fn of(model: &MechanismModel) -> Self {
        let bodies = model.equations.iter();
        let bodies: Vec<_> = bodies.map(|e| [e.a.body, e.b.body, e.carrier]).collect();
        Self::new(&model.mass, &model.first, &bodies)
    }

    /// For constraints over `bodies`; all masses must be above zero.
    fn new(mass: &[f64], first: &[Option<usize>], bodies: &[[usize; 3]]) -> Self {
        let m = bodies.len();
        let on_body = rows_on_bodies(first, bodies);
        let mut neighbours = vec![BTreeSet::new(); m];
        for rows in &on_body {
            for &(i, _) in rows {
                neighbours[i].extend(rows.iter().map(|&(j, _)| j).filter(|&j| j != i));
            }
        }
        let order = least_degree_order(neighbours.clone());
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
            inverse_mass: mass.iter().map(|m| 1.0 / m).collect(),
            first: first.to_vec(),
            place,
            meetings,
            factors: Factors::new(&structure),
            structure,
            factorised: vec![Row::default(); m],
            twice: None,
            null_space: None,
            right: vec![0.0; m],
        }
    }

    pub(crate) fn rank(&self) -> usize {
        self.factors.rank
    }

    /// How independent the constraints are: the least part of one that those before it leave.
    pub(crate) fn independence(&self) -> f64 {
        self.factors.least.sqrt()
    }

    /// Constraints that those described before them imply.
    pub(crate) fn dependent(&mut self) -> Vec<usize> {
        self.find_null_space();
        let space = self.null_space.as_ref();
        space.map_or_else(Vec::new, |space| space.last_rows(&self.place))
    }

    /// Gathers S and factorises it without constraints of which those before them leave less than `part`.
    pub(crate) fn factorise(&mut self, rows: &[Row], part: f64) {
        self.null_space = None;
        self.factorised.copy_from_slice(rows);
        let entries = &mut self.factors.entries;
        gather(&self.meetings, &self.inverse_mass, rows, entries);
        self.factors
            .eliminate(&self.structure, (part * part).max(DEPENDENT * DEPENDENT));
        let certain = self.rank() == rows.len() && self.factors.least > ROUNDED;
        if part * part < ROUNDED && !certain {
            self.factorise_twice(rows, part.max(DEPENDENT));
        }
    }

    /// The same in twice the precision.
    fn factorise_twice(&mut self, rows: &[Row], part: f64) {
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

    /// Multipliers that do nothing: Lᵀ n = `e_k` for each constraint left out, at place k, less what those behind it take of the rest
    /// that those before it leave.
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
            // Rounded pivots would make more of the rest than there is.
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

    /// Solves S x = b in the order of elimination, in place.
    fn solve_factors(&mut self) {
        let (x, structure, factors) = (&mut self.right, &self.structure, &self.factors);
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

    /// G x of one row.
    fn along(&self, row: &Row, x: &[f64]) -> f64 {
        let mut sum = 0.0;
        for (body, part) in row.bodies.iter().zip(&row.jacobian) {
            if let Some(first) = self.first[*body]
                && let [x, y, angle] = x[first..first + 3]
            {
                sum += part[0] * x + part[1] * y + part[2] * angle;
            }
        }
        sum
    }

    /// Adds M⁻¹ Gᵀ λ times `sign`.
    fn push(&self, rows: &[Row], sign: f64, lambda: impl Fn(usize) -> f64, x: &mut [f64]) {
        for (i, row) in rows.iter().enumerate() {
            let lambda = sign * lambda(i);
            for (body, part) in row.bodies.iter().zip(&row.jacobian) {
                if let Some(first) = self.first[*body] {
                    let inverse = &self.inverse_mass[first..first + 3];
                    for ((x, inverse), part) in
                        x[first..first + 3].iter_mut().zip(inverse).zip(part)
                    {
                        *x += inverse * part * lambda;
                    }
                }
            }
        }
    }

    /// Accelerations and multipliers of forces f with G a = γ; further passes take off what rounding left of the first.
    pub(crate) fn solve(
        &mut self,
        forces: &[f64],
        rows: &[Row],
        accelerations: &mut [f64],
        multipliers: &mut [f64],
    ) {
        for ((a, f), inverse) in accelerations.iter_mut().zip(forces).zip(&self.inverse_mass) {
            *a = f * inverse;
        }
        multipliers.fill(0.0);
        let passes = if self.factors.least > ROUNDED { 2 } else { 3 };
        for _ in 0..passes {
            for (i, row) in rows.iter().enumerate() {
                self.right[self.place[i]] = self.along(row, accelerations) - row.gamma;
            }
            self.solve_factors();
            self.push(rows, -1.0, |i| self.right[self.place[i]], accelerations);
            for (lambda, &place) in multipliers.iter_mut().zip(&self.place) {
                *lambda += self.right[place];
            }
        }
        if self.rank() < rows.len() {
            self.find_null_space();
        }
        if let Some(space) = &self.null_space {
            space.take_off(&self.place, multipliers);
        }
    }

    /// Adds to `change` the least change (weighed by mass) of coordinates that takes `residual` off the constraints as they
    /// were factorised: S of one state with G of another would change too much where bodies are turned much more easily than moved.
    pub(crate) fn correct(&mut self, residual: &[f64], change: &mut [f64]) {
        for (residual, &place) in residual.iter().zip(&self.place) {
            self.right[place] = *residual;
        }
        self.solve_factors();
        let rows = &self.factorised;
        self.push(rows, -1.0, |i| self.right[self.place[i]], change);
    }
}

/// S, entry by entry.
fn gather<T: Number>(meetings: &[Meeting], inverse_mass: &[f64], rows: &[Row], entries: &mut [T]) {
    entries.fill(T::default());
    for meeting in meetings {
        let ([i, j], [part_i, part_j]) = (meeting.rows, meeting.parts);
        let [a, b] = [&rows[i].jacobian[part_i], &rows[j].jacobian[part_j]];
        let weights = &inverse_mass[meeting.first..meeting.first + 3];
        entries[meeting.entry] = entries[meeting.entry].plus(T::meet(a, weights, b));
    }
}

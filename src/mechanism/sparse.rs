//! The constrained equations of large mechanisms: S λ = G M⁻¹ f - γ with S = G M⁻¹ Gᵀ, as sparse as the joints are connected.
//!
//! The order of elimination (least degree first) and the places of all numbers are found once; each state then costs what
//! they ask for: for a chain of hinges, open or closed, a fixed number of operations a link. A constraint whose pivot
//! vanishes depends on others and is left out; `null_space.rs` then shares the multipliers out.

use std::collections::BTreeSet;

use super::equation::Row;
use super::null_space::NullSpace;
use super::structure::{least_degree_order, patterns, rows_on_bodies, upper_triangle};

/// Factors L D Lᵀ of S, and room to solve.
#[derive(Debug, Clone)]
pub(super) struct SparseKkt {
    inverse_mass: Vec<f64>,
    first: Vec<Option<usize>>,
    /// Place of each constraint in the order of elimination.
    place: Vec<usize>,
    /// Which rows of G meet in which entry of S.
    meetings: Vec<Meeting>,
    /// Upper triangle of S, column after column in the order of elimination, the diagonal last.
    start: Vec<usize>,
    above: Vec<usize>,
    entries: Vec<f64>,
    /// Columns in which each row of L has an entry, in order.
    pattern_start: Vec<usize>,
    pattern: Vec<usize>,
    /// Columns of L: where they begin, how much is filled, rows and values.
    column_start: Vec<usize>,
    filled: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
    inverse_pivots: Vec<f64>,
    rank: usize,
    /// Least pivot in parts of its diagonal entry, of those that count.
    least: f64,
    /// Multipliers that do nothing, where constraints were left out.
    null_space: NullSpace,
    /// Scratch, zero between calls.
    work: Vec<f64>,
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

/// A pivot counts as vanished below this part of its diagonal entry.
const PIVOT_TOLERANCE: f64 = 1e-13;

impl SparseKkt {
    /// For constraints over `bodies`; all masses must be above zero.
    pub(super) fn new(mass: &[f64], first: &[Option<usize>], bodies: &[[usize; 3]]) -> Self {
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
        let (pattern_start, pattern) = patterns(&start, &above);
        let mut column_start = vec![0; m + 1];
        for &column in &pattern {
            column_start[column + 1] += 1;
        }
        for k in 0..m {
            column_start[k + 1] += column_start[k];
        }
        Self {
            inverse_mass: mass.iter().map(|m| 1.0 / m).collect(),
            first: first.to_vec(),
            place,
            meetings,
            entries: vec![0.0; above.len()],
            start,
            above,
            filled: vec![0; m],
            rows: vec![0; pattern.len()],
            values: vec![0.0; pattern.len()],
            pattern_start,
            pattern,
            column_start,
            inverse_pivots: vec![0.0; m],
            rank: 0,
            least: 1.0,
            null_space: NullSpace::default(),
            work: vec![0.0; m],
            right: vec![0.0; m],
        }
    }

    pub(super) fn rank(&self) -> usize {
        self.rank
    }

    /// How independent the constraints are: the least part of one that those before it leave.
    pub(super) fn independence(&self) -> f64 {
        self.least.sqrt()
    }

    /// Leaves out what is less independent than `part`, until the next factors.
    pub(super) fn truncate(&mut self, part: f64) {
        if self.independence() < part {
            self.eliminate_all(part * part);
        }
    }

    /// Constraints that those described before them imply.
    pub(super) fn dependent(&self) -> Vec<usize> {
        self.null_space.last_rows(&self.place)
    }

    /// Gathers S and factorises it.
    pub(super) fn factorise(&mut self, rows: &[Row]) {
        self.entries.fill(0.0);
        for meeting in &self.meetings {
            let ([i, j], [part_i, part_j]) = (meeting.rows, meeting.parts);
            let [a, b] = [&rows[i].jacobian[part_i], &rows[j].jacobian[part_j]];
            if let [wx, wy, turning] = self.inverse_mass[meeting.first..meeting.first + 3] {
                self.entries[meeting.entry] +=
                    a[0] * wx * b[0] + a[1] * wy * b[1] + a[2] * turning * b[2];
            }
        }
        self.eliminate_all(PIVOT_TOLERANCE);
    }

    /// Factors of S without constraints whose pivot is below `tolerance` of its diagonal entry.
    fn eliminate_all(&mut self, tolerance: f64) {
        self.filled.fill(0);
        self.rank = 0;
        self.least = 1.0;
        for k in 0..self.place.len() {
            self.eliminate(k, tolerance);
        }
        self.null_space.clear();
        if self.rank < self.place.len() {
            for k in 0..self.place.len() {
                if self.inverse_pivots[k] == 0.0 {
                    let vector = self.null_vector(k);
                    self.null_space.add(vector);
                }
            }
        }
    }

    /// Multipliers in the order of elimination that do nothing, with 1 at the constraint left out at `k`: Lᵀ n = `e_k`.
    fn null_vector(&self, k: usize) -> Vec<f64> {
        let mut n = vec![0.0; self.place.len()];
        n[k] = 1.0;
        for i in (0..k).rev().filter(|&i| self.inverse_pivots[i] > 0.0) {
            let column = self.column_start[i]..self.column_start[i + 1];
            n[i] = -column
                .map(|at| self.values[at] * n[self.rows[at]])
                .sum::<f64>();
        }
        n
    }

    /// Row k of L and its pivot.
    fn eliminate(&mut self, k: usize, tolerance: f64) {
        let upper = self.start[k]..self.start[k + 1];
        for (&row, &entry) in self.above[upper.clone()].iter().zip(&self.entries[upper]) {
            self.work[row] = entry;
        }
        let diagonal = self.work[k];
        for &column in &self.pattern[self.pattern_start[k]..self.pattern_start[k + 1]] {
            let y = std::mem::take(&mut self.work[column]);
            let begin = self.column_start[column];
            let end = begin + self.filled[column];
            for (&row, value) in self.rows[begin..end].iter().zip(&self.values[begin..end]) {
                self.work[row] -= value * y;
            }
            let value = y * self.inverse_pivots[column];
            self.work[k] -= value * y;
            self.rows[end] = k;
            self.values[end] = value;
            self.filled[column] += 1;
        }
        let pivot = std::mem::take(&mut self.work[k]);
        self.inverse_pivots[k] = 0.0;
        if pivot > tolerance * diagonal {
            self.least = self.least.min(pivot / diagonal);
            self.inverse_pivots[k] = 1.0 / pivot;
            self.rank += 1;
        }
    }

    /// Solves S x = b in the order of elimination, in place.
    fn solve_factors(&mut self) {
        let x = &mut self.right;
        for k in 0..x.len() {
            let known = x[k];
            let column = self.column_start[k]..self.column_start[k + 1];
            for (&row, value) in self.rows[column.clone()].iter().zip(&self.values[column]) {
                x[row] -= value * known;
            }
        }
        for (x, pivot) in x.iter_mut().zip(&self.inverse_pivots) {
            *x *= pivot;
        }
        for k in (0..x.len()).rev() {
            let column = self.column_start[k]..self.column_start[k + 1];
            let below = self.rows[column.clone()].iter().zip(&self.values[column]);
            let sum: f64 = below.map(|(&row, value)| value * x[row]).sum();
            if self.inverse_pivots[k] > 0.0 {
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

    /// Accelerations and multipliers of forces f with G a = γ; the second pass takes off what rounding left of the first.
    pub(super) fn solve(
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
        for _ in 0..2 {
            for (i, row) in rows.iter().enumerate() {
                self.right[self.place[i]] = self.along(row, accelerations) - row.gamma;
            }
            self.solve_factors();
            self.push(rows, -1.0, |i| self.right[self.place[i]], accelerations);
            for (lambda, &place) in multipliers.iter_mut().zip(&self.place) {
                *lambda += self.right[place];
            }
        }
        self.null_space.take_off(&self.place, multipliers);
    }

    /// Adds to `change` the least change (weighed by mass) of coordinates that takes `residual` off the constraints.
    pub(super) fn correct(&mut self, rows: &[Row], residual: &[f64], change: &mut [f64]) {
        for (residual, &place) in residual.iter().zip(&self.place) {
            self.right[place] = *residual;
        }
        self.solve_factors();
        self.push(rows, -1.0, |i| self.right[self.place[i]], change);
    }
}

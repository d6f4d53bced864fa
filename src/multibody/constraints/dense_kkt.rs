//! The constrained equations of motion, M a + Gᵀ λ = f and G a = γ, by orthogonal factors of the weighted Gᵀ.
//!
//! With x = D a, D = √M: the part of x in the range of D⁻¹ Gᵀ follows from γ, the part across it from the forces. The
//! condition number is that of the joints themselves, not its square. Dependent constraints show as columns that the
//! others have used up: they are left out, and of all multipliers that do the same the least are taken.

use super::equation::Row;
use crate::math::pivoted_qr::{Orthogonal, solve_positive};
use crate::math::sparse_kkt::null_space::NullSpace;

/// Factors of the constrained equations at one state, and room to solve them.
#[derive(Debug, Clone)]
pub(crate) struct Kkt {
    coordinates: usize,
    /// 1/D; for coordinates without mass the weight of typical ones.
    inverse_weight: Vec<f64>,
    /// M' = D⁻¹ M D⁻¹: 1, or 0 without mass.
    massive: Vec<bool>,
    /// Where each body's coordinates begin; `None` for those that are held.
    first: Vec<Option<usize>>,
    factors: Orthogonal,
    /// Scratch: forces, and the solution being made.
    f: Vec<f64>,
    x: Vec<f64>,
    multipliers: Vec<f64>,
}

impl Kkt {
    /// For `rows` constraints over bodies whose coordinates have these masses.
    pub(crate) fn new(mass: &[f64], first: &[Option<usize>], rows: usize) -> Self {
        let n = mass.len();
        let largest = |turning: usize| {
            let of_kind = mass
                .iter()
                .enumerate()
                .filter(|(i, _)| i % 3 / 2 == turning);
            let most = of_kind.map(|(_, m)| *m).fold(0.0, f64::max);
            if most > 0.0 { most } else { 1.0 }
        };
        let typical = [largest(0), largest(1)];
        let weight = |i: usize| {
            if mass[i] > 0.0 {
                mass[i]
            } else {
                typical[i % 3 / 2]
            }
        };
        Self {
            coordinates: n,
            inverse_weight: (0..n).map(|i| 1.0 / weight(i).sqrt()).collect(),
            massive: mass.iter().map(|&m| m > 0.0).collect(),
            first: first.to_vec(),
            factors: Orthogonal::new(n, rows),
            f: vec![0.0; n],
            x: vec![0.0; n],
            multipliers: vec![0.0; rows.max(n)],
        }
    }

    /// Number of independent constraints at the state of the last factors.
    pub(crate) fn rank(&self) -> usize {
        self.factors.rank()
    }

    /// How independent the constraints are: the least part of a row that the others leave.
    pub(crate) fn independence(&self) -> f64 {
        self.factors.least_part()
    }

    /// Constraints that those described before them imply.
    pub(crate) fn dependent(&self) -> Vec<usize> {
        let (r, order) = (self.factors.rank(), self.factors.order());
        let extra = order.len() - r;
        let t = self.factors.dependence();
        let mut space = NullSpace::default();
        for j in 0..extra {
            let mut vector = vec![0.0; order.len()];
            vector[order[r + j]] = 1.0;
            for i in 0..r {
                vector[order[i]] = -t[i * extra + j];
            }
            space.add(vector);
        }
        let place: Vec<usize> = (0..order.len()).collect();
        space.last_rows(&place)
    }

    /// Factorises D⁻¹ Gᵀ without columns of which less than `part` was left.
    pub(crate) fn factorise(&mut self, rows: &[Row], part: f64) {
        let n = self.coordinates;
        let table = self.factors.clear();
        for (column, row) in table.chunks_exact_mut(n.max(1)).zip(rows) {
            for (body, part) in row.bodies.iter().zip(&row.jacobian) {
                if let Some(first) = self.first[*body] {
                    for (k, value) in part.iter().enumerate() {
                        column[first + k] += value * self.inverse_weight[first + k];
                    }
                }
            }
        }
        self.factors.factorise();
        self.factors.truncate(part);
    }

    /// Accelerations and multipliers of forces f with G a = γ; false when a motion has no mass.
    pub(crate) fn solve(
        &mut self,
        forces: &[f64],
        rows: &[Row],
        accelerations: &mut [f64],
        multipliers: &mut [f64],
    ) -> bool {
        let r = self.factors.rank();
        for ((f, force), weight) in self.f.iter_mut().zip(forces).zip(&self.inverse_weight) {
            *f = force * weight;
        }
        for (x, &row) in self.x.iter_mut().zip(&self.factors.order()[..r]) {
            *x = rows[row].gamma;
        }
        self.factors.solve_transposed(&mut self.x[..r]);
        if self.massive.iter().all(|&massive| massive) {
            self.factors.turn(&mut self.f);
            self.x[r..].copy_from_slice(&self.f[r..]);
            for k in 0..r {
                self.multipliers[k] = self.f[k] - self.x[k];
            }
            self.factors.turn_back(&mut self.x);
        } else if !self.move_massless(r) {
            return false;
        }
        for ((a, x), weight) in accelerations
            .iter_mut()
            .zip(&self.x)
            .zip(&self.inverse_weight)
        {
            *a = x * weight;
        }
        self.factors.solve(&mut self.multipliers[..r]);
        self.spread(multipliers);
        true
    }

    /// The part across the constraints where some coordinates have no mass: Zᵀ M' Z z = Zᵀ (f - M' x).
    fn move_massless(&mut self, r: usize) -> bool {
        let n = self.coordinates;
        let free = n - r;
        self.x[r..].fill(0.0);
        self.factors.turn_back(&mut self.x);
        let mut basis = vec![0.0; free * n];
        for (k, z) in basis.chunks_exact_mut(n).enumerate() {
            z[r + k] = 1.0;
            self.factors.turn_back(z);
        }
        let weighted = |a: &[f64], b: &[f64]| -> f64 {
            let terms = a.iter().zip(b).zip(&self.massive);
            terms.map(|((a, b), &m)| if m { a * b } else { 0.0 }).sum()
        };
        let column = |k: usize| &basis[k * n..(k + 1) * n];
        let mut matrix: Vec<f64> = (0..free * free)
            .map(|ij| weighted(column(ij / free), column(ij % free)))
            .collect();
        let mut z: Vec<f64> = (0..free)
            .map(|k| {
                let pushed: f64 = column(k).iter().zip(&self.f).map(|(z, f)| z * f).sum();
                pushed - weighted(column(k), &self.x)
            })
            .collect();
        if !solve_positive(&mut matrix, free, &mut z) {
            return false;
        }
        for (k, z) in z.iter().enumerate() {
            let column = &basis[k * n..(k + 1) * n];
            self.x.iter_mut().zip(column).for_each(|(x, c)| *x += z * c);
        }
        let mut left = self.f.clone();
        for ((left, x), &massive) in left.iter_mut().zip(&self.x).zip(&self.massive) {
            *left -= if massive { *x } else { 0.0 };
        }
        self.factors.turn(&mut left);
        self.multipliers[..r].copy_from_slice(&left[..r]);
        true
    }

    /// Writes the multipliers of the independent constraints to all: of all that do the same, the least.
    fn spread(&mut self, multipliers: &mut [f64]) {
        let (r, order) = (self.factors.rank(), self.factors.order());
        let extra = order.len() - r;
        multipliers.fill(0.0);
        if extra > 0 {
            // λ₁ = l - T λ₂ does the same for every λ₂; |λ|² is least where (1 + Tᵀ T) λ₂ = Tᵀ l.
            let t = self.factors.dependence();
            let at = |i: usize, j: usize| t[i * extra + j];
            let mut normal = vec![0.0; extra * extra];
            let mut second = vec![0.0; extra];
            for j in 0..extra {
                for k in 0..extra {
                    let sum: f64 = (0..r).map(|i| at(i, j) * at(i, k)).sum();
                    normal[j * extra + k] = sum + if j == k { 1.0 } else { 0.0 };
                }
                second[j] = (0..r).map(|i| at(i, j) * self.multipliers[i]).sum();
            }
            if solve_positive(&mut normal, extra, &mut second) {
                for (j, &value) in second.iter().enumerate() {
                    multipliers[order[r + j]] = value;
                    for i in 0..r {
                        self.multipliers[i] -= at(i, j) * value;
                    }
                }
            }
        }
        for (&row, &value) in order.iter().zip(&self.multipliers[..r]) {
            multipliers[row] = value;
        }
    }

    /// Adds to `change` the least change (weighed by mass) of coordinates that takes `residual` off the constraints.
    pub(crate) fn correct(&mut self, residual: &[f64], change: &mut [f64]) {
        let r = self.factors.rank();
        self.x.fill(0.0);
        for (x, &row) in self.x.iter_mut().zip(&self.factors.order()[..r]) {
            *x = residual[row];
        }
        self.factors.solve_transposed(&mut self.x[..r]);
        self.factors.turn_back(&mut self.x);
        for ((change, x), weight) in change.iter_mut().zip(&self.x).zip(&self.inverse_weight) {
            *change -= x * weight;
        }
    }
}

//! Correction of the implicit corrector: solution of the linear system with the factors of the last factorisation.

use pulp::{Simd, WithSimd};

use super::Factors;
use super::link_group::LinkGroup;
use super::links::{Border, RightHand};
use super::ring::BASE;
use crate::math::simd::{
    Entries, EntriesMut, Lanes, Number, Numbers, Pack8, PartialSums, Vectors, parts,
    put_double_part, read, write,
};

/// Right-hand side of a correction: residuals times masses and inertias, minus columns times factors of the border.
struct ChainResidual<'a, S: Vectors> {
    /// Residuals x, y and θ of all links.
    residuals: [Entries<'a, S>; 3],
    columns: &'a [Border<S::Number>],
    /// Factors of the columns; empty where the border is eliminated and rollers are no bodies.
    border_solution: &'a [f64],
}

impl<S: Vectors> RightHand<S> for ChainResidual<'_, S> {
    #[inline(always)]
    fn at(
        &self,
        simd: S,
        group: &LinkGroup<S::Number>,
        (number, part): (usize, usize),
    ) -> [Lanes<S>; 3] {
        let mass = group.mass.at(simd, part);
        let [x, y, turn] = &self.residuals;
        let mut right = [
            mass * x.at(number, part),
            mass * y.at(number, part),
            group.inertia.at(simd, part) * turn.at(number, part),
        ];
        if group.touches_teeth {
            for (column, &border_solution) in self.columns.iter().zip(self.border_solution) {
                take(simd, &mut right, &column[number], border_solution, part);
            }
        }
        right
    }
}

/// Subtract vector `part` of a column times `factor` from the entries of links.
#[inline(always)]
fn take<S: Vectors>(
    simd: S,
    from: &mut [Lanes<S>; 3],
    column: &[Pack8<S::Number>; 3],
    factor: f64,
    part: usize,
) {
    let factor = Lanes::splat(simd, factor);
    for (from, column) in from.iter_mut().zip(read(simd, column, part)) {
        *from = factor.negate_mul_add(column, *from);
    }
}

/// Kernel of [`Factors::correct`]; `FRICTION`: with moments on the links.
pub(super) struct Correct<'a, T: Number, const FRICTION: bool> {
    pub(super) factors: &'a mut Factors<T>,
    pub(super) links: usize,
    pub(super) residual: &'a mut [f64],
    pub(super) lack: Option<&'a [Numbers; 2]>,
}

impl<T: Number, const FRICTION: bool> WithSimd for Correct<'_, T, FRICTION> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.run(T::vectors(simd));
    }
}

impl<T: Number, const FRICTION: bool> Correct<'_, T, FRICTION> {
    #[inline(always)]
    fn run<S: Vectors<Number = T>>(self, simd: S) {
        let Self {
            factors: matrix,
            links: n,
            residual,
            lack,
        } = self;
        let (links, rest) = residual.split_at_mut(3 * n);
        let (border, rollers) = rest.split_at_mut(matrix.solved.len());
        matrix.corner.weigh(border);
        let Factors {
            rollers: terms,
            columns,
            border_solution,
            ..
        } = matrix;
        let (of_border, of_rollers) = border_solution.split_at_mut(border.len());
        if let (Some(terms), [.., column]) = (terms, &mut columns[..]) {
            let (links, right) = (&matrix.links, &*rollers);
            terms.solve_free::<S, FRICTION>(simd, right, border, links, column);
            of_border.fill(0.0);
            of_rollers.fill(-1.0);
        }
        let gauss_seidel = matrix.gauss_seidel && !border.is_empty();
        if gauss_seidel {
            // Block Gauss-Seidel, first half: the border alone. The second half below solves the border with the links' solution.
            of_border.copy_from_slice(border);
            matrix.corner.solve(of_border);
        }
        let gauss_seidel = gauss_seidel || !rollers.is_empty();
        let axis = |number: usize| Entries::of(simd, &links[number * n..(number + 1) * n]);
        let right = ChainResidual {
            residuals: [axis(0), axis(1), axis(2)],
            columns: &matrix.columns,
            border_solution: if gauss_seidel {
                &matrix.border_solution
            } else {
                &[]
            },
        };
        matrix
            .links
            .solve_free::<S, _, FRICTION>(simd, n, &matrix.roots, &right);
        if let Some(lack) = lack {
            matrix.add_lack(n, lack);
        }
        matrix.solve_hinges(simd, n);
        matrix.sums.fill(PartialSums::default());
        matrix.links.solve_bound::<S, FRICTION>(
            simd,
            &mut matrix.unknowns,
            &matrix.columns,
            &mut matrix.sums,
        );
        // Border: right-hand side minus rows times the links' solution.
        for (sum, entry) in matrix.sums.iter().zip(border.iter_mut()) {
            *entry -= sum.total();
        }
        matrix.corner.solve(border);
        if !matrix.gauss_seidel {
            take_border(simd, &mut matrix.unknowns, &matrix.solved, border);
            matrix.take_forces_of_columns(border);
        }
        if let Some(terms) = &mut matrix.rollers {
            let (links, unknowns) = (&matrix.links, &matrix.unknowns);
            terms.solve_bound::<S, FRICTION>(simd, links, unknowns, border, rollers);
        }
        put_solution(simd, &matrix.unknowns, links);
    }
}

impl<T: Number> Factors<T> {
    /// Add what the constraints of `n` ideal hinges lack to their right-hand sides.
    #[inline(always)]
    fn add_lack(&mut self, n: usize, lack: &[Numbers; 2]) {
        for (right, lack) in self.links.ring_unknowns().iter_mut().zip(lack) {
            let right = &mut right[BASE..][..n];
            for (right, lack) in right.iter_mut().zip(&lack[..n]) {
                *right = T::nearest(right.double() + lack);
            }
        }
    }

    /// Subtract the hinge forces of the border's columns times its solution from the hinge forces.
    #[inline(always)]
    fn take_forces_of_columns(&mut self, border: &[f64]) {
        for (of_column, &factor) in self.forces_of_columns.iter().zip(border) {
            let forces = self.links.ring_unknowns().iter_mut().zip(of_column);
            for (force, of_column) in forces {
                for (force, of_column) in force.iter_mut().zip(&**of_column) {
                    *force = T::nearest(force.double() - factor * of_column.double());
                }
            }
        }
    }
}

/// Subtract the solved columns of the border times its solution from the links' solution: w -= (A⁻¹ c) s.
#[inline(always)]
fn take_border<S: Vectors>(
    simd: S,
    unknowns: &mut [[Pack8<S::Number>; 3]],
    solved: &[Border<S::Number>],
    border: &[f64],
) {
    for (column, &factor) in solved.iter().zip(border) {
        for (unknowns, column) in unknowns.iter_mut().zip(column) {
            for part in parts::<S>() {
                let mut rest = read(simd, unknowns, part);
                take(simd, &mut rest, column, factor, part);
                write(unknowns, part, rest);
            }
        }
    }
}

/// Write the links' solution, axis by axis.
#[inline(always)]
fn put_solution<S: Vectors>(simd: S, solution: &[[Pack8<S::Number>; 3]], links: &mut [f64]) {
    let n = links.len() / 3;
    let (x, rest) = links.split_at_mut(n);
    let (y, turn) = rest.split_at_mut(n);
    let [(x, x_rest), (y, y_rest), (turn, turn_rest)] =
        [x, y, turn].map(|axis| axis.as_chunks_mut());
    let (whole, behind) = solution.split_at(x.len());
    let (y, turn) = (&mut y[..whole.len()], &mut turn[..whole.len()]);
    for (number, solution) in whole.iter().enumerate() {
        for part in parts::<S>() {
            let values = read(simd, solution, part);
            put_double_part(&mut x[number], part, values[0]);
            put_double_part(&mut y[number], part, values[1]);
            put_double_part(&mut turn[number], part, values[2]);
        }
    }
    if let [solution] = behind {
        for (rest, solution) in [x_rest, y_rest, turn_rest].into_iter().zip(solution) {
            let mut rest = EntriesMut::of(simd, rest);
            for part in parts::<S>() {
                rest.set(0, part, solution.at(simd, part));
            }
        }
    }
}

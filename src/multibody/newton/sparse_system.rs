//! Sparse linear system of the implicit corrector with its constraints: places of all entries, factors, solutions.
//!
//! The matrix is [M - γ D - γ² K, Gᵀ; G', -ε] over corrections of the velocities and of the multipliers. Its sparsity pattern is
//! constant, so places and the order of elimination are determined once. Factors are faer's, with partial pivoting, in memory that is
//! kept. ε is far below the diagonal entries of G M⁻¹ Gᵀ and keeps the matrix regular with redundant constraints.

use std::collections::BTreeSet;

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::sparse::linalg::lu::{LuSymbolicParams, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Spec};

use crate::multibody::constraints::relative_kinematics::Block;

/// Places of a 3 × 3 block: for each column, the place of its first row.
type Places = [usize; 3];

/// Places of the blocks aa, ab, ba, bb of two bodies; `None` for a fixed body.
pub(crate) type PairPlaces = [Option<Places>; 4];

/// Places of a constraint, by body: the column of Gᵀ, and the row of G'.
pub(crate) type RowPlaces = [Option<(usize, Places)>; 3];

/// Matrix of the saddle-point system and its factors.
#[derive(Debug, Clone)]
pub(crate) struct Saddle {
    size: usize,
    column_start: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
    diagonal: Vec<usize>,
    symbolic: SymbolicLu<usize>,
    numeric: NumericLu<usize, f64>,
    room: Room,
    /// Right-hand side and solution.
    pub(crate) right: Vec<f64>,
}

/// Work memory for factors and solutions.
struct Room {
    buffer: MemBuffer,
    needed: StackReq,
}

impl Room {
    /// Allocate the memory that is needed.
    fn new(needed: StackReq) -> Self {
        Self {
            buffer: MemBuffer::new(needed),
            needed,
        }
    }
}

impl Clone for Room {
    fn clone(&self) -> Self {
        Self::new(self.needed)
    }
}

impl std::fmt::Debug for Room {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Room")
    }
}

/// Sparsity pattern: the rows of each column.
#[derive(Debug)]
pub(crate) struct Pattern {
    coordinates: usize,
    first: Vec<Option<usize>>,
    columns: Vec<BTreeSet<usize>>,
}

impl Pattern {
    /// Return the pattern with the diagonal blocks of bodies whose coordinates begin at `first`, and of `constraints`.
    pub(crate) fn new(first: &[Option<usize>], coordinates: usize, constraints: usize) -> Self {
        let size = coordinates + constraints;
        let mut columns: Vec<BTreeSet<usize>> = (0..size).map(|i| BTreeSet::from([i])).collect();
        for &start in first.iter().flatten() {
            for column in &mut columns[start..start + 3] {
                column.extend(start..start + 3);
            }
        }
        Self {
            coordinates,
            first: first.to_vec(),
            columns,
        }
    }

    /// Add the blocks of a force between two bodies.
    pub(crate) fn couple(&mut self, a: usize, b: usize) {
        for (row, column) in [(a, b), (b, a)] {
            if let (Some(row), Some(column)) = (self.first[row], self.first[column]) {
                for entries in &mut self.columns[column..column + 3] {
                    entries.extend(row..row + 3);
                }
            }
        }
    }

    /// Add the entries of a constraint on bodies.
    pub(crate) fn constrain(&mut self, constraint: usize, bodies: [usize; 3]) {
        let own = self.coordinates + constraint;
        for start in bodies.into_iter().filter_map(|body| self.first[body]) {
            self.columns[own].extend(start..start + 3);
            for entries in &mut self.columns[start..start + 3] {
                entries.insert(own);
            }
        }
    }

    /// Return the zero matrix of this pattern; `None` when memory is insufficient.
    pub(crate) fn finish(&self) -> Option<Saddle> {
        let size = self.columns.len();
        let mut column_start = vec![0];
        let mut rows = Vec::new();
        let mut diagonal = Vec::with_capacity(size);
        for (k, column) in self.columns.iter().enumerate() {
            diagonal.push(rows.len() + column.range(..k).count());
            rows.extend(column);
            column_start.push(rows.len());
        }
        let pattern = SymbolicSparseColMatRef::new_checked(size, size, &column_start, None, &rows);
        let symbolic = factorize_symbolic_lu(pattern, LuSymbolicParams::default()).ok()?;
        let factors = symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Spec::default());
        let solution = symbolic.solve_in_place_scratch::<f64>(1, Par::Seq);
        Some(Saddle {
            size,
            values: vec![0.0; rows.len()],
            right: vec![0.0; size],
            room: Room::new(factors.or(solution)),
            numeric: NumericLu::new(),
            column_start,
            rows,
            diagonal,
            symbolic,
        })
    }
}

impl Saddle {
    /// Return the place of an entry among the values.
    fn place(&self, row: usize, column: usize) -> usize {
        let start = self.column_start[column];
        let rows = &self.rows[start..self.column_start[column + 1]];
        start + rows.partition_point(|&r| r < row)
    }

    /// Return the places of the blocks of two bodies.
    pub(crate) fn pair_places(&self, first: &[Option<usize>], a: usize, b: usize) -> PairPlaces {
        [(a, a), (a, b), (b, a), (b, b)].map(|(row, column)| {
            let (row, column) = (first[row]?, first[column]?);
            Some([0, 1, 2].map(|l| self.place(row, column + l)))
        })
    }

    /// Return the places of a constraint, whose row and column are `own`.
    pub(crate) fn row_places(
        &self,
        first: &[Option<usize>],
        own: usize,
        bodies: [usize; 3],
    ) -> RowPlaces {
        bodies.map(|body| {
            let start = first[body]?;
            let row = [0, 1, 2].map(|l| self.place(own, start + l));
            Some((self.place(start, own), row))
        })
    }

    /// Set all entries to zero.
    pub(crate) fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Add a value to a diagonal entry.
    pub(crate) fn add_diagonal(&mut self, k: usize, value: f64) {
        self.values[self.diagonal[k]] += value;
    }

    /// Add the block of two bodies.
    pub(crate) fn add_pair(&mut self, places: &PairPlaces, block: &Block) {
        for (at, (row, column)) in places.iter().zip([(0, 0), (0, 3), (3, 0), (3, 3)]) {
            let Some(columns) = at else { continue };
            for (l, &place) in columns.iter().enumerate() {
                for k in 0..3 {
                    self.values[place + k] += block[row + k][column + l];
                }
            }
        }
    }

    /// Add a constraint: its column of Gᵀ (`down`) and its row of G' (`across`), three numbers per body.
    pub(crate) fn add_row(
        &mut self,
        places: &RowPlaces,
        down: &[[f64; 3]; 3],
        across: &[[f64; 3]; 3],
    ) {
        for ((at, down), across) in places.iter().zip(down).zip(across) {
            let Some((column, row)) = at else { continue };
            for k in 0..3 {
                self.values[column + k] += down[k];
                self.values[row[k]] += across[k];
            }
        }
    }

    /// Factorise; return false when the matrix is singular or not finite.
    pub(crate) fn factorise(&mut self) -> bool {
        let pattern = SymbolicSparseColMatRef::new_checked(
            self.size,
            self.size,
            &self.column_start,
            None,
            &self.rows,
        );
        let matrix = SparseColMatRef::new(pattern, &self.values);
        let stack = MemStack::new(&mut self.room.buffer);
        let factors = self.symbolic.factorize_numeric_lu(
            &mut self.numeric,
            matrix,
            Par::Seq,
            stack,
            Spec::default(),
        );
        factors.is_ok() && self.values.iter().all(|value| value.is_finite())
    }

    /// Overwrite the right-hand side by the solution.
    pub(crate) fn solve(&mut self) {
        let stack = MemStack::new(&mut self.room.buffer);
        let right = MatMut::from_column_major_slice_mut(&mut self.right, self.size, 1);
        faer::sparse::linalg::lu::LuRef::new_unchecked(&self.symbolic, &self.numeric)
            .solve_in_place_with_conj(Conj::No, right, Par::Seq, stack);
    }
}

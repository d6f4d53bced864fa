//! Sparse linear system of the implicit corrector with its constraints: places of all entries, factors, solutions.
//!
//! The matrix is [M - γ D - γ² K, Gᵀ; G', -ε] over corrections of the velocities and of the multipliers. Its nodes are the free bodies
//! and the joints. ε is far below the diagonal entries of G M⁻¹ Gᵀ and keeps the matrix regular with redundant constraints.

use std::collections::BTreeSet;
use std::ops::Range;

use crate::math::sparse_kkt::block_lu::BlockLu;
use crate::multibody::constraints::relative_kinematics::CoordinateBlock;

/// Blocks aa, ab, ba, bb of two bodies; `None` for a fixed body.
pub(crate) type PairPlaces = [Option<usize>; 4];

/// Places of a constraint: its number within its joint, and by body the blocks of Gᵀ and of G'.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowPlaces {
    own: usize,
    blocks: [Option<[usize; 2]>; 3],
}

/// Blocks of a point between two free bodies: the diagonal blocks of its joint and of the bodies, and the pairs of each with the joint.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PointPlaces {
    joint: usize,
    bodies: [usize; 2],
    pairs: [usize; 2],
}

/// Entries of a point between two free bodies a and b.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PointEntries {
    /// Derivatives of both constraints with respect to the two angles, in Gᵀ and in G'.
    pub(crate) slopes: [[f64; 2]; 2],
    pub(crate) across: [[f64; 2]; 2],
    /// Values to add on the diagonal: for the two angles, and for both constraints.
    pub(crate) bends: [f64; 2],
    pub(crate) compliances: [f64; 2],
}

/// Matrix of the saddle-point system and its factors.
#[derive(Debug, Clone)]
pub(crate) struct Saddle {
    lu: BlockLu,
    /// Node of each body, in the order of its coordinates; nodes in the order of elimination.
    bodies: Vec<usize>,
    /// Node and number within it of each constraint.
    constraints: Vec<(usize, usize)>,
}

/// Sparsity pattern: the adjacent nodes of each node.
#[derive(Debug)]
pub(crate) struct Pattern {
    coordinates: usize,
    first: Vec<Option<usize>>,
    /// Node and number within it of each constraint.
    constraints: Vec<(usize, usize)>,
    sizes: Vec<usize>,
    neighbours: Vec<BTreeSet<usize>>,
}

impl Pattern {
    /// Return the pattern without couplings of bodies whose coordinates begin at `first`, and of joints with these constraints.
    pub(crate) fn new(
        first: &[Option<usize>],
        coordinates: usize,
        joints: &[Range<usize>],
    ) -> Self {
        let bodies = coordinates / 3;
        let mut sizes = vec![3; bodies];
        sizes.extend(joints.iter().map(ExactSizeIterator::len));
        let constraints = joints.iter().enumerate();
        let constraints =
            constraints.flat_map(|(joint, own)| (0..own.len()).map(move |k| (bodies + joint, k)));
        Self {
            coordinates,
            first: first.to_vec(),
            constraints: constraints.collect(),
            neighbours: vec![BTreeSet::new(); sizes.len()],
            sizes,
        }
    }

    /// Return the node of a body; `None` for a fixed body.
    fn node(&self, body: usize) -> Option<usize> {
        self.first[body].map(|first| first / 3)
    }

    fn connect(&mut self, i: usize, j: usize) {
        if i != j {
            self.neighbours[i].insert(j);
            self.neighbours[j].insert(i);
        }
    }

    /// Add the blocks of a force between two bodies.
    pub(crate) fn couple(&mut self, a: usize, b: usize) {
        if let (Some(a), Some(b)) = (self.node(a), self.node(b)) {
            self.connect(a, b);
        }
    }

    /// Add the entries of a constraint on bodies.
    pub(crate) fn constrain(&mut self, constraint: usize, bodies: [usize; 3]) {
        let (joint, _) = self.constraints[constraint];
        for body in bodies.map(|body| self.node(body)).into_iter().flatten() {
            self.connect(body, joint);
        }
    }

    /// Return the zero matrix of this pattern.
    pub(crate) fn finish(&self) -> Saddle {
        let lu = BlockLu::new(&self.sizes, self.coordinates / 3, &self.neighbours);
        let constraints = self.constraints.iter();
        Saddle {
            bodies: (0..self.coordinates / 3)
                .map(|node| lu.place(node))
                .collect(),
            constraints: constraints.map(|&(node, k)| (lu.place(node), k)).collect(),
            lu,
        }
    }

    /// Return the blocks of two bodies in `saddle`.
    pub(crate) fn pair_places(&self, saddle: &Saddle, a: usize, b: usize) -> PairPlaces {
        [(a, a), (a, b), (b, a), (b, b)]
            .map(|(row, column)| Some(saddle.lu.block(self.node(row)?, self.node(column)?)))
    }

    /// Return the places of a constraint in `saddle`.
    pub(crate) fn row_places(
        &self,
        saddle: &Saddle,
        constraint: usize,
        bodies: [usize; 3],
    ) -> RowPlaces {
        let (joint, own) = self.constraints[constraint];
        let blocks = bodies.map(|body| {
            let body = self.node(body)?;
            Some([(body, joint), (joint, body)].map(|(row, column)| saddle.lu.block(row, column)))
        });
        RowPlaces { own, blocks }
    }

    /// Return the places of a point between two free bodies by their numbers; `constraint` is the first of its two.
    pub(crate) fn point_places(
        &self,
        saddle: &Saddle,
        constraint: usize,
        bodies: [usize; 2],
    ) -> PointPlaces {
        let (joint, _) = self.constraints[constraint];
        PointPlaces {
            joint: saddle.lu.place(joint),
            bodies: bodies.map(|body| saddle.lu.place(body)),
            pairs: bodies.map(|body| saddle.lu.block(body, joint)),
        }
    }
}

impl Saddle {
    /// Set all entries to zero, except for the inertia of each coordinate.
    pub(crate) fn begin(&mut self, mass: &[f64]) {
        self.lu.clear(self.bodies.len());
        for (&node, mass) in self.bodies.iter().zip(mass.as_chunks().0) {
            self.lu.write_diagonal(node, *mass);
        }
    }

    /// Add a value to the diagonal entry of a constraint.
    pub(crate) fn add_compliance(&mut self, constraint: usize, value: f64) {
        let (node, own) = self.constraints[constraint];
        self.lu.tile_mut(node)[own][own] += value;
    }

    /// Write the blocks of a point: a joint is eliminated after its bodies, so that its column of Gᵀ is the first block of a pair.
    pub(crate) fn write_point(&mut self, place: &PointPlaces, point: &PointEntries) {
        let PointEntries {
            slopes: [one, other],
            across: [one_across, other_across],
            bends,
            compliances,
        } = point;
        for (k, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let below = [
                [sign, 0.0, one[k], 0.0],
                [0.0, sign, other[k], 0.0],
                [0.0; 4],
            ];
            let turn = [one_across[k], other_across[k], 0.0, 0.0];
            let beside = [[sign, 0.0, 0.0, 0.0], [0.0, sign, 0.0, 0.0], turn];
            self.lu.write_pair(place.pairs[k], &below, &beside);
            self.lu.tile_mut(place.bodies[k])[2][2] += bends[k];
        }
        let own = self.lu.tile_mut(place.joint);
        (0..2).for_each(|i| own[i][i] += compliances[i]);
    }

    /// Add the block of two bodies.
    pub(crate) fn add_pair(&mut self, places: &PairPlaces, block: &CoordinateBlock) {
        for (at, (row, column)) in places.iter().zip([(0, 0), (0, 3), (3, 0), (3, 3)]) {
            let Some(at) = *at else { continue };
            for (l, entries) in self.lu.tile_mut(at).iter_mut().enumerate() {
                for k in 0..3 {
                    entries[k] += block[row + k][column + l];
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
        let own = places.own;
        for ((at, down), across) in places.blocks.iter().zip(down).zip(across) {
            let Some([below, beside]) = *at else { continue };
            let column = &mut self.lu.tile_mut(below)[own];
            column.iter_mut().zip(down).for_each(|(x, j)| *x += j);
            let columns = self.lu.tile_mut(beside).iter_mut();
            columns.zip(across).for_each(|(x, j)| x[own] += j);
        }
    }

    /// Factorise; return false when the matrix is singular or not finite.
    pub(crate) fn factorise(&mut self) -> bool {
        self.lu.factorise()
    }

    /// Write the right-hand side by coordinate and by constraint.
    pub(crate) fn write_right(
        &mut self,
        velocity: impl Fn(usize) -> f64,
        constraint: impl Fn(usize) -> f64,
    ) {
        let right = self.lu.right_mut();
        for (body, &node) in self.bodies.iter().enumerate() {
            let [x, y, turn] = [0, 1, 2].map(|k| velocity(3 * body + k));
            right[node] = [x, y, turn, 0.0];
        }
        for (i, &(node, own)) in self.constraints.iter().enumerate() {
            right[node][own] = constraint(i);
        }
    }

    /// Call `visit` with the number of each coordinate and its solution.
    pub(crate) fn visit_velocities(&self, mut visit: impl FnMut(usize, f64)) {
        let right = self.lu.right();
        for (body, &node) in self.bodies.iter().enumerate() {
            (0..3).for_each(|k| visit(3 * body + k, right[node][k]));
        }
    }

    /// Call `visit` with the number of each constraint and its solution.
    pub(crate) fn visit_multipliers(&self, mut visit: impl FnMut(usize, f64)) {
        let right = self.lu.right();
        for (i, &(node, own)) in self.constraints.iter().enumerate() {
            visit(i, right[node][own]);
        }
    }

    /// Overwrite the right-hand side by the solution.
    pub(crate) fn solve(&mut self) {
        self.lu.solve();
    }
}

//! L U factors of a sparse matrix of small blocks with symmetric structure, for equations of motion with constraints.
//!
//! Nodes are bodies and joints, with up to three unknowns each. The order of elimination and the places of all blocks are determined
//! once. A joint is eliminated after its bodies: its pivot is then -G A⁻¹ Gᵀ, which is definite, and no pivoting between blocks is
//! needed. Blocks that are zero at present are skipped.

#![allow(clippy::inline_always)] // a function that is not inlined is compiled without the kernel's instruction set

mod tile;

use std::collections::BTreeSet;

use pulp::{Simd, WithSimd};

use tile::{inverse, less_image, negative, product, subtract_product};

use super::symbolic::{Tie, least_degree_order, patterns, upper_triangle};
use crate::math::simd::InstructionSet;

/// A block by columns. The fourth number of a column is zero; it fills a SIMD vector.
pub(crate) type Tile = [[f64; 4]; 3];

/// Unknowns of a node, padded as a column of a [`Tile`].
pub(crate) type Part = [f64; 4];

const ZERO: Tile = [[0.0; 4]; 3];

/// A later node of a live pair, and its number of unknowns.
#[derive(Debug, Clone, Copy)]
struct Later {
    node: usize,
    size: usize,
    /// Number of the pair among those of the earlier node.
    local: usize,
}

/// Matrix and its factors.
#[derive(Debug, Clone)]
pub(crate) struct BlockLu {
    /// Place of each node in the order of elimination.
    place: Vec<usize>,
    /// Number of unknowns of each node, in the order of elimination: two or three. A node of one unknown has a second one, decoupled.
    sizes: Vec<usize>,
    /// Nodes of one unknown.
    single: Vec<usize>,
    /// Pairs of adjacent nodes: those of node k with later nodes are `start[k]..start[k + 1]`, and `later` is the other node.
    start: Vec<usize>,
    later: Vec<usize>,
    /// For every two pairs of one node, the pair of their later nodes.
    target_start: Vec<usize>,
    targets: Vec<usize>,
    /// Diagonal blocks, after a factorisation minus the inverses of the pivots; then for each pair of nodes k, i the blocks (k, i) and (i, k).
    tiles: Vec<Tile>,
    /// Pairs whose blocks are not zero at present.
    live: Vec<bool>,
    /// Factors: the number of live pairs of each node, then by pair the later node, the block of U and that of -L.
    counts: Vec<usize>,
    active: Vec<Later>,
    factors: Vec<[Tile; 2]>,
    /// Right-hand side and solution, in the order of elimination.
    right: Vec<Part>,
    instructions: InstructionSet,
}

impl BlockLu {
    /// Return a zero matrix with nodes of these sizes, of which those from `first_joint` on are joints; `neighbours` are the adjacent
    /// nodes of each.
    pub(crate) fn new(sizes: &[usize], first_joint: usize, neighbours: &[BTreeSet<usize>]) -> Self {
        let n = sizes.len();
        let order = least_degree_order(neighbours.to_vec(), first_joint, Tie::Untouched);
        let mut place = vec![0; n];
        for (k, &node) in order.iter().enumerate() {
            place[node] = k;
        }
        let (above_start, above) = upper_triangle(&order, &place, neighbours);
        let (row_start, columns) = patterns(&above_start, &above);
        let mut after = vec![Vec::new(); n];
        for i in 0..n {
            for &k in &columns[row_start[i]..row_start[i + 1]] {
                after[k].push(i);
            }
        }
        let (mut start, mut later) = (vec![0], Vec::new());
        for after in &after {
            later.extend(after);
            start.push(later.len());
        }
        let pair = |k: usize, i: usize| {
            let found = later[start[k]..start[k + 1]].binary_search(&i);
            start[k] + found.unwrap_or(0)
        };
        let (mut target_start, mut targets) = (Vec::with_capacity(n), Vec::new());
        for after in &after {
            target_start.push(targets.len());
            for (b, &j) in after.iter().enumerate() {
                targets.extend(after[..b].iter().map(|&i| pair(i, j)));
            }
        }
        Self {
            sizes: order.iter().map(|&node| sizes[node].max(2)).collect(),
            single: (0..n).filter(|&k| sizes[order[k]] == 1).collect(),
            tiles: vec![ZERO; n + 2 * later.len()],
            live: vec![false; later.len()],
            counts: vec![0; n],
            active: Vec::with_capacity(later.len()),
            factors: Vec::with_capacity(later.len()),
            right: vec![[0.0; 4]; n],
            // A column of a block is one AVX2 register.
            instructions: InstructionSet::detect_for(ZERO[0].len()),
            place,
            start,
            later,
            target_start,
            targets,
        }
    }

    /// Return the place of a node in the order of elimination.
    pub(crate) fn place(&self, node: usize) -> usize {
        self.place[node]
    }

    /// Return the number of the block in the row of one node and the column of another; they must be adjacent or the same.
    pub(crate) fn block(&self, row: usize, column: usize) -> usize {
        let (row, column) = (self.place[row], self.place[column]);
        if row == column {
            return row;
        }
        let (k, i) = (row.min(column), row.max(column));
        let found = self.later[self.start[k]..self.start[k + 1]].binary_search(&i);
        let pair = self.start[k] + found.unwrap_or(0);
        self.tiles_of(pair) + usize::from(row > column)
    }

    /// Return the number of the first of the two blocks of a pair.
    #[inline]
    fn tiles_of(&self, pair: usize) -> usize {
        self.sizes.len() + 2 * pair
    }

    /// Set all entries to zero, except for the diagonal blocks of the nodes from `first_joint` on, in the order of description.
    pub(crate) fn clear(&mut self, first_joint: usize) {
        self.live.fill(false);
        for &node in &self.place[first_joint..] {
            self.tiles[node] = ZERO;
        }
        for &node in &self.single {
            self.tiles[node][1][1] = 1.0;
        }
    }

    /// Write the diagonal entries of a node, in the order of elimination; its other ones become zero.
    #[inline]
    pub(crate) fn write_diagonal(&mut self, node: usize, [x, y, z]: [f64; 3]) {
        self.tiles[node] = [[x, 0.0, 0.0, 0.0], [0.0, y, 0.0, 0.0], [0.0, 0.0, z, 0.0]];
    }

    /// Return a block for the addition of entries.
    #[inline]
    pub(crate) fn tile_mut(&mut self, block: usize) -> &mut Tile {
        if let Some(beyond) = block.checked_sub(self.sizes.len()) {
            self.revive(beyond / 2);
        }
        &mut self.tiles[block]
    }

    /// Write both blocks of a pair of nodes; `block` is the number of the one in the row of the node that is eliminated first.
    #[inline]
    pub(crate) fn write_pair(&mut self, block: usize, upper: &Tile, lower: &Tile) {
        self.live[(block - self.sizes.len()) / 2] = true;
        if let [to_upper, to_lower, ..] = &mut self.tiles[block..] {
            (*to_upper, *to_lower) = (*upper, *lower);
        }
    }

    /// Set the blocks of a pair to zero if they are left from an earlier matrix.
    #[inline(always)]
    fn revive(&mut self, pair: usize) {
        if !self.live[pair] {
            self.live[pair] = true;
            let at = self.tiles_of(pair);
            self.tiles[at] = ZERO;
            self.tiles[at + 1] = ZERO;
        }
    }

    /// Factorise; return false when the matrix is singular or not finite.
    pub(crate) fn factorise(&mut self) -> bool {
        self.instructions.run(Eliminate(self))
    }

    /// Return the right-hand side or the solution, in the order of elimination.
    pub(crate) fn right(&self) -> &[Part] {
        &self.right
    }

    /// Return the right-hand side for changes.
    pub(crate) fn right_mut(&mut self) -> &mut [Part] {
        &mut self.right
    }

    /// Overwrite the right-hand side by the solution.
    pub(crate) fn solve(&mut self) {
        self.instructions.run(Substitute(self));
    }

    /// Eliminate node k, which has K unknowns, from all later nodes: A(i, j) -= A(i, k) A(k, k)⁻¹ A(k, j).
    #[inline(always)]
    fn eliminate<S: Simd, const K: usize>(&mut self, simd: S, k: usize) -> bool {
        let nodes = self.sizes.len();
        let (begin, end) = (self.start[k], self.start[k + 1]);
        // The blocks of node k stand before those that its elimination changes.
        let (before, after) = self.tiles.split_at_mut(nodes + 2 * end);
        let (diagonal, own) = before.split_at_mut(nodes);
        let own = &own[2 * begin..];
        let Some(inverse) = inverse::<K>(&diagonal[k]) else {
            return false;
        };
        let minus = negative(&inverse);
        diagonal[k] = minus;
        let first = self.active.len();
        let (active, factors, live) = (&mut self.active, &mut self.factors, &mut self.live[..]);
        let pairs = self.later[begin..end].iter().zip(&live[begin..end]);
        for (local, ((&node, &live), blocks)) in pairs.zip(own.as_chunks().0).enumerate() {
            if live {
                let [upper, lower]: &[Tile; 2] = blocks;
                let (size, lower) = (self.sizes[node], product::<S, K>(simd, lower, &minus));
                active.push(Later { node, size, local });
                factors.push([*upper, lower]);
                subtract_product::<S, K>(simd, &mut diagonal[node], &lower, upper, size);
            }
        }
        self.counts[k] = active.len() - first;
        let (active, factors) = (&active[first..], &factors[first..]);
        let targets = &self.targets[self.target_start[k]..];
        for (b, (pair, [upper, lower])) in active.iter().zip(factors).enumerate() {
            let targets = &targets[pair.local * pair.local.saturating_sub(1) / 2..];
            for (other, [upper_other, lower_other]) in active[..b].iter().zip(factors) {
                let target = targets[other.local];
                let [to_upper, to_lower, ..] = &mut after[2 * (target - end)..] else {
                    return false;
                };
                if !live[target] {
                    live[target] = true;
                    (*to_upper, *to_lower) = (ZERO, ZERO);
                }
                subtract_product::<S, K>(simd, to_upper, lower_other, upper, pair.size);
                subtract_product::<S, K>(simd, to_lower, lower, upper_other, other.size);
            }
        }
        true
    }
}

/// The factorisation as a kernel.
struct Eliminate<'a>(&'a mut BlockLu);

impl WithSimd for Eliminate<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let lu = self.0;
        lu.active.clear();
        lu.factors.clear();
        for k in 0..lu.sizes.len() {
            let regular = if lu.sizes[k] == 3 {
                lu.eliminate::<S, 3>(simd, k)
            } else {
                lu.eliminate::<S, 2>(simd, k)
            };
            if !regular {
                return false;
            }
        }
        true
    }
}

/// The solution of L y = b, then U x = y, as a kernel.
struct Substitute<'a>(&'a mut BlockLu);

impl WithSimd for Substitute<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let lu = self.0;
        // Unknowns that a node lacks are zero, so that all nodes are taken alike, without branches.
        let right = &mut lu.right[..];
        let mut pairs = lu.active.iter().zip(&lu.factors);
        for (k, &count) in lu.counts.iter().enumerate() {
            let known = right[k];
            for (pair, [_, lower]) in pairs.by_ref().take(count) {
                let sum = &mut right[pair.node];
                *sum = less_image::<S, 3>(simd, sum, lower, &known);
            }
        }
        let mut pairs = lu.active.iter().zip(&lu.factors).rev();
        let nodes = lu.counts.iter().zip(&lu.tiles).enumerate();
        for (k, (&count, minus_inverse)) in nodes.rev() {
            let mut rest = right[k];
            for (pair, [upper, _]) in pairs.by_ref().take(count) {
                rest = less_image::<S, 3>(simd, &rest, upper, &right[pair.node]);
            }
            right[k] = less_image::<S, 3>(simd, &[0.0; 4], minus_inverse, &rest);
        }
    }
}

#[cfg(test)]
mod tests;

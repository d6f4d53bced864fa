//! L U factors of a sparse matrix of small blocks with symmetric structure, for equations of motion with constraints.
//!
//! Nodes are bodies and joints, with up to three unknowns each. The order of elimination and the places of all blocks are determined
//! once. A joint is eliminated after its bodies: its pivot is then -G A⁻¹ Gᵀ, which is definite, and no pivoting between blocks is
//! needed. Blocks that are zero at present are skipped.

#![allow(clippy::inline_always)] // a function that is not inlined is compiled without the kernel's instruction set

mod tile;

use std::collections::BTreeSet;

use pulp::{Simd, WithSimd};

use tile::{inverse, less_image, minus_product, negative, subtract_product};

use super::symbolic::{least_degree_order, patterns, upper_triangle};
use crate::math::simd::InstructionSet;

/// A block by columns. The fourth number of a column is zero; it fills a SIMD vector.
pub(crate) type Tile = [[f64; 4]; 3];

/// Unknowns of a node, padded as a column of a [`Tile`].
pub(crate) type Part = [f64; 4];

const ZERO: Tile = [[0.0; 4]; 3];

/// Matrix and its factors.
#[derive(Debug, Clone)]
pub(crate) struct BlockLu {
    /// Place of each node in the order of elimination.
    place: Vec<usize>,
    /// Number of unknowns of each node, in the order of elimination.
    sizes: Vec<usize>,
    /// Pairs of adjacent nodes: those of node k with later nodes are `start[k]..start[k + 1]`, and `later` is the other node.
    start: Vec<usize>,
    later: Vec<usize>,
    /// For every two pairs of one node, the pair of their later nodes.
    target_start: Vec<usize>,
    targets: Vec<usize>,
    /// Diagonal blocks, then for each pair of nodes k, i the blocks (k, i) and (i, k).
    tiles: Vec<Tile>,
    /// Pairs whose blocks are not zero at present.
    live: Vec<bool>,
    /// The live pairs of each node after a factorisation.
    active_start: Vec<usize>,
    active: Vec<usize>,
    /// Right-hand side and solution, in the order of elimination.
    right: Vec<Part>,
    instructions: InstructionSet,
}

impl BlockLu {
    /// Return a zero matrix with nodes of these sizes, of which those from `first_joint` on are joints; `neighbours` are the adjacent
    /// nodes of each.
    pub(crate) fn new(sizes: &[usize], first_joint: usize, neighbours: &[BTreeSet<usize>]) -> Self {
        let n = sizes.len();
        let order = least_degree_order(neighbours.to_vec(), first_joint);
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
            sizes: order.iter().map(|&node| sizes[node]).collect(),
            tiles: vec![ZERO; n + 2 * later.len()],
            live: vec![false; later.len()],
            active_start: vec![0; n + 1],
            active: Vec::with_capacity(later.len()),
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

    /// Set all entries to zero.
    pub(crate) fn clear(&mut self) {
        self.live.fill(false);
        for (tile, &size) in self.tiles.iter_mut().zip(&self.sizes) {
            *tile = ZERO;
            // Unknowns that pad a node are decoupled.
            for (k, column) in tile.iter_mut().enumerate().skip(size) {
                column[k] = 1.0;
            }
        }
    }

    /// Return a block for the addition of entries.
    #[inline]
    pub(crate) fn tile_mut(&mut self, block: usize) -> &mut Tile {
        if let Some(beyond) = block.checked_sub(self.sizes.len()) {
            self.revive(beyond / 2);
        }
        &mut self.tiles[block]
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

    /// Eliminate node k from all later nodes: A(i, j) -= A(i, k) A(k, k)⁻¹ A(k, j).
    #[inline(always)]
    fn eliminate<S: Simd>(&mut self, simd: S, k: usize) -> bool {
        let Some(inverse) = inverse(&self.tiles[k], self.sizes[k]) else {
            return false;
        };
        self.tiles[k] = inverse;
        let minus = negative(&inverse);
        let first = self.active.len();
        let (begin, end) = (self.start[k], self.start[k + 1]);
        for pair in begin..end {
            if self.live[pair] {
                self.active.push(pair);
                let lower = self.tiles_of(pair) + 1;
                self.tiles[lower] = minus_product(simd, &self.tiles[lower], &minus);
            }
        }
        let last = self.active.len();
        self.active_start[k + 1] = last;
        for b in first..last {
            let pair_b = self.active[b];
            let (j, at_b) = (self.later[pair_b], self.tiles_of(pair_b));
            let (upper, lower) = (self.tiles[at_b], self.tiles[at_b + 1]);
            subtract_product(simd, &mut self.tiles[j], &lower, &upper);
            let local = pair_b - begin;
            let targets = self.target_start[k] + local * local.saturating_sub(1) / 2;
            for a in first..b {
                let pair_a = self.active[a];
                let at_a = self.tiles_of(pair_a);
                let (upper_a, lower_a) = (self.tiles[at_a], self.tiles[at_a + 1]);
                let target = self.targets[targets + pair_a - begin];
                self.revive(target);
                let at = self.tiles_of(target);
                subtract_product(simd, &mut self.tiles[at], &lower_a, &upper);
                subtract_product(simd, &mut self.tiles[at + 1], &lower, &upper_a);
            }
        }
        true
    }

    /// Return the live pairs of node k.
    #[inline(always)]
    fn live_pairs(&self, k: usize) -> &[usize] {
        &self.active[self.active_start[k]..self.active_start[k + 1]]
    }
}

/// The factorisation as a kernel.
struct Eliminate<'a>(&'a mut BlockLu);

impl WithSimd for Eliminate<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        self.0.active.clear();
        for k in 0..self.0.sizes.len() {
            if !self.0.eliminate(simd, k) {
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
        let mut right = std::mem::take(&mut lu.right);
        for k in 0..lu.sizes.len() {
            let known = right[k];
            for &pair in lu.live_pairs(k) {
                let tile = &lu.tiles[lu.tiles_of(pair) + 1];
                let other = lu.later[pair];
                right[other] = less_image(simd, &right[other], tile, &known);
            }
        }
        for k in (0..lu.sizes.len()).rev() {
            let mut rest = right[k];
            for &pair in lu.live_pairs(k) {
                let tile = &lu.tiles[lu.tiles_of(pair)];
                rest = less_image(simd, &rest, tile, &right[lu.later[pair]]);
            }
            let minus = [-rest[0], -rest[1], -rest[2], 0.0];
            right[k] = less_image(simd, &[0.0; 4], &lu.tiles[k], &minus);
        }
        lu.right = right;
    }
}

#[cfg(test)]
mod tests;

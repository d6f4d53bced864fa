//! Symbolic factorisation: the order of elimination and the structure of sparse factors.

use std::collections::BTreeSet;

/// Return for each free body its constraints, each with its part of the row.
pub(crate) fn rows_on_bodies(
    first: &[Option<usize>],
    bodies: &[[usize; 3]],
) -> Vec<Vec<(usize, usize)>> {
    let mut found = vec![Vec::new(); first.len()];
    for (row, parts) in bodies.iter().enumerate() {
        for (part, &body) in parts.iter().enumerate() {
            if first[body].is_some() {
                found[body].push((row, part));
            }
        }
    }
    found
}

/// Order of elimination of nodes with equally many neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Tie {
    /// The one described first.
    Described,
    /// The one whose neighbours have not been eliminated for the longest time. A ring then loses every second node, again and again, so
    /// that a coupling to a node outside the ring spreads over few of its nodes.
    Untouched,
}

/// Return the minimum-degree order: the node with the fewest neighbours is eliminated first, and its neighbours become neighbours of each
/// other. Nodes from `first_joint` on wait until all of their own neighbours are eliminated.
pub(crate) fn least_degree_order(
    mut neighbours: Vec<BTreeSet<usize>>,
    first_joint: usize,
    tie: Tie,
) -> Vec<usize> {
    let joints = neighbours.get(first_joint..).unwrap_or_default().to_vec();
    let mut waits_for: Vec<usize> = vec![0; first_joint.min(neighbours.len())];
    waits_for.extend(joints.iter().map(BTreeSet::len));
    let mut joints_of = vec![Vec::new(); neighbours.len()];
    for (joint, bodies) in joints.iter().enumerate() {
        for &body in bodies {
            joints_of[body].push(first_joint + joint);
        }
    }
    // Number of the last elimination of a neighbour.
    let mut touched = vec![0; neighbours.len()];
    let mut queue: BTreeSet<(usize, usize, usize)> = (neighbours.iter().enumerate())
        .filter(|&(i, _)| waits_for[i] == 0)
        .map(|(i, n)| (n.len(), 0, i))
        .collect();
    let mut order = Vec::with_capacity(neighbours.len());
    while let Some((_, _, row)) = queue.pop_first() {
        order.push(row);
        let around = std::mem::take(&mut neighbours[row]);
        for &i in &around {
            queue.remove(&(neighbours[i].len(), touched[i], i));
            neighbours[i].remove(&row);
            neighbours[i].extend(around.iter().copied().filter(|&j| j != i));
            if tie == Tie::Untouched {
                touched[i] = order.len();
            }
            if waits_for[i] == 0 {
                queue.insert((neighbours[i].len(), touched[i], i));
            }
        }
        for &joint in &joints_of[row] {
            waits_for[joint] -= 1;
            if waits_for[joint] == 0 {
                queue.insert((neighbours[joint].len(), touched[joint], joint));
            }
        }
    }
    order
}

pub(crate) fn upper_triangle(
    order: &[usize],
    place: &[usize],
    neighbours: &[BTreeSet<usize>],
) -> (Vec<usize>, Vec<usize>) {
    let (mut start, mut above) = (vec![0], Vec::new());
    for (k, &row) in order.iter().enumerate() {
        let first = above.len();
        above.extend(neighbours[row].iter().map(|&j| place[j]).filter(|&j| j < k));
        above.push(k);
        above[first..].sort_unstable();
        start.push(above.len());
    }
    (start, above)
}

/// Return the columns of the entries of each row of L, found along the elimination tree from the entries of S.
pub(crate) fn patterns(start: &[usize], above: &[usize]) -> (Vec<usize>, Vec<usize>) {
    let m = start.len() - 1;
    let mut parent = vec![usize::MAX; m];
    let mut mark = vec![usize::MAX; m];
    let (mut pattern_start, mut pattern) = (vec![0], Vec::new());
    for k in 0..m {
        mark[k] = k;
        let first = pattern.len();
        for &entry in &above[start[k]..start[k + 1]] {
            let mut i = entry;
            // All columns on the path up the elimination tree, to the first marked one, have an entry in row k.
            while mark[i] != k {
                mark[i] = k;
                pattern.push(i);
                if parent[i] == usize::MAX {
                    parent[i] = k;
                }
                i = parent[i];
            }
        }
        pattern[first..].sort_unstable();
        pattern_start.push(pattern.len());
    }
    (pattern_start, pattern)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_loses_every_second_node_where_the_untouched_one_is_first() {
        let n = 16;
        let beside = |i: usize| BTreeSet::from([(i + 1) % n, (i + n - 1) % n]);
        let neighbours: Vec<_> = (0..n).map(beside).collect();
        let order = least_degree_order(neighbours.clone(), n, Tie::Untouched);
        let mut ring: Vec<usize> = (0..n).collect();
        for eliminated in [&order[..8], &order[8..12]] {
            let gone: Vec<bool> = ring.iter().map(|node| eliminated.contains(node)).collect();
            let adjacent = gone.iter().zip(gone.iter().cycle().skip(1));
            assert!(
                adjacent.clone().all(|(one, other)| one != other),
                "{order:?}"
            );
            ring.retain(|node| !eliminated.contains(node));
        }
        // In the order of description, one node after the other.
        let order = least_degree_order(neighbours, n, Tie::Described);
        assert_eq!(order, (0..n).collect::<Vec<_>>());
    }
}

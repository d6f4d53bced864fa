//! Factors of blocks against dense ones.

use nalgebra::{DMatrix, DVector};

use super::*;
use crate::math::testing::random;

/// Check inverses of random blocks of K unknowns by their products with the blocks.
fn check_inverses<const K: usize>(next: &mut impl FnMut() -> f64) {
    for _ in 0..20 {
        let mut block = ZERO;
        (0..3).for_each(|k| block[k][k] = 1.0);
        for column in block.iter_mut().take(K) {
            column.iter_mut().take(K).for_each(|x| *x = next());
        }
        if K == 3 {
            // Needs an exchange of rows.
            block[0][0] = 0.0;
        }
        let minus = negative(&inverse::<K>(&block).unwrap());
        let found = product::<_, K>(pulp::Scalar::new(), &block, &minus);
        for (c, column) in found.iter().enumerate().take(K) {
            for (r, x) in column.iter().enumerate() {
                let unit = f64::from(u8::from(r == c));
                assert!((x - unit).abs() < 1e-11, "{K} {found:?}");
            }
        }
    }
}

#[test]
fn inverses_of_blocks_are_those_of_dense_matrices() {
    let mut next = random(7);
    check_inverses::<2>(&mut next);
    check_inverses::<3>(&mut next);
    assert!(inverse::<3>(&ZERO).is_none());
    assert!(inverse::<2>(&[[1.0, 2.0, 0.0, 0.0], [2.0, 4.0, 0.0, 0.0], ZERO[0]]).is_none());
}

#[test]
fn solutions_of_a_closed_chain_are_those_of_dense_factors_and_vanishing_blocks_are_skipped() {
    // Five bodies in a ring of five joints, each body coupled to a sixth one.
    let (bodies, n) = (6, 11);
    let sizes: Vec<usize> = (0..n)
        .map(|i| {
            if i < bodies {
                3
            } else {
                1 + usize::from(i > bodies)
            }
        })
        .collect();
    let mut neighbours = vec![BTreeSet::new(); n];
    let mut edges = Vec::new();
    for k in 0..5 {
        edges.extend([(k, 6 + k), ((k + 1) % 5, 6 + k), (k, 5)]);
    }
    for &(i, j) in &edges {
        neighbours[i].insert(j);
        neighbours[j].insert(i);
    }
    let mut lu = BlockLu::new(&sizes, bodies, &neighbours);
    for (joint, its_bodies) in neighbours.iter().enumerate().skip(bodies) {
        let after_its_bodies = |&body: &usize| lu.place(body) < lu.place(joint);
        assert!(its_bodies.iter().all(after_its_bodies));
    }
    let first: Vec<usize> = (0..n).map(|i| sizes[..i].iter().sum()).collect();
    let total: usize = sizes.iter().sum();
    let mut next = random(7);
    // The second matrix has fewer blocks than the first, whose factors are still in place.
    for coupled in [5, 2] {
        let mut dense = DMatrix::zeros(total, total);
        lu.clear(0);
        let mut add = |lu: &mut BlockLu, i: usize, j: usize| {
            let tile = lu.tile_mut(lu.block(i, j));
            for (c, column) in tile.iter_mut().enumerate().take(sizes[j]) {
                for (r, entry) in column.iter_mut().enumerate().take(sizes[i]) {
                    let shift = if i == j && r == c { 4.0 } else { 0.0 };
                    // Joints have no entries of their own.
                    let value = if i == j && i >= bodies {
                        0.0
                    } else {
                        next() + shift
                    };
                    *entry += value;
                    dense[(first[i] + r, first[j] + c)] += value;
                }
            }
        };
        (0..n).for_each(|i| add(&mut lu, i, i));
        for &(i, j) in &edges {
            if j != 5 || i < coupled {
                add(&mut lu, i, j);
                add(&mut lu, j, i);
            }
        }
        assert!(lu.factorise());
        let right = DVector::from_fn(total, |i, _| (i as f64).sin());
        let mut expected = right.clone();
        assert!(dense.lu().solve_mut(&mut expected));
        for i in 0..n {
            let place = lu.place(i);
            let part = &mut lu.right_mut()[place];
            *part = [0.0; 4];
            part[..sizes[i]].copy_from_slice(&right.as_slice()[first[i]..first[i] + sizes[i]]);
        }
        lu.solve();
        for i in 0..n {
            let place = lu.place(i);
            let found = &lu.right()[place];
            for (k, found) in found.iter().enumerate().take(sizes[i]) {
                assert!((found - expected[first[i] + k]).abs() < 1e-10);
            }
        }
    }
}

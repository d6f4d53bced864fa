//! Tests of the ring: solutions against a dense matrix, and refusal of blocks without an inverse.

use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use pulp::{Simd, WithSimd};

use super::*;
use crate::math::simd::InstructionSet;

struct FactoriseRing<'a, T: Number> {
    ring: &'a mut Ring<T>,
    rows: &'a [Pack8<T>],
}

impl<T: Number> WithSimd for FactoriseRing<'_, T> {
    type Output = bool;
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        self.ring.factorise(T::vectors(simd), self.rows)
    }
}

struct SolveRing<'a, T: Number> {
    ring: &'a mut Ring<T>,
    unknowns: &'a mut [Numbers<T>; 2],
}

impl<T: Number> WithSimd for SolveRing<'_, T> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.ring.solve(T::vectors(simd), self.unknowns);
    }
}

/// Check that every instruction set solves a ring of `n` hinges with these rows to `bound` of the largest unknown, and that all those with
/// fused multiply-add give the same bits.
fn check_solutions<T: Number>(
    n: usize,
    rows: &[Pack8],
    (dense, right): (&DMatrix<f64>, &DVector<f64>),
    bound: f64,
) -> Result<(), TestCaseError> {
    let rows: Vec<Pack8<T>> = rows
        .iter()
        .map(|row| Pack8(row.0.map(T::nearest)))
        .collect();
    let mut bits: Option<Vec<f64>> = None;
    for set in InstructionSet::available() {
        let mut ring = Ring::new(n);
        let regular = T::run(
            set,
            FactoriseRing {
                ring: &mut ring,
                rows: &rows,
            },
        );
        prop_assert!(regular);
        let mut unknowns = [hinge_numbers(n), hinge_numbers(n)];
        for (i, &entry) in right.iter().enumerate() {
            unknowns[i % 2][BASE + i / 2] = T::nearest(entry);
        }
        T::run(
            set,
            SolveRing {
                ring: &mut ring,
                unknowns: &mut unknowns,
            },
        );
        let found = DVector::from_fn(2 * n, |i, _| unknowns[i % 2][BASE + i / 2].double());
        let error = (dense * &found - right).amax() / found.amax().max(1e-3);
        prop_assert!(error < bound, "{} {}", set.name(), error);
        if set.has_fused_multiply_add() {
            let same = bits.get_or_insert_with(|| found.as_slice().to_vec());
            prop_assert_eq!(&same[..], found.as_slice());
        }
    }
    Ok(())
}

proptest! {
    #[test]
    fn solutions_are_those_of_the_dense_matrix(
        n in 2usize..90,
        open in proptest::collection::vec(0u8..4, 90),
        any_open in any::<bool>(),
        numbers in proptest::collection::vec(-0.3f64..0.3, 800),
    ) {
        let closed = |k: usize| !any_open || open[k] > 0;
        let mut next = numbers.iter().copied().cycle();
        let mut rows: HingeRows<f64> = hinge_rows(n);
        for k in 0..n {
            let coupled = closed(k) && closed((k + n - 1) % n);
            let (own, before) = rows[k].0.split_at_mut(BEFORE);
            for (entry, own) in own[..3].iter_mut().enumerate() {
                let one = f64::from(u8::from(entry < 2));
                *own = if closed(k) { 1.5 * one + next.next().unwrap() } else { one };
            }
            for before in before {
                *before = if coupled { next.next().unwrap() } else { 0.0 };
            }
        }
        let mut dense = DMatrix::<f64>::zeros(2 * n, 2 * n);
        for k in 0..n {
            let ([a, d, b, _], coupling) = rows[k].0.split_first_chunk::<BEFORE>().unwrap();
            dense[(2 * k, 2 * k)] += a;
            dense[(2 * k + 1, 2 * k + 1)] += d;
            dense[(2 * k, 2 * k + 1)] += b;
            dense[(2 * k + 1, 2 * k)] += b;
            let before = (k + n - 1) % n;
            for (i, entry) in coupling.iter().enumerate() {
                dense[(2 * k + i / 2, 2 * before + i % 2)] += entry;
                dense[(2 * before + i % 2, 2 * k + i / 2)] += entry;
            }
        }
        let right = DVector::from_fn(2 * n, |i, _| if closed(i / 2) { 1.0 + (i % 7) as f64 } else { 0.0 });
        // Positive definite, and not by rounding only.
        prop_assume!(dense.clone().symmetric_eigenvalues().min() > 1e-3);
        check_solutions::<f64>(n, &rows, (&dense, &right), 1e-12)?;
        check_solutions::<f32>(n, &rows, (&dense, &right), 1e-4)?;
    }
}

#[test]
fn a_block_without_an_inverse_is_reported() {
    for hinge in [0, 3, 20, 37] {
        for wrong in [0.0, f64::NAN, -1.0] {
            let mut rows: HingeRows<f64> = hinge_rows(38);
            for row in &mut rows {
                row.0[..2].fill(1.0);
            }
            rows[hinge].0[0] = wrong;
            for set in InstructionSet::available() {
                let mut ring = Ring::new(38);
                let regular = set.run(FactoriseRing {
                    ring: &mut ring,
                    rows: &rows,
                });
                assert!(!regular, "{hinge} {wrong} {}", set.name());
            }
        }
    }
}

//! A contact in series with a spring: the contact's part of the total penetration.
//!
//! With the compliance c of the spring, the contact's penetration x at a total of d solves x + c F(x) = d. Newton's method from x = d
//! converges monotonically from above where F is convex. Bisection takes over elsewhere, at the end of a law's range. Each lane ends at its
//! own convergence to rounding, so that its result is independent of the other lanes of the vector.

use super::ElasticLaw;
use crate::math::{Real, Truth};

/// Relative change of the penetration at which the iteration ends: four units of rounding.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Number of steps before bisection is forced; the hinges of the published drive converge in 3 to 6.
const QUICK_STEPS: usize = 12;

/// Maximum number of steps. Every other step after `QUICK_STEPS` is a bisection, which suffices for any law.
const MOST_STEPS: usize = 120;

/// Return the contacts' own penetrations \[m\] at the totals `depth`, with the springs' compliances \[m/N\]. Totals that are not positive
/// are returned unchanged.
#[inline(always)]
pub(crate) fn depth_in_series<R: Real>(
    law: impl ElasticLaw,
    pair: [R; 2],
    compliance: R,
    depth: R,
) -> R {
    let (one, half) = (depth.constant(1.0), depth.constant(0.5));
    let zero = depth.constant(0.0);
    let rounding = depth * depth.constant(ROUNDING);
    let (mut x, mut low, mut high) = (depth, zero, depth);
    let mut moves = depth.greater(zero);
    for round in 0..MOST_STEPS {
        let force_and_root = law.elastic_and_root(pair, x);
        let slope = law.slope(pair, x, force_and_root);
        let [force, _] = force_and_root;
        let excess = compliance.mul_add(force, x - depth);
        let above = excess.greater(zero);
        high = above.select(x, high);
        low = above.select(low, x);
        // Newton step for x + c F(x) - d = 0, replaced by the midpoint outside of the bracket.
        let middle = half * (low + high);
        let mut next = x - excess / compliance.mul_add(slope, one);
        next = next.less(low).or(next.greater(high)).select(middle, next);
        if round > QUICK_STEPS && round % 2 == 0 {
            next = middle;
        }
        moves = moves.and((next - x).abs().greater(rounding));
        if !moves.any() {
            break;
        }
        x = moves.select(next, x);
    }
    x
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use pulp::{Simd, WithSimd};

    use super::*;
    use crate::force_law::{Elastic, PairTable, SurfacePair};
    use crate::math::simd::{InstructionSet, Lanes};

    const COMPLIANCES: [f64; 4] = [1e-11, 3e-9, 1e-7, 1e-5];

    fn depths() -> impl Iterator<Item = f64> {
        (0..60).map(|i| 1e-10 * 1.25f64.powi(i))
    }

    fn laws() -> Vec<PairTable> {
        let pair = SurfacePair::internal(2.22e-3, 2.245e-3, 0.011, 1.1e11);
        let mut laws = Elastic::ALL.to_vec();
        laws.push(Elastic::Linear(3e8));
        (laws.into_iter())
            .map(|law| PairTable::prepare(law, &[pair]))
            .collect()
    }

    /// The same by bisection.
    fn halved(law: impl ElasticLaw, pair: &[f64; 2], compliance: f64, depth: f64) -> f64 {
        let (mut low, mut high) = (0.0, depth);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if middle + compliance * law.force(pair, middle) < depth {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }

    #[test]
    fn depths_are_those_found_by_halving_for_every_law() {
        for table in laws() {
            let (law, pair) = (table.form(), table.pairs()[0]);
            for compliance in COMPLIANCES {
                for depth in depths() {
                    let found = depth_in_series(law, pair, compliance, depth);
                    let expected = halved(law, &pair, compliance, depth);
                    assert!(
                        (found - expected).abs() <= 1e-14 * depth,
                        "{table:?}, {compliance:e} m/N, {depth:e} m: {found:e} for {expected:e}"
                    );
                }
            }
        }
    }

    #[test]
    fn nothing_gives_way_by_nothing() {
        for table in laws() {
            let (law, pair) = (table.form(), table.pairs()[0]);
            assert_eq!(depth_in_series(law, pair, 1e-8, 0.0), 0.0);
            assert_eq!(depth_in_series(law, pair, 1e-8, -1e-6), -1e-6);
            assert!(depth_in_series(law, pair, 1e-8, f64::NAN).is_nan());
        }
    }

    struct InSeries<'a> {
        table: &'a PairTable,
        compliance: f64,
        depths: &'a [f64],
        found: &'a mut Vec<f64>,
    }

    impl WithSimd for InSeries<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let splat = |value| Lanes::splat(simd, value);
            let (law, constants) = (self.table.form(), self.table.pairs()[0].map(splat));
            for &depth in self.depths {
                let x = depth_in_series(law, constants, splat(self.compliance), splat(depth));
                self.found.push(x.greatest());
            }
        }
    }

    #[test]
    fn vectors_give_what_single_depths_give() {
        let depths: Vec<f64> = std::iter::once(0.0).chain(depths()).collect();
        for table in laws() {
            for compliance in COMPLIANCES {
                for set in InstructionSet::available() {
                    let mut found = Vec::new();
                    set.run(InSeries {
                        table: &table,
                        compliance,
                        depths: &depths,
                        found: &mut found,
                    });
                    let (law, pair) = (table.form(), table.pairs()[0]);
                    for (&depth, found) in depths.iter().zip(found) {
                        let expected = depth_in_series(law, pair, compliance, depth);
                        assert!(
                            (found - expected).abs() <= 1e-14 * depth,
                            "{table:?} {depth:e}"
                        );
                    }
                }
            }
        }
    }

    thread_local! {
        static EVALUATIONS: Cell<u32> = const { Cell::new(0) };
    }

    /// A cubic force, f = 1e18 δ³, whose evaluations are counted.
    #[derive(Clone, Copy)]
    struct Counted;

    impl ElasticLaw for Counted {
        fn elastic<R: Real>(self, _: [R; 2], penetration: R) -> R {
            EVALUATIONS.set(EVALUATIONS.get() + 1);
            penetration.constant(1e18) * penetration * penetration * penetration
        }

        fn slope<R: Real>(self, _: [R; 2], penetration: R, _: [R; 2]) -> R {
            penetration.constant(3e18) * penetration * penetration
        }

        fn stored(self, _: &[f64; 2], _: f64, _: f64) -> f64 {
            0.0
        }
    }

    #[test]
    fn newtons_method_takes_few_evaluations_where_the_force_is_convex() {
        for (compliance, most) in [(1e-9, 4), (1e-8, 5), (1e-7, 6), (1e-6, 7)] {
            EVALUATIONS.set(0);
            let found = depth_in_series(Counted, [0.0; 2], compliance, 1e-6);
            let rest = found + compliance * 1e18 * found.powi(3) - 1e-6;
            assert!(rest.abs() < 1e-20, "{compliance:e}: {rest:e}");
            assert!(
                EVALUATIONS.get() <= most,
                "{compliance:e}: {}",
                EVALUATIONS.get()
            );
        }
    }

    /// A force that jumps from zero to one newton at 0.3 m; its slope does not show the jump.
    #[derive(Clone, Copy)]
    struct Jump;

    impl ElasticLaw for Jump {
        fn elastic<R: Real>(self, _: [R; 2], penetration: R) -> R {
            let jump = penetration.greater(penetration.constant(0.3));
            jump.select(penetration.constant(1.0), penetration.constant(0.0))
        }

        fn slope<R: Real>(self, _: [R; 2], penetration: R, _: [R; 2]) -> R {
            penetration.constant(0.0)
        }

        fn stored(self, _: &[f64; 2], _: f64, _: f64) -> f64 {
            0.0
        }
    }

    #[test]
    fn bisection_finds_the_jump_at_which_newtons_method_has_a_cycle() {
        let found = depth_in_series(Jump, [0.0; 2], 0.9, 1.0);
        assert!((found - 0.3).abs() < 1e-13, "{found}");
    }
}

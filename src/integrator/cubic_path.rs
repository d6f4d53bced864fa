//! The cubic through values and slopes at both ends of the last step, at any order of that step.
//!
//! The dense output of an implicit step does not begin where the step began, and has its own error inside.

use pulp::{Simd, WithSimd};

use super::Adams;
use crate::math::simd::{Lanes, load, vectors, vectors_mut};

/// Write the cubic at a `part` of a step of `length` \[s\].
struct CubicPath<'a> {
    part: f64,
    length: f64,
    /// Values at both ends.
    ends: [&'a [f64]; 2],
    /// φ*_1 and φ*_2 of the step; without the second at order one, where it is zero.
    predicted: (&'a [f64], Option<&'a [f64]>),
    /// Newest difference of the step.
    newest: &'a [f64],
    y: &'a mut [f64],
}

impl WithSimd for CubicPath<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (part, rest) = (self.part, 1.0 - self.part);
        let splat = |value| Lanes::splat(simd, value);
        let from = splat((1.0 + 2.0 * part) * rest * rest);
        let from_slope = splat(self.length * part * rest * rest);
        let to_slope = splat(-self.length * part * part * rest);
        let blocks = self.y.len() / S::F64_LANES;
        let ends = self.ends.map(|y| vectors::<S>(y, blocks));
        let (phi_1, phi_2) = self.predicted;
        let (phi_1, newest) = (
            vectors::<S>(phi_1, blocks),
            vectors::<S>(self.newest, blocks),
        );
        let phi_2 = phi_2.map(|row| vectors::<S>(row, blocks));
        let y = vectors_mut::<S>(self.y, blocks);
        for b in 0..blocks {
            let [start, end] = ends.map(|y| load(simd, &y[b]));
            let phi = load(simd, &phi_1[b]);
            // φ*_1 = φ_1 + φ*_2, and φ_1 is the derivative at the start; φ*_1 plus the newest difference is that at the end.
            let rise = phi_2.map_or(phi, |row| phi - load(simd, &row[b]));
            let fall = phi + load(simd, &newest[b]);
            let bend = rise.mul_add(from_slope, fall * to_slope);
            y[b] = (from.mul_add(start - end, end) + bend).values();
        }
    }
}

impl Adams {
    /// Write the solution at a `part` of the last step into the padded `y`, by the cubic; valid until the next prediction.
    pub(crate) fn write_cubic(&self, part: f64, y: &mut [f64]) {
        let (phi_1, phi_2, newest) = self.history.differences.rows_of_last_step();
        self.instructions.run(CubicPath {
            part,
            length: self.history.last_step_size,
            // An accepted step swaps the solution with its trial value.
            ends: [&self.vectors.trial, &self.vectors.y],
            predicted: (phi_1, phi_2),
            newest,
            y,
        });
    }
}

#[cfg(test)]
impl Adams {
    /// Return the slopes of the cubic at the start and at the end of the last step.
    pub(crate) fn slopes_of_last_step(&self) -> [Vec<f64>; 2] {
        let (phi_1, phi_2, newest) = self.history.differences.rows_of_last_step();
        let all = 0..self.vectors.dimension;
        let at_start = |i: usize| phi_1[i] - phi_2.map_or(0.0, |row| row[i]);
        [
            all.clone().map(at_start).collect(),
            all.map(|i| phi_1[i] + newest[i]).collect(),
        ]
    }
}

#[cfg(test)]
mod tests {
    use crate::integrator::{Adams, Corrector, OdeSystem, SecondOrderSystem, StepControl};
    use crate::math::simd::padded;

    const NQ: usize = 11;

    /// The acceleration of coordinate i is i cos t.
    struct Swings;

    impl OdeSystem for Swings {
        fn dimension(&self) -> usize {
            2 * NQ
        }
        fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
            let (rates, accelerations) = dydt.split_at_mut(NQ);
            rates.copy_from_slice(&y[NQ..]);
            for (i, acceleration) in accelerations.iter_mut().enumerate() {
                *acceleration = i as f64 * t.cos();
            }
        }
    }

    impl SecondOrderSystem for Swings {
        fn coordinates(&self) -> usize {
            NQ
        }
        fn factorise(&mut self, _y: &[f64], _gamma: f64) -> bool {
            true
        }
        fn correct(&mut self, _residual: &mut [f64]) {}
        fn scale(&self, lengths: &mut [f64]) {
            lengths.fill(1.0);
        }
    }

    /// Check the cubic of 40 steps against Newton's form of it and the exact accelerations.
    fn check(corrector: Corrector, max_order: usize) {
        let control = StepControl {
            max_order,
            corrector,
            ..StepControl::default()
        };
        let mut adams = Adams::new(2 * NQ, control);
        adams.restart(0.0, &[0.0; 2 * NQ]);
        let mut y = vec![0.0; padded(2 * NQ)];
        for _ in 0..40 {
            let before = adams.y().to_vec();
            let step = adams.step_second_order(&mut Swings).unwrap();
            let h = step.end - step.start;
            let [rise, fall] = adams.slopes_of_last_step();
            for part in [0.0, 0.3, 0.5, 1.0] {
                adams.write_cubic(part, &mut y);
                for i in 0..2 * NQ {
                    let (from, change) = (before[i], adams.y()[i] - before[i]);
                    let turn = h * rise[i] - change;
                    let bend = h * (rise[i] + fall[i]) - 2.0 * change;
                    let inside = part * (1.0 - part) * (turn - part * bend);
                    let expected = from + part * change + inside;
                    // Rounding of a few sums.
                    assert!((y[i] - expected).abs() < 1e-15 * (1.0 + from.abs()), "{i}");
                }
            }
            for i in 0..NQ {
                for (slope, t) in [&rise, &fall].into_iter().zip([step.start, step.end]) {
                    // Rounding of the velocities over the shortest step.
                    let exact = i as f64 * t.cos();
                    assert!((slope[NQ + i] - exact).abs() < 1e-9, "{i} {t}");
                }
            }
        }
    }

    #[test]
    fn the_cubic_has_values_and_slopes_of_both_ends_after_a_step_of_any_order() {
        for (corrector, max_order) in [
            (Corrector::Pece, 1),
            (Corrector::Pece, 12),
            (Corrector::Newton, 1),
            (Corrector::Newton, 2),
            (Corrector::Newton, 5),
        ] {
            check(corrector, max_order);
        }
    }
}

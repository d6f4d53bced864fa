//! SIMD kernels of one step over all components; one vector of components goes through all differences at once.

use pulp::{Simd, WithSimd};

use super::StepControl;
use super::coefficients::Coefficients;
use super::slice_lanes::{At, SliceLanes, SliceLanesMut, each_vector, vector_count};
use super::vectors::Vectors;
use crate::math::simd::{BlockKernel, Lanes, Squares, WIDTH, load, vectors, vectors_mut};

/// Run `$each` for each of `$blocks` vectors, with alternating parts of a sum, constants in the unrolled loop.
macro_rules! each_block {
    ($simd:ty, $blocks:expr, |$part:ident, $block:ident| $each:expr) => {
        let parts = Squares::<$simd>::PARTS;
        for group in (0..$blocks).step_by(parts) {
            for $part in 0..parts {
                let $block = group + $part;
                if $block >= $blocks {
                    break;
                }
                $each;
            }
        }
    };
}

/// Rows of the difference table as SIMD vectors; a row is as long as a padded vector of all components.
struct DifferenceRows<'a, S: Simd> {
    simd: S,
    table: &'a mut [S::f64s],
    /// SIMD vectors of a row.
    width: usize,
}

impl<'a, S: Simd> DifferenceRows<'a, S> {
    #[inline(always)]
    fn new(simd: S, table: &'a mut [f64], width: usize) -> Self {
        let all = table.len() / S::F64_LANES;
        Self {
            simd,
            table: vectors_mut::<S>(table, all),
            width: width / S::F64_LANES,
        }
    }

    #[inline(always)]
    fn get(&self, row: usize, block: usize) -> Lanes<S> {
        load(self.simd, &self.table[row * self.width + block])
    }

    #[inline(always)]
    fn set(&mut self, row: usize, block: usize, values: Lanes<S>) {
        self.table[row * self.width + block] = values.values();
    }
}

/// Add the newest difference to the rows before it, replace φ by φ*, and write the predicted value or its increment.
///
/// `φ*_i = β_i φ_i + φ*_{i+1}`, `p = y + h Σ g_i β_i φ_i`. φ_{k+1} is kept: [`UpdateDifferences`] needs it. The increment without y is
/// written for compensated summation.
pub(super) struct Predict<'a> {
    pub(super) coefficients: &'a Coefficients,
    pub(super) order: usize,
    /// Index of the newest difference, whose addition is deferred; zero for none.
    pub(super) newest: usize,
    pub(super) step: f64,
    pub(super) table: &'a mut [f64],
    /// Write the increment alone.
    pub(super) compensates: bool,
    pub(super) vectors: &'a mut Vectors,
}

impl BlockKernel for Predict<'_> {
    type Output = ();

    #[inline(always)]
    fn length(&self) -> usize {
        self.vectors.dimension
    }

    #[inline(always)]
    fn with_blocks<S: Simd>(self, simd: S, blocks: usize) {
        let c = self.coefficients;
        debug_assert!(
            c.beta[..c.equal_steps.min(self.order)]
                .iter()
                .all(|&beta| beta == 1.0)
        );
        let all = self.vectors;
        let mut stars = Stars {
            beta: &c.beta[..self.order],
            g: &c.g[..self.order],
            newest: self.newest,
            rows: DifferenceRows::<S>::new(simd, self.table, all.y.len()),
        };
        let step = Lanes::splat(simd, self.step);
        let y = (!self.compensates).then_some(vectors::<S>(&all.y, blocks));
        let predicted = vectors_mut::<S>(&mut all.predicted, blocks);
        if let [predicted] = predicted {
            // One vector: no loop.
            let sum = stars.sum_of_one();
            *predicted = increased(step * sum, y, 0);
            return;
        }
        for (b, predicted) in predicted.iter_mut().enumerate() {
            *predicted = increased(step * stars.sum(b), y, b);
        }
    }
}

/// Operands of [`Predict`] for one vector of components.
struct Stars<'a, S: Simd> {
    beta: &'a [f64],
    g: &'a [f64],
    newest: usize,
    rows: DifferenceRows<'a, S>,
}

/// Return vector `b` of y plus its increment, or the increment without y.
#[inline(always)]
fn increased<S: Simd>(increment: Lanes<S>, y: Option<&[S::f64s]>, b: usize) -> S::f64s {
    let y = y.map(|y| load(increment.simd(), &y[b]));
    y.map_or(increment, |y| increment + y).values()
}

impl<S: Simd> Stars<'_, S> {
    /// Replace φ by φ* in rows of one vector; return Σ g β φ, the same number as [`Self::sum`].
    ///
    /// The length of a row is a constant: its multiples and checks of bounds are left out.
    #[inline(always)]
    fn sum_of_one(&mut self) -> Lanes<S> {
        let (rows, order, newest) = (&mut self.rows, self.beta.len(), self.newest);
        let (simd, width) = (rows.simd, WIDTH / S::F64_LANES);
        let zero = Lanes::splat(simd, 0.0);
        let latest = if newest > 0 {
            load(simd, &rows.table[newest * width])
        } else {
            zero
        };
        let (below, above) = rows.table.split_at_mut(order * width);
        let fallen = newest.saturating_sub(order);
        for row in above.chunks_exact_mut(width).take(fallen) {
            row[0] = (load(simd, &row[0]) + latest).values();
        }
        let lacking = newest.min(order);
        let mut sums = [zero; 2];
        let below = below.chunks_exact_mut(width);
        let mut terms = below.zip(self.beta.iter().zip(self.g)).rev();
        for (row, (beta, g)) in terms.by_ref().take(order - lacking) {
            row[0] = star(load(simd, &row[0]), [*beta, *g], &mut sums);
        }
        for (row, (beta, g)) in terms {
            row[0] = star(load(simd, &row[0]) + latest, [*beta, *g], &mut sums);
        }
        sums[0]
    }

    /// Replace φ by φ* in vector `b` of all rows; return Σ g β φ.
    #[inline(always)]
    fn sum(&mut self, b: usize) -> Lanes<S> {
        let (rows, order, newest) = (&mut self.rows, self.beta.len(), self.newest);
        let zero = Lanes::splat(rows.simd, 0.0);
        // The newest difference is added to the rows before it, deferred from the last step.
        let latest = if newest > 0 {
            rows.get(newest, b)
        } else {
            zero
        };
        // The order fell: rows above it are completed, too, for a later rise.
        for i in order..newest {
            rows.set(i, b, rows.get(i, b) + latest);
        }
        // Rows that include the newest difference, and rows to which it is added here.
        let (whole, lacking) = (newest.min(order)..order, 0..newest.min(order));
        // From the highest order down: partial sums Σ β φ are the extrapolated differences.
        let mut sums = [zero; 2];
        let mut at = order * rows.width + b;
        for (beta, g) in self.beta[whole.clone()].iter().zip(&self.g[whole]).rev() {
            at -= rows.width;
            let phi = load(rows.simd, &rows.table[at]);
            rows.table[at] = star(phi, [*beta, *g], &mut sums);
        }
        for (beta, g) in self.beta[lacking.clone()]
            .iter()
            .zip(&self.g[lacking])
            .rev()
        {
            at -= rows.width;
            let phi = load(rows.simd, &rows.table[at]) + latest;
            rows.table[at] = star(phi, [*beta, *g], &mut sums);
        }
        sums[0]
    }
}

/// Return φ* of one order from φ.
///
/// `above` accumulates Σ β φ over this order and those above, which is φ*; `sum` accumulates Σ g β φ.
#[inline(always)]
fn star<S: Simd>(phi: Lanes<S>, [beta, g]: [f64; 2], [sum, above]: &mut [Lanes<S>; 2]) -> S::f64s {
    // β φ, whose sum with weight g is the increment of the predicted value.
    let term = phi * phi.constant(beta);
    *sum = term.mul_add(phi.constant(g), *sum);
    *above = *above + term;
    above.values()
}

/// Replace φ* by φ after a rejected step: `φ_i = (φ*_i - φ*_{i+1})/β_i`.
pub(super) struct UndoPrediction<'a> {
    pub(super) coefficients: &'a Coefficients,
    pub(super) order: usize,
    pub(super) dimension: usize,
    /// Components of a row, padded.
    pub(super) width: usize,
    pub(super) table: &'a mut [f64],
}

impl BlockKernel for UndoPrediction<'_> {
    type Output = ();

    #[inline(always)]
    fn length(&self) -> usize {
        self.dimension
    }

    #[inline(always)]
    fn with_blocks<S: Simd>(self, simd: S, blocks: usize) {
        // Inverse of the partial sums, row by row from the lowest order.
        let inverse = self.coefficients.beta.map(|beta| 1.0 / beta);
        let mut rows = DifferenceRows::<S>::new(simd, self.table, self.width);
        for b in 0..blocks {
            let mut here = rows.get(0, b);
            for (i, &inverse) in inverse.iter().enumerate().take(self.order) {
                let below = if i + 1 < self.order {
                    rows.get(i + 1, b)
                } else {
                    here.constant(0.0)
                };
                rows.set(i, b, (here - below) * here.constant(inverse));
                here = below;
            }
        }
    }
}

/// Write the newest difference `φ_{k+1} = f(y) - φ*_1` and, with `above`, `φ_{k+2}`; return its weighted sum of squares.
///
/// [`Predict`] adds the newest difference to the rows before it.
pub(super) struct UpdateDifferences<'a> {
    pub(super) order: usize,
    pub(super) table: &'a mut [f64],
    pub(super) vectors: &'a Vectors,
    pub(super) inverse_weight: &'a [f64],
    pub(super) above: bool,
}

impl BlockKernel for UpdateDifferences<'_> {
    type Output = f64;

    #[inline(always)]
    fn length(&self) -> usize {
        self.vectors.dimension
    }

    #[inline(always)]
    fn with_blocks<S: Simd>(self, simd: S, blocks: usize) -> f64 {
        let derivative = &self.vectors.derivative;
        let mut newest = Newest {
            order: self.order,
            rows: DifferenceRows::<S>::new(simd, self.table, derivative.len()),
            derivative: vectors::<S>(derivative, blocks),
            inverse_weight: vectors::<S>(self.inverse_weight, blocks),
        };
        match (self.above, blocks) {
            (false, _) => {
                for b in 0..blocks {
                    newest.write(b);
                }
                0.0
            }
            // One vector: no loop.
            (true, 1) => Squares::of_one(newest.write_above(0)),
            (true, _) => {
                let mut sum = Squares::new(simd);
                each_block!(S, blocks, |part, b| sum.add(part, newest.write_above(b)));
                sum.total()
            }
        }
    }
}

/// Operands of [`UpdateDifferences`].
struct Newest<'a, S: Simd> {
    order: usize,
    rows: DifferenceRows<'a, S>,
    derivative: &'a [S::f64s],
    inverse_weight: &'a [S::f64s],
}

impl<S: Simd> Newest<'_, S> {
    /// Write vector `b` of the newest difference, `φ_{k+1}(n+1) = f(y) - φ*_1`, and return it.
    #[inline(always)]
    fn write(&mut self, b: usize) -> Lanes<S> {
        let newest = load(self.rows.simd, &self.derivative[b]) - self.rows.get(0, b);
        self.rows.set(self.order, b, newest);
        newest
    }

    /// Write the same and `φ_{k+2}(n+1) = φ_{k+1}(n+1) - φ_{k+1}(n)`; return the latter over the permitted error.
    #[inline(always)]
    fn write_above(&mut self, b: usize) -> Lanes<S> {
        let before = self.rows.get(self.order, b);
        let above = self.write(b) - before;
        self.rows.set(self.order + 1, b, above);
        above * load(self.rows.simd, &self.inverse_weight[b])
    }
}

/// Weighted sums of squares of the error estimates: `f(p) - φ*_1`, and the same plus φ*_k and φ*_{k-1} for the lower orders.
pub(super) struct Errors<'a> {
    /// φ*_1, φ*_k and φ*_{k-1}.
    pub(super) rows: [&'a [f64]; 3],
    pub(super) inverse_weight: &'a [f64],
    pub(super) vectors: &'a mut Vectors,
    /// h g_{k+1}: write the corrected value `y = p + h g_{k+1} (f(p) - φ*_1)` in the same pass.
    pub(super) correction: Option<f64>,
}

impl BlockKernel for Errors<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn length(&self) -> usize {
        self.vectors.dimension
    }

    #[inline(always)]
    fn with_blocks<S: Simd>(self, simd: S, blocks: usize) -> [f64; 3] {
        let all = self.vectors;
        let mut changes = Changes::<S> {
            simd,
            derivative: vectors::<S>(&all.derivative, blocks),
            rows: self.rows.map(|row| vectors::<S>(row, blocks)),
            inverse_weight: vectors::<S>(self.inverse_weight, blocks),
            correction: self.correction.map(|weight| Correction {
                weight: Lanes::splat(simd, weight),
                predicted: vectors::<S>(&all.predicted, blocks),
                corrected: vectors_mut::<S>(&mut all.trial, blocks),
            }),
        };
        if blocks == 1 {
            // One vector: no loop.
            let [at, one, two] = changes.weighted(0);
            return [
                Squares::of_one(at),
                Squares::of_one(one),
                Squares::of_one(two),
            ];
        }
        let (mut at, mut one, mut two) =
            (Squares::new(simd), Squares::new(simd), Squares::new(simd));
        each_block!(S, blocks, |part, b| {
            let values = changes.weighted(b);
            at.add(part, values[0]);
            one.add(part, values[1]);
            two.add(part, values[2]);
        });
        [at.total(), one.total(), two.total()]
    }
}

/// Operands of [`Errors`].
struct Changes<'a, S: Simd> {
    simd: S,
    derivative: &'a [S::f64s],
    rows: [&'a [S::f64s]; 3],
    inverse_weight: &'a [S::f64s],
    correction: Option<Correction<'a, S>>,
}

/// Corrected value of a step, and what it follows from.
struct Correction<'a, S: Simd> {
    /// h g_{k+1}
    weight: Lanes<S>,
    predicted: &'a [S::f64s],
    corrected: &'a mut [S::f64s],
}

impl<S: Simd> Changes<'_, S> {
    /// Return vector `b` of the changes at the three orders over the permitted error; correct the predicted value.
    #[inline(always)]
    fn weighted(&mut self, b: usize) -> [Lanes<S>; 3] {
        let simd = self.simd;
        let weight = load(simd, &self.inverse_weight[b]);
        let [first, one_below, two_below] = self.rows;
        // f(p) - φ*_1; at lower orders φ*_k and φ*_{k-1} belong to the difference.
        let change = load(simd, &self.derivative[b]) - load(simd, &first[b]);
        // y = p + h g_{k+1} (f(p) - φ*_1).
        if let Some(correction) = &mut self.correction {
            let predicted = load(simd, &correction.predicted[b]);
            correction.corrected[b] = change.mul_add(correction.weight, predicted).values();
        }
        [
            change * weight,
            (load(simd, &one_below[b]) + change) * weight,
            (load(simd, &two_below[b]) + change) * weight,
        ]
    }
}

/// Weighted sum of squares of `values` plus `more`.
pub(super) struct WeightedSquares<'a> {
    pub(super) values: &'a [f64],
    pub(super) more: Option<&'a [f64]>,
    pub(super) inverse_weight: &'a [f64],
}

impl WithSimd for WeightedSquares<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let n = self.values.len();
        let values = SliceLanes::<S>::new(simd, self.values, n);
        let more = self.more.map(|more| SliceLanes::<S>::new(simd, more, n));
        let inverse_weight = SliceLanes::<S>::new(simd, self.inverse_weight, n);
        let mut sum = Squares::new(simd);
        each_vector!(S, n, |part, at| {
            let own = values.get(at);
            let value = more.as_ref().map_or(own, |more| own + more.get(at));
            sum.add(part, value * inverse_weight.get(at));
        });
        sum.total()
    }
}

/// Write the weights 1/(atol + rtol |y|).
pub(super) struct Weigh<'a> {
    pub(super) control: &'a StepControl,
    pub(super) y: &'a [f64],
    pub(super) inverse_weight: &'a mut [f64],
}

impl WithSimd for Weigh<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.inverse_weight.len();
        let rtol = Lanes::splat(simd, self.control.rtol);
        let atol = Lanes::splat(simd, self.control.atol);
        let y = SliceLanes::<S>::new(simd, self.y, n);
        let mut inverse_weight = SliceLanesMut::<S>::new(simd, self.inverse_weight, n);
        each_vector!(S, n, |at| {
            inverse_weight.set(at, rtol.constant(1.0) / y.get(at).abs().mul_add(rtol, atol));
        });
    }
}

/// Weighted sums of squares of the changes of the derivative and of the solution between the two evaluations of a step.
pub(super) struct DerivativeChange<'a> {
    pub(super) derivative: &'a [f64],
    pub(super) at_prediction: &'a [f64],
    /// Points of evaluation: predicted value and solution.
    pub(super) ends: (&'a [f64], &'a [f64]),
    pub(super) inverse_weight: &'a [f64],
}

impl WithSimd for DerivativeChange<'_> {
    type Output = [f64; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; 2] {
        let n = self.derivative.len();
        let derivative = SliceLanes::<S>::new(simd, self.derivative, n);
        let at_prediction = SliceLanes::<S>::new(simd, self.at_prediction, n);
        let prediction = SliceLanes::<S>::new(simd, self.ends.0, n);
        let solution = SliceLanes::<S>::new(simd, self.ends.1, n);
        let inverse_weight = SliceLanes::<S>::new(simd, self.inverse_weight, n);
        let (mut slopes, mut steps) = (Squares::new(simd), Squares::new(simd));
        each_vector!(S, n, |part, at| {
            let weight = inverse_weight.get(at);
            slopes.add(part, (derivative.get(at) - at_prediction.get(at)) * weight);
            steps.add(part, (solution.get(at) - prediction.get(at)) * weight);
        });
        [slopes.total(), steps.total()]
    }
}

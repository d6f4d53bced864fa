//! Cubic Hermite interpolant over a step, for one number or a SIMD vector.

// A function that is not inlined into a kernel is compiled without its instruction set.
#![allow(clippy::inline_always)]

use super::Real;

/// Weights of the interpolant at one time inside a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hermite<R> {
    start: R,
    start_slope: R,
    end_slope: R,
}

impl<R: Real> Hermite<R> {
    /// Return the weights at a `part` of a step of `length` \[s\].
    #[inline(always)]
    pub(crate) fn new(context: R::Context, part: f64, length: f64) -> Self {
        let rest = 1.0 - part;
        Self {
            start: R::splat(context, (1.0 + 2.0 * part) * rest * rest),
            start_slope: R::splat(context, length * part * rest * rest),
            end_slope: R::splat(context, -length * part * part * rest),
        }
    }

    /// Return the interpolant of values and slopes at both ends of the step.
    #[inline(always)]
    pub(crate) fn at(&self, [start, start_slope]: [R; 2], [end, end_slope]: [R; 2]) -> R {
        let bend = start_slope.mul_add(self.start_slope, end_slope * self.end_slope);
        self.start.mul_add(start - end, end) + bend
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_its_own_interpolant() {
        let value = |t: f64| ((0.7 * t - 2.0) * t + 0.3) * t + 5.0;
        let slope = |t: f64| (2.1 * t - 4.0) * t + 0.3;
        let length = 1.6;
        for part in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let t = part * length;
            let ends = [0.0, length].map(|t| [value(t), slope(t)]);
            let found = Hermite::<f64>::new((), part, length).at(ends[0], ends[1]);
            assert!((found - value(t)).abs() < 1e-14, "{part}: {found}");
        }
    }
}

//! Double-double numbers, sums of two `f64`: normal equations in this precision are as accurate as orthogonal factors.

/// Number type of an elimination: `f64` or double-double.
pub(crate) trait Number: Copy + Default + std::fmt::Debug {
    /// Return Σ a w b.
    fn meet(a: &[f64; 3], w: &[f64], b: &[f64; 3]) -> Self;
    /// Return self + other.
    fn plus(self, other: Self) -> Self;
    /// Return self - a b.
    fn less(self, a: Self, b: Self) -> Self;
    /// Return the product.
    fn times(self, other: Self) -> Self;
    /// Return the reciprocal.
    fn inverse(self) -> Self;
    /// Return the value rounded to `f64`.
    fn rounded(self) -> f64;
}

impl Number for f64 {
    #[inline]
    fn meet(a: &[f64; 3], w: &[f64], b: &[f64; 3]) -> Self {
        if let [x, y, turning] = *w {
            a[0] * x * b[0] + a[1] * y * b[1] + a[2] * turning * b[2]
        } else {
            0.0
        }
    }

    #[inline]
    fn plus(self, other: Self) -> Self {
        self + other
    }

    #[inline]
    fn less(self, a: Self, b: Self) -> Self {
        self - a * b
    }

    #[inline]
    fn times(self, other: Self) -> Self {
        self * other
    }

    #[inline]
    fn inverse(self) -> Self {
        1.0 / self
    }

    #[inline]
    fn rounded(self) -> f64 {
        self
    }
}

/// Double-double number: a rounded value and its rounding error.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Twice(f64, f64);

impl Twice {
    /// Return a + b without rounding error (Knuth 1969).
    fn sum(a: f64, b: f64) -> Self {
        let sum = a + b;
        let part = sum - a;
        Self(sum, (a - (sum - part)) + (b - part))
    }

    /// Return a b without rounding error.
    fn product(a: f64, b: f64) -> Self {
        let product = a * b;
        Self(product, a.mul_add(b, -product))
    }
}

impl From<f64> for Twice {
    fn from(value: f64) -> Self {
        Self(value, 0.0)
    }
}

impl Number for Twice {
    fn meet(a: &[f64; 3], w: &[f64], b: &[f64; 3]) -> Self {
        let terms = a.iter().zip(w).zip(b);
        terms.fold(Self::default(), |sum, ((a, w), b)| {
            sum.plus(Self::product(*a, *w).times((*b).into()))
        })
    }

    fn plus(self, other: Self) -> Self {
        // Both parts are added without rounding error, then renormalised twice.
        let Self(sum, left) = Self::sum(self.0, other.0);
        let Self(rest, least) = Self::sum(self.1, other.1);
        let Self(sum, left) = Self::sum(sum, left + rest);
        Self::sum(sum, left + least)
    }

    fn less(self, a: Self, b: Self) -> Self {
        let Self(product, left) = a.times(b);
        self.plus(Self(-product, -left))
    }

    fn times(self, other: Self) -> Self {
        let Self(product, left) = Self::product(self.0, other.0);
        // The product of the low parts is below the precision.
        Self::sum(product, left + (self.0 * other.1 + self.1 * other.0))
    }

    fn inverse(self) -> Self {
        let first = Self::from(1.0 / self.0);
        // One step of Newton's method doubles the number of digits.
        let missed = Self::from(1.0).less(self, first);
        first.plus(first.times(missed))
    }

    fn rounded(self) -> f64 {
        self.0 + self.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_times_three_misses_one_by_the_square_of_rounding() {
        let third = Twice::from(3.0).inverse();
        let missed = Twice::from(1.0).less(third, 3.0.into()).rounded().abs();
        assert!(missed < 1e-31, "{missed:e}");
        let tiny = 1e-25;
        let sum = Twice::from(1.0)
            .plus(tiny.into())
            .less(1.0.into(), 1.0.into());
        assert!((sum.rounded() / tiny - 1.0).abs() < 1e-6);
        let [a, b] = [[1.0, 1e-9, 0.0], [1e-9, -1.0, 3.0]];
        assert_eq!(Twice::meet(&a, &[1.0, 1.0, 1.0], &b).rounded(), 0.0);
    }
}

//! Numbers given by rows (argument, value): straight lines between them, or a cubic spline where two derivatives are needed.

use crate::error::{Error, Result, check};

/// Piecewise linear; held constant before the first and after the last row.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    arguments: Vec<f64>,
    values: Vec<f64>,
    /// Integral from the first row to each row.
    sums: Vec<f64>,
}

impl Curve {
    /// Rows of (argument, value); `field` names them in errors.
    ///
    /// # Errors
    /// When there is no row, a number is not finite or arguments do not increase.
    pub fn new(field: &str, rows: &[(f64, f64)]) -> Result<Self> {
        check_rows(field, rows, 1)?;
        let mut sums = vec![0.0];
        for pair in rows.windows(2) {
            let area = 0.5 * (pair[1].0 - pair[0].0) * (pair[0].1 + pair[1].1);
            sums.push(sums[sums.len() - 1] + area);
        }
        Ok(Self {
            arguments: rows.iter().map(|row| row.0).collect(),
            values: rows.iter().map(|row| row.1).collect(),
            sums,
        })
    }

    /// Its rows.
    #[must_use]
    pub fn rows(&self) -> Vec<(f64, f64)> {
        let arguments = self.arguments.iter().copied();
        arguments.zip(self.values.iter().copied()).collect()
    }

    /// Arguments of the rows.
    pub(crate) fn arguments(&self) -> &[f64] {
        &self.arguments
    }

    /// Value at `x`.
    #[must_use]
    pub fn value(&self, x: f64) -> f64 {
        match row_before(&self.arguments, x) {
            None => self.values[0],
            Some(i) => self.values[i] + self.slope_after(i) * (x - self.arguments[i]),
        }
    }

    /// Slope at `x`, from the right.
    #[must_use]
    pub fn slope(&self, x: f64) -> f64 {
        row_before(&self.arguments, x).map_or(0.0, |i| self.slope_after(i))
    }

    /// Integral from zero to `x`.
    #[must_use]
    pub fn integral(&self, x: f64) -> f64 {
        self.sum(x) - self.sum(0.0)
    }

    fn slope_after(&self, i: usize) -> f64 {
        match (self.arguments.get(i + 1), self.values.get(i + 1)) {
            (Some(x), Some(value)) => (value - self.values[i]) / (x - self.arguments[i]),
            _ => 0.0,
        }
    }

    fn sum(&self, x: f64) -> f64 {
        match row_before(&self.arguments, x) {
            None => self.values[0] * (x - self.arguments[0]),
            Some(i) => {
                let distance = x - self.arguments[i];
                self.sums[i] + distance * (self.values[i] + 0.5 * self.slope_after(i) * distance)
            }
        }
    }
}

/// A cubic spline with free ends: two continuous derivatives; beyond its ends it goes on along its tangent.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    arguments: Vec<f64>,
    values: Vec<f64>,
    /// Second derivative at each row.
    bends: Vec<f64>,
}

impl Spline {
    /// Rows of (argument, value); `field` names them in errors.
    ///
    /// # Errors
    /// When there are fewer than two rows, a number is not finite or arguments do not increase.
    pub fn new(field: &str, rows: &[(f64, f64)]) -> Result<Self> {
        check_rows(field, rows, 2)?;
        let arguments: Vec<f64> = rows.iter().map(|row| row.0).collect();
        let values: Vec<f64> = rows.iter().map(|row| row.1).collect();
        let bends = bends(&arguments, &values);
        Ok(Self {
            arguments,
            values,
            bends,
        })
    }

    /// Arguments of the rows.
    pub(crate) fn arguments(&self) -> &[f64] {
        &self.arguments
    }

    /// Value and first two derivatives at `x`.
    #[must_use]
    pub fn derivatives(&self, x: f64) -> [f64; 3] {
        let last = self.arguments.len() - 1;
        let (low, high) = (self.arguments[0], self.arguments[last]);
        if x < low || x > high {
            let end = x.clamp(low, high);
            let [value, slope, _] = self.derivatives(end);
            return [value + slope * (x - end), slope, 0.0];
        }
        let i = row_before(&self.arguments, x).unwrap_or(0).min(last - 1);
        let h = self.arguments[i + 1] - self.arguments[i];
        let (a, b) = ((self.arguments[i + 1] - x) / h, (x - self.arguments[i]) / h);
        let (m, n) = (self.bends[i], self.bends[i + 1]);
        let value = a * self.values[i]
            + b * self.values[i + 1]
            + ((a * a * a - a) * m + (b * b * b - b) * n) * h * h / 6.0;
        let slope = (self.values[i + 1] - self.values[i]) / h
            + ((1.0 - 3.0 * a * a) * m + (3.0 * b * b - 1.0) * n) * h / 6.0;
        [value, slope, a * m + b * n]
    }
}

/// Second derivatives at the rows, zero at both ends: the tridiagonal system by elimination.
fn bends(x: &[f64], y: &[f64]) -> Vec<f64> {
    let count = x.len();
    let mut bends = vec![0.0; count];
    let mut upper = vec![0.0; count];
    for i in 1..count - 1 {
        let (left, right) = (x[i] - x[i - 1], x[i + 1] - x[i]);
        let jump = (y[i + 1] - y[i]) / right - (y[i] - y[i - 1]) / left;
        let pivot = 2.0 * (left + right) - left * upper[i - 1];
        upper[i] = right / pivot;
        bends[i] = (6.0 * jump - left * bends[i - 1]) / pivot;
    }
    for i in (1..count.saturating_sub(1)).rev() {
        bends[i] -= upper[i] * bends[i + 1];
    }
    bends
}

fn row_before(arguments: &[f64], x: f64) -> Option<usize> {
    arguments.partition_point(|&a| a <= x).checked_sub(1)
}

fn check_rows(field: &str, rows: &[(f64, f64)], fewest: usize) -> Result<()> {
    if rows.len() < fewest {
        return Err(Error::invalid(
            field,
            format!("{} rows", rows.len()),
            format!("needs at least {fewest} row(s) (argument, value)"),
        ));
    }
    for &(argument, value) in rows {
        check::finite(field, argument, "the unit of its argument")?;
        check::finite(field, value, "the unit of its value")?;
    }
    match rows.windows(2).find(|pair| pair[1].0 <= pair[0].0) {
        None => Ok(()),
        Some(pair) => Err(Error::invalid(
            field,
            format!("{} after {}", pair[1].0, pair[0].0),
            "arguments must increase from row to row",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_integrates_to_its_parabola_and_holds_its_ends() {
        let curve = Curve::new("force", &[(-1.0, -3.0), (1.0, 1.0), (2.0, 1.0)]).unwrap();
        assert_eq!(curve.value(-5.0), -3.0);
        assert_eq!(curve.value(0.0), -1.0);
        assert_eq!(curve.slope(0.5), 2.0);
        assert!((curve.integral(1.0) - 0.0).abs() < 1e-15);
        assert!((curve.integral(-1.0) - 2.0).abs() < 1e-15);
        assert!((curve.integral(4.0) - 3.0).abs() < 1e-15);
    }

    #[test]
    fn a_spline_meets_its_rows_and_its_derivatives_are_those_of_its_value() {
        let rows = [(0.0, 1.0), (0.4, -2.0), (1.0, 0.5), (1.1, 0.7)];
        let spline = Spline::new("angle", &rows).unwrap();
        for (x, y) in rows {
            assert!((spline.derivatives(x)[0] - y).abs() < 1e-14);
        }
        for x in [-0.3, 0.2, 0.7, 1.05, 1.4] {
            let h = 1e-6;
            let [_, slope, bend] = spline.derivatives(x);
            let (up, down) = (spline.derivatives(x + h), spline.derivatives(x - h));
            assert!(((up[0] - down[0]) / (2.0 * h) - slope).abs() < 1e-7);
            assert!(((up[1] - down[1]) / (2.0 * h) - bend).abs() < 1e-6);
        }
    }

    #[test]
    fn rows_that_do_not_increase_are_refused() {
        let error = Curve::new("torque", &[(1.0, 0.0), (1.0, 4.0)]).unwrap_err();
        assert!(error.to_string().contains("must increase"));
        assert!(Spline::new("angle", &[(0.0, 1.0)]).is_err());
    }
}

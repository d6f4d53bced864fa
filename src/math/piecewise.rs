//! Functions given by rows (argument, value): linear interpolation, or a cubic spline where two derivatives are needed.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, check};

/// Piecewise linear function; constant before the first row and after the last one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Table {
    arguments: Vec<f64>,
    values: Vec<f64>,
    /// Integral from the first row to each row.
    sums: Vec<f64>,
}

impl Table {
    /// Return a table from rows of (time \[s\], value); `field` is its name in errors.
    ///
    /// # Errors
    /// If there is no row, a number is not finite or times do not increase.
    pub fn new(field: &str, unit: &str, rows: &[(f64, f64)]) -> Result<Self> {
        Self::against(field, TIME, unit, rows)
    }

    /// Return a table from rows of (argument, value); `axis` is the name of the argument and its unit.
    ///
    /// # Errors
    /// If there is no row, a number is not finite or arguments do not increase.
    pub fn against(
        field: &str,
        axis: (&str, &str),
        unit: &str,
        rows: &[(f64, f64)],
    ) -> Result<Self> {
        check_rows(field, axis, unit, rows, 1)?;
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

    /// Return the rows.
    #[must_use]
    pub fn rows(&self) -> Vec<(f64, f64)> {
        let arguments = self.arguments.iter().copied();
        arguments.zip(self.values.iter().copied()).collect()
    }

    /// Return the arguments of the rows.
    pub(crate) fn arguments(&self) -> &[f64] {
        &self.arguments
    }

    /// Return the smallest and the largest value.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        range_of(self.values.iter().copied())
    }

    /// Return the largest absolute value.
    pub(crate) fn largest(&self) -> f64 {
        largest(&self.values)
    }

    /// Return the largest absolute argument.
    pub(crate) fn farthest(&self) -> f64 {
        largest(&self.arguments)
    }

    /// Return the value at `x`.
    #[must_use]
    pub fn value(&self, x: f64) -> f64 {
        match row_before(&self.arguments, x) {
            None => self.values[0],
            Some(i) => self.values[i] + self.slope_after(i) * (x - self.arguments[i]),
        }
    }

    /// Return the slope at `x`, from the right.
    #[must_use]
    pub fn slope(&self, x: f64) -> f64 {
        row_before(&self.arguments, x).map_or(0.0, |i| self.slope_after(i))
    }

    /// Return the integral from zero to `x`.
    #[must_use]
    pub fn integral(&self, x: f64) -> f64 {
        if let [value] = self.values[..] {
            return value * x;
        }
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

/// Natural cubic spline with two continuous derivatives; linear beyond its ends, along its tangents.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Spline {
    arguments: Vec<f64>,
    values: Vec<f64>,
    /// Second derivative at each row.
    bends: Vec<f64>,
    /// Integral from the first row to each row.
    sums: Vec<f64>,
}

impl Spline {
    /// Return a spline from rows of (time \[s\], value); `field` is its name in errors.
    ///
    /// # Errors
    /// If there are fewer than two rows, a number is not finite or times do not increase.
    pub fn new(field: &str, unit: &str, rows: &[(f64, f64)]) -> Result<Self> {
        check_rows(field, TIME, unit, rows, 2)?;
        let arguments: Vec<f64> = rows.iter().map(|row| row.0).collect();
        let values: Vec<f64> = rows.iter().map(|row| row.1).collect();
        let bends = bends(&arguments, &values);
        let mut spline = Self {
            arguments,
            values,
            bends,
            sums: vec![0.0],
        };
        for i in 0..rows.len() - 1 {
            let length = spline.arguments[i + 1] - spline.arguments[i];
            spline.sums.push(spline.sums[i] + spline.area(i, length));
        }
        Ok(spline)
    }

    /// Return the rows.
    #[must_use]
    pub fn rows(&self) -> Vec<(f64, f64)> {
        let arguments = self.arguments.iter().copied();
        arguments.zip(self.values.iter().copied()).collect()
    }

    /// Return the arguments of the rows.
    pub(crate) fn arguments(&self) -> &[f64] {
        &self.arguments
    }

    /// Return the value and the first two derivatives at `x`.
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

    /// Return the integral from zero to `x`.
    #[must_use]
    pub fn integral(&self, x: f64) -> f64 {
        self.sum(x) - self.sum(0.0)
    }

    /// Return the smallest and the largest value between the ends.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        let extrema = (0..self.values.len() - 1).flat_map(|i| {
            let [_, c1, c2, c3] = self.cubic(i);
            let length = self.arguments[i + 1] - self.arguments[i];
            // Roots of c1 + 2 c2 s + 3 c3 s² = 0 without cancellation; q is NaN if there is none.
            let q = -(c2 + c2.signum() * (c2 * c2 - 3.0 * c1 * c3).sqrt());
            let inside = [q / (3.0 * c3), c1 / q]
                .into_iter()
                .filter(move |s| (0.0..length).contains(s));
            inside.map(move |s| self.derivatives(self.arguments[i] + s)[0])
        });
        range_of(self.values.iter().copied().chain(extrema))
    }

    /// Return the coefficients of the cubic after row `i`, in powers of the distance from it.
    fn cubic(&self, i: usize) -> [f64; 4] {
        let length = self.arguments[i + 1] - self.arguments[i];
        let (m, n) = (self.bends[i], self.bends[i + 1]);
        let secant = (self.values[i + 1] - self.values[i]) / length;
        [
            self.values[i],
            secant - length * (2.0 * m + n) / 6.0,
            0.5 * m,
            (n - m) / (6.0 * length),
        ]
    }

    /// Return the integral from row `i` over the distance `s`.
    fn area(&self, i: usize, s: f64) -> f64 {
        let [c0, c1, c2, c3] = self.cubic(i);
        s * (c0 + s * (c1 / 2.0 + s * (c2 / 3.0 + s * c3 / 4.0)))
    }

    /// Return the integral from the first row to `x`.
    fn sum(&self, x: f64) -> f64 {
        let last = self.arguments.len() - 1;
        let end = x.clamp(self.arguments[0], self.arguments[last]);
        let i = row_before(&self.arguments, end).unwrap_or(0).min(last - 1);
        let [value, slope, _] = self.derivatives(end);
        let beyond = x - end;
        self.sums[i]
            + self.area(i, end - self.arguments[i])
            + beyond * (value + 0.5 * slope * beyond)
    }
}

fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |most, x| most.max(x.abs()))
}

/// Return the smallest and the largest of some values.
fn range_of(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let infinite = [f64::INFINITY, f64::NEG_INFINITY];
    values.fold(infinite, |[least, most], value| {
        [least.min(value), most.max(value)]
    })
}

/// Return the second derivatives at the rows, zero at both ends, by elimination of the tridiagonal system.
fn bends(x: &[f64], y: &[f64]) -> Vec<f64> {
    let count = x.len();
    let mut bends = vec![0.0; count];
    let mut upper = vec![0.0; count];
    // Continuity of the slope: h₁ m₋ + 2 (h₁ + h₂) m + h₂ m₊ = 6 (change of the secants' slope).
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

/// Name and unit of the argument of a function of time.
const TIME: (&str, &str) = ("time", "s");

/// Least distance of two rows in time, over the time: four times the rounding that the end of a step may have (`signal.rs`).
///
/// Inputs are read on one side of a row that is at the end of a step. Nearer rows would be one, and the jump between them lost. Doubled:
/// rows that are 2e-14 of the time apart are refused, too.
const LEAST_DISTANCE: f64 = 64.0 * f64::EPSILON;

fn check_rows(
    field: &str,
    (axis, axis_unit): (&str, &str),
    unit: &str,
    rows: &[(f64, f64)],
    fewest: usize,
) -> Result<()> {
    if rows.len() < fewest {
        let given = match rows.len() {
            0 => "()".to_string(),
            count => format!("{count} row"),
        };
        let needed = ["one row", "two rows"][fewest - 1];
        let expected = format!("needs at least {needed} ({axis}, value)");
        return Err(Error::invalid(field, given, expected));
    }
    for &(argument, value) in rows {
        check::finite(&format!("{field} ({axis})"), argument, axis_unit)?;
        check::finite(&format!("{field} (value)"), value, unit)?;
    }
    let refused = |pair: &[(f64, f64)], expected: String| {
        let [before, after] = [pair[0].0, pair[1].0].map(|x| format!("{x} {axis_unit}"));
        let given = format!("{} after {}", after.trim_end(), before.trim_end());
        Err(Error::invalid(field, given, expected))
    };
    let least = |pair: &[(f64, f64)]| LEAST_DISTANCE * pair[0].0.abs().max(pair[1].0.abs());
    if let Some(pair) = rows.windows(2).find(|pair| pair[1].0 <= pair[0].0) {
        return refused(pair, format!("{axis}s must increase from row to row"));
    }
    let near = |pair: &&[(f64, f64)]| pair[1].0 - pair[0].0 < least(pair);
    if axis == TIME.0
        && let Some(pair) = rows.windows(2).find(near)
    {
        let expected = format!(
            "are one time to rounding: a jump needs rows that are {:.0e} {axis_unit} or more apart",
            2.0 * least(pair)
        );
        return refused(pair, expected);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_integrates_to_its_parabola_and_holds_its_ends() {
        let table = Table::new("force", "N", &[(-1.0, -3.0), (1.0, 1.0), (2.0, 1.0)]).unwrap();
        assert_eq!(table.value(-5.0), -3.0);
        assert_eq!(table.value(0.0), -1.0);
        assert_eq!(table.slope(0.5), 2.0);
        assert!((table.integral(1.0) - 0.0).abs() < 1e-15);
        assert!((table.integral(-1.0) - 2.0).abs() < 1e-15);
        assert!((table.integral(4.0) - 3.0).abs() < 1e-15);
        let table = Table::new("speed", "rad/s", &[(0.5, 3.0)]).unwrap();
        assert_eq!((table.value(9.0), table.slope(9.0)), (3.0, 0.0));
        assert_eq!(table.integral(0.3), 3.0 * 0.3);
    }

    #[test]
    fn a_spline_meets_its_rows_and_its_derivatives_are_those_of_its_value() {
        let rows = [(0.0, 1.0), (0.4, -2.0), (1.0, 0.5), (1.1, 0.7)];
        let spline = Spline::new("angle", "rad", &rows).unwrap();
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

    /// Simpson's rule is exact for a cubic.
    fn simpson(spline: &Spline, from: f64, to: f64) -> f64 {
        let value = |x: f64| spline.derivatives(x)[0];
        (to - from) / 6.0 * (value(from) + 4.0 * value(0.5 * (from + to)) + value(to))
    }

    #[test]
    fn a_spline_integrates_exactly_between_its_rows_and_along_its_tangents() {
        let rows = [(-0.2, 1.0), (0.4, -2.0), (1.0, 0.5), (1.1, 0.7)];
        let spline = Spline::new("speed", "rad/s", &rows).unwrap();
        let cuts = [-0.7, -0.2, 0.0, 0.4, 0.9, 1.0, 1.1, 2.0];
        let mut expected = -(simpson(&spline, -0.7, -0.2) + simpson(&spline, -0.2, 0.0));
        for pair in cuts.windows(2) {
            assert!(
                (spline.integral(pair[0]) - expected).abs() < 1e-15,
                "{pair:?}"
            );
            expected += simpson(&spline, pair[0], pair[1]);
        }
        assert!((spline.integral(2.0) - expected).abs() < 4e-15);
    }

    #[test]
    fn the_range_of_a_spline_has_its_overshoots_in_it() {
        let rows = [(0.0, 1.0), (0.4, -2.0), (1.0, 0.5), (1.1, 0.7), (1.5, 0.7)];
        let spline = Spline::new("speed", "rad/s", &rows).unwrap();
        let [least, most] = spline.range();
        let dense = (0..=150_000).map(|k| spline.derivatives(f64::from(k) * 1e-5)[0]);
        let [low, high] = range_of(dense);
        assert!(least <= low && low - least < 1e-8, "{least} {low}");
        assert!(most >= high && most - high < 1e-8, "{most} {high}");
        assert!(least < -2.0 && most < 1.01);
        let level = Spline::new("speed", "rad/s", &[(0.0, 0.0), (1.0, 0.0)]).unwrap();
        assert_eq!(level.range(), [0.0, 0.0]);
    }

    #[test]
    fn rows_that_do_not_increase_are_refused() {
        let error = Table::new("torque", "N m", &[(1.0, 0.0), (1.0, 4.0)]).unwrap_err();
        assert!(error.to_string().contains("must increase"));
        let error = Spline::new("angle", "rad", &[(0.0, 1.0)]).unwrap_err();
        assert!(error.to_string().contains("at least two rows"));
    }
}

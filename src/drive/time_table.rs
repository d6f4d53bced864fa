//! A constant or piecewise linear function of time or of speed.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, check};

/// Values over time or speed; constant before the first and after the last row.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TimeTable {
    times: Vec<f64>,
    values: Vec<f64>,
    /// Integral from the first row to each row.
    sums: Vec<f64>,
}

impl From<f64> for TimeTable {
    fn from(value: f64) -> Self {
        Self {
            times: vec![0.0],
            values: vec![value],
            sums: vec![0.0],
        }
    }
}

impl TimeTable {
    /// Return a table of rows (time \[s\], value); `field` is its name in errors.
    ///
    /// # Errors
    /// When there is no row, a number is not finite or times do not increase.
    pub fn new(field: &str, unit: &str, rows: &[(f64, f64)]) -> Result<Self> {
        Self::against(field, ("time", "s"), unit, rows)
    }

    /// Return a table of rows (`axis`, value); `axis` includes the unit.
    ///
    /// # Errors
    /// When there is no row, a number is not finite or the axis does not increase.
    pub fn against(
        field: &str,
        (axis, axis_unit): (&str, &str),
        unit: &str,
        rows: &[(f64, f64)],
    ) -> Result<Self> {
        if rows.is_empty() {
            return Err(Error::invalid(
                field,
                "()",
                format!("needs at least one row ({axis}, value)"),
            ));
        }
        for &(time, value) in rows {
            check::finite(&format!("{field} ({axis})"), time, axis_unit)?;
            check::finite(&format!("{field} (value)"), value, unit)?;
        }
        if let Some(pair) = rows.windows(2).find(|pair| pair[1].0 <= pair[0].0) {
            return Err(Error::invalid(
                field,
                format!("{} {axis_unit} after {} {axis_unit}", pair[1].0, pair[0].0),
                format!("{axis}s must increase from row to row"),
            ));
        }
        let mut sums = vec![0.0];
        for pair in rows.windows(2) {
            let area = 0.5 * (pair[1].0 - pair[0].0) * (pair[0].1 + pair[1].1);
            sums.push(sums[sums.len() - 1] + area);
        }
        Ok(Self {
            times: rows.iter().map(|r| r.0).collect(),
            values: rows.iter().map(|r| r.1).collect(),
            sums,
        })
    }

    /// Return the index of the row at or before `t`, if any.
    fn row(&self, t: f64) -> Option<usize> {
        self.times.partition_point(|&time| time <= t).checked_sub(1)
    }

    /// Its rows.
    pub(crate) fn rows(&self) -> Vec<(f64, f64)> {
        let rows = self.times.iter().copied();
        rows.zip(self.values.iter().copied()).collect()
    }

    /// Return the values of all rows.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    /// Return the largest absolute value.
    pub(super) fn largest(&self) -> f64 {
        self.values
            .iter()
            .fold(0.0, |most, value| most.max(value.abs()))
    }

    /// Return the largest absolute argument.
    pub(super) fn farthest(&self) -> f64 {
        self.times
            .iter()
            .fold(0.0, |most, time| most.max(time.abs()))
    }

    /// Return the value at time `t` \[s\].
    #[must_use]
    pub fn value(&self, t: f64) -> f64 {
        match self.row(t) {
            None => self.values[0],
            Some(i) => self.values[i] + self.slope_after(i) * (t - self.times[i]),
        }
    }

    /// Return the time of the first row after `t` \[s\]; infinite for none.
    #[must_use]
    pub fn next_row(&self, t: f64) -> f64 {
        let next = self.times.partition_point(|&time| time <= t);
        self.times.get(next).copied().unwrap_or(f64::INFINITY)
    }

    /// Return the derivative at `t` from the right.
    #[must_use]
    pub fn slope(&self, t: f64) -> f64 {
        self.row(t).map_or(0.0, |i| self.slope_after(i))
    }

    fn slope_after(&self, row: usize) -> f64 {
        match (self.times.get(row + 1), self.values.get(row + 1)) {
            (Some(time), Some(value)) => (value - self.values[row]) / (time - self.times[row]),
            _ => 0.0,
        }
    }

    fn sum(&self, t: f64) -> f64 {
        match self.row(t) {
            None => self.values[0] * (t - self.times[0]),
            Some(i) => {
                let dt = t - self.times[i];
                self.sums[i] + dt * (self.values[i] + 0.5 * self.slope_after(i) * dt)
            }
        }
    }

    /// Return the integral from time zero to `t`.
    #[must_use]
    pub fn integral(&self, t: f64) -> f64 {
        if self.times.len() == 1 {
            return self.values[0] * t;
        }
        self.sum(t) - self.sum(0.0)
    }

    /// Return whether every value is zero.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        self.values.iter().all(|&v| v == 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_integrates_to_its_parabola_and_holds_its_ends() {
        let table = TimeTable::new("w", "rad/s", &[(0.5, 0.0), (1.5, 4.0), (2.0, 2.0)]).unwrap();
        assert_eq!(table.value(0.0), 0.0);
        assert_eq!(table.value(1.0), 2.0);
        assert_eq!(table.value(9.0), 2.0);
        assert_eq!(table.slope(1.75), -4.0);
        assert!((table.integral(1.0) - 0.5).abs() < 1e-15);
        assert!((table.integral(3.0) - (2.0 + 1.5 + 2.0)).abs() < 1e-14);
    }

    #[test]
    fn the_next_row_is_the_first_one_after_a_time() {
        let table = TimeTable::new("w", "rad/s", &[(0.5, 0.0), (1.5, 4.0)]).unwrap();
        assert_eq!(table.next_row(0.0), 0.5);
        assert_eq!(table.next_row(0.5), 1.5);
        assert_eq!(table.next_row(1.5), f64::INFINITY);
        assert_eq!(TimeTable::from(3.0).next_row(0.0), f64::INFINITY);
    }

    #[test]
    fn times_that_do_not_increase_are_refused() {
        let error = TimeTable::new("w", "rad/s", &[(1.0, 0.0), (1.0, 4.0)]).unwrap_err();
        assert!(error.to_string().contains("must increase"));
    }
}

//! Functions of time: prescribed speeds and positions, applied torques and forces.

use serde::{Deserialize, Serialize};

use super::piecewise::{Spline, Table};
use crate::error::{Error, Result, check};

/// Function of time with its derivatives and its integral.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Signal {
    /// Constant value.
    Constant(f64),
    /// Transition between two values with two continuous derivatives: s³ (10 - 15 s + 6 s²).
    SmoothStep {
        /// Start of the transition \[s\].
        start: f64,
        /// End of the transition \[s\].
        end: f64,
        /// Value before the transition.
        from: f64,
        /// Value after the transition.
        to: f64,
    },
    /// Linear interpolation between rows; a ramp has two rows.
    Table(Table),
    /// Cubic spline through rows.
    Spline(Spline),
    /// offset + Σ amplitude · sin(frequency · t + phase).
    Sines {
        /// Mean value.
        offset: f64,
        /// (amplitude, angular frequency \[rad/s\], phase \[rad\]).
        terms: Vec<[f64; 3]>,
    },
}

/// Longest step inside a smooth step, as a fraction of its duration.
///
/// The path of a driver is then a polynomial, which long steps integrate exactly: the error estimate does not shorten them. The power of the
/// driver has twice the degree: with steps of an eighth its work had an error of 0.8 %.
const PART_OF_RISE: f64 = 0.03125;
/// Longest step along a sine, as a fraction of its period.
const PART_OF_PERIOD: f64 = 0.25;

/// Difference of two slopes of a table over the larger one below which they are the same but for rounding.
const SAME_SLOPE: f64 = 1e-9;

/// Return the rounding error permitted for a step that ends at `t`.
fn margin(t: f64) -> f64 {
    16.0 * f64::EPSILON * t.abs()
}

impl From<f64> for Signal {
    fn from(value: f64) -> Self {
        Self::Constant(value)
    }
}

impl From<Table> for Signal {
    fn from(table: Table) -> Self {
        Self::Table(table)
    }
}

impl Signal {
    /// Return a signal that increases linearly from zero to `value` within `time` \[s\], and is constant for a time of zero.
    ///
    /// # Errors
    /// If a number is not finite.
    pub(crate) fn growing(value: f64, time: f64) -> Result<Self> {
        if time > 0.0 {
            return Self::ramp(0.0, time, 0.0, value);
        }
        Ok(value.into())
    }

    /// Return a linear transition from one value to another.
    ///
    /// # Errors
    /// If a number is not finite or the end is not after the start.
    pub fn ramp(start: f64, end: f64, from: f64, to: f64) -> Result<Self> {
        Table::new("ramp", "its unit", &[(start, from), (end, to)]).map(Self::Table)
    }

    /// Check every number.
    ///
    /// # Errors
    /// The error has `field`, its value and the permitted range.
    pub fn validate(&self, field: &str) -> Result<()> {
        match self {
            Self::Constant(value) => check::finite(field, *value, "its unit"),
            Self::SmoothStep {
                start,
                end,
                from,
                to,
            } => {
                for value in [start, end, from, to] {
                    check::finite(field, *value, "its unit")?;
                }
                if end > start {
                    return Ok(());
                }
                Err(Error::invalid(
                    format!("{field}.end"),
                    end,
                    format!("must be after its start, {start} s"),
                ))
            }
            Self::Table(_) | Self::Spline(_) => Ok(()),
            Self::Sines { offset, terms } => {
                for value in std::iter::once(offset).chain(terms.iter().flatten()) {
                    check::finite(field, *value, "its unit")?;
                }
                Ok(())
            }
        }
    }

    /// Return the value at `t` \[s\].
    #[must_use]
    pub fn value(&self, t: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Table(table) => table.value(t),
            _ => self.derivatives(t)[0],
        }
    }

    /// Return the value and the first two derivatives at `t` \[s\].
    #[must_use]
    pub fn derivatives(&self, t: f64) -> [f64; 3] {
        match self {
            Self::Constant(value) => [*value, 0.0, 0.0],
            Self::SmoothStep {
                start,
                end,
                from,
                to,
            } => {
                let (span, rise) = (end - start, to - from);
                let s = ((t - start) / span).clamp(0.0, 1.0);
                [
                    from + rise * s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s),
                    rise / span * 30.0 * (s * (1.0 - s)).powi(2),
                    rise / (span * span) * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s),
                ]
            }
            Self::Table(table) => [table.value(t), table.slope(t), 0.0],
            Self::Spline(spline) => spline.derivatives(t),
            Self::Sines { offset, terms } => {
                let mut found = [*offset, 0.0, 0.0];
                for [amplitude, frequency, phase] in terms {
                    let (sin, cos) = (frequency * t + phase).sin_cos();
                    found[0] += amplitude * sin;
                    found[1] += amplitude * frequency * cos;
                    found[2] -= amplitude * frequency * frequency * sin;
                }
                found
            }
        }
    }

    /// Return the derivative at `t` \[s\], from the right.
    #[must_use]
    pub fn slope(&self, t: f64) -> f64 {
        self.derivatives(t)[1]
    }

    /// Return the smallest and the largest value; bounds of them for sines; between the ends for a spline.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        match self {
            Self::Constant(value) => [*value; 2],
            Self::SmoothStep { from, to, .. } => [from.min(*to), from.max(*to)],
            Self::Table(table) => table.range(),
            Self::Spline(spline) => spline.range(),
            Self::Sines { offset, terms } => {
                let most: f64 = terms.iter().map(|term| term[0].abs()).sum();
                [offset - most, offset + most]
            }
        }
    }

    /// Return the largest absolute value, from [`Self::range`].
    #[must_use]
    pub fn largest(&self) -> f64 {
        let [least, most] = self.range();
        least.abs().max(most.abs())
    }

    /// Return whether the function is zero at all times.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        self.range() == [0.0; 2]
    }

    /// Return the first time after `t` \[s\] at which a derivative jumps; infinity if there is none.
    #[must_use]
    pub fn next_knot(&self, t: f64) -> f64 {
        self.first_knot(|knot| knot <= t)
    }

    /// Return the first time, not `passed`, at which a derivative jumps.
    fn first_knot(&self, passed: impl Fn(f64) -> bool) -> f64 {
        let first = |knots: &[f64]| {
            let next = knots.partition_point(|&knot| passed(knot));
            knots.get(next).copied().unwrap_or(f64::INFINITY)
        };
        match self {
            Self::Constant(_) | Self::Sines { .. } => f64::INFINITY,
            Self::SmoothStep { from, to, .. } if from == to => f64::INFINITY,
            Self::SmoothStep { start, end, .. } => first(&[*start, *end]),
            Self::Table(table) => first(table.arguments()),
            Self::Spline(spline) => first(spline.arguments()),
        }
    }

    /// Return the longest step from `t` \[s\] that resolves the function between its knots.
    pub(crate) fn longest_step_between_knots(&self, t: f64) -> f64 {
        match self {
            Self::SmoothStep {
                start,
                end,
                from,
                to,
            } if from != to && t >= start - margin(*start) && t < end - margin(*end) => {
                PART_OF_RISE * (end - start)
            }
            Self::Sines { terms, .. } => {
                let moving = terms.iter().filter(|term| term[0] != 0.0);
                let fastest = moving.fold(0.0, |most: f64, term| most.max(term[1].abs()));
                PART_OF_PERIOD * 2.0 * std::f64::consts::PI / fastest
            }
            _ => f64::INFINITY,
        }
    }

    /// Return the longest step from `t` \[s\] that resolves the function: at most to its next knot, and short relative to the duration of a
    /// transition or a period.
    pub(crate) fn longest_step(&self, t: f64) -> f64 {
        let to_knot = self.knot_after(t) - t;
        to_knot.min(self.longest_step_between_knots(t))
    }

    /// Return the first knot after `t` \[s\]; a knot that differs from `t` by rounding is not after it.
    fn knot_after(&self, t: f64) -> f64 {
        self.first_knot(|knot| knot - margin(knot) <= t)
    }

    /// Return whether the slope of a table jumps at a row after `since` \[s\] that is at `t`, to rounding.
    pub(crate) fn has_corner(&self, t: f64, since: f64) -> bool {
        let Some(knot) = self.row_at(t).filter(|knot| knot - margin(*knot) > since) else {
            return false;
        };
        let slope = |t: f64| self.derivatives(t)[1];
        let [before, behind] = [slope(knot - margin(knot)), slope(knot + margin(knot))];
        (behind - before).abs() > SAME_SLOPE * before.abs().max(behind.abs())
    }

    /// Return `t`, or where a row of a table is at `t`, to rounding, a time on one side of it: before a row after `since` \[s\], else behind.
    pub(crate) fn one_sided(&self, t: f64, since: f64) -> f64 {
        match self.row_at(t) {
            Some(knot) if knot - margin(knot) > since => knot - margin(knot),
            Some(knot) => knot + margin(knot),
            None => t,
        }
    }

    /// Return the time of the row of a table that differs from `t` by rounding, if there is one \[s\].
    fn row_at(&self, t: f64) -> Option<f64> {
        let Self::Table(_) = self else { return None };
        let knot = self.first_knot(|knot| knot + margin(knot) < t);
        (knot.is_finite() && knot - margin(knot) <= t).then_some(knot)
    }

    /// Integral from zero to `t` \[s\].
    #[must_use]
    pub fn integral(&self, t: f64) -> f64 {
        match self {
            Self::Constant(value) => value * t,
            Self::SmoothStep {
                start,
                end,
                from,
                to,
            } => {
                let (span, rise) = (end - start, to - from);
                let risen = |t: f64| {
                    let s = ((t - start) / span).clamp(0.0, 1.0);
                    span * s.powi(4) * (2.5 - 3.0 * s + s * s) + (t - end).max(0.0)
                };
                from * t + rise * (risen(t) - risen(0.0))
            }
            Self::Table(table) => table.integral(t),
            Self::Spline(spline) => spline.integral(t),
            Self::Sines { offset, terms } => {
                let waves = terms.iter().map(|[amplitude, frequency, phase]| {
                    if *frequency == 0.0 {
                        amplitude * phase.sin() * t
                    } else {
                        // cos φ - cos(2 x + φ) = 2 sin x sin(x + φ) avoids the cancellation at small x.
                        let x = 0.5 * frequency * t;
                        2.0 * amplitude / frequency * x.sin() * (x + phase).sin()
                    }
                });
                offset * t + waves.sum::<f64>()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_and_integrals_belong_together() {
        let functions = [
            Signal::Constant(3.0),
            Signal::SmoothStep {
                start: 0.2,
                end: 0.9,
                from: -1.0,
                to: 2.0,
            },
            Signal::ramp(0.1, 2.0, 1.0, 5.0).unwrap(),
            Signal::Sines {
                offset: 0.3,
                terms: vec![[1.0, 2.0, 0.4], [0.5, 0.0, 1.0]],
            },
            Signal::Spline(Spline::new("x", "m", &[(0.0, 1.0), (0.4, 2.0), (0.9, -1.0)]).unwrap()),
        ];
        let h = 1e-5;
        for function in functions {
            for t in [-0.4, 0.3, 0.55, 1.2] {
                let [value, rate, acceleration] = function.derivatives(t);
                let (up, down) = (function.derivatives(t + h), function.derivatives(t - h));
                let integral = function.integral(t + h) - function.integral(t - h);
                assert!(
                    (integral / (2.0 * h) - value).abs() < 1e-8,
                    "{function:?} {t}"
                );
                assert!(((up[0] - down[0]) / (2.0 * h) - rate).abs() < 1e-7);
                assert!(((up[1] - down[1]) / (2.0 * h) - acceleration).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn no_step_passes_over_a_bend_or_over_a_change() {
        let rise = Signal::SmoothStep {
            start: 1.0,
            end: 1.8,
            from: 0.0,
            to: 1.0,
        };
        assert_eq!(rise.longest_step(0.25), 0.75);
        assert!((rise.longest_step(1.0 - 1e-16) - 0.025).abs() < 1e-12);
        assert!((rise.longest_step(1.79) - 0.01).abs() < 1e-12);
        assert_eq!(rise.longest_step(1.8), f64::INFINITY);
        let pulse = Table::new("x", "m", &[(1.0, 0.0), (1.001, 5.0), (1.002, 0.0)]).unwrap();
        let pulse = Signal::Table(pulse);
        assert_eq!(pulse.longest_step(0.0), 1.0);
        assert!((pulse.longest_step(1.001) - 0.001).abs() < 1e-12);
        assert_eq!(pulse.longest_step(2.0), f64::INFINITY);
        let waves = Signal::Sines {
            offset: 1.0,
            terms: vec![[2.0, 10.0, 0.0], [0.0, 1e9, 0.0]],
        };
        assert!((waves.longest_step(3.0) - 0.05 * std::f64::consts::PI).abs() < 1e-12);
    }

    #[test]
    fn the_next_knot_is_the_first_one_after_a_time() {
        let table = Signal::ramp(0.5, 1.5, 0.0, 4.0).unwrap();
        assert_eq!(table.next_knot(0.0), 0.5);
        assert_eq!(table.next_knot(0.5), 1.5);
        assert_eq!(table.next_knot(1.5), f64::INFINITY);
        assert_eq!(Signal::from(3.0).next_knot(0.0), f64::INFINITY);
    }

    #[test]
    fn a_range_bounds_the_values() {
        let waves = Signal::Sines {
            offset: 1.0,
            terms: vec![[2.0, 10.0, 0.0], [-0.5, 3.0, 0.2]],
        };
        assert_eq!(waves.range(), [-1.5, 3.5]);
        assert_eq!(Signal::ramp(0.0, 1.0, 2.0, -5.0).unwrap().largest(), 5.0);
        assert!(Signal::from(0.0).is_zero() && !waves.is_zero());
    }
}

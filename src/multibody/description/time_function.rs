//! Numbers that depend on time: what drivers prescribe and applied forces follow.

use crate::error::{Error, Result, check};
use crate::math::piecewise::{Curve, Spline};

/// A number as a function of time.
#[derive(Debug, Clone, PartialEq)]
pub enum TimeFunction {
    /// The same at all times.
    Constant(f64),
    /// From one value to another with two continuous derivatives: s³ (10 - 15 s + 6 s²).
    SmoothStep {
        /// When it begins to change \[s\].
        start: f64,
        /// When it has changed \[s\].
        end: f64,
        /// Value before.
        from: f64,
        /// Value after.
        to: f64,
    },
    /// Straight lines between rows; a ramp has two of them.
    Table(Curve),
    /// A cubic spline through rows.
    Spline(Spline),
    /// offset + Σ amplitude · sin(frequency · t + phase).
    Sines {
        /// Mean value.
        offset: f64,
        /// (amplitude, angular frequency \[rad/s\], phase \[rad\]).
        terms: Vec<[f64; 3]>,
    },
}

/// Longest step inside a smooth step, as a part of its time, and along a wave, as a part of its period.
const PART_OF_RISE: f64 = 0.125;
const PART_OF_PERIOD: f64 = 0.25;

/// What rounding may leave of a step that was to end at `t`.
fn margin(t: f64) -> f64 {
    16.0 * f64::EPSILON * t.abs()
}

/// The first of increasing `arguments` behind `t`; infinite where there is none.
fn next_after(arguments: &[f64], t: f64) -> f64 {
    let next = arguments.partition_point(|&x| x - margin(x) <= t);
    arguments.get(next).copied().unwrap_or(f64::INFINITY)
}

impl From<f64> for TimeFunction {
    fn from(value: f64) -> Self {
        Self::Constant(value)
    }
}

impl TimeFunction {
    /// From one value to another along a straight line.
    ///
    /// # Errors
    /// When a number is not finite or the end is not after the start.
    pub fn ramp(start: f64, end: f64, from: f64, to: f64) -> Result<Self> {
        Curve::new("ramp", &[(start, from), (end, to)]).map(Self::Table)
    }

    /// Checks every number.
    ///
    /// # Errors
    /// Names `field`, its value and what is allowed.
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
                    format!("{field} (end)"),
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

    /// Value at `t` \[s\].
    #[must_use]
    pub fn value(&self, t: f64) -> f64 {
        match self {
            Self::Table(curve) => curve.value(t),
            _ => self.derivatives(t)[0],
        }
    }

    /// Value and first two derivatives at `t` \[s\].
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
            Self::Table(curve) => [curve.value(t), curve.slope(t), 0.0],
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

    /// The longest step from `t` \[s\] that passes over nothing unseen: to where the function bends next, and short beside
    /// the time that it takes to change.
    pub(crate) fn longest_step(&self, t: f64) -> f64 {
        match self {
            Self::Constant(_) => f64::INFINITY,
            Self::SmoothStep {
                start,
                end,
                from,
                to,
            } => {
                if from == to || t >= end - margin(*end) {
                    f64::INFINITY
                } else if t < start - margin(*start) {
                    start - t
                } else {
                    (end - t).min(PART_OF_RISE * (end - start))
                }
            }
            Self::Table(curve) => next_after(curve.arguments(), t) - t,
            Self::Spline(spline) => next_after(spline.arguments(), t) - t,
            Self::Sines { terms, .. } => {
                let moving = terms.iter().filter(|term| term[0] != 0.0);
                let fastest = moving.fold(0.0, |most: f64, term| most.max(term[1].abs()));
                PART_OF_PERIOD * 2.0 * std::f64::consts::PI / fastest
            }
        }
    }

    /// Integral from zero to `t` \[s\]; a spline's is not known, and is refused where one is needed.
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
            Self::Table(curve) => curve.integral(t),
            Self::Spline(_) => f64::NAN,
            Self::Sines { offset, terms } => {
                let waves = terms.iter().map(|[amplitude, frequency, phase]| {
                    if *frequency == 0.0 {
                        amplitude * phase.sin() * t
                    } else {
                        amplitude / frequency * (phase.cos() - (frequency * t + phase).cos())
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
            TimeFunction::Constant(3.0),
            TimeFunction::SmoothStep {
                start: 0.2,
                end: 0.9,
                from: -1.0,
                to: 2.0,
            },
            TimeFunction::ramp(0.1, 2.0, 1.0, 5.0).unwrap(),
            TimeFunction::Sines {
                offset: 0.3,
                terms: vec![[1.0, 2.0, 0.4], [0.5, 0.0, 1.0]],
            },
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
        let rise = TimeFunction::SmoothStep {
            start: 1.0,
            end: 1.8,
            from: 0.0,
            to: 1.0,
        };
        assert_eq!(rise.longest_step(0.25), 0.75);
        assert!((rise.longest_step(1.0 - 1e-16) - 0.1).abs() < 1e-12);
        assert!((rise.longest_step(1.75) - 0.05).abs() < 1e-12);
        assert_eq!(rise.longest_step(1.8), f64::INFINITY);
        let pulse = Curve::new("x", &[(1.0, 0.0), (1.001, 5.0), (1.002, 0.0)]).unwrap();
        let pulse = TimeFunction::Table(pulse);
        assert_eq!(pulse.longest_step(0.0), 1.0);
        assert!((pulse.longest_step(1.001) - 0.001).abs() < 1e-12);
        assert_eq!(pulse.longest_step(2.0), f64::INFINITY);
        let waves = TimeFunction::Sines {
            offset: 1.0,
            terms: vec![[2.0, 10.0, 0.0], [0.0, 1e9, 0.0]],
        };
        assert!((waves.longest_step(3.0) - 0.05 * std::f64::consts::PI).abs() < 1e-12);
    }
}

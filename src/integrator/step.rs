//! Result of one step: the accepted interval, the reason of a failure, and counts of work.

use serde::{Deserialize, Serialize};

use crate::error::Error;

/// An accepted step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Time at the start of the step \[s\].
    pub start: f64,
    /// Time at the end of the step \[s\].
    pub end: f64,
    /// Degree of the polynomial through slopes at the end of the step, at its start and at the starts before, whose integral the corrector
    /// takes: the order of the predictor, and one less with Newton's method.
    pub degree: usize,
}

/// Reason why no step is possible.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StepFailure {
    /// The step size is below the rounding of time.
    TooSmall {
        /// Time reached \[s\].
        time: f64,
        /// Size of the failed step \[s\].
        step_size: f64,
        /// Component with the largest error.
        component: usize,
    },
    /// The derivative is not finite at the smallest step size.
    NotFinite {
        /// Time reached \[s\].
        time: f64,
        /// Size of the failed step \[s\].
        step_size: f64,
        /// First component that is not a number.
        component: usize,
    },
    /// The tolerances are below the rounding of the solution.
    ToleranceTooSmall {
        /// Time reached \[s\].
        time: f64,
        /// Size of the next step \[s\].
        step_size: f64,
        /// Factor by which the tolerances are too small.
        factor: f64,
        /// Value of the component.
        value: f64,
        /// Component with the largest ratio of value and tolerance.
        component: usize,
    },
}

impl StepFailure {
    /// Return the error of a run; `name` returns the text for a time and a component.
    pub(crate) fn into_error(self, name: impl FnOnce(f64, usize) -> String) -> Error {
        match self {
            Self::TooSmall {
                time,
                step_size,
                component,
            } => Error::StepTooSmall {
                time,
                step_size,
                culprit: name(time, component),
            },
            Self::NotFinite {
                time,
                step_size,
                component,
            } => Error::NotFinite {
                time,
                step_size,
                culprit: name(time, component),
            },
            Self::ToleranceTooSmall {
                time,
                step_size,
                factor,
                value,
                component,
            } => Error::ToleranceTooSmall {
                time,
                step_size,
                factor,
                value,
                culprit: name(time, component),
            },
        }
    }
}

/// Counts of work since the integrator was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Counts {
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejected: u64,
    /// Evaluations of the right-hand side.
    pub evaluations: u64,
    /// Newton matrices factorised by the implicit corrector.
    pub jacobians: u64,
}

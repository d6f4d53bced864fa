//! Start of the last step of a mechanism.

use super::contact::impact_memory::Memory;
use super::contact::onset::OnsetNumbers;

/// Largest number of iterations of a projection in a run, where the residual is small at the start.
pub(super) const ITERATIONS: usize = 12;

/// Start of the last step, for the return after a failure and for states within the step.
#[derive(Debug, Clone, Default)]
pub(super) struct StepStart {
    pub(super) time: f64,
    pub(super) solution: Vec<f64>,
    pub(super) shift: Vec<f64>,
    pub(super) memory: Vec<Memory>,
    pub(super) onsets: OnsetNumbers,
    /// Whether the step uses the implicit corrector, whose last evaluation is not at the final solution.
    pub(super) is_implicit: bool,
}

impl StepStart {
    /// Return the state before the first step, with `dimension` coordinates and velocities and `sides` sides of contacts.
    pub(super) fn new(dimension: usize, sides: usize) -> Self {
        Self {
            shift: vec![0.0; dimension],
            memory: vec![Memory::default(); sides],
            ..Self::default()
        }
    }
}

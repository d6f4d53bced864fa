//! Largest forces and impulses between two reports, from the forces at the ends of the steps.

use pulp::{Simd, WithSimd};

use crate::math::simd::InstructionSet;

/// Largest force and impulse of each contact of a kind since the last report.
#[derive(Debug, Clone)]
pub struct Peaks {
    instructions: InstructionSet,
    time: f64,
    last: Vec<f64>,
    /// Forces at the end of the present step.
    pub(crate) arriving: Vec<f64>,
    force: Vec<f64>,
    impulse: Vec<f64>,
}

impl Peaks {
    pub(crate) fn new(contacts: usize, t: f64) -> Self {
        let zeros = || vec![0.0; contacts];
        Self {
            instructions: InstructionSet::detect(),
            time: t,
            last: zeros(),
            arriving: zeros(),
            force: zeros(),
            impulse: zeros(),
        }
    }

    /// Include the forces stored for time `t`.
    pub(crate) fn arrive(&mut self, t: f64) {
        let forces = std::mem::take(&mut self.arriving);
        self.account(t, &forces);
        self.arriving = forces;
    }

    /// Add the trapezoid between the previous forces and these to the impulses.
    fn account(&mut self, t: f64, forces: &[f64]) {
        self.instructions.run(Account {
            half_time: 0.5 * (t - self.time),
            forces,
            last: &mut self.last,
            largest: &mut self.force,
            impulses: &mut self.impulse,
        });
        self.time = t;
    }

    /// End an interval with the forces of a report at `t`; return largest forces and impulses, which are zero at the `first` report.
    pub(crate) fn close(&mut self, t: f64, forces: &[f64], first: bool) -> [&[f64]; 2] {
        self.account(t, forces);
        if first {
            self.force.fill(0.0);
            self.impulse.fill(0.0);
        }
        [&self.force, &self.impulse]
    }

    /// Begin the next interval with the last forces.
    pub(crate) fn begin_interval(&mut self) {
        self.force.copy_from_slice(&self.last);
        self.impulse.fill(0.0);
    }
}

/// Kernel of [`Peaks::account`], which runs after each step.
struct Account<'a> {
    half_time: f64,
    forces: &'a [f64],
    last: &'a mut [f64],
    largest: &'a mut [f64],
    impulses: &'a mut [f64],
}

impl WithSimd for Account<'_> {
    type Output = ();

    /// Two plain loops that the compiler vectorizes for the instruction set. A comparison is one instruction, `max` is several.
    #[inline(always)]
    #[allow(clippy::inline_always)] // a function that is not inlined is compiled without the kernel's instruction set
    fn with_simd<S: Simd>(self, _: S) {
        for (largest, &force) in self.largest.iter_mut().zip(self.forces) {
            *largest = if force > *largest { force } else { *largest };
        }
        let steps = self.last.iter_mut().zip(self.forces);
        for (impulse, (last, &force)) in self.impulses.iter_mut().zip(steps) {
            *impulse += self.half_time * (*last + force);
            *last = force;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_peak_between_two_reports_is_kept_with_its_impulse() {
        let mut peaks = Peaks::new(1, 1.0);
        let close = |peaks: &mut Peaks, t: f64, force: f64, first: bool| {
            let [largest, impulse] = peaks.close(t, &[force], first).map(|values| values[0]);
            peaks.begin_interval();
            (largest, impulse)
        };
        assert_eq!(close(&mut peaks, 1.0, 3.0, true), (0.0, 0.0));
        for (t, force) in [(1.5, 5.0), (2.0, 1.0)] {
            peaks.arriving[0] = force;
            peaks.arrive(t);
        }
        assert_eq!(close(&mut peaks, 3.0, 2.0, false), (5.0, 2.0 + 1.5 + 1.5));
        // A report within a step precedes the end of the step.
        peaks.arriving[0] = 8.0;
        assert_eq!(close(&mut peaks, 4.0, 4.0, false), (4.0, 3.0));
        peaks.arrive(5.0);
        assert_eq!(close(&mut peaks, 6.0, 0.0, false), (8.0, 10.0));
    }
}

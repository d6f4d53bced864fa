//! Largest forces and impulses between two reports, from the forces at the ends of the steps.

use pulp::{Simd, WithSimd};

use crate::math::simd::{
    InstructionSet, Lanes, Numbers, WIDTH, packs, packs_mut, padded_zeros, part_of, parts, put_part,
};

/// Largest force and impulse of each contact of a kind since the last report. Arrays are padded, with zeros behind the contacts.
#[derive(Debug, Clone)]
pub struct Peaks {
    contacts: usize,
    instructions: InstructionSet,
    /// Forces at the end of the present step, and those of a report.
    arriving: Numbers,
    reported: Numbers,
    /// Last included forces and their time.
    last: Numbers,
    time: f64,
    largest: Numbers,
    impulses: Numbers,
}

impl Peaks {
    pub(crate) fn new(contacts: usize, t: f64) -> Self {
        let zeros = || padded_zeros(contacts);
        Self {
            contacts,
            instructions: InstructionSet::detect(),
            arriving: zeros(),
            reported: zeros(),
            last: zeros(),
            time: t,
            largest: zeros(),
            impulses: zeros(),
        }
    }

    /// Return whether there is no contact.
    pub(crate) fn is_empty(&self) -> bool {
        self.contacts == 0
    }

    /// Return the forces at the end of the present step, to be written.
    pub(crate) fn arriving(&mut self) -> &mut [f64] {
        &mut self.arriving[..self.contacts]
    }

    /// Include the forces stored for time `t`.
    pub(crate) fn arrive(&mut self, t: f64) {
        self.include(t, false);
    }

    /// End an interval with the forces of a report at `t`; return largest forces and impulses. At the `first` report these are the forces
    /// there, and zero.
    pub(crate) fn close(&mut self, t: f64, forces: &[f64], first: bool) -> [&[f64]; 2] {
        self.reported[..self.contacts].copy_from_slice(forces);
        self.include(t, true);
        if first {
            self.begin_interval();
        }
        [&self.largest, &self.impulses].map(|values| &values[..self.contacts])
    }

    /// Begin the next interval with the last forces.
    pub(crate) fn begin_interval(&mut self) {
        self.largest.copy_from_slice(&self.last);
        self.impulses.fill(0.0);
    }

    /// Include the forces `reported` or arriving at `t`, and add the trapezoid between the last ones and these to the impulses.
    fn include(&mut self, t: f64, reported: bool) {
        self.instructions.run(Include {
            half_time: 0.5 * (t - self.time),
            forces: if reported {
                &self.reported
            } else {
                &self.arriving
            },
            last: &mut self.last,
            largest: &mut self.largest,
            impulses: &mut self.impulses,
        });
        self.time = t;
    }
}

/// Kernel of [`Peaks::include`], which runs after each step.
struct Include<'a> {
    half_time: f64,
    forces: &'a [f64],
    last: &'a mut [f64],
    largest: &'a mut [f64],
    impulses: &'a mut [f64],
}

impl WithSimd for Include<'_> {
    type Output = ();

    #[inline(always)]
    #[allow(clippy::inline_always)] // a function that is not inlined is compiled without the kernel's instruction set
    fn with_simd<S: Simd>(self, simd: S) {
        let count = self.forces.len() / WIDTH;
        let (forces, last) = (packs(self.forces, count), packs_mut(self.last, count));
        let (largest, impulses) = (
            packs_mut(self.largest, count),
            packs_mut(self.impulses, count),
        );
        let half_time = Lanes::splat(simd, self.half_time);
        for number in 0..count {
            for part in parts::<S>() {
                let force = part_of(simd, &forces[number], part);
                let before = part_of(simd, &largest[number], part);
                let larger = force.greater(before).select(force, before);
                put_part(&mut largest[number], part, larger);
                let sum = half_time * (part_of(simd, &last[number], part) + force);
                let impulse = part_of(simd, &impulses[number], part) + sum;
                put_part(&mut impulses[number], part, impulse);
                put_part(&mut last[number], part, force);
            }
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
        assert_eq!(close(&mut peaks, 1.0, 3.0, true), (3.0, 0.0));
        for (t, force) in [(1.5, 5.0), (2.0, 1.0)] {
            peaks.arriving()[0] = force;
            peaks.arrive(t);
        }
        assert_eq!(close(&mut peaks, 3.0, 2.0, false), (5.0, 2.0 + 1.5 + 1.5));
        // A report within a step precedes the end of the step.
        peaks.arriving()[0] = 8.0;
        assert_eq!(close(&mut peaks, 4.0, 4.0, false), (4.0, 3.0));
        peaks.arrive(5.0);
        assert_eq!(close(&mut peaks, 6.0, 0.0, false), (8.0, 10.0));
    }
}

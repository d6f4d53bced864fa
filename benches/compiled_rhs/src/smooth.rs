//! The problems with known answers as this crate's integrators see them.

use crate::problems::{Kepler, Pin};
use crate::system::{Accepted, Evolving};

impl Evolving for Kepler {
    fn scale(&self) -> Vec<f64> {
        vec![1.0; 4]
    }

    fn crossed(&mut self, _: &Accepted<'_>) -> bool {
        false
    }

    fn remember(&mut self, _: &Accepted<'_>) {}
}

impl Evolving for Pin {
    fn scale(&self) -> Vec<f64> {
        vec![1.0; 2]
    }

    /// It is one contact: its onset is found, and charged, as in this project's own run.
    fn crossed(&mut self, step: &Accepted<'_>) -> bool {
        self.watch(step.start, step.end, step.y_end[0], |t| {
            let mut y = [0.0; 2];
            step.at(t, &mut y);
            y
        })
    }

    fn remember(&mut self, _: &Accepted<'_>) {}
}

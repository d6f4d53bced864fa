//! Work of the external power in a step, by the formula with which the corrector integrates forces.
//!
//! A sprocket of prescribed speed, or a moving end, does the work of its speed and the impulse of the contact forces on it. Velocities change
//! by the impulse that the corrector integrates: of order two the mean of the forces at both ends of the step times its length. With
//! another impulse the balance would have an error of the difference times the speed of the sprocket, though the motion has none. Along
//! the path of the step, forces of overdamped contacts contain their damping times errors of velocities (decision 22).

use serde::{Deserialize, Serialize};

use crate::integrator::Step;

/// External powers at the starts of the two steps before a step, the later one first.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct ExternalPowers {
    /// Times \[s\] and powers \[W\].
    before: [Option<(f64, f64)>; 2],
}

impl ExternalPowers {
    /// Return the power in the middle of a step with the powers `ends` at its ends \[W\] with which Simpson's rule gives the work of the
    /// step, and remember the one at its start.
    ///
    /// The work is the integral of the polynomial through the powers at the end, at the start, and at the starts before: of the step's
    /// degree, but at most three, and a line in the first step.
    pub(super) fn in_the_middle(&mut self, step: &Step, ends: [f64; 2]) -> f64 {
        let [start, end] = ends;
        let length = step.end - step.start;
        let place = |(t, power): (f64, f64)| ((t - step.start) / length, power);
        let [later, earlier] = self.before.map(|node| node.map(place));
        self.before = [Some((step.start, start)), self.before[0]];
        // The first step is of degree zero and can be long: a speed that rises from rest is then not that of its end.
        if step.degree == 0 && later.is_some() {
            // Of constant power, that at the end: 6 times it less both ends, over 4.
            return 1.25 * end - 0.25 * start;
        }
        let mut middle = 0.5 * (start + end);
        let Some((a, later)) = later.filter(|_| step.degree > 1) else {
            return middle;
        };
        // Divided differences. The mean of x (x - 1) in the step is -1/6, and that of x (x - 1) (x - a) is a/6 - 1/12. Simpson's rule has a
        // weight of 4/6 in the middle.
        let slope = (later - start) / a;
        let bend = (end - start - slope) / (1.0 - a);
        middle -= 0.25 * bend;
        if let Some((b, earlier)) = earlier.filter(|_| step.degree > 2) {
            let before = ((earlier - later) / (b - a) - slope) / b;
            middle += (0.25 * a - 0.125) * (bend - before) / (1.0 - b);
        }
        middle
    }
}

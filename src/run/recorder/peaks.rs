//! What passes between two reports: peaks and impulses.

use super::rows::Row;

/// Largest force and impulse of every contact since the last report, from the forces at the ends of the steps.
#[derive(Debug, Clone)]
pub(super) struct Peaks {
    time: f64,
    last: Vec<f64>,
    pub(super) arriving: Vec<f64>,
    force: Vec<f64>,
    impulse: Vec<f64>,
}

impl Peaks {
    pub(super) fn new(contacts: usize, t: f64) -> Self {
        let zeros = || vec![0.0; contacts];
        Self {
            time: t,
            last: zeros(),
            arriving: zeros(),
            force: zeros(),
            impulse: zeros(),
        }
    }

    /// Takes in the forces that have been set aside for time `t`.
    pub(super) fn arrive(&mut self, t: f64) {
        let forces = std::mem::take(&mut self.arriving);
        self.account(t, &forces);
        self.arriving = forces;
    }

    fn account(&mut self, t: f64, forces: &[f64]) {
        let half = 0.5 * (t - self.time);
        for (i, &force) in forces.iter().enumerate() {
            self.force[i] = self.force[i].max(force);
            self.impulse[i] += half * (self.last[i] + force);
        }
        self.last.copy_from_slice(forces);
        self.time = t;
    }

    /// Ends an interval at a report with the forces there, writes it and begins the next.
    pub(super) fn close(&mut self, t: f64, forces: &[f64], first: bool, row: &mut Row) {
        self.account(t, forces);
        if first {
            self.force.fill(0.0);
            self.impulse.fill(0.0);
        }
        row.real(self.force.iter().copied());
        row.real(self.impulse.iter().copied());
        self.force.copy_from_slice(forces);
        self.impulse.fill(0.0);
    }
}

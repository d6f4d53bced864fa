//! Largest forces and impulses between two reports, from the forces at the ends of the steps.

/// Forces of a kind, summed up since the last report.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Peaks {
    /// When `last` was.
    time: f64,
    /// Forces taken in last; none before the first report.
    last: Vec<f64>,
    /// Forces at the end of the step under way.
    arriving: Vec<f64>,
    largest: Vec<f64>,
    impulse: Vec<f64>,
}

impl Peaks {
    /// Sets aside the forces at the end of a step.
    pub(crate) fn arrive(&mut self, forces: impl Iterator<Item = f64>) {
        self.arriving.clear();
        self.arriving.extend(forces);
    }

    /// Takes the forces set aside into the sums: they belong to `t`.
    pub(crate) fn take_arrived(&mut self, t: f64) {
        let forces = std::mem::take(&mut self.arriving);
        if !forces.is_empty() {
            self.account(t, &forces);
        }
        self.arriving = forces;
        self.arriving.clear();
    }

    /// Trapezoids from the forces before to these.
    fn account(&mut self, t: f64, forces: &[f64]) {
        let half = 0.5 * (t - self.time);
        for (i, &force) in forces.iter().enumerate() {
            self.largest[i] = self.largest[i].max(force);
            self.impulse[i] += half * (self.last[i] + force);
        }
        self.last.copy_from_slice(forces);
        self.time = t;
    }

    /// Ends an interval with the forces of a report, adds largest forces and impulses to `rows`, and begins the next one.
    pub(crate) fn close(
        &mut self,
        t: f64,
        forces: impl Iterator<Item = f64>,
        [largest, impulse]: [&mut Vec<f64>; 2],
    ) {
        let forces: Vec<f64> = forces.collect();
        if self.last.len() == forces.len() {
            self.account(t, &forces);
        } else {
            self.largest = vec![0.0; forces.len()];
            self.impulse = vec![0.0; forces.len()];
            (self.time, self.last) = (t, forces);
        }
        largest.extend(&self.largest);
        impulse.extend(&self.impulse);
        self.largest.copy_from_slice(&self.last);
        self.impulse.fill(0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_peak_between_two_reports_is_kept_with_its_impulse() {
        let (mut peaks, mut rows) = (Peaks::default(), [Vec::new(), Vec::new()]);
        let mut close = |peaks: &mut Peaks, t: f64, force: f64| {
            let [largest, impulse] = &mut rows;
            peaks.close(t, [force].into_iter(), [largest, impulse]);
            (rows[0].last().copied(), rows[1].last().copied())
        };
        assert_eq!(close(&mut peaks, 1.0, 3.0), (Some(0.0), Some(0.0)));
        for (t, force) in [(1.5, 5.0), (2.0, 1.0)] {
            peaks.arrive([force].into_iter());
            peaks.take_arrived(t);
        }
        assert_eq!(
            close(&mut peaks, 3.0, 2.0),
            (Some(5.0), Some(2.0 + 1.5 + 1.5))
        );
        // A report inside a step comes before the step's end.
        peaks.arrive([8.0].into_iter());
        assert_eq!(close(&mut peaks, 4.0, 4.0), (Some(4.0), Some(3.0)));
        peaks.take_arrived(5.0);
        assert_eq!(close(&mut peaks, 6.0, 0.0), (Some(8.0), Some(10.0)));
    }
}

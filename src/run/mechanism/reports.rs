//! Reports of a running mechanism: when they are due, and what has been recorded.

use super::recording::MechanismRecording;
use super::simulation::MechanismSimulation;
use crate::run::simulation::{describe_open_balance, tighter_accuracy};

/// When reports are due.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reports {
    start: f64,
    step: f64,
    made: usize,
    count: usize,
    /// Whether the run pauses after each report.
    pauses: bool,
}

impl Reports {
    fn time(&self, number: usize) -> f64 {
        self.start + self.step * number as f64
    }

    fn next(&self) -> Option<f64> {
        (self.made < self.count).then(|| self.time(self.made))
    }

    pub(crate) fn end(&self) -> f64 {
        self.time(self.count - 1)
    }
}

impl MechanismSimulation {
    /// Begins a recording at the present time.
    pub fn start_recording(&mut self, duration: f64, report_step: f64) {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        // checked to be at most 1e9
        let count = (duration / report_step * (1.0 + 1e-12)).floor() as usize + 1;
        self.recording = MechanismRecording::default();
        self.reports = Some(Reports {
            start: self.now,
            step: report_step,
            made: 0,
            count,
            pauses: false,
        });
    }

    /// Makes the recording pause after each report, so that its caller can look at the state there: [`record`](Self::record) then
    /// returns, and goes on when it is called again.
    pub fn pause_at_reports(&mut self) {
        if let Some(reports) = &mut self.reports {
            reports.pauses = true;
        }
    }

    /// The recording under way, or the last one.
    #[must_use]
    pub fn recording(&self) -> &MechanismRecording {
        &self.recording
    }

    /// Ends the recording and hands it over, with all rows made so far.
    pub fn take_recording(&mut self) -> MechanismRecording {
        self.reports = None;
        if self.balance_note.is_none() {
            let control = self.adams.control();
            let open = self.recording.open_balance();
            self.balance_note =
                open.map(|open| describe_open_balance(&open, &tighter_accuracy(&control, &open)));
        }
        std::mem::take(&mut self.recording)
    }

    /// Makes the reports that the last step has come past; false at a pause.
    pub(crate) fn report(&mut self) -> bool {
        let end = self.adams.time();
        while let Some(t) = self.reports.and_then(|r| r.next()).filter(|&t| t <= end) {
            self.look_at(t);
            let sums = 2 * self.dynamics.model.coordinates();
            let sums = [self.inside[sums], self.inside[sums + 1]];
            self.recording.report(t, &self.dynamics, sums);
            self.now = t;
            if let Some(reports) = &mut self.reports {
                reports.made += 1;
                if reports.pauses {
                    return false;
                }
            }
        }
        if self.reports.is_some() {
            self.recording.take_arrived(end);
        }
        true
    }
}

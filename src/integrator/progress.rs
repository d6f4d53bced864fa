//! Progress of a run: mean step size, compared with the remaining time.

use super::Counts;

/// Steps, rejected ones included, over which the mean step size is measured.
///
/// More than the some thousand steps of a phase of dense impacts; few enough that a stalled drive ends within seconds. Doubled: the
/// error of a stalled run comes after twice as many steps.
const WINDOW: u64 = 100_000;

/// Largest number of steps that a run may need at the present mean step size.
///
/// A drive of 60 links takes 5 µs per step: this number takes more than an hour. Default tolerances need 3e5 steps per simulated second,
/// `rtol = atol = 1e-13` needs 2e8. Doubled: runs of two hours per simulated second are permitted.
pub(crate) const MOST_STEPS: f64 = 1e9;

/// Longest simulated time \[s\] for which [`MOST_STEPS`] must suffice.
///
/// A run with a stop condition may have any duration. Doubled: runs stall at twice the mean step size.
const HORIZON: f64 = 1.0;

/// Start of the present window of steps.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Progress {
    tried: u64,
    time: f64,
}

impl Progress {
    /// Begin a window at `time` \[s\].
    pub(crate) fn from(counts: Counts, time: f64) -> Self {
        let tried = counts.steps + counts.rejected;
        Self { tried, time }
    }

    /// Return the mean step size \[s\] of a full window, if the time to `target` \[s\], at most [`HORIZON`], would take more than
    /// [`MOST_STEPS`] at this step size.
    pub(crate) fn stalled(&mut self, counts: Counts, time: f64, target: f64) -> Option<f64> {
        let now = Self::from(counts, time);
        let steps = now.tried.saturating_sub(self.tried);
        if steps < WINDOW {
            return None;
        }
        let mean = (time - self.time) / steps as f64;
        *self = now;
        ((target - time).min(HORIZON) > MOST_STEPS * mean).then_some(mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(steps: u64, rejected: u64) -> Counts {
        Counts {
            steps,
            rejected,
            ..Counts::default()
        }
    }

    #[test]
    fn a_run_stalls_when_the_rest_of_it_needs_too_many_steps() {
        let step = 0.5 * HORIZON / MOST_STEPS;
        let time = WINDOW as f64 * step;
        let stalled = |target: f64| Progress::default().stalled(counts(WINDOW, 0), time, target);
        assert_eq!(stalled(time + 0.4), None);
        assert_eq!(stalled(time + 0.6), Some(step));
        assert_eq!(stalled(1e9), Some(step));
    }

    #[test]
    fn the_duration_asked_for_does_not_stall_a_run() {
        let time = WINDOW as f64 * 1e-7;
        assert_eq!(
            Progress::default().stalled(counts(WINDOW, 0), time, 1e12),
            None
        );
    }

    #[test]
    fn rejected_steps_count_and_windows_follow_each_other() {
        let mut progress = Progress::default();
        assert_eq!(progress.stalled(counts(10, WINDOW - 11), 0.0, 1.0), None);
        assert_eq!(
            progress.stalled(counts(10, WINDOW - 10), 0.0, 1.0),
            Some(0.0)
        );
        assert_eq!(progress.stalled(counts(10, WINDOW), 0.0, 1.0), None);
    }

    #[test]
    fn a_late_window_is_measured_by_its_own_steps_and_the_rest_of_the_run() {
        let step = 0.1 * HORIZON / MOST_STEPS;
        let start = 5.0;
        let time = start + WINDOW as f64 * step;
        let late = |target: f64| {
            let mut progress = Progress::default();
            assert_eq!(progress.stalled(counts(WINDOW, 0), start, start), None);
            progress.stalled(counts(2 * WINDOW, 0), time, target)
        };
        let mean = late(1e9).unwrap();
        assert!((mean / step - 1.0).abs() < 1e-6, "{mean}");
        // A rest that takes fewer steps than the limit.
        assert_eq!(late(time + 0.05 * HORIZON), None);
    }
}

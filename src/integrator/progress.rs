//! Progress of a run: simulated time per step, compared with the time that is left.

use super::Counts;

/// Steps, rejected ones included, over which the mean step size is measured. Large enough that a phase of dense impacts, some
/// thousand steps long, does not decide; small enough that a stalled drive ends within seconds. With ten times as many the
/// error arrives ten times later.
const WINDOW: u64 = 100_000;

/// Most steps that a run may need at the present rate. A drive of 60 links takes 5 us a step, so that this many take more than an
/// hour. Default tolerances need 3e5 steps per simulated second, `rtol = atol = 1e-13` needs 2e8. Twice as many would let a
/// hopeless run go on for two hours.
pub(crate) const MOST_STEPS: f64 = 1e9;

/// Simulated time for which that many steps must suffice \[s\], where more is left: a run with a stop condition, or one to be
/// interrupted, may ask for any duration.
const HORIZON: f64 = 1.0;

/// Where the present window began.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Progress {
    tried: u64,
    time: f64,
}

impl Progress {
    /// A window that begins at `time` \[s\].
    pub(crate) fn from(counts: Counts, time: f64) -> Self {
        let tried = counts.steps + counts.rejected;
        Self { tried, time }
    }

    /// The mean step size \[s\] of a window that ends now, if at this rate the time to `target` \[s\] or the horizon, whichever is
    /// nearer, takes more than [`MOST_STEPS`].
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
}

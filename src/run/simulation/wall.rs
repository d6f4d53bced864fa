//! Wall time of runs, by activity.

use std::time::Duration;

/// Wall time of runs. Steps are too short to read the clock in each: some are timed, and all are assumed to be like them.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Wall {
    /// Total wall time.
    pub(super) runs: Duration,
    pub(super) reports: Duration,
    /// Wall time of the timed steps, and of the location of their onsets.
    stepping: Duration,
    onsets: Duration,
    timed: u32,
}

/// Ratio of a step's time to the mean of previous ones above which it counts as interrupted and is ignored.
const INTERRUPTED: u32 = 30;

impl Wall {
    /// Include a timed step: its own time and that of locating its onsets.
    pub(super) fn include(&mut self, stepping: Duration, onsets: Duration) {
        let before = self.stepping + self.onsets;
        if self.timed > 0 && (stepping + onsets) * self.timed > before * INTERRUPTED {
            return;
        }
        self.stepping += stepping;
        self.onsets += onsets;
        self.timed += 1;
    }

    /// Return the wall times in steps and in locating onsets \[s\].
    pub(super) fn steps(&self) -> [f64; 2] {
        let all = self.runs.saturating_sub(self.reports).as_secs_f64();
        let [stepping, onsets] = [self.stepping, self.onsets].map(|d| d.as_secs_f64());
        let timed = stepping + onsets;
        if timed > 0.0 {
            [all * stepping / timed, all * onsets / timed]
        } else {
            [all, 0.0]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_that_was_interrupted_does_not_say_where_time_goes() {
        let micros = Duration::from_micros;
        let mut wall = Wall {
            runs: Duration::from_secs(1),
            ..Wall::default()
        };
        assert_eq!(wall.steps(), [1.0, 0.0]);
        for _ in 0..100 {
            wall.include(micros(3), micros(1));
        }
        wall.include(micros(3), micros(10_000));
        wall.include(micros(30), micros(10));
        let [stepping, onsets] = wall.steps();
        assert!((stepping - 0.75).abs() < 1e-12, "{stepping}");
        assert!((onsets - 0.25).abs() < 1e-12, "{onsets}");
    }
}

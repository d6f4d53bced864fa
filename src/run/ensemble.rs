//! Ensembles of independent drives: each is built, run and recorded on one thread of a pool.

use std::num::NonZero;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use rayon::iter::{ParallelBridge, ParallelIterator};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::chain::Groups;
use crate::chain::model::{ForceLaws, Model};
use crate::drive::Drive;
use crate::error::{Error, Result};
use crate::integrator::StepControl;
use crate::layout::InitialConfiguration;
use crate::panics;
use crate::run::simulation::{Simulation, check_reports};

/// Wall time between two checks for cancellation of the ensemble.
const SLICE: Duration = Duration::from_millis(50);

/// Drive with the settings of its run.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// Description of the drive.
    pub drive: Drive,
    /// Force laws.
    pub laws: ForceLaws,
    /// Start; `None`: the generated initial configuration.
    pub start: Option<InitialConfiguration>,
    /// Recorded groups.
    pub groups: Groups,
    /// Settings of the integration.
    pub control: StepControl,
    /// Simulated time \[s\].
    pub duration: f64,
    /// Report interval \[s\].
    pub report_step: f64,
}

/// Case that was started.
#[derive(Debug, Clone)]
pub struct Run {
    /// Initial positions and velocities.
    pub start: InitialConfiguration,
    /// Simulation with its recording, statistics and warnings.
    pub simulation: Simulation,
}

/// Reason why a case did not reach its end.
#[derive(Debug, Clone)]
pub struct Failure {
    /// Error that ended the case.
    pub error: Error,
    /// Run with its recording up to the error; `None` if the case did not start.
    pub run: Option<Box<Run>>,
}

/// Outcome of a case.
pub type Outcome = std::result::Result<Box<Run>, Failure>;

/// Cases and the threads that run them.
///
/// Each case runs on one thread from its start to its end. Its results are therefore independent of the number of threads and of the other
/// cases.
#[derive(Debug)]
pub struct Ensemble {
    cases: Vec<Case>,
    pool: ThreadPool,
    cancelled: AtomicBool,
    /// Simulated time of each case \[s\], as bits.
    reached: Vec<AtomicU64>,
}

impl Ensemble {
    /// Return an ensemble of `cases` on `threads` threads; `None`: one thread per core.
    ///
    /// # Errors
    /// If the operating system grants no threads.
    pub fn new(cases: Vec<Case>, threads: Option<NonZero<usize>>) -> Result<Self> {
        let cores = || std::thread::available_parallelism().unwrap_or(NonZero::<usize>::MIN);
        let threads = threads.unwrap_or_else(cores).get().min(cases.len().max(1));
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|number| format!("rustchain case runner {number}"))
            .build()
            .map_err(|error| {
                Error::Impossible(format!(
                    "cannot start {threads} threads ({error}): request fewer"
                ))
            })?;
        Ok(Self {
            reached: cases.iter().map(|_| AtomicU64::default()).collect(),
            cases,
            pool,
            cancelled: AtomicBool::new(false),
        })
    }

    /// Return the number of threads.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Run the cases in their order and pass each to `finished` with its number, from 0, as soon as it has ended.
    ///
    /// `finished` is called on the thread of the case, which starts its next case when `finished` returns. No more cases are in memory than
    /// there are threads, except those kept by `finished`. A panic in a case fails that case alone.
    pub fn run(&self, finished: impl Fn(usize, Outcome) + Sync) {
        self.pool.install(|| {
            // A bridge hands out one case at a time, in order: a thread with short cases takes more of them.
            (0..self.cases.len()).par_bridge().for_each(|number| {
                if let Some(outcome) = guarded(|| self.run_case(number)) {
                    self.note(number, self.cases[number].duration);
                    finished(number, outcome);
                }
            });
        });
    }

    /// End [`run`](Self::run) soon, from any thread. Cases that have not ended by then are dropped.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Return the simulated time of all cases together \[s\]; a failed case counts in full.
    #[must_use]
    pub fn simulated(&self) -> f64 {
        let seconds = |bits: &AtomicU64| f64::from_bits(bits.load(Ordering::Relaxed));
        self.reached.iter().map(seconds).sum()
    }

    /// Run a case to its end; return `None` if the ensemble was cancelled before.
    fn run_case(&self, number: usize) -> Option<Outcome> {
        if self.cancelled.load(Ordering::Relaxed) {
            return None;
        }
        let mut run = match self.cases[number].begin() {
            Ok(run) => Box::new(run),
            Err(error) => return Some(Err(Failure { error, run: None })),
        };
        loop {
            match run.simulation.record(SLICE) {
                Ok(true) => return Some(Ok(run)),
                Ok(false) if self.cancelled.load(Ordering::Relaxed) => return None,
                Ok(false) => self.note(number, run.simulation.time()),
                Err(error) => {
                    let run = Some(run);
                    return Some(Err(Failure { error, run }));
                }
            }
        }
    }

    fn note(&self, number: usize, time: f64) {
        self.reached[number].store(time.to_bits(), Ordering::Relaxed);
    }
}

impl Case {
    /// Compile the model, place all bodies and begin the recording.
    fn begin(&self) -> Result<Run> {
        check_reports(self.duration, self.report_step)?;
        let place = match &self.start {
            Some(start) => start.clone(),
            None => InitialConfiguration::generate(&self.drive)?.0,
        };
        let model = Arc::new(Model::compile(&self.drive, &self.laws, &place)?);
        let mut simulation = Simulation::new(model, &place, self.control)?;
        let motion = simulation.motion();
        let start = InitialConfiguration {
            positions: motion.positions(),
            velocities: motion.velocities(),
            ..InitialConfiguration::default()
        };
        simulation.start_recording(self.duration, self.report_step, self.groups);
        Ok(Run { start, simulation })
    }
}

/// Return the result of `work`; convert a panic to a failure.
fn guarded(work: impl FnOnce() -> Option<Outcome>) -> Option<Outcome> {
    panics::guarded(work).unwrap_or_else(|message| {
        let error = Error::Panicked {
            time: None,
            message,
        };
        Some(Err(Failure { error, run: None }))
    })
}

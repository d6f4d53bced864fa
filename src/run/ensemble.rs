//! Many scenes at once: each is built, run and recorded on one thread of a pool, and none disturbs another.

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
use crate::multibody::{Mechanism, MechanismGroups, MechanismModel, Stabilisation};
use crate::panics;
use crate::run::simulation::{Simulation, check_reports};
use crate::run::{AnySimulation, MechanismSimulation};

/// Wall time between two looks at whether the ensemble was cancelled.
const SLICE: Duration = Duration::from_millis(50);

/// What moves, where it begins and what is recorded of it.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant)] // one a case: the difference does not matter
pub enum Scene {
    /// A chain drive.
    Drive {
        /// Its description.
        drive: Box<Drive>,
        /// The force laws.
        laws: ForceLaws,
        /// Where it begins; `None`: as generated.
        start: Option<InitialConfiguration>,
        /// What to record.
        groups: Groups,
    },
    /// A mechanism, which begins where it is placed.
    Mechanism {
        /// Its description.
        mechanism: Mechanism,
        /// How it is kept on its constraints.
        stabilisation: Stabilisation,
        /// What to record.
        groups: MechanismGroups,
    },
}

/// One scene and how it is run.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// What moves.
    pub scene: Scene,
    /// How it is integrated.
    pub control: StepControl,
    /// Simulated time \[s\].
    pub duration: f64,
    /// Time between two rows \[s\].
    pub report_step: f64,
}

/// A case that was begun.
#[derive(Debug, Clone)]
pub struct Run {
    /// Where it began.
    pub start: InitialConfiguration,
    /// Where it is, with recording, statistics and notes.
    pub simulation: AnySimulation,
}

/// Why a case did not reach its end.
#[derive(Debug, Clone)]
pub struct Failure {
    /// What went wrong.
    pub error: Error,
    /// The run with what it had recorded; `None` when it did not begin.
    pub run: Option<Box<Run>>,
}

/// What came of a case.
pub type Outcome = std::result::Result<Box<Run>, Failure>;

/// Cases and the threads that run them.
///
/// Each case runs on one thread from its beginning to its end, so that its numbers are the same whatever the number of
/// threads and whatever the others do.
#[derive(Debug)]
pub struct Ensemble {
    cases: Vec<Case>,
    pool: ThreadPool,
    cancelled: AtomicBool,
    /// Simulated time of each case \[s\], as bits.
    reached: Vec<AtomicU64>,
}

impl Ensemble {
    /// `cases` on so many `threads`; `None`: as many as there are cores.
    ///
    /// # Errors
    /// When the system grants no threads.
    pub fn new(cases: Vec<Case>, threads: Option<NonZero<usize>>) -> Result<Self> {
        let cores = || std::thread::available_parallelism().unwrap_or(NonZero::<usize>::MIN);
        let threads = threads.unwrap_or_else(cores).get().min(cases.len().max(1));
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|number| format!("rustchain case runner {number}"))
            .build()
            .map_err(|error| {
                Error::Impossible(format!(
                    "cannot start {threads} threads ({error}): ask for fewer"
                ))
            })?;
        Ok(Self {
            reached: cases.iter().map(|_| AtomicU64::default()).collect(),
            cases,
            pool,
            cancelled: AtomicBool::new(false),
        })
    }

    /// How many threads there are.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Runs the cases in their order and hands each to `finished` with its number, from 0, as soon as it has ended.
    ///
    /// `finished` is called on the thread that ran the case, which takes its next one when `finished` returns: no more cases
    /// are in memory than there are threads, but for those that `finished` keeps. A case that panics fails alone.
    pub fn run(&self, finished: impl Fn(usize, Outcome) + Sync) {
        self.pool.install(|| {
            // A bridge hands out one case at a time, in order: a thread that had short cases takes more of them.
            (0..self.cases.len()).par_bridge().for_each(|number| {
                if let Some(outcome) = guarded(|| self.run_case(number)) {
                    self.note(number, self.cases[number].duration);
                    finished(number, outcome);
                }
            });
        });
    }

    /// Ends [`run`](Self::run) soon, from whatever thread. Cases that have not ended by then are dropped.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Simulated time that all cases together have behind them \[s\]; a case that failed counts as a whole one.
    #[must_use]
    pub fn simulated(&self) -> f64 {
        let seconds = |bits: &AtomicU64| f64::from_bits(bits.load(Ordering::Relaxed));
        self.reached.iter().map(seconds).sum()
    }

    /// Runs a case to its end; `None` when the ensemble was cancelled before.
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
    /// Compiles the model, places everything and begins the recording.
    fn begin(&self) -> Result<Run> {
        check_reports(self.duration, self.report_step)?;
        let mut simulation = self.simulation()?;
        let start = InitialConfiguration {
            positions: simulation.positions(),
            velocities: simulation.velocities(),
        };
        Ok(Run { start, simulation })
    }

    fn simulation(&self) -> Result<AnySimulation> {
        let (duration, report_step) = (self.duration, self.report_step);
        match &self.scene {
            Scene::Drive {
                drive,
                laws,
                start,
                groups,
            } => {
                let start = match start {
                    Some(start) => start.clone(),
                    None => InitialConfiguration::generate(drive)?.0,
                };
                let model = Arc::new(Model::compile(drive, laws, &start)?);
                let mut simulation = Simulation::new(model, &start, self.control)?;
                simulation.start_recording(duration, report_step, *groups);
                Ok(AnySimulation::Drive(simulation))
            }
            Scene::Mechanism {
                mechanism,
                stabilisation,
                groups,
            } => {
                let model = Arc::new(MechanismModel::compile(mechanism)?);
                let mut simulation =
                    MechanismSimulation::assemble(model, self.control, *stabilisation)?;
                simulation.start_recording(duration, report_step, *groups);
                Ok(AnySimulation::Mechanism(simulation))
            }
        }
    }
}

/// What `work` comes to; a panic becomes a failure.
fn guarded(work: impl FnOnce() -> Option<Outcome>) -> Option<Outcome> {
    panics::guarded(work).unwrap_or_else(|message| {
        let error = Error::Panicked {
            time: None,
            message,
        };
        Some(Err(Failure { error, run: None }))
    })
}

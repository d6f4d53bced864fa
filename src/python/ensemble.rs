//! Ensembles of runs for Python: cases run on threads of their own and are fetched one by one.

use std::num::NonZero;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use numpy::PyReadonlyArray2;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use super::core::Core;
use super::describe;
use super::mechanism_callable::Raised;
use super::starts::{DriveScene, budget};
use crate::error::Error;
use crate::run::AnySimulation;
use crate::run::ensemble;
use crate::run::ensemble::{Failure, Outcome, Run};

/// Drive with its recorded groups, checked and ready to run.
#[pyclass(module = "rustchain._rustchain", frozen)]
pub(super) struct Case(ensemble::Case);

#[pymethods]
impl Case {
    #[new]
    #[pyo3(signature = (scene, duration, report_step, groups, energy, positions, velocities, surfaces=Vec::new()))]
    #[allow(clippy::needless_pass_by_value, clippy::too_many_arguments)] // keywords in Python; PyO3 passes lists by value
    fn new(
        scene: &Bound<'_, PyAny>,
        duration: &Bound<'_, PyAny>,
        report_step: &Bound<'_, PyAny>,
        groups: Vec<String>,
        energy: &Bound<'_, PyAny>,
        positions: Option<PyReadonlyArray2<'_, f64>>,
        velocities: Option<PyReadonlyArray2<'_, f64>>,
        surfaces: Vec<[usize; 3]>,
    ) -> PyResult<Self> {
        let scene = DriveScene::new(scene, (positions.as_ref(), velocities.as_ref(), surfaces))?;
        let (duration, report_step, energy) =
            describe::reports(duration, report_step, Some(energy))?;
        Ok(Self(ensemble::Case {
            drive: scene.drive,
            laws: scene.laws,
            start: scene.start,
            groups: describe::drive_groups(&groups, energy),
            control: scene.control,
            duration,
            report_step,
        }))
    }
}

/// Running cases.
#[pyclass(module = "rustchain._rustchain", frozen)]
pub(super) struct Ensemble {
    running: Arc<ensemble::Ensemble>,
    outcomes: Mutex<Option<Receiver<(usize, Outcome)>>>,
    runner: Mutex<Option<JoinHandle<()>>>,
}

/// Number of the case; its run, if it started; the error, if there was one.
type Fetched = (usize, Option<Core>, Option<Py<PyAny>>);

#[pymethods]
impl Ensemble {
    #[new]
    #[allow(clippy::needless_pass_by_value)] // PyO3 passes lists by value
    fn new(cases: Vec<PyRef<'_, Case>>, threads: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let threads = threads.map(number_of_threads).transpose()?;
        let cases = cases.iter().map(|case| case.0.clone()).collect();
        let running = Arc::new(ensemble::Ensemble::new(cases, threads)?);
        // Each thread may leave one finished case in the channel and continue: memory is bounded by the number of threads.
        let (sender, outcomes) = sync_channel(running.threads());
        let shared = Arc::clone(&running);
        let runner = std::thread::spawn(move || {
            shared.run(|number, outcome| {
                // After `close` there is no receiver.
                let _ = sender.send((number, outcome));
            });
        });
        Ok(Self {
            running,
            outcomes: Mutex::new(Some(outcomes)),
            runner: Mutex::new(Some(runner)),
        })
    }

    #[getter]
    fn simulated(&self) -> f64 {
        self.running.simulated()
    }

    fn fetch(&self, py: Python<'_>, wall_budget: f64) -> PyResult<Option<Fetched>> {
        let found = py.detach(|| {
            let outcomes = self.outcomes.lock().unwrap_or_else(PoisonError::into_inner);
            outcomes
                .as_ref()
                .map(|outcomes| outcomes.recv_timeout(budget(wall_budget)))
        });
        let (number, outcome) = match found {
            Some(Ok(found)) => found,
            Some(Err(RecvTimeoutError::Timeout)) => return Ok(None),
            Some(Err(RecvTimeoutError::Disconnected)) | None => {
                return Err(PyRuntimeError::new_err(
                    "all cases were fetched, or the ensemble was closed",
                ));
            }
        };
        let (run, error) = match outcome {
            Ok(run) => (Some(run), None),
            Err(Failure { run, error }) => (run, Some(error)),
        };
        let error = error.map(|error| PyErr::from(error).into_value(py).into_any());
        let run = run.map(|run| {
            let Run { start, simulation } = *run;
            let start = [start.positions, start.velocities];
            Core::of(AnySimulation::Drive(simulation), start, Raised::default())
        });
        Ok(Some((number, run, error)))
    }

    fn close(&self, py: Python<'_>) {
        self.running.cancel();
        py.detach(|| {
            // Without a receiver, threads that wait to send a case continue.
            drop(
                self.outcomes
                    .lock()
                    .unwrap_or_else(PoisonError::into_inner)
                    .take(),
            );
            let runner = self
                .runner
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .take();
            runner.map(JoinHandle::join)
        });
    }
}

impl Drop for Ensemble {
    fn drop(&mut self) {
        self.running.cancel();
    }
}

fn number_of_threads(value: &Bound<'_, PyAny>) -> PyResult<NonZero<usize>> {
    let count = describe::count(value, "threads")?;
    let expected = "must be at least 1, or None for all cores";
    let refuse = || Error::invalid("threads", count, expected).into();
    NonZero::new(count as usize).ok_or_else(refuse)
}

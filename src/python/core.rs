//! Simulation object for Python, of a chain drive or of a mechanism.

use std::sync::Arc;

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use super::arrays::{RecordedRows, recorded, rows, table};
use super::describe;
use super::evaluation::{
    assembly, drive_evaluation, mechanism_evaluation, set_contact_memory, statistics,
};
use super::mechanism_callable::{Raised, take};
use super::starts::{DriveScene, budget, describe_tooth_jumps, input};
use crate::chain::contact::ToothJump;
use crate::chain::dynamics::check_rows;
use crate::chain::model::Model;
use crate::error::{Error, Result};
use crate::panics::contained;
use crate::run::simulation::Simulation;
use crate::run::{AnySimulation, MechanismSimulation};

/// Compiled model with its state and integrator.
#[pyclass(module = "rustchain._rustchain")]
pub(super) struct Core {
    simulation: AnySimulation,
    /// Positions and velocities at construction.
    start: [RecordedRows; 2],
    /// Exception raised by a callable of a mechanism.
    raised: Raised,
    /// Warnings already issued; each is issued once.
    warned: Vec<String>,
    /// Number of tooth jumps already warned of.
    jumps_warned: usize,
}

#[pymethods]
impl Core {
    #[new]
    #[pyo3(signature = (scene, positions, velocities, surfaces=Vec::new()))]
    #[allow(clippy::needless_pass_by_value)] // PyO3 passes arrays by value
    fn new(
        scene: &Bound<'_, PyAny>,
        positions: Option<PyReadonlyArray2<'_, f64>>,
        velocities: Option<PyReadonlyArray2<'_, f64>>,
        surfaces: Vec<[usize; 3]>,
    ) -> PyResult<Self> {
        let py = scene.py();
        let scene = DriveScene::new(scene, (positions.as_ref(), velocities.as_ref(), surfaces))?;
        let start = scene.own_or_generated_start(py)?;
        let (simulation, start) = contained(|| {
            let model = Model::compile(&scene.drive, &scene.laws, &start)?;
            let simulation = Simulation::new(Arc::new(model), &start, scene.control)?;
            Ok((simulation, [start.positions, start.velocities]))
        })?;
        Ok(Self::of(
            AnySimulation::Drive(simulation),
            start,
            Raised::default(),
        ))
    }

    #[getter]
    fn body_names(&self) -> Vec<String> {
        self.simulation.body_names()
    }

    /// Return the names of the joints of a mechanism; none for a drive.
    #[getter]
    fn joint_names(&self) -> Vec<String> {
        let mechanism = self.simulation.mechanism();
        mechanism.map_or(Vec::new(), |mechanism| mechanism.model().joint_names())
    }

    /// Return the names of the contacts of a mechanism; none for a drive.
    #[getter]
    fn contact_names(&self) -> Vec<String> {
        let contacts = |mechanism: &MechanismSimulation| mechanism.model().contact_names().to_vec();
        self.simulation.mechanism().map_or(Vec::new(), contacts)
    }

    #[getter]
    fn time(&self) -> f64 {
        self.simulation.time()
    }

    #[getter]
    fn positions<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(py, self.simulation.positions())
    }

    #[getter]
    fn velocities<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(py, self.simulation.velocities())
    }

    /// Return the result of the assembly of a mechanism.
    fn check<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let mechanism = self.simulation.mechanism().ok_or_else(|| {
            let value = "of a chain drive";
            Error::invalid("simulation", value, "expected one of a mechanism")
        })?;
        assembly(py, mechanism.assembly())
    }

    /// Return the complete state of the run.
    fn state<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let snapshot = self.simulation.state()?;
        let state = PyDict::new(py);
        state.set_item("time", self.simulation.time())?;
        state.set_item("positions", self.positions(py)?)?;
        state.set_item("velocities", self.velocities(py)?)?;
        if let AnySimulation::Drive(simulation) = &self.simulation {
            set_contact_memory(py, simulation.dynamics(), &state)?;
        }
        state.set_item("snapshot", PyBytes::new(py, &snapshot))?;
        Ok(state)
    }

    /// Return the same simulation in the state of a snapshot.
    fn restored(&self, snapshot: &[u8]) -> PyResult<Self> {
        let mut simulation = self.simulation.clone();
        simulation.restore(snapshot)?;
        let mut core = Self::of(simulation, self.start.clone(), Arc::clone(&self.raised));
        core.jumps_warned = core.jumps().len();
        core.warned.clone_from(&self.warned);
        Ok(core)
    }

    /// Return positions and velocities at construction.
    fn start<'py>(&self, py: Python<'py>) -> PyResult<[Bound<'py, PyArray2<f64>>; 2]> {
        let [positions, velocities] = self.start.clone();
        Ok([table(py, positions)?, table(py, velocities)?])
    }

    #[allow(clippy::needless_pass_by_value)] // PyO3 passes arrays by value
    fn evaluate<'py>(
        &mut self,
        py: Python<'py>,
        positions: Option<PyReadonlyArray2<'py, f64>>,
        velocities: Option<PyReadonlyArray2<'py, f64>>,
        time: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let positions = rows("positions", positions.as_ref())?;
        let velocities = rows("velocities", velocities.as_ref())?;
        let time = time.map(|t| describe::finite(t, "time", "s")).transpose()?;
        let (places, speeds) = (positions.as_deref(), velocities.as_deref());
        match &mut self.simulation {
            AnySimulation::Drive(simulation) => {
                for (name, given) in [("positions", places), ("velocities", speeds)] {
                    if let Some(given) = given {
                        check_rows(simulation.model(), name, given)?;
                    }
                }
                drive_evaluation(py, &simulation.evaluate_elsewhere(places, speeds, time))
            }
            AnySimulation::Mechanism(simulation) => {
                let row = simulation.evaluate_elsewhere(places, speeds, time);
                take(&self.raised)?;
                mechanism_evaluation(py, row?)
            }
        }
    }

    #[pyo3(signature = (duration, report_step, groups=None, energy=None))]
    #[allow(clippy::needless_pass_by_value)] // PyO3 passes lists by value
    fn start_recording(
        &mut self,
        duration: &Bound<'_, PyAny>,
        report_step: &Bound<'_, PyAny>,
        groups: Option<Vec<String>>,
        energy: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let (duration, report_step, energy) = describe::reports(duration, report_step, energy)?;
        match &mut self.simulation {
            AnySimulation::Drive(simulation) => {
                let groups = describe::drive_groups(&groups.unwrap_or_default(), energy);
                simulation.start_recording(duration, report_step, groups);
            }
            AnySimulation::Mechanism(simulation) => {
                let groups = describe::mechanism_groups(groups.as_deref(), energy);
                simulation.start_recording(duration, report_step, groups);
            }
        }
        Ok(())
    }

    fn advance(&mut self, py: Python<'_>, wall_budget: f64) -> PyResult<bool> {
        self.moved(py, |simulation| simulation.record(budget(wall_budget)))
    }

    /// Make `advance` return after each report.
    fn pause_at_reports(&mut self) {
        self.simulation.pause_at_reports();
    }

    /// Return the number of rows in the recording, without those that were taken from it.
    #[getter]
    fn rows(&self) -> usize {
        let recording = self.simulation.recording();
        recording.map_or(0, |recording| recording.time.len())
    }

    /// Return the last row of a channel, flat.
    fn last_row<'py>(&self, py: Python<'py>, name: &str) -> Option<Bound<'py, PyArray1<f64>>> {
        let row = self.simulation.recording()?.last_row(name)?;
        Some(PyArray1::from_slice(py, row))
    }

    /// Set the speed ("speed") or torque ("torque") of a part from the present time on: of a sprocket, numbered from 1, or of the driver
    /// or torque of a mechanism, by its name; or the force of the tensioner (`"tensioner_force"`) of a sprocket.
    fn set_input(
        &mut self,
        part: &Bound<'_, PyAny>,
        quantity: &str,
        value: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let (quantity, signal) = input(quantity, value)?;
        let outcome = match &mut self.simulation {
            AnySimulation::Drive(simulation) => {
                simulation.set_input(part.extract::<usize>()?.wrapping_sub(1), quantity, signal)
            }
            AnySimulation::Mechanism(simulation) => {
                simulation.set_input(part.extract()?, quantity, signal)
            }
        };
        Ok(outcome?)
    }

    fn take_recording<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        recorded(py, self.simulation.take_recording())
    }

    /// Remove the first `count` rows of the recording, or all of them, and return them; the recording continues.
    fn take_rows<'py>(&mut self, py: Python<'py>, count: usize) -> PyResult<Bound<'py, PyDict>> {
        recorded(py, self.simulation.take_rows(count))
    }

    fn step_to(
        &mut self,
        py: Python<'_>,
        t: &Bound<'_, PyAny>,
        wall_budget: f64,
    ) -> PyResult<bool> {
        let t = describe::finite(t, "t", "s")?;
        let now = self.simulation.time();
        if t < now {
            let expected = format!("must not lie before the present time, {now} s");
            return Err(Error::invalid("t", t, expected).into());
        }
        self.moved(py, |simulation| simulation.advance(t, budget(wall_budget)))
    }

    fn stats<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        statistics(py, &self.simulation.statistics())
    }

    /// Return times \[s\], sprockets (from 1) and directions of all tooth jumps so far; none for a mechanism, which does not count them.
    #[allow(clippy::type_complexity)] // three columns
    fn tooth_jumps<'py>(
        &self,
        py: Python<'py>,
    ) -> Option<(
        Bound<'py, PyArray1<f64>>,
        Bound<'py, PyArray1<i64>>,
        Bound<'py, PyArray1<i64>>,
    )> {
        let AnySimulation::Drive(simulation) = &self.simulation else {
            return None;
        };
        let jumps = simulation.tooth_jumps();
        let column = |value: fn(&ToothJump) -> i64| {
            let values: Vec<i64> = jumps.iter().map(value).collect();
            values.into_pyarray(py)
        };
        let times: Vec<f64> = jumps.iter().map(|jump| jump.time).collect();
        Some((
            times.into_pyarray(py),
            #[allow(clippy::cast_possible_wrap)] // sprockets are few
            column(|jump| jump.sprocket as i64 + 1),
            column(|jump| jump.direction.into()),
        ))
    }

    /// Return the warnings not issued yet: law warnings, energy warnings, tooth jumps.
    pub(super) fn take_warnings(&mut self) -> (Vec<String>, Vec<String>, Vec<String>) {
        let balance = self.simulation.balance_note().map(str::to_string);
        let range = self.simulation.range_notes();
        let mut new = |notes: Vec<String>| {
            let new: Vec<String> = notes
                .into_iter()
                .filter(|note| !self.warned.contains(note))
                .collect();
            self.warned.extend_from_slice(&new);
            new
        };
        let (range, balance) = (new(range), new(balance.into_iter().collect()));
        let jumps = self.jumps().split_at(self.jumps_warned).1;
        let jumped = describe_tooth_jumps(jumps).into_iter().collect();
        self.jumps_warned += jumps.len();
        (range, balance, jumped)
    }
}

impl Core {
    pub(super) fn of(simulation: AnySimulation, start: [RecordedRows; 2], raised: Raised) -> Self {
        Self {
            simulation,
            start,
            raised,
            warned: Vec::new(),
            jumps_warned: 0,
        }
    }

    fn jumps(&self) -> &[ToothJump] {
        match &self.simulation {
            AnySimulation::Drive(simulation) => simulation.tooth_jumps(),
            AnySimulation::Mechanism(_) => &[],
        }
    }

    /// Integrate with the interpreter released. An exception of a callable takes precedence over the error that it caused.
    fn moved(
        &mut self,
        py: Python<'_>,
        steps: impl FnOnce(&mut AnySimulation) -> Result<bool> + Send,
    ) -> PyResult<bool> {
        // An exception from an earlier evaluation does not belong to these steps.
        drop(take(&self.raised));
        let simulation = &mut self.simulation;
        let outcome = py.detach(|| steps(simulation));
        take(&self.raised)?;
        Ok(outcome?)
    }
}

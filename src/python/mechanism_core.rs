//! A run of a mechanism as Python sees it.

use std::sync::Arc;

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use super::core::{budget, rows, table};
use super::describe;
use super::errors::to_python;
use super::mechanism::mechanism;
use super::mechanism_arrays::arrays;
use super::mechanism_callable::Raised;
use crate::error::{Error, Result};
use crate::integrator::StepControl;
use crate::multibody::{Mechanism, MechanismModel, Stabilisation};
use crate::panics::contained;
use crate::run::mechanism::{MechanismSimulation, MechanismSnapshot};
use crate::run::simulation::check_reports;

/// A compiled mechanism, its state and its integrator.
#[pyclass(module = "rustchain._rustchain", subclass)]
pub(super) struct MechanismCore {
    pub(super) simulation: MechanismSimulation,
    raised: Raised,
    /// Whether the energy balance was warned of.
    warned: bool,
}

#[pymethods]
impl MechanismCore {
    #[new]
    fn new(
        mechanism: &Bound<'_, PyAny>,
        solver: &Bound<'_, PyAny>,
        baumgarte: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let py = mechanism.py();
        let raised = Raised::default();
        let description = self::mechanism(mechanism, &raised)?;
        let control = describe::solver(solver)?;
        let stabilisation = match baumgarte {
            None => Stabilisation::Projection,
            Some(value) => {
                let frequency = describe::finite(value, "baumgarte", "rad/s")?;
                describe::checked(
                    py,
                    crate::error::check::not_negative("baumgarte", frequency, "rad/s"),
                )?;
                Stabilisation::Baumgarte(frequency)
            }
        };
        Self::assembled(py, &description, control, stabilisation, raised)
    }

    #[getter]
    fn body_names(&self) -> Vec<String> {
        self.simulation.model().body_names()
    }

    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.simulation.model().joint_names()
    }

    #[getter]
    fn contact_names(&self) -> Vec<String> {
        self.simulation.model().contact_names().to_vec()
    }

    #[getter]
    fn time(&self) -> f64 {
        self.simulation.time()
    }

    #[getter]
    fn positions<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(py, self.simulation.motion(false))
    }

    #[getter]
    fn velocities<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(py, self.simulation.motion(true))
    }

    /// What assembling found.
    fn check<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let assembly = self.simulation.assembly();
        let found = PyDict::new(py);
        found.set_item("degrees_of_freedom", assembly.degrees_of_freedom)?;
        found.set_item("redundant", &assembly.redundant)?;
        found.set_item("moved", assembly.moved)?;
        found.set_item("turned", assembly.turned)?;
        found.set_item("velocity_change", assembly.velocity_change)?;
        found.set_item("spin_change", assembly.spin_change)?;
        found.set_item("warnings", &assembly.warnings)?;
        Ok(found)
    }

    /// The complete state, and what of it is worth a look.
    pub(super) fn state<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        describe::checked(py, self.simulation.check_intact())?;
        let state = PyDict::new(py);
        state.set_item("time", self.simulation.time())?;
        state.set_item("positions", self.positions(py)?)?;
        state.set_item("velocities", self.velocities(py)?)?;
        let snapshot = describe::checked(py, self.simulation.snapshot().to_bytes())?;
        state.set_item("snapshot", PyBytes::new(py, &snapshot))?;
        Ok(state)
    }

    /// The same simulation in another state.
    fn restored(&self, py: Python<'_>, snapshot: &[u8]) -> PyResult<Self> {
        self.in_state(py, snapshot)
    }

    /// Accelerations, reactions and contacts of a state.
    #[allow(clippy::needless_pass_by_value)] // PyO3 hands arrays over
    fn evaluate<'py>(
        &mut self,
        py: Python<'py>,
        positions: Option<PyReadonlyArray2<'py, f64>>,
        velocities: Option<PyReadonlyArray2<'py, f64>>,
        time: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let positions = rows(py, "positions", positions.as_ref())?;
        let velocities = rows(py, "velocities", velocities.as_ref())?;
        let time = time.map(|t| describe::finite(t, "time", "s")).transpose()?;
        let there =
            self.simulation
                .evaluate_elsewhere(positions.as_deref(), velocities.as_deref(), time);
        take(&self.raised)?;
        let there = describe::checked(py, there)?;
        let (row, forces) = (there.row(), there.contact_forces());
        let model = self.simulation.model();
        let (bodies, joints) = (model.body_names().len(), model.joint_names().len());
        let found = PyDict::new(py);
        let set = |name: &str, values: Vec<f64>, rows: usize| {
            found.set_item(name, values.into_pyarray(py).reshape([rows, 3])?)
        };
        set("accelerations", row.accelerations, bodies)?;
        set("joint_reaction", row.reactions, joints)?;
        found.set_item("contact_force", row.contact_force.into_pyarray(py))?;
        found.set_item("contact_penetration", row.penetration.into_pyarray(py))?;
        found.set_item(
            "contact_force_vector",
            forces
                .concat()
                .into_pyarray(py)
                .reshape([forces.len(), 2])?,
        )?;
        found.set_item("contact_gap", row.contact_gap.into_pyarray(py))?;
        found.set_item("contact_region", row.contact_region.into_pyarray(py))?;
        Ok(found)
    }

    /// What was not warned of yet of the energy balance.
    fn take_warnings(&mut self) -> Option<String> {
        self.balance_warning(true)
    }

    fn start_recording(
        &mut self,
        duration: &Bound<'_, PyAny>,
        report_step: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let py = duration.py();
        let duration = describe::number(duration, "duration", "s")?;
        let report_step = describe::number(report_step, "report_step", "s")?;
        describe::checked(py, check_reports(duration, report_step))?;
        self.simulation.start_recording(duration, report_step);
        Ok(())
    }

    fn advance(&mut self, py: Python<'_>, wall_budget: f64) -> PyResult<bool> {
        self.forget_raised();
        let simulation = &mut self.simulation;
        let outcome = py.detach(|| simulation.record(budget(wall_budget)));
        self.outcome(py, outcome)
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
            return Err(to_python(py, &Error::invalid("t", t, expected)));
        }
        self.forget_raised();
        let simulation = &mut self.simulation;
        let outcome = py.detach(|| simulation.advance(t, budget(wall_budget)));
        self.outcome(py, outcome)
    }

    /// Makes `advance` return after each report.
    fn pause_at_reports(&mut self) {
        self.simulation.pause_at_reports();
    }

    /// Number of rows recorded so far.
    #[getter]
    fn rows(&self) -> usize {
        self.simulation.recording().time.len()
    }

    /// The last row of the largest forces since the row before, of joints and contacts.
    fn last_peaks<'py>(&self, py: Python<'py>) -> [Bound<'py, PyArray1<f64>>; 2] {
        let (model, recording) = (self.simulation.model(), self.simulation.recording());
        let row = |values: &[f64], length: usize| {
            PyArray1::from_slice(py, &values[values.len().saturating_sub(length)..])
        };
        [
            row(&recording.peak_joint_force, model.joint_names().len()),
            row(&recording.peak_contact_force, model.contact_names().len()),
        ]
    }

    fn take_recording<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let recording = self.simulation.take_recording();
        arrays(py, recording, self.simulation.model())
    }

    fn stats<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let counts = self.simulation.counts();
        let stats = PyDict::new(py);
        stats.set_item("steps", counts.steps)?;
        stats.set_item("rejected", counts.rejected)?;
        stats.set_item("evaluations", counts.evaluations)?;
        stats.set_item("onsets", self.simulation.onsets())?;
        Ok(stats)
    }
}

impl MechanismCore {
    /// The run of `mechanism`, assembled; callables have left what they raise in `raised`.
    pub(super) fn assembled(
        py: Python<'_>,
        mechanism: &Mechanism,
        control: StepControl,
        stabilisation: Stabilisation,
        raised: Raised,
    ) -> PyResult<Self> {
        let made = contained(|| {
            let model = MechanismModel::compile(mechanism)?;
            let give_up = || interrupted(py, &raised);
            MechanismSimulation::new_unless(Arc::new(model), control, stabilisation, &give_up)
        });
        take(&raised)?;
        Ok(Self {
            simulation: describe::checked(py, made)?,
            raised,
            warned: false,
        })
    }

    /// The same run in another state.
    pub(super) fn in_state(&self, py: Python<'_>, snapshot: &[u8]) -> PyResult<Self> {
        let snapshot = describe::checked(py, MechanismSnapshot::from_bytes(snapshot))?;
        let mut simulation = self.simulation.clone();
        describe::checked(py, simulation.restore(&snapshot))?;
        Ok(Self {
            simulation,
            raised: Arc::clone(&self.raised),
            warned: self.warned,
        })
    }

    /// What was not warned of yet of the energy balance, where that is `wanted`.
    pub(super) fn balance_warning(&mut self, wanted: bool) -> Option<String> {
        let new = wanted && !self.warned;
        let note = self.simulation.balance_note().filter(|_| new)?;
        let note = note.to_string();
        self.warned = true;
        Some(note)
    }

    /// What a callable raised when a state was looked at is not of the steps to come.
    fn forget_raised(&self) {
        drop(take(&self.raised));
    }

    /// What a callable has raised goes before what came of it.
    fn outcome(&self, py: Python<'_>, outcome: Result<bool>) -> PyResult<bool> {
        take(&self.raised)?;
        describe::checked(py, outcome)
    }
}

/// Whether Ctrl-C was pressed, which is then what was raised.
fn interrupted(py: Python<'_>, raised: &Raised) -> bool {
    let Err(error) = py.check_signals() else {
        return false;
    };
    if let Ok(mut slot) = raised.lock() {
        *slot = Some(error);
    }
    true
}

fn take(raised: &Raised) -> PyResult<()> {
    match raised.lock().ok().and_then(|mut slot| slot.take()) {
        Some(error) => Err(error),
        None => Ok(()),
    }
}

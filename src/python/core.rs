//! A run as Python sees it.

use std::sync::Arc;
use std::time::Duration;

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use super::describe;
use super::errors::to_python;
use crate::chain::contact::ToothJump;
use crate::chain::dynamics::Dynamics;
use crate::chain::model::{Model, Quantity};
use crate::drive::Drive;
use crate::error::Error;
use crate::layout::InitialConfiguration;
use crate::panics::contained;
use crate::run::recorder::{Recording, Values};
use crate::run::simulation::{Simulation, Snapshot, check_rows};

/// A compiled model, its state and its integrator.
#[pyclass(module = "rustchain._rustchain")]
pub(super) struct Core {
    simulation: Simulation,
    /// What was warned of, so that each is said once.
    warned: Vec<String>,
    /// How many tooth jumps were warned of.
    jumps_warned: usize,
}

pub(super) type Rows = Vec<[f64; 3]>;

#[pymethods]
impl Core {
    #[new]
    #[allow(clippy::needless_pass_by_value, clippy::too_many_arguments)] // keywords in Python; PyO3 hands arrays over
    fn new(
        drive: &Bound<'_, PyAny>,
        force_law: &Bound<'_, PyAny>,
        hinge_law: Option<&Bound<'_, PyAny>>,
        tooth_law: Option<&Bound<'_, PyAny>>,
        min_impact_velocity: &Bound<'_, PyAny>,
        solver: &Bound<'_, PyAny>,
        positions: Option<PyReadonlyArray2<'_, f64>>,
        velocities: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Self> {
        let py = drive.py();
        let description = describe::drive(drive)?;
        let laws = describe::force_laws(force_law, hinge_law, tooth_law, min_impact_velocity)?;
        let control = describe::solver(solver)?;
        let own = own_start(py, &description, positions.as_ref(), velocities.as_ref())?;
        let simulation = contained(|| {
            let start = match own {
                Some(start) => start,
                None => InitialConfiguration::generate(&description)?.0,
            };
            let model = Model::compile(&description, &laws, &start)?;
            Simulation::new(Arc::new(model), &start, control)
        });
        describe::checked(py, simulation).map(Self::from)
    }

    #[getter]
    fn body_names(&self) -> Vec<String> {
        self.simulation.model().body_names()
    }

    #[getter]
    fn time(&self) -> f64 {
        self.simulation.time()
    }

    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(py, self.simulation.motion().positions())
    }

    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(py, self.simulation.motion().velocities())
    }

    /// All that decides how the run goes on.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (model, dynamics) = (self.simulation.model(), self.simulation.dynamics());
        let (memory, parted) = (&dynamics.memory, dynamics.parted());
        describe::checked(py, self.simulation.check_intact())?;
        let state = PyDict::new(py);
        state.set_item("time", self.simulation.time())?;
        state.set_item("positions", self.positions(py)?)?;
        state.set_item("velocities", self.velocities(py)?)?;
        state.set_item(
            "hinge_onset_speed",
            memory.hinge_speed().to_vec().into_pyarray(py),
        )?;
        state.set_item(
            "tooth_onset_speed",
            by_bushing(model, |pair| memory.tooth_speed[pair])
                .into_pyarray(py)
                .reshape([model.links, model.sprockets.len()])?,
        )?;
        state.set_item(
            "tooth_onset_surface",
            by_bushing(model, |pair| i32::from(memory.tooth_surface[pair].0))
                .into_pyarray(py)
                .reshape([model.links, model.sprockets.len()])?,
        )?;
        if model.rollers.is_some() {
            let speeds = memory.roller_speed().to_vec();
            state.set_item("roller_onset_speed", speeds.into_pyarray(py))?;
            let parted = dynamics.parted_rollers();
            state.set_item("parted_rollers", parted.into_pyarray(py))?;
        }
        state.set_item("parted_hinges", parted.0.into_pyarray(py))?;
        state.set_item("parted_tooth_pairs", parted.1.into_pyarray(py))?;
        let snapshot = describe::checked(py, self.simulation.snapshot().to_bytes())?;
        state.set_item("snapshot", PyBytes::new(py, &snapshot))?;
        Ok(state)
    }

    /// The same simulation in another state: its snapshot.
    fn restored(&self, py: Python<'_>, snapshot: &[u8]) -> PyResult<Self> {
        let snapshot = describe::checked(py, Snapshot::from_bytes(snapshot))?;
        let mut simulation = self.simulation.clone();
        describe::checked(py, simulation.restore(&snapshot))?;
        Ok(Self {
            jumps_warned: simulation.tooth_jumps().len(),
            simulation,
            warned: self.warned.clone(),
        })
    }

    /// Positions and velocities that the simulation was made with.
    fn start<'py>(&self, py: Python<'py>) -> PyResult<[Bound<'py, PyArray2<f64>>; 2]> {
        let start = self.simulation.start();
        Ok([
            table(py, start.positions.clone())?,
            table(py, start.velocities.clone())?,
        ])
    }

    #[allow(clippy::needless_pass_by_value)] // PyO3 hands arrays over
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        positions: Option<PyReadonlyArray2<'py, f64>>,
        velocities: Option<PyReadonlyArray2<'py, f64>>,
        time: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let positions = rows(py, "positions", positions.as_ref())?;
        let velocities = rows(py, "velocities", velocities.as_ref())?;
        for (name, given) in [("positions", &positions), ("velocities", &velocities)] {
            if let Some(given) = given {
                describe::checked(py, check_rows(self.simulation.model(), name, given))?;
            }
        }
        let time = time.map(|t| describe::finite(t, "time", "s")).transpose()?;
        let dynamics =
            self.simulation
                .evaluate_elsewhere(positions.as_deref(), velocities.as_deref(), time);
        evaluation(py, &dynamics)
    }

    #[allow(clippy::needless_pass_by_value)] // PyO3 hands lists over
    fn start_recording(
        &mut self,
        duration: &Bound<'_, PyAny>,
        report_step: &Bound<'_, PyAny>,
        groups: Vec<String>,
        energy: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let (duration, report_step, groups) =
            describe::reports(duration, report_step, &groups, energy)?;
        self.simulation
            .start_recording(duration, report_step, groups);
        Ok(())
    }

    fn advance(&mut self, py: Python<'_>, wall_budget: f64) -> PyResult<bool> {
        let outcome = py.detach(|| self.simulation.record(budget(wall_budget)));
        describe::checked(py, outcome)
    }

    /// Makes `advance` return after each report.
    fn pause_at_reports(&mut self) {
        self.simulation.pause_at_reports();
    }

    /// Number of rows recorded so far.
    #[getter]
    fn rows(&self) -> usize {
        let recording = self.simulation.recording();
        recording.map_or(0, |recording| recording.time.len())
    }

    /// The last row of a channel, flat.
    fn last_row<'py>(&self, py: Python<'py>, name: &str) -> Option<Bound<'py, PyArray1<f64>>> {
        let recording = self.simulation.recording()?;
        let channel = recording.channels.iter().find(|c| c.name == name)?;
        let Values::Real(values) = &channel.values else {
            return None;
        };
        let length: usize = channel.row_shape.iter().product();
        let row = values.len().checked_sub(length)?;
        Some(PyArray1::from_slice(py, &values[row..]))
    }

    /// Lets a sprocket, by its number from 1, have another speed ("speed") or torque ("torque") from now on.
    fn set_input(
        &mut self,
        sprocket: usize,
        quantity: &str,
        value: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let (quantity, unit) = match quantity {
            "speed" => (Quantity::Speed, "rad/s"),
            _ => (Quantity::Torque, "N m"),
        };
        let name = if unit == "N m" { "torque" } else { "speed" };
        let signal = describe::signal(value, name, unit)?;
        let outcome = self
            .simulation
            .set_input(sprocket.wrapping_sub(1), quantity, signal);
        describe::checked(value.py(), outcome)
    }

    fn take_recording<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        set_channels(py, self.simulation.take_recording())
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
            return Err(to_python(
                py,
                &Error::invalid(
                    "t",
                    t,
                    format!("must not lie before the present time, {now} s"),
                ),
            ));
        }
        let outcome = py.detach(|| self.simulation.advance(t, budget(wall_budget)));
        describe::checked(py, outcome)
    }

    fn stats<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let statistics = self.simulation.statistics();
        let stats = PyDict::new(py);
        stats.set_item("steps", statistics.counts.steps)?;
        stats.set_item("rejected", statistics.counts.rejected)?;
        stats.set_item("evaluations", statistics.counts.evaluations)?;
        stats.set_item("meter_evaluations", statistics.meter_evaluations)?;
        stats.set_item("jacobians", statistics.counts.jacobians)?;
        stats.set_item("onsets", statistics.onsets)?;
        stats.set_item("onsets_at_floor", statistics.onsets_at_floor)?;
        stats.set_item("unseen_touches", statistics.unseen_touches)?;
        stats.set_item("wall_stepping", statistics.wall_stepping)?;
        stats.set_item("wall_onsets", statistics.wall_onsets)?;
        stats.set_item("wall_reports", statistics.wall_reports)?;
        Ok(stats)
    }

    /// Times \[s\], sprockets (from 1) and directions of all tooth jumps so far.
    #[allow(clippy::type_complexity)] // three columns
    fn tooth_jumps<'py>(
        &self,
        py: Python<'py>,
    ) -> (
        Bound<'py, PyArray1<f64>>,
        Bound<'py, PyArray1<i64>>,
        Bound<'py, PyArray1<i64>>,
    ) {
        let jumps = self.simulation.tooth_jumps();
        let column = |value: fn(&ToothJump) -> i64| {
            let values: Vec<i64> = jumps.iter().map(value).collect();
            values.into_pyarray(py)
        };
        let times: Vec<f64> = jumps.iter().map(|jump| jump.time).collect();
        (
            times.into_pyarray(py),
            #[allow(clippy::cast_possible_wrap)] // sprockets are few
            column(|jump| jump.sprocket as i64 + 1),
            column(|jump| jump.direction.into()),
        )
    }

    /// What was not warned of yet: laws that left their range; the energy balance; tooth jumps.
    fn take_warnings(&mut self) -> (Vec<String>, Vec<String>, Vec<String>) {
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
        let jumps = self.simulation.tooth_jumps().split_at(self.jumps_warned).1;
        let jumped = describe_tooth_jumps(jumps).into_iter().collect();
        self.jumps_warned += jumps.len();
        (range, balance, jumped)
    }
}

impl From<Simulation> for Core {
    fn from(simulation: Simulation) -> Self {
        Self {
            simulation,
            warned: Vec::new(),
            jumps_warned: 0,
        }
    }
}

/// The arrays of a recording by their names, time first.
pub(super) fn set_channels(py: Python<'_>, recording: Recording) -> PyResult<Bound<'_, PyDict>> {
    let rows = recording.time.len();
    let arrays = PyDict::new(py);
    arrays.set_item("time", recording.time.into_pyarray(py))?;
    for channel in recording.channels {
        let shape: Vec<usize> = std::iter::once(rows).chain(channel.row_shape).collect();
        match channel.values {
            Values::Real(values) => {
                arrays.set_item(channel.name, values.into_pyarray(py).reshape(shape)?)?;
            }
            Values::Whole(values) => {
                arrays.set_item(channel.name, values.into_pyarray(py).reshape(shape)?)?;
            }
        }
    }
    Ok(arrays)
}

/// Tooth jumps in words: how many, and the first; nothing where there are none.
fn describe_tooth_jumps(jumps: &[ToothJump]) -> Option<String> {
    let first = jumps.first()?;
    let teeth = if jumps.len() == 1 { "tooth" } else { "teeth" };
    let (number, time) = (first.sprocket + 1, first.time);
    Some(format!(
        "the chain jumped {} {teeth}, first on sprocket {number} at t = {time:.6} s: outputs that need a \
         seated chain do not hold there; raise the pretension or lower the load, see Result.tooth_jumps",
        jumps.len()
    ))
}

/// A start of the caller's own; of velocities alone, with the generated positions. `None` where nothing is given.
pub(super) fn own_start(
    py: Python<'_>,
    drive: &Drive,
    positions: Option<&PyReadonlyArray2<'_, f64>>,
    velocities: Option<&PyReadonlyArray2<'_, f64>>,
) -> PyResult<Option<InitialConfiguration>> {
    let positions = rows(py, "positions", positions)?;
    let velocities = rows(py, "velocities", velocities)?;
    match (positions, velocities) {
        (None, None) => Ok(None),
        (Some(positions), Some(velocities)) => Ok(Some(InitialConfiguration {
            positions,
            velocities,
        })),
        (None, Some(velocities)) => {
            let generated = contained(|| InitialConfiguration::generate(drive));
            let (generated, _) = describe::checked(py, generated)?;
            Ok(Some(InitialConfiguration {
                positions: generated.positions,
                velocities,
            }))
        }
        (Some(_), None) => Err(to_python(
            py,
            &Error::invalid("velocities", "None", "must be given when positions are"),
        )),
    }
}

pub(super) fn budget(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX)
}

/// Rows of three numbers, one a body.
pub(super) fn rows(
    py: Python<'_>,
    field: &str,
    array: Option<&PyReadonlyArray2<'_, f64>>,
) -> PyResult<Option<Rows>> {
    let Some(array) = array else { return Ok(None) };
    let array = array.as_array();
    if array.ncols() != 3 {
        return Err(to_python(
            py,
            &Error::invalid(
                field,
                format!("an array of shape ({}, {})", array.nrows(), array.ncols()),
                "must have three columns (x, y, theta)",
            ),
        ));
    }
    Ok(Some(
        array
            .rows()
            .into_iter()
            .map(|r| [r[0], r[1], r[2]])
            .collect(),
    ))
}

pub(super) fn table(py: Python<'_>, rows: Rows) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let count = rows.len();
    rows.into_iter()
        .flatten()
        .collect::<Vec<f64>>()
        .into_pyarray(py)
        .reshape([count, 3])
}

/// Values over (bushings, sprockets) from values over pairs.
fn by_bushing<T>(model: &Model, value: impl Fn(usize) -> T) -> Vec<T> {
    let (links, sprockets) = (model.links, model.sprockets.len());
    (0..links)
        .flat_map(|k| (0..sprockets).map(move |s| s * links + k))
        .map(value)
        .collect()
}

#[allow(clippy::cast_possible_wrap)] // gaps are few
fn evaluation<'py>(py: Python<'py>, dynamics: &Dynamics) -> PyResult<Bound<'py, PyDict>> {
    let model = dynamics.model();
    let (links, sprockets) = (model.links, model.sprockets.len());
    let (hinges, teeth, a) = (&dynamics.hinges, &dynamics.teeth, &dynamics.accelerations);
    let near = |pair: usize| teeth.penetration[pair] > f64::NEG_INFINITY;
    let accelerations = (0..model.bodies())
        .map(|i| [a.x[i], a.y[i], a.angle[i]])
        .collect();
    let shape = [links, sprockets];
    let found = PyDict::new(py);
    found.set_item("accelerations", table(py, accelerations)?)?;
    found.set_item("hinge_force", hinges.force.clone().into_pyarray(py))?;
    found.set_item(
        "hinge_penetration",
        hinges.penetration.clone().into_pyarray(py),
    )?;
    let on_pins: Vec<f64> = (0..links)
        .flat_map(|k| <[f64; 2]>::from(hinges.force_on_pin(k)))
        .collect();
    found.set_item(
        "hinge_force_vector",
        on_pins.into_pyarray(py).reshape([links, 2])?,
    )?;
    if model.rollers.is_some() {
        let rollers = &dynamics.rollers;
        found.set_item("roller_force", rollers.force.clone().into_pyarray(py))?;
        let depths = rollers.penetration.clone();
        found.set_item("roller_penetration", depths.into_pyarray(py))?;
        let on_rollers: Vec<f64> = (0..links)
            .flat_map(|k| <[f64; 2]>::from(rollers.force_on_roller(k)))
            .collect();
        let on_rollers = on_rollers.into_pyarray(py).reshape([links, 2])?;
        found.set_item("roller_force_vector", on_rollers)?;
    }
    let real =
        |value: &dyn Fn(usize) -> f64| by_bushing(model, value).into_pyarray(py).reshape(shape);
    found.set_item(
        "tooth_force",
        real(&|p| if near(p) { teeth.force[p] } else { 0.0 })?,
    )?;
    found.set_item("tooth_penetration", real(&|p| teeth.penetration[p])?)?;
    let vectors: Vec<f64> = by_bushing(model, |p| {
        if near(p) {
            <[f64; 2]>::from(teeth.force_on_bushing(p))
        } else {
            [0.0; 2]
        }
    })
    .into_iter()
    .flatten()
    .collect();
    found.set_item(
        "tooth_force_vector",
        vectors.into_pyarray(py).reshape([links, sprockets, 2])?,
    )?;
    let bent = &dynamics.bristles.deflection;
    let places = &model.bristles;
    let first = |range: &std::ops::Range<usize>| range.start - places.hinges.start;
    if !places.hinges.is_empty() {
        let hinges = bent[..links].to_vec();
        found.set_item("hinge_bristle", hinges.into_pyarray(py))?;
    }
    if !places.rollers.is_empty() {
        let rollers = bent[first(&places.rollers)..][..links].to_vec();
        found.set_item("roller_bristle", rollers.into_pyarray(py))?;
    }
    if !places.teeth.is_empty() {
        let teeth = &bent[first(&places.teeth)..];
        found.set_item("tooth_bristle", real(&|p| teeth[p])?)?;
    }
    let whole =
        |value: &dyn Fn(usize) -> i32| by_bushing(model, value).into_pyarray(py).reshape(shape);
    found.set_item(
        "tooth_region",
        whole(&|p| {
            if near(p) {
                i32::from(teeth.region[p])
            } else {
                0
            }
        })?,
    )?;
    found.set_item(
        "tooth_index",
        whole(&|p| if near(p) { teeth.gap[p] as i32 } else { -1 })?,
    )?;
    Ok(found)
}

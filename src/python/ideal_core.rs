//! Simulation of a drive with ideal hinges, for Python: its mechanism, with the channels of a drive.

use std::sync::Arc;

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arrays::{recorded, rows, table};
use super::core::{Core, input};
use super::describe;
use super::drive_mechanism::drive_contacts;
use super::errors::InvalidInput;
use super::mechanism_callable::Raised;
use super::starts::own_start;
use crate::chain::Groups;
use crate::error::Result;
use crate::geometry::Vec2;
use crate::layout::InitialConfiguration;
use crate::multibody::from_drive::channels::{BushingContact, DriveView};
use crate::multibody::{Mechanism, MechanismGroups, Stabilisation};
use crate::panics::contained;
use crate::run::ideal_drive::Rows;

/// Largest displacement of a given link by the assembly without a warning, over the pitch.
const FAR: f64 = 0.01;

/// Mechanism of a drive with ideal hinges, as a core of the drive.
#[pyclass(module = "rustchain._rustchain", extends = Core)]
pub(super) struct IdealCore {
    view: DriveView,
    /// Positions and velocities before assembly, which moves them by rounding.
    start: InitialConfiguration,
    groups: Groups,
    /// Warning of the assembly for a user's start.
    note: Option<String>,
}

#[pymethods]
impl IdealCore {
    #[new]
    #[allow(clippy::needless_pass_by_value, clippy::too_many_arguments)] // keywords in Python; PyO3 passes arrays by value
    fn new(
        drive: &Bound<'_, PyAny>,
        force_law: &Bound<'_, PyAny>,
        hinge_law: Option<&Bound<'_, PyAny>>,
        tooth_law: Option<&Bound<'_, PyAny>>,
        min_impact_velocity: &Bound<'_, PyAny>,
        solver: &Bound<'_, PyAny>,
        positions: Option<PyReadonlyArray2<'_, f64>>,
        velocities: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let py = drive.py();
        let description = describe::drive(drive)?;
        check_hinge_law(force_law, hinge_law)?;
        tooth_law.map_or(Ok(()), describe::without_film)?;
        let contacts = drive_contacts(tooth_law.unwrap_or(force_law), min_impact_velocity)?;
        let control = describe::solver(solver)?;
        let own = own_start(py, &description, positions.as_ref(), velocities.as_ref())?;
        let made = contained(|| Mechanism::from_drive(&description, &contacts, own.as_ref()));
        let mechanism = describe::checked(py, made)?;
        let mut core = Core::assembled(
            py,
            &mechanism,
            control,
            Stabilisation::Projection,
            Raised::default(),
        )?;
        let simulation = describe::checked(py, core.mechanism())?;
        let view = describe::checked(py, DriveView::new(&description, simulation.model()))?;
        let moved = simulation.assembly().moved;
        let far = positions.is_some() && moved > FAR * description.chain.pitch;
        let placed = &mechanism.bodies[..view.bodies()];
        let ideal = Self {
            start: InitialConfiguration {
                positions: placed.iter().map(|body| body.position).collect(),
                velocities: placed.iter().map(|body| body.velocity).collect(),
            },
            view,
            groups: Groups::default(),
            note: far.then(|| {
                format!(
                    "positions: links had to be moved by up to {moved:.3e} m to close the ideal hinges: is each link placed \
                     where its hinges meet?"
                )
            }),
        };
        Ok(PyClassInitializer::from(core).add_subclass(ideal))
    }

    /// Return the warning at the start.
    fn take_start_note(&mut self) -> Option<String> {
        self.note.take()
    }

    #[getter]
    #[allow(clippy::needless_pass_by_value)] // PyO3 passes borrowed objects by value
    fn body_names(slf: PyRef<'_, Self>) -> Vec<String> {
        let mut names = slf.as_super().body_names();
        names.truncate(slf.view.bodies());
        names
    }

    #[getter]
    fn positions<'py>(
        slf: PyRefMut<'py, Self>,
        py: Python<'py>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = own_motion(slf, false);
        table(py, describe::checked(py, rows)?)
    }

    #[getter]
    fn velocities<'py>(
        slf: PyRefMut<'py, Self>,
        py: Python<'py>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = own_motion(slf, true);
        table(py, describe::checked(py, rows)?)
    }

    /// Return positions and velocities at construction.
    fn start<'py>(&self, py: Python<'py>) -> PyResult<[Bound<'py, PyArray2<f64>>; 2]> {
        Ok([
            table(py, self.start.positions.clone())?,
            table(py, self.start.velocities.clone())?,
        ])
    }

    fn state<'py>(mut slf: PyRefMut<'py, Self>, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let bodies = slf.view.bodies();
        let core = slf.as_super();
        let state = core.state(py)?;
        for (name, velocities) in [("positions", false), ("velocities", true)] {
            let mut rows = describe::checked(py, core.mechanism())?.motion(velocities);
            rows.truncate(bodies);
            state.set_item(name, table(py, rows)?)?;
        }
        Ok(state)
    }

    /// Return the same simulation in another state.
    #[allow(clippy::needless_pass_by_value)] // PyO3 passes borrowed objects by value
    fn restored(slf: PyRef<'_, Self>, py: Python<'_>, snapshot: &[u8]) -> PyResult<Py<Self>> {
        let core = slf.as_super().restored(py, snapshot)?;
        let ideal = Self {
            view: slf.view.clone(),
            start: slf.start.clone(),
            groups: slf.groups,
            note: None,
        };
        Py::new(py, PyClassInitializer::from(core).add_subclass(ideal))
    }

    /// Return the fields of an `Evaluation`.
    #[allow(clippy::needless_pass_by_value)] // PyO3 passes arrays by value
    fn evaluate<'py>(
        mut slf: PyRefMut<'py, Self>,
        py: Python<'py>,
        positions: Option<PyReadonlyArray2<'py, f64>>,
        velocities: Option<PyReadonlyArray2<'py, f64>>,
        time: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let positions = rows(py, "positions", positions.as_ref())?;
        let velocities = rows(py, "velocities", velocities.as_ref())?;
        let time = time.map(|t| describe::finite(t, "time", "s")).transpose()?;
        let view = slf.view.clone();
        let simulation = describe::checked(py, slf.as_super().mechanism())?;
        // With given positions, no contact has an impact velocity memory.
        let given = positions.is_some();
        let mut own = |velocities: bool| {
            let mut rows = simulation.motion(velocities);
            rows.truncate(view.bodies());
            rows
        };
        let [places, rates] = if positions.is_none() && velocities.is_none() {
            [None, None]
        } else {
            let positions = positions.unwrap_or_else(|| own(false));
            let velocities = velocities.unwrap_or_else(|| own(true));
            describe::checked(py, view.with_arm(positions, velocities))?.map(Some)
        };
        let places = places.filter(|_| given);
        let there = simulation.evaluate_elsewhere(places.as_deref(), rates.as_deref(), time);
        let recording = describe::checked(py, there)?;
        evaluation(py, &view, &Rows::new(&recording, simulation.model()))
    }

    #[pyo3(signature = (duration, report_step, groups=None, energy=None))]
    #[allow(clippy::needless_pass_by_value)] // PyO3 passes lists by value
    fn start_recording(
        mut slf: PyRefMut<'_, Self>,
        duration: &Bound<'_, PyAny>,
        report_step: &Bound<'_, PyAny>,
        groups: Option<Vec<String>>,
        energy: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let py = duration.py();
        let (duration, report_step, energy) = describe::reports(duration, report_step, energy)?;
        slf.groups = describe::drive_groups(&groups.unwrap_or_default(), energy);
        let simulation = describe::checked(py, slf.as_super().mechanism())?;
        // Channels of a drive are computed from those of bodies, joints and contacts.
        let groups = MechanismGroups {
            energy,
            ..MechanismGroups::ALL
        };
        simulation.start_recording(duration, report_step, groups);
        Ok(())
    }

    /// Return the last row of a channel used by a stop condition.
    #[allow(clippy::needless_pass_by_value)] // PyO3 passes borrowed objects by value
    fn last_row<'py>(
        slf: PyRef<'py, Self>,
        py: Python<'py>,
        name: &str,
    ) -> Option<Bound<'py, PyArray1<f64>>> {
        let core = slf.as_super();
        let rows = Rows::new(core.recording()?, core.mechanism_model()?);
        let Some(row) = rows.last(&slf.view, name) else {
            return core.last_row(py, name);
        };
        Some(row.into_pyarray(py))
    }

    /// Set the speed or torque of a sprocket, numbered from 1, from the present time on.
    fn set_input(
        mut slf: PyRefMut<'_, Self>,
        part: usize,
        quantity: &str,
        value: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let py = value.py();
        let (quantity, signal) = input(quantity, value)?;
        let name = slf.view.input(part.wrapping_sub(1), quantity, &signal);
        let name = describe::checked(py, name)?;
        let simulation = describe::checked(py, slf.as_super().mechanism())?;
        describe::checked(py, simulation.set_input(&name, quantity, signal))
    }

    fn take_recording<'py>(
        mut slf: PyRefMut<'py, Self>,
        py: Python<'py>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let simulation = describe::checked(py, slf.as_super().mechanism())?;
        let recording = simulation.take_recording();
        let model = Arc::clone(simulation.model());
        let rows = Rows::new(&recording, &model);
        recorded(py, rows.channels(&slf.view, slf.groups))
    }
}

/// Return the rows of the drive's own bodies at the present time.
fn own_motion(mut slf: PyRefMut<'_, IdealCore>, velocities: bool) -> Result<Vec<[f64; 3]>> {
    let bodies = slf.view.bodies();
    let mut rows = slf.as_super().mechanism()?.motion(velocities);
    rows.truncate(bodies);
    Ok(rows)
}

/// Reject friction, film and a separate force law of hinges: ideal hinges have no contact.
fn check_hinge_law(
    force_law: &Bound<'_, PyAny>,
    hinge_law: Option<&Bound<'_, PyAny>>,
) -> PyResult<()> {
    let law = hinge_law.unwrap_or(force_law);
    let only =
        "must be None with ChainDrive.hinges = 'ideal'; only chain drives with clearance hinges";
    for (field, expected) in [
        ("friction", "have friction"),
        ("film", "have room for a film"),
    ] {
        let value = law.getattr_opt(field)?.filter(|value| !value.is_none());
        if let Some(value) = value {
            let message = format!("{field} = {}: {only} {expected}", value.repr()?);
            return Err(InvalidInput::new_err(message));
        }
    }
    if let Some(law) = hinge_law
        && law.ne(force_law)?
    {
        return Err(InvalidInput::new_err(format!(
            "hinge_law = {}: must be None with ChainDrive.hinges = 'ideal', whose hinges have no contact; it is for 'clearance'",
            law.repr()?
        )));
    }
    Ok(())
}

/// Return the fields of an `Evaluation` from a recording of one row.
fn evaluation<'py>(
    py: Python<'py>,
    view: &DriveView,
    rows: &Rows<'_>,
) -> PyResult<Bound<'py, PyDict>> {
    let row = rows.row(0);
    let shape = [view.links(), view.sprockets()];
    let contacts: Vec<BushingContact> = (0..view.links())
        .flat_map(|k| (0..view.sprockets()).map(move |s| (k, s)))
        .map(|(k, s)| view.bushing_contact(&row, k, s))
        .collect();
    let real = |value: fn(&BushingContact) -> f64| {
        let values: Vec<f64> = contacts.iter().map(value).collect();
        values.into_pyarray(py).reshape(shape)
    };
    let whole = |value: fn(&BushingContact) -> i32| {
        let values: Vec<i32> = contacts.iter().map(value).collect();
        values.into_pyarray(py).reshape(shape)
    };
    let sizes = |values: &[Vec2]| -> Vec<f64> { values.iter().map(|v| v.x.hypot(v.y)).collect() };
    let on_pins = view.on_pins(row.reactions);
    let apart = view.eccentricities(row.positions);
    let vectors: Vec<f64> = on_pins.iter().flat_map(|v| [v.x, v.y]).collect();
    let pushes: Vec<f64> = contacts.iter().flat_map(|found| found.vector).collect();
    let own = rows.accelerations()[..3 * view.bodies()].to_vec();
    let found = PyDict::new(py);
    found.set_item(
        "accelerations",
        own.into_pyarray(py).reshape([view.bodies(), 3])?,
    )?;
    found.set_item("hinge_force", sizes(&on_pins).into_pyarray(py))?;
    found.set_item("hinge_penetration", sizes(&apart).into_pyarray(py))?;
    let vectors = vectors.into_pyarray(py).reshape([view.links(), 2])?;
    found.set_item("hinge_force_vector", vectors)?;
    found.set_item("tooth_force", real(|found| found.force)?)?;
    found.set_item("tooth_penetration", real(|found| found.penetration)?)?;
    let pushes = pushes.into_pyarray(py).reshape([shape[0], shape[1], 2])?;
    found.set_item("tooth_force_vector", pushes)?;
    found.set_item("tooth_region", whole(|found| found.region)?)?;
    found.set_item("tooth_index", whole(|found| found.gap)?)?;
    Ok(found)
}

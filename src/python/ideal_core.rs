//! Simulation of a drive with ideal hinges, for Python: descriptions read, and the fields of its evaluations.

use numpy::{IntoPyArray, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arrays::table;
use super::core::Core;
use super::describe;
use super::drive_mechanism::ideal_contacts;
use super::errors::InvalidInput;
use super::evaluation::{mechanism_evaluation, put_bushing_contacts};
use super::mechanism_callable::{Raised, take};
use super::starts::{DriveScene, interrupted};
use crate::geometry::Vec2;
use crate::multibody::from_drive::channels::BushingContact;
use crate::panics::contained;
use crate::run::ideal_drive::IdealRows;
use crate::run::{AnySimulation, IdealDrive};
use crate::system::Recording;

/// Largest displacement of a given link by the assembly without a warning, over the pitch.
const FAR: f64 = 0.01;

/// Return the run of a drive with ideal hinges, and a warning of its assembly for a user's start.
#[pyfunction]
#[pyo3(signature = (scene, positions, velocities, surfaces=Vec::new()))]
#[allow(clippy::needless_pass_by_value)] // PyO3 passes arrays by value
pub(super) fn ideal_core(
    scene: &Bound<'_, PyAny>,
    positions: Option<PyReadonlyArray2<'_, f64>>,
    velocities: Option<PyReadonlyArray2<'_, f64>>,
    surfaces: Vec<[usize; 3]>,
) -> PyResult<(Core, Option<String>)> {
    let py = scene.py();
    check_hinge_law(scene)?;
    let contacts = ideal_contacts(scene)?;
    let place = (positions.as_ref(), velocities.as_ref(), surfaces);
    let DriveScene {
        drive,
        control,
        start,
        ..
    } = DriveScene::new(scene, place)?;
    let raised = Raised::default();
    let made = contained(|| {
        let give_up = || interrupted(py, &raised);
        IdealDrive::new(&drive, &contacts, start.as_ref(), control, &give_up)
    });
    take(&raised)?;
    let (simulation, start) = made?;
    let moved = simulation.assembly().moved;
    let far = positions.is_some() && moved > FAR * drive.chain.pitch;
    let note = far.then(|| {
        format!(
            "positions: links had to be moved by up to {moved:.3e} m to close the ideal hinges: is each link placed \
             where its hinges meet?"
        )
    });
    let start = [start.positions, start.velocities];
    let core = Core::of(AnySimulation::Ideal(simulation), start, raised);
    Ok((core, note))
}

/// Reject friction, film and a separate force law of hinges: ideal hinges have no contact.
fn check_hinge_law(scene: &Bound<'_, PyAny>) -> PyResult<()> {
    let (force_law, hinge_law) = (
        scene.getattr("force_law")?,
        describe::law_of(scene, "hinge_law")?,
    );
    let law = hinge_law.as_ref().unwrap_or(&force_law);
    for (field, remedy) in [
        ("friction", "give that of the teeth in tooth_law, or take"),
        ("film", "take"),
    ] {
        let value = law.getattr_opt(field)?.filter(|value| !value.is_none());
        if let Some(value) = value {
            let message = format!(
                "{field} = {}: must be None with ChainDrive.hinges = 'ideal', whose hinges have no contact; {remedy} \
                 hinges = 'clearance'",
                value.repr()?
            );
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

/// Return the fields of an `Evaluation` of a drive with ideal hinges, from a recording of one row of its mechanism.
pub(super) fn ideal_evaluation<'py>(
    py: Python<'py>,
    simulation: &IdealDrive,
    recording: &Recording,
) -> PyResult<Bound<'py, PyDict>> {
    let found = mechanism_evaluation(py, recording.clone())?;
    let view = simulation.view();
    let rows = IdealRows::new(recording, simulation.model());
    let row = rows.row(0);
    let shape = [view.links(), view.sprockets()];
    let contacts: Vec<BushingContact> = (0..view.links())
        .flat_map(|k| (0..view.sprockets()).map(move |s| (k, s)))
        .map(|(k, s)| view.bushing_contact(&row, k, s))
        .collect();
    let sizes = |values: &[Vec2]| -> Vec<f64> { values.iter().map(|v| v.x.hypot(v.y)).collect() };
    let on_pins = view.on_pins(row.reactions);
    let apart = view.eccentricities(row.positions);
    let own = rows.accelerations()[..3 * view.bodies()].to_vec();
    found.set_item(
        "accelerations",
        own.into_pyarray(py).reshape([view.bodies(), 3])?,
    )?;
    found.set_item("hinge_force", sizes(&on_pins).into_pyarray(py))?;
    found.set_item("hinge_penetration", sizes(&apart).into_pyarray(py))?;
    let vectors = table(py, on_pins.into_iter().map(<[f64; 2]>::from).collect())?;
    found.set_item("hinge_force_vector", vectors)?;
    put_bushing_contacts(&found, shape, &contacts)?;
    Ok(found)
}

//! The rows of a run of a mechanism as arrays, by the names of its channels.

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::multibody::MechanismModel;
use crate::run::mechanism::MechanismRecording;

/// All channels, time first.
pub(super) fn arrays<'py>(
    py: Python<'py>,
    recording: MechanismRecording,
    model: &MechanismModel,
) -> PyResult<Bound<'py, PyDict>> {
    let (rows, joints) = (recording.time.len(), model.joint_names().len());
    let (bodies, contacts) = (model.body_names().len(), model.contact_names().len());
    let arrays = PyDict::new(py);
    let set = |name: &str, mut values: Vec<f64>, shape: &[usize]| {
        let shape: Vec<usize> = std::iter::once(rows).chain(shape.iter().copied()).collect();
        values.truncate(shape.iter().product());
        arrays.set_item(name, values.into_pyarray(py).reshape(shape)?)
    };
    set("time", recording.time, &[])?;
    set("positions", recording.positions, &[bodies, 3])?;
    set("velocities", recording.velocities, &[bodies, 3])?;
    set("accelerations", recording.accelerations, &[bodies, 3])?;
    set("joint_reaction", recording.reactions, &[joints, 3])?;
    set(
        "joint_position_residual",
        recording.position_residual,
        &[joints],
    )?;
    set(
        "joint_velocity_residual",
        recording.velocity_residual,
        &[joints],
    )?;
    set("contact_force", recording.contact_force, &[contacts])?;
    set(
        "contact_force_vector",
        recording.contact_force_vector,
        &[contacts, 2],
    )?;
    set(
        "contact_impact_velocity",
        recording.impact_velocity,
        &[contacts],
    )?;
    set("contact_penetration", recording.penetration, &[contacts])?;
    set("peak_joint_force", recording.peak_joint_force, &[joints])?;
    set(
        "peak_joint_impulse",
        recording.peak_joint_impulse,
        &[joints],
    )?;
    set(
        "peak_contact_force",
        recording.peak_contact_force,
        &[contacts],
    )?;
    set(
        "peak_contact_impulse",
        recording.peak_contact_impulse,
        &[contacts],
    )?;
    for (name, mut values) in [
        ("contact_gap", recording.contact_gap),
        ("contact_region", recording.contact_region),
    ] {
        values.truncate(rows * contacts);
        arrays.set_item(name, values.into_pyarray(py).reshape([rows, contacts])?)?;
    }
    let parts = [
        "kinetic",
        "gravity",
        "elastic",
        "dissipated",
        "external_work",
        "residual",
    ];
    for (i, name) in parts.iter().enumerate() {
        let values = recording
            .energy
            .chunks(parts.len())
            .map(|row| row[i])
            .collect();
        set(&format!("energy_{name}"), values, &[])?;
    }
    Ok(arrays)
}

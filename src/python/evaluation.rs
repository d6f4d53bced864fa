//! Evaluations and states as dictionaries of arrays.

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arrays::{recorded, table};
use crate::chain::contact::ContactId;
use crate::chain::dynamics::Dynamics;
use crate::chain::model::Model;
use crate::multibody::Assembly;
use crate::run::simulation::Statistics;
use crate::system::Recording;

/// Return values over (bushings, sprockets) from values over pairs.
fn by_bushing<T>(model: &Model, value: impl Fn(usize) -> T) -> Vec<T> {
    let (links, sprockets) = (model.links, model.sprockets.len());
    (0..links)
        .flat_map(|k| (0..sprockets).map(move |s| s * links + k))
        .map(value)
        .collect()
}

/// Write the impact velocity memory of a drive, and the contacts that ended in the last step.
pub(super) fn set_contact_memory(
    py: Python<'_>,
    dynamics: &Dynamics,
    state: &Bound<'_, PyDict>,
) -> PyResult<()> {
    let model = dynamics.model();
    let memory = &dynamics.memory;
    let ended = |number: fn(ContactId) -> Option<usize>| {
        let ended = dynamics.ended_contacts().iter().copied();
        ended
            .filter_map(number)
            .collect::<Vec<_>>()
            .into_pyarray(py)
    };
    let shape = [model.links, model.sprockets.len()];
    let hinges = memory.hinge_impact_velocity().to_vec();
    state.set_item("hinge_onset_speed", hinges.into_pyarray(py))?;
    let speeds = by_bushing(model, |pair| memory.tooth_impact_velocity[pair]);
    let speeds = speeds.into_pyarray(py).reshape(shape)?;
    state.set_item("tooth_onset_speed", speeds)?;
    let surfaces = by_bushing(model, |pair| i32::from(memory.tooth_surface[pair].0));
    let surfaces = surfaces.into_pyarray(py).reshape(shape)?;
    state.set_item("tooth_onset_surface", surfaces)?;
    if model.rollers.is_some() {
        let speeds = memory.roller_impact_velocity().to_vec();
        state.set_item("roller_onset_speed", speeds.into_pyarray(py))?;
        let ended = ended(|contact| match contact {
            ContactId::Roller(k) => Some(k),
            _ => None,
        });
        state.set_item("ended_rollers", ended)?;
    }
    let hinges = ended(|contact| match contact {
        ContactId::Hinge(k) => Some(k),
        _ => None,
    });
    state.set_item("ended_hinges", hinges)?;
    let pairs = ended(|contact| match contact {
        ContactId::Tooth(pair) => Some(pair),
        _ => None,
    });
    state.set_item("ended_tooth_pairs", pairs)?;
    Ok(())
}

/// Return counts and wall times of a run.
pub(super) fn statistics<'py>(
    py: Python<'py>,
    statistics: &Statistics,
) -> PyResult<Bound<'py, PyDict>> {
    let stats = PyDict::new(py);
    stats.set_item("steps", statistics.counts.steps)?;
    stats.set_item("rejected", statistics.counts.rejected)?;
    stats.set_item("evaluations", statistics.counts.evaluations)?;
    stats.set_item("energy_evaluations", statistics.energy_evaluations)?;
    stats.set_item("jacobians", statistics.counts.jacobians)?;
    stats.set_item("onsets", statistics.onsets)?;
    stats.set_item(
        "onsets_at_minimum_velocity",
        statistics.onsets_at_minimum_velocity,
    )?;
    stats.set_item("in_step_contacts", statistics.in_step_contacts)?;
    stats.set_item("wall_stepping", statistics.wall_stepping)?;
    stats.set_item("wall_onsets", statistics.wall_onsets)?;
    stats.set_item("wall_reports", statistics.wall_reports)?;
    Ok(stats)
}

/// Return accelerations, reactions and contacts of one row of a mechanism.
pub(super) fn mechanism_evaluation(py: Python<'_>, row: Recording) -> PyResult<Bound<'_, PyDict>> {
    let all = recorded(py, row)?;
    let found = PyDict::new(py);
    for name in [
        "accelerations",
        "joint_reaction",
        "contact_force",
        "contact_penetration",
        "contact_force_vector",
        "contact_gap",
        "contact_region",
    ] {
        let rows = all.get_item(name)?;
        found.set_item(name, rows.map(|rows| rows.get_item(0)).transpose()?)?;
    }
    Ok(found)
}

/// Return accelerations and contacts of a drive.
pub(super) fn drive_evaluation<'py>(
    py: Python<'py>,
    dynamics: &Dynamics,
) -> PyResult<Bound<'py, PyDict>> {
    let a = &dynamics.evaluated.accelerations;
    let accelerations = (0..dynamics.model().bodies())
        .map(|i| [a.x[i], a.y[i], a.angle[i]])
        .collect();
    let found = PyDict::new(py);
    found.set_item("accelerations", table(py, accelerations)?)?;
    put_joints(&found, dynamics)?;
    put_teeth(&found, dynamics)?;
    put_bristles(&found, dynamics)?;
    Ok(found)
}

/// Add the contacts of hinges and rollers.
fn put_joints(found: &Bound<'_, PyDict>, dynamics: &Dynamics) -> PyResult<()> {
    let py = found.py();
    let hinges = &dynamics.evaluated.hinges;
    found.set_item(
        "hinge_force",
        hinges.recorded_forces().to_vec().into_pyarray(py),
    )?;
    let depths = if dynamics.model().hinges.ideal {
        hinges.distances().collect()
    } else {
        hinges.penetration.clone()
    };
    found.set_item("hinge_penetration", depths.into_pyarray(py))?;
    found.set_item(
        "hinge_force_vector",
        table(py, hinges.forces_on_pins().collect())?,
    )?;
    if dynamics.model().rollers.is_some() {
        let rollers = &dynamics.evaluated.rollers;
        found.set_item("roller_force", rollers.force.clone().into_pyarray(py))?;
        let depths = rollers.penetration.clone();
        found.set_item("roller_penetration", depths.into_pyarray(py))?;
        let forces = rollers.forces_on_rollers().collect();
        found.set_item("roller_force_vector", table(py, forces)?)?;
    }
    Ok(())
}

/// Contact of a bushing with a sprocket.
struct BushingContact {
    /// Magnitude of the contact force \[N\]; zero without contact.
    force: f64,
    /// Contact force on the bushing \[N\].
    vector: [f64; 2],
    /// Penetration \[m\]; minus infinity out of reach of the teeth.
    penetration: f64,
    /// Number of the tooth gap, from 0; -1 out of reach.
    gap: i32,
    /// Region of the tooth, from 1; 0 out of reach.
    region: i32,
}

/// Add the contacts of bushings with teeth, (links, sprockets) each.
fn put_teeth(found: &Bound<'_, PyDict>, dynamics: &Dynamics) -> PyResult<()> {
    let (model, teeth) = (dynamics.model(), &dynamics.evaluated.teeth);
    let contact = |pair: usize| {
        let apart = BushingContact {
            force: 0.0,
            vector: [0.0; 2],
            penetration: teeth.penetration[pair],
            gap: -1,
            region: 0,
        };
        let near = apart.penetration > f64::NEG_INFINITY;
        if !near {
            return apart;
        }
        BushingContact {
            force: teeth.force[pair],
            vector: [0, 1].map(|axis| teeth.on_bushing[axis][pair]),
            #[allow(clippy::cast_possible_wrap)] // gaps are few
            gap: teeth.gap[pair] as i32,
            region: i32::from(teeth.region(&model.sprockets[pair / model.links].profile, pair)),
            ..apart
        }
    };
    let shape = [model.links, model.sprockets.len()];
    let (py, contacts) = (found.py(), by_bushing(model, contact));
    let real = |value: fn(&BushingContact) -> f64| {
        let values: Vec<f64> = contacts.iter().map(value).collect();
        values.into_pyarray(py).reshape(shape)
    };
    let whole = |value: fn(&BushingContact) -> i32| {
        let values: Vec<i32> = contacts.iter().map(value).collect();
        values.into_pyarray(py).reshape(shape)
    };
    let vectors: Vec<f64> = contacts.iter().flat_map(|found| found.vector).collect();
    let vectors = vectors.into_pyarray(py).reshape([shape[0], shape[1], 2])?;
    found.set_item("tooth_force", real(|found| found.force)?)?;
    found.set_item("tooth_penetration", real(|found| found.penetration)?)?;
    found.set_item("tooth_force_vector", vectors)?;
    found.set_item("tooth_region", whole(|found| found.region)?)?;
    found.set_item("tooth_index", whole(|found| found.gap)?)
}

/// Add the deflections of bristles, of the contacts that have any.
fn put_bristles(found: &Bound<'_, PyDict>, dynamics: &Dynamics) -> PyResult<()> {
    let (py, model) = (found.py(), dynamics.model());
    let bent = &dynamics.evaluated.bristles.deflection;
    let places = &model.bristles;
    let first = |range: &std::ops::Range<usize>| range.start - places.hinges.start;
    if !places.hinges.is_empty() {
        let hinges = bent[..model.links].to_vec();
        found.set_item("hinge_bristle", hinges.into_pyarray(py))?;
    }
    if !places.rollers.is_empty() {
        let rollers = bent[first(&places.rollers)..][..model.links].to_vec();
        found.set_item("roller_bristle", rollers.into_pyarray(py))?;
    }
    if !places.teeth.is_empty() {
        let teeth = &bent[first(&places.teeth)..];
        let teeth = by_bushing(model, |p| teeth[p]).into_pyarray(py);
        let shape = [model.links, model.sprockets.len()];
        found.set_item("tooth_bristle", teeth.reshape(shape)?)?;
    }
    Ok(())
}

/// Return the fields of a report on the assembly of a mechanism.
pub(super) fn assembly<'py>(py: Python<'py>, assembly: &Assembly) -> PyResult<Bound<'py, PyDict>> {
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

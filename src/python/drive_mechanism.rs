//! Mechanism of a drive, for Python: the calls of the methods of `Mechanism` that describe it.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::describe;
use super::errors::InvalidInput;
use super::starts::generated;
use crate::geometry::Vec2;
use crate::math::{Signal, Table};
use crate::multibody::{
    Body, ContactLaw, ContactPair, DriveContacts, ForceElement, ForceKind, Joint, JointKind,
    Mechanism, PrescribedMotion, Profile, SpringLaw,
};
use crate::panics::contained;

/// Name of a method of `Mechanism`, and its keyword arguments.
type Call<'py> = (&'static str, Bound<'py, PyDict>);

/// Read the law of the contacts in the mechanism of a drive.
pub(super) fn drive_contacts(
    force_law: &Bound<'_, PyAny>,
    min_impact_velocity: &Bound<'_, PyAny>,
) -> PyResult<DriveContacts> {
    Ok(DriveContacts {
        law: describe::mechanism_law(force_law, "force_law")?,
        min_impact_velocity: describe::min_impact_velocity(min_impact_velocity)?,
        tribology: describe::tribology(force_law)?,
    })
}

/// Return the calls (method of `Mechanism`, keyword arguments) that describe the mechanism of a drive. A contact has its `length` in the
/// place of its law, and the sprocket's number, from 0, in the place of sprocket and chain.
#[pyfunction]
pub(super) fn drive_mechanism<'py>(
    drive: &Bound<'py, PyAny>,
    force_law: &Bound<'py, PyAny>,
    min_impact_velocity: &Bound<'py, PyAny>,
) -> PyResult<Vec<Call<'py>>> {
    let py = drive.py();
    let description = describe::drive(drive)?;
    let contacts = drive_contacts(force_law, min_impact_velocity)?;
    let (start, _) = generated(py, &description)?;
    let mechanism = contained(|| Mechanism::from_drive(&description, &contacts, Some(&start)))?;
    let links = description.chain.links as usize;
    let mut calls = Vec::new();
    for part in &mechanism.bodies {
        calls.push(body(py, part)?);
    }
    for part in &mechanism.joints {
        calls.push(joint(py, part)?);
    }
    for part in &mechanism.forces {
        calls.push(force(py, part)?);
    }
    for part in &mechanism.contacts {
        let mut wheels = mechanism.bodies[links..].iter();
        let sprocket = wheels.position(|wheel| wheel.name == part.a.body);
        calls.push(contact(py, part, sprocket)?);
    }
    Ok(calls)
}

/// Return the error of a part whose kind does not occur in a drive.
fn unknown(name: &str) -> PyErr {
    InvalidInput::new_err(format!("{name} is of a kind that no drive has"))
}

fn pair(vector: Vec2) -> (f64, f64) {
    (vector.x, vector.y)
}

fn body<'py>(py: Python<'py>, part: &Body) -> PyResult<Call<'py>> {
    let keywords = PyDict::new(py);
    keywords.set_item("name", &part.name)?;
    keywords.set_item("mass", part.mass)?;
    keywords.set_item("inertia", part.inertia)?;
    keywords.set_item("position", <(f64, f64, f64)>::from(part.position))?;
    keywords.set_item("velocity", <(f64, f64, f64)>::from(part.velocity))?;
    Ok(("add_body", keywords))
}

fn joint<'py>(py: Python<'py>, part: &Joint) -> PyResult<Call<'py>> {
    let keywords = PyDict::new(py);
    keywords.set_item("name", &part.name)?;
    keywords.set_item("body_a", &part.a.body)?;
    keywords.set_item("body_b", &part.b.body)?;
    let points = || {
        keywords.set_item("point_a", pair(part.a.point))?;
        keywords.set_item("point_b", pair(part.b.point))
    };
    let method = match &part.kind {
        JointKind::Revolute => {
            points()?;
            "add_revolute"
        }
        JointKind::PointOnLine { direction } => {
            points()?;
            keywords.set_item("direction", pair(*direction))?;
            "add_point_on_line"
        }
        JointKind::DrivenAngle(PrescribedMotion::Speed(speed)) => {
            keywords.set_item("speed", signal_object(py, speed)?)?;
            "add_driver"
        }
        _ => return Err(unknown(&part.name)),
    };
    Ok((method, keywords))
}

fn force<'py>(py: Python<'py>, part: &ForceElement) -> PyResult<Call<'py>> {
    let keywords = PyDict::new(py);
    keywords.set_item("name", &part.name)?;
    let function = |signal: &Signal| signal_object(py, signal);
    let on_body = |field: &str, value: Bound<'py, PyAny>| {
        keywords.set_item("body", &part.b.body)?;
        keywords.set_item(field, value)
    };
    let between = |law: &SpringLaw, field: &str, rest: Option<f64>| {
        keywords.set_item("body_a", &part.a.body)?;
        keywords.set_item("body_b", &part.b.body)?;
        keywords.set_item("stiffness", law.stiffness)?;
        keywords.set_item("damping", law.damping)?;
        keywords.set_item("table", law.table.as_ref().map(Table::rows))?;
        keywords.set_item(field, rest)
    };
    let method = match &part.kind {
        ForceKind::Force { x, y, .. } => {
            let force = (function(x)?, function(y)?).into_pyobject(py)?;
            on_body("force", force.into_any())?;
            "add_force"
        }
        ForceKind::Torque(torque) => {
            on_body("torque", function(torque)?)?;
            "add_torque"
        }
        ForceKind::TorqueBySpeed(curve) => {
            on_body("by_speed", curve.rows().into_pyobject(py)?)?;
            "add_torque"
        }
        ForceKind::Spring { law, rest } => {
            between(law, "rest_length", *rest)?;
            keywords.set_item("point_a", pair(part.a.point))?;
            "add_spring"
        }
        ForceKind::TorsionSpring { law, rest } => {
            between(law, "rest_angle", *rest)?;
            "add_torsion_spring"
        }
        ForceKind::Custom(_) => return Err(unknown(&part.name)),
    };
    Ok((method, keywords))
}

fn contact<'py>(
    py: Python<'py>,
    part: &ContactPair,
    sprocket: Option<usize>,
) -> PyResult<Call<'py>> {
    let keywords = PyDict::new(py);
    keywords.set_item("name", &part.name)?;
    let ContactLaw::Surfaces { length, .. } = part.law else {
        return Err(unknown(&part.name));
    };
    keywords.set_item("length", length)?;
    let method = match &part.profile {
        Profile::Bore { radius } => {
            keywords.set_item("bore", &part.a.body)?;
            keywords.set_item("pin", &part.b.body)?;
            keywords.set_item("bore_radius", *radius)?;
            keywords.set_item("pin_radius", part.radius)?;
            keywords.set_item("bore_point", pair(part.a.point))?;
            keywords.set_item("pin_point", pair(part.b.point))?;
            "add_clearance_joint"
        }
        Profile::Teeth(_) => {
            keywords.set_item("wheel", &part.a.body)?;
            keywords.set_item("circle", &part.b.body)?;
            keywords.set_item("sprocket", sprocket)?;
            keywords.set_item("circle_point", pair(part.b.point))?;
            "add_sprocket_contact"
        }
        _ => return Err(unknown(&part.name)),
    };
    Ok((method, keywords))
}

/// Return a number, or the Python object of another signal.
fn signal_object<'py>(py: Python<'py>, signal: &Signal) -> PyResult<Bound<'py, PyAny>> {
    let class = |name: &str| py.import("rustchain.description.signals")?.getattr(name);
    match signal {
        Signal::Constant(value) => Ok(value.into_pyobject(py)?.into_any()),
        Signal::Table(table) => class("Table")?.call1((table.rows(),)),
        Signal::Spline(spline) => class("Spline")?.call1((spline.rows(),)),
        Signal::SmoothStep {
            start,
            end,
            from,
            to,
        } => class("SmoothStep")?.call1((*start, *end, *from, *to)),
        Signal::Sines { offset, terms } => class("Sines")?.call1((terms.clone(), *offset)),
    }
}

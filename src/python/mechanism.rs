//! Conversion of Python's description of a mechanism to that of this crate, part by part.

use std::sync::Arc;

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use super::arrays::rows;
use super::core::Core;
use super::describe::{Reader, friction, number, refuse, shown, signal, table, truth};
use super::errors::InvalidInput;
use super::interrupt::interruptible;
use super::mechanism_callable::{Raised, custom, take};
use super::mechanism_contact::contact;
use super::mechanism_fields::{markers, text};
use crate::layout::InitialConfiguration;
use crate::multibody::{
    Body, ForceElement, ForceKind, Joint, JointKind, Mechanism, MechanismModel, PinFriction,
    PrescribedMotion, SpringLaw,
};
use crate::panics::contained;
use crate::run::{AnySimulation, MechanismSimulation};

/// Read a `Mechanism`; exceptions of callables are stored in `raised`.
pub(super) fn mechanism(object: &Bound<'_, PyAny>, raised: &Raised) -> PyResult<Mechanism> {
    let read = Reader::new(object, "mechanism", &["Mechanism"])?;
    let mut found = Mechanism {
        gravity: read.vector("gravity", "m/s^2")?,
        ..Mechanism::default()
    };
    found.bodies = parts(&read, "bodies", "body", body)?;
    found.joints = parts(&read, "joints", "joint", joint)?;
    found.forces = parts(&read, "forces", "force", |part| force(part, raised))?;
    found.contacts = parts(&read, "contacts", "contact", contact)?;
    Ok(found)
}

/// Read all parts of a kind; the error of a part includes its name.
fn parts<T>(
    read: &Reader<'_, '_>,
    field: &str,
    kind: &str,
    one: impl Fn(&Bound<'_, PyAny>) -> PyResult<T>,
) -> PyResult<Vec<T>> {
    let mut found = Vec::new();
    for part in read.get(field)?.try_iter()? {
        let part = part?;
        found.push(one(&part).map_err(|error| of_part(&part, kind, error))?);
    }
    Ok(found)
}

/// Return the error of a part, preceded by the name of the part; other exceptions stay as they are.
fn of_part(part: &Bound<'_, PyAny>, kind: &str, error: PyErr) -> PyErr {
    if !error.is_instance_of::<InvalidInput>(part.py()) {
        return error;
    }
    let named = || {
        let name = match part.getattr("name") {
            Ok(name) => shown(&name)?,
            Err(_) => "without a name".to_string(),
        };
        let message = error.value(part.py()).str()?;
        PyResult::Ok(format!("{kind} {name}: {}", message.to_string_lossy()))
    };
    named().map_or_else(|interrupt| interrupt, InvalidInput::new_err)
}

fn optional_text(read: &Reader<'_, '_>, field: &str) -> PyResult<Option<String>> {
    let given = !read.get(field)?.is_none();
    given.then(|| text(read, field)).transpose()
}

fn optional(value: &Bound<'_, PyAny>, field: &str, unit: &str) -> PyResult<Option<f64>> {
    let given = !value.is_none();
    given.then(|| number(value, field, unit)).transpose()
}

fn triple(read: &Reader<'_, '_>, field: &str, unit: &str) -> PyResult<[f64; 3]> {
    let value = read.get(field)?;
    let parts: [Bound<'_, PyAny>; 3] = value
        .extract()
        .map_err(|_| refuse(field, &value, &format!("must be three numbers in {unit}")))?;
    let [x, y, angle] = parts.map(|part| number(&part, field, unit));
    Ok([x?, y?, angle?])
}

fn body(object: &Bound<'_, PyAny>) -> PyResult<Body> {
    let read = Reader::new(object, "bodies", &["Body"])?;
    Ok(Body {
        name: text(&read, "name")?,
        mass: read.number("mass", "kg")?,
        inertia: read.number("inertia", "kg m^2")?,
        position: triple(&read, "position", "m, m, rad")?,
        velocity: triple(&read, "velocity", "m/s, m/s, rad/s")?,
        fixed: truth(&read.get("fixed")?, "fixed")?,
    })
}

fn joint(object: &Bound<'_, PyAny>) -> PyResult<Joint> {
    let read = Reader::new(object, "joints", &["Joint"])?;
    let [a, b] = markers(&read)?;
    let direction = || read.vector("direction", "1");
    let value = |name: &str, unit: &str| optional(&read.get("value")?, name, unit);
    let kind = match text(&read, "kind")?.as_str() {
        "revolute" => JointKind::Revolute,
        "fixed" => JointKind::Fixed {
            angle: value("angle", "rad")?,
        },
        "prismatic" => JointKind::Prismatic {
            direction: direction()?,
            angle: value("angle", "rad")?,
        },
        "point_on_line" => JointKind::PointOnLine {
            direction: direction()?,
        },
        "distance" => JointKind::Distance {
            length: value("length", "m")?,
        },
        "gear" => JointKind::Gear {
            ratio: number(&read.get("value")?, "ratio", "1")?,
            carrier: optional_text(&read, "carrier")?,
        },
        "rack" => JointKind::Rack {
            direction: direction()?,
            radius: number(&read.get("value")?, "radius", "m")?,
        },
        "driven_angle" => JointKind::DrivenAngle(motion(&read)?),
        "driven_position" => JointKind::DrivenPosition {
            direction: direction()?,
            motion: motion(&read)?,
        },
        _ => {
            return Err(refuse("kind", &read.get("kind")?, "is no joint"));
        }
    };
    Ok(Joint {
        name: text(&read, "name")?,
        a,
        b,
        kind,
        friction: pin_friction(&read)?,
    })
}

fn pin_friction(read: &Reader<'_, '_>) -> PyResult<Option<PinFriction>> {
    let law = read.get("friction")?;
    let radius = optional(&read.get("radius")?, "radius", "m")?;
    match (law.is_none(), radius) {
        (true, None) => Ok(None),
        (false, Some(radius)) => Ok(Some(PinFriction {
            radius,
            law: friction(&law, "friction")?,
        })),
        (true, Some(radius)) => Err(InvalidInput::new_err(format!(
            "radius = {radius} m: is of a pin with friction; give friction, a Coulomb, too, or leave it out"
        ))),
        (false, None) => Err(InvalidInput::new_err(
            "radius = None: friction of a pin needs its radius [m]: give radius, too",
        )),
    }
}

fn motion(read: &Reader<'_, '_>) -> PyResult<PrescribedMotion> {
    let function = signal(&read.get("motion")?, "motion", "its unit")?;
    Ok(if truth(&read.get("by_speed")?, "by_speed")? {
        PrescribedMotion::Speed(function)
    } else {
        PrescribedMotion::Position(function)
    })
}

fn spring_law(read: &Reader<'_, '_>) -> PyResult<SpringLaw> {
    let given = read.get("table")?;
    let of_table = || table(&given, "table", ("argument", "m or rad"), "N or N m");
    Ok(SpringLaw {
        stiffness: read.number("stiffness", "N/m")?,
        cubic: read.number("cubic", "N/m^3")?,
        damping: read.number("damping", "N s/m")?,
        table: (!given.is_none()).then(of_table).transpose()?,
    })
}

fn force(object: &Bound<'_, PyAny>, raised: &Raised) -> PyResult<ForceElement> {
    let read = Reader::new(object, "forces", &["Force"])?;
    let [a, b] = markers(&read)?;
    let name = text(&read, "name")?;
    let component = |field: &str| signal(&read.get(field)?, field, "N");
    let kind = match text(&read, "kind")?.as_str() {
        "force" => ForceKind::Force {
            x: component("x")?,
            y: component("y")?,
            follows: truth(&read.get("follows")?, "follows")?,
        },
        "torque" => ForceKind::Torque(signal(&read.get("x")?, "torque", "N m")?),
        "torque_by_speed" => ForceKind::TorqueBySpeed(table(
            &read.get("table")?,
            "table",
            ("speed", "rad/s"),
            "N m",
        )?),
        "spring" => ForceKind::Spring {
            law: spring_law(&read)?,
            rest: optional(&read.get("rest")?, "rest_length", "m")?,
        },
        "torsion_spring" => ForceKind::TorsionSpring {
            law: spring_law(&read)?,
            rest: optional(&read.get("rest")?, "rest_angle", "rad")?,
        },
        "custom" => custom(&name, &read.get("function")?, raised)?,
        _ => {
            return Err(refuse("kind", &read.get("kind")?, "is no force"));
        }
    };
    Ok(ForceElement { name, a, b, kind })
}

/// Return a run of a mechanism. It begins at `positions` with `velocities`, by default those described, and its contacts on `surfaces`, by
/// default the nearest.
#[pyfunction]
#[pyo3(name = "MechanismCore", signature = (description, solver, positions=None, velocities=None, surfaces=Vec::new()))]
#[allow(clippy::needless_pass_by_value)] // PyO3 passes arrays by value
pub(super) fn mechanism_core(
    description: &Bound<'_, PyAny>,
    solver: &Bound<'_, PyAny>,
    positions: Option<PyReadonlyArray2<'_, f64>>,
    velocities: Option<PyReadonlyArray2<'_, f64>>,
    surfaces: Vec<[usize; 3]>,
) -> PyResult<Core> {
    let py = description.py();
    let raised = Raised::default();
    let description = mechanism(description, &raised)?;
    let control = super::describe::solver(solver)?;
    let positions = rows("positions", positions.as_ref())?;
    let velocities = rows("velocities", velocities.as_ref())?;
    let made = interruptible(py, |give_up| {
        contained(|| {
            let model = MechanismModel::compile(&description)?;
            let (Some(positions), Some(velocities)) = (positions, velocities) else {
                return MechanismSimulation::assemble_unless(Arc::new(model), control, give_up);
            };
            let start = InitialConfiguration {
                positions,
                velocities,
                surfaces,
            };
            MechanismSimulation::assemble_from(model, &start, control, give_up)
        })
    });
    take(&raised)?;
    let mut simulation = AnySimulation::Mechanism(made??);
    let start = [simulation.positions(), simulation.velocities()];
    Ok(Core::of(simulation, start, raised))
}

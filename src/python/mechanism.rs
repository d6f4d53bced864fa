//! Python's description of a mechanism -> the one of this crate, part by part.

use std::sync::{Arc, Mutex};

use pyo3::prelude::*;

use super::describe::{
    Reader, chain, checked, force_law, material, number, refuse, sprocket, truth,
};
use crate::geometry::Vec2;
use crate::mechanism::{
    Body, ContactLaw, ContactPair, Curve, CustomForce, ForceElement, ForceKind, Joint, JointKind,
    Marker, Mechanism, Motion, Piece, Profile, Spline, SpringLaw, TimeFunction,
};

/// The first exception that a callable raised.
pub(super) type Raised = Arc<Mutex<Option<PyErr>>>;

/// Reads a `Mechanism`; callables leave what they raise in `raised`.
pub(super) fn mechanism(object: &Bound<'_, PyAny>, raised: &Raised) -> PyResult<Mechanism> {
    let read = Reader::new(object, "mechanism", &["Mechanism"])?;
    let mut found = Mechanism {
        gravity: read.vector("gravity", "m/s^2")?,
        ..Mechanism::default()
    };
    for part in read.get("bodies")?.try_iter()? {
        found.bodies.push(body(&part?)?);
    }
    for part in read.get("joints")?.try_iter()? {
        found.joints.push(joint(&part?)?);
    }
    for part in read.get("forces")?.try_iter()? {
        found.forces.push(force(&part?, raised)?);
    }
    for part in read.get("contacts")?.try_iter()? {
        found.contacts.push(contact(&part?)?);
    }
    Ok(found)
}

fn text(read: &Reader<'_, '_>, field: &str) -> PyResult<String> {
    let value = read.get(field)?;
    value
        .extract()
        .map_err(|_| refuse(value.py(), field, &value, "must be text"))
}

fn triple(read: &Reader<'_, '_>, field: &str, unit: &str) -> PyResult<[f64; 3]> {
    let value = read.get(field)?;
    let parts: [Bound<'_, PyAny>; 3] = value.extract().map_err(|_| {
        refuse(
            value.py(),
            field,
            &value,
            &format!("must be three numbers in {unit}"),
        )
    })?;
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

fn markers(read: &Reader<'_, '_>) -> PyResult<[Marker; 2]> {
    let marker = |body: &str, point: &str| {
        Ok::<_, PyErr>(Marker {
            body: text(read, body)?,
            point: read.vector(point, "m")?,
        })
    };
    Ok([marker("body_a", "point_a")?, marker("body_b", "point_b")?])
}

fn joint(object: &Bound<'_, PyAny>) -> PyResult<Joint> {
    let read = Reader::new(object, "joints", &["Joint"])?;
    let [a, b] = markers(&read)?;
    let direction = || read.vector("direction", "1");
    let kind = match text(&read, "kind")?.as_str() {
        "revolute" => JointKind::Revolute,
        "fixed" => JointKind::Fixed {
            angle: read.optional_number("value", "rad")?,
        },
        "prismatic" => JointKind::Prismatic {
            direction: direction()?,
            angle: read.optional_number("value", "rad")?,
        },
        "point_on_line" => JointKind::PointOnLine {
            direction: direction()?,
        },
        "distance" => JointKind::Distance {
            length: read.optional_number("value", "m")?,
        },
        "gear" => JointKind::Gear {
            ratio: read.number("value", "1")?,
            carrier: read.get("carrier")?.extract()?,
        },
        "rack" => JointKind::Rack {
            direction: direction()?,
            radius: read.number("value", "m")?,
        },
        "driven_angle" => JointKind::DrivenAngle(motion(&read)?),
        "driven_position" => JointKind::DrivenPosition {
            direction: direction()?,
            motion: motion(&read)?,
        },
        _ => {
            return Err(refuse(
                object.py(),
                "kind",
                &read.get("kind")?,
                "is no joint",
            ));
        }
    };
    Ok(Joint {
        name: text(&read, "name")?,
        a,
        b,
        kind,
    })
}

fn motion(read: &Reader<'_, '_>) -> PyResult<Motion> {
    let function = time_function(&read.get("motion")?, "motion")?;
    Ok(if truth(&read.get("by_speed")?, "by_speed")? {
        Motion::Speed(function)
    } else {
        Motion::Position(function)
    })
}

fn pairs(value: &Bound<'_, PyAny>, field: &str) -> PyResult<Vec<(f64, f64)>> {
    value
        .extract()
        .map_err(|_| refuse(value.py(), field, value, "must be rows of two numbers"))
}

/// A number, or one of the functions of time.
fn time_function(value: &Bound<'_, PyAny>, field: &str) -> PyResult<TimeFunction> {
    let kind = value.get_type().name()?.to_string();
    let known = ["SmoothStep", "Table", "Spline", "Sines"];
    if !known.contains(&kind.as_str()) {
        return number(
            value,
            field,
            "its unit, or a SmoothStep, Table, Spline or Sines",
        )
        .map(TimeFunction::Constant);
    }
    let read = Reader::new(value, field, &known)?;
    let rows = || pairs(&read.get("rows")?, field);
    Ok(match kind.as_str() {
        "SmoothStep" => TimeFunction::SmoothStep {
            start: read.number("start", "s")?,
            end: read.number("end", "s")?,
            from: read.number("before", "its unit")?,
            to: read.number("after", "its unit")?,
        },
        "Table" => TimeFunction::Table(checked(value.py(), Curve::new(field, &rows()?))?),
        "Spline" => TimeFunction::Spline(checked(value.py(), Spline::new(field, &rows()?))?),
        _ => TimeFunction::Sines {
            offset: read.number("offset", "its unit")?,
            terms: read.get("terms")?.extract()?,
        },
    })
}

fn spring_law(read: &Reader<'_, '_>, field: &str) -> PyResult<SpringLaw> {
    let table = read.get("table")?;
    Ok(SpringLaw {
        stiffness: read.number("stiffness", "N/m")?,
        cubic: read.number("cubic", "N/m^3")?,
        damping: read.number("damping", "N s/m")?,
        table: if table.is_none() {
            None
        } else {
            Some(checked(
                table.py(),
                Curve::new(field, &pairs(&table, field)?),
            )?)
        },
    })
}

fn force(object: &Bound<'_, PyAny>, raised: &Raised) -> PyResult<ForceElement> {
    let read = Reader::new(object, "forces", &["Force"])?;
    let [a, b] = markers(&read)?;
    let name = text(&read, "name")?;
    let value =
        |field: &str| time_function(&read.get(field)?, &format!("{field} of force {name:?}"));
    let kind = match text(&read, "kind")?.as_str() {
        "force" => ForceKind::Force {
            x: value("x")?,
            y: value("y")?,
            follows: truth(&read.get("follows")?, "follows")?,
        },
        "torque" => ForceKind::Torque(value("x")?),
        "torque_by_speed" => {
            let rows = pairs(&read.get("table")?, "table")?;
            ForceKind::TorqueBySpeed(checked(object.py(), Curve::new("table", &rows))?)
        }
        "spring" => ForceKind::Spring {
            law: spring_law(&read, &name)?,
            rest: read.optional_number("rest", "m")?,
        },
        "torsion_spring" => ForceKind::TorsionSpring {
            law: spring_law(&read, &name)?,
            rest: read.optional_number("rest", "rad")?,
        },
        "custom" => custom(&read.get("function")?, raised),
        _ => {
            return Err(refuse(
                object.py(),
                "kind",
                &read.get("kind")?,
                "is no force",
            ));
        }
    };
    Ok(ForceElement { name, a, b, kind })
}

/// A callable; what it raises ends the run, which sees a load that is not a number.
fn custom(function: &Bound<'_, PyAny>, raised: &Raised) -> ForceKind {
    let (function, raised) = (function.clone().unbind(), Arc::clone(raised));
    ForceKind::Custom(CustomForce(Arc::new(move |t, position, velocity| {
        let Ok(mut failure) = raised.lock() else {
            return [f64::NAN; 3];
        };
        if failure.is_some() {
            return [f64::NAN; 3];
        }
        let found = Python::attach(|py| {
            let load = function.call1(py, (t, position.to_vec(), velocity.to_vec()))?;
            load.extract::<[f64; 3]>(py).map_err(|_| {
                let shown = load.bind(py);
                refuse(
                    py,
                    "load of a callable",
                    shown,
                    "must be three numbers (force x, force y, torque)",
                )
            })
        });
        found.unwrap_or_else(|error| {
            *failure = Some(error);
            [f64::NAN; 3]
        })
    })))
}

fn points(value: &Bound<'_, PyAny>, field: &str) -> PyResult<Vec<Vec2>> {
    Ok(pairs(value, field)?
        .into_iter()
        .map(|(x, y)| Vec2::new(x, y))
        .collect())
}

fn contact(object: &Bound<'_, PyAny>) -> PyResult<ContactPair> {
    let read = Reader::new(object, "contacts", &["Contact"])?;
    let [a, b] = markers(&read)?;
    let name = text(&read, "name")?;
    let field = format!("contact {name:?}");
    let closed = || truth(&read.get("closed")?, "closed");
    let profile = match text(&read, "kind")?.as_str() {
        "bore" => Profile::Bore {
            radius: read.number("profile_radius", "m")?,
        },
        "disc" => Profile::Disc {
            radius: read.number("profile_radius", "m")?,
        },
        "sprocket" => {
            let wheel = sprocket(&read.get("sprocket")?, &field)?;
            let chain = chain(&read.get("chain")?, &field)?;
            Profile::Teeth(Box::new(checked(object.py(), wheel.tooth_profile(&chain))?))
        }
        "polyline" => {
            let points = points(&read.get("points")?, &field)?;
            checked(object.py(), Profile::polyline(&field, &points, closed()?))?
        }
        _ => Profile::Outline {
            pieces: arcs(&read.get("points")?, &field)?,
            closed: closed()?,
        },
    };
    Ok(ContactPair {
        a,
        b,
        profile,
        radius: read.number("radius", "m")?,
        law: contact_law(&read.get("law")?)?,
        name,
    })
}

/// Pieces (from x, from y, to x, to y, centre x, centre y, whether convex), the centre NaN for a straight line.
fn arcs(value: &Bound<'_, PyAny>, field: &str) -> PyResult<Vec<Piece>> {
    let rows: Vec<[f64; 7]> = value
        .extract()
        .map_err(|_| refuse(value.py(), field, value, "must be rows of seven numbers"))?;
    Ok(rows
        .into_iter()
        .map(|[fx, fy, tx, ty, cx, cy, convex]| Piece {
            from: Vec2::new(fx, fy),
            to: Vec2::new(tx, ty),
            center: (!cx.is_nan()).then_some(Vec2::new(cx, cy)),
            convex: convex > 0.0,
        })
        .collect())
}

fn contact_law(object: &Bound<'_, PyAny>) -> PyResult<ContactLaw> {
    let kinds = ["LinearContact", "HuntCrossley", "SurfaceContact"];
    let read = Reader::new(object, "law", &kinds)?;
    Ok(match read.kind.as_str() {
        "LinearContact" => {
            // Per length where a length is given.
            let length = read.optional_number("length", "m")?.unwrap_or(1.0);
            ContactLaw::Linear {
                stiffness: length * read.number("stiffness", "N/m")?,
                damping: length * read.number("damping", "N s/m")?,
            }
        }
        "HuntCrossley" => ContactLaw::HuntCrossley {
            stiffness: read.number("stiffness", "N/m^n")?,
            exponent: read.number("exponent", "1")?,
            damping: read.number("damping", "s/m")?,
        },
        _ => {
            let material = material(&read.get("material")?, "material")?;
            checked(object.py(), material.validate())?;
            ContactLaw::Surfaces {
                law: force_law(&read.get("law")?, "law")?,
                contact_modulus: material.contact_modulus(),
                restitution: material.restitution,
                length: read.number("length", "m")?,
                min_approach_speed: read.number("min_approach_speed", "m/s")?,
            }
        }
    })
}

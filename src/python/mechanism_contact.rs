//! Conversion of Python's contacts of a mechanism, with their profiles and laws, to those of this crate.

use pyo3::prelude::*;

use super::describe::{
    LAWS, Reader, chain, kind_of, material, mechanism_law, number, refuse, sprocket, tribology,
    truth,
};
use super::mechanism_fields::{markers, pairs, text};
use crate::geometry::Vec2;
use crate::multibody::{ContactLaw, ContactPair, Piece, Profile, Tribology};

fn points(value: &Bound<'_, PyAny>, field: &str) -> PyResult<Vec<Vec2>> {
    Ok(pairs(value, field)?
        .into_iter()
        .map(|(x, y)| Vec2::new(x, y))
        .collect())
}

pub(super) fn contact(object: &Bound<'_, PyAny>) -> PyResult<ContactPair> {
    let read = Reader::new(object, "contacts", &["Contact"])?;
    let [a, b] = markers(&read)?;
    let name = text(&read, "name")?;
    let field = format!("contact {name:?}");
    let closed = || truth(&read.get("closed")?, "closed");
    let profile = match text(&read, "kind")?.as_str() {
        "bore" => Profile::Bore {
            radius: number(&read.get("profile_radius")?, "bore_radius", "m")?,
        },
        "disc" => Profile::Disc {
            radius: number(&read.get("profile_radius")?, "radius_a", "m")?,
        },
        "sprocket" => {
            let wheel = sprocket(&read.get("sprocket")?, &field)?;
            let chain = chain(&read.get("chain")?, &field)?;
            Profile::Teeth(Box::new(wheel.tooth_profile(&chain)?))
        }
        "polyline" => {
            let points = points(&read.get("points")?, &field)?;
            Profile::polyline(&field, &points, closed()?)?
        }
        _ => Profile::Outline {
            pieces: arcs(&read.get("points")?, &field)?,
            closed: closed()?,
        },
    };
    let law = read.get("law")?;
    Ok(ContactPair {
        a,
        b,
        profile,
        radius: read.number("radius", "m")?,
        law: contact_law(&law)?,
        tribology: surfaces(&law)?,
        name,
    })
}

/// Read pieces (from x, from y, to x, to y, centre x, centre y, 1 where convex, -1 where concave, 0 where straight).
fn arcs(value: &Bound<'_, PyAny>, field: &str) -> PyResult<Vec<Piece>> {
    let rows: Vec<[f64; 7]> = value
        .extract()
        .map_err(|_| refuse(field, value, "must be rows of seven numbers"))?;
    Ok(rows
        .into_iter()
        .map(|[fx, fy, tx, ty, cx, cy, convex]| Piece {
            from: Vec2::new(fx, fy),
            to: Vec2::new(tx, ty),
            // Files of earlier versions have a centre of NaN where a piece is straight.
            center: (convex != 0.0 && !cx.is_nan()).then_some(Vec2::new(cx, cy)),
            convex: convex > 0.0,
        })
        .collect())
}

/// Return friction and film of a contact law, or of the cylinder law in it; the default length of a film is the contact length.
fn surfaces(object: &Bound<'_, PyAny>) -> PyResult<Tribology> {
    if let Ok(law) = object.getattr("law") {
        return tribology(&law);
    }
    let mut found = tribology(object)?;
    if let (Some(film), Ok(length)) = (&mut found.film, object.getattr("length"))
        && film.length.is_none()
        && !length.is_none()
    {
        film.length = Some(number(&length, "length", "m")?);
    }
    Ok(found)
}

fn contact_law(object: &Bound<'_, PyAny>) -> PyResult<ContactLaw> {
    let kinds = ["LinearContact", "HuntCrossley", "SurfaceContact"];
    let given = kind_of(object);
    if LAWS.contains(&given.as_str()) {
        let expected = format!(
            "is a force law; expected a contact law, such as SurfaceContact(law={given}(...), length=...)"
        );
        return Err(refuse("law", object, &expected));
    }
    let read = Reader::new(object, "law", &kinds)?;
    Ok(match read.kind.as_str() {
        "LinearContact" => {
            // Stiffness and damping are per length if a length is given.
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
            material.validate()?;
            ContactLaw::Surfaces {
                law: mechanism_law(&read.get("law")?, "law")?,
                contact_modulus: material.contact_modulus(),
                restitution: material.restitution,
                length: read.number("length", "m")?,
                min_impact_velocity: read.number("min_impact_velocity", "m/s")?,
            }
        }
    })
}

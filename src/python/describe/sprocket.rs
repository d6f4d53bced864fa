//! Readers of sprockets, their motion and their faults.

use pyo3::prelude::*;

use super::reader::{Reader, table};
use super::teeth::tooth_form;
use crate::drive::{Bearing, Faults, Sprocket, SprocketMotion};
use crate::geometry::Damage;
use crate::geometry::path::belt::Side;

/// Read rows (number of a tooth, remaining fraction of its height).
fn damage(read: &Reader<'_, '_>) -> PyResult<Vec<Damage>> {
    let expected = "must be rows (number of the tooth from 0, share of its height that is left)";
    let rows = read.counted_rows("damaged_teeth", expected, "1")?;
    let rows = rows.into_iter();
    Ok(rows
        .map(|(tooth, height)| Damage { tooth, height })
        .collect())
}

pub(super) fn motion(object: &Bound<'_, PyAny>, field: &str) -> PyResult<SprocketMotion> {
    let read = Reader::new(object, field, &["PrescribedSpeed", "AppliedTorque", "Free"])?;
    Ok(match read.kind.as_str() {
        "PrescribedSpeed" => SprocketMotion::PrescribedSpeed(read.signal("speed", "rad/s")?),
        "AppliedTorque" => {
            let torque = read.signal("torque", "N m")?;
            let over_speed = |curve: &_, name: &_| table(curve, name, ("speed", "rad/s"), "N m");
            match read.optional("curve", over_speed)? {
                None => SprocketMotion::AppliedTorque(torque),
                Some(curve) => SprocketMotion::TorqueCurve { torque, curve },
            }
        }
        _ => SprocketMotion::Free,
    })
}

pub(crate) fn sprocket(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Sprocket> {
    let read = Reader::new(object, field, &["Sprocket"])?;
    Ok(Sprocket {
        teeth: read.count("teeth")?,
        center: read.vector("center", "m")?,
        motion: read.part("motion", motion)?,
        profile: read.part("profile", tooth_form)?,
        faults: Faults {
            eccentricity: read.number("eccentricity", "m")?,
            eccentricity_angle: read.number("eccentricity_angle", "rad")?,
            damage: damage(&read)?,
        },
        mass: read.optional_number("mass", "kg")?,
        inertia: read.optional_number("inertia", "kg m^2")?,
        initial_speed: read.optional_number("initial_speed", "rad/s")?,
        bearing: read.word(
            "bearing",
            &[("fixed", Bearing::Fixed), ("floating", Bearing::Floating)],
        )?,
        side: read.word(
            "side",
            &[("inside", Side::Inside), ("outside", Side::Outside)],
        )?,
        load_inertia: read.number("load_inertia", "kg m^2")?,
    })
}

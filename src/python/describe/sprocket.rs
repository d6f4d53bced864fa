//! Readers of sprockets, their motion and their faults.

use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::reader::{Reader, count, number, refuse, table};
use super::teeth::tooth_form;
use crate::drive::{Bearing, Faults, Sprocket, SprocketMotion};
use crate::geometry::Damage;
use crate::geometry::path::belt::Side;

/// Read rows (number of a tooth, remaining fraction of its height).
fn damage(read: &Reader<'_, '_>) -> PyResult<Vec<Damage>> {
    const NAME: &str = "Sprocket.damaged_teeth";
    let rows = read.get("damaged_teeth")?;
    let wrong = |value: &Bound<'_, PyAny>| {
        let expected =
            "must be rows (number of the tooth from 0, share of its height that is left)";
        refuse(value.py(), NAME, value, expected)
    };
    let Ok(rows) = rows.cast::<PyTuple>() else {
        return Err(wrong(&rows));
    };
    let row = |row: Bound<'_, PyAny>| {
        let Ok([tooth, height]) = row.extract::<[Bound<'_, PyAny>; 2]>() else {
            return Err(wrong(&row));
        };
        Ok(Damage {
            tooth: count(&tooth, NAME)?,
            height: number(&height, NAME, "1")?,
        })
    };
    rows.iter().map(row).collect()
}

pub(super) fn motion(object: &Bound<'_, PyAny>, field: &str) -> PyResult<SprocketMotion> {
    let read = Reader::new(object, field, &["PrescribedSpeed", "AppliedTorque", "Free"])?;
    Ok(match read.kind.as_str() {
        "PrescribedSpeed" => SprocketMotion::PrescribedSpeed(read.signal("speed", "rad/s")?),
        "AppliedTorque" => {
            let torque = read.signal("torque", "N m")?;
            let curve = read.get("curve")?;
            if curve.is_none() {
                SprocketMotion::AppliedTorque(torque)
            } else {
                let curve = table(&curve, "AppliedTorque.curve", ("speed", "rad/s"), "N m")?;
                SprocketMotion::TorqueCurve { torque, curve }
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
        motion: motion(&read.get("motion")?, "Sprocket.motion")?,
        profile: tooth_form(&read.get("profile")?, "Sprocket.profile")?,
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

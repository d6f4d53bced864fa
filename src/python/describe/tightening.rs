//! Readers of tensioners, rails, blades and smooth idlers.

use pyo3::prelude::*;

use super::chain::material;
use super::reader::Reader;
use crate::drive::{Arm, Mount, Rail, RailShape, Tensioner};
use crate::geometry::Vec2;

/// Read the two lengths of a travel, without stops by default.
fn travel(read: &Reader<'_, '_>) -> PyResult<[f64; 2]> {
    let given = read.optional_vector("travel", "m")?;
    Ok(given.map_or([f64::INFINITY; 2], Into::into))
}

pub(super) fn tensioner(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Tensioner> {
    let read = Reader::new(object, field, &["Tensioner"])?;
    Ok(Tensioner {
        sprocket: read.count("sprocket")? as usize,
        pretension: read.number("pretension", "N")?,
        ramp_time: read.number("ramp_time", "s")?,
        damping: read.number("damping", "N s/m")?,
        damping_back: read.optional_number("damping_back", "N s/m")?,
        direction: read.optional_vector("direction", "1")?,
        stiffness: read.number("stiffness", "N/m")?,
        travel: travel(&read)?,
        pivot: read.optional_vector("pivot", "m")?,
        arm_inertia: read.number("arm_inertia", "kg m^2")?,
        ratchet: read.optional_number("ratchet", "m")?,
    })
}

pub(super) fn arm(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Arm> {
    let read = Reader::new(object, field, &["GuideArm"])?;
    Ok(Arm {
        pivot: read.vector("pivot", "m")?,
        force: read.number("force", "N")?,
        ramp_time: read.number("ramp_time", "s")?,
        stiffness: read.number("stiffness", "N/m")?,
        damping: read.number("damping", "N s/m")?,
        damping_back: read.optional_number("damping_back", "N s/m")?,
        travel: travel(&read)?,
        inertia: read.number("inertia", "kg m^2")?,
        ratchet: read.optional_number("ratchet", "m")?,
    })
}

pub(crate) fn rail(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Rail> {
    let read = Reader::new(object, field, &["GuideRail", "SmoothIdler"])?;
    let of = read.optional("material", material)?;
    let center = read.vector("center", "m")?;
    if read.kind == "SmoothIdler" {
        return Ok(Rail {
            shape: RailShape::Wheel {
                radius: read.number("radius", "m")?,
            },
            center,
            direction: Vec2::x(),
            mount: read
                .optional_number("inertia", "kg m^2")?
                .map_or(Mount::Fixed, |inertia| Mount::Turning { inertia }),
            material: of,
            plate_height: read.optional_number("plate_height", "m")?,
        });
    }
    Ok(Rail {
        shape: RailShape::Bar {
            length: read.number("length", "m")?,
            radius: read.optional_number("radius", "m")?,
            end_radius: read.number("end_radius", "m")?,
        },
        center,
        direction: read.vector("direction", "1")?,
        mount: read.optional("arm", arm)?.map_or(Mount::Fixed, Mount::Arm),
        material: of,
        plate_height: read.optional_number("plate_height", "m")?,
    })
}

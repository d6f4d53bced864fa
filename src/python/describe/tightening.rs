//! Readers of tensioners, rails, blades and smooth idlers.

use pyo3::prelude::*;

use super::chain::material;
use super::reader::Reader;
use crate::drive::{Arm, Mount, Rail, RailShape, Tensioner};
use crate::geometry::Vec2;

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
        travel: if read.get("travel")?.is_none() {
            [f64::INFINITY; 2]
        } else {
            read.vector("travel", "m")?.into()
        },
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
        travel: if read.get("travel")?.is_none() {
            [f64::INFINITY; 2]
        } else {
            read.vector("travel", "m")?.into()
        },
        inertia: read.number("inertia", "kg m^2")?,
        ratchet: read.optional_number("ratchet", "m")?,
    })
}

pub(crate) fn rail(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Rail> {
    let read = Reader::new(object, field, &["GuideRail", "SmoothIdler"])?;
    let own = read.get("material")?;
    let of = if own.is_none() {
        None
    } else {
        Some(material(&own, &read.name("material"))?)
    };
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
    let swung = read.get("arm")?;
    Ok(Rail {
        shape: RailShape::Bar {
            length: read.number("length", "m")?,
            radius: read.optional_number("radius", "m")?,
            end_radius: read.number("end_radius", "m")?,
        },
        center,
        direction: read.vector("direction", "1")?,
        mount: if swung.is_none() {
            Mount::Fixed
        } else {
            Mount::Arm(arm(&swung, "GuideRail.arm")?)
        },
        material: of,
        plate_height: read.optional_number("plate_height", "m")?,
    })
}

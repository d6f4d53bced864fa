//! A chain, its links, hinges and material.

use pyo3::prelude::*;

use super::reader::Reader;
use crate::drive::{Chain, ClearanceHinge, Link, Material, Roller, Variation};

pub(in crate::python) fn material(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Material> {
    let read = Reader::new(object, field, &["Material"])?;
    Ok(Material {
        elastic_modulus: read.number("elastic_modulus", "Pa")?,
        poisson_ratio: read.number("poisson_ratio", "1")?,
        restitution: read.number("restitution", "1")?,
    })
}

pub(super) fn link(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Link> {
    let read = Reader::new(object, field, &["Link"])?;
    Ok(Link {
        mass: read.number("mass", "kg")?,
        inertia: read.number("inertia", "kg m^2")?,
    })
}

pub(super) fn hinge(object: &Bound<'_, PyAny>, field: &str) -> PyResult<ClearanceHinge> {
    let read = Reader::new(object, field, &["ClearanceHinge"])?;
    Ok(ClearanceHinge {
        pin_radius: read.number("pin_radius", "m")?,
        bore_radius: read.number("bore_radius", "m")?,
        length: read.number("length", "m")?,
    })
}

pub(super) fn roller(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Roller> {
    let read = Reader::new(object, field, &["Roller"])?;
    Ok(Roller {
        radius: read.number("radius", "m")?,
        bore_radius: read.number("bore_radius", "m")?,
        length: read.number("length", "m")?,
        mass: read.number("mass", "kg")?,
        inertia: read.number("inertia", "kg m^2")?,
    })
}

pub(in crate::python) fn chain(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Chain> {
    let read = Reader::new(object, field, &["Chain"])?;
    read.check_text("name")?;
    Ok(Chain {
        pitch: read.number("pitch", "m")?,
        links: read.count("links")?,
        inner: link(&read.get("inner")?, "Chain.inner")?,
        outer: link(&read.get("outer")?, "Chain.outer")?,
        hinge: hinge(&read.get("hinge")?, "Chain.hinge")?,
        bushing_radius: read.number("bushing_radius", "m")?,
        tooth_contact_length: read.number("tooth_contact_length", "m")?,
        material: material(&read.get("material")?, "Chain.material")?,
        offset: {
            let offset = read.get("offset")?;
            if offset.is_none() {
                None
            } else {
                Some(link(&offset, "Chain.offset")?)
            }
        },
        strands: read.count("strands")?,
        variation: Variation {
            elongation: read.numbers("elongation", "1")?,
            pitch_spread: read.number("pitch_spread", "1")?,
            seed: u64::from(read.count("seed")?),
        },
        roller: {
            let given = read.get("roller")?;
            if given.is_none() {
                None
            } else {
                Some(roller(&given, "Chain.roller")?)
            }
        },
        link_stiffness: read.optional_number("link_stiffness", "N/m")?,
    })
}

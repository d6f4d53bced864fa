//! Readers of a chain, its links, hinges and material.

use pyo3::prelude::*;

use super::reader::{Reader, kind_of, number};
use crate::drive::{
    Chain, ClearanceHinge, Link, LinkStiffness, Material, Plates, Roller, Variation,
};

pub(crate) fn material(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Material> {
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

pub(super) fn plates(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Plates> {
    let read = Reader::new(object, field, &["Plates"])?;
    Ok(Plates {
        inner_section: read.number("inner_section", "m^2")?,
        outer_section: read.number("outer_section", "m^2")?,
        elastic_modulus: read.optional_number("elastic_modulus", "Pa")?,
    })
}

/// Read a stiffness, or the plates that determine it.
fn link_stiffness(given: &Bound<'_, PyAny>, name: &str) -> PyResult<LinkStiffness> {
    Ok(match kind_of(given).as_str() {
        "Plates" => LinkStiffness::Of(plates(given, name)?),
        _ => LinkStiffness::Given(number(given, name, "N/m, or Plates")?),
    })
}

pub(crate) fn chain(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Chain> {
    let read = Reader::new(object, field, &["Chain"])?;
    read.check_text("name")?;
    let of_carried = "must be rows (number of the link from 1, mass in kg)";
    Ok(Chain {
        pitch: read.number("pitch", "m")?,
        links: read.count("links")?,
        inner: read.part("inner", link)?,
        outer: read.part("outer", link)?,
        hinge: read.part("hinge", hinge)?,
        bushing_radius: read.number("bushing_radius", "m")?,
        tooth_contact_length: read.number("tooth_contact_length", "m")?,
        material: read.part("material", material)?,
        offset: read.optional("offset", link)?,
        strands: read.count("strands")?,
        variation: Variation {
            elongation: read.numbers("elongation", "1")?,
            pitch_spread: read.number("pitch_spread", "1")?,
            seed: u64::from(read.count("seed")?),
        },
        roller: read.optional("roller", roller)?,
        link_stiffness: read.optional("link_stiffness", link_stiffness)?,
        carried: read.counted_rows("carried", of_carried, "kg")?,
    })
}

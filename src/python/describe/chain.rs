//! Readers of a chain, its links, hinges and material.

use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::reader::{Reader, count, kind_of, number, refuse};
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

/// Read rows (number of a link, mass).
fn carried(read: &Reader<'_, '_>) -> PyResult<Vec<(u32, f64)>> {
    const NAME: &str = "Chain.carried";
    let rows = read.get("carried")?;
    let wrong = |value: &Bound<'_, PyAny>| {
        let expected = "must be rows (number of the link from 1, mass in kg)";
        refuse(value.py(), NAME, value, expected)
    };
    let Ok(rows) = rows.cast::<PyTuple>() else {
        return Err(wrong(&rows));
    };
    let row = |row: Bound<'_, PyAny>| {
        let Ok([link, mass]) = row.extract::<[Bound<'_, PyAny>; 2]>() else {
            return Err(wrong(&row));
        };
        Ok((count(&link, NAME)?, number(&mass, NAME, "kg")?))
    };
    rows.iter().map(row).collect()
}

/// Read a stiffness, or the plates that determine it.
fn link_stiffness(read: &Reader<'_, '_>) -> PyResult<Option<LinkStiffness>> {
    const NAME: &str = "link_stiffness";
    let given = read.get(NAME)?;
    if given.is_none() {
        return Ok(None);
    }
    if kind_of(&given) == "Plates" {
        return plates(&given, "Chain.link_stiffness")
            .map(|plates| Some(LinkStiffness::Of(plates)));
    }
    let number = read.number(NAME, "N/m, or Plates")?;
    Ok(Some(LinkStiffness::Given(number)))
}

pub(crate) fn chain(object: &Bound<'_, PyAny>, field: &str) -> PyResult<Chain> {
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
        link_stiffness: link_stiffness(&read)?,
        carried: carried(&read)?,
    })
}

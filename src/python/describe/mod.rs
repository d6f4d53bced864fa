//! Readers of Python's frozen dataclasses: conversion to the descriptions of this crate, field by field.

mod chain;
mod ends;
mod laws;
mod reader;
mod run;
mod sprocket;
mod teeth;
mod tightening;

use pyo3::prelude::*;

use super::errors::InvalidInput;
use crate::drive::{Drive, HingeKind};
use chain::{hinge, link, plates, roller};
use ends::{ENDS, chain_ends};
use laws::{film_of, friction_law};
use reader::SIGNALS;
use sprocket::motion;
use teeth::{FORMS, outline_piece, tooth_form};
use tightening::{arm, tensioner};

pub(super) use chain::{chain, material};
pub(super) use ends::chain_end;
pub(super) use laws::{
    LAWS, damping, film, force_laws, friction, law_and_friction, law_of, mechanism_law,
    min_impact_velocity, tribology,
};
pub(super) use reader::{
    Reader, count, finite, kind_of, number, refuse, shown, signal, table, truth, two_teeth,
};
pub(super) use run::{drive_groups, mechanism_groups, reports, solver};
pub(super) use sprocket::sprocket;
pub(super) use tightening::rail;

/// Read a `ChainDrive` without validation.
pub(super) fn drive(object: &Bound<'_, PyAny>) -> PyResult<Drive> {
    let read = Reader::new(object, "drive", &["ChainDrive"])?;
    read.check_text("name")?;
    let of_guides = "must be a sequence of GuideRail and SmoothIdler";
    Ok(Drive {
        chain: read.part("chain", chain)?,
        sprockets: read.sequence("sprockets", "must be a sequence of Sprocket", sprocket)?,
        tensioner: read.optional("tensioner", tensioner)?,
        gravity: read.vector("gravity", "m/s^2")?,
        guides: read.sequence("guides", of_guides, rail)?,
        ends: read.optional("ends", chain_ends)?,
        hinge_kind: read.word(
            "hinges",
            &[
                ("clearance", HingeKind::Clearance),
                ("ideal", HingeKind::Ideal),
            ],
        )?,
    })
}

/// Raise `InvalidInput` if a field of a description is invalid.
#[pyfunction]
pub(super) fn validate(description: &Bound<'_, PyAny>) -> PyResult<()> {
    let object = description;
    match kind_of(object).as_str() {
        "Material" => material(object, "")?.validate()?,
        "Link" => link(object, "")?.validate()?,
        "ClearanceHinge" => hinge(object, "")?.validate()?,
        "Roller" => roller(object, "")?.validate()?,
        "Plates" => plates(object, "")?.validate()?,
        "Chain" => chain(object, "")?.validate()?,
        kind if FORMS.contains(&kind) => tooth_form(object, "")?.validate()?,
        "ToothLine" | "ToothArc" => outline_piece(object, "").map(drop)?,
        "PrescribedSpeed" | "AppliedTorque" | "Free" => motion(object, "").map(drop)?,
        // The argument of a table may be time or any other quantity.
        "Table" => table(object, "Table.rows", ("argument", ""), "its unit").map(drop)?,
        kind if SIGNALS.contains(&kind) => signal(object, kind, "its unit").map(drop)?,
        "Sprocket" => sprocket(object, "")?.validate()?,
        "Tensioner" => tensioner(object, "")?.validate()?,
        "GuideArm" => arm(object, "")?.validate()?,
        "GuideRail" | "SmoothIdler" => rail(object, "guide")?.validate()?,
        kind if ENDS.contains(&kind) => chain_end(object, "")?.validate()?,
        "ChainDrive" => drive(object)?.validate()?,
        "Solver" => solver(object).map(drop)?,
        kind if LAWS.contains(&kind) => {
            film_of(object, "")?;
            law_and_friction(object, "").map(drop)?;
        }
        "Coulomb" | "LuGre" => friction_law(object, "").map(drop)?,
        "LubricantFilm" => film(object, "").map(drop)?,
        kind => {
            let remedy = if object.getattr_opt("elastic_force")?.is_some() {
                "; expected one of the force laws of the package, such as Hertz(): a law of your own is possible as \
                 Mechanism.add_callable only"
            } else {
                ""
            };
            return Err(InvalidInput::new_err(format!(
                "{kind} is not a description that this version knows{remedy}"
            )));
        }
    }
    Ok(())
}

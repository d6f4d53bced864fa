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
use pyo3::types::PyTuple;

use super::errors::InvalidInput;
use crate::drive::{Drive, HingeKind};
use chain::{hinge, link, plates, roller};
use ends::{ENDS, chain_ends};
use laws::{LAWS, film_of, rubbing};
use reader::{SIGNALS, kind_of};
use sprocket::motion;
use teeth::{FORMS, outline_piece, tooth_form};
use tightening::{arm, tensioner};

pub(super) use chain::{chain, material};
pub(super) use ends::chain_end;
pub(super) use laws::{
    damping, film, force_laws, friction, law_and_friction, law_of, law_or_common,
    min_impact_velocity, tribology,
};
pub(super) use reader::{
    Reader, checked, count, finite, number, refuse, signal, table, truth, two_teeth,
};
pub(super) use run::{drive_groups, ideal_groups, mechanism_groups, reports, solver};
pub(super) use sprocket::sprocket;
pub(super) use tightening::rail;

/// Read a `ChainDrive` without validation.
pub(super) fn drive(object: &Bound<'_, PyAny>) -> PyResult<Drive> {
    let read = Reader::new(object, "drive", &["ChainDrive"])?;
    read.check_text("name")?;
    let sprockets = read.get("sprockets")?;
    let Ok(sprockets) = sprockets.cast::<PyTuple>() else {
        return Err(refuse(
            object.py(),
            "ChainDrive.sprockets",
            &sprockets,
            "must be a sequence of Sprocket",
        ));
    };
    let guides = read.get("guides")?;
    let Ok(guides) = guides.cast::<PyTuple>() else {
        return Err(refuse(
            object.py(),
            "ChainDrive.guides",
            &guides,
            "must be a sequence of GuideRail and SmoothIdler",
        ));
    };
    let tight = read.get("tensioner")?;
    Ok(Drive {
        chain: chain(&read.get("chain")?, "ChainDrive.chain")?,
        sprockets: sprockets
            .iter()
            .enumerate()
            .map(|(i, s)| sprocket(&s, &format!("ChainDrive.sprockets.{}", i + 1)))
            .collect::<PyResult<_>>()?,
        tensioner: if tight.is_none() {
            None
        } else {
            Some(tensioner(&tight, "ChainDrive.tensioner")?)
        },
        gravity: read.vector("gravity", "m/s^2")?,
        guides: guides
            .iter()
            .enumerate()
            .map(|(i, guide)| rail(&guide, &format!("ChainDrive.guides.{}", i + 1)))
            .collect::<PyResult<_>>()?,
        ends: chain_ends(&read)?,
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
    let outcome = match kind_of(object).as_str() {
        "Material" => material(object, "")?.validate(),
        "Link" => link(object, "")?.validate(),
        "ClearanceHinge" => hinge(object, "")?.validate(),
        "Roller" => roller(object, "")?.validate(),
        "Plates" => plates(object, "")?.validate(),
        "Chain" => chain(object, "")?.validate(),
        kind if FORMS.contains(&kind) => tooth_form(object, "")?.validate(),
        "ToothLine" | "ToothArc" => outline_piece(object, "").map(|_| Ok(()))?,
        "PrescribedSpeed" | "AppliedTorque" | "Free" => motion(object, "").map(|_| Ok(()))?,
        // The argument of a table may be time or any other quantity.
        "Table" => table(object, "Table.rows", ("argument", ""), "its unit").map(|_| Ok(()))?,
        kind if SIGNALS.contains(&kind) => signal(object, kind, "its unit").map(|_| Ok(()))?,
        "Sprocket" => sprocket(object, "")?.validate(),
        "Tensioner" => tensioner(object, "")?.validate(),
        "GuideArm" => arm(object, "")?.validate(),
        "GuideRail" | "SmoothIdler" => rail(object, "guide")?.validate(),
        kind if ENDS.contains(&kind) => chain_end(object, "")?.validate(),
        "ChainDrive" => drive(object)?.validate(),
        "Solver" => solver(object).map(|_| Ok(()))?,
        kind if LAWS.contains(&kind) => {
            film_of(object, "")?;
            law_and_friction(object, "").map(|_| Ok(()))?
        }
        "Coulomb" | "LuGre" => rubbing(object, "").map(|_| Ok(()))?,
        "LubricantFilm" => film(object, "").map(|_| Ok(()))?,
        kind => {
            return Err(InvalidInput::new_err(format!(
                "{kind} is not a description that this version knows"
            )));
        }
    };
    checked(object.py(), outcome)
}

//! Readers of the tooth forms of sprockets.

use pyo3::prelude::*;
use pyo3::types::{PyString, PyTuple};

use super::reader::{Reader, number, refuse};
use crate::drive::{AnsiTooth, CustomTooth, IsoTooth, StraightTooth, Tip, ToothForm};
use crate::geometry::{OutlinePiece, Seat};

pub(super) const FORMS: [&str; 4] = ["AnsiTooth", "IsoTooth", "StraightTooth", "CustomTooth"];

fn seat(read: &Reader<'_, '_>) -> PyResult<Seat> {
    read.word(
        "seat",
        &[
            ("bottom-diameter", Seat::BottomDiameter),
            ("pitch-circle", Seat::PitchCircle),
        ],
    )
}

pub(super) fn tooth_form(object: &Bound<'_, PyAny>, field: &str) -> PyResult<ToothForm> {
    let read = Reader::new(object, field, &FORMS)?;
    let edge_radius = read.optional_number("edge_radius", "m")?;
    Ok(match read.kind.as_str() {
        "AnsiTooth" => ToothForm::Ansi(AnsiTooth {
            seat: seat(&read)?,
            roller_diameter: read.optional_number("roller_diameter", "m")?,
            tip: read.word("tip", &[("full", Tip::Full), ("cut", Tip::Cut)])?,
            edge_radius,
        }),
        "IsoTooth" => ToothForm::Iso(IsoTooth {
            gap: iso_gap(&read)?,
            seat: seat(&read)?,
            roller_diameter: read.optional_number("roller_diameter", "m")?,
            tip_diameter: read.optional_number("tip_diameter", "m")?,
            edge_radius,
        }),
        "StraightTooth" => ToothForm::Straight(StraightTooth {
            flank_angle: read.number("flank_angle", "rad")?,
            seat_radius: read.optional_number("seat_radius", "m")?,
            seat: seat(&read)?,
            roller_diameter: read.optional_number("roller_diameter", "m")?,
            tip_diameter: read.optional_number("tip_diameter", "m")?,
            edge_radius,
        }),
        _ => ToothForm::Custom(CustomTooth {
            pieces: outline(&read)?,
            tip_diameter: read.optional_number("tip_diameter", "m")?,
            edge_radius,
        }),
    })
}

/// Read the position between the minimum gap (0) and the maximum gap (1), or one of the two by name.
fn iso_gap(read: &Reader<'_, '_>) -> PyResult<f64> {
    let gap = read.get("gap")?;
    if gap.is_instance_of::<PyString>() {
        return read.word("gap", &[("minimum", 0.0), ("maximum", 1.0)]);
    }
    number(&gap, "IsoTooth.gap", "1")
}

fn outline(read: &Reader<'_, '_>) -> PyResult<Vec<OutlinePiece>> {
    let pieces = read.get("pieces")?;
    let Ok(pieces) = pieces.cast::<PyTuple>() else {
        let expected = "must be a sequence of ToothLine and ToothArc";
        return Err(refuse(pieces.py(), "CustomTooth.pieces", &pieces, expected));
    };
    let piece = |(i, piece): (usize, Bound<'_, PyAny>)| {
        let field = format!("CustomTooth.pieces.{}", i + 1);
        outline_piece(&piece, &field)
    };
    pieces.iter().enumerate().map(piece).collect()
}

pub(super) fn outline_piece(object: &Bound<'_, PyAny>, field: &str) -> PyResult<OutlinePiece> {
    let read = Reader::new(object, field, &["ToothLine", "ToothArc"])?;
    Ok(OutlinePiece {
        start: read.vector("start", "m")?,
        end: read.vector("end", "m")?,
        center: if read.kind == "ToothArc" {
            Some(read.vector("center", "m")?)
        } else {
            None
        },
    })
}

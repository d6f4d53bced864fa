//! Readers of the tooth forms of sprockets.

use pyo3::prelude::*;

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
    let of_pieces = "must be a sequence of ToothLine and ToothArc";
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
            pieces: read.sequence("pieces", of_pieces, outline_piece)?,
            tip_diameter: read.optional_number("tip_diameter", "m")?,
            edge_radius,
        }),
    })
}

/// Read the position between the minimum gap (0) and the maximum gap (1), or one of the two by name.
fn iso_gap(read: &Reader<'_, '_>) -> PyResult<f64> {
    let gap = read.get("gap")?;
    match gap.extract::<&str>() {
        Ok("minimum") => Ok(0.0),
        Ok("maximum") => Ok(1.0),
        _ => number(&gap, "IsoTooth.gap", "1").map_err(|_| {
            let expected = "must be a number from 0 to 1, or \"minimum\" or \"maximum\"";
            refuse("IsoTooth.gap", &gap, expected)
        }),
    }
}

pub(super) fn outline_piece(object: &Bound<'_, PyAny>, field: &str) -> PyResult<OutlinePiece> {
    let read = Reader::new(object, field, &["ToothLine", "ToothArc"])?;
    Ok(OutlinePiece {
        start: read.vector("start", "m")?,
        end: read.vector("end", "m")?,
        center: (read.kind == "ToothArc")
            .then(|| read.vector("center", "m"))
            .transpose()?,
    })
}

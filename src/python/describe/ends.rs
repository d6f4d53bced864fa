//! Readers of the ends of an open chain.

use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::reader::{Reader, count, refuse, signal};
use crate::drive::ChainEnd;
use crate::math::{Signal, Table};

pub(super) const ENDS: [&str; 3] = ["AnchoredEnd", "LoadedEnd", "FreeEnd"];

/// Read an end of an open chain.
pub(crate) fn chain_end(object: &Bound<'_, PyAny>, field: &str) -> PyResult<ChainEnd> {
    let read = Reader::new(object, field, &ENDS)?;
    let links = read.optional("links", count)?;
    Ok(match read.kind.as_str() {
        "AnchoredEnd" => ChainEnd::Anchored {
            position: read.vector("position", "m")?,
            velocity: read.part("velocity", end_velocity)?,
            links,
        },
        "LoadedEnd" => {
            let mass = read.number("mass", "kg")?;
            ChainEnd::Loaded {
                mass,
                inertia: read
                    .optional_number("inertia", "kg m^2")?
                    .unwrap_or_else(|| ChainEnd::ball_inertia(mass)),
                arm: read.number("arm", "m")?,
                position: read.optional_vector("position", "m")?,
                links,
            }
        }
        _ => ChainEnd::Free {
            position: read.optional_vector("position", "m")?,
            links,
        },
    })
}

/// Read two functions of time, or rows (time, x, y).
fn end_velocity(value: &Bound<'_, PyAny>, name: &str) -> PyResult<[Signal; 2]> {
    let wrong = || {
        let expected =
            "must be two numbers (x, y) in m/s, two functions of time, or rows (time, x, y)";
        refuse(name, value, expected)
    };
    let given = value.cast::<PyTuple>().map_err(|_| wrong())?;
    let is_row = |item: &Bound<'_, PyAny>| item.extract::<[f64; 3]>().is_ok();
    // Two rows (time, x, y) are no functions of time, which have two numbers in each of their rows.
    if let Ok([x, y]) = given.extract::<[Bound<'_, PyAny>; 2]>()
        && !(is_row(&x) || is_row(&y))
    {
        return Ok([signal(&x, name, "m/s")?, signal(&y, name, "m/s")?]);
    }
    let first = given.get_item(0).map_err(|_| wrong())?;
    if !first.is_instance_of::<PyTuple>() {
        return Err(wrong());
    }
    let mut both = [Vec::new(), Vec::new()];
    for row in given {
        let Ok([t, x, y]) = row.extract::<[f64; 3]>() else {
            let expected = "each row must be (time, x, y) in s and m/s";
            return Err(refuse(name, &row, expected));
        };
        both[0].push((t, x));
        both[1].push((t, y));
    }
    let table = |rows: &[(f64, f64)]| Table::new(name, "m/s", rows).map(Signal::Table);
    Ok([table(&both[0])?, table(&both[1])?])
}

/// Read the two ends of an open chain.
pub(super) fn chain_ends(value: &Bound<'_, PyAny>, name: &str) -> PyResult<[ChainEnd; 2]> {
    let Ok([first, last]) = value.extract::<[Bound<'_, PyAny>; 2]>() else {
        let expected = "must be None, or two of AnchoredEnd, LoadedEnd and FreeEnd";
        return Err(refuse(name, value, expected));
    };
    Ok([
        chain_end(&first, &format!("{name}.1"))?,
        chain_end(&last, &format!("{name}.2"))?,
    ])
}

//! Rows and recordings as `NumPy` arrays.

use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Error;
use crate::system::{Recording, Values};

pub(super) type RecordedRows = Vec<[f64; 3]>;

/// Read rows of three numbers, one row per body.
pub(super) fn rows(
    field: &str,
    array: Option<&PyReadonlyArray2<'_, f64>>,
) -> PyResult<Option<RecordedRows>> {
    let Some(array) = array else { return Ok(None) };
    let array = array.as_array();
    if array.ncols() != 3 {
        return Err(Error::invalid(
            field,
            format!("an array of shape ({}, {})", array.nrows(), array.ncols()),
            "must have three columns (x, y, theta)",
        )
        .into());
    }
    let rows = array.rows().into_iter();
    Ok(Some(rows.map(|r| [r[0], r[1], r[2]]).collect()))
}

/// Return rows of `N` numbers as an array (rows, `N`).
pub(super) fn table<const N: usize>(
    py: Python<'_>,
    rows: Vec<[f64; N]>,
) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let count = rows.len();
    let flat: Vec<f64> = rows.into_iter().flatten().collect();
    flat.into_pyarray(py).reshape([count, N])
}

/// Return all channels of a recording, time first.
pub(super) fn recorded(py: Python<'_>, recording: Recording) -> PyResult<Bound<'_, PyDict>> {
    let rows = recording.time.len();
    let arrays = PyDict::new(py);
    arrays.set_item("time", recording.time.into_pyarray(py))?;
    for channel in recording.channels {
        let shape: Vec<usize> = std::iter::once(rows).chain(channel.row_shape).collect();
        match channel.values {
            Values::Real(values) => {
                arrays.set_item(channel.name, values.into_pyarray(py).reshape(shape)?)?;
            }
            Values::Whole(values) => {
                arrays.set_item(channel.name, values.into_pyarray(py).reshape(shape)?)?;
            }
        }
    }
    Ok(arrays)
}

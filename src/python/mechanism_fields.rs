//! Fields that several parts of a mechanism have, for Python's description of it.

use pyo3::prelude::*;

use super::describe::{Reader, refuse};
use crate::multibody::Marker;

pub(super) fn text(read: &Reader<'_, '_>, field: &str) -> PyResult<String> {
    let value = read.get(field)?;
    value
        .extract()
        .map_err(|_| refuse(field, &value, "must be text"))
}

pub(super) fn markers(read: &Reader<'_, '_>) -> PyResult<[Marker; 2]> {
    let marker = |body: &str, point: &str| {
        Ok::<_, PyErr>(Marker {
            body: text(read, body)?,
            point: read.vector(point, "m")?,
        })
    };
    Ok([marker("body_a", "point_a")?, marker("body_b", "point_b")?])
}

pub(super) fn pairs(value: &Bound<'_, PyAny>, field: &str) -> PyResult<Vec<(f64, f64)>> {
    value
        .extract()
        .map_err(|_| refuse(field, value, "must be rows of two numbers"))
}

//! Radii of tooth surfaces, for Python.

use pyo3::prelude::*;

use super::describe;
use crate::geometry::SurfaceCurve;

/// Return the radii of the surfaces of whole teeth \[m\], from the seat outward: positive if concave, negative if convex, infinite if
/// straight.
#[pyfunction]
pub(super) fn tooth_radii(
    sprocket: &Bound<'_, PyAny>,
    chain: &Bound<'_, PyAny>,
) -> PyResult<Vec<f64>> {
    let described = describe::sprocket(sprocket, "sprocket")?;
    let chain = describe::chain(chain, "chain")?;
    let profile = describe::checked(sprocket.py(), described.tooth_profile(&chain))?;
    let radius = |curve: &SurfaceCurve| match curve {
        SurfaceCurve::Concave(arc) => arc.radius,
        SurfaceCurve::Convex(arc) => -arc.radius,
        SurfaceCurve::Straight(_) => f64::INFINITY,
    };
    let whole = profile.whole();
    Ok(whole.iter().map(|piece| radius(&piece.curve)).collect())
}

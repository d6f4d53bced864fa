//! Free functions for Python.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use super::describe;
use super::errors::to_python;
use crate::drive::bushing_on_front;
use crate::error::{Error, check};
use crate::force_law::{SurfacePair, effective_restitution as obtained, elastic_forces};
use crate::geometry::{Vec2, unit};
use crate::math::simd::InstructionSet;

/// Return the instruction set of the kernels on this machine: "avx512", "avx2", "neon" or "plain".
///
/// "avx512" and "avx2" give the same bits; "plain", without fused multiply-add, differs by rounding.
#[pyfunction]
pub(super) fn instruction_set() -> &'static str {
    InstructionSet::detect().name()
}

/// Maximum number of points on each arc of an outline: 14 million on a sprocket of 1000 teeth with 14 arcs each.
const MOST_POINTS: f64 = 1e3;

/// Read the number of points on each arc of an outline.
fn points_of_arcs(points: &Bound<'_, PyAny>) -> PyResult<usize> {
    let count = describe::count(points, "points")?;
    let allowed = check::within("points", f64::from(count), 2.0, MOST_POINTS);
    describe::checked(points.py(), allowed).map(|()| count as usize)
}

/// Return the closed outline of a sprocket in its own frame \[m\], (points, 2).
#[pyfunction]
pub(super) fn tooth_outline<'py>(
    sprocket: &Bound<'py, PyAny>,
    chain: &Bound<'py, PyAny>,
    points: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let points = points_of_arcs(points)?;
    let sprocket_description = describe::sprocket(sprocket, "sprocket")?;
    let chain = describe::chain(chain, "chain")?;
    let profile = describe::checked(sprocket.py(), sprocket_description.tooth_profile(&chain))?;
    let outline = profile.outline(points);
    let rows = outline.len();
    let flat: Vec<f64> = outline.into_iter().flat_map(|p| [p.x, p.y]).collect();
    flat.into_pyarray(sprocket.py()).reshape([rows, 2])
}

/// Return the closed outline of a guide around its described position, in a frame whose x axis is the outward normal of its face \[m\].
#[pyfunction]
pub(super) fn guide_outline<'py>(
    guide: &Bound<'py, PyAny>,
    points: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let described = describe::rail(guide, "guide")?;
    describe::checked(guide.py(), described.validate())?;
    let count = points_of_arcs(points)?;
    let profile = describe::checked(guide.py(), described.profile())?;
    let outline = profile.outline(count);
    let rows = outline.len();
    let below = described.depth();
    let flat: Vec<f64> = outline
        .into_iter()
        .flat_map(|p| [p.x - below, p.y])
        .collect();
    flat.into_pyarray(guide.py()).reshape([rows, 2])
}

/// Return the names of the surfaces of whole teeth, from the seat outward.
#[pyfunction]
pub(super) fn tooth_surfaces(
    sprocket: &Bound<'_, PyAny>,
    chain: &Bound<'_, PyAny>,
) -> PyResult<Vec<&'static str>> {
    let described = describe::sprocket(sprocket, "sprocket")?;
    let chain = describe::chain(chain, "chain")?;
    let profile = describe::checked(sprocket.py(), described.tooth_profile(&chain))?;
    Ok(profile.whole().iter().map(|piece| piece.name).collect())
}

/// Return for each link: distance of its hinges \[m\], mass \[kg\], moment of inertia \[kg m²\], and 1 if a bushing is at its front,
/// (links, 4).
#[pyfunction]
pub(super) fn chain_links<'py>(chain: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let described = describe::chain(chain, "chain")?;
    describe::checked(chain.py(), described.validate())?;
    let pitches = described.link_pitches();
    let count = pitches.len();
    let rows = pitches.into_iter().enumerate().flat_map(|(i, pitch)| {
        let link = described.link(i);
        let on_front = f64::from(bushing_on_front(i, count));
        [pitch, link.mass, link.inertia, on_front]
    });
    let flat: Vec<f64> = rows.collect();
    flat.into_pyarray(chain.py()).reshape([count, 4])
}

/// Return the axial stiffness of a link, over all strands \[N/m\]; None: links are rigid.
#[pyfunction]
pub(super) fn link_stiffness(chain: &Bound<'_, PyAny>) -> PyResult<Option<f64>> {
    let described = describe::chain(chain, "chain")?;
    describe::checked(chain.py(), described.validate())?;
    Ok(described.axial_stiffness())
}

/// Return the contacts of cylinders at `points` (n, 2) in the frame of the teeth with a whole sprocket: region (n,), penetration (n,)
/// \[m\], and normal (n, 2), the direction of growing penetration.
#[pyfunction]
#[allow(clippy::type_complexity, clippy::needless_pass_by_value)] // three arrays; PyO3 passes arrays by value
pub(super) fn tooth_contacts<'py>(
    sprocket: &Bound<'py, PyAny>,
    chain: &Bound<'py, PyAny>,
    points: PyReadonlyArray2<'py, f64>,
    radius: f64,
) -> PyResult<(
    Bound<'py, PyArray1<u8>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
)> {
    let py = sprocket.py();
    let described = describe::sprocket(sprocket, "sprocket")?;
    let chain = describe::chain(chain, "chain")?;
    let profile = describe::checked(py, described.tooth_profile(&chain))?;
    let (mut regions, mut depths, mut normals) = (Vec::new(), Vec::new(), Vec::new());
    for row in points.as_array().rows() {
        let point = Vec2::new(row[0], row[1]);
        let gap = profile.nearest_gap(point.y.atan2(point.x));
        let v = unit(f64::from(gap) * profile.gap_angle());
        let u = Vec2::new(v.y, -v.x);
        let place = Vec2::new(point.dot(&u), point.dot(&v) - profile.seat_center_radius);
        let found = profile.contact_in(gap, place, radius);
        let normal = found.normal.x * u + found.normal.y * v;
        regions.push(found.region);
        depths.push(found.penetration);
        normals.extend([normal.x, normal.y]);
    }
    let rows = depths.len();
    Ok((
        regions.into_pyarray(py),
        depths.into_pyarray(py),
        normals.into_pyarray(py).reshape([rows, 2])?,
    ))
}

/// Return the force \[N\] of a film at eccentricities \[m\] and their velocities \[m/s\], along each eccentricity and to its left.
#[pyfunction]
#[allow(clippy::needless_pass_by_value)] // PyO3 passes arrays by value
pub(super) fn film_forces<'py>(
    film: &Bound<'py, PyAny>,
    radii: (f64, f64),
    length: f64,
    eccentricity: PyReadonlyArray1<'py, f64>,
    velocity: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let py = film.py();
    let film = describe::film(film, "film")?;
    let (pin, bore) = radii;
    for (value, name) in [
        (pin, "radii[0]"),
        (bore - pin, "radii[1] - radii[0]"),
        (length, "length"),
    ] {
        describe::checked(py, check::positive(name, value, "m"))?;
    }
    let film = film.between(pin, bore - pin, length);
    let velocities = velocity.as_array();
    let rows = (eccentricity.as_slice()?.iter()).zip(velocities.rows());
    let forces = rows.map(|(&eccentricity, velocity)| {
        film.at(eccentricity, [velocity[0], velocity[1]])
            .force
            .to_vec()
    });
    Ok(PyArray2::from_vec2(py, &forces.collect::<Vec<_>>())?)
}

/// Return the elastic force \[N\] of a law at each penetration \[m\].
#[pyfunction]
#[allow(clippy::too_many_arguments, clippy::needless_pass_by_value)] // the two surfaces; PyO3 passes arrays by value
pub(super) fn law_force<'py>(
    law: &Bound<'py, PyAny>,
    kind: &str,
    radius_i: f64,
    radius_j: f64,
    length: f64,
    material: &Bound<'py, PyAny>,
    penetration: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let py = law.py();
    let modulus = describe::material(material, "material")?.contact_modulus();
    for (value, name) in [
        (radius_i, "radii[0]"),
        (radius_j, "radii[1]"),
        (length, "length"),
    ] {
        describe::checked(py, check::positive(name, value, "m"))?;
    }
    let pair = match kind {
        "internal" if radius_j > radius_i => {
            SurfacePair::internal(radius_i, radius_j, length, modulus)
        }
        "external" => SurfacePair::external(radius_i, radius_j, length, modulus),
        "flat" => SurfacePair::flat(radius_i, radius_j, length, modulus),
        "internal" => {
            return Err(to_python(
                py,
                &Error::invalid(
                    "radii[1]",
                    radius_j,
                    format!("must be larger than radii[0], {radius_i} m"),
                ),
            ));
        }
        _ => {
            return Err(to_python(
                py,
                &Error::invalid(
                    "kind",
                    kind,
                    "must be \"internal\", \"external\" or \"flat\"",
                ),
            ));
        }
    };
    let (law, _) = describe::law_and_friction(law, "law")?;
    Ok(elastic_forces(law.elastic, &pair, penetration.as_slice()?).into_pyarray(py))
}

/// Return the effective restitution of a damping law at the requested `restitution`.
#[pyfunction]
pub(super) fn effective_restitution(
    damping: &str,
    restitution: &Bound<'_, PyAny>,
) -> PyResult<f64> {
    let py = restitution.py();
    let law = describe::damping(damping, py)?;
    let asked = describe::number(restitution, "restitution", "1")?;
    describe::checked(py, check::within("restitution", asked, 0.0, 1.0))?;
    describe::checked(py, law.check("restitution", asked))?;
    Ok(obtained(law.lambda(asked)))
}

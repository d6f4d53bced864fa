//! Free functions for Python.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use super::arrays::table;
use super::describe;
use crate::drive::bushing_on_front;
use crate::error::{Error, check};
use crate::force_law::{self, SurfacePair, elastic_forces};
use crate::geometry::{SurfaceCurve, ToothProfile, Vec2};
use crate::math::simd::InstructionSet;

/// Return the instruction set of the kernels on this machine: "avx512", "avx2", "neon" or "plain".
///
/// "avx512", "avx2" and "neon" give the same bits with the same C library; "plain", without fused multiply-add, differs by rounding.
#[pyfunction]
pub(super) fn instruction_set() -> &'static str {
    InstructionSet::detect().name()
}

/// Maximum number of points on each arc of an outline: 14 million on a sprocket of 1000 teeth with 14 arcs each.
const MOST_POINTS: f64 = 1e3;

/// Read the number of points on each arc of an outline.
fn points_of_arcs(points: &Bound<'_, PyAny>) -> PyResult<usize> {
    let count = describe::count(points, "points")?;
    check::within("points", f64::from(count), 2.0, MOST_POINTS)?;
    Ok(count as usize)
}

/// Read a sprocket and return its tooth profile for a chain.
fn tooth_profile(sprocket: &Bound<'_, PyAny>, chain: &Bound<'_, PyAny>) -> PyResult<ToothProfile> {
    let sprocket = describe::sprocket(sprocket, "sprocket")?;
    Ok(sprocket.tooth_profile(&describe::chain(chain, "chain")?)?)
}

/// Check that radii or lengths, each with its name, are positive.
fn check_lengths<const N: usize>(lengths: [(f64, &str); N]) -> PyResult<()> {
    for (length, name) in lengths {
        check::positive(name, length, "m")?;
    }
    Ok(())
}

/// Return the closed outline of a sprocket in its own frame \[m\], (points, 2).
#[pyfunction]
pub(super) fn tooth_outline<'py>(
    sprocket: &Bound<'py, PyAny>,
    chain: &Bound<'py, PyAny>,
    points: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let points = points_of_arcs(points)?;
    let outline = tooth_profile(sprocket, chain)?.outline(points).into_iter();
    table(sprocket.py(), outline.map(<[f64; 2]>::from).collect())
}

/// Return the closed outline of a guide around its described position, in a frame whose x axis is the outward normal of its face \[m\].
#[pyfunction]
pub(super) fn guide_outline<'py>(
    guide: &Bound<'py, PyAny>,
    points: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let described = describe::rail(guide, "guide")?;
    described.validate()?;
    let count = points_of_arcs(points)?;
    let profile = described.profile()?;
    let outline = profile.outline(count).into_iter();
    let below = described.depth();
    table(guide.py(), outline.map(|p| [p.x - below, p.y]).collect())
}

/// Return the names of the surfaces of whole teeth, from the seat outward.
#[pyfunction]
pub(super) fn tooth_surfaces(
    sprocket: &Bound<'_, PyAny>,
    chain: &Bound<'_, PyAny>,
) -> PyResult<Vec<&'static str>> {
    let profile = tooth_profile(sprocket, chain)?;
    Ok(profile.whole().iter().map(|piece| piece.name).collect())
}

/// Return the radii of the surfaces of whole teeth \[m\], from the seat outward: positive if concave, negative if convex, infinite if
/// straight.
#[pyfunction]
pub(super) fn tooth_radii(
    sprocket: &Bound<'_, PyAny>,
    chain: &Bound<'_, PyAny>,
) -> PyResult<Vec<f64>> {
    let radius = |curve: &SurfaceCurve| match curve {
        SurfaceCurve::Concave(arc) => arc.radius,
        SurfaceCurve::Convex(arc) => -arc.radius,
        SurfaceCurve::Straight(_) => f64::INFINITY,
    };
    let profile = tooth_profile(sprocket, chain)?;
    let whole = profile.whole();
    Ok(whole.iter().map(|piece| radius(&piece.curve)).collect())
}

/// Return for each link: distance of its hinges \[m\], mass \[kg\], moment of inertia \[kg m²\], and 1 if a bushing is at its front,
/// (links, 4).
#[pyfunction]
pub(super) fn chain_links<'py>(chain: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let described = describe::chain(chain, "chain")?;
    described.validate()?;
    let pitches = described.link_pitches();
    let count = pitches.len();
    let rows = pitches.into_iter().enumerate().map(|(i, pitch)| {
        let link = described.link(i);
        let on_front = f64::from(bushing_on_front(i, count));
        [pitch, link.mass, link.inertia, on_front]
    });
    table(chain.py(), rows.collect())
}

/// Return the axial stiffness of a link, over all strands \[N/m\]; None: links are rigid.
#[pyfunction]
pub(super) fn link_stiffness(chain: &Bound<'_, PyAny>) -> PyResult<Option<f64>> {
    let described = describe::chain(chain, "chain")?;
    described.validate()?;
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
    let profile = tooth_profile(sprocket, chain)?;
    let (mut regions, mut depths, mut normals) = (Vec::new(), Vec::new(), Vec::new());
    for row in points.as_array().rows() {
        let point = Vec2::new(row[0], row[1]);
        let (_, found) = profile.contact_in_sprocket(point, radius);
        regions.push(found.region);
        depths.push(found.penetration);
        normals.push(found.normal.into());
    }
    Ok((
        regions.into_pyarray(py),
        depths.into_pyarray(py),
        table(py, normals)?,
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
    let clearance = (bore - pin, "radii[1] - radii[0]");
    check_lengths([(pin, "radii[0]"), clearance, (length, "length")])?;
    let film = film.between(pin, bore - pin, length);
    let velocities = velocity.as_array();
    for &distance in eccentricity.as_slice()? {
        check::not_negative("eccentricity", distance, "m")?;
    }
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
    let radii = [(radius_i, "radii[0]"), (radius_j, "radii[1]")];
    check_lengths([radii[0], radii[1], (length, "length")])?;
    let pair = match kind {
        "internal" if radius_j > radius_i => {
            SurfacePair::internal(radius_i, radius_j, length, modulus)
        }
        "external" => SurfacePair::external(radius_i, radius_j, length, modulus),
        "flat" => SurfacePair::flat(radius_i, radius_j, length, modulus),
        "internal" => {
            let expected = format!("must be larger than radii[0], {radius_i} m");
            return Err(Error::invalid("radii[1]", radius_j, expected).into());
        }
        _ => {
            let expected = "must be \"internal\", \"external\" or \"flat\"";
            return Err(Error::invalid("kind", kind, expected).into());
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
    let law = describe::damping(damping)?;
    let asked = describe::number(restitution, "restitution", "1")?;
    check::within("restitution", asked, 0.0, 1.0)?;
    law.check("restitution", asked)?;
    Ok(force_law::effective_restitution(law.lambda(asked)))
}

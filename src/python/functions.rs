//! Free functions for Python.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::describe;
use super::errors::{InvalidInput, to_python};
use super::interrupt::interruptible;
use crate::drive::bushing_on_front;
use crate::drive::{BeltLine, Drive, MOST_LINKS, check_links};
use crate::error::{Error, check};
use crate::force_law::{SurfacePair, effective_restitution as obtained, elastic_forces};
use crate::geometry::{Vec2, unit};
use crate::integrator::{Adams, OdeSystem, StepControl};
use crate::layout::InitialConfiguration;
use crate::math::simd::InstructionSet;
use crate::run::equilibrium::Equilibrium;

/// Return the instruction set of the kernels on this machine: "avx512", "avx2", "neon" or "plain".
///
/// "avx512" and "avx2" give the same bits; "plain", without fused multiply-add, differs by rounding.
#[pyfunction]
pub(super) fn instruction_set() -> &'static str {
    InstructionSet::detect().name()
}

/// Generate the layout of a drive and return its properties.
#[pyfunction]
pub(super) fn layout<'py>(drive: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
    let py = drive.py();
    let description = describe::drive(drive)?;
    let (_, layout) = describe::checked(py, InitialConfiguration::generate(&description))?;
    let found = PyDict::new(py);
    let numbered = |sprockets: &[usize]| sprockets.iter().map(|s| s + 1).collect::<Vec<_>>();
    let teeth: Vec<u32> = description.sprockets.iter().map(|s| s.teeth).collect();
    let gap_angle = |i: usize| std::f64::consts::TAU / f64::from(teeth[i]);
    let wrap_angle: Vec<f64> = (0..teeth.len())
        .map(|i| f64::from(layout.seated[i]) * gap_angle(i))
        .collect();
    let names: Vec<String> = (0..layout.strands.len())
        .map(|i| layout.strand_name(i))
        .collect();
    found.set_item("links", description.chain.links)?;
    found.set_item("pitch", description.chain.pitch)?;
    found.set_item("belt_pitches", layout.belt_pitches)?;
    found.set_item("order", numbered(&layout.order))?;
    found.set_item("teeth", teeth)?;
    found.set_item(
        "sides",
        layout
            .sides
            .iter()
            .map(|side| side.name())
            .collect::<Vec<_>>(),
    )?;
    found.set_item("center_distance", layout.center_distance)?;
    found.set_item("closing_center_distance", layout.closing_center_distance)?;
    found.set_item("pitch_radius", layout.pitch_radius)?;
    found.set_item("wrap_pitches", layout.seated)?;
    found.set_item("wrap_angle", wrap_angle)?;
    found.set_item("belt_wrap_angle", layout.belt_wrap)?;
    found.set_item("first_seat_angle", layout.first_seat)?;
    found.set_item("phase", layout.phase)?;
    found.set_item("initial_speed", layout.speeds)?;
    found.set_item("strands", names)?;
    found.set_item("strand_pitches", layout.strand_pitches)?;
    found.set_item("strand_span", layout.spans)?;
    found.set_item("strand_slack", layout.slack)?;
    found.set_item("sag", layout.sag)?;
    found.set_item("hinge_stretch", layout.hinge_stretch)?;
    found.set_item("start_gap", layout.start_gap)?;
    found.set_item("speed_ratios", layout.speed_ratio)?;
    found.set_item("tension_force", layout.tension_force)?;
    let guides = &layout.guides;
    found.set_item(
        "guide_gap",
        guides.iter().map(|g| g.gap).collect::<Vec<_>>(),
    )?;
    found.set_item(
        "guide_turn",
        guides.iter().map(|g| g.turn).collect::<Vec<_>>(),
    )?;
    found.set_item(
        "guide_travel",
        guides.iter().map(|g| g.travel).collect::<Vec<_>>(),
    )?;
    found.set_item(
        "guide_bushings",
        guides.iter().map(|g| g.bushings).collect::<Vec<_>>(),
    )?;
    found.set_item(
        "guide_place",
        guides.iter().map(|g| g.place.clone()).collect::<Vec<_>>(),
    )?;
    found.set_item("warnings", layout.warnings)?;
    Ok(found)
}

/// Find the static equilibrium of a drive: positions, velocities at the start of a run, and the residual.
#[pyfunction]
pub(super) fn static_start<'py>(
    drive: &Bound<'py, PyAny>,
    force_law: &Bound<'py, PyAny>,
    hinge_law: Option<&Bound<'py, PyAny>>,
    tooth_law: Option<&Bound<'py, PyAny>>,
    min_impact_velocity: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyDict>> {
    let py = drive.py();
    let description = describe::drive(drive)?;
    let laws = describe::force_laws(force_law, hinge_law, tooth_law, min_impact_velocity)?;
    let rest = interruptible(py, |give_up| {
        Equilibrium::find_unless(&description, &laws, give_up)
    })?;
    let rest = describe::checked(py, rest)?;
    let found = PyDict::new(py);
    for (name, rows) in [
        ("positions", rest.start.positions),
        ("velocities", rest.start.velocities),
    ] {
        let count = rows.len();
        let flat: Vec<f64> = rows.into_iter().flatten().collect();
        found.set_item(name, flat.into_pyarray(py).reshape([count, 3])?)?;
    }
    found.set_item("residual", rest.residual)?;
    found.set_item("largest_force", rest.largest_force)?;
    found.set_item("iterations", rest.iterations)?;
    Ok(found)
}

/// Return the names of the strands of a drive, in the order of arrays over strands.
#[pyfunction]
pub(super) fn strand_names(drive: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    let description = describe::drive(drive)?;
    if description.sprockets.len() == 2 && description.ends.is_none() {
        return Ok(vec!["upper".to_string(), "lower".to_string()]);
    }
    let strands = crate::layout::strands(&description);
    Ok((0..strands.len())
        .map(|i| crate::layout::strand_name(&strands, i))
        .collect())
}

/// Return the smallest even number of links that closes around a drive's sprockets in their positions.
#[pyfunction]
pub(super) fn links_around(drive: &Bound<'_, PyAny>) -> PyResult<u32> {
    let description = describe::drive(drive)?;
    describe::checked(drive.py(), description.validate())?;
    describe::checked(drive.py(), crate::layout::links_around(&description))
}

/// Return the displacement of sprocket `number` along `direction` at which a drive's chain is taut \[m\], searched within `reach` \[m\].
#[pyfunction]
pub(super) fn closing_move(
    drive: &Bound<'_, PyAny>,
    number: usize,
    direction: (f64, f64),
    reach: f64,
) -> PyResult<f64> {
    let py = drive.py();
    let description = one_of(drive, number)?;
    let farthest = f64::from(MOST_LINKS) * description.chain.pitch;
    describe::checked(py, check::within("reach", reach, 0.0, farthest))?;
    let along = Vec2::new(direction.0, direction.1);
    if !(along.norm().is_finite() && along.norm() > 0.0) {
        let expected = "must be two finite numbers, not both zero";
        let shown = format!("({}, {})", along.x, along.y);
        return Err(to_python(py, &Error::invalid("direction", shown, expected)));
    }
    describe::checked(
        py,
        crate::layout::closing_move(&description, number - 1, along, reach),
    )
}

/// Return the unit vector along which sprocket `number` of a drive tightens both adjacent strands equally.
#[pyfunction]
pub(super) fn bisector(drive: &Bound<'_, PyAny>, number: usize) -> PyResult<(f64, f64)> {
    let description = one_of(drive, number)?;
    let line = describe::checked(drive.py(), BeltLine::of(&description))?;
    let along = -line.belt.pull(line.place_of(number - 1)).normalize();
    Ok((along.x, along.y))
}

/// Read a drive that has a sprocket of this number.
fn one_of(drive: &Bound<'_, PyAny>, number: usize) -> PyResult<Drive> {
    let description = describe::drive(drive)?;
    describe::checked(drive.py(), description.validate())?;
    let count = description.sprockets.len();
    if (1..=count).contains(&number) {
        return Ok(description);
    }
    let expected = format!("must be the number of a sprocket, 1 to {count}");
    let refusal = Error::invalid("adjust", number, expected);
    Err(to_python(drive.py(), &refusal))
}

fn positive(value: &Bound<'_, PyAny>, field: &str, unit: &str) -> PyResult<f64> {
    let found = describe::number(value, field, unit)?;
    describe::checked(value.py(), check::positive(field, found, unit)).map(|()| found)
}

/// Return the centre distance \[m\] at which both strands are taut and straight.
#[pyfunction]
pub(super) fn closing_center_distance(
    pitch: &Bound<'_, PyAny>,
    teeth: &Bound<'_, PyAny>,
    links: &Bound<'_, PyAny>,
) -> PyResult<f64> {
    let pitch = positive(pitch, "pitch", "m")?;
    let teeth = describe::two_teeth(teeth)?;
    let count = describe::count(links, "links")?;
    describe::checked(links.py(), check_links("links", count))?;
    let links = count;
    crate::layout::closing_center_distance(pitch, teeth, links).ok_or_else(|| {
        let fewest = fewest_links(pitch, teeth);
        InvalidInput::new_err(format!(
            "links = {links}: too few for sprockets of {} and {} teeth, which need at least {fewest} to stand clear of \
             each other",
            teeth[0], teeth[1]
        ))
    })
}

/// Return the number of links that closes around two sprockets with a minimum clearance between them.
fn fewest_links(pitch: f64, teeth: [u32; 2]) -> u32 {
    let outside = |n: u32| {
        let half = std::f64::consts::PI / f64::from(n);
        0.5 * pitch * (0.6 + 1.0 / half.tan())
    };
    crate::layout::links_for(
        pitch,
        teeth,
        1.001 * (outside(teeth[0]) + outside(teeth[1])),
    )
}

/// Return the smallest even number of links that closes around two sprockets.
#[pyfunction]
pub(super) fn links_for(
    pitch: &Bound<'_, PyAny>,
    teeth: &Bound<'_, PyAny>,
    center_distance: &Bound<'_, PyAny>,
) -> PyResult<u32> {
    let py = pitch.py();
    let pitch = positive(pitch, "pitch", "m")?;
    let teeth = describe::two_teeth(teeth)?;
    let center_distance = positive(center_distance, "center_distance", "m")?;
    // Two strands of this length form the longest chain.
    let farthest = 0.5 * f64::from(MOST_LINKS) * pitch;
    let allowed = check::within("center_distance", center_distance, 0.0, farthest);
    describe::checked(py, allowed)?;
    Ok(crate::layout::links_for(pitch, teeth, center_distance))
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

/// Python callable as an ODE system; its first exception ends the run.
struct Callable<'py> {
    function: Bound<'py, PyAny>,
    dimension: usize,
    failure: Option<PyErr>,
}

impl Callable<'_> {
    fn call(&self, t: f64, y: &[f64], dydt: &mut [f64]) -> PyResult<()> {
        let py = self.function.py();
        let values = self.function.call1((t, PyArray1::from_slice(py, y)))?;
        let array = py
            .import("numpy")?
            .call_method1("asarray", (values, "float64"))?;
        let array = array.cast_into::<PyArray1<f64>>()?;
        let array = array.readonly();
        let found = array.as_array();
        if found.len() != dydt.len() {
            return Err(to_python(
                py,
                &Error::invalid(
                    "fun",
                    format!("{} values", found.len()),
                    format!("must return {} values", dydt.len()),
                ),
            ));
        }
        for (slot, value) in dydt.iter_mut().zip(found) {
            *slot = *value;
        }
        Ok(())
    }
}

impl OdeSystem for Callable<'_> {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        if self.failure.is_none() {
            self.failure = self.call(t, y, dydt).err();
        }
        if self.failure.is_some() {
            dydt.fill(f64::NAN);
        }
    }
}

/// Maximum number of values returned by [`integrate`]: a gigabyte.
const MOST_VALUES: f64 = 1.25e8;

/// Integrate y' = fun(t, y) with the embedded Adams-Bashforth-Moulton method.
#[pyfunction]
#[allow(clippy::too_many_arguments, clippy::needless_pass_by_value)] // signature of SciPy; PyO3 passes arrays by value
pub(super) fn integrate<'py>(
    fun: &Bound<'py, PyAny>,
    t_span: (f64, f64),
    y0: PyReadonlyArray1<'py, f64>,
    rtol: f64,
    atol: f64,
    max_step: f64,
    max_order: usize,
    t_eval: Option<PyReadonlyArray1<'py, f64>>,
) -> PyResult<Bound<'py, PyDict>> {
    let py = fun.py();
    let control = StepControl {
        rtol,
        atol,
        max_step: max_step.min(t_span.1 - t_span.0),
        max_order,
        ..StepControl::default()
    };
    if t_span.1.partial_cmp(&t_span.0) != Some(std::cmp::Ordering::Greater) {
        return Err(to_python(
            py,
            &Error::invalid("t_span", format!("{t_span:?}"), "must end after it begins"),
        ));
    }
    describe::checked(py, control.validate())?;
    if !control.is_by_component() {
        let expected = "rtol and atol must not both be zero";
        return Err(to_python(
            py,
            &Error::invalid("Solver.atol", atol, expected),
        ));
    }
    let y0 = y0.as_array().to_vec();
    let times = match t_eval {
        Some(times) => times.as_array().to_vec(),
        None => vec![t_span.1],
    };
    if times.iter().any(|t| !(t_span.0..=t_span.1).contains(t))
        || times.windows(2).any(|w| w[1] < w[0])
    {
        return Err(to_python(
            py,
            &Error::invalid("t_eval", "its times", "must rise and lie within t_span"),
        ));
    }
    let values = times.len() as f64 * y0.len() as f64;
    describe::checked(
        py,
        check::within("t_eval times y0", values, 0.0, MOST_VALUES),
    )?;
    let mut system = Callable {
        function: fun.clone(),
        dimension: y0.len(),
        failure: None,
    };
    let mut adams = Adams::new(y0.len(), control);
    adams.restart(t_span.0, &y0);
    let mut rows = vec![0.0; times.len() * y0.len()];
    for (&t, row) in times.iter().zip(rows.chunks_mut(y0.len().max(1))) {
        while adams.time() < t {
            let outcome = adams.step(&mut system);
            if let Some(failure) = system.failure.take() {
                return Err(failure);
            }
            py.check_signals()?;
            outcome.map_err(|failure| {
                let name = |_, component| format!("component {component}");
                to_python(py, &failure.into_error(name))
            })?;
        }
        adams.interpolate(t, row);
    }
    let counts = adams.counts();
    let found = PyDict::new(py);
    let (count, width) = (times.len(), y0.len());
    found.set_item("t", times.into_pyarray(py))?;
    found.set_item("y", rows.into_pyarray(py).reshape([count, width])?)?;
    found.set_item("evaluations", counts.evaluations)?;
    found.set_item("steps", counts.steps)?;
    found.set_item("rejected", counts.rejected)?;
    Ok(found)
}

//! Layouts for Python: properties of a layout, static equilibrium, number of links and centres that close a chain.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arrays::table;
use super::describe;
use super::errors::InvalidInput;
use super::interrupt::interruptible;
use super::mechanism::mechanism;
use super::mechanism_callable::{Raised, take};
use super::starts::{drive_of, generated};
use crate::drive::{BeltLine, Drive, MOST_LINKS, check_links};
use crate::error::{Error, check};
use crate::geometry::Vec2;
use crate::geometry::ansi_outside_radius;
use crate::run::equilibrium::Equilibrium;

fn each<T, V>(items: &[T], value: impl Fn(&T) -> V) -> Vec<V> {
    items.iter().map(value).collect()
}

/// Generate the layout of a drive and return its properties.
#[pyfunction]
pub(super) fn layout<'py>(drive: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
    let py = drive.py();
    let description = describe::drive(drive)?;
    let (_, layout) = generated(py, &description)?;
    let found = PyDict::new(py);
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
    found.set_item("order", each(&layout.order, |sprocket| sprocket + 1))?;
    found.set_item("teeth", teeth)?;
    found.set_item("sides", each(&layout.sides, |side| side.name()))?;
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
    found.set_item("guide_gap", each(guides, |guide| guide.gap))?;
    found.set_item("guide_turn", each(guides, |guide| guide.turn))?;
    found.set_item("guide_travel", each(guides, |guide| guide.travel))?;
    found.set_item("guide_bushings", each(guides, |guide| guide.bushings))?;
    found.set_item("guide_place", each(guides, |guide| guide.place.clone()))?;
    found.set_item("warnings", layout.warnings)?;
    Ok(found)
}

/// Find the static equilibrium of a drive: positions, velocities and surfaces at the start of a run, and the residual.
#[pyfunction]
pub(super) fn static_start<'py>(scene: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
    let py = scene.py();
    let description = drive_of(scene)?;
    let laws = describe::force_laws(scene)?;
    let rest = interruptible(py, |give_up| {
        Equilibrium::find_unless(&description, &laws, give_up)
    })?;
    rest_values(py, rest?)
}

/// Find the static equilibrium of a mechanism: positions, velocities and surfaces at the start of a run, and the residual.
#[pyfunction]
pub(super) fn mechanism_static_start<'py>(
    description: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyDict>> {
    let py = description.py();
    let raised = Raised::default();
    let description = mechanism(description, &raised)?;
    let rest = interruptible(py, |give_up| {
        Equilibrium::of_mechanism(&description, give_up)
    });
    take(&raised)?;
    rest_values(py, rest??)
}

/// Return the values of an equilibrium.
fn rest_values(py: Python<'_>, rest: Equilibrium) -> PyResult<Bound<'_, PyDict>> {
    let found = PyDict::new(py);
    found.set_item("positions", table(py, rest.start.positions)?)?;
    found.set_item("velocities", table(py, rest.start.velocities)?)?;
    found.set_item("surfaces", rest.start.surfaces)?;
    found.set_item("residual", rest.residual)?;
    found.set_item("largest_force", rest.largest_force)?;
    found.set_item("iterations", rest.iterations)?;
    Ok(found)
}

/// Return the names of the strands of a drive, in the order of arrays over strands.
#[pyfunction]
pub(super) fn strand_names(drive: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    let description = describe::drive(drive)?;
    let strands = crate::layout::strands(&description);
    Ok((0..strands.len())
        .map(|i| crate::layout::strand_name(&strands, i))
        .collect())
}

/// Return the smallest even number of links that closes around a drive's sprockets in their positions.
#[pyfunction]
pub(super) fn links_around(drive: &Bound<'_, PyAny>) -> PyResult<u32> {
    let description = describe::drive(drive)?;
    description.validate()?;
    Ok(crate::layout::links_around(&description)?)
}

/// Return the displacement of sprocket `number` along `direction` at which a drive's chain is taut \[m\], searched within `reach` \[m\].
#[pyfunction]
pub(super) fn closing_move(
    drive: &Bound<'_, PyAny>,
    number: usize,
    direction: (f64, f64),
    reach: f64,
) -> PyResult<f64> {
    let description = one_of(drive, number)?;
    let farthest = f64::from(MOST_LINKS) * description.chain.pitch;
    check::within("reach", reach, 0.0, farthest)?;
    let along = Vec2::new(direction.0, direction.1);
    check::direction("direction", along)?;
    let moved = crate::layout::closing_move(&description, number - 1, along, reach)?;
    Ok(moved)
}

/// Return the unit vector along which sprocket `number` of a drive tightens both adjacent strands equally.
#[pyfunction]
pub(super) fn bisector(drive: &Bound<'_, PyAny>, number: usize) -> PyResult<(f64, f64)> {
    let description = one_of(drive, number)?;
    let line = BeltLine::of(&description)?;
    let along = -line.belt.pull(line.place_of(number - 1)).normalize();
    Ok((along.x, along.y))
}

/// Read a drive that has a sprocket of this number.
fn one_of(drive: &Bound<'_, PyAny>, number: usize) -> PyResult<Drive> {
    let description = describe::drive(drive)?;
    description.validate()?;
    let count = description.sprockets.len();
    if (1..=count).contains(&number) {
        return Ok(description);
    }
    let expected = format!("must be the number of a sprocket, 1 to {count}");
    Err(Error::invalid("adjust", number, expected).into())
}

fn positive(value: &Bound<'_, PyAny>, field: &str, unit: &str) -> PyResult<f64> {
    let found = describe::number(value, field, unit)?;
    check::positive(field, found, unit)?;
    Ok(found)
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
    let links = describe::count(links, "links")?;
    check_links("links", links)?;
    crate::layout::closing_center_distance(pitch, teeth, links).ok_or_else(|| {
        let fewest = fewest_links(pitch, teeth);
        InvalidInput::new_err(format!(
            "links = {links}: too few for sprockets of {} and {} teeth, which need at least {fewest} to stand clear of \
             each other",
            teeth[0], teeth[1]
        ))
    })
}

/// Distance of the centres over the sum of the outside radii, for the fewest links that a message names: above one, teeth do not touch.
const TIP_CLEARANCE: f64 = 1.001;

/// Return the number of links that closes around two sprockets with a minimum clearance between them.
fn fewest_links(pitch: f64, teeth: [u32; 2]) -> u32 {
    crate::layout::links_for(
        pitch,
        teeth,
        TIP_CLEARANCE
            * teeth
                .map(|n| ansi_outside_radius(pitch, n))
                .iter()
                .sum::<f64>(),
    )
}

/// Return the smallest even number of links that closes around two sprockets.
#[pyfunction]
pub(super) fn links_for(
    pitch: &Bound<'_, PyAny>,
    teeth: &Bound<'_, PyAny>,
    center_distance: &Bound<'_, PyAny>,
) -> PyResult<u32> {
    let pitch = positive(pitch, "pitch", "m")?;
    let teeth = describe::two_teeth(teeth)?;
    let center_distance = positive(center_distance, "center_distance", "m")?;
    // Two strands of this length form the longest chain.
    let farthest = 0.5 * f64::from(MOST_LINKS) * pitch;
    check::within("center_distance", center_distance, 0.0, farthest)?;
    Ok(crate::layout::links_for(pitch, teeth, center_distance))
}

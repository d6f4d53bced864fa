//! Warnings on force laws outside their range of validity.

use super::ForceLaws;
use super::bristles::bristle_warnings;
use super::sprocket::SprocketModel;
use super::surface_pairs::SurfacePairs;
use crate::drive::{Drive, HingeKind};
use crate::force_law::{Elastic, SurfacePair, range_note};

/// Return warnings on laws outside their range of validity in `drive`, one line for each pair of surfaces.
pub(super) fn range_notes(
    drive: &Drive,
    laws: &ForceLaws,
    pairs: &SurfacePairs,
    wheels: &[SprocketModel],
) -> Vec<String> {
    let toothed = drive.sprockets.len();
    let note = |law: Elastic, pair: &SurfacePair, surfaces: &str| {
        let note = range_note(law, pair)?;
        Some(format!("{} law, {surfaces}: {note}", law.name()))
    };
    let mut notes: Vec<String> =
        bristle_warnings([laws.hinge_bristles, laws.tooth_bristles]).collect();
    if drive.hinge_kind == HingeKind::Clearance {
        notes.extend(note(laws.hinge.elastic, &pairs.hinges, "pin and bushing"));
    }
    notes.extend(pairs.teeth.iter().enumerate().filter_map(|(i, pair)| {
        let surfaces = format!("bushing and {}", surface_name(i, wheels, toothed));
        note(laws.tooth.elastic, pair, &surfaces)
    }));
    let rollers = pairs.rollers.iter();
    notes.extend(rollers.filter_map(|pair| note(laws.hinge.elastic, pair, "bushing and roller")));
    notes
}

/// Return the name of the surface of tooth pair `pair`, with that of its wheel.
fn surface_name(pair: usize, wheels: &[SprocketModel], toothed: usize) -> String {
    let owner = wheels.iter().rposition(|wheel| wheel.first_pair <= pair);
    let number = owner.unwrap_or_default();
    let wheel = &wheels[number];
    let name = wheel.profile.surfaces()[pair - wheel.first_pair].name;
    match number.checked_sub(toothed) {
        None => format!("{name} of sprocket {}", number + 1),
        Some(guide) => format!("{name} of guide {}", guide + 1),
    }
}

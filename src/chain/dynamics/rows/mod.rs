//! Recorded row of a drive.

mod contacts;
mod ends;

use contacts::{gather_by_bushing, write_hinges, write_rollers, write_sprockets, write_teeth};

use super::Dynamics;
use crate::chain::report::Groups;
use crate::geometry::Vec2;
use crate::system::Row;

/// Number of the kind of contact for peak values: hinges, then rollers, then teeth.
pub(super) const HINGES: usize = 0;
pub(super) const ROLLERS: usize = 1;
const TEETH: usize = 2;

/// Write a row of `groups` for `dynamics`, evaluated at `t` \[s\] for the outputs of `Groups::request`.
///
/// `tooth_forces`: scratch, one value per bushing.
pub(super) fn write_row(
    row: &mut Row,
    dynamics: &Dynamics,
    t: f64,
    groups: Groups,
    tooth_forces: &mut [f64],
) {
    let model = dynamics.model();
    if groups.hinges {
        write_hinges(row, dynamics);
        row.close_peaks(HINGES, dynamics.evaluated.hinges.recorded_forces());
        if model.hinges.film.is_some() {
            let [x, y] = &dynamics.evaluated.hinges.film;
            row.real(x.iter().zip(y).map(|(&x, &y)| Vec2::new(x, y).norm()));
        }
        if let Some(ends) = &model.ends {
            ends::write(row, dynamics, ends);
        }
    }
    if groups.hinges && model.rollers.is_some() {
        write_rollers(row, dynamics);
        row.close_peaks(ROLLERS, &dynamics.evaluated.rollers.force);
    }
    if groups.teeth {
        write_teeth(row, dynamics);
        gather_by_bushing(&dynamics.evaluated.teeth, tooth_forces);
        row.close_peaks(TEETH, tooth_forces);
    }
    if groups.sprockets {
        write_sprockets(row, dynamics, t);
    }
    if groups.bodies {
        let motion = &dynamics.evaluated.motion;
        row.vectors(motion.each_position());
        row.vectors(motion.each_velocity());
    }
}

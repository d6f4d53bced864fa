//! Bristle deflections in the state: deflections among the velocities, their integrals among the coordinates.
//!
//! The state of a drive is [q, dq/dt], and the integrator supports no other form. The deflection z of a bristle is a first-order unknown.
//! It is stored as the velocity of a coordinate, the integral of z, which no equation uses. Prediction, correction, error weights, dense
//! output and checkpoints therefore treat z like every velocity.

use std::ops::Range;

use super::Model;
use crate::force_law::LuGre;

/// Coordinates of bristles, behind all others; empty ranges for contacts without bristles.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct BristlePlaces {
    /// One coordinate for every hinge.
    pub hinges: Range<usize>,
    /// One coordinate for every bushing in its roller.
    pub rollers: Range<usize>,
    /// One coordinate for every pair: sprocket or guide · links + bushing.
    pub teeth: Range<usize>,
}

impl BristlePlaces {
    /// Return the ranges that begin at coordinate `first`, for the given numbers of bristles.
    pub(super) fn from(first: usize, [hinges, rollers, teeth]: [usize; 3]) -> Self {
        let in_rollers = first + hinges;
        let on_teeth = in_rollers + rollers;
        Self {
            hinges: first..in_rollers,
            rollers: in_rollers..on_teeth,
            teeth: on_teeth..on_teeth + teeth,
        }
    }

    /// Return the range of all bristle coordinates.
    #[must_use]
    pub fn all(&self) -> Range<usize> {
        self.hinges.start..self.teeth.end
    }

    /// Return whether there are no bristles.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.all().is_empty()
    }

    /// Return the body on which the bristle of a coordinate acts: the front link of the hinge, the roller, or the link of the bushing.
    pub(super) fn body(&self, model: &Model, index: usize) -> Option<usize> {
        if self.hinges.contains(&index) {
            return Some(index - self.hinges.start);
        }
        if self.rollers.contains(&index) {
            return Some(model.links + (index - self.rollers.start));
        }
        let on_teeth = |pair: usize| match &model.rollers {
            Some(_) => model.links + pair % model.links,
            None => model.link_of_bushing(pair % model.links),
        };
        (self.teeth.contains(&index)).then(|| on_teeth(index - self.teeth.start))
    }
}

/// Return the warnings for the bristles of hinges and of teeth.
pub(super) fn bristle_warnings(
    [hinges, teeth]: [Option<LuGre>; 2],
) -> impl Iterator<Item = String> {
    let all = [(hinges, "hinges"), (teeth, "teeth")];
    all.into_iter().filter_map(|(law, place)| {
        let note = law?.breakaway_note()?;
        Some(format!("LuGre friction, {place}: {note}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_follow_one_another() {
        let places = BristlePlaces::from(10, [4, 0, 8]);
        assert_eq!(
            (
                places.hinges.clone(),
                places.rollers.clone(),
                places.teeth.clone()
            ),
            (10..14, 14..14, 14..22)
        );
        assert_eq!(places.all(), 10..22);
        assert!(BristlePlaces::default().is_empty() && !places.is_empty());
    }
}

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

/// Largest break-away deflection without a warning \[m\]; larger ones exceed the usual clearances of a drive.
const SOFTEST: f64 = 1e-4;

/// Smallest break-away deflection without a warning \[m\]; steps at usual accuracies do not resolve stiffer bristles.
const STIFFEST: f64 = 1e-8;

/// Return the warnings for the bristles of hinges and of teeth.
pub(super) fn bristle_warnings(
    [hinges, teeth]: [Option<LuGre>; 2],
) -> impl Iterator<Item = String> {
    let all = [(hinges, "hinges"), (teeth, "teeth")];
    all.into_iter()
        .filter_map(|(law, place)| bristle_warning(&law?, place))
}

/// Return a warning for a break-away deflection `static_coefficient/stiffness` outside of `STIFFEST` to `SOFTEST`.
fn bristle_warning(law: &LuGre, place: &str) -> Option<String> {
    let found = law.breakaway();
    let what = format!(
        "LuGre friction, {place}: bristles break away at a deflection of {found:.1e} m, static_coefficient/stiffness"
    );
    if found > SOFTEST {
        Some(format!(
            "{what}, more than {SOFTEST:.0e} m: contacts oscillate where they should stick; raise stiffness to {:.1e}/m or more",
            law.static_coefficient / SOFTEST
        ))
    } else if found < STIFFEST {
        Some(format!(
            "{what}, less than {STIFFEST:.0e} m: they shorten the steps; reduce stiffness to {:.1e}/m or less",
            law.static_coefficient / STIFFEST
        ))
    } else {
        None
    }
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

    #[test]
    fn only_absurd_bristles_are_doubted() {
        let law = |stiffness| LuGre {
            static_coefficient: 0.1,
            kinetic_coefficient: 0.1,
            stiffness,
            damping: 0.0,
            viscous_coefficient: 0.0,
            stribeck_speed: 1e-3,
            stribeck_exponent: 2.0,
        };
        assert!(bristle_warning(&law(1e5), "hinges").is_none());
        assert!(bristle_warning(&law(1e2), "hinges").is_some_and(|note| note.contains("or more")));
        assert!(
            bristle_warning(&law(1e9), "teeth")
                .is_some_and(|note| note.contains("teeth") && note.contains("or less"))
        );
    }
}

//! Where the deflections of bristles stand in the state: among the velocities, their integrals among the coordinates.
//!
//! The state of a drive is [q, dq/dt], and all that integrates it knows no other. A bristle's deflection z is a first-order unknown:
//! as the velocity of a coordinate that is the integral of z, which nothing reads, it is foretold, corrected, weighed, written out
//! inside steps and saved as every velocity is.

use std::ops::Range;

use super::Model;
use crate::force_law::LuGre;

/// Coordinates of bristles, behind all others; empty where there are none.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct BristlePlaces {
    /// One for every hinge.
    pub hinges: Range<usize>,
    /// One for every bushing in its roller.
    pub rollers: Range<usize>,
    /// One for every pair: sprocket or guide · links + bushing.
    pub teeth: Range<usize>,
}

impl BristlePlaces {
    /// Places from coordinate `first` on.
    pub(super) fn from(first: usize, [hinges, rollers, teeth]: [usize; 3]) -> Self {
        let in_rollers = first + hinges;
        let on_teeth = in_rollers + rollers;
        Self {
            hinges: first..in_rollers,
            rollers: in_rollers..on_teeth,
            teeth: on_teeth..on_teeth + teeth,
        }
    }

    /// All of them.
    #[must_use]
    pub fn all(&self) -> Range<usize> {
        self.hinges.start..self.teeth.end
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.all().is_empty()
    }

    /// The body that feels the bristle of a coordinate: the link of the hinge's front, the roller, or the link of the bushing.
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

/// Deflection at break-away above which bristles bend further than contacts of a drive have play \[m\].
const SOFTEST: f64 = 1e-4;

/// The same below which they are stiffer than steps at any usual accuracy resolve \[m\].
const STIFFEST: f64 = 1e-8;

/// What is to be said of the bristles of hinges and of teeth.
pub(super) fn doubts([hinges, teeth]: [Option<LuGre>; 2]) -> impl Iterator<Item = String> {
    let all = [(hinges, "hinges"), (teeth, "teeth")];
    all.into_iter()
        .filter_map(|(law, place)| doubt(&law?, place))
}

/// Why bristles would hardly be what was meant, in words.
fn doubt(law: &LuGre, place: &str) -> Option<String> {
    let found = law.breakaway();
    let what = format!(
        "LuGre friction, {place}: bristles break away at a deflection of {found:.1e} m, static_coefficient/stiffness"
    );
    if found > SOFTEST {
        Some(format!(
            "{what}, more than {SOFTEST:.0e} m: contacts spring where they should stick; make stiffness {:.1e}/m or more",
            law.static_coefficient / SOFTEST
        ))
    } else if found < STIFFEST {
        Some(format!(
            "{what}, less than {STIFFEST:.0e} m: steps follow them, and grow short; make stiffness {:.1e}/m or less",
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
        assert!(doubt(&law(1e5), "hinges").is_none());
        assert!(doubt(&law(1e2), "hinges").is_some_and(|note| note.contains("or more")));
        assert!(
            doubt(&law(1e9), "teeth")
                .is_some_and(|note| note.contains("teeth") && note.contains("or less"))
        );
    }
}

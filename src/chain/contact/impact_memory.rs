//! Impact velocity memory: initial impact velocity and surface of each contact, written between steps only.

use serde::{Deserialize, Serialize};

use crate::geometry::Surface;
use crate::math::simd::{Numbers, padded_zeros};

/// Contact pair: hinge, bushing and roller, or bushing and sprocket (sprocket · links + bushing).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ContactId {
    /// Pin and bushing of a hinge.
    Hinge(usize),
    /// Bushing and its roller.
    Roller(usize),
    /// Bushing, or its roller, and sprocket.
    Tooth(usize),
}

/// Initial impact velocities and surfaces of all pairs; a velocity of zero marks a pair without memory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ImpactMemory {
    /// Initial impact velocity of each hinge \[m/s\].
    hinge_impact_velocity: Vec<f64>,
    /// Inverse of `hinge_impact_velocity` \[s/m\], zero without memory; padded for the kernels.
    hinge_inverse_impact_velocity: Numbers,
    /// Initial impact velocity of each bushing in its roller \[m/s\]; empty where rollers are no bodies of their own.
    roller_impact_velocity: Vec<f64>,
    /// Inverse of `roller_impact_velocity` \[s/m\], zero without memory; padded for the kernels.
    roller_inverse_impact_velocity: Numbers,
    /// Initial impact velocity of each pair of bushing and sprocket \[m/s\].
    pub tooth_impact_velocity: Vec<f64>,
    /// Surface at the contact onset of each pair of bushing and sprocket.
    pub tooth_surface: Vec<Surface>,
    /// Minimum impact velocity \[m/s\].
    minimum: f64,
    /// Position of the pawl of each sprocket's or guide's ratchet, see [`crate::chain::model::Ratchet`]; -inf before its first update.
    pub pawls: Vec<f64>,
    /// Numbers of contact onsets.
    counts: OnsetCounts,
}

/// Numbers of contact onsets since the start of the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct OnsetCounts {
    /// All contact onsets.
    pub onsets: u64,
    /// Contact onsets below the minimum impact velocity.
    pub at_minimum: u64,
}

impl ImpactMemory {
    /// Create a memory in which no pair has an initial impact velocity; `minimum`: minimum impact velocity \[m/s\].
    #[must_use]
    pub fn new(hinges: usize, rollers: usize, tooth_pairs: usize, minimum: f64) -> Self {
        Self {
            hinge_impact_velocity: vec![0.0; hinges],
            hinge_inverse_impact_velocity: padded_zeros(hinges),
            roller_impact_velocity: vec![0.0; rollers],
            roller_inverse_impact_velocity: padded_zeros(rollers),
            tooth_impact_velocity: vec![0.0; tooth_pairs],
            tooth_surface: vec![Surface::SEATING; tooth_pairs],
            minimum,
            pawls: vec![f64::NEG_INFINITY; tooth_pairs.checked_div(hinges).unwrap_or(0)],
            counts: OnsetCounts::default(),
        }
    }

    /// Record a contact onset at the penetration rate `rate` \[m/s\]. The surface of a tooth remains.
    pub fn begin(&mut self, contact: ContactId, rate: f64) {
        let speed = rate.max(self.minimum);
        self.counts.onsets += 1;
        self.counts.at_minimum += u64::from(self.is_at_minimum(speed));
        self.set_impact_velocity(contact, speed);
    }

    /// Record a contact onset of a pair of bushing and sprocket on `surface` at the penetration rate `rate` \[m/s\].
    pub fn begin_tooth(&mut self, pair: usize, rate: f64, surface: Surface) {
        self.begin(ContactId::Tooth(pair), rate);
        self.tooth_surface[pair] = surface;
    }

    /// Return the surface at the onset of a tooth contact; `None` for hinges and rollers.
    pub(crate) fn surface(&self, contact: ContactId) -> Option<Surface> {
        match contact {
            ContactId::Tooth(pair) => Some(self.tooth_surface[pair]),
            ContactId::Hinge(_) | ContactId::Roller(_) => None,
        }
    }

    /// Set the surface of a tooth contact.
    pub(crate) fn set_surface(&mut self, contact: ContactId, surface: Option<Surface>) {
        if let (ContactId::Tooth(pair), Some(surface)) = (contact, surface) {
            self.tooth_surface[pair] = surface;
        }
    }

    /// Record a contact end.
    pub fn end(&mut self, contact: ContactId) {
        self.set_impact_velocity(contact, 0.0);
    }

    /// Remove the last contact onset from the counts and return to the memory before it, `speed` \[m/s\]; zero: no contact.
    pub(crate) fn take_back_onset(&mut self, contact: ContactId, speed: f64) {
        let removed = self.impact_velocity(contact);
        self.counts.onsets -= 1;
        self.counts.at_minimum -= u64::from(self.is_at_minimum(removed));
        self.set_impact_velocity(contact, speed);
    }

    fn set_impact_velocity(&mut self, contact: ContactId, speed: f64) {
        let inverse = if speed > 0.0 { 1.0 / speed } else { 0.0 };
        match contact {
            ContactId::Hinge(k) => {
                self.hinge_impact_velocity[k] = speed;
                self.hinge_inverse_impact_velocity[k] = inverse;
            }
            ContactId::Roller(k) => {
                self.roller_impact_velocity[k] = speed;
                self.roller_inverse_impact_velocity[k] = inverse;
            }
            ContactId::Tooth(pair) => self.tooth_impact_velocity[pair] = speed,
        }
    }

    /// Return the initial impact velocity of a contact \[m/s\]; zero without memory.
    #[must_use]
    pub fn impact_velocity(&self, contact: ContactId) -> f64 {
        match contact {
            ContactId::Hinge(k) => self.hinge_impact_velocity[k],
            ContactId::Roller(k) => self.roller_impact_velocity[k],
            ContactId::Tooth(pair) => self.tooth_impact_velocity[pair],
        }
    }

    /// Return whether a contact has an initial impact velocity.
    #[must_use]
    pub fn has(&self, contact: ContactId) -> bool {
        self.impact_velocity(contact) > 0.0
    }

    /// Return whether any contact has an initial impact velocity.
    pub(crate) fn has_any(&self) -> bool {
        self.contacts().any(|contact| self.has(contact))
    }

    /// Return whether the memory has a place for this contact.
    pub(crate) fn contains(&self, contact: ContactId) -> bool {
        let [hinges, rollers, pairs] = self.numbers();
        match contact {
            ContactId::Hinge(k) => k < hinges,
            ContactId::Roller(k) => k < rollers,
            ContactId::Tooth(pair) => pair < pairs,
        }
    }

    /// Return all contacts: hinges, rollers, then pairs of bushing and sprocket.
    pub(crate) fn contacts(&self) -> impl Iterator<Item = ContactId> + use<> {
        let [hinges, rollers, pairs] = self.numbers();
        (0..hinges)
            .map(ContactId::Hinge)
            .chain((0..rollers).map(ContactId::Roller))
            .chain((0..pairs).map(ContactId::Tooth))
    }

    fn numbers(&self) -> [usize; 3] {
        [
            &self.hinge_impact_velocity,
            &self.roller_impact_velocity,
            &self.tooth_impact_velocity,
        ]
        .map(Vec::len)
    }

    /// Return the initial impact velocity of each hinge \[m/s\].
    #[must_use]
    pub fn hinge_impact_velocity(&self) -> &[f64] {
        &self.hinge_impact_velocity
    }

    /// Return the inverses of the initial impact velocities \[s/m\], zero without memory; padded.
    #[must_use]
    pub(crate) fn hinge_inverse_impact_velocity(&self) -> &[f64] {
        &self.hinge_inverse_impact_velocity
    }

    /// Return the initial impact velocity of each bushing in its roller \[m/s\].
    #[must_use]
    pub fn roller_impact_velocity(&self) -> &[f64] {
        &self.roller_impact_velocity
    }

    /// Return the inverses of the initial impact velocities \[s/m\], zero without memory; padded.
    #[must_use]
    pub(crate) fn roller_inverse_impact_velocity(&self) -> &[f64] {
        &self.roller_inverse_impact_velocity
    }

    fn is_at_minimum(&self, speed: f64) -> bool {
        speed <= self.minimum
    }

    /// Return the numbers of contact onsets.
    #[must_use]
    pub fn counts(&self) -> OnsetCounts {
        self.counts
    }

    /// Return whether both memories have the same numbers of pairs and the same minimum impact velocity.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let lengths = |memory: &Self| {
            let hinges = (
                memory.hinge_impact_velocity.len(),
                memory.hinge_inverse_impact_velocity.len(),
            );
            let rollers = (
                memory.roller_impact_velocity.len(),
                memory.roller_inverse_impact_velocity.len(),
            );
            let teeth = (
                memory.tooth_impact_velocity.len(),
                memory.tooth_surface.len(),
            );
            (hinges, rollers, teeth, memory.pawls.len())
        };
        lengths(self) == lengths(other) && self.minimum == other.minimum
    }

    /// Clear the memory of every pair and the positions of all pawls; the counts remain.
    pub fn clear(&mut self) {
        self.hinge_impact_velocity.fill(0.0);
        self.hinge_inverse_impact_velocity.fill(0.0);
        self.roller_impact_velocity.fill(0.0);
        self.roller_inverse_impact_velocity.fill(0.0);
        self.tooth_impact_velocity.fill(0.0);
        self.pawls.fill(f64::NEG_INFINITY);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MINIMUM: f64 = 0.01;

    fn memory() -> ImpactMemory {
        ImpactMemory::new(6, 6, 12, MINIMUM)
    }

    #[test]
    fn an_onset_keeps_its_speed_or_the_minimum_and_its_inverse_until_the_contact_ends() {
        for (rate, speed) in [
            (0.5, 0.5),
            (MINIMUM, MINIMUM),
            (0.001, MINIMUM),
            (-0.2, MINIMUM),
        ] {
            let mut memory = memory();
            memory.begin(ContactId::Hinge(2), rate);
            memory.begin(ContactId::Roller(3), rate);
            memory.begin_tooth(7, rate, Surface::FLAT);
            assert_eq!(memory.hinge_impact_velocity()[2], speed);
            assert_eq!(memory.hinge_inverse_impact_velocity()[2], 1.0 / speed);
            assert_eq!(memory.roller_impact_velocity()[3], speed);
            assert_eq!(memory.roller_inverse_impact_velocity()[3], 1.0 / speed);
            assert_eq!(memory.tooth_impact_velocity[7], speed);
            assert_eq!(memory.tooth_surface[7], Surface::FLAT);
            let slow = if rate <= MINIMUM { 3 } else { 0 };
            let counts = memory.counts();
            assert_eq!((counts.onsets, counts.at_minimum), (3, slow));
            memory.end(ContactId::Hinge(2));
            memory.end(ContactId::Roller(3));
            memory.end(ContactId::Tooth(7));
            assert_eq!(memory.hinge_impact_velocity(), [0.0; 6]);
            assert_eq!(memory.roller_impact_velocity(), [0.0; 6]);
            assert!(
                memory
                    .hinge_inverse_impact_velocity()
                    .iter()
                    .all(|&x| x == 0.0)
            );
            assert!(
                memory
                    .roller_inverse_impact_velocity()
                    .iter()
                    .all(|&x| x == 0.0)
            );
            assert_eq!(memory.tooth_impact_velocity, [0.0; 12]);
            // An end is no onset.
            assert_eq!(memory.counts(), counts);
        }
    }

    #[test]
    fn only_contacts_with_teeth_have_a_surface() {
        let mut memory = memory();
        for contact in [ContactId::Hinge(2), ContactId::Roller(2)] {
            memory.set_surface(contact, Some(Surface::FLAT));
            assert_eq!(memory.surface(contact), None);
        }
        assert_eq!(memory, self::memory());
        memory.set_surface(ContactId::Tooth(2), Some(Surface::FLAT));
        memory.set_surface(ContactId::Tooth(2), None);
        assert_eq!(memory.surface(ContactId::Tooth(2)), Some(Surface::FLAT));
        assert_eq!(memory.surface(ContactId::Tooth(1)), Some(Surface::SEATING));
    }

    #[test]
    fn an_onset_that_is_taken_back_is_not_counted() {
        let mut memory = memory();
        let hinge = ContactId::Hinge(0);
        for rate in [0.5, 0.001, 0.002] {
            memory.begin(hinge, rate);
        }
        memory.take_back_onset(hinge, 0.5);
        assert_eq!(
            memory.counts(),
            OnsetCounts {
                onsets: 2,
                at_minimum: 1
            }
        );
        assert_eq!(memory.impact_velocity(hinge), 0.5);
        assert_eq!(memory.hinge_inverse_impact_velocity()[0], 2.0);
        memory.take_back_onset(hinge, 0.0);
        assert!(!memory.has(hinge));
        assert_eq!(
            memory.counts(),
            OnsetCounts {
                onsets: 1,
                at_minimum: 1
            }
        );
    }

    #[test]
    fn a_cleared_memory_is_a_new_one_with_its_counts() {
        let mut memory = memory();
        memory.begin(ContactId::Hinge(1), 0.3);
        memory.begin(ContactId::Roller(2), 0.3);
        memory.begin_tooth(3, 0.3, Surface::SEATING);
        memory.pawls[1] = 0.4;
        let counts = memory.counts();
        memory.clear();
        let expected = ImpactMemory {
            counts,
            ..self::memory()
        };
        assert_eq!(memory, expected);
        assert_eq!(counts.onsets, 3);
    }

    #[test]
    fn memories_are_alike_with_the_same_pairs_and_the_same_minimum() {
        let one = memory();
        assert!(one.is_like(&memory()));
        for other in [
            ImpactMemory::new(6, 6, 12, 0.02),
            ImpactMemory::new(6, 0, 12, MINIMUM),
            ImpactMemory::new(6, 6, 18, MINIMUM),
            ImpactMemory::new(4, 6, 12, MINIMUM),
        ] {
            assert!(!one.is_like(&other));
        }
        // A pawl for each sprocket; a memory without hinges has none.
        assert_eq!(one.pawls, [f64::NEG_INFINITY; 2]);
        assert!(ImpactMemory::new(0, 0, 0, MINIMUM).pawls.is_empty());
    }
}

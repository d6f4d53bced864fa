//! Impact velocity memory: initial impact velocity and surface of each contact, written between steps only.

use serde::{Deserialize, Serialize};

use crate::geometry::Surface;
use crate::math::simd::{Numbers, padded_zeros};

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
    floor: f64,
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
    pub at_floor: u64,
}

impl ImpactMemory {
    /// Create a memory in which no pair has an initial impact velocity; `floor`: minimum impact velocity \[m/s\].
    #[must_use]
    pub fn new(hinges: usize, rollers: usize, tooth_pairs: usize, floor: f64) -> Self {
        Self {
            hinge_impact_velocity: vec![0.0; hinges],
            hinge_inverse_impact_velocity: padded_zeros(hinges),
            roller_impact_velocity: vec![0.0; rollers],
            roller_inverse_impact_velocity: padded_zeros(rollers),
            tooth_impact_velocity: vec![0.0; tooth_pairs],
            tooth_surface: vec![Surface::SEATING; tooth_pairs],
            floor,
            pawls: vec![f64::NEG_INFINITY; tooth_pairs.checked_div(hinges).unwrap_or(0)],
            counts: OnsetCounts::default(),
        }
    }

    /// Record a contact onset of hinge `k` at the penetration rate `rate` \[m/s\].
    pub fn begin_hinge(&mut self, k: usize, rate: f64) {
        self.hinge_impact_velocity[k] = self.count(rate);
        self.hinge_inverse_impact_velocity[k] = 1.0 / self.hinge_impact_velocity[k];
    }

    /// Record the contact end of hinge `k`.
    pub fn end_hinge(&mut self, k: usize) {
        self.hinge_impact_velocity[k] = 0.0;
        self.hinge_inverse_impact_velocity[k] = 0.0;
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

    /// Record a contact onset of bushing `k` and its roller at the penetration rate `rate` \[m/s\].
    pub fn begin_roller(&mut self, k: usize, rate: f64) {
        self.roller_impact_velocity[k] = self.count(rate);
        self.roller_inverse_impact_velocity[k] = 1.0 / self.roller_impact_velocity[k];
    }

    /// Record the contact end of bushing `k` and its roller.
    pub fn end_roller(&mut self, k: usize) {
        self.roller_impact_velocity[k] = 0.0;
        self.roller_inverse_impact_velocity[k] = 0.0;
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

    /// Record a contact onset of a pair of bushing and sprocket on `surface` at the penetration rate `rate` \[m/s\].
    pub fn begin_tooth(&mut self, pair: usize, rate: f64, surface: Surface) {
        self.tooth_impact_velocity[pair] = self.count(rate);
        self.tooth_surface[pair] = surface;
    }

    /// Record the contact end of a pair of bushing and sprocket.
    pub fn end_tooth(&mut self, pair: usize) {
        self.tooth_impact_velocity[pair] = 0.0;
    }

    /// Remove a contact onset with the initial impact velocity `speed` \[m/s\] from the counts.
    pub(crate) fn uncount(&mut self, speed: f64) {
        self.counts.onsets -= 1;
        self.counts.at_floor -= u64::from(self.is_at_floor(speed));
    }

    /// Count a contact onset at the penetration rate `rate` and return its initial impact velocity \[m/s\].
    fn count(&mut self, rate: f64) -> f64 {
        let speed = rate.max(self.floor);
        self.counts.onsets += 1;
        self.counts.at_floor += u64::from(self.is_at_floor(speed));
        speed
    }

    fn is_at_floor(&self, speed: f64) -> bool {
        speed <= self.floor
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
        lengths(self) == lengths(other) && self.floor == other.floor
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

    const FLOOR: f64 = 0.01;

    fn memory() -> ImpactMemory {
        ImpactMemory::new(6, 6, 12, FLOOR)
    }

    #[test]
    fn an_onset_keeps_its_speed_or_the_minimum_and_its_inverse_until_the_contact_ends() {
        for (rate, speed) in [(0.5, 0.5), (FLOOR, FLOOR), (0.001, FLOOR), (-0.2, FLOOR)] {
            let mut memory = memory();
            memory.begin_hinge(2, rate);
            memory.begin_roller(3, rate);
            memory.begin_tooth(7, rate, Surface::FLAT);
            assert_eq!(memory.hinge_impact_velocity()[2], speed);
            assert_eq!(memory.hinge_inverse_impact_velocity()[2], 1.0 / speed);
            assert_eq!(memory.roller_impact_velocity()[3], speed);
            assert_eq!(memory.roller_inverse_impact_velocity()[3], 1.0 / speed);
            assert_eq!(memory.tooth_impact_velocity[7], speed);
            assert_eq!(memory.tooth_surface[7], Surface::FLAT);
            let slow = if rate <= FLOOR { 3 } else { 0 };
            let counts = memory.counts();
            assert_eq!((counts.onsets, counts.at_floor), (3, slow));
            memory.end_hinge(2);
            memory.end_roller(3);
            memory.end_tooth(7);
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
    fn an_onset_that_is_taken_back_is_not_counted() {
        let mut memory = memory();
        for rate in [0.5, 0.001, 0.002] {
            memory.begin_hinge(0, rate);
        }
        memory.uncount(FLOOR);
        assert_eq!(
            memory.counts(),
            OnsetCounts {
                onsets: 2,
                at_floor: 1
            }
        );
        memory.uncount(0.5);
        assert_eq!(
            memory.counts(),
            OnsetCounts {
                onsets: 1,
                at_floor: 1
            }
        );
    }

    #[test]
    fn a_cleared_memory_is_a_new_one_with_its_counts() {
        let mut memory = memory();
        memory.begin_hinge(1, 0.3);
        memory.begin_roller(2, 0.3);
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
            ImpactMemory::new(6, 0, 12, FLOOR),
            ImpactMemory::new(6, 6, 18, FLOOR),
            ImpactMemory::new(4, 6, 12, FLOOR),
        ] {
            assert!(!one.is_like(&other));
        }
        // A pawl for each sprocket; a memory without hinges has none.
        assert_eq!(one.pawls, [f64::NEG_INFINITY; 2]);
        assert!(ImpactMemory::new(0, 0, 0, FLOOR).pawls.is_empty());
    }
}

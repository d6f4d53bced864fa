//! Impact velocity memory: initial impact velocity and surface of each contact, written between steps only.

use serde::{Deserialize, Serialize};

use crate::geometry::Surface;
use crate::math::simd::{Numbers, padded_zeros};

/// Initial impact velocities and surfaces of all pairs; a velocity of zero marks a pair without memory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ImpactMemory {
    /// Initial impact velocity of each hinge \[m/s\].
    hinge_speed: Vec<f64>,
    /// Inverse of `hinge_speed` \[s/m\], zero without memory; padded for the kernels.
    hinge_inverse: Numbers,
    /// Initial impact velocity of each bushing in its roller \[m/s\]; empty where rollers are no bodies of their own.
    roller_speed: Vec<f64>,
    /// Inverse of `roller_speed` \[s/m\], zero without memory; padded for the kernels.
    roller_inverse: Numbers,
    /// Initial impact velocity of each pair of bushing and sprocket \[m/s\].
    pub tooth_speed: Vec<f64>,
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
            hinge_speed: vec![0.0; hinges],
            hinge_inverse: padded_zeros(hinges),
            roller_speed: vec![0.0; rollers],
            roller_inverse: padded_zeros(rollers),
            tooth_speed: vec![0.0; tooth_pairs],
            tooth_surface: vec![Surface::SEATING; tooth_pairs],
            floor,
            pawls: vec![f64::NEG_INFINITY; tooth_pairs.checked_div(hinges).unwrap_or(0)],
            counts: OnsetCounts::default(),
        }
    }

    /// Return the initial impact velocity used by a damping law \[m/s\].
    ///
    /// A pair without memory uses its present penetration rate `rate`, at least the minimum impact velocity.
    #[must_use]
    #[inline]
    pub fn onset_speed(&self, remembered: f64, rate: f64) -> f64 {
        if remembered > 0.0 {
            remembered
        } else {
            rate.max(self.floor)
        }
    }

    /// Record a contact onset of hinge `k` at the penetration rate `rate` \[m/s\].
    pub fn begin_hinge(&mut self, k: usize, rate: f64) {
        self.hinge_speed[k] = self.count(rate);
        self.hinge_inverse[k] = 1.0 / self.hinge_speed[k];
    }

    /// Record the contact end of hinge `k`.
    pub fn end_hinge(&mut self, k: usize) {
        self.hinge_speed[k] = 0.0;
        self.hinge_inverse[k] = 0.0;
    }

    /// Return the initial impact velocity of each hinge \[m/s\].
    #[must_use]
    pub fn hinge_speed(&self) -> &[f64] {
        &self.hinge_speed
    }

    /// Return the inverses of the initial impact velocities \[s/m\], zero without memory; padded.
    #[must_use]
    pub(crate) fn hinge_inverse(&self) -> &[f64] {
        &self.hinge_inverse
    }

    /// Record a contact onset of bushing `k` and its roller at the penetration rate `rate` \[m/s\].
    pub fn begin_roller(&mut self, k: usize, rate: f64) {
        self.roller_speed[k] = self.count(rate);
        self.roller_inverse[k] = 1.0 / self.roller_speed[k];
    }

    /// Record the contact end of bushing `k` and its roller.
    pub fn end_roller(&mut self, k: usize) {
        self.roller_speed[k] = 0.0;
        self.roller_inverse[k] = 0.0;
    }

    /// Return the initial impact velocity of each bushing in its roller \[m/s\].
    #[must_use]
    pub fn roller_speed(&self) -> &[f64] {
        &self.roller_speed
    }

    /// Return the inverses of the initial impact velocities \[s/m\], zero without memory; padded.
    #[must_use]
    pub(crate) fn roller_inverse(&self) -> &[f64] {
        &self.roller_inverse
    }

    /// Record a contact onset of a pair of bushing and sprocket on `surface` at the penetration rate `rate` \[m/s\].
    pub fn begin_tooth(&mut self, pair: usize, rate: f64, surface: Surface) {
        self.tooth_speed[pair] = self.count(rate);
        self.tooth_surface[pair] = surface;
    }

    /// Record the contact end of a pair of bushing and sprocket.
    pub fn end_tooth(&mut self, pair: usize) {
        self.tooth_speed[pair] = 0.0;
    }

    /// Remove a contact onset with the initial impact velocity `speed` \[m/s\] from the counts.
    pub(crate) fn take_back(&mut self, speed: f64) {
        self.counts.onsets -= 1;
        if speed <= self.floor {
            self.counts.at_floor -= 1;
        }
    }

    /// Count a contact onset at the penetration rate `rate` and return its initial impact velocity \[m/s\].
    fn count(&mut self, rate: f64) -> f64 {
        self.counts.onsets += 1;
        if rate < self.floor {
            self.counts.at_floor += 1;
        }
        rate.max(self.floor)
    }

    /// Return the numbers of contact onsets.
    #[must_use]
    pub fn counts(&self) -> OnsetCounts {
        self.counts
    }

    /// Return whether both memories have the same numbers of pairs and the same minimum impact velocity.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let lengths = |memory: &Self| {
            let hinges = (memory.hinge_speed.len(), memory.hinge_inverse.len());
            let rollers = (memory.roller_speed.len(), memory.roller_inverse.len());
            let teeth = (memory.tooth_speed.len(), memory.tooth_surface.len());
            (hinges, rollers, teeth, memory.pawls.len())
        };
        lengths(self) == lengths(other) && self.floor == other.floor
    }

    /// Clear the memory of every pair and the positions of all pawls; the counts remain.
    pub fn clear(&mut self) {
        self.hinge_speed.fill(0.0);
        self.hinge_inverse.fill(0.0);
        self.roller_speed.fill(0.0);
        self.roller_inverse.fill(0.0);
        self.tooth_speed.fill(0.0);
        self.pawls.fill(f64::NEG_INFINITY);
    }
}

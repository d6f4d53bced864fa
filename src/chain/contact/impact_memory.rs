//! What each live contact remembers from its onset: approach speed and stiffness. Written between steps only.

use serde::{Deserialize, Serialize};

use crate::geometry::Surface;
use crate::math::simd::{Numbers, padded_zeros};

/// Onset speeds and surfaces; a speed of zero means that the pair has no memory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ImpactMemory {
    /// Approach speed at onset of each hinge \[m/s\].
    hinge_speed: Vec<f64>,
    /// Its inverse \[s/m\], zero without memory; padded for the kernels.
    hinge_inverse: Numbers,
    /// Approach speed at onset of each bushing in its roller \[m/s\]; empty where rollers are no bodies of their own.
    roller_speed: Vec<f64>,
    /// Its inverse \[s/m\], as of the hinges.
    roller_inverse: Numbers,
    /// Approach speed at onset of each pair of bushing and sprocket \[m/s\].
    pub tooth_speed: Vec<f64>,
    /// Surface at onset of each pair of bushing and sprocket.
    pub tooth_surface: Vec<Surface>,
    /// Floor of the approach speed \[m/s\].
    floor: f64,
    /// How far forward the pawl of each sprocket's or guide's ratchet has come, see [`crate::chain::model::Ratchet`].
    pub pawls: Vec<f64>,
    /// Onsets so far.
    counts: OnsetCounts,
}

/// Onsets so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct OnsetCounts {
    /// All.
    pub onsets: u64,
    /// Those whose approach speed was below the floor.
    pub at_floor: u64,
}

impl ImpactMemory {
    /// No pair has a memory.
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

    /// The onset speed that a law uses: the remembered one, or for a pair without memory the present rate, not below the floor.
    #[must_use]
    #[inline]
    pub fn onset_speed(&self, remembered: f64, rate: f64) -> f64 {
        if remembered > 0.0 {
            remembered
        } else {
            rate.max(self.floor)
        }
    }

    /// Hinge `k` came into contact at `rate` \[m/s\].
    pub fn begin_hinge(&mut self, k: usize, rate: f64) {
        self.hinge_speed[k] = self.count(rate);
        self.hinge_inverse[k] = 1.0 / self.hinge_speed[k];
    }

    /// Hinge `k` came apart.
    pub fn end_hinge(&mut self, k: usize) {
        self.hinge_speed[k] = 0.0;
        self.hinge_inverse[k] = 0.0;
    }

    /// Approach speed at onset of each hinge \[m/s\].
    #[must_use]
    pub fn hinge_speed(&self) -> &[f64] {
        &self.hinge_speed
    }

    /// Its inverse \[s/m\], zero without memory; padded.
    #[must_use]
    pub(crate) fn hinge_inverse(&self) -> &[f64] {
        &self.hinge_inverse
    }

    /// Bushing `k` came into contact with its roller at `rate` \[m/s\].
    pub fn begin_roller(&mut self, k: usize, rate: f64) {
        self.roller_speed[k] = self.count(rate);
        self.roller_inverse[k] = 1.0 / self.roller_speed[k];
    }

    /// Bushing `k` and its roller came apart.
    pub fn end_roller(&mut self, k: usize) {
        self.roller_speed[k] = 0.0;
        self.roller_inverse[k] = 0.0;
    }

    /// Approach speed at onset of each bushing in its roller \[m/s\].
    #[must_use]
    pub fn roller_speed(&self) -> &[f64] {
        &self.roller_speed
    }

    /// Its inverse \[s/m\], zero without memory; padded.
    #[must_use]
    pub(crate) fn roller_inverse(&self) -> &[f64] {
        &self.roller_inverse
    }

    /// A bushing came into contact with a tooth at `rate` \[m/s\].
    pub fn begin_tooth(&mut self, pair: usize, rate: f64, surface: Surface) {
        self.tooth_speed[pair] = self.count(rate);
        self.tooth_surface[pair] = surface;
    }

    /// A bushing left its tooth.
    pub fn end_tooth(&mut self, pair: usize) {
        self.tooth_speed[pair] = 0.0;
    }

    /// The onset at `speed` is not to have been \[m/s\].
    pub(crate) fn take_back(&mut self, speed: f64) {
        self.counts.onsets -= 1;
        if speed <= self.floor {
            self.counts.at_floor -= 1;
        }
    }

    fn count(&mut self, rate: f64) -> f64 {
        self.counts.onsets += 1;
        if rate < self.floor {
            self.counts.at_floor += 1;
        }
        rate.max(self.floor)
    }

    /// Onsets so far.
    #[must_use]
    pub fn counts(&self) -> OnsetCounts {
        self.counts
    }

    /// Whether it is a memory of as many pairs, with the same floor.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let lengths = |memory: &Self| {
            let hinges = (memory.hinge_speed.len(), memory.hinge_inverse.len());
            let rollers = (memory.roller_speed.len(), memory.roller_inverse.len());
            let teeth = (memory.tooth_speed.len(), memory.tooth_surface.len());
            (hinges, rollers, teeth, memory.pawls.len())
        };
        lengths(self) == lengths(other) && self.floor == other.floor
    }

    /// Forgets every pair.
    pub fn clear(&mut self) {
        self.hinge_speed.fill(0.0);
        self.hinge_inverse.fill(0.0);
        self.roller_speed.fill(0.0);
        self.roller_inverse.fill(0.0);
        self.tooth_speed.fill(0.0);
        self.pawls.fill(f64::NEG_INFINITY);
    }
}

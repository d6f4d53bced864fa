//! Candidate lists: the bushings that can touch each sprocket before a body has moved by the margin, and their tooth gaps.
//!
//! A list is valid until a bushing has moved by more than the margin, in space or relative to a sprocket. Every evaluation measures this
//! displacement: no contact is missed, whatever the step size. A candidate list built at an undefined state is invalid. A pair with an
//! impact velocity memory remains a candidate until the memory has ended. The gaps are initial values: the kernel detects a bushing that
//! has crossed to another gap and determines its gap again.

mod checkpoint;

pub(crate) use checkpoint::CandidatesCheckpoint;

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::chain::contact::{ContactId, ImpactMemory};
use crate::chain::model::{Model, SprocketModel, Support};

use crate::geometry::{Surface, Vec2};
use crate::math::simd::{Numbers, WIDTH, padded, padded_zeros};

/// Candidates of all sprockets.
#[derive(Debug, Clone)]
pub(crate) struct Candidates {
    /// Candidates of each sprocket.
    pub(crate) sprockets: Vec<SprocketCandidates>,
    /// Positions of the bushings when the list was built: x, y \[m\].
    pub(crate) reference: [Numbers; 2],
    /// Sprockets with moving centres, and their centres when the list was built \[m\].
    movable: Vec<(usize, Vec2)>,
    /// Displacement that invalidates the list \[m\].
    margin: f64,
    /// Largest number of bushings of a run behind the last bushing of the chain, counted on from the first.
    pub(crate) overhang: usize,
    /// Whether the list is invalid, independent of displacements.
    stale: bool,
    /// Number of lists built so far.
    refreshes: u64,
}

/// Successive bushings of the chain that are candidates of one sprocket.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct BushingRun {
    /// Number of the first bushing.
    pub(crate) first: usize,
    /// Number of bushings; a run may continue from the last bushing of the chain to the first one.
    pub(crate) length: usize,
    /// Slot of the first bushing, a multiple of [`WIDTH`].
    pub(crate) slot: usize,
}

impl BushingRun {
    /// Return the number of bushing `i` of the run in a chain of `links` links.
    ///
    /// A run reaches past the last bushing once at most. The remainder of a division would take longer than all else in these loops.
    pub(crate) fn bushing(&self, i: usize, links: usize) -> usize {
        let k = self.first + i;
        if k < links { k } else { k - links }
    }
}

/// Candidates of one sprocket: runs of bushings, and arrays over their slots.
#[derive(Debug, Clone)]
pub(crate) struct SprocketCandidates {
    /// Runs of successive bushings.
    pub(crate) runs: Vec<BushingRun>,
    /// Number of the tooth gap of each candidate at the last evaluation.
    pub(crate) gap: Vec<u32>,
    /// Direction of that gap in the frame of the sprocket, cosine.
    pub(crate) gap_cos: Numbers,
    /// Direction of that gap in the frame of the sprocket, sine.
    pub(crate) gap_sin: Numbers,
    /// Inverse of the initial impact velocity of each candidate \[s/m\]; zero without memory.
    pub(crate) inverse_impact_velocity: Numbers,
    /// Constants of the elastic law for the surface at the contact onset.
    pub(crate) kept_constants: [Numbers; 2],
    /// Penetration of each candidate \[m\]; zero where apart. Written by the kernel.
    pub(crate) depth: Numbers,
    /// Normal force on each candidate \[N\]. Written by the kernel.
    pub(crate) force: Numbers,
    /// Friction on the sprocket, along the normal turned left \[N\]. Written by the kernel for drives with tooth friction.
    pub(crate) friction: Numbers,
}

impl SprocketCandidates {
    /// Create empty candidates with capacity for `slots` slots.
    fn with_room_for(slots: usize) -> Self {
        let room = || Numbers::with_capacity(64, slots);
        Self {
            runs: Vec::with_capacity(slots / WIDTH),
            gap: Vec::with_capacity(slots),
            gap_cos: room(),
            gap_sin: room(),
            inverse_impact_velocity: room(),
            kept_constants: [room(), room()],
            depth: room(),
            force: room(),
            friction: room(),
        }
    }

    /// Return (slot, bushing) of all candidates, in a chain of `links` links.
    pub(crate) fn bushings(&self, links: usize) -> impl Iterator<Item = (usize, usize)> {
        self.runs.iter().flat_map(move |run| {
            (0..run.length).map(move |i| (run.slot + i, run.bushing(i, links)))
        })
    }

    /// Return (first bushing, slots) of all runs in a chain of `links` links; a run past the last bushing is two pieces.
    pub(crate) fn pieces(&self, links: usize) -> impl Iterator<Item = (usize, Range<usize>)> {
        self.runs.iter().flat_map(move |run| {
            let behind = (run.first + run.length).saturating_sub(links);
            let (end, turn) = (run.slot + run.length, run.slot + run.length - behind);
            [(run.first, run.slot..turn), (0, turn..end)]
        })
    }

    /// Return the slot of a bushing; `None` where it is no candidate.
    fn slot_of(&self, bushing: usize, links: usize) -> Option<usize> {
        // The distance along the ring, modulo the number of links, also finds bushings behind the end of the chain.
        self.runs.iter().find_map(|run| {
            let place = (bushing + links - run.first) % links;
            (place < run.length).then_some(run.slot + place)
        })
    }

    /// Set the number of slots and fill all arrays with zeros.
    fn resize(&mut self, slots: usize) {
        self.gap.clear();
        self.gap.resize(slots, 0);
        for array in self.arrays() {
            array.clear();
            array.resize(slots, 0.0);
        }
    }

    /// Return the floating-point arrays over slots.
    fn arrays(&mut self) -> [&mut Numbers; 8] {
        let Self {
            gap_cos,
            gap_sin,
            inverse_impact_velocity,
            kept_constants: [kept_0, kept_1],
            depth,
            force,
            friction,
            ..
        } = self;
        [
            gap_cos,
            gap_sin,
            inverse_impact_velocity,
            kept_0,
            kept_1,
            depth,
            force,
            friction,
        ]
    }

    /// Copy runs, gaps and constants of `other` without allocation. Results of the kernel are undefined until it writes them.
    fn copy(&mut self, other: &Self) {
        self.runs.clear();
        self.runs.extend_from_slice(&other.runs);
        if self.gap.len() != other.gap.len() {
            self.resize(other.gap.len());
        }
        self.gap.copy_from_slice(&other.gap);
        self.gap_cos.copy_from_slice(&other.gap_cos);
        self.gap_sin.copy_from_slice(&other.gap_sin);
        self.inverse_impact_velocity
            .copy_from_slice(&other.inverse_impact_velocity);
        for (own, other) in self.kept_constants.iter_mut().zip(&other.kept_constants) {
            own.copy_from_slice(other);
        }
    }

    /// Assign a tooth gap of its sprocket to the candidate in `slot`.
    pub(crate) fn put_into_gap(&mut self, slot: usize, sprocket: &SprocketModel, gap: u32) {
        self.gap[slot] = gap;
        (self.gap_cos[slot], self.gap_sin[slot]) = sprocket.gap_directions[gap as usize];
    }
}

impl Candidates {
    /// Create an invalid list; the first evaluation builds it.
    pub(crate) fn new(model: &Model) -> Self {
        let sprocket = || SprocketCandidates::with_room_for(Self::most_slots(model));
        Self {
            sprockets: model.sprockets.iter().map(|_| sprocket()).collect(),
            reference: [padded_zeros(model.links), padded_zeros(model.links)],
            movable: (0..model.sprockets.len())
                .filter(|&s| model.sprockets[s].support != Support::Fixed)
                .map(|s| (s, Vec2::zeros()))
                .collect(),
            // With half a pitch, the candidates at the ends of a wrap fill lanes of SIMD vectors that the wrap needs in any case.
            margin: model.half_pitch,
            overhang: 0,
            stale: true,
            refreshes: 0,
        }
    }

    /// Return the largest number of slots of the candidates of a sprocket.
    pub(crate) fn most_slots(model: &Model) -> usize {
        // Runs are at least one SIMD vector apart: the bushings between two runs provide the slots for padding. Two runs at the opening of
        // an open chain may be nearer.
        let open = if model.ends.is_some() { 2 } else { 0 };
        padded(model.links) + (2 + open) * WIDTH
    }

    /// Invalidate the list.
    pub(crate) fn invalidate(&mut self) {
        self.stale = true;
    }

    /// Copy the list `other` without allocation.
    pub(crate) fn copy(&mut self, other: &Self) {
        for (own, other) in self.sprockets.iter_mut().zip(&other.sprockets) {
            own.copy(other);
        }
        for (own, other) in self.reference.iter_mut().zip(&other.reference) {
            own.copy_from_slice(other);
        }
        self.movable.copy_from_slice(&other.movable);
        (self.overhang, self.stale) = (other.overhang, other.stale);
    }

    /// Return the number of lists built so far.
    pub(crate) fn refreshes(&self) -> u64 {
        self.refreshes
    }

    /// Return whether the list is valid for sprockets at `center` \[m\].
    ///
    /// `moved_squared`: largest squared displacement of a bushing since the list was built \[m²\].
    #[inline]
    pub(crate) fn hold(&self, moved_squared: f64, center: impl Fn(usize) -> Vec2) -> bool {
        let mut sprocket_moved: f64 = 0.0;
        for &(s, reference) in &self.movable {
            sprocket_moved = sprocket_moved.max((center(s) - reference).norm_squared());
        }
        // Sufficient condition for a + b < margin, without square roots: (a + b)² <= 2 (a² + b²).
        !self.stale && 2.0 * (moved_squared + sprocket_moved) < self.margin * self.margin
    }

    /// Build the list from the present positions of bushings (`x`, `y`) and sprockets (centre; cosine and sine of the angle).
    pub(crate) fn refresh(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        [x, y]: [&[f64]; 2],
        frames: impl Iterator<Item = (Vec2, [f64; 2])>,
    ) {
        let n = model.links;
        self.reference[0][..n].copy_from_slice(&x[..n]);
        self.reference[1][..n].copy_from_slice(&y[..n]);
        // A displacement from a non-finite position is undefined: such a list is invalid.
        let finite = |places: &[f64]| places[..n].iter().all(|place| place.is_finite());
        self.stale = !(finite(x) && finite(y));
        self.refreshes += 1;
        self.overhang = 0;
        for (s, (center, direction)) in frames.enumerate() {
            if let Some((_, reference)) = self.movable.iter_mut().find(|(movable, _)| *movable == s)
            {
                *reference = center;
                self.stale |= !(center.x.is_finite() && center.y.is_finite());
            }
            let candidates = &mut self.sprockets[s];
            let limit = model.sprockets[s].reach + self.margin;
            let live = &memory.tooth_impact_velocity[s * n..(s + 1) * n];
            let near = |k: usize| {
                let distance_squared = (Vec2::new(x[k], y[k]) - center).norm_squared();
                distance_squared < limit * limit || distance_squared.is_nan() || live[k] > 0.0
            };
            let there = |k: usize| model.bushing_is_there(k);
            let slots = find_runs(n, near, there, &mut candidates.runs);
            candidates.resize(slots);
            for i in 0..candidates.runs.len() {
                let run = candidates.runs[i];
                self.overhang = self
                    .overhang
                    .max((run.first + run.length).saturating_sub(n));
                for j in 0..run.length {
                    let k = (run.first + j) % n;
                    let arm = Vec2::new(x[k], y[k]) - center;
                    let slot = run.slot + j;
                    let sprocket = &model.sprockets[s];
                    candidates.put_into_gap(slot, sprocket, gap_of(sprocket, arm, direction));
                    candidates.remember(model, memory, s, slot, k);
                }
            }
        }
    }

    /// Return the tooth gap of sprocket `s` with bushing `k` at the last evaluation; `None` where the pair is no candidate.
    pub(crate) fn gap(&self, model: &Model, s: usize, k: usize) -> Option<u32> {
        let candidates = &self.sprockets[s];
        let slot = candidates.slot_of(k, model.links)?;
        Some(candidates.gap[slot])
    }

    /// Copy the initial impact velocity and the surface of a tooth contact from `memory` into its slot; hinges and rollers have none.
    pub(crate) fn update_memory(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        contact: ContactId,
    ) {
        let ContactId::Tooth(pair) = contact else {
            return;
        };
        let (s, k) = (pair / model.links, pair % model.links);
        if let Some(slot) = self.sprockets[s].slot_of(k, model.links) {
            self.sprockets[s].remember(model, memory, s, slot, k);
        }
    }
}

impl SprocketCandidates {
    /// Copy the initial impact velocity and the law constants of the surface at the contact onset into a slot.
    fn remember(&mut self, model: &Model, memory: &ImpactMemory, s: usize, slot: usize, k: usize) {
        let pair = s * model.links + k;
        let speed = memory.tooth_impact_velocity[pair];
        self.inverse_impact_velocity[slot] = if speed > 0.0 { 1.0 / speed } else { 0.0 };
        let constants = surface_constants(model, s, memory.tooth_surface[pair]);
        for (array, constant) in self.kept_constants.iter_mut().zip(constants) {
            array[slot] = constant;
        }
    }
}

/// Return the tooth gap of a bushing at `arm` \[m\] from a sprocket's centre.
///
/// `direction`: cosine and sine of the sprocket's angle.
#[cold]
#[inline(never)]
pub(crate) fn gap_of(sprocket: &SprocketModel, arm: Vec2, [cos, sin]: [f64; 2]) -> u32 {
    let (x, y) = (
        arm.x * cos + arm.y * sin - sprocket.offset.x,
        arm.y * cos - arm.x * sin - sprocket.offset.y,
    );
    sprocket.profile.nearest_gap(y.atan2(x))
}

/// Return the constants of the tooth law for a surface of sprocket `s`.
pub(crate) fn surface_constants(model: &Model, s: usize, surface: Surface) -> [f64; 2] {
    model.teeth.law.pairs.pairs()[model.tooth_pair(s, surface)]
}

/// Write the runs of those of `n` bushings that are `near`, and return the number of their slots.
///
/// Two runs less than one SIMD vector apart are joined: that vector is loaded in any case. The last and the first run are joined where
/// that saves a vector. Bushings that are not `there` belong to no run.
fn find_runs(
    n: usize,
    near: impl Fn(usize) -> bool,
    there: impl Fn(usize) -> bool,
    runs: &mut Vec<BushingRun>,
) -> usize {
    runs.clear();
    let all_there = |from: usize, to: usize| (from..to).all(|k| there(k % n));
    for k in (0..n).filter(|&k| near(k) && there(k)) {
        match runs.last_mut() {
            Some(run)
                if k - (run.first + run.length) < WIDTH && all_there(run.first + run.length, k) =>
            {
                run.length = k + 1 - run.first;
            }
            _ => runs.push(BushingRun {
                first: k,
                length: 1,
                slot: 0,
            }),
        }
    }
    // A vector is saved only if less than one vector is between the two.
    if let [first, .., last] = runs.as_mut_slice()
        && padded(first.first + n + first.length - last.first)
            < padded(first.length) + padded(last.length)
        && all_there(last.first + last.length, first.first + n)
    {
        last.length = first.first + n + first.length - last.first;
        runs.remove(0);
    }
    lay_out(runs)
}

/// Assign slots to the runs and return the number of slots.
fn lay_out(runs: &mut [BushingRun]) -> usize {
    let mut slots = 0;
    for run in runs {
        run.slot = slots;
        slots += padded(run.length);
    }
    slots
}

#[cfg(test)]
mod tests;

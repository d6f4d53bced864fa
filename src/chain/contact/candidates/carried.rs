//! A list of candidates as a state carries it: whom it has, in which gaps, and for how long it holds.
//!
//! The list is a cache, but it decides the order in which a sprocket's sums run, and so their last bits. Whom it has depends on
//! places and contacts when it was made, which are gone: it is carried and not made again.

use serde::{Deserialize, Serialize};

use super::{Candidates, Run, SprocketCandidates, lay_out};
use crate::chain::contact::ImpactMemory;
use crate::chain::model::Model;
use crate::geometry::Vec2;

/// A list, and how often lists were made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct CarriedCandidates {
    /// `None` where the next evaluation makes a new one.
    list: Option<CarriedList>,
    refreshes: u64,
}

/// Places that the list holds near, and for each sprocket its candidates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct CarriedList {
    /// Where the bushings were, x and y \[m\].
    bushings: [Vec<f64>; 2],
    /// Where the sprockets were that can move \[m\].
    centers: Vec<[f64; 2]>,
    sprockets: Vec<CarriedRuns>,
}

/// Candidates of one sprocket.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct CarriedRuns {
    /// First bushing and length of each run.
    runs: Vec<(usize, usize)>,
    /// The gap that each candidate was last seen in, run by run.
    gaps: Vec<u32>,
}

impl Candidates {
    /// The present list.
    pub(crate) fn carried(&self, model: &Model) -> CarriedCandidates {
        let runs = |candidates: &SprocketCandidates| {
            let bushings = candidates.bushings(model.links);
            CarriedRuns {
                runs: (candidates.runs.iter())
                    .map(|run| (run.first, run.length))
                    .collect(),
                gaps: bushings.map(|(slot, _)| candidates.gap[slot]).collect(),
            }
        };
        CarriedCandidates {
            list: (!self.stale).then(|| CarriedList {
                bushings: [0, 1].map(|i| self.reference[i][..model.links].to_vec()),
                centers: (self.movable.iter())
                    .map(|&(_, center)| center.into())
                    .collect(),
                sprockets: self.sprockets.iter().map(runs).collect(),
            }),
            refreshes: self.refreshes,
        }
    }

    /// Goes on with `carried`; `None` when it is no list of this model.
    pub(crate) fn carry_on(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        carried: &CarriedCandidates,
    ) -> Option<()> {
        self.refreshes = carried.refreshes;
        self.stale = true;
        let Some(list) = &carried.list else {
            return Some(());
        };
        let n = model.links;
        if list.bushings.iter().any(|places| places.len() != n)
            || list.centers.len() != self.movable.len()
            || list.sprockets.len() != self.sprockets.len()
        {
            return None;
        }
        for (reference, places) in self.reference.iter_mut().zip(&list.bushings) {
            reference[..n].copy_from_slice(places);
        }
        for ((_, reference), &center) in self.movable.iter_mut().zip(&list.centers) {
            *reference = Vec2::from(center);
        }
        self.overhang = 0;
        for (s, (candidates, carried)) in self.sprockets.iter_mut().zip(&list.sprockets).enumerate()
        {
            candidates.carry_on(model, memory, s, carried)?;
            let behind = |run: &Run| (run.first + run.length).saturating_sub(n);
            let behind = candidates.runs.iter().map(behind).max();
            self.overhang = self.overhang.max(behind.unwrap_or(0));
        }
        self.stale = false;
        Some(())
    }
}

impl SprocketCandidates {
    fn carry_on(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        s: usize,
        carried: &CarriedRuns,
    ) -> Option<()> {
        let mut free = vec![true; model.links];
        self.runs.clear();
        for &(first, length) in &carried.runs {
            if first >= model.links || !(1..=model.links).contains(&length) {
                return None;
            }
            // No bushing is twice in a list.
            for k in first..first + length {
                if !std::mem::take(&mut free[k % model.links]) {
                    return None;
                }
            }
            self.runs.push(Run {
                first,
                length,
                slot: 0,
            });
        }
        let slots = lay_out(&mut self.runs);
        self.resize(slots);
        let bushings: Vec<(usize, usize)> = self.bushings(model.links).collect();
        if carried.gaps.len() != bushings.len() {
            return None;
        }
        for ((slot, k), &gap) in bushings.into_iter().zip(&carried.gaps) {
            let sprocket = &model.sprockets[s];
            sprocket.gap_directions.get(gap as usize)?;
            self.put_into_gap(slot, sprocket, gap);
            self.remember(model, memory, s, slot, k);
        }
        Some(())
    }
}

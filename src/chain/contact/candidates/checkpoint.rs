//! Candidate list of a checkpoint: its bushings, their tooth gaps, and the reference positions of its validity.
//!
//! The list is a cache, but it determines the order of summation for a sprocket, and therefore the last bits of the sums. Its bushings
//! depend on positions and contacts at the time of its construction, which cannot be recovered: the checkpoint stores the list.

use serde::{Deserialize, Serialize};

use super::{Candidates, Run, SprocketCandidates, lay_out};
use crate::chain::contact::ImpactMemory;
use crate::chain::model::Model;
use crate::geometry::Vec2;

/// A candidate list, and the number of lists built so far.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct CandidatesCheckpoint {
    /// `None` where the next evaluation builds a new list.
    list: Option<ListCheckpoint>,
    refreshes: u64,
}

/// Reference positions of the list, and the candidates of each sprocket.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct ListCheckpoint {
    /// Positions of the bushings when the list was built, x and y \[m\].
    bushings: [Vec<f64>; 2],
    /// Centres of the movable sprockets when the list was built \[m\].
    centers: Vec<[f64; 2]>,
    sprockets: Vec<RunsCheckpoint>,
}

/// Candidates of one sprocket.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct RunsCheckpoint {
    /// First bushing and length of each run.
    runs: Vec<(usize, usize)>,
    /// Tooth gap of each candidate at the last evaluation, run by run.
    gaps: Vec<u32>,
}

impl Candidates {
    /// Return the present list for a checkpoint.
    pub(crate) fn to_checkpoint(&self, model: &Model) -> CandidatesCheckpoint {
        let runs = |candidates: &SprocketCandidates| {
            let bushings = candidates.bushings(model.links);
            RunsCheckpoint {
                runs: (candidates.runs.iter())
                    .map(|run| (run.first, run.length))
                    .collect(),
                gaps: bushings.map(|(slot, _)| candidates.gap[slot]).collect(),
            }
        };
        CandidatesCheckpoint {
            list: (!self.stale).then(|| ListCheckpoint {
                bushings: [0, 1].map(|i| self.reference[i][..model.links].to_vec()),
                centers: (self.movable.iter())
                    .map(|&(_, center)| center.into())
                    .collect(),
                sprockets: self.sprockets.iter().map(runs).collect(),
            }),
            refreshes: self.refreshes,
        }
    }

    /// Restore the list of `checkpoint`; `None` when it does not belong to this model.
    pub(crate) fn restore(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        checkpoint: &CandidatesCheckpoint,
    ) -> Option<()> {
        self.refreshes = checkpoint.refreshes;
        self.stale = true;
        let Some(list) = &checkpoint.list else {
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
        for (s, (candidates, checkpoint)) in
            self.sprockets.iter_mut().zip(&list.sprockets).enumerate()
        {
            candidates.restore(model, memory, s, checkpoint)?;
            let behind = |run: &Run| (run.first + run.length).saturating_sub(n);
            let behind = candidates.runs.iter().map(behind).max();
            self.overhang = self.overhang.max(behind.unwrap_or(0));
        }
        self.stale = false;
        Some(())
    }
}

impl SprocketCandidates {
    /// Restore the candidates of sprocket `s`; `None` for bushings or gaps that do not exist in `model`.
    fn restore(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        s: usize,
        checkpoint: &RunsCheckpoint,
    ) -> Option<()> {
        let mut free = vec![true; model.links];
        self.runs.clear();
        for &(first, length) in &checkpoint.runs {
            if first >= model.links || !(1..=model.links).contains(&length) {
                return None;
            }
            // Each bushing occurs at most once in a list.
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
        if checkpoint.gaps.len() != bushings.len() {
            return None;
        }
        for ((slot, k), &gap) in bushings.into_iter().zip(&checkpoint.gaps) {
            let sprocket = &model.sprockets[s];
            sprocket.gap_directions.get(gap as usize)?;
            self.put_into_gap(slot, sprocket, gap);
            self.remember(model, memory, s, slot, k);
        }
        Some(())
    }
}

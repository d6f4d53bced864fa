//! What a list of candidates was made from: enough to make the very same list again.
//!
//! The list is a cache, but it decides the order in which a sprocket's sums run, and so their last bits.

use serde::{Deserialize, Serialize};

use super::Candidates;
use crate::contact::ImpactMemory;
use crate::geometry::Vec2;
use crate::model::Model;

/// A list, and how often lists were made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct CandidatesOrigin {
    /// `None` where the next evaluation makes a new one.
    list: Option<ListOrigin>,
    refreshes: u64,
}

/// What a list was made from, and what became of its hints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct ListOrigin {
    /// Where the bushings were, x and y \[m\].
    bushings: [Vec<f64>; 2],
    /// Where the sprockets were \[m\].
    centers: Vec<[f64; 2]>,
    /// For each sprocket, the gap that each candidate was last seen in, in the order of their slots.
    gaps: Vec<Vec<u32>>,
}

impl Candidates {
    /// What the present list was made from.
    pub(crate) fn origin(&self, model: &Model) -> CandidatesOrigin {
        let center = |s: usize| {
            let moved = self.movable.iter().find(|(movable, _)| *movable == s);
            moved.map_or(model.sprockets[s].center, |&(_, reference)| reference)
        };
        let sprockets = 0..model.sprockets.len();
        let gaps = |s: usize| {
            let candidates = self.sprockets[s].bushings(model.links);
            candidates.filter_map(move |(_, k)| self.gap(model, s, k))
        };
        CandidatesOrigin {
            list: (!self.stale).then(|| ListOrigin {
                bushings: [0, 1].map(|i| self.reference[i][..model.links].to_vec()),
                centers: sprockets.clone().map(|s| center(s).into()).collect(),
                gaps: sprockets.map(|s| gaps(s).collect()).collect(),
            }),
            refreshes: self.refreshes,
        }
    }

    /// Makes the list that `origin` tells of; `None` when there is no such list in this model.
    pub(crate) fn make_again(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        origin: &CandidatesOrigin,
    ) -> Option<()> {
        self.stale = true;
        if let Some(list) = &origin.list {
            let [x, y] = &list.bushings;
            let sprockets = model.sprockets.len();
            if x.len() != model.links || y.len() != model.links || list.centers.len() != sprockets {
                return None;
            }
            let frames = list.centers.iter().map(|&at| (Vec2::from(at), [1.0, 0.0]));
            self.refresh(model, memory, [x, y], frames);
            self.hint(model, &list.gaps)?;
        }
        self.refreshes = origin.refreshes;
        Some(())
    }

    /// Puts the candidates into these gaps.
    fn hint(&mut self, model: &Model, gaps: &[Vec<u32>]) -> Option<()> {
        for (s, candidates) in self.sprockets.iter_mut().enumerate() {
            let gaps = gaps.get(s)?;
            let slots: Vec<usize> = candidates.bushings(model.links).map(|(i, _)| i).collect();
            if gaps.len() != slots.len() {
                return None;
            }
            for (slot, &gap) in slots.into_iter().zip(gaps) {
                let direction = model.sprockets[s].gap_directions.get(gap as usize)?;
                (candidates.gap_cos[slot], candidates.gap_sin[slot]) = *direction;
            }
        }
        Some(())
    }
}

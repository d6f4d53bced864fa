//! Candidate list of a checkpoint: its bushings, their tooth gaps, and the reference positions of its validity.
//!
//! The list is a cache, but it determines the order of summation for a sprocket, and therefore the last bits of the sums. Its bushings
//! depend on positions and contacts at the time of its construction, which cannot be recovered: the checkpoint stores the list.

use serde::{Deserialize, Serialize};

use super::{BushingRun, Candidates, SprocketCandidates, lay_out};
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
            let behind = |run: &BushingRun| (run.first + run.length).saturating_sub(n);
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
            self.runs.push(BushingRun {
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

#[cfg(test)]
mod tests {
    use super::super::super::tests::{compiled, with_tensioner};
    use super::*;

    /// Return whether the list of a checkpoint with these runs and gaps of the first sprocket fits.
    fn fits(change: impl FnOnce(&mut ListCheckpoint)) -> bool {
        let (model, _) = compiled(&with_tensioner(None));
        let n = model.links;
        let mut list = ListCheckpoint {
            bushings: [vec![0.0; n], vec![0.0; n]],
            centers: vec![[0.0; 2]],
            sprockets: vec![
                RunsCheckpoint {
                    runs: vec![(2, 3), (n - 2, 4)],
                    gaps: vec![0, 1, 2, 13, 14, 15, 16],
                },
                RunsCheckpoint {
                    runs: vec![(0, n)],
                    gaps: vec![20; n],
                },
            ],
        };
        change(&mut list);
        let checkpoint = CandidatesCheckpoint {
            list: Some(list),
            refreshes: 7,
        };
        let memory = ImpactMemory::new(n, 0, 2 * n, 1e-3);
        let mut candidates = Candidates::new(&model);
        let found = candidates.restore(&model, &memory, &checkpoint);
        assert_eq!(candidates.refreshes(), 7);
        found.is_some()
    }

    #[test]
    fn only_a_list_of_bushings_and_gaps_of_the_model_is_restored() {
        assert!(fits(|_| ()));
        // Other numbers of bushings, of movable sprockets, of sprockets.
        assert!(!fits(|list| list.bushings[1].truncate(39)));
        assert!(!fits(|list| list.bushings[0].push(0.0)));
        assert!(!fits(|list| list.centers.clear()));
        assert!(!fits(|list| list.centers.push([0.0; 2])));
        assert!(!fits(|list| list.sprockets.truncate(1)));
        // Bushings that do not exist, are there twice, or make no run.
        assert!(!fits(|list| list.sprockets[0].runs[1] = (40, 4)));
        assert!(!fits(|list| list.sprockets[0].runs[1] = (4, 4)));
        assert!(!fits(|list| list.sprockets[0].runs[1] = (39, 4)));
        assert!(!fits(|list| {
            list.sprockets[0].runs[1].1 = 0;
            list.sprockets[0].gaps.truncate(3);
        }));
        assert!(!fits(|list| {
            list.sprockets[1] = RunsCheckpoint {
                runs: vec![(0, 41)],
                gaps: vec![20; 41],
            };
        }));
        // Gaps that do not exist, too few or too many.
        assert!(fits(|list| list.sprockets[0].gaps[6] = 0));
        assert!(!fits(|list| list.sprockets[0].gaps[6] = 17));
        assert!(!fits(|list| list.sprockets[0].gaps.truncate(6)));
        assert!(!fits(|list| list.sprockets[0].gaps.push(0)));
    }

    #[test]
    fn a_restored_list_reaches_past_the_last_bushing_by_its_longest_run() {
        let (model, _) = compiled(&with_tensioner(None));
        let n = model.links;
        let of = |runs: Vec<(usize, usize)>| {
            let count = runs.iter().map(|run| run.1).sum();
            RunsCheckpoint {
                runs,
                gaps: vec![3; count],
            }
        };
        for (runs, overhang) in [
            ([vec![(2, 3)], vec![(5, 8)]], 0),
            ([vec![(2, 3), (n - 1, 2)], vec![(n - 5, 8)]], 3),
            ([vec![(n - 3, 5)], vec![]], 2),
            ([vec![], vec![(n - 3, 3)]], 0),
        ] {
            let checkpoint = CandidatesCheckpoint {
                list: Some(ListCheckpoint {
                    bushings: [vec![0.5; n], vec![-0.5; n]],
                    centers: vec![[0.1, 0.2]],
                    sprockets: runs.map(of).to_vec(),
                }),
                refreshes: 1,
            };
            let memory = ImpactMemory::new(n, 0, 2 * n, 1e-3);
            let mut candidates = Candidates::new(&model);
            candidates.overhang = 17;
            candidates.restore(&model, &memory, &checkpoint).unwrap();
            assert_eq!(candidates.overhang, overhang);
            assert!(candidates.hold(0.0, |_| Vec2::new(0.1, 0.2)));
        }
    }
}

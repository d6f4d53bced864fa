//! Tooth jumps: detection of a chain that has moved to other tooth gaps than those in which it was seated.
//!
//! Successive bushings are seated in successive gaps. The gap of one seated bushing therefore determines the gap of every other one; a
//! seated bushing in a different gap is displaced by a whole number of teeth. The chain has jumped when all seated bushings of a sprocket
//! are displaced by the same number of teeth. As long as some of them are not displaced, the others can return.

use serde::{Deserialize, Serialize};

use crate::chain::model::Model;
use crate::geometry::Vec2;

/// Jump of a chain over one tooth of a sprocket.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ToothJump {
    /// End of the step after which all seated bushings were displaced \[s\].
    pub time: f64,
    /// Number of the sprocket, from 0.
    pub sprocket: usize,
    /// 1 for a counterclockwise rotation of the sprocket relative to the chain, -1 for a clockwise one.
    pub direction: i32,
}

/// A bushing seated on a sprocket, and its tooth gap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Seated {
    pub(crate) bushing: usize,
    pub(crate) gap: u32,
}

/// Seating of the chain on one sprocket.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Seating {
    /// Bushing near the middle of the wrap, and its gap.
    middle: Seated,
    /// Whether the gap number increases with the bushing number.
    rises: bool,
}

/// Seating of the chain on each sprocket, and the tooth jumps since the start of the run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ToothJumps {
    /// `None` for a sprocket without seated bushings so far.
    seatings: Vec<Option<Seating>>,
    jumps: Vec<ToothJump>,
}

impl ToothJumps {
    /// Create a record without jumps and without seated bushings.
    pub(crate) fn new(model: &Model) -> Self {
        Self {
            seatings: vec![None; model.toothed()],
            jumps: Vec::new(),
        }
    }

    /// Return the jumps since the start of the run, in the order of time.
    pub(crate) fn jumps(&self) -> &[ToothJump] {
        &self.jumps
    }

    /// Compare the seated bushings of sprocket `s` at time `t` \[s\] with its previous seating, and record jumps.
    ///
    /// `seated`: seated bushings in their order along the chain. `place` returns the centre of a bushing relative to the sprocket's \[m\].
    pub(crate) fn look(
        &mut self,
        model: &Model,
        (t, s): (f64, usize),
        seated: &[Seated],
        place: impl Fn(usize) -> Vec2,
    ) {
        let links = model.links;
        let Some(&middle) = middle_of(seated, links) else {
            return;
        };
        let seating = self.seatings[s].get_or_insert_with(|| {
            let k = middle.bushing;
            let along = place((k + 1) % links) - place((k + links - 1) % links);
            let rises = place(k).perp(&along) > 0.0;
            Seating { middle, rises }
        });
        let teeth = model.sprockets[s].profile.teeth;
        let off = |bushing: &Seated| seating.off_by(bushing, links, teeth);
        let teeth_moved = off(&middle);
        let gap = i64::from(middle.gap);
        if seated.iter().any(|bushing| off(bushing) != teeth_moved) {
            // Some bushings are not displaced: the previous seating remains the reference, expressed by the present middle bushing.
            let gap = wrapped(gap - teeth_moved, teeth);
            seating.middle = Seated { gap, ..middle };
            return;
        }
        seating.middle = middle;
        let direction = if teeth_moved > 0 { -1 } else { 1 };
        for _ in 0..teeth_moved.unsigned_abs() {
            self.jumps.push(ToothJump {
                time: t,
                sprocket: s,
                direction,
            });
        }
    }

    /// Discard all seatings; the next call of [`Self::look`] defines new ones without a jump.
    pub(crate) fn lose_seatings(&mut self) {
        self.seatings.fill(None);
    }

    /// Remove the jumps after `t` \[s\], for a run that restarts at `t`, and restore the seatings before them.
    pub(crate) fn remove_after(&mut self, model: &Model, t: f64) {
        while let Some(jump) = self.jumps.pop_if(|jump| jump.time > t) {
            if let Some(seating) = &mut self.seatings[jump.sprocket] {
                let teeth = model.sprockets[jump.sprocket].profile.teeth;
                let gap = i64::from(seating.middle.gap) + i64::from(jump.direction);
                seating.middle.gap = wrapped(gap, teeth);
            }
        }
    }

    /// Return whether sprockets, bushings and gaps of this record exist in `model`.
    pub(crate) fn is_like(&self, model: &Model) -> bool {
        let toothed = model.toothed();
        let fits = |(s, seating): (usize, &Option<Seating>)| {
            seating.is_none_or(|seating| {
                seating.middle.bushing < model.links
                    && seating.middle.gap < model.sprockets[s].profile.teeth
            })
        };
        self.seatings.len() == toothed
            && self.seatings.iter().enumerate().all(fits)
            && self.jumps.iter().all(|jump| jump.sprocket < toothed)
    }
}

impl Seating {
    /// Return the counterclockwise displacement of a bushing from its expected gap, in teeth.
    #[allow(clippy::cast_possible_wrap)] // links are few
    fn off_by(&self, seated: &Seated, links: usize, teeth: u32) -> i64 {
        let (links, round) = (links as i64, i64::from(teeth));
        let ahead = nearest_to_zero(seated.bushing as i64 - self.middle.bushing as i64, links);
        let gaps = if self.rises { ahead } else { -ahead };
        nearest_to_zero(
            i64::from(seated.gap) - i64::from(self.middle.gap) - gaps,
            round,
        )
    }
}

/// Return the bushing in the middle of a wrap: opposite the largest break between successive seated bushings.
fn middle_of(seated: &[Seated], links: usize) -> Option<&Seated> {
    let count = seated.len();
    let break_behind = |&i: &usize| {
        let next = seated[(i + 1) % count].bushing;
        (next + links - seated[i].bushing) % links
    };
    let last = (0..count).max_by_key(break_behind)?;
    seated.get((last + 1 + count / 2) % count)
}

/// Return the number nearest to zero that differs from `value` by a multiple of `round`.
fn nearest_to_zero(value: i64, round: i64) -> i64 {
    (value + round / 2).rem_euclid(round) - round / 2
}

/// Return the gap number in 0 to `teeth` - 1 that differs from `gap` by a multiple of `teeth`.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // below the number of teeth
fn wrapped(gap: i64, teeth: u32) -> u32 {
    gap.rem_euclid(i64::from(teeth)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seated(pairs: &[(usize, u32)]) -> Vec<Seated> {
        let one = |&(bushing, gap)| Seated { bushing, gap };
        pairs.iter().map(one).collect()
    }

    fn middle(bushings: &[usize], links: usize) -> Option<usize> {
        let pairs: Vec<_> = bushings.iter().map(|&k| (k, 0)).collect();
        middle_of(&seated(&pairs), links).map(|found| found.bushing)
    }

    #[test]
    fn the_middle_of_a_wrap_lies_opposite_its_largest_break() {
        assert_eq!(middle(&[3, 4, 5, 6, 7], 38), Some(5));
        assert_eq!(middle(&[0, 1, 2, 36, 37], 38), Some(0));
        assert_eq!(middle(&[9], 38), Some(9));
        // Of two, the second one along the chain.
        assert_eq!(middle(&[0, 1], 38), Some(1));
        assert_eq!(middle(&[0, 37], 38), Some(0));
        assert_eq!(middle(&[], 38), None);
    }

    #[test]
    fn neighbours_in_neighbouring_gaps_are_off_by_nothing_whatever_the_wrap() {
        let seating = |rises| Seating {
            middle: Seated {
                bushing: 1,
                gap: 16,
            },
            rises,
        };
        let off = |rises, bushing, gap| seating(rises).off_by(&Seated { bushing, gap }, 38, 17);
        assert_eq!((off(true, 2, 0), off(true, 37, 14)), (0, 0));
        assert_eq!((off(false, 2, 15), off(false, 37, 1)), (0, 0));
        assert_eq!((off(true, 2, 1), off(true, 2, 16)), (1, -1));
    }
    use super::super::tests::{compiled, drive};
    use crate::geometry::unit;

    /// Look at bushings 0 to 8 of a chain of 40 links on sprocket `s`, each in the gap of its number plus `moved`, counted as `rises` says.
    fn look(
        record: &mut ToothJumps,
        model: &Model,
        (t, s): (f64, usize),
        rises: bool,
        moved: impl Fn(usize) -> i64,
    ) {
        let teeth = i64::from(model.sprockets[s].profile.teeth);
        // Numbers from 36 on, over the end of the chain.
        let of = |i: usize| {
            let number = i64::try_from(i).unwrap();
            let gap = if rises { number } else { -number } + moved(i);
            Seated {
                bushing: (36 + i) % 40,
                gap: u32::try_from(gap.rem_euclid(teeth)).unwrap(),
            }
        };
        let mut seated: Vec<Seated> = (0..9).map(of).collect();
        seated.sort_by_key(|each| each.bushing);
        let sign = if rises { 1.0 } else { -1.0 };
        record.look(model, (t, s), &seated, |k| {
            unit(sign * ((k + 4) % 40) as f64 * 2.0 * std::f64::consts::PI / 17.0)
        });
    }

    #[test]
    fn a_chain_that_follows_its_sprocket_does_not_jump_and_one_that_slips_jumps_once_per_tooth() {
        let (model, _) = compiled(&drive());
        for (s, rises) in [(0, true), (0, false), (1, true), (1, false)] {
            let mut record = ToothJumps::new(&model);
            look(&mut record, &model, (0.0, s), rises, |_| 0);
            look(&mut record, &model, (0.1, s), rises, |_| 0);
            assert_eq!(record.jumps(), []);
            // A gap with a higher number: the sprocket has turned clockwise relative to the chain.
            look(&mut record, &model, (0.2, s), rises, |_| 1);
            let jump = |time, direction| ToothJump {
                time,
                sprocket: s,
                direction,
            };
            assert_eq!(record.jumps(), [jump(0.2, -1)]);
            look(&mut record, &model, (0.3, s), rises, |_| 1);
            look(&mut record, &model, (0.4, s), rises, |_| -1);
            assert_eq!(record.jumps(), [jump(0.2, -1), jump(0.4, 1), jump(0.4, 1)]);
            assert!(record.is_like(&model));
            // Without a seated bushing there is nothing to see.
            record.look(&model, (0.5, s), &[], |_| Vec2::zeros());
            assert_eq!(record.jumps().len(), 3);
            // New seatings are no jump.
            record.lose_seatings();
            look(&mut record, &model, (0.6, s), rises, |_| 5);
            assert_eq!(record.jumps().len(), 3);
        }
    }

    #[test]
    fn gap_numbers_rise_along_a_chain_that_runs_counterclockwise_about_its_sprocket() {
        let (model, _) = compiled(&drive());
        for k in [0, 5, 39] {
            // The neighbours of the middle bushing decide, also where they are not symmetric to it.
            for (before, after) in [(-0.3, 0.3), (-0.3, -0.01), (0.01, 0.3)] {
                for rises in [true, false] {
                    let mut record = ToothJumps::new(&model);
                    let sign = if rises { 1.0 } else { -1.0 };
                    record.look(&model, (0.0, 0), &seated(&[(k, 3)]), |bushing| {
                        let angles = [((k + 39) % 40, before), (k, 0.0), ((k + 1) % 40, after)];
                        let found = angles.iter().find(|(number, _)| *number == bushing);
                        found.map_or(Vec2::repeat(f64::NAN), |(_, angle)| unit(sign * angle))
                    });
                    assert_eq!(record.seatings[0].unwrap().rises, rises, "{k} {before}");
                }
            }
        }
    }

    #[test]
    fn bushings_that_return_to_their_gaps_have_not_jumped() {
        let (model, _) = compiled(&drive());
        let mut record = ToothJumps::new(&model);
        let half = |i: usize| i64::from(i >= 3);
        look(&mut record, &model, (0.0, 0), true, |_| 0);
        // The middle bushing has moved, the first three have not; then all return, or all have moved.
        look(&mut record, &model, (0.1, 0), true, half);
        look(&mut record, &model, (0.2, 0), true, |_| 0);
        assert_eq!(record.jumps(), []);
        look(&mut record, &model, (0.3, 0), true, half);
        look(&mut record, &model, (0.4, 0), true, half);
        look(&mut record, &model, (0.5, 0), true, |_| 1);
        assert_eq!(record.jumps().len(), 1);
        assert_eq!(record.jumps()[0].time, 0.5);
    }

    #[test]
    fn a_run_that_restarts_before_a_jump_sees_it_again() {
        let (model, _) = compiled(&drive());
        let mut record = ToothJumps::new(&model);
        look(&mut record, &model, (0.0, 0), true, |_| 0);
        look(&mut record, &model, (0.2, 0), true, |_| 1);
        look(&mut record, &model, (0.4, 0), true, |_| -1);
        assert_eq!(record.jumps().len(), 3);
        let first = record.jumps()[0];
        // A jump at the time of the restart remains.
        record.remove_after(&model, 0.4);
        assert_eq!(record.jumps().len(), 3);
        record.remove_after(&model, 0.3);
        assert_eq!(record.jumps(), [first]);
        look(&mut record, &model, (0.35, 0), true, |_| 1);
        assert_eq!(record.jumps(), [first]);
        record.remove_after(&model, 0.1);
        assert_eq!(record.jumps(), []);
        look(&mut record, &model, (0.15, 0), true, |_| 0);
        assert_eq!(record.jumps(), []);
    }

    #[test]
    fn a_record_of_other_sprockets_bushings_or_gaps_is_not_of_the_model() {
        let (model, _) = compiled(&drive());
        let of = |bushing: usize, gap: u32, sprocket: usize| {
            let mut record = ToothJumps::new(&model);
            let middle = Seated { bushing, gap };
            record.seatings[1] = Some(Seating {
                middle,
                rises: true,
            });
            record.jumps.push(ToothJump {
                time: 0.0,
                sprocket,
                direction: 1,
            });
            record
        };
        assert!(ToothJumps::new(&model).is_like(&model));
        assert!(of(39, 20, 1).is_like(&model));
        assert!(!of(40, 20, 1).is_like(&model));
        assert!(!of(39, 21, 1).is_like(&model));
        assert!(!of(39, 20, 2).is_like(&model));
        let mut other = ToothJumps::new(&model);
        other.seatings.push(None);
        assert!(!other.is_like(&model));
    }
}

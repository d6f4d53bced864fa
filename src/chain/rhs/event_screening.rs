//! Event screening: signed depths and their rates at both ends of a step for every hinge and candidate, and contacts with a possible
//! event in between.
//!
//! A signed depth is (d² - D²)/2D, positive in contact, where d is the distance of two centres and D its value at touch. It needs no
//! square root, is smooth where the centres coincide, and equals the penetration near zero.
//!
//! Values at the end of a step are those of the last evaluation: the predicted value of an explicit step, the last iterate of an
//! implicit one. Both are within the tolerance of the solution (decision 24).

use pulp::{Simd, WithSimd};
use serde::{Deserialize, Serialize};

use super::gap::{Form, Gap, GapConstants};
use super::layout::ChainArrays;
use super::pose::SprocketPose;
use super::{Kernels, on_teeth};
use crate::chain::contact::{Candidates, Run, SprocketCandidates};
use crate::chain::model::Model;
use crate::geometry::Vec2;
use crate::math::simd::{
    Lanes, Mask, Numbers, WIDTH, both, both_mut, lane_numbers, load, padded_zeros, splat_two,
    vectors,
};

/// Maximum over a step of the part of a cubic that a slope at one end contributes: 4/27 of slope times length.
const REACH_OF_SLOPES: f64 = 4.0 / 27.0;

/// Signed depths (d² - D²)/2D \[m\], positive in contact, and their rates \[m/s\] at both ends of a step. Depth and rate zero: unknown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct StepEndStates {
    start: [Numbers; 2],
    end: [Numbers; 2],
}

impl StepEndStates {
    /// Allocate `room` contacts.
    fn new(room: usize) -> Self {
        let zeros = || [padded_zeros(room), padded_zeros(room)];
        Self {
            start: zeros(),
            end: zeros(),
        }
    }

    /// Return signed depth and rate of contact `i` at the start and at the end.
    fn of(&self, i: usize) -> [[f64; 2]; 2] {
        [&self.start, &self.end].map(|[depth, rate]| [depth[i], rate[i]])
    }

    /// Exchange start and end.
    fn advance(&mut self) {
        std::mem::swap(&mut self.start, &mut self.end);
    }

    /// Return whether all arrays have the same lengths as those of `other`.
    fn is_like(&self, other: &Self) -> bool {
        let lengths =
            |ends: &Self| [&ends.start, &ends.end].map(|[depth, rate]| [depth.len(), rate.len()]);
        lengths(self) == lengths(other)
    }
}

/// Event screening of all hinges and candidates over successive steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Watch {
    pub(super) hinges: StepEndStates,
    /// Contacts between bushings and rollers; empty where rollers are no bodies of their own.
    pub(super) rollers: StepEndStates,
    /// Candidates of each sprocket, slot by slot.
    pub(super) teeth: Vec<StepEndStates>,
    /// Bushings of the slots: runs of each sprocket.
    runs: Vec<Vec<Run>>,
    /// Number of the list of candidates with these slots.
    list: u64,
}

impl Watch {
    /// Allocate the arrays for `model`.
    pub(super) fn new(model: &Model) -> Self {
        let slots = Candidates::most_slots(model);
        let sprockets = model.sprockets.iter();
        Self {
            hinges: StepEndStates::new(model.links),
            rollers: StepEndStates::new(model.roller_count()),
            teeth: sprockets
                .clone()
                .map(|_| StepEndStates::new(slots))
                .collect(),
            runs: sprockets
                .map(|_| Vec::with_capacity(slots / WIDTH))
                .collect(),
            list: 0,
        }
    }

    /// Return whether this state can replace `other`, the state of a chain of `links`.
    pub(crate) fn is_like(&self, other: &Self, links: usize) -> bool {
        let there = |run: &Run, slots: usize| {
            run.first < links
                && run.length <= links
                && run
                    .slot
                    .checked_add(run.length)
                    .is_some_and(|end| end <= slots)
        };
        self.hinges.is_like(&other.hinges)
            && self.rollers.is_like(&other.rollers)
            && self.teeth.len() == other.teeth.len()
            && self.runs.len() == other.runs.len()
            && (self.teeth.iter().zip(&other.teeth)).all(|(own, other)| own.is_like(other))
            && (self.runs.iter().zip(&self.teeth).zip(&other.runs)).all(|((runs, ends), room)| {
                runs.len() <= room.capacity()
                    && runs.iter().all(|run| there(run, ends.start[0].len()))
            })
    }

    /// Copy `other` without allocation.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.hinges.clone_from(&other.hinges);
        self.rollers.clone_from(&other.rollers);
        self.teeth.clone_from(&other.teeth);
        for (runs, others) in self.runs.iter_mut().zip(&other.runs) {
            runs.clear();
            runs.extend_from_slice(others);
        }
        self.list = other.list;
    }

    /// Make the end of this step the start of the next one.
    pub(crate) fn advance(&mut self) {
        self.hinges.advance();
        self.rollers.advance();
        self.teeth.iter_mut().for_each(StepEndStates::advance);
    }

    /// Return signed depth and rate of hinge `k` at both ends of the step.
    pub(crate) fn hinge(&self, k: usize) -> [[f64; 2]; 2] {
        self.hinges.of(k)
    }

    /// Return signed depth and rate of bushing `k` in its roller at both ends of the step.
    pub(crate) fn roller(&self, k: usize) -> [[f64; 2]; 2] {
        self.rollers.of(k)
    }

    /// Return sprocket, bushing, and signed depth and rate at both ends of the step for every candidate.
    pub(crate) fn candidates(
        &self,
        links: usize,
    ) -> impl Iterator<Item = (usize, usize, [[f64; 2]; 2])> {
        let sprockets = self.runs.iter().zip(&self.teeth).enumerate();
        sprockets.flat_map(move |(s, (runs, ends))| {
            runs.iter().flat_map(move |run| {
                (0..run.length).map(move |i| (s, run.bushing(i, links), ends.of(run.slot + i)))
            })
        })
    }

    /// Move the values of the start to the slots of a new list of candidates; new candidates have unknown values.
    pub(super) fn follow(&mut self, candidates: &Candidates, links: usize) {
        if self.list == candidates.refreshes() {
            return;
        }
        self.list = candidates.refreshes();
        let sprockets = self.teeth.iter_mut().zip(&mut self.runs);
        for ((ends, runs), candidates) in sprockets.zip(&candidates.sprockets) {
            let StepEndStates { start, end } = ends;
            for (start, end) in start.iter().zip(end.iter_mut()) {
                end.fill(0.0);
                for (slot, bushing) in candidates.bushings(links) {
                    let before = runs.iter().find_map(|run| {
                        let place = (bushing + links - run.first) % links;
                        (place < run.length).then_some(run.slot + place)
                    });
                    end[slot] = before.map_or(0.0, |before| start[before]);
                }
            }
            std::mem::swap(start, end);
            runs.clear();
            runs.extend_from_slice(&candidates.runs);
        }
    }
}

/// Return the contacts that may have touched between two separated ends of the step, or separated between two ends in contact.
///
/// The criterion for touch is the intersection of the tangents at both ends, which bounds every peak from above, a tip's included.
/// The criterion for separation is the lower bound of a cubic.
#[inline(always)]
fn may_have_event<S: Simd>(
    length: Lanes<S>,
    [start, start_rate]: [Lanes<S>; 2],
    [end, end_rate]: [Lanes<S>; 2],
) -> Mask<S> {
    let zero = length.constant(0.0);
    let least = -(-start).max(-end);
    let rising = start_rate.greater(zero).and(end_rate.less(zero));
    let falling = start_rate.less(zero).and(end_rate.greater(zero));
    // Height of the intersection times (rate at start - rate at end), which is positive here: g0 (-v1) + g1 v0 - h v0 v1.
    let slopes = start.mul_add(-end_rate, end * start_rate);
    let peak = (length * start_rate).mul_add(-end_rate, slopes);
    let touched = (start.max(end).less(zero))
        .and(rising)
        .and(peak.greater(zero));
    // Lower bound of the cubic: min(g0, g1) - 4/27 h (v1 - v0).
    let reach = length.constant(REACH_OF_SLOPES) * length;
    let fall = reach.mul_add(start_rate - end_rate, least);
    let parted = least.greater(zero).and(falling).and(fall.less(zero));
    touched.or(parted)
}

/// Result of event screening.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Watched {
    /// Whether an event inside the step is possible.
    pub(crate) event_possible: bool,
    /// Upper bound of the speed of the bushings relative to any tooth \[m/s\].
    pub(crate) speed: f64,
}

/// Kernel that screens all hinges at the end of a step of `length` \[s\], with the values of the last evaluation. The
/// speed is that of the bushings.
pub(super) struct WatchHinges<'a> {
    pub(super) length: f64,
    pub(super) links: usize,
    pub(super) clearance: f64,
    pub(super) arrays: &'a ChainArrays,
    pub(super) ends: &'a mut StepEndStates,
}

impl WithSimd for WatchHinges<'_> {
    type Output = Watched;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Watched {
        let splat = |value| Lanes::splat(simd, value);
        let blocks = self.links.div_ceil(S::F64_LANES);
        let length = splat(self.length);
        let scale = splat(0.5 / self.clearance);
        let half_clearance = splat(0.5 * self.clearance);
        let start = both::<S>(&self.ends.start, 0, blocks);
        let end = both_mut::<S>(&mut self.ends.end, 0, blocks);
        let distance_squared = vectors::<S>(&self.arrays.distance_squared, blocks);
        let along = vectors::<S>(&self.arrays.along, blocks);
        let velocity = both::<S>(&self.arrays.bushing_velocity, 0, blocks);
        let mut event_possible = false;
        let mut speed_squared = splat(0.0);
        for i in 0..blocks {
            let at = |array: &[S::f64s]| load(simd, &array[i]);
            // Signed depth (d² - c²)/(2 c) with the clearance c, and its rate (e · de/dt)/c.
            let depth = at(distance_squared).mul_add(scale, -half_clearance);
            let rate = at(along) * (scale + scale);
            event_possible |= may_have_event(length, two(simd, start, i), [depth, rate]).any();
            (end[0][i], end[1][i]) = (depth.values(), rate.values());
            let [vx, vy] = two(simd, velocity, i);
            let left = splat((self.links - i * S::F64_LANES) as f64);
            let own = lane_numbers(simd).less(left);
            let squared = own.select(vx.mul_add(vx, vy * vy), splat(0.0));
            speed_squared = speed_squared.max(squared);
        }
        Watched {
            event_possible,
            speed: speed_squared.greatest().sqrt(),
        }
    }
}

/// Return vector `i` of two arrays.
#[inline(always)]
fn two<S: Simd>(simd: S, arrays: [&[S::f64s]; 2], i: usize) -> [Lanes<S>; 2] {
    [load(simd, &arrays[0][i]), load(simd, &arrays[1][i])]
}

/// Kernel that screens the candidates of one sprocket; true where an event is possible.
pub(super) struct WatchTeeth<'a, C> {
    pub(super) length: f64,
    pub(super) constants: &'a C,
    pub(super) pose: &'a SprocketPose,
    pub(super) arrays: &'a ChainArrays,
    pub(super) candidates: &'a SprocketCandidates,
    pub(super) ends: &'a mut StepEndStates,
}

impl<C: GapConstants> WithSimd for WatchTeeth<'_, C> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let splat = |value| Lanes::splat(simd, value);
        let length = splat(self.length);
        let gaps = self.constants.gap(simd);
        let (center, own) = (
            splat_two(simd, self.pose.center),
            splat_two(simd, self.pose.velocity),
        );
        let (direction, spin) = (splat_two(simd, self.pose.direction), splat(self.pose.spin));
        let mut event_possible = false;
        for run in &self.candidates.runs {
            let blocks = run.length.div_ceil(S::F64_LANES);
            let bushing = both::<S>(&self.arrays.bushing, run.first, blocks);
            let velocity = both::<S>(&self.arrays.bushing_velocity, run.first, blocks);
            let gap_cos = vectors::<S>(&self.candidates.gap_cos[run.slot..], blocks);
            let gap_sin = vectors::<S>(&self.candidates.gap_sin[run.slot..], blocks);
            let start = both::<S>(&self.ends.start, run.slot, blocks);
            let end = both_mut::<S>(&mut self.ends.end, run.slot, blocks);
            for b in 0..blocks {
                let at = |array: &[S::f64s]| load(simd, &array[b]);
                let left = splat((run.length - b * S::F64_LANES) as f64);
                let valid = lane_numbers(simd).less(left);
                let [x, y] = two(simd, bushing, b);
                let [x, y] = [x - center[0], y - center[1]];
                let [vx, vy] = two(simd, velocity, b);
                let [vx, vy] = [vx - own[0], vy - own[1]];
                // Velocity of the bushing relative to the rotating sprocket.
                let relative = [spin.mul_add(y, vx), spin.negate_mul_add(x, vy)];
                let place = gaps.place([x, y], direction, [at(gap_cos), at(gap_sin)]);
                let surface = gaps.nearest(&place);
                let found = gaps.gap_and_rate(&surface, &place, relative);
                let before = two(simd, start, b);
                event_possible |= may_have_event(length, before, found).and(valid).any();
                (end[0][b], end[1][b]) = (found[0].values(), found[1].values());
            }
        }
        event_possible
    }
}

impl Kernels {
    /// Screen all contacts for events in a step of `length` \[s\]. The last evaluation must be at its end, see the module.
    pub(crate) fn watch(&mut self, model: &Model, length: f64) -> Watched {
        let n = model.links;
        self.watch.follow(&self.candidates, n);
        let mut watched = self.instructions.run(WatchHinges {
            length,
            links: n,
            clearance: model.hinges.clearance,
            arrays: &self.chain,
            ends: &mut self.watch.hinges,
        });
        if let (Some(rollers), Some(of)) = (&self.rollers, &model.rollers) {
            let found = self.instructions.run(WatchHinges {
                length,
                links: n,
                clearance: of.clearance,
                arrays: &rollers.arrays,
                ends: &mut self.watch.rollers,
            });
            watched.event_possible |= found.event_possible;
            watched.speed = watched.speed.max(found.speed);
        }
        let mut rim: f64 = 0.0;
        for (s, ends) in self.watch.teeth.iter_mut().enumerate() {
            let pose = &self.poses[s];
            macro_rules! watch {
                ($constants:expr) => {
                    self.instructions.run(WatchTeeth {
                        length,
                        constants: $constants,
                        pose,
                        arrays: on_teeth(&self.chain, self.rollers.as_deref()),
                        candidates: &self.candidates.sprockets[s],
                        ends,
                    })
                };
            }
            watched.event_possible |= match &self.teeth[self.kind[s]].form {
                Form::Ansi(gap) => watch!(gap),
                Form::Table(gap) => watch!(gap),
            };
            // Bound of the speed of any point of the teeth.
            let center_speed = Vec2::from(pose.velocity).norm();
            rim = rim.max(center_speed + pose.spin.abs() * model.sprockets[s].reach);
        }
        watched.speed += rim;
        watched
    }
}

//! Event screening: signed depths and their rates at both ends of a step for every hinge and candidate, and contacts with a possible
//! event in between.
//!
//! A signed depth is (d² - D²)/2D, positive in contact, where d is the distance of two centres and D its value at touch. It needs no
//! square root, is smooth where the centres coincide, and equals the penetration near zero.
//!
//! Values at the end of a step are those of the last evaluation before the screening: the predicted value of an explicit step, the last
//! iterate of an implicit one. Both are within the tolerance of the solution (decision 24). The evaluation of the teeth has nearest
//! surface and relative velocity at hand and writes the values of the candidates; the screening compares.

use pulp::{Simd, WithSimd};
use serde::{Deserialize, Serialize};

use super::Kernels;
use crate::chain::arrays::layout::ChainArrays;
use crate::chain::contact::{BushingRun, Candidates, ContactId, SprocketCandidates};
use crate::chain::model::Model;
use crate::geometry::Vec2;
use crate::math::simd::{Lanes, Numbers, WIDTH, both, both_mut, load, padded_zeros, vectors};

/// Maximum over a step of the part of a cubic that a slope at one end contributes: 4/27 of slope times length.
const REACH_OF_SLOPES: f64 = 4.0 / 27.0;

/// Signed depths (d² - D²)/2D \[m\], positive in contact, and their rates \[m/s\] at both ends of a step. Depth and rate zero: unknown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct StepEndStates {
    /// Boxes: each step exchanges two pointers.
    start: Box<[Numbers; 2]>,
    end: Box<[Numbers; 2]>,
}

impl StepEndStates {
    /// Allocate `room` contacts.
    fn new(room: usize) -> Self {
        let zeros = || Box::new([padded_zeros(room), padded_zeros(room)]);
        Self {
            start: zeros(),
            end: zeros(),
        }
    }

    /// Return signed depth and rate of contact `i` at the start and at the end.
    fn of(&self, i: usize) -> [[f64; 2]; 2] {
        [&*self.start, &*self.end].map(|[depth, rate]| [depth[i], rate[i]])
    }

    /// Copy `other`, whose arrays have the same lengths.
    fn copy_from(&mut self, other: &Self) {
        for (to, from) in [(&mut self.start, &other.start), (&mut self.end, &other.end)] {
            for (to, from) in to.iter_mut().zip(&**from) {
                to.copy_from_slice(from);
            }
        }
    }

    /// Exchange start and end.
    fn advance(&mut self) {
        std::mem::swap(&mut self.start, &mut self.end);
    }

    /// Return whether all arrays have the same lengths as those of `other`.
    fn is_like(&self, other: &Self) -> bool {
        let lengths =
            |ends: &Self| [&*ends.start, &*ends.end].map(|[depth, rate]| [depth.len(), rate.len()]);
        lengths(self) == lengths(other)
    }
}

/// Event screening of all hinges and candidates over successive steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct EventScreening {
    pub(super) hinges: StepEndStates,
    /// Contacts between bushings and rollers; empty where rollers are no bodies of their own.
    pub(super) rollers: StepEndStates,
    /// Candidates of each sprocket, slot by slot.
    pub(super) teeth: Vec<StepEndStates>,
    /// Bushings of the slots: runs of each sprocket.
    runs: Vec<Vec<BushingRun>>,
    /// Number of the list of candidates with these slots.
    list: u64,
}

impl EventScreening {
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
        let there = |run: &BushingRun, slots: usize| {
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
        self.hinges.copy_from(&other.hinges);
        self.rollers.copy_from(&other.rollers);
        for (ends, others) in self.teeth.iter_mut().zip(&other.teeth) {
            ends.copy_from(others);
        }
        for (runs, others) in self.runs.iter_mut().zip(&other.runs) {
            runs.clear();
            runs.extend_from_slice(others);
        }
        self.list = other.list;
    }

    /// Make the end of this step the start of the next one.
    fn advance(&mut self) {
        self.hinges.advance();
        self.rollers.advance();
        self.teeth.iter_mut().for_each(StepEndStates::advance);
    }

    /// Return signed depth and rate at both ends of the step for all hinges, rollers and candidates.
    pub(crate) fn contacts(
        &self,
        model: &Model,
    ) -> impl Iterator<Item = (ContactId, [[f64; 2]; 2])> {
        let links = model.links;
        let hinges = (0..links).map(|k| (ContactId::Hinge(k), self.hinges.of(k)));
        let rollers = 0..model.roller_count();
        let rollers = rollers.map(|k| (ContactId::Roller(k), self.rollers.of(k)));
        let sprockets = self.runs.iter().zip(&self.teeth).enumerate();
        let teeth = sprockets.flat_map(move |(s, (runs, ends))| {
            runs.iter().flat_map(move |run| {
                let pair = move |i| ContactId::Tooth(s * links + run.bushing(i, links));
                (0..run.length).map(move |i| (pair(i), ends.of(run.slot + i)))
            })
        });
        hinges.chain(rollers).chain(teeth)
    }

    /// Return the values at the end of the step of the candidates of sprocket `s`, for an evaluation that writes them.
    pub(super) fn tooth_ends(&mut self, s: usize) -> &mut [Numbers; 2] {
        &mut self.teeth[s].end
    }

    /// Move the values of the start to the slots of a new list of candidates; new candidates have unknown values. `spare` is as long as
    /// the slots of a sprocket.
    fn follow(&mut self, candidates: &Candidates, links: usize, spare: &mut Numbers) {
        if self.list == candidates.refreshes() {
            return;
        }
        self.list = candidates.refreshes();
        let sprockets = self.teeth.iter_mut().zip(&mut self.runs);
        for ((ends, runs), candidates) in sprockets.zip(&candidates.sprockets) {
            for start in &mut *ends.start {
                spare.fill(0.0);
                for (slot, bushing) in candidates.bushings(links) {
                    let before = runs.iter().find_map(|run| {
                        let place = (bushing + links - run.first) % links;
                        (place < run.length).then_some(run.slot + place)
                    });
                    spare[slot] = before.map_or(0.0, |before| start[before]);
                }
                std::mem::swap(start, spare);
            }
            runs.clear();
            runs.extend_from_slice(&candidates.runs);
        }
    }
}

/// Contacts that may have touched between two separated ends of the step, or separated between two ends in contact: the least and
/// the greatest number of all contacts, of which one is negative or one positive. (Numbers need fewer comparisons than masks.)
struct Events<S: Simd> {
    length: Lanes<S>,
    reach: Lanes<S>,
    touched: Lanes<S>,
    parted: Lanes<S>,
}

impl<S: Simd> Events<S> {
    /// Begin without an event, for a step of `length` \[s\].
    #[inline(always)]
    fn none(length: Lanes<S>) -> Self {
        Self {
            length,
            reach: length.constant(REACH_OF_SLOPES) * length,
            touched: length.constant(0.0),
            parted: length.constant(0.0),
        }
    }

    /// Include one vector of contacts.
    ///
    /// The criterion for touch is the intersection of the tangents at both ends, which bounds every peak from above, a tip's included.
    /// The criterion for separation is the lower bound of a cubic.
    #[inline(always)]
    fn include(&mut self, [[start, start_rate], [end, end_rate]]: [[Lanes<S>; 2]; 2]) {
        let least = start.min(end);
        // Height of the intersection times (rate at end - rate at start), which is negative here: g0 v1 - g1 v0 + h v0 v1.
        let slopes = start.mul_add(end_rate, -(end * start_rate));
        let peak = (self.length * start_rate).mul_add(end_rate, slopes);
        // Separated at both ends, rising at the start and falling at the end: all negative.
        let (falling, separated) = (-start_rate, start.max(end));
        let touched = separated.max(end_rate).max(falling).max(peak);
        // The sum is the second operand: these instructions return it where the first is no number.
        self.touched = touched.min(self.touched);
        // Lower bound of the cubic with opposite sign: 4/27 h (v1 - v0) - min(g0, g1). In contact at both ends: all positive.
        let fall = self.reach.mul_add(end_rate - start_rate, -least);
        let parted = least.min(end_rate).min(falling).min(fall);
        self.parted = parted.max(self.parted);
    }

    /// Return whether an event is possible.
    #[inline(always)]
    fn any(&self) -> bool {
        let zero = self.length.constant(0.0);
        (self.parted - self.touched).greater(zero).any()
    }
}

/// Result of event screening.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Screened {
    /// Whether an event inside the step is possible.
    pub(crate) event_possible: bool,
    /// Upper bound of the speed of the bushings relative to any tooth \[m/s\].
    pub(crate) speed: f64,
}

/// Kernel that compares both ends of a step of `length` \[s\]; true where an event is possible.
///
/// Evaluations have written the ends of the candidates; those of hinges and rollers follow from the arrays of the last one.
struct Screen<'a> {
    length: f64,
    links: usize,
    hinges: JointEnds<'a>,
    rollers: Option<JointEnds<'a>>,
    teeth: &'a [StepEndStates],
    candidates: &'a [SprocketCandidates],
}

/// Hinges, or rollers on their bushings, at the end of a step.
struct JointEnds<'a> {
    clearance: f64,
    arrays: &'a ChainArrays,
    ends: &'a mut StepEndStates,
}

impl WithSimd for Screen<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let length = Lanes::splat(simd, self.length);
        let blocks = self.links.div_ceil(S::F64_LANES);
        let mut events = Events::none(length);
        self.hinges.screen(&mut events, blocks);
        if let Some(rollers) = self.rollers {
            rollers.screen(&mut events, blocks);
        }
        for (ends, candidates) in self.teeth.iter().zip(self.candidates) {
            for run in &candidates.runs {
                let blocks = run.length.div_ceil(S::F64_LANES);
                let start = both::<S>(&ends.start, run.slot, blocks);
                let end = both::<S>(&ends.end, run.slot, blocks);
                for b in 0..blocks {
                    events.include([two(simd, start, b), two(simd, end, b)]);
                }
            }
        }
        events.any()
    }
}

impl JointEnds<'_> {
    /// Write the end of the step; include the joints in `events`.
    #[inline(always)]
    fn screen<S: Simd>(self, events: &mut Events<S>, blocks: usize) {
        let simd = events.length.simd();
        let scale = Lanes::splat(simd, 0.5 / self.clearance);
        let half_clearance = Lanes::splat(simd, 0.5 * self.clearance);
        let start = both::<S>(&self.ends.start, 0, blocks);
        let end = both_mut::<S>(&mut self.ends.end, 0, blocks);
        let distance_squared = vectors::<S>(&self.arrays.distance_squared, blocks);
        let along = vectors::<S>(&self.arrays.along, blocks);
        for i in 0..blocks {
            // Signed depth (d² - c²)/(2 c) with the clearance c, and its rate (e · de/dt)/c.
            let depth = load(simd, &distance_squared[i]).mul_add(scale, -half_clearance);
            let rate = load(simd, &along[i]) * (scale + scale);
            (end[0][i], end[1][i]) = (depth.values(), rate.values());
            events.include([two(simd, start, i), [depth, rate]]);
        }
    }
}

/// Return vector `i` of two arrays.
#[inline(always)]
fn two<S: Simd>(simd: S, arrays: [&[S::f64s]; 2], i: usize) -> [Lanes<S>; 2] {
    [load(simd, &arrays[0][i]), load(simd, &arrays[1][i])]
}

impl Kernels {
    /// Screen all contacts for events in a step of `length` \[s\]. The last evaluation must be at its end, see the module.
    pub(crate) fn screen(&mut self, model: &Model, length: f64) -> Screened {
        let n = model.links;
        let Self {
            screening, rollers, ..
        } = self;
        screening.follow(&self.candidates, n, &mut self.spare_slots);
        let rollers = rollers.as_ref().zip(model.rollers.as_ref());
        let event_possible = self.instructions.run(Screen {
            length,
            links: n,
            hinges: JointEnds {
                clearance: model.hinges.clearance,
                arrays: &self.chain,
                ends: &mut screening.hinges,
            },
            rollers: rollers.map(|(rollers, of)| JointEnds {
                clearance: of.clearance,
                arrays: &rollers.arrays,
                ends: &mut screening.rollers,
            }),
            teeth: &screening.teeth,
            candidates: &self.candidates.sprockets,
        });
        let mut rim: f64 = 0.0;
        for (sprocket, pose) in model.sprockets.iter().zip(&self.poses) {
            // Bound of the speed of any point of the teeth.
            let center_speed = Vec2::from(pose.velocity).norm();
            rim = rim.max(center_speed + pose.spin.abs() * sprocket.reach);
        }
        Screened {
            event_possible,
            speed: self.speed_squared.sqrt() + rim,
        }
    }

    /// Begin the next step: its start is the end of this one.
    pub(crate) fn advance_screening(&mut self) {
        self.screening.advance();
        self.write_gaps(true);
    }
}

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

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;
    use crate::chain::contact::ImpactMemory;
    use crate::chain::contact::tests::{compiled, drive, with_rollers};
    use crate::chain::motion::Motion;
    use crate::drive::Drive;
    use crate::math::simd::InstructionSet;

    /// Kernel: whether an event is possible in these contacts, in a step of this length.
    struct Possible<'a>(f64, &'a [[[f64; 2]; 2]]);

    impl WithSimd for Possible<'_> {
        type Output = bool;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> bool {
            let mut events = Events::none(Lanes::splat(simd, self.0));
            for ends in self.1 {
                events.include(ends.map(|end| end.map(|value| Lanes::splat(simd, value))));
            }
            events.any()
        }
    }

    /// Return whether the tangents at both ends intersect above zero, or the lower bound of the cubic is negative, and the distance from the
    /// limit.
    fn expected(h: f64, [[g0, v0], [g1, v1]]: [[f64; 2]; 2]) -> (bool, f64) {
        if g0 < 0.0 && g1 < 0.0 && v0 > 0.0 && v1 < 0.0 {
            let height = g0 + v0 * (g1 - g0 - v1 * h) / (v0 - v1);
            (height > 0.0, height.abs())
        } else if g0 > 0.0 && g1 > 0.0 && v0 < 0.0 && v1 > 0.0 {
            let least = g0.min(g1) - 4.0 / 27.0 * h * (v1 - v0);
            (least < 0.0, least.abs())
        } else {
            (false, f64::INFINITY)
        }
    }

    #[test]
    fn events_are_possible_by_the_tangents_at_both_ends_or_the_lower_bound_of_a_cubic() {
        let none = [[-1.0, -1.0], [-2.0, -1.0]];
        let (depths, rates) = (
            [-3.0, -1.1, -0.2, 0.3, 0.9, 2.5],
            [-4.0, -1.3, -0.3, 0.5, 1.0, 3.0],
        );
        let ends = || depths.iter().flat_map(|&g| rates.map(|v| [g, v]));
        for set in InstructionSet::available() {
            let mut counts = [0, 0];
            for h in [0.3, 0.7, 2.0] {
                for (start, end) in ends().flat_map(|start| ends().map(move |end| (start, end))) {
                    let contact = [start, end];
                    let (possible, from_limit) = expected(h, contact);
                    if from_limit < 1e-12 {
                        continue;
                    }
                    counts[usize::from(possible)] += 1;
                    for all in [[contact, none], [none, contact]] {
                        let found = set.run(Possible(h, &all));
                        assert_eq!(found, possible, "{} {h} {contact:?}", set.name());
                    }
                }
            }
            assert!(counts[1] > 100, "{counts:?}");
        }
    }

    /// A chain whose bodies have left their places by some micrometres, in motion.
    struct Scene {
        model: Model,
        kernels: Kernels,
        memory: ImpactMemory,
        y: Vec<f64>,
    }

    impl Scene {
        fn of(drive: &Drive) -> Self {
            let (model, start) = compiled(drive);
            let mut y = vec![0.0; 2 * model.coordinates];
            let mut motion = Motion::new(model.bodies());
            motion.set(&start.positions, &start.velocities);
            motion.write(&model, &mut y);
            let (q, v) = y.split_at_mut(model.coordinates);
            for (i, (q, v)) in q.iter_mut().zip(v).enumerate() {
                *q += 1e-5 * (3.0 * i as f64).sin();
                *v = 0.3 + (5.0 * i as f64).sin();
            }
            let pairs = model.links * model.sprockets.len();
            let memory = ImpactMemory::new(model.links, model.roller_count(), pairs, 1e-3);
            let kernels = Kernels::new(&model);
            let mut scene = Self {
                model,
                kernels,
                memory,
                y,
            };
            scene.evaluate();
            scene
        }

        fn evaluate(&mut self) {
            let mut accelerations = vec![0.0; self.model.coordinates];
            let (memory, y) = (&self.memory, &self.y);
            self.kernels
                .accelerations(&self.model, memory, 0.0, y, &mut accelerations);
        }

        fn screen(&mut self) -> Screened {
            self.kernels.screen(&self.model, 1e-5)
        }

        fn contacts(&self) -> Vec<(ContactId, [[f64; 2]; 2])> {
            self.kernels.screening.contacts(&self.model).collect()
        }

        /// Return place and velocity of the point `arm` along a link, or of the centre of the body with these three coordinates.
        fn point(&self, [x, y, angle]: [usize; 3], arm: f64) -> [Vec2; 2] {
            let (q, v) = self.y.split_at(self.model.coordinates);
            let (sin, cos) = q[angle].sin_cos();
            [
                Vec2::new(q[x] + arm * cos, q[y] + arm * sin),
                Vec2::new(v[x] - arm * v[angle] * sin, v[y] + arm * v[angle] * cos),
            ]
        }

        /// Return the ends of the links at a hinge: the front of link k and the rear of the next one.
        fn ends(&self, k: usize) -> [[Vec2; 2]; 2] {
            let (n, arms) = (self.model.links, &self.model.chain.arms);
            let next = (k + 1) % n;
            [
                self.point([k, n + k, 2 * n + k], arms[k]),
                self.point([next, n + next, 2 * n + next], -arms[next]),
            ]
        }

        fn bushing(&self, k: usize) -> [Vec2; 2] {
            self.ends(k)[usize::from(self.model.link_of_bushing(k) != k)]
        }

        fn roller(&self, k: usize) -> [Vec2; 2] {
            let (n, first) = (self.model.links, self.model.rollers.as_ref().unwrap().first);
            self.point([0, 1, 2].map(|axis| first + axis * n + k), 0.0)
        }
    }

    #[test]
    fn depths_rates_and_speed_at_the_end_of_a_step_are_those_of_the_bodies() {
        for drive in [drive(), with_rollers()] {
            let mut scene = Scene::of(&drive);
            let screened = scene.screen();
            let (model, mut compared, mut fastest) = (&scene.model, 0, 0.0f64);
            for (contact, [_, [depth, rate]]) in scene.contacts() {
                let ([one, other], clearance) = match contact {
                    ContactId::Hinge(k) => (scene.ends(k), model.hinges.clearance),
                    ContactId::Roller(k) => (
                        [scene.roller(k), scene.bushing(k)],
                        model.rollers.as_ref().unwrap().clearance,
                    ),
                    ContactId::Tooth(_) => continue,
                };
                let (offset, velocity) = (one[0] - other[0], one[1] - other[1]);
                let expected = (offset.norm_squared() - clearance * clearance) / (2.0 * clearance);
                // Rounding of coordinates below 1 m and of velocities below 10 m/s.
                assert!((depth - expected).abs() < 1e-14, "{contact:?}");
                let expected = offset.dot(&velocity) / clearance;
                assert!((rate - expected).abs() < 1e-10, "{contact:?}");
                compared += 1;
            }
            assert_eq!(compared, model.links + model.roller_count());
            for k in 0..model.links {
                fastest = fastest.max(scene.bushing(k)[1].norm());
                if model.rollers.is_some() {
                    fastest = fastest.max(scene.roller(k)[1].norm());
                }
            }
            // Both sprockets are on fixed shafts; the first one turns with 12 rad/s.
            let free = scene.y[model.coordinates + 3 * model.links];
            let [first, second] = [0, 1].map(|s: usize| model.sprockets[s].reach);
            let rim = (12.0 * first).max(free.abs() * second);
            assert!((screened.speed / (fastest + rim) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_end_of_a_step_is_the_start_of_the_next_one() {
        let mut scene = Scene::of(&with_rollers());
        scene.screen();
        let before = scene.contacts();
        scene.kernels.write_gaps(false);
        scene.kernels.advance_screening();
        assert!(scene.kernels.write_gaps(true));
        let n = scene.model.links;
        for (i, ((contact, [_, end]), (_, [start, _]))) in
            before.iter().zip(scene.contacts()).enumerate()
        {
            assert_eq!(*end, start, "{contact:?}");
            assert!(i >= n || *end != [0.0; 2], "{contact:?}");
        }
    }

    #[test]
    fn values_of_candidates_follow_into_the_slots_of_a_new_list() {
        let mut scene = Scene::of(&drive());
        scene.screen();
        scene.kernels.advance_screening();
        let before: HashMap<usize, [f64; 2]> = (scene.contacts().into_iter())
            .filter_map(|(contact, [start, _])| match contact {
                ContactId::Tooth(pair) => Some((pair, start)),
                _ => None,
            })
            .collect();
        let list = scene.kernels.candidates.refreshes();
        let n = scene.model.links;
        // All links are displaced by some 6 mm: bushings leave the reach of a sprocket, and others enter it.
        for (i, q) in scene.y[..2 * n].iter_mut().enumerate() {
            *q += if i < n { 6e-3 } else { -1e-3 };
        }
        scene.evaluate();
        assert!(scene.kernels.candidates.refreshes() > list);
        scene.screen();
        let (mut kept, mut new) = ([0, 0], 0);
        for (contact, [start, end]) in scene.contacts() {
            let ContactId::Tooth(pair) = contact else {
                continue;
            };
            assert!(end != [0.0; 2], "{contact:?}");
            if let Some(before) = before.get(&pair) {
                assert_eq!(start, *before, "{contact:?}");
                kept[pair / n] += 1;
            } else {
                assert_eq!(start, [0.0; 2], "{contact:?}");
                new += 1;
            }
        }
        assert!(
            kept.iter().all(|&count| count > 5) && new > 0,
            "{kept:?} {new}"
        );
        // One of the runs goes on from the last bushing to the first.
        let mut runs = scene
            .kernels
            .candidates
            .sprockets
            .iter()
            .flat_map(|of| &of.runs);
        assert!(runs.any(|run| run.first + run.length > n));
    }
}

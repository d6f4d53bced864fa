//! Paths of all contacts along a step: cubics of their penetrations, penetration rates, lever arms and sliding velocities through both ends
//! of the step, from which the powers inside it follow without an evaluation of the right-hand side.
//!
//! Penetration and penetration rate have a cubic each, as coordinates and velocities have in the energy quadrature (decision 22).

mod joints;
mod kernels;
mod powers;
mod teeth;

use pulp::Simd;
use serde::{Deserialize, Serialize};

use crate::chain::contact::{Candidates, Run, SprocketCandidates, slot_of};
use crate::chain::model::Model;
use crate::math::simd::{Numbers, WIDTH, both_mut, padded_zeros};

/// Quantities of one kind of contacts at one end of a step. Arrays of quantities that these contacts do not have are empty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Ends {
    /// Penetration \[m\], negative without contact, and its first and second derivative.
    penetration: [Numbers; 3],
    /// Lever arm of the normal force about the sprocket's centre \[m\], and its rate.
    lever: [Numbers; 2],
    /// Number of the nearest surface of the teeth.
    surface: Numbers,
    /// Sliding velocity \[m/s\], and its rate.
    slip: [Numbers; 2],
    /// Lever arm of friction about the sprocket's centre \[m\].
    friction_lever: Numbers,
}

impl Ends {
    /// Allocate the quantities of `contacts`.
    fn new(contacts: usize, on_teeth: bool, rubbed: bool) -> Self {
        let zeros = |exist: bool| padded_zeros(if exist { contacts } else { 0 });
        Self {
            penetration: [0, 1, 2].map(|_| zeros(true)),
            lever: [0, 1].map(|_| zeros(on_teeth)),
            surface: zeros(on_teeth),
            slip: [0, 1].map(|_| zeros(rubbed)),
            friction_lever: zeros(on_teeth && rubbed),
        }
    }

    /// Return all arrays.
    fn arrays(&self) -> [&Numbers; 9] {
        let ([a, b, c], [d, e], [f, g]) = (&self.penetration, &self.lever, &self.slip);
        [a, b, c, d, e, f, g, &self.surface, &self.friction_lever]
    }

    /// Return all arrays, mutable.
    fn arrays_mut(&mut self) -> [&mut Numbers; 9] {
        let Self {
            penetration: [a, b, c],
            lever: [d, e],
            surface,
            slip: [f, g],
            friction_lever,
        } = self;
        [a, b, c, d, e, f, g, surface, friction_lever]
    }
}

/// One kind of contacts at both ends of a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Path {
    start: Ends,
    end: Ends,
}

impl Path {
    fn new(ends: Ends) -> Self {
        Self {
            start: ends.clone(),
            end: ends,
        }
    }

    /// Make the end of this step the start of the next one.
    fn advance(&mut self) {
        std::mem::swap(&mut self.start, &mut self.end);
    }

    /// Return whether all arrays have the same lengths as those of `other`.
    fn is_like(&self, other: &Self) -> bool {
        let lengths = |ends: &Ends| ends.arrays().map(|array| array.len());
        lengths(&self.start) == lengths(&other.start) && lengths(&self.end) == lengths(&other.end)
    }

    /// Move the values of the start from the slots of `runs` to those of new `candidates`; new candidates are open.
    fn follow(&mut self, runs: &[Run], candidates: &SprocketCandidates, links: usize) {
        let starts = self.start.arrays_mut().into_iter();
        for (start, end) in starts.zip(self.end.arrays_mut()) {
            end.fill(0.0);
            if !start.is_empty() {
                for (slot, bushing) in candidates.bushings(links) {
                    end[slot] = slot_of(runs, bushing, links).map_or(0.0, |before| start[before]);
                }
            }
            std::mem::swap(start, end);
            end.fill(0.0);
        }
    }
}

/// All contacts at both ends of a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct StepPaths {
    hinges: Path,
    /// Bushings in their rollers; empty where rollers are no bodies of their own.
    rollers: Path,
    /// Candidates of each sprocket, slot by slot.
    teeth: Vec<Path>,
    /// Bushings of the slots: runs of each sprocket.
    runs: Vec<Vec<Run>>,
    /// Number of the list of candidates with these slots.
    list: u64,
}

impl StepPaths {
    fn new(model: &Model) -> Self {
        let slots = Candidates::most_slots(model);
        let joints = |count| Path::new(Ends::new(count, false, model.hinges.friction.is_some()));
        let teeth = || Path::new(Ends::new(slots, true, model.teeth.friction.is_some()));
        Self {
            hinges: joints(model.links),
            rollers: joints(model.roller_count()),
            teeth: model.sprockets.iter().map(|_| teeth()).collect(),
            runs: (model.sprockets.iter())
                .map(|_| Vec::with_capacity(slots / WIDTH))
                .collect(),
            list: 0,
        }
    }

    /// Return whether this state can replace `other`, the state of a chain of `links`.
    fn is_like(&self, other: &Self, links: usize) -> bool {
        let exists = |run: &Run, slots: usize| {
            run.first < links
                && run.length <= links
                && (run.slot.checked_add(run.length)).is_some_and(|end| end <= slots)
        };
        self.hinges.is_like(&other.hinges)
            && self.rollers.is_like(&other.rollers)
            && self.teeth.len() == other.teeth.len()
            && self.runs.len() == other.runs.len()
            && (self.teeth.iter().zip(&other.teeth)).all(|(own, other)| own.is_like(other))
            && (self.runs.iter().zip(&self.teeth).zip(&other.runs)).all(|((runs, path), room)| {
                let slots = path.start.penetration[0].len();
                runs.len() <= room.capacity() && runs.iter().all(|run| exists(run, slots))
            })
    }

    /// Copy `other` without allocation.
    fn carry_on(&mut self, other: &Self) {
        let own = [&mut self.hinges, &mut self.rollers].into_iter();
        let others = [&other.hinges, &other.rollers].into_iter();
        for (own, other) in own.chain(&mut self.teeth).zip(others.chain(&other.teeth)) {
            for (own, other) in [(&mut own.start, &other.start), (&mut own.end, &other.end)] {
                for (own, other) in own.arrays_mut().into_iter().zip(other.arrays()) {
                    own.copy_from_slice(other);
                }
            }
        }
        for (runs, others) in self.runs.iter_mut().zip(&other.runs) {
            runs.clear();
            runs.extend_from_slice(others);
        }
        self.list = other.list;
    }
}

/// Motion of the bushings or of the rollers. Copies of the first ones follow the last, for runs of candidates past the last one.
#[derive(Debug, Clone)]
struct BodyMotion {
    /// x, y \[m\], and their derivatives.
    place: [Numbers; 2],
    velocity: [Numbers; 2],
    acceleration: [Numbers; 2],
    /// dθ/dt \[rad/s\] and d²θ/dt² \[rad/s²\].
    spin: [Numbers; 2],
}

/// The same in SIMD vectors.
struct BodyVectors<'a, S: Simd> {
    place: [&'a mut [S::f64s]; 2],
    velocity: [&'a mut [S::f64s]; 2],
    acceleration: [&'a mut [S::f64s]; 2],
    spin: [&'a mut [S::f64s]; 2],
}

impl BodyMotion {
    fn new(model: &Model) -> Self {
        let zeros = || [0, 1].map(|_| padded_zeros(2 * model.links + 3 * WIDTH));
        Self {
            place: zeros(),
            velocity: zeros(),
            acceleration: zeros(),
            spin: zeros(),
        }
    }

    #[inline(always)]
    fn vectors<S: Simd>(&mut self, blocks: usize) -> BodyVectors<'_, S> {
        BodyVectors {
            place: both_mut::<S>(&mut self.place, 0, blocks),
            velocity: both_mut::<S>(&mut self.velocity, 0, blocks),
            acceleration: both_mut::<S>(&mut self.acceleration, 0, blocks),
            spin: both_mut::<S>(&mut self.spin, 0, blocks),
        }
    }

    /// Copy the first `overhang` of `links` bodies behind the last one.
    fn repeat(&mut self, links: usize, overhang: usize) {
        let arrays = [
            &mut self.place,
            &mut self.velocity,
            &mut self.acceleration,
            &mut self.spin,
        ];
        for array in arrays.into_iter().flatten() {
            array.copy_within(..overhang, links);
        }
    }
}

/// Time inside a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Inside {
    /// Part of the step.
    pub(crate) part: f64,
    /// Length of the step \[s\].
    pub(crate) length: f64,
    /// Time \[s\].
    pub(crate) t: f64,
}

/// Paths of the contacts of a model, and arrays of their kernels.
#[derive(Debug, Clone)]
pub(crate) struct PathTracer {
    pub(crate) paths: StepPaths,
    /// Law constants of the surfaces at the end of the step, slot by slot.
    law: Vec<[Numbers; 2]>,
    bushings: BodyMotion,
    rollers: BodyMotion,
}

impl PathTracer {
    /// Return the tracer of `model`; `None` where powers depend on more than penetrations and sliding velocities: lubricant, elastic
    /// plates, bristles, and ends of an open chain.
    pub(crate) fn of(model: &Model) -> Option<Self> {
        if model.hinges.has_film_or_compliance()
            || !model.bristles.is_empty()
            || model.ends.is_some()
        {
            return None;
        }
        let slots = Candidates::most_slots(model);
        let pairs = model.sprockets.iter();
        Some(Self {
            paths: StepPaths::new(model),
            law: pairs.map(|_| [0, 1].map(|_| padded_zeros(slots))).collect(),
            bushings: BodyMotion::new(model),
            rollers: BodyMotion::new(model),
        })
    }

    /// Make the end of this step the start of the next one.
    pub(crate) fn advance(&mut self) {
        self.paths.hinges.advance();
        self.paths.rollers.advance();
        self.paths.teeth.iter_mut().for_each(Path::advance);
    }

    /// Continue from the paths of a checkpoint; `None`: they belong to a different model.
    pub(crate) fn carry_on(&mut self, paths: &StepPaths, links: usize) -> Option<()> {
        paths
            .is_like(&self.paths, links)
            .then(|| self.paths.carry_on(paths))
    }

    /// Move the start of the step to the slots of a new list of candidates.
    fn follow(&mut self, candidates: &Candidates, links: usize) {
        let paths = &mut self.paths;
        if paths.list == candidates.refreshes() {
            return;
        }
        paths.list = candidates.refreshes();
        let sprockets = paths.teeth.iter_mut().zip(&mut paths.runs);
        for ((path, runs), candidates) in sprockets.zip(&candidates.sprockets) {
            path.follow(runs, candidates, links);
            runs.clear();
            runs.extend_from_slice(&candidates.runs);
        }
    }
}

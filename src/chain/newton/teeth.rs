//! Terms of the contacts between bushings and teeth: stiffness of the teeth at each bushing, and columns of the sprockets' own
//! coordinates. The matrix is symmetric: the columns are rows too.

use std::ops::Range;

use super::border::Corner;
use super::contacts::scaled;
use super::ring::BASE;
use super::tooth_motion::{BorderMotion, MOST, ToothMotion};
use crate::chain::arrays::pose::SprocketPose;
use crate::chain::arrays::slopes::{ContactSlopes, SlopeGroup};
use crate::chain::contact::{BushingRun, SprocketCandidates};
use crate::math::simd::{
    Lanes, Number, Numbers, Pack, PartialSums, Vectors, WIDTH, fold_packs, packs_from,
    packs_from_mut, padded, padded_zeros, part_of, parts, put_part, read_rounded, rounded_part,
};

/// Terms of the teeth, bushing by bushing: change of the force per change of the bushing's velocity, and per change of each
/// coordinate on the border. Bushing k is at [`BASE`] + k; a copy of the last one precedes the first. Everything is zero outside of
/// the marked groups of [`WIDTH`] bushings.
#[derive(Debug, Clone)]
pub(super) struct ToothTerms<T: Number> {
    /// xx, yy, xy
    pub(super) tooth_stiffness: [Numbers<T>; 3],
    /// Moments about the bushings by friction: per change of their velocity, x and y, and of their angular velocity.
    pub(super) spun: [Numbers<T>; 3],
    /// Force x and y of each coordinate, and its moment about the bushing.
    pub(super) column: Vec<[Numbers<T>; 3]>,
    /// Marks of the groups that are not zero.
    touched: Vec<bool>,
}

/// Run `$each` for every array of terms, with these columns; for those of moments only with `$friction`. (An iterator over all arrays is not
/// inlined.)
macro_rules! each_array {
    ($terms:expr, $columns:expr, $friction:expr, |$array:ident| $each:block) => {
        for $array in &mut $terms.tooth_stiffness $each
        for [x, y, moment] in &mut $terms.column[$columns] {
            for $array in [x, y] $each
            if $friction {
                let $array = moment;
                $each
            }
        }
        if $friction {
            for $array in &mut $terms.spun $each
        }
    };
}

impl<T: Number> ToothTerms<T> {
    /// Allocate the terms of `links` bushings and `border` coordinates.
    pub(super) fn new(links: usize, border: usize) -> Self {
        let room = padded(BASE + 2 * links + 3 * WIDTH);
        let zeros = || padded_zeros(room);
        Self {
            tooth_stiffness: [(); 3].map(|()| zeros()),
            spun: [(); 3].map(|()| zeros()),
            column: (0..border).map(|_| [(); 3].map(|()| zeros())).collect(),
            touched: vec![false; room / WIDTH],
        }
    }

    /// Set the terms of all groups of `links` bushings to zero. Terms behind them are zero since [`Self::fold_overhang`], which ends each
    /// assembly of teeth.
    #[inline(always)]
    pub(super) fn clear<const FRICTION: bool>(&mut self, links: usize) {
        self.touched.fill(false);
        each_array!(self, .., FRICTION, |array| {
            array[..BASE + padded(links)].fill(T::default());
        });
    }

    /// Mark the group with bushing `k`.
    #[inline(always)]
    pub(super) fn touch(&mut self, k: usize) {
        self.touched[k / WIDTH] = true;
    }

    /// Copy the last one of `links` bushings to the entry before the first, where it is not zero.
    #[inline(always)]
    pub(super) fn repeat_last<const FRICTION: bool>(&mut self, links: usize) {
        if !self.touches(links - 1) {
            return;
        }
        each_array!(self, .., FRICTION, |array| {
            array[BASE - 1] = array[BASE + links - 1];
        });
    }

    /// Return whether the group with bushing `k` is marked.
    #[inline(always)]
    pub(super) fn touches(&self, k: usize) -> bool {
        self.touched[k / WIDTH]
    }

    /// Add the terms that runs past the last bushing have written behind it to the first bushings. Only these `columns` have such terms. Copy
    /// the last bushing to the entry before the first.
    #[inline(always)]
    pub(super) fn fold_overhang<S: Vectors<Number = T>, const FRICTION: bool>(
        &mut self,
        simd: S,
        (links, overhang): (usize, usize),
        columns: Range<usize>,
    ) {
        let behind = links / WIDTH..(links + overhang).div_ceil(WIDTH);
        if overhang > 0 && self.touched[behind].contains(&true) {
            let count = overhang.div_ceil(WIDTH);
            self.touched[..count].fill(true);
            each_array!(self, columns, FRICTION, |array| {
                // Entries behind the overhang are zero. The last group of rollers contains the first of them.
                fold_packs(simd, &mut array[BASE..], links, count);
                array[BASE + links..][..count * WIDTH].fill(T::default());
            });
        }
        self.repeat_last::<FRICTION>(links);
    }
}

/// Candidates of one sprocket, to be added to the terms. `FRICTION`: with friction.
pub(super) struct AddTeeth<'a, const FRICTION: bool> {
    pub(super) gamma: f64,
    pub(super) pose: &'a SprocketPose,
    pub(super) candidates: &'a SprocketCandidates,
    pub(super) slopes: &'a ContactSlopes,
    /// Centres of the bushings \[m\].
    pub(super) bushing: &'a [Numbers; 2],
    /// Radius of the bushings \[m\].
    pub(super) bushing_radius: f64,
    /// Coordinates of the sprocket; the first is number `first` on the border.
    pub(super) motions: &'a [BorderMotion],
    pub(super) first: usize,
}

impl<const FRICTION: bool> AddTeeth<'_, FRICTION> {
    /// Return the columns with terms behind the last one of `links` bushings; `others` are those of other sprockets.
    #[inline(always)]
    pub(super) fn columns_behind(&self, links: usize, others: Range<usize>) -> Range<usize> {
        let passes = |run: &BushingRun| run.first + run.length > links;
        if !self.candidates.runs.iter().any(passes) {
            return others;
        }
        let own = self.first..self.first + self.motions.len();
        if others.is_empty() {
            return own;
        }
        others.start.min(own.start)..others.end.max(own.end)
    }
}

impl<const FRICTION: bool> AddTeeth<'_, FRICTION> {
    /// Add all candidates to `terms`, and the entries of the sprocket's coordinates among themselves to `corner`.
    #[inline(always)]
    pub(super) fn add<S: Vectors>(
        &self,
        simd: S,
        terms: &mut ToothTerms<S::Number>,
        corner: &mut Corner,
    ) {
        let zero = Lanes::splat(simd, 0.0);
        let mut among = [[PartialSums::default(); MOST]; MOST];
        for run in &self.candidates.runs {
            let groups = run.length.div_ceil(WIDTH);
            let [x, y] = self.bushing;
            let (x, y) = (
                packs_from(x, run.first, groups),
                packs_from(y, run.first, groups),
            );
            let ToothTerms {
                tooth_stiffness: [xx, yy, xy],
                spun,
                column,
                touched,
                ..
            } = &mut *terms;
            let first = BASE + run.first;
            let mut terms = TermsOfRun {
                first,
                tooth_stiffness: [
                    packs_from_mut(xx, first, groups),
                    packs_from_mut(yy, first, groups),
                    packs_from_mut(xy, first, groups),
                ],
                spun,
                columns: &mut column[self.first..],
            };
            let slopes = &self.slopes.normal[run.slot / WIDTH..][..groups];
            let friction = &self.slopes.friction[if FRICTION { run.slot / WIDTH } else { 0 }..];
            for number in 0..groups {
                let slopes = &slopes[number];
                for part in parts::<S>() {
                    let force = slopes.force.rounded(simd, part);
                    if !force.exceeds(zero).any() {
                        continue;
                    }
                    let center = [
                        rounded_part(simd, &x[number], part),
                        rounded_part(simd, &y[number], part),
                    ];
                    let friction = FRICTION.then(|| friction[number].slope.rounded(simd, part));
                    let tooth = self.tooth(center, force, (slopes, part), friction);
                    let group = run.first + number * WIDTH;
                    // A run may begin within a group: its vectors then reach into the next one.
                    touched[group / WIDTH] = true;
                    touched[group.div_ceil(WIDTH)] = true;
                    terms.hold::<S, FRICTION>((number, part), &tooth);
                    let place = (number, part);
                    terms.couple::<S, FRICTION>(place, &tooth, self.motions, &mut among);
                }
            }
        }
        // The matrix is symmetric: entries on and above the diagonal are enough.
        for j in 0..self.motions.len().min(MOST) {
            for i in 0..=j {
                let entry = among[i][j].total();
                corner.add(self.first + i, self.first + j, entry);
                if i < j {
                    corner.add(self.first + j, self.first + i, entry);
                }
            }
        }
    }

    /// Return one vector of bushings in contact, with these centres \[m\], normal forces \[N\] and, for `FRICTION`, slopes of friction.
    #[inline(always)]
    fn tooth<S: Vectors>(
        &self,
        [x, y]: [Lanes<S>; 2],
        force: Lanes<S>,
        (slopes, part): (&SlopeGroup, usize),
        friction: Option<Lanes<S>>,
    ) -> ToothMotion<S> {
        let simd = force.simd();
        let splat = |value| Lanes::splat(simd, value);
        let [alpha, mut eta] = scaled(self.gamma, simd, slopes, part);
        let mut tau = splat(0.0);
        if let Some(slope) = friction {
            tau = splat(self.gamma) * slope;
            eta = eta + tau;
        }
        let [center_x, center_y] = self.pose.center;
        ToothMotion {
            alpha,
            eta,
            tau,
            normal: read_rounded(simd, &slopes.normal, part),
            arm: [x - splat(center_x), y - splat(center_y)],
            curvature: slopes.curvature.rounded(simd, part),
            turn: splat(self.gamma * self.gamma) * force,
            radius: splat(self.bushing_radius),
        }
    }
}

/// Terms of one run of bushings, for writing.
struct TermsOfRun<'a, T: Number> {
    /// Entry of the first bushing.
    first: usize,
    tooth_stiffness: [&'a mut [Pack<T>]; 3],
    spun: &'a mut [Numbers<T>; 3],
    /// Columns of the sprocket.
    columns: &'a mut [[Numbers<T>; 3]],
}

impl<T: Number> TermsOfRun<'_, T> {
    /// Add the stiffness of one vector, pack and part, to the bushings.
    #[inline(always)]
    fn hold<S: Vectors<Number = T>, const FRICTION: bool>(
        &mut self,
        place: (usize, usize),
        tooth: &ToothMotion<S>,
    ) {
        let stiff = tooth.stiff();
        for axis in 0..3 {
            add(self.tooth_stiffness[axis], place, stiff[axis]);
        }
        if FRICTION {
            let ([nx, ny], moment) = (tooth.normal, tooth.radius * tooth.tau);
            let entries = [-(moment * ny), moment * nx, moment * tooth.radius];
            for (array, entry) in self.spun.iter_mut().zip(entries) {
                add(array[self.first..].as_chunks_mut().0, place, entry);
            }
        }
    }

    /// Add one vector, pack and part, to the columns of the sprocket's coordinates and to their entries among themselves.
    #[inline(always)]
    fn couple<S: Vectors<Number = T>, const FRICTION: bool>(
        &mut self,
        place: (usize, usize),
        tooth: &ToothMotion<S>,
        motions: &[BorderMotion],
        corner: &mut [[PartialSums<T>; MOST]; MOST],
    ) {
        let ([nx, ny], tau) = (tooth.normal, tooth.tau);
        let moved = tooth.all_moved(motions);
        for (j, &motion) in motions.iter().enumerate().take(MOST) {
            let of = moved[j];
            // Column j: α n ∂δ/∂s_j + t (γ² f ∂φ/∂s_j + τ ∂x_t/∂s_j), with the penetration δ, the angle φ of the normal and
            // the sliding distance x_t.
            let (push, mut across) = (tooth.alpha * of.closes, tooth.turn * of.turns);
            if FRICTION {
                across = tau.mul_add(of.slides, across);
            }
            let pull = [
                nx.mul_add(push, -(ny * across)),
                ny.mul_add(push, nx * across),
            ];
            if FRICTION {
                let array = &mut self.columns[j][2][self.first..];
                add(
                    array.as_chunks_mut().0,
                    place,
                    tooth.radius * tau * of.slides,
                );
            }
            let [x, y, _] = &mut self.columns[j];
            add(x[self.first..].as_chunks_mut().0, place, pull[0]);
            add(y[self.first..].as_chunks_mut().0, place, pull[1]);
            for i in 0..=j.min(MOST - 1) {
                let by = moved[i];
                // Entry (i, j): α ∂δ/∂s_i ∂δ/∂s_j + γ² f ∂²δ/(∂s_i ∂s_j) + τ ∂x_t/∂s_i ∂x_t/∂s_j.
                let second = match motion {
                    BorderMotion::Along(_) => of.across * by.turns,
                    BorderMotion::Turn => by.across - by.turns * tooth.outward(),
                };
                let mut entry = by.closes.mul_add(push, tooth.turn * second);
                if FRICTION {
                    entry = (tau * by.slides).mul_add(of.slides, entry);
                }
                corner[i][j].add_part(place.1, entry);
            }
        }
    }
}

/// Add `entry` to one vector of an array, pack and part.
#[inline(always)]
fn add<S: Vectors>(array: &mut [Pack<S::Number>], (number, part): (usize, usize), entry: Lanes<S>) {
    let pack = &mut array[number];
    put_part(pack, part, part_of(entry.simd(), pack, part) + entry);
}

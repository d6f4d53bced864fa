//! Terms of the contacts between bushings and teeth: stiffness of the teeth at each bushing, and columns of the sprockets' own
//! coordinates. The matrix is symmetric: the columns are rows too.

use pulp::Simd;

use super::contacts::{BASE, scaled};
use super::tooth_motion::{BorderMotion, MOST, Tooth};
use crate::chain::contact::SprocketCandidates;
use crate::chain::rhs::pose::SprocketPose;
use crate::chain::rhs::slopes::{ContactSlopes, SlopeGroup};
use crate::math::simd::{
    Lanes, Numbers, PartialSums, WIDTH, both, load, padded, padded_zeros, read, vectors_mut,
};

/// Terms of the teeth, bushing by bushing: change of the force per change of the bushing's velocity, and per change of each
/// coordinate on the border. Bushing k is at [`BASE`] + k; a copy of the last one precedes the first. Everything is zero outside of
/// the marked groups of [`WIDTH`] bushings.
#[derive(Debug, Clone)]
pub(super) struct ToothTerms {
    /// xx, yy, xy
    pub(super) tooth_stiffness: [Numbers; 3],
    /// Moments about the bushings by friction: per change of their velocity, x and y, and of their angular velocity.
    pub(super) spun: [Numbers; 3],
    /// Force x and y of each coordinate, and its moment about the bushing.
    pub(super) column: Vec<[Numbers; 3]>,
    /// Marks of the groups that are not zero.
    touched: Vec<bool>,
}

impl ToothTerms {
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

    /// Return all arrays; those of moments only with friction.
    #[inline(always)]
    fn arrays<const FRICTION: bool>(&mut self) -> impl Iterator<Item = &mut Numbers> {
        let (of_column, spun) = if FRICTION { (3, 3) } else { (2, 0) };
        let columns = self.column.iter_mut();
        let pulls = columns.flat_map(move |arrays| &mut arrays[..of_column]);
        let stiffness = self.tooth_stiffness.iter_mut();
        stiffness.chain(pulls).chain(&mut self.spun[..spun])
    }

    /// Set the marked groups and the copies before the first bushing to zero.
    #[inline(always)]
    pub(super) fn clear<const FRICTION: bool>(&mut self) {
        for group in 0..self.touched.len() {
            if std::mem::take(&mut self.touched[group]) {
                for array in self.arrays::<FRICTION>() {
                    array.as_chunks_mut().0[BASE / WIDTH + group] = [0.0; WIDTH];
                }
            }
        }
        for array in self.arrays::<FRICTION>() {
            array[BASE - 1] = 0.0;
        }
    }

    /// Mark the group with bushing `k`.
    #[inline(always)]
    pub(super) fn touch(&mut self, k: usize) {
        self.touched[k / WIDTH] = true;
    }

    /// Copy the last one of `links` bushings to the entry before the first.
    #[inline(always)]
    pub(super) fn repeat_last<const FRICTION: bool>(&mut self, links: usize) {
        for array in self.arrays::<FRICTION>() {
            array[BASE - 1] = array[BASE + links - 1];
        }
    }

    /// Return whether the group with bushing `k` is marked.
    #[inline(always)]
    pub(super) fn touches(&self, k: usize) -> bool {
        self.touched[k / WIDTH]
    }

    /// Add the terms that runs past the last bushing have written behind it to the first bushings. Copy the last bushing to the
    /// entry before the first.
    #[inline(always)]
    pub(super) fn fold_overhang<const FRICTION: bool>(&mut self, links: usize, overhang: usize) {
        let behind = links / WIDTH..(links + overhang).div_ceil(WIDTH);
        let past = overhang > 0 && self.touched[behind].contains(&true);
        if past {
            self.touched[..overhang.div_ceil(WIDTH)].fill(true);
        }
        if !past && !self.touches(links - 1) {
            return;
        }
        for array in self.arrays::<FRICTION>() {
            if past {
                // Entries behind the overhang are zero.
                for first in (BASE..BASE + overhang).step_by(WIDTH) {
                    let behind = &mut array[first + links..first + links + WIDTH];
                    let mut past = [0.0; WIDTH];
                    past.copy_from_slice(behind);
                    behind.fill(0.0);
                    for (entry, past) in array[first..first + WIDTH].iter_mut().zip(past) {
                        *entry += past;
                    }
                }
            }
            array[BASE - 1] = array[BASE + links - 1];
        }
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
    /// Add all candidates to `terms`. Return the entries of the sprocket's coordinates among themselves, on and above the diagonal.
    #[inline(always)]
    pub(super) fn add<S: Simd>(&self, simd: S, terms: &mut ToothTerms) -> [[f64; MOST]; MOST] {
        let zero = Lanes::splat(simd, 0.0);
        let mut corner = [[PartialSums::default(); MOST]; MOST];
        for run in &self.candidates.runs {
            let blocks = run.length.div_ceil(S::F64_LANES);
            let [x, y] = both::<S>(self.bushing, run.first, blocks);
            let ToothTerms {
                tooth_stiffness: [xx, yy, xy],
                spun,
                column,
                touched,
            } = &mut *terms;
            let mut terms = TermsOfRun::<S> {
                first: run.first,
                blocks,
                tooth_stiffness: [
                    vectors_mut::<S>(&mut xx[BASE + run.first..], blocks),
                    vectors_mut::<S>(&mut yy[BASE + run.first..], blocks),
                    vectors_mut::<S>(&mut xy[BASE + run.first..], blocks),
                ],
                spun,
                columns: &mut column[self.first..],
            };
            let slopes = &self.slopes.normal[run.slot / WIDTH..];
            let friction = &self.slopes.friction[if FRICTION { run.slot / WIDTH } else { 0 }..];
            for (b, (x, y)) in x.iter().zip(y).enumerate() {
                let number = b * S::F64_LANES / WIDTH;
                let (slopes, part) = (&slopes[number], b % (WIDTH / S::F64_LANES));
                let force = slopes.force.at(simd, part);
                if !force.exceeds(zero).any() {
                    continue;
                }
                let center = [load(simd, x), load(simd, y)];
                let friction = FRICTION.then(|| friction[number].slope.at(simd, part));
                let tooth = self.tooth(center, force, (slopes, part), friction);
                let group = run.first + number * WIDTH;
                // A run may begin within a group: its vectors then reach into the next one.
                touched[group / WIDTH] = true;
                touched[group.div_ceil(WIDTH)] = true;
                terms.hold::<FRICTION>(b, &tooth);
                terms.couple::<FRICTION>(b, &tooth, self.motions, &mut corner);
            }
        }
        totals(&corner, self.motions.len())
    }

    /// Return one vector of bushings in contact, with these centres \[m\], normal forces \[N\] and, for `FRICTION`, slopes of friction.
    #[inline(always)]
    fn tooth<S: Simd>(
        &self,
        [x, y]: [Lanes<S>; 2],
        force: Lanes<S>,
        (slopes, part): (&SlopeGroup, usize),
        friction: Option<Lanes<S>>,
    ) -> Tooth<S> {
        let simd = force.simd();
        let splat = |value| Lanes::splat(simd, value);
        let [alpha, mut eta] = scaled(self.gamma, simd, slopes, part);
        let mut tau = splat(0.0);
        if let Some(slope) = friction {
            tau = splat(self.gamma) * slope;
            eta = eta + tau;
        }
        let [center_x, center_y] = self.pose.center;
        Tooth {
            alpha,
            eta,
            tau,
            normal: read(simd, &slopes.normal, part),
            arm: [x - splat(center_x), y - splat(center_y)],
            curvature: slopes.curvature.at(simd, part),
            turn: splat(self.gamma * self.gamma) * force,
            radius: splat(self.bushing_radius),
        }
    }
}

/// Terms of one run of bushings, for writing.
struct TermsOfRun<'a, S: Simd> {
    /// First bushing.
    first: usize,
    /// Number of vectors.
    blocks: usize,
    tooth_stiffness: [&'a mut [S::f64s]; 3],
    spun: &'a mut [Numbers; 3],
    /// Columns of the sprocket.
    columns: &'a mut [[Numbers; 3]],
}

impl<S: Simd> TermsOfRun<'_, S> {
    /// Add the stiffness of vector `b` to the bushings.
    #[inline(always)]
    fn hold<const FRICTION: bool>(&mut self, b: usize, tooth: &Tooth<S>) {
        let simd = tooth.turn.simd();
        for (array, entry) in self.tooth_stiffness.iter_mut().zip(tooth.stiff()) {
            array[b] = (load(simd, &array[b]) + entry).values();
        }
        if FRICTION {
            let ([nx, ny], moment) = (tooth.normal, tooth.radius * tooth.tau);
            let entries = [-(moment * ny), moment * nx, moment * tooth.radius];
            for (array, entry) in self.spun.iter_mut().zip(entries) {
                add(&mut array[BASE + self.first..], self.blocks, b, entry);
            }
        }
    }

    /// Add vector `b` to the columns of the sprocket's coordinates and to their entries among themselves.
    #[inline(always)]
    fn couple<const FRICTION: bool>(
        &mut self,
        b: usize,
        tooth: &Tooth<S>,
        motions: &[BorderMotion],
        corner: &mut [[PartialSums; MOST]; MOST],
    ) {
        let ([nx, ny], tau) = (tooth.normal, tooth.tau);
        let moved = tooth.all_moved(motions);
        for (j, &motion) in motions.iter().enumerate() {
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
                let array = &mut self.columns[j][2][BASE + self.first..];
                add(array, self.blocks, b, tooth.radius * tau * of.slides);
            }
            for (array, entry) in self.columns[j][..2].iter_mut().zip(pull) {
                add(&mut array[BASE + self.first..], self.blocks, b, entry);
            }
            for (i, by) in moved.iter().enumerate().take(j + 1) {
                // Entry (i, j): α ∂δ/∂s_i ∂δ/∂s_j + γ² f ∂²δ/(∂s_i ∂s_j) + τ ∂x_t/∂s_i ∂x_t/∂s_j.
                let second = match motion {
                    BorderMotion::Along(_) => of.across * by.turns,
                    BorderMotion::Turn => by.across - by.turns * tooth.outward(),
                };
                let mut entry = by.closes.mul_add(push, tooth.turn * second);
                if FRICTION {
                    entry = (tau * by.slides).mul_add(of.slides, entry);
                }
                corner[i][j].add(b, entry);
            }
        }
    }
}

/// Return the entries on and above the diagonal of the first `count` rows.
#[inline(always)]
fn totals(corner: &[[PartialSums; MOST]; MOST], count: usize) -> [[f64; MOST]; MOST] {
    let mut totals = [[0.0; MOST]; MOST];
    for (i, (row, sums)) in totals.iter_mut().zip(corner).enumerate().take(count) {
        for (total, sum) in row.iter_mut().zip(sums).take(count).skip(i) {
            *total = sum.total();
        }
    }
    totals
}

/// Add `entry` to vector `b` of the `blocks` of an array.
#[inline(always)]
fn add<S: Simd>(array: &mut [f64], blocks: usize, b: usize, entry: Lanes<S>) {
    let place = &mut vectors_mut::<S>(array, blocks)[b];
    *place = (load(entry.simd(), place) + entry).values();
}

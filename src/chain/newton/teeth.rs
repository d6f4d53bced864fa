//! Terms of the contacts between bushings and teeth: stiffness of the teeth at each bushing, and columns of the sprockets' own
//! coordinates. The matrix is symmetric: the columns are rows too.

use pulp::{Simd, WithSimd};

use super::contacts::{BASE, scaled};
use crate::chain::contact::{Run, SprocketCandidates};
use crate::chain::rhs::slopes::{FrictionGroup, SlopeGroup};
use crate::chain::rhs::teeth::SprocketPose;
use crate::math::simd::{
    Lanes, Numbers, PartialSums, WIDTH, both, load, padded, padded_zeros, read, vectors_mut,
};

/// Coordinate of a sprocket.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Motion {
    /// Displacement of its centre along this direction.
    Along([f64; 2]),
    /// Rotation.
    Turn,
}

/// Maximum number of coordinates of a sprocket: two of its centre and its angle.
pub(super) const MOST: usize = 3;

/// Terms of the teeth, bushing by bushing: change of the force per change of the bushing's velocity, and per change of each
/// coordinate on the border. Bushing k is at [`BASE`] + k; a copy of the last one precedes the first. Everything is zero outside of
/// the marked groups of [`WIDTH`] bushings.
#[derive(Debug, Clone)]
pub(super) struct ToothTerms {
    /// xx, yy, xy
    pub(super) held: [Numbers; 3],
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
            held: [(); 3].map(|()| zeros()),
            spun: [(); 3].map(|()| zeros()),
            column: (0..border).map(|_| [(); 3].map(|()| zeros())).collect(),
            touched: vec![false; room / WIDTH],
        }
    }

    /// Set the marked groups and the copies before the first bushing to zero.
    #[inline(always)]
    pub(super) fn clear<const RUBBED: bool>(&mut self) {
        for group in 0..self.touched.len() {
            if !std::mem::take(&mut self.touched[group]) {
                continue;
            }
            for array in &mut self.held {
                clear_group(array, group);
            }
            for arrays in &mut self.column {
                clear_group(&mut arrays[0], group);
                clear_group(&mut arrays[1], group);
                if RUBBED {
                    clear_group(&mut arrays[2], group);
                }
            }
            if RUBBED {
                for array in &mut self.spun {
                    clear_group(array, group);
                }
            }
        }
        for array in &mut self.held {
            array[BASE - 1] = 0.0;
        }
        for array in self.column.iter_mut().flatten() {
            array[BASE - 1] = 0.0;
        }
        if RUBBED {
            for array in &mut self.spun {
                array[BASE - 1] = 0.0;
            }
        }
    }

    /// Mark the group with bushing `k`.
    #[inline(always)]
    pub(super) fn touch(&mut self, k: usize) {
        self.touched[k / WIDTH] = true;
    }

    /// Copy the last one of `links` bushings to the entry before the first.
    #[inline(always)]
    pub(super) fn close<const RUBBED: bool>(&mut self, links: usize) {
        let spun = if RUBBED { &mut self.spun[..] } else { &mut [] };
        let pulls = pulls::<RUBBED>(&mut self.column);
        for array in self.held.iter_mut().chain(pulls).chain(spun) {
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
    pub(super) fn take_back<const RUBBED: bool>(&mut self, links: usize, overhang: usize) {
        let behind = links / WIDTH..(links + overhang).div_ceil(WIDTH);
        let past = overhang > 0 && self.touched[behind].contains(&true);
        if past {
            self.touched[..overhang.div_ceil(WIDTH)].fill(true);
        }
        if !past && !self.touches(links - 1) {
            return;
        }
        let spun = if RUBBED { &mut self.spun[..] } else { &mut [] };
        let pulls = pulls::<RUBBED>(&mut self.column);
        for array in self.held.iter_mut().chain(pulls).chain(spun) {
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

/// Set this group of bushings to zero.
#[inline(always)]
fn clear_group(array: &mut Numbers, group: usize) {
    array.as_chunks_mut().0[BASE / WIDTH + group] = [0.0; WIDTH];
}

/// Return the arrays of the columns; those of moments only with friction.
#[inline(always)]
fn pulls<const RUBBED: bool>(column: &mut [[Numbers; 3]]) -> impl Iterator<Item = &mut Numbers> {
    let count = if RUBBED { 3 } else { 2 };
    column
        .iter_mut()
        .flat_map(move |arrays| &mut arrays[..count])
}

/// Friction slopes of the candidates of one sprocket; empty without friction.
pub(super) struct RubbingTeeth<'a> {
    pub(super) slopes: &'a [FrictionGroup],
    pub(super) bushing_radius: f64,
}

/// Kernel that adds the candidates of one sprocket. `RUBBED`: with friction.
pub(super) struct AddTeeth<'a, const RUBBED: bool> {
    pub(super) gamma: f64,
    pub(super) pose: &'a SprocketPose,
    pub(super) candidates: &'a SprocketCandidates,
    pub(super) slopes: &'a [SlopeGroup],
    /// Centres of the bushings \[m\].
    pub(super) bushing: &'a [Numbers; 2],
    /// Coordinates of the sprocket; the first is number `first` on the border.
    pub(super) motions: &'a [Motion],
    pub(super) first: usize,
    pub(super) terms: &'a mut ToothTerms,
    pub(super) rubbing: RubbingTeeth<'a>,
}

impl<const RUBBED: bool> WithSimd for AddTeeth<'_, RUBBED> {
    /// Entries of the sprocket's coordinates among themselves, on and above the diagonal.
    type Output = [[f64; MOST]; MOST];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let splat = |value| Lanes::splat(simd, value);
        let (zero, gamma_squared) = (splat(0.0), splat(self.gamma * self.gamma));
        let mut corner = [[PartialSums::default(); MOST]; MOST];
        for &Run {
            first,
            length,
            slot,
        } in &self.candidates.runs
        {
            let blocks = length.div_ceil(S::F64_LANES);
            let bushing = both::<S>(self.bushing, first, blocks);
            let ToothTerms {
                held: [xx, yy, xy],
                spun,
                column,
                touched,
            } = &mut *self.terms;
            let columns = &mut column[self.first..];
            let mut held = [
                vectors_mut::<S>(&mut xx[BASE + first..], blocks),
                vectors_mut::<S>(&mut yy[BASE + first..], blocks),
                vectors_mut::<S>(&mut xy[BASE + first..], blocks),
            ];
            let slopes = &self.slopes[slot / WIDTH..];
            let rubs = &self.rubbing.slopes[if RUBBED { slot / WIDTH } else { 0 }..];
            for b in 0..blocks {
                let (slopes, part) = (
                    &slopes[b * S::F64_LANES / WIDTH],
                    b % (WIDTH / S::F64_LANES),
                );
                let force = slopes.force.at(simd, part);
                if !force.exceeds(zero).any() {
                    continue;
                }
                let [alpha, mut eta] = scaled(self.gamma, simd, slopes, part);
                let arm = [
                    load(simd, &bushing[0][b]) - splat(self.pose.center[0]),
                    load(simd, &bushing[1][b]) - splat(self.pose.center[1]),
                ];
                let tooth = Tooth {
                    normal: read(simd, &slopes.normal, part),
                    arm,
                    curvature: slopes.curvature.at(simd, part),
                    turn: gamma_squared * force,
                    radius: splat(self.rubbing.bushing_radius),
                };
                let mut tau = zero;
                if RUBBED {
                    let slope = &rubs[b * S::F64_LANES / WIDTH].slope;
                    tau = splat(self.gamma) * slope.at(simd, part);
                    eta = eta + tau;
                }
                let group = first + b * S::F64_LANES / WIDTH * WIDTH;
                // A run may begin within a group: its vectors then reach into the next one.
                touched[group / WIDTH] = true;
                touched[group.div_ceil(WIDTH)] = true;
                let [nx, ny] = tooth.normal;
                for (array, entry) in held.iter_mut().zip(tooth.stiff(alpha, eta)) {
                    array[b] = (load(simd, &array[b]) + entry).values();
                }
                let moment = tooth.radius * tau;
                if RUBBED {
                    let entries = [-(moment * ny), moment * nx, moment * tooth.radius];
                    for (array, entry) in spun.iter_mut().zip(entries) {
                        add(&mut array[BASE + first..], blocks, b, entry);
                    }
                }
                let moved = tooth.all_moved(self.motions);
                for (j, &motion) in self.motions.iter().enumerate() {
                    let of = moved[j];
                    // Column j: α n ∂δ/∂s_j + t (γ² f ∂φ/∂s_j + τ ∂x_t/∂s_j), with the penetration δ, the angle φ of the normal and
                    // the sliding distance x_t.
                    let (push, mut across) = (alpha * of.closes, tooth.turn * of.turns);
                    if RUBBED {
                        across = tau.mul_add(of.rubs, across);
                    }
                    let pull = [
                        nx.mul_add(push, -(ny * across)),
                        ny.mul_add(push, nx * across),
                    ];
                    if RUBBED {
                        let array = &mut columns[j][2][BASE + first..];
                        add(array, blocks, b, moment * of.rubs);
                    }
                    for (array, entry) in columns[j][..2].iter_mut().zip(pull) {
                        add(&mut array[BASE + first..], blocks, b, entry);
                    }
                    for (i, by) in moved.iter().enumerate().take(j + 1) {
                        // Entry (i, j): α ∂δ/∂s_i ∂δ/∂s_j + γ² f ∂²δ/(∂s_i ∂s_j) + τ ∂x_t/∂s_i ∂x_t/∂s_j.
                        let bend = match motion {
                            Motion::Along(_) => of.across * by.turns,
                            Motion::Turn => by.across - by.turns * tooth.outward(),
                        };
                        let mut entry = by.closes.mul_add(push, tooth.turn * bend);
                        if RUBBED {
                            entry = (tau * by.rubs).mul_add(of.rubs, entry);
                        }
                        corner[i][j].add(b, entry);
                    }
                }
            }
        }
        totals(&corner, self.motions.len())
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

/// Geometry of one SIMD vector of bushings on teeth.
struct Tooth<S: Simd> {
    normal: [Lanes<S>; 2],
    /// Position of the bushing's centre relative to the sprocket's \[m\].
    arm: [Lanes<S>; 2],
    curvature: Lanes<S>,
    /// γ² f
    turn: Lanes<S>,
    /// Radius of the bushings \[m\].
    radius: Lanes<S>,
}

/// Derivatives of the contact geometry with respect to a coordinate of the sprocket.
#[derive(Clone, Copy)]
struct Moved<S: Simd> {
    /// Penetration.
    closes: Lanes<S>,
    /// Position of the bushing relative to the sprocket, along t.
    across: Lanes<S>,
    /// Angle of the normal.
    turns: Lanes<S>,
    /// Position of the bushing's contact point relative to the sprocket's, along t.
    rubs: Lanes<S>,
}

impl<S: Simd> Tooth<S> {
    /// Return the stiffness at the bushing, α n n^T + η t t^T: xx, yy, xy.
    #[inline(always)]
    fn stiff(&self, alpha: Lanes<S>, eta: Lanes<S>) -> [Lanes<S>; 3] {
        let [nx, ny] = self.normal;
        [
            alpha.mul_add(nx * nx, eta * (ny * ny)),
            alpha.mul_add(ny * ny, eta * (nx * nx)),
            (alpha - eta) * (nx * ny),
        ]
    }

    /// Return the derivatives for each of these coordinates.
    #[inline(always)]
    fn all_moved(&self, motions: &[Motion]) -> [Moved<S>; MOST] {
        let mut moved = [self.still(); MOST];
        for (moved, &motion) in moved.iter_mut().zip(motions) {
            *moved = self.moved(motion);
        }
        moved
    }

    /// Return n·arm.
    #[inline(always)]
    fn outward(&self) -> Lanes<S> {
        self.arm[0].mul_add(self.normal[0], self.arm[1] * self.normal[1])
    }

    /// Return zero derivatives.
    #[inline(always)]
    fn still(&self) -> Moved<S> {
        let zero = self.turn.constant(0.0);
        Moved {
            closes: zero,
            across: zero,
            turns: zero,
            rubs: zero,
        }
    }

    /// Return the derivatives for one coordinate.
    #[inline(always)]
    fn moved(&self, motion: Motion) -> Moved<S> {
        let [nx, ny] = self.normal;
        match motion {
            Motion::Along(direction) => {
                let [x, y] = [nx.constant(direction[0]), nx.constant(direction[1])];
                let across = ny.mul_add(x, -(nx * y));
                Moved {
                    closes: -(nx.mul_add(x, ny * y)),
                    across,
                    turns: self.curvature * across,
                    rubs: across,
                }
            }
            Motion::Turn => {
                let [x, y] = self.arm;
                let one = nx.constant(1.0);
                Moved {
                    closes: y.mul_add(nx, -(x * ny)),
                    across: nx.constant(0.0),
                    turns: self.curvature.negate_mul_add(self.outward(), one),
                    rubs: -(self.outward() + self.radius),
                }
            }
        }
    }
}

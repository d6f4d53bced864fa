//! What bushings on teeth add to the matrix: how stiffly each of them is held, and columns of the sprockets' own coordinates,
//! which are their rows too.

use pulp::{Simd, WithSimd};

use super::contacts::{BASE, scaled};
use crate::contact::{Run, SprocketCandidates};
use crate::kernels::slopes::SlopeGroup;
use crate::kernels::teeth::SprocketPose;
use crate::vector::{
    Lanes, Numbers, PartialSums, WIDTH, both, load, padded, padded_zeros, read, vectors_mut,
};

/// A coordinate of a sprocket.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Motion {
    /// Its centre moves along this direction.
    Along([f64; 2]),
    /// It turns.
    Turn,
}

/// Coordinates that a sprocket may have at most: two of its centre and its angle.
pub(super) const MOST: usize = 3;

/// What teeth add, bushing by bushing: the change of force for a change of the bushing's velocity, and that for one of each
/// coordinate on the border. Bushing k is at [`BASE`] + k, and the last one once more before the first. All but the groups of
/// [`WIDTH`] bushings that are marked is zero.
#[derive(Debug, Clone)]
pub(super) struct ToothTerms {
    /// xx, yy, xy
    pub(super) held: [Numbers; 3],
    /// x and y of each coordinate.
    pub(super) column: Vec<[Numbers; 2]>,
    /// Groups that are not zero.
    touched: Vec<bool>,
}

impl ToothTerms {
    pub(super) fn new(links: usize, border: usize) -> Self {
        let room = padded(BASE + 2 * links + 3 * WIDTH);
        let zeros = || padded_zeros(room);
        Self {
            held: [(); 3].map(|()| zeros()),
            column: (0..border).map(|_| [(); 2].map(|()| zeros())).collect(),
            touched: vec![false; room / WIDTH],
        }
    }

    /// No teeth yet.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        let Self {
            held,
            column,
            touched,
        } = self;
        for (group, touched) in touched.iter_mut().enumerate() {
            if !std::mem::take(touched) {
                continue;
            }
            let entries = BASE + group * WIDTH..BASE + (group + 1) * WIDTH;
            for array in held.iter_mut().chain(column.iter_mut().flatten()) {
                array[entries.clone()].fill(0.0);
            }
        }
        for array in held.iter_mut().chain(column.iter_mut().flatten()) {
            array[BASE - 1] = 0.0;
        }
    }

    /// Whether any bushing of the group with bushing `k` touches.
    #[inline(always)]
    pub(super) fn touches(&self, k: usize) -> bool {
        self.touched[k / WIDTH]
    }

    /// Adds to the first bushings what runs that go past the last one have left behind it, and puts the last one before them.
    #[inline(always)]
    pub(super) fn take_back(&mut self, links: usize, overhang: usize) {
        let behind = links / WIDTH..(links + overhang).div_ceil(WIDTH);
        let past = overhang > 0 && self.touched[behind].contains(&true);
        if past {
            self.touched[..overhang.div_ceil(WIDTH)].fill(true);
        }
        if !past && !self.touches(links - 1) {
            return;
        }
        for array in self.held.iter_mut().chain(self.column.iter_mut().flatten()) {
            if past {
                let (first, behind) = array[BASE..].split_at_mut(links);
                for (entry, past) in first.iter_mut().zip(&mut behind[..overhang]) {
                    *entry += *past;
                    *past = 0.0;
                }
            }
            array[BASE - 1] = array[BASE + links - 1];
        }
    }
}

/// Adds the candidates of one sprocket.
pub(super) struct AddTeeth<'a> {
    pub(super) gamma: f64,
    pub(super) pose: &'a SprocketPose,
    pub(super) candidates: &'a SprocketCandidates,
    pub(super) slopes: &'a [SlopeGroup],
    /// Centres of the bushings \[m\].
    pub(super) bushing: &'a [Numbers; 2],
    /// The sprocket's coordinates, the first of which is number `first` on the border.
    pub(super) motions: &'a [Motion],
    pub(super) first: usize,
    pub(super) terms: &'a mut ToothTerms,
}

impl WithSimd for AddTeeth<'_> {
    /// Entries of the sprocket's coordinates among themselves, those on and above the diagonal.
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
            for b in 0..blocks {
                let (slopes, part) = (
                    &slopes[b * S::F64_LANES / WIDTH],
                    b % (WIDTH / S::F64_LANES),
                );
                let force = slopes.force.at(simd, part);
                if !force.exceeds(zero).any() {
                    continue;
                }
                let [alpha, eta] = scaled(self.gamma, simd, slopes, part);
                let tooth = Tooth {
                    normal: read(simd, &slopes.normal, part),
                    arm: [
                        load(simd, &bushing[0][b]) - splat(self.pose.center[0]),
                        load(simd, &bushing[1][b]) - splat(self.pose.center[1]),
                    ],
                    curvature: slopes.curvature.at(simd, part),
                    turn: gamma_squared * force,
                };
                let group = first + b * S::F64_LANES / WIDTH * WIDTH;
                touched[group / WIDTH] = true;
                touched[group.div_ceil(WIDTH)] = true;
                let [nx, ny] = tooth.normal;
                let stiff = [
                    alpha.mul_add(nx * nx, eta * (ny * ny)),
                    alpha.mul_add(ny * ny, eta * (nx * nx)),
                    (alpha - eta) * (nx * ny),
                ];
                for (array, entry) in held.iter_mut().zip(stiff) {
                    array[b] = (load(simd, &array[b]) + entry).values();
                }
                let mut moved = [tooth.still(); MOST];
                for (moved, &motion) in moved.iter_mut().zip(self.motions) {
                    *moved = tooth.moved(motion);
                }
                for (j, &motion) in self.motions.iter().enumerate() {
                    let of = moved[j];
                    let (push, across) = (alpha * of.closes, tooth.turn * of.turns);
                    let pull = [
                        nx.mul_add(push, -(ny * across)),
                        ny.mul_add(push, nx * across),
                    ];
                    for (array, entry) in columns[j].iter_mut().zip(pull) {
                        let place = &mut vectors_mut::<S>(&mut array[BASE + first..], blocks)[b];
                        *place = (load(simd, place) + entry).values();
                    }
                    for (i, by) in moved.iter().enumerate().take(j + 1) {
                        let bend = match motion {
                            Motion::Along(_) => of.across * by.turns,
                            Motion::Turn => by.across - by.turns * tooth.outward(),
                        };
                        let entry = by.closes.mul_add(push, tooth.turn * bend);
                        corner[i][j].add(b, entry);
                    }
                }
            }
        }
        let mut totals = [[0.0; MOST]; MOST];
        for (row, sums) in totals.iter_mut().zip(&corner) {
            for (total, sum) in row.iter_mut().zip(sums) {
                *total = sum.total();
            }
        }
        totals
    }
}

/// A register of bushings on teeth.
struct Tooth<S: Simd> {
    normal: [Lanes<S>; 2],
    /// Bushing seen from the sprocket's centre \[m\].
    arm: [Lanes<S>; 2],
    curvature: Lanes<S>,
    /// γ² f
    turn: Lanes<S>,
}

/// What a coordinate of the sprocket does to a contact.
#[derive(Clone, Copy)]
struct Moved<S: Simd> {
    /// Penetration.
    closes: Lanes<S>,
    /// Bushing seen from the sprocket, along t.
    across: Lanes<S>,
    /// Angle of the normal.
    turns: Lanes<S>,
}

impl<S: Simd> Tooth<S> {
    /// n·arm
    #[inline(always)]
    fn outward(&self) -> Lanes<S> {
        self.arm[0].mul_add(self.normal[0], self.arm[1] * self.normal[1])
    }

    #[inline(always)]
    fn still(&self) -> Moved<S> {
        let zero = self.turn.constant(0.0);
        Moved {
            closes: zero,
            across: zero,
            turns: zero,
        }
    }

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
                }
            }
            Motion::Turn => {
                let [x, y] = self.arm;
                let one = nx.constant(1.0);
                Moved {
                    closes: y.mul_add(nx, -(x * ny)),
                    across: nx.constant(0.0),
                    turns: self.curvature.negate_mul_add(self.outward(), one),
                }
            }
        }
    }
}

//! What bushings on teeth add to the matrix: blocks of their links, and columns of the sprockets' own coordinates, which are
//! their rows too.

use pulp::{Simd, WithSimd};

use super::contacts::scaled;
use super::links::at;
use crate::contact::{Run, SprocketCandidates};
use crate::kernels::slopes::ContactSlopes;
use crate::kernels::teeth::SprocketPose;
use crate::vector::{
    Lanes, Numbers, PartialSums, WIDTH, both, load, padded, padded_zeros, vectors_mut,
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

/// Entries of a symmetric 3x3 block that are kept: xx, xy, xθ, yy, yθ, θθ.
pub(super) const ENTRIES: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

/// From the centre of its link to every bushing \[m\]; runs that go past the last bushing find the first ones behind it.
pub(super) type Levers = [Numbers; 2];

/// What teeth add, bushing by bushing: to the 3x3 block of its link, and to the three entries of its link in the column of
/// each coordinate on the border. All but the groups of [`WIDTH`] bushings that are marked is zero.
#[derive(Debug, Clone)]
pub(super) struct ToothTerms {
    pub(super) block: [Numbers; 6],
    pub(super) column: Vec<[Numbers; 3]>,
    /// Groups that are not zero.
    touched: Vec<bool>,
}

impl ToothTerms {
    pub(super) fn new(links: usize, border: usize) -> Self {
        let room = padded(2 * links + 3 * WIDTH);
        let zeros = || padded_zeros(room);
        Self {
            block: [(); 6].map(|()| zeros()),
            column: (0..border).map(|_| [(); 3].map(|()| zeros())).collect(),
            touched: vec![false; room / WIDTH],
        }
    }

    /// No teeth yet.
    pub(super) fn clear(&mut self) {
        let touched = |&(_, touched): &(usize, &bool)| *touched;
        let Some((first, _)) = self.touched.iter().enumerate().find(touched) else {
            return;
        };
        let last = self.touched.iter().enumerate().rfind(touched);
        let entries = first * WIDTH..(last.map_or(first, |(group, _)| group) + 1) * WIDTH;
        self.touched.fill(false);
        for array in &mut self.block {
            array[entries.clone()].fill(0.0);
        }
        for array in self.column.iter_mut().flatten() {
            array[entries.clone()].fill(0.0);
        }
    }

    /// Whether any bushing of these entries touches.
    #[inline(always)]
    pub(super) fn touches(&self, first: usize, count: usize) -> bool {
        let groups = first / WIDTH..=(first + count - 1) / WIDTH;
        self.touched[groups].contains(&true)
    }

    #[inline(always)]
    fn touch(&mut self, first: usize, count: usize) {
        let groups = first / WIDTH..=(first + count - 1) / WIDTH;
        self.touched[groups].fill(true);
    }

    /// Adds to the first bushings what runs that go past the last one have left behind it.
    pub(super) fn take_back(&mut self, links: usize, overhang: usize) {
        if overhang == 0 || !self.touches(links, overhang) {
            return;
        }
        self.touch(0, overhang);
        for array in self
            .block
            .iter_mut()
            .chain(self.column.iter_mut().flatten())
        {
            let (first, behind) = array.split_at_mut(links);
            for (entry, past) in first.iter_mut().zip(&mut behind[..overhang]) {
                *entry += *past;
                *past = 0.0;
            }
        }
    }
}

/// Adds the candidates of one sprocket.
pub(super) struct AddTeeth<'a> {
    pub(super) gamma: f64,
    pub(super) pose: &'a SprocketPose,
    pub(super) candidates: &'a SprocketCandidates,
    pub(super) slopes: &'a ContactSlopes,
    /// Centres of the bushings \[m\].
    pub(super) bushing: &'a [Numbers; 2],
    pub(super) levers: &'a Levers,
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
            let normal = both::<S>(&self.slopes.normal, slot, blocks);
            let along = both::<S>(self.levers, first, blocks);
            let bushing = both::<S>(self.bushing, first, blocks);
            for b in 0..blocks {
                let force = at(simd, &self.candidates.force[slot..], b);
                if !force.exceeds(zero).any() {
                    continue;
                }
                let slopes = [
                    at(simd, &self.slopes.stiffness[slot..], b),
                    at(simd, &self.slopes.damping[slot..], b),
                    at(simd, &self.slopes.curvature[slot..], b),
                ];
                let place = both_at(simd, bushing, b);
                let [alpha, eta] = scaled(self.gamma, slopes, force);
                let tooth = Tooth {
                    normal: both_at(simd, normal, b),
                    arm: [
                        place[0] - splat(self.pose.center[0]),
                        place[1] - splat(self.pose.center[1]),
                    ],
                    curvature: slopes[2],
                    turn: gamma_squared * force,
                };
                self.terms
                    .touch(first + b * S::F64_LANES / WIDTH * WIDTH, WIDTH);
                let [along_n, along_t] = tooth.levers(both_at(simd, along, b));
                for (array, (i, j)) in self.terms.block.iter_mut().zip(ENTRIES) {
                    let across = eta * along_t[i] * along_t[j];
                    let entry = (alpha * along_n[i]).mul_add(along_n[j], across);
                    add::<S>(array, first, b, entry);
                }
                let mut moved = [tooth.still(); MOST];
                for (moved, &motion) in moved.iter_mut().zip(self.motions) {
                    *moved = tooth.moved(motion);
                }
                for (j, &motion) in self.motions.iter().enumerate() {
                    let of = moved[j];
                    let (push, across) = (alpha * of.closes, tooth.turn * of.turns);
                    let column = &mut self.terms.column[self.first + j];
                    for (i, array) in column.iter_mut().enumerate() {
                        let entry = along_n[i].mul_add(push, along_t[i] * across);
                        add::<S>(array, first, b, entry);
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
        corner.map(|row| row.map(|sum| sum.total()))
    }
}

#[inline(always)]
fn both_at<S: Simd>(simd: S, of: [&[S::f64s]; 2], b: usize) -> [Lanes<S>; 2] {
    [load(simd, &of[0][b]), load(simd, &of[1][b])]
}

#[inline(always)]
fn add<S: Simd>(array: &mut [f64], first: usize, b: usize, values: Lanes<S>) {
    let place = &mut vectors_mut::<S>(&mut array[first..], b + 1)[b];
    *place = (load(values.simd(), place) + values).values();
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
    /// How far the coordinates of a bushing's link move it along n and along t.
    #[inline(always)]
    fn levers(&self, [x, y]: [Lanes<S>; 2]) -> [[Lanes<S>; 3]; 2] {
        let [nx, ny] = self.normal;
        [
            [nx, ny, x.mul_add(ny, -(y * nx))],
            [-ny, nx, x.mul_add(nx, y * ny)],
        ]
    }

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

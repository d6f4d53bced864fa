//! What bushings on teeth add to the matrix: blocks of their links, and rows and columns of the sprockets' own coordinates.

use pulp::{Simd, WithSimd};

use super::contacts::scaled;
use crate::contact::{Run, SprocketCandidates};
use crate::kernels::slopes::ContactSlopes;
use crate::kernels::teeth::SprocketPose;
use crate::vector::{Lanes, Numbers, PartialSums, WIDTH, both, load, padded_zeros, vectors, vectors_mut};

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

/// What is known of the link that a bushing belongs to; runs that go past the last bushing find the first ones behind it.
#[derive(Debug, Clone)]
pub(super) struct BushingLevers {
    /// From the link's centre to the bushing \[m\].
    pub(super) along: [Numbers; 2],
    /// Angular speed of the link \[rad/s\].
    pub(super) spin: Numbers,
}

/// What teeth add, bushing by bushing: to the 3x3 block of its link, and to the three entries of its link in column and row
/// of each coordinate on the border.
#[derive(Debug, Clone)]
pub(super) struct ToothTerms {
    pub(super) block: [Numbers; 9],
    pub(super) column: Vec<[Numbers; 3]>,
    pub(super) row: Vec<[Numbers; 3]>,
}

impl BushingLevers {
    pub(super) fn new(links: usize) -> Self {
        let zeros = || padded_zeros(2 * links + 3 * WIDTH);
        Self {
            along: [zeros(), zeros()],
            spin: zeros(),
        }
    }
}

impl ToothTerms {
    pub(super) fn new(links: usize, border: usize) -> Self {
        let zeros = || padded_zeros(2 * links + 3 * WIDTH);
        let three = || (0..border).map(|_| [(); 3].map(|()| zeros())).collect();
        Self {
            block: [(); 9].map(|()| zeros()),
            column: three(),
            row: three(),
        }
    }

    fn all(&mut self) -> impl Iterator<Item = &mut Numbers> {
        let border = self.column.iter_mut().chain(&mut self.row).flatten();
        self.block.iter_mut().chain(border)
    }

    /// No teeth yet.
    pub(super) fn clear(&mut self, links: usize, overhang: usize) {
        for array in self.all() {
            array[..links + overhang + WIDTH].fill(0.0);
        }
    }

    /// Adds to the first bushings what runs that go past the last one have left behind it.
    pub(super) fn take_back(&mut self, links: usize, overhang: usize) {
        for array in self.all() {
            for k in 0..overhang {
                array[k] += array[links + k];
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
    pub(super) levers: &'a BushingLevers,
    /// The sprocket's coordinates, the first of which is number `first` on the border.
    pub(super) motions: &'a [Motion],
    pub(super) first: usize,
    pub(super) terms: &'a mut ToothTerms,
}

impl WithSimd for AddTeeth<'_> {
    /// Entries of the sprocket's coordinates among themselves.
    type Output = [[f64; MOST]; MOST];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let splat = |value| Lanes::splat(simd, value);
        let spin = splat(self.pose.spin);
        let mut corner = [[PartialSums::default(); MOST]; MOST];
        for &Run {
            first,
            length,
            slot,
        } in &self.candidates.runs
        {
            let blocks = length.div_ceil(S::F64_LANES);
            let at = |array: &[f64], b: usize| load(simd, &vectors::<S>(array, blocks)[b]);
            let normal = both::<S>(&self.slopes.normal, slot, blocks);
            let along = both::<S>(&self.levers.along, first, blocks);
            let bushing = both::<S>(self.bushing, first, blocks);
            for b in 0..blocks {
                let slopes = [
                    at(&self.slopes.stiffness[slot..], b),
                    at(&self.slopes.damping[slot..], b),
                    at(&self.slopes.curvature[slot..], b),
                    at(&self.slopes.slip[slot..], b),
                ];
                let force = at(&self.candidates.force[slot..], b);
                if !force.exceeds(splat(0.0)).any() {
                    continue;
                }
                let pair = |of: [&[S::f64s]; 2]| of.map(|array| load(simd, &array[b]));
                let place = pair(bushing);
                let tooth = Tooth {
                    normal: pair(normal),
                    arm: [
                        place[0] - splat(self.pose.center[0]),
                        place[1] - splat(self.pose.center[1]),
                    ],
                    curvature: slopes[2],
                    slip: slopes[3],
                    spin,
                    contact: scaled(self.gamma, slopes, force, spin),
                    turn: splat(self.gamma * self.gamma) * force,
                };
                let levers = tooth.levers(pair(along));
                let changes = tooth.changes(&levers, at(&self.levers.spin[first..], b));
                let Levers { normal, tangent } = levers;
                let eta = tooth.contact.eta;
                for i in 0..3 {
                    for j in 0..3 {
                        let entry = normal[i].mul_add(changes[j], eta * tangent[i] * tangent[j]);
                        add::<S>(&mut self.terms.block[3 * i + j], first, b, entry);
                    }
                }
                let mut moved = [tooth.still(); MOST];
                for (moved, &motion) in moved.iter_mut().zip(self.motions) {
                    *moved = tooth.moved(motion);
                }
                for j in 0..self.motions.len() {
                    let of = &moved[j];
                    let across = tooth.turn * of.turns;
                    let (column, row) = (
                        &mut self.terms.column[self.first + j],
                        &mut self.terms.row[self.first + j],
                    );
                    for i in 0..3 {
                        let pushed = normal[i].mul_add(of.force, tangent[i] * across);
                        add::<S>(&mut column[i], first, b, pushed);
                        let pushing = of.closes.mul_add(changes[i], across * tangent[i]);
                        add::<S>(&mut row[i], first, b, pushing);
                    }
                    for (i, by) in moved.iter().enumerate().take(self.motions.len()) {
                        let bend = match self.motions[i] {
                            Motion::Along(_) => by.across * of.turns,
                            Motion::Turn => of.across - of.turns * tooth.outward(),
                        };
                        let entry = by.closes.mul_add(of.force, tooth.turn * bend);
                        corner[i][j].add(b, entry);
                    }
                }
            }
        }
        corner.map(|row| row.map(|sum| sum.total()))
    }
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
    slip: Lanes<S>,
    /// Of the sprocket.
    spin: Lanes<S>,
    contact: super::contacts::Scaled<S>,
    /// γ² f
    turn: Lanes<S>,
}

/// How far the coordinates of a bushing's link move it along n and t.
struct Levers<S: Simd> {
    normal: [Lanes<S>; 3],
    tangent: [Lanes<S>; 3],
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
    /// Force, times γ².
    force: Lanes<S>,
}

impl<S: Simd> Tooth<S> {
    #[inline(always)]
    fn levers(&self, [x, y]: [Lanes<S>; 2]) -> Levers<S> {
        let [nx, ny] = self.normal;
        Levers {
            normal: [nx, ny, x.mul_add(ny, -(y * nx))],
            tangent: [-ny, nx, x.mul_add(nx, y * ny)],
        }
    }

    /// Change of the force with the link's coordinates.
    #[inline(always)]
    fn changes(&self, levers: &Levers<S>, spin: Lanes<S>) -> [Lanes<S>; 3] {
        let contact = &self.contact;
        let of = |i: usize| {
            contact
                .alpha
                .mul_add(levers.normal[i], contact.beta * levers.tangent[i])
        };
        // A link that turns takes the velocity of its end along.
        let turned = (contact.damping * spin).negate_mul_add(levers.tangent[2], of(2));
        [of(0), of(1), turned]
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
            force: zero,
        }
    }

    #[inline(always)]
    fn moved(&self, motion: Motion) -> Moved<S> {
        let [nx, ny] = self.normal;
        let (closes, across, turns) = match motion {
            Motion::Along(direction) => {
                let [x, y] = direction.map(|part| nx.constant(part));
                let across = ny.mul_add(x, -(nx * y));
                (-(nx.mul_add(x, ny * y)), across, self.curvature * across)
            }
            Motion::Turn => {
                let [x, y] = self.arm;
                let one = nx.constant(1.0);
                let turns = self.curvature.negate_mul_add(self.outward(), one);
                (y.mul_add(nx, -(x * ny)), nx.constant(0.0), turns)
            }
        };
        let rate = self.spin.mul_add(across, self.slip * turns);
        Moved {
            closes,
            across,
            turns,
            force: self
                .contact
                .alpha
                .mul_add(closes, self.contact.damping * rate),
        }
    }
}

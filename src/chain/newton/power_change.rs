//! Change of the forces and powers of the contacts, and of the loads on the sprockets, with the last correction.
//!
//! A step of Newton's method has its last evaluation before its last correction. This correction Δv changes the penetration rate of a
//! contact by n·Δv, with the relative velocity of its two points, and its penetration by γ n·Δv. Slopes of force and power are those of
//! the evaluation: forces are of first order, powers of second order in Δv. The turn of the normals is left out, as in the matrix.

use pulp::{Simd, WithSimd};

use super::tooth_motion::BorderMotion;
use super::{Factors, NewtonMatrix, SprocketMotions};
use crate::chain::arrays::layout::{ChainArrays, LinkConstants};
use crate::chain::arrays::pose::SprocketPose;
use crate::chain::arrays::slopes::SlopeGroup;
use crate::chain::contact::SprocketCandidates;
use crate::chain::loads::SprocketLoad;
use crate::geometry::Vec2;
use crate::math::simd::{
    Entries, InstructionSet, Lanes, Number, Numbers, Pack, PartialSums, WIDTH, packs, packs_mut,
    padded, padded_zeros, part_of, parts, put_part, read, splat_two,
};

/// Corrections of the velocities of the links' ends and of the bodies on the teeth, for scratch.
#[derive(Debug, Clone)]
pub(super) struct CorrectedEnds {
    /// Fronts, x and y, and rears; a copy of the first rear follows the last. The fifth array is that of friction and not used.
    links: [Numbers; 5],
    /// Bodies on the teeth, x and y: bushings, or rollers. Copies of the first ones follow the last.
    on_teeth: [Numbers; 2],
}

impl CorrectedEnds {
    /// Allocate the ends of `links`.
    pub(super) fn new(links: usize) -> Self {
        let zeros = || padded_zeros(padded(2 * links + 3 * WIDTH));
        Self {
            links: [(); 5].map(|()| zeros()),
            on_teeth: [zeros(), zeros()],
        }
    }
}

/// Kernel: write the corrections of the velocities of the links' ends with the last correction.
struct WriteEnds<'a, T: Number>(&'a Factors<T>, &'a mut CorrectedEnds);

impl<T: Number> WithSimd for WriteEnds<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self(
            Factors {
                links, unknowns, ..
            },
            ends,
        ) = self;
        let simd = T::vectors(simd);
        links.write_ends::<_, false>(simd, unknowns, &mut ends.links);
    }
}

impl<T: Number> Factors<T> {
    /// Write the corrections of the velocities of the links' ends with the last correction.
    pub(super) fn write_ends(&self, instructions: InstructionSet, ends: &mut CorrectedEnds) {
        T::run(instructions, WriteEnds(self, ends));
    }
}

/// Rollers that are bodies, and the corrections of their velocities.
pub(crate) struct CorrectedRollers<'a> {
    pub(crate) arrays: &'a mut ChainArrays,
    /// Corrections, x and y \[m/s\].
    pub(crate) correction: [&'a [f64]; 2],
}

/// Kernel: return the changes of the powers of hinges, rollers and teeth \[W\] with the last correction; add those of their forces, and of
/// the loads on the sprockets. The corrections of the links' ends must be written, and the slopes must be those of the last evaluation,
/// without friction. Without `FORCES`, forces stay, and of the loads only the moments change: the powers need no more.
pub(crate) struct PowerChange<'a, const FORCES: bool> {
    pub(crate) matrix: &'a mut NewtonMatrix,
    pub(crate) links: usize,
    pub(crate) gamma: f64,
    pub(crate) constants: &'a LinkConstants,
    pub(crate) chain: &'a mut ChainArrays,
    pub(crate) rollers: Option<CorrectedRollers<'a>>,
    pub(crate) candidates: &'a mut [SprocketCandidates],
    pub(crate) overhang: usize,
    pub(crate) poses: &'a [SprocketPose],
    /// Corrections of the coordinates on the border.
    pub(crate) border: &'a [f64],
    pub(crate) loads: &'a mut [SprocketLoad],
}

impl<const FORCES: bool> WithSimd for PowerChange<'_, FORCES> {
    type Output = [f64; 3];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; 3] {
        let Self { matrix, gamma, .. } = self;
        let NewtonMatrix {
            slopes,
            corrected,
            motions,
            ..
        } = matrix;
        for rear in &mut corrected.links[2..4] {
            rear[self.links] = rear[0];
        }
        let of_hinges = hinges::<S, FORCES>(
            simd,
            (gamma, &slopes.hinges.normal),
            &self.constants.bushing_on_front,
            (corrected, &mut self.chain.force),
        );
        let (mut of_rollers, mut bodies) = (0.0, &self.chain.bushing);
        if let Some(CorrectedRollers { arrays, correction }) = self.rollers {
            of_rollers = rollers::<S, FORCES>(
                simd,
                (gamma, &slopes.rollers.normal),
                correction,
                (&mut corrected.on_teeth, &mut arrays.force),
            );
            bodies = &arrays.bushing;
        }
        for body in &mut corrected.on_teeth {
            body.copy_within(..self.overhang, self.links);
        }
        let mut of_teeth = 0.0;
        for (s, load) in self.loads.iter_mut().enumerate() {
            let teeth = ToothPowers {
                gamma,
                slopes: &slopes.teeth[s].normal,
                candidates: &mut self.candidates[s],
                pose: &self.poses[s],
                bodies,
                correction: &corrected.on_teeth,
            };
            let [power, x, y, moment] =
                teeth.sums::<S, FORCES>(simd, moved(&motions[s], self.border));
            of_teeth += power;
            load.force += Vec2::new(x, y);
            load.moment += moment;
        }
        [of_hinges, of_rollers, of_teeth]
    }
}

/// Return the corrections of the velocity of a sprocket's centre, x and y, and of its angular velocity.
#[inline(always)]
fn moved(of: &SprocketMotions, border: &[f64]) -> [f64; 3] {
    let mut moved = [0.0; 3];
    for (motion, &correction) in of.motions.iter().zip(border.iter().skip(of.first)) {
        match motion {
            BorderMotion::Along([x, y]) => {
                moved[0] += x * correction;
                moved[1] += y * correction;
            }
            BorderMotion::Turn => moved[2] += correction,
        }
    }
    moved
}

/// Return the change of the power of the hinges; write the corrections of the bushings, and add the changes of the forces.
#[inline(always)]
fn hinges<S: Simd, const FORCES: bool>(
    simd: S,
    (gamma, slopes): (f64, &[SlopeGroup]),
    on_front: &[f64],
    (ends, force): (&mut CorrectedEnds, &mut [f64]),
) -> f64 {
    let (gamma, zero) = (Lanes::splat(simd, gamma), Lanes::splat(simd, 0.0));
    let count = slopes.len();
    let [front_x, front_y, rear_x, rear_y, _] = &ends.links;
    let (front_x, front_y) = (packs(front_x, count), packs(front_y, count));
    // Hinge k joins the front of link k to the rear of link k + 1.
    let (rear_x, rear_y) = (packs(&rear_x[1..], count), packs(&rear_y[1..], count));
    let on_front = packs(on_front, count);
    let [bushing_x, bushing_y] = &mut ends.on_teeth;
    let (bushing_x, bushing_y) = (packs_mut(bushing_x, count), packs_mut(bushing_y, count));
    let force = packs_mut(force, count);
    let mut power = PartialSums::default();
    for number in 0..count {
        let group = &slopes[number];
        for part in parts::<S>() {
            let at = |array: &[Pack]| part_of(simd, &array[number], part);
            let (front, rear) = ([at(front_x), at(front_y)], [at(rear_x), at(rear_y)]);
            let of_front = at(on_front).greater(zero);
            put_part(
                &mut bushing_x[number],
                part,
                of_front.select(front[0], rear[0]),
            );
            put_part(
                &mut bushing_y[number],
                part,
                of_front.select(front[1], rear[1]),
            );
            let [nx, ny] = read(simd, &group.normal, part);
            let closing = nx.mul_add(front[0] - rear[0], ny * (front[1] - rear[1]));
            let to = (&mut power, &mut force[number]);
            add_changes::<S, FORCES>(simd, (group, part), gamma, closing, to);
        }
    }
    power.total()
}

/// Return the change of the power of the contacts between rollers and bushings, and add the changes of their forces. The corrections of the
/// bushings are replaced by those of the rollers.
#[inline(always)]
fn rollers<S: Simd, const FORCES: bool>(
    simd: S,
    (gamma, slopes): (f64, &[SlopeGroup]),
    rollers: [&[f64]; 2],
    (on_teeth, force): (&mut [Numbers; 2], &mut [f64]),
) -> f64 {
    let gamma = Lanes::splat(simd, gamma);
    let count = slopes.len();
    let [x, y] = rollers.map(|axis| Entries::<S>::of(simd, axis));
    let [to_x, to_y] = on_teeth;
    let (to_x, to_y) = (packs_mut(to_x, count), packs_mut(to_y, count));
    let force = packs_mut(force, count);
    let mut power = PartialSums::default();
    for number in 0..count {
        let group = &slopes[number];
        for part in parts::<S>() {
            let (x, y) = (x.at(number, part), y.at(number, part));
            let (to_x, to_y) = (&mut to_x[number], &mut to_y[number]);
            let (of_x, of_y) = (part_of(simd, to_x, part), part_of(simd, to_y, part));
            put_part(to_x, part, x);
            put_part(to_y, part, y);
            let [nx, ny] = read(simd, &group.normal, part);
            let closing = nx.mul_add(x - of_x, ny * (y - of_y));
            let to = (&mut power, &mut force[number]);
            add_changes::<S, FORCES>(simd, (group, part), gamma, closing, to);
        }
    }
    power.total()
}

/// Add the changes of the power and the forces of contacts whose penetration rates change by `closing`.
#[inline(always)]
fn add_changes<S: Simd, const FORCES: bool>(
    simd: S,
    of: (&SlopeGroup, usize),
    gamma: Lanes<S>,
    closing: Lanes<S>,
    (power, forces): (&mut PartialSums, &mut Pack),
) {
    power.add_part(of.1, power_by(simd, of, gamma, closing));
    if FORCES {
        add_to(simd, forces, of.1, push_by(simd, of, gamma, closing));
    }
}

/// Return the change of the power of contacts whose penetration rates change by `closing`.
///
/// The power is quadratic in the rate, P = d v²: d Δv² is positive whatever the sign of Δv, and would accumulate.
#[inline(always)]
fn power_by<S: Simd>(
    simd: S,
    (slopes, part): (&SlopeGroup, usize),
    gamma: Lanes<S>,
    closing: Lanes<S>,
) -> Lanes<S> {
    let [by_depth, by_rate] = read(simd, &slopes.power, part);
    let linear = gamma.mul_add(by_depth, by_rate);
    slopes.damping.at(simd, part).mul_add(closing, linear) * closing
}

/// Return the change of the forces of contacts whose penetration rates change by `closing`.
#[inline(always)]
fn push_by<S: Simd>(
    simd: S,
    (slopes, part): (&SlopeGroup, usize),
    gamma: Lanes<S>,
    closing: Lanes<S>,
) -> Lanes<S> {
    let damping = slopes.damping.at(simd, part);
    gamma.mul_add(slopes.stiffness.at(simd, part), damping) * closing
}

/// Add a change to forces, which push only.
#[inline(always)]
fn add_to<S: Simd>(simd: S, forces: &mut Pack, part: usize, change: Lanes<S>) {
    let force = (part_of(simd, forces, part) + change).max(Lanes::splat(simd, 0.0));
    put_part(forces, part, force);
}

/// Candidates of one sprocket.
struct ToothPowers<'a> {
    gamma: f64,
    slopes: &'a [SlopeGroup],
    candidates: &'a mut SprocketCandidates,
    pose: &'a SprocketPose,
    /// Centres of the bushings, or of the rollers \[m\].
    bodies: &'a [Numbers; 2],
    /// Corrections of their velocities \[m/s\].
    correction: &'a [Numbers; 2],
}

impl ToothPowers<'_> {
    /// Return the changes of the power dissipated, the force on the sprocket and its moment for a sprocket with these corrections of its
    /// velocities; add those of the forces of the contacts.
    #[inline(always)]
    fn sums<S: Simd, const FORCES: bool>(
        self,
        simd: S,
        [of_x, of_y, of_spin]: [f64; 3],
    ) -> [f64; 4] {
        let splat = |value| Lanes::splat(simd, value);
        let (gamma, zero) = (splat(self.gamma), splat(0.0));
        let center = splat_two(simd, self.pose.center);
        let mut sums = [PartialSums::default(); 4];
        let SprocketCandidates { runs, force, .. } = self.candidates;
        for run in runs.iter() {
            let vectors = run.length.div_ceil(S::F64_LANES);
            let groups = run.length.div_ceil(WIDTH);
            let ([x, y], [vx, vy]) = (self.bodies, self.correction);
            let (x, y) = (
                packs(&x[run.first..], groups),
                packs(&y[run.first..], groups),
            );
            let (vx, vy) = (
                packs(&vx[run.first..], groups),
                packs(&vy[run.first..], groups),
            );
            let slopes = &self.slopes[run.slot / WIDTH..][..groups];
            let force = packs_mut(&mut force[run.slot..], groups);
            for number in 0..groups {
                let group = &slopes[number];
                for part in parts::<S>() {
                    // Slopes behind the last vector of the run are not written.
                    if number * parts::<S>().len() + part >= vectors {
                        break;
                    }
                    if !group.force.at(simd, part).exceeds(zero).any() {
                        continue;
                    }
                    let at = |array: &[Pack]| part_of(simd, &array[number], part);
                    let (x, y) = (at(x) - center[0], at(y) - center[1]);
                    let vx = splat(of_spin).mul_add(y, at(vx) - splat(of_x));
                    let vy = splat(of_spin).negate_mul_add(x, at(vy) - splat(of_y));
                    let [nx, ny] = read(simd, &group.normal, part);
                    let closing = nx.mul_add(vx, ny * vy);
                    let push = push_by(simd, (group, part), gamma, closing);
                    if FORCES {
                        add_to(simd, &mut force[number], part, push);
                        sums[1].add_part(part, push * nx);
                        sums[2].add_part(part, push * ny);
                    }
                    sums[0].add_part(part, power_by(simd, (group, part), gamma, closing));
                    sums[3].add_part(part, push * x.mul_add(ny, -(y * nx)));
                }
            }
        }
        let [power, x, y, moment] = sums;
        [power.total(), x.total(), y.total(), moment.total()]
    }
}

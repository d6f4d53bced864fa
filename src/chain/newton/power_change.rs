//! Change of the forces and powers of the contacts, and of the moments on the sprockets, with the last correction.
//!
//! A step of Newton's method has its last evaluation before its last correction. This correction Δv changes the penetration rate of a
//! contact by n·Δv, with the relative velocity of its two points, and its penetration by γ n·Δv. Slopes of force and power are those of
//! the evaluation: forces are of first order, powers of second order in Δv. The turn of the normals is left out, as in the matrix. Friction
//! follows from its law, with the changed normal force and sliding velocity.

use pulp::{Simd, WithSimd};

use super::tooth_motion::BorderMotion;
use super::{Factors, NewtonMatrix, SprocketMotions};
use crate::chain::arrays::layout::{ChainArrays, LinkConstants};
use crate::chain::arrays::pose::SprocketPose;
use crate::chain::arrays::slopes::{ContactSlopes, FrictionGroup, SlopeGroup};
use crate::chain::contact::SprocketCandidates;
use crate::chain::loads::SprocketLoad;
use crate::chain::powers::Losses;
use crate::force_law::{Friction, RegularizedFriction};
use crate::math::simd::{
    Entries, InstructionSet, Lanes, Number, Numbers, Pack, PartialSums, WIDTH, packs, packs_mut,
    padded, padded_zeros, part_of, parts, put_part, read, splat_two,
};

/// Corrections of the velocities of the links' ends and of the bodies on the teeth, for scratch.
#[derive(Debug, Clone)]
pub(super) struct CorrectedEnds {
    /// Fronts, x and y, rears, and with friction angular velocities; copies of the first rear and angular velocity follow the last.
    pub(super) links: [Numbers; 5],
    /// Bodies on the teeth, x and y: bushings, or rollers; with friction their angular velocities. Copies of the first ones follow the last.
    on_teeth: [Numbers; 3],
}

impl CorrectedEnds {
    /// Allocate the ends of `links`.
    pub(super) fn new(links: usize) -> Self {
        let zeros = || padded_zeros(padded(2 * links + 3 * WIDTH));
        Self {
            links: [(); 5].map(|()| zeros()),
            on_teeth: [(); 3].map(|()| zeros()),
        }
    }
}

/// Kernel: write the corrections of the velocities of the links' ends with the last correction; with `FRICTION` of angular velocities too.
struct WriteEnds<'a, T: Number, const FRICTION: bool>(&'a Factors<T>, &'a mut CorrectedEnds);

impl<T: Number, const FRICTION: bool> WithSimd for WriteEnds<'_, T, FRICTION> {
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
        links.write_ends::<_, FRICTION>(simd, unknowns, &mut ends.links);
    }
}

impl<T: Number> Factors<T> {
    /// Write the corrections of the velocities of the links' ends with the last correction.
    pub(super) fn write_ends<const FRICTION: bool>(
        &self,
        instructions: InstructionSet,
        ends: &mut CorrectedEnds,
    ) {
        T::run(instructions, WriteEnds::<_, FRICTION>(self, ends));
    }
}

/// Rollers that are bodies, and the corrections of their velocities.
pub(crate) struct CorrectedRollers<'a> {
    pub(crate) arrays: &'a mut ChainArrays,
    /// Corrections, x and y \[m/s\], and of the angular velocities \[rad/s\].
    pub(crate) correction: [&'a [f64]; 3],
}

/// Kernel: return the changes of the powers dissipated with the last correction; add those of the moments on the sprockets, and with `FORCES`
/// of the normal forces. The corrections of the links' ends must be written, and the slopes must be those of the last evaluation. `FRICTION`:
/// with regularised friction.
pub(crate) struct PowerChange<'a, const FORCES: bool, const FRICTION: bool> {
    pub(crate) matrix: &'a mut NewtonMatrix,
    pub(crate) links: usize,
    pub(crate) gamma: f64,
    pub(crate) constants: &'a LinkConstants,
    pub(crate) chain: &'a mut ChainArrays,
    pub(crate) rollers: Option<CorrectedRollers<'a>>,
    pub(crate) candidates: &'a mut [SprocketCandidates],
    pub(crate) overhang: usize,
    /// Friction of hinges and rollers, and of teeth, for `FRICTION`.
    pub(crate) friction: [Option<&'a Friction>; 2],
    /// Radius of the bushings on the teeth \[m\].
    pub(crate) bushing_radius: f64,
    pub(crate) poses: &'a [SprocketPose],
    /// Corrections of the coordinates on the border.
    pub(crate) border: &'a [f64],
    pub(crate) loads: &'a mut [SprocketLoad],
}

impl<const FORCES: bool, const FRICTION: bool> WithSimd for PowerChange<'_, FORCES, FRICTION> {
    type Output = Losses;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Losses {
        let Self { matrix, gamma, .. } = self;
        let NewtonMatrix {
            slopes,
            corrected,
            motions,
            ..
        } = matrix;
        let ChainArrays {
            bushing,
            force,
            friction,
            ..
        } = self.chain;
        let [in_joints, on_teeth] = self.friction;
        let joints = JointChanges::new(simd, (gamma, &slopes.hinges), (force, friction), in_joints);
        let [hinge_contact, hinge_friction] = hinges::<S, FORCES, FRICTION>(
            simd,
            joints,
            &self.constants.bushing_on_front,
            corrected,
        );
        let mut losses = Losses {
            hinge_contact,
            hinge_friction,
            ..Losses::default()
        };
        let mut bodies = &*bushing;
        if let Some(CorrectedRollers { arrays, correction }) = self.rollers {
            let ChainArrays {
                bushing,
                force,
                friction,
                ..
            } = arrays;
            let joints =
                JointChanges::new(simd, (gamma, &slopes.rollers), (force, friction), in_joints);
            [losses.roller_contact, losses.roller_friction] =
                rollers::<S, FORCES, FRICTION>(simd, joints, correction, &mut corrected.on_teeth);
            bodies = &*bushing;
        }
        for body in &mut corrected.on_teeth {
            body.copy_within(..self.overhang, self.links);
        }
        for (s, load) in self.loads.iter_mut().enumerate() {
            let teeth = ToothPowers {
                gamma,
                friction: on_teeth,
                bushing_radius: self.bushing_radius,
                slopes: &slopes.teeth[s],
                candidates: &mut self.candidates[s],
                pose: &self.poses[s],
                bodies,
                correction: &corrected.on_teeth,
            };
            let [contact, friction, moment] =
                teeth.sums::<S, FORCES, FRICTION>(simd, moved(&motions[s], self.border));
            losses.tooth_contact += contact;
            losses.tooth_friction += friction;
            load.moment += moment;
        }
        losses
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

/// Friction of joints: its law, its slopes and its present values \[N\].
struct JointFriction<'a, S: Simd> {
    law: RegularizedFriction<Lanes<S>>,
    slopes: &'a [FrictionGroup],
    present: &'a [Pack],
}

/// Hinges, or rollers on their bushings.
struct JointChanges<'a, S: Simd> {
    gamma: Lanes<S>,
    normal: &'a [SlopeGroup],
    /// For `FRICTION`.
    friction: Option<JointFriction<'a, S>>,
    force: &'a mut [Pack],
    power: PartialSums,
    friction_power: PartialSums,
}

impl<'a, S: Simd> JointChanges<'a, S> {
    /// Return joints with these forces and this friction, before any change.
    #[inline(always)]
    fn new(
        simd: S,
        (gamma, slopes): (f64, &'a ContactSlopes),
        (force, friction): (&'a mut [f64], &'a [f64]),
        law: Option<&Friction>,
    ) -> Self {
        let count = slopes.normal.len();
        let law = law.map(|law| RegularizedFriction::new(simd, law));
        Self {
            gamma: Lanes::splat(simd, gamma),
            normal: &slopes.normal,
            friction: law.map(|law| JointFriction {
                law,
                slopes: &slopes.friction,
                present: packs(friction, count),
            }),
            force: packs_mut(force, count),
            power: PartialSums::default(),
            friction_power: PartialSums::default(),
        }
    }

    /// Add the changes of powers and forces of one vector of joints, for changes of the velocity of the first body of each relative to the
    /// second one, and of the angular velocities of both.
    #[inline(always)]
    fn add<const FORCES: bool, const FRICTION: bool>(
        &mut self,
        (number, part): (usize, usize),
        [vx, vy]: [Lanes<S>; 2],
        [spin, other]: [Lanes<S>; 2],
    ) {
        let (simd, gamma) = (vx.simd(), self.gamma);
        let normal = &self.normal[number];
        let [nx, ny] = read(simd, &normal.normal, part);
        let closing = nx.mul_add(vx, ny * vy);
        let change = power_by(simd, (normal, part), gamma, closing);
        self.power.add_part(part, change);
        // Contacts that are apart have old sliding velocities.
        let zero = gamma.constant(0.0);
        if FRICTION
            && let Some(friction) = &self.friction
            && normal.force.at(simd, part).exceeds(zero).any()
        {
            let rubbing = &friction.slopes[number];
            let [first, second] = read(simd, &rubbing.places, part);
            let turning = first.mul_add(spin, -(second * other));
            let sliding = nx.mul_add(vy, -(ny * vx)) + turning;
            let push = push_by(simd, (normal, part), gamma, closing);
            let present = part_of(simd, &friction.present[number], part);
            let of = (normal, rubbing, part);
            let [_, change] = friction_by(&friction.law, present, of, [push, sliding]);
            self.friction_power.add_part(part, change);
        }
        if FORCES {
            let push = push_by(simd, (normal, part), gamma, closing);
            add_to(simd, &mut self.force[number], part, push);
        }
    }

    /// Return the changes of the powers of damping and friction.
    #[inline(always)]
    fn powers(&self, has_friction: bool) -> [f64; 2] {
        let friction = self.friction_power.total_if(has_friction);
        [self.power.total(), friction]
    }
}

/// Return the changes of the powers of damping and friction in these hinges; write the corrections of the bushings, and add the changes of
/// the normal forces.
#[inline(always)]
fn hinges<S: Simd, const FORCES: bool, const FRICTION: bool>(
    simd: S,
    mut joints: JointChanges<S>,
    on_front: &[f64],
    ends: &mut CorrectedEnds,
) -> [f64; 2] {
    let zero = Lanes::splat(simd, 0.0);
    let count = joints.normal.len();
    let [front_x, front_y, rear_x, rear_y, spin] = &ends.links;
    let (front_x, front_y) = (packs(front_x, count), packs(front_y, count));
    // Hinge k joins the front of link k to the rear of link k + 1.
    let (rear_x, rear_y) = (packs(&rear_x[1..], count), packs(&rear_y[1..], count));
    let (front_spin, rear_spin) = (packs(spin, count), packs(&spin[1..], count));
    let on_front = packs(on_front, count);
    let [bushing_x, bushing_y, bushing_spin] = &mut ends.on_teeth;
    let (bushing_x, bushing_y) = (packs_mut(bushing_x, count), packs_mut(bushing_y, count));
    let bushing_spin = packs_mut(bushing_spin, count);
    for number in 0..count {
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
            let mut spins = [zero; 2];
            if FRICTION {
                spins = [at(front_spin), at(rear_spin)];
                let spin = of_front.select(spins[0], spins[1]);
                put_part(&mut bushing_spin[number], part, spin);
            }
            let velocity = [front[0] - rear[0], front[1] - rear[1]];
            joints.add::<FORCES, FRICTION>((number, part), velocity, spins);
        }
    }
    joints.powers(FRICTION)
}

/// Return the changes of the powers of damping and friction of rollers on their bushings, and add the changes of their normal forces. The
/// corrections of the bushings are replaced by those of the rollers.
#[inline(always)]
fn rollers<S: Simd, const FORCES: bool, const FRICTION: bool>(
    simd: S,
    mut joints: JointChanges<S>,
    rollers: [&[f64]; 3],
    on_teeth: &mut [Numbers; 3],
) -> [f64; 2] {
    let count = joints.normal.len();
    let [x, y, spin] = rollers.map(|axis| Entries::<S>::of(simd, axis));
    let [to_x, to_y, to_spin] = on_teeth;
    let (to_x, to_y) = (packs_mut(to_x, count), packs_mut(to_y, count));
    let to_spin = packs_mut(to_spin, count);
    for number in 0..count {
        for part in parts::<S>() {
            let (x, y) = (x.at(number, part), y.at(number, part));
            let (to_x, to_y) = (&mut to_x[number], &mut to_y[number]);
            let velocity = [x - part_of(simd, to_x, part), y - part_of(simd, to_y, part)];
            put_part(to_x, part, x);
            put_part(to_y, part, y);
            let mut spins = [Lanes::splat(simd, 0.0); 2];
            if FRICTION {
                let to = &mut to_spin[number];
                spins = [spin.at(number, part), part_of(simd, to, part)];
                put_part(to, part, spins[0]);
            }
            joints.add::<FORCES, FRICTION>((number, part), velocity, spins);
        }
    }
    joints.powers(FRICTION)
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

/// Return the changes of friction \[N\] and of its power \[W\] for contacts with the `present` friction, whose normal force and sliding
/// velocity change by `push` and `sliding`.
///
/// They follow from the law: at a loose accuracy the sliding velocity can change by more than v₁, at which friction is full.
#[inline(always)]
fn friction_by<S: Simd>(
    law: &RegularizedFriction<Lanes<S>>,
    present: Lanes<S>,
    (normal, slopes, part): (&SlopeGroup, &FrictionGroup, usize),
    [push, sliding]: [Lanes<S>; 2],
) -> [Lanes<S>; 2] {
    let simd = present.simd();
    let force = (normal.force.at(simd, part) + push).positive_part();
    let before = slopes.slip.at(simd, part);
    let slip = before + sliding;
    let [friction, _] = law.force(force, slip);
    [
        friction - present,
        friction.mul_add(slip, -(present * before)),
    ]
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
    friction: Option<&'a Friction>,
    /// Radius of the bushings \[m\].
    bushing_radius: f64,
    slopes: &'a ContactSlopes,
    candidates: &'a mut SprocketCandidates,
    pose: &'a SprocketPose,
    /// Centres of the bushings, or of the rollers \[m\].
    bodies: &'a [Numbers; 2],
    /// Corrections of their velocities \[m/s\], and with friction of their angular velocities \[rad/s\].
    correction: &'a [Numbers; 3],
}

impl ToothPowers<'_> {
    /// Return the changes of the powers of damping and friction, and of the moment on the sprocket, which has these corrections of its
    /// velocities; add those of the normal forces of the contacts.
    #[inline(always)]
    fn sums<S: Simd, const FORCES: bool, const FRICTION: bool>(
        self,
        simd: S,
        [of_x, of_y, of_spin]: [f64; 3],
    ) -> [f64; 3] {
        let splat = |value| Lanes::splat(simd, value);
        let (gamma, zero, radius) = (splat(self.gamma), splat(0.0), splat(self.bushing_radius));
        let center = splat_two(simd, self.pose.center);
        let law = self.friction.map(|law| RegularizedFriction::new(simd, law));
        let mut sums = [PartialSums::default(); 3];
        let SprocketCandidates {
            runs,
            force,
            friction,
            ..
        } = self.candidates;
        for run in runs.iter() {
            let vectors = run.length.div_ceil(S::F64_LANES);
            let groups = run.length.div_ceil(WIDTH);
            let ([x, y], [vx, vy, spin]) = (self.bodies, self.correction);
            let (x, y) = (
                packs(&x[run.first..], groups),
                packs(&y[run.first..], groups),
            );
            let (vx, vy) = (
                packs(&vx[run.first..], groups),
                packs(&vy[run.first..], groups),
            );
            let spin = packs(&spin[run.first..], groups);
            let first = run.slot / WIDTH;
            let slopes = &self.slopes.normal[first..][..groups];
            let force = packs_mut(&mut force[run.slot..], groups);
            let friction = packs(&friction[run.slot..], groups);
            for number in 0..groups {
                let group = &slopes[number];
                for part in parts::<S>() {
                    // Slopes behind the last vector of the run are not written.
                    if number * parts::<S>().len() + part >= vectors {
                        break;
                    }
                    // A contact whose factor 1 + λ δ'/δ'₀ is negative has no force. It dissipates all of its elastic power.
                    let bears = group.force.at(simd, part).exceeds(zero);
                    if !bears.or(zero.exceeds(group.power[1].at(simd, part))).any() {
                        continue;
                    }
                    let at = |array: &[Pack]| part_of(simd, &array[number], part);
                    let (x, y) = (at(x) - center[0], at(y) - center[1]);
                    let vx = splat(of_spin).mul_add(y, at(vx) - splat(of_x));
                    let vy = splat(of_spin).negate_mul_add(x, at(vy) - splat(of_y));
                    let [nx, ny] = read(simd, &group.normal, part);
                    let closing = nx.mul_add(vx, ny * vy);
                    let push = push_by(simd, (group, part), gamma, closing);
                    let mut moment = push * x.mul_add(ny, -(y * nx));
                    if FRICTION && let Some(law) = &law {
                        let turning = radius * (at(spin) - splat(of_spin));
                        let sliding = nx.mul_add(vy, -(ny * vx)) + turning;
                        let of = (group, &self.slopes.friction[first + number], part);
                        let [change, power] = friction_by(law, at(friction), of, [push, sliding]);
                        sums[1].add_part(part, power);
                        let arm = x.mul_add(nx, y.mul_add(ny, radius));
                        moment = change.mul_add(arm, moment);
                    }
                    if FORCES {
                        add_to(simd, &mut force[number], part, push);
                    }
                    sums[0].add_part(part, power_by(simd, (group, part), gamma, closing));
                    sums[2].add_part(part, moment);
                }
            }
        }
        let [contact, friction, moment] = sums;
        let friction = friction.total_if(FRICTION);
        [contact.total(), friction, moment.total()]
    }
}

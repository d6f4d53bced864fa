//! The right-hand side: equations of motion in SIMD kernels over vectors of contacts, for the instruction set of the machine.
//!
//! chain (directions, ends, hinges, bushings) -> rollers, where they are bodies -> candidates -> teeth -> loads -> accelerations
//!
//! Each kernel evaluates one law in one loop over arrays, one array per quantity. Options are constant parameters of a loop:
//! damping, friction, and the dissipated power. A model without an option runs an instance of the loop without it.

#![allow(clippy::inline_always)] // a function that is not inlined is compiled without the kernel's instruction set

mod ansi_gap;
mod bristles;
mod chain;
mod event_screening;
pub(crate) mod gap;
pub(crate) mod layout;
mod loads;
mod readout;
pub(crate) mod slopes;
mod surface_table;
pub(crate) mod teeth;

use std::marker::PhantomData;

use crate::chain::newton::{Evaluated, NewtonMatrix};
use bristles::{BristleState, Bristling, ContactKind};
use chain::{
    ChainFound, FilledHinges, HingeFriction, JoinChain, JoinRollers, Joints, RepeatBushings,
    Rollers,
};
pub(crate) use event_screening::{Watch, Watched};
use event_screening::{WatchHinges, WatchTeeth};
use gap::{Form, ToothConstants};
use layout::{ChainArrays, FIRST, LinkConstants};
use loads::{AccelerateLinks, AccelerateRollers};
pub(crate) use readout::ToothReadings;
use teeth::{SprocketPose, TeethFound, ToothFriction, TouchTeeth};

use crate::chain::contact::{
    Candidates, ImpactMemory, Seated, SprocketFrame, ToothJumps, seen_from_teeth,
};
use crate::chain::dynamics::{Losses, Powers, SprocketLoad, outside_powers, sprocket_acceleration};
use crate::chain::model::{Model, OpenEnds, RollerModel, Rotation, Support};
use crate::chain::motion::sprocket_motion;
use crate::force_law::{ElasticLaw, LuGre, with_law};
use crate::geometry::Vec2;
use crate::math::simd::InstructionSet;

/// Return the arrays of the bodies on the teeth: the rollers', or the chain's.
fn on_teeth<'a>(chain: &'a ChainArrays, rollers: Option<&'a Rollers>) -> &'a ChainArrays {
    rollers.map_or(chain, |rollers| &rollers.arrays)
}

/// Return the arrays and the law of the bristles of a loop, where its contacts have any.
fn bristling<'a>(
    state: Option<&'a mut BristleState>,
    (place, law): (ContactKind, Option<&'a LuGre>),
    radius: f64,
) -> Option<Bristling<'a>> {
    state
        .zip(law)
        .map(|(state, law)| state.lend(place, law, radius))
}

/// Arrays of the right-hand side and the instruction set of its kernels.
#[derive(Debug, Clone)]
pub(crate) struct Kernels {
    instructions: InstructionSet,
    links: LinkConstants,
    chain: ChainArrays,
    /// Rollers, where they are bodies of their own; the teeth then touch them.
    rollers: Option<Box<Rollers>>,
    pub(crate) candidates: Candidates,
    /// Event screening: gaps at both ends of the last step.
    pub(crate) watch: Watch,
    /// Constants of the teeth, one per kind of sprocket: sprockets with identical teeth share them.
    teeth: Vec<ToothConstants>,
    /// Index of the constants of each sprocket.
    kind: Vec<usize>,
    poses: Vec<SprocketPose>,
    loads: Vec<SprocketLoad>,
    /// By [`ContactKind`]: whether the contact states of the last evaluation differ from the impact velocity memory. Either a
    /// contact has no memory, or a memory has no contact.
    changed: [bool; 3],
    /// Newton's matrix, allocated on request.
    newton: Option<Box<NewtonMatrix>>,
    /// Bristles, where friction is modelled by them.
    bristles: Option<Box<BristleState>>,
    /// Whether evaluations write the slopes for Newton's matrix.
    writes_slopes: bool,
    /// Scratch: bushings seated on one sprocket.
    seated: Vec<Seated>,
}

impl Kernels {
    /// Allocate the arrays for `model`.
    pub(crate) fn new(model: &Model) -> Self {
        let sprockets = model.sprockets.len();
        let (mut teeth, mut kind) = (Vec::new(), Vec::new());
        for s in 0..sprockets {
            let own = ToothConstants::new(model, s);
            let known = teeth.iter().position(|other| *other == own);
            kind.push(known.unwrap_or(teeth.len()));
            if known.is_none() {
                teeth.push(own);
            }
        }
        Self {
            instructions: InstructionSet::detect(),
            links: LinkConstants::new(model),
            chain: ChainArrays::new(model),
            rollers: Rollers::of(model).map(Box::new),
            candidates: Candidates::new(model),
            watch: Watch::new(model),
            teeth,
            kind,
            poses: vec![SprocketPose::default(); sprockets],
            loads: vec![SprocketLoad::default(); sprockets],
            changed: [true; 3],
            newton: None,
            bristles: BristleState::of(model, Candidates::most_slots(model)).map(Box::new),
            writes_slopes: false,
            seated: Vec::with_capacity(model.links),
        }
    }

    /// Allocate Newton's matrix.
    pub(crate) fn make_room_for_newton(&mut self, model: &Model) {
        if self.newton.is_none() {
            self.newton = Some(Box::new(NewtonMatrix::new(model)));
        }
    }

    /// Switch on or off the slopes of all forces, which [`Self::factorise`] needs, for the next evaluations.
    pub(crate) fn write_slopes(&mut self, write: bool) {
        self.writes_slopes = write;
    }

    /// Factorise Newton's matrix of the last evaluation, which must have written slopes. Return false where it is singular, or not
    /// definite and not allowed to be `indefinite`.
    pub(crate) fn factorise(
        &mut self,
        model: &Model,
        pawls: &[f64],
        gamma: f64,
        indefinite: bool,
    ) -> bool {
        let evaluated = Evaluated {
            instructions: self.instructions,
            constants: &self.links,
            chain: &self.chain,
            on_teeth: on_teeth(&self.chain, self.rollers.as_deref()),
            candidates: &self.candidates,
            poses: &self.poses,
            pawls,
            indefinite,
        };
        self.newton
            .as_mut()
            .is_some_and(|newton| newton.factorise(model, &evaluated, gamma))
    }

    /// Overwrite a residual of the velocities with the correction, the solution with the last matrix.
    pub(crate) fn correct(&mut self, model: &Model, residual: &mut [f64]) {
        if let Some(newton) = &mut self.newton {
            newton.correct(model, self.instructions, residual);
        }
    }

    /// Start or end an implicit step for bristles. With predicted deflections and γ, evaluations solve for the deflections; with
    /// `None` they use those of the state.
    pub(crate) fn solve_for_bristles(&mut self, step: Option<(&[f64], f64)>) {
        match (&mut self.bristles, step) {
            (Some(bristles), Some((predicted, gamma))) => {
                bristles.begin_implicit_stage(predicted, gamma);
            }
            (Some(bristles), None) => bristles.end_implicit_stage(),
            (None, _) => {}
        }
    }

    /// Return the deflections of the bristles that the last evaluation of an implicit step solved for \[m\].
    pub(crate) fn solved_bristles(&self) -> &[f64] {
        (self.bristles.as_ref()).map_or(&[], |bristles| bristles.solved())
    }

    /// Set the instruction set.
    pub(crate) fn use_instructions(&mut self, instructions: InstructionSet) {
        self.instructions = instructions;
    }

    /// Return the instruction set.
    pub(crate) fn instructions(&self) -> InstructionSet {
        self.instructions
    }

    /// Return whether any contact state of the last evaluation differs from the impact velocity memory.
    pub(crate) fn changed(&self) -> bool {
        self.changed.contains(&true)
    }

    /// Return the same by [`ContactKind`].
    pub(crate) fn changes(&self) -> [bool; 3] {
        self.changed
    }

    /// Return position and motion of sprocket `s` at the last evaluation.
    pub(crate) fn sprocket_frame(&self, s: usize) -> SprocketFrame {
        let pose = &self.poses[s];
        SprocketFrame {
            center: pose.center.into(),
            velocity: pose.velocity.into(),
            spin: pose.spin,
            cos: pose.direction[0],
            sin: pose.direction[1],
        }
    }

    /// Return the penetration of every hinge at the last evaluation \[m\]; zero without contact.
    pub(crate) fn hinge_depths(&self, model: &Model) -> &[f64] {
        &self.chain.depth[..model.links]
    }

    /// Return the penetration of every bushing in its roller at the last evaluation \[m\]; zero without contact.
    pub(crate) fn roller_depths(&self, model: &Model) -> &[f64] {
        let rollers = self.rollers.as_ref();
        rollers.map_or(&[], |rollers| &rollers.arrays.depth[..model.links])
    }

    /// Return the normal force of bushing `k` in its roller at the last evaluation \[N\].
    pub(crate) fn roller_force(&self, k: usize) -> f64 {
        let rollers = self.rollers.as_ref();
        rollers.map_or(0.0, |rollers| rollers.arrays.force[k])
    }

    /// Return the normal force of hinge `k` at the last evaluation \[N\].
    pub(crate) fn hinge_force(&self, k: usize) -> f64 {
        self.chain.force[k]
    }

    /// Return sprocket, bushing, penetration \[m\] and normal force \[N\] of every candidate at the last evaluation.
    pub(crate) fn tooth_contacts(
        &self,
        model: &Model,
    ) -> impl Iterator<Item = (usize, usize, f64, f64)> {
        let links = model.links;
        let sprockets = self.candidates.sprockets.iter().enumerate();
        sprockets.flat_map(move |(s, candidates)| {
            candidates
                .bushings(links)
                .map(move |(slot, k)| (s, k, candidates.depth[slot], candidates.force[slot]))
        })
    }

    /// Return the centre of bushing `k`, or of its roller, at the last evaluation \[m\].
    fn place_on_teeth(&self, k: usize) -> Vec2 {
        let [x, y] = &on_teeth(&self.chain, self.rollers.as_deref()).bushing;
        Vec2::new(x[k], y[k])
    }

    /// Detect jumps over the teeth of any sprocket at the last evaluation, which was at time `t` \[s\].
    pub(crate) fn look_for_jumps(&mut self, model: &Model, t: f64, jumps: &mut ToothJumps) {
        for s in 0..model.toothed() {
            let (sprocket, frame) = (&model.sprockets[s], self.sprocket_frame(s));
            let limit = sprocket.seated_within();
            self.seated.clear();
            for (_, bushing) in self.candidates.sprockets[s].bushings(model.links) {
                let arm = self.place_on_teeth(bushing) - frame.center;
                let in_body = seen_from_teeth(sprocket, &frame, arm);
                if in_body.norm_squared() < limit * limit {
                    let gap = sprocket.profile.nearest_gap(in_body.y.atan2(in_body.x));
                    self.seated.push(Seated { bushing, gap });
                }
            }
            jumps.look(model, (t, s), &self.seated, |k| {
                self.place_on_teeth(k) - frame.center
            });
        }
    }

    /// Screen all contacts for events in a step of `length` \[s\]. The last evaluation must be at its end.
    pub(crate) fn watch(&mut self, model: &Model, length: f64) -> Watched {
        let n = model.links;
        self.watch.follow(&self.candidates, n);
        let mut watched = self.instructions.run(WatchHinges {
            length,
            links: n,
            clearance: model.clearance,
            arrays: &self.chain,
            ends: &mut self.watch.hinges,
        });
        if let (Some(rollers), Some(of)) = (&self.rollers, &model.rollers) {
            let found = self.instructions.run(WatchHinges {
                length,
                links: n,
                clearance: of.clearance,
                arrays: &rollers.arrays,
                ends: &mut self.watch.rollers,
            });
            watched.turned |= found.turned;
            watched.speed = watched.speed.max(found.speed);
        }
        let mut rim: f64 = 0.0;
        for (s, ends) in self.watch.teeth.iter_mut().enumerate() {
            let pose = &self.poses[s];
            macro_rules! watch {
                ($constants:expr) => {
                    self.instructions.run(WatchTeeth {
                        length,
                        constants: $constants,
                        pose,
                        arrays: on_teeth(&self.chain, self.rollers.as_deref()),
                        candidates: &self.candidates.sprockets[s],
                        ends,
                    })
                };
            }
            watched.turned |= match &self.teeth[self.kind[s]].form {
                Form::Ansi(gap) => watch!(gap),
                Form::Table(gap) => watch!(gap),
            };
            // Bound of the speed of any point of the teeth.
            let center_speed = Vec2::from(pose.velocity).norm();
            rim = rim.max(center_speed + pose.spin.abs() * model.sprockets[s].reach);
        }
        watched.speed += rim;
        watched
    }

    /// Write the accelerations at (`t`, `y`) into `rates`, coordinate by coordinate; return the powers when an energy balance is
    /// kept.
    pub(crate) fn accelerations<const ENERGY: bool>(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        t: f64,
        y: &[f64],
        rates: &mut [f64],
    ) -> Powers {
        self.place_sprockets(model, t, y);
        self.accelerate_placed::<ENERGY>(model, memory, t, y, rates)
    }

    /// Evaluate as [`Self::accelerations`] with sprockets that are positioned already.
    fn accelerate_placed<const ENERGY: bool>(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        t: f64,
        y: &[f64],
        rates: &mut [f64],
    ) -> Powers {
        let (moved_squared, mut losses) = self.join::<ENERGY>(model, memory, y, rates);
        self.touch::<ENERGY>(model, memory, (y, moved_squared), rates, &mut losses);
        self.put_bristles(model, rates);
        self.accelerate_links(model, rates);
        self.accelerate_rollers(model, rates);
        let moved = model
            .ends
            .as_ref()
            .map_or(0.0, |ends| self.move_ends(ends, t, rates));
        self.accelerate_sprockets(model, &memory.pawls, t, rates);
        let mut powers = Powers::of(losses);
        if ENERGY {
            powers.worked_in += moved;
            for ((sprocket, pose), load) in model.sprockets.iter().zip(&self.poses).zip(&self.loads)
            {
                powers += outside_powers(sprocket, &pose.moves(), load, t);
            }
        }
        powers
    }

    /// Evaluate hinges and rollers at `y`; return the largest squared distance of the bodies on the teeth from their references
    /// \[m²\], and the losses.
    fn join<const ENERGY: bool>(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        y: &[f64],
        rates: &mut [f64],
    ) -> (f64, Losses) {
        self.take_bristles(model, y, rates);
        if model.has_moments() {
            self.chain.clear_moments();
            if let Some(rollers) = &mut self.rollers {
                rollers.arrays.clear_moments();
            }
        }
        let chain = with_law!(&model.hinge_law.pairs, Law, pairs => {
            self.join_chain::<Law, ENERGY>(model, memory, pairs[0], y)
        });
        if let Some(ends) = &model.ends {
            self.chain.forget_open_hinges(ends);
        }
        for (s, pose) in self.poses.iter_mut().enumerate() {
            pose.direction = [self.chain.sprocket_cos[s], self.chain.sprocket_sin[s]];
        }
        let rolling = model.rollers.as_ref().map(|of| {
            if model.hinges_rub() {
                let spins = &y[model.coordinates + 2 * model.links..][..model.links];
                self.chain.spin_bushings(&self.links, spins, 0);
            }
            with_law!(&of.law.pairs, Law, pairs => {
                self.join_rollers::<Law, ENERGY>(model, of, memory, pairs[0], y)
            })
        });
        if let (Some(rollers), Some(_)) = (&mut self.rollers, &model.ends) {
            rollers.arrays.forget_absent_rollers(model);
        }
        let rollers_changed = rolling.is_some_and(|found| found.changed);
        self.changed = [chain.changed, rollers_changed, false];
        let losses = Losses {
            hinge_contact: chain.dissipated,
            hinge_friction: chain.rubbed,
            roller_contact: rolling.map_or(0.0, |found| found.dissipated),
            roller_friction: rolling.map_or(0.0, |found| found.rubbed),
            hinge_film: chain.sheared,
            ..Losses::default()
        };
        let moved_squared = rolling.map_or(chain.moved_squared, |found| found.moved_squared);
        (moved_squared, losses)
    }

    /// Evaluate the teeth at `y`, after hinges and rollers, with the squared distance that [`Self::join`] returns; add the losses
    /// of the teeth.
    fn touch<const ENERGY: bool>(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        (y, moved_squared): (&[f64], f64),
        rates: &mut [f64],
        losses: &mut Losses,
    ) {
        self.choose_candidates(model, memory, moved_squared);
        if model.teeth_rub() {
            let (n, overhang) = (model.links, self.candidates.overhang);
            let spins = &y[model.coordinates..];
            if let (Some(of), Some(rollers)) = (&model.rollers, &mut self.rollers) {
                let Rollers { constants, arrays } = &mut **rollers;
                arrays.spin_bushings(constants, &spins[of.first + 2 * n..][..n], overhang);
            } else {
                let spins = &spins[2 * n..3 * n];
                self.chain.spin_bushings(&self.links, spins, overhang);
            }
        }
        for s in 0..model.sprockets.len() {
            self.take_tooth_bristles(model, s, y);
            let teeth = with_law!(&model.tooth_law.pairs, Law, _pairs => {
                self.touch_teeth::<Law, ENERGY>(model, s)
            });
            self.put_tooth_bristles(model, s, rates);
            self.changed[ContactKind::Teeth as usize] |= teeth.changed;
            losses.tooth_contact += teeth.dissipated;
            losses.tooth_friction += teeth.rubbed;
            self.loads[s] = SprocketLoad {
                force: Vec2::new(teeth.force[0], teeth.force[1]),
                moment: teeth.moment,
            };
        }
    }

    /// Copy the deflections of the bristles of hinges and rollers from the state, where there are any.
    fn take_bristles(&mut self, model: &Model, y: &[f64], rates: &mut [f64]) {
        let Some(bristles) = &mut self.bristles else {
            return;
        };
        let places = &model.bristles;
        let all = &y[model.coordinates..][places.all()];
        bristles.begin(&mut rates[places.all()]);
        let hinges = places.hinges.len();
        bristles.take(ContactKind::Hinges, all, (0..hinges).map(|k| (k, k)));
        let rollers = 0..places.rollers.len();
        bristles.take(ContactKind::Rollers, all, rollers.map(|k| (k, hinges + k)));
    }

    /// Write the rates of the bristles of hinges and rollers into `rates`.
    fn put_bristles(&mut self, model: &Model, rates: &mut [f64]) {
        let Some(bristles) = &mut self.bristles else {
            return;
        };
        let places = &model.bristles;
        let rates = &mut rates[places.all()];
        let hinges = places.hinges.len();
        bristles.put(ContactKind::Hinges, rates, (0..hinges).map(|k| (k, k)));
        let rollers = 0..places.rollers.len();
        bristles.put(
            ContactKind::Rollers,
            rates,
            rollers.map(|k| (k, hinges + k)),
        );
    }

    /// Copy the deflections of the bristles of sprocket `s` from the state, where teeth have any.
    fn take_tooth_bristles(&mut self, model: &Model, s: usize, y: &[f64]) {
        if let (Some(bristles), Some(_)) = (&mut self.bristles, &model.tooth_bristles) {
            let (n, places) = (model.links, &model.bristles);
            let all = &y[model.coordinates..][places.all()];
            let first = places.teeth.start - places.hinges.start + s * n;
            let slots = self.candidates.sprockets[s].bushings(n);
            bristles.take(
                ContactKind::Teeth,
                all,
                slots.map(|(slot, k)| (slot, first + k)),
            );
        }
    }

    /// Write the rates of the bristles of sprocket `s` into `rates`.
    fn put_tooth_bristles(&mut self, model: &Model, s: usize, rates: &mut [f64]) {
        if let (Some(bristles), Some(_)) = (&mut self.bristles, &model.tooth_bristles) {
            let (n, places) = (model.links, &model.bristles);
            let rates = &mut rates[places.all()];
            let first = places.teeth.start - places.hinges.start + s * n;
            let slots = self.candidates.sprockets[s].bushings(n);
            bristles.put(
                ContactKind::Teeth,
                rates,
                slots.map(|(slot, k)| (slot, first + k)),
            );
        }
    }

    /// Write positions and velocities of the sprockets at (`t`, `y`).
    fn place_sprockets(&mut self, model: &Model, t: f64, y: &[f64]) {
        let (q, v) = y.split_at(model.coordinates);
        let angles = &mut self.chain.sprocket_angle;
        for ((sprocket, pose), place) in model
            .sprockets
            .iter()
            .zip(&mut self.poses)
            .zip(angles.iter_mut())
        {
            let ((center, velocity), (angle, spin)) =
                sprocket_motion(sprocket, t, |i| (q[i], v[i]));
            *pose = SprocketPose {
                center: center.into(),
                velocity: velocity.into(),
                angle,
                spin,
                direction: [1.0, 0.0],
            };
            *place = angle;
        }
    }

    /// Evaluate the hinges with the loop instance for the options of `model`.
    fn join_chain<L: ElasticLaw, const ENERGY: bool>(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        pair: [f64; 2],
        y: &[f64],
    ) -> ChainFound {
        let law = &model.hinge_law;
        let n = model.links;
        let (q, v) = y.split_at(model.coordinates);
        let newton = self.newton.as_mut().filter(|_| self.writes_slopes);
        let (slopes, rubs, film_slopes) = newton.map_or((None, None, None), |newton| {
            let NewtonMatrix {
                hinge_slopes,
                hinge_rubs,
                films,
                ..
            } = &mut **newton;
            (
                Some(&mut hinge_slopes[..]),
                Some(&mut hinge_rubs[..]),
                Some(&mut films[..]),
            )
        });
        let lubricant = model.hinge_film.as_ref().map(|film| FilledHinges {
            film,
            slopes: film_slopes,
        });
        let friction = model.hinge_friction.as_ref().map(|law| HingeFriction {
            law,
            pin_radius: model.pin_radius,
        });
        let bristles = bristling(
            self.bristles.as_deref_mut(),
            (ContactKind::Hinges, model.hinge_bristles.as_ref()),
            model.pin_radius,
        );
        let rubbed = friction.is_some();
        let hinges = Joints {
            pair,
            clearance: model.clearance,
            lambda: law.lambda,
            floor: model.min_approach_speed,
            inverse_onset: memory.hinge_inverse(),
            reference: &self.candidates.reference,
            slopes,
            rubs,
            friction,
            bristles,
        };
        macro_rules! join {
            ($damped:literal, $rubbed:literal, $bristled:literal, $extra:literal, $energy:expr) => {
                self.instructions.run(JoinChain::<
                    L,
                    $damped,
                    $rubbed,
                    $bristled,
                    $extra,
                    { $energy },
                > {
                    law: PhantomData,
                    hinges,
                    places: [&q[..n], &q[n..2 * n], &q[2 * n..3 * n]],
                    speeds: [&v[..n], &v[n..2 * n], &v[2 * n..3 * n]],
                    overhang: self.candidates.overhang,
                    constants: &self.links,
                    arrays: &mut self.chain,
                    lubricant,
                    compliance: self.links.compliance.as_deref(),
                })
            };
        }
        // Loops with friction always compute the dissipated power: this costs less than one more instance of each loop.
        if model.hinge_bristles.is_some() {
            join!(true, true, true, true, true)
        } else if model.has_extra() {
            join!(true, true, false, true, true)
        } else if rubbed {
            join!(true, true, false, false, true)
        } else if law.lambda > 0.0 {
            join!(true, false, false, false, ENERGY)
        } else {
            join!(false, false, false, false, false)
        }
    }

    /// Evaluate the rollers on their bushings with the loop instance for the options of `model`.
    fn join_rollers<L: ElasticLaw, const ENERGY: bool>(
        &mut self,
        model: &Model,
        of: &RollerModel,
        memory: &ImpactMemory,
        pair: [f64; 2],
        y: &[f64],
    ) -> ChainFound {
        let Some(rollers) = &mut self.rollers else {
            return ChainFound::default();
        };
        let n = model.links;
        let (q, v) = y.split_at(model.coordinates);
        let (q, v) = (&q[of.first..], &v[of.first..]);
        let newton = self.newton.as_mut().filter(|_| self.writes_slopes);
        let (slopes, rubs) = newton.map_or((None, None), |newton| {
            let NewtonMatrix {
                roller_slopes,
                roller_rubs,
                ..
            } = &mut **newton;
            (Some(&mut roller_slopes[..]), Some(&mut roller_rubs[..]))
        });
        let friction = model.hinge_friction.as_ref().map(|law| HingeFriction {
            law,
            pin_radius: of.bushing_radius,
        });
        let bristles = bristling(
            self.bristles.as_deref_mut(),
            (ContactKind::Rollers, model.hinge_bristles.as_ref()),
            of.bushing_radius,
        );
        let rubbed = friction.is_some();
        let bores = Joints {
            pair,
            clearance: of.clearance,
            lambda: of.law.lambda,
            floor: model.min_approach_speed,
            inverse_onset: memory.roller_inverse(),
            reference: &self.candidates.reference,
            slopes,
            rubs,
            friction,
            bristles,
        };
        macro_rules! join {
            ($damped:literal, $rubbed:literal, $bristled:literal, $energy:expr) => {
                self.instructions
                    .run(JoinRollers::<L, $damped, $rubbed, $bristled, { $energy }> {
                        law: PhantomData,
                        bores,
                        places: [&q[..n], &q[n..2 * n]],
                        speeds: [&v[..n], &v[n..2 * n], &v[2 * n..3 * n]],
                        overhang: self.candidates.overhang,
                        links: &self.links,
                        chain: &mut self.chain,
                        rollers,
                    })
            };
        }
        if model.hinge_bristles.is_some() {
            join!(true, true, true, true)
        } else if rubbed {
            join!(true, true, false, true)
        } else if of.law.lambda > 0.0 {
            join!(true, false, false, ENERGY)
        } else {
            join!(false, false, false, false)
        }
    }

    /// Write the accelerations of the rollers.
    fn accelerate_rollers(&mut self, model: &Model, rates: &mut [f64]) {
        let (Some(rollers), Some(of)) = (&mut self.rollers, &model.rollers) else {
            return;
        };
        let n = model.links;
        let (x, rest) = rates[of.first..].split_at_mut(n);
        let (y, rest) = rest.split_at_mut(n);
        let accelerations = [x, y, &mut rest[..n]];
        macro_rules! accelerate {
            ($rubbed:literal) => {
                self.instructions.run(AccelerateRollers::<$rubbed> {
                    arrays: &mut rollers.arrays,
                    overhang: self.candidates.overhang,
                    gravity: model.gravity.into(),
                    inverse_mass: 1.0 / of.mass,
                    inverse_inertia: 1.0 / of.inertia,
                    accelerations,
                })
            };
        }
        if model.has_friction() {
            accelerate!(true);
        } else {
            accelerate!(false);
        }
        // Missing rollers of an open chain stay at rest.
        for k in model.absent_rollers() {
            (rates[of.first + k], rates[of.first + n + k]) = (0.0, 0.0);
        }
    }

    /// Refresh the list of candidates where a displacement since its last refresh exceeds the permitted one.
    fn choose_candidates(&mut self, model: &Model, memory: &ImpactMemory, moved_squared: f64) {
        let poses = &self.poses;
        let center = |s: usize| Vec2::from(poses[s].center);
        if !self.candidates.hold(moved_squared, center) {
            let frames = poses
                .iter()
                .map(|pose| (Vec2::from(pose.center), pose.direction));
            let [x, y] = &on_teeth(&self.chain, self.rollers.as_deref()).bushing;
            self.candidates.refresh(model, memory, [x, y], frames);
            let rollers = self.rollers.as_mut().map(|rollers| &mut rollers.arrays);
            for arrays in std::iter::once(&mut self.chain).chain(rollers) {
                arrays.clear_repeated(model.links);
                self.instructions.run(RepeatBushings {
                    links: model.links,
                    overhang: self.candidates.overhang,
                    arrays,
                });
            }
        }
    }

    /// Evaluate the teeth of sprocket `s` with the loop instance for its tooth form and the options of `model`.
    fn touch_teeth<L: ElasticLaw, const ENERGY: bool>(
        &mut self,
        model: &Model,
        s: usize,
    ) -> TeethFound {
        let law = &model.tooth_law;
        let newton = self.newton.as_mut().filter(|_| self.writes_slopes);
        let (slopes, rubs) = newton.map_or((None, None), |newton| {
            let NewtonMatrix {
                tooth_slopes,
                tooth_rubs,
                ..
            } = &mut **newton;
            (Some(&mut tooth_slopes[s][..]), Some(&mut tooth_rubs[s][..]))
        });
        let friction = model.tooth_friction.as_ref().map(|law| ToothFriction {
            law,
            bushing_radius: model.contact_radius,
        });
        let bristles = bristling(
            self.bristles.as_deref_mut(),
            (ContactKind::Teeth, model.tooth_bristles.as_ref()),
            model.contact_radius,
        );
        let (links, arrays) = match &mut self.rollers {
            Some(rollers) => (&rollers.constants, &mut rollers.arrays),
            None => (&self.links, &mut self.chain),
        };
        let ToothConstants {
            form,
            keeps_stiffness,
        } = &self.teeth[self.kind[s]];
        let keeps_stiffness = *keeps_stiffness;
        macro_rules! touch {
            ($constants:expr, $damped:literal, $rubbed:literal, $bristled:literal, $energy:expr) => {
                self.instructions.run(
                    TouchTeeth::<_, L, $damped, $rubbed, $bristled, { $energy }> {
                        law: PhantomData,
                        sprocket: &model.sprockets[s],
                        constants: $constants,
                        keeps_stiffness,
                        pose: &self.poses[s],
                        lambda: law.lambda,
                        floor: model.min_approach_speed,
                        links,
                        arrays,
                        candidates: &mut self.candidates.sprockets[s],
                        slopes,
                        rubs,
                        friction,
                        bristles,
                    },
                )
            };
        }
        let bristled = model.tooth_bristles.is_some();
        match form {
            Form::Ansi(gap) if bristled => touch!(gap, true, true, true, true),
            Form::Ansi(gap) if friction.is_some() => touch!(gap, true, true, false, true),
            Form::Ansi(gap) if law.lambda > 0.0 => touch!(gap, true, false, false, ENERGY),
            Form::Ansi(gap) => touch!(gap, false, false, false, false),
            Form::Table(gap) if bristled => touch!(gap, true, true, true, true),
            Form::Table(gap) if friction.is_some() => touch!(gap, true, true, false, true),
            Form::Table(gap) if law.lambda > 0.0 => touch!(gap, true, false, false, ENERGY),
            Form::Table(gap) => touch!(gap, false, false, false, false),
        }
    }

    /// Write the accelerations of the links.
    fn accelerate_links(&mut self, model: &Model, rates: &mut [f64]) {
        let n = model.links;
        let (x, rest) = rates.split_at_mut(n);
        let (y, rest) = rest.split_at_mut(n);
        let accelerations = [x, y, &mut rest[..n]];
        macro_rules! accelerate {
            ($rubbed:literal) => {
                self.instructions.run(AccelerateLinks::<$rubbed> {
                    constants: &self.links,
                    arrays: &mut self.chain,
                    overhang: self.candidates.overhang,
                    gravity: model.gravity.into(),
                    accelerations,
                })
            };
        }
        if model.has_moments() {
            accelerate!(true);
        } else {
            accelerate!(false);
        }
    }

    /// Write the prescribed accelerations of the ends of an open chain; return the external power at the ends \[W\].
    fn move_ends(&self, ends: &OpenEnds, t: f64, rates: &mut [f64]) -> f64 {
        let n = ends.links + 2;
        for end in &ends.bodies {
            if let Some(given) = end.given_acceleration(t) {
                let i = end.body;
                (rates[i], rates[n + i], rates[2 * n + i]) = (given.x, given.y, 0.0);
            }
        }
        ends.worked_in(self.on_ends(ends), t)
    }

    /// Return the force of the chain on both ends of an open chain at the last evaluation \[N\].
    fn on_ends(&self, ends: &OpenEnds) -> [Vec2; 2] {
        ends.bodies.each_ref().map(|end| {
            let [front, rear] = [&self.chain.front_force, &self.chain.rear_force];
            let [x, y] = [0, 1].map(|axis| front[axis][end.body] + rear[axis][FIRST + end.body]);
            Vec2::new(x, y)
        })
    }

    /// Write the accelerations of the sprockets' own coordinates.
    fn accelerate_sprockets(&self, model: &Model, pawls: &[f64], t: f64, rates: &mut [f64]) {
        let moved = model.sprockets.iter().zip(&self.poses).zip(&self.loads);
        for (((sprocket, pose), load), &pawl) in moved.zip(pawls) {
            if sprocket.support == Support::Fixed
                && matches!(sprocket.rotation, Rotation::Prescribed(_))
            {
                continue;
            }
            let moves = pose.moves();
            let (center, angle) =
                sprocket_acceleration(sprocket, model.gravity, &moves, load, pawl, t);
            match sprocket.support {
                Support::Fixed => {}
                Support::Slide { index, .. } => {
                    let (_, tangent) = sprocket.slide_at(moves.center).unwrap_or_default();
                    rates[index] = center.dot(&tangent);
                }
                Support::Floating { x, y } => (rates[x], rates[y]) = (center.x, center.y),
            }
            if let Rotation::Free { index, .. } = sprocket.rotation {
                rates[index] = angle;
            }
        }
    }
}

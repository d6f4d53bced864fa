//! The right-hand side: the equations of motion over vectors of contacts, with the instructions that the machine has.
//!
//! chain (directions, ends, hinges, bushings) -> rollers, where they are bodies -> candidates -> teeth -> loads -> accelerations
//!
//! Each kernel is one law in one loop over arrays of one quantity. What a scene does not need has its own instance of the loop,
//! without it: damping, friction, the power dissipated where no energy balance is kept.

#![allow(clippy::inline_always)] // what is not inlined into a kernel does not run with its instructions

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

/// Arrays with what meets the teeth in the place of bushings: the rollers', or the chain's.
fn on_teeth<'a>(chain: &'a ChainArrays, rollers: Option<&'a Rollers>) -> &'a ChainArrays {
    rollers.map_or(chain, |rollers| &rollers.arrays)
}

/// What a loop needs of bristles, where its contacts have any.
fn bristling<'a>(
    state: Option<&'a mut BristleState>,
    (place, law): (ContactKind, Option<&'a LuGre>),
    radius: f64,
) -> Option<Bristling<'a>> {
    state
        .zip(law)
        .map(|(state, law)| state.lend(place, law, radius))
}

/// Arrays of the right-hand side and the instructions it runs with.
#[derive(Debug, Clone)]
pub(crate) struct Kernels {
    instructions: InstructionSet,
    links: LinkConstants,
    chain: ChainArrays,
    /// Where rollers are bodies of their own; then they meet the teeth.
    rollers: Option<Box<Rollers>>,
    pub(crate) candidates: Candidates,
    /// Gaps at both ends of the last step.
    pub(crate) watch: Watch,
    /// One for each kind of sprocket: identical teeth share one.
    teeth: Vec<ToothConstants>,
    /// Which of them each sprocket has.
    kind: Vec<usize>,
    poses: Vec<SprocketPose>,
    loads: Vec<SprocketLoad>,
    /// By [`ContactKind`]: whether at the last evaluation some contact had no memory, or some memory no contact.
    changed: [bool; 3],
    /// Newton's matrix, once it is asked for.
    newton: Option<Box<NewtonMatrix>>,
    /// Where friction is that of bristles.
    bristles: Option<Box<BristleState>>,
    /// Whether evaluations write the slopes that it is made from.
    writes_slopes: bool,
    /// Scratch: bushings that are seated on one sprocket.
    seated: Vec<Seated>,
}

impl Kernels {
    /// Arrays for `model`.
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

    /// Makes the room for Newton's matrix.
    pub(crate) fn make_room_for_newton(&mut self, model: &Model) {
        if self.newton.is_none() {
            self.newton = Some(Box::new(NewtonMatrix::new(model)));
        }
    }

    /// Lets the next evaluations write the slopes of all forces for [`Self::factorise`], or not.
    pub(crate) fn write_slopes(&mut self, write: bool) {
        self.writes_slopes = write;
    }

    /// Factorises Newton's matrix of the last evaluation, which wrote slopes; false when it is singular, or not definite and not
    /// allowed to be `indefinite`.
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

    /// Overwrites a residual of velocities by the correction that the last matrix asks for.
    pub(crate) fn correct(&mut self, model: &Model, residual: &mut [f64]) {
        if let Some(newton) = &mut self.newton {
            newton.correct(model, self.instructions, residual);
        }
    }

    /// Lets evaluations solve for bristles in an implicit step, from what is predicted of their deflections, with γ; nothing: no more.
    pub(crate) fn solve_for_bristles(&mut self, step: Option<(&[f64], f64)>) {
        match (&mut self.bristles, step) {
            (Some(bristles), Some((predicted, gamma))) => {
                bristles.begin_implicit_stage(predicted, gamma);
            }
            (Some(bristles), None) => bristles.end_implicit_stage(),
            (None, _) => {}
        }
    }

    /// The deflections that the last evaluation of an implicit step solved for \[m\].
    pub(crate) fn solved_bristles(&self) -> &[f64] {
        (self.bristles.as_ref()).map_or(&[], |bristles| bristles.solved())
    }

    /// Goes on with other instructions.
    pub(crate) fn use_instructions(&mut self, instructions: InstructionSet) {
        self.instructions = instructions;
    }

    /// The instructions in use.
    pub(crate) fn instructions(&self) -> InstructionSet {
        self.instructions
    }

    /// Whether at the last evaluation some contact had no memory, or some memory no contact.
    pub(crate) fn changed(&self) -> bool {
        self.changed.contains(&true)
    }

    /// Where that was, by [`ContactKind`].
    pub(crate) fn changes(&self) -> [bool; 3] {
        self.changed
    }

    /// Place and motion of sprocket `s` at the last evaluation.
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

    /// Depth of every hinge at the last evaluation \[m\]; zero where apart.
    pub(crate) fn hinge_depths(&self, model: &Model) -> &[f64] {
        &self.chain.depth[..model.links]
    }

    /// Depth of every bushing in its roller at the last evaluation \[m\]; zero where apart.
    pub(crate) fn roller_depths(&self, model: &Model) -> &[f64] {
        let rollers = self.rollers.as_ref();
        rollers.map_or(&[], |rollers| &rollers.arrays.depth[..model.links])
    }

    /// Normal force of bushing `k` in its roller at the last evaluation \[N\].
    pub(crate) fn roller_force(&self, k: usize) -> f64 {
        let rollers = self.rollers.as_ref();
        rollers.map_or(0.0, |rollers| rollers.arrays.force[k])
    }

    /// Normal force of hinge `k` at the last evaluation \[N\].
    pub(crate) fn hinge_force(&self, k: usize) -> f64 {
        self.chain.force[k]
    }

    /// Sprocket, bushing, depth \[m\] and normal force \[N\] of every candidate at the last evaluation.
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

    /// Centre of bushing `k` at the last evaluation \[m\], or of its roller.
    fn place_on_teeth(&self, k: usize) -> Vec2 {
        let [x, y] = &on_teeth(&self.chain, self.rollers.as_deref()).bushing;
        Vec2::new(x[k], y[k])
    }

    /// Looks for jumps over the teeth of any sprocket at the last evaluation, that of time `t` \[s\].
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

    /// Watches all contacts at the end of a step of `length` \[s\], where the last evaluation was.
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
            let center_speed = Vec2::from(pose.velocity).norm();
            rim = rim.max(center_speed + pose.spin.abs() * model.sprockets[s].reach);
        }
        watched.speed += rim;
        watched
    }

    /// Writes the accelerations at (`t`, `y`) into `rates`, coordinate by coordinate; returns the powers when energy is kept.
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

    /// The same with sprockets that are placed already.
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

    /// Hinges and rollers at `y`: the largest squared distance of what meets the teeth from its reference \[m²\], and the losses.
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

    /// Teeth at `y`, after hinges and rollers, which have moved by so much; adds their losses.
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

    /// Takes the deflections of hinges' and rollers' bristles, where there are any.
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

    /// Puts their rates beside the accelerations.
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

    /// Takes the deflections of the bristles of sprocket `s`, where teeth have any.
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

    /// Puts their rates beside the accelerations.
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
        // Friction comes with its power whether it is asked for or not: that costs less than one more instance of each loop.
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
        // Rollers that are none stay where they are.
        for k in model.absent_rollers() {
            (rates[of.first + k], rates[of.first + n + k]) = (0.0, 0.0);
        }
    }

    /// Makes the list of candidates again when something has moved too far for it.
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

    /// Lets the ends of an open chain move as they are told; returns the power that this takes \[W\].
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

    /// Force of the chain on both ends of an open one at the last evaluation \[N\].
    fn on_ends(&self, ends: &OpenEnds) -> [Vec2; 2] {
        ends.bodies.each_ref().map(|end| {
            let [front, rear] = [&self.chain.front_force, &self.chain.rear_force];
            let [x, y] = [0, 1].map(|axis| front[axis][end.body] + rear[axis][FIRST + end.body]);
            Vec2::new(x, y)
        })
    }

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

//! The right-hand side: equations of motion in SIMD kernels over vectors of contacts, for the instruction set of the machine.
//!
//! chain (directions, ends, hinges, bushings) -> rollers, where they are bodies -> candidates -> teeth -> loads -> accelerations
//!
//! Each kernel is one loop over arrays, one array per quantity. Damping and friction are constant parameters of a loop: a model without
//! them runs an instance of the loop without them. The form of the elastic law is chosen once per vector.

#![allow(clippy::inline_always)] // a function that is not inlined is compiled without the kernel's instruction set

mod accelerations;
mod ansi_gap;
mod bristles;
mod chain;
mod contact_states;
mod event_screening;
pub(crate) mod gap;
mod ideal_hinges;
mod implicit;
mod link_accelerations;
mod loops;
mod readout;
mod surface_table;
mod teeth;
mod tooth_constants;

use crate::chain::arrays::layout::{ChainArrays, LinkConstants};
use crate::chain::arrays::pose::SprocketPose;
use bristles::{BristleState, ContactKind};
use chain::Rollers;
pub(crate) use event_screening::EventScreening;
use ideal_hinges::IdealHinges;
pub(crate) use readout::ToothReadings;
use tooth_constants::ToothConstants;

use crate::chain::contact::{Candidates, ImpactMemory, Seated};
use crate::chain::loads::{SprocketLoad, outside_powers};
use crate::chain::model::{Model, OpenEnds};
use crate::chain::motion::sprocket_motion;
use crate::chain::newton::NewtonMatrix;
use crate::chain::powers::{Losses, Powers};
use crate::geometry::Vec2;
use crate::math::simd::{InstructionSet, Numbers, padded_zeros};

/// Return the arrays of the bodies on the teeth: the rollers', or the chain's.
fn on_teeth<'a>(chain: &'a ChainArrays, rollers: Option<&'a Rollers>) -> &'a ChainArrays {
    rollers.map_or(chain, |rollers| &rollers.arrays)
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
    pub(crate) screening: EventScreening,
    /// Scratch for the event screening: slots of a sprocket.
    spare_slots: Numbers,
    /// Constants of the teeth, one per kind of sprocket: sprockets with identical teeth share them.
    teeth: Vec<ToothConstants>,
    /// Index of the constants of each sprocket.
    kind: Vec<usize>,
    poses: Vec<SprocketPose>,
    loads: Vec<SprocketLoad>,
    /// Power dissipated in contacts at the last evaluation, where powers are kept \[W\].
    losses: Losses,
    /// By [`ContactKind`]: whether the contact states of the last evaluation differ from the impact velocity memory. Either a
    /// contact has no memory, or a memory has no contact.
    changed: [bool; 3],
    /// Largest squared speed of a bushing, or of a roller, at the last evaluation \[m²/s²\].
    speed_squared: f64,
    /// Start of the present step \[s\], infinite before the first one: prescribed accelerations at a row of a table are those of its side.
    step_start: f64,
    /// Newton's matrix, allocated on request.
    newton: Option<Box<NewtonMatrix>>,
    /// Ideal hinges, where hinges have no clearance.
    pub(crate) ideal: Option<Box<IdealHinges>>,
    /// Bristles, where friction is modelled by them.
    bristles: Option<Box<BristleState>>,
    /// Whether evaluations write the slopes for Newton's matrix.
    writes_slopes: bool,
    /// Whether evaluations compute the powers of all forces.
    keeps_powers: bool,
    /// Whether evaluations write the gaps of the candidates for the event screening.
    writes_gaps: bool,
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
            screening: EventScreening::new(model),
            spare_slots: padded_zeros(Candidates::most_slots(model)),
            teeth,
            kind,
            poses: vec![SprocketPose::default(); sprockets],
            loads: vec![SprocketLoad::default(); sprockets],
            losses: Losses::default(),
            changed: [true; 3],
            speed_squared: 0.0,
            step_start: f64::INFINITY,
            newton: (model.hinges.ideal).then(|| Box::new(NewtonMatrix::new(model))),
            ideal: IdealHinges::of(model).map(Box::new),
            bristles: BristleState::of(model, Candidates::most_slots(model)).map(Box::new),
            writes_slopes: false,
            keeps_powers: false,
            writes_gaps: true,
            seated: Vec::with_capacity(model.links),
        }
    }

    /// Set the instruction set.
    pub(crate) fn use_instructions(&mut self, instructions: InstructionSet) {
        self.instructions = instructions;
    }

    /// Return the instruction set.
    pub(crate) fn instructions(&self) -> InstructionSet {
        self.instructions
    }

    /// Begin a step at `t` \[s\].
    pub(crate) fn begin_step(&mut self, t: f64) {
        self.step_start = t;
    }

    /// Switch on or off the powers of all forces for the next evaluations.
    pub(crate) fn keep_powers(&mut self, keep: bool) {
        self.keeps_powers = keep;
    }

    /// Switch on or off the gaps for the event screening for the next evaluations; return what it was.
    pub(crate) fn write_gaps(&mut self, write: bool) -> bool {
        std::mem::replace(&mut self.writes_gaps, write)
    }

    /// Write the accelerations at (`t`, `y`) into `accelerations`, coordinate by coordinate.
    pub(crate) fn accelerations(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        t: f64,
        y: &[f64],
        accelerations: &mut [f64],
    ) {
        self.place_sprockets(model, t, y);
        self.accelerate_placed(model, memory, t, y, accelerations);
    }

    /// Evaluate as [`Self::accelerations`] with sprockets that are positioned already.
    fn accelerate_placed(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        t: f64,
        y: &[f64],
        accelerations: &mut [f64],
    ) {
        self.evaluate_forces(model, memory, y, accelerations);
        self.put_bristles(model, accelerations);
        self.accelerate_links(model, accelerations);
        self.accelerate_rollers(model, accelerations);
        if let Some(ends) = &model.ends {
            self.move_ends(ends, t, accelerations);
        }
        self.accelerate_sprockets(model, &memory.pawls, t, accelerations);
        self.close_hinges(model, &memory.pawls, (t, y), accelerations);
    }

    /// Return the powers at (`t`, `y`). `bristle_rates` as for [`Self::evaluate_joints`].
    ///
    /// Accelerations are left out, but where ideal hinges move with an end: they give the force on it.
    pub(crate) fn powers(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        t: f64,
        y: &[f64],
        bristle_rates: &mut [f64],
    ) -> Powers {
        self.place_sprockets(model, t, y);
        self.keep_powers(true);
        let writes_gaps = self.write_gaps(false);
        if self.ideal.is_some() && model.ends.as_ref().is_some_and(OpenEnds::are_moved) {
            self.take_hinge_forces(false);
            self.accelerate_placed(model, memory, t, y, bristle_rates);
        } else {
            self.evaluate_forces(model, memory, y, bristle_rates);
        }
        self.write_gaps(writes_gaps);
        self.last_powers(model, t, y)
    }

    /// Evaluate the forces of all contacts at `y`, and the losses where powers are kept.
    fn evaluate_forces(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        y: &[f64],
        bristle_rates: &mut [f64],
    ) {
        let moved_squared = self.evaluate_joints(model, memory, y, bristle_rates);
        self.evaluate_all_teeth(model, memory, (y, moved_squared), bristle_rates);
    }

    /// Return all powers at (`t`, `y`): those of the contacts at the last evaluation, at the same time and with powers, and those of moving
    /// ends, motors, applied torques, tensioners and dashpots.
    pub(crate) fn last_powers(&self, model: &Model, t: f64, y: &[f64]) -> Powers {
        let mut powers = Powers::of(self.losses);
        let [dissipated, external] = self.outside_powers(model, t, y);
        powers.dissipated += dissipated;
        powers.external_work += external;
        powers
    }

    /// Return the power dissipated in dashpots, and the external power: those of [`Self::last_powers`] that are not of contacts.
    fn outside_powers(&self, model: &Model, t: f64, y: &[f64]) -> [f64; 2] {
        let mut dissipated = 0.0;
        let mut external =
            (model.ends.as_ref()).map_or(0.0, |ends| ends.external_work(self.on_ends(ends), t));
        let speeds = &y[model.coordinates..];
        for ((sprocket, pose), load) in model.sprockets.iter().zip(&self.poses).zip(&self.loads) {
            let of = outside_powers(sprocket, load, (speeds, pose.spin), t);
            dissipated += of[0];
            external += of[1];
        }
        [dissipated, external]
    }

    /// Evaluate hinges and rollers at `y`, and their losses; return the largest squared distance of the bodies on the teeth from their
    /// references \[m²\]. `bristle_rates` is the array of all accelerations, of which only the rates of the bristles are written.
    fn evaluate_joints(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        y: &[f64],
        bristle_rates: &mut [f64],
    ) -> f64 {
        self.take_bristles(model, y, bristle_rates);
        if model.has_moments() {
            self.chain.clear_moments();
            if let Some(rollers) = &mut self.rollers {
                rollers.arrays.clear_moments();
            }
        }
        let chain = self.evaluate_hinges(model, memory, y);
        self.push_by_hinges();
        if let Some(ends) = &model.ends {
            self.chain.forget_open_hinges(ends);
        }
        self.turn_sprockets();
        let rolling = model.rollers.as_ref().map(|of| {
            if model.hinges.has_friction() {
                let spins = &y[model.coordinates + 2 * model.links..][..model.links];
                self.chain.spin_bushings(&self.links, spins, 0);
            }
            self.evaluate_rollers(model, of, memory, y)
        });
        if let (Some(rollers), Some(_)) = (&mut self.rollers, &model.ends) {
            rollers.arrays.forget_absent_rollers(model);
        }
        let rollers_changed = rolling.is_some_and(|found| found.changed);
        self.changed = [chain.changed, rollers_changed, false];
        self.losses = Losses {
            hinge_contact: chain.dissipated,
            hinge_friction: chain.friction_power,
            roller_contact: rolling.map_or(0.0, |found| found.dissipated),
            roller_friction: rolling.map_or(0.0, |found| found.friction_power),
            hinge_film: chain.film_power,
            ..Losses::default()
        };
        let moved_squared = rolling.map_or(chain.moved_squared, |found| found.moved_squared);
        self.speed_squared = rolling.map_or(chain.speed_squared, |found| {
            found.speed_squared.max(chain.speed_squared)
        });
        moved_squared
    }

    /// Evaluate the teeth at `y`, and their losses, after hinges and rollers, with the squared distance that [`Self::evaluate_joints`]
    /// returns.
    fn evaluate_all_teeth(
        &mut self,
        model: &Model,
        memory: &ImpactMemory,
        (y, moved_squared): (&[f64], f64),
        bristle_rates: &mut [f64],
    ) {
        self.choose_candidates(model, memory, moved_squared);
        self.spin_bushings(model, y);
        for s in 0..model.sprockets.len() {
            self.evaluate_teeth_of(model, s, y, bristle_rates);
        }
    }

    /// Write the angular velocities of the bodies on the teeth, where teeth have friction.
    fn spin_bushings(&mut self, model: &Model, y: &[f64]) {
        if model.teeth.has_friction() {
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
    }

    /// Evaluate the teeth of sprocket `s` at `y`.
    fn evaluate_teeth_of(&mut self, model: &Model, s: usize, y: &[f64], bristle_rates: &mut [f64]) {
        self.take_tooth_bristles(model, s, y);
        let teeth = self.evaluate_teeth(model, s);
        self.put_tooth_bristles(model, s, bristle_rates);
        self.changed[ContactKind::Teeth as usize] |= teeth.changed;
        self.losses.tooth_contact += teeth.dissipated;
        self.losses.tooth_friction += teeth.friction_power;
        self.loads[s] = SprocketLoad {
            force: Vec2::new(teeth.force[0], teeth.force[1]),
            moment: teeth.moment,
        };
    }

    /// Write the directions of the sprockets, which the loop over the hinges computes.
    fn turn_sprockets(&mut self) {
        for (s, pose) in self.poses.iter_mut().enumerate() {
            pose.direction = [self.chain.sprocket_cos[s], self.chain.sprocket_sin[s]];
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
}

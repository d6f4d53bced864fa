//! Equations of motion: contacts -> forces -> accelerations.
//!
//! A chain drive has no ideal joints and therefore no constraints: accelerations are forces divided by masses. The only linear system is
//! that of the implicit corrector.

mod bristles;
mod checkpoint;
mod energy;
mod energy_quadrature;
mod implicit;
mod in_step_events;
mod inputs;
mod loads;
mod output_request;
mod powers;
mod rollback;
mod start_checks;
mod system;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub use bristles::{Bristles, Stored};
pub use checkpoint::Checkpoint;
use energy_quadrature::StepEnds;
use inputs::Inputs;
pub use loads::SprocketLoad;
pub(crate) use loads::{Moves, outside_powers, sprocket_acceleration};
pub(crate) use output_request::{Needs, Want};
pub use powers::{Losses, Powers};
#[cfg(feature = "python")]
pub(crate) use start_checks::check_rows;
pub(crate) use start_checks::check_start;

use crate::chain::contact::{
    HingePath, ImpactMemory, RollerPath, ToothJump, ToothJumps, ToothPath,
};
use crate::chain::model::Model;
use crate::chain::motion::Motion;
use crate::chain::report::{Accelerations, HingeContacts, Reader, RollerContacts, ToothContacts};
use crate::chain::rhs::Kernels;
use crate::force_law::{Elastic, Regions, with_law};
use crate::geometry::Surface;
use crate::integrator::event_location::first_crossing;
use crate::integrator::{Adams, OdeSystem, Step};
use crate::math::simd::{InstructionSet, padded};
pub use crate::system::Energy;
use crate::system::EnergyQuadrature;

/// Dynamics of a drive: right-hand side for the integrator, and the impact velocity memory of its contacts.
///
/// State: y = [q, dq/dt].
#[derive(Debug, Clone)]
pub struct Dynamics {
    model: Arc<Model>,
    /// Impact velocity memory of the contacts; written between steps only.
    pub memory: ImpactMemory,
    /// Motion of all bodies at the last evaluation.
    pub motion: Motion,
    /// Hinges at the last evaluation.
    pub hinges: HingeContacts,
    /// Rollers on their bushings at the last evaluation.
    pub rollers: RollerContacts,
    /// Teeth at the last evaluation.
    pub teeth: ToothContacts,
    /// Bristles at the last evaluation.
    pub bristles: Bristles,
    /// Accelerations at the last evaluation.
    pub accelerations: Accelerations,
    kernels: Kernels,
    /// Kernels for reports, separate from those of the steps.
    reader: Box<Reader>,
    keeps_energy: bool,
    /// Powers at the last evaluation of the right-hand side, with energy metering on.
    powers: Powers,
    quadrature: EnergyQuadrature<Powers>,
    inputs: Inputs,
    /// Both ends of the metered step, or the start of the next one.
    ends: StepEnds,
    /// Pairs that ended their contact in the last step; their memory remains until the next step, for reports inside the last one.
    parted: Vec<Pair>,
    /// Whether event screening found a pair that may have touched or separated inside the last step.
    turned: bool,
    /// Upper bound on the speeds of bushings relative to teeth at the end of the last step \[m/s\].
    fastest: f64,
    /// Number of accepted contacts inside steps whose penetration was within the accuracy.
    unseen_touches: u64,
    /// Scratch: tooth contacts with an onset in the last step, as (sprocket, bushing).
    begun: Vec<(usize, usize)>,
    /// Scratch: derivative of the state.
    slope: Vec<f64>,
    /// Scratch: state inside a step, padded.
    inside: Vec<f64>,
    /// Message on the first hinge or roller beyond the end of its law.
    hinge_past_range: Option<String>,
    /// Message on the first tooth contact beyond the end of its law.
    tooth_past_range: Option<String>,
    /// Seatings of the chain, and jumps over teeth.
    tooth_jumps: ToothJumps,
    /// Number of candidate lists built at the last search for tooth jumps.
    jumps_looked_for: u64,
}

/// Contact pair: hinge, bushing and roller, or bushing and sprocket (sprocket · links + bushing).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum Pair {
    Hinge(usize),
    Roller(usize),
    Tooth(usize),
}

impl Dynamics {
    /// Create the dynamics of `model`.
    #[must_use]
    pub fn new(model: Arc<Model>) -> Self {
        let (links, sprockets) = (model.links, model.sprockets.len());
        Self {
            memory: ImpactMemory::new(
                links,
                model.roller_count(),
                links * sprockets,
                model.min_approach_speed,
            ),
            motion: Motion::new(model.bodies()),
            hinges: HingeContacts::new(links),
            rollers: RollerContacts::new(model.roller_count()),
            teeth: ToothContacts::new(links, sprockets),
            bristles: Bristles::of(&model),
            accelerations: Accelerations::new(model.bodies(), sprockets),
            kernels: Kernels::new(&model),
            reader: Box::new(Reader::new(&model)),
            keeps_energy: false,
            powers: Powers::default(),
            quadrature: EnergyQuadrature::new(),
            inputs: Inputs::new(&model),
            ends: StepEnds::new(2 * model.coordinates),
            parted: Vec::with_capacity(links * (1 + sprockets) + model.roller_count()),
            turned: false,
            fastest: 0.0,
            unseen_touches: 0,
            slope: vec![0.0; 2 * model.coordinates],
            inside: vec![0.0; padded(2 * model.coordinates)],
            begun: Vec::with_capacity(links * sprockets),
            hinge_past_range: None,
            tooth_past_range: None,
            tooth_jumps: ToothJumps::new(&model),
            jumps_looked_for: 0,
            model,
        }
    }

    /// Return the model.
    #[must_use]
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// Return whether energy metering is on.
    #[must_use]
    pub fn keeps_energy(&self) -> bool {
        self.keeps_energy
    }

    /// Switch energy metering on or off: powers, and with them the sums of the energy balance.
    pub fn keep_energy(&mut self, keep: bool) {
        self.keeps_energy = keep;
        self.powers = Powers::default();
    }

    /// Return the powers at the last evaluation of the right-hand side with energy metering.
    #[must_use]
    pub fn powers(&self) -> Powers {
        self.powers
    }

    /// Return the hinges, and the pairs of bushing and sprocket, whose contact ended in the last step.
    ///
    /// Their memory is cleared at the beginning of the next step.
    #[must_use]
    pub fn parted(&self) -> (Vec<usize>, Vec<usize>) {
        let mut parted = (Vec::new(), Vec::new());
        for pair in &self.parted {
            match *pair {
                Pair::Hinge(k) => parted.0.push(k),
                Pair::Tooth(pair) => parted.1.push(pair),
                Pair::Roller(_) => {}
            }
        }
        parted
    }

    /// Return the bushings whose contact with their roller ended in the last step.
    #[must_use]
    pub fn parted_rollers(&self) -> Vec<usize> {
        let roller = |pair: &Pair| match *pair {
            Pair::Roller(k) => Some(k),
            _ => None,
        };
        self.parted.iter().filter_map(roller).collect()
    }

    /// Evaluate contacts, forces and accelerations at (`t`, `y`), and return the powers.
    pub fn evaluate(&mut self, t: f64, y: &[f64]) -> Powers {
        self.motion.read(&self.model, t, y);
        self.bristles.read(&self.model, y);
        self.reader.state.copy_from_slice(y);
        self.evaluate_state(t)
    }

    /// Evaluate the same for the present motion and bristles.
    pub fn evaluate_motion(&mut self, t: f64) -> Powers {
        self.motion.write(&self.model, &mut self.reader.state);
        self.bristles.write(&self.model, &mut self.reader.state);
        self.evaluate_state(t)
    }

    /// Evaluate the reader's state with a new candidate list, valid for any positions of the bodies.
    fn evaluate_state(&mut self, t: f64) -> Powers {
        let Reader {
            kernels,
            state,
            rates,
            ..
        } = &mut *self.reader;
        let (model, memory, place) = (&self.model, &self.memory, (&self.motion, t));
        kernels.candidates.invalidate();
        let powers = if self.keeps_energy {
            kernels.evaluate_placed::<true>(model, memory, place, state, rates)
        } else {
            kernels.evaluate_placed::<false>(model, memory, place, state, rates);
            Powers::default()
        };
        self.accelerations.on_ends = kernels.forces_on_ends(model).unwrap_or_default();
        self.accelerations
            .chain
            .copy_from_slice(kernels.sprocket_loads());
        self.accelerations
            .read(model, &self.motion, rates, &memory.pawls, t);
        self.read_hinges();
        self.read_teeth();
        powers
    }

    /// Evaluate the outputs requested by `needs` at (`t`, `y`). Other outputs are undefined afterwards.
    pub(crate) fn evaluate_for(&mut self, needs: Needs, t: f64, y: &[f64]) {
        self.motion.read(&self.model, t, y);
        if needs.hinges == Want::Nothing && needs.teeth == Want::Nothing {
            return;
        }
        self.bristles.read(&self.model, y);
        let Reader { kernels, rates, .. } = &mut *self.reader;
        let teeth = needs.teeth != Want::Nothing;
        if teeth {
            kernels.candidates.copy(&self.kernels.candidates);
        }
        kernels.evaluate_contacts(&self.model, &self.memory, &self.motion, (y, rates), teeth);
        if needs.sprocket_loads {
            self.accelerations
                .chain
                .copy_from_slice(kernels.sprocket_loads());
        }
        if needs.hinges != Want::Nothing {
            self.read_hinges();
        }
        if teeth {
            self.read_teeth();
        }
    }

    /// Copy hinges, rollers and bristles from the last evaluation of the reader.
    fn read_hinges(&mut self) {
        let (model, kernels) = (&self.model, &self.reader.kernels);
        let chain = kernels.chain();
        self.motion.cos[..model.links].copy_from_slice(&chain.cos[..model.links]);
        self.motion.sin[..model.links].copy_from_slice(&chain.sin[..model.links]);
        self.hinges.read(model, &self.motion, chain);
        self.rollers
            .read(model, &self.motion, &self.hinges, kernels.rollers());
        let rates = &self.reader.rates[model.bristles.all()];
        self.bristles.rate.copy_from_slice(rates);
    }

    /// Copy the tooth contacts from the last evaluation of the reader.
    fn read_teeth(&mut self) {
        let Reader {
            kernels, readings, ..
        } = &mut *self.reader;
        self.teeth.clear();
        for s in 0..self.model.sprockets.len() {
            let candidates = kernels.read_teeth(s, readings);
            self.teeth.read(&self.model, s, candidates, readings);
        }
    }

    /// Start the memory of every pair in contact at (`t`, `y`), with its present penetration rate, for an initial configuration.
    pub fn remember_present_contacts(&mut self, t: f64, y: &[f64]) {
        self.memory.clear();
        self.follow_with_pawls(y);
        self.evaluate(t, y);
        for k in 0..self.model.links {
            if self.hinges.penetration[k] > 0.0 {
                self.memory.begin_hinge(k, self.hinges.rate[k]);
            }
        }
        for k in 0..self.model.roller_count() {
            if self.rollers.penetration[k] > 0.0 {
                self.memory.begin_roller(k, self.rollers.rate[k]);
            }
        }
        for &pair in &self.teeth.near {
            let pair = pair as usize;
            if self.teeth.penetration[pair] > 0.0 {
                self.memory
                    .begin_tooth(pair, self.teeth.rate[pair], self.teeth.surface[pair]);
            }
        }
        self.kernels.candidates.invalidate();
        // Event screening needs the gaps at the start of the first step.
        self.differentiate(t, y);
        self.fastest = self.kernels.watch(&self.model, 0.0).speed;
        self.kernels.watch.advance();
        self.look_for_jumps(t);
    }

    /// Advance the pawls of all ratchets behind the teeth that passed in the last step, whose end is `y`.
    ///
    /// Call before the next step: reports inside the last step use the previous positions of the pawls.
    pub(crate) fn follow_with_pawls(&mut self, y: &[f64]) {
        let sprockets = self.model.sprockets.iter().zip(&mut self.memory.pawls);
        for (sprocket, pawl) in sprockets {
            if let Some((ratchet, s)) = sprocket.ratchet_at(y) {
                *pawl = ratchet.follow(*pawl, s);
            }
        }
    }

    /// Clear the memory of contacts that ended in the last step; call before the next step.
    pub fn begin_step(&mut self) {
        for pair in self.parted.drain(..) {
            match pair {
                Pair::Hinge(k) => self.memory.end_hinge(k),
                Pair::Roller(k) => self.memory.end_roller(k),
                Pair::Tooth(pair) => {
                    self.memory.end_tooth(pair);
                    let (s, k) = (pair / self.model.links, pair % self.model.links);
                    self.kernels
                        .candidates
                        .update_memory(&self.model, &self.memory, s, k);
                }
            }
        }
    }

    /// Locate the contact onsets of the last step and record their initial impact velocities.
    ///
    /// Call after the step, before another evaluation of the right-hand side.
    pub fn finish_step(&mut self, adams: &Adams, step: &Step) {
        let [hinges, rollers, teeth] = self.kernels.changes();
        if hinges {
            self.find_hinge_onsets(adams, step);
        }
        if rollers {
            self.find_roller_onsets(adams, step);
        }
        if teeth {
            self.find_tooth_onsets(adams, step);
        }
        if std::mem::take(&mut self.turned) {
            self.look_inside(adams, step);
        }
        self.kernels.watch.advance();
        self.watch_ranges(adams);
        // Steps are far shorter than a gap. After a displacement of more than half a pitch, the number of passed teeth is ambiguous.
        let farthest = self.fastest * (step.end - step.start);
        if farthest.is_nan() || farthest > self.model.half_pitch {
            self.tooth_jumps.lose_seatings();
        } else if self.jumps_looked_for != self.candidate_refreshes() {
            self.look_for_jumps(step.end);
        }
    }

    /// Search for tooth jumps at the last evaluation, at time `t` \[s\].
    ///
    /// A bushing that has changed gaps has moved by more than the margin of the candidate list relative to its sprocket. The search is
    /// therefore necessary only after the list was built again.
    fn look_for_jumps(&mut self, t: f64) {
        self.jumps_looked_for = self.candidate_refreshes();
        let jumps = &mut self.tooth_jumps;
        self.kernels.look_for_jumps(&self.model, t, jumps);
    }

    /// Return the tooth jumps since the start of the run, in the order of time.
    #[must_use]
    pub fn tooth_jumps(&self) -> &[ToothJump] {
        self.tooth_jumps.jumps()
    }

    /// Record contact onsets and ends of hinges in the last step.
    fn find_hinge_onsets(&mut self, adams: &Adams, step: &Step) {
        let model = &self.model;
        // Penetration without memory: contact onset in this step. Memory without penetration: contact end.
        for (k, &depth) in self.kernels.hinge_depths(model).iter().enumerate() {
            let touching = depth > 0.0;
            if touching == (self.memory.hinge_speed()[k] > 0.0) {
                continue;
            }
            if touching {
                let path = HingePath::new(model, adams, k);
                let (_, rate) = first_crossing(|t| path.at(t), step.start, step.end);
                self.memory.begin_hinge(k, rate);
            } else {
                self.parted.push(Pair::Hinge(k));
            }
        }
    }

    /// Record contact onsets and ends of bushings in their rollers in the last step.
    fn find_roller_onsets(&mut self, adams: &Adams, step: &Step) {
        let model = &self.model;
        for (k, &depth) in self.kernels.roller_depths(model).iter().enumerate() {
            let touching = depth > 0.0;
            if touching == (self.memory.roller_speed()[k] > 0.0) {
                continue;
            }
            if !touching {
                self.parted.push(Pair::Roller(k));
            } else if let Some(path) = RollerPath::new(model, adams, k) {
                let (_, rate) = first_crossing(|t| path.at(t), step.start, step.end);
                self.memory.begin_roller(k, rate);
            }
        }
    }

    /// Record contact onsets, with their surfaces, and contact ends of teeth in the last step.
    fn find_tooth_onsets(&mut self, adams: &Adams, step: &Step) {
        let model = &self.model;
        let mut begun = std::mem::take(&mut self.begun);
        for (s, k, depth, _) in self.kernels.tooth_contacts(model) {
            let pair = s * model.links + k;
            let touching = depth > 0.0;
            if touching == (self.memory.tooth_speed[pair] > 0.0) {
                continue;
            }
            if touching {
                let path = ToothPath::new(model, adams, k, s);
                let contact = |t| path.at(t).contact;
                let (t, rate) = first_crossing(contact, step.start, step.end);
                self.memory.begin_tooth(pair, rate, path.at(t).surface);
                begun.push((s, k));
            } else {
                self.parted.push(Pair::Tooth(pair));
            }
        }
        for (s, k) in begun.drain(..) {
            self.kernels
                .candidates
                .update_memory(model, &self.memory, s, k);
        }
        self.begun = begun;
    }

    /// Record the first joint and the first tooth contact beyond the end of their law at the end of a step.
    fn watch_ranges(&mut self, adams: &Adams) {
        let model = &self.model;
        if self.hinge_past_range.is_none() {
            let hinges = self.kernels.hinge_depths(model);
            let rollers = self.kernels.roller_depths(model);
            self.hinge_past_range = self.joint_past_its_end(hinges, rollers);
        }
        let model = &self.model;
        if model.teeth.law.elastic.has_an_end() && self.tooth_past_range.is_none() {
            let nearest_end = with_law!(&model.teeth.law.pairs, Law, pairs => {
                pairs.iter().map(range_end::<Law>).fold(f64::INFINITY, f64::min)
            });
            let beyond = |(_, _, depth, _): (usize, usize, f64, f64)| depth > nearest_end;
            if self.kernels.tooth_contacts(model).any(beyond) {
                self.evaluate(adams.time(), adams.y());
                self.tooth_past_range = self.tooth_past_its_end();
            }
        }
    }

    /// Record the same for the last evaluation, that of a report with `needs`: penetrations inside a step may exceed those at its ends.
    pub(crate) fn watch_reported_ranges(&mut self, needs: Needs) {
        if needs.hinges != Want::Nothing && self.hinge_past_range.is_none() {
            let (hinges, rollers) = (&self.hinges.penetration, &self.rollers.penetration);
            self.hinge_past_range = self.joint_past_its_end(hinges, rollers);
        }
        if needs.teeth != Want::Nothing
            && self.tooth_past_range.is_none()
            && self.model.teeth.law.elastic.has_an_end()
        {
            self.tooth_past_range = self.tooth_past_its_end();
        }
    }

    /// Return a message on the first hinge, or bushing in its roller, beyond the end of its law.
    fn joint_past_its_end(&self, hinges: &[f64], rollers: &[f64]) -> Option<String> {
        let model = &self.model;
        let law = &model.hinges.law;
        if law.elastic.has_an_end() {
            let (end, force) = with_law!(&law.pairs, Law, pairs => {
                let end = range_end::<Law>(&pairs[0]);
                (end, force_at::<Law>(&pairs[0], end))
            });
            let end_of = |k: usize| {
                end + model
                    .hinges
                    .compliance_at(k)
                    .map_or(0.0, |given| given * force)
            };
            // Elastic plates in series: the total approach at the end of the law is δ_end + C f(δ_end).
            if let Some(k) = (0..hinges.len()).find(|&k| hinges[k] > end_of(k)) {
                let name = format!("hinge {}", k + 1);
                return Some(past_range(law.elastic, &name, hinges[k], end_of(k)));
            }
        }
        let law = &model.rollers.as_ref()?.law;
        if !law.elastic.has_an_end() {
            return None;
        }
        let end = with_law!(&law.pairs, Law, pairs => range_end::<Law>(&pairs[0]));
        let k = rollers.iter().position(|&depth| depth > end)?;
        let name = format!("bushing {0} in roller {0}", k + 1);
        Some(past_range(law.elastic, &name, rollers[k], end))
    }

    /// Return a message on the first tooth contact of the last evaluation beyond the end of the law for its surface.
    fn tooth_past_its_end(&self) -> Option<String> {
        let model = &self.model;
        self.teeth.near.iter().find_map(|&pair| {
            let pair = pair as usize;
            let depth = self.teeth.penetration[pair];
            let (s, k) = (pair / model.links, pair % model.links);
            let number = model.tooth_pair(s, self.stiffness_surface(pair));
            let end =
                with_law!(&model.teeth.law.pairs, Law, pairs => range_end::<Law>(&pairs[number]));
            let name = || format!("{} on {}", model.on_teeth_name(k), model.wheel_name(s));
            (depth > end).then(|| past_range(model.teeth.law.elastic, &name(), depth, end))
        })
    }

    /// Return the messages on the first contacts beyond the end of their law, one line each.
    pub fn past_range(&self) -> impl Iterator<Item = &String> {
        self.hinge_past_range.iter().chain(&self.tooth_past_range)
    }

    /// Return the surface that determines the stiffness of a pair: that at the contact onset with kept regions, else the present one.
    fn stiffness_surface(&self, pair: usize) -> Surface {
        if self.model.teeth.law.regions == Regions::Kept && self.memory.tooth_speed[pair] > 0.0 {
            self.memory.tooth_surface[pair]
        } else {
            self.teeth.surface[pair]
        }
    }

    /// Return the energies at the last evaluation.
    #[must_use]
    pub fn energy(&self) -> Energy {
        energy::energy(self)
    }

    /// Return a description of the contact of a body with the largest force at the last evaluation of the right-hand side.
    ///
    /// Bodies: links, then rollers, then sprockets. For a body that is not a link, all hinges are included.
    #[must_use]
    pub fn busiest_contact(&self, body: usize) -> Option<String> {
        let (model, n) = (&self.model, self.model.links);
        let hinges = (0..n)
            .filter(|&k| body >= n || k == body || (k + 1) % n == body)
            .map(|k| (self.kernels.hinge_force(k), format!("hinge {}", k + 1)));
        let rollers = (0..model.roller_count())
            .filter(|&k| body == n + k || body == model.link_of_bushing(k))
            .map(|k| {
                let name = format!("bushing {0} in roller {0}", k + 1);
                (self.kernels.roller_force(k), name)
            });
        let meets_teeth = |k: usize| match &model.rollers {
            Some(_) => n + k,
            None => model.link_of_bushing(k),
        };
        let teeth = self
            .kernels
            .tooth_contacts(model)
            .filter(|&(s, k, ..)| meets_teeth(k) == body || model.wheel_body(s) == body)
            .map(|(s, k, _, force)| {
                let gap = self.kernels.candidates.gap(model, s, k).unwrap_or(0);
                let (what, wheel) = (model.on_teeth_name(k), model.wheel_name(s));
                let name = format!("{what} on {wheel}, gap {gap}");
                (force, name)
            });
        hinges
            .chain(rollers)
            .chain(teeth)
            .filter(|(force, _)| *force != 0.0)
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(force, name)| format!("{name} pressed by {force:.3e} N"))
    }

    /// Write the normal force of every hinge at the last evaluation of the right-hand side \[N\].
    pub(crate) fn write_hinge_forces(&self, forces: &mut [f64]) {
        for (k, force) in forces.iter_mut().enumerate() {
            *force = self.kernels.hinge_force(k);
        }
    }

    /// Write the normal force of every bushing in its roller at the last evaluation of the right-hand side \[N\].
    pub(crate) fn write_roller_forces(&self, forces: &mut [f64]) {
        for (k, force) in forces.iter_mut().enumerate() {
            *force = self.kernels.roller_force(k);
        }
    }

    /// Write the tooth force on every bushing, summed over all sprockets, at the last evaluation of the right-hand side \[N\].
    pub(crate) fn write_tooth_forces(&self, forces: &mut [f64]) {
        forces.fill(0.0);
        for (_, k, _, force) in self.kernels.tooth_contacts(&self.model) {
            forces[k] += force;
        }
    }

    /// Return sprocket, bushing, penetration \[m\] (zero where apart) and normal force \[N\] of every candidate.
    ///
    /// The values are those of the last evaluation of the right-hand side.
    pub fn candidates(&self) -> impl Iterator<Item = (usize, usize, f64, f64)> {
        self.kernels.tooth_contacts(&self.model)
    }

    /// Return the number of candidate lists built so far.
    #[must_use]
    pub fn candidate_refreshes(&self) -> u64 {
        self.kernels.candidates.refreshes()
    }

    /// Return penetration \[m\] (zero where apart) and normal force \[N\] of every hinge at the last evaluation of the right-hand side.
    pub fn hinge_contacts(&self) -> impl Iterator<Item = (f64, f64)> {
        let depths = self.kernels.hinge_depths(&self.model).iter().enumerate();
        depths.map(|(k, &depth)| (depth, self.kernels.hinge_force(k)))
    }

    /// Return penetration \[m\] (zero where apart) and normal force \[N\] of every bushing in its roller.
    ///
    /// The values are those of the last evaluation of the right-hand side.
    pub fn roller_contacts(&self) -> impl Iterator<Item = (f64, f64)> {
        let depths = self.kernels.roller_depths(&self.model).iter().enumerate();
        depths.map(|(k, &depth)| (depth, self.kernels.roller_force(k)))
    }

    /// Write the accelerations at (`t`, `y`) of all coordinates.
    fn accelerate(&mut self, t: f64, y: &[f64], accelerations: &mut [f64]) {
        let (kernels, model, memory) = (&mut self.kernels, &self.model, &self.memory);
        if self.keeps_energy {
            self.powers = kernels.accelerations::<true>(model, memory, t, y, accelerations);
        } else {
            kernels.accelerations::<false>(model, memory, t, y, accelerations);
        }
    }

    /// Evaluate the right-hand side at (`t`, `y`) and discard the derivative.
    ///
    /// The results are penetrations and forces of contacts, and the powers with energy metering on.
    pub(crate) fn differentiate(&mut self, t: f64, y: &[f64]) {
        let mut slope = std::mem::take(&mut self.slope);
        self.derivative(t, y, &mut slope);
        self.slope = slope;
    }

    /// Select an instruction set instead of the widest one of this machine.
    pub fn use_instructions(&mut self, instructions: InstructionSet) {
        self.kernels.use_instructions(instructions);
        self.reader.kernels.use_instructions(instructions);
    }

    /// Return the instruction set in use.
    #[must_use]
    pub fn instructions(&self) -> InstructionSet {
        self.kernels.instructions()
    }
}

/// Return the message on a contact beyond the end of its law: penetration `depth` and end of the law `end` \[m\].
fn past_range(law: Elastic, contact: &str, depth: f64, end: f64) -> String {
    let law = law.name();
    format!(
        "{law} law, {contact}: penetration {depth:.3e} m is past the end of the law, {end:.3e} m; \
         the force goes on with the secant's stiffness"
    )
}

/// Return the elastic force at a penetration \[N\].
fn force_at<L: crate::force_law::ElasticLaw>(pair: &[f64; 2], depth: f64) -> f64 {
    L::force(pair, depth)
}

/// Return the penetration at the end of a law \[m\].
fn range_end<L: crate::force_law::ElasticLaw>(pair: &[f64; 2]) -> f64 {
    L::range_end(pair)
}

impl OdeSystem for Dynamics {
    fn accepts_step(&mut self, length: f64, allowed: f64) -> bool {
        let watched = self.kernels.watch(&self.model, length);
        (self.turned, self.fastest) = (watched.turned, watched.speed);
        !self.turned || self.deepest_unseen(length) <= allowed
    }

    fn dimension(&self) -> usize {
        2 * self.model.coordinates
    }

    fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        let nq = self.model.coordinates;
        let (rates, accelerations) = dydt.split_at_mut(nq);
        rates.copy_from_slice(&y[nq..2 * nq]);
        self.accelerate(t, y, accelerations);
    }
}

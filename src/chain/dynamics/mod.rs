//! The equations of motion: contacts -> forces -> accelerations.
//!
//! A scene without ideal joints has no constraints: accelerations are forces over masses, and no linear system exists but that of
//! the implicit corrector, where it is asked for.

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

/// A drive in motion: the right-hand side that the integrator calls, and the memory of its contacts.
///
/// State: y = [q, dq/dt].
#[derive(Debug, Clone)]
pub struct Dynamics {
    model: Arc<Model>,
    /// What live contacts remember; written between steps only.
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
    /// Evaluates for all who read contacts.
    reader: Box<Reader>,
    keeps_energy: bool,
    /// Powers at the last derivative, while energy is kept.
    powers: Powers,
    quadrature: EnergyQuadrature<Powers>,
    inputs: Inputs,
    /// Both ends of the step that is metered, or where the next one begins.
    ends: StepEnds,
    /// Pairs that came apart in the last step; they keep their memory until the next one begins, for reports inside it.
    parted: Vec<Pair>,
    /// Whether some contact may have turned round inside the step just made.
    turned: bool,
    /// No bushing was faster at the end of that step, seen from any tooth \[m/s\].
    fastest: f64,
    /// Touches inside steps that were too shallow to matter.
    unseen_touches: u64,
    /// Scratch: tooth contacts that began in the last step.
    begun: Vec<(usize, usize)>,
    /// Scratch: a derivative that nobody asked for.
    slope: Vec<f64>,
    /// Scratch: the state inside a step, padded.
    inside: Vec<f64>,
    /// The first hinge that went past the end of its law, in words.
    hinge_past_range: Option<String>,
    /// The first tooth contact that did.
    tooth_past_range: Option<String>,
    /// Jumps of the chain over teeth.
    tooth_jumps: ToothJumps,
    /// How often the list of candidates had been made when those were last looked for.
    jumps_looked_for: u64,
}

/// A hinge, or a bushing and a sprocket.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum Pair {
    Hinge(usize),
    Roller(usize),
    Tooth(usize),
}

impl Dynamics {
    /// The dynamics of `model`.
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

    /// The model.
    #[must_use]
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// Whether the sums of the energy balance grow.
    #[must_use]
    pub fn keeps_energy(&self) -> bool {
        self.keeps_energy
    }

    /// Switches powers, and with them the sums of the energy balance, on or off.
    pub fn keep_energy(&mut self, keep: bool) {
        self.keeps_energy = keep;
        self.powers = Powers::default();
    }

    /// Powers at the last derivative for which energy was kept.
    #[must_use]
    pub fn powers(&self) -> Powers {
        self.powers
    }

    /// Hinges, and pairs of bushing and sprocket, that came apart in the last step: their memory ends with it.
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

    /// Bushings that came apart from their rollers in the last step, likewise.
    #[must_use]
    pub fn parted_rollers(&self) -> Vec<usize> {
        let roller = |pair: &Pair| match *pair {
            Pair::Roller(k) => Some(k),
            _ => None,
        };
        self.parted.iter().filter_map(roller).collect()
    }

    /// Evaluates contacts, forces and accelerations at (`t`, `y`).
    pub fn evaluate(&mut self, t: f64, y: &[f64]) -> Powers {
        self.motion.read(&self.model, t, y);
        self.bristles.read(&self.model, y);
        self.reader.state.copy_from_slice(y);
        self.evaluate_state(t)
    }

    /// The same for motion and bristles as they stand.
    pub fn evaluate_motion(&mut self, t: f64) -> Powers {
        self.motion.write(&self.model, &mut self.reader.state);
        self.bristles.write(&self.model, &mut self.reader.state);
        self.evaluate_state(t)
    }

    /// Evaluates the reader's state; candidates are found anew, wherever bodies are.
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

    /// Evaluates at (`t`, `y`) what `needs` asks for; the rest stays as it was, or what it was is gone.
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

    /// Takes hinges, rollers and bristles from the reader's last evaluation.
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

    /// Takes the teeth from the reader's last evaluation.
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

    /// Gives every pair that is in contact now a memory, as if it had begun here (positions just given).
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
        // Where the first step begins.
        self.differentiate(t, y);
        self.fastest = self.kernels.watch(&self.model, 0.0).speed;
        self.kernels.watch.advance();
        self.look_for_jumps(t);
    }

    /// Lets the pawls of ratchets fall behind the teeth that have passed them in the last step, whose end is `y`; call before the next
    /// one, so that reports inside that step have them where they were.
    pub(crate) fn follow_with_pawls(&mut self, y: &[f64]) {
        let sprockets = self.model.sprockets.iter().zip(&mut self.memory.pawls);
        for (sprocket, pawl) in sprockets {
            if let Some((ratchet, s)) = sprocket.ratchet_at(y) {
                *pawl = ratchet.follow(*pawl, s);
            }
        }
    }

    /// Forgets the contacts that ended in the last step; call before the next one.
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

    /// Finds the contacts that began in the step just made and their onset speeds; call after it, before another derivative.
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
        // Steps are far shorter than a gap; of one that is not, nobody knows how many teeth it has passed.
        let farthest = self.fastest * (step.end - step.start);
        if farthest.is_nan() || farthest > self.model.half_pitch {
            self.tooth_jumps.lose_seatings();
        } else if self.jumps_looked_for != self.candidate_refreshes() {
            self.look_for_jumps(step.end);
        }
    }

    /// Looks for jumps over teeth at the last evaluation, that of time `t` \[s\]. A bushing that has changed gaps has moved by more than the
    /// margin of the list of candidates against its sprocket, so that this is done only where that list was made again.
    fn look_for_jumps(&mut self, t: f64) {
        self.jumps_looked_for = self.candidate_refreshes();
        let jumps = &mut self.tooth_jumps;
        self.kernels.look_for_jumps(&self.model, t, jumps);
    }

    /// Teeth that the chain has jumped so far, in the order of time.
    #[must_use]
    pub fn tooth_jumps(&self) -> &[ToothJump] {
        self.tooth_jumps.jumps()
    }

    fn find_hinge_onsets(&mut self, adams: &Adams, step: &Step) {
        let model = &self.model;
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

    /// Notes the first hinge and the first tooth contact that go past the end of their law at the end of a step.
    fn watch_ranges(&mut self, adams: &Adams) {
        let model = &self.model;
        if self.hinge_past_range.is_none() {
            let hinges = self.kernels.hinge_depths(model);
            let rollers = self.kernels.roller_depths(model);
            self.hinge_past_range = self.joint_past_its_end(hinges, rollers);
        }
        let model = &self.model;
        if model.tooth_law.elastic.has_an_end() && self.tooth_past_range.is_none() {
            let nearest_end = with_law!(&model.tooth_law.pairs, Law, pairs => {
                pairs.iter().map(range_end::<Law>).fold(f64::INFINITY, f64::min)
            });
            let beyond = |(_, _, depth, _): (usize, usize, f64, f64)| depth > nearest_end;
            if self.kernels.tooth_contacts(model).any(beyond) {
                self.evaluate(adams.time(), adams.y());
                self.tooth_past_range = self.tooth_past_its_end();
            }
        }
    }

    /// The same as contacts were last evaluated, for a report with `needs`: inside a step they may be deeper than at its ends.
    pub(crate) fn watch_reported_ranges(&mut self, needs: Needs) {
        if needs.hinges != Want::Nothing && self.hinge_past_range.is_none() {
            let (hinges, rollers) = (&self.hinges.penetration, &self.rollers.penetration);
            self.hinge_past_range = self.joint_past_its_end(hinges, rollers);
        }
        if needs.teeth != Want::Nothing
            && self.tooth_past_range.is_none()
            && self.model.tooth_law.elastic.has_an_end()
        {
            self.tooth_past_range = self.tooth_past_its_end();
        }
    }

    /// The first hinge, or bushing in its roller, that is deeper than its law goes.
    fn joint_past_its_end(&self, hinges: &[f64], rollers: &[f64]) -> Option<String> {
        let model = &self.model;
        let law = &model.hinge_law;
        if law.elastic.has_an_end() {
            let (end, force) = with_law!(&law.pairs, Law, pairs => {
                let end = range_end::<Law>(&pairs[0]);
                (end, force_at::<Law>(&pairs[0], end))
            });
            let end_of = |k: usize| end + model.compliance_at(k).map_or(0.0, |given| given * force);
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

    /// The first tooth contact of the last evaluation that is past the end of its own surface's law.
    fn tooth_past_its_end(&self) -> Option<String> {
        let model = &self.model;
        self.teeth.near.iter().find_map(|&pair| {
            let pair = pair as usize;
            let depth = self.teeth.penetration[pair];
            let (s, k) = (pair / model.links, pair % model.links);
            let number = model.tooth_pair(s, self.stiffness_surface(pair));
            let end =
                with_law!(&model.tooth_law.pairs, Law, pairs => range_end::<Law>(&pairs[number]));
            let name = || format!("{} on {}", model.on_teeth_name(k), model.wheel_name(s));
            (depth > end).then(|| past_range(model.tooth_law.elastic, &name(), depth, end))
        })
    }

    /// Which contacts were the first to go past the end of their law, a line each.
    pub fn past_range(&self) -> impl Iterator<Item = &String> {
        self.hinge_past_range.iter().chain(&self.tooth_past_range)
    }

    /// The surface whose stiffness a pair has now.
    fn stiffness_surface(&self, pair: usize) -> Surface {
        if self.model.tooth_law.regions == Regions::Kept && self.memory.tooth_speed[pair] > 0.0 {
            self.memory.tooth_surface[pair]
        } else {
            self.teeth.surface[pair]
        }
    }

    /// Energies at the last evaluation.
    #[must_use]
    pub fn energy(&self) -> Energy {
        energy::energy(self)
    }

    /// The hardest pressed contact of a body (links, then rollers, then sprockets) at the last derivative, in words.
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

    /// Normal force of every hinge at the last derivative \[N\].
    pub(crate) fn write_hinge_forces(&self, forces: &mut [f64]) {
        for (k, force) in forces.iter_mut().enumerate() {
            *force = self.kernels.hinge_force(k);
        }
    }

    /// Normal force of every bushing in its roller at the last derivative \[N\].
    pub(crate) fn write_roller_forces(&self, forces: &mut [f64]) {
        for (k, force) in forces.iter_mut().enumerate() {
            *force = self.kernels.roller_force(k);
        }
    }

    /// Tooth force on every bushing at the last derivative, over all sprockets \[N\].
    pub(crate) fn write_tooth_forces(&self, forces: &mut [f64]) {
        forces.fill(0.0);
        for (_, k, _, force) in self.kernels.tooth_contacts(&self.model) {
            forces[k] += force;
        }
    }

    /// Sprocket, bushing, depth \[m\] (zero where apart) and normal force \[N\] of every candidate at the last derivative: the
    /// pairs that were looked at.
    pub fn candidates(&self) -> impl Iterator<Item = (usize, usize, f64, f64)> {
        self.kernels.tooth_contacts(&self.model)
    }

    /// How often the list of candidates was made.
    #[must_use]
    pub fn candidate_refreshes(&self) -> u64 {
        self.kernels.candidates.refreshes()
    }

    /// Depth \[m\] (zero where apart) and normal force \[N\] of every hinge at the last derivative.
    pub fn hinge_contacts(&self) -> impl Iterator<Item = (f64, f64)> {
        let depths = self.kernels.hinge_depths(&self.model).iter().enumerate();
        depths.map(|(k, &depth)| (depth, self.kernels.hinge_force(k)))
    }

    /// Depth \[m\] (zero where apart) and normal force \[N\] of every bushing in its roller at the last derivative.
    pub fn roller_contacts(&self) -> impl Iterator<Item = (f64, f64)> {
        let depths = self.kernels.roller_depths(&self.model).iter().enumerate();
        depths.map(|(k, &depth)| (depth, self.kernels.roller_force(k)))
    }

    /// Writes the accelerations at (`t`, `y`), coordinate by coordinate.
    fn accelerate(&mut self, t: f64, y: &[f64], accelerations: &mut [f64]) {
        let (kernels, model, memory) = (&mut self.kernels, &self.model, &self.memory);
        if self.keeps_energy {
            self.powers = kernels.accelerations::<true>(model, memory, t, y, accelerations);
        } else {
            kernels.accelerations::<false>(model, memory, t, y, accelerations);
        }
    }

    /// Evaluates the right-hand side at (`t`, `y`) for what it leaves behind: depths and forces of contacts, and the powers when
    /// energy is kept.
    pub(crate) fn differentiate(&mut self, t: f64, y: &[f64]) {
        let mut slope = std::mem::take(&mut self.slope);
        self.derivative(t, y, &mut slope);
        self.slope = slope;
    }

    /// Goes on with other instructions than the widest ones that this machine has.
    pub fn use_instructions(&mut self, instructions: InstructionSet) {
        self.kernels.use_instructions(instructions);
        self.reader.kernels.use_instructions(instructions);
    }

    /// The instructions in use.
    #[must_use]
    pub fn instructions(&self) -> InstructionSet {
        self.kernels.instructions()
    }
}

fn past_range(law: Elastic, contact: &str, depth: f64, end: f64) -> String {
    let law = law.name();
    format!(
        "{law} law, {contact}: penetration {depth:.3e} m is past the end of the law, {end:.3e} m; \
         the force goes on with the secant's stiffness"
    )
}

fn force_at<L: crate::force_law::ElasticLaw>(pair: &[f64; 2], depth: f64) -> f64 {
    L::force(pair, depth)
}

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

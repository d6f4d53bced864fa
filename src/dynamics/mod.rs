//! The equations of motion: contacts -> forces -> accelerations.
//!
//! A scene without ideal joints has no constraints: accelerations are forces over masses, and no linear system exists.

mod energy;
mod forces;
mod loads;

use std::sync::Arc;

pub use energy::Energy;

use crate::contact::{
    HingeContacts, ImpactMemory, ToothContacts, first_crossing, hinge_at, tooth_at,
};
use crate::force_law::{Elastic, Regions, with_law};
use crate::integrator::{Adams, OdeSystem, Step};
use crate::model::{Model, Rotation, Support};
use crate::state::Motion;
use loads::Accelerations;

/// A drive in motion: the right-hand side that the integrator calls, and the memory of its contacts.
///
/// State: y = [q, dq/dt] and two sums, the energy dissipated and the work done on the drive \[J\], which stand still unless
/// the energy balance is kept.
#[derive(Debug, Clone)]
pub struct Dynamics {
    model: Arc<Model>,
    /// What live contacts remember; written between steps only.
    pub memory: ImpactMemory,
    /// Motion of all bodies at the last evaluation.
    pub motion: Motion,
    /// Hinges at the last evaluation.
    pub hinges: HingeContacts,
    /// Teeth at the last evaluation.
    pub teeth: ToothContacts,
    /// Accelerations at the last evaluation.
    pub accelerations: Accelerations,
    keeps_energy: bool,
    /// Pairs that came apart in the last step; they keep their memory until the next one begins, for reports inside it.
    parted: Vec<Pair>,
    /// The first hinge that went past the end of its law, in words.
    hinge_past_range: Option<String>,
    /// The first tooth contact that did.
    tooth_past_range: Option<String>,
}

/// A hinge, or a bushing and a sprocket.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Pair {
    Hinge(usize),
    Tooth(usize),
}

impl Dynamics {
    /// The dynamics of `model`.
    #[must_use]
    pub fn new(model: Arc<Model>) -> Self {
        let (links, sprockets) = (model.links, model.sprockets.len());
        Self {
            memory: ImpactMemory::new(links, links * sprockets, model.min_approach_speed),
            motion: Motion::new(model.bodies()),
            hinges: HingeContacts::new(links),
            teeth: ToothContacts::new(links, sprockets),
            accelerations: Accelerations::new(model.bodies()),
            keeps_energy: false,
            parted: Vec::with_capacity(links * (1 + sprockets)),
            hinge_past_range: None,
            tooth_past_range: None,
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

    /// Switches the sums of the energy balance on or off.
    pub fn keep_energy(&mut self, keep: bool) {
        self.keeps_energy = keep;
    }

    /// Hinges, and pairs of bushing and sprocket, that came apart in the last step: their memory ends with it.
    #[must_use]
    pub fn parted(&self) -> (Vec<usize>, Vec<usize>) {
        let mut parted = (Vec::new(), Vec::new());
        for pair in &self.parted {
            match *pair {
                Pair::Hinge(k) => parted.0.push(k),
                Pair::Tooth(pair) => parted.1.push(pair),
            }
        }
        parted
    }

    /// Evaluates contacts, forces and accelerations at (`t`, `y`).
    pub fn evaluate(&mut self, t: f64, y: &[f64]) -> Powers {
        self.motion.read(&self.model, t, y);
        self.evaluate_motion(t)
    }

    /// The same for the motion as it stands.
    pub fn evaluate_motion(&mut self, t: f64) -> Powers {
        self.hinges.find(&self.model, &self.motion);
        self.teeth.find(&self.model, &self.motion, &self.hinges);
        let dissipated = if self.keeps_energy {
            self.forces::<true>()
        } else {
            self.forces::<false>()
        };
        self.accelerations
            .gather(&self.model, &self.motion, &self.hinges, &self.teeth, t);
        let mut powers = Powers {
            dissipated,
            worked_in: 0.0,
        };
        if self.keeps_energy {
            loads::add_outside_powers(
                &self.model,
                &self.motion,
                &self.accelerations,
                t,
                &mut powers,
            );
        }
        powers
    }

    /// Normal forces of all contacts; returns the power they dissipate when asked to \[W\].
    fn forces<const ENERGY: bool>(&mut self) -> f64 {
        let model = &self.model;
        let hinges = with_law!(&model.hinge_law.pairs, Law, pairs => {
            forces::hinge_forces::<Law, ENERGY>(&pairs[0], model.hinge_law.lambda, &self.memory, &mut self.hinges)
        });
        let teeth = with_law!(&model.tooth_law.pairs, Law, pairs => {
            forces::tooth_forces::<Law, ENERGY>(pairs, model, &self.memory, &mut self.teeth)
        });
        hinges + teeth
    }

    /// Gives every pair that is in contact now a memory, as if it had begun here (positions just given).
    pub fn remember_present_contacts(&mut self, t: f64, y: &[f64]) {
        self.memory.clear();
        self.evaluate(t, y);
        for k in 0..self.model.links {
            if self.hinges.penetration[k] > 0.0 {
                self.memory.begin_hinge(k, self.hinges.rate[k]);
            }
        }
        for &pair in &self.teeth.near {
            let pair = pair as usize;
            if self.teeth.penetration[pair] > 0.0 {
                self.memory
                    .begin_tooth(pair, self.teeth.rate[pair], self.teeth.surface[pair]);
            }
        }
    }

    /// Forgets the contacts that ended in the last step; call before the next one.
    pub fn begin_step(&mut self) {
        for pair in self.parted.drain(..) {
            match pair {
                Pair::Hinge(k) => self.memory.hinge_speed[k] = 0.0,
                Pair::Tooth(pair) => self.memory.tooth_speed[pair] = 0.0,
            }
        }
    }

    /// Finds the contacts that began in the step just made and their onset speeds; call after it, before any other evaluation.
    #[allow(clippy::cast_possible_truncation)]
    pub fn finish_step(&mut self, adams: &Adams, step: &Step) {
        let model = Arc::clone(&self.model);
        for k in 0..model.links {
            let touching = self.hinges.penetration[k] > 0.0;
            if touching == (self.memory.hinge_speed[k] > 0.0) {
                continue;
            }
            if touching {
                let (_, rate) = first_crossing(
                    |t| Some(hinge_at(&model, adams, k, t)),
                    step.start,
                    step.end,
                );
                self.memory.begin_hinge(k, rate);
            } else {
                self.parted.push(Pair::Hinge(k));
            }
        }
        for (pair, &depth) in self.teeth.penetration.iter().enumerate() {
            let touching = depth > 0.0;
            if touching == (self.memory.tooth_speed[pair] > 0.0) {
                continue;
            }
            if touching {
                let (sprocket, bushing) = (pair / model.links, pair % model.links);
                let at = |t| tooth_at(&model, adams, bushing, sprocket, t);
                let (t, rate) =
                    first_crossing(|t| at(t).map(|found| found.contact), step.start, step.end);
                let surface = at(t).map_or(self.teeth.surface[pair], |found| found.surface);
                self.memory.begin_tooth(pair, rate, surface);
            } else {
                self.parted.push(Pair::Tooth(pair));
            }
        }
        self.watch_ranges();
    }

    /// Notes the first hinge and the first tooth contact that go past the end of their law.
    fn watch_ranges(&mut self) {
        let model = &self.model;
        if model.hinge_law.elastic == Elastic::Johnson && self.hinge_past_range.is_none() {
            let end = with_law!(&model.hinge_law.pairs, Law, pairs => range_end::<Law>(&pairs[0]));
            let depths = &self.hinges.penetration;
            if let Some(k) = depths.iter().position(|&depth| depth > end) {
                self.hinge_past_range =
                    Some(past_range(&format!("hinge {}", k + 1), depths[k], end));
            }
        }
        if model.tooth_law.elastic == Elastic::Johnson && self.tooth_past_range.is_none() {
            self.tooth_past_range = self.teeth.near.iter().find_map(|&pair| {
                let pair = pair as usize;
                let depth = self.teeth.penetration[pair];
                let (s, k) = (pair / model.links, pair % model.links);
                let number = Model::tooth_pair(s, self.stiffness_surface(pair));
                let end = with_law!(&model.tooth_law.pairs, Law, pairs => range_end::<Law>(&pairs[number]));
                let name = || format!("bushing {} on sprocket {}", k + 1, s + 1);
                (depth > end).then(|| past_range(&name(), depth, end))
            });
        }
    }

    /// Which contacts were the first to go past the end of their law, a line each.
    pub fn past_range(&self) -> impl Iterator<Item = &String> {
        self.hinge_past_range.iter().chain(&self.tooth_past_range)
    }

    /// The surface whose stiffness a pair has now.
    fn stiffness_surface(&self, pair: usize) -> crate::geometry::Surface {
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

    /// The hardest pressed contact of a body (links, then sprockets), in words.
    #[must_use]
    pub fn busiest_contact(&self, body: usize) -> Option<String> {
        let n = self.model.links;
        let hinge = (0..n)
            .filter(|&k| body >= n || k == body || (k + 1) % n == body)
            .map(|k| (self.hinges.force[k], format!("hinge {}", k + 1)));
        let tooth = self
            .teeth
            .near
            .iter()
            .map(|&p| p as usize)
            .filter_map(|pair| {
                let (s, k) = (pair / n, pair % n);
                (self.model.link_of_bushing(k) == body || n + s == body).then(|| {
                    (
                        self.teeth.force[pair],
                        format!(
                            "bushing {} on sprocket {}, gap {}",
                            k + 1,
                            s + 1,
                            self.teeth.gap[pair]
                        ),
                    )
                })
            });
        hinge
            .chain(tooth)
            .filter(|(force, _)| *force != 0.0)
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(force, name)| format!("{name} pressed by {force:.3e} N"))
    }
}

fn past_range(contact: &str, depth: f64, end: f64) -> String {
    format!(
        "johnson law, {contact}: penetration {depth:.3e} m is past the end of the law, {end:.3e} m; \
         the force goes on with the secant's stiffness"
    )
}

fn range_end<L: crate::force_law::ElasticLaw>(pair: &L::Pair) -> f64 {
    L::range_end(pair)
}

/// Power dissipated in contacts and dashpots, and power put in from outside \[W\].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Powers {
    /// Dissipated.
    pub dissipated: f64,
    /// Put in by motors, torques and the tensioner.
    pub worked_in: f64,
}

impl OdeSystem for Dynamics {
    fn dimension(&self) -> usize {
        self.controlled() + 2
    }

    fn controlled(&self) -> usize {
        2 * self.model.coordinates
    }

    fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        let powers = self.evaluate(t, y);
        let (nq, n) = (self.model.coordinates, self.model.links);
        let (rates, rest) = dydt.split_at_mut(nq);
        rates.copy_from_slice(&y[nq..2 * nq]);
        let a = &self.accelerations;
        rest[..n].copy_from_slice(&a.x[..n]);
        rest[n..2 * n].copy_from_slice(&a.y[..n]);
        rest[2 * n..3 * n].copy_from_slice(&a.angle[..n]);
        for (i, sprocket) in self.model.sprockets.iter().enumerate() {
            let body = n + i;
            match sprocket.support {
                Support::Fixed => {}
                Support::Slide {
                    index, direction, ..
                } => {
                    rest[index] = a.x[body] * direction.x + a.y[body] * direction.y;
                }
                Support::Floating { x, y } => {
                    rest[x] = a.x[body];
                    rest[y] = a.y[body];
                }
            }
            if let Rotation::Free { index, .. } = sprocket.rotation {
                rest[index] = a.angle[body];
            }
        }
        rest[nq] = powers.dissipated;
        rest[nq + 1] = powers.worked_in;
    }
}

//! The published drive as other integrators see it: kernels for the right-hand side, memory of contacts kept between steps, and
//! on demand the energy balance, metered as this project meters its own.

use std::sync::Arc;

use rustchain::chain::contact::ContactId;
use rustchain::chain::dynamics::{Dynamics, Powers};
use rustchain::chain::motion::Motion;
use rustchain::drive::Drive;
use rustchain::integrator::OdeSystem;
use rustchain::integrator::event_location::onset_in_step;
use rustchain::layout::InitialConfiguration;
use rustchain::system::PowerSum;
use rustchain::{ForceLaws, Model};

use crate::system::{Accepted, Evolving, Pattern};

/// Gauss-Lobatto formula of four points: the three after the start of a panel as parts of it, and the weights of all.
const POINTS: [f64; 3] = [0.276_393_202_250_021, 0.723_606_797_749_979, 1.0];
const WEIGHTS: [f64; 4] = [1.0 / 12.0, 5.0 / 12.0, 5.0 / 12.0, 1.0 / 12.0];

/// A drive, its contacts' memory, and what its energy was.
pub(crate) struct DriveSystem {
    dynamics: Dynamics,
    start: Vec<f64>,
    energy_at_start: f64,
    metered: bool,
    /// Energies that passed since the start \[J\], and the powers at the end of the last step \[W\].
    passed: Powers,
    last_powers: Powers,
    pattern: Pattern,
    /// Hinges, and pairs of bushing and sprocket, that begin (true) or end with the last step.
    hinges: Vec<(usize, bool)>,
    teeth: Vec<(usize, bool)>,
    /// Scratch: state inside a step.
    inside: Vec<f64>,
    slope: Vec<f64>,
}

impl DriveSystem {
    /// With `metered`, energies are summed along every step, which takes evaluations.
    pub(crate) fn new(
        drive: &Drive,
        laws: &ForceLaws,
        start: &InitialConfiguration,
        metered: bool,
    ) -> rustchain::Result<Self> {
        let model = Arc::new(Model::compile(drive, laws, start)?);
        let mut dynamics = Dynamics::new(model.clone());
        let mut y = vec![0.0; dynamics.dimension()];
        let mut motion = Motion::new(model.bodies());
        motion.set(&start.positions, &start.velocities);
        motion.write(&model, &mut y);
        dynamics.remember_present_contacts(0.0, &y);
        let mut slope = vec![0.0; y.len()];
        dynamics.keep_energy(metered);
        dynamics.evaluate(0.0, &y);
        let energy_at_start = dynamics.energy().total();
        dynamics.derivative(0.0, &y, &mut slope);
        Ok(Self {
            energy_at_start,
            metered,
            passed: Powers::default(),
            last_powers: dynamics.powers(0.0, &y),
            slope,
            inside: y.clone(),
            start: y,
            hinges: Vec::new(),
            teeth: Vec::new(),
            pattern: folded(&model),
            dynamics,
        })
    }

    pub(crate) fn start(&self) -> &[f64] {
        &self.start
    }

    /// Energy missing and energy dissipated since the start \[J\]; NaN where they are not metered.
    pub(crate) fn balance(&mut self, t: f64, y: &[f64]) -> [f64; 2] {
        if !self.metered {
            return [f64::NAN; 2];
        }
        self.dynamics.evaluate(t, y);
        let Powers {
            dissipated,
            external_work,
            ..
        } = self.passed;
        let gained = self.dynamics.energy().total() - self.energy_at_start;
        [gained + dissipated - external_work, dissipated]
    }

    pub(crate) fn onsets(&self) -> u64 {
        self.dynamics.memory.counts().onsets
    }

    /// Adds the energies of a step: powers along the cubic through its ends, integrated over as many panels as this project's own
    /// meter lays into a step.
    fn meter(&mut self, step: &Accepted<'_>, panels: usize) {
        let width = (step.end - step.start) / panels as f64;
        for panel in 0..panels {
            let mut sum = Powers::default();
            sum.add_scaled(WEIGHTS[0], &self.last_powers);
            for (point, weight) in POINTS.into_iter().zip(&WEIGHTS[1..]) {
                let t = step.start + width * (panel as f64 + point);
                step.at(t, &mut self.inside);
                self.dynamics.derivative(t, &self.inside, &mut self.slope);
                self.last_powers = self.dynamics.powers(t, &self.inside);
                sum.add_scaled(*weight, &self.last_powers);
            }
            self.passed.add_scaled(width, &sum);
        }
    }

    /// x, y, θ of all bodies, one after the other.
    pub(crate) fn positions(&mut self, t: f64, y: &[f64]) -> Vec<f64> {
        self.dynamics.evaluate(t, y);
        self.dynamics.evaluated.motion.positions().concat()
    }

    /// Depth and rate of a pair inside a step: a hinge, or (sprocket, bushing).
    fn depth_at(
        &mut self,
        step: &Accepted<'_>,
        t: f64,
        find: impl Fn(&Dynamics) -> (f64, f64),
    ) -> (f64, f64) {
        step.at(t, &mut self.inside);
        self.dynamics.evaluate(t, &self.inside);
        find(&self.dynamics)
    }

    /// Time and speed at which a pair's depth turned positive in a step.
    fn onset(&mut self, step: &Accepted<'_>, find: impl Fn(&Dynamics) -> (f64, f64)) -> (f64, f64) {
        let contact = |depth: f64, rate: f64| rustchain::geometry::Contact {
            normal: rustchain::geometry::Vec2::zeros(),
            penetration: depth,
            penetration_rate: rate,
        };
        let own = std::cell::RefCell::new(self);
        onset_in_step(
            |t| {
                let (depth, rate) = own.borrow_mut().depth_at(step, t, &find);
                contact(depth, rate)
            },
            step.start,
            step.end,
        )
    }
}

impl OdeSystem for DriveSystem {
    fn dimension(&self) -> usize {
        self.dynamics.dimension()
    }

    fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        self.dynamics.derivative(t, y, dydt);
    }
}

impl Evolving for DriveSystem {
    /// As for the product's `accuracy` of 1 m: lengths 1 m, speeds 1e5 m/s, angles through half the pitch or the pitch radius.
    fn scale(&self) -> Vec<f64> {
        let model = self.dynamics.model();
        let (nq, n) = (model.coordinates, model.links);
        let mut lengths = vec![1.0; nq];
        // The padding has no error: its scale is infinite.
        lengths[model.used_coordinates..].fill(0.0);
        for (q, length) in lengths.iter_mut().enumerate().skip(2 * n) {
            let body = model.body_of_coordinate(q);
            if q < 3 * n {
                *length = model.half_pitch;
            } else if matches!(model.sprockets[body - n].rotation,
                rustchain::chain::model::Rotation::Free { index, .. } if index == q)
            {
                let teeth = model.sprockets[body - n].gap_directions.len() as f64;
                *length = model.half_pitch / (std::f64::consts::PI / teeth).sin();
            }
        }
        let positions = lengths.iter().map(|length| 1.0 / length);
        let speeds = lengths.iter().map(|length| 1e5 / length);
        positions.chain(speeds).collect()
    }

    fn crossed(&mut self, _: &Accepted<'_>) -> bool {
        let (dynamics, memory) = (&self.dynamics, &self.dynamics.memory);
        let links = dynamics.model().links;
        self.hinges.clear();
        for (k, (depth, _)) in dynamics.hinge_contacts().enumerate() {
            let touching = depth > 0.0;
            if touching != (memory.hinge_impact_velocity()[k] > 0.0) {
                self.hinges.push((k, touching));
            }
        }
        self.teeth.clear();
        for (s, k, depth, _) in dynamics.candidates() {
            let (pair, touching) = (s * links + k, depth > 0.0);
            if touching != (memory.tooth_impact_velocity[pair] > 0.0) {
                self.teeth.push((pair, touching));
            }
        }
        !(self.hinges.is_empty() && self.teeth.is_empty())
    }

    fn remember(&mut self, step: &Accepted<'_>) {
        let (hinges, teeth) = (self.hinges.clone(), self.teeth.clone());
        for &(k, _) in hinges.iter().filter(|(_, touching)| *touching) {
            let (_, rate) = self.onset(step, |d| {
                (
                    d.evaluated.hinges.penetration[k],
                    d.evaluated.hinges.rate[k],
                )
            });
            self.dynamics.memory.begin(ContactId::Hinge(k), rate);
        }
        let mut memory = self.dynamics.memory.clone();
        for &(pair, _) in teeth.iter().filter(|(_, touching)| *touching) {
            let find = |d: &Dynamics| {
                (
                    d.evaluated.teeth.penetration[pair],
                    d.evaluated.teeth.rate[pair],
                )
            };
            let (t, rate) = self.onset(step, find);
            self.depth_at(step, t, find);
            memory.begin_tooth(pair, rate, self.dynamics.evaluated.teeth.surface(pair));
        }
        if self.metered {
            // What parted in this step keeps its memory up to its end.
            if !teeth.is_empty() {
                self.dynamics.replace_memory(memory.clone());
            }
            self.meter(step, 2);
        }
        for &(pair, _) in teeth.iter().filter(|(_, touching)| !touching) {
            memory.end(ContactId::Tooth(pair));
        }
        for &(k, _) in hinges.iter().filter(|(_, touching)| !touching) {
            memory.end(ContactId::Hinge(k));
        }
        if teeth.is_empty() {
            self.dynamics.memory = memory;
        } else {
            self.dynamics.replace_memory(memory);
        }
    }

    fn pass(&mut self, step: &Accepted<'_>) {
        if self.metered {
            self.meter(step, 1);
        }
    }

    fn pattern(&self) -> Option<&Pattern> {
        Some(&self.pattern)
    }
}

/// The closed chain folded flat: links in the order 0, 1, n-1, 2, n-2, ..., so that neighbours are two places apart at most. The
/// sprockets come last; what couples them to the links is left out of the matrix, which Newton's method makes up for.
fn folded(model: &Model) -> Pattern {
    let (n, nq) = (model.links, model.coordinates);
    let mut order = vec![0];
    for i in 1..=n / 2 {
        order.push(i);
        if n - i != i {
            order.push(n - i);
        }
    }
    let mut component = Vec::new();
    for &link in &order {
        component.extend((0..6).map(|c| link + c % 3 * n + c / 3 * nq));
    }
    component.extend((3 * n..nq).flat_map(|q| [q, nq + q]));
    let mut groups: Vec<Vec<usize>> = (0..5)
        .flat_map(|colour| {
            (0..6).map(move |c| (colour..n).step_by(5).map(|place| 6 * place + c).collect())
        })
        .collect();
    // Columns of the padding, which comes last, are zero.
    groups.extend((6 * n..2 * model.used_coordinates).map(|place| vec![place]));
    Pattern {
        component,
        half_width: 17,
        groups,
    }
}

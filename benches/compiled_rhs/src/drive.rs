//! The published drive as other integrators see it: kernels for the right-hand side, memory of contacts kept between steps.

use std::sync::Arc;

use rustchain::contact::first_crossing;
use rustchain::drive::Drive;
use rustchain::dynamics::Dynamics;
use rustchain::integrator::OdeSystem;
use rustchain::state::{Motion, Start};
use rustchain::{ForceLaws, Model};

use crate::system::{Accepted, Evolving, Pattern};

/// A drive, its contacts' memory, and what its energy was.
pub(crate) struct DriveSystem {
    dynamics: Dynamics,
    start: Vec<f64>,
    energy_at_start: f64,
    pattern: Pattern,
    /// Hinges, and pairs of bushing and sprocket, that begin (true) or end with the last step.
    hinges: Vec<(usize, bool)>,
    teeth: Vec<(usize, bool)>,
    /// Scratch: state inside a step.
    inside: Vec<f64>,
}

impl DriveSystem {
    pub(crate) fn new(drive: &Drive, laws: &ForceLaws, start: &Start) -> rustchain::Result<Self> {
        let model = Arc::new(Model::compile(drive, laws, start)?);
        let mut dynamics = Dynamics::new(model.clone());
        let mut y = vec![0.0; dynamics.dimension()];
        let mut motion = Motion::new(model.bodies());
        motion.set(&start.positions, &start.velocities);
        motion.write(&model, &mut y);
        dynamics.remember_present_contacts(0.0, &y);
        dynamics.keep_energy(true);
        dynamics.evaluate(0.0, &y);
        Ok(Self {
            energy_at_start: dynamics.energy().total(),
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

    /// Energy missing and energy dissipated since the start \[J\].
    pub(crate) fn balance(&mut self, t: f64, y: &[f64]) -> [f64; 2] {
        self.dynamics.evaluate(t, y);
        let sums = self.dynamics.controlled();
        let [dissipated, worked_in] = [y[sums], y[sums + 1]];
        let gained = self.dynamics.energy().total() - self.energy_at_start;
        [gained + dissipated - worked_in, dissipated]
    }

    pub(crate) fn onsets(&self) -> u64 {
        self.dynamics.memory.counts().onsets
    }

    /// x, y, θ of all bodies, one after the other.
    pub(crate) fn positions(&mut self, t: f64, y: &[f64]) -> Vec<f64> {
        self.dynamics.evaluate(t, y);
        self.dynamics.motion.positions().concat()
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
        let contact = |depth: f64, rate: f64| rustchain::contact::Contact {
            normal: rustchain::geometry::Vec2::zeros(),
            penetration: depth,
            penetration_rate: rate,
        };
        let own = std::cell::RefCell::new(self);
        first_crossing(
            |t| {
                let (depth, rate) = own.borrow_mut().depth_at(step, t, &find);
                Some(contact(depth, rate))
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

    fn controlled(&self) -> usize {
        self.dynamics.controlled()
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
        for q in 2 * n..nq {
            let body = model.body_of_coordinate(q);
            if q < 3 * n {
                lengths[q] = model.half_pitch;
            } else if matches!(model.sprockets[body - n].rotation,
                rustchain::model::Rotation::Free { index, .. } if index == q)
            {
                let teeth = model.sprockets[body - n].gap_directions.len() as f64;
                lengths[q] = model.half_pitch / (std::f64::consts::PI / teeth).sin();
            }
        }
        let positions = lengths.iter().map(|length| 1.0 / length);
        let speeds = lengths.iter().map(|length| 1e5 / length);
        positions.chain(speeds).chain([f64::INFINITY; 2]).collect()
    }

    fn crossed(&mut self, _: &Accepted<'_>) -> bool {
        let (dynamics, memory) = (&self.dynamics, &self.dynamics.memory);
        let links = dynamics.model().links;
        self.hinges.clear();
        for (k, (depth, _)) in dynamics.hinge_contacts().enumerate() {
            let touching = depth > 0.0;
            if touching != (memory.hinge_speed()[k] > 0.0) {
                self.hinges.push((k, touching));
            }
        }
        self.teeth.clear();
        for (s, k, depth, _) in dynamics.candidates() {
            let (pair, touching) = (s * links + k, depth > 0.0);
            if touching != (memory.tooth_speed[pair] > 0.0) {
                self.teeth.push((pair, touching));
            }
        }
        !(self.hinges.is_empty() && self.teeth.is_empty())
    }

    fn remember(&mut self, step: &Accepted<'_>) {
        let (hinges, teeth) = (self.hinges.clone(), self.teeth.clone());
        for &(k, touching) in &hinges {
            if touching {
                let (_, rate) = self.onset(step, |d| (d.hinges.penetration[k], d.hinges.rate[k]));
                self.dynamics.memory.begin_hinge(k, rate);
            } else {
                self.dynamics.memory.end_hinge(k);
            }
        }
        let mut memory = self.dynamics.memory.clone();
        for &(pair, touching) in &teeth {
            if touching {
                let find = |d: &Dynamics| (d.teeth.penetration[pair], d.teeth.rate[pair]);
                let (t, rate) = self.onset(step, find);
                self.depth_at(step, t, find);
                memory.begin_tooth(pair, rate, self.dynamics.teeth.surface[pair]);
            } else {
                memory.end_tooth(pair);
            }
        }
        if !teeth.is_empty() {
            // Makes the candidates' list anew, with the memory that is put there.
            self.dynamics
                .remember_present_contacts(step.end, step.y_end);
            self.dynamics.memory = memory;
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
    component.extend([2 * nq, 2 * nq + 1]);
    let mut groups: Vec<Vec<usize>> = (0..5)
        .flat_map(|colour| {
            (0..6).map(move |c| (colour..n).step_by(5).map(|place| 6 * place + c).collect())
        })
        .collect();
    groups.extend((6 * n..2 * nq).map(|place| vec![place]));
    Pattern {
        component,
        half_width: 17,
        groups,
    }
}

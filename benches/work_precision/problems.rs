//! Problems with known answers: a planet, and a pin that bounces once.

use rustchain::force_law::{Elastic, ElasticPair, SurfacePair, damping_factor};
use rustchain::geometry::Contact;
use rustchain::geometry::Vec2;
use rustchain::integrator::event_location::onset_in_step;
use rustchain::integrator::{OdeSystem, SecondOrderSystem};

/// x'' = -x/|x|³ in the plane with eccentricity 0.6: after every period of 2π the planet is where it began.
#[derive(Default)]
pub(crate) struct Kepler {
    /// Inverse of Newton's matrix, row by row.
    inverse: [f64; 4],
}

impl Kepler {
    pub(crate) const START: [f64; 4] = [0.4, 0.0, 0.0, 2.0];
}

impl OdeSystem for Kepler {
    fn dimension(&self) -> usize {
        4
    }

    fn derivative(&mut self, _: f64, y: &[f64], dydt: &mut [f64]) {
        let squared = y[0] * y[0] + y[1] * y[1];
        let pull = 1.0 / (squared * squared.sqrt());
        dydt.copy_from_slice(&[y[2], y[3], -pull * y[0], -pull * y[1]]);
    }
}

impl SecondOrderSystem for Kepler {
    fn coordinates(&self) -> usize {
        2
    }

    fn factorise(&mut self, y: &[f64], gamma: f64) -> bool {
        let squared = y[0] * y[0] + y[1] * y[1];
        let share = gamma * gamma / (squared * squared.sqrt());
        let bend = 3.0 * share / squared;
        let (a, b) = (
            1.0 + share - bend * y[0] * y[0],
            1.0 + share - bend * y[1] * y[1],
        );
        let c = -bend * y[0] * y[1];
        let determinant = a * b - c * c;
        self.inverse = [b, -c, -c, a].map(|entry| entry / determinant);
        determinant != 0.0
    }

    fn correct(&mut self, residual: &mut [f64]) {
        let [a, b, c, d] = self.inverse;
        let [x, y] = [residual[0], residual[1]];
        residual[..2].copy_from_slice(&[a * x + b * y, c * x + d * y]);
    }

    fn scale(&self, lengths: &mut [f64]) {
        lengths.fill(1.0);
    }
}

/// A pin of a link's mass that flies into a bushing: y = [penetration, its rate], in units of the depth at which all energy is
/// stored and of the speed of approach; time in their ratio.
///
/// m δ'' = -K δ^1.5 (1 + λ δ'/v). Undamped, it parts after 2 √π Γ(7/5)/Γ(9/10) units at the speed it came with. Damped, the first
/// integral of the law gives the speed of parting e, λ (1 + e) = ln[(1 + λ)/(1 - λ e)].
pub(crate) struct Pin {
    lambda: f64,
    /// K depth^2.5/(m speed²) \[-\]: 5/4, whatever the pin.
    stiffness: f64,
    onset_speed: Option<f64>,
    /// Newton's matrix.
    matrix: f64,
}

impl Pin {
    /// Above the surface, at speed one.
    pub(crate) const START: [f64; 2] = [-0.05, 1.0];
    /// Time in contact without damping: 2 √π Γ(7/5)/Γ(9/10).
    pub(crate) const DURATION: f64 = 2.943_275_184_324_703;
    /// When a run ends, after the bounce.
    pub(crate) const END: f64 = 3.5;

    pub(crate) fn new(lambda: f64) -> Self {
        let (mass, speed) = (7e-3, 0.5);
        let surfaces = SurfacePair::internal(2.22e-3, 2.245e-3, 0.011, 2.07e11 / 1.82);
        let law = ElasticPair::prepare(Elastic::Hertz, &surfaces);
        let depth = (1.25 * mass * speed * speed / law.force(1.0)).powf(0.4);
        Self {
            lambda,
            stiffness: law.force(depth) * depth / (mass * speed * speed),
            onset_speed: None,
            matrix: 1.0,
        }
    }

    /// Error at the end: of the position without damping, of the speed with it.
    pub(crate) fn error(&self, y: &[f64]) -> f64 {
        if self.lambda == 0.0 {
            let flight = Self::END + Self::START[0] - Self::DURATION;
            (y[0] + flight).abs()
        } else {
            (y[1] + rustchain::force_law::effective_restitution(self.lambda)).abs()
        }
    }

    /// Looks for onset and end of the contact in a step; true when one was found.
    pub(crate) fn watch(
        &mut self,
        start: f64,
        end: f64,
        depth: f64,
        at: impl Fn(f64) -> [f64; 2],
    ) -> bool {
        let touching = depth > 0.0;
        if touching == self.onset_speed.is_some() {
            return false;
        }
        let path = |t: f64| {
            let [penetration, penetration_rate] = at(t);
            Contact {
                normal: Vec2::zeros(),
                penetration,
                penetration_rate,
            }
        };
        self.onset_speed = touching.then(|| onset_in_step(path, start, end).1);
        true
    }
}

impl OdeSystem for Pin {
    fn dimension(&self) -> usize {
        2
    }

    fn derivative(&mut self, _: f64, y: &[f64], dydt: &mut [f64]) {
        let depth = y[0].max(0.0);
        let onset_speed = self.onset_speed.unwrap_or_else(|| y[1].max(1e-3));
        let factor = damping_factor(self.lambda, y[1], onset_speed);
        dydt[0] = y[1];
        dydt[1] = -self.stiffness * depth * depth.sqrt() * factor;
    }
}

impl SecondOrderSystem for Pin {
    fn coordinates(&self) -> usize {
        1
    }

    fn factorise(&mut self, y: &[f64], gamma: f64) -> bool {
        let depth = y[0].max(0.0);
        // Before the onset is known, the damping factor does not depend on the speed.
        let (onset_speed, varies) = self.onset_speed.map_or((y[1].max(1e-3), 0.0), |v| (v, 1.0));
        let factor = damping_factor(self.lambda, y[1], onset_speed);
        let by_depth = -1.5 * self.stiffness * depth.sqrt() * factor;
        let by_rate = -varies * self.stiffness * depth * depth.sqrt() * self.lambda / onset_speed;
        self.matrix = 1.0 - gamma * by_rate - gamma * gamma * by_depth;
        self.matrix != 0.0
    }

    fn correct(&mut self, residual: &mut [f64]) {
        residual[0] /= self.matrix;
    }

    fn scale(&self, lengths: &mut [f64]) {
        lengths.fill(1.0);
    }
}

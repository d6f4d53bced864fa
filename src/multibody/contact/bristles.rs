//! Deflections of `LuGre` bristles, one for each side of a contact that has them, as unknowns of the ODE.
//!
//! The integrator's state is y = [q, Z, v, z, sums]: a deflection z stands among the velocities and its integral Z, which nobody
//! reads, among the coordinates, as in chain drives. In a step of Newton's method an evaluation solves z = foretold + γ dz/dt,
//! which is linear in z once the sliding velocity is known; the matrix of the bodies then holds z in its friction slope.

use crate::multibody::dynamics::MechanismDynamics;
use crate::multibody::model::MechanismModel;

/// All bristles of a mechanism.
#[derive(Debug, Clone, Default)]
pub(crate) struct Bristles {
    /// z of the last evaluation, given or solved for \[m\].
    pub(crate) deflection: Vec<f64>,
    /// dz/dt of the last evaluation \[m/s\].
    pub(crate) rate: Vec<f64>,
    /// What is known of z before an implicit step's own rate \[m\].
    foretold: Vec<f64>,
    /// γ of the implicit step under way \[s\]; none: deflections are those of the state.
    gamma: Option<f64>,
}

/// What one bristle begins an evaluation with.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Bent {
    /// Bent so far \[m\].
    Given(f64),
    /// To be solved for: foretold \[m\] and γ \[s\].
    Ahead(f64, f64),
}

impl Bristles {
    pub(crate) fn new(count: usize) -> Self {
        Self {
            deflection: vec![0.0; count],
            rate: vec![0.0; count],
            foretold: vec![0.0; count],
            gamma: None,
        }
    }

    /// Begins an evaluation: bristles of contacts that are apart stand still.
    pub(crate) fn begin(&mut self) {
        self.rate.fill(0.0);
        if self.gamma.is_some() {
            self.deflection.copy_from_slice(&self.foretold);
        }
    }

    /// What bristle `i` begins with.
    pub(crate) fn bent(&self, i: usize) -> Bent {
        match self.gamma {
            Some(gamma) => Bent::Ahead(self.foretold[i], gamma),
            None => Bent::Given(self.deflection[i]),
        }
    }

    /// Begins an implicit step, or ends it.
    pub(crate) fn begin_implicit_stage(&mut self, step: Option<(&[f64], f64)>) {
        self.gamma = step.map(|(_, gamma)| gamma);
        if let Some((foretold, _)) = step {
            self.foretold.copy_from_slice(foretold);
        }
    }
}

impl MechanismModel {
    /// Coordinates of the ODE: those of the bodies, then one for each bristle.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.coordinates() + self.bristles
    }

    /// Where a coordinate or velocity of the bodies, numbered in [q, v], stands in the integrator's state.
    pub(crate) fn component(&self, i: usize) -> usize {
        if i < self.coordinates() {
            i
        } else {
            i + self.bristles
        }
    }
}

impl MechanismDynamics {
    /// Reads [q, v] and the deflections from a state of the integrator.
    pub(crate) fn read(&mut self, y: &[f64], state: &mut [f64]) {
        let (n, count) = (self.model.coordinates(), self.model.bristles);
        if count == 0 {
            state.copy_from_slice(&y[..2 * n]);
            return;
        }
        state[..n].copy_from_slice(&y[..n]);
        let velocities = n + count;
        state[n..2 * n].copy_from_slice(&y[velocities..velocities + n]);
        let z = velocities + n;
        self.bristles.deflection.copy_from_slice(&y[z..z + count]);
    }

    /// The state of the integrator with all bristles unbent and without energy sums, of [q, v].
    pub(crate) fn with_bristles(&self, state: &[f64]) -> Vec<f64> {
        let (q, v) = state.split_at(self.model.coordinates());
        let unbent = vec![0.0; self.model.bristles];
        let sums = [0.0; 2];
        [q, &unbent, v, &unbent, &sums].concat()
    }

    /// Bristles of sides that do not touch where everything was evaluated last, and that are still bent.
    pub(crate) fn parted_bristles(&self) -> impl Iterator<Item = usize> {
        let sides = self.touches.iter().zip(&self.model.bristle_of_side);
        sides.filter_map(|(touch, bristle)| bristle.filter(|_| touch.contact.penetration <= 0.0))
    }
}

//! Deflections of `LuGre` bristles, one for each side of a contact with this friction law, as unknowns of the ODE.
//!
//! The integrator's state is y = [q, Z, v, z, sums]. A deflection z is one of the velocities, and its integral Z, which is unused,
//! one of the coordinates, as in chain drives. In an implicit step an evaluation solves z = z₀ + γ dz/dt with the predicted value
//! z₀. This equation is linear in z for a given sliding velocity. The friction slope in the matrix of the bodies includes z.

use crate::multibody::dynamics::MechanismDynamics;
use crate::multibody::model::MechanismModel;
use crate::system::PowerSum;

/// All bristles of a mechanism.
#[derive(Debug, Clone, Default)]
pub(crate) struct Bristles {
    /// Deflections z of the last evaluation, given or solved for \[m\].
    pub(crate) deflection: Vec<f64>,
    /// Rates dz/dt of the last evaluation \[m/s\].
    pub(crate) rate: Vec<f64>,
    /// Predicted values z₀ of an implicit step, without the contribution of its own rate \[m\].
    foretold: Vec<f64>,
    /// γ of the present implicit step \[s\]; `None`: the deflections are those of the state.
    gamma: Option<f64>,
}

/// Deflection of one bristle at the beginning of an evaluation.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Bent {
    /// Deflection of the state \[m\].
    Given(f64),
    /// Deflection to be solved for, with its predicted value \[m\] and γ \[s\].
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

    /// Begin an evaluation. The rates are zero for bristles of contacts that are apart.
    pub(crate) fn begin(&mut self) {
        self.rate.fill(0.0);
        if self.gamma.is_some() {
            self.deflection.copy_from_slice(&self.foretold);
        }
    }

    /// Return the deflection of bristle `i` at the beginning of the evaluation.
    pub(crate) fn bent(&self, i: usize) -> Bent {
        match self.gamma {
            Some(gamma) => Bent::Ahead(self.foretold[i], gamma),
            None => Bent::Given(self.deflection[i]),
        }
    }

    /// Begin an implicit step with predicted values \[m\] and γ \[s\], or end it with `None`.
    pub(crate) fn begin_implicit_stage(&mut self, step: Option<(&[f64], f64)>) {
        self.gamma = step.map(|(_, gamma)| gamma);
        if let Some((foretold, _)) = step {
            self.foretold.copy_from_slice(foretold);
        }
    }

    /// Read [q, v] and the deflections from a state of the integrator.
    pub(crate) fn read(&mut self, model: &MechanismModel, y: &[f64], state: &mut [f64]) {
        let (n, count) = (model.coordinates(), model.bristles);
        if count == 0 {
            state.copy_from_slice(&y[..2 * n]);
            return;
        }
        state[..n].copy_from_slice(&y[..n]);
        let velocities = n + count;
        state[n..2 * n].copy_from_slice(&y[velocities..velocities + n]);
        let z = velocities + n;
        self.deflection.copy_from_slice(&y[z..z + count]);
    }
}

impl MechanismModel {
    /// Return the number of coordinates of the ODE: those of the bodies, then one for each bristle.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.coordinates() + self.bristles
    }

    /// Return the index in the integrator's state of component `i` of [q, v] of the bodies.
    pub(crate) fn component(&self, i: usize) -> usize {
        if i < self.coordinates() {
            i
        } else {
            i + self.bristles
        }
    }
}

impl MechanismDynamics {
    /// Return the integrator's state for [q, v] with the present deflections and energy sums.
    pub(crate) fn solution_of(&self, state: &[f64]) -> Vec<f64> {
        let (q, v) = state.split_at(self.model.coordinates());
        let unused = vec![0.0; self.model.bristles];
        [
            q,
            &unused,
            v,
            &self.contacts.bristles.deflection,
            &self.sums.totals(),
        ]
        .concat()
    }
}

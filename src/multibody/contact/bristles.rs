//! Deflections of `LuGre` bristles, one for each side of a contact with this friction law, as unknowns of the ODE.
//!
//! The integrator's state is y = [q, Z, v, z, sums]. A deflection z is one of the velocities, and its integral Z, which is unused,
//! one of the coordinates, as in chain drives. In an implicit step an evaluation solves z = z₀ + γ dz/dt with the predicted value
//! z₀. This equation is linear in z for a given sliding velocity. The friction slope in the matrix of the bodies includes z.

use crate::multibody::model::MechanismModel;

/// All bristles of a mechanism.
#[derive(Debug, Clone, Default)]
pub(crate) struct ContactBristles {
    /// Deflections z of the last evaluation, given or solved for \[m\].
    pub(crate) deflection: Vec<f64>,
    /// Rates dz/dt of the last evaluation \[m/s\].
    pub(crate) rate: Vec<f64>,
    /// Predicted values z₀ of an implicit step, without the contribution of its own rate \[m\].
    predicted: Vec<f64>,
    /// γ of the present implicit step \[s\]; `None`: the deflections are those of the state.
    gamma: Option<f64>,
}

/// Deflection of one bristle at the beginning of an evaluation.
#[derive(Debug, Clone, Copy)]
pub(crate) enum BristleDeflection {
    /// Deflection of the state \[m\].
    Given(f64),
    /// Deflection to be solved for, with its predicted value \[m\] and γ \[s\].
    Ahead(f64, f64),
}

impl ContactBristles {
    pub(crate) fn new(count: usize) -> Self {
        Self {
            deflection: vec![0.0; count],
            rate: vec![0.0; count],
            predicted: vec![0.0; count],
            gamma: None,
        }
    }

    /// Begin an evaluation. The rates are zero for bristles of contacts that are apart.
    pub(crate) fn begin(&mut self) {
        self.rate.fill(0.0);
        if self.gamma.is_some() {
            self.deflection.copy_from_slice(&self.predicted);
        }
    }

    /// Return the deflection of bristle `i` at the beginning of the evaluation.
    pub(crate) fn bent(&self, i: usize) -> BristleDeflection {
        match self.gamma {
            Some(gamma) => BristleDeflection::Ahead(self.predicted[i], gamma),
            None => BristleDeflection::Given(self.deflection[i]),
        }
    }

    /// Begin an implicit step with predicted values \[m\] and γ \[s\], or end it with `None`.
    pub(crate) fn begin_implicit_stage(&mut self, step: Option<(&[f64], f64)>) {
        self.gamma = step.map(|(_, gamma)| gamma);
        if let Some((predicted, _)) = step {
            self.predicted.copy_from_slice(predicted);
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

#[cfg(test)]
mod tests {
    use super::super::tests::{self, bristled};
    use super::*;
    use crate::multibody::dynamics::MechanismDynamics;
    use std::sync::Arc;

    /// Return the model of two bodies with `count` contacts with bristles.
    fn model(count: usize) -> MechanismModel {
        let pairs = (0..count).map(|k| bristled(&format!("contact {k}")));
        tests::model(pairs.collect())
    }

    #[test]
    fn bodies_and_deflections_written_to_a_solution_are_read_again() {
        for count in [0, 3] {
            let model = Arc::new(model(count));
            // Three coordinates for each body, and one for each bristle.
            assert_eq!(model.unknowns(), 6 + count);
            let mut dynamics = MechanismDynamics::new(Arc::clone(&model));
            let state: Vec<f64> = (0..12).map(|i| 1.0 + f64::from(i)).collect();
            let bent: Vec<f64> = (0..count).map(|i| -0.5 - i as f64).collect();
            dynamics.contacts.bristles.deflection.clone_from(&bent);
            dynamics.sums.dissipated = 77.0;
            dynamics.sums.external_work = 78.0;
            let y = dynamics.solution_of(&state);
            assert_eq!(y.len(), 2 * (6 + count) + 2);
            assert_eq!(y[y.len() - 2..], [77.0, 78.0]);
            for (i, x) in state.iter().enumerate() {
                assert_eq!(y[model.component(i)], *x);
            }
            let mut bristles = ContactBristles::new(count);
            let mut read = vec![0.0; 12];
            bristles.read(&model, &y, &mut read);
            assert_eq!((read, bristles.deflection), (state, bent));
        }
    }

    #[test]
    fn deflections_are_given_or_predicted_in_an_implicit_stage() {
        let mut bristles = ContactBristles::new(2);
        bristles.deflection.copy_from_slice(&[1.0, 2.0]);
        bristles.rate.fill(5.0);
        bristles.begin();
        assert_eq!(
            (bristles.rate.clone(), bristles.deflection.clone()),
            (vec![0.0; 2], vec![1.0, 2.0])
        );
        assert!(matches!(bristles.bent(1), BristleDeflection::Given(2.0)));
        bristles.begin_implicit_stage(Some((&[3.0, 4.0], 0.5)));
        bristles.begin();
        assert_eq!(bristles.deflection, [3.0, 4.0]);
        assert!(matches!(
            bristles.bent(1),
            BristleDeflection::Ahead(4.0, 0.5)
        ));
        bristles.begin_implicit_stage(None);
        bristles.begin();
        assert!(matches!(bristles.bent(0), BristleDeflection::Given(3.0)));
    }
}

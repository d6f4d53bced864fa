//! Bristles of all contacts: deflections, stored energy, and their reset at the contact end.
//!
//! A bristle is deflected during its contact. After the contact end its deflection has no effect. Before the next step the deflection and
//! its history in the integrator are set to zero, so that no discontinuity remains.

use super::{Dynamics, Losses};
use crate::chain::contact::ContactId;
use crate::chain::model::Model;
use crate::force_law::LuGre;
use crate::integrator::Adams;

/// Deflections of bristles and their rates: hinges, then rollers, then teeth, in the order of
/// [`BristlePlaces`](crate::chain::model::BristlePlaces); empty without bristle friction.
#[derive(Debug, Clone, Default)]
pub struct Bristles {
    /// Deflection z \[m\].
    pub deflection: Vec<f64>,
    /// Rate dz/dt at the last evaluation \[m/s\].
    pub rate: Vec<f64>,
}

impl Bristles {
    /// Create deflections of zero for all bristles of `model`.
    pub(super) fn of(model: &Model) -> Self {
        let zeros = || vec![0.0; model.bristles.all().len()];
        Self {
            deflection: zeros(),
            rate: zeros(),
        }
    }

    /// Read the deflections from the state `y`.
    pub(crate) fn read(&mut self, model: &Model, y: &[f64]) {
        let all = &y[model.coordinates..2 * model.coordinates][model.bristles.all()];
        self.deflection.copy_from_slice(all);
    }

    /// Write the deflections into the state `y`.
    pub(crate) fn write(&self, model: &Model, y: &mut [f64]) {
        let all = &mut y[model.coordinates..2 * model.coordinates][model.bristles.all()];
        all.copy_from_slice(&self.deflection);
    }

    /// Set all deflections to zero.
    pub(crate) fn clear(&mut self) {
        self.deflection.fill(0.0);
    }
}

/// Energy stored in the bristles \[J\].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Stored {
    /// Bristles of hinges.
    pub hinges: f64,
    /// Bristles of rollers.
    pub rollers: f64,
    /// Bristles of teeth.
    pub teeth: f64,
}

impl Stored {
    /// Return the sum.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.hinges + self.rollers + self.teeth
    }

    /// Return losses without the stored energy: the integral of the friction power contains both.
    pub(crate) fn subtract_from(&self, losses: Losses) -> Losses {
        Losses {
            hinge_friction: losses.hinge_friction - self.hinges,
            roller_friction: losses.roller_friction - self.rollers,
            tooth_friction: losses.tooth_friction - self.teeth,
            ..losses
        }
    }
}

impl Dynamics {
    /// Return the energy stored in the bristles at the last evaluation.
    #[must_use]
    pub fn stored(&self) -> Stored {
        let places = &self.model.bristles;
        let first = places.hinges.start;
        let stored = |law: Option<LuGre>, number: usize, force: f64| {
            law.map_or(0.0, |law| {
                force * law.stored(self.evaluated.bristles.deflection[number])
            })
        };
        let hinge = self.model.hinges.bristles;
        let of_hinges = places.hinges.clone().zip(&self.evaluated.hinges.force);
        let of_rollers = places.rollers.clone().zip(&self.evaluated.rollers.force);
        let mut all = Stored {
            hinges: of_hinges
                .map(|(i, &force)| stored(hinge, i - first, force))
                .sum(),
            rollers: of_rollers
                .map(|(i, &force)| stored(hinge, i - first, force))
                .sum(),
            teeth: 0.0,
        };
        let law = self.model.teeth.bristles;
        if law.is_some() {
            for &pair in &self.evaluated.teeth.near {
                let pair = pair as usize;
                let number = places.teeth.start - first + pair;
                all.teeth += stored(law, number, self.evaluated.teeth.force[pair]);
            }
        }
        all
    }

    /// Reset the bristles of contacts that ended in the last step, with their history; call before [`Self::forget_ended_contacts`].
    pub(crate) fn reset_bristles_of_ended_contacts(&mut self, adams: &mut Adams) {
        if self.model.bristles.is_empty() {
            return;
        }
        for i in 0..self.events.ended.len() {
            if let Some(coordinate) = self.bristle_of(self.events.ended[i]) {
                for component in [coordinate, self.model.coordinates + coordinate] {
                    adams.reset_component(component);
                }
            }
        }
    }

    /// Set the deflections of all open contacts at time `t` \[s\] to zero in the state `y`.
    pub(crate) fn unbend_open(&mut self, t: f64, y: &mut [f64]) {
        if self.model.bristles.is_empty() {
            return;
        }
        self.evaluate(t, y);
        let places = &self.model.bristles;
        let mut unbend = |coordinate: usize, depth: f64| {
            if depth <= 0.0 {
                y[coordinate] = 0.0;
                y[self.model.coordinates + coordinate] = 0.0;
            }
        };
        for (i, &depth) in places
            .hinges
            .clone()
            .zip(&self.evaluated.hinges.penetration)
        {
            unbend(i, depth);
        }
        for (i, &depth) in places
            .rollers
            .clone()
            .zip(&self.evaluated.rollers.penetration)
        {
            unbend(i, depth);
        }
        for (i, &depth) in places.teeth.clone().zip(&self.evaluated.teeth.penetration) {
            unbend(i, depth);
        }
    }

    /// Return the coordinate of a pair's bristle; `None` for a pair without bristle.
    fn bristle_of(&self, pair: ContactId) -> Option<usize> {
        let places = &self.model.bristles;
        let (range, number) = match pair {
            ContactId::Hinge(k) => (&places.hinges, k),
            ContactId::Roller(k) => (&places.rollers, k),
            ContactId::Tooth(pair) => (&places.teeth, pair),
        };
        (number < range.len()).then(|| range.start + number)
    }
}

//! Powers of the energy balance: dissipated power by kind of contact, and external power.

use serde::{Deserialize, Serialize};

use crate::system::PowerSum;

/// Powers dissipated in contacts \[W\], or their integrals over time \[J\].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Losses {
    /// Damping of pins in bushings.
    pub hinge_contact: f64,
    /// Damping of bushings on teeth.
    pub tooth_contact: f64,
    /// Friction of pins in bushings.
    pub hinge_friction: f64,
    /// Friction of bushings on teeth.
    pub tooth_friction: f64,
    /// Damping of bushings in rollers.
    pub roller_contact: f64,
    /// Friction of bushings in rollers.
    pub roller_friction: f64,
    /// Lubricant film between pins and bushings.
    pub hinge_film: f64,
}

impl Losses {
    /// Return all values, in the order of the fields.
    #[must_use]
    pub fn values(&self) -> [f64; 7] {
        [
            self.hinge_contact,
            self.tooth_contact,
            self.hinge_friction,
            self.tooth_friction,
            self.roller_contact,
            self.roller_friction,
            self.hinge_film,
        ]
    }
}

/// Power dissipated in contacts and dashpots, and external power \[W\], or their integrals over time \[J\].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Powers {
    /// Total dissipated power, in contacts and dashpots.
    pub dissipated: f64,
    /// External power of motors, applied torques, tensioner and moving ends.
    pub external_work: f64,
    /// Dissipated power by kind of contact.
    pub losses: Losses,
}

impl Powers {
    /// Return the powers of contacts alone, without dashpots and external power.
    pub(crate) fn of(losses: Losses) -> Self {
        Self {
            dissipated: losses.hinge_contact
                + losses.tooth_contact
                + (losses.hinge_friction + losses.tooth_friction)
                + (losses.roller_contact + losses.roller_friction)
                + losses.hinge_film,
            external_work: 0.0,
            losses,
        }
    }
}

impl PowerSum for Powers {
    fn add_scaled(&mut self, factor: f64, other: &Self) {
        *self = Self::combined([(1.0, &*self), (factor, other)]);
    }

    /// Each sum stays in a register.
    fn combined<const N: usize>(terms: [(f64, &Self); N]) -> Self {
        let sum = |of: fn(&Self) -> f64| terms.iter().fold(0.0, |sum, (f, p)| sum + f * of(p));
        Self {
            dissipated: sum(|p| p.dissipated),
            external_work: sum(|p| p.external_work),
            losses: Losses {
                hinge_contact: sum(|p| p.losses.hinge_contact),
                tooth_contact: sum(|p| p.losses.tooth_contact),
                hinge_friction: sum(|p| p.losses.hinge_friction),
                tooth_friction: sum(|p| p.losses.tooth_friction),
                roller_contact: sum(|p| p.losses.roller_contact),
                roller_friction: sum(|p| p.losses.roller_friction),
                hinge_film: sum(|p| p.losses.hinge_film),
            },
        }
    }

    fn totals(&self) -> [f64; 2] {
        [self.dissipated, self.external_work]
    }

    fn with_external(self, external_work: f64) -> Self {
        Self {
            external_work,
            ..self
        }
    }
}

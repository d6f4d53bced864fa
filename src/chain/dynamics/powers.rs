//! Powers of the energy balance: what is dissipated, where, and what is put in.

use serde::{Deserialize, Serialize};

use crate::system::PowerSum;

/// Powers dissipated in contacts \[W\]; integrated, the energies \[J\].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Losses {
    /// By the damping of pins in bushings.
    pub hinge_contact: f64,
    /// By the damping of bushings on teeth.
    pub tooth_contact: f64,
    /// By friction of pins in bushings.
    pub hinge_friction: f64,
    /// By friction of bushings on teeth.
    pub tooth_friction: f64,
    /// By the damping of bushings in rollers.
    pub roller_contact: f64,
    /// By friction of bushings in rollers.
    pub roller_friction: f64,
    /// By lubricant between pins and bushings.
    pub hinge_film: f64,
}

impl Losses {
    /// All of them, in the order of the fields.
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

    fn of_values(values: [f64; 7]) -> Self {
        let [
            hinge_contact,
            tooth_contact,
            hinge_friction,
            tooth_friction,
            roller_contact,
            roller_friction,
            hinge_film,
        ] = values;
        Self {
            hinge_contact,
            tooth_contact,
            hinge_friction,
            tooth_friction,
            roller_contact,
            roller_friction,
            hinge_film,
        }
    }
}

/// Power dissipated in contacts and dashpots, and power put in from outside \[W\]; integrated, the energies \[J\].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Powers {
    /// Dissipated, everywhere.
    pub dissipated: f64,
    /// Put in by motors, torques and the tensioner.
    pub worked_in: f64,
    /// What contacts have of it.
    pub losses: Losses,
}

impl Powers {
    /// Of contacts alone.
    pub(crate) fn of(losses: Losses) -> Self {
        Self {
            dissipated: losses.hinge_contact
                + losses.tooth_contact
                + (losses.hinge_friction + losses.tooth_friction)
                + (losses.roller_contact + losses.roller_friction)
                + losses.hinge_film,
            worked_in: 0.0,
            losses,
        }
    }
}

impl std::ops::AddAssign for Powers {
    fn add_assign(&mut self, other: Self) {
        self.dissipated += other.dissipated;
        self.worked_in += other.worked_in;
        let (mut losses, others) = (self.losses.values(), other.losses.values());
        for (loss, other) in losses.iter_mut().zip(others) {
            *loss += other;
        }
        self.losses = Losses::of_values(losses);
    }
}

impl std::ops::Add for Powers {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl PowerSum for Powers {
    fn scaled(self, factor: f64) -> Self {
        Self {
            dissipated: factor * self.dissipated,
            worked_in: factor * self.worked_in,
            losses: Losses::of_values(self.losses.values().map(|loss| factor * loss)),
        }
    }

    fn totals(&self) -> [f64; 2] {
        [self.dissipated, self.worked_in]
    }
}

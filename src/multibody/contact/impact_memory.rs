//! What happens on one side of a contact's profile, and what it remembers from its onset.

use serde::{Deserialize, Serialize};

use super::outline::Place;
use crate::geometry::Contact;
use crate::geometry::Vec2;
use crate::multibody::description::profile::Tooth;

/// What a live contact remembers of one side of its profile from its onset: written between steps only.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct Memory {
    /// Approach speed \[m/s\]; zero: no memory; below zero: behind an open outline, until it has come out.
    pub(crate) speed: f64,
    /// The piece it began on, whose stiffness it keeps.
    pub(crate) piece: usize,
    /// Whether it bears on the front of an open outline: from there it may sink in however deep.
    pub(crate) in_front: bool,
}

/// A contact with one side of its profile at one state; out of reach, its penetration is -∞.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Touch {
    /// Where it is deepest.
    pub(crate) contact: Contact,
    pub(crate) piece: usize,
    pub(crate) place: Place,
    /// Where among teeth, when it is near them.
    pub(crate) tooth: Option<Tooth>,
    /// Normal force \[N\].
    pub(crate) force: f64,
    /// Normal force on the circle \[N\].
    pub(crate) push: Vec2,
    /// Force on the circle by friction and film \[N\].
    pub(crate) friction: Vec2,
}

impl Default for Touch {
    fn default() -> Self {
        Self {
            contact: Contact {
                normal: Vec2::zeros(),
                penetration: f64::NEG_INFINITY,
                penetration_rate: 0.0,
            },
            piece: 0,
            place: Place::Front,
            tooth: None,
            force: 0.0,
            push: Vec2::zeros(),
            friction: Vec2::zeros(),
        }
    }
}

impl Touch {
    /// Whether anything was found out about it.
    pub(crate) fn is_known(&self) -> bool {
        self.contact.penetration > f64::NEG_INFINITY || self.push != Vec2::zeros()
    }
}

impl Memory {
    /// Of a circle behind an open outline, which it did not come through.
    pub(crate) const BEHIND: Self = Self {
        speed: -1.0,
        piece: 0,
        in_front: false,
    };
}

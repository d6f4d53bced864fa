//! State of a contact on one side of its profile, and its impact velocity memory.

use serde::{Deserialize, Serialize};

use super::outline::OutlinePlace;
use crate::geometry::Contact;
use crate::geometry::Vec2;
use crate::multibody::description::profile::Tooth;

/// Impact velocity memory of one side of a contact's profile, written between steps only.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct Memory {
    /// Initial impact velocity \[m/s\]. Zero means no memory. A negative value means that the circle is behind an open outline;
    /// it remains until the circle is outside.
    pub(crate) speed: f64,
    /// Number of the piece at the onset; its stiffness is used until the contact ends.
    pub(crate) piece: usize,
    /// Whether the circle came from the front of an open outline, from where the penetration has no limit.
    pub(crate) in_front: bool,
}

/// Contact with one side of a profile at one state; the penetration is -∞ out of reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SideState {
    /// Normal, penetration and penetration rate at the point of largest penetration.
    pub(crate) contact: Contact,
    pub(crate) piece: usize,
    pub(crate) place: OutlinePlace,
    /// Tooth gap and region, if the circle is near the teeth of a sprocket.
    pub(crate) tooth: Option<Tooth>,
    /// Normal force \[N\].
    pub(crate) force: f64,
    /// Normal force on the circle \[N\].
    pub(crate) push: Vec2,
    /// The same without the gradients of weights between two sides, which cancel over both \[N\]: friction is a part of it.
    pub(crate) pressing: Vec2,
    /// Force on the circle by friction and film \[N\].
    pub(crate) friction: Vec2,
}

impl Default for SideState {
    fn default() -> Self {
        Self {
            contact: Contact {
                normal: Vec2::zeros(),
                penetration: f64::NEG_INFINITY,
                penetration_rate: 0.0,
            },
            piece: 0,
            place: OutlinePlace::Front,
            tooth: None,
            force: 0.0,
            push: Vec2::zeros(),
            pressing: Vec2::zeros(),
            friction: Vec2::zeros(),
        }
    }
}

impl SideState {
    /// Return whether the evaluation found a contact point or a force.
    pub(crate) fn is_known(&self) -> bool {
        self.contact.penetration > f64::NEG_INFINITY || self.push != Vec2::zeros()
    }
}

impl Memory {
    /// Return whether the side had an onset and no contact end since.
    pub(crate) fn is_in_contact(&self) -> bool {
        self.speed > 0.0
    }

    /// Return whether the circle is behind an open outline.
    pub(crate) fn is_behind(&self) -> bool {
        self.speed < 0.0
    }

    /// Return whether there is no memory.
    pub(crate) fn is_empty(&self) -> bool {
        self.speed == 0.0
    }

    /// Memory of a circle behind an open outline that did not come through the surface.
    pub(crate) const BEHIND: Self = Self {
        speed: -1.0,
        piece: 0,
        in_front: false,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_memory_is_of_a_contact_of_a_back_or_empty() {
        let of = |speed: f64| {
            let memory = Memory {
                speed,
                ..Memory::default()
            };
            [
                memory.is_in_contact(),
                memory.is_behind(),
                memory.is_empty(),
            ]
        };
        assert_eq!(of(f64::MIN_POSITIVE), [true, false, false]);
        assert_eq!(of(0.0), [false, false, true]);
        assert_eq!(of(Memory::BEHIND.speed), [false, true, false]);
    }

    #[test]
    fn a_side_is_known_by_its_contact_point_or_its_force() {
        assert!(!SideState::default().is_known());
        let mut near = SideState::default();
        near.contact.penetration = -3.0;
        let pushed = SideState {
            push: Vec2::new(0.0, -1.0),
            ..SideState::default()
        };
        assert!(near.is_known() && pushed.is_known());
    }
}

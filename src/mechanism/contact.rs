//! Contacts of a mechanism: a circle of body b against a profile of body a; a pin in a bore is the clearance joint.

use serde::{Deserialize, Serialize};

use super::body::{End, Frame, Marker};
use super::contact_law::{ContactLaw, Prepared};
use super::loads::Loads;
use super::profile::{Nearest, Profile, Tooth};
use crate::contact::Contact;
use crate::error::{Result, check};
use crate::geometry::{Vec2, turned_left};

/// A circle that may touch a profile.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPair {
    /// Unique name.
    pub name: String,
    /// Origin of the profile.
    pub a: Marker,
    /// Centre of the circle.
    pub b: Marker,
    /// The shape on `a`, in the frame of `a` around the point of the marker.
    pub profile: Profile,
    /// Radius of the circle \[m\].
    pub radius: f64,
    /// How hard they press.
    pub law: ContactLaw,
}

impl ContactPair {
    /// Checks every field.
    ///
    /// # Errors
    /// Names the contact, the field and what is allowed.
    pub fn validate(&self) -> Result<()> {
        let field = format!("contact {:?}", self.name);
        for marker in [&self.a, &self.b] {
            for value in [marker.point.x, marker.point.y] {
                check::finite(&format!("point of {field}"), value, "m")?;
            }
        }
        check::positive(&format!("radius of {field}"), self.radius, "m")?;
        self.profile.validate(&field)?;
        self.law.validate(&field)
    }
}

/// Part of its radius that a circle near a profile may move by in one step: none passes through another unseen.
const FARTHEST: f64 = 0.25;

/// A contact whose bodies are numbers, with the constants of each piece of its profile.
#[derive(Debug, Clone)]
pub(super) struct CompiledContact {
    pub(super) a: End,
    pub(super) b: End,
    profile: Profile,
    radius: f64,
    /// Distance of the markers from which on they are apart; infinite for what has no outside.
    reach: f64,
    pairs: Vec<Prepared>,
}

/// What a live contact remembers from its onset: written between steps only.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Memory {
    /// Approach speed \[m/s\]; zero: no memory; below zero: behind an open outline, until it has come out.
    pub(super) speed: f64,
    /// The piece it began on, whose stiffness it keeps.
    pub(super) piece: usize,
}

/// A contact at one state; out of reach, its penetration is -∞.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Touch {
    pub(super) contact: Contact,
    pub(super) piece: usize,
    /// Where among teeth, when it is near them.
    pub(super) tooth: Option<Tooth>,
    /// Normal force \[N\].
    pub(super) force: f64,
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
            tooth: None,
            force: 0.0,
        }
    }
}

impl Memory {
    /// Of a circle behind an open outline, which it did not come through.
    pub(super) const BEHIND: Self = Self {
        speed: -1.0,
        piece: 0,
    };
}

impl CompiledContact {
    pub(super) fn new(pair: &ContactPair, a: End, b: End) -> Result<Self> {
        let field = format!("contact {:?}", pair.name);
        let prepare = |curvature| pair.law.prepare(&field, pair.radius, curvature);
        Ok(Self {
            a,
            b,
            pairs: pair
                .profile
                .curvatures()
                .into_iter()
                .map(prepare)
                .collect::<Result<_>>()?,
            reach: pair.profile.reach() + pair.radius,
            profile: pair.profile.clone(),
            radius: pair.radius,
        })
    }

    /// Depth and rate, and the place nearest; the normal points into the profile's material.
    ///
    /// A contact that has begun stays one however deep it is; what is behind an open outline does not touch it.
    pub(super) fn find(&self, fa: &Frame, fb: &Frame, memory: Memory) -> (Contact, Nearest) {
        let center = fb.place(self.b.point);
        let local = fa.into_local(center - fa.place(self.a.point));
        let nearest = self.profile.nearest(local, self.radius);
        let normal = -fa.turned(nearest.outward);
        // Both bodies' velocities along the normal are the same anywhere on it, so at the centre too.
        let approach = fb.velocity_at(center) - fa.velocity_at(center);
        let depth = self.radius - nearest.distance;
        let begun = memory.speed > 0.0;
        let behind = memory.speed < 0.0 && depth > 0.0 || depth > 2.0 * self.radius;
        let penetration = if self.is_open() && behind && !begun {
            f64::NEG_INFINITY
        } else {
            depth
        };
        let contact = Contact {
            normal,
            penetration,
            penetration_rate: normal.dot(&approach),
        };
        (contact, nearest)
    }

    /// The same as it is recorded.
    pub(super) fn penetration(&self, frames: &[Frame], memory: Memory) -> f64 {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let (contact, _) = self.find(fa, fb, memory);
        contact.penetration
    }

    /// Adds the loads of the contact, its stored energy and what it loses; returns it.
    pub(super) fn add(&self, frames: &[Frame], memory: Memory, loads: &mut Loads) -> Touch {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let apart = fb.place(self.b.point) - fa.place(self.a.point);
        if apart.norm_squared() > self.reach * self.reach {
            return Touch::default();
        }
        let (contact, Nearest { piece, tooth, .. }) = self.find(fa, fb, memory);
        if contact.penetration <= 0.0 {
            return Touch {
                contact,
                piece,
                tooth,
                force: 0.0,
            };
        }
        let pair = &self.pairs[if memory.speed > 0.0 {
            memory.piece
        } else {
            piece
        }];
        let force = pair.force(contact.penetration, contact.penetration_rate, memory.speed);
        let center = fb.place(self.b.point);
        let push = force.total * contact.normal;
        loads.push(self.b.body, fb, center, -push);
        loads.push(self.a.body, fa, center, push);
        loads.elastic += pair.energy(contact.penetration);
        loads.dissipated += (force.total - force.elastic) * contact.penetration_rate;
        Touch {
            contact,
            piece,
            tooth,
            force: force.total,
        }
    }

    /// How far the circle may move along the profile \[m\] before its distance has to be looked at again: its gap, and
    /// where that is small a part of its radius.
    pub(super) fn free_way(&self, frames: &[Frame]) -> f64 {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let apart = (fb.place(self.b.point) - fa.place(self.a.point)).norm();
        let gap = if apart > self.reach {
            apart - self.reach
        } else {
            let (contact, nearest) = self.find(fa, fb, Memory::default());
            if contact.penetration == f64::NEG_INFINITY {
                -nearest.distance - self.radius
            } else {
                nearest.distance - self.radius
            }
        };
        gap.max(FARTHEST * self.radius)
    }

    /// Speed \[m/s\] and acceleration \[m/s²\] of the circle's centre as seen from the profile, of bodies that accelerate so.
    pub(super) fn relative_motion(&self, frames: &[Frame], rates: [[f64; 3]; 2]) -> (f64, f64) {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let center = fb.place(self.b.point);
        let speed = (fb.velocity_at(center) - fa.velocity_at(center)).norm();
        let accelerated = |frame: &Frame, [x, y, spin]: [f64; 3]| {
            let arm = center - frame.origin;
            Vec2::new(x, y) + spin * turned_left(arm) - frame.spin * frame.spin * arm
        };
        let acceleration = accelerated(fb, rates[1]) - accelerated(fa, rates[0]);
        (speed, acceleration.norm())
    }

    /// Whether the circle is in the material of an open outline, or beyond, without having come through the surface.
    pub(super) fn is_behind(&self, fa: &Frame, fb: &Frame, memory: Memory) -> bool {
        self.is_open() && self.find(fa, fb, memory).0.penetration == f64::NEG_INFINITY
    }

    fn is_open(&self) -> bool {
        matches!(self.profile, Profile::Outline { closed: false, .. })
    }

    /// What a contact that began on `piece` at `rate` remembers.
    pub(super) fn remember(&self, piece: usize, rate: f64) -> Memory {
        Memory {
            speed: self.pairs[piece].onset_speed(rate),
            piece,
        }
    }
}

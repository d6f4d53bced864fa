//! Applied forces, springs and dampers: loads on the bodies, stored energy and powers.

use std::sync::Arc;

use super::body::{End, Frame, Marker};
use super::spring_law::SpringLaw;
use crate::error::{Error, Result, check};
use crate::geometry::{Vec2, direction};
use crate::math::{Signal, Table};
use crate::multibody::GROUND;
use crate::multibody::forces::loads::BodyLoads;

/// A force or torque between body `a` and body `b`.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceElement {
    /// Unique name.
    pub name: String,
    /// Point of action of the reaction.
    pub a: Marker,
    /// Point of action of the force.
    pub b: Marker,
    /// Type of the element.
    pub kind: ForceKind,
}

/// Type of a force element.
#[derive(Debug, Clone, PartialEq)]
pub enum ForceKind {
    /// A force on point b \[N\], without a reaction on `a`.
    Force {
        /// Component along x.
        x: Signal,
        /// Component along y.
        y: Signal,
        /// Whether the components are in the frame of the body, which rotates, instead of the ground's frame.
        follows: bool,
    },
    /// A torque on `b`, its reaction on `a` \[N m\].
    Torque(Signal),
    /// A torque on `b`, its reaction on `a` \[N m\], by the angular velocity of `b` relative to `a` \[rad/s\].
    TorqueBySpeed(Table),
    /// A spring and damper between the points.
    Spring {
        /// Force as a function of the elongation.
        law: SpringLaw,
        /// Length at zero force \[m\]; `None`: that of the initial configuration.
        rest: Option<f64>,
    },
    /// A spring and damper between the angles.
    TorsionSpring {
        /// Torque as a function of the angle.
        law: SpringLaw,
        /// Angle of `b` less that of `a` at zero torque \[rad\]; `None`: that of the initial configuration.
        rest: Option<f64>,
    },
    /// Force and torque on `b` from a function, for prototypes.
    Custom(CustomForce),
}

/// Function of time, position and velocity of a body that returns force and torque about its centre of mass \[N, N, N m\].
pub type LoadFunction = dyn Fn(f64, [f64; 3], [f64; 3]) -> [f64; 3] + Send + Sync;

/// A load function of the user.
#[derive(Clone)]
pub struct CustomForce(pub Arc<LoadFunction>);

impl std::fmt::Debug for CustomForce {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("CustomForce")
    }
}

impl PartialEq for CustomForce {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl ForceElement {
    /// Return a force element between two points.
    pub fn new(name: impl Into<String>, a: Marker, b: Marker, kind: ForceKind) -> Self {
        Self {
            name: name.into(),
            a,
            b,
            kind,
        }
    }

    /// Check every field.
    ///
    /// # Errors
    /// An invalid value; the message has the element, the field and the permitted values.
    pub fn validate(&self) -> Result<()> {
        let field = format!("force {:?}", self.name);
        self.a.validate(&format!("point of {field}"))?;
        self.b.validate(&format!("point of {field}"))?;
        self.check_bodies(&field)?;
        match &self.kind {
            ForceKind::Force { x, y, .. } => {
                x.validate(&field)?;
                y.validate(&field)
            }
            ForceKind::Torque(torque) => torque.validate(&field),
            ForceKind::TorqueBySpeed(_) | ForceKind::Custom(_) => Ok(()),
            ForceKind::Spring { law, rest } => {
                if let Some(rest) = rest {
                    check::not_negative(&format!("rest length of {field}"), *rest, "m")?;
                }
                law.validate(&field)
            }
            ForceKind::TorsionSpring { law, rest } => {
                let rest = rest.unwrap_or(0.0);
                check::finite(&format!("rest angle of {field}"), rest, "rad")?;
                law.validate(&field)
            }
        }
    }

    /// Check the bodies: an element between bodies needs two different ones, an element on one body needs one that is not the ground.
    fn check_bodies(&self, field: &str) -> Result<()> {
        if self.a.body != self.b.body {
            return Ok(());
        }
        let between = match &self.kind {
            ForceKind::Spring { .. } | ForceKind::TorsionSpring { .. } => true,
            ForceKind::Torque(_) | ForceKind::TorqueBySpeed(_) => self.b.body != GROUND,
            ForceKind::Force { .. } | ForceKind::Custom(_) => false,
        };
        if between {
            return Err((self.a).same_body(field, ": a body does not act on itself"));
        }
        if self.b.body == GROUND {
            return Err(Error::invalid(
                format!("body of {field}"),
                format!("{GROUND:?}"),
                "must be a body that can move",
            ));
        }
        Ok(())
    }
}

/// A force element with its bodies by index and the length or angle at zero force.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Force {
    pub(crate) name: String,
    pub(crate) a: End,
    pub(crate) b: End,
    pub(crate) kind: ForceKind,
    pub(crate) rest: f64,
}

impl Force {
    /// Add the loads, the stored energy and the powers of the element.
    pub(crate) fn add(&self, t: f64, frames: &[Frame], loads: &mut BodyLoads) {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        match &self.kind {
            ForceKind::Force { x, y, follows } => {
                let given = Vec2::new(x.value(t), y.value(t));
                let force = if *follows { fb.turned(given) } else { given };
                let place = fb.place(self.b.point);
                loads.push(self.b.body, fb, place, force);
                loads.external_work += force.dot(&fb.velocity_at(place));
            }
            ForceKind::Torque(_) | ForceKind::TorqueBySpeed(_) => {
                self.twist(self.torque(t, frames), fa, fb, loads);
            }
            ForceKind::Spring { law, .. } => self.pull(law, fa, fb, loads),
            ForceKind::Custom(CustomForce(function)) => {
                let velocity = fb.rates();
                let [x, y, torque] = function(t, fb.position(), velocity);
                loads.push(self.b.body, fb, fb.origin, Vec2::new(x, y));
                loads.twist(self.b.body, torque);
                loads.external_work += x * velocity[0] + y * velocity[1] + torque * velocity[2];
            }
            ForceKind::TorsionSpring { law, .. } => {
                let (x, rate) = (fb.angle - fa.angle - self.rest, fb.spin - fa.spin);
                let torque = law.elastic(x) + law.damping * rate;
                loads.twist(self.b.body, -torque);
                loads.twist(self.a.body, torque);
                loads.elastic += law.energy(x);
                loads.dissipated += law.damping * rate * rate;
            }
        }
    }

    /// Return the torque applied to body b \[N m\]; zero for an element that is no applied torque.
    pub(crate) fn torque(&self, t: f64, frames: &[Frame]) -> f64 {
        match &self.kind {
            ForceKind::Torque(torque) => torque.value(t),
            ForceKind::TorqueBySpeed(table) => {
                table.value(frames[self.b.body].spin - frames[self.a.body].spin)
            }
            _ => 0.0,
        }
    }

    /// Return the longest step from `t` that skips no feature of the element's functions of time \[s\].
    pub(crate) fn longest_step(&self, t: f64) -> f64 {
        match &self.kind {
            ForceKind::Force { x, y, .. } => x.longest_step(t).min(y.longest_step(t)),
            ForceKind::Torque(torque) => torque.longest_step(t),
            _ => f64::INFINITY,
        }
    }

    /// Add a torque on b, its reaction on a and its power.
    fn twist(&self, torque: f64, fa: &Frame, fb: &Frame, loads: &mut BodyLoads) {
        loads.twist(self.b.body, torque);
        loads.twist(self.a.body, -torque);
        loads.external_work += torque * (fb.spin - fa.spin);
    }

    /// Add the force of a spring and damper between both points: T = f(x) + c n·v along their connecting line.
    fn pull(&self, law: &SpringLaw, fa: &Frame, fb: &Frame, loads: &mut BodyLoads) {
        let (from, to) = (fa.place(self.a.point), fb.place(self.b.point));
        let d = to - from;
        let length = d.norm();
        // The direction is undefined for coincident points: the force is then zero.
        let n = direction(d, length);
        let rate = n.dot(&(fb.velocity_at(to) - fa.velocity_at(from)));
        let x = length - self.rest;
        let tension = law.elastic(x) + law.damping * rate;
        loads.push(self.b.body, fb, to, -tension * n);
        loads.push(self.a.body, fa, from, tension * n);
        loads.elastic += law.energy(x);
        loads.dissipated += law.damping * rate * rate;
    }
}

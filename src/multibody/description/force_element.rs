//! Applied forces, springs and dampers: their loads on the bodies, and what they do to the energy.

use std::sync::Arc;

use super::body::{End, Frame, Marker};
use super::spring_law::SpringLaw;
use crate::error::{Error, Result, check};
use crate::geometry::Vec2;
use crate::math::{Signal, Table};
use crate::multibody::GROUND;
use crate::multibody::forces::loads::Loads;

/// A force or torque between body `a` and body `b`.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceElement {
    /// Unique name.
    pub name: String,
    /// Where the reaction acts.
    pub a: Marker,
    /// Where the force acts.
    pub b: Marker,
    /// What it is.
    pub kind: ForceKind,
}

/// What a force element does.
#[derive(Debug, Clone, PartialEq)]
pub enum ForceKind {
    /// A force on point b \[N\]; it has no reaction.
    Force {
        /// Component along x.
        x: Signal,
        /// Component along y.
        y: Signal,
        /// Whether the components turn with the body.
        follows: bool,
    },
    /// A torque on `b`, its reaction on `a` \[N m\].
    Torque(Signal),
    /// A torque on `b`, its reaction on `a` \[N m\], by the speed of `b` seen from `a` \[rad/s\].
    TorqueBySpeed(Table),
    /// A spring and damper between the points.
    Spring {
        /// Force by length.
        law: SpringLaw,
        /// Length without force \[m\]; `None`: as placed.
        rest: Option<f64>,
    },
    /// A spring and damper between the angles.
    TorsionSpring {
        /// Torque by angle.
        law: SpringLaw,
        /// Angle of `b` less that of `a` without torque \[rad\]; `None`: as placed.
        rest: Option<f64>,
    },
    /// Whatever a function says, on `b`; for prototypes.
    Custom(CustomForce),
}

/// Force and torque about the centre of mass, by time, position and velocity of the body \[N, N, N m\].
pub type LoadFunction = dyn Fn(f64, [f64; 3], [f64; 3]) -> [f64; 3] + Send + Sync;

/// A function that gives a load.
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
    /// A force element between two points.
    pub fn new(name: impl Into<String>, a: Marker, b: Marker, kind: ForceKind) -> Self {
        Self {
            name: name.into(),
            a,
            b,
            kind,
        }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// Names the element, the field and what is allowed.
    pub fn validate(&self) -> Result<()> {
        let field = format!("force {:?}", self.name);
        for marker in [&self.a, &self.b] {
            for value in [marker.point.x, marker.point.y] {
                check::finite(&format!("point of {field}"), value, "m")?;
            }
        }
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
                check::finite(
                    &format!("rest angle of {field}"),
                    rest.unwrap_or(0.0),
                    "rad",
                )?;
                law.validate(&field)
            }
        }
    }
}

impl ForceElement {
    /// What acts between bodies needs two, and what acts on one needs a body that moves.
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
            return Err(Error::invalid(
                format!("bodies of {field}"),
                format!("{:?} twice", self.a.body),
                "must be two different bodies: a body does not act on itself",
            ));
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

/// A force element whose bodies are numbers and whose rest is known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Force {
    pub(crate) a: End,
    pub(crate) b: End,
    pub(crate) kind: ForceKind,
    pub(crate) rest: f64,
}

impl Force {
    /// Adds the element's loads, its stored energy and its powers.
    pub(crate) fn add(&self, t: f64, frames: &[Frame], loads: &mut Loads) {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        match &self.kind {
            ForceKind::Force { x, y, follows } => {
                let given = Vec2::new(x.value(t), y.value(t));
                let force = if *follows { fb.turned(given) } else { given };
                let place = fb.place(self.b.point);
                loads.push(self.b.body, fb, place, force);
                loads.worked_in += force.dot(&fb.velocity_at(place));
            }
            ForceKind::Torque(torque) => self.twist(torque.value(t), fa, fb, loads),
            ForceKind::TorqueBySpeed(table) => {
                self.twist(table.value(fb.spin - fa.spin), fa, fb, loads);
            }
            ForceKind::Spring { law, .. } => self.pull(law, fa, fb, loads),
            ForceKind::Custom(CustomForce(function)) => {
                let position = [fb.origin.x, fb.origin.y, fb.angle];
                let velocity = [fb.velocity.x, fb.velocity.y, fb.spin];
                let [x, y, torque] = function(t, position, velocity);
                loads.push(self.b.body, fb, fb.origin, Vec2::new(x, y));
                loads.twist(self.b.body, torque);
                loads.worked_in += x * velocity[0] + y * velocity[1] + torque * velocity[2];
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

    /// The longest step from `t` that passes over nothing of its functions of time unseen \[s\].
    pub(crate) fn longest_step(&self, t: f64) -> f64 {
        match &self.kind {
            ForceKind::Force { x, y, .. } => x.longest_step(t).min(y.longest_step(t)),
            ForceKind::Torque(torque) => torque.longest_step(t),
            _ => f64::INFINITY,
        }
    }

    fn twist(&self, torque: f64, fa: &Frame, fb: &Frame, loads: &mut Loads) {
        loads.twist(self.b.body, torque);
        loads.twist(self.a.body, -torque);
        loads.worked_in += torque * (fb.spin - fa.spin);
    }

    fn pull(&self, law: &SpringLaw, fa: &Frame, fb: &Frame, loads: &mut Loads) {
        let (from, to) = (fa.place(self.a.point), fb.place(self.b.point));
        let d = to - from;
        let length = d.norm();
        // Points that coincide give the spring no direction to act in.
        let n = if length > 0.0 {
            d / length
        } else {
            Vec2::zeros()
        };
        let rate = n.dot(&(fb.velocity_at(to) - fa.velocity_at(from)));
        let x = length - self.rest;
        let tension = law.elastic(x) + law.damping * rate;
        loads.push(self.b.body, fb, to, -tension * n);
        loads.push(self.a.body, fa, from, tension * n);
        loads.elastic += law.energy(x);
        loads.dissipated += law.damping * rate * rate;
    }
}

//! Description of ideal joints and drivers.

use super::body::Marker;
use super::driver::PrescribedMotion;
use super::tribology::PinFriction;
use crate::error::{Error, Result, check};
use crate::geometry::Vec2;

/// A joint between body `a` and body `b`.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// Point of body `a`; the directions below are in the frame of this body.
    pub a: Marker,
    /// Point of body `b`.
    pub b: Marker,
    /// Type of the joint, with its constrained quantities.
    pub kind: JointKind,
    /// Pin friction of a revolute joint.
    pub friction: Option<PinFriction>,
}

/// Type of a joint: the relative motion that it constrains.
#[derive(Debug, Clone, PartialEq)]
pub enum JointKind {
    /// Both points coincide.
    Revolute,
    /// Both points coincide and the relative angle is constant.
    Fixed {
        /// Angle of `b` less that of `a` \[rad\]; `None`: that of the initial configuration.
        angle: Option<f64>,
    },
    /// Point b is on a line through point a, and the relative angle is constant.
    Prismatic {
        /// Direction of the line in the frame of `a`.
        direction: Vec2,
        /// Angle of `b` less that of `a` \[rad\]; `None`: that of the initial configuration.
        angle: Option<f64>,
    },
    /// Point b is on a line through point a.
    PointOnLine {
        /// Direction of the line in the frame of `a`.
        direction: Vec2,
    },
    /// The distance between the points is constant.
    Distance {
        /// Distance \[m\]; `None`: that of the initial configuration.
        length: Option<f64>,
    },
    /// Two wheels rolling on each other: rotation of `b` = ratio · rotation of `a`, both relative to the carrier.
    Gear {
        /// Revolutions of `b` per revolution of `a`: negative for external gears, `-r_a/r_b`.
        ratio: f64,
        /// The body that carries both wheels; `None`: the ground.
        carrier: Option<String>,
    },
    /// A wheel `b` rolling on a line of body `a`: displacement along the line = radius · rotation of `b` \[rad\].
    Rack {
        /// Direction of the line in the frame of `a`.
        direction: Vec2,
        /// Radius of the wheel \[m\]; positive if a counterclockwise rotation moves it along the direction.
        radius: f64,
    },
    /// A motor: the angle of `b` less that of `a` is prescribed by a motion.
    DrivenAngle(PrescribedMotion),
    /// An actuator: the displacement of point b along a line from point a is prescribed by a motion.
    DrivenPosition {
        /// Direction of the line in the frame of `a`.
        direction: Vec2,
        /// Displacement along the line \[m\].
        motion: PrescribedMotion,
    },
}

impl Joint {
    /// Return a joint between two points, without friction.
    pub fn new(name: impl Into<String>, a: Marker, b: Marker, kind: JointKind) -> Self {
        Self {
            name: name.into(),
            a,
            b,
            kind,
            friction: None,
        }
    }

    /// Return the joint with pin friction, which is valid for revolute joints only.
    #[must_use]
    pub fn with_friction(mut self, friction: PinFriction) -> Self {
        self.friction = Some(friction);
        self
    }

    /// Check every field.
    ///
    /// # Errors
    /// An invalid value; the message has the joint, the field and the permitted values.
    pub fn validate(&self) -> Result<()> {
        let field = |name: &str| format!("{name} of joint {:?}", self.name);
        self.a.validate(&field("point a"))?;
        self.b.validate(&field("point b"))?;
        if self.a.body == self.b.body {
            return Err(self.a.same_body(&format!("joint {:?}", self.name), ""));
        }
        if let Some(friction) = &self.friction {
            if self.kind != JointKind::Revolute {
                return Err(Error::invalid(
                    field("friction"),
                    "given",
                    "must be none: only revolute joints have friction",
                ));
            }
            friction.validate(&format!("joint {:?}", self.name))?;
        }
        match &self.kind {
            JointKind::Revolute | JointKind::Distance { length: None } => Ok(()),
            JointKind::Fixed { angle } => optional(angle.as_ref(), &field("angle")),
            JointKind::Prismatic { direction, angle } => {
                optional(angle.as_ref(), &field("angle"))?;
                check::direction(&field("direction"), *direction)
            }
            JointKind::PointOnLine { direction } => {
                check::direction(&field("direction"), *direction)
            }
            JointKind::Distance { length: Some(l) } => check::positive(&field("length"), *l, "m"),
            JointKind::Gear { ratio, .. } => not_zero(&field("ratio"), *ratio, "1"),
            JointKind::Rack { direction, radius } => {
                not_zero(&field("radius"), *radius, "m")?;
                check::direction(&field("direction"), *direction)
            }
            JointKind::DrivenAngle(motion) => motion.validate(&field("motion")),
            JointKind::DrivenPosition { direction, motion } => {
                check::direction(&field("direction"), *direction)?;
                motion.validate(&field("motion"))
            }
        }
    }
}

fn optional(value: Option<&f64>, field: &str) -> Result<()> {
    value.map_or(Ok(()), |value| check::finite(field, *value, "rad"))
}

fn not_zero(field: &str, value: f64, unit: &str) -> Result<()> {
    check::finite(field, value, unit)?;
    if value == 0.0 {
        return Err(Error::invalid(field, value, "must not be zero"));
    }
    Ok(())
}

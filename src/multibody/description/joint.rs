//! Ideal joints and drivers, as they are described.

use super::body::Marker;
use super::driver::Motion;
use super::tribology::PinFriction;
use crate::error::{Error, Result, check};
use crate::geometry::Vec2;

/// A joint between body `a` and body `b`.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// The point on the one body; directions below are in this body's frame.
    pub a: Marker,
    /// The point on the other.
    pub b: Marker,
    /// What it holds.
    pub kind: JointKind,
    /// Friction of the pin of a revolute joint.
    pub friction: Option<PinFriction>,
}

/// What a joint holds.
#[derive(Debug, Clone, PartialEq)]
pub enum JointKind {
    /// Both points coincide.
    Revolute,
    /// Both points coincide and the bodies do not turn against each other; `None`: the angle as placed.
    Fixed {
        /// Angle of `b` less that of `a` \[rad\].
        angle: Option<f64>,
    },
    /// Point b stays on the line through point a, and the bodies do not turn against each other.
    Prismatic {
        /// Direction of the line in the frame of `a`.
        direction: Vec2,
        /// Angle of `b` less that of `a` \[rad\]; `None`: as placed.
        angle: Option<f64>,
    },
    /// Point b stays on the line through point a.
    PointOnLine {
        /// Direction of the line in the frame of `a`.
        direction: Vec2,
    },
    /// The points keep their distance \[m\]; `None`: as placed.
    Distance {
        /// Distance \[m\].
        length: Option<f64>,
    },
    /// Wheels rolling on each other: turns of `b` = ratio · turns of `a`, both seen from the carrier.
    Gear {
        /// Turns of `b` for one turn of `a`: negative for wheels outside each other, `-r_a/r_b`.
        ratio: f64,
        /// The body that both wheels turn on; `None`: the ground.
        carrier: Option<String>,
    },
    /// A wheel `b` rolls on a line of body `a`: way along the line = radius · turns of `b`.
    Rack {
        /// Direction of the line in the frame of `a`.
        direction: Vec2,
        /// Radius of the wheel \[m\]; positive where a counterclockwise turn drives along the direction.
        radius: f64,
    },
    /// A motor: the angle of `b` less that of `a` follows a motion.
    DrivenAngle(Motion),
    /// An actuator: the way of point b along a line from point a follows a motion.
    DrivenPosition {
        /// Direction of the line in the frame of `a`.
        direction: Vec2,
        /// The way along it \[m\].
        motion: Motion,
    },
}

impl Joint {
    /// A joint between two points.
    pub fn new(name: impl Into<String>, a: Marker, b: Marker, kind: JointKind) -> Self {
        Self {
            name: name.into(),
            a,
            b,
            kind,
            friction: None,
        }
    }

    /// The same revolute joint with friction of its pin.
    #[must_use]
    pub fn with_friction(mut self, friction: PinFriction) -> Self {
        self.friction = Some(friction);
        self
    }

    /// Checks every field.
    ///
    /// # Errors
    /// Names the joint, the field and what is allowed.
    pub fn validate(&self) -> Result<()> {
        let field = |name: &str| format!("{name} of joint {:?}", self.name);
        for (end, marker) in [("a", &self.a), ("b", &self.b)] {
            for value in [marker.point.x, marker.point.y] {
                check::finite(&field(&format!("point {end}")), value, "m")?;
            }
        }
        if self.a.body == self.b.body {
            return Err(Error::invalid(
                field("bodies"),
                format!("{:?} twice", self.a.body),
                "must be two different bodies",
            ));
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
                has_direction(&field("direction"), *direction)
            }
            JointKind::PointOnLine { direction } => has_direction(&field("direction"), *direction),
            JointKind::Distance { length: Some(l) } => check::positive(&field("length"), *l, "m"),
            JointKind::Gear { ratio, .. } => not_zero(&field("ratio"), *ratio, "1"),
            JointKind::Rack { direction, radius } => {
                not_zero(&field("radius"), *radius, "m")?;
                has_direction(&field("direction"), *direction)
            }
            JointKind::DrivenAngle(motion) => motion.validate(&field("motion")),
            JointKind::DrivenPosition { direction, motion } => {
                has_direction(&field("direction"), *direction)?;
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

pub(crate) fn has_direction(field: &str, direction: Vec2) -> Result<()> {
    let length = direction.norm();
    if length.is_finite() && length > 0.0 {
        return Ok(());
    }
    Err(Error::invalid(
        field,
        format!("({}, {})", direction.x, direction.y),
        "must be two finite numbers, not both zero",
    ))
}

//! Rigid bodies: what is described of them, and where they are at one instant.

use crate::error::{Error, Result, check};
use crate::geometry::{Vec2, turned_left};

/// A rigid body. Its frame sits at the centre of mass.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Unique name.
    pub name: String,
    /// Mass \[kg\].
    pub mass: f64,
    /// Moment of inertia about the centre of mass \[kg m²\].
    pub inertia: f64,
    /// Centre of mass and angle at the start \[m, m, rad\].
    pub position: [f64; 3],
    /// Its rates at the start \[m/s, m/s, rad/s\].
    pub velocity: [f64; 3],
    /// Whether it is held where it is.
    pub fixed: bool,
}

impl Body {
    /// A free body at rest at the origin.
    pub fn new(name: impl Into<String>, mass: f64, inertia: f64) -> Self {
        Self {
            name: name.into(),
            mass,
            inertia,
            position: [0.0; 3],
            velocity: [0.0; 3],
            fixed: false,
        }
    }

    /// The same body elsewhere.
    #[must_use]
    pub fn at(mut self, x: f64, y: f64, angle: f64) -> Self {
        self.position = [x, y, angle];
        self
    }

    /// The same body in motion.
    #[must_use]
    pub fn moving(mut self, vx: f64, vy: f64, spin: f64) -> Self {
        self.velocity = [vx, vy, spin];
        self
    }

    /// The same body, held.
    #[must_use]
    pub fn fixed(mut self) -> Self {
        self.fixed = true;
        self
    }

    /// Checks every field.
    ///
    /// # Errors
    /// Names the body, the field and what is allowed.
    pub fn validate(&self) -> Result<()> {
        let field = |name: &str| format!("{name} of body {:?}", self.name);
        check::not_negative(&field("mass"), self.mass, "kg")?;
        check::not_negative(&field("inertia"), self.inertia, "kg m^2")?;
        for value in self.position {
            check::finite(&field("position"), value, "m, m, rad")?;
        }
        for value in self.velocity {
            check::finite(&field("velocity"), value, "m/s, m/s, rad/s")?;
        }
        if self.fixed && self.velocity != [0.0; 3] {
            return Err(Error::invalid(
                field("velocity"),
                format!("{:?}", self.velocity),
                "must be zero for a body that is held: leave it out, or let the body go and drive it",
            ));
        }
        Ok(())
    }
}

/// A point of a body, in the body's frame \[m\].
#[derive(Debug, Clone, PartialEq)]
pub struct Marker {
    /// Name of the body; "ground" is the frame that does not move.
    pub body: String,
    /// The point in the body's frame \[m\].
    pub point: Vec2,
}

impl Marker {
    /// A point of a body.
    pub fn new(body: impl Into<String>, x: f64, y: f64) -> Self {
        Self {
            body: body.into(),
            point: Vec2::new(x, y),
        }
    }
}

/// A marker whose body is a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct End {
    pub(crate) body: usize,
    pub(crate) point: Vec2,
}

/// Where a body is at one instant, and how it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub(crate) origin: Vec2,
    pub(crate) angle: f64,
    /// (cos, sin) of the angle.
    direction: Vec2,
    pub(crate) velocity: Vec2,
    pub(crate) spin: f64,
}

impl Frame {
    pub(crate) fn new([x, y, angle]: [f64; 3], [vx, vy, spin]: [f64; 3]) -> Self {
        Self {
            origin: Vec2::new(x, y),
            angle,
            direction: crate::geometry::unit(angle),
            velocity: Vec2::new(vx, vy),
            spin,
        }
    }

    /// A vector of the body's frame in the ground's.
    pub(crate) fn turned(&self, local: Vec2) -> Vec2 {
        local.x * self.direction + local.y * turned_left(self.direction)
    }

    /// A vector of the ground's frame in the body's.
    pub(crate) fn into_local(self, vector: Vec2) -> Vec2 {
        Vec2::new(
            vector.dot(&self.direction),
            vector.dot(&turned_left(self.direction)),
        )
    }

    /// Place of a point of the body.
    pub(crate) fn place(&self, local: Vec2) -> Vec2 {
        self.origin + self.turned(local)
    }

    /// Velocity of the point of the body that is at `place`.
    pub(crate) fn velocity_at(&self, place: Vec2) -> Vec2 {
        self.velocity + self.spin * turned_left(place - self.origin)
    }
}

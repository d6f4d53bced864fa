//! Rigid bodies: description, and position and velocity at one instant.

use crate::error::{Error, Result, check};
use crate::geometry::{Vec2, turned_left};

/// A rigid body. The origin of its frame is its centre of mass.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Unique name.
    pub name: String,
    /// Mass \[kg\].
    pub mass: f64,
    /// Moment of inertia about the centre of mass \[kg m²\].
    pub inertia: f64,
    /// Initial position of the centre of mass and initial angle \[m, m, rad\].
    pub position: [f64; 3],
    /// Initial velocity of the centre of mass and initial angular velocity \[m/s, m/s, rad/s\].
    pub velocity: [f64; 3],
    /// Whether the body is fixed to the ground.
    pub fixed: bool,
}

impl Body {
    /// Return a free body at rest at the origin.
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

    /// Return the body with another initial position \[m\] and angle \[rad\].
    #[must_use]
    pub fn at(mut self, x: f64, y: f64, angle: f64) -> Self {
        self.position = [x, y, angle];
        self
    }

    /// Return the body with another initial velocity \[m/s\] and angular velocity \[rad/s\].
    #[must_use]
    pub fn moving(mut self, vx: f64, vy: f64, spin: f64) -> Self {
        self.velocity = [vx, vy, spin];
        self
    }

    /// Return the body, fixed to the ground.
    #[must_use]
    pub fn fixed(mut self) -> Self {
        self.fixed = true;
        self
    }

    /// Check every field.
    ///
    /// # Errors
    /// An invalid value; the message has the body, the field and the permitted values.
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
                "must be zero for a fixed body: leave it out, or free the body and drive it",
            ));
        }
        Ok(())
    }
}

/// A point of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Marker {
    /// Name of the body; "ground" is the inertial frame.
    pub body: String,
    /// The point in the body's frame \[m\].
    pub point: Vec2,
}

impl Marker {
    /// Return the marker at point (`x`, `y`) \[m\] of a body.
    pub fn new(body: impl Into<String>, x: f64, y: f64) -> Self {
        Self {
            body: body.into(),
            point: Vec2::new(x, y),
        }
    }

    /// Check the coordinates of the point, which is `name` in messages.
    pub(super) fn validate(&self, name: &str) -> Result<()> {
        check::finite(name, self.point.x, "m")?;
        check::finite(name, self.point.y, "m")
    }

    /// Return the error for two markers on this body; `owner` has them, and `why` follows the expectation.
    pub(super) fn same_body(&self, owner: &str, why: &str) -> Error {
        let field = format!("bodies of {owner}");
        let value = format!("{:?} twice", self.body);
        Error::invalid(field, value, format!("must be two different bodies{why}"))
    }
}

/// A marker with its body by index.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct End {
    pub(crate) body: usize,
    pub(crate) point: Vec2,
}

/// Largest rotation of [`Frame::moved`] without trigonometric functions \[rad\]; its cube is below rounding.
const SMALL_TURN: f64 = 1e-6;

/// Position and velocity of a body at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    /// Position of the centre of mass \[m\].
    pub(crate) origin: Vec2,
    /// Angle \[rad\].
    pub(crate) angle: f64,
    /// Unit vector (cos, sin) of the angle.
    direction: Vec2,
    /// Velocity of the centre of mass \[m/s\].
    pub(crate) velocity: Vec2,
    /// Angular velocity \[rad/s\].
    pub(crate) spin: f64,
}

impl Frame {
    pub(crate) fn new(position: [f64; 3], velocity: [f64; 3]) -> Self {
        Self::directed(position, crate::geometry::unit(position[2]), velocity)
    }

    /// Return the frame with a given unit vector (cos, sin) of its angle.
    #[inline]
    pub(crate) fn directed(
        [x, y, angle]: [f64; 3],
        direction: Vec2,
        [vx, vy, spin]: [f64; 3],
    ) -> Self {
        Self {
            origin: Vec2::new(x, y),
            angle,
            direction,
            velocity: Vec2::new(vx, vy),
            spin,
        }
    }

    /// Return the frame at a position and velocity nearby. Small rotations take no trigonometric functions.
    pub(crate) fn moved(&self, position: [f64; 3], velocity: [f64; 3]) -> Self {
        let turn = position[2] - self.angle;
        if turn.abs() > SMALL_TURN {
            return Self::new(position, velocity);
        }
        let left = turned_left(self.direction);
        Self {
            origin: Vec2::new(position[0], position[1]),
            angle: position[2],
            // Cosine and sine of the rotation to second order.
            direction: self.direction + turn * (left - 0.5 * turn * self.direction),
            velocity: Vec2::new(velocity[0], velocity[1]),
            spin: velocity[2],
        }
    }

    /// Return position and angle \[m, m, rad\].
    pub(crate) fn position(&self) -> [f64; 3] {
        [self.origin.x, self.origin.y, self.angle]
    }

    /// Return velocity and angular velocity \[m/s, m/s, rad/s\].
    pub(crate) fn rates(&self) -> [f64; 3] {
        [self.velocity.x, self.velocity.y, self.spin]
    }

    /// Transform a vector of the body's frame into the ground's frame.
    pub(crate) fn turned(&self, local: Vec2) -> Vec2 {
        local.x * self.direction + local.y * turned_left(self.direction)
    }

    /// Transform a vector of the ground's frame into the body's frame.
    pub(crate) fn into_local(self, vector: Vec2) -> Vec2 {
        Vec2::new(
            vector.dot(&self.direction),
            vector.dot(&turned_left(self.direction)),
        )
    }

    /// Return the position of a point of the body in the ground's frame \[m\].
    pub(crate) fn place(&self, local: Vec2) -> Vec2 {
        self.origin + self.turned(local)
    }

    /// Return the velocity of the body's material point at `place` \[m/s\].
    pub(crate) fn velocity_at(&self, place: Vec2) -> Vec2 {
        self.velocity + self.spin * turned_left(place - self.origin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_moved_by_a_small_rotation_is_that_of_the_angle() {
        let frame = Frame::new([0.1, 0.2, 0.7], [1.0, 2.0, 3.0]);
        for turn in [0.0, 1e-12, -3e-9, 9.9e-7, -1e-6, 2e-6, 0.4] {
            let (position, velocity) = ([0.3, -0.1, 0.7 + turn], [0.5, 0.4, -2.0]);
            let (moved, exact) = (
                frame.moved(position, velocity),
                Frame::new(position, velocity),
            );
            assert!((moved.direction - exact.direction).norm() < 4e-16, "{turn}");
            assert_eq!(moved.origin, exact.origin);
            assert_eq!((moved.velocity, moved.spin), (exact.velocity, exact.spin));
        }
    }
}

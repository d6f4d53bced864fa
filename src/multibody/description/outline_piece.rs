//! A piece of an outline, a straight line or an arc: ends, tangents and curvature.

use crate::error::{Error, Result, check};
use crate::geometry::{Vec2, turned_left};

/// Curvature of a piece at its contact with a circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Curvature {
    Flat,
    /// A straight line followed by a convex curve of this radius \[m\].
    FlatBefore(f64),
    Convex(f64),
    Concave(f64),
}

/// Largest difference of the radii at both ends of an arc, over the larger one. It separates rounded coordinates from a wrong centre.
const RADIUS_MISMATCH: f64 = 1e-6;

/// A piece of an outline \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Start point.
    pub from: Vec2,
    /// End point.
    pub to: Vec2,
    /// Centre of an arc; `None`: a straight line.
    pub center: Option<Vec2>,
    /// Whether an arc runs counterclockwise, which makes its outside convex.
    pub convex: bool,
}

impl Piece {
    /// Check every number; `name` identifies the piece in messages.
    pub(crate) fn validate(&self, name: &str) -> Result<()> {
        for value in [self.from.x, self.from.y, self.to.x, self.to.y] {
            check::finite(name, value, "m")?;
        }
        if self.from == self.to {
            return Err(Error::invalid(
                name,
                format!("from ({}, {}) to the same point", self.from.x, self.from.y),
                "has no length: leave one of the points out (a closed outline goes back to its first point by itself)",
            ));
        }
        if let Some(center) = self.center {
            let (first, last) = ((self.from - center).norm(), (self.to - center).norm());
            if !((first - last).abs() <= RADIUS_MISMATCH * first.max(last) && first > 0.0) {
                return Err(Error::invalid(
                    name,
                    format!("an arc of radii {first} m and {last} m at its ends"),
                    "its ends must be equally far from its centre",
                ));
            }
        }
        Ok(())
    }

    pub(crate) fn curvature(&self) -> Curvature {
        match self.center {
            None => Curvature::Flat,
            Some(_) if self.convex => Curvature::Convex(self.radius()),
            Some(_) => Curvature::Concave(self.radius()),
        }
    }

    /// Return the radius of an arc \[m\]; infinite for a straight line.
    pub(crate) fn radius(&self) -> f64 {
        self.center
            .map_or(f64::INFINITY, |center| (self.from - center).norm())
    }

    /// Return the unit tangent at one of the ends.
    pub(crate) fn tangent(&self, at: Vec2) -> Vec2 {
        match self.center {
            None => (self.to - self.from).normalize(),
            Some(center) => {
                let left = turned_left((at - center).normalize());
                if self.convex { left } else { -left }
            }
        }
    }

    /// Return the angle of an arc, from 0 to 2π \[rad\]; 0 for a straight line.
    pub(crate) fn span(&self) -> f64 {
        let Some(center) = self.center else {
            return 0.0;
        };
        let (first, last) = (self.from - center, self.to - center);
        if self.convex {
            turn(first, last)
        } else {
            turn(last, first)
        }
    }

    /// Split an arc into `count` pieces of equal angle; a straight line remains one piece.
    pub(crate) fn split(&self, count: usize) -> Vec<Self> {
        let Some(center) = self.center.filter(|_| count > 1) else {
            return vec![*self];
        };
        let step = self.span() / count as f64 * if self.convex { 1.0 } else { -1.0 };
        let arm = self.from - center;
        let at = |k: usize| {
            if k == 0 {
                self.from
            } else if k == count {
                self.to
            } else {
                let (sin, cos) = (step * k as f64).sin_cos();
                center + cos * arm + sin * turned_left(arm)
            }
        };
        (0..count)
            .map(|k| Self {
                from: at(k),
                to: at(k + 1),
                ..*self
            })
            .collect()
    }
}

/// Return the counterclockwise angle from one direction to another, from 0 to 2π \[rad\].
fn turn(from: Vec2, to: Vec2) -> f64 {
    let angle = from.perp(&to).atan2(from.dot(&to));
    if angle < 0.0 {
        angle + 2.0 * std::f64::consts::PI
    } else {
        angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_is_split_where_its_angle_is() {
        let arc = Piece {
            from: Vec2::new(1.0, 0.0),
            to: Vec2::new(0.0, -1.0),
            center: Some(Vec2::zeros()),
            convex: true,
        };
        assert!((arc.span() - 1.5 * std::f64::consts::PI).abs() < 1e-15);
        let parts = arc.split(3);
        for (part, to) in parts.iter().zip([(0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)]) {
            assert!((part.to - Vec2::new(to.0, to.1)).norm() < 1e-15);
            assert!((part.span() - 0.5 * std::f64::consts::PI).abs() < 1e-15);
        }
        let clockwise = Piece {
            convex: false,
            ..arc
        };
        assert!((clockwise.span() - 0.5 * std::f64::consts::PI).abs() < 1e-15);
        assert_eq!(clockwise.tangent(clockwise.from), Vec2::new(0.0, -1.0));
    }
}

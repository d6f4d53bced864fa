//! A circular arc of a profile and the penetration of a cylinder.

use crate::geometry::Vec2;

/// A circle of which an arc belongs to a profile; the ends of the arc are stored in the profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// Centre of curvature \[m\].
    pub center: Vec2,
    /// Radius \[m\].
    pub radius: f64,
}

impl Arc {
    /// Return the penetration \[m\] of a cylinder of `radius` on the concave side, and its direction of increase.
    #[must_use]
    pub fn depth_inside(&self, point: Vec2, radius: f64) -> (f64, Vec2) {
        let offset = point - self.center;
        let distance = offset.norm();
        (
            distance - (self.radius - radius),
            direction(offset, distance),
        )
    }

    /// Return the penetration \[m\] of a cylinder of `radius` on the convex side, and its direction of increase.
    #[must_use]
    pub fn depth_outside(&self, point: Vec2, radius: f64) -> (f64, Vec2) {
        let offset = self.center - point;
        let distance = offset.norm();
        (self.radius + radius - distance, direction(offset, distance))
    }

    /// Return the point of the circle in direction `normal` (a unit vector) from its centre.
    #[must_use]
    pub fn point(&self, normal: Vec2) -> Vec2 {
        self.center + self.radius * normal
    }
}

/// Return the unit vector along `offset`; for coincident centres, straight down.
fn direction(offset: Vec2, distance: f64) -> Vec2 {
    if distance > 0.0 {
        offset / distance
    } else {
        Vec2::new(0.0, -1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cylinder_at_the_centre_is_one_clearance_away() {
        let seat = Arc {
            center: Vec2::new(0.1, 0.2),
            radius: 0.005,
        };
        let (depth, normal) = seat.depth_inside(seat.center, 0.004);
        assert!((depth + 0.001).abs() < 1e-18);
        assert_eq!(normal, Vec2::new(0.0, -1.0));
    }

    #[test]
    fn depth_outside_grows_towards_the_centre() {
        let tip = Arc {
            center: Vec2::zeros(),
            radius: 2.0,
        };
        let (depth, normal) = tip.depth_outside(Vec2::new(2.5, 0.0), 1.0);
        assert!((depth - 0.5).abs() < 1e-15);
        assert_eq!(normal, Vec2::new(-1.0, 0.0));
    }

    #[test]
    fn depth_inside_grows_away_from_the_centre() {
        let seat = Arc {
            center: Vec2::new(1.0, 2.0),
            radius: 7.0,
        };
        let (depth, normal) = seat.depth_inside(Vec2::new(4.0, -2.0), 3.0);
        assert_eq!(depth, 1.0);
        assert!((normal - Vec2::new(0.6, -0.8)).norm() < 1e-15);
        assert_eq!(seat.point(Vec2::y()), Vec2::new(1.0, 9.0));
        let (depth, normal) = seat.depth_outside(seat.center, 3.0);
        assert_eq!((depth, normal), (10.0, -Vec2::y()));
    }
}

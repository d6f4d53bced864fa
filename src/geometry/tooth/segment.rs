//! A straight segment of a profile and the penetration of a cylinder.

use crate::geometry::Vec2;

/// A straight segment with the material on the side of its normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// First point \[m\].
    pub start: Vec2,
    /// Unit vector from the first to the last point.
    pub tangent: Vec2,
    /// Unit vector into the material.
    pub normal: Vec2,
    /// Length \[m\].
    pub length: f64,
}

impl Segment {
    /// Return the position of `point` along the segment \[m\]: 0 at its start, `length` at its end.
    #[must_use]
    pub fn along(&self, point: Vec2) -> f64 {
        (point - self.start).dot(&self.tangent)
    }

    /// Return the penetration \[m\] of a cylinder of `radius`, and its direction of increase.
    #[must_use]
    pub fn depth(&self, point: Vec2, radius: f64) -> (f64, Vec2) {
        ((point - self.start).dot(&self.normal) + radius, self.normal)
    }

    /// Return the last point \[m\].
    #[must_use]
    pub fn end(&self) -> Vec2 {
        self.start + self.length * self.tangent
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cylinder_over_a_slope_has_the_place_and_depth_of_its_right_triangle() {
        // Slope 3:4 from (1, 2), material below it: the normal is (3, -4)/5.
        let slope = Segment {
            start: Vec2::new(1.0, 2.0),
            tangent: Vec2::new(0.8, 0.6),
            normal: Vec2::new(0.6, -0.8),
            length: 10.0,
        };
        assert!((slope.end() - Vec2::new(9.0, 8.0)).norm() < 1e-14);
        // Five along the slope and two off it.
        let place = Vec2::new(1.0 + 5.0 * 0.8 - 2.0 * 0.6, 2.0 + 5.0 * 0.6 + 2.0 * 0.8);
        assert!((slope.along(place) - 5.0).abs() < 1e-14);
        let (depth, normal) = slope.depth(place, 3.0);
        assert!((depth - 1.0).abs() < 1e-14);
        assert_eq!(normal, slope.normal);
    }
}

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

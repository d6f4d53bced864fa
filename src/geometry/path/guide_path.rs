//! Guide path: a straight line or a circle about a pivot.

use crate::geometry::{Vec2, turned_left};

/// Return the displacement at arc length `s` \[m\] of a guide path that begins in `direction`, and the unit tangent there.
///
/// `curvature` \[1/m\]: 1/distance of the pivot, positive for a pivot on the left; 0 for a straight line.
#[must_use]
pub fn along(direction: Vec2, curvature: f64, s: f64) -> (Vec2, Vec2) {
    if curvature == 0.0 {
        return (s * direction, direction);
    }
    let (sin, cos) = (curvature * s).sin_cos();
    let left = turned_left(direction);
    (
        (sin * direction + (1.0 - cos) * left) / curvature,
        cos * direction + sin * left,
    )
}

/// Return the arc length of a point at `offset` from the beginning of the guide path \[m\].
#[must_use]
pub fn place(direction: Vec2, curvature: f64, offset: Vec2) -> f64 {
    if curvature == 0.0 {
        return offset.dot(&direction);
    }
    let (sense, radius) = (curvature.signum(), 1.0 / curvature.abs());
    let across = sense * offset.dot(&turned_left(direction));
    radius * offset.dot(&direction).atan2(radius - across)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::unit;

    #[test]
    fn a_curved_way_stays_on_its_circle_and_gives_its_place_back() {
        for curvature in [12.5, -8.0] {
            let direction = unit(0.7);
            let pivot = turned_left(direction) / curvature;
            for s in [-0.15, -1e-6, 0.0, 0.02, 0.2] {
                let (offset, tangent) = along(direction, curvature, s);
                assert!(((offset - pivot).norm() - 1.0 / curvature.abs()).abs() < 1e-15);
                assert!((place(direction, curvature, offset) - s).abs() < 1e-15);
                let h = 1e-6;
                let at = |s: f64| along(direction, curvature, s).0;
                let slope = (at(s + h) - at(s - h)) / (2.0 * h);
                assert!((slope - tangent).norm() < 1e-8);
            }
        }
    }

    #[test]
    fn a_straight_path_leads_along_its_direction_and_is_the_limit_of_a_flat_arc() {
        let direction = unit(-2.1);
        let (offset, tangent) = along(direction, 0.0, 0.3);
        assert_eq!((offset, tangent), (0.3 * direction, direction));
        // A point beside the line has the place of its foot.
        let beside = offset + 0.2 * turned_left(direction);
        assert!((place(direction, 0.0, beside) - 0.3).abs() < 1e-15);
        // An arc departs from its tangent by s²/2R.
        let (bent, _) = along(direction, 1e-4, 0.3);
        assert!((bent - offset).norm() < 5e-6);
    }
}

//! Plane geometry: tooth forms and chain paths, without bodies, forces and time.

pub(crate) mod components;
pub mod path;
pub(crate) mod tooth;

pub use tooth::ansi::{AnsiCurves, ansi_outside_radius};
pub use tooth::arc::Arc;
pub use tooth::custom::{Misfit, OutlinePiece};
pub use tooth::flank::{SurfaceCurve, SurfacePiece};
pub use tooth::iso::{Blank, IsoGap, SEAT_OVER_ROLLER, iso_tip_diameters};
pub use tooth::profile::{Damage, Seat, Surface, ToothContact, ToothProfile};
pub use tooth::segment::Segment;

/// A point or a direction in the plane, \[m\] or dimensionless.
pub type Vec2 = nalgebra::Vector2<f64>;

/// Return the unit vector at `angle` \[rad\] from the x axis.
#[must_use]
pub fn unit(angle: f64) -> Vec2 {
    let (sin, cos) = angle.sin_cos();
    Vec2::new(cos, sin)
}

/// Return the unit vector along `vector`, which has this length; zero for a length of zero.
pub(crate) fn direction(vector: Vec2, length: f64) -> Vec2 {
    if length > 0.0 {
        vector / length
    } else {
        Vec2::zeros()
    }
}

/// Return the vector rotated by +90 degrees.
#[must_use]
pub fn turned_left(v: Vec2) -> Vec2 {
    Vec2::new(-v.y, v.x)
}

/// Return the distance of a point from a line segment \[m\].
pub(crate) fn distance_from_segment(point: Vec2, [start, end]: [Vec2; 2]) -> f64 {
    let (along, offset) = (end - start, point - start);
    let share = offset.dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
    (offset - share.clamp(0.0, 1.0) * along).norm()
}

/// Distance of a pair of surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Unit vector of increasing penetration.
    pub normal: Vec2,
    /// Penetration δ \[m\]; negative when apart.
    pub penetration: f64,
    /// dδ/dt \[m/s\].
    pub penetration_rate: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_direction_of_a_vector_without_length_is_zero() {
        assert_eq!(direction(Vec2::zeros(), 0.0), Vec2::zeros());
        assert_eq!(direction(Vec2::new(0.0, -2.0), 2.0), -Vec2::y());
    }
}

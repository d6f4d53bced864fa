//! Plane curves: no bodies, no forces, no time.

mod ansi_tooth;
mod arc;
pub mod belt;
mod custom_tooth;
mod flank;
pub mod hanging;
mod iso_tooth;
pub mod polygon;
mod rail;
mod segment;
mod tooth_profile;
pub mod way;
pub mod wrap;

pub use ansi_tooth::AnsiCurves;
pub use arc::Arc;
pub use custom_tooth::{Misfit, OutlinePiece};
pub use flank::{Curve, Piece};
pub use iso_tooth::{Blank, IsoGap, iso_tip_diameters};
pub use segment::Segment;
pub use tooth_profile::{Damage, Seat, Surface, ToothContact, ToothProfile};

/// A point or a direction in the plane, \[m\] or dimensionless.
pub type Vec2 = nalgebra::Vector2<f64>;

/// The unit vector at `angle` \[rad\] from the x axis.
#[must_use]
pub fn unit(angle: f64) -> Vec2 {
    let (sin, cos) = angle.sin_cos();
    Vec2::new(cos, sin)
}

/// The vector turned by +90 degrees.
#[must_use]
pub fn turned_left(v: Vec2) -> Vec2 {
    Vec2::new(-v.y, v.x)
}

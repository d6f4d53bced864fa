//! Profiles for contacts with a circle: bore, disc, teeth of a sprocket, and outlines of straight lines and arcs.

use crate::error::{Error, Result, check};
use crate::force_law::radius_beside_flat;
use crate::geometry::{SurfaceCurve, SurfacePiece, ToothProfile, Vec2, direction};

use super::outline_piece::{Curvature, Piece};

/// Shape in the frame of marker a, for contacts with a circle around marker b.
#[derive(Debug, Clone, PartialEq)]
pub enum Profile {
    /// The inside of a circular hole, such as a bushing around a pin.
    Bore {
        /// Radius \[m\].
        radius: f64,
    },
    /// The outside of a disc.
    Disc {
        /// Radius \[m\].
        radius: f64,
    },
    /// The teeth of a sprocket, one gap after another; gap 0 lies along x.
    Teeth(Box<ToothProfile>),
    /// A sequence of pieces, each beginning at the end of the previous one; the material lies on their left.
    Outline {
        /// The pieces in order.
        pieces: Vec<Piece>,
        /// Whether the last piece ends at the beginning of the first.
        closed: bool,
    },
}

/// Point of a profile nearest to a given point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nearest {
    /// Distance from the surface \[m\], negative inside the material.
    pub(crate) distance: f64,
    /// Unit vector out of the material.
    pub(crate) outward: Vec2,
    /// Number of the piece.
    pub(crate) piece: usize,
    /// Tooth gap and region, if the point is near the teeth of a sprocket.
    pub(crate) tooth: Option<Tooth>,
}

impl Nearest {
    /// Return a point of the only piece of a profile.
    fn on_circle(distance: f64, outward: Vec2) -> Self {
        Self {
            distance,
            outward,
            piece: 0,
            tooth: None,
        }
    }
}

/// Position on the teeth of a sprocket.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Tooth {
    /// Number of the gap; gap 0 lies along x.
    pub(crate) gap: u32,
    /// Region of the tooth, from 1.
    pub(crate) region: u8,
}

impl Profile {
    /// Return a polyline through points \[m\]; the material lies on its left.
    ///
    /// # Errors
    /// Too few points, coincident consecutive points, or a path that is not simple or encloses no area.
    pub fn polyline(field: &str, points: &[Vec2], closed: bool) -> Result<Self> {
        let fewest = if closed { 3 } else { 2 };
        if points.len() < fewest {
            return Err(Error::invalid(
                field,
                format!("{} points", points.len()),
                if closed {
                    "needs at least 3 where it is closed; closed=False makes a line of 2"
                } else {
                    "needs at least 2"
                },
            ));
        }
        let ends = points
            .iter()
            .skip(1)
            .chain(points.first().filter(|_| closed));
        let pieces = points
            .iter()
            .zip(ends)
            .map(|(&from, &to)| Piece {
                from,
                to,
                center: None,
                convex: true,
            })
            .collect();
        let profile = Self::Outline { pieces, closed };
        profile.validate(field)?;
        Ok(profile)
    }

    /// Check every number and the path of an outline.
    ///
    /// # Errors
    /// An invalid value; the message has `field`, the value and the permitted values.
    pub fn validate(&self, field: &str) -> Result<()> {
        let (pieces, closed) = match self {
            Self::Bore { radius } => {
                return check::positive(&format!("bore_radius of {field}"), *radius, "m");
            }
            Self::Disc { radius } => {
                return check::positive(&format!("radius_a of {field}"), *radius, "m");
            }
            Self::Teeth(_) => return Ok(()),
            Self::Outline { pieces, closed } => (pieces, closed),
        };
        if pieces.is_empty() {
            return Err(Error::invalid(field, "()", "needs at least one piece"));
        }
        for (i, piece) in pieces.iter().enumerate() {
            piece.validate(&format!("piece {} of {field}", i + 1))?;
        }
        super::outline_check::check_path(field, pieces, *closed)
    }

    /// Return the radius of a circle around the origin of the profile's frame that encloses the profile \[m\]; infinite for unbounded
    /// material.
    pub(crate) fn reach(&self) -> f64 {
        match self {
            Self::Bore { .. } => f64::INFINITY,
            Self::Disc { radius } => *radius,
            Self::Teeth(profile) => profile.outside_radius,
            Self::Outline { pieces, closed } => {
                // The material of a clockwise closed outline lies outside the outline.
                let twice_area: f64 = pieces.iter().map(|p| p.from.perp(&p.to)).sum();
                if !closed || twice_area <= 0.0 {
                    return f64::INFINITY;
                }
                let far = |piece: &Piece| match piece.center {
                    None => piece.from.norm(),
                    Some(center) => center.norm() + (piece.from - center).norm(),
                };
                pieces.iter().map(far).fold(0.0, f64::max)
            }
        }
    }

    /// Return the rotation of the outward direction per displacement of a point along the surface \[1/m\], at a `distance` from `piece`;
    /// zero for outlines.
    pub(crate) fn bend(&self, piece: usize, distance: f64) -> f64 {
        let curve = match self {
            Self::Outline { .. } => None,
            Self::Bore { radius } => Some((-1.0, *radius)),
            Self::Disc { radius } => Some((1.0, *radius)),
            Self::Teeth(profile) => match profile.surfaces()[piece].curve {
                SurfaceCurve::Concave(arc) => Some((-1.0, arc.radius)),
                SurfaceCurve::Convex(arc) => Some((1.0, arc.radius)),
                SurfaceCurve::Straight(_) => None,
            },
        };
        // The direction is that from the centre of the curve, or towards it; at the centre it is arbitrary.
        let from_center = curve.map_or(0.0, |(sign, radius)| sign * radius + distance);
        if from_center == 0.0 {
            0.0
        } else {
            1.0 / from_center
        }
    }

    /// Return the curvature of each piece, for a circle of `circle` \[m\].
    pub(crate) fn curvatures(&self, circle: f64) -> Vec<Curvature> {
        match self {
            Self::Bore { radius } => vec![Curvature::Concave(*radius)],
            Self::Disc { radius } => vec![Curvature::Convex(*radius)],
            Self::Teeth(profile) => tooth_curvatures(profile, circle),
            Self::Outline { pieces, .. } => pieces.iter().map(Piece::curvature).collect(),
        }
    }

    /// Return the point of the profile nearest to a circle of `radius` around `point`, in the frame of the profile.
    ///
    /// The distance is infinite for an outline: see [`crate::multibody::contact::outline::Outline`].
    pub(crate) fn nearest(&self, point: Vec2, radius: f64) -> Nearest {
        match self {
            Self::Outline { .. } => Nearest::on_circle(f64::INFINITY, Vec2::zeros()),
            Self::Bore { radius } => {
                let distance = point.norm();
                Nearest::on_circle(radius - distance, -direction(point, distance))
            }
            Self::Disc { radius } => {
                let distance = point.norm();
                Nearest::on_circle(distance - radius, direction(point, distance))
            }
            Self::Teeth(profile) => nearest_tooth(profile, point, radius),
        }
    }
}

/// Return the curvature of each surface of a tooth gap, for a circle of `radius`.
fn tooth_curvatures(profile: &ToothProfile, radius: f64) -> Vec<Curvature> {
    let curvature = |(i, surface): (usize, &SurfacePiece)| match surface.curve {
        SurfaceCurve::Concave(arc) => Curvature::Concave(arc.radius),
        SurfaceCurve::Convex(arc) => Curvature::Convex(arc.radius),
        SurfaceCurve::Straight(_) => Curvature::FlatBefore(radius_beside_flat(profile, i, radius)),
    };
    let surfaces = profile.surfaces().iter().enumerate();
    surfaces.map(curvature).collect()
}

/// Return the point of the teeth nearest to a circle, or the outside circle if that is farther away than the radius.
fn nearest_tooth(profile: &ToothProfile, point: Vec2, radius: f64) -> Nearest {
    let distance = point.norm();
    let clear = distance - profile.outside_radius;
    if clear > radius {
        return Nearest::on_circle(clear, direction(point, distance));
    }
    let (gap, found) = profile.contact_in_sprocket(point, radius);
    Nearest {
        distance: radius - found.penetration,
        outward: -found.normal,
        piece: found.surface.index(),
        tooth: Some(Tooth {
            gap,
            region: found.region,
        }),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::geometry::{Seat, turned_left};

    #[test]
    fn bore_and_disc_are_each_others_complement() {
        let point = Vec2::new(0.3, -0.4);
        let (bore, disc) = (
            Profile::Bore { radius: 0.7 }.nearest(point, 0.1),
            Profile::Disc { radius: 0.7 }.nearest(point, 0.1),
        );
        assert_eq!(bore.distance, -disc.distance);
        assert_eq!(bore.outward, -disc.outward);
    }

    #[test]
    fn the_outward_direction_turns_as_that_of_a_point_beside() {
        let teeth = ToothProfile::ansi(0.0127, 0.007_937_5, 17, Seat::PitchCircle);
        let (radius, pitch_radius) = (0.003_968_75, teeth.pitch_radius);
        let profiles = [
            (Profile::Bore { radius: 0.7 }, Vec2::new(0.3, -0.4)),
            (Profile::Disc { radius: 0.7 }, Vec2::new(0.6, -0.4)),
        ];
        // Seat, working curve and topping curve, on both flanks.
        let places = [
            (0.0, -1e-5),
            (6e-4, -1e-4),
            (-6e-4, -1e-4),
            (1.5e-3, 2.5e-3),
            (-1.2e-3, 2e-3),
        ];
        let teeth = Profile::Teeth(Box::new(teeth));
        let in_gap =
            places.map(|(along, out)| (teeth.clone(), Vec2::new(pitch_radius + out, along)));
        let mut pieces = BTreeSet::new();
        for (profile, point) in profiles.into_iter().chain(in_gap) {
            let here = profile.nearest(point, radius);
            let (along, step) = (turned_left(here.outward), 3e-9);
            let [before, after] = [-step, step].map(|s| profile.nearest(point + s * along, radius));
            let expected = (after.outward - before.outward).dot(&along) / (2.0 * step);
            let found = profile.bend(here.piece, here.distance);
            assert!(
                (found - expected).abs() < 1e-6 * (1.0 + expected.abs()),
                "{point:?}: {found} {expected}"
            );
            pieces.insert(here.piece);
        }
        assert!(pieces.len() > 2, "{pieces:?}");
        assert_eq!(Profile::Bore { radius: 0.5 }.bend(0, 0.5), 0.0);
    }
}

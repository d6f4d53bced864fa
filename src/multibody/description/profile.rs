//! Shapes that a circle may touch: bore, circle, segment, arc, and outlines made of them.

use crate::error::{Error, Result, check};
use crate::geometry::{SurfaceCurve, ToothProfile, Vec2, turned_left, unit};

use super::outline_piece::Piece;

/// A shape in the frame of marker a; a circle around marker b may touch it.
#[derive(Debug, Clone, PartialEq)]
pub enum Profile {
    /// The inside of a hole: a pin in a bushing.
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
    /// A row of pieces, each beginning where the one before ends; the material lies on their left.
    Outline {
        /// The pieces in order.
        pieces: Vec<Piece>,
        /// Whether the last one ends where the first begins.
        closed: bool,
    },
}

/// Where a profile is nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nearest {
    /// Distance from the surface \[m\], negative inside the material.
    pub(crate) distance: f64,
    /// Unit vector out of the material.
    pub(crate) outward: Vec2,
    /// Number of the piece.
    pub(crate) piece: usize,
    /// Where among teeth, when it is near them.
    pub(crate) tooth: Option<Tooth>,
}

/// A place among the teeth of a sprocket.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Tooth {
    /// Number of the gap; gap 0 lies along x.
    pub(crate) gap: u32,
    /// Region of the tooth, from 1.
    pub(crate) region: u8,
}

/// How a piece is curved where a circle touches it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Curvature {
    Flat,
    /// A flat that goes on as a convex curve of this radius.
    FlatBefore(f64),
    Convex(f64),
    Concave(f64),
}

impl Profile {
    /// A polyline through points \[m\]; the material lies on its left.
    ///
    /// # Errors
    /// When there are too few points or two that follow each other coincide.
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

    /// Checks every number.
    ///
    /// # Errors
    /// Names `field`, its value and what is allowed.
    pub fn validate(&self, field: &str) -> Result<()> {
        let outline = match self {
            Self::Bore { radius } | Self::Disc { radius } => {
                return check::positive(&format!("radius of {field}"), *radius, "m");
            }
            Self::Teeth(_) => return Ok(()),
            Self::Outline { pieces, closed } => (pieces, closed),
        };
        let (pieces, closed) = outline;
        if pieces.is_empty() {
            return Err(Error::invalid(field, "()", "needs at least one piece"));
        }
        for (i, piece) in pieces.iter().enumerate() {
            piece.validate(&format!("piece {} of {field}", i + 1))?;
        }
        super::outline_check::check_way(field, pieces, *closed)
    }

    /// Radius of a circle around the origin of its frame that holds all of it; infinite where the material goes on without end.
    pub(crate) fn reach(&self) -> f64 {
        match self {
            Self::Bore { .. } => f64::INFINITY,
            Self::Disc { radius } => *radius,
            Self::Teeth(profile) => profile.outside_radius,
            Self::Outline { pieces, closed } => {
                // Material that an outline runs round clockwise lies outside it.
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

    /// How the outward direction turns as a point moves along the surface \[1/m\]; by a difference among teeth.
    pub(crate) fn bend(&self, point: Vec2, radius: f64, outward: Vec2) -> f64 {
        match self {
            Self::Bore { .. } => -1.0 / point.norm(),
            Self::Disc { .. } => 1.0 / point.norm(),
            Self::Outline { .. } => 0.0,
            Self::Teeth(profile) => {
                let (along, step) = (turned_left(outward), 1e-6 * radius);
                let moved = nearest_tooth(profile, point + step * along, radius);
                moved.outward.dot(&along) / step
            }
        }
    }

    /// Curvature of each piece.
    pub(crate) fn curvatures(&self) -> Vec<Curvature> {
        match self {
            Self::Bore { radius } => vec![Curvature::Concave(*radius)],
            Self::Disc { radius } => vec![Curvature::Convex(*radius)],
            Self::Teeth(profile) => tooth_curvatures(profile),
            Self::Outline { pieces, .. } => pieces.iter().map(Piece::curvature).collect(),
        }
    }

    /// Where the profile is nearest to a circle of `radius` around `point`, which is given in its frame; for an outline, see
    /// [`crate::multibody::contact::outline::Outline`].
    pub(crate) fn nearest(&self, point: Vec2, radius: f64) -> Nearest {
        match self {
            Self::Outline { .. } => Nearest {
                distance: f64::INFINITY,
                outward: Vec2::zeros(),
                piece: 0,
                tooth: None,
            },
            Self::Bore { radius } => {
                let distance = point.norm();
                Nearest {
                    distance: radius - distance,
                    outward: -direction(point, distance),
                    piece: 0,
                    tooth: None,
                }
            }
            Self::Disc { radius } => {
                let distance = point.norm();
                Nearest {
                    distance: distance - radius,
                    outward: direction(point, distance),
                    piece: 0,
                    tooth: None,
                }
            }
            Self::Teeth(profile) => nearest_tooth(profile, point, radius),
        }
    }
}

fn direction(vector: Vec2, length: f64) -> Vec2 {
    if length > 0.0 {
        vector / length
    } else {
        Vec2::zeros()
    }
}

fn tooth_curvatures(profile: &ToothProfile) -> Vec<Curvature> {
    let surfaces = profile.surfaces();
    let curves = surfaces.iter().map(|surface| surface.curve);
    let next = curves.clone().skip(1).map(Some).chain([None]);
    let curvature = |(curve, next)| match (curve, next) {
        (SurfaceCurve::Concave(arc), _) => Curvature::Concave(arc.radius),
        (SurfaceCurve::Convex(arc), _) => Curvature::Convex(arc.radius),
        (SurfaceCurve::Straight(_), Some(SurfaceCurve::Convex(arc))) => {
            Curvature::FlatBefore(arc.radius)
        }
        (SurfaceCurve::Straight(_), _) => Curvature::Flat,
    };
    curves.zip(next).map(curvature).collect()
}

fn nearest_tooth(profile: &ToothProfile, point: Vec2, radius: f64) -> Nearest {
    let distance = point.norm();
    let clear = distance - profile.outside_radius;
    if clear > radius {
        return Nearest {
            distance: clear,
            outward: direction(point, distance),
            piece: 0,
            tooth: None,
        };
    }
    let gap = profile.nearest_gap(point.y.atan2(point.x));
    // v: radially outward through the gap; u: v turned clockwise.
    let v = unit(f64::from(gap) * profile.gap_angle());
    let u = Vec2::new(v.y, -v.x);
    let place = Vec2::new(point.dot(&u), point.dot(&v) - profile.seat_center_radius);
    let found = profile.contact_in(gap, place, radius);
    Nearest {
        distance: radius - found.penetration,
        outward: -(found.normal.x * u + found.normal.y * v),
        piece: found.surface.index(),
        tooth: Some(Tooth {
            gap,
            region: found.region,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}

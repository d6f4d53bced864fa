//! Shapes that a circle may touch: bore, circle, segment, arc, and outlines made of them.

use crate::error::{Error, Result, check};
use crate::geometry::{Curve, ToothProfile, Vec2, turned_left, unit};

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

/// A piece of an outline \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Where it begins.
    pub from: Vec2,
    /// Where it ends.
    pub to: Vec2,
    /// Centre of an arc; `None`: a straight line.
    pub center: Option<Vec2>,
    /// Whether an arc runs counterclockwise: its outside is then convex.
    pub convex: bool,
}

/// Where a profile is nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Nearest {
    /// Distance from the surface \[m\], negative inside the material.
    pub(super) distance: f64,
    /// Unit vector out of the material.
    pub(super) outward: Vec2,
    /// Number of the piece.
    pub(super) piece: usize,
    /// Where among teeth, when it is near them.
    pub(super) tooth: Option<Tooth>,
}

/// A place among the teeth of a sprocket.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Tooth {
    /// Number of the gap; gap 0 lies along x.
    pub(super) gap: u32,
    /// Region of the tooth, from 1.
    pub(super) region: u8,
}

/// How a piece is curved where a circle touches it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Curvature {
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
                format!("needs at least {fewest}"),
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
        let pieces = match self {
            Self::Bore { radius } | Self::Disc { radius } => {
                return check::positive(&format!("radius of {field}"), *radius, "m");
            }
            Self::Teeth(_) => return Ok(()),
            Self::Outline { pieces, .. } => pieces,
        };
        if pieces.is_empty() {
            return Err(Error::invalid(field, "()", "needs at least one piece"));
        }
        for (i, piece) in pieces.iter().enumerate() {
            let name = format!("piece {} of {field}", i + 1);
            for value in [piece.from.x, piece.from.y, piece.to.x, piece.to.y] {
                check::finite(&name, value, "m")?;
            }
            if piece.from == piece.to {
                return Err(Error::invalid(name, "no length", "must have two ends"));
            }
            if let Some(center) = piece.center {
                let (first, last) = ((piece.from - center).norm(), (piece.to - center).norm());
                if !((first - last).abs() <= 1e-6 * first.max(last) && first > 0.0) {
                    return Err(Error::invalid(
                        name,
                        format!("an arc of radii {first} m and {last} m at its ends"),
                        "its ends must be equally far from its centre",
                    ));
                }
            }
        }
        Ok(())
    }

    /// Radius of a circle around the origin of its frame that holds all of it; infinite where the material goes on without end.
    pub(super) fn reach(&self) -> f64 {
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

    /// Curvature of each piece.
    pub(super) fn curvatures(&self) -> Vec<Curvature> {
        match self {
            Self::Bore { radius } => vec![Curvature::Concave(*radius)],
            Self::Disc { radius } => vec![Curvature::Convex(*radius)],
            Self::Teeth(profile) => tooth_curvatures(profile),
            Self::Outline { pieces, .. } => pieces.iter().map(Piece::curvature).collect(),
        }
    }

    /// Where the profile is nearest to a circle of `radius` around `point`, which is given in its frame.
    pub(super) fn nearest(&self, point: Vec2, radius: f64) -> Nearest {
        match self {
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
            Self::Outline { pieces, closed } => nearest_piece(pieces, *closed, point),
        }
    }
}

impl Piece {
    fn curvature(&self) -> Curvature {
        match self.center {
            None => Curvature::Flat,
            Some(center) if self.convex => Curvature::Convex((self.from - center).norm()),
            Some(center) => Curvature::Concave((self.from - center).norm()),
        }
    }

    /// Direction in which it runs at one of its ends.
    fn tangent(&self, at: Vec2) -> Vec2 {
        match self.center {
            None => (self.to - self.from).normalize(),
            Some(center) => {
                let left = turned_left((at - center).normalize());
                if self.convex { left } else { -left }
            }
        }
    }

    /// Distance and outward direction where `point` is nearest to the inside of the piece, not to an end.
    fn nearest_inside(&self, point: Vec2) -> Option<(f64, Vec2)> {
        match self.center {
            None => {
                let along = self.to - self.from;
                let part = (point - self.from).dot(&along) / along.norm_squared();
                let outward = -turned_left(along.normalize());
                (0.0..=1.0)
                    .contains(&part)
                    .then(|| ((point - self.from).dot(&outward), outward))
            }
            Some(center) => {
                let d = point - center;
                let distance = d.norm();
                let n = direction(d, distance);
                let radius = (self.from - center).norm();
                let (first, last) = if self.convex {
                    (self.from - center, self.to - center)
                } else {
                    (self.to - center, self.from - center)
                };
                let within = turn(first, d) <= turn(first, last);
                within.then_some(if self.convex {
                    (distance - radius, n)
                } else {
                    (radius - distance, -n)
                })
            }
        }
    }
}

/// Angle from one direction counterclockwise to another, from 0 to 2π \[rad\].
fn turn(from: Vec2, to: Vec2) -> f64 {
    let angle = from.perp(&to).atan2(from.dot(&to));
    if angle < 0.0 {
        angle + 2.0 * std::f64::consts::PI
    } else {
        angle
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
        (Curve::Concave(arc), _) => Curvature::Concave(arc.radius),
        (Curve::Convex(arc), _) => Curvature::Convex(arc.radius),
        (Curve::Straight(_), Some(Curve::Convex(arc))) => Curvature::FlatBefore(arc.radius),
        (Curve::Straight(_), _) => Curvature::Flat,
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

fn nearest_piece(pieces: &[Piece], closed: bool, point: Vec2) -> Nearest {
    let mut best = Nearest {
        distance: f64::INFINITY,
        outward: Vec2::zeros(),
        piece: 0,
        tooth: None,
    };
    for (i, piece) in pieces.iter().enumerate() {
        if let Some((distance, outward)) = piece.nearest_inside(point)
            && distance.abs() < best.distance.abs()
        {
            best = Nearest {
                distance,
                outward,
                piece: i,
                tooth: None,
            };
        }
        let corner = point - piece.from;
        if corner.norm() < best.distance.abs() {
            let before = match i {
                0 if closed => pieces.last(),
                0 => None,
                _ => pieces.get(i - 1),
            };
            // From outside only a convex corner can be the nearest place, from inside only a reentrant one.
            let convex = before.is_none_or(|before| {
                before.tangent(before.to).perp(&piece.tangent(piece.from)) >= 0.0
            });
            best = at_corner(corner, convex, i);
        }
    }
    if let Some(last) = pieces.last().filter(|_| !closed) {
        let corner = point - last.to;
        if corner.norm() < best.distance.abs() {
            best = at_corner(corner, true, pieces.len() - 1);
        }
    }
    best
}

fn at_corner(corner: Vec2, convex: bool, piece: usize) -> Nearest {
    let distance = corner.norm();
    let outward = direction(corner, distance);
    Nearest {
        distance: if convex { distance } else { -distance },
        outward: if convex { outward } else { -outward },
        piece,
        tooth: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Profile {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let points: Vec<Vec2> = corners.map(|(x, y)| Vec2::new(x, y)).to_vec();
        Profile::polyline("square", &points, true).unwrap()
    }

    #[test]
    fn a_square_is_nearest_at_its_sides_and_corners() {
        for (point, distance, outward) in [
            ((0.5, -0.2), 0.2, (0.0, -1.0)),
            ((0.5, 0.1), -0.1, (0.0, -1.0)),
            ((1.3, 1.4), 0.5, (0.6, 0.8)),
            ((-0.25, 0.5), 0.25, (-1.0, 0.0)),
        ] {
            let found = square().nearest(Vec2::new(point.0, point.1), 0.1);
            assert!((found.distance - distance).abs() < 1e-15);
            assert!((found.outward - Vec2::new(outward.0, outward.1)).norm() < 1e-15);
        }
    }

    #[test]
    fn arcs_are_convex_counterclockwise_and_concave_clockwise() {
        let arc = |convex: bool| {
            let (from, to) = if convex { (1.0, -1.0) } else { (-1.0, 1.0) };
            Profile::Outline {
                pieces: vec![Piece {
                    from: Vec2::new(from, 0.0),
                    to: Vec2::new(to, 0.0),
                    center: Some(Vec2::zeros()),
                    convex,
                }],
                closed: false,
            }
        };
        let above = Vec2::new(0.0, 1.25);
        assert!((arc(true).nearest(above, 0.1).distance - 0.25).abs() < 1e-15);
        assert!((arc(false).nearest(above, 0.1).distance + 0.25).abs() < 1e-15);
        assert_eq!(arc(false).nearest(above, 0.1).outward, Vec2::new(0.0, -1.0));
        let beside = Vec2::new(1.3, -0.4);
        assert!((arc(true).nearest(beside, 0.1).distance - 0.5).abs() < 1e-15);
    }

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

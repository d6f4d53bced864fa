//! Half a tooth gap as a sequence of tangent curves, and the curve nearest to a cylinder.
//!
//! Right half in the frame of a gap (u, v): from the middle of the gap to the middle of the tooth, the material on
//! the right.

use crate::geometry::{Arc, Segment, Vec2, turned_left, unit};

/// A curve of a flank, seen from outside the material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SurfaceCurve {
    /// A concave arc: the cylinder is inside.
    Concave(Arc),
    /// A convex arc: the cylinder is outside.
    Convex(Arc),
    /// A straight line.
    Straight(Segment),
}

impl SurfaceCurve {
    /// Return the penetration \[m\] of a cylinder of `radius` at `point`, and its direction of increase.
    #[must_use]
    pub fn depth(&self, point: Vec2, radius: f64) -> (f64, Vec2) {
        match self {
            Self::Concave(arc) => arc.depth_inside(point, radius),
            Self::Convex(arc) => arc.depth_outside(point, radius),
            Self::Straight(segment) => segment.depth(point, radius),
        }
    }

    /// Return the unit tangent at `point` of the curve, along the flank.
    #[must_use]
    pub fn tangent(&self, point: Vec2) -> Vec2 {
        match self {
            Self::Concave(arc) => turned_left((point - arc.center) / arc.radius),
            Self::Convex(arc) => -turned_left((point - arc.center) / arc.radius),
            Self::Straight(segment) => segment.tangent,
        }
    }

    /// Return the centres of circles of `radius` in the material that touch the curve and the inside of a circle of
    /// `outside` about `center`.
    fn inscribed(&self, radius: f64, center: Vec2, outside: f64) -> Vec<Vec2> {
        let within = outside - radius;
        match self {
            Self::Concave(arc) => crossings(arc.center, arc.radius + radius, center, within),
            Self::Convex(arc) => crossings(arc.center, arc.radius - radius, center, within),
            Self::Straight(segment) => {
                let from = segment.start + radius * segment.normal - center;
                let along = -from.dot(&segment.tangent);
                let foot = from + along * segment.tangent;
                let half = (within * within - foot.norm_squared()).sqrt();
                if half.is_nan() {
                    return Vec::new();
                }
                [half, -half]
                    .map(|half| center + foot + half * segment.tangent)
                    .to_vec()
            }
        }
    }

    /// Return the point of the curve nearest to `center` of a tangent circle.
    fn touched_from(&self, center: Vec2) -> Vec2 {
        match self {
            Self::Concave(arc) | Self::Convex(arc) => arc.point((center - arc.center).normalize()),
            Self::Straight(segment) => segment.start + segment.along(center) * segment.tangent,
        }
    }

    /// Return `points` of the curve from `start` to `end`; the two ends of a straight line.
    pub(crate) fn sweep(&self, start: Vec2, end: Vec2, points: usize) -> Vec<Vec2> {
        let (arc, sense) = match self {
            Self::Straight(_) => return vec![start, end],
            Self::Concave(arc) => (arc, 1.0),
            Self::Convex(arc) => (arc, -1.0),
        };
        let (first, last) = (start - arc.center, end - arc.center);
        let turn = sense * first.perp(&last).atan2(first.dot(&last));
        let turn = if turn < 0.0 {
            turn + 2.0 * std::f64::consts::PI
        } else {
            turn
        };
        let from = first.y.atan2(first.x);
        (0..points)
            .map(|i| {
                if i + 1 == points {
                    end
                } else {
                    arc.point(unit(from + sense * turn * i as f64 / (points - 1) as f64))
                }
            })
            .collect()
    }
}

/// Return the intersections of two circles, if any.
fn crossings(a: Vec2, radius_a: f64, b: Vec2, radius_b: f64) -> Vec<Vec2> {
    let between = b - a;
    let distance = between.norm();
    let along = 0.5 * (distance + (radius_a - radius_b) * (radius_a + radius_b) / distance);
    let half = (radius_a * radius_a - along * along).sqrt();
    if radius_a <= 0.0 || radius_b <= 0.0 || half.is_nan() {
        return Vec::new();
    }
    let e = between / distance;
    [half, -half]
        .map(|half| a + along * e + half * turned_left(e))
        .to_vec()
}

/// Normal at the junction of two curves: the second curve is nearest to points at `limit` or more along `tangent`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Boundary {
    pub(crate) foot: Vec2,
    pub(crate) tangent: Vec2,
    /// \[m\]
    pub(crate) limit: f64,
}

impl Boundary {
    /// Return the distance of `point` past the normal \[m\].
    fn past(&self, point: Vec2) -> f64 {
        (point - self.foot).dot(&self.tangent) - self.limit
    }
}

/// A curve of a flank with its ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePiece {
    /// The curve.
    pub curve: SurfaceCurve,
    /// First point \[m\].
    pub start: Vec2,
    /// Last point \[m\].
    pub end: Vec2,
    /// Name in messages.
    pub name: &'static str,
    /// Number of regions of the tooth between this one and the middle of the gap.
    pub step: u8,
    pub(crate) boundary: Boundary,
}

/// Curves of half a gap in order.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Flank {
    pub(crate) pieces: Vec<SurfacePiece>,
}

impl Flank {
    /// Begin a flank at `start` with `curve`.
    pub(crate) fn begin(name: &'static str, start: Vec2, curve: SurfaceCurve) -> Self {
        let boundary = Boundary {
            foot: start,
            tangent: curve.tangent(start),
            limit: 0.0,
        };
        Self {
            pieces: vec![SurfacePiece {
                curve,
                start,
                end: start,
                name,
                step: 0,
                boundary,
            }],
        }
    }

    /// Append `curve` at `point`, where both have the unit `tangent`.
    pub(crate) fn then(
        mut self,
        point: Vec2,
        tangent: Vec2,
        name: &'static str,
        curve: SurfaceCurve,
    ) -> Self {
        let mut step = 0;
        if let Some(last) = self.pieces.last_mut() {
            let (foot, limit) = match (last.curve, curve) {
                (_, SurfaceCurve::Straight(segment)) => (segment.start, 0.0),
                (SurfaceCurve::Straight(segment), _) if point == segment.end() => {
                    (segment.start, segment.length)
                }
                (SurfaceCurve::Straight(segment), _) => (segment.start, segment.along(point)),
                (SurfaceCurve::Concave(arc) | SurfaceCurve::Convex(arc), _) => (arc.center, 0.0),
            };
            last.end = point;
            last.boundary = Boundary {
                foot,
                tangent,
                limit,
            };
            step = last.step + 1;
        }
        self.pieces.extend(Self::begin(name, point, curve).pieces);
        if let Some(last) = self.pieces.last_mut() {
            last.step = step;
        }
        self
    }

    /// End the flank at `point`.
    pub(crate) fn end(mut self, point: Vec2) -> Self {
        if let Some(last) = self.pieces.last_mut() {
            last.end = point;
        }
        self
    }

    /// Return the flank cut by the circle of `outside` about `center`, its edge rounded by an arc of radius `edge`; `axis` is the
    /// unit vector from `center` along the middle of the tooth. `None` where the circle does not meet the flank.
    pub(crate) fn cut(&self, center: Vec2, axis: Vec2, outside: f64, edge: f64) -> Option<Self> {
        let slack = 1e-9 * outside;
        for (i, piece) in self.pieces.iter().enumerate() {
            for middle in piece.curve.inscribed(edge, center, outside) {
                let from_center = middle - center;
                let touched = piece.curve.touched_from(middle);
                let before = i > 0 && self.pieces[i - 1].boundary.past(touched) < -slack;
                let behind = (i + 1 < self.pieces.len() && piece.boundary.past(touched) > slack)
                    || (i + 1 == self.pieces.len()
                        && (touched - piece.end).dot(&piece.curve.tangent(piece.end)) > slack);
                let beside = middle.x < 0.0 || from_center.perp(&axis) > 0.0;
                if before || behind || beside || from_center.dot(&axis) < 0.0 {
                    continue;
                }
                let mut cut = Self {
                    pieces: self.pieces[..=i].to_vec(),
                };
                let round = Arc {
                    center: middle,
                    radius: edge,
                };
                let land = Arc {
                    center,
                    radius: outside,
                };
                cut = cut.then(
                    touched,
                    piece.curve.tangent(touched),
                    "edge",
                    SurfaceCurve::Convex(round),
                );
                let corner = land.point(from_center.normalize());
                let level = SurfaceCurve::Convex(land);
                cut = cut.then(corner, level.tangent(corner), "land", level);
                return Some(cut.end(center + outside * axis));
            }
        }
        None
    }

    /// Return the land of a tooth cut down to the circle of `outside` about `center`.
    pub(crate) fn level(center: Vec2, axis: Vec2, outside: f64) -> Self {
        let land = SurfaceCurve::Convex(Arc {
            center,
            radius: outside,
        });
        Self::begin("land", center + Vec2::new(0.0, outside), land).end(center + outside * axis)
    }
}

/// Return the number of the piece nearest to `point` on the right half: the normals at the junctions divide the plane.
pub(crate) fn nearest_piece(pieces: &[SurfacePiece], point: Vec2) -> usize {
    let last = pieces.len() - 1;
    let within = |piece: &SurfacePiece| {
        let Boundary {
            foot,
            tangent,
            limit,
        } = piece.boundary;
        (point - foot).dot(&tangent) < limit
    };
    pieces[..last].iter().position(within).unwrap_or(last)
}

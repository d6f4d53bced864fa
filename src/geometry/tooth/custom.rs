//! A custom tooth form of arcs and lines, and the errors of its pieces.

use serde::{Deserialize, Serialize};

use super::flank::{Flank, SurfaceCurve};
use crate::geometry::{Arc, Segment, ToothProfile, Vec2, turned_left};

/// Largest permitted gap between two pieces \[m\]: coordinates with seven decimals.
const LARGEST_GAP: f64 = 1e-7;
/// Largest permitted angle between the tangents of two pieces \[rad\].
const LARGEST_ANGLE: f64 = 1e-4;

/// A piece of an outline. Frame: origin in the sprocket's centre, u across the tooth gap, v outward through its middle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OutlinePiece {
    /// First point \[m\].
    #[serde(with = "crate::geometry::components")]
    pub start: Vec2,
    /// Last point \[m\].
    #[serde(with = "crate::geometry::components")]
    pub end: Vec2,
    /// Centre of an arc of less than half a turn; `None`: a straight line.
    #[serde(with = "crate::geometry::components")]
    pub center: Option<Vec2>,
}

/// Error of a flank's pieces; pieces are numbered from 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Misfit {
    /// No pieces.
    Nothing,
    /// A piece of zero length, or an arc whose ends have different distances from its centre \[m\].
    NoCurve(usize, f64, f64),
    /// Gap between a piece and the one before it \[m\].
    Apart(usize, f64),
    /// Angle between the tangents of a piece and the one before it \[rad\], counterclockwise positive.
    Corner(usize, f64),
    /// Distance of the first piece from the middle of the tooth gap \[m\].
    Beside(f64),
    /// Angle of the first piece at its mirror image \[rad\].
    Leans(f64),
    /// Distance of the last piece from the middle of an uncut tooth \[m\].
    Open(f64),
    /// Angle of the last piece at its mirror image \[rad\]: a pointed tooth.
    Point(f64),
    /// Radius at which the flanks meet \[m\], inside the outside circle.
    Pointed(f64),
}

impl OutlinePiece {
    fn curve(&self, number: usize) -> Result<SurfaceCurve, Misfit> {
        let chord = self.end - self.start;
        let length = chord.norm();
        let Some(center) = self.center else {
            if length <= LARGEST_GAP {
                return Err(Misfit::NoCurve(number, length, length));
            }
            let tangent = chord / length;
            return Ok(SurfaceCurve::Straight(Segment {
                start: self.start,
                tangent,
                normal: -turned_left(tangent),
                length,
            }));
        };
        let [first, last] = [self.start, self.end].map(|end| (end - center).norm());
        if length <= LARGEST_GAP || (first - last).abs() > LARGEST_GAP {
            return Err(Misfit::NoCurve(number, first, last));
        }
        let arc = Arc {
            center,
            radius: 0.5 * (first + last),
        };
        // The material is on the right: an arc about a centre on the left is concave.
        Ok(if chord.perp(&(center - self.start)) > 0.0 {
            SurfaceCurve::Concave(arc)
        } else {
            SurfaceCurve::Convex(arc)
        })
    }
}

impl ToothProfile {
    /// Return a tooth of `pieces`, from the middle of the gap along the right flank. They end in the middle of the tooth, or are cut at
    /// a circle: (its radius, radius of the edge) \[m\].
    ///
    /// # Errors
    /// The position and size of the first misfit.
    pub fn custom(
        pitch: f64,
        teeth: u32,
        pieces: &[OutlinePiece],
        tip: Option<(f64, f64)>,
    ) -> Result<Self, Misfit> {
        let (Some(first), Some(last)) = (pieces.first(), pieces.last()) else {
            return Err(Misfit::Nothing);
        };
        // A seat with its centre in the middle of the gap is the origin of the frame, as in the other forms.
        let seat = first.center.filter(|center| center.x.abs() <= LARGEST_GAP);
        let pitch_radius = crate::geometry::path::wrap::pitch_radius(pitch, teeth);
        let origin = Vec2::new(0.0, seat.map_or(pitch_radius, |center| center.y));
        let moved: Vec<OutlinePiece> = pieces
            .iter()
            .map(|piece| OutlinePiece {
                start: piece.start - origin,
                end: piece.end - origin,
                center: piece.center.map(|center| center - origin),
            })
            .collect();
        if first.start.x.abs() > LARGEST_GAP {
            return Err(Misfit::Beside(first.start.x));
        }
        let curve = moved[0].curve(1)?;
        let leaning = curve.tangent(moved[0].start).y.asin();
        if leaning.abs() > LARGEST_ANGLE {
            return Err(Misfit::Leans(leaning));
        }
        let mut flank = Flank::begin("piece", moved[0].start, curve);
        let mut before = curve;
        for (i, (end, piece)) in moved.iter().zip(&moved[1..]).enumerate() {
            let curve = piece.curve(i + 2)?;
            let apart = (piece.start - end.end).norm();
            if apart > LARGEST_GAP {
                return Err(Misfit::Apart(i + 2, apart));
            }
            let (from, to) = (before.tangent(end.end), curve.tangent(piece.start));
            let turn = from.perp(&to).atan2(from.dot(&to));
            if turn.abs() > LARGEST_ANGLE {
                return Err(Misfit::Corner(i + 2, turn));
            }
            flank = flank.then(piece.start, to.normalize(), "piece", curve);
            before = curve;
        }
        flank = flank.end(last.end - origin);
        let outermost = pieces
            .iter()
            .flat_map(|piece| [piece.start.norm(), piece.end.norm()])
            .fold(0.0, f64::max);
        let profile = Self::of(teeth, pitch, origin.y, outermost, flank);
        if let Some((outside, edge)) = tip {
            return profile.cut(outside, edge).map_err(Misfit::Pointed);
        }
        let axis = profile.axis();
        let open = axis.perp(&last.end);
        if open.abs() > LARGEST_GAP {
            return Err(Misfit::Open(open));
        }
        let tangent = before.tangent(last.end - origin);
        let point = tangent.dot(&axis).asin();
        if point.abs() > LARGEST_ANGLE {
            return Err(Misfit::Point(point));
        }
        Ok(profile)
    }
}

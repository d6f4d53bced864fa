//! A tooth of the user's own arcs and lines, and what is wrong with one that does not fit together.

use super::flank::{Flank, SurfaceCurve};
use crate::geometry::{Arc, Segment, ToothProfile, Vec2, turned_left};

/// Largest gap between two pieces \[m\].
const LARGEST_GAP: f64 = 1e-7;
/// Largest angle between the tangents of two pieces \[rad\].
const LARGEST_ANGLE: f64 = 1e-4;

/// A piece of an outline, in a frame with the sprocket's centre as its origin: u across the gap, v outward through its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutlinePiece {
    /// Where it begins \[m\].
    pub start: Vec2,
    /// Where it ends \[m\].
    pub end: Vec2,
    /// Centre of an arc of less than half a turn; `None`: a straight line.
    pub center: Option<Vec2>,
}

/// Why pieces make no flank; pieces are numbered from 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Misfit {
    /// There are none.
    Nothing,
    /// A piece has no length, or an arc's ends are not equally far from its centre: these distances \[m\].
    NoCurve(usize, f64, f64),
    /// A piece begins this far \[m\] from where the one before ends.
    Apart(usize, f64),
    /// A piece turns by this angle \[rad\], counterclockwise positive, from the one before.
    Corner(usize, f64),
    /// The first piece begins this far \[m\] from the middle of the gap.
    Beside(f64),
    /// The first piece leans by this angle \[rad\] where it meets its mirror image.
    Leans(f64),
    /// The last piece ends this far \[m\] from the middle of the tooth, and nothing is cut off.
    Open(f64),
    /// The last piece meets its mirror image in a point, at this angle \[rad\] from level.
    Point(f64),
    /// The flanks meet at this radius \[m\], inside the outside circle.
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
        // The material is on the right: an arc about a centre on the left is hollow.
        Ok(if chord.perp(&(center - self.start)) > 0.0 {
            SurfaceCurve::Concave(arc)
        } else {
            SurfaceCurve::Convex(arc)
        })
    }
}

impl ToothProfile {
    /// A tooth of `pieces`, from the middle of the gap up the right flank; they end in the middle of the tooth, or are cut off at
    /// a circle: (its radius, radius of the edge) \[m\].
    ///
    /// # Errors
    /// Where and by how much the pieces do not fit.
    pub fn custom(
        pitch: f64,
        teeth: u32,
        pieces: &[OutlinePiece],
        tip: Option<(f64, f64)>,
    ) -> Result<Self, Misfit> {
        let (Some(first), Some(last)) = (pieces.first(), pieces.last()) else {
            return Err(Misfit::Nothing);
        };
        // A seat about a centre in the middle of the gap is the origin of its frame, as of the other forms.
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

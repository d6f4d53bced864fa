//! Tooth forms as sequences of arcs and segments.

pub(crate) mod ansi;
pub(crate) mod arc;
pub(crate) mod custom;
pub(crate) mod flank;
pub(crate) mod iso;
pub(crate) mod profile;
pub(crate) mod segment;

/// Properties that tests of all tooth forms and rails check.
#[cfg(test)]
pub(crate) mod checks {
    use super::flank::SurfacePiece;
    use crate::geometry::{ToothProfile, Vec2};

    /// Return the largest misfit of pieces \[m\]: gaps between them, and ends that are not on their curves.
    pub(crate) fn largest_gap(pieces: &[SurfacePiece]) -> f64 {
        let ends = pieces.iter().flat_map(|piece| {
            [piece.start, piece.end].map(|end| piece.curve.depth(end, 0.0).0.abs())
        });
        let gaps = pieces
            .windows(2)
            .map(|two| (two[1].start - two[0].end).norm());
        ends.chain(gaps).fold(0.0, f64::max)
    }

    /// Return the largest corner between pieces, and where the first one meets its mirror image \[rad\].
    pub(crate) fn largest_corner(pieces: &[SurfacePiece]) -> f64 {
        let angle = |from: Vec2, to: Vec2| from.perp(&to).atan2(from.dot(&to)).abs();
        let corners = pieces.windows(2).map(|two| {
            let at = two[0].end;
            angle(two[0].curve.tangent(at), two[1].curve.tangent(at))
        });
        let first = angle(pieces[0].curve.tangent(pieces[0].start), Vec2::x());
        corners.fold(first, f64::max)
    }

    /// Return the distance of a point from the outline \[m\], in the body's own frame.
    pub(crate) fn distance_from_outline(profile: &ToothProfile, point: Vec2) -> f64 {
        let outline = profile.outline(400);
        let next = outline.iter().cycle().skip(1);
        let distances = outline.iter().zip(next).map(|(from, to)| {
            let along = to - from;
            let share = (point - from).dot(&along) / along.norm_squared().max(1e-30);
            (from + share.clamp(0.0, 1.0) * along - point).norm()
        });
        distances.fold(f64::INFINITY, f64::min)
    }
}

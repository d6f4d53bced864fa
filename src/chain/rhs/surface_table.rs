//! Gap of any surfaces for a SIMD vector of bushings, from a table of surfaces: all tooth forms, including damaged and eccentric
//! teeth.

mod vectors;

use crate::chain::contact::surface_constants;
use crate::chain::model::Model;
use crate::geometry::{Surface, SurfaceCurve, SurfacePiece, ToothProfile, Vec2};

/// Penetration on a missing part of a flank \[m\]. Every real penetration exceeds it.
const NOWHERE: f64 = -1.0;

/// Constants of one surface.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SurfaceRow {
    /// Boundary to the surface before: points with a coordinate of at least `from` along `tangent` are past it \[m\].
    tangent: [f64; 2],
    from: f64,
    /// Centre of curvature; for a straight line its start \[m\].
    center: [f64; 2],
    /// Distance of the centres at which bushing and curve touch; for a straight line the bushing's radius \[m\].
    touch: f64,
    /// 1: the bushing is inside an arc; -1: outside; 0: straight line.
    side: f64,
    /// Normal of a straight line, into the material.
    normal: [f64; 2],
    /// Constants of the contact law.
    law: [f64; 2],
}

impl SurfaceRow {
    /// Return the row of a surface; `before` is the surface before it on the flank.
    fn new(
        piece: &SurfacePiece,
        before: Option<&SurfacePiece>,
        radius: f64,
        law: [f64; 2],
    ) -> Self {
        let pair = |v: Vec2| [v.x, v.y];
        let (center, touch, side, normal) = match piece.curve {
            SurfaceCurve::Concave(arc) => (arc.center, arc.radius - radius, 1.0, Vec2::zeros()),
            SurfaceCurve::Convex(arc) => (arc.center, arc.radius + radius, -1.0, Vec2::zeros()),
            SurfaceCurve::Straight(segment) => (segment.start, radius, 0.0, segment.normal),
        };
        let (tangent, from) = before.map_or((Vec2::zeros(), 0.0), |before| {
            let boundary = &before.boundary;
            let from = boundary.foot.dot(&boundary.tangent) + boundary.limit;
            (boundary.tangent, from)
        });
        Self {
            tangent: pair(tangent),
            from,
            center: pair(center),
            touch,
            side,
            normal: pair(normal),
            law,
        }
    }
}

/// Damaged tooth and the range of its surfaces in the table.
#[derive(Debug, Clone, PartialEq)]
struct Damaged {
    /// Directions of the two gaps beside the tooth, in the frame of the sprocket: the tooth is the left flank of the first and the
    /// right flank of the second.
    gaps: [[f64; 2]; 2],
    first: usize,
    last: usize,
}

/// Surfaces of a sprocket's teeth, by their numbers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SurfaceTable {
    rows: Vec<SurfaceRow>,
    /// Index of the last surface of undamaged teeth.
    last: usize,
    damaged: Vec<Damaged>,
    has_lines: bool,
    seat_center_radius: f64,
    /// Cosine and sine of half the angle between adjacent gaps.
    half_gap: [f64; 2],
    /// Centre of the teeth in the frame of the sprocket \[m\].
    offset: [f64; 2],
}

impl SurfaceTable {
    /// Return the table of sprocket `s`.
    pub(crate) fn new(model: &Model, s: usize) -> Self {
        let sprocket = &model.sprockets[s];
        let law = |surface| surface_constants(model, s, surface);
        Self::of(
            &sprocket.profile,
            model.teeth.contact_radius,
            sprocket.offset,
            law,
        )
    }

    /// Return the table for cylinders of `radius` on `profile`, with the law constants of its surfaces.
    fn of(
        profile: &ToothProfile,
        radius: f64,
        offset: Vec2,
        law: impl Fn(Surface) -> [f64; 2],
    ) -> Self {
        let surfaces = profile.surfaces();
        let rows = (0..).zip(surfaces).map(|(number, piece)| {
            let before = usize::from(number).checked_sub(1).map(|i| &surfaces[i]);
            SurfaceRow::new(piece, before, radius, law(Surface(number)))
        });
        let gap = |number: u32| {
            let (sin, cos) = (f64::from(number % profile.teeth) * profile.gap_angle()).sin_cos();
            [cos, sin]
        };
        let damaged = profile.damaged().map(|(tooth, surfaces)| Damaged {
            gaps: [gap(tooth), gap(tooth + 1)],
            first: surfaces.start,
            last: surfaces.end - 1,
        });
        let (sin, cos) = (0.5 * profile.gap_angle()).sin_cos();
        Self {
            rows: rows.collect(),
            last: profile.whole().len() - 1,
            damaged: damaged.collect(),
            has_lines: surfaces
                .iter()
                .any(|piece| matches!(piece.curve, SurfaceCurve::Straight(_))),
            seat_center_radius: profile.seat_center_radius,
            half_gap: [cos, sin],
            offset: [offset.x, offset.y],
        }
    }
}

#[cfg(test)]
mod tests;

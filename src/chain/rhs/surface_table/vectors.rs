//! Gap of a SIMD vector of bushings from the table of surfaces.

use pulp::Simd;

use super::{NOWHERE, SurfaceRow, SurfaceTable};
use crate::chain::rhs::gap::{Gap, GapConstants, InGap};
use crate::math::simd::{Lanes, Mask, splat_two};

/// Table for SIMD vectors of bushings.
pub(crate) struct TableVectors<'a, S: Simd> {
    simd: S,
    table: &'a SurfaceTable,
}

impl GapConstants for SurfaceTable {
    type Of<'a, S: Simd> = TableVectors<'a, S>;

    #[inline(always)]
    fn gap<S: Simd>(&self, simd: S) -> TableVectors<'_, S> {
        TableVectors { simd, table: self }
    }
}

/// Nearest row of each bushing.
#[derive(Clone, Copy)]
struct NearestSurface<S: Simd> {
    number: Lanes<S>,
    center: [Lanes<S>; 2],
    touch: Lanes<S>,
    side: Lanes<S>,
}

impl<S: Simd> NearestSurface<S> {
    /// Return a table row in all lanes.
    #[inline(always)]
    fn of(simd: S, number: usize, row: &SurfaceRow) -> Self {
        let splat = |value| Lanes::splat(simd, value);
        Self {
            number: splat(number as f64),
            center: splat_two(simd, row.center),
            touch: splat(row.touch),
            side: splat(row.side),
        }
    }

    /// Return `by` in the lanes of `where_true`, `self` elsewhere.
    #[inline(always)]
    fn replaced(self, where_true: Mask<S>, by: &Self) -> Self {
        Self {
            number: where_true.select(by.number, self.number),
            center: where_true.select_two(by.center, self.center),
            touch: where_true.select(by.touch, self.touch),
            side: where_true.select(by.side, self.side),
        }
    }
}

/// Bushings whose nearest surface is a straight line, their penetration and the line's normal.
type OnLine<S> = (Mask<S>, Lanes<S>, [Lanes<S>; 2]);

/// Nearest surface of each bushing, and position relative to its centre of curvature.
pub(crate) struct NearestOfTable<S: Simd> {
    found: NearestSurface<S>,
    /// Bushings on left flanks.
    left: Mask<S>,
    /// Position of the bushing relative to the centre of curvature; u as on the right flank, v \[m\].
    offset: [Lanes<S>; 2],
    distance_squared: Lanes<S>,
    /// Straight lines, where the table has any.
    line: Option<OnLine<S>>,
    near: Mask<S>,
}

impl<S: Simd> TableVectors<'_, S> {
    /// Return a vector with `value` in all lanes.
    #[inline(always)]
    fn splat(&self, value: f64) -> Lanes<S> {
        Lanes::splat(self.simd, value)
    }

    /// Return the nearest of the rows `first` to `last`, which are adjacent surfaces.
    #[inline(always)]
    fn scan(&self, first: usize, last: usize, [right, v]: [Lanes<S>; 2]) -> NearestSurface<S> {
        let rows = &self.table.rows;
        let mut found = NearestSurface::of(self.simd, first, &rows[first]);
        let mut past: Option<Mask<S>> = None;
        for (number, row) in rows.iter().enumerate().take(last + 1).skip(first + 1) {
            // A bushing is on this row or a later one if it is past the boundary to the row before and past all earlier boundaries.
            let [tangent_u, tangent_v] = splat_two(self.simd, row.tangent);
            let along = right.mul_add(tangent_u, v * tangent_v);
            let within = along.less(self.splat(row.from));
            let here = match past {
                Some(before) => before.and(within.not()),
                None => within.not(),
            };
            found = found.replaced(here, &NearestSurface::of(self.simd, number, row));
            past = Some(here);
        }
        found
    }

    /// Return the bushings in the gap with this direction in the frame of the sprocket.
    #[inline(always)]
    fn within(&self, place: &InGap<S>, gap: [f64; 2]) -> Mask<S> {
        let [cos, sin] = splat_two(self.simd, gap);
        let [gap_cos, gap_sin] = place.gap;
        let half = self.splat(self.table.half_gap[0]);
        // Cosine of the angle between the two directions above that of half a pitch.
        gap_cos.mul_add(cos, gap_sin * sin).greater(half)
    }

    /// Return the nearest row of one flank, undamaged or damaged, and the penetration there.
    #[inline(always)]
    fn flank(&self, left: bool, place: &InGap<S>, v: Lanes<S>) -> (NearestSurface<S>, Lanes<S>) {
        let table = self.table;
        let across = [if left { -place.u } else { place.u }, v];
        let mut found = self.scan(0, table.last, across);
        let mut first = self.splat(0.0);
        for damaged in &table.damaged {
            let own = self.within(place, damaged.gaps[usize::from(!left)]);
            if own.any() {
                let other = self.scan(damaged.first, damaged.last, across);
                found = found.replaced(own, &other);
                first = own.select(self.splat(damaged.first as f64), first);
            }
        }
        let nearest = self.measure(found, place.on_left(), across);
        // The first curve of a flank ends in the middle of the gap.
        let past_middle = across[0].less(self.splat(0.0));
        let middle = (found.number - first).less(self.splat(0.5));
        let depth = nearest.depth();
        let depth = past_middle.and(middle).select(self.splat(NOWHERE), depth);
        (found, depth)
    }

    /// Return the geometry of bushings at `across` (u as on the right flank, v) relative to their nearest rows.
    #[inline(always)]
    fn measure(
        &self,
        found: NearestSurface<S>,
        left: Mask<S>,
        [across, v]: [Lanes<S>; 2],
    ) -> NearestOfTable<S> {
        let table = self.table;
        let zero = self.splat(0.0);
        let offset = [across - found.center[0], v - found.center[1]];
        let distance_squared = offset[0].mul_add(offset[0], offset[1] * offset[1]);
        // Overlap, without a square root: d > D inside an arc (side 1), d < D outside (side -1).
        let beyond = distance_squared - found.touch * found.touch;
        let near = (found.side * beyond).exceeds(zero);
        let mut nearest = NearestOfTable {
            found,
            left,
            offset,
            distance_squared,
            line: None,
            near,
        };
        if table.has_lines {
            let lines = found.side.abs().less(self.splat(0.5));
            let mut normal = [zero, zero];
            for (number, row) in table.rows.iter().enumerate() {
                if row.side == 0.0 {
                    let own = (found.number - self.splat(number as f64)).abs();
                    let own = own.less(self.splat(0.5));
                    normal = own.select_two(splat_two(self.simd, row.normal), normal);
                }
            }
            // Line: distance of the centre from it, along the normal into the material, plus radius.
            let depth = offset[0].mul_add(normal[0], offset[1] * normal[1]) + found.touch;
            nearest.near = lines.and(depth.exceeds(zero)).or(lines.not().and(near));
            nearest.line = Some((lines, depth, normal));
        }
        nearest
    }
}

impl<S: Simd> NearestOfTable<S> {
    /// Return the penetration: side (d - D) on arcs, linear on straight lines.
    #[inline(always)]
    fn depth(&self) -> Lanes<S> {
        let NearestSurface { touch, side, .. } = self.found;
        let depth = side * (self.distance_squared.sqrt() - touch);
        match self.line {
            Some((lines, line_depth, _)) => lines.select(line_depth, depth),
            None => depth,
        }
    }
}

impl<S: Simd> Gap<S> for TableVectors<'_, S> {
    type Nearest = NearestOfTable<S>;

    #[inline(always)]
    fn place(
        &self,
        [arm_x, arm_y]: [Lanes<S>; 2],
        [cos, sin]: [Lanes<S>; 2],
        gap: [Lanes<S>; 2],
    ) -> InGap<S> {
        let [x, y] = splat_two(self.simd, self.table.offset);
        let from_teeth = [
            arm_x - cos.mul_add(x, -(sin * y)),
            arm_y - sin.mul_add(x, cos * y),
        ];
        InGap::new(from_teeth, [cos, sin], gap)
    }

    #[inline(always)]
    fn half_gap(&self) -> [Lanes<S>; 2] {
        splat_two(self.simd, self.table.half_gap)
    }

    #[inline(always)]
    fn near(&self, surface: &NearestOfTable<S>) -> Mask<S> {
        surface.near
    }

    #[inline(always)]
    fn nearest(&self, place: &InGap<S>) -> NearestOfTable<S> {
        let table = self.table;
        let mut across = place.u.abs();
        let mut left = place.on_left();
        let v = place.outward - self.splat(table.seat_center_radius);
        let mut found = self.scan(0, table.last, [across, v]);
        // In a gap beside a damaged tooth either flank may be nearer, wherever a bushing is: the flank with the larger penetration
        // is selected.
        let mut beside = place.u.less(place.u);
        for damaged in &table.damaged {
            for gap in damaged.gaps {
                beside = beside.or(self.within(place, gap));
            }
        }
        if !table.damaged.is_empty() && beside.any() {
            let (on_right, right_depth) = self.flank(false, place, v);
            let (on_left, left_depth) = self.flank(true, place, v);
            let deeper = left_depth.greater(right_depth);
            found = found.replaced(beside, &on_right.replaced(deeper, &on_left));
            let nearer = deeper.select(-place.u, place.u);
            across = beside.select(nearer, across);
            left = beside.and(deeper).or(beside.not().and(left));
        }
        self.measure(found, left, [across, v])
    }

    #[inline(always)]
    fn depth(
        &self,
        surface: &NearestOfTable<S>,
        place: &InGap<S>,
    ) -> (Lanes<S>, [Lanes<S>; 2], Lanes<S>) {
        let zero = self.splat(0.0);
        let side = surface.found.side;
        let distance = surface.distance_squared.sqrt();
        let apart = distance.exceeds(zero);
        let mut curvature = apart.select(side / distance, zero);
        let depth = surface.depth();
        let mut normal = [surface.offset[0] * curvature, surface.offset[1] * curvature];
        if let Some((lines, _, line_normal)) = surface.line {
            curvature = lines.select(zero, curvature);
            normal = lines.select_two(line_normal, normal);
        }
        (depth, place.to_scene(surface.left, normal), curvature)
    }

    #[inline(always)]
    fn gap_and_rate(
        &self,
        surface: &NearestOfTable<S>,
        place: &InGap<S>,
        velocity: [Lanes<S>; 2],
    ) -> [Lanes<S>; 2] {
        let NearestSurface { touch, side, .. } = surface.found;
        let [right, outward] = place.in_gap(surface.left, velocity);
        let scale = side * (self.splat(0.5) / touch);
        // Gap side (d² - D²)/(2 D) and its rate side (offset · velocity)/D.
        let mut gap = (surface.distance_squared - touch * touch) * scale;
        let mut rate =
            surface.offset[0].mul_add(right, surface.offset[1] * outward) * (scale + scale);
        if let Some((lines, depth, normal)) = surface.line {
            let on_line = right.mul_add(normal[0], outward * normal[1]);
            gap = lines.select(depth, gap);
            rate = lines.select(on_line, rate);
        }
        [gap, rate]
    }

    #[inline(always)]
    fn surface(&self, surface: &NearestOfTable<S>, _place: &InGap<S>) -> (Lanes<S>, Mask<S>) {
        (surface.found.number, surface.left)
    }

    #[inline(always)]
    fn law_constants(&self, surface: &NearestOfTable<S>) -> [Lanes<S>; 2] {
        let rows = &self.table.rows;
        let mut law = splat_two(self.simd, rows[0].law);
        for (number, row) in rows.iter().enumerate().skip(1) {
            let from_here = surface
                .found
                .number
                .greater(self.splat(number as f64 - 0.5));
            law = from_here.select_two(splat_two(self.simd, row.law), law);
        }
        law
    }
}

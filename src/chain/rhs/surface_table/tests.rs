//! Tests of the table of surfaces against the scalar profile, for every tooth form.

use pulp::{Simd, WithSimd};

use super::*;
use crate::chain::rhs::gap::{Gap, GapConstants};
use crate::geometry::{Blank, Damage, IsoGap, Seat};
use crate::math::simd::{InstructionSet, Lanes};

const RADIUS: f64 = 3.968_75e-3;

/// Kernel for one point (u, outward) of gap 0: surface, penetration, normal (u, v), and whether bushing and surface overlap.
struct At<'a>(&'a SurfaceTable, Vec2);

impl WithSimd for At<'_> {
    type Output = (Surface, f64, Vec2, bool);

    #[inline(always)]
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a small whole number
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let splat = |value| Lanes::splat(simd, value);
        let gap = self.0.gap(simd);
        let along_x = [splat(1.0), splat(0.0)];
        // v along x, so that u is along -y.
        let place = gap.place([splat(self.1.y), splat(-self.1.x)], along_x, along_x);
        let surface = gap.nearest(&place);
        let (depth, [x, y], _) = gap.depth(&surface, &place);
        let number = gap.law_constants(&surface)[0].greatest();
        (
            Surface(number as u8),
            depth.greatest(),
            Vec2::new(-y.greatest(), x.greatest()),
            gap.near(&surface).any(),
        )
    }
}

fn profiles() -> Vec<ToothProfile> {
    let mut profiles = Vec::new();
    for teeth in [9, 17, 60] {
        let full = ToothProfile::ansi(0.0127, 2.0 * RADIUS, teeth, Seat::BottomDiameter);
        let blank = Blank {
            pitch: 0.0127,
            roller_diameter: 2.0 * RADIUS,
            teeth,
            seat: Seat::BottomDiameter,
            outside_radius: full.pitch_radius + 2.8e-3,
            edge_radius: 2e-4,
        };
        let iso = IsoGap::new(2.0 * RADIUS, teeth, 0.3);
        for whole in [
            full.cut(full.outside_radius, 2e-4).unwrap(),
            ToothProfile::iso(&blank, &iso).unwrap(),
            ToothProfile::straight(&blank, 4.01e-3, 0.4).unwrap(),
        ] {
            // Both flanks of gap 0 are damaged, and others that do not belong to it.
            let damage = [(0, 0.5), (teeth - 1, 0.0), (3, 0.5)];
            let damage = damage.map(|(tooth, height)| Damage { tooth, height });
            profiles.push(whole.clone().with_damage(&damage, 2e-4).unwrap());
            profiles.push(whole);
        }
        profiles.push(full);
    }
    profiles
}

/// Return points (u, outward) of both flanks: on the normals at the ends of surfaces and in between, and a few units of
/// rounding beside them.
fn points(profile: &ToothProfile) -> Vec<Vec2> {
    let mut points = Vec::new();
    for piece in profile.surfaces() {
        let middle = piece.curve.sweep(piece.start, piece.end, 3);
        for foot in [piece.start, piece.end].into_iter().chain(middle) {
            let off = crate::geometry::turned_left(piece.curve.tangent(foot));
            for i in (-100..=300).step_by(25) {
                let point = foot + (RADIUS + 1e-6 * f64::from(i)) * off - profile.center();
                for beside in -2..=2 {
                    let u = point.x + f64::from(beside) * f64::EPSILON * RADIUS;
                    points.extend([Vec2::new(u, point.y), Vec2::new(-u, point.y)]);
                }
            }
        }
    }
    points
}

/// Compare with the scalar reference implementation at the same point: penetrations to 8 units of rounding of the distance of
/// centres and of the distant starts of straight lines.
#[test]
fn a_point_of_every_form_has_the_depth_and_normal_of_the_twin() {
    for profile in profiles() {
        let law = |surface: Surface| [f64::from(surface.0), 0.0];
        let table = SurfaceTable::of(&profile, RADIUS, Vec2::zeros(), law);
        let mut seen = vec![0; profile.surfaces().len()];
        for point in points(&profile) {
            let in_gap = point + profile.center();
            let twin = profile.contact_in(0, in_gap, RADIUS);
            seen[twin.surface.index()] += 1;
            for set in InstructionSet::available() {
                let (surface, depth, normal, near) = set.run(At(&table, point));
                let what = format!(
                    "{} {} teeth at {in_gap:?}: {surface:?}, {twin:?}",
                    set.name(),
                    profile.teeth
                );
                // On a joint either of the two surfaces is nearest; they have a common normal there.
                let size = profile.outside_radius;
                let off = (depth - twin.penetration).abs();
                assert!(off <= 4.0 * f64::EPSILON * size, "{what}: {off:e}");
                let seat = profile.surfaces()[surface.index()].step == 0;
                let far = in_gap.norm() > 1e-4 || !seat;
                let turned = (normal - twin.normal).amax();
                let unit = f64::EPSILON * size / (RADIUS * 0.01);
                assert!(turned <= unit || !far, "{what}: {turned:e}");
                assert!(near || depth <= 0.0, "{what}: {depth:e} unseen");
                assert!(!near || depth >= -1e-18, "{what}: {depth:e}");
            }
        }
        // Gap 0 has no undamaged surfaces where both of its flanks are damaged.
        let first = profile
            .damaged()
            .next()
            .map_or(0, |_| profile.whole().len());
        let missing: Vec<usize> = (first..seen.len()).filter(|&i| seen[i] < 3).collect();
        assert!(missing.is_empty(), "{missing:?} of {} teeth", profile.teeth);
    }
}

//! Contact of a bushing with the surfaces of a tooth gap.

use crate::chain::model::SprocketModel;
use crate::geometry::{Contact, Surface, Vec2};

/// Position, orientation and velocity of a sprocket.
#[derive(Debug, Clone, Copy)]
pub struct SprocketFrame {
    /// Centre \[m\].
    pub center: Vec2,
    /// Velocity of the centre \[m/s\].
    pub velocity: Vec2,
    /// Angular speed \[rad/s\].
    pub spin: f64,
    /// cos θ
    pub cos: f64,
    /// sin θ
    pub sin: f64,
}

impl SprocketFrame {
    /// Create the frame of a sprocket from centre, velocity, angle \[rad\] and angular speed `spin` \[rad/s\].
    #[must_use]
    pub fn new(center: Vec2, velocity: Vec2, angle: f64, spin: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self {
            center,
            velocity,
            spin,
            cos,
            sin,
        }
    }
}

/// Contact of a bushing with a tooth gap of a sprocket.
#[derive(Debug, Clone, Copy)]
pub struct OnGap {
    /// Normal, penetration and penetration rate.
    pub contact: Contact,
    /// Number of the surface.
    pub surface: Surface,
    /// Region from 1.
    pub region: u8,
    /// Number of the tooth gap, from 0.
    pub gap: u32,
}

/// Return the contact of one bushing with one sprocket; `None` when the bushing is out of reach of every tooth.
#[must_use]
pub fn bushing_on_sprocket(
    sprocket: &SprocketModel,
    frame: &SprocketFrame,
    point: Vec2,
    velocity: Vec2,
    radius: f64,
) -> Option<OnGap> {
    let arm = point - frame.center;
    if arm.norm_squared() >= sprocket.reach * sprocket.reach {
        return None;
    }
    Some(on_gap(sprocket, frame, arm, velocity, radius))
}

/// Return the same contact at any distance, for a bushing that was near `gap`.
///
/// The comparison with both neighbouring gaps replaces the arc tangent of the general search.
pub(super) fn bushing_near_gap(
    sprocket: &SprocketModel,
    frame: &SprocketFrame,
    point: Vec2,
    velocity: Vec2,
    radius: f64,
    gap: u32,
) -> OnGap {
    let arm = point - frame.center;
    let gaps = &sprocket.gap_directions;
    let in_body = seen_from_teeth(sprocket, frame, arm);
    let towards = |gap: usize| in_body.x * gaps[gap].0 + in_body.y * gaps[gap].1;
    let (here, last) = (gap as usize, gaps.len() - 1);
    let before = if here == 0 { last } else { here - 1 };
    let behind = if here == last { 0 } else { here + 1 };
    let own = towards(here);
    if own >= towards(before) && own >= towards(behind) {
        in_gap(sprocket, frame, arm, velocity, radius, gap)
    } else {
        on_gap(sprocket, frame, arm, velocity, radius)
    }
}

/// Return `arm` in the frame of the sprocket, relative to the centre of its teeth.
pub(crate) fn seen_from_teeth(sprocket: &SprocketModel, frame: &SprocketFrame, arm: Vec2) -> Vec2 {
    Vec2::new(
        arm.x * frame.cos + arm.y * frame.sin,
        arm.y * frame.cos - arm.x * frame.sin,
    ) - sprocket.offset
}

/// Return the contact of a bushing with the nearest tooth gap.
fn on_gap(
    sprocket: &SprocketModel,
    frame: &SprocketFrame,
    arm: Vec2,
    velocity: Vec2,
    radius: f64,
) -> OnGap {
    let in_body = seen_from_teeth(sprocket, frame, arm);
    let gap = sprocket.profile.nearest_gap(in_body.y.atan2(in_body.x));
    in_gap(sprocket, frame, arm, velocity, radius, gap)
}

/// Return the contact of a bushing with tooth gap `gap`.
fn in_gap(
    sprocket: &SprocketModel,
    frame: &SprocketFrame,
    arm: Vec2,
    velocity: Vec2,
    radius: f64,
    gap: u32,
) -> OnGap {
    let profile = &sprocket.profile;
    let (cos, sin) = sprocket.gap_directions[gap as usize];
    // v: radially outward through the gap; u: v turned clockwise.
    let v = Vec2::new(
        frame.cos * cos - frame.sin * sin,
        frame.sin * cos + frame.cos * sin,
    );
    let u = Vec2::new(v.y, -v.x);
    let offset = sprocket.offset;
    let from_teeth = arm
        - Vec2::new(
            frame.cos * offset.x - frame.sin * offset.y,
            frame.sin * offset.x + frame.cos * offset.y,
        );
    let found = profile.contact_in(
        gap,
        Vec2::new(
            from_teeth.dot(&u),
            from_teeth.dot(&v) - profile.seat_center_radius,
        ),
        radius,
    );
    let normal = found.normal.x * u + found.normal.y * v;
    // Each surface is fixed in the sprocket; its normal is constant or lies on the line of centres. In every region, the penetration
    // rate is therefore n · (v_bushing - v_centre - ω × arm).
    let relative = velocity - frame.velocity - frame.spin * Vec2::new(-arm.y, arm.x);
    OnGap {
        contact: Contact {
            normal,
            penetration: found.penetration,
            penetration_rate: normal.dot(&relative),
        },
        surface: found.surface,
        region: found.region,
        gap,
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{compiled, drive};
    use super::*;
    use crate::chain::model::Model;
    use crate::geometry::unit;
    use crate::math::testing::random;

    const RADIUS: f64 = 3.97e-3;

    /// Return a sprocket with eccentric teeth.
    fn model() -> Model {
        compiled(&drive()).0
    }

    /// Return the place of a bushing that touches teeth: `part` of a gap from that of `gap`, above the bottom by `height` \[m\].
    fn near_teeth(sprocket: &SprocketModel, gap: f64, height: f64) -> Vec2 {
        let distance = sprocket.profile.seat_center_radius + height;
        sprocket.offset + distance * unit(gap * sprocket.profile.gap_angle())
    }

    /// Return the frame of a sprocket at the time `t` \[s\] of a steady motion.
    fn frame(t: f64) -> SprocketFrame {
        let velocity = Vec2::new(0.4, -0.2);
        SprocketFrame::new(
            Vec2::new(0.3, 0.1) + t * velocity,
            velocity,
            0.8 - 7.0 * t,
            -7.0,
        )
    }

    /// Return a place in the frame of the sprocket in that of the ground.
    fn on_ground(frame: &SprocketFrame, place: Vec2) -> Vec2 {
        let (x, y) = (
            Vec2::new(frame.cos, frame.sin),
            Vec2::new(-frame.sin, frame.cos),
        );
        frame.center + place.x * x + place.y * y
    }

    #[test]
    fn a_place_is_seen_from_the_centre_of_the_teeth_in_the_frame_of_the_sprocket() {
        let model = model();
        let (here, sprocket) = (frame(0.0), &model.sprockets[1]);
        for place in [
            Vec2::zeros(),
            Vec2::new(0.03, -0.01),
            Vec2::new(-0.02, 0.04),
        ] {
            let arm = on_ground(&here, sprocket.offset + place) - here.center;
            assert!((seen_from_teeth(sprocket, &here, arm) - place).norm() < 1e-16);
        }
    }

    #[test]
    fn the_contact_is_that_of_the_profile_in_the_nearest_gap() {
        let model = model();
        let sprocket = &model.sprockets[1];
        assert!(sprocket.offset.norm() > 1e-5);
        let here = frame(0.0);
        let mut next = random(5);
        for gap in (0..21).cycle().take(3000) {
            let (number, across) = (f64::from(gap), 0.45 * next());
            let place = near_teeth(sprocket, number + across, 2e-3 * next());
            let found = bushing_on_sprocket(
                sprocket,
                &here,
                on_ground(&here, place),
                Vec2::zeros(),
                RADIUS,
            )
            .unwrap();
            assert_eq!(found.gap, gap);
            // The gap along y of its own frame, seen by turning the sprocket back.
            let own = on_ground(
                &SprocketFrame::new(
                    Vec2::zeros(),
                    Vec2::zeros(),
                    std::f64::consts::FRAC_PI_2 - number * sprocket.profile.gap_angle(),
                    0.0,
                ),
                place - sprocket.offset,
            );
            let exact = sprocket.profile.contact_in(
                found.gap,
                own - Vec2::new(0.0, sprocket.profile.seat_center_radius),
                RADIUS,
            );
            assert_eq!((found.surface, found.region), (exact.surface, exact.region));
            assert!((found.contact.penetration - exact.penetration).abs() < 1e-15);
        }
    }

    #[test]
    fn the_rate_is_the_change_of_the_penetration_and_the_normal_its_gradient() {
        let model = model();
        let sprocket = &model.sprockets[1];
        let mut next = random(9);
        let mut count = 0;
        for _ in 0..500 {
            let place = near_teeth(sprocket, 10.5 * (1.0 + next()), 1e-3 * next());
            let velocity = 3.0 * Vec2::new(next(), next());
            let begin = on_ground(&frame(0.0), place);
            let at = |t: f64, beside: Vec2| {
                bushing_on_sprocket(
                    sprocket,
                    &frame(t),
                    begin + beside + t * velocity,
                    velocity,
                    RADIUS,
                )
                .unwrap()
            };
            let found = at(0.0, Vec2::zeros());
            let (h, step) = (1e-8, 1e-8);
            let [before, after] = [-h, h].map(|t| at(t, Vec2::zeros()));
            let sides = [Vec2::x(), Vec2::y()].map(|axis| [-step, step].map(|x| at(0.0, x * axis)));
            let same = |other: &OnGap| {
                other.surface == found.surface
                    && other.region == found.region
                    && other.gap == found.gap
            };
            // Where the bushing passes to another surface, both sides of the difference are of two curves.
            if ![&before, &after]
                .into_iter()
                .chain(sides.iter().flatten())
                .all(same)
            {
                continue;
            }
            let rate = (after.contact.penetration - before.contact.penetration) / (2.0 * h);
            // Rounding of 1e-17 m over the step of the difference, and its square over the radius.
            assert!(
                (found.contact.penetration_rate - rate).abs() < 1e-6,
                "{rate}"
            );
            for (side, normal) in sides.iter().zip(found.contact.normal.iter()) {
                let slope =
                    (side[1].contact.penetration - side[0].contact.penetration) / (2.0 * step);
                assert!((normal - slope).abs() < 1e-6, "{slope} {normal}");
            }
            count += 1;
        }
        assert!(count > 450, "{count}");
    }

    #[test]
    fn a_bushing_out_of_reach_of_every_tooth_has_no_contact() {
        let model = model();
        let sprocket = &model.sprockets[1];
        let here = frame(0.0);
        for (distance, found) in [(0.999_999, true), (1.0, false), (1.000_001, false)] {
            let point = here.center + distance * Vec2::new(sprocket.reach, 0.0);
            let arm = point - here.center;
            // Rounding decides at the reach itself.
            if distance == 1.0 && arm.norm_squared() < sprocket.reach * sprocket.reach {
                continue;
            }
            let contact = bushing_on_sprocket(sprocket, &here, point, Vec2::zeros(), RADIUS);
            assert_eq!(contact.is_some(), found, "{distance}");
        }
    }

    #[test]
    fn a_bushing_that_has_left_a_gap_is_seen_in_the_nearest_one() {
        let model = model();
        let sprocket = &model.sprockets[1];
        let here = frame(0.0);
        for gap in 0..21u32 {
            // Gaps ahead and the position beside their middle.
            let beside = [
                (18, 0.4),
                (20, -0.4),
                (20, 0.4),
                (0, -0.4),
                (0, 0.0),
                (0, 0.4),
                (1, -0.4),
            ];
            for (ahead, part) in beside {
                let place = f64::from(gap + ahead) + part;
                let point = on_ground(&here, near_teeth(sprocket, place, 1e-3));
                let velocity = Vec2::new(0.7, 0.3);
                let exact = bushing_on_sprocket(sprocket, &here, point, velocity, RADIUS).unwrap();
                let found = bushing_near_gap(sprocket, &here, point, velocity, RADIUS, gap);
                let nearest = (gap + ahead) % 21;
                assert_eq!((found.gap, exact.gap), (nearest, nearest));
                assert_eq!(found.contact, exact.contact);
            }
        }
    }
}

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

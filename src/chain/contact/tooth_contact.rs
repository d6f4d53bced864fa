//! Bushing on the surfaces of a tooth gap.

use super::{HingeContacts, on_teeth};
use crate::chain::model::{Model, SprocketModel};
use crate::chain::motion::Motion;
use crate::geometry::Contact;
use crate::geometry::{Surface, Vec2, turned_left};

/// All bushings against all sprockets; pair `sprocket * links + bushing`.
#[derive(Debug, Clone)]
pub struct ToothContacts {
    /// Penetration δ \[m\]; -inf when not even near.
    pub penetration: Vec<f64>,
    /// The pairs that are near, in rising order; the arrays below hold for these only.
    pub near: Vec<u32>,
    /// dδ/dt \[m/s\].
    pub rate: Vec<f64>,
    /// Direction in which the penetration grows, x.
    pub normal_x: Vec<f64>,
    /// The same, y.
    pub normal_y: Vec<f64>,
    /// Bushing's centre seen from the sprocket's, x \[m\].
    pub arm_x: Vec<f64>,
    /// The same, y \[m\].
    pub arm_y: Vec<f64>,
    /// Number of the surface.
    pub surface: Vec<Surface>,
    /// Region from 1.
    pub region: Vec<u8>,
    /// Gap the bushing is in.
    pub gap: Vec<u32>,
    /// Normal force \[N\], written by the dynamics.
    pub force: Vec<f64>,
    /// Friction on the sprocket, along the normal turned left \[N\]; zero without a law of friction.
    pub friction: Vec<f64>,
}

impl ToothContacts {
    /// Room for every pair.
    #[must_use]
    pub fn new(links: usize, sprockets: usize) -> Self {
        let pairs = links * sprockets;
        let zeros = || vec![0.0; pairs];
        Self {
            penetration: vec![f64::NEG_INFINITY; pairs],
            near: Vec::with_capacity(pairs),
            rate: zeros(),
            normal_x: zeros(),
            normal_y: zeros(),
            arm_x: zeros(),
            arm_y: zeros(),
            surface: vec![Surface::SEATING; pairs],
            region: vec![0; pairs],
            gap: vec![0; pairs],
            force: zeros(),
            friction: zeros(),
        }
    }

    /// Force of the sprocket on the bushing of a near pair, friction included \[N\].
    #[must_use]
    pub fn force_on_bushing(&self, pair: usize) -> Vec2 {
        let normal = Vec2::new(self.normal_x[pair], self.normal_y[pair]);
        -self.force[pair] * normal - self.friction[pair] * turned_left(normal)
    }

    /// Finds the depth of every bushing on every sprocket that is near enough.
    #[allow(clippy::cast_possible_truncation)] // pairs are far fewer than 2^32
    pub fn find(&mut self, model: &Model, motion: &Motion, hinges: &HingeContacts) {
        for &pair in &self.near {
            self.penetration[pair as usize] = f64::NEG_INFINITY;
            self.force[pair as usize] = 0.0;
            self.friction[pair as usize] = 0.0;
        }
        self.near.clear();
        for (s, sprocket) in model.sprockets.iter().enumerate() {
            let frame = SprocketFrame::of(motion, model.wheel_body(s));
            let reach_squared = sprocket.reach * sprocket.reach;
            for k in (0..model.links).filter(|&k| model.bushing_is_there(k)) {
                let ((point, velocity), _) = on_teeth(model, motion, hinges, k);
                let arm = point - frame.center;
                if arm.norm_squared() >= reach_squared {
                    continue;
                }
                let found = on_gap(sprocket, &frame, arm, velocity, model.contact_radius);
                let pair = s * model.links + k;
                self.near.push(pair as u32);
                self.penetration[pair] = found.contact.penetration;
                self.rate[pair] = found.contact.penetration_rate;
                self.normal_x[pair] = found.contact.normal.x;
                self.normal_y[pair] = found.contact.normal.y;
                self.arm_x[pair] = arm.x;
                self.arm_y[pair] = arm.y;
                self.surface[pair] = found.surface;
                self.region[pair] = found.region;
                self.gap[pair] = found.gap;
            }
        }
    }
}

/// A sprocket's place and motion.
#[derive(Debug, Clone, Copy)]
pub struct SprocketFrame {
    /// Centre \[m\].
    pub center: Vec2,
    /// Its velocity \[m/s\].
    pub velocity: Vec2,
    /// Angular speed \[rad/s\].
    pub spin: f64,
    /// cos θ
    pub cos: f64,
    /// sin θ
    pub sin: f64,
}

impl SprocketFrame {
    /// A sprocket with this motion.
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

    fn of(motion: &Motion, body: usize) -> Self {
        Self {
            center: Vec2::new(motion.x[body], motion.y[body]),
            velocity: Vec2::new(motion.vx[body], motion.vy[body]),
            spin: motion.spin[body],
            cos: motion.cos[body],
            sin: motion.sin[body],
        }
    }
}

/// A bushing in the gap of a sprocket.
#[derive(Debug, Clone, Copy)]
pub struct OnGap {
    /// Depth and rate.
    pub contact: Contact,
    /// Number of the surface.
    pub surface: Surface,
    /// Region from 1.
    pub region: u8,
    /// Gap, from 0.
    pub gap: u32,
}

/// One bushing against one sprocket; `None` when it is out of reach of every tooth.
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

/// The same at any distance, for a bushing that was near `gap`, which saves the angle that it would be found by.
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

/// `arm` in the frame of the sprocket, from the centre of its teeth.
pub(crate) fn seen_from_teeth(sprocket: &SprocketModel, frame: &SprocketFrame, arm: Vec2) -> Vec2 {
    Vec2::new(
        arm.x * frame.cos + arm.y * frame.sin,
        arm.y * frame.cos - arm.x * frame.sin,
    ) - sprocket.offset
}

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
    // Each surface is fixed in the sprocket and its normal points along the line of centres (or is constant): the
    // bushing's velocity seen from the sprocket at the same place gives the rate in every region.
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

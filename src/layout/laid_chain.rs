//! Measurements on a laid chain: seats of its bushings, stretch of its hinges, smallest gap to a tooth.

use crate::drive::Chain;
use crate::geometry::path::wrap;
use crate::geometry::path::wrap::Wheel;
use crate::geometry::{ToothProfile, Vec2, unit};

/// Initial distances of seated bushings from their seats that are tried \[m\]; a stretched chain, whose bushings are beside
/// the middle of their seats, may need the larger ones.
pub(super) const START_GAPS: [f64; 4] = [1e-6, 3e-6, 1e-5, 3e-5];
/// Largest stretch of a chain at the start, over the hinge clearance.
pub(super) const LARGEST_STRETCH: f64 = 0.9;
/// Least distance of a bushing from a tooth at the start \[m\]: the least one that is tried, less a tenth.
const LEAST_GAP: f64 = 0.9 * START_GAPS[0];

/// Return the wheel of a sprocket with seated bushings at least `gap` \[m\] off their seats.
pub(super) fn wheel(profile: &ToothProfile, chain: &Chain, gap: f64) -> Wheel {
    let depth = seat_depth(profile, chain);
    Wheel {
        teeth: profile.teeth,
        hinge_radius: hinge_circle(profile, chain) + (depth + gap).max(0.0),
    }
}

/// Return the penetration of the bushing of a hinge on the hinge circle \[m\]; negative for a clearance.
pub(super) fn seat_depth(profile: &ToothProfile, chain: &Chain) -> f64 {
    let middle = Vec2::new(
        0.0,
        hinge_circle(profile, chain) - profile.seat_center_radius,
    );
    profile.contact(middle, chain.contact_radius()).penetration
}

/// Return the radius of the hinges of fully seated links \[m\]; longer links lie farther out.
fn hinge_circle(profile: &ToothProfile, chain: &Chain) -> f64 {
    wrap::pitch_radius(chain.mean_pitch(), profile.teeth)
}

/// Return the angle θ of a sprocket with a gap centre at `angle`: the one nearest to zero.
pub(super) fn phase(profile: &ToothProfile, angle: f64) -> f64 {
    let gap = profile.gap_angle();
    angle - (angle / gap).round() * gap
}

/// A chain laid round sprockets.
pub(super) struct Lie<'a> {
    pub(super) chain: &'a Chain,
    pub(super) hinges: &'a [Vec2],
    /// Centre, angle of a gap, and tooth profile of each sprocket.
    pub(super) sprockets: Vec<(Vec2, f64, &'a ToothProfile)>,
}

impl Lie<'_> {
    /// An open chain has a hinge at both of its ends.
    fn is_open(&self) -> bool {
        self.hinges.len() > self.chain.links as usize
    }

    /// Return the ends of every link in the model, (rear, front): half a pitch from its middle.
    fn link_ends(&self) -> Vec<(Vec2, Vec2)> {
        let pitches = self.chain.link_pitches();
        let n = pitches.len();
        (0..n)
            .map(|i| {
                let (rear, front) = if self.is_open() {
                    (self.hinges[i], self.hinges[i + 1])
                } else {
                    (self.hinges[(i + n - 1) % n], self.hinges[i])
                };
                let middle = 0.5 * (rear + front);
                let half = 0.5 * pitches[i] * (front - rear).normalize();
                (middle - half, middle + half)
            })
            .collect()
    }

    /// Return the largest distance of the centres of pin and bushing \[m\].
    pub(super) fn stretch(&self) -> f64 {
        let ends = self.link_ends();
        let next = ends.iter().cycle().skip(1);
        let joined = ends.len() - usize::from(self.is_open());
        ends.iter()
            .zip(next)
            .take(joined)
            .map(|((_, front), (rear, _))| (front - rear).norm())
            .fold(0.0, f64::max)
    }

    /// Return the fault of a chain whose hinges open too far or whose bushings are inside a tooth, if any. `opened`: the hinges that
    /// open; `where_and_remedy`: text before and after that of a bushing.
    pub(super) fn fault(&self, opened: &str, where_and_remedy: [&str; 2]) -> Option<String> {
        let (stretch, clearance) = (self.stretch(), self.chain.hinge.clearance());
        if stretch >= LARGEST_STRETCH * clearance {
            return Some(format!(
                "it would open {opened} by {:.1} um, and their clearance is {:.1} um",
                1e6 * stretch,
                1e6 * clearance
            ));
        }
        let ((gap, sprocket), [before, behind]) = (self.nearest_tooth(), where_and_remedy);
        (gap < LEAST_GAP).then(|| {
            format!(
                "{before}a bushing would start {:.3} um {} a tooth of sprocket {}{behind}",
                1e6 * gap.abs(),
                if gap < 0.0 { "inside" } else { "off" },
                sprocket + 1
            )
        })
    }

    /// Return the smallest distance of a bushing from a tooth \[m\]; infinite where none is near.
    pub(super) fn smallest_gap(&self) -> f64 {
        self.nearest_tooth().0
    }

    /// Return the smallest distance of a bushing from a tooth \[m\] and the sprocket of that tooth, from 0.
    fn nearest_tooth(&self) -> (f64, usize) {
        let radius = self.chain.contact_radius();
        let bushings: Vec<Vec2> = self
            .link_ends()
            .into_iter()
            .step_by(2) // the inner links
            .flat_map(|(rear, front)| [rear, front])
            .collect();
        let mut nearest_tooth = (f64::INFINITY, 0);
        for (i, &(center, first_seat, profile)) in self.sprockets.iter().enumerate() {
            for bushing in &bushings {
                let offset = bushing - center;
                if offset.norm() >= profile.reach(radius) {
                    continue;
                }
                let gap_angle = profile.gap_angle();
                let nearest = ((offset.y.atan2(offset.x) - first_seat) / gap_angle).round();
                let middle = unit(first_seat + nearest * gap_angle);
                let point = Vec2::new(
                    offset.perp(&middle),
                    offset.dot(&middle) - profile.seat_center_radius,
                );
                let gap = -profile.contact(point, radius).penetration;
                if gap < nearest_tooth.0 {
                    nearest_tooth = (gap, i);
                }
            }
        }
        nearest_tooth
    }
}

//! Initial configuration of guides: clear of the laid chain, with arms rotated back as far as needed.

use super::configuration::InitialConfiguration;
use super::laid_chain::{Lie, START_GAPS};
use super::report::{GuidePlacement, Layout};
use crate::drive::{Chain, Drive, Mount, Rail, RailShape};
use crate::error::{Error, Result, pair};
use crate::geometry::path::wrap::pitch_radius;
use crate::geometry::{ToothProfile, Vec2, distance_from_segment, turned_left, unit};
use crate::math::bisected;

/// Distance by which a proposed centre is farther than enough \[m\], for the rounding of the coordinates that are printed.
const MORE_THAN_ENOUGH: f64 = 1e-6;
/// Largest rotation of an arm from its described position \[rad\].
const FARTHEST_SWING: f64 = 1.0;
/// Points per arc of an outline that is checked against sprockets.
const OUTLINE_POINTS: usize = 24;
/// Number of parts of that rotation in the search for a clear position.
const SWINGS: u32 = 200;
/// Bisections of the displacement that a refusal proposes: 1 m to 1e-3 um.
const HALVINGS: u32 = 30;

impl InitialConfiguration {
    /// Return the same configuration with the guides of `drive` at rest, clear of its chain; writes their positions into `layout`.
    ///
    /// # Errors
    /// When a guide penetrates a sprocket, or the chain at its described position without an arm, or with an arm that cannot rotate far
    /// enough. The message has the penetration.
    pub(super) fn with_guides(mut self, drive: &Drive, layout: &mut Layout) -> Result<Self> {
        if drive.guides.is_empty() {
            return Ok(self);
        }
        let hinges = self.hinges(drive);
        for (number, rail) in drive.guides.iter().enumerate() {
            let outline = rail.for_bushings(drive.chain.contact_radius());
            let profile = outline.profile()?;
            let beside = Beside {
                chain: &drive.chain,
                hinges: &hinges,
                rail,
                profile: &profile,
                offset: outline.offset(),
            };
            let described = rail.angle();
            check_beside_sprockets(drive, number)?;
            let angle = clear_angle(rail, |angle| beside.gap(angle)).ok_or_else(|| {
                let inside = -beside.gap(described);
                overlap(number, rail, inside, beside.displacement(inside))
            })?;
            let turn = angle - described;
            let travel = plunger_travel(number, rail, turn)?;
            layout.start_gap = layout.start_gap.min(beside.gap(angle));
            let (nearest, gap, bushings) = beside.nearest(angle);
            if bushings == 0 && !matches!(rail.mount, Mount::Arm(_)) {
                layout.warnings.push(format!(
                    "guide {} has no bushing within half a pitch of it, the nearest at {:.1} mm: it has no contact",
                    number + 1,
                    1e3 * gap
                ));
            }
            let place = layout.place_of(nearest);
            layout.guides.push(GuidePlacement {
                gap,
                turn,
                travel,
                bushings,
                place,
            });
            let bearing = rail.bearing();
            self.positions.push([bearing.x, bearing.y, angle]);
            self.velocities.push([0.0; 3]);
        }
        Ok(self)
    }

    /// Return the hinges of the chain \[m\]: midpoints of the centres of pin and bushing.
    fn hinges(&self, drive: &Drive) -> Vec<Vec2> {
        let pitches = drive.chain.link_pitches();
        let n = pitches.len();
        let is_open = drive.ends.is_some();
        let end = |i: usize, side: f64| {
            let [x, y, angle] = self.positions[i];
            Vec2::new(x, y) + 0.5 * side * pitches[i] * unit(angle)
        };
        let between = |k: usize| 0.5 * (end(k, 1.0) + end((k + 1) % n, -1.0));
        if is_open {
            let inside = (0..n - 1).map(between);
            return std::iter::once(end(0, -1.0))
                .chain(inside)
                .chain([end(n - 1, 1.0)])
                .collect();
        }
        (0..n).map(between).collect()
    }
}

/// Return the travel of a guide's plunger \[m\], out and in, after a rotation of its arm by `turn`; zeros without an arm.
fn plunger_travel(number: usize, rail: &Rail, turn: f64) -> Result<[f64; 2]> {
    let Mount::Arm(arm) = rail.mount else {
        return Ok([0.0; 2]);
    };
    let out = turn * rail.lever(&arm);
    if -out > arm.travel[0] {
        // Rounded up, so that the proposed number is enough.
        return Err(Error::Impossible(format!(
            "guide {}: its plunger must start {:.3} mm back for the arm to be clear of the chain, past its stop at {:.3} \
             mm; give GuideArm.travel a first number of at least {:.6} m, or {}",
            number + 1,
            -1e3 * out,
            1e3 * arm.travel[0],
            (-1e6 * out).ceil() / 1e6,
            move_back(rail)
        )));
    }
    Ok([arm.travel[0] + out, arm.travel[1] - out])
}

/// Return a unit vector across the chain at the hinge nearest to a point.
fn across(hinges: &[Vec2], point: Vec2) -> Vec2 {
    let distance = |k: &usize| (hinges[*k] - point).norm();
    let nearest = (0..hinges.len())
        .min_by(|j, k| distance(j).total_cmp(&distance(k)))
        .unwrap_or(0);
    let next = hinges[(nearest + 1).min(hinges.len() - 1)];
    turned_left(next - hinges[nearest.saturating_sub(1)]).normalize()
}

/// Return the least displacement \[m\] that clears a guide which overlaps the chain by `inside` \[m\]; `gap` is its gap after a
/// displacement.
fn least_displacement(inside: f64, gap: impl Fn(f64) -> f64) -> f64 {
    let overlaps = |displacement: f64| gap(displacement) <= START_GAPS[0];
    let (mut short, mut enough) = (0.0, inside.max(START_GAPS[0]));
    while overlaps(enough) && enough < 1.0 {
        (short, enough) = (enough, 2.0 * enough);
    }
    bisected([short, enough], HALVINGS, overlaps)[1]
}

/// Return the error of a guide that overlaps the chain by `inside` \[m\] at its described position, and at every position of its arm;
/// after `displacement` it is clear.
fn overlap(number: usize, rail: &Rail, inside: f64, displacement: Vec2) -> Error {
    // Rounded up, so that the proposed number is enough.
    let distance = format!("{:.3} mm or more", (1e6 * displacement.norm()).ceil() / 1e3);
    let (cause, remedy) = match (rail.shape, rail.mount) {
        (RailShape::Wheel { .. }, _) => {
            let [x, y]: [f64; 2] = rail.center.into();
            let to = rail.center + displacement + MORE_THAN_ENOUGH * displacement.normalize();
            (
                "",
                format!(
                    "move SmoothIdler.center = ({x}, {y}) m to {} m",
                    pair(to, 6)
                ),
            )
        }
        (RailShape::Bar { .. }, Mount::Arm(_)) => (
            ", and no rotation of its arm clears it",
            format!("{} by {distance}", move_back(rail)),
        ),
        (RailShape::Bar { .. }, _) => (
            "",
            format!(
                "{} by {distance}, or give it a GuideRail.arm, which starts rotated clear of the chain",
                move_back(rail)
            ),
        ),
    };
    Error::Impossible(format!(
        "guide {} overlaps the chain of the initial configuration by {:.3} mm{cause}; {remedy}",
        number + 1,
        1e3 * inside.max(0.0),
    ))
}

/// Return the remedy that moves a rail away from the chain.
fn move_back(rail: &Rail) -> String {
    let [x, y]: [f64; 2] = rail.center.into();
    // Without negative zeros.
    let [along_x, along_y] = [rail.direction.x + 0.0, rail.direction.y + 0.0];
    format!(
        "move GuideRail.center = ({x}, {y}) m against GuideRail.direction = ({along_x}, {along_y})"
    )
}

/// Return the point at `offset` in the rotating frame at the bearing of a guide \[m\], at an angle of the guide.
fn placed(rail: &Rail, offset: Vec2, angle: f64) -> Vec2 {
    let along = unit(angle);
    rail.bearing() + offset.x * along + offset.y * turned_left(along)
}

/// Check that a guide as described does not penetrate the body of a sprocket below the seats of its teeth.
fn check_beside_sprockets(drive: &Drive, number: usize) -> Result<()> {
    let rail = &drive.guides[number];
    let angle = rail.angle();
    let (middle, along) = (placed(rail, rail.offset(), angle), unit(angle));
    let outline: Vec<Vec2> = (rail.profile()?.outline(OUTLINE_POINTS))
        .into_iter()
        .map(|p| middle + p.x * along + p.y * turned_left(along))
        .collect();
    for (i, sprocket) in drive.sprockets.iter().enumerate() {
        let root = pitch_radius(drive.chain.pitch, sprocket.teeth) - drive.chain.contact_radius();
        let inside = root - distance(&outline, sprocket.center);
        if inside > 0.0 {
            return Err(Error::Impossible(format!(
                "guide {} stands in sprocket {} by {:.3} mm, below the roots of its teeth: move it away from ({:.4}, {:.4})",
                number + 1,
                i + 1,
                1e3 * inside,
                sprocket.center.x,
                sprocket.center.y
            )));
        }
    }
    Ok(())
}

/// Return the distance of a point from a closed outline, counterclockwise \[m\]; negative inside.
fn distance(outline: &[Vec2], point: Vec2) -> f64 {
    let (mut nearest, mut turned) = (f64::INFINITY, 0.0);
    for (from, to) in outline.iter().zip(outline.iter().cycle().skip(1)) {
        nearest = nearest.min(distance_from_segment(point, [*from, *to]));
        let (one, other) = (from - point, to - point);
        turned += one.perp(&other).atan2(one.dot(&other));
    }
    if turned.abs() > std::f64::consts::PI {
        -nearest
    } else {
        nearest
    }
}

/// A guide beside the laid chain.
struct Beside<'a> {
    chain: &'a Chain,
    hinges: &'a [Vec2],
    rail: &'a Rail,
    profile: &'a ToothProfile,
    /// Middle of the outline for bushings in the rotating frame at the bearing \[m\].
    offset: Vec2,
}

impl Beside<'_> {
    /// Return the centre of the guide's outline at an angle of the guide \[m\].
    fn middle(&self, angle: f64) -> Vec2 {
        placed(self.rail, self.offset, angle)
    }

    /// Return the smallest gap to the chain at an angle of the guide \[m\].
    fn gap(&self, angle: f64) -> f64 {
        self.gap_at(self.middle(angle), angle)
    }

    /// Return the smallest gap to the chain with the outline's centre at `middle` \[m\].
    fn gap_at(&self, middle: Vec2, angle: f64) -> f64 {
        Lie {
            chain: self.chain,
            hinges: self.hinges,
            sprockets: vec![(middle, angle, self.profile)],
        }
        .smallest_gap()
    }

    /// Return the least displacement \[m\] that clears the guide at its described angle, where it overlaps the chain by `inside`: a
    /// rail backwards, a wheel to the nearer side of the chain.
    fn displacement(&self, inside: f64) -> Vec2 {
        let angle = self.rail.angle();
        let middle = self.middle(angle);
        let moved = |back: Vec2| {
            let gap = |by: f64| self.gap_at(middle + by * back, angle);
            least_displacement(inside, gap) * back
        };
        match self.rail.shape {
            RailShape::Bar { .. } => moved(-self.rail.direction.normalize()),
            RailShape::Wheel { .. } => {
                let across = across(self.hinges, middle);
                let [one, other] = [moved(across), moved(-across)];
                let nearer = one.norm() < other.norm();
                if nearer { one } else { other }
            }
        }
    }

    /// Return the bushing nearest to the guide at an angle, its distance \[m\], and the number within half a pitch.
    fn nearest(&self, angle: f64) -> (usize, f64, u32) {
        let (middle, along) = (self.middle(angle), unit(angle));
        let gaps = self.hinges.iter().map(|hinge| {
            let offset = hinge - middle;
            // The half outline on the side of the face.
            let out = if offset.dot(&along) < 0.0 {
                -along
            } else {
                along
            };
            let place = Vec2::new(offset.perp(&out), offset.dot(&out));
            -self
                .profile
                .contact(place, self.chain.contact_radius())
                .penetration
        });
        let (mut nearest, mut least, mut beside) = (0, f64::INFINITY, 0);
        for (k, gap) in gaps.enumerate() {
            if gap < least {
                (nearest, least) = (k, gap);
            }
            beside += u32::from(gap < 0.5 * self.chain.pitch);
        }
        (nearest, least, beside)
    }
}

/// Return the angle \[rad\] nearest to the described one at which the guide is clear of the chain, if any.
fn clear_angle(rail: &Rail, gap: impl Fn(f64) -> f64) -> Option<f64> {
    let described = rail.angle();
    let clear = |angle: f64| gap(angle) > START_GAPS[0];
    if clear(described) {
        return Some(described);
    }
    let Mount::Arm(arm) = rail.mount else {
        return None;
    };
    let back = -rail.lever(&arm).signum() * FARTHEST_SWING / f64::from(SWINGS);
    let first = (1..=SWINGS).find(|&i| clear(described + f64::from(i) * back))?;
    let between = [first - 1, first].map(f64::from);
    let [_, part] = bisected(between, 40, |part| !clear(described + part * back));
    Some(described + part * back)
}

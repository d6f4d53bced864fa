//! Where guides begin: clear of the laid chain, arms swung back until they are.

use super::initial::Start;
use super::layout::{Lie, START_GAPS};
use crate::drive::{Drive, Mount, Rail};
use crate::error::{Error, Result};
use crate::geometry::{Vec2, turned_left, unit};

/// How far an arm may be swung back \[rad\].
const FARTHEST_SWING: f64 = 1.0;
/// In so many parts of that a place is looked for where the chain is clear.
const SWINGS: u32 = 200;

impl Start {
    /// The same with the guides of `drive` at rest, clear of its chain; and the smallest gap between them \[m\].
    ///
    /// # Errors
    /// When a guide stands in the chain where it is described, and no arm can be swung back, or not so far: by how much.
    pub(super) fn with_guides(mut self, drive: &Drive) -> Result<(Self, f64)> {
        let hinges = self.hinges(drive);
        let mut smallest = f64::INFINITY;
        for (number, rail) in drive.guides.iter().enumerate() {
            let profile = rail.profile()?;
            let (bearing, offset) = (rail.bearing(), rail.offset());
            let gap = |angle: f64| {
                let along = unit(angle);
                let center = bearing + offset.x * along + offset.y * turned_left(along);
                Lie {
                    chain: &drive.chain,
                    hinges: &hinges,
                    sprockets: vec![(center, angle, &profile)],
                }
                .smallest_gap()
            };
            let angle = clear_angle(rail, gap).ok_or_else(|| {
                let inside = -1e3 * gap(rail.angle());
                Error::Impossible(format!(
                    "guide {} stands in the laid chain by {inside:.3} mm: move it back, out of its face's direction ({:.4}, \
                     {:.4}), or put it on an arm, which is swung clear",
                    number + 1,
                    -rail.direction.x,
                    -rail.direction.y
                ))
            })?;
            if let Mount::Arm(arm) = rail.mount {
                let back = (angle - rail.angle()).abs() * rail.lever(&arm).abs();
                if back > arm.travel[0] {
                    return Err(Error::Impossible(format!(
                        "guide {}: for its arm to begin clear of the laid chain, its plunger would have to go back by {:.3} mm, past \
                         its stop at {:.3} mm (GuideArm.travel): move it back, out of its face's direction, or let it go back farther",
                        number + 1,
                        1e3 * back,
                        1e3 * arm.travel[0]
                    )));
                }
            }
            smallest = smallest.min(gap(angle));
            self.positions.push([bearing.x, bearing.y, angle]);
            self.velocities.push([0.0; 3]);
        }
        Ok((self, smallest))
    }

    /// Hinges of the chain \[m\]: between the pin's and the bushing's centre.
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

/// The angle \[rad\] nearest to where a guide is described at which it is clear of the chain, if there is one.
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
    let (mut low, mut high) = (f64::from(first - 1), f64::from(first));
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if clear(described + middle * back) {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(described + high * back)
}

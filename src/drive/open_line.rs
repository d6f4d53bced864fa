//! The taut line of an open chain along its sprockets: directions, wraps and length, from the first end to the last.

use std::f64::consts::TAU;

use super::{ChainEnd, Drive};
use crate::geometry::path::belt::WRAP_ROUNDING;
use crate::geometry::path::wrap::pitch_radius;
use crate::geometry::{Vec2, turned_left};

/// Circles along the path of a chain from one end to the other.
pub(crate) struct OpenLine<'a> {
    drive: &'a Drive,
    ends: &'a [ChainEnd; 2],
    /// Sense of rotation of the chain path on each sprocket.
    pub(crate) sense: Vec<f64>,
    /// Radius of the hinges on each sprocket \[m\].
    pub(crate) radius: Vec<f64>,
    down: Option<Vec2>,
}

impl<'a> OpenLine<'a> {
    /// `forward`: 1 where sprockets inside lie on the left, -1 where they lie on the right.
    pub(crate) fn new(
        drive: &'a Drive,
        ends: &'a [ChainEnd; 2],
        radius: Vec<f64>,
        forward: f64,
    ) -> Self {
        let size = drive.gravity.norm();
        Self {
            drive,
            ends,
            sense: (drive.sprockets.iter())
                .map(|sprocket| forward * sprocket.side.sign())
                .collect(),
            radius,
            down: (size > 0.0).then(|| drive.gravity / size),
        }
    }

    /// Return the line with the smaller total wrap, over or under the sprockets, along circles of these radii \[m\].
    pub(crate) fn least_turn(
        drive: &'a Drive,
        ends: &'a [ChainEnd; 2],
        radius: &[f64],
    ) -> Result<Self, String> {
        let way = |forward: f64| Self::new(drive, ends, radius.to_vec(), forward);
        let [left, right] = [way(1.0), way(-1.0)];
        match (left.turn(), right.turn()) {
            (Err(why), Err(_)) => Err(why),
            (Ok(over), Ok(under)) if under < over => Ok(right),
            (Err(_), Ok(_)) => Ok(right),
            _ => Ok(left),
        }
    }

    /// Return that line on the pitch circles.
    pub(crate) fn on_pitch_circles(
        drive: &'a Drive,
        ends: &'a [ChainEnd; 2],
    ) -> Result<Self, String> {
        let radii = drive
            .sprockets
            .iter()
            .map(|sprocket| pitch_radius(drive.chain.mean_pitch(), sprocket.teeth));
        Self::least_turn(drive, ends, &radii.collect::<Vec<f64>>())
    }

    /// Return the direction of gravity, if any.
    pub(crate) fn gravity_direction(&self) -> Option<Vec2> {
        self.down
    }

    /// Return the direction of gravity if the strand at this end hangs freely.
    pub(crate) fn down(&self, end: usize) -> Result<Vec2, String> {
        self.down.ok_or_else(|| {
            format!(
                "without gravity the strand at end {} has no direction: give the end's position",
                end + 1
            )
        })
    }

    /// Return the direction of the common tangent from a circle to the next. A point has radius zero; radii are positive on the
    /// left.
    fn tangent(
        (from, from_radius): (Vec2, f64),
        (to, to_radius): (Vec2, f64),
    ) -> Result<Vec2, String> {
        let apart = to - from;
        let sine = (to_radius - from_radius) / apart.norm();
        if sine.abs() >= 1.0 {
            return Err(format!(
                "there is no straight line from ({:.4}, {:.4}) m to ({:.4}, {:.4}) m beside the sprockets there: they overlap, or an \
                 end lies in a sprocket",
                from.x, from.y, to.x, to.y
            ));
        }
        let turn = -sine.asin();
        let along = apart.normalize();
        let (sin, cos) = turn.sin_cos();
        Ok(cos * along + sin * turned_left(along))
    }

    fn circle(&self, i: usize) -> (Vec2, f64) {
        (
            self.drive.sprockets[i].center,
            self.sense[i] * self.radius[i],
        )
    }

    /// Return the directions of the strands; `slack` overrides the first and the last one.
    pub(crate) fn directions(&self, slack: [Option<Vec2>; 2]) -> Result<Vec<Vec2>, String> {
        let count = self.radius.len();
        let mut directions = Vec::new();
        directions.push(match (slack[0], self.ends[0].position()) {
            (Some(along), _) => along,
            (None, Some(point)) => Self::tangent((point, 0.0), self.circle(0))?,
            (None, None) => -self.down(0)?,
        });
        for i in 1..count {
            directions.push(Self::tangent(self.circle(i - 1), self.circle(i))?);
        }
        directions.push(match (slack[1], self.ends[1].position()) {
            (Some(along), _) => along,
            (None, Some(point)) => Self::tangent(self.circle(count - 1), (point, 0.0))?,
            (None, None) => self.down(1)?,
        });
        Ok(directions)
    }

    /// Return the wrap of the chain on sprocket `i` between these directions \[rad\].
    pub(crate) fn wrap(&self, i: usize, [before, after]: [Vec2; 2]) -> f64 {
        let angle = self.sense[i] * before.perp(&after).atan2(before.dot(&after));
        // A wrap that is a full turn by rounding is zero.
        if angle < -WRAP_ROUNDING {
            angle + TAU
        } else {
            angle.max(0.0)
        }
    }

    /// Return the sum of all wraps of the taut chain \[rad\].
    fn turn(&self) -> Result<f64, String> {
        let directions = self.directions([None, None])?;
        let pairs = directions.windows(2).enumerate();
        Ok(pairs
            .map(|(i, pair)| self.wrap(i, [pair[0], pair[1]]))
            .sum())
    }

    /// Return the force of a belt of unit tension on sprocket `i`.
    pub(crate) fn pull(&self, i: usize) -> Result<Vec2, String> {
        let directions = self.directions([None, None])?;
        Ok(directions[i + 1] - directions[i])
    }

    /// Return the pitches of a taut chain from end to end (chords on the wraps); `None` where an end has no position.
    pub(crate) fn pitches(&self) -> Result<Option<f64>, String> {
        let [Some(from), Some(to)] = self.ends.each_ref().map(ChainEnd::position) else {
            return Ok(None);
        };
        let directions = self.directions([None, None])?;
        let circles: Vec<(Vec2, f64)> = std::iter::once((from, 0.0))
            .chain((0..self.radius.len()).map(|i| self.circle(i)))
            .chain([(to, 0.0)])
            .collect();
        let straight = circles.windows(2).map(|pair| {
            let [(a, r), (b, s)] = [pair[0], pair[1]];
            ((b - a).norm_squared() - (s - r) * (s - r)).max(0.0).sqrt()
        });
        let wraps = directions.windows(2).enumerate().map(|(i, pair)| {
            self.wrap(i, [pair[0], pair[1]]) * f64::from(self.drive.sprockets[i].teeth) / TAU
        });
        let pitch = self.drive.chain.mean_pitch();
        Ok(Some(straight.sum::<f64>() / pitch + wraps.sum::<f64>()))
    }
}

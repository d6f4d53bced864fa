//! The strands of a chain, and their tensions from where its hinges are and what they pull.

use super::open_layout::open_strands;
use crate::drive::{BeltLine, Drive};
use crate::geometry::Vec2;
use crate::geometry::path::belt::{Belt, Pulley, Span};

/// From which to which sprocket (from 0) the strands lead; where the centres make no belt line (with a start of the caller's own they need
/// not), as the sprockets are listed.
#[must_use]
pub fn strands(drive: &Drive) -> Vec<[usize; 2]> {
    let n = drive.sprockets.len();
    if drive.ends.is_some() {
        return open_strands(n);
    }
    if n == 2 {
        return vec![[1, 0], [0, 1]];
    }
    BeltLine::of(drive).map_or_else(
        |_| (0..n).map(|i| [i, (i + 1) % n]).collect(),
        |line| line.strands(),
    )
}

/// A chain at one instant, as a ring of links.
pub(crate) struct ChainRow<'a> {
    /// Centres of the links, x and y \[m\]. Those of an open chain are followed by the pins of its last and its first end.
    pub(crate) links: [&'a [f64]; 2],
    /// Centre of the bushing of each hinge, x and y \[m\].
    pub(crate) bushings: [&'a [f64]; 2],
    /// Force of each hinge on the link before it, x and y \[N\].
    pub(crate) on_front: [&'a [f64]; 2],
    /// The sprockets in the order in which the strands leave them, with their pitch circles.
    pub(crate) pulleys: &'a [Pulley],
    /// Largest distance from its centre at which each of them touches a bushing \[m\].
    pub(crate) reaches: &'a [f64],
}

/// Mean of the hinges of each strand.
#[derive(Clone, Default)]
struct Mean {
    sum: f64,
    count: f64,
}

impl ChainRow<'_> {
    /// Return the centres of the bushings \[m\].
    fn bushings(&self) -> impl DoubleEndedIterator<Item = Vec2> + ExactSizeIterator {
        let [x, y] = self.bushings;
        x.iter().zip(y).map(|(&x, &y)| Vec2::new(x, y))
    }

    /// Mean pull along the chain of the hinges of each strand of a closed chain \[N\]; zero for one without hinges.
    ///
    /// Two sprockets: upper strand, left of the line from the first listed to the second, then lower strand. More: strand `i` leaves
    /// `pulleys[i]`.
    pub(crate) fn strand_tensions(&self) -> Vec<f64> {
        averages(&match self.pulleys {
            [second, first] => self.between_two(first, second),
            _ => self.between_many(),
        })
    }

    /// The same of an open chain, from its first end to its last.
    ///
    /// A hinge in reach of a sprocket is in no strand, and those after it are in the next one. Hinges without contact are `open`.
    pub(crate) fn open_strand_tensions(&self, open: impl Fn(usize) -> bool) -> Vec<f64> {
        let links = self.links[0].len() - 2;
        let mut means = vec![Mean::default(); self.pulleys.len() + 1];
        let mut strand = 0_usize;
        for k in std::iter::once(links + 1).chain(0..links) {
            let bushing = Vec2::new(self.bushings[0][k], self.bushings[1][k]);
            let beside = strand.saturating_sub(1)..self.pulleys.len().min(strand + 1);
            if let Some(s) = beside.rev().find(|&s| self.touches(s, bushing)) {
                strand = s + 1;
            } else if !open(k) {
                self.add(k, &mut means[strand]);
            }
        }
        averages(&means)
    }

    /// Return whether sprocket `s` is in reach of a bushing.
    fn touches(&self, s: usize, bushing: Vec2) -> bool {
        (bushing - self.pulleys[s].center).norm() < self.reaches[s]
    }

    /// Add hinge `k` to the hinges of a strand.
    fn add(&self, k: usize, mean: &mut Mean) {
        let next = if k + 1 < self.links[0].len() {
            k + 1
        } else {
            0
        };
        let [here, there, force] = [(self.links, k), (self.links, next), (self.on_front, k)]
            .map(|([x, y], k)| Vec2::new(x[k], y[k]));
        mean.sum += force.dot(&(there - here).normalize());
        mean.count += 1.0;
    }

    /// A hinge is in a strand when it lies between that strand's tangent points and the strand leaves or meets the sprocket that the
    /// chain touched last; of two such, the nearer one. A hinge in reach of a sprocket is no farther from the strand than its radius.
    fn between_many(&self) -> Vec<Mean> {
        let strands = self.pulleys.len();
        let mut means = vec![Mean::default(); strands];
        let Ok(belt) = Belt::around(self.pulleys) else {
            return means;
        };
        let touched = |bushing| (0..strands).find(|&s| self.touches(s, bushing));
        // The last sprocket that the chain touches before its first hinge.
        let Some(mut last) = self.bushings().rev().find_map(touched) else {
            return means;
        };
        for (k, bushing) in self.bushings().enumerate() {
            let on = touched(bushing);
            last = on.unwrap_or(last);
            // With a wrap of more than half a turn, hinges on the far side of the sprocket lie beside the strand, too.
            let widest = on.map_or(f64::INFINITY, |on| self.pulleys[on].radius);
            let meeting = (last + strands - 1) % strands;
            let near = [last, meeting]
                .into_iter()
                .filter_map(|i| beside(&belt.spans[i], bushing).map(|apart| (apart, i)))
                .filter(|&(apart, _)| apart < widest)
                .min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, strand)) = near {
                self.add(k, &mut means[strand]);
            }
        }
        means
    }

    /// A hinge is in a strand when it lies between the ends of the common tangents of both pitch circles.
    fn between_two(&self, first: &Pulley, second: &Pulley) -> Vec<Mean> {
        let line = second.center - first.center;
        let distance = line.norm();
        let axis = line / distance;
        // A common tangent leaves each pitch circle where its normal does.
        let cos = (first.radius - second.radius) / distance;
        let between = (first.radius * cos)..=(distance + second.radius * cos);
        let mut means = vec![Mean::default(); 2];
        for (k, bushing) in self.bushings().enumerate() {
            let offset = bushing - first.center;
            if between.contains(&offset.dot(&axis)) {
                let strand = usize::from(axis.perp(&offset) < 0.0);
                self.add(k, &mut means[strand]);
            }
        }
        means
    }
}

fn averages(means: &[Mean]) -> Vec<f64> {
    let average = |mean: &Mean| mean.sum / f64::max(mean.count, 1.0);
    means.iter().map(average).collect()
}

/// Distance from the line of a strand of a point that lies between its ends \[m\].
fn beside(span: &Span, point: Vec2) -> Option<f64> {
    let offset = point - span.from;
    let along = offset.dot(&span.direction);
    (0.0..=span.length)
        .contains(&along)
        .then(|| (offset - along * span.direction).norm())
}

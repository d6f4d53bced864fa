//! An open chain as the ring of links that the kernels know: two more bodies close it, and hinges that are none stay open.
//!
//! Behind the links stand the body at the end of the last link and the body at the beginning of the first one. The hinge between
//! these two never touches, nor does that of a loose end. An anchor has no inverse mass: it feels nothing and moves as it is told.

use super::Model;
use crate::drive::bushing_on_front;
use crate::drive::{ChainEnd, Drive};
use crate::geometry::Vec2;
use crate::layout::InitialConfiguration;
use crate::math::Signal;

/// Mass \[kg\] and inertia \[kg m²\] that Newton's matrix has for a body that nothing moves.
pub(crate) const IMMOVABLE: f64 = 1e20;

/// Both ends of an open chain: that of the first link, that of the last one.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenEnds {
    /// Number of links, without the two bodies that close the ring.
    pub links: usize,
    /// The bodies at the ends.
    pub bodies: [EndModel; 2],
}

/// One end of an open chain.
#[derive(Debug, Clone, PartialEq)]
pub struct EndModel {
    /// Its body.
    pub body: usize,
    /// The hinge that joins it to the chain.
    pub hinge: usize,
    /// Where its body is at the start \[m\].
    pub start: Vec2,
    /// What it is.
    pub kind: EndKind,
}

/// What an end of an open chain is.
#[derive(Debug, Clone, PartialEq)]
pub enum EndKind {
    /// Nothing: its body takes no part.
    Loose,
    /// A pin with this velocity, x and y \[m/s\].
    Held([Signal; 2]),
    /// A body with a mass.
    Load,
}

impl EndModel {
    fn new(end: &ChainEnd, body: usize, hinge: usize, start: &InitialConfiguration) -> Self {
        let kind = match end {
            ChainEnd::Anchor { velocity, .. } => EndKind::Held(velocity.clone()),
            ChainEnd::Load { .. } => EndKind::Load,
            ChainEnd::Loose { .. } => EndKind::Loose,
        };
        let [x, y, _] = start.positions[body];
        Self {
            body,
            hinge,
            start: Vec2::new(x, y),
            kind,
        }
    }

    /// Place that it is given at time `t` \[m\], and its velocity \[m/s\]; nothing for a load.
    #[must_use]
    pub fn given_motion(&self, t: f64) -> Option<(Vec2, Vec2)> {
        let moved = match &self.kind {
            EndKind::Held([x, y]) => Vec2::new(x.integral(t), y.integral(t)),
            _ => Vec2::zeros(),
        };
        Some((self.start + moved, self.given_velocity(t)?))
    }

    /// Whether it is moved with an acceleration that changes between knots, which the integrator follows within its tolerance only.
    pub(crate) fn follows_a_curve(&self) -> bool {
        let straight = |signal: &Signal| matches!(signal, Signal::Constant(_) | Signal::Table(_));
        matches!(&self.kind, EndKind::Held(velocity) if !velocity.iter().all(straight))
    }

    /// Velocity that it is given at time `t` \[m/s\]; nothing for a load.
    #[must_use]
    pub fn given_velocity(&self, t: f64) -> Option<Vec2> {
        match &self.kind {
            EndKind::Load => None,
            EndKind::Loose => Some(Vec2::zeros()),
            EndKind::Held([x, y]) => Some(Vec2::new(x.value(t), y.value(t))),
        }
    }

    /// Acceleration that it is given at time `t` \[m/s²\]; nothing for a load.
    #[must_use]
    pub fn given_acceleration(&self, t: f64) -> Option<Vec2> {
        match &self.kind {
            EndKind::Load => None,
            EndKind::Loose => Some(Vec2::zeros()),
            EndKind::Held([x, y]) => Some(Vec2::new(x.slope(t), y.slope(t))),
        }
    }
}

impl OpenEnds {
    /// The ends of `drive`, which begins at `start`, if its chain is open.
    #[must_use]
    pub fn of(drive: &Drive, start: &InitialConfiguration) -> Option<Self> {
        let [first, last] = drive.ends.as_ref()?;
        let links = drive.chain.links as usize;
        Some(Self {
            links,
            bodies: [
                EndModel::new(first, links + 1, links + 1, start),
                EndModel::new(last, links, links - 1, start),
            ],
        })
    }

    /// The velocities that its ends follow.
    pub(super) fn signals(&self) -> impl Iterator<Item = &Signal> {
        self.bodies.iter().flat_map(|end| match &end.kind {
            EndKind::Held(velocity) => velocity.as_slice(),
            _ => &[],
        })
    }

    /// Time of the first knot after `t` of a velocity of an end \[s\]; infinite when there is none.
    #[must_use]
    pub fn next_knot(&self, t: f64) -> f64 {
        let knots = self.signals().map(|signal| signal.next_knot(t));
        knots.fold(f64::INFINITY, f64::min)
    }

    /// Whether hinge `k` is none.
    #[must_use]
    pub fn hinge_is_open(&self, k: usize) -> bool {
        let loose = |end: &EndModel| end.hinge == k && end.kind == EndKind::Loose;
        k == self.links || self.bodies.iter().any(loose)
    }

    /// Whether hinge `k` has a bushing; at a loose end the link itself may have one.
    #[must_use]
    pub fn bushing_is_there(&self, k: usize) -> bool {
        let [first, last] = &self.bodies;
        if k == last.hinge && last.kind == EndKind::Loose {
            return bushing_on_front(k, self.links + 2);
        }
        k == first.hinge || k != self.links
    }

    /// Power that the chain's pull on the ends, `force` \[N\] of each, takes from those that are moved, at time `t` \[W\].
    #[must_use]
    pub(crate) fn worked_in(&self, force: [Vec2; 2], t: f64) -> f64 {
        let ends = self.bodies.iter().zip(force);
        ends.map(|(end, force)| match &end.kind {
            EndKind::Held(_) => -end.given_velocity(t).unwrap_or_default().dot(&force),
            _ => 0.0,
        })
        .sum()
    }
}

impl Model {
    /// Whether hinge `k` is none: where an open chain is open.
    #[must_use]
    pub fn hinge_is_open(&self, k: usize) -> bool {
        self.ends.as_ref().is_some_and(|ends| ends.hinge_is_open(k))
    }

    /// Whether hinge `k` has a bushing.
    #[must_use]
    pub fn bushing_is_there(&self, k: usize) -> bool {
        self.ends
            .as_ref()
            .is_none_or(|ends| ends.bushing_is_there(k))
    }

    /// Rollers that are none: where an open chain has no bushing.
    pub(crate) fn absent_rollers(&self) -> impl Iterator<Item = usize> {
        // Only the hinge between the ends and that of the last link can be without.
        let last = self
            .ends
            .as_ref()
            .map_or(0..0, |ends| ends.links - 1..ends.links + 1);
        last.filter(|&k| !self.bushing_is_there(k))
    }

    /// Whether link `i` is an end that nothing moves but what it is told.
    #[must_use]
    pub fn is_held(&self, i: usize) -> bool {
        let held = |end: &EndModel| end.body == i && end.kind != EndKind::Load;
        (self.ends.as_ref()).is_some_and(|ends| ends.bodies.iter().any(held))
    }
}

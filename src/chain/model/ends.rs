//! Open chain as a ring of links for the kernels: two additional bodies close the ring, and its open hinges have no contact.
//!
//! The links are followed by the body at the end of the last link and the body at the beginning of the first one. The hinge between
//! these two bodies has no contact; neither has the hinge of a free end. The inverse mass of an anchored end is zero: forces do not
//! affect its prescribed motion.

use super::Model;
use crate::drive::bushing_on_front;
use crate::drive::{ChainEnd, Drive};
use crate::geometry::Vec2;
use crate::layout::InitialConfiguration;
use crate::math::Signal;

/// Mass \[kg\] and inertia \[kg m²\] in Newton's matrix of a body with prescribed motion: larger by far than those of any body of a chain.
pub(crate) const IMMOVABLE: f64 = 1e20;

/// Both ends of an open chain: the end at the first link, then the end at the last one.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenEnds {
    /// Number of links of the chain, without the two bodies that close the ring.
    pub links: usize,
    /// Bodies at the ends.
    pub bodies: [EndModel; 2],
}

/// One end of an open chain.
#[derive(Debug, Clone, PartialEq)]
pub struct EndModel {
    /// Number of its body.
    pub body: usize,
    /// Hinge between this body and the chain.
    pub hinge: usize,
    /// Centre of its body at the start \[m\].
    pub start: Vec2,
    /// Kind of the end.
    pub kind: EndKind,
}

/// Kind of an end of an open chain.
#[derive(Debug, Clone, PartialEq)]
pub enum EndKind {
    /// Free end: its body has no effect.
    Free,
    /// Anchored end: a pin with this velocity, x and y \[m/s\].
    Anchored([Signal; 2]),
    /// Loaded end: a body with mass and inertia.
    Loaded,
}

impl EndModel {
    fn new(end: &ChainEnd, body: usize, hinge: usize, start: &InitialConfiguration) -> Self {
        let kind = match end {
            ChainEnd::Anchored { velocity, .. } => EndKind::Anchored(velocity.clone()),
            ChainEnd::Loaded { .. } => EndKind::Loaded,
            ChainEnd::Free { .. } => EndKind::Free,
        };
        let [x, y, _] = start.positions[body];
        Self {
            body,
            hinge,
            start: Vec2::new(x, y),
            kind,
        }
    }

    /// Return the prescribed position \[m\] and velocity \[m/s\] at time `t` \[s\]; `None` for a loaded end.
    #[must_use]
    pub fn given_motion(&self, t: f64) -> Option<(Vec2, Vec2)> {
        let moved = match &self.kind {
            EndKind::Anchored([x, y]) => Vec2::new(x.integral(t), y.integral(t)),
            _ => Vec2::zeros(),
        };
        Some((self.start + moved, self.given_velocity(t)?))
    }

    /// Return whether the prescribed acceleration varies between knots.
    ///
    /// The integrator follows such a motion only within its tolerance.
    pub(crate) fn follows_a_curve(&self) -> bool {
        let straight = |signal: &Signal| matches!(signal, Signal::Constant(_) | Signal::Table(_));
        matches!(&self.kind, EndKind::Anchored(velocity) if !velocity.iter().all(straight))
    }

    /// Return the prescribed velocity at time `t` \[s\] \[m/s\]; `None` for a loaded end.
    #[must_use]
    pub fn given_velocity(&self, t: f64) -> Option<Vec2> {
        match &self.kind {
            EndKind::Loaded => None,
            EndKind::Free => Some(Vec2::zeros()),
            EndKind::Anchored([x, y]) => Some(Vec2::new(x.value(t), y.value(t))),
        }
    }

    /// Return the prescribed acceleration at time `t` \[s\] \[m/s²\]; `None` for a loaded end. At a row of a table after `since` \[s\] it is the
    /// one before the row, else the one behind it.
    #[must_use]
    pub fn given_acceleration(&self, t: f64, since: f64) -> Option<Vec2> {
        let slope = |velocity: &Signal| velocity.slope(velocity.one_sided(t, since));
        match &self.kind {
            EndKind::Loaded => None,
            EndKind::Free => Some(Vec2::zeros()),
            EndKind::Anchored([x, y]) => Some(Vec2::new(slope(x), slope(y))),
        }
    }
}

impl OpenEnds {
    /// Return the ends of `drive` with the initial configuration `start`; `None` for a closed chain.
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

    /// Return the velocity signals of the anchored ends.
    pub(super) fn signals(&self) -> impl Iterator<Item = &Signal> {
        self.bodies.iter().flat_map(|end| match &end.kind {
            EndKind::Anchored(velocity) => velocity.as_slice(),
            _ => &[],
        })
    }

    /// Return whether an end is moved, so that the force on it does work.
    pub(crate) fn are_moved(&self) -> bool {
        self.signals().any(|velocity| !velocity.is_zero())
    }

    /// Return the time of the first knot of an end's velocity after `t` \[s\]; infinite without one.
    #[must_use]
    pub fn next_knot(&self, t: f64) -> f64 {
        let knots = self.signals().map(|signal| signal.next_knot(t));
        knots.fold(f64::INFINITY, f64::min)
    }

    /// Return the open hinges of the ring: between the two end bodies, and at free ends.
    pub fn open_hinges(&self) -> impl Iterator<Item = usize> {
        let free = (self.bodies.iter()).filter(|end| end.kind == EndKind::Free);
        std::iter::once(self.links).chain(free.map(|end| end.hinge))
    }

    /// Return whether hinge `k` has a bushing; at a free end, the bushing may belong to the link itself.
    #[must_use]
    pub fn bushing_is_there(&self, k: usize) -> bool {
        let [_, last] = &self.bodies;
        if k == last.hinge && last.kind == EndKind::Free {
            return bushing_on_front(k, self.links + 2);
        }
        k != self.links
    }

    /// Return the external power of the prescribed end motions at time `t` \[W\]: -Σ v · F over the anchored ends.
    ///
    /// `force`: force of the chain on each end \[N\].
    #[must_use]
    pub(crate) fn external_work(&self, force: [Vec2; 2], t: f64) -> f64 {
        let ends = self.bodies.iter().zip(force);
        ends.map(|(end, force)| match &end.kind {
            EndKind::Anchored(_) => -end.given_velocity(t).unwrap_or_default().dot(&force),
            _ => 0.0,
        })
        .sum()
    }
}

impl Model {
    /// Return whether hinge `k` is an open hinge of an open chain.
    #[must_use]
    pub fn hinge_is_open(&self, k: usize) -> bool {
        self.open_hinges().any(|open| open == k)
    }

    /// Return the open hinges of an open chain.
    pub fn open_hinges(&self) -> impl Iterator<Item = usize> {
        self.ends.iter().flat_map(OpenEnds::open_hinges)
    }

    /// Return whether hinge `k` has a bushing.
    #[must_use]
    pub fn bushing_is_there(&self, k: usize) -> bool {
        self.ends
            .as_ref()
            .is_none_or(|ends| ends.bushing_is_there(k))
    }

    /// Return the numbers of absent rollers: hinges of an open chain without a bushing.
    pub(crate) fn absent_rollers(&self) -> impl Iterator<Item = usize> {
        // Only the hinge between the end bodies and the hinge of the last link can lack a bushing.
        let last = self
            .ends
            .as_ref()
            .map_or(0..0, |ends| ends.links - 1..ends.links + 1);
        last.filter(|&k| !self.bushing_is_there(k))
    }

    /// Return whether link `i` is the body of an anchored or free end: its motion is prescribed.
    #[must_use]
    pub fn is_held(&self, i: usize) -> bool {
        let held = |end: &EndModel| end.body == i && end.kind != EndKind::Loaded;
        (self.ends.as_ref()).is_some_and(|ends| ends.bodies.iter().any(held))
    }
}

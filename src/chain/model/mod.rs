//! What a run needs: flat, indexed, immutable.

mod bristles;
mod compile;
mod ends;
mod guide;
mod input;
mod rail;

pub use bristles::BristlePlaces;
pub use compile::ForceLaws;
pub(crate) use ends::IMMOVABLE;
pub use ends::{EndKind, EndModel, OpenEnds};
pub use guide::{Guide, Ratchet};
pub use input::{Input, Quantity};

use crate::drive::{InputBounds, bushing_on_front};
use crate::force_law::{Elastic, Friction, HingeFilm, LuGre, PairTable, Regions};
use crate::geometry::path::belt::Side;
use crate::geometry::{Surface, ToothProfile, Vec2};
use crate::math::{Signal, Table};

/// The complete model of a drive. Read-only during a run.
///
/// Bodies: links first, then rollers, then sprockets. Generalized coordinates q: all link x, all link y, all link θ, those that the
/// sprockets have, then all roller x, all roller y, all roller θ, then the integrals of what bristles are bent by, see [`BristlePlaces`]. Hinge `k` joins the front of link `k` and the rear of link `k + 1`;
/// bushing `k` belongs to the inner one. An open chain is closed to a ring by the two bodies at its ends, which count as links; see
/// [`OpenEnds`].
#[derive(Debug, Clone)]
pub struct Model {
    /// Number of links, hinges and bushings.
    pub links: usize,
    /// The ends of an open chain.
    pub ends: Option<OpenEnds>,
    /// Number of generalized coordinates.
    pub coordinates: usize,
    /// Half the nominal pitch \[m\].
    pub half_pitch: f64,
    /// Half the length of each link \[m\]: its hinges lie at (± arm, 0).
    pub arms: Vec<f64>,
    /// Mass of each link \[kg\].
    pub mass: Vec<f64>,
    /// Moment of inertia of each link \[kg m²\].
    pub inertia: Vec<f64>,
    /// 1/mass of each link \[1/kg\].
    pub inverse_mass: Vec<f64>,
    /// 1/inertia of each link \[1/(kg m²)\].
    pub inverse_inertia: Vec<f64>,
    /// Radial clearance of the hinges \[m\].
    pub clearance: f64,
    /// Radius of the pins \[m\].
    pub pin_radius: f64,
    /// Outside radius of what meets the teeth: bushings, or rollers \[m\].
    pub contact_radius: f64,
    /// The rollers, where they are bodies of their own.
    pub rollers: Option<RollerModel>,
    /// The sprockets, and behind them the guides: to the chain, wheels without teeth.
    pub sprockets: Vec<SprocketModel>,
    /// How many of them are guides.
    pub guides: usize,
    /// From which to which sprocket each strand leads. Two sprockets: the upper strand, the lower one.
    pub strands: Vec<[usize; 2]>,
    /// Law of the hinges: one pair for all.
    pub hinge_law: ContactLaw,
    /// Law of the teeth: the pairs of one sprocket after those of another, see [`Self::tooth_pair`].
    pub tooth_law: ContactLaw,
    /// Friction in the hinges; none: absent.
    pub hinge_friction: Option<Friction>,
    /// Friction on the teeth.
    pub tooth_friction: Option<Friction>,
    /// Bristles in the hinges, in the place of a friction of the slip speed; none: absent.
    pub hinge_bristles: Option<LuGre>,
    /// Bristles on the teeth.
    pub tooth_bristles: Option<LuGre>,
    /// Where their deflections stand.
    pub bristles: BristlePlaces,
    /// What the plates at each hinge give way by \[m/N\]; none: they are rigid.
    pub link_compliance: Option<Vec<f64>>,
    /// Lubricant in the hinges; none: absent.
    pub hinge_film: Option<HingeFilm>,
    /// Floor of the approach speed at onset \[m/s\].
    pub min_approach_speed: f64,
    /// Gravity \[m/s²\].
    pub gravity: Vec2,
    /// Why a law is outside its range in this drive, one line each.
    pub range_notes: Vec<String>,
}

/// A force law made ready for one group of pairs.
#[derive(Debug, Clone)]
pub struct ContactLaw {
    /// Which elastic law.
    pub elastic: Elastic,
    /// Its constants for each pair.
    pub pairs: PairTable,
    /// λ of the damping factor; zero without damping.
    pub lambda: f64,
    /// What happens between the regions of a tooth.
    pub regions: Regions,
}

/// Rollers: one on every bushing, all alike.
#[derive(Debug, Clone)]
pub struct RollerModel {
    /// Coordinate of the first one: all x, all y, all θ follow.
    pub first: usize,
    /// Mass \[kg\].
    pub mass: f64,
    /// Moment of inertia \[kg m²\].
    pub inertia: f64,
    /// Radial clearance on the bushings \[m\].
    pub clearance: f64,
    /// Outside radius of the bushings \[m\].
    pub bushing_radius: f64,
    /// Law of bushings in the rollers' bores: one pair for all.
    pub law: ContactLaw,
}

/// One sprocket.
#[derive(Debug, Clone)]
pub struct SprocketModel {
    /// Tooth profile.
    pub profile: ToothProfile,
    /// Number of the pair of its first surface in the law of the teeth.
    pub first_pair: usize,
    /// Directions (cos, sin) of the gaps in the sprocket's own frame.
    pub gap_directions: Vec<(f64, f64)>,
    /// The teeth's centre in the sprocket's own frame \[m\]; zero unless they are eccentric.
    pub offset: Vec2,
    /// Distance of a bushing beyond which nothing touches \[m\].
    pub reach: f64,
    /// Mass \[kg\].
    pub mass: f64,
    /// Moment of inertia \[kg m²\].
    pub inertia: f64,
    /// Centre at the start \[m\].
    pub center: Vec2,
    /// Angle at time zero \[rad\]: that of gap 0.
    pub phase: f64,
    /// What holds the centre.
    pub support: Support,
    /// What the rotation obeys.
    pub rotation: Rotation,
    /// On which side of the chain it stands.
    pub side: Side,
    /// What holds back the arm of a guide, by the angle that it has turned by \[rad\]: N m in the place of N.
    pub swing: Option<Guide>,
    /// What it may be driven by at most; none: a guide, which nothing drives.
    pub input_bounds: Option<InputBounds>,
}

/// What holds a sprocket's centre; indices point into q.
#[derive(Debug, Clone, PartialEq)]
pub enum Support {
    /// At rest.
    Fixed,
    /// Slides along a line or round a pivot, pulled and damped by a tensioner.
    Slide {
        /// Coordinate: distance from the start along the way \[m\].
        index: usize,
        /// Unit vector of the way at the start.
        direction: Vec2,
        /// The way, its spring and its stops.
        guide: Guide,
        /// Full pull \[N\].
        pull: f64,
        /// Time in which the pull grows \[s\].
        ramp_time: f64,
        /// Dashpot \[N s/m\]: the harder one of both directions.
        damping: f64,
    },
    /// Free in the plane: coordinates x and y \[m\].
    Floating {
        /// Coordinate x.
        x: usize,
        /// Coordinate y.
        y: usize,
    },
}

/// What a sprocket's rotation obeys.
#[derive(Debug, Clone, PartialEq)]
pub enum Rotation {
    /// Turns at a given speed \[rad/s\]: no coordinate.
    Prescribed(Signal),
    /// Turned by a torque \[N m\] and the chain.
    Free {
        /// Coordinate θ \[rad\].
        index: usize,
        /// Applied torque, if any.
        torque: Option<Signal>,
        /// Torque against the sprocket's own speed, if any.
        curve: Option<Table>,
    },
}

impl Model {
    /// All that prescribed speeds, applied torques and moved ends follow.
    fn signals(&self) -> impl Iterator<Item = &Signal> {
        let of_sprockets = self.sprockets.iter().filter_map(|s| match &s.rotation {
            Rotation::Prescribed(signal) => Some(signal),
            Rotation::Free { torque, .. } => torque.as_ref(),
        });
        of_sprockets.chain(self.ends.iter().flat_map(OpenEnds::signals))
    }

    /// Time of the first knot after `t` of any speed or torque \[s\]: a derivative jumps there; infinite when there is none.
    #[must_use]
    pub fn next_kink(&self, t: f64) -> f64 {
        let knots = self.signals().map(|signal| signal.next_knot(t));
        knots.fold(f64::INFINITY, f64::min)
    }

    /// Longest step from `t` beside the time that speeds and torques take to change between their knots \[s\].
    pub(crate) fn longest_step_between_kinks(&self, t: f64) -> f64 {
        let steps = self
            .signals()
            .map(|signal| signal.longest_step_between_knots(t));
        steps.fold(f64::INFINITY, f64::min)
    }

    /// Number of sprockets that have teeth.
    #[must_use]
    pub fn toothed(&self) -> usize {
        self.sprockets.len() - self.guides
    }

    /// What sprocket or guide `s` is called.
    #[must_use]
    pub fn wheel_name(&self, s: usize) -> String {
        match s.checked_sub(self.toothed()) {
            None => format!("sprocket {}", s + 1),
            Some(guide) => format!("guide {}", guide + 1),
        }
    }

    /// What of hinge `k` meets the teeth, in words.
    #[must_use]
    pub fn on_teeth_name(&self, k: usize) -> String {
        let what = self.rollers.as_ref().map_or("bushing", |_| "roller");
        format!("{what} {}", k + 1)
    }

    /// Number of bodies: links, rollers, sprockets and guides.
    #[must_use]
    pub fn bodies(&self) -> usize {
        self.wheel_body(self.sprockets.len())
    }

    /// Number of rollers that are bodies.
    #[must_use]
    pub fn roller_count(&self) -> usize {
        self.rollers.as_ref().map_or(0, |_| self.links)
    }

    /// Number of sprocket or guide `s` among the bodies.
    #[must_use]
    pub fn wheel_body(&self, s: usize) -> usize {
        self.links + self.roller_count() + s
    }

    /// Number of the coordinates that are neither of links nor of rollers: those of sprockets and guides.
    #[must_use]
    pub fn wheel_coordinates(&self) -> usize {
        self.coordinates - 3 * (self.links + self.roller_count()) - self.bristles.all().len()
    }

    /// Names of the bodies, in the order of every array over bodies.
    #[must_use]
    pub fn body_names(&self) -> Vec<String> {
        (0..self.links)
            .map(|i| self.link_name(i))
            .chain((1..=self.roller_count()).map(|k| format!("roller_{k}")))
            .chain((0..self.sprockets.len()).map(|s| self.wheel_name(s).replace(' ', "_")))
            .collect()
    }

    /// What link `i` is called: by its number, from 1; ends of an open chain by theirs.
    #[must_use]
    pub fn link_name(&self, i: usize) -> String {
        let ends = self.ends.as_ref().map(|ends| &ends.bodies);
        match ends.and_then(|ends| ends.iter().position(|end| end.body == i)) {
            Some(end) => format!("end_{}", end + 1),
            None => format!("link_{}", i + 1),
        }
    }

    /// The link that bushing `k` is rigid with.
    #[must_use]
    pub fn link_of_bushing(&self, bushing: usize) -> usize {
        if bushing_on_front(bushing, self.links) {
            bushing
        } else {
            (bushing + 1) % self.links
        }
    }

    /// From the centre of the link that bushing `k` is rigid with to the bushing, along the link \[m\].
    #[must_use]
    pub fn bushing_arm(&self, bushing: usize) -> f64 {
        let link = self.link_of_bushing(bushing);
        if link == bushing {
            self.arms[link]
        } else {
            -self.arms[link]
        }
    }

    /// Whether hinges, and bushings in rollers, have friction.
    #[must_use]
    pub fn hinges_rub(&self) -> bool {
        self.hinge_friction.is_some() || self.hinge_bristles.is_some()
    }

    /// Whether teeth have friction.
    #[must_use]
    pub fn teeth_rub(&self) -> bool {
        self.tooth_friction.is_some() || self.tooth_bristles.is_some()
    }

    /// Whether any contact has friction.
    #[must_use]
    pub fn has_friction(&self) -> bool {
        self.hinges_rub() || self.teeth_rub()
    }

    /// Whether hinges have a film or links are elastic.
    #[must_use]
    pub fn has_extra(&self) -> bool {
        self.hinge_film.is_some() || self.link_compliance.is_some()
    }

    /// What the plates at hinge `k` give way by \[m/N\], where they are elastic.
    #[must_use]
    pub fn compliance_at(&self, k: usize) -> Option<f64> {
        Some(self.link_compliance.as_ref()?[k])
    }

    /// Whether links may feel moments besides forces at the hinges' centres: where there is friction or a film, and where hinges are
    /// treated as if there were.
    #[must_use]
    pub fn has_moments(&self) -> bool {
        self.has_friction() || self.has_extra()
    }

    /// The pair constants' number for a surface of a sprocket.
    #[must_use]
    pub fn tooth_pair(&self, sprocket: usize, surface: Surface) -> usize {
        self.sprockets[sprocket].first_pair + surface.index()
    }

    /// The body that generalized coordinate `index` belongs to.
    #[must_use]
    pub fn body_of_coordinate(&self, index: usize) -> usize {
        if index < 3 * self.links {
            return index % self.links;
        }
        if let Some(body) = self.bristles.body(self, index) {
            return body;
        }
        if let Some(rollers) = &self.rollers
            && index >= rollers.first
        {
            return self.links + (index - rollers.first) % self.links;
        }
        let owns = |s: &SprocketModel| {
            let by_support = match s.support {
                Support::Fixed => false,
                Support::Slide { index: i, .. } => i == index,
                Support::Floating { x, y } => x == index || y == index,
            };
            by_support || matches!(s.rotation, Rotation::Free { index: i, .. } if i == index)
        };
        self.wheel_body(self.sprockets.iter().position(owns).unwrap_or(0))
    }
}

impl SprocketModel {
    /// Calls `each` with every coordinate of the sprocket and its mass \[kg\] or moment of inertia \[kg m²\].
    pub(crate) fn for_each_inertia(&self, mut each: impl FnMut(usize, f64)) {
        match self.support {
            Support::Fixed => {}
            Support::Slide { index, guide, .. } => each(index, self.mass + guide.extra_mass),
            Support::Floating { x, y } => {
                each(x, self.mass);
                each(y, self.mass);
            }
        }
        if let Rotation::Free { index, .. } = self.rotation {
            each(index, self.inertia);
        }
    }

    /// Distance from the centre of the teeth \[m\] within which a bushing is seated: halfway from the pitch circle to where it passes
    /// over the tips. A bushing cannot change gaps within it.
    #[must_use]
    pub fn seated_within(&self) -> f64 {
        0.5 * (self.profile.pitch_radius + self.reach - self.offset.norm())
    }

    /// Torque applied from outside at time `t` and angular speed `spin` \[N m\]; zero where the rotation is prescribed or free.
    #[must_use]
    pub fn applied_torque(&self, t: f64, spin: f64) -> f64 {
        let Rotation::Free { torque, curve, .. } = &self.rotation else {
            return 0.0;
        };
        let of_time = torque.as_ref().map_or(0.0, |table| table.value(t));
        match curve {
            Some(curve) => of_time + curve.value(spin),
            None => of_time,
        }
    }

    /// Place along its tensioner's way of a centre there \[m\], and the unit vector of the way; nothing without a tensioner.
    #[must_use]
    pub fn slide_at(&self, center: Vec2) -> Option<(f64, Vec2)> {
        let Support::Slide {
            direction, guide, ..
        } = &self.support
        else {
            return None;
        };
        let s = guide.place(*direction, center - self.center);
        Some((s, guide.tangent(*direction, s)))
    }

    /// The ratchet of its tensioner or arm, and how far along its way what that holds is in the state `y`.
    pub(crate) fn ratchet_at(&self, y: &[f64]) -> Option<(Ratchet, f64)> {
        if let Support::Slide { index, guide, .. } = self.support {
            return guide.ratchet.map(|ratchet| (ratchet, y[index]));
        }
        match (self.swing, &self.rotation) {
            (Some(swing), Rotation::Free { index, .. }) => swing
                .ratchet
                .map(|ratchet| (ratchet, y[*index] - self.phase)),
            _ => None,
        }
    }

    /// The tensioner's pull \[N\] at time `t`, along its direction.
    #[must_use]
    pub fn pull(&self, t: f64) -> f64 {
        match self.support {
            Support::Slide {
                pull, ramp_time, ..
            } if t < ramp_time => pull * (t / ramp_time).max(0.0),
            Support::Slide { pull, .. } => pull,
            _ => 0.0,
        }
    }
}

//! Compiled model of a drive: flat arrays, indices instead of names, constant during a run.

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

/// Complete model of a drive, constant during a run.
///
/// Bodies: links first, then rollers, then sprockets and guides. Generalized coordinates q: all link x, all link y, all link θ, those of
/// the sprockets and guides, all roller x, all roller y, all roller θ, and the integrals of the bristle deflections, see
/// [`BristlePlaces`].
///
/// Hinge `k` joins the front of link `k` and the rear of link `k + 1`; bushing `k` belongs to the inner one of these links. An open chain
/// is closed to a ring by the two bodies at its ends, which count as links; see [`OpenEnds`].
#[derive(Debug, Clone)]
pub struct Model {
    /// Number of links, hinges and bushings.
    pub links: usize,
    /// Ends of an open chain; `None` for a closed chain.
    pub ends: Option<OpenEnds>,
    /// Number of generalized coordinates.
    pub coordinates: usize,
    /// Half the nominal pitch \[m\].
    pub half_pitch: f64,
    /// Half the length of each link \[m\]: its hinges lie at (± arm, 0) in its own frame.
    pub arms: Vec<f64>,
    /// Mass of each link \[kg\].
    pub mass: Vec<f64>,
    /// Moment of inertia of each link \[kg m²\].
    pub inertia: Vec<f64>,
    /// 1/mass of each link \[1/kg\]; zero for an end with prescribed motion.
    pub inverse_mass: Vec<f64>,
    /// 1/inertia of each link \[1/(kg m²)\]; zero for an end with prescribed motion.
    pub inverse_inertia: Vec<f64>,
    /// Radial clearance of the hinges \[m\].
    pub clearance: f64,
    /// Radius of the pins \[m\].
    pub pin_radius: f64,
    /// Outside radius of the bushings or rollers in contact with the teeth \[m\].
    pub contact_radius: f64,
    /// Rollers, where they are bodies of their own.
    pub rollers: Option<RollerModel>,
    /// Sprockets, followed by the guides, which are treated as wheels without teeth.
    pub sprockets: Vec<SprocketModel>,
    /// Number of guides at the end of `sprockets`.
    pub guides: usize,
    /// Sprockets at the start and at the end of each strand. With two sprockets: the upper strand, then the lower one.
    pub strands: Vec<[usize; 2]>,
    /// Contact law of the hinges: one pair of surfaces for all.
    pub hinge_law: ContactLaw,
    /// Contact law of the teeth: pairs of surfaces sprocket by sprocket, see [`Self::tooth_pair`].
    pub tooth_law: ContactLaw,
    /// Friction in the hinges; `None`: no friction.
    pub hinge_friction: Option<Friction>,
    /// Friction on the teeth; `None`: no friction.
    pub tooth_friction: Option<Friction>,
    /// Bristle (`LuGre`) friction in the hinges, instead of a function of the sliding velocity; `None`: no bristles.
    pub hinge_bristles: Option<LuGre>,
    /// Bristle (`LuGre`) friction on the teeth; `None`: no bristles.
    pub tooth_bristles: Option<LuGre>,
    /// Coordinates of the bristles.
    pub bristles: BristlePlaces,
    /// Compliance of the plates at each hinge \[m/N\]; `None`: rigid plates.
    pub link_compliance: Option<Vec<f64>>,
    /// Lubricant film in the hinges; `None`: no film.
    pub hinge_film: Option<HingeFilm>,
    /// Minimum impact velocity \[m/s\].
    pub min_approach_speed: f64,
    /// Gravity \[m/s²\].
    pub gravity: Vec2,
    /// Warnings on laws outside their range of validity in this drive, one line each.
    pub range_notes: Vec<String>,
}

/// Contact law with constants for one group of surface pairs.
#[derive(Debug, Clone)]
pub struct ContactLaw {
    /// Elastic law.
    pub elastic: Elastic,
    /// Constants of the elastic law for each pair.
    pub pairs: PairTable,
    /// λ of the damping factor; zero without damping.
    pub lambda: f64,
    /// Treatment of transitions between the regions of a tooth.
    pub regions: Regions,
}

/// Rollers: one on every bushing, all identical.
#[derive(Debug, Clone)]
pub struct RollerModel {
    /// First coordinate of the rollers: all x, all y, all θ follow.
    pub first: usize,
    /// Mass \[kg\].
    pub mass: f64,
    /// Moment of inertia \[kg m²\].
    pub inertia: f64,
    /// Radial clearance on the bushings \[m\].
    pub clearance: f64,
    /// Outside radius of the bushings \[m\].
    pub bushing_radius: f64,
    /// Contact law of bushings in the bores of the rollers: one pair of surfaces for all.
    pub law: ContactLaw,
}

/// Sprocket or guide.
#[derive(Debug, Clone)]
pub struct SprocketModel {
    /// Tooth profile.
    pub profile: ToothProfile,
    /// Number of the first surface pair of this sprocket in the contact law of the teeth.
    pub first_pair: usize,
    /// Directions (cos, sin) of the tooth gaps in the frame of the sprocket.
    pub gap_directions: Vec<(f64, f64)>,
    /// Centre of the teeth in the frame of the sprocket \[m\]; zero unless the teeth are eccentric.
    pub offset: Vec2,
    /// Distance of a bushing from the centre beyond which contact is impossible \[m\].
    pub reach: f64,
    /// Mass \[kg\].
    pub mass: f64,
    /// Moment of inertia \[kg m²\].
    pub inertia: f64,
    /// Centre at the start \[m\].
    pub center: Vec2,
    /// Angle of gap 0 at time zero \[rad\]. For a guide on an arm: angle at zero displacement of `swing`.
    pub phase: f64,
    /// Support of the centre.
    pub support: Support,
    /// Law of the rotation.
    pub rotation: Rotation,
    /// Side of the chain path on which the sprocket lies.
    pub side: Side,
    /// Spring, stops and dashpots of a guide's arm, as functions of its rotation \[rad\]: N m instead of N, rad instead of m.
    pub swing: Option<Guide>,
    /// Bounds of speed and torque inputs; `None` for a guide, which has no inputs.
    pub input_bounds: Option<InputBounds>,
}

/// Support of a sprocket's centre; indices refer to q.
#[derive(Debug, Clone, PartialEq)]
pub enum Support {
    /// Fixed centre.
    Fixed,
    /// Slide along a line or about a pivot, with the pull and the damping of a tensioner.
    Slide {
        /// Coordinate: displacement along the slide from its origin \[m\].
        index: usize,
        /// Unit vector of the guide path at its origin.
        direction: Vec2,
        /// Guide path, spring and stops.
        guide: Guide,
        /// Tensioner force after the ramp \[N\].
        pull: f64,
        /// Duration of the linear ramp of the tensioner force \[s\].
        ramp_time: f64,
        /// Dashpot coefficient \[N s/m\]: the larger one of both directions.
        damping: f64,
    },
    /// Centre free in the plane: coordinates x and y \[m\].
    Floating {
        /// Coordinate x.
        x: usize,
        /// Coordinate y.
        y: usize,
    },
}

/// Law of a sprocket's rotation.
#[derive(Debug, Clone, PartialEq)]
pub enum Rotation {
    /// Prescribed angular speed \[rad/s\]: no coordinate.
    Prescribed(Signal),
    /// Free rotation under the moment of the chain and an applied torque \[N m\].
    Free {
        /// Coordinate θ \[rad\].
        index: usize,
        /// Applied torque as a function of time \[N m\].
        torque: Option<Signal>,
        /// Applied torque as a function of the sprocket's angular speed \[N m\].
        curve: Option<Table>,
    },
}

impl Model {
    /// Return all signals of prescribed speeds, applied torques and moving ends.
    fn signals(&self) -> impl Iterator<Item = &Signal> {
        let of_sprockets = self.sprockets.iter().filter_map(|s| match &s.rotation {
            Rotation::Prescribed(signal) => Some(signal),
            Rotation::Free { torque, .. } => torque.as_ref(),
        });
        of_sprockets.chain(self.ends.iter().flat_map(OpenEnds::signals))
    }

    /// Return the time of the first knot of any signal after `t` \[s\]; infinite without one.
    ///
    /// A derivative is discontinuous at a knot: steps end there.
    #[must_use]
    pub fn next_kink(&self, t: f64) -> f64 {
        let knots = self.signals().map(|signal| signal.next_knot(t));
        knots.fold(f64::INFINITY, f64::min)
    }

    /// Return the longest step from `t` that resolves the variation of speeds and torques between their knots \[s\].
    pub(crate) fn longest_step_between_kinks(&self, t: f64) -> f64 {
        let steps = self
            .signals()
            .map(|signal| signal.longest_step_between_knots(t));
        steps.fold(f64::INFINITY, f64::min)
    }

    /// Return the number of sprockets with teeth.
    #[must_use]
    pub fn toothed(&self) -> usize {
        self.sprockets.len() - self.guides
    }

    /// Return the name of sprocket or guide `s`.
    #[must_use]
    pub fn wheel_name(&self, s: usize) -> String {
        match s.checked_sub(self.toothed()) {
            None => format!("sprocket {}", s + 1),
            Some(guide) => format!("guide {}", guide + 1),
        }
    }

    /// Return the name of the bushing or roller of hinge `k` that is in contact with the teeth.
    #[must_use]
    pub fn on_teeth_name(&self, k: usize) -> String {
        let what = self.rollers.as_ref().map_or("bushing", |_| "roller");
        format!("{what} {}", k + 1)
    }

    /// Return the number of bodies: links, rollers, sprockets and guides.
    #[must_use]
    pub fn bodies(&self) -> usize {
        self.wheel_body(self.sprockets.len())
    }

    /// Return the number of rollers that are bodies of their own.
    #[must_use]
    pub fn roller_count(&self) -> usize {
        self.rollers.as_ref().map_or(0, |_| self.links)
    }

    /// Return the body number of sprocket or guide `s`.
    #[must_use]
    pub fn wheel_body(&self, s: usize) -> usize {
        self.links + self.roller_count() + s
    }

    /// Return the number of coordinates of sprockets and guides.
    #[must_use]
    pub fn wheel_coordinates(&self) -> usize {
        self.coordinates - 3 * (self.links + self.roller_count()) - self.bristles.all().len()
    }

    /// Return the names of the bodies, in the order of every array over bodies.
    #[must_use]
    pub fn body_names(&self) -> Vec<String> {
        (0..self.links)
            .map(|i| self.link_name(i))
            .chain((1..=self.roller_count()).map(|k| format!("roller_{k}")))
            .chain((0..self.sprockets.len()).map(|s| self.wheel_name(s).replace(' ', "_")))
            .collect()
    }

    /// Return the name of link `i`, numbered from 1; a body at an end of an open chain has the number of that end.
    #[must_use]
    pub fn link_name(&self, i: usize) -> String {
        let ends = self.ends.as_ref().map(|ends| &ends.bodies);
        match ends.and_then(|ends| ends.iter().position(|end| end.body == i)) {
            Some(end) => format!("end_{}", end + 1),
            None => format!("link_{}", i + 1),
        }
    }

    /// Return the link to which bushing `k` is fixed.
    #[must_use]
    pub fn link_of_bushing(&self, bushing: usize) -> usize {
        if bushing_on_front(bushing, self.links) {
            bushing
        } else {
            (bushing + 1) % self.links
        }
    }

    /// Return the position of bushing `k` along its link, from the link's centre \[m\].
    #[must_use]
    pub fn bushing_arm(&self, bushing: usize) -> f64 {
        let link = self.link_of_bushing(bushing);
        if link == bushing {
            self.arms[link]
        } else {
            -self.arms[link]
        }
    }

    /// Return whether hinges, and bushings in rollers, have friction.
    #[must_use]
    pub fn hinges_rub(&self) -> bool {
        self.hinge_friction.is_some() || self.hinge_bristles.is_some()
    }

    /// Return whether teeth have friction.
    #[must_use]
    pub fn teeth_rub(&self) -> bool {
        self.tooth_friction.is_some() || self.tooth_bristles.is_some()
    }

    /// Return whether any contact has friction.
    #[must_use]
    pub fn has_friction(&self) -> bool {
        self.hinges_rub() || self.teeth_rub()
    }

    /// Return whether hinges have a lubricant film or links are elastic.
    #[must_use]
    pub fn has_extra(&self) -> bool {
        self.hinge_film.is_some() || self.link_compliance.is_some()
    }

    /// Return the compliance of the plates at hinge `k` \[m/N\]; `None` for rigid plates.
    #[must_use]
    pub fn compliance_at(&self, k: usize) -> Option<f64> {
        Some(self.link_compliance.as_ref()?[k])
    }

    /// Return whether hinges can transmit moments to links besides forces at their centres.
    ///
    /// That is the case with friction or a lubricant film. Hinges of elastic links are treated in the same way.
    #[must_use]
    pub fn has_moments(&self) -> bool {
        self.has_friction() || self.has_extra()
    }

    /// Return the number of the surface pair of a sprocket's surface in the contact law of the teeth.
    #[must_use]
    pub fn tooth_pair(&self, sprocket: usize, surface: Surface) -> usize {
        self.sprockets[sprocket].first_pair + surface.index()
    }

    /// Return the body of generalized coordinate `index`.
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
    /// Call `each` with every coordinate of the sprocket and its mass \[kg\] or moment of inertia \[kg m²\].
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

    /// Return the distance from the centre of the teeth below which a bushing counts as seated \[m\].
    ///
    /// It lies halfway between the pitch circle and the distance at which a bushing passes over the tips. A bushing within this distance
    /// cannot change gaps.
    #[must_use]
    pub fn seated_within(&self) -> f64 {
        0.5 * (self.profile.pitch_radius + self.reach - self.offset.norm())
    }

    /// Return the applied torque at time `t` \[s\] and angular speed `spin` \[rad/s\] \[N m\]; zero for prescribed or free rotation.
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

    /// Return the displacement along the slide for a centre at `center` \[m\], and the tangent there; `None` without a tensioner.
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

    /// Return the ratchet of the tensioner or arm, and the displacement (rotation for an arm) that it limits, in the state `y`.
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

    /// Return the tensioner force at time `t` along its direction \[N\]: a linear ramp, then constant.
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

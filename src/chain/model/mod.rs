//! Compiled model of a drive: flat arrays, indices instead of names, constant during a run.

mod bristles;
mod compile;
mod coordinates;
mod ends;
mod force_laws;
mod guide;
mod input;
mod rail;
mod range_notes;
mod sprocket;
mod surface_pairs;

pub use bristles::BristlePlaces;
pub(crate) use ends::IMMOVABLE;
pub use ends::{EndKind, EndModel, OpenEnds};
pub use force_laws::ForceLaws;
pub use guide::{Guide, Ratchet};
pub use input::Input;
pub use sprocket::{Rotation, SprocketModel, Support};

use crate::drive::bushing_on_front;
use crate::force_law::{Elastic, Friction, HingeFilm, LuGre, PairTable, Regions};
use crate::geometry::{Surface, Vec2};
use crate::math::Signal;

/// Complete model of a drive, constant during a run.
///
/// Bodies: links first, then rollers, then sprockets and guides. Generalized coordinates q: all link x, all link y, all link θ, those of
/// the sprockets and guides, all roller x, all roller y, all roller θ, the integrals of the bristle deflections, see
/// [`BristlePlaces`], and zeros up to a multiple of eight.
///
/// Hinge `k` joins the front of link `k` and the rear of link `k + 1`; bushing `k` belongs to the inner one of these links. An open chain
/// is closed to a ring by the two bodies at its ends, which count as links; see [`OpenEnds`].
#[derive(Debug, Clone)]
pub struct Model {
    /// Number of links, hinges and bushings.
    pub links: usize,
    /// Ends of an open chain; `None` for a closed chain.
    pub ends: Option<OpenEnds>,
    /// Number of positions in a state, and of velocities: the generalized coordinates, and zeros up to whole SIMD vectors. Vectors of the
    /// velocities then do not cross cache lines.
    pub coordinates: usize,
    /// Number of generalized coordinates.
    pub used_coordinates: usize,
    /// Half the nominal pitch \[m\].
    pub half_pitch: f64,
    /// Lengths and inertias of the links.
    pub chain: ChainBodies,
    /// Contacts of pins in bushings.
    pub hinges: HingeModel,
    /// Contacts of bushings or rollers with sprockets and guides.
    pub teeth: ToothModel,
    /// Rollers, where they are bodies of their own.
    pub rollers: Option<RollerModel>,
    /// Sprockets, followed by the guides, which are treated as wheels without teeth.
    pub sprockets: Vec<SprocketModel>,
    /// Number of guides at the end of `sprockets`.
    pub guides: usize,
    /// Sprockets at the start and at the end of each strand. With two sprockets: the upper strand, then the lower one.
    pub strands: Vec<[usize; 2]>,
    /// Coordinates of the bristles.
    pub bristles: BristlePlaces,
    /// Minimum impact velocity \[m/s\].
    pub min_impact_velocity: f64,
    /// Gravity \[m/s²\].
    pub gravity: Vec2,
    /// Warnings on laws outside their range of validity in this drive, one line each.
    pub range_notes: Vec<String>,
}

/// Lengths and inertias of the bodies of the chain: links, and the bodies at the ends of an open chain.
#[derive(Debug, Clone)]
pub struct ChainBodies {
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
}

/// Hinges: a pin in a bushing each, all identical.
#[derive(Debug, Clone)]
pub struct HingeModel {
    /// Whether hinges are ideal joints: the rest applies to hinges with clearance only.
    pub ideal: bool,
    /// Radial clearance \[m\].
    pub clearance: f64,
    /// Radius of the pins \[m\].
    pub pin_radius: f64,
    /// Contact law: one pair of surfaces for all.
    pub law: CompiledContactLaw,
    /// Friction, also of bushings in rollers; `None`: no friction.
    pub friction: Option<Friction>,
    /// Bristle (`LuGre`) friction, instead of a function of the sliding velocity; `None`: no bristles.
    pub bristles: Option<LuGre>,
    /// Compliance of the plates at each hinge \[m/N\]; `None`: rigid plates.
    pub compliance: Option<Vec<f64>>,
    /// Lubricant film; `None`: no film.
    pub film: Option<HingeFilm>,
}

impl HingeModel {
    /// Return whether hinges, and bushings in rollers, have friction.
    #[must_use]
    pub fn has_friction(&self) -> bool {
        self.friction.is_some() || self.bristles.is_some()
    }

    /// Return whether hinges have a lubricant film or links are elastic.
    #[must_use]
    pub fn has_film_or_compliance(&self) -> bool {
        self.film.is_some() || self.compliance.is_some()
    }

    /// Return the compliance of the plates at hinge `k` \[m/N\]; `None` for rigid plates.
    #[must_use]
    pub fn compliance_at(&self, k: usize) -> Option<f64> {
        Some(self.compliance.as_ref()?[k])
    }
}

/// Contacts of bushings or rollers with the teeth of sprockets and with guides.
#[derive(Debug, Clone)]
pub struct ToothModel {
    /// Outside radius of the bushings or rollers in contact with the teeth \[m\].
    pub contact_radius: f64,
    /// Contact law: pairs of surfaces sprocket by sprocket, see [`Model::tooth_pair`].
    pub law: CompiledContactLaw,
    /// Friction; `None`: no friction.
    pub friction: Option<Friction>,
    /// Bristle (`LuGre`) friction; `None`: no bristles.
    pub bristles: Option<LuGre>,
}

impl ToothModel {
    /// Return whether teeth have friction.
    #[must_use]
    pub fn has_friction(&self) -> bool {
        self.friction.is_some() || self.bristles.is_some()
    }
}

/// Contact law with constants for one group of surface pairs.
#[derive(Debug, Clone)]
pub struct CompiledContactLaw {
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
    pub law: CompiledContactLaw,
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

    /// Return the time of the first knot of any signal, or end of a tensioner's ramp, after `t` \[s\]; infinite without one.
    ///
    /// A derivative is discontinuous there: steps end there.
    #[must_use]
    pub fn next_kink(&self, t: f64) -> f64 {
        let knots = self.signals().map(|signal| signal.next_knot(t));
        let ramps = self.sprockets.iter().filter_map(|s| match s.support {
            Support::Slide { ramp_time, .. } if ramp_time > t => Some(ramp_time),
            _ => None,
        });
        knots.chain(ramps).fold(f64::INFINITY, f64::min)
    }

    /// Return the longest step from `t` to the next knot that resolves the variation of speeds and torques until then \[s\].
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

    /// Return the number of coordinates of all bodies, which precede those of the bristles.
    #[must_use]
    pub fn body_coordinates(&self) -> usize {
        self.used_coordinates - self.bristles.all().len()
    }

    /// Return the number of coordinates of sprockets and guides.
    #[must_use]
    pub fn wheel_coordinates(&self) -> usize {
        self.body_coordinates() - 3 * (self.links + self.roller_count())
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
            self.chain.arms[link]
        } else {
            -self.chain.arms[link]
        }
    }

    /// Return whether any contact has friction.
    #[must_use]
    pub fn has_friction(&self) -> bool {
        self.hinges.has_friction() || self.teeth.has_friction()
    }

    /// Return whether hinges can transmit moments to links besides forces at their centres.
    ///
    /// That is the case with friction or a lubricant film. Hinges of elastic links are treated in the same way.
    #[must_use]
    pub fn has_moments(&self) -> bool {
        self.has_friction() || self.hinges.has_film_or_compliance()
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

//! A contact prepared for a run: contact points, forces, energies and the impact velocity memory of each side of the profile.

use super::impact_memory::{Memory, SideState};
use super::outline::{ContactPoint, Outline, OutlinePlace, is_tight};
use crate::error::Result;
use crate::force_law::HingeFilm;
use crate::geometry::Contact;
use crate::geometry::Vec2;
use crate::multibody::description::body::{End, Frame};
use crate::multibody::description::contact_law::CompiledLaw;
use crate::multibody::description::contact_pair::ContactPair;
use crate::multibody::description::outline_piece::Curvature;
use crate::multibody::description::profile::{Nearest, Profile, Tooth};
use crate::multibody::description::tribology::FrictionLaw;
use crate::multibody::forces::loads::BodyLoads;

/// Gap of a circle below which it is near a profile, over its radius. No step carries a circle to the profile from a larger gap.
/// From a smaller gap no step carries it farther than this length, and the path is screened for contacts.
pub(crate) const FARTHEST: f64 = 0.25;

/// A contact with its bodies by index and the constants of each piece of its profile.
#[derive(Debug, Clone)]
pub(crate) struct CompiledContact {
    pub(crate) a: End,
    pub(crate) b: End,
    profile: Profile,
    /// The prepared outline, if the profile is an outline; a circle may have several contact points on it.
    pub(crate) outline: Option<Outline>,
    pub(crate) radius: f64,
    /// Distance of the markers above which there is no contact \[m\]; infinite for profiles of unbounded extent.
    pub(crate) reach: f64,
    pairs: Vec<CompiledLaw>,
    pub(crate) friction: Option<FrictionLaw>,
    pub(crate) film: Option<HingeFilm>,
}

impl CompiledContact {
    pub(crate) fn new(pair: &ContactPair, a: End, b: End) -> Result<Self> {
        let field = format!("contact {:?}", pair.name);
        let outline = match &pair.profile {
            Profile::Outline { pieces, closed } => Some(Outline::new(pieces, *closed, pair.radius)),
            _ => None,
        };
        let prepare = |curvature| pair.law.prepare(&field, pair.radius, curvature);
        Ok(Self {
            a,
            b,
            pairs: (curvatures(pair).into_iter())
                .map(prepare)
                .collect::<Result<_>>()?,
            outline,
            reach: pair.profile.reach() + pair.radius,
            profile: pair.profile.clone(),
            radius: pair.radius,
            friction: pair.tribology.friction,
            film: pair
                .tribology
                .film_of(&pair.profile, pair.radius, &pair.law),
        })
    }

    /// Return the number of sides of the profile, each with its own contact force.
    pub(crate) fn sides(&self) -> usize {
        self.outline.as_ref().map_or(1, Outline::sides)
    }

    /// Return the position of the circle's centre in the frame of the profile \[m\].
    pub(crate) fn local(&self, fa: &Frame, fb: &Frame) -> Vec2 {
        fa.into_local(fb.place(self.b.point) - fa.place(self.a.point))
    }

    /// Call `visit` with every candidate contact point in the frame of the profile, independent of the memory.
    pub(crate) fn contact_points(
        &self,
        local: Vec2,
        mut visit: impl FnMut(&ContactPoint, Option<Tooth>),
    ) {
        if let Some(outline) = &self.outline {
            outline.contact_points(local, self.radius, |candidate| visit(candidate, None));
        } else {
            self.only_contact_point(local, visit);
        }
    }

    /// Call `visit` with the candidate contact points needed for forces: points far from the surface only if there is no other.
    fn contact_points_near(
        &self,
        local: Vec2,
        mut visit: impl FnMut(&ContactPoint, Option<Tooth>),
    ) {
        if let Some(outline) = &self.outline {
            outline.contact_points_near(local, self.radius, |candidate| visit(candidate, None));
        } else {
            self.only_contact_point(local, visit);
        }
    }

    /// Call `visit` with the single candidate contact point of a profile that is not an outline.
    fn only_contact_point(&self, local: Vec2, mut visit: impl FnMut(&ContactPoint, Option<Tooth>)) {
        let Nearest {
            distance,
            outward,
            piece,
            tooth,
        } = self.profile.nearest(local, self.radius);
        let candidate = ContactPoint {
            distance,
            outward,
            piece,
            side: 0,
            weight: 1.0,
            weight_gradient: Vec2::zeros(),
            bend: 0.0,
            place: OutlinePlace::Front,
        };
        visit(&candidate, tooth);
    }

    /// Return whether a contact point may have a force. A circle behind an open outline has none until it is outside. A circle that
    /// penetrated from the front has one.
    pub(crate) fn may_carry_force(&self, candidate: &ContactPoint, memory: Memory) -> bool {
        match candidate.place {
            OutlinePlace::DeepAtEnd => memory.in_front,
            // Without memory, a centre less than half a radius deep counts as having come from the front.
            OutlinePlace::Deep if self.is_open() => {
                memory.in_front || memory.is_empty() && -candidate.distance < 0.5 * self.radius
            }
            // A circle marked as behind has no force while it overlaps the surface.
            _ => !memory.is_behind() || candidate.distance >= self.radius,
        }
    }

    /// Return the contact with one side at its point of largest penetration.
    pub(crate) fn find(&self, fa: &Frame, fb: &Frame, side: usize, memory: Memory) -> SideState {
        let mut side_state = SideState::default();
        let approach = self.approach(fa, fb);
        self.contact_points(self.local(fa, fb), |candidate, tooth| {
            if candidate.side == side
                && candidate.weight > 0.0
                && self.may_carry_force(candidate, memory)
            {
                self.keep_deepest(
                    &mut side_state,
                    candidate,
                    tooth,
                    -fa.turned(candidate.outward),
                    approach,
                );
            }
        });
        side_state
    }

    /// Return the velocity of the circle's centre relative to the profile's body at the same point \[m/s\]. Its component along the
    /// normal is the penetration rate: that component is the same at all points of the normal.
    pub(crate) fn approach(&self, fa: &Frame, fb: &Frame) -> Vec2 {
        let center = fb.place(self.b.point);
        fb.velocity_at(center) - fa.velocity_at(center)
    }

    fn keep_deepest(
        &self,
        side_state: &mut SideState,
        candidate: &ContactPoint,
        tooth: Option<Tooth>,
        inward: Vec2,
        approach: Vec2,
    ) {
        let penetration = self.radius - candidate.distance;
        if penetration > side_state.contact.penetration {
            side_state.contact = Contact {
                normal: inward,
                penetration,
                penetration_rate: inward.dot(&approach),
            };
            (side_state.piece, side_state.place, side_state.tooth) =
                (candidate.piece, candidate.place, tooth);
        }
    }

    /// Return the largest penetration of all sides \[m\], which is the recorded one.
    pub(crate) fn penetration(&self, frames: &[Frame], memory: &[Memory]) -> f64 {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let depths = memory.iter().enumerate();
        let depths = depths.map(|(side, m)| self.find(fa, fb, side, *m).contact.penetration);
        depths.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Return the square of the distance of both markers \[m²\]. The circle is near the profile up to the square of [`Self::reach`].
    pub(crate) fn apart_squared(&self, frames: &[Frame]) -> f64 {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        (fb.place(self.b.point) - fa.place(self.a.point)).norm_squared()
    }

    /// Add forces, elastic energy and dissipated power of the contact, and write the state of each side.
    ///
    /// Return the largest penetration \[m\], negative when apart, and its rate \[m/s\]; the penetration is -∞ without a contact point.
    ///
    /// The force on the circle is Σ (w f n - E ∇w) over the contact points, with outward normal n, weight w and energy E(δ). Its
    /// elastic part is the negative gradient of U = Σ w E(δ).
    pub(crate) fn add(
        &self,
        frames: &[Frame],
        memory: &[Memory],
        loads: &mut BodyLoads,
        side_states: &mut [SideState],
    ) -> [f64; 2] {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        for side_state in side_states
            .iter_mut()
            .filter(|side_state| side_state.is_known())
        {
            *side_state = SideState::default();
        }
        let mut deepest = [f64::NEG_INFINITY, 0.0];
        let approach = self.approach(fa, fb);
        self.contact_points_near(self.local(fa, fb), |candidate, tooth| {
            let (side_state, memory) = (&mut side_states[candidate.side], memory[candidate.side]);
            if !self.may_carry_force(candidate, memory) {
                return;
            }
            // Into the material: the direction of growing penetration, as in `Contact`.
            let inward = -fa.turned(candidate.outward);
            let depth = self.radius - candidate.distance;
            if candidate.weight > 0.0 {
                self.keep_deepest(side_state, candidate, tooth, inward, approach);
                if depth > deepest[0] {
                    deepest = [depth, inward.dot(&approach)];
                }
            }
            if depth <= 0.0 {
                return;
            }
            let rate = inward.dot(&approach);
            let law = self.law_on(candidate.piece, memory);
            let force = law.force(depth, rate, memory.speed);
            let energy = law.energy(depth);
            let mut pressing = -candidate.weight * force.total * inward;
            let by_weight = energy * fa.turned(candidate.weight_gradient);
            side_state.push += pressing - by_weight;
            if !candidate.is_between() {
                pressing -= by_weight;
            }
            side_state.pressing += pressing;
            loads.elastic += candidate.weight * energy;
            loads.dissipated += candidate.weight * force.dissipated;
        });
        // The resultant of each side passes through the circle's centre.
        let center = fb.place(self.b.point);
        for side_state in side_states
            .iter_mut()
            .filter(|side_state| side_state.push != Vec2::zeros())
        {
            side_state.force = side_state.push.norm();
            loads.push(self.b.body, fb, center, side_state.push);
            loads.push(self.a.body, fa, center, -side_state.push);
        }
        deepest
    }

    /// Return the contact law at a contact point on `piece`. A contact keeps the law of the piece on which it began.
    pub(crate) fn law_on(&self, piece: usize, memory: Memory) -> &CompiledLaw {
        let began = memory.is_in_contact().then_some(memory.piece);
        &self.pairs[began.unwrap_or(piece)]
    }

    /// Return the smallest penetration at which the law of a piece ends \[m\]; infinite without an end.
    pub(crate) fn nearest_range_end(&self) -> f64 {
        let ends = self.pairs.iter().map(|law| law.elastic.range_end());
        ends.fold(f64::INFINITY, f64::min)
    }

    /// Return the memory of a side without a force. It is [`Memory::BEHIND`] if the circle is behind an open outline without having
    /// come through the surface, and empty otherwise.
    pub(crate) fn apart(&self, fa: &Frame, fb: &Frame, side: usize, memory: Memory) -> Memory {
        let mut behind = false;
        if self.is_open() {
            self.contact_points(self.local(fa, fb), |candidate, _| {
                behind |= candidate.side == side && self.is_behind_at(candidate, memory);
            });
        }
        if behind {
            Memory::BEHIND
        } else {
            Memory::default()
        }
    }

    /// Return whether the circle is behind an open outline at this point.
    fn is_behind_at(&self, point: &ContactPoint, memory: Memory) -> bool {
        match point.place {
            OutlinePlace::DeepAtEnd => false,
            OutlinePlace::Deep => true,
            _ => memory.is_behind() && point.weight > 0.0 && point.distance < self.radius,
        }
    }

    /// Return the depth of the circle's centre in the material \[m\], not above zero outside; -∞ for an open outline, which has a back.
    pub(crate) fn center_depth(&self, frames: &[Frame]) -> f64 {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let mut depth = f64::NEG_INFINITY;
        if !self.is_open() {
            self.contact_points(self.local(fa, fb), |candidate, _| {
                if candidate.weight > 0.0 {
                    depth = depth.max(-candidate.distance);
                }
            });
        }
        depth
    }

    /// Return whether the circle's centre is behind an open outline by half a radius or more and does not move towards the front.
    pub(crate) fn is_behind(&self, frames: &[Frame]) -> bool {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let mut behind = false;
        if self.is_open() {
            self.contact_points(self.local(fa, fb), |candidate, _| {
                let comes_out = self.approach(fa, fb).dot(&fa.turned(candidate.outward)) > 0.0;
                let deep = candidate.place == OutlinePlace::Deep
                    && -candidate.distance >= 0.5 * self.radius;
                behind |= deep && !comes_out;
            });
        }
        behind
    }

    /// Return whether the material of a closed outline lies outside the outline.
    pub(crate) fn is_hole(&self) -> bool {
        self.outline.is_some() && !self.is_open() && self.reach.is_infinite()
    }

    /// Return the number of pieces of the profile.
    pub(crate) fn pieces(&self) -> usize {
        self.pairs.len()
    }

    /// Return the clearance of a pin in a bore, and a quarter of the circle's radius for other profiles \[m\].
    pub(crate) fn play(&self) -> f64 {
        match &self.profile {
            Profile::Bore { radius } if *radius > self.radius => radius - self.radius,
            _ => FARTHEST * self.radius,
        }
    }

    pub(crate) fn profile(&self) -> &Profile {
        &self.profile
    }

    pub(crate) fn is_open(&self) -> bool {
        self.outline.as_ref().is_some_and(Outline::is_open)
    }

    /// Return whether the initial impact velocity in a memory is the minimum impact velocity of the law.
    pub(crate) fn is_at_minimum(&self, memory: Memory) -> bool {
        self.pairs[memory.piece].is_at_minimum(memory.speed)
    }

    /// Return the impact velocity memory of a contact with its onset on `piece` at the penetration rate `rate` \[m/s\].
    pub(crate) fn remember(&self, piece: usize, rate: f64) -> Memory {
        Memory {
            speed: self.pairs[piece].onset_speed(rate),
            piece,
            in_front: false,
        }
    }
}

/// Return the curvature of each piece of the profile of a contact, as its law takes it.
pub(super) fn curvatures(pair: &ContactPair) -> Vec<Curvature> {
    let is_outline = matches!(pair.profile, Profile::Outline { .. });
    let mut curvatures = pair.profile.curvatures(pair.radius);
    // In an arc that the circle does not fit into, it is in contact with the pieces beside the arc.
    for curvature in &mut curvatures {
        if is_outline && is_tight(*curvature, pair.radius) {
            *curvature = Curvature::Flat;
        }
    }
    curvatures
}

#[cfg(test)]
mod tests;

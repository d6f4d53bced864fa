//! A contact prepared for a run: contact points, forces, energies and the impact velocity memory of each side of the profile.

use super::impact_memory::{Memory, SideState};
use super::outline::{ContactPoint, Outline, Place, is_tight};
use super::step_bound::FARTHEST;
use crate::error::Result;
use crate::force_law::HingeFilm;
use crate::geometry::Contact;
use crate::geometry::Vec2;
use crate::multibody::description::body::{End, Frame};
use crate::multibody::description::contact_law::CompiledLaw;
use crate::multibody::description::contact_pair::ContactPair;
use crate::multibody::description::profile::{Curvature, Nearest, Profile, Tooth};
use crate::multibody::description::tribology::FrictionLaw;
use crate::multibody::forces::loads::Loads;

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
        let prepare = |curvature| {
            // In an arc that the circle does not fit into, it is in contact with the pieces beside the arc.
            let sides = outline.is_some() && is_tight(curvature, pair.radius);
            let curvature = if sides { Curvature::Flat } else { curvature };
            pair.law.prepare(&field, pair.radius, curvature)
        };
        Ok(Self {
            a,
            b,
            pairs: pair
                .profile
                .curvatures(pair.radius)
                .into_iter()
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
            place: Place::Front,
        };
        visit(&candidate, tooth);
    }

    /// Return whether a contact point may have a force. A circle behind an open outline has none until it is outside. A circle that
    /// penetrated from the front has one.
    pub(crate) fn may_carry_force(&self, candidate: &ContactPoint, memory: Memory) -> bool {
        match candidate.place {
            Place::DeepAtEnd => memory.in_front,
            // Without memory, a centre less than half a radius deep counts as having come from the front.
            Place::Deep if self.is_open() => {
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
        loads: &mut Loads,
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
            let force = self
                .pair(candidate, memory)
                .force(depth, rate, memory.speed);
            let energy = self.pair(candidate, memory).energy(depth);
            side_state.push -= candidate.weight * force.total * inward
                + energy * fa.turned(candidate.weight_gradient);
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

    /// Return the contact law at a contact point. A contact keeps the law of the piece on which it began.
    pub(crate) fn pair(&self, candidate: &ContactPoint, memory: Memory) -> &CompiledLaw {
        &self.pairs[if memory.is_in_contact() {
            memory.piece
        } else {
            candidate.piece
        }]
    }

    /// Return the memory of a side without a force. It is [`Memory::BEHIND`] if the circle is behind an open outline without having
    /// come through the surface, and empty otherwise.
    pub(crate) fn apart(&self, fa: &Frame, fb: &Frame, side: usize, memory: Memory) -> Memory {
        let mut behind = false;
        if self.is_open() {
            self.contact_points(self.local(fa, fb), |candidate, _| {
                behind |= candidate.side == side
                    && match candidate.place {
                        Place::DeepAtEnd => false,
                        Place::Deep => true,
                        _ => {
                            memory.is_behind()
                                && candidate.weight > 0.0
                                && candidate.distance < self.radius
                        }
                    };
            });
        }
        if behind {
            Memory::BEHIND
        } else {
            Memory::default()
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
                let deep =
                    candidate.place == Place::Deep && -candidate.distance >= 0.5 * self.radius;
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
    pub(crate) fn is_at_floor(&self, memory: Memory) -> bool {
        self.pairs[memory.piece].is_at_floor(memory.speed)
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

#[cfg(test)]
mod tests {
    use super::super::tests::{
        BALL, BLOCK, at_rest, contact, distance_to, evaluated, floor, frames, model, only, outline,
    };
    use super::*;
    use crate::force_law::{Damping, Elastic, ForceLaw, Regions};
    use crate::multibody::contact::contact_states::ContactStates;
    use crate::multibody::description::contact_law::ContactLaw;
    use crate::multibody::description::outline_piece::Piece;
    use crate::multibody::model::MechanismModel;

    const RADIUS: f64 = 0.1;
    const IN_CONTACT: Memory = Memory {
        speed: 0.5,
        piece: 0,
        in_front: false,
    };
    const FROM_FRONT: Memory = Memory {
        speed: 0.5,
        piece: 0,
        in_front: true,
    };

    /// Return frames with the ball at a place and at a velocity.
    fn at((x, y): (f64, f64), (vx, vy): (f64, f64)) -> Vec<Frame> {
        frames(&at_rest(), &[[x, y, 0.0], [vx, vy, 0.0], [0.0; 3]], 0.0)
    }

    fn hertz() -> ContactLaw {
        ContactLaw::Surfaces {
            law: ForceLaw {
                elastic: Elastic::Hertz,
                damping: Damping::LankaraniNikravesh,
                regions: Regions::Kept,
            },
            contact_modulus: 1e7,
            restitution: 0.9,
            length: 0.02,
            min_approach_speed: 0.01,
        }
    }

    /// Return the force on the ball of a contact with Hertz' law.
    fn force(profile: Profile, place: (f64, f64), memory: Memory) -> Vec2 {
        let mut pair = contact(profile, RADIUS);
        pair.law = hertz();
        let model = model(vec![pair]);
        let mut states = ContactStates::new(&model);
        states.memory.fill(memory);
        let load = evaluated(&model, &mut states, &at(place, (0.0, 0.0))).on[BALL];
        Vec2::new(load[0], load[1])
    }

    fn arc(radius: f64, convex: bool) -> Piece {
        let x = if convex { radius } else { -radius };
        Piece {
            from: Vec2::new(x, 0.0),
            to: Vec2::new(-x, 0.0),
            center: Some(Vec2::zeros()),
            convex,
        }
    }

    #[test]
    fn an_arc_presses_as_the_disc_or_the_bore_of_its_radius() {
        let half = |convex| Profile::Outline {
            pieces: vec![arc(0.3, convex)],
            closed: false,
        };
        for (one, other, place) in [
            (half(true), Profile::Disc { radius: 0.3 }, (0.1, 0.37)),
            (half(false), Profile::Bore { radius: 0.3 }, (0.05, 0.21)),
        ] {
            let [one, other] = [one, other].map(|profile| force(profile, place, IN_CONTACT));
            assert!((one - other).norm() < 1e-12 * other.norm() && other.norm() > 1.0);
        }
        // An arc into which the circle does not fit needs no law of its own.
        let pieces = vec![
            Piece {
                from: Vec2::new(1.05, 1.0),
                to: Vec2::new(0.05, 0.0),
                center: None,
                convex: true,
            },
            Piece {
                from: Vec2::new(0.05, 0.0),
                to: Vec2::new(-0.05, 0.0),
                center: Some(Vec2::new(0.0, 0.05)),
                convex: false,
            },
        ];
        let tight = Profile::Outline {
            pieces,
            closed: false,
        };
        let mut pair = contact(tight, RADIUS);
        pair.law = hertz();
        assert_eq!(only(&model(vec![pair])).pieces(), 2);
    }

    #[test]
    fn a_contact_keeps_the_law_of_the_piece_of_its_onset() {
        // A flat and an arc of 0.15 m beside it.
        let pieces = vec![
            Piece {
                from: Vec2::new(1.0, 0.15),
                to: Vec2::new(0.0, 0.15),
                center: None,
                convex: true,
            },
            Piece {
                from: Vec2::new(0.0, 0.15),
                to: Vec2::new(-0.15, 0.0),
                center: Some(Vec2::zeros()),
                convex: true,
            },
        ];
        let shape = || Profile::Outline {
            pieces: pieces.clone(),
            closed: false,
        };
        let on = |memory: Memory| force(shape(), (0.5, 0.24), memory).y;
        let memory = |piece| Memory {
            piece,
            ..IN_CONTACT
        };
        let on_arc = force(Profile::Disc { radius: 0.15 }, (0.0, 0.24), IN_CONTACT).y;
        assert!((on(memory(1)) / on_arc - 1.0).abs() < 1e-12);
        assert!((on(memory(0)) / on_arc - 1.0).abs() > 1e-3);
        // Without memory, the law is that of the piece of the contact point.
        let without = Memory {
            piece: 1,
            ..Memory::default()
        };
        assert_eq!(on(without), on(memory(0)));
    }

    #[test]
    fn only_a_circle_from_the_front_is_in_contact_behind_an_open_outline() {
        let model = model(vec![contact(floor(), RADIUS)]);
        let square = outline(&[(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)], true);
        let closed = super::super::tests::model(vec![contact(square, RADIUS)]);
        let may = |model: &MechanismModel, place, distance, memory| {
            let candidate = ContactPoint {
                distance,
                outward: Vec2::y(),
                piece: 0,
                side: 0,
                weight: 1.0,
                weight_gradient: Vec2::zeros(),
                bend: 0.0,
                place,
            };
            only(model).may_carry_force(&candidate, memory)
        };
        let none = Memory::default();
        for (place, distance, memory, expected) in [
            (Place::DeepAtEnd, -0.01, FROM_FRONT, true),
            (Place::DeepAtEnd, -0.01, IN_CONTACT, false),
            (Place::DeepAtEnd, -0.01, none, false),
            (Place::Deep, -0.5, FROM_FRONT, true),
            (Place::Deep, -0.01, IN_CONTACT, false),
            (Place::Deep, -0.049, none, true),
            (Place::Deep, -0.05, none, false),
            (Place::Deep, -0.051, none, false),
            (Place::Deep, -0.01, Memory::BEHIND, false),
            (Place::Front, 0.05, none, true),
            (Place::Front, 0.05, Memory::BEHIND, false),
            (Place::Front, 0.11, Memory::BEHIND, true),
            (Place::EndBack, 0.05, Memory::BEHIND, false),
            (Place::EndFront, 0.05, IN_CONTACT, true),
        ] {
            assert_eq!(
                may(&model, place, distance, memory),
                expected,
                "{place:?} {distance}"
            );
        }
        // Closed outlines have no back.
        assert!(may(&closed, Place::Deep, -0.5, none));
    }

    #[test]
    fn the_state_of_a_side_is_that_of_its_deepest_point() {
        // A re-entrant corner at the origin, with a wall along y and a floor along x, and an edge beyond the floor.
        let corner = outline(&[(0.5, -0.3), (0.4, 0.0), (0.0, 0.0), (0.0, 1.0)], false);
        let model = model(vec![contact(corner, RADIUS)]);
        let contact = only(&model);
        let here = at((0.07, 0.06), (-2.0, -3.0));
        let side = |k: usize, memory| contact.find(&here[BLOCK], &here[BALL], k, memory);
        let [floor, wall] = [0, 1].map(|k| side(k, Memory::default()));
        assert!((floor.contact.penetration - 0.04).abs() < 1e-15);
        assert!((wall.contact.penetration - 0.03).abs() < 1e-15);
        // Normals point into the material, and rates are velocities along them.
        assert_eq!(
            (floor.contact.normal, wall.contact.normal),
            (-Vec2::y(), -Vec2::x())
        );
        assert_eq!(
            (
                floor.contact.penetration_rate,
                wall.contact.penetration_rate
            ),
            (3.0, 2.0)
        );
        assert_eq!((floor.piece, wall.piece, floor.place), (1, 2, Place::Front));
        let behind = side(0, Memory::BEHIND).contact.penetration;
        assert_eq!(behind, f64::NEG_INFINITY);
        let deepest = contact.penetration(&here, &[Memory::default(); 2]);
        assert!((deepest - 0.04).abs() < 1e-15);
        let mut states = ContactStates::new(&model);
        evaluated(&model, &mut states, &here);
        for (found, exact) in states.side_states.iter().zip([floor, wall]) {
            assert_eq!(found.contact, exact.contact);
        }
        assert!((states.deepest[0][0] - 0.04).abs() < 1e-15 && states.deepest[0][1] == 3.0);
    }

    #[test]
    fn the_depth_of_a_centre_is_its_distance_from_the_outline_inside_of_it() {
        let points = [
            (-1.0, -1.0),
            (1.0, -1.0),
            (1.0, 1.0),
            (0.2, 0.1),
            (-1.0, 1.0),
        ];
        let round = [&points[..], &points[..1]].concat();
        let closed = model(vec![contact(outline(&points, true), RADIUS)]);
        for place in [(0.0, -0.3), (0.8, 0.4), (-0.9, -0.9), (0.5, -0.2)] {
            let depth = only(&closed).center_depth(&at(place, (0.0, 0.0)));
            let exact = distance_to(&round, Vec2::new(place.0, place.1));
            assert!((depth - exact).abs() < 1e-14, "{place:?}: {depth} {exact}");
        }
        for place in [(0.0, 1.4), (1.5, 0.0), (0.2, 0.4)] {
            let depth = only(&closed).center_depth(&at(place, (0.0, 0.0)));
            let exact = distance_to(&round, Vec2::new(place.0, place.1));
            assert!((depth + exact).abs() < 1e-14, "{place:?}: {depth} {exact}");
        }
        let open = model(vec![contact(floor(), RADIUS)]);
        let depth = only(&open).center_depth(&at((0.0, -0.3), (0.0, 0.0)));
        assert_eq!(depth, f64::NEG_INFINITY);
    }

    #[test]
    fn a_circle_is_behind_an_open_outline_at_half_a_radius_unless_it_comes_out() {
        let open = model(vec![contact(floor(), RADIUS)]);
        for (y, speed, behind) in [
            (-0.051, 0.0, true),
            (-0.05, 0.0, true),
            (-0.049, 0.0, false),
            (-0.051, -1.0, true),
            (-0.051, 1.0, false),
            (0.051, -1.0, false),
        ] {
            let found = only(&open).is_behind(&at((0.0, y), (0.0, speed)));
            assert_eq!(found, behind, "{y} {speed}");
        }
        let square = outline(&[(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)], true);
        let closed = model(vec![contact(square, RADIUS)]);
        assert!(!only(&closed).is_behind(&at((0.0, 0.3), (0.0, 0.0))));
    }

    #[test]
    fn a_memory_behind_ends_when_the_circle_is_outside_or_past_the_end() {
        let corner = outline(&[(1.0, 0.0), (0.0, 0.0), (0.0, 1.0)], false);
        let corner = model(vec![contact(corner, RADIUS)]);
        let open = model(vec![contact(floor(), RADIUS)]);
        let apart = |model: &MechanismModel, place, side, memory| {
            let here = at(place, (0.0, 0.0));
            only(model).apart(&here[BLOCK], &here[BALL], side, memory)
        };
        let none = Memory::default();
        for (place, before, expected) in [
            ((0.0, -0.3), none, Memory::BEHIND),
            ((0.0, -0.3), FROM_FRONT, Memory::BEHIND),
            ((0.0, 0.05), Memory::BEHIND, Memory::BEHIND),
            ((0.0, 0.15), Memory::BEHIND, none),
            ((0.0, 0.05), none, none),
            ((0.0, 0.15), IN_CONTACT, none),
            // Past the end, the circle is behind until it does not overlap.
            ((1.05, -0.02), Memory::BEHIND, Memory::BEHIND),
            ((1.05, -0.02), none, none),
            ((1.2, -0.02), Memory::BEHIND, none),
        ] {
            assert_eq!(apart(&open, place, 0, before), expected, "{place:?}");
        }
        // Each side has its own: behind the floor of the corner, and in front of its wall.
        assert_eq!(apart(&corner, (0.5, -0.05), 0, none), Memory::BEHIND);
        assert_eq!(apart(&corner, (0.5, -0.05), 1, none), none);
        let square = outline(&[(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)], true);
        let closed = model(vec![contact(square, RADIUS)]);
        assert_eq!(apart(&closed, (0.0, 0.0), 0, none), none);
    }

    #[test]
    fn a_bore_has_its_clearance_a_clockwise_outline_is_a_hole_and_a_memory_at_the_minimum_is_slow()
    {
        let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let mut hole = square;
        hole.reverse();
        for (profile, play, is_hole, pieces) in [
            (Profile::Bore { radius: 0.13 }, 0.03, false, 1),
            (Profile::Disc { radius: 0.13 }, 0.025, false, 1),
            (outline(&square, true), 0.025, false, 4),
            (outline(&hole, true), 0.025, true, 4),
            (floor(), 0.025, false, 1),
        ] {
            let mut pair = contact(profile, RADIUS);
            pair.law = hertz();
            let model = model(vec![pair]);
            let contact = only(&model);
            assert!((contact.play() - play).abs() < 1e-15);
            assert_eq!((contact.is_hole(), contact.pieces()), (is_hole, pieces));
            for (rate, speed, slow) in [(0.3, 0.3, false), (0.01, 0.01, true), (0.001, 0.01, true)]
            {
                let memory = contact.remember(pieces - 1, rate);
                let expected = Memory {
                    speed,
                    piece: pieces - 1,
                    in_front: false,
                };
                assert_eq!((memory, contact.is_at_floor(memory)), (expected, slow));
            }
        }
        // A disc is near up to the sum of the radii, 0.23 m.
        let model = model(vec![contact(Profile::Disc { radius: 0.13 }, RADIUS)]);
        assert!((only(&model).reach - 0.23).abs() < 1e-15);
        let apart = only(&model).apart_squared(&at((0.3, 0.4), (0.0, 0.0)));
        assert!((apart - 0.25).abs() < 1e-15);
    }
}

//! Two bodies with contacts between them, for the unit tests of this folder.

use super::compiled_contact::CompiledContact;
use super::contact_states::ContactStates;
use crate::force_law::LuGre;
use crate::geometry::Vec2;
use crate::multibody::Mechanism;
use crate::multibody::description::body::{Body, Frame, Marker};
use crate::multibody::description::contact_law::ContactLaw;
use crate::multibody::description::contact_pair::ContactPair;
use crate::multibody::description::profile::Profile;
use crate::multibody::description::tribology::{FrictionLaw, Tribology};
use crate::multibody::forces::loads::BodyLoads;
use crate::multibody::model::MechanismModel;

/// Number of the body with the profiles, behind the ground.
pub(super) const BLOCK: usize = 1;

/// Number of the body with the circles.
pub(super) const BALL: usize = 2;

/// Return a linear law without damping, of 1 kN/m.
pub(super) fn spring() -> ContactLaw {
    ContactLaw::Linear {
        stiffness: 1e3,
        damping: 0.0,
    }
}

/// Return the contact of a circle around the centre of the ball with a profile around that of the block.
pub(super) fn contact(profile: Profile, radius: f64) -> ContactPair {
    ContactPair {
        name: "contact".into(),
        a: Marker::new("block", 0.0, 0.0),
        b: Marker::new("ball", 0.0, 0.0),
        profile,
        radius,
        law: spring(),
        tribology: Tribology::default(),
    }
}

/// Return the contact of a circle of 0.1 m with the floor, with bristles.
pub(super) fn bristled(name: &str) -> ContactPair {
    let mut pair = contact(floor(), 0.1);
    pair.name = name.into();
    pair.tribology.friction = Some(FrictionLaw::LuGre(LuGre {
        static_coefficient: 0.4,
        kinetic_coefficient: 0.3,
        stiffness: 1e3,
        damping: 0.0,
        viscous_coefficient: 0.0,
        stribeck_speed: 0.1,
        stribeck_exponent: 2.0,
    }));
    pair
}

/// Return the outline of straight lines through `points` \[m\].
pub(super) fn outline(points: &[(f64, f64)], closed: bool) -> Profile {
    let points: Vec<Vec2> = points.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
    Profile::polyline("outline", &points, closed).unwrap()
}

/// Return the level line through the origin, from x = 1 m to -1 m. The material is below it, and it has a back.
pub(super) fn floor() -> Profile {
    outline(&[(1.0, 0.0), (-1.0, 0.0)], false)
}

/// Return the description of both bodies with `contacts`. Each has a mass of 2 kg and a moment of inertia of 3 kg m².
pub(super) fn mechanism(contacts: Vec<ContactPair>) -> Mechanism {
    Mechanism {
        bodies: vec![Body::new("block", 2.0, 3.0), Body::new("ball", 2.0, 3.0)],
        contacts,
        ..Mechanism::default()
    }
}

/// Return the model of both bodies with `contacts`.
pub(super) fn model(contacts: Vec<ContactPair>) -> MechanismModel {
    MechanismModel::compile(&mechanism(contacts)).unwrap()
}

/// Return the only contact of a model.
pub(super) fn only(model: &MechanismModel) -> &CompiledContact {
    assert_eq!(model.contacts.len(), 1);
    &model.contacts[0]
}

/// Motion of a body with constant accelerations: position \[m, m, rad\], velocity and acceleration.
pub(super) type Course = [[f64; 3]; 3];

/// Return the frame of a body at the time `t` \[s\] of its course.
pub(super) fn frame([position, velocity, acceleration]: &Course, t: f64) -> Frame {
    Frame::new(
        [0, 1, 2].map(|i| position[i] + t * velocity[i] + 0.5 * t * t * acceleration[i]),
        [0, 1, 2].map(|i| velocity[i] + t * acceleration[i]),
    )
}

/// Return the frames of ground, block and ball at the time `t` \[s\].
pub(super) fn frames(block: &Course, ball: &Course, t: f64) -> Vec<Frame> {
    let ground = Frame::new([0.0; 3], [0.0; 3]);
    vec![ground, frame(block, t), frame(ball, t)]
}

/// Return a body at rest at the origin.
pub(super) fn at_rest() -> Course {
    [[0.0; 3]; 3]
}

/// Return the accelerations of block and ball as one vector, as the equations of motion have them.
pub(super) fn accelerations(block: &Course, ball: &Course) -> Vec<f64> {
    [block[2], ball[2]].concat()
}

/// Evaluate all contacts and return their loads.
pub(super) fn evaluated(
    model: &MechanismModel,
    states: &mut ContactStates,
    frames: &[Frame],
) -> BodyLoads {
    let mut loads = BodyLoads::new(frames.len(), model.coordinates());
    states.add_loads(model, frames, &mut loads);
    loads
}

/// Return the power of the loads on all bodies \[W\].
pub(super) fn power(loads: &BodyLoads, frames: &[Frame]) -> f64 {
    let of_body = |(load, frame): (&[f64; 3], &Frame)| {
        load[0] * frame.velocity.x + load[1] * frame.velocity.y + load[2] * frame.spin
    };
    loads.on.iter().zip(frames).map(of_body).sum()
}

/// Return the distance of a point from a polyline \[m\].
pub(super) fn distance_to(points: &[(f64, f64)], point: Vec2) -> f64 {
    let ends = points.windows(2).map(|pair| {
        let [from, to] = [pair[0], pair[1]].map(|(x, y)| Vec2::new(x, y));
        let along = to - from;
        let part = ((point - from).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
        (point - from - part * along).norm()
    });
    ends.fold(f64::INFINITY, f64::min)
}

//! Friction on the sides of a contact, from the resultant normal force of each side.
//!
//! The normal force of a side on the circle is N n, n pointing from the profile to the centre: the sum of w f n over the side's contact
//! points with weights w, without the forces -E ∇w between two sides. These cancel over both, and would have friction of their own. In a
//! concave polyline N may be negative: a side then takes back a part of what its neighbours have too much. The contact point is -r n from the
//! circle's centre. The sliding velocity along t, left of n, is s = t·v - r ω. Here v and ω are the velocity of the centre and the
//! angular velocity of b relative to a. The friction force φ = N h(s) acts on both bodies at the contact point. On b, about the
//! centre, it is a force -φ t and a torque r φ. Chain drives have the same equations over vectors (`chain/rhs/chain/losses.rs`).

use nalgebra::Matrix2;

use super::bristles::{BristleDeflection, ContactBristles};
use super::compiled_contact::CompiledContact;
use super::impact_memory::SideState;
use crate::force_law::LuGre;
use crate::geometry::{Vec2, turned_left};
use crate::multibody::constraints::relative_kinematics::{PairForce, PairTorque};
use crate::multibody::description::body::Frame;
use crate::multibody::description::tribology::FrictionLaw;
use crate::multibody::forces::loads::BodyLoads;

/// Normal force and sliding velocity of one side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sliding {
    /// N \[N\].
    normal_force: f64,
    /// n.
    normal: Vec2,
    /// t.
    tangent: Vec2,
    /// v \[m/s\].
    velocity: Vec2,
    /// s \[m/s\].
    slip: f64,
}

/// Ratio of friction force to normal force, and its slope.
#[derive(Debug, Clone, Copy)]
struct Share {
    /// h.
    value: f64,
    /// dh/ds \[s/m\].
    slope: f64,
    /// Deflection of the bristle \[m\] and its rate \[m/s\]; zero without one.
    deflection: f64,
    rate: f64,
}

/// Return h(s) of a friction law.
fn share(law: &FrictionLaw, slip: f64, bent: Option<BristleDeflection>) -> Share {
    match (law, bent) {
        (FrictionLaw::Coulomb(law), _) => {
            let (value, slope) = law.share(slip);
            Share {
                value: law.coefficient * value,
                slope: law.coefficient * slope,
                deflection: 0.0,
                rate: 0.0,
            }
        }
        (FrictionLaw::LuGre(law), bent) => {
            bristled(law, slip, bent.unwrap_or(BristleDeflection::Given(0.0)))
        }
    }
}

fn bristled(law: &LuGre, slip: f64, bent: BristleDeflection) -> Share {
    let (deflection, slope) = match bent {
        BristleDeflection::Given(deflection) => (deflection, 0.0),
        BristleDeflection::Ahead(predicted, gamma) => law.solve(predicted, gamma, slip),
    };
    let found = law.bent(deflection, slip);
    Share {
        value: found.share,
        slope,
        deflection,
        rate: found.rate,
    }
}

impl CompiledContact {
    /// Return normal, tangent and sliding velocity of a side with the normal force `pressing` on the circle, which is not zero. `inward` is
    /// the normal into the material.
    fn sliding(&self, pressing: Vec2, inward: Vec2, (fa, fb): (&Frame, &Frame)) -> Sliding {
        // A side without a contact point of its own, whose `inward` is zero, takes back a part of what others have too much.
        let pulls = pressing.dot(&inward) >= 0.0;
        let normal_force = if pulls {
            -pressing.norm()
        } else {
            pressing.norm()
        };
        let normal = pressing / normal_force;
        let tangent = turned_left(normal);
        let velocity = self.approach(fa, fb);
        Sliding {
            normal_force,
            normal,
            tangent,
            velocity,
            slip: tangent.dot(&velocity) - self.radius * (fb.spin - fa.spin),
        }
    }

    /// Add the friction of all sides with a normal force; the normal forces must be evaluated before.
    pub(crate) fn add_friction(
        &self,
        law: &FrictionLaw,
        frames: &[Frame],
        numbers: &[Option<usize>],
        bristles: &mut ContactBristles,
        (loads, side_states): (&mut BodyLoads, &mut [SideState]),
    ) {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        for (side_state, number) in side_states.iter_mut().zip(numbers) {
            if side_state.pressing == Vec2::zeros() {
                continue;
            }
            let inward = side_state.contact.normal;
            let at = self.sliding(side_state.pressing, inward, (fa, fb));
            let share = share(law, at.slip, number.map(|i| bristles.bent(i)));
            let friction = at.normal_force * share.value;
            let force = -friction * at.tangent;
            side_state.friction += force;
            self.add_wrench(frames, force, self.radius * friction, loads);
            loads.dissipated += friction * at.slip;
            if let (FrictionLaw::LuGre(law), Some(i)) = (law, *number) {
                (bristles.deflection[i], bristles.rate[i]) = (share.deflection, share.rate);
                loads.bristles += at.normal_force * law.stored(share.deflection);
            }
        }
    }

    /// Add a force on b at the circle's centre and a torque on b, with the opposite force and torque on a.
    pub(crate) fn add_wrench(
        &self,
        frames: &[Frame],
        force: Vec2,
        torque: f64,
        loads: &mut BodyLoads,
    ) {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let center = fb.place(self.b.point);
        loads.push(self.b.body, fb, center, force);
        loads.push(self.a.body, fa, center, -force);
        loads.twist(self.b.body, torque);
        loads.twist(self.a.body, -torque);
    }

    /// Return friction force and torque of a side with their slopes, from the normal force `pressing` and its slopes; `inward` is the normal
    /// into the material.
    pub(crate) fn friction_slopes(
        &self,
        law: &FrictionLaw,
        frames: &[Frame],
        (pressing, inward): (&PairForce, Vec2),
        bent: Option<BristleDeflection>,
    ) -> (PairForce, PairTorque) {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let at = self.sliding(pressing.force, inward, (fa, fb));
        let (n, t) = (at.normal, at.tangent);
        let share = share(law, at.slip, bent);
        let friction = at.normal_force * share.value;
        let slope = at.normal_force * share.slope;
        // The normal rotates by dθ = t·dP/N, P being the normal force vector, and the sliding velocity changes by -n·v dθ.
        let rows = |by: &Matrix2<f64>| {
            let turning = by.tr_mul(&t) / at.normal_force;
            let slip = -n.dot(&at.velocity) * turning;
            (turning, share.value * by.tr_mul(&n) + slope * slip)
        };
        let (turning_by_place, by_place) = rows(&pressing.by_place);
        let (turning_by_velocity, by_velocity) = rows(&pressing.by_velocity);
        // Derivatives of s = t·v - r ω at a constant normal: ∂s/∂v = t, ∂s/∂ω = -r.
        let by_velocity = by_velocity + slope * t;
        let by_spin = -slope * self.radius;
        // d(-φ t) = -t dφ + φ n dθ.
        let force = PairForce {
            force: -friction * t,
            by_place: friction * n * turning_by_place.transpose() - t * by_place.transpose(),
            by_velocity: friction * n * turning_by_velocity.transpose()
                - t * by_velocity.transpose(),
        };
        let torque = PairTorque {
            force_by_spin: -by_spin * t,
            by_place: self.radius * by_place,
            by_velocity: self.radius * by_velocity,
            by_spin: self.radius * by_spin,
        };
        (force, torque)
    }
}

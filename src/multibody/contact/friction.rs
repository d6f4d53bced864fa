//! Friction of the sides of a contact, by the resultant normal force of each side.
//!
//! Of a side that pushes the circle by N n, n from the profile to the centre, the bodies touch at the circle's point -r n. There
//! the circle slides along t, left of n, by s = t·v - r ω, v and ω being velocity of the centre and angular velocity of b as seen
//! from a. Both bodies feel the friction φ = N h(s) at that point: on b about the centre a force -φ t and a torque r φ.

use nalgebra::Matrix2;

use super::bristles::{Bent, Bristles};
use super::contact_state::CompiledContact;
use super::impact_memory::Touch;
use crate::force_law::LuGre;
use crate::geometry::{Vec2, turned_left};
use crate::multibody::constraints::relative_kinematics::{PairForce, PairTorque};
use crate::multibody::description::body::Frame;
use crate::multibody::description::tribology::FrictionLaw;
use crate::multibody::forces::loads::Loads;

/// How one side slides.
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

/// Friction over normal force.
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

/// h(s) by a law.
fn share(law: &FrictionLaw, slip: f64, bent: Option<Bent>) -> Share {
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
        (FrictionLaw::LuGre(law), bent) => bristled(law, slip, bent.unwrap_or(Bent::Given(0.0))),
    }
}

fn bristled(law: &LuGre, slip: f64, bent: Bent) -> Share {
    let (deflection, slope) = match bent {
        Bent::Given(deflection) => (deflection, 0.0),
        Bent::Ahead(foretold, gamma) => law.solve(foretold, gamma, slip),
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
    /// How a side slides that pushes the circle by `push`, which is not zero.
    fn sliding(&self, push: Vec2, fa: &Frame, fb: &Frame) -> Sliding {
        let normal_force = push.norm();
        let normal = push / normal_force;
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

    /// Adds the friction of all sides that push, after their normal forces.
    pub(crate) fn add_friction(
        &self,
        law: &FrictionLaw,
        frames: &[Frame],
        numbers: &[Option<usize>],
        bristles: &mut Bristles,
        (loads, touches): (&mut Loads, &mut [Touch]),
    ) {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        for (touch, number) in touches.iter_mut().zip(numbers) {
            if touch.push == Vec2::zeros() {
                continue;
            }
            let at = self.sliding(touch.push, fa, fb);
            let share = share(law, at.slip, number.map(|i| bristles.bent(i)));
            let friction = at.normal_force * share.value;
            let force = -friction * at.tangent;
            touch.friction += force;
            self.add_wrench(frames, force, self.radius * friction, loads);
            loads.dissipated += friction * at.slip;
            if let (FrictionLaw::LuGre(law), Some(i)) = (law, *number) {
                (bristles.deflection[i], bristles.rate[i]) = (share.deflection, share.rate);
                loads.bristles += at.normal_force * law.stored(share.deflection);
            }
        }
    }

    /// Adds a force on b at the circle's centre and a torque on b, and both turned round on a.
    pub(crate) fn add_wrench(&self, frames: &[Frame], force: Vec2, torque: f64, loads: &mut Loads) {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let center = fb.place(self.b.point);
        loads.push(self.b.body, fb, center, force);
        loads.push(self.a.body, fa, center, -force);
        loads.twist(self.b.body, torque);
        loads.twist(self.a.body, -torque);
    }

    /// How the friction of a side changes whose normal force is `push` with its slopes.
    pub(crate) fn friction_slopes(
        &self,
        law: &FrictionLaw,
        frames: &[Frame],
        push: &PairForce,
        bent: Option<Bent>,
    ) -> (PairForce, PairTorque) {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let at = self.sliding(push.force, fa, fb);
        let (n, t) = (at.normal, at.tangent);
        let share = share(law, at.slip, bent);
        let friction = at.normal_force * share.value;
        let slope = at.normal_force * share.slope;
        // The normal turns by t·dP/N; with it the sliding velocity changes by -n·v of that.
        let rows = |by: &Matrix2<f64>| {
            let turning = by.tr_mul(&t) / at.normal_force;
            let slip = -n.dot(&at.velocity) * turning;
            (turning, share.value * by.tr_mul(&n) + slope * slip)
        };
        let (turning_by_place, by_place) = rows(&push.by_place);
        let (turning_by_velocity, by_velocity) = rows(&push.by_velocity);
        let by_velocity = by_velocity + slope * t;
        let by_spin = -slope * self.radius;
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

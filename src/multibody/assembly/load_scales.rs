//! Springs, dampers, forces, drivers and contact lengths whose sizes do not go with the mechanism, as after a change of units by
//! 1000.
//!
//! Each number is held against what the mechanism itself gives: weights, its size, the critical damping of a spring, the other
//! forces, the speed of sound. What these leave open by more than a factor of 1000 is not told (see `docs/mechanisms.md`).

use super::scales::factor;
use crate::multibody::description::contact_law::ContactLaw;
use crate::multibody::description::driver::Motion;
use crate::multibody::description::force_element::{Force, ForceKind};
use crate::multibody::description::joint::JointKind;
use crate::multibody::description::spring_law::SpringLaw;
use crate::multibody::description::time_function::TimeFunction;
use crate::multibody::model::MechanismModel;

/// Part of the weights that a spring bears when it is stretched by the size of the mechanism.
const WEAK: f64 = 0.03;
/// The same of one that no part of a machine is as stiff as.
const RIGID: f64 = 1e8;
/// Damping over the critical one.
const DAMPING: [f64; 2] = [1e-4, 30.0];
/// Length without force over the length as placed, and over the size.
const REST: [f64; 2] = [0.01, 100.0];
/// A force over the largest of the weights and the other forces; a large one over springs and the inertia forces of drivers, too.
const FORCE: [f64; 2] = [1e-3, 300.0];
/// Fastest that a rim moves \[m/s\]: the speed of sound in air.
const RIM: f64 = 343.0;
/// Way of a driver over the size.
const WAY: f64 = 100.0;
/// Length of a contact over the radius of its circle.
const LENGTH: [f64; 2] = [3e-3, 300.0];

/// All loads and lengths that seem to be in another unit than the rest; `size` is that of the mechanism \[m\], `sound` tells of
/// which contacts the radii are none of it.
pub(crate) fn odd_loads(
    model: &MechanismModel,
    size: f64,
    sound: impl Fn(usize) -> bool,
) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    let places = model.start_frames();
    for (force, name) in model.forces.iter().zip(&model.force_names) {
        found.extend(match &force.kind {
            ForceKind::Spring { law, .. } => {
                let length = (places[force.b.body].place(force.b.point)
                    - places[force.a.body].place(force.a.point))
                .norm();
                odd_rest(name, force.rest, length, size)
                    .or_else(|| odd_spring(model, name, law, force, size))
            }
            ForceKind::TorsionSpring { law, .. } => odd_spring(model, name, law, force, size),
            _ => odd_force(model, name, force, size),
        });
    }
    for joint in &model.joints {
        found.extend(odd_driver(model, joint, size));
    }
    let lengths = model.contact_lengths.iter().enumerate();
    found.extend(lengths.filter_map(|(k, &length)| {
        let (name, radius) = (&model.contact_names[k], model.contacts[k].radius);
        let ratio = length? / radius;
        (outside(ratio, LENGTH) && sound(k)).then(|| {
            let length = ratio * radius;
            format!(
                "length of contact {name:?} is {length:.4e} m along a circle of radius {radius:.4e} m: {}",
                factor(ratio)
            )
        })
    }));
    found
}

fn outside(ratio: f64, [low, high]: [f64; 2]) -> bool {
    ratio > high || ratio < low && ratio > 0.0
}

/// Weight of the bodies that can move \[N\].
fn weight(model: &MechanismModel) -> f64 {
    let masses = model.bodies.iter().filter(|body| !body.fixed);
    masses.map(|body| body.mass).sum::<f64>() * model.gravity.norm()
}

/// A length without force that is far from the length as placed.
fn odd_rest(name: &str, rest: f64, length: f64, size: f64) -> Option<String> {
    let beside = length.max(size);
    let ratio = rest / if rest > beside { beside } else { length };
    (length > 0.0 && outside(ratio, REST)).then(|| {
        format!(
            "rest_length of spring {name:?} is {rest:.4e} m, its length as placed {length:.4e} m: {}",
            factor(ratio)
        )
    })
}

/// What a spring moves: mass \[kg\] or inertia \[kg m²\] of the lighter of its bodies that can move.
fn moved(model: &MechanismModel, force: &Force, turning: bool) -> f64 {
    let ends = [force.a.body, force.b.body].map(|i| &model.bodies[i]);
    let values = ends.iter().filter(|body| !body.fixed);
    let values = values.map(|body| if turning { body.inertia } else { body.mass });
    values.filter(|&v| v > 0.0).fold(f64::INFINITY, f64::min)
}

/// A stiffness or a damping that does not go with the masses, the weights and the size.
fn odd_spring(
    model: &MechanismModel,
    name: &str,
    law: &SpringLaw,
    force: &Force,
    size: f64,
) -> Option<String> {
    if law.table.is_some() || law.cubic != 0.0 {
        return None;
    }
    let turning = matches!(force.kind, ForceKind::TorsionSpring { .. });
    let units = if turning {
        ["N m/rad", "N m s/rad"]
    } else {
        ["N/m", "N s/m"]
    };
    let k = law.stiffness;
    if k < 0.0 {
        return Some(format!(
            "stiffness of spring {name:?} is {k:.4e} {}: it drives away from its rest; is the sign right?",
            units[0]
        ));
    }
    // Of a turn by 1 rad, of a stretch by the size.
    let (bears, turned) = (
        weight(model) * size,
        if turning { k } else { k * size * size },
    );
    let stretch = if turning {
        "turned by 1 rad"
    } else {
        "stretched by the size of the mechanism"
    };
    let ratio = turned / bears;
    if k > 0.0 && bears > 0.0 && outside(ratio, [WEAK, RIGID]) {
        return Some(format!(
            "stiffness of spring {name:?} is {k:.4e} {}: {stretch}, {size:.1e} m, it bears {ratio:.1e} of the weights: {}",
            units[0],
            factor(ratio)
        ));
    }
    let critical = 2.0 * (k * moved(model, force, turning)).sqrt();
    let ratio = law.damping / critical;
    (critical > 0.0 && critical.is_finite() && outside(ratio, DAMPING)).then(|| {
        format!(
            "damping of spring {name:?} is {:.4e} {}, {ratio:.1e} of the critical damping of {critical:.1e} {}: {} \
             (or its stiffness, of {k:.4e} {}, by the square of that?)",
            law.damping,
            units[1],
            units[1],
            factor(ratio),
            units[0]
        )
    })
}

/// Largest value that a function of time has, where that is known.
fn largest(function: &TimeFunction) -> f64 {
    match function {
        TimeFunction::Constant(value) => value.abs(),
        TimeFunction::SmoothStep { from, to, .. } => from.abs().max(to.abs()),
        TimeFunction::Table(curve) => curve.largest(),
        TimeFunction::Spline(_) => f64::NAN,
        TimeFunction::Sines { offset, terms } => {
            offset.abs() + terms.iter().map(|term| term[0].abs()).sum::<f64>()
        }
    }
}

/// Largest force of an element \[N\], a torque at the size of the mechanism; NaN for springs and callables.
fn force_of(force: &Force, size: f64) -> f64 {
    match &force.kind {
        ForceKind::Force { x, y, .. } => largest(x).hypot(largest(y)),
        ForceKind::Torque(torque) => largest(torque) / size,
        ForceKind::TorqueBySpeed(curve) => curve.largest() / size,
        _ => f64::NAN,
    }
}

/// A force that is very large or small beside all that the mechanism has to set against it.
fn odd_force(model: &MechanismModel, name: &str, force: &Force, size: f64) -> Option<String> {
    let own = force_of(force, size);
    let springs = model.forces.iter().map(|other| match &other.kind {
        // Of a stretch by a tenth of the size, or of a turn by a tenth.
        ForceKind::Spring { law, .. } => 0.1 * size * law.stiffness.abs() + law.largest(),
        ForceKind::TorsionSpring { law, .. } => (0.1 * law.stiffness.abs() + law.largest()) / size,
        _ => 0.0,
    });
    let others = model
        .forces
        .iter()
        .filter(|other| !std::ptr::eq(*other, force));
    let others = others.map(|other| force_of(other, size));
    // A force may be as small as it likes beside a stiff bush, and beside what makes masses go round, which needs no torque.
    let least = others
        .filter(|value| value.is_finite())
        .fold(weight(model), f64::max);
    let most = springs
        .filter(|value| value.is_finite())
        .fold(least.max(inertia_force(model, size)), f64::max);
    let beside = if own < FORCE[0] * least {
        least
    } else if own > FORCE[1] * most {
        most
    } else {
        return None;
    };
    let ratio = own / beside;
    (beside > 0.0 && ratio.is_finite()).then(|| {
        let (kind, unit, per) = match force.kind {
            ForceKind::Force { .. } => ("force", "N", 1.0),
            _ => ("torque", "N m", size),
        };
        format!(
            "{kind} {name:?} is up to {:.4e} {unit}, beside weights, springs, inertia and other forces of about {:.1e} \
             {unit}: {}",
            own * per,
            beside * per,
            factor(ratio)
        )
    })
}

/// Force that turns the masses with the fastest driver, m ω² r \[N\].
fn inertia_force(model: &MechanismModel, size: f64) -> f64 {
    let mass: f64 = model
        .bodies
        .iter()
        .filter(|b| !b.fixed)
        .map(|b| b.mass)
        .sum();
    let speeds = model.joints.iter().map(|joint| match &joint.kind {
        JointKind::DrivenAngle(Motion::Speed(function)) => largest(function),
        _ => 0.0,
    });
    let given = model.bodies.iter().map(|body| body.velocity[2].abs());
    let fastest = speeds
        .chain(given)
        .filter(|w| w.is_finite())
        .fold(0.0, f64::max);
    mass * fastest * fastest * size
}

/// A driver whose speed no machine has, or whose way is far beyond its mechanism.
fn odd_driver(
    model: &MechanismModel,
    joint: &crate::multibody::description::joint::Joint,
    size: f64,
) -> Option<String> {
    let name = &joint.name;
    match &joint.kind {
        JointKind::DrivenAngle(Motion::Speed(function)) => {
            let speed = largest(function);
            let arm = arm(model, &joint.b.body).max(arm(model, &joint.a.body));
            let rim = speed * arm;
            (rim > RIM).then(|| {
                format!(
                    "speed of driver {name:?} is up to {speed:.4e} rad/s: points {arm:.1e} m from the centre of mass \
                     move at {rim:.1e} m/s, faster than sound: is it 1000 times too large, in another unit?"
                )
            })
        }
        JointKind::DrivenPosition { motion, .. } => {
            let (Motion::Position(function) | Motion::Speed(function)) = motion;
            let value = largest(function);
            let is_speed = matches!(motion, Motion::Speed(_));
            let (limit, unit) = if is_speed {
                (RIM, "m/s")
            } else {
                (WAY * size, "m")
            };
            (limit > 0.0 && value > limit).then(|| {
                let field = if is_speed { "speed" } else { "position" };
                format!(
                    "{field} of driver {name:?} is up to {value:.4e} {unit} in a mechanism of {size:.1e} m: is it 1000 \
                     times too large, in another unit?"
                )
            })
        }
        _ => None,
    }
}

/// Farthest point of a body from its centre of mass, its radius of gyration at least \[m\].
fn arm(model: &MechanismModel, name: &str) -> f64 {
    let Some(i) = model.bodies.iter().position(|b| b.name == name && !b.fixed) else {
        return 0.0;
    };
    let gyration = (model.bodies[i].inertia / model.bodies[i].mass).sqrt();
    let joints = model.equations.iter().flat_map(|e| [e.a, e.b]);
    let contacts = model.contacts.iter().flat_map(|c| [c.a, c.b]);
    let ends = joints.chain(contacts).filter(|end| end.body == i);
    let far = ends.map(|end| end.point.norm()).fold(0.0, f64::max);
    far.max(if gyration.is_finite() { gyration } else { 0.0 })
}

/// Length of each contact whose law has one.
pub(crate) fn contact_lengths(mechanism: &crate::multibody::Mechanism) -> Vec<Option<f64>> {
    let length = |contact: &crate::multibody::ContactPair| match contact.law {
        ContactLaw::Surfaces { length, .. } => Some(length),
        _ => None,
    };
    mechanism.contacts.iter().map(length).collect()
}

//! Tensioner of a drive as parts of a mechanism: slide or arm, pull, spring, damper and stops.

use std::f64::consts::TAU;

use super::sprocket_name;
use crate::drive::{Drive, STOP_STIFFNESS, Tensioner, TensionerLine};
use crate::error::Result;
use crate::geometry::{Vec2, turned_left, unit};
use crate::math::{Signal, Table};
use crate::multibody::{
    Body, ForceElement, ForceKind, GROUND, Joint, JointKind, Marker, Mechanism, SpringLaw,
};

/// Mass of an arm over that of its sprocket.
///
/// The arm of a drive has inertia alone, but a body needs mass. The arm becomes a bar of length L with this share `m_a` of the
/// sprocket's mass. The sprocket's mass is reduced by `m_a` / 2, and the arm's inertia about its centre is increased by `m_a` L² / 4.
///
/// The moment of the weight and the inertia about the pivot then remain exactly as described, for any share below 2. The pivot bears
/// the other half of the arm's weight.
const ARM_SHARE: f64 = 0.1;

/// Distance from the start of a slide back to the anchor of its spring, and length of a stop's segment in its force table \[m\].
const ROOM: f64 = 1.0;

/// Return the part of its mass that sprocket `number` (from 0) keeps beside an arm.
pub(super) fn share_beside_arm(drive: &Drive, number: usize) -> f64 {
    let arm = drive
        .tensioner
        .filter(|t| t.sprocket == number + 1 && t.pivot.is_some());
    if arm.is_some() {
        1.0 - 0.5 * ARM_SHARE
    } else {
        1.0
    }
}

/// Arm that carries a sprocket and rotates about `pivot`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TensionerArm {
    pub(super) pivot: Vec2,
    length: f64,
    /// Angle as described \[rad\].
    angle: f64,
}

impl TensionerArm {
    /// Return the arm of the drive's tensioner, if it has one.
    pub(super) fn of(drive: &Drive) -> Option<Self> {
        let tensioner = drive.tensioner.as_ref()?;
        let pivot = tensioner.pivot?;
        let along = drive.sprockets[tensioner.sprocket - 1].center - pivot;
        Some(Self {
            pivot,
            length: along.norm(),
            angle: along.y.atan2(along.x),
        })
    }

    /// Return 1 where the pull rotates the arm counterclockwise, as a positive torque does, and -1 elsewhere.
    fn sense(&self, line: &TensionerLine) -> f64 {
        line.direction.dot(&turned_left(unit(self.angle))).signum()
    }

    /// Return position and velocity of the arm's body with the sprocket at `center`. Its centre of mass is its midpoint, and its
    /// angle is within half a turn of that described.
    pub(super) fn placed(&self, center: Vec2, velocity: Vec2) -> [[f64; 3]; 2] {
        let along = center - self.pivot;
        let spin = along.perp(&velocity) / along.norm_squared();
        let turned = along.y.atan2(along.x) - self.angle;
        let angle = self.angle + turned - TAU * (turned / TAU).round();
        let middle = self.pivot + 0.5 * along;
        [
            [middle.x, middle.y, angle],
            [0.5 * velocity.x, 0.5 * velocity.y, spin],
        ]
    }
}

/// Force of a tensioner on its sprocket, as a load of its mechanism.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum PullLoad {
    /// Components on the slide \[N\].
    Force(f64, f64),
    /// Torque on the arm \[N m\], counterclockwise.
    Torque(f64),
}

/// Direction of the pull of a tensioner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Pull {
    /// Unit vector along the slide.
    Slide(Vec2),
    /// Torque on the arm over the force \[m\].
    Arm(f64),
}

impl Pull {
    /// Return the pull of the tensioner of `drive`.
    pub(super) fn of(drive: &Drive, line: &TensionerLine) -> Self {
        TensionerArm::of(drive).map_or(Self::Slide(line.direction), |arm| {
            Self::Arm(arm.sense(line) * arm.length)
        })
    }

    /// Return the load of `force` \[N\].
    pub(super) fn load(self, force: f64) -> PullLoad {
        match self {
            Self::Slide(along) => PullLoad::Force(force * along.x, force * along.y),
            Self::Arm(lever) => PullLoad::Torque(lever * force),
        }
    }

    /// Return the kind of a force element with this load, which grows within `time` \[s\].
    fn kind(self, force: f64, time: f64) -> Result<ForceKind> {
        Ok(match self.load(force) {
            PullLoad::Force(x, y) => ForceKind::Force {
                x: Signal::growing(x, time)?,
                y: Signal::growing(y, time)?,
                follows: false,
            },
            PullLoad::Torque(torque) => ForceKind::Torque(Signal::growing(torque, time)?),
        })
    }
}

impl Mechanism {
    /// Add the tensioner of `drive`, whose sprocket is at `center`.
    pub(super) fn add_tensioner(
        &mut self,
        drive: &Drive,
        tensioner: &Tensioner,
        center: Vec2,
        velocity: Vec2,
    ) -> Result<()> {
        let line = tensioner.line(drive)?;
        match TensionerArm::of(drive) {
            None => self.add_slide(drive, tensioner, &line, center),
            Some(arm) => self.add_arm(drive, tensioner, (&arm, &line), center, velocity),
        }
    }

    /// Add a slide along the pull, with a spring from a point behind the sprocket.
    fn add_slide(
        &mut self,
        drive: &Drive,
        tensioner: &Tensioner,
        line: &TensionerLine,
        center: Vec2,
    ) -> Result<()> {
        let number = tensioner.sprocket;
        let wheel = Marker::new(sprocket_name(number - 1), 0.0, 0.0);
        let kind = JointKind::PointOnLine {
            direction: line.direction,
        };
        let origin = Marker::new(GROUND, center.x, center.y);
        let name = format!("slide_{number}");
        self.joints
            .push(Joint::new(name, origin, wheel.clone(), kind));
        let pull = Pull::of(drive, line).kind(line.pull, tensioner.ramp_time)?;
        let nowhere = Marker::new(GROUND, 0.0, 0.0);
        let name = format!("tensioner_{number}");
        self.forces
            .push(ForceElement::new(name, nowhere, wheel.clone(), pull));
        // The displacement is measured from the sprocket's centre as described, not from its initial position.
        let described = drive.sprockets[number - 1].center;
        let moved = (center - described).dot(&line.direction);
        let [back, _] = tensioner.travel;
        let room = moved + ROOM + if back.is_finite() { back } else { 0.0 };
        let behind = center - room * line.direction;
        let behind = Marker::new(GROUND, behind.x, behind.y);
        for (name, law) in springs(tensioner, 1.0, 1.0)? {
            let rest = Some(room - moved);
            let kind = ForceKind::Spring { law, rest };
            let name = format!("{name}_{number}");
            let spring = ForceElement::new(name, behind.clone(), wheel.clone(), kind);
            self.forces.push(spring);
        }
        Ok(())
    }

    /// Add an arm as a body on a pivot; its torques are forces times the arm's length.
    fn add_arm(
        &mut self,
        drive: &Drive,
        tensioner: &Tensioner,
        (arm, line): (&TensionerArm, &TensionerLine),
        center: Vec2,
        velocity: Vec2,
    ) -> Result<()> {
        let number = tensioner.sprocket;
        let name = format!("arm_{number}");
        let (whole, _) = drive.sprockets[number - 1].mass_properties(&drive.chain);
        let mass = ARM_SHARE * whole;
        let inertia = tensioner.arm_inertia + 0.25 * mass * arm.length.powi(2);
        let [position, moving] = arm.placed(center, velocity);
        self.bodies.push(Body {
            position,
            velocity: moving,
            ..Body::new(name.clone(), mass, inertia)
        });
        self.add_revolute(format!("pivot_{number}"), GROUND, &name, arm.pivot);
        let wheel = sprocket_name(number - 1);
        self.add_revolute(format!("bearing_{number}"), &name, &wheel, center);
        let [ground, body] = [GROUND, &name].map(|body| Marker::new(body, 0.0, 0.0));
        let mut add = |name: &str, kind: ForceKind| {
            let name = format!("{name}_{number}");
            self.forces
                .push(ForceElement::new(name, ground.clone(), body.clone(), kind));
        };
        let pull = Pull::of(drive, line).kind(line.pull, tensioner.ramp_time)?;
        add("tensioner", pull);
        for (name, law) in springs(tensioner, arm.length, arm.sense(line))? {
            let rest = Some(arm.angle);
            add(name, ForceKind::TorsionSpring { law, rest });
        }
        Ok(())
    }
}

/// Return the spring with damper and the stops of a tensioner, where it has them.
///
/// On a slide, `length` and `sense` are 1, and the laws give forces over the displacement. On an arm of `length` they give torques
/// over the angle, which the pull increases (`sense` 1) or decreases (-1).
fn springs(
    tensioner: &Tensioner,
    length: f64,
    sense: f64,
) -> Result<Vec<(&'static str, SpringLaw)>> {
    let mut found = Vec::new();
    if tensioner.damping > 0.0 || tensioner.stiffness > 0.0 {
        let [stiffness, damping] =
            [tensioner.stiffness, tensioner.damping].map(|of_way| of_way * length * length);
        found.push(("damper", SpringLaw::linear(stiffness, damping)));
    }
    let [back, forth] = tensioner.travel;
    let mut rows = Vec::new();
    if back.is_finite() {
        rows.extend([(-back - ROOM, -ROOM * STOP_STIFFNESS), (-back, 0.0)]);
    }
    if forth.is_finite() {
        rows.extend([(forth, 0.0), (forth + ROOM, ROOM * STOP_STIFFNESS)]);
    }
    // Displacement s = `sense` r φ and torque τ = `sense` r F on an arm of length r.
    for (way, force) in &mut rows {
        *way *= sense / length;
        *force *= sense * length;
    }
    if sense < 0.0 {
        rows.reverse();
    }
    if !rows.is_empty() {
        let law = SpringLaw {
            table: Some(Table::against(
                "travel",
                ("way", "m or rad"),
                "N or N m",
                &rows,
            )?),
            ..SpringLaw::default()
        };
        found.push(("stops", law));
    }
    Ok(found)
}

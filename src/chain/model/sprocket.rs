//! Sprockets and guides of a compiled model: teeth, inertias, support of the centre and law of the rotation.

use super::coordinates::Coordinates;
use super::guide::{Guide, Ratchet};
use crate::drive::{Bearing, Drive, InputBounds, STOP_STIFFNESS, Sprocket, SprocketMotion};
use crate::error::Result;
use crate::geometry::path::belt::Side;
use crate::geometry::{ToothProfile, Vec2};
use crate::layout::InitialConfiguration;
use crate::math::{Signal, Table};

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

/// Return the model of sprocket `number` (from 0): profile, mass properties, support and rotation.
pub(super) fn place_sprocket(
    drive: &Drive,
    number: usize,
    sprocket: &Sprocket,
    start: &InitialConfiguration,
    coordinates: &mut Coordinates,
) -> Result<SprocketModel> {
    let chain = &drive.chain;
    let profile = sprocket.tooth_profile(chain)?;
    let (mass, inertia) = sprocket.mass_properties(chain);
    let [x, y, angle] = start.positions[drive.first_wheel() + number];
    let (center, support) = place_center(drive, number, Vec2::new(x, y), coordinates)?;
    let rotation = place_rotation(&sprocket.motion, coordinates);
    let gap_directions = (0..profile.teeth)
        .map(|gap| {
            let (sin, cos) = (f64::from(gap) * profile.gap_angle()).sin_cos();
            (cos, sin)
        })
        .collect();
    Ok(SprocketModel {
        side: sprocket.side,
        reach: profile.reach(chain.contact_radius()) + sprocket.faults.eccentricity,
        offset: sprocket.faults.offset(),
        profile,
        first_pair: 0,
        gap_directions,
        mass,
        inertia,
        center,
        phase: angle,
        support,
        rotation,
        swing: None,
        input_bounds: Some(InputBounds::of(chain, sprocket.teeth)),
    })
}

/// Return the centre and the support of sprocket `number` (from 0), whose centre in the initial configuration is `center` \[m\].
fn place_center(
    drive: &Drive,
    number: usize,
    center: Vec2,
    coordinates: &mut Coordinates,
) -> Result<(Vec2, Support)> {
    let sprocket = &drive.sprockets[number];
    let Some(tensioner) = drive.tensioner.filter(|t| t.sprocket == number + 1) else {
        let support = match sprocket.bearing {
            Bearing::Fixed => Support::Fixed,
            Bearing::Floating => Support::Floating {
                x: coordinates.take(),
                y: coordinates.take(),
            },
        };
        return Ok((center, support));
    };
    let line = tensioner.line(drive)?;
    let [back, forth] = tensioner.travel;
    let damping_back = tensioner.damping_back.unwrap_or(tensioner.damping);
    // Spring and stops have their origin at the described centre, whatever the initial configuration. A straight guide path passes
    // through the initial centre: its origin is the described centre, shifted across the path.
    let moved = center - sprocket.center;
    let origin = if line.curvature == 0.0 {
        center - moved.dot(&line.direction) * line.direction
    } else {
        sprocket.center
    };
    let support = Support::Slide {
        index: coordinates.take(),
        direction: line.direction,
        guide: Guide {
            curvature: line.curvature,
            stiffness: tensioner.stiffness,
            stops: [-back, forth],
            stop_stiffness: STOP_STIFFNESS,
            extra_mass: tensioner.arm_inertia * line.curvature * line.curvature,
            ratchet: tensioner.ratchet.map(|step| Ratchet { step, forward: 1.0 }),
            dashpots: [damping_back, tensioner.damping],
        },
        pull: line.pull,
        ramp_time: tensioner.ramp_time,
        // Newton's method converges with the larger coefficient, whichever direction the centre moves in.
        damping: tensioner.damping.max(tensioner.damping_back.unwrap_or(0.0)),
    };
    Ok((origin, support))
}

/// Return the law of the rotation of a sprocket with this `motion`.
fn place_rotation(motion: &SprocketMotion, coordinates: &mut Coordinates) -> Rotation {
    let (torque, curve) = match motion {
        SprocketMotion::PrescribedSpeed(speed) => return Rotation::Prescribed(speed.clone()),
        SprocketMotion::AppliedTorque(torque) => (Some(torque), None),
        SprocketMotion::TorqueCurve { torque, curve } => (Some(torque), Some(curve.clone())),
        SprocketMotion::Free => (None, None),
    };
    Rotation::Free {
        index: coordinates.take(),
        torque: torque.filter(|torque| !torque.is_zero()).cloned(),
        curve,
    }
}

//! Conversion of a chain drive into a mechanism: links, sprockets and tensioner as bodies, hinges as joints, teeth as contacts.
//!
//! ```text
//! bodies     link_1 ... link_n, sprocket_1 ... sprocket_m, arm_k of a tensioner with a pivot
//! joints     bearing_k, slide_k or pivot_k, motor_k, and hinge_1 ... hinge_n where hinges are ideal
//! forces     tensioner_k, damper_k, stops_k, motor_k, curve_k
//! contacts   hinge_k where hinges have clearance, bushing_k_on_sprocket_m
//! ```
//!
//! Bodies are in the order of the drive, so rows of both agree. An arm, which is not a body of the drive, comes last.

pub(crate) mod tensioner;

use super::description::body::Frame;
use super::{
    Body, ContactLaw, ContactPair, ForceElement, ForceKind, GROUND, Joint, JointKind, Marker,
    Mechanism, PrescribedMotion, Profile, Tribology,
};
use crate::drive::{Bearing, Drive, HingeKind, SprocketMotion, bushing_on_front};
use crate::error::{Error, Result, check};
use crate::force_law::ForceLaw;
use crate::geometry::Vec2;
use crate::layout::{InitialConfiguration, check_places};
use crate::math::Signal;

/// Force law of all contacts of a mechanism converted from a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveContacts {
    /// Elastic force and damping.
    pub law: ForceLaw,
    /// Lower bound on the initial impact velocity used by the damping factor \[m/s\].
    pub min_impact_velocity: f64,
    /// Friction of all contacts; lubricant film of hinges with clearance.
    pub tribology: Tribology,
}

impl Mechanism {
    /// Return the mechanism of `drive` at the positions and velocities `start`; `None`: the generated initial configuration.
    ///
    /// # Errors
    /// When the drive is invalid or has a part without counterpart in a mechanism, or `start` moves a fixed body.
    pub fn from_drive(
        drive: &Drive,
        contacts: &DriveContacts,
        start: Option<&InitialConfiguration>,
    ) -> Result<Self> {
        check_chain(drive)?;
        let generated;
        let start = if let Some(start) = start {
            drive.validate()?;
            check_places(drive, start)?;
            start
        } else {
            (generated, _) = InitialConfiguration::generate(drive)?;
            &generated
        };
        check_parts(drive)?;
        let mut mechanism = Self {
            gravity: drive.gravity,
            ..Self::default()
        };
        mechanism.add_bodies(drive, start)?;
        for number in 0..drive.sprockets.len() {
            mechanism.add_support(drive, number, start)?;
            mechanism.add_motor(drive, number);
        }
        mechanism.add_chain(drive, contacts)?;
        Ok(mechanism)
    }

    /// Add links and sprockets, in the order of the drive.
    fn add_bodies(&mut self, drive: &Drive, start: &InitialConfiguration) -> Result<()> {
        let chain = &drive.chain;
        let links = chain.links as usize;
        let rows = start.positions.iter().zip(&start.velocities);
        check::rows("velocities", &start.velocities, start.positions.len())?;
        for (i, (&position, &velocity)) in rows.enumerate() {
            let (name, mass, inertia) = if i < links {
                let link = chain.link(i);
                (link_name(i), link.mass, link.inertia)
            } else {
                let number = i - links;
                let (mass, inertia) = drive.sprockets[number].mass_properties(chain);
                let mass = mass * tensioner::share_beside_arm(drive, number);
                (sprocket_name(number), mass, inertia)
            };
            self.bodies.push(Body {
                position,
                velocity,
                ..Body::new(name, mass, inertia)
            });
        }
        Ok(())
    }

    /// Add the support of the centre of sprocket `number` (from 0): its tensioner or its bearing, or nothing where it floats.
    fn add_support(
        &mut self,
        drive: &Drive,
        number: usize,
        start: &InitialConfiguration,
    ) -> Result<()> {
        let body = drive.first_wheel() + number;
        let [x, y, _] = start.positions[body];
        let center = Vec2::new(x, y);
        if let Some(tensioner) = drive.tensioner.filter(|t| t.sprocket == number + 1) {
            let [vx, vy, _] = start.velocities[body];
            return self.add_tensioner(drive, &tensioner, center, Vec2::new(vx, vy));
        }
        if drive.sprockets[number].bearing == Bearing::Fixed {
            let name = format!("bearing_{}", number + 1);
            self.add_revolute(name, GROUND, &sprocket_name(number), center);
        }
        Ok(())
    }

    /// Add a revolute joint at a point of the ground's frame.
    fn add_revolute(&mut self, name: String, a: &str, b: &str, at: Vec2) {
        let joint = Joint::new(
            name,
            self.marker(a, at),
            self.marker(b, at),
            JointKind::Revolute,
        );
        self.joints.push(joint);
    }

    /// Return the point of a body, as placed, that is at `place` in the ground's frame.
    fn marker(&self, body: &str, place: Vec2) -> Marker {
        let placed = self.bodies.iter().find(|known| known.name == body);
        let point = placed.map_or(place, |placed| {
            let frame = Frame::new(placed.position, placed.velocity);
            frame.into_local(place - frame.origin)
        });
        Marker::new(body, point.x, point.y)
    }

    /// Add the driver or the torques of sprocket `number` (from 0).
    fn add_motor(&mut self, drive: &Drive, number: usize) {
        let [ground, wheel] =
            [GROUND, &sprocket_name(number)].map(|body| Marker::new(body, 0.0, 0.0));
        let name = motor_name(number);
        let (torque, curve) = match &drive.sprockets[number].motion {
            SprocketMotion::PrescribedSpeed(speed) => {
                let kind = JointKind::DrivenAngle(PrescribedMotion::Speed(speed.clone()));
                self.joints.push(Joint::new(name, ground, wheel, kind));
                return;
            }
            SprocketMotion::AppliedTorque(torque) => (torque, None),
            SprocketMotion::TorqueCurve { torque, curve } => (torque, Some(curve)),
            // A run can set the torque of a free sprocket.
            SprocketMotion::Free => (&Signal::Constant(0.0), None),
        };
        let kind = ForceKind::Torque(torque.clone());
        self.forces
            .push(ForceElement::new(name, ground.clone(), wheel.clone(), kind));
        if let Some(curve) = curve {
            let kind = ForceKind::TorqueBySpeed(curve.clone());
            let name = curve_name(number);
            self.forces
                .push(ForceElement::new(name, ground, wheel, kind));
        }
    }

    /// Add hinges and tooth contacts.
    fn add_chain(&mut self, drive: &Drive, contacts: &DriveContacts) -> Result<()> {
        let chain = &drive.chain;
        let surfaces = |length: f64| ContactLaw::Surfaces {
            law: contacts.law,
            contact_modulus: chain.material.contact_modulus(),
            restitution: chain.material.restitution,
            length,
            min_impact_velocity: contacts.min_impact_velocity,
        };
        let profiles = (drive.sprockets.iter())
            .map(|sprocket| sprocket.tooth_profile(chain))
            .collect::<Result<Vec<_>>>()?;
        let pitches = chain.link_pitches();
        let links = pitches.len();
        for k in 0..links {
            // Hinge k joins the front of link k and the rear of link k + 1. Body a carries the bushing, body b the pin.
            let behind = (k + 1) % links;
            let front = Marker::new(link_name(k), 0.5 * pitches[k], 0.0);
            let rear = Marker::new(link_name(behind), -0.5 * pitches[behind], 0.0);
            let (bushing, pin) = if bushing_on_front(k, links) {
                (front, rear)
            } else {
                (rear, front)
            };
            let name = format!("hinge_{}", k + 1);
            match drive.hinge_kind {
                HingeKind::Ideal => {
                    let joint = Joint::new(name, bushing.clone(), pin, JointKind::Revolute);
                    self.joints.push(joint);
                }
                HingeKind::Clearance => self.contacts.push(ContactPair {
                    name,
                    a: bushing.clone(),
                    b: pin,
                    profile: Profile::Bore {
                        radius: chain.hinge.bore_radius,
                    },
                    radius: chain.hinge.pin_radius,
                    law: surfaces(chain.hinge_contact_length()),
                    tribology: Tribology {
                        film: (contacts.tribology.film).map(|film| film.of_strands(chain.strands)),
                        ..contacts.tribology
                    },
                }),
            }
            for (number, profile) in profiles.iter().enumerate() {
                self.contacts.push(ContactPair {
                    name: format!("bushing_{}_on_{}", k + 1, sprocket_name(number)),
                    a: Marker::new(sprocket_name(number), 0.0, 0.0),
                    b: bushing.clone(),
                    profile: Profile::Teeth(Box::new(profile.clone())),
                    radius: chain.contact_radius(),
                    law: surfaces(chain.teeth_contact_length()),
                    tribology: Tribology {
                        film: None,
                        ..contacts.tribology
                    },
                });
            }
        }
        Ok(())
    }
}

/// Return the name of a link, whose number counts from 0.
fn link_name(link: usize) -> String {
    format!("link_{}", link + 1)
}

/// Return the name of a sprocket, whose number counts from 0.
fn sprocket_name(sprocket: usize) -> String {
    format!("sprocket_{}", sprocket + 1)
}

/// Return the name of the driver or torque of a sprocket, whose number counts from 0.
fn motor_name(sprocket: usize) -> String {
    format!("motor_{}", sprocket + 1)
}

/// Return the name of the curve of torque over speed of a sprocket, whose number counts from 0.
fn curve_name(sprocket: usize) -> String {
    format!("curve_{}", sprocket + 1)
}

/// Return the error for a drive without a mechanism.
fn refuse(what: impl Into<String>) -> Result<()> {
    Err(Error::Impossible(what.into()))
}

/// Return an error for a chain with rollers as bodies and for an open chain.
fn check_chain(drive: &Drive) -> Result<()> {
    if drive.chain.roller.is_some() {
        return refuse(
            "Chain.roller: a mechanism has no rollers as bodies; give it a chain with rollers='fixed', or run the drive itself",
        );
    }
    if drive.ends.is_some() {
        return refuse(
            "ChainDrive.ends: an open chain cannot be a mechanism; run the drive itself, which has ideal hinges, too",
        );
    }
    Ok(())
}

/// Return an error for parts of a valid drive without counterpart in a mechanism.
fn check_parts(drive: &Drive) -> Result<()> {
    if !drive.guides.is_empty() {
        return refuse(format!(
            "ChainDrive.guides: {} of them; expected none in a mechanism; leave them out, or run the drive itself",
            drive.guides.len()
        ));
    }
    if let Some(stiffness) = drive.chain.axial_stiffness() {
        return refuse(format!(
            "Chain.link_stiffness, {stiffness} N/m in all: must be None in a mechanism, whose links are rigid"
        ));
    }
    for (number, sprocket) in drive.sprockets.iter().enumerate() {
        if sprocket.faults.eccentricity != 0.0 {
            return Err(Error::invalid(
                format!("ChainDrive.sprockets.{}.eccentricity", number + 1),
                sprocket.faults.eccentricity,
                "must be 0 in a mechanism, whose teeth are concentric",
            ));
        }
    }
    if let Some(tensioner) = &drive.tensioner {
        let leak = tensioner.damping_back;
        if tensioner.ratchet.is_some() || leak.is_some_and(|back| back != tensioner.damping) {
            return refuse(
                "Tensioner: a ratchet or a leak do not go into a mechanism: leave ratchet out, and damping_back as damping, or \
                 run the drive itself",
            );
        }
    }
    Ok(())
}

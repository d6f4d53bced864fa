//! Channels of a drive with ideal hinges from the rows of its mechanism: reactions as hinge forces, contacts as those of bushings.

use super::tensioner::{Pull, PullLoad, TensionerArm};
use super::{curve_name, motor_name, sprocket_name};
use crate::drive::{
    Drive, InputBounds, InputQuantity, Tensioner, bushing_on_front, sprocket_of, tensioner_force,
};
use crate::error::{Error, Result, check};
use crate::geometry::path::belt::{Pulley, Side};
use crate::geometry::{Vec2, unit};
use crate::layout::{ChainRow, strands};
use crate::math::Signal;
use crate::multibody::MechanismModel;

/// Recorded values of a mechanism at one time, three numbers per body or joint.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MechanismRow<'a> {
    pub(crate) positions: &'a [f64],
    pub(crate) velocities: &'a [f64],
    pub(crate) reactions: &'a [f64],
    pub(crate) applied_torque: &'a [f64],
    pub(crate) contact_force: &'a [f64],
    pub(crate) contact_force_vector: &'a [f64],
    pub(crate) penetration: &'a [f64],
    pub(crate) contact_gap: &'a [i32],
    pub(crate) contact_region: &'a [i32],
}

/// Contact of a bushing with a sprocket.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BushingContact {
    /// Number of the sprocket, from 0.
    pub(crate) sprocket: usize,
    /// Magnitude of the contact force \[N\]; zero without contact.
    pub(crate) force: f64,
    /// Contact force on the bushing \[N\].
    pub(crate) vector: [f64; 2],
    /// Penetration \[m\]; minus infinity out of reach of the teeth.
    pub(crate) penetration: f64,
    /// Number of the tooth gap, from 0; -1 without contact.
    pub(crate) gap: i32,
    /// Region of the tooth, from 1; 0 without contact.
    pub(crate) region: i32,
}

impl BushingContact {
    /// Return the number of the sprocket in contact, from 1; 0 without contact.
    pub(crate) fn number(&self) -> i32 {
        let number = i32::try_from(self.sprocket + 1).unwrap_or(i32::MAX);
        if self.penetration > 0.0 { number } else { 0 }
    }
}

/// Data of a sprocket for the channels.
#[derive(Debug, Clone)]
struct DriveWheel {
    /// Number of the joint that prescribes its speed.
    motor: Option<usize>,
    /// Numbers of the force elements that apply its torque and its curve over speed.
    torques: Vec<usize>,
    bounds: InputBounds,
    pitch_radius: f64,
    side: Side,
    /// Distance from its centre within which bushings are in reach of its teeth \[m\].
    reach: f64,
}

/// Drive with ideal hinges, for the channels of its mechanism.
#[derive(Debug, Clone)]
pub(crate) struct DriveView {
    /// Half the pitch of each link \[m\].
    arms: Vec<f64>,
    wheels: Vec<DriveWheel>,
    /// Number of the sprocket at which each strand begins.
    strands: Vec<usize>,
    /// Number of the joint of hinge 1; the others follow.
    first_hinge: usize,
    /// Arm of the tensioner, which is not a body of the drive, and the row of its sprocket.
    arm: Option<(TensionerArm, usize)>,
    /// Tensioner: its sprocket, from 0, and its pull.
    pull: Option<(usize, Pull)>,
}

impl DriveView {
    /// Return the view of the drive from which `model` was converted.
    pub(crate) fn new(drive: &Drive, model: &MechanismModel) -> Result<Self> {
        let chain = &drive.chain;
        let joints = model.joint_names();
        let joint = |name: &str| joints.iter().position(|known| known == name);
        let forces: Vec<&str> = model.force_names().collect();
        let wheel = |(number, sprocket): (usize, &crate::drive::Sprocket)| {
            let profile = sprocket.tooth_profile(chain)?;
            Ok(DriveWheel {
                motor: joint(&motor_name(number)),
                torques: [motor_name(number), curve_name(number)]
                    .iter()
                    .filter_map(|name| forces.iter().position(|known| known == name))
                    .collect(),
                bounds: InputBounds::of(chain, sprocket.teeth),
                pitch_radius: profile.pitch_radius,
                side: sprocket.side,
                reach: profile.reach(chain.contact_radius()),
            })
        };
        let pull = |tensioner: &Tensioner| {
            let line = tensioner.line(drive)?;
            Ok((tensioner.sprocket - 1, Pull::of(drive, &line)))
        };
        let arm = TensionerArm::of(drive).zip(drive.tensioner.as_ref());
        Ok(Self {
            arms: chain.link_pitches().iter().map(|p| 0.5 * p).collect(),
            wheels: (drive.sprockets.iter().enumerate())
                .map(wheel)
                .collect::<Result<_>>()?,
            strands: strands(drive).iter().map(|[from, _]| *from).collect(),
            first_hinge: joint("hinge_1").ok_or_else(|| {
                Error::Impossible("ChainDrive.hinges: only ideal hinges are joints".to_string())
            })?,
            pull: drive.tensioner.as_ref().map(pull).transpose()?,
            arm: arm.map(|(arm, tensioner)| (arm, drive.first_wheel() + tensioner.sprocket - 1)),
        })
    }

    /// Return the number of links, which is that of hinges and of bushings.
    pub(crate) fn links(&self) -> usize {
        self.arms.len()
    }

    /// Return the number of sprockets.
    pub(crate) fn sprockets(&self) -> usize {
        self.wheels.len()
    }

    /// Return the number of bodies of the drive, which are the first of the mechanism.
    pub(crate) fn bodies(&self) -> usize {
        self.links() + self.sprockets()
    }

    /// Return the number of strands.
    pub(crate) fn strands(&self) -> usize {
        self.strands.len()
    }

    /// Return the numbers of the hinges among the joints of the mechanism.
    pub(crate) fn hinges(&self) -> std::ops::Range<usize> {
        self.first_hinge..self.first_hinge + self.links()
    }

    /// Return the rows of the mechanism's bodies from those of the drive's bodies; that of an arm follows from its sprocket.
    pub(crate) fn with_arm(
        &self,
        mut positions: Vec<[f64; 3]>,
        mut velocities: Vec<[f64; 3]>,
    ) -> Result<[Vec<[f64; 3]>; 2]> {
        let bodies = self.bodies();
        for (name, rows) in [("positions", &positions), ("velocities", &velocities)] {
            check::rows(name, rows, bodies)?;
        }
        if let Some((arm, row)) = &self.arm {
            let ([x, y, _], [vx, vy, _]) = (positions[*row], velocities[*row]);
            let [position, velocity] = arm.placed(Vec2::new(x, y), Vec2::new(vx, vy));
            positions.push(position);
            velocities.push(velocity);
        }
        Ok([positions, velocities])
    }

    /// Return the front end of link `k` and the rear end of the link behind it \[m\], which hinge `k` joins.
    fn ends(&self, positions: &[f64], k: usize) -> [Vec2; 2] {
        let end = |link: usize, side: f64| {
            let [x, y, angle] = [0, 1, 2].map(|i| positions[3 * link + i]);
            Vec2::new(x, y) + side * self.arms[link] * unit(angle)
        };
        [end(k, 1.0), end((k + 1) % self.links(), -1.0)]
    }

    /// Return the position of each pin's centre relative to its bushing's \[m\]: the residual of the joint's equations.
    pub(crate) fn eccentricities(&self, positions: &[f64]) -> Vec<Vec2> {
        let eccentricity = |k: usize| {
            let [front, rear] = self.ends(positions, k);
            if bushing_on_front(k, self.links()) {
                rear - front
            } else {
                front - rear
            }
        };
        (0..self.links()).map(eccentricity).collect()
    }

    /// Return the force of each hinge on its pin \[N\]: the reaction on body b of the joint.
    pub(crate) fn on_pins(&self, reactions: &[f64]) -> Vec<Vec2> {
        let rows = reactions.chunks_exact(3).skip(self.first_hinge);
        rows.take(self.links())
            .map(|row| Vec2::new(row[0], row[1]))
            .collect()
    }

    /// Return the tension of each strand \[N\]: the mean of the forces along the chain over its hinges.
    pub(crate) fn strand_tensions(&self, row: &MechanismRow) -> Vec<f64> {
        let links = self.links();
        let place = |body: usize| Vec2::new(row.positions[3 * body], row.positions[3 * body + 1]);
        let on_front = |(k, force): (usize, &Vec2)| {
            if bushing_on_front(k, links) {
                -*force
            } else {
                *force
            }
        };
        let bushing = |k: usize| {
            let [front, rear] = self.ends(row.positions, k);
            if bushing_on_front(k, links) {
                front
            } else {
                rear
            }
        };
        let wheels = || self.strands.iter().map(|&s| (links + s, &self.wheels[s]));
        let pulley = |(body, wheel): (usize, &DriveWheel)| Pulley {
            center: place(body),
            radius: wheel.pitch_radius,
            side: wheel.side,
        };
        let forces = self.on_pins(row.reactions);
        let [links, bushings, on_front] = [
            columns((0..links).map(place)),
            columns((0..links).map(bushing)),
            columns(forces.iter().enumerate().map(on_front)),
        ];
        ChainRow {
            links: links.each_ref().map(Vec::as_slice),
            bushings: bushings.each_ref().map(Vec::as_slice),
            on_front: on_front.each_ref().map(Vec::as_slice),
            pulleys: &wheels().map(pulley).collect::<Vec<_>>(),
            reaches: &wheels().map(|(_, wheel)| wheel.reach).collect::<Vec<_>>(),
        }
        .strand_tensions()
    }

    /// Return the contact of bushing `k` with sprocket `s`.
    pub(crate) fn bushing_contact(&self, row: &MechanismRow, k: usize, s: usize) -> BushingContact {
        let contact = k * self.sprockets() + s;
        let near = row.contact_region[contact] > 0;
        let penetration = if near {
            row.penetration[contact]
        } else {
            f64::NEG_INFINITY
        };
        let touching = penetration > 0.0;
        BushingContact {
            sprocket: s,
            penetration,
            force: if touching {
                row.contact_force[contact]
            } else {
                0.0
            },
            vector: [0, 1].map(|axis| {
                let value = row.contact_force_vector[2 * contact + axis];
                if touching { value } else { 0.0 }
            }),
            gap: if touching {
                row.contact_gap[contact]
            } else {
                -1
            },
            region: if touching {
                row.contact_region[contact]
            } else {
                0
            },
        }
    }

    /// Return the contact of largest penetration of each bushing.
    pub(crate) fn deepest_contacts(&self, row: &MechanismRow) -> Vec<BushingContact> {
        let deepest = |k: usize| {
            (1..self.sprockets()).fold(self.bushing_contact(row, k, 0), |deepest, s| {
                let other = self.bushing_contact(row, k, s);
                if other.penetration > deepest.penetration {
                    other
                } else {
                    deepest
                }
            })
        };
        (0..self.links()).map(deepest).collect()
    }

    /// Return the torque of the motor or load of sprocket `s` \[N m\].
    pub(crate) fn shaft_torque(&self, row: &MechanismRow, s: usize) -> f64 {
        let wheel = &self.wheels[s];
        if let Some(motor) = wheel.motor {
            return row.reactions[3 * motor + 2];
        }
        let torques = wheel.torques.iter().map(|&force| row.applied_torque[force]);
        torques.sum()
    }

    /// Return the driver or torque that an input of a sprocket (from 0) sets.
    ///
    /// # Errors
    /// If there is no such sprocket, its motion has no such quantity, or `signal` exceeds the bounds of a drive.
    pub(crate) fn input(
        &self,
        sprocket: usize,
        quantity: InputQuantity,
        signal: &Signal,
    ) -> Result<String> {
        let wheel = sprocket_of(&self.wheels, sprocket)?;
        let (name, driven) = (sprocket_name(sprocket), wheel.motor.is_some());
        wheel.bounds.check_input(&name, driven, quantity, signal)?;
        Ok(motor_name(sprocket))
    }

    /// Return the name of the tensioner of a sprocket (from 0), and its load under the force `signal`.
    ///
    /// # Errors
    /// If the sprocket has no tensioner, or the force is a function of time.
    pub(crate) fn tensioner_load(
        &self,
        sprocket: usize,
        signal: &Signal,
    ) -> Result<(String, PullLoad)> {
        let pull = self.pull.filter(|(tight, _)| *tight == sprocket);
        let force = tensioner_force(&sprocket_name(sprocket), pull.is_some(), signal)?;
        let load = pull.map_or(PullLoad::Torque(0.0), |(_, pull)| pull.load(force));
        Ok((format!("tensioner_{}", sprocket + 1), load))
    }
}

/// Return the coordinates of these points in one array each.
fn columns(points: impl Iterator<Item = Vec2>) -> [Vec<f64>; 2] {
    let (x, y) = points.map(|point| (point.x, point.y)).unzip();
    [x, y]
}

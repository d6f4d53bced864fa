//! Recording of a mechanism: its channels and the values written into their rows.

use super::description::body::Frame;
use super::dynamics::MechanismDynamics;
use super::model::MechanismModel;
use crate::system::{Channel, Row};

/// Index of the peaks of joints, and of those of contacts.
pub(crate) const JOINTS: usize = 0;
/// See [`JOINTS`].
pub(crate) const CONTACTS: usize = 1;

/// Groups of channels of a mechanism to record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::struct_excessive_bools)] // independent switches
pub struct MechanismGroups {
    /// Positions, velocities and accelerations of all bodies.
    pub bodies: bool,
    /// Reactions and residuals of all joints, with peaks.
    pub joints: bool,
    /// Forces, penetrations and onsets of all contacts, with peaks.
    pub contacts: bool,
    /// The energy balance.
    pub energy: bool,
}

impl MechanismGroups {
    /// All groups.
    pub const ALL: Self = Self {
        bodies: true,
        joints: true,
        contacts: true,
        energy: true,
    };
}

/// Return the channels of these groups without rows; rows are written in the same order.
pub(crate) fn channels(model: &MechanismModel, groups: MechanismGroups) -> Vec<Channel> {
    let (bodies, joints) = (model.bodies.len() - 1, model.joints.len());
    let contacts = model.contacts.len();
    let mut channels = Vec::new();
    if groups.bodies {
        for name in ["positions", "velocities", "accelerations"] {
            channels.push(Channel::real(name, &[bodies, 3]));
        }
    }
    if groups.joints {
        channels.push(Channel::real("joint_reaction", &[joints, 3]));
        for name in [
            "joint_position_residual",
            "joint_velocity_residual",
            "peak_joint_force",
            "peak_joint_impulse",
        ] {
            channels.push(Channel::real(name, &[joints]));
        }
    }
    if groups.contacts {
        channels.push(Channel::real("contact_force", &[contacts]));
        channels.push(Channel::real("contact_force_vector", &[contacts, 2]));
        channels.push(Channel::real("contact_impact_velocity", &[contacts]));
        channels.push(Channel::real("contact_penetration", &[contacts]));
        channels.push(Channel::whole("contact_gap", &[contacts]));
        channels.push(Channel::whole("contact_region", &[contacts]));
        channels.push(Channel::real("peak_contact_force", &[contacts]));
        channels.push(Channel::real("peak_contact_impulse", &[contacts]));
    }
    channels
}

/// Write a row of `groups` for `dynamics` as evaluated at `t`.
pub(crate) fn write_row(
    row: &mut Row,
    dynamics: &mut MechanismDynamics,
    t: f64,
    groups: MechanismGroups,
) {
    if groups.bodies {
        write_bodies(row, dynamics);
    }
    if groups.joints {
        write_joints(row, dynamics);
    }
    if groups.contacts {
        let impacts = dynamics
            .onsets
            .take_velocities(dynamics.model.contacts.len(), t);
        write_contacts(row, dynamics, &impacts);
    }
}

/// Write positions, velocities and accelerations of all bodies but the ground; the last two are zero for fixed bodies.
fn write_bodies(row: &mut Row, dynamics: &MechanismDynamics) {
    let frames = &dynamics.frames[1..];
    row.vectors(frames.iter().map(Frame::position));
    row.vectors(frames.iter().map(Frame::rates));
    let bodies = 1..dynamics.model.bodies.len();
    let accelerations = &dynamics.accelerations;
    row.vectors(bodies.map(|body| dynamics.model.accelerations_of(body, accelerations)));
}

/// Write reactions, largest residuals and peaks of all joints.
fn write_joints(row: &mut Row, dynamics: &MechanismDynamics) {
    let joints = dynamics.model.joints.len();
    row.vectors((0..joints).map(|joint| dynamics.reaction(joint)));
    let mut residuals = [vec![0.0f64; joints], vec![0.0f64; joints]];
    for (equation, line) in dynamics
        .model
        .equations
        .iter()
        .zip(&dynamics.constraints.rows)
    {
        let found = [
            equation.residual(line),
            equation.residual_rate(line, &dynamics.frames),
        ];
        for (largest, found) in residuals.iter_mut().zip(found) {
            let largest = &mut largest[equation.joint];
            *largest = largest.max(found.abs());
        }
    }
    for residual in residuals {
        row.copy(&residual);
    }
    let forces: Vec<f64> = (0..joints)
        .map(|joint| dynamics.joint_force(joint))
        .collect();
    row.close_peaks(JOINTS, &forces);
}

/// Write forces, impact velocities, penetrations, tooth positions and peaks of all contacts.
fn write_contacts(row: &mut Row, dynamics: &MechanismDynamics, impacts: &[f64]) {
    let model = &dynamics.model;
    let forces: Vec<f64> = dynamics
        .contacts
        .pushes(model)
        .map(|push| push.norm())
        .collect();
    row.copy(&forces);
    row.vectors(dynamics.contacts.pushes(model).map(<[f64; 2]>::from));
    row.copy(impacts);
    let sides = || model.contacts.iter().zip(&model.sides_of_contact);
    row.real(sides().map(|(contact, sides)| {
        let side_states = &dynamics.contacts.side_states[sides.clone()];
        let depths = side_states
            .iter()
            .map(|side_state| side_state.contact.penetration);
        let depth = depths.fold(f64::NEG_INFINITY, f64::max);
        if depth > 0.0 {
            depth
        } else {
            contact.penetration(&dynamics.frames, &dynamics.contacts.memory[sides.clone()])
        }
    }));
    let teeth = || sides().map(|(_, sides)| dynamics.contacts.side_states[sides.start].tooth);
    // The number of a tooth gap is small, so the conversion to a signed number is exact.
    row.whole(teeth().map(|tooth| tooth.map_or(-1, |tooth| tooth.gap.cast_signed())));
    row.whole(teeth().map(|tooth| tooth.map_or(0, |tooth| i32::from(tooth.region))));
    row.close_peaks(CONTACTS, &forces);
}

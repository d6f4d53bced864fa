//! Planar mechanisms: bodies, ideal joints, drivers, force elements and contacts, and the constrained equations of motion.
//!
//! ```text
//! Mechanism -> MechanismModel -> assembly -> MechanismDynamics (a System) -> run::Simulation
//! ```

pub(crate) mod assembly;
pub(crate) mod constraints;
pub(crate) mod contact;
pub(crate) mod description;
pub(crate) mod dynamics;
pub(crate) mod forces;
mod frames;
pub(crate) mod from_drive;
mod input_changes;
mod inputs;
pub(crate) mod model;
pub(crate) mod newton;
pub(crate) mod report;
pub(crate) mod singular;
mod statics;
mod step;
mod step_start;
mod sums;
mod system;
pub(crate) mod views;

pub use assembly::outcome::Assembly;
pub use description::body::{Body, Marker};
pub use description::contact_law::ContactLaw;
pub use description::contact_pair::ContactPair;
pub use description::driver::PrescribedMotion;
pub use description::force_element::{CustomForce, ForceElement, ForceKind, LoadFunction};
pub use description::joint::{Joint, JointKind};
pub use description::outline_piece::Piece;
pub use description::profile::Profile;
pub use description::spring_law::SpringLaw;
pub use description::tribology::{FrictionLaw, PinFriction, Tribology};
pub use dynamics::MechanismDynamics;
pub use from_drive::DriveContacts;
pub use model::MechanismModel;
pub use report::MechanismGroups;
pub use sums::MechanismSums;
pub use system::MechanismCheckpoint;

use crate::geometry::Vec2;

/// Name of the fixed frame.
pub const GROUND: &str = "ground";

/// Description of a mechanism.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mechanism {
    /// Gravity \[m/s²\].
    pub gravity: Vec2,
    /// The bodies.
    pub bodies: Vec<Body>,
    /// Ideal joints and drivers.
    pub joints: Vec<Joint>,
    /// Applied forces, springs and dampers.
    pub forces: Vec<ForceElement>,
    /// Clearance joints and other contacts.
    pub contacts: Vec<ContactPair>,
}

//! Any planar mechanism: bodies, ideal joints, drivers, force elements and contacts, and the constrained equations of motion.
//!
//! ```text
//! Mechanism -> MechanismModel -> assembly -> MechanismDynamics (an OdeSystem) -> MechanismSimulation -> recording
//! ```

mod approach;
mod assembly;
mod body;
mod branches;
mod constrained;
mod contact;
mod contact_law;
mod contact_path;
mod contact_slopes;
mod curve;
mod dynamics;
mod elimination;
mod equation;
mod event_screening;
mod force_element;
mod force_slopes;
mod free_way;
mod implicit;
mod joint;
mod joint_slopes;
mod kkt;
mod load_scales;
mod loads;
mod memory;
mod misses;
mod model;
mod motion;
mod moves;
mod null_space;
mod onset;
mod orthogonal;
mod outline;
mod outline_check;
mod pair;
mod peaks;
mod piece;
mod plausibility;
mod present;
mod profile;
mod projection;
mod recording;
mod reports;
mod residuals;
mod saddle;
mod scales;
mod simulation;
mod singular;
mod snapshot;
mod sparse;
mod spring_law;
mod structure;
mod time_function;
mod touch;
mod twice;
mod views;
mod whole;

pub use assembly::Assembly;
pub use body::{Body, Marker};
pub use contact::ContactPair;
pub use contact_law::ContactLaw;
pub use curve::{Curve, Spline};
pub use dynamics::{MechanismDynamics, Stabilisation};
pub use force_element::{CustomForce, ForceElement, ForceKind, LoadFunction};
pub use joint::{Joint, JointKind};
pub use model::MechanismModel;
pub use motion::Motion;
pub use piece::Piece;
pub use profile::Profile;
pub use recording::MechanismRecording;
pub use simulation::MechanismSimulation;
pub use snapshot::MechanismSnapshot;
pub use spring_law::SpringLaw;
pub use time_function::TimeFunction;

use crate::geometry::Vec2;

/// Name of the frame that does not move.
pub const GROUND: &str = "ground";

/// Everything that a mechanism is made of.
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

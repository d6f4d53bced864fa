//! The chain-drive system: compiled model, contacts, right-hand side, matrix of the implicit corrector, events, energy.

pub mod contact;
pub mod dynamics;
pub mod model;
pub mod motion;
pub(crate) mod newton;
pub mod report;
pub(crate) mod rhs;

pub use report::Groups;

//! The chain-drive system: compiled model, contacts, right-hand side, matrix of the implicit corrector, events, energy.

mod arrays;
pub mod contact;
pub mod dynamics;
mod loads;
pub mod model;
pub mod motion;
pub(crate) mod newton;
mod powers;
pub mod report;
pub(crate) mod rhs;

pub use report::Groups;

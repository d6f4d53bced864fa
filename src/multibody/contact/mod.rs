//! Contacts of circles with profiles: contact points, forces, impact velocity memory, bound of the step size.

pub(crate) mod bristles;
pub(crate) mod compiled_contact;
pub(crate) mod contact_path;
pub(crate) mod contact_slopes;
pub(crate) mod contact_states;
pub(crate) mod event_screening;
pub(crate) mod film;
pub(crate) mod friction;
pub(crate) mod impact_memory;
pub(crate) mod law_ranges;
pub(crate) mod onset;
pub(crate) mod outline;
pub(crate) mod step_bound;

#[cfg(test)]
mod tests;

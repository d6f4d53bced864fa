//! Motion near singular positions.

pub(crate) mod acceleration;
pub(crate) mod start;

//! Positions and velocities that satisfy the constraints, and checks of the description.

pub(crate) mod approach;
pub(crate) mod changes;
pub(crate) mod outcome;
pub(crate) mod placement;
pub(crate) mod projection;
pub(crate) mod residual_report;
pub(crate) mod residuals;
pub(crate) mod start_warnings;

//! Constraint equations and the linear systems that contain them.

pub(crate) mod constraint_state;
pub(crate) mod equation;
pub(crate) mod jacobian;
pub(crate) mod joint_slopes;
pub(crate) mod pin;
pub(crate) mod pin_friction;
pub(crate) mod relative_kinematics;
pub(crate) mod sparse_kkt;

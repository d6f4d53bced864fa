//! Contact detection and memory: candidate lists, impact velocity memory, relative kinematics along a step, tooth jumps.

mod candidates;
mod clearance_joint;
mod contact_path;
mod impact_memory;
mod pair_path;
mod roller_path;
mod tooth_gap;
mod tooth_jumps;

pub(crate) use candidates::{
    BushingRun, Candidates, CandidatesCheckpoint, SprocketCandidates, gap_of, surface_constants,
};
pub(crate) use contact_path::ContactPath;
pub use impact_memory::{ContactId, ImpactMemory, OnsetCounts};
pub use pair_path::{HingePath, ToothPath};
pub use roller_path::RollerPath;
pub(crate) use tooth_gap::seen_from_teeth;
pub use tooth_gap::{OnGap, SprocketFrame, bushing_on_sprocket};
pub use tooth_jumps::ToothJump;
pub(crate) use tooth_jumps::{Seated, ToothJumps};

#[cfg(test)]
pub(crate) mod tests;

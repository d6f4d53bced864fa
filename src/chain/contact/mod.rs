//! Who touches whom, how deep, how fast.

mod candidates;
mod clearance_joint;
mod impact_memory;
mod pair_path;
mod roller_joint;
mod roller_path;
mod tooth_contact;
mod tooth_jumps;

pub(crate) use candidates::{
    Candidates, CarriedCandidates, Run, SprocketCandidates, gap_direction, surface_constants,
};
pub use clearance_joint::HingeContacts;
pub use impact_memory::{ImpactMemory, OnsetCounts};
pub use pair_path::{HingePath, ToothPath};
pub use roller_joint::{RollerContacts, on_teeth};
pub use roller_path::RollerPath;
pub(crate) use tooth_contact::seen_from_teeth;
pub use tooth_contact::{OnGap, SprocketFrame, ToothContacts, bushing_on_sprocket};
pub use tooth_jumps::ToothJump;
pub(crate) use tooth_jumps::{Seated, ToothJumps};

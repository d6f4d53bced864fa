//! What changes: time, coordinates, velocities; and the motion of every body read from them.

mod fit;
mod initial;
mod layout;
mod motion;

pub use initial::Start;
pub use layout::{Layout, closing_center_distance, links_for};
pub use motion::Motion;
pub(crate) use motion::sprocket_motion;

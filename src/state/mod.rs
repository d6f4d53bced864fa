//! What changes: time, coordinates, velocities; and the motion of every body read from them.

mod closing;
mod fit;
mod guides;
mod initial;
mod layout;
mod many_sprockets;
mod motion;
mod open_chain;
mod open_layout;
mod strand_motion;
mod tightness;
mod two_sprockets;

pub use closing::{closing_move, links_around};
pub use initial::Start;
pub use layout::{GuideLie, Layout, closing_center_distance, links_for, strand_name};
pub use motion::Motion;
pub(crate) use motion::sprocket_motion;
pub use tightness::{Tightness, tightness};

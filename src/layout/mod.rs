//! What changes: time, coordinates, velocities; and the motion of every body read from them.

mod closing;
mod fit;
mod guides;
mod initial;
mod many_sprockets;
mod open_chain;
mod open_layout;
mod report;
mod strand_motion;
mod tightness;
mod two_sprockets;

pub use closing::{closing_move, links_around};
pub use initial::Start;
pub(crate) use open_layout::open_strands;
pub use report::{GuideLie, Layout, closing_center_distance, links_for, strand_name};
pub use tightness::{Tightness, tightness};

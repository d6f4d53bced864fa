//! The initial configuration of a chain drive: belt line, seats, slack, velocities, and what the generator chose.

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
pub use initial::InitialConfiguration;
pub(crate) use open_layout::open_strands;
pub use report::{GuidePlacement, Layout, closing_center_distance, links_for, strand_name};
pub use tightness::{Tightness, tightness};

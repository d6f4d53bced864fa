//! The initial configuration of a chain drive: belt line, seats, slack, velocities, and what the generator chose.

mod closing;
mod configuration;
mod fit;
mod guides;
mod initial;
mod laid_chain;
mod many_sprockets;
mod open_chain;
mod open_layout;
mod places;
mod report;
mod strand_motion;
mod strand_tension;
mod tightness;
mod two_sprockets;
mod warnings;

pub use closing::{closing_center_distance, closing_move, links_around, links_for};
pub use configuration::InitialConfiguration;
pub(crate) use places::check_places;
pub(crate) use report::USUAL_SAG;
pub use report::{GuidePlacement, Layout, strand_name};
pub(crate) use strand_tension::ChainRow;
pub use strand_tension::strands;

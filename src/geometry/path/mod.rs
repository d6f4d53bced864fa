//! The path of a chain: belt line, polygon of links, hanging strand, rails, guide paths.

pub mod belt;
pub(crate) mod bow;
pub mod guide_path;
pub mod hanging;
pub mod polygon;
pub(crate) mod rail;
pub mod wrap;

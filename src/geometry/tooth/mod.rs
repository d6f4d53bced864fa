//! Tooth forms as sequences of arcs and segments.

pub(crate) mod ansi;
pub(crate) mod arc;
#[cfg(test)]
pub(crate) mod checks;
pub(crate) mod custom;
pub(crate) mod flank;
pub(crate) mod iso;
pub(crate) mod profile;
pub(crate) mod segment;

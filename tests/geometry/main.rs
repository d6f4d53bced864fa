//! Tooth forms as plane curves.

#![allow(clippy::unwrap_used)]

mod tooth_profile;

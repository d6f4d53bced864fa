//! Arrays that evaluations of the right-hand side write, and that Newton's matrix and reports read.

#![allow(clippy::inline_always)] // as in the kernels that call them

pub(crate) mod layout;
pub(crate) mod pose;
pub(crate) mod slopes;

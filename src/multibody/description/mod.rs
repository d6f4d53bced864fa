//! Description of a mechanism by its user: plain validated data.

pub(crate) mod body;
pub(crate) mod contact_law;
pub(crate) mod contact_pair;
pub(crate) mod driver;
pub(crate) mod force_element;
pub(crate) mod joint;
pub(crate) mod outline_check;
pub(crate) mod outline_piece;
pub(crate) mod profile;
pub(crate) mod spring_law;
pub(crate) mod tribology;
pub(crate) mod validate;

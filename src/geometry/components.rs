//! Encoding of vectors as their two components, for `#[serde(with = "crate::geometry::components")]`.
//!
//! The feature of nalgebra that does the same would add serde to the linear algebra of every build.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::Vec2;

/// Vector, or optional vector, that is encoded as its components.
pub(crate) trait Components: Copy {
    /// Encoded form.
    type Plain: Serialize + for<'de> Deserialize<'de>;

    /// Return the components.
    fn to_plain(self) -> Self::Plain;

    /// Return the vector of these components.
    fn from_plain(plain: Self::Plain) -> Self;
}

impl Components for Vec2 {
    type Plain = [f64; 2];

    fn to_plain(self) -> [f64; 2] {
        self.into()
    }

    fn from_plain(plain: [f64; 2]) -> Self {
        plain.into()
    }
}

impl Components for Option<Vec2> {
    type Plain = Option<[f64; 2]>;

    fn to_plain(self) -> Option<[f64; 2]> {
        self.map(Vec2::into)
    }

    fn from_plain(plain: Option<[f64; 2]>) -> Self {
        plain.map(Vec2::from)
    }
}

pub(crate) fn serialize<C: Components, S: Serializer>(
    vector: &C,
    to: S,
) -> Result<S::Ok, S::Error> {
    vector.to_plain().serialize(to)
}

pub(crate) fn deserialize<'de, C: Components, D: Deserializer<'de>>(
    from: D,
) -> Result<C, D::Error> {
    C::Plain::deserialize(from).map(C::from_plain)
}

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

#[cfg(test)]
mod tests {
    use super::*;

    /// Both kinds of fields.
    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Piece {
        #[serde(with = "crate::geometry::components")]
        start: Vec2,
        #[serde(with = "crate::geometry::components")]
        center: Option<Vec2>,
    }

    #[test]
    fn vectors_are_encoded_as_their_two_components() {
        for center in [None, Some(Vec2::new(-0.25, 3.5))] {
            let piece = Piece {
                start: Vec2::new(1.5, -2.0),
                center,
            };
            let bytes = postcard::to_allocvec(&piece).unwrap();
            let plain = ([1.5, -2.0], center.map(|_| [-0.25, 3.5]));
            assert_eq!(bytes, postcard::to_allocvec(&plain).unwrap());
            assert_eq!(postcard::from_bytes::<Piece>(&bytes), Ok(piece));
        }
    }
}

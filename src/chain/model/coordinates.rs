//! Numbers of the generalized coordinates.

/// Counter that allocates generalized coordinates.
pub(super) struct Coordinates(pub(super) usize);

impl Coordinates {
    /// Return the next free coordinate.
    pub(super) fn take(&mut self) -> usize {
        self.0 += 1;
        self.0 - 1
    }
}

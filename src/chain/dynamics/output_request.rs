//! Requested outputs of an evaluation: contacts that are not requested are neither detected nor evaluated.

/// Requested quantities of one kind of contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Want {
    /// Nothing.
    Nothing,
    /// Penetrations, and the positions of the contacts.
    Depths,
    /// Penetrations, positions and forces.
    Forces,
}

/// Requested outputs of an evaluation, besides positions and velocities of all bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Needs {
    /// Outputs of the hinges.
    pub(crate) hinges: Want,
    /// Outputs of the teeth.
    pub(crate) teeth: Want,
    /// Loads of the chain on the sprockets; they require the forces on the teeth.
    pub(crate) sprocket_loads: bool,
}

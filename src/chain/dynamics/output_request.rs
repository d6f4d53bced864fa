//! What an evaluation is for: contacts that nobody asked for are neither looked for nor given a force.

/// How much of one kind of contact is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Want {
    /// Nothing.
    Nothing,
    /// Depths, and where the contacts are.
    Depths,
    /// Normal forces too.
    Forces,
}

/// What is wanted of an evaluation beside the places and velocities of all bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Needs {
    /// Of the hinges.
    pub(crate) hinges: Want,
    /// Of the teeth.
    pub(crate) teeth: Want,
    /// What the chain does to the sprockets, for which the teeth's forces are needed.
    pub(crate) sprocket_loads: bool,
}

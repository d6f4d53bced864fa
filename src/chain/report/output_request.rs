//! Requested outputs of an evaluation. Teeth are evaluated on request only; hinges whenever anything is requested.

/// Requested outputs of an evaluation, besides positions and velocities of all bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct OutputRequest {
    /// Whether the outputs of the hinges are requested.
    pub(crate) hinges: bool,
    /// Whether the outputs of the teeth are requested.
    pub(crate) teeth: bool,
    /// Loads of the chain on the sprockets; they require the forces on the teeth.
    pub(crate) sprocket_loads: bool,
}

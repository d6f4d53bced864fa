//! Result of assembling a mechanism.

/// Result of assembling a mechanism.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Assembly {
    /// Positions and velocities (q, then v) that satisfy the constraints, three components per body that is not fixed.
    pub state: Vec<f64>,
    /// Largest displacement of a body \[m\].
    pub moved: f64,
    /// Largest rotation of a body \[rad\].
    pub turned: f64,
    /// Largest change of a body's velocity \[m/s\].
    pub velocity_change: f64,
    /// Largest change of a body's angular velocity \[rad/s\].
    pub spin_change: f64,
    /// Degrees of freedom: number of coordinates less the rank of the constraints, which include the drivers.
    pub degrees_of_freedom: usize,
    /// Redundant constraints at the initial configuration: the joint of each.
    pub redundant: Vec<String>,
    /// Warnings.
    pub warnings: Vec<String>,
}

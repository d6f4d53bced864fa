//! Co-simulation of a chain drive by the Functional Mock-up Interface (FMI) 2.0 and 3.0.
//!
//! [`Contents`] is the scene in an FMU with its variables, [`Instance`] an instance of it that a master steps. The C functions of both
//! standards are behind the feature `fmu`: a library with them needs no Python.

#[cfg(feature = "fmu")]
mod c_interface;
mod contents;
mod instance;
#[cfg(any(test, feature = "fmu"))]
mod resource_uri;

pub use contents::{Contents, InputVariable, OutputVariable};
pub use instance::{Instance, InstanceState};

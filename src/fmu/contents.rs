//! Contents of an FMU: its scene, its start and its variables, as one file in its resources.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::chain::Groups;
use crate::chain::model::{ForceLaws, Model};
use crate::drive::{Drive, InputQuantity};
use crate::error::{Error, Result};
use crate::integrator::StepControl;
use crate::layout::InitialConfiguration;
use crate::run::simulation::{Simulation, Snapshot};
use crate::system::{Recording, hash};

/// Version of the file; every change of the contents has a new version.
const FORMAT: u32 = 2;

/// Recorded groups of the channels of output variables.
pub(super) const GROUPS: Groups = Groups {
    hinges: true,
    teeth: true,
    sprockets: true,
    bodies: false,
    energy: false,
};

/// Input variable: a quantity of a sprocket.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct InputVariable {
    /// Number of the sprocket, from 0.
    pub sprocket: usize,
    /// Quantity.
    pub quantity: InputQuantity,
}

/// Output variable: an element of a recorded channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OutputVariable {
    /// Name of the channel.
    pub channel: String,
    /// Number of the element in a row, from 0; `None`: the largest element.
    pub element: Option<usize>,
}

/// Scene, start and variables of an FMU.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contents {
    /// Drive.
    pub drive: Drive,
    /// Force laws.
    pub laws: ForceLaws,
    /// Solver.
    pub control: StepControl,
    /// Initial configuration of the scene.
    pub start: InitialConfiguration,
    /// State at the start of the FMU, as bytes of a snapshot; `None`: the initial configuration.
    pub state: Option<Vec<u8>>,
    /// Inputs, with value references from 1 on.
    pub inputs: Vec<InputVariable>,
    /// Outputs, with the value references behind those of the inputs.
    pub outputs: Vec<OutputVariable>,
}

impl Contents {
    /// Return the contents as bytes, for [`Self::from_bytes`], and their instantiation token.
    ///
    /// # Errors
    /// None for contents; the encoder has errors for other types.
    pub fn to_bytes(&self) -> Result<(Vec<u8>, String)> {
        let bytes = postcard::to_allocvec(&(FORMAT, self)).map_err(|error| {
            Error::Impossible(format!("the scene of the FMU cannot be encoded: {error}"))
        })?;
        let token = token_of(&bytes);
        Ok((bytes, token))
    }

    /// Return the contents that [`Self::to_bytes`] encoded with this instantiation token.
    ///
    /// # Errors
    /// If the bytes belong to another token, are damaged, or have another version.
    pub fn from_bytes(bytes: &[u8], token: &str) -> Result<Self> {
        let own = token_of(bytes);
        if token != own {
            let expected =
                format!("the scene in the FMU has {own}: use the files of one FMU together");
            return Err(Error::invalid("instantiation token", token, expected));
        }
        let damaged =
            |_| Error::Impossible("the scene in the FMU is damaged: export it again".to_string());
        let (format, rest): (u32, _) = postcard::take_from_bytes(bytes).map_err(damaged)?;
        if format != FORMAT {
            let expected = format!("this library reads {FORMAT}: export the FMU again");
            return Err(Error::invalid("version of the scene", format, expected));
        }
        postcard::from_bytes(rest).map_err(damaged)
    }

    /// Return the simulation at the start of the FMU.
    ///
    /// # Errors
    /// If the scene or its state is invalid.
    pub(super) fn simulation(&self) -> Result<Simulation> {
        let model = Model::compile(&self.drive, &self.laws, &self.start)?;
        let mut simulation = Simulation::new(Arc::new(model), &self.start, self.control)?;
        if let Some(state) = &self.state {
            simulation.restore(&Snapshot::from_bytes(state)?)?;
        }
        Ok(simulation)
    }
}

impl OutputVariable {
    /// Return the value in the last row of `recording`.
    ///
    /// # Errors
    /// If there is no such channel or element.
    pub(super) fn value_in(&self, recording: &Recording) -> Result<f64> {
        let row = recording.last_row(&self.channel);
        let value = row.and_then(|row| match self.element {
            Some(element) => row.get(element).copied(),
            None => row.iter().copied().reduce(f64::max),
        });
        value.ok_or_else(|| {
            let element = self.element.map_or(String::new(), |i| format!("[{i}]"));
            let name = format!("{}{element}", self.channel);
            Error::invalid("output", name, "is not recorded of this drive")
        })
    }
}

/// Return the instantiation token of encoded contents.
fn token_of(bytes: &[u8]) -> String {
    format!("{{rustchain-{:016x}}}", hash(bytes))
}

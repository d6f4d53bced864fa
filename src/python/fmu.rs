//! Contents of an FMU for Python.

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::starts::{DriveScene, input_quantity};
use crate::error::Result;
use crate::fmu::{Contents, InputVariable, Instance, OutputVariable};
use crate::panics::contained;

/// Bytes of the scene in an FMU, its instantiation token, and the values of all variables at the start, the time first.
type Packed<'py> = (Bound<'py, PyBytes>, String, Vec<f64>);

/// Return the scene of an FMU, checked by an instance of it.
///
/// `inputs`: number of the sprocket, from 1, and its quantity. `outputs`: channel, and number of its element, from 0, or `None` for the
/// largest one. `state`: snapshot of the state to start with.
#[pyfunction]
#[allow(clippy::needless_pass_by_value)] // PyO3 passes arrays by value
pub(super) fn fmu_scene<'py>(
    scene: &Bound<'py, PyAny>,
    positions: Option<PyReadonlyArray2<'py, f64>>,
    velocities: Option<PyReadonlyArray2<'py, f64>>,
    state: Option<Vec<u8>>,
    inputs: Vec<(usize, String)>,
    outputs: Vec<(String, Option<usize>)>,
) -> PyResult<Packed<'py>> {
    let py = scene.py();
    let scene = DriveScene::new(scene, (positions.as_ref(), velocities.as_ref(), Vec::new()))?;
    let inputs = inputs.into_iter().map(input_variable);
    let inputs = inputs.collect::<Result<Vec<_>>>()?;
    let start = scene.own_or_generated_start(py)?;
    let (bytes, token, values) = contained(|| {
        let contents = Contents {
            drive: scene.drive,
            laws: scene.laws,
            control: scene.control,
            start,
            state,
            inputs,
            outputs: outputs
                .into_iter()
                .map(|(channel, element)| OutputVariable { channel, element })
                .collect(),
        };
        let (bytes, token) = contents.to_bytes()?;
        let instance = Instance::new(Contents::from_bytes(&bytes, &token)?)?;
        Ok((bytes, token, instance.values()))
    })?;
    Ok((PyBytes::new(py, &bytes), token, values))
}

fn input_variable((sprocket, quantity): (usize, String)) -> Result<InputVariable> {
    Ok(InputVariable {
        sprocket: sprocket.wrapping_sub(1),
        quantity: input_quantity(&quantity)?,
    })
}

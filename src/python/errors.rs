//! Conversion of this crate's errors to the exceptions of `rustchain.errors`.

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::import_exception;
use pyo3::prelude::*;

use crate::error::Error;
use crate::panics;

import_exception!(rustchain.errors, InvalidInput);
import_exception!(rustchain.errors, SimulationError);

/// Return the exception of a panic caught at the boundary with this `message`, of an object whose present time is `time` \[s\].
#[pyfunction]
pub(super) fn panicked(py: Python<'_>, message: &str, time: Option<f64>) -> Py<PyAny> {
    let message = message.to_string() + &panics::place();
    let exception = PyErr::from(Error::Panicked { time, message });
    exception.into_value(py).into_any()
}

impl From<Error> for PyErr {
    fn from(error: Error) -> Self {
        Python::attach(|py| to_python(py, &error))
    }
}

/// Return the exception of `error`.
fn to_python(py: Python<'_>, error: &Error) -> PyErr {
    // At its first use the numpy crate imports NumPy's interface. An interrupt there is a panic, whose message names its exception.
    if let Error::Panicked { message, .. } = error
        && message.contains("<class 'KeyboardInterrupt'>")
    {
        return PyKeyboardInterrupt::new_err(());
    }
    let (time, step_size, contact) = match error {
        Error::InvalidValue { .. } | Error::Impossible(_) => {
            return InvalidInput::new_err(error.to_string());
        }
        Error::StepTooSmall {
            time,
            step_size,
            culprit,
        }
        | Error::Standstill {
            time,
            step_size,
            culprit,
            ..
        }
        | Error::NotFinite {
            time,
            step_size,
            culprit,
        }
        | Error::ToleranceTooSmall {
            time,
            step_size,
            culprit,
            ..
        } => (Some(*time), Some(*step_size), Some(culprit.as_str())),
        Error::JointsApart { time, residuals } => (Some(*time), None, Some(residuals.as_str())),
        Error::Panicked { time, .. } => (*time, None, None),
    };
    let exception = SimulationError::new_err(error.to_string());
    let value = exception.value(py);
    let attributes = value
        .setattr("time", time)
        .and_then(|()| value.setattr("step_size", step_size))
        .and_then(|()| value.setattr("contact", contact))
        .and_then(|()| value.setattr("result", py.None()));
    match attributes {
        Ok(()) => exception,
        Err(error) => error,
    }
}

//! Python callable as a force of a mechanism: an exception or an invalid result ends the run, with name and time.

use std::sync::{Arc, Mutex};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use super::describe::refuse;
use super::errors::InvalidInput;
use crate::multibody::{CustomForce, ForceKind};

/// First exception raised by a callable.
pub(super) type Raised = Arc<Mutex<Option<PyErr>>>;

/// Return the force of a callable; its exception ends the run, in which the load is NaN.
pub(super) fn custom(
    name: &str,
    function: &Bound<'_, PyAny>,
    raised: &Raised,
) -> PyResult<ForceKind> {
    if !function.is_callable() {
        return Err(refuse(
            "function",
            function,
            "must be callable: f(time, position, velocity) that returns (force x, force y, torque)",
        ));
    }
    let (name, function, raised) = (
        name.to_string(),
        function.clone().unbind(),
        Arc::clone(raised),
    );
    let load = move |t: f64, position: [f64; 3], velocity: [f64; 3]| {
        // The slot is not locked during the call: another thread may wait for it with the interpreter, which the call needs.
        if raised.lock().map_or(true, |slot| slot.is_some()) {
            return [f64::NAN; 3];
        }
        let found = Python::attach(|py| call(py, &name, &function, t, position, velocity));
        found.unwrap_or_else(|error| {
            if let Ok(mut slot) = raised.lock() {
                slot.get_or_insert(error);
            }
            [f64::NAN; 3]
        })
    };
    Ok(ForceKind::Custom(CustomForce(Arc::new(load))))
}

fn call(
    py: Python<'_>,
    name: &str,
    function: &Py<PyAny>,
    t: f64,
    position: [f64; 3],
    velocity: [f64; 3],
) -> PyResult<[f64; 3]> {
    let load = function
        .call1(py, (t, position.to_vec(), velocity.to_vec()))
        .map_err(|error| explained(py, name, error))?;
    let found = load.extract::<[f64; 3]>(py).ok();
    found
        .filter(|load| load.iter().all(|part| part.is_finite()))
        .ok_or_else(|| {
            refuse(
                &format!("load of force {name:?} at t = {t} s"),
                load.bind(py),
                "must be three finite numbers (force x, force y, torque)",
            )
        })
}

/// Return an explanatory error for a callable that uses the simulation during its step.
fn explained(py: Python<'_>, name: &str, error: PyErr) -> PyErr {
    if !error.get_type(py).is(py.get_type::<PyRuntimeError>()) {
        return error;
    }
    match error.value(py).str() {
        Ok(message) if message.to_string_lossy().starts_with("Already ") => {}
        Ok(_) => return error,
        Err(interrupt) => return interrupt,
    }
    let told = InvalidInput::new_err(format!(
        "function of force {name:?}: uses the simulation that calls it, which is within a step: a callable may use its arguments \
         (time, position and velocity of its body) and values stored before the run only"
    ));
    told.set_cause(py, Some(error));
    told
}

/// Raise the stored exception of a callable, once.
pub(super) fn take(raised: &Raised) -> PyResult<()> {
    match raised.lock().ok().and_then(|mut slot| slot.take()) {
        Some(error) => Err(error),
        None => Ok(()),
    }
}

//! The integrator for Python: an ordinary differential equation given as a Python function.

use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{Error, Result, check};
use crate::integrator::{Adams, OdeSystem, StepControl};

/// Python callable as an ODE system; its first exception ends the run.
struct Callable<'py> {
    function: Bound<'py, PyAny>,
    dimension: usize,
    failure: Option<PyErr>,
}

impl Callable<'_> {
    fn call(&self, t: f64, y: &[f64], dydt: &mut [f64]) -> PyResult<()> {
        let py = self.function.py();
        let values = self.function.call1((t, PyArray1::from_slice(py, y)))?;
        let array = py
            .import("numpy")?
            .call_method1("asarray", (values, "float64"))?;
        let array = array.cast_into::<PyArray1<f64>>()?;
        let array = array.readonly();
        let found = array.as_array();
        if found.len() != dydt.len() {
            let value = format!("{} values", found.len());
            let expected = format!("must return {} values", dydt.len());
            return Err(Error::invalid("fun", value, expected).into());
        }
        for (slot, value) in dydt.iter_mut().zip(found) {
            *slot = *value;
        }
        Ok(())
    }
}

impl OdeSystem for Callable<'_> {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn derivative(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        if self.failure.is_none() {
            self.failure = self.call(t, y, dydt).err();
        }
        if self.failure.is_some() {
            dydt.fill(f64::NAN);
        }
    }
}

/// Maximum number of values returned by [`integrate`]: a gigabyte.
const MOST_VALUES: f64 = 1.25e8;

/// Check the span, the step control and the times of the values, `unknowns` at each.
fn check_integration(
    t_span: (f64, f64),
    control: &StepControl,
    times: &[f64],
    unknowns: usize,
) -> Result<()> {
    check::finite("t_span (start)", t_span.0, "s")?;
    check::finite("t_span (end)", t_span.1, "s")?;
    if t_span.1 <= t_span.0 {
        let shown = format!("{t_span:?}");
        return Err(Error::invalid("t_span", shown, "must end after it begins"));
    }
    control.validate()?;
    let rounding = f64::EPSILON * t_span.0.abs().max(t_span.1.abs());
    if control.max_step < rounding {
        let expected = format!("must be at least {rounding:.1e} s, the rounding of t_span");
        return Err(Error::invalid(
            "Solver.max_step",
            control.max_step,
            expected,
        ));
    }
    if !control.is_by_component() {
        let expected = "rtol and atol must not both be zero";
        return Err(Error::invalid("Solver.atol", control.atol, expected));
    }
    let within = |t: &f64| (t_span.0..=t_span.1).contains(t);
    if !times.iter().all(within) || !times.is_sorted() {
        let expected = "must rise and lie within t_span";
        return Err(Error::invalid("t_eval", "its times", expected));
    }
    let values = times.len() as f64 * unknowns as f64;
    check::within("t_eval times y0", values, 0.0, MOST_VALUES)
}

/// Integrate y' = fun(t, y) with the embedded Adams-Bashforth-Moulton method.
#[pyfunction]
#[allow(clippy::too_many_arguments, clippy::needless_pass_by_value)] // signature of SciPy; PyO3 passes arrays by value
pub(super) fn integrate<'py>(
    fun: &Bound<'py, PyAny>,
    t_span: (f64, f64),
    y0: PyReadonlyArray1<'py, f64>,
    rtol: f64,
    atol: f64,
    max_step: f64,
    max_order: usize,
    t_eval: Option<PyReadonlyArray1<'py, f64>>,
) -> PyResult<Bound<'py, PyDict>> {
    let py = fun.py();
    let mut control = StepControl {
        rtol,
        atol,
        max_step,
        max_order,
        ..StepControl::default()
    };
    let y0 = y0.as_array().to_vec();
    let times = match t_eval {
        Some(times) => times.as_array().to_vec(),
        None => vec![t_span.1],
    };
    check_integration(t_span, &control, &times, y0.len())?;
    control.max_step = max_step.min(t_span.1 - t_span.0);
    let mut system = Callable {
        function: fun.clone(),
        dimension: y0.len(),
        failure: None,
    };
    let mut adams = Adams::new(y0.len(), control);
    adams.restart(t_span.0, &y0);
    let mut rows = vec![0.0; times.len() * y0.len()];
    for (&t, row) in times.iter().zip(rows.chunks_mut(y0.len().max(1))) {
        while adams.time() < t {
            let outcome = adams.step(&mut system);
            if let Some(failure) = system.failure.take() {
                return Err(failure);
            }
            py.check_signals()?;
            outcome.map_err(|failure| {
                let name = |_, component| format!("component {component}");
                PyErr::from(failure.into_error(name))
            })?;
        }
        adams.interpolate(t, row);
    }
    let counts = adams.counts();
    let found = PyDict::new(py);
    let (count, width) = (times.len(), y0.len());
    found.set_item("t", times.into_pyarray(py))?;
    found.set_item("y", rows.into_pyarray(py).reshape([count, width])?)?;
    found.set_item("evaluations", counts.evaluations)?;
    found.set_item("steps", counts.steps)?;
    found.set_item("rejected", counts.rejected)?;
    Ok(found)
}

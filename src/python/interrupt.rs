//! Handling of Ctrl-C while the compiled module is running.

use std::cell::{Cell, RefCell};
use std::time::{Duration, Instant};

use pyo3::prelude::*;

/// Wall time between two checks for Ctrl-C: well below the 0.2 s within which it must act.
const BETWEEN_LOOKS: Duration = Duration::from_millis(50);

/// Run `work` with the interpreter released. `work` ends soon after the function passed to it returns true: Ctrl-C was pressed, or another
/// signal's handler has raised an exception, which is then raised here.
pub(super) fn interruptible<T: Send>(
    py: Python<'_>,
    work: impl FnOnce(&dyn Fn() -> bool) -> T + Send,
) -> PyResult<T> {
    let (done, raised) = py.detach(|| {
        let (looked, raised) = (Cell::new(Instant::now()), RefCell::new(None));
        let done = work(&|| {
            if raised.borrow().is_some() {
                return true;
            }
            if looked.get().elapsed() < BETWEEN_LOOKS {
                return false;
            }
            looked.set(Instant::now());
            #[allow(clippy::redundant_closure_for_method_calls)]
            // the lifetime of the method is not general enough
            let error = Python::attach(|py| py.check_signals()).err();
            let stops = error.is_some();
            raised.replace(error);
            stops
        });
        (done, raised.into_inner())
    });
    raised.map_or(Ok(done), Err)
}

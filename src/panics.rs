//! Panics converted to errors: a run keeps its recording, and Python receives an exception instead of a panic.

use std::any::Any;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};

#[cfg(any(feature = "python", feature = "fmu"))]
use crate::error::{Error, Result};

thread_local! {
    /// Source location of the last panic of this thread; empty unless [`keep_places`] was called.
    static PLACE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Record the source location of every panic for its error instead of printing it: an extension module writes nothing to standard error.
///
/// The hook belongs to this copy of the standard library. Other extension modules of the process have their own.
#[cfg(any(feature = "python", feature = "fmu"))]
pub(crate) fn keep_places() {
    std::panic::set_hook(Box::new(|info| {
        let place = info.location().map(|at| format!(" ({at})"));
        PLACE.set(place.unwrap_or_default());
    }));
}

/// Return the result of `work`, or the message and the source location of its panic.
pub(crate) fn guarded<T>(work: impl FnOnce() -> T) -> std::result::Result<T, String> {
    // Callers discard the state that `work` left incomplete, or refuse to continue with it.
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| message_of(panic.as_ref()) + &place())
}

/// Return the result of a fallible `work`; convert a panic to an error.
#[cfg(any(feature = "python", feature = "fmu"))]
pub(crate) fn contained<T>(work: impl FnOnce() -> Result<T>) -> Result<T> {
    guarded(work).unwrap_or_else(|message| {
        let time = None;
        Err(Error::Panicked { time, message })
    })
}

/// Return the source location of the last panic of this thread, in parentheses, and clear it.
pub(crate) fn place() -> String {
    PLACE.take()
}

fn message_of(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    text.unwrap_or("without a message").to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_with_its_message() {
        let message = |work: fn()| guarded(work).unwrap_err();
        assert_eq!(message(|| panic!("body {}", 7)), "body 7");
        assert_eq!(
            message(|| panic!("index out of bounds")),
            "index out of bounds"
        );
        let nothing = message(|| std::panic::resume_unwind(Box::new(1)));
        assert_eq!(nothing, "without a message");
        assert_eq!(guarded(|| 1), Ok(1));
    }
}

//! Panics, which are defects of this crate, as errors: a run keeps what it has recorded, and a caller in Python meets no panic.

use std::any::Any;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};

#[cfg(feature = "python")]
use crate::error::{Error, Result};

thread_local! {
    /// Where the last panic of this thread arose; empty unless [`keep_places`] was called.
    static PLACE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Keeps the place of every panic for its error, instead of printing it: an extension module writes nothing to standard error.
///
/// The hook belongs to this copy of the standard library; other extension modules of the process have their own.
#[cfg(feature = "python")]
pub(crate) fn keep_places() {
    std::panic::set_hook(Box::new(|info| {
        let place = info.location().map(|at| format!(" ({at})"));
        PLACE.set(place.unwrap_or_default());
    }));
}

/// Returns what `work` returns, or the message and the place of its panic.
pub(crate) fn guarded<T>(work: impl FnOnce() -> T) -> std::result::Result<T, String> {
    // Callers drop what `work` left half changed, or refuse to go on with it.
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| message_of(panic.as_ref()) + &place())
}

/// The same of work that may fail.
#[cfg(feature = "python")]
pub(crate) fn contained<T>(work: impl FnOnce() -> Result<T>) -> Result<T> {
    guarded(work).unwrap_or_else(|message| {
        let time = None;
        Err(Error::Panicked { time, message })
    })
}

/// Where the last panic of this thread arose, in parentheses; it is forgotten.
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

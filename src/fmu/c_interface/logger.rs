//! Loggers of masters: functions of FMI 2.0 and 3.0 that take the messages of an instance.

use std::ffi::{CStr, CString, c_char, c_void};

use super::{ERROR, Status};
use crate::error::Error;

/// Category of all messages, as in the model description.
const CATEGORY: &CStr = c"logStatusError";

/// Logger of FMI 2.0: environment, name of the instance, status, category, format of printf and its arguments.
pub(super) type Logger2 =
    unsafe extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char, ...);

/// Logger of FMI 3.0: environment, status, category, message.
pub(super) type Logger3 = unsafe extern "C" fn(*mut c_void, Status, *const c_char, *const c_char);

/// Logger of a master.
pub(super) enum Logger {
    None,
    Fmi2(Logger2, *mut c_void, CString),
    Fmi3(Logger3, *mut c_void),
}

impl Logger {
    /// Pass an error to the master.
    pub(super) fn log(&self, error: &Error) {
        let text = error.to_string().replace('\0', " ");
        match self {
            Self::None => {}
            Self::Fmi2(logger, environment, name) => {
                // The text is a format of printf.
                let text = CString::new(text.replace('%', "%%")).unwrap_or_default();
                // SAFETY: the master gave this function and its environment for calls until the instance is freed; the texts end in zero.
                unsafe {
                    logger(
                        *environment,
                        name.as_ptr(),
                        ERROR,
                        CATEGORY.as_ptr(),
                        text.as_ptr(),
                    );
                }
            }
            Self::Fmi3(logger, environment) => {
                let text = CString::new(text).unwrap_or_default();
                // SAFETY: as above.
                unsafe { logger(*environment, ERROR, CATEGORY.as_ptr(), text.as_ptr()) };
            }
        }
    }
}

//! C functions of FMI 2.0 and 3.0 over [`Instance`].
//!
//! All unsafe code of the crate is here: the standards pass handles, arrays and texts as pointers. The types are those of the headers of
//! the standards. No panic crosses the boundary: it is the status "error" and a message to the logger of the master.

#![allow(unsafe_code)] // C interface
#![allow(non_snake_case)] // names of the standards

mod fmi2;
mod fmi3;
mod logger;

use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::Path;
use std::sync::Once;

use logger::{Logger, Logger2, Logger3};

use super::{Contents, Instance, InstanceState};
use crate::error::{Error, Result};
use crate::panics::{contained, keep_places};

/// Status of a function; both standards have the same numbers.
type Status = c_int;
const OK: Status = 0;
const DISCARD: Status = 2;
const ERROR: Status = 3;

/// File of the scene in the folder of resources.
const SCENE: &str = "scene.bin";

/// Object behind a handle of the master.
struct Slave {
    instance: Instance,
    logger: Logger,
}

/// Return the handle of a new instance; null after an error, which is logged.
fn instantiate(logger: Logger, make: impl FnOnce() -> Result<Instance>) -> *mut c_void {
    static HOOK: Once = Once::new();
    HOOK.call_once(keep_places);
    match contained(make) {
        Ok(instance) => Box::into_raw(Box::new(Slave { instance, logger })).cast(),
        Err(error) => {
            logger.log(&error);
            std::ptr::null_mut()
        }
    }
}

/// Return an instance of the scene in the folder `resources`.
fn open(resources: &Path, token: &str) -> Result<Instance> {
    let path = resources.join(SCENE);
    let bytes = std::fs::read(&path).map_err(|error| {
        let expected = format!("cannot be read ({error}): unpack the FMU again");
        Error::invalid("scene of the FMU", path.display(), expected)
    })?;
    Instance::new(Contents::from_bytes(&bytes, token)?)
}

/// Free the instance behind `handle`.
///
/// # Safety
/// `handle` is null or one of [`instantiate`] that was not freed.
unsafe fn free(handle: *mut c_void) {
    if !handle.is_null() {
        // SAFETY: by the condition of this function, the box was made by `instantiate` and has no other owner.
        drop(unsafe { Box::from_raw(handle.cast::<Slave>()) });
    }
}

/// Call `action` with the instance behind `handle`; its error or panic is logged.
///
/// # Safety
/// `handle` is null or one of [`instantiate`] that was not freed, and no other call with it is active.
unsafe fn call(handle: *mut c_void, action: impl FnOnce(&mut Instance) -> Result<()>) -> Status {
    // SAFETY: by the condition of this function.
    let Some(slave) = (unsafe { handle.cast::<Slave>().as_mut() }) else {
        return ERROR;
    };
    match contained(|| action(&mut slave.instance)) {
        Ok(()) => OK,
        Err(error) => {
            slave.logger.log(&error);
            ERROR
        }
    }
}

/// Refuse a function of a capability that the FMU does not have.
///
/// # Safety
/// As of [`call`].
unsafe fn refuse(handle: *mut c_void, function: &str) -> Status {
    let refusal = || {
        let expected = "is of a capability that the model description does not announce";
        Error::invalid("function", function, expected)
    };
    // SAFETY: as of this function.
    unsafe { call(handle, |_| Err(refusal())) }
}

/// Define functions that the FMU refuses.
macro_rules! refused {
    ($($name:ident($($argument:ty),*);)*) => {$(
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $name(handle: *mut c_void $(, _: $argument)*) -> Status {
            // SAFETY: the master passes a handle of this library.
            unsafe { $crate::fmu::c_interface::refuse(handle, stringify!($name)) }
        }
    )*};
}

/// Define getters and setters of types that no variable has: they do nothing for no variables, and refuse others.
macro_rules! without_variables {
    ($($name:ident($($argument:ty),*);)*) => {$(
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $name(
            handle: *mut c_void,
            _: *const u32,
            count: usize
            $(, _: $argument)*
        ) -> Status {
            if count == 0 {
                return OK;
            }
            // SAFETY: the master passes a handle of this library.
            unsafe { $crate::fmu::c_interface::refuse(handle, stringify!($name)) }
        }
    )*};
}
/// Define functions that pass the handle and their arguments on to a function of this module.
macro_rules! forwarded {
    ($($name:ident($($argument:ident: $kind:ty),*) => $function:ident;)*) => {$(
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $name(handle: *mut c_void $(, $argument: $kind)*) -> Status {
            // SAFETY: the master passes a handle of this library, and states and arrays as the function has them.
            unsafe { $crate::fmu::c_interface::$function(handle $(, $argument)*) }
        }
    )*};
}

/// Define functions that call a method of the instance without arguments.
macro_rules! called {
    ($($name:ident => $method:ident;)*) => {$(
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $name(handle: *mut c_void) -> Status {
            // SAFETY: the master passes a handle of this library.
            unsafe { $crate::fmu::c_interface::call(handle, $crate::fmu::Instance::$method) }
        }
    )*};
}
use {called, forwarded, refused, without_variables};

/// Return the array of `count` elements at `pointer`.
///
/// # Safety
/// `pointer` is null, or readable for `count` elements while the array is used.
unsafe fn array<'a, T>(pointer: *const T, count: usize) -> Result<&'a [T]> {
    if count == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() {
        return Err(null("array"));
    }
    // SAFETY: by the condition of this function.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// Write `value` to `pointer`.
///
/// # Safety
/// `pointer` is null or writable.
unsafe fn put<T>(pointer: *mut T, value: T) -> Result<()> {
    if pointer.is_null() {
        return Err(null("pointer"));
    }
    // SAFETY: by the condition of this function.
    unsafe { pointer.write(value) };
    Ok(())
}

/// Return the text at `pointer`.
///
/// # Safety
/// `pointer` is null or a text that ends in zero.
unsafe fn text(pointer: *const c_char, name: &str) -> Result<String> {
    if pointer.is_null() {
        return Err(null(name));
    }
    // SAFETY: by the condition of this function.
    let text = unsafe { CStr::from_ptr(pointer) };
    Ok(text.to_string_lossy().into_owned())
}

fn null(name: &str) -> Error {
    Error::invalid(name, "null", "must not be a null pointer")
}

/// Write the values of variables.
///
/// # Safety
/// As of [`call`], [`array`] and [`put`] for `count` elements.
unsafe fn get_values(
    handle: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut f64,
) -> Status {
    let action = |instance: &mut Instance| {
        // SAFETY: by the condition of this function.
        let references = unsafe { array(references, count) }?;
        for (i, &reference) in references.iter().enumerate() {
            // SAFETY: `values` has as many elements as `references`.
            unsafe { put(values.wrapping_add(i), instance.value(reference)?) }?;
        }
        Ok(())
    };
    // SAFETY: by the condition of this function.
    unsafe { call(handle, action) }
}

/// Set the values of inputs.
///
/// # Safety
/// As of [`call`] and [`array`] for `count` elements.
unsafe fn set_values(
    handle: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const f64,
) -> Status {
    let action = |instance: &mut Instance| {
        // SAFETY: by the condition of this function.
        let (references, values) = unsafe { (array(references, count)?, array(values, count)?) };
        let mut pairs = references.iter().zip(values);
        pairs.try_for_each(|(&reference, &value)| instance.set_value(reference, value))
    };
    // SAFETY: by the condition of this function.
    unsafe { call(handle, action) }
}

/// Write the state of the instance to `*state`: a new one, or the one that is there already.
///
/// # Safety
/// As of [`call`]; `*state` is null or a state of this library that was not freed.
unsafe fn get_state(handle: *mut c_void, state: *mut *mut c_void) -> Status {
    let action = |instance: &mut Instance| {
        let found = instance.state()?;
        // SAFETY: by the condition of this function.
        unsafe { store(state, found) }
    };
    // SAFETY: by the condition of this function.
    unsafe { call(handle, action) }
}

/// Write `found` to the state behind `*state`, or to a new one.
///
/// # Safety
/// `state` is null or writable; `*state` is null or a state of this library that was not freed.
unsafe fn store(state: *mut *mut c_void, found: InstanceState) -> Result<()> {
    // SAFETY: by the condition of this function.
    let Some(handle) = (unsafe { state.as_mut() }) else {
        return Err(null("state"));
    };
    // SAFETY: by the condition of this function.
    if let Some(old) = unsafe { handle.cast::<InstanceState>().as_mut() } {
        *old = found;
    } else {
        *handle = Box::into_raw(Box::new(found)).cast();
    }
    Ok(())
}

/// Return the state behind a handle.
///
/// # Safety
/// `state` is null or a state of this library that is not freed while it is used.
unsafe fn state_of<'a>(state: *mut c_void) -> Result<&'a InstanceState> {
    // SAFETY: by the condition of this function.
    unsafe { state.cast::<InstanceState>().as_ref() }.ok_or_else(|| null("state"))
}

/// Continue from a state.
///
/// # Safety
/// As of [`call`] and [`state_of`].
unsafe fn set_state(handle: *mut c_void, state: *mut c_void) -> Status {
    // SAFETY: by the condition of this function.
    unsafe { call(handle, |instance| instance.set_state(state_of(state)?)) }
}

/// Free the state behind `*state` and set `*state` to null.
///
/// # Safety
/// As of [`store`].
unsafe fn free_state(_: *mut c_void, state: *mut *mut c_void) -> Status {
    // SAFETY: by the condition of this function; the box was made by `store` and has no other owner.
    unsafe {
        if let Some(handle) = state.as_mut()
            && !handle.is_null()
        {
            drop(Box::from_raw(handle.cast::<InstanceState>()));
            *handle = std::ptr::null_mut();
        }
    }
    OK
}

/// Write the number of bytes of a state.
///
/// # Safety
/// As of [`call`], [`state_of`] and [`put`].
unsafe fn serialized_size(handle: *mut c_void, state: *mut c_void, size: *mut usize) -> Status {
    // SAFETY: by the condition of this function.
    unsafe { call(handle, |_| put(size, state_of(state)?.to_bytes()?.len())) }
}

/// Write the bytes of a state.
///
/// # Safety
/// As of [`call`] and [`state_of`]; `bytes` is null or writable for `size` bytes.
unsafe fn serialize(
    handle: *mut c_void,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> Status {
    let action = |_: &mut Instance| {
        // SAFETY: by the condition of this function.
        let found = unsafe { state_of(state) }?.to_bytes()?;
        if bytes.is_null() {
            return Err(null("serialized state"));
        }
        if size < found.len() {
            let expected = format!("must be at least {} bytes", found.len());
            let field = "size of the serialized state";
            return Err(Error::invalid(field, size, expected));
        }
        // SAFETY: `bytes` is writable for `size` bytes, no fewer than `found` has.
        unsafe { bytes.copy_from_nonoverlapping(found.as_ptr(), found.len()) };
        Ok(())
    };
    // SAFETY: by the condition of this function.
    unsafe { call(handle, action) }
}

/// Write the state of `size` bytes to `*state`.
///
/// # Safety
/// As of [`call`], [`array`] and [`store`].
unsafe fn deserialize(
    handle: *mut c_void,
    bytes: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> Status {
    // SAFETY: by the condition of this function.
    unsafe {
        call(handle, |_| {
            store(state, InstanceState::from_bytes(array(bytes, size)?)?)
        })
    }
}

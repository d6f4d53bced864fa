//! Functions of FMI 2.0 for co-simulation.

use std::ffi::{CStr, CString, c_char, c_int, c_void};

use super::{
    DISCARD, ERROR, Logger, Logger2, OK, Status, call, called, forwarded, free, instantiate, open,
    put, refused, text, without_variables,
};
use crate::error::Error;
use crate::fmu::resource_uri::path_of;

/// Kind of FMU for co-simulation, `fmi2CoSimulation`.
const CO_SIMULATION: c_int = 1;
/// Kinds of status, of `fmi2StatusKind`.
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

/// Functions of the master, `fmi2CallbackFunctions`.
#[repr(C)]
struct Callbacks {
    logger: Option<Logger2>,
    allocate_memory: *const c_void,
    free_memory: *const c_void,
    step_finished: *const c_void,
    environment: *mut c_void,
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// Accept any request: errors are always logged, and there are no other messages.
#[unsafe(no_mangle)]
extern "C" fn fmi2SetDebugLogging(
    _: *mut c_void,
    _: c_int,
    _: usize,
    _: *const *const c_char,
) -> Status {
    OK
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2Instantiate(
    name: *const c_char,
    kind: c_int,
    token: *const c_char,
    resources: *const c_char,
    callbacks: *const Callbacks,
    _visible: c_int,
    _logging_on: c_int,
) -> *mut c_void {
    // SAFETY: the master passes its functions or null, and texts.
    let logger = match unsafe { callbacks.as_ref() } {
        Some(&Callbacks {
            logger: Some(logger),
            environment,
            ..
        }) => {
            let name = if name.is_null() {
                CString::default()
            } else {
                // SAFETY: a text that ends in zero.
                unsafe { CStr::from_ptr(name) }.to_owned()
            };
            Logger::Fmi2(logger, environment, name)
        }
        _ => Logger::None,
    };
    instantiate(logger, || {
        if kind != CO_SIMULATION {
            let expected = "must be 1, co-simulation: the FMU has no other interface";
            return Err(Error::invalid("fmuType", kind, expected));
        }
        // SAFETY: the master passes texts or null.
        let (token, resources) = unsafe {
            (
                text(token, "fmuGUID")?,
                text(resources, "fmuResourceLocation")?,
            )
        };
        open(&path_of(&resources)?, &token)
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2FreeInstance(handle: *mut c_void) {
    // SAFETY: the master passes a handle of this library, and does not use it again.
    unsafe { free(handle) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2SetupExperiment(
    handle: *mut c_void,
    _tolerance_defined: c_int,
    _tolerance: f64,
    start_time: f64,
    stop_time_defined: c_int,
    stop_time: f64,
) -> Status {
    let stop = (stop_time_defined != 0).then_some(stop_time);
    // SAFETY: the master passes a handle of this library.
    unsafe { call(handle, |instance| instance.set_times(start_time, stop)) }
}

called! {
    fmi2EnterInitializationMode => enter_initialization;
    fmi2ExitInitializationMode => exit_initialization;
    fmi2Terminate => terminate;
    fmi2Reset => reset;
}

without_variables! {
    fmi2GetInteger(*mut c_int);
    fmi2GetBoolean(*mut c_int);
    fmi2GetString(*mut *const c_char);
    fmi2SetInteger(*const c_int);
    fmi2SetBoolean(*const c_int);
    fmi2SetString(*const *const c_char);
    fmi2SetRealInputDerivatives(*const c_int, *const f64);
    fmi2GetRealOutputDerivatives(*const c_int, *mut f64);
}

forwarded! {
    fmi2GetReal(references: *const u32, count: usize, values: *mut f64) => get_values;
    fmi2SetReal(references: *const u32, count: usize, values: *const f64) => set_values;
    fmi2GetFMUstate(state: *mut *mut c_void) => get_state;
    fmi2SetFMUstate(state: *mut c_void) => set_state;
    fmi2FreeFMUstate(state: *mut *mut c_void) => free_state;
    fmi2SerializedFMUstateSize(state: *mut c_void, size: *mut usize) => serialized_size;
    fmi2SerializeFMUstate(state: *mut c_void, bytes: *mut u8, size: usize) => serialize;
    fmi2DeSerializeFMUstate(bytes: *const u8, size: usize, state: *mut *mut c_void) => deserialize;
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2DoStep(handle: *mut c_void, time: f64, size: f64, _: c_int) -> Status {
    // SAFETY: the master passes a handle of this library.
    unsafe { call(handle, |instance| instance.step(time, size)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetRealStatus(
    handle: *mut c_void,
    kind: c_int,
    value: *mut f64,
) -> Status {
    if kind != LAST_SUCCESSFUL_TIME {
        return DISCARD;
    }
    // SAFETY: the master passes a handle of this library.
    unsafe { call(handle, |instance| put(value, instance.time())) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetBooleanStatus(
    _: *mut c_void,
    kind: c_int,
    value: *mut c_int,
) -> Status {
    if kind != TERMINATED {
        return DISCARD;
    }
    // SAFETY: the master passes a pointer to a truth value. The FMU never asks to be terminated.
    unsafe { put(value, 0) }.map_or(ERROR, |()| OK)
}

/// Return that there is no such status: steps are synchronous.
#[unsafe(no_mangle)]
extern "C" fn fmi2GetStatus(_: *mut c_void, _: c_int, _: *mut Status) -> Status {
    DISCARD
}

/// Return that there is no such status: steps are synchronous.
#[unsafe(no_mangle)]
extern "C" fn fmi2GetIntegerStatus(_: *mut c_void, _: c_int, _: *mut c_int) -> Status {
    DISCARD
}

/// Return that there is no such status: steps are synchronous.
#[unsafe(no_mangle)]
extern "C" fn fmi2GetStringStatus(_: *mut c_void, _: c_int, _: *mut *const c_char) -> Status {
    DISCARD
}

refused! {
    fmi2GetDirectionalDerivative(*const u32, usize, *const u32, usize, *const f64, *mut f64);
    fmi2CancelStep();
}

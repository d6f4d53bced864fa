//! Functions of FMI 3.0 for co-simulation, and the refused functions of its other interfaces.

use std::ffi::{c_char, c_int, c_void};
use std::path::Path;

use super::{
    Logger, Logger3, OK, Status, call, called, forwarded, free, get_values, instantiate, open, put,
    refused, set_values, text, without_variables,
};
use crate::error::{Error, Result};

#[unsafe(no_mangle)]
extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Accept any request: errors are always logged, and there are no other messages.
#[unsafe(no_mangle)]
extern "C" fn fmi3SetDebugLogging(
    _: *mut c_void,
    _: bool,
    _: usize,
    _: *const *const c_char,
) -> Status {
    OK
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    _logging_on: bool,
    _event_mode_used: bool,
    _early_return_allowed: bool,
    _intermediate_variables: *const u32,
    _intermediate_count: usize,
    environment: *mut c_void,
    logger: Option<Logger3>,
    _intermediate_update: *const c_void,
) -> *mut c_void {
    let logger = logger.map_or(Logger::None, |logger| Logger::Fmi3(logger, environment));
    instantiate(logger, || {
        // SAFETY: the master passes texts or null.
        let (token, resources) = unsafe {
            (
                text(token, "instantiationToken")?,
                text(resources, "resourcePath")?,
            )
        };
        open(Path::new(&resources), &token)
    })
}

fn other_interface(environment: *mut c_void, logger: Option<Logger3>, kind: &str) -> *mut c_void {
    let logger = logger.map_or(Logger::None, |logger| Logger::Fmi3(logger, environment));
    instantiate(logger, || {
        let expected = "the FMU is one for co-simulation";
        Err(Error::invalid("interface", kind, expected))
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi3InstantiateModelExchange(
    _: *const c_char,
    _: *const c_char,
    _: *const c_char,
    _: bool,
    _: bool,
    environment: *mut c_void,
    logger: Option<Logger3>,
) -> *mut c_void {
    other_interface(environment, logger, "model exchange")
}

#[unsafe(no_mangle)]
extern "C" fn fmi3InstantiateScheduledExecution(
    _: *const c_char,
    _: *const c_char,
    _: *const c_char,
    _: bool,
    _: bool,
    environment: *mut c_void,
    logger: Option<Logger3>,
    _clock_update: *const c_void,
    _lock: *const c_void,
    _unlock: *const c_void,
) -> *mut c_void {
    other_interface(environment, logger, "scheduled execution")
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3FreeInstance(handle: *mut c_void) {
    // SAFETY: the master passes a handle of this library, and does not use it again.
    unsafe { free(handle) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3EnterInitializationMode(
    handle: *mut c_void,
    _tolerance_defined: bool,
    _tolerance: f64,
    start_time: f64,
    stop_time_defined: bool,
    stop_time: f64,
) -> Status {
    let stop = stop_time_defined.then_some(stop_time);
    // SAFETY: the master passes a handle of this library.
    unsafe {
        call(handle, |instance| {
            instance.set_times(start_time, stop)?;
            instance.enter_initialization()
        })
    }
}

called! {
    fmi3ExitInitializationMode => exit_initialization;
    fmi3Terminate => terminate;
    fmi3Reset => reset;
}

/// Check that there is one value for each variable: all are scalars.
fn check_count(count: usize, values: usize) -> Result<()> {
    if count == values {
        return Ok(());
    }
    let expected = format!("must be the number of value references, {count}");
    Err(Error::invalid("nValues", values, expected))
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3GetFloat64(
    handle: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut f64,
    value_count: usize,
) -> Status {
    // SAFETY: the master passes a handle of this library, and arrays of these numbers of elements.
    unsafe {
        match call(handle, |_| check_count(count, value_count)) {
            OK => get_values(handle, references, count, values),
            error => error,
        }
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SetFloat64(
    handle: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const f64,
    value_count: usize,
) -> Status {
    // SAFETY: the master passes a handle of this library, and arrays of these numbers of elements.
    unsafe {
        match call(handle, |_| check_count(count, value_count)) {
            OK => set_values(handle, references, count, values),
            error => error,
        }
    }
}

without_variables! {
    fmi3GetFloat32(*mut f32, usize);
    fmi3GetInt8(*mut i8, usize);
    fmi3GetUInt8(*mut u8, usize);
    fmi3GetInt16(*mut i16, usize);
    fmi3GetUInt16(*mut u16, usize);
    fmi3GetInt32(*mut i32, usize);
    fmi3GetUInt32(*mut u32, usize);
    fmi3GetInt64(*mut i64, usize);
    fmi3GetUInt64(*mut u64, usize);
    fmi3GetBoolean(*mut bool, usize);
    fmi3GetString(*mut *const c_char, usize);
    fmi3GetBinary(*mut usize, *mut *const u8, usize);
    fmi3GetClock(*mut bool);
    fmi3SetFloat32(*const f32, usize);
    fmi3SetInt8(*const i8, usize);
    fmi3SetUInt8(*const u8, usize);
    fmi3SetInt16(*const i16, usize);
    fmi3SetUInt16(*const u16, usize);
    fmi3SetInt32(*const i32, usize);
    fmi3SetUInt32(*const u32, usize);
    fmi3SetInt64(*const i64, usize);
    fmi3SetUInt64(*const u64, usize);
    fmi3SetBoolean(*const bool, usize);
    fmi3SetString(*const *const c_char, usize);
    fmi3SetBinary(*const usize, *const *const u8, usize);
    fmi3SetClock(*const bool);
    fmi3GetIntervalDecimal(*mut f64, *mut c_int);
    fmi3GetIntervalFraction(*mut u64, *mut u64, *mut c_int);
    fmi3GetShiftDecimal(*mut f64);
    fmi3GetShiftFraction(*mut u64, *mut u64);
    fmi3SetIntervalDecimal(*const f64);
    fmi3SetIntervalFraction(*const u64, *const u64);
    fmi3SetShiftDecimal(*const f64);
    fmi3SetShiftFraction(*const u64, *const u64);
    fmi3GetOutputDerivatives(*const i32, *mut f64, usize);
}

forwarded! {
    fmi3GetFMUState(state: *mut *mut c_void) => get_state;
    fmi3SetFMUState(state: *mut c_void) => set_state;
    fmi3FreeFMUState(state: *mut *mut c_void) => free_state;
    fmi3SerializedFMUStateSize(state: *mut c_void, size: *mut usize) => serialized_size;
    fmi3SerializeFMUState(state: *mut c_void, bytes: *mut u8, size: usize) => serialize;
    fmi3DeserializeFMUState(bytes: *const u8, size: usize, state: *mut *mut c_void) => deserialize;
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3DoStep(
    handle: *mut c_void,
    time: f64,
    size: f64,
    _: bool,
    event_handling_needed: *mut bool,
    terminate_simulation: *mut bool,
    early_return: *mut bool,
    last_successful_time: *mut f64,
) -> Status {
    // SAFETY: the master passes a handle of this library, and pointers to these values.
    unsafe {
        call(handle, |instance| {
            let stepped = instance.step(time, size);
            put(event_handling_needed, false)?;
            put(terminate_simulation, false)?;
            put(early_return, false)?;
            put(last_successful_time, instance.time())?;
            stepped
        })
    }
}

refused! {
    fmi3EnterEventMode();
    fmi3EnterStepMode();
    fmi3EnterConfigurationMode();
    fmi3ExitConfigurationMode();
    fmi3EvaluateDiscreteStates();
    fmi3UpdateDiscreteStates(*mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64);
    fmi3EnterContinuousTimeMode();
    fmi3CompletedIntegratorStep(bool, *mut bool, *mut bool);
    fmi3SetTime(f64);
    fmi3SetContinuousStates(*const f64, usize);
    fmi3GetContinuousStateDerivatives(*mut f64, usize);
    fmi3GetEventIndicators(*mut f64, usize);
    fmi3GetContinuousStates(*mut f64, usize);
    fmi3GetNominalsOfContinuousStates(*mut f64, usize);
    fmi3GetNumberOfEventIndicators(*mut usize);
    fmi3GetNumberOfContinuousStates(*mut usize);
    fmi3GetNumberOfVariableDependencies(u32, *mut usize);
    fmi3GetVariableDependencies(u32, *mut usize, *mut u32, *mut usize, *mut c_int, usize);
    fmi3GetDirectionalDerivative(
        *const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize
    );
    fmi3GetAdjointDerivative(
        *const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize
    );
    fmi3ActivateModelPartition(u32, f64);
}

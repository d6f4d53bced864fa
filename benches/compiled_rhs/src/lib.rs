//! The right-hand side of rustchain behind a C interface, and integrators that call it without Python in between.
//!
//! Only here, outside the product, may code be unsafe: C knows no other.

#![allow(clippy::missing_safety_doc)] // each function says what its pointers point at

mod cvode;
mod drive;
mod explicit;
#[path = "../../../tests/common/mod.rs"]
mod paper;
#[path = "../../work_precision/problems.rs"]
mod problems;
mod smooth;
mod system;

use std::cell::RefCell;
use std::ffi::{CStr, c_char};
use std::time::Duration;

use cpu_time::ThreadTime;
use drive::DriveSystem;
use problems::{Kepler, Pin};
use rustchain::ForceLaws;
use rustchain::layout::InitialConfiguration;
use system::{Accepted, Evolving};

/// What a run came to; the same layout in C.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub struct Outcome {
    /// Accepted steps.
    pub steps: u64,
    /// Evaluations of the right-hand side that the integrator asked for.
    pub evaluations: u64,
    /// Jacobians.
    pub jacobians: u64,
    /// Contacts begun.
    pub onsets: u64,
    /// 1 when the end was reached, 2 when the method failed, 0 when it was given up.
    pub finished: u64,
    /// Time reached \[s\].
    pub reached: f64,
    /// Processor time but for the search for onsets \[s\].
    pub wall: f64,
    /// Time of that search \[s\].
    pub uncharged: f64,
    /// Energy missing \[J\].
    pub residual: f64,
    /// Energy dissipated \[J\].
    pub dissipated: f64,
    /// Part of the processor time that is not in `wall` and is the same in every run \[s\].
    pub deducted: f64,
    /// Parts of the run, of which the caller has the times.
    pub parts: u64,
}

impl Outcome {
    /// Takes the time of the integration, which began with the `budget`.
    fn timed(mut self, budget: &Budget) -> Self {
        self.wall = budget.begin.elapsed().as_secs_f64() - self.uncharged;
        self
    }

    /// Does what this project's integrator does outside of its steps too, and takes the time.
    fn uncharged<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let begin = ThreadTime::now();
        let done = work();
        self.uncharged += begin.elapsed().as_secs_f64();
        done
    }

    fn finished(mut self, t: f64) -> Self {
        (self.finished, self.reached) = (1, t);
        self
    }

    fn unfinished(mut self, t: f64) -> Self {
        self.reached = t;
        self
    }

    fn failed(mut self, t: f64) -> Self {
        (self.finished, self.reached) = (2, t);
        self
    }
}

/// When a run that takes too long is given up, and the times of its parts.
struct Budget {
    begin: ThreadTime,
    wall: Duration,
    /// Processor time but for the search for onsets, at the ends of parts of so many steps \[s\].
    marks: RefCell<Vec<f64>>,
}

/// Steps of a part.
const STEPS_OF_A_PART: u64 = 64;

impl Budget {
    fn spent(&self, outcome: &Outcome) -> bool {
        if outcome.steps.is_multiple_of(STEPS_OF_A_PART) {
            let elapsed = self.begin.elapsed();
            let charged = elapsed.as_secs_f64() - outcome.uncharged;
            self.marks.borrow_mut().push(charged);
            return elapsed > self.wall;
        }
        false
    }
}

enum Problem {
    Drive(Box<DriveSystem>),
    Kepler(Kepler),
    Pin(Pin),
}

/// A system and, for integrators that step from outside, the end of its last step.
pub struct Handle {
    problem: Problem,
    start: Vec<f64>,
    last: (f64, Vec<f64>, Vec<f64>),
    slope: Vec<f64>,
}

impl Handle {
    fn new(problem: Problem) -> *mut Self {
        let start = match &problem {
            Problem::Drive(drive) => drive.start().to_vec(),
            Problem::Kepler(_) => Kepler::START.to_vec(),
            Problem::Pin(_) => Pin::START.to_vec(),
        };
        let mut handle = Box::new(Self {
            problem,
            last: (0.0, start.clone(), start.clone()),
            slope: start.clone(),
            start,
        });
        let Self { problem, last, .. } = &mut *handle;
        problem.evolving().derivative(0.0, &last.1, &mut last.2);
        Box::into_raw(handle)
    }
}

impl Problem {
    fn evolving(&mut self) -> &mut (dyn Evolving + 'static) {
        match self {
            Self::Drive(drive) => &mut **drive,
            Self::Kepler(kepler) => kepler,
            Self::Pin(pin) => pin,
        }
    }
}

/// The paper's drive with a pretension that grows in `ramp_time`. From `positions` and `velocities`, `bodies` rows of three
/// numbers each, or from the generated start when they are null; with its energies summed along every step when `metered`. Null
/// when there is no such drive.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drive_system(
    pretension: f64,
    ramp_time: f64,
    minimum: f64,
    positions: *const f64,
    velocities: *const f64,
    bodies: usize,
    metered: bool,
) -> *mut Handle {
    let mut drive = paper::paper_drive();
    if pretension > 0.0 {
        drive.tensioner = Some(paper::tensioner(pretension, ramp_time));
    }
    let laws = ForceLaws {
        min_impact_velocity: minimum,
        ..ForceLaws::default()
    };
    let start = if positions.is_null() {
        InitialConfiguration::generate(&drive).map(|(start, _)| start)
    } else {
        // SAFETY: the caller's arrays have that many rows.
        let rows = |numbers| {
            unsafe { std::slice::from_raw_parts(numbers, 3 * bodies) }
                .as_chunks::<3>()
                .0
                .to_vec()
        };
        Ok(InitialConfiguration {
            positions: rows(positions),
            velocities: rows(velocities),
            ..InitialConfiguration::default()
        })
    };
    let system = start.and_then(|start| DriveSystem::new(&drive, &laws, &start, metered));
    system.map_or(std::ptr::null_mut(), |system| {
        Handle::new(Problem::Drive(Box::new(system)))
    })
}

/// A planet on an ellipse.
#[unsafe(no_mangle)]
pub extern "C" fn kepler_system() -> *mut Handle {
    Handle::new(Problem::Kepler(Kepler::default()))
}

/// A pin that bounces; `lambda` is the damping of its law.
#[unsafe(no_mangle)]
pub extern "C" fn pin_system(lambda: f64) -> *mut Handle {
    Handle::new(Problem::Pin(Pin::new(lambda)))
}

/// Ends a system.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn system_free(handle: *mut Handle) {
    // SAFETY: made by `Handle::new`, ended once.
    drop(unsafe { Box::from_raw(handle) });
}

/// Number of components.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn system_dimension(handle: *const Handle) -> usize {
    // SAFETY: a live handle.
    unsafe { (*handle).start.len() }
}

/// Writes the state at time 0 into `y` and what an absolute tolerance of one stands for into `scale`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn system_start(handle: *mut Handle, y: *mut f64, scale: *mut f64) {
    // SAFETY: a live handle, and arrays of its dimension.
    unsafe {
        let handle = &mut *handle;
        let n = handle.start.len();
        std::slice::from_raw_parts_mut(y, n).copy_from_slice(&handle.start);
        std::slice::from_raw_parts_mut(scale, n)
            .copy_from_slice(&handle.problem.evolving().scale());
    }
}

/// dy/dt, in the signature that numbalsoda and others take; `system` is a handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn right_hand_side(
    t: f64,
    y: *const f64,
    slope: *mut f64,
    system: *mut Handle,
) {
    // SAFETY: a live handle, and arrays of its dimension.
    unsafe {
        let handle = &mut *system;
        let n = handle.start.len();
        let (y, slope) = (
            std::slice::from_raw_parts(y, n),
            std::slice::from_raw_parts_mut(slope, n),
        );
        handle.problem.evolving().derivative(t, y, slope);
    }
}

/// To be called after every accepted step of an integrator outside: finds onsets in it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn accepted_step(handle: *mut Handle, t: f64, y: *const f64) {
    // SAFETY: a live handle, and an array of its dimension.
    let handle = unsafe { &mut *handle };
    let y = unsafe { std::slice::from_raw_parts(y, handle.start.len()) };
    let Handle {
        problem,
        last,
        slope,
        ..
    } = handle;
    let system = problem.evolving();
    system.derivative(t, y, slope);
    let step = Accepted {
        start: last.0,
        end: t,
        y_start: &last.1,
        y_end: y,
        slope_start: &last.2,
        slope_end: slope,
    };
    if system.crossed(&step) {
        system.remember(&step);
    } else {
        system.pass(&step);
    }
    last.0 = t;
    last.1.copy_from_slice(y);
    last.2.copy_from_slice(slope);
}

/// Writes energy missing and dissipated \[J\], and the onsets so far, of a drive at (t, y).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drive_balance(handle: *mut Handle, t: f64, y: *const f64, out: *mut f64) {
    // SAFETY: a live handle, an array of its dimension and one of three numbers.
    unsafe {
        let y = std::slice::from_raw_parts(y, (*handle).start.len());
        if let Problem::Drive(drive) = &mut (*handle).problem {
            let [residual, dissipated] = drive.balance(t, y);
            let found = [residual, dissipated, drive.onsets() as f64];
            std::slice::from_raw_parts_mut(out, 3).copy_from_slice(&found);
        }
    }
}

/// Writes x, y, θ of all bodies of a drive at (t, y).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drive_positions(
    handle: *mut Handle,
    t: f64,
    y: *const f64,
    out: *mut f64,
) {
    // SAFETY: a live handle, an array of its dimension and one of three numbers a body.
    unsafe {
        let y = std::slice::from_raw_parts(y, (*handle).start.len());
        if let Problem::Drive(drive) = &mut (*handle).problem {
            let found = drive.positions(t, y);
            std::slice::from_raw_parts_mut(out, found.len()).copy_from_slice(&found);
        }
    }
}

/// Error of a bounced pin at its end, y.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pin_error(handle: *const Handle, y: *const f64) -> f64 {
    // SAFETY: a live handle, and an array of its dimension.
    let (handle, y) = unsafe { (&*handle, std::slice::from_raw_parts(y, 2)) };
    match &handle.problem {
        Problem::Pin(pin) => pin.error(y),
        _ => f64::NAN,
    }
}

/// An embedded pair; the arrays are the caller's, `error_3` may be empty.
#[repr(C)]
pub struct CTableau {
    stages: usize,
    order: f64,
    a: *const f64,
    b: *const f64,
    c: *const f64,
    error: *const f64,
    error_3: *const f64,
}

/// Integrates a system from its start to `end`, from where `y` is written. `method`: 0 classical Runge-Kutta with steps of
/// `tolerance`, 1 the embedded pair of `tableau`, 2 CVODE's Adams with functional iteration, 3 with Newton, 4 its BDF, all three
/// from the shared library at `library`. Writes the times at the ends of parts into `marks` \[s\], which has room for `room` of them.
/// Returns 0, or 1 when that library cannot be used.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn integrate(
    handle: *mut Handle,
    method: i32,
    tolerance: f64,
    end: f64,
    wall: f64,
    tableau: *const CTableau,
    library: *const c_char,
    y: *mut f64,
    marks: *mut f64,
    room: usize,
    outcome: *mut Outcome,
) -> i32 {
    // SAFETY: a live handle, arrays as `CTableau` and the dimension say, a C string.
    let (handle, y, marks, outcome) = unsafe {
        let handle = &mut *handle;
        let n = handle.start.len();
        let y = std::slice::from_raw_parts_mut(y, n);
        let marks = std::slice::from_raw_parts_mut(marks, room);
        (handle, y, marks, &mut *outcome)
    };
    y.copy_from_slice(&handle.start);
    let system = handle.problem.evolving();
    let budget = Budget {
        begin: ThreadTime::now(),
        wall: Duration::from_secs_f64(wall),
        marks: RefCell::default(),
    };
    let done = match method {
        0 => Ok(explicit::rk4(system, y, tolerance, end, &budget).timed(&budget)),
        1 => {
            // SAFETY: the tableau's arrays have the lengths that its stages ask for.
            let tableau = unsafe {
                let given = &*tableau;
                let (s, slice) = (given.stages, |p, n| std::slice::from_raw_parts::<f64>(p, n));
                let error_3 = if given.error_3.is_null() {
                    &[]
                } else {
                    slice(given.error_3, s + 1)
                };
                explicit::Tableau {
                    stages: s,
                    order: given.order,
                    a: slice(given.a, s * s),
                    b: slice(given.b, s),
                    c: slice(given.c, s),
                    error: slice(given.error, s + 1),
                    error_3,
                }
            };
            let done = explicit::embedded(system, &tableau, y, tolerance, end, &budget);
            Ok(done.timed(&budget))
        }
        _ => {
            let method = match method {
                2 => cvode::Method::AdamsFunctional,
                3 => cvode::Method::AdamsNewton,
                _ => cvode::Method::Bdf,
            };
            // SAFETY: a C string.
            let library = unsafe { CStr::from_ptr(library) }.to_string_lossy();
            cvode::run(&library, system, method, y, tolerance, end, &budget)
        }
    };
    let Ok(done) = done else { return 1 };
    *outcome = done;
    // The rest is one part, also where there are more parts than room.
    let mut found = budget.marks.into_inner();
    found.truncate(room - 1);
    found.push(done.wall + done.deducted);
    marks[..found.len()].copy_from_slice(&found);
    outcome.parts = found.len() as u64;
    if let Problem::Drive(drive) = &mut handle.problem {
        [outcome.residual, outcome.dissipated] = drive.balance(outcome.reached, y);
        outcome.onsets = drive.onsets();
    }
    0
}

//! CVODE of SUNDIALS, from a shared library that is loaded when it is asked for: Adams and BDF, one step at a time.

use std::ffi::{c_char, c_int, c_void};

use cpu_time::ThreadTime;
use libloading::Library;

use crate::system::{Accepted, Evolving};
use crate::{Budget, Outcome};

type Pointer = *mut c_void;

const ADAMS: c_int = 1;
const BDF: c_int = 2;
const ONE_STEP: c_int = 2;
const STOP_RETURN: c_int = 1;

/// Relative step of forward differences. In drives a length of one stands for 0.1 mm, a contact's own size.
const INCREMENT: f64 = 1e-8;

/// How CVODE solves its equation.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Method {
    AdamsFunctional,
    AdamsNewton,
    Bdf,
}

/// What the callbacks work on.
struct User {
    system: *mut dyn Evolving,
    component: Vec<usize>,
    half_width: usize,
    groups: Vec<Vec<usize>>,
    n: usize,
    y: Vec<f64>,
    slope: Vec<f64>,
    perturbed: Vec<f64>,
    /// Steps of the forward differences.
    increment: Vec<f64>,
    array: unsafe extern "C" fn(Pointer) -> *mut f64,
    column: unsafe extern "C" fn(Pointer, i64) -> *mut f64,
    evaluations: u64,
    jacobians: u64,
}

unsafe extern "C" fn right_hand_side(t: f64, y: Pointer, slope: Pointer, user: Pointer) -> c_int {
    // SAFETY: CVODE hands back what `run` gave it, vectors of n numbers and the user data, one call at a time.
    unsafe {
        let user = &mut *user.cast::<User>();
        let y = std::slice::from_raw_parts((user.array)(y), user.n);
        let out = std::slice::from_raw_parts_mut((user.array)(slope), user.n);
        for (place, &component) in user.component.iter().enumerate() {
            user.y[component] = y[place];
        }
        (*user.system).derivative(t, &user.y, &mut user.slope);
        for (place, &component) in user.component.iter().enumerate() {
            out[place] = user.slope[component];
        }
        user.evaluations += 1;
        c_int::from(!out.iter().all(|v| v.is_finite()))
    }
}

/// Forward differences, one evaluation for all columns of a group.
unsafe extern "C" fn jacobian(
    t: f64,
    y: Pointer,
    slope: Pointer,
    matrix: Pointer,
    user: Pointer,
    _: Pointer,
    _: Pointer,
    _: Pointer,
) -> c_int {
    // SAFETY: as above; the matrix is the band matrix that `run` made, whose columns point at their diagonal.
    unsafe {
        let user = &mut *user.cast::<User>();
        let y = std::slice::from_raw_parts((user.array)(y), user.n);
        let base = std::slice::from_raw_parts((user.array)(slope), user.n);
        for (place, &component) in user.component.iter().enumerate() {
            user.y[component] = y[place];
        }
        for group in &user.groups {
            user.perturbed.copy_from_slice(&user.y);
            let step = |component: usize| user.increment[component];
            for &place in group {
                user.perturbed[user.component[place]] += step(user.component[place]);
            }
            (*user.system).derivative(t, &user.perturbed, &mut user.slope);
            for &place in group {
                let column = (user.column)(matrix, place as i64);
                let first = place.saturating_sub(user.half_width);
                let last = (place + user.half_width).min(user.n - 1);
                for (row, base) in base.iter().enumerate().take(last + 1).skip(first) {
                    let rise = user.slope[user.component[row]] - base;
                    *column.offset(row as isize - place as isize) =
                        rise / step(user.component[place]);
                }
            }
        }
        user.evaluations += user.groups.len() as u64;
        user.jacobians += 1;
    }
    0
}

unsafe extern "C" fn silent(
    _: c_int,
    _: *const c_char,
    _: *const c_char,
    _: *const c_char,
    _: c_int,
    _: Pointer,
    _: Pointer,
) {
}

macro_rules! call {
    ($library:expr, $name:literal, ($($kind:ty),*) -> $result:ty, ($($argument:expr),*)) => {{
        // SAFETY: the signatures are those of the headers of SUNDIALS 6 and 7.
        let function = unsafe {
            $library.get::<unsafe extern "C" fn($($kind),*) -> $result>($name).map_err(|e| e.to_string())?
        };
        #[allow(unused_unsafe)]
        unsafe { function($($argument),*) }
    }};
}

/// Integrates from `y` at 0 to `end`.
///
/// `pattern`'s band for systems that have one; a full matrix in band form otherwise.
pub(crate) fn run(
    library: &str,
    system: &mut (dyn Evolving + 'static),
    method: Method,
    y: &mut [f64],
    tolerance: f64,
    end: f64,
    budget: &Budget,
) -> Result<Outcome, String> {
    // SAFETY: a library of functions; its initialisers do nothing but initialise.
    let lib = unsafe { Library::new(library) }.map_err(|e| e.to_string())?;
    let n = y.len();
    let scale: Vec<f64> = (system.scale().iter())
        .map(|s| (tolerance * s).min(1e30))
        .collect();
    let (component, half_width, groups) = match system.pattern() {
        Some(p) => (p.component.clone(), p.half_width, p.groups.clone()),
        None => ((0..n).collect(), n - 1, (0..n).map(|i| vec![i]).collect()),
    };
    let increment = (system.scale().iter())
        .map(|s| {
            INCREMENT
                * if system.pattern().is_some() {
                    1e-4 * s.min(1e10)
                } else {
                    *s
                }
        })
        .collect();
    // SAFETY: `get` finds functions of these signatures.
    let (array, column) = unsafe {
        (
            *lib.get(b"N_VGetArrayPointer").map_err(|e| e.to_string())?,
            *lib.get(b"SUNBandMatrix_Column")
                .map_err(|e| e.to_string())?,
        )
    };
    let mut user = Box::new(User {
        system: std::ptr::from_mut(system),
        component,
        half_width,
        groups,
        n,
        y: y.to_vec(),
        slope: vec![0.0; n],
        perturbed: y.to_vec(),
        increment,
        array,
        column,
        evaluations: 0,
        jacobians: 0,
    });
    let data = std::ptr::from_mut(&mut *user).cast::<c_void>();

    let mut context: Pointer = std::ptr::null_mut();
    call!(lib, b"SUNContext_Create", (c_int, *mut Pointer) -> c_int, (0, &raw mut context));
    call!(lib, b"SUNContext_ClearErrHandlers", (Pointer) -> c_int, (context));
    call!(lib, b"SUNContext_PushErrHandler", (Pointer, unsafe extern "C" fn(c_int, *const c_char, *const c_char, *const c_char, c_int, Pointer, Pointer), Pointer) -> c_int,
        (context, silent, std::ptr::null_mut()));
    let vector = call!(lib, b"N_VNew_Serial", (i64, Pointer) -> Pointer, (n as i64, context));
    let tolerances = call!(lib, b"N_VNew_Serial", (i64, Pointer) -> Pointer, (n as i64, context));
    // SAFETY: both vectors have n numbers.
    let (solution, absolute) = unsafe {
        (
            std::slice::from_raw_parts_mut(array(vector), n),
            std::slice::from_raw_parts_mut(array(tolerances), n),
        )
    };
    for (place, &component) in user.component.iter().enumerate() {
        solution[place] = y[component];
        absolute[place] = scale[component];
    }
    let formula = if method == Method::Bdf { BDF } else { ADAMS };
    let mut memory = call!(lib, b"CVodeCreate", (c_int, Pointer) -> Pointer, (formula, context));
    call!(lib, b"CVodeInit", (Pointer, unsafe extern "C" fn(f64, Pointer, Pointer, Pointer) -> c_int, f64, Pointer) -> c_int,
        (memory, right_hand_side, 0.0, vector));
    call!(lib, b"CVodeSVtolerances", (Pointer, f64, Pointer) -> c_int, (memory, 0.0, tolerances));
    call!(lib, b"CVodeSetUserData", (Pointer, Pointer) -> c_int, (memory, data));
    call!(lib, b"CVodeSetStopTime", (Pointer, f64) -> c_int, (memory, end));
    let mut solver: Pointer = std::ptr::null_mut();
    let mut matrix: Pointer = std::ptr::null_mut();
    let mut fixed_point: Pointer = std::ptr::null_mut();
    if method == Method::AdamsFunctional {
        fixed_point = call!(lib, b"SUNNonlinSol_FixedPoint", (Pointer, c_int, Pointer) -> Pointer, (vector, 0, context));
        call!(lib, b"CVodeSetNonlinearSolver", (Pointer, Pointer) -> c_int, (memory, fixed_point));
    } else {
        let width = user.half_width as i64;
        matrix = call!(lib, b"SUNBandMatrix", (i64, i64, i64, Pointer) -> Pointer, (n as i64, width, width, context));
        solver = call!(lib, b"SUNLinSol_Band", (Pointer, Pointer, Pointer) -> Pointer, (vector, matrix, context));
        call!(lib, b"CVodeSetLinearSolver", (Pointer, Pointer, Pointer) -> c_int, (memory, solver, matrix));
        call!(lib, b"CVodeSetJacFn", (Pointer, unsafe extern "C" fn(f64, Pointer, Pointer, Pointer, Pointer, Pointer, Pointer, Pointer) -> c_int) -> c_int,
            (memory, jacobian));
    }

    // SAFETY: the signature of the header.
    let step = unsafe {
        *lib.get::<unsafe extern "C" fn(Pointer, f64, Pointer, *mut f64, c_int) -> c_int>(b"CVode")
            .map_err(|e| e.to_string())?
    };
    let mut outcome = Outcome::default();
    let (mut t, mut before) = (0.0, y.to_vec());
    let (mut slope_before, mut slope) = (vec![0.0; n], vec![0.0; n]);
    system.derivative(0.0, y, &mut slope_before);
    let ended: fn(Outcome, f64) -> Outcome = loop {
        let start = t;
        // SAFETY: all that was made above is still there.
        let flag = unsafe { step(memory, end, vector, &raw mut t, ONE_STEP) };
        outcome.evaluations = user.evaluations;
        if flag < 0 {
            break Outcome::failed;
        }
        if budget.spent(&outcome) {
            break Outcome::unfinished;
        }
        outcome.steps += 1;
        before.copy_from_slice(y);
        for (place, &component) in user.component.iter().enumerate() {
            y[component] = solution[place];
        }
        system.derivative(t, y, &mut slope);
        let accepted = Accepted {
            start,
            end: t,
            y_start: &before,
            y_end: y,
            slope_start: &slope_before,
            slope_end: &slope,
        };
        if system.crossed(&accepted) {
            outcome.uncharged(|| system.remember(&accepted));
        } else {
            system.pass(&accepted);
        }
        std::mem::swap(&mut slope_before, &mut slope);
        if !y.iter().all(|y| y.is_finite()) {
            break Outcome::failed;
        }
        if flag == STOP_RETURN || t >= end {
            break Outcome::finished;
        }
    };
    // The slope that the search for onsets needs is no part of the method.
    outcome = outcome.timed(budget);
    let slopes = outcome.steps as f64;
    // No more than its share, should the machine have been slower while it was timed.
    let most = outcome.wall / (outcome.evaluations as f64 + slopes);
    outcome.deducted = slopes * time_of_slope(system, t, y, &mut slope).min(most);
    outcome.wall -= outcome.deducted;
    outcome.jacobians = user.jacobians;
    call!(lib, b"CVodeFree", (*mut Pointer) -> (), (&raw mut memory));
    if !solver.is_null() {
        call!(lib, b"SUNLinSolFree", (Pointer) -> c_int, (solver));
        call!(lib, b"SUNMatDestroy", (Pointer) -> (), (matrix));
    }
    if !fixed_point.is_null() {
        call!(lib, b"SUNNonlinSolFree", (Pointer) -> c_int, (fixed_point));
    }
    call!(lib, b"N_VDestroy", (Pointer) -> (), (vector));
    call!(lib, b"N_VDestroy", (Pointer) -> (), (tolerances));
    call!(lib, b"SUNContext_Free", (*mut Pointer) -> c_int, (&raw mut context));
    Ok(ended(outcome, t))
}

/// Least time of a right-hand side \[s\].
fn time_of_slope(system: &mut dyn Evolving, t: f64, y: &[f64], slope: &mut [f64]) -> f64 {
    const CALLS: u32 = 200;
    let batch = || {
        let begin = ThreadTime::now();
        for _ in 0..CALLS {
            system.derivative(t, y, slope);
        }
        begin.elapsed().as_secs_f64() / f64::from(CALLS)
    };
    std::iter::repeat_with(batch)
        .take(5)
        .fold(f64::INFINITY, f64::min)
}

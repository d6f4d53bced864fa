//! What this machine can do at most with the widest registers that it has, the least time of a right-hand side that follows from
//! it, and the time it takes: the figures of docs/development/roofline.md.
//!
//! Limits come from small loops of one instruction each, counts from the kernels' source, one line of it at a time, at the revision
//! that the page names: with later kernels the least times are those of that revision.

#![allow(clippy::inline_always)] // what is not inlined into a kernel does not run with its instructions

mod common;

use std::hint::black_box;

use common::{Effort, Halves, laws, longer_drive, race};
use pulp::{Arch, Simd, WithSimd};
use rustchain::chain::dynamics::Dynamics;
use rustchain::drive::Drive;
use rustchain::force_law::{Damping, Elastic};
use rustchain::integrator::OdeSystem;
use rustchain::{ForceLaws, Simulation};

/// Registers that do not wait for each other: more than any instruction here takes cycles to repeat.
const CHAINS: usize = 12;

/// Rounds of each loop.
const ROUNDS: usize = 1000;

/// Numbers of an array that the first-level cache holds several times: 8 kB.
const NUMBERS: usize = 1024;

/// Instructions of [`Arithmetic`].
const FUSED_MULTIPLY_ADD: u8 = 0;
const ADD: u8 = 1;
const DIVIDE: u8 = 2;
const SQUARE_ROOT: u8 = 3;

/// One instruction, over and over.
struct Arithmetic<const INSTRUCTION: u8>;

impl<const INSTRUCTION: u8> WithSimd for Arithmetic<INSTRUCTION> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let [factor, addend] = [1.000_001, 1e-9].map(|value| simd.splat_f64s(black_box(value)));
        let mut values = [factor; CHAINS];
        for _ in 0..ROUNDS {
            for value in &mut values {
                *value = match INSTRUCTION {
                    FUSED_MULTIPLY_ADD => simd.mul_add_f64s(*value, factor, addend),
                    ADD => simd.add_f64s(*value, addend),
                    DIVIDE => simd.div_f64s(*value, factor),
                    _ => simd.sqrt_f64s(*value),
                };
            }
        }
        let sums = values.map(|value| simd.reduce_sum_f64s(value));
        sums.into_iter().sum()
    }
}

/// Reads the array.
struct Load<'a>(&'a [f64]);

impl WithSimd for Load<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut found = [simd.splat_u64s(0); 8];
        for _ in 0..ROUNDS {
            let (registers, _) = S::as_simd_f64s(black_box(self.0));
            for eight in registers.chunks_exact(found.len()) {
                for (found, value) in found.iter_mut().zip(eight) {
                    *found = simd.xor_u64s(*found, simd.transmute_u64s_f64s(*value));
                }
            }
        }
        let all = found
            .into_iter()
            .reduce(|a, b| simd.xor_u64s(a, b))
            .unwrap_or(simd.splat_u64s(0));
        black_box(all);
    }
}

/// Writes the array.
struct Store<'a>(&'a mut [f64]);

impl WithSimd for Store<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for round in 0..ROUNDS {
            let value = simd.splat_f64s(round as f64);
            let (registers, _) = S::as_mut_simd_f64s(black_box(&mut *self.0));
            for eight in registers.chunks_exact_mut(8) {
                for register in eight {
                    *register = value;
                }
            }
        }
    }
}

/// Cycles that one link of [`chain`] takes on every x86-64 core of the last ten years: exclusive or 1, multiplication 3.
const CYCLES_OF_A_LINK: f64 = 4.0;

/// Instructions that wait for each other: their time gives that of a cycle.
fn chain() -> u64 {
    let mut value = black_box(3u64);
    for round in 0..ROUNDS as u64 {
        value = (value ^ round).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }
    value
}

/// Instructions on whole registers, or the time of one of each \[ns\].
#[derive(Debug, Clone, Copy)]
struct Instructions<T> {
    loads: T,
    stores: T,
    /// Fused or not: both go to the multipliers.
    products: T,
    sums: T,
    divisions: T,
    roots: T,
}

/// One register of links: sine and cosine, `chain/rhs/chain.rs` `point` and `math/simd/sin_cos.rs`.
const DIRECTIONS: Instructions<f64> = counts([1, 2, 17 + 2, 1, 0, 0]);
/// One register of hinges where none touches, `Hinges::join` and `End::new`.
const HINGES_APART: Instructions<f64> = counts([12, 10, 10 + 4, 4, 0, 0]);
/// The same where one touches: Hertz's law, damped.
const HINGES: Instructions<f64> = counts([12, 10, 12 + 13, 7, 1, 2]);
/// One register of candidates where none touches, `chain/rhs/teeth.rs` and `gap.rs`.
const TEETH_APART: Instructions<f64> = counts([5, 2, 7 + 10, 8, 0, 0]);
/// The same where one touches, not on the flat.
const TEETH: Instructions<f64> = counts([13, 6, 14 + 22, 20, 1, 2]);
/// One register of links: loads to accelerations, `chain/rhs/link_accelerations.rs`.
const ACCELERATIONS: Instructions<f64> = counts([9, 3, 3 + 3, 4, 0, 0]);
/// One register of links: velocities copied into the derivative.
const COPY: Instructions<f64> = counts([3, 3, 0, 0, 0, 0]);

const fn counts([loads, stores, products, sums, divisions, roots]: [u32; 6]) -> Instructions<f64> {
    Instructions {
        loads: loads as f64,
        stores: stores as f64,
        products: products as f64,
        sums: sums as f64,
        divisions: divisions as f64,
        roots: roots as f64,
    }
}

impl Instructions<f64> {
    /// Least time of one register and what takes it: units work side by side, division and root share one.
    fn least(&self, time: &Self) -> (f64, &'static str) {
        [
            (self.loads * time.loads, "loads"),
            (self.stores * time.stores, "stores"),
            (self.products * time.products, "products"),
            (self.sums * time.sums, "sums"),
            (
                self.divisions * time.divisions + self.roots * time.roots,
                "division and roots",
            ),
        ]
        .into_iter()
        .fold((0.0, ""), |a, b| if b.0 > a.0 { b } else { a })
    }
}

/// Registers of hinges and of candidates: all, and those with a contact.
struct Registers {
    hinges: [usize; 2],
    candidates: [usize; 2],
}

impl Registers {
    fn of(dynamics: &Dynamics, lanes: usize) -> Self {
        let hinges: Vec<bool> = dynamics.hinge_contacts().map(|(d, _)| d > 0.0).collect();
        let mut runs: Vec<(usize, Vec<bool>)> = Vec::new();
        let mut last = None;
        for (sprocket, bushing, depth, _) in dynamics.candidates() {
            if last != Some((sprocket, bushing)) {
                runs.push((sprocket, Vec::new()));
            }
            if let Some((_, run)) = runs.last_mut() {
                run.push(depth > 0.0);
            }
            last = Some((sprocket, (bushing + 1) % hinges.len()));
        }
        let count = |touching: &[bool]| {
            let busy = touching.chunks(lanes).filter(|r| r.contains(&true)).count();
            [touching.len().div_ceil(lanes), busy]
        };
        Self {
            hinges: count(&hinges),
            candidates: runs
                .iter()
                .map(|(_, run)| count(run))
                .fold([0, 0], |a, b| [a[0] + b[0], a[1] + b[1]]),
        }
    }

    /// Least time of a right-hand side \[ns\].
    fn least(&self, time: &Instructions<f64>) -> f64 {
        let sum =
            |[all, busy]: [usize; 2], apart: Instructions<f64>, touching: Instructions<f64>| {
                (all - busy) as f64 * apart.least(time).0 + busy as f64 * touching.least(time).0
            };
        let links = [DIRECTIONS, ACCELERATIONS, COPY].map(|part| part.least(time).0);
        self.hinges[0] as f64 * links.into_iter().sum::<f64>()
            + sum(self.hinges, HINGES_APART, HINGES)
            + sum(self.candidates, TEETH_APART, TEETH)
    }
}

#[allow(clippy::print_stdout)] // a benchmark's figures
fn main() {
    let lanes = Arch::new().dispatch(Width);
    let limits = limits(lanes);
    println!(
        "\n{:<28}{:>12}  limited by",
        "least time of a register", "ns"
    );
    for (name, part) in [
        ("directions", DIRECTIONS),
        ("hinges, apart", HINGES_APART),
        ("hinges, touching", HINGES),
        ("candidates, apart", TEETH_APART),
        ("candidates, touching", TEETH),
        ("accelerations", ACCELERATIONS),
        ("copy of velocities", COPY),
    ] {
        let (least, limit) = part.least(&limits);
        println!("{name:<28}{least:>12.2}  {limit}");
    }
    println!(
        "\n{:<28}{:>12}{:>10}{:>8}  registers of hinges, candidates (touching)",
        "right-hand side", "least, ns", "measured", "ratio"
    );
    let (elastic, damping) = (Elastic::Hertz, Damping::LankaraniNikravesh);
    let long = |simulation: fn(&Drive, &ForceLaws) -> Simulation| {
        simulation(&longer_drive([17, 17], 608), &laws(elastic, damping))
    };
    let states = vec![
        ("start", common::at_start(elastic, damping)),
        ("under way", common::under_way(elastic, damping)),
        ("pressed", common::pressed(elastic, damping)),
        ("start, 608 links", long(common::at_start_of)),
        ("pressed, 608 links", long(common::pressed_into_seats)),
    ];
    for (name, simulation) in states {
        let (registers, time) = right_hand_side(simulation, lanes);
        let least = registers.least(&limits);
        let Registers {
            hinges: [hinges, joined],
            candidates: [candidates, touching],
        } = registers;
        println!(
            "{name:<28}{least:>12.0}{time:>10.0}{:>8.2}  {hinges} ({joined}), {candidates} ({touching})",
            time / least
        );
    }
}

/// What a right-hand side works on, and the least time that it takes \[ns\].
fn right_hand_side(mut simulation: Simulation, lanes: usize) -> (Registers, f64) {
    let Halves {
        mut dynamics,
        adams,
    } = Halves::of(&mut simulation);
    let (t, y) = (adams.time(), adams.y().to_vec());
    let mut dydt = y.clone();
    dynamics.derivative(t, &y, &mut dydt);
    let registers = Registers::of(&dynamics, lanes);
    let effort = Effort {
        batches: 2000,
        calls: 50,
    };
    let time = race(
        effort.or_once(),
        &mut [Box::new(|| {
            dynamics.derivative(black_box(t), black_box(&y), &mut dydt);
        })],
    );
    (registers, time[0])
}

/// Times of one instruction of each kind \[ns\], printed.
#[allow(clippy::print_stdout)] // a benchmark's figures
fn limits(lanes: usize) -> Instructions<f64> {
    let arch = Arch::new();
    let set = rustchain::math::simd::InstructionSet::detect();
    let array = aligned_vec::avec![[64]| 1.0; NUMBERS];
    let mut other = array.clone();
    let effort = Effort {
        batches: 2000,
        calls: 1,
    };
    let least = race(
        effort.or_once(),
        &mut [
            Box::new(|| {
                black_box(chain());
            }),
            Box::new(|| {
                black_box(arch.dispatch(Arithmetic::<FUSED_MULTIPLY_ADD>));
            }),
            Box::new(|| {
                black_box(arch.dispatch(Arithmetic::<ADD>));
            }),
            Box::new(|| {
                black_box(arch.dispatch(Arithmetic::<DIVIDE>));
            }),
            Box::new(|| {
                black_box(arch.dispatch(Arithmetic::<SQUARE_ROOT>));
            }),
            Box::new(|| arch.dispatch(Load(&array))),
            Box::new(|| arch.dispatch(Store(&mut other))),
        ],
    );
    let cycle = least[0] / (ROUNDS as f64 * CYCLES_OF_A_LINK);
    let arithmetic = (ROUNDS * CHAINS) as f64;
    let memory = (ROUNDS * NUMBERS / lanes) as f64;
    println!(
        "{}, {lanes} numbers a register; a cycle of {cycle:.3} ns ({:.2} GHz)\n",
        set.name(),
        1.0 / cycle
    );
    println!("{:<28}{:>12}{:>10}", "one instruction", "ns", "cycles");
    for (name, time, count) in [
        ("fused multiply-add", least[1], arithmetic),
        ("addition", least[2], arithmetic),
        ("division", least[3], arithmetic),
        ("square root", least[4], arithmetic),
        ("load", least[5], memory),
        ("store", least[6], memory),
    ] {
        let time = time / count;
        println!("{name:<28}{time:>12.3}{:>10.2}", time / cycle);
    }
    Instructions {
        products: least[1] / arithmetic,
        sums: least[2] / arithmetic,
        divisions: least[3] / arithmetic,
        roots: least[4] / arithmetic,
        loads: least[5] / memory,
        stores: least[6] / memory,
    }
}
/// How many numbers a register holds.
struct Width;

impl WithSimd for Width {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        S::F64_LANES
    }
}

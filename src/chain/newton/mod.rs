//! Matrix of Newton's method for the velocities, M - γ dQ/dv - γ² dQ/dq: assembly, factorisation and solution.
//!
//! contacts (slopes scaled by γ) -> teeth (blocks of bushings, border) -> rollers, where they are bodies (eliminated) -> links
//! (eliminated) -> ring (hinges) -> border
//!
//! The 3x3 blocks of the links are eliminated first. The remainder is a ring of 2x2 blocks, one per hinge, bordered by the
//! coordinates of the sprockets. The work is proportional to the number of links. No memory is allocated after construction.

#![allow(clippy::inline_always)] // a function that is not inlined is compiled without the kernel's instruction set

mod blocks;
mod border;
mod contacts;
mod dense;
mod entries;
mod film;
mod links;
mod ring;
mod rollers;
mod teeth;

use pulp::{Simd, WithSimd};

use border::{Corner, SprocketMotions};
use contacts::{Arms, Closed, Rubbing, soften_hinges};
use entries::{Entries, EntriesMut};
use film::soften_filled_hinges;
use links::{Border, LinkTerms, Linked, RightHand};
use ring::{HingeBlocks, Ring};
use rollers::RollerTerms;
use teeth::{AddTeeth, RubbingTeeth, ToothTerms};

use super::rhs::layout::{ChainArrays, FIRST, LinkConstants};
use super::rhs::slopes::{FilmGroup, FrictionGroup, SlopeGroup, slope_groups};
use super::rhs::teeth::SprocketPose;
use crate::chain::contact::Candidates;
use crate::chain::model::Model;
use crate::math::simd::{InstructionSet, Lanes, Octet, PartialSums, WIDTH, parts, read, write};

/// Upper bound of the share of a diagonal border entry that teeth contribute. Below this bound one block Gauss-Seidel sweep
/// replaces the elimination of the border. The relative error of a correction is then below this share.
const WEAK: f64 = 0.14;

/// Contact slopes written by evaluations, the matrix and its factors.
#[derive(Debug, Clone)]
pub(crate) struct NewtonMatrix {
    /// Slopes of the hinges.
    pub(crate) hinge_slopes: Vec<SlopeGroup>,
    /// Slopes of the candidates of each sprocket, slot by slot.
    pub(crate) tooth_slopes: Vec<Vec<SlopeGroup>>,
    /// Friction slopes of the hinges; empty where links have no moments.
    pub(crate) hinge_rubs: Vec<FrictionGroup>,
    /// Friction slopes of the candidates of each sprocket, slot by slot.
    pub(crate) tooth_rubs: Vec<Vec<FrictionGroup>>,
    /// Slopes of the contacts between bushings and rollers; empty where rollers are no bodies.
    pub(crate) roller_slopes: Vec<SlopeGroup>,
    /// Friction slopes of these contacts.
    pub(crate) roller_rubs: Vec<FrictionGroup>,
    /// Slopes of the lubricant films in hinges; empty without lubricant.
    pub(crate) films: Vec<FilmGroup>,
    motions: Vec<SprocketMotions>,
    arms: Arms,
    closed: Closed,
    teeth: ToothTerms,
    /// Eliminated rollers, where rollers are bodies.
    rollers: Option<RollerTerms>,
    links: LinkTerms,
    hinges: HingeBlocks,
    ring: Ring,
    /// Columns of the border, link by link. The matrix is symmetric: they are its rows too. With rollers, one more column holds
    /// their forces on the links.
    columns: Vec<Border>,
    /// Columns multiplied by the inverse of the links' part, where the border is eliminated.
    solved: Vec<Border>,
    corner: Corner,
    /// Whether the coupling of the border by teeth is weak: one block Gauss-Seidel sweep replaces its elimination.
    swept: bool,
    /// Scratch: solution of the border alone, without links. With rollers, the factor -1 of their column follows.
    alone: Vec<f64>,
    /// Scratch: products of the border's rows with the solutions of the links.
    sums: Vec<PartialSums>,
    /// Scratch: solutions of the links.
    unknowns: Border,
}

/// Data of the last evaluation of the right-hand side from which the matrix is assembled.
pub(crate) struct Evaluated<'a> {
    pub(crate) instructions: InstructionSet,
    pub(crate) constants: &'a LinkConstants,
    pub(crate) chain: &'a ChainArrays,
    /// Arrays of the bodies on the teeth: the chain's, or those of the rollers.
    pub(crate) on_teeth: &'a ChainArrays,
    pub(crate) candidates: &'a Candidates,
    pub(crate) poses: &'a [SprocketPose],
    /// Positions of the pawls of ratchets.
    pub(crate) pawls: &'a [f64],
    /// Whether the matrix may be indefinite. The matrix of a step in time is definite, or the step is too long. A step towards a
    /// static equilibrium may begin with unstable links under compression.
    pub(crate) indefinite: bool,
}

impl NewtonMatrix {
    /// Allocate the matrix of `model`.
    pub(crate) fn new(model: &Model) -> Self {
        let n = model.links;
        let border = model.wheel_coordinates();
        let besides = usize::from(model.rollers.is_some());
        let three = || vec![[Octet::default(); 3]; n.div_ceil(WIDTH)];
        let slots = Candidates::most_slots(model);
        let rubs = |contacts: usize| {
            let contacts = if model.has_moments() { contacts } else { 0 };
            vec![FrictionGroup::default(); contacts.div_ceil(WIDTH)]
        };
        Self {
            hinge_slopes: slope_groups(n),
            tooth_slopes: model
                .sprockets
                .iter()
                .map(|_| slope_groups(slots))
                .collect(),
            hinge_rubs: rubs(n),
            tooth_rubs: model.sprockets.iter().map(|_| rubs(slots)).collect(),
            roller_slopes: slope_groups(model.roller_count()),
            roller_rubs: rubs(model.roller_count()),
            films: match model.hinge_film {
                Some(_) => vec![FilmGroup::default(); n.div_ceil(WIDTH)],
                None => Vec::new(),
            },
            motions: SprocketMotions::of(model),
            arms: Arms::new(n),
            closed: Closed::new(n),
            teeth: ToothTerms::new(n, border),
            rollers: (model.rollers.as_ref()).map(|rollers| RollerTerms::new(model, rollers)),
            links: LinkTerms::new(model),
            hinges: HingeBlocks::new(n),
            ring: Ring::new(n),
            columns: (0..border + besides).map(|_| three()).collect(),
            solved: (0..border).map(|_| three()).collect(),
            swept: true,
            alone: vec![0.0; border + besides],
            sums: vec![PartialSums::default(); border],
            corner: Corner::new(border),
            unknowns: three(),
        }
    }

    /// Assemble and factorise the matrix; return false where it is singular, or indefinite without permission.
    pub(crate) fn factorise(&mut self, model: &Model, evaluated: &Evaluated, gamma: f64) -> bool {
        macro_rules! factorise {
            ($rubbed:literal) => {
                evaluated.instructions.run(Factorise::<$rubbed> {
                    matrix: self,
                    model,
                    evaluated,
                    gamma,
                })
            };
        }
        if model.has_moments() {
            factorise!(true)
        } else {
            factorise!(false)
        }
    }

    /// Overwrite a residual of the velocities with the correction, the solution of the linear system.
    pub(crate) fn correct(
        &mut self,
        model: &Model,
        instructions: InstructionSet,
        residual: &mut [f64],
    ) {
        if model.has_moments() {
            instructions.run(Correct::<true> {
                matrix: self,
                model,
                residual,
            });
        } else {
            instructions.run(Correct::<false> {
                matrix: self,
                model,
                residual,
            });
        }
    }

    /// Add the contacts on all teeth to the bushings' blocks and to the border; eliminate the rollers.
    #[inline(always)]
    fn add_teeth<S: Simd, const RUBBED: bool>(
        &mut self,
        simd: S,
        model: &Model,
        evaluated: &Evaluated,
        gamma: f64,
    ) {
        self.teeth.clear::<RUBBED>();
        let supports = (evaluated.poses, evaluated.pawls);
        self.corner.start(model, supports, gamma);
        for (s, candidates) in evaluated.candidates.sprockets.iter().enumerate() {
            self.motions[s].follow(&model.sprockets[s], &evaluated.poses[s]);
            let SprocketMotions { first, motions } = &self.motions[s];
            let among = AddTeeth::<RUBBED> {
                gamma,
                pose: &evaluated.poses[s],
                candidates,
                slopes: &self.tooth_slopes[s],
                bushing: &evaluated.on_teeth.bushing,
                motions,
                first: *first,
                terms: &mut self.teeth,
                rubbing: RubbingTeeth {
                    slopes: &self.tooth_rubs[s],
                    bushing_radius: model.contact_radius,
                },
            }
            .with_simd(simd);
            for (i, row) in among.iter().enumerate().take(motions.len()) {
                for (j, &entry) in row.iter().enumerate().take(motions.len()).skip(i) {
                    self.corner.add(first + i, first + j, entry);
                    // The matrix is symmetric; tooth kernels return the upper triangle.
                    if i < j {
                        self.corner.add(first + j, first + i, entry);
                    }
                }
            }
        }
        self.teeth
            .take_back::<RUBBED>(model.links, evaluated.candidates.overhang);
        if let Some(rollers) = &mut self.rollers {
            let bores = (&self.roller_slopes[..], &self.roller_rubs[..]);
            let (teeth, corner) = (&mut self.teeth, &mut self.corner);
            rollers.eliminate::<S, RUBBED>(simd, gamma, bores, teeth, corner);
            teeth.close::<RUBBED>(model.links);
        }
    }

    /// Gather the border's columns by links and eliminate the border where its coupling is strong; return false where it is
    /// singular.
    #[inline(always)]
    fn eliminate_border<S: Simd, const RUBBED: bool>(&mut self, simd: S, links: usize) -> bool {
        for (from, column) in self.teeth.column.iter().zip(&mut self.columns) {
            self.links.gather_column::<S, RUBBED>(simd, from, column);
        }
        self.swept = self.corner.bound_by_teeth() < WEAK;
        if !self.swept {
            self.solve_columns::<S, RUBBED>(simd, links);
        }
        self.corner.factorise()
    }

    /// Eliminate the border: corner -= cᵀ A⁻¹ c, where A is the part of links and hinges and c the columns.
    #[inline(always)]
    fn solve_columns<S: Simd, const RUBBED: bool>(&mut self, simd: S, links: usize) {
        for j in 0..self.solved.len() {
            let column = Column(&self.columns[j]);
            self.links
                .solve_free::<S, _, RUBBED>(simd, links, &self.closed, &column);
            self.solve_hinges(simd, links);
            self.sums.fill(PartialSums::default());
            self.links.solve_bound::<S, RUBBED>(
                simd,
                &mut self.solved[j],
                &self.columns,
                &mut self.sums,
            );
            for (i, sum) in self.sums.iter().enumerate() {
                self.corner.add(i, j, -sum.total());
            }
        }
    }

    /// Solve the ring for the changes of the hinge forces.
    #[inline(always)]
    fn solve_hinges<S: Simd>(&mut self, simd: S, links: usize) {
        if self.closed.any {
            self.ring.solve(simd, self.links.ring_unknowns());
        }
        self.links.close_ring(links);
    }
}

/// Column of the border as the right-hand side.
struct Column<'a>(&'a Border);

impl<S: Simd> RightHand<S> for Column<'_> {
    #[inline(always)]
    fn at(&self, simd: S, _mass: [Lanes<S>; 3], _held: bool, i: usize) -> [Lanes<S>; 3] {
        let count = parts::<S>().len();
        read(simd, &self.0[i / count], i % count)
    }
}

/// Right-hand side of a correction: residuals times masses and inertias, minus columns times factors of the border.
struct Residual<'a, S: Simd> {
    /// Residuals x, y and θ of all links.
    accelerations: [Entries<'a, S>; 3],
    columns: &'a [Border],
    /// Factors of the columns; empty where the border is eliminated and rollers are no bodies.
    alone: &'a [f64],
}

impl<S: Simd> RightHand<S> for Residual<'_, S> {
    #[inline(always)]
    fn at(&self, simd: S, mass: [Lanes<S>; 3], held: bool, i: usize) -> [Lanes<S>; 3] {
        let mut right = mass;
        for (right, accelerations) in right.iter_mut().zip(&self.accelerations) {
            *right = *right * accelerations.at(i);
        }
        if held {
            let count = parts::<S>().len();
            for (column, &alone) in self.columns.iter().zip(self.alone) {
                take(simd, &mut right, &column[i / count], alone, i % count);
            }
        }
        right
    }
}

/// Subtract vector `part` of a column times `factor` from the entries of links.
#[inline(always)]
fn take<S: Simd>(simd: S, from: &mut [Lanes<S>; 3], column: &[Octet; 3], factor: f64, part: usize) {
    let factor = Lanes::splat(simd, factor);
    for (from, column) in from.iter_mut().zip(read(simd, column, part)) {
        *from = factor.negate_mul_add(column, *from);
    }
}

/// Kernel of [`NewtonMatrix::factorise`]; `RUBBED`: with moments on the links.
struct Factorise<'a, const RUBBED: bool> {
    matrix: &'a mut NewtonMatrix,
    model: &'a Model,
    evaluated: &'a Evaluated<'a>,
    gamma: f64,
}

impl<const RUBBED: bool> WithSimd for Factorise<'_, RUBBED> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Self {
            matrix,
            model,
            evaluated,
            gamma,
        } = self;
        let n = model.links;
        let rubbing = RUBBED.then_some(Rubbing {
            slopes: &matrix.hinge_rubs,
            arms: &mut matrix.arms,
        });
        if matrix.films.is_empty() {
            soften_hinges::<S, RUBBED>(
                simd,
                gamma,
                &matrix.hinge_slopes,
                &mut matrix.closed,
                &mut matrix.hinges,
                rubbing,
            );
        } else if RUBBED {
            soften_filled_hinges(
                simd,
                gamma,
                &matrix.hinge_slopes,
                &matrix.films,
                &mut matrix.closed,
                &mut matrix.hinges,
                rubbing,
            );
        }
        matrix.closed.close(n);
        if RUBBED {
            matrix.arms.close(n);
        }
        matrix.add_teeth::<S, RUBBED>(simd, model, evaluated, gamma);
        let ChainArrays {
            cos,
            sin,
            front_force: [front_x, front_y],
            rear_force: [rear_x, rear_y],
            ..
        } = evaluated.chain;
        let linked = Linked {
            links: n,
            gamma,
            direction: [cos, sin],
            arm: &evaluated.constants.front_arm,
            front_force: [front_x, front_y],
            rear_force: [&rear_x[FIRST..], &rear_y[FIRST..]],
            teeth: &matrix.teeth,
            closed: &matrix.closed,
            arms: &matrix.arms,
        };
        matrix
            .links
            .eliminate::<S, RUBBED>(simd, &linked, &mut matrix.hinges);
        let definite = !matrix.closed.any || matrix.ring.factorise(simd, &matrix.hinges);
        (definite || evaluated.indefinite) && matrix.eliminate_border::<S, RUBBED>(simd, n)
    }
}

/// Kernel of [`NewtonMatrix::correct`]; `RUBBED`: with moments on the links.
struct Correct<'a, const RUBBED: bool> {
    matrix: &'a mut NewtonMatrix,
    model: &'a Model,
    residual: &'a mut [f64],
}

impl<const RUBBED: bool> WithSimd for Correct<'_, RUBBED> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            matrix,
            model,
            residual,
        } = self;
        let n = model.links;
        let (links, rest) = residual.split_at_mut(3 * n);
        let (border, rollers) = rest.split_at_mut(matrix.solved.len());
        for sprocket in &model.sprockets {
            sprocket.for_each_inertia(|index, inertia| border[index - 3 * n] *= inertia);
        }
        let NewtonMatrix {
            rollers: terms,
            columns,
            alone,
            ..
        } = matrix;
        let (of_border, of_rollers) = alone.split_at_mut(border.len());
        if let (Some(terms), [.., column]) = (terms, &mut columns[..]) {
            let (links, right) = (&matrix.links, &*rollers);
            terms.solve_free::<S, RUBBED>(simd, right, border, links, column);
            of_border.fill(0.0);
            of_rollers.fill(-1.0);
        }
        let swept = matrix.swept && !border.is_empty();
        if swept {
            // Block Gauss-Seidel, first half: the border alone. The second half below solves the border with the links' solution.
            of_border.copy_from_slice(border);
            matrix.corner.solve(of_border);
        }
        let swept = swept || !rollers.is_empty();
        let right = Residual {
            accelerations: [
                Entries::of(simd, &links[..n]),
                Entries::of(simd, &links[n..2 * n]),
                Entries::of(simd, &links[2 * n..]),
            ],
            columns: &matrix.columns,
            alone: if swept { &matrix.alone } else { &[] },
        };
        matrix
            .links
            .solve_free::<S, _, RUBBED>(simd, n, &matrix.closed, &right);
        matrix.solve_hinges(simd, n);
        matrix.sums.fill(PartialSums::default());
        matrix.links.solve_bound::<S, RUBBED>(
            simd,
            &mut matrix.unknowns,
            &matrix.columns,
            &mut matrix.sums,
        );
        // Border: right-hand side minus rows times the links' solution.
        for (sum, entry) in matrix.sums.iter().zip(border.iter_mut()) {
            *entry -= sum.total();
        }
        matrix.corner.solve(border);
        // Elimination: w -= (A⁻¹ c) s, where s is the solution of the border.
        if !matrix.swept {
            for (column, &factor) in matrix.solved.iter().zip(&*border) {
                for (unknowns, column) in matrix.unknowns.iter_mut().zip(column) {
                    for part in parts::<S>() {
                        let mut rest = read(simd, unknowns, part);
                        take(simd, &mut rest, column, factor, part);
                        write(unknowns, part, rest);
                    }
                }
            }
        }
        if let Some(terms) = &mut matrix.rollers {
            let (links, unknowns) = (&matrix.links, &matrix.unknowns);
            terms.solve_bound::<S, RUBBED>(simd, links, unknowns, border, rollers);
        }
        for (axis, residual) in links.chunks_exact_mut(n).enumerate() {
            let mut residual = EntriesMut::of(simd, residual);
            for (number, unknowns) in matrix.unknowns.iter().enumerate() {
                for part in parts::<S>() {
                    let i = number * parts::<S>().len() + part;
                    residual.set(i, unknowns[axis].at(simd, part));
                }
            }
        }
    }
}

//! Newton's matrix for velocities, M - γ dQ/dv - γ² dQ/dq, made and solved from what the last evaluation left.
//!
//! contacts (slopes scaled by γ) -> teeth (blocks of bushings, border) -> rollers, where they are bodies (eliminated) -> links
//! (eliminated) -> ring (hinges) -> border
//!
//! The unknowns of links go first, 3x3 each; what remains is a ring of 2x2 blocks, one a hinge, and the sprockets' own
//! coordinates on its border. The work grows with the links; nothing is allocated once it has been made.

#![allow(clippy::inline_always)] // what is not inlined into a kernel does not run with its instructions

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

/// Share of a border coordinate's own entry that teeth may make up for the border to be swept instead of eliminated: what a
/// correction then lacks is less than that share.
const WEAK: f64 = 0.14;

/// The slopes that evaluations write, the matrix and its factors.
#[derive(Debug, Clone)]
pub(crate) struct NewtonMatrix {
    /// Of the hinges.
    pub(crate) hinge_slopes: Vec<SlopeGroup>,
    /// Of each sprocket's candidates, slot by slot.
    pub(crate) tooth_slopes: Vec<Vec<SlopeGroup>>,
    /// Those of friction in hinges; empty where there is none anywhere.
    pub(crate) hinge_rubs: Vec<FrictionGroup>,
    /// Likewise on teeth.
    pub(crate) tooth_rubs: Vec<Vec<FrictionGroup>>,
    /// Of bushings in rollers; empty where rollers are no bodies.
    pub(crate) roller_slopes: Vec<SlopeGroup>,
    /// Those of friction there.
    pub(crate) roller_rubs: Vec<FrictionGroup>,
    /// Those of lubricant in hinges; empty where there is none.
    pub(crate) films: Vec<FilmGroup>,
    motions: Vec<SprocketMotions>,
    arms: Arms,
    closed: Closed,
    teeth: ToothTerms,
    /// Where rollers are bodies.
    rollers: Option<RollerTerms>,
    links: LinkTerms,
    hinges: HingeBlocks,
    ring: Ring,
    /// Columns of the border, which are its rows too, link by link; behind them, where there are rollers, what those do to links.
    columns: Vec<Border>,
    /// The columns solved by the links' part, when the border is eliminated.
    solved: Vec<Border>,
    corner: Corner,
    /// Whether teeth bind the border so weakly that it is swept, not eliminated.
    swept: bool,
    /// Scratch: what the border would do without links; behind it, where there are rollers, minus one.
    alone: Vec<f64>,
    /// Scratch: products of the border's rows with the links.
    sums: Vec<PartialSums>,
    /// Scratch: solutions of links.
    unknowns: Border,
}

/// What an evaluation left.
pub(crate) struct Evaluated<'a> {
    pub(crate) instructions: InstructionSet,
    pub(crate) constants: &'a LinkConstants,
    pub(crate) chain: &'a ChainArrays,
    /// The same, or rollers in the place of bushings.
    pub(crate) on_teeth: &'a ChainArrays,
    pub(crate) candidates: &'a Candidates,
    pub(crate) poses: &'a [SprocketPose],
    /// How far the pawls of ratchets have come.
    pub(crate) pawls: &'a [f64],
    /// Whether the matrix may be indefinite. That of a step in time is definite, or the step is too long; a step to a static
    /// equilibrium may begin where links under compression are unstable.
    pub(crate) indefinite: bool,
}

impl NewtonMatrix {
    /// Room for the matrix of `model`.
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

    /// Makes and factorises the matrix; false when it is singular, or indefinite where it may not be.
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

    /// Overwrites a residual of velocities by the correction that it asks for.
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

    /// Brings the border's columns to the links and, unless it is only swept, eliminates it; false when singular.
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

    /// From links that are free to changes of hinge forces.
    #[inline(always)]
    fn solve_hinges<S: Simd>(&mut self, simd: S, links: usize) {
        if self.closed.any {
            self.ring.solve(simd, self.links.ring_unknowns());
        }
        self.links.close_ring(links);
    }
}

/// A column of the border as right-hand side.
struct Column<'a>(&'a Border);

impl<S: Simd> RightHand<S> for Column<'_> {
    #[inline(always)]
    fn at(&self, simd: S, _mass: [Lanes<S>; 3], _held: bool, i: usize) -> [Lanes<S>; 3] {
        let count = parts::<S>().len();
        read(simd, &self.0[i / count], i % count)
    }
}

/// Accelerations times masses and inertias, less what the border does by itself.
struct Residual<'a, S: Simd> {
    /// x, y and θ of all links.
    accelerations: [Entries<'a, S>; 3],
    columns: &'a [Border],
    /// What the border does; nothing where it is not swept.
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

/// Takes register `part` of a column, times its factor, off entries of links.
#[inline(always)]
fn take<S: Simd>(simd: S, from: &mut [Lanes<S>; 3], column: &[Octet; 3], factor: f64, part: usize) {
    let factor = Lanes::splat(simd, factor);
    for (from, column) in from.iter_mut().zip(read(simd, column, part)) {
        *from = factor.negate_mul_add(column, *from);
    }
}

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
            // What the border does by itself comes first; links then know most of it.
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
        for (sum, entry) in matrix.sums.iter().zip(border.iter_mut()) {
            *entry -= sum.total();
        }
        matrix.corner.solve(border);
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

//! Matrix of Newton's method for the velocities, M - γ dQ/dv - γ² dQ/dq: assembly, factorisation and solution.
//!
//! contacts (slopes scaled by γ) -> teeth (blocks of bushings, border) -> rollers, where they are bodies (eliminated) -> links
//! (eliminated) -> ring (hinges) -> border
//!
//! The 3x3 blocks of the links are eliminated first. The remainder is a ring of 2x2 blocks, one per hinge, bordered by the
//! coordinates of the sprockets. The work is proportional to the number of links. Memory is allocated at
//! construction, and once more where a model of single precision first needs factors of double precision.

#![allow(clippy::inline_always)] // a function that is not inlined is compiled without the kernel's instruction set
#![allow(clippy::needless_range_loop)] // several arrays of packs have one index, whose bound is checked once for all

mod blocks;
mod border;
mod bores;
mod contacts;
mod correct;
mod film;
mod link_ends;
mod link_group;
mod links;
mod power_change;
mod ring;
mod roller_group;
mod rollers;
mod spatial;
mod teeth;
mod tooth_motion;

use pulp::{Simd, WithSimd};

use border::{Corner, SprocketMotions};
use contacts::{FrictionArms, HingeRoots, assemble_roots};
use correct::Correct;
use film::{FilmSlopesChange, assemble_film_roots};
use link_group::{LinkGroup, Linked};
use links::{Border, LinkTerms, RightHand};
use power_change::CorrectedEnds;
pub(crate) use power_change::{CorrectedRollers, PowerChange};
use ring::{BASE, HingeRows, Ring, hinge_numbers, hinge_rows};
use rollers::RollerTerms;
use teeth::{AddTeeth, ToothTerms};

use crate::chain::arrays::layout::{ChainArrays, FIRST};
use crate::chain::arrays::pose::SprocketPose;
use crate::chain::arrays::slopes::Slopes;
use crate::chain::contact::Candidates;
use crate::chain::model::Model;
use crate::math::simd::{
    InstructionSet, Lanes, Number, Numbers, Pack8, PartialSums, Vectors, WIDTH, read,
};

/// Upper bound of the share of a diagonal border entry that teeth contribute. Below this bound one block Gauss-Seidel sweep
/// replaces the elimination of the border. The relative error of a correction is then below this share.
const WEAK: f64 = 0.14;

/// Longest γ for factors of single precision \[s\]. In ten states of the published drive, rounding changes a correction by at most 1e-6 of it up to
/// γ = 10 µs, by 4e-5 at 30 µs and by 4e-3 at 100 µs.
const LONGEST: f64 = 3e-5;

/// Smallest mass or moment of inertia for factors of single precision, and the inverse of the largest. The product of three masses stays
/// within the range of such numbers, 1e-38 to 3e38.
const LIGHTEST: f64 = 1e-12;

/// Largest ratio of the masses at two ideal hinges for factors of single precision. These hinges have no compliance, which would bound the effect of
/// rounding, 6e-8 times the ratio.
const MOST_UNEQUAL: f64 = 1e3;

/// Contact slopes written by evaluations, the matrix and its factors.
///
/// The factors of a step have single precision, whose vectors hold twice as many numbers. The residual has double precision. Rounding
/// changes a correction by far less than the terms that the matrix neglects, but where a film is much stiffer than a link is heavy, or where
/// links on ideal hinges have very unequal masses.
#[derive(Debug, Clone)]
pub(crate) struct NewtonMatrix {
    /// Written by evaluations.
    pub(crate) slopes: Slopes,
    motions: Vec<SprocketMotions>,
    /// Factors of single precision, where the model suits it.
    single: Option<Box<Factors<f32>>>,
    /// Factors of double precision, where it does not, or once a step or accelerations with ideal hinges have needed them.
    double: Option<Box<Factors<f64>>>,
    /// Whether the last factors have double precision.
    is_double: bool,
    /// Scratch: corrections of the links' ends.
    corrected: CorrectedEnds,
    /// Whether the last correction has changed the slopes of a film.
    pub(crate) film_slopes_changed: bool,
    /// γ times the changes of the forces of ideal hinges by the last solution, those on fronts with opposite sign; that of the
    /// last hinge precedes the first.
    force_changes: [Vec<f64>; 2],
}

/// Factors of the matrix, in one precision.
#[derive(Debug, Clone)]
struct Factors<T: Number> {
    arms: FrictionArms<T>,
    roots: HingeRoots<T>,
    teeth: ToothTerms<T>,
    /// Eliminated rollers, where rollers are bodies.
    rollers: Option<RollerTerms<T>>,
    links: LinkTerms<T>,
    rows: HingeRows<T>,
    ring: Ring<T>,
    /// Columns of the border, link by link. The matrix is symmetric: they are its rows too. With rollers, one more column holds
    /// their forces on the links.
    columns: Vec<Border<T>>,
    /// Columns multiplied by the inverse of the links' part, where the border is eliminated.
    solved: Vec<Border<T>>,
    corner: Corner,
    /// Whether the coupling of the border by teeth is weak: one block Gauss-Seidel sweep replaces its elimination.
    gauss_seidel: bool,
    /// Scratch: solution of the border alone, without links. With rollers, the factor -1 of their column follows.
    border_solution: Vec<f64>,
    /// Scratch: products of the border's rows with the solutions of the links.
    sums: Vec<PartialSums<T>>,
    /// Scratch: solutions of the links.
    unknowns: Border<T>,
    /// The same of a solution beside a step, where hinges are ideal.
    spare: Border<T>,
    /// Hinge forces of the border's columns, where hinges are ideal.
    forces_of_columns: Vec<[Numbers<T>; 2]>,
}

/// Data of the last evaluation of the right-hand side from which the matrix is assembled.
pub(crate) struct Evaluated<'a> {
    pub(crate) instructions: InstructionSet,
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
        let inertias = model.chain.mass.iter().chain(&model.chain.inertia);
        let rollers = model.rollers.iter();
        let rollers = rollers.flat_map(|rollers| [rollers.mass, rollers.inertia]);
        // A thick film has a stiffness of up to 1e4 masses of a link and more, which multiplies the rounding of a correction.
        let suits_single = model.hinges.film.is_none()
            && (inertias.copied().chain(rollers))
                .all(|inertia| (LIGHTEST..1.0 / LIGHTEST).contains(&inertia))
            && !(model.hinges.ideal && inequality(model) > MOST_UNEQUAL);
        Self {
            slopes: Slopes::new(model),
            motions: SprocketMotions::of(model),
            single: suits_single.then(|| Box::new(Factors::new(model))),
            double: (!suits_single).then(|| Box::new(Factors::new(model))),
            is_double: false,
            corrected: CorrectedEnds::new(model.links),
            film_slopes_changed: false,
            force_changes: if model.hinges.ideal {
                [(); 2].map(|()| vec![0.0; model.links + 1])
            } else {
                [(); 2].map(|()| Vec::new())
            },
        }
    }

    /// Assemble and factorise the matrix; return false where it is singular, or indefinite without permission.
    pub(crate) fn factorise(&mut self, model: &Model, evaluated: &Evaluated, gamma: f64) -> bool {
        let (slopes, motions) = (&self.slopes, &mut self.motions[..]);
        let suited = gamma <= LONGEST && !evaluated.indefinite;
        let single = self.single.as_mut().filter(|_| suited);
        // One that is not definite may be so by rounding.
        self.is_double = !single
            .is_some_and(|single| single.factorise((slopes, motions), model, evaluated, gamma));
        if !self.is_double {
            return true;
        }
        let of = (slopes, &mut self.motions[..]);
        let double = self
            .double
            .get_or_insert_with(|| Box::new(Factors::new(model)));
        double.factorise(of, model, evaluated, gamma)
    }

    /// Overwrite a residual of the velocities with the correction, the solution of the linear system. `lack`: velocity of each ideal hinge
    /// that the correction takes away, front minus rear \[m/s\].
    pub(crate) fn correct(
        &mut self,
        model: &Model,
        instructions: InstructionSet,
        residual: &mut [f64],
        lack: Option<&[Numbers; 2]>,
    ) {
        let changes = &mut self.force_changes;
        if self.is_double
            && let Some(double) = &mut self.double
        {
            double.correct(model, instructions, residual, (lack, changes));
        } else if let Some(single) = &mut self.single {
            single.correct(model, instructions, residual, (lack, changes));
        }
        if model.hinges.film.is_some() {
            self.write_corrected_ends::<false>(model.links, instructions);
            self.film_slopes_changed = instructions.run(FilmSlopesChange {
                films: &self.slopes.films,
                ends: &self.corrected,
            });
        }
    }

    /// Take away the velocities `lack` of ideal hinges, without forces; write the change of the velocities. The last correction of a step is
    /// kept, from which the powers at its end follow.
    pub(crate) fn close(
        &mut self,
        model: &Model,
        instructions: InstructionSet,
        change: &mut [f64],
        lack: &[Numbers; 2],
    ) {
        change.fill(0.0);
        self.exchange_spare();
        self.correct(model, instructions, change, Some(lack));
        self.exchange_spare();
    }

    /// Exchange the last solution and the one beside a step.
    fn exchange_spare(&mut self) {
        if let Some(double) = &mut self.double {
            std::mem::swap(&mut double.unknowns, &mut double.spare);
        }
        if let Some(single) = &mut self.single {
            std::mem::swap(&mut single.unknowns, &mut single.spare);
        }
    }

    /// Return γ times the changes of the forces of ideal hinges by the last correction, those on fronts with opposite sign; that of
    /// the last hinge precedes the first.
    pub(crate) fn changes_of_hinge_forces(&self) -> [&[f64]; 2] {
        let [x, y] = &self.force_changes;
        [x, y]
    }

    /// Write the corrections of the velocities of the links' ends with the last correction; with `FRICTION` of angular velocities too.
    pub(crate) fn write_corrected_ends<const FRICTION: bool>(
        &mut self,
        links: usize,
        set: InstructionSet,
    ) {
        let ends = &mut self.corrected;
        if self.is_double
            && let Some(double) = &self.double
        {
            double.write_ends::<FRICTION>(set, ends);
        } else if let Some(single) = &self.single {
            single.write_ends::<FRICTION>(set, ends);
        }
        for behind in &mut ends.links[2..] {
            behind[links] = behind[0];
        }
    }
}

impl<T: Number> Factors<T> {
    /// Allocate the factors of `model`.
    fn new(model: &Model) -> Self {
        let n = model.links;
        let border = model.wheel_coordinates();
        let besides = usize::from(model.rollers.is_some());
        let three = || vec![[Pack8::default(); 3]; n.div_ceil(WIDTH)];
        Self {
            arms: FrictionArms::new(n),
            roots: HingeRoots::new(n),
            teeth: ToothTerms::new(n, border),
            rollers: (model.rollers.as_ref()).map(|rollers| RollerTerms::new(model, rollers)),
            links: LinkTerms::new(model),
            rows: hinge_rows(n),
            ring: Ring::new(n),
            columns: (0..border + besides).map(|_| three()).collect(),
            solved: (0..border).map(|_| three()).collect(),
            gauss_seidel: true,
            border_solution: vec![0.0; border + besides],
            sums: vec![PartialSums::default(); border],
            corner: Corner::of(model),
            unknowns: three(),
            spare: if model.hinges.ideal {
                three()
            } else {
                Vec::new()
            },
            forces_of_columns: if model.hinges.ideal {
                vec![[(); 2].map(|()| hinge_numbers(n)); border]
            } else {
                Vec::new()
            },
        }
    }

    /// Assemble and factorise, see [`NewtonMatrix::factorise`].
    fn factorise(
        &mut self,
        (slopes, motions): (&Slopes, &mut [SprocketMotions]),
        model: &Model,
        evaluated: &Evaluated,
        gamma: f64,
    ) -> bool {
        macro_rules! factorise {
            ($friction:literal) => {
                T::run(
                    evaluated.instructions,
                    Factorise::<T, $friction> {
                        factors: self,
                        slopes,
                        motions,
                        model,
                        evaluated,
                        gamma,
                    },
                )
            };
        }
        if model.has_moments() {
            factorise!(true)
        } else {
            factorise!(false)
        }
    }

    /// Solve, see [`NewtonMatrix::correct`].
    fn correct(
        &mut self,
        model: &Model,
        instructions: InstructionSet,
        residual: &mut [f64],
        (lack, force_changes): (Option<&[Numbers; 2]>, &mut [Vec<f64>; 2]),
    ) {
        macro_rules! correct {
            ($friction:literal) => {
                T::run(
                    instructions,
                    Correct::<T, $friction> {
                        factors: self,
                        links: model.links,
                        residual,
                        lack,
                    },
                )
            };
        }
        if model.has_moments() {
            correct!(true);
        } else {
            correct!(false);
        }
        let forces = self.links.hinge_forces().iter();
        for (changes, forces) in force_changes.iter_mut().zip(forces) {
            for (change, force) in changes.iter_mut().zip(&forces[BASE - 1..]) {
                *change = force.double();
            }
        }
    }

    /// Add the contacts on all teeth to the bushings' blocks and to the border; eliminate the rollers.
    #[inline(always)]
    fn add_teeth<S: Vectors<Number = T>, const FRICTION: bool>(
        &mut self,
        simd: S,
        (slopes, motions): (&Slopes, &mut [SprocketMotions]),
        model: &Model,
        evaluated: &Evaluated,
        gamma: f64,
    ) {
        self.teeth.clear::<FRICTION>(model.links);
        let supports = (evaluated.poses, evaluated.pawls);
        self.corner.start(model, supports, gamma);
        // With γ = 0 contacts have no effect, and may be those of an evaluation without slopes.
        let sprockets: &[_] = if gamma > 0.0 {
            &evaluated.candidates.sprockets
        } else {
            &[]
        };
        let mut columns = 0..0;
        for (s, candidates) in sprockets.iter().enumerate() {
            motions[s].follow(&model.sprockets[s], &evaluated.poses[s]);
            let SprocketMotions { first, motions } = &motions[s];
            let teeth = AddTeeth::<FRICTION> {
                gamma,
                pose: &evaluated.poses[s],
                candidates,
                slopes: &slopes.teeth[s],
                bushing: &evaluated.on_teeth.bushing,
                motions,
                first: *first,
                bushing_radius: model.teeth.contact_radius,
            };
            teeth.add(simd, &mut self.teeth, &mut self.corner);
            columns = teeth.columns_behind(model.links, columns);
        }
        let places = (model.links, evaluated.candidates.overhang);
        self.teeth
            .fold_overhang::<S, FRICTION>(simd, places, columns);
        if let Some(rollers) = &mut self.rollers {
            let bores = &slopes.rollers;
            let (teeth, corner) = (&mut self.teeth, &mut self.corner);
            rollers.eliminate::<S, FRICTION>(simd, gamma, bores, teeth, corner);
            teeth.repeat_last::<FRICTION>(model.links);
        }
    }

    /// Gather the border's columns by links and eliminate the border where its coupling is strong; return false where it is
    /// singular.
    #[inline(always)]
    fn eliminate_border<S: Vectors<Number = T>, const FRICTION: bool>(
        &mut self,
        simd: S,
        links: usize,
    ) -> bool {
        for (from, column) in self.teeth.column.iter().zip(&mut self.columns) {
            self.links.gather_column::<S, FRICTION>(simd, from, column);
        }
        self.gauss_seidel = self.corner.is_bound_weakly(WEAK);
        if !self.gauss_seidel {
            self.solve_columns::<S, FRICTION>(simd, links);
        }
        self.corner.factorise()
    }

    /// Eliminate the border: corner -= cᵀ A⁻¹ c, where A is the part of links and hinges and c the columns.
    #[inline(always)]
    fn solve_columns<S: Vectors<Number = T>, const FRICTION: bool>(
        &mut self,
        simd: S,
        links: usize,
    ) {
        for j in 0..self.solved.len() {
            let column = Column(&self.columns[j]);
            self.links
                .solve_free::<S, _, FRICTION>(simd, links, &self.roots, &column);
            self.solve_hinges(simd, links);
            if let Some(forces) = self.forces_of_columns.get_mut(j) {
                for (kept, force) in forces.iter_mut().zip(self.links.hinge_forces()) {
                    kept.copy_from_slice(force);
                }
            }
            self.sums.fill(PartialSums::default());
            self.links.solve_bound::<S, FRICTION>(
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
    fn solve_hinges<S: Vectors<Number = T>>(&mut self, simd: S, links: usize) {
        if self.roots.any {
            self.ring.solve(simd, self.links.ring_unknowns());
        }
        self.links.close_ring(simd, links, &self.roots);
    }
}

/// Return the largest ratio of masses of links at their hinges: of whole links, and of moments of inertia over the square of the arm.
fn inequality(model: &Model) -> f64 {
    let turning = |inertia| inertia / (model.half_pitch * model.half_pitch);
    let masses = model.chain.mass.iter().copied();
    let masses = masses.chain(model.chain.inertia.iter().map(turning));
    let (least, most) = masses.fold((f64::INFINITY, 0.0f64), |(least, most), mass| {
        (least.min(mass), most.max(mass))
    });
    most / least
}

/// Column of the border as the right-hand side.
struct Column<'a, T>(&'a Border<T>);

impl<S: Vectors> RightHand<S> for Column<'_, S::Number> {
    #[inline(always)]
    fn at(
        &self,
        simd: S,
        group: &LinkGroup<S::Number>,
        (number, part): (usize, usize),
    ) -> [Lanes<S>; 3] {
        if group.touches_teeth {
            read(simd, &self.0[number], part)
        } else {
            [Lanes::splat(simd, 0.0); 3]
        }
    }
}

/// Kernel of [`Factors::factorise`]; `FRICTION`: with moments on the links.
struct Factorise<'a, T: Number, const FRICTION: bool> {
    factors: &'a mut Factors<T>,
    slopes: &'a Slopes,
    motions: &'a mut [SprocketMotions],
    model: &'a Model,
    evaluated: &'a Evaluated<'a>,
    gamma: f64,
}

impl<T: Number, const FRICTION: bool> WithSimd for Factorise<'_, T, FRICTION> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        self.run(T::vectors(simd))
    }
}

impl<T: Number, const FRICTION: bool> Factorise<'_, T, FRICTION> {
    #[inline(always)]
    fn run<S: Vectors<Number = T>>(self, simd: S) -> bool {
        let Self {
            factors,
            slopes,
            motions,
            model,
            evaluated,
            gamma,
        } = self;
        let n = model.links;
        let Slopes { hinges, films, .. } = slopes;
        let (roots, arms) = (&mut factors.roots, &mut factors.arms);
        // A film transmits moments: its hinges have friction slopes and arms, FRICTION holds.
        if model.hinges.ideal {
            roots.assemble_ideal(n, model.open_hinges());
        } else if FRICTION && !films.is_empty() {
            assemble_film_roots(simd, gamma, hinges, films, roots, arms);
        } else {
            assemble_roots::<S, FRICTION>(simd, gamma, hinges, roots, arms);
        }
        roots.repeat_last(n);
        if FRICTION {
            arms.repeat_last(n);
        }
        factors.add_teeth::<S, FRICTION>(simd, (slopes, motions), model, evaluated, gamma);
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
            front_force: [front_x, front_y],
            rear_force: [&rear_x[FIRST..], &rear_y[FIRST..]],
            teeth: &factors.teeth,
            arms: &factors.arms,
        };
        let (roots, rows) = (&factors.roots, &mut factors.rows);
        factors
            .links
            .eliminate::<S, FRICTION>(simd, &linked, roots, rows);
        if model.hinges.ideal {
            ring::give_identity(rows, model.open_hinges());
        }
        let definite = !factors.roots.any || factors.ring.factorise(simd, &factors.rows);
        (definite || evaluated.indefinite) && factors.eliminate_border::<S, FRICTION>(simd, n)
    }
}

#[cfg(test)]
mod tests {
    use super::NewtonMatrix;
    use crate::chain::contact::tests::{compiled, drive};

    #[test]
    fn a_model_that_always_takes_double_precision_has_no_factors_of_single_precision() {
        let (mut model, _) = compiled(&drive());
        for ideal in [false, true] {
            model.hinges.ideal = ideal;
            // Factors of the mass of one link.
            for (factor, suits) in [(1.0, true), (1e4, !ideal), (1e20, false)] {
                model.chain.mass[0] = factor * model.chain.mass[1];
                let matrix = NewtonMatrix::new(&model);
                assert_eq!(matrix.single.is_some(), suits, "{ideal} {factor}");
                assert_eq!(matrix.double.is_some(), !suits, "{ideal} {factor}");
            }
        }
    }
}

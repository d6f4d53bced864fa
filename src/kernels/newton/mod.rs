//! Newton's matrix for velocities, M - γ dQ/dv - γ² dQ/dq, made and solved from what the last evaluation left.
//!
//! contacts (slopes scaled by γ) -> teeth (blocks of bushings, border) -> links (eliminated) -> ring (hinges) -> border
//!
//! The unknowns of links go first, 3x3 each; what remains is a ring of 2x2 blocks, one a hinge, and the sprockets' own
//! coordinates on its border. The work grows with the links; nothing is allocated once it has been made.

mod border;
mod contacts;
mod gather;
mod links;
mod ring;
mod teeth;

use border::{Corner, SprocketMotions};
use contacts::{HingeTerms, ScaleHinges};
use gather::{Along, FindLevers, GatherColumn, Take};
use links::{EliminateLinks, LinkInertia, LinkTerms, SolveFree, SolveLinks, TimesInertia};
use ring::{FactoriseRing, Ring, SolveRing};
use teeth::{AddTeeth, Levers, ToothTerms};

use super::layout::{ChainArrays, FIRST, LinkConstants};
use super::slopes::ContactSlopes;
use super::teeth::SprocketPose;
use crate::contact::Candidates;
use crate::model::Model;
use crate::vector::{InstructionSet, Numbers, WIDTH, padded_zeros};

/// Share of a border coordinate's own entry that teeth may make up for the border to be swept instead of eliminated: what a
/// correction then lacks is that share of it.
const WEAK: f64 = 0.1;

/// The slopes that evaluations write, the matrix and its factors.
#[derive(Debug, Clone)]
pub(super) struct NewtonMatrix {
    /// Of the hinges.
    pub(super) hinge_slopes: ContactSlopes,
    /// Of each sprocket's candidates, slot by slot.
    pub(super) tooth_slopes: Vec<ContactSlopes>,
    inertia: LinkInertia,
    motions: Vec<SprocketMotions>,
    levers: Levers,
    hinges: HingeTerms,
    teeth: ToothTerms,
    links: LinkTerms,
    ring: Ring,
    /// Columns of the border, which are its rows too, link by link.
    columns: Vec<[Numbers; 3]>,
    /// The columns solved by the links' part, when the border is eliminated.
    solved: Vec<[Numbers; 3]>,
    corner: Corner,
    /// Whether teeth bind the border so weakly that it is swept, not eliminated.
    swept: bool,
    /// Scratch: what the border would do without links.
    alone: Vec<f64>,
    /// Scratch: right-hand sides of links, then their solutions.
    unknowns: [Numbers; 3],
}

/// What an evaluation left.
pub(super) struct Evaluated<'a> {
    pub(super) instructions: InstructionSet,
    pub(super) constants: &'a LinkConstants,
    pub(super) chain: &'a ChainArrays,
    pub(super) candidates: &'a Candidates,
    pub(super) poses: &'a [SprocketPose],
}

impl NewtonMatrix {
    /// Room for the matrix of `model`.
    pub(super) fn new(model: &Model) -> Self {
        let n = model.links;
        let border = model.coordinates - 3 * n;
        let three = || [(); 3].map(|()| padded_zeros(n));
        let slots = Candidates::most_slots(model);
        Self {
            hinge_slopes: ContactSlopes::new(n),
            tooth_slopes: model
                .sprockets
                .iter()
                .map(|_| ContactSlopes::new(slots))
                .collect(),
            inertia: LinkInertia::new(model),
            motions: SprocketMotions::of(model),
            levers: [(); 2].map(|()| padded_zeros(2 * n + 3 * WIDTH)),
            hinges: HingeTerms::new(n),
            teeth: ToothTerms::new(n, border),
            links: LinkTerms::new(n),
            ring: Ring::new(n),
            columns: (0..border).map(|_| three()).collect(),
            solved: (0..border).map(|_| three()).collect(),
            swept: true,
            alone: vec![0.0; border],
            corner: Corner::new(border),
            unknowns: three(),
        }
    }

    /// Makes and factorises the matrix; false when it is singular.
    pub(super) fn factorise(&mut self, model: &Model, evaluated: &Evaluated, gamma: f64) -> bool {
        let n = model.links;
        let instructions = evaluated.instructions;
        instructions.run(ScaleHinges {
            hinges: n,
            gamma,
            slopes: &self.hinge_slopes,
            force: &evaluated.chain.force,
            terms: &mut self.hinges,
        });
        self.add_teeth(model, evaluated, gamma);
        let ChainArrays {
            cos,
            sin,
            front_force: [front_x, front_y],
            rear_force: [rear_x, rear_y],
            ..
        } = evaluated.chain;
        instructions.run(EliminateLinks {
            links: n,
            gamma,
            inertia: &self.inertia,
            direction: [cos, sin],
            arm: &evaluated.constants.front_arm,
            front_force: [front_x, front_y],
            rear_force: [&rear_x[FIRST..], &rear_y[FIRST..]],
            hinges: &self.hinges,
            teeth: &self.teeth,
            terms: &mut self.links,
        });
        let regular = instructions.run(FactoriseRing {
            ring: &mut self.ring,
            blocks: &self.links.ring,
            force: &evaluated.chain.force,
        });
        regular && self.eliminate_border(instructions, n)
    }

    fn add_teeth(&mut self, model: &Model, evaluated: &Evaluated, gamma: f64) {
        let (n, overhang) = (model.links, evaluated.candidates.overhang);
        let chain = evaluated.chain;
        evaluated.instructions.run(FindLevers {
            links: n,
            overhang,
            on_front: &evaluated.constants.bushing_on_front,
            arm: &evaluated.constants.front_arm,
            direction: [&chain.cos, &chain.sin],
            levers: &mut self.levers,
        });
        self.teeth.clear();
        self.corner.start(model, gamma);
        for (s, candidates) in evaluated.candidates.sprockets.iter().enumerate() {
            let SprocketMotions { first, motions } = &self.motions[s];
            let among = evaluated.instructions.run(AddTeeth {
                gamma,
                pose: &evaluated.poses[s],
                candidates,
                slopes: &self.tooth_slopes[s],
                bushing: &chain.bushing,
                levers: &self.levers,
                motions,
                first: *first,
                terms: &mut self.teeth,
            });
            for (i, row) in among.iter().enumerate().take(motions.len()) {
                for (j, &entry) in row.iter().enumerate().take(motions.len()).skip(i) {
                    self.corner.add(first + i, first + j, entry);
                    if i < j {
                        self.corner.add(first + j, first + i, entry);
                    }
                }
            }
        }
        self.teeth.take_back(n, overhang);
    }

    /// Brings the border's columns to the links and, unless it is only swept, eliminates it; false when singular.
    fn eliminate_border(&mut self, instructions: InstructionSet, links: usize) -> bool {
        for (coordinate, column) in self.columns.iter_mut().enumerate() {
            instructions.run(GatherColumn {
                links,
                inertia: &self.inertia,
                teeth: &self.teeth,
                coordinate,
                column,
            });
        }
        self.swept = self.corner.bound_by_teeth() < WEAK;
        if !self.swept {
            for j in 0..self.columns.len() {
                for (unknowns, column) in self.unknowns.iter_mut().zip(&self.columns[j]) {
                    unknowns.copy_from_slice(column);
                }
                self.solve_links(instructions, links);
                std::mem::swap(&mut self.solved[j], &mut self.unknowns);
            }
            for (i, row) in self.columns.iter().enumerate() {
                for (j, column) in self.solved.iter().enumerate() {
                    let product = instructions.run(Along { links, row, column });
                    self.corner.add(i, j, -product);
                }
            }
        }
        self.corner.factorise()
    }

    /// Solves the links' part for `unknowns`, in place.
    fn solve_links(&mut self, instructions: InstructionSet, links: usize) {
        instructions.run(SolveFree {
            links,
            right: &self.unknowns,
            hinges: &self.hinges,
            terms: &mut self.links,
        });
        let unknowns = self.links.ring_unknowns(links);
        instructions.run(SolveRing {
            ring: &mut self.ring,
            unknowns,
        });
        self.links.close_ring(links);
        instructions.run(SolveLinks {
            links,
            hinges: &self.hinges,
            terms: &self.links,
            unknowns: &mut self.unknowns,
        });
    }

    /// Overwrites a residual of velocities by the correction that it asks for.
    pub(super) fn correct(
        &mut self,
        model: &Model,
        instructions: InstructionSet,
        residual: &mut [f64],
    ) {
        let n = model.links;
        let (links, border) = residual.split_at_mut(3 * n);
        instructions.run(TimesInertia {
            links: n,
            residual: links,
            inertia: &self.inertia,
            right: &mut self.unknowns,
        });
        for sprocket in &model.sprockets {
            sprocket.for_each_inertia(|index, inertia| border[index - 3 * n] *= inertia);
        }
        if self.swept && !border.is_empty() {
            // What the border does by itself comes first; links then know most of it.
            self.alone.copy_from_slice(border);
            self.corner.solve(&mut self.alone);
            take(
                instructions,
                n,
                &self.columns,
                &self.alone,
                &mut self.unknowns,
            );
        }
        self.solve_links(instructions, n);
        for (row, entry) in self.columns.iter().zip(border.iter_mut()) {
            *entry -= instructions.run(Along {
                links: n,
                row,
                column: &self.unknowns,
            });
        }
        self.corner.solve(border);
        if !self.swept {
            take(instructions, n, &self.solved, border, &mut self.unknowns);
        }
        for (unknowns, residual) in self.unknowns.iter().zip(links.chunks_exact_mut(n)) {
            residual.copy_from_slice(&unknowns[..n]);
        }
    }
}

/// Takes `columns`, each times its factor, off the entries of links.
fn take(
    instructions: InstructionSet,
    links: usize,
    columns: &[[Numbers; 3]],
    factors: &[f64],
    from: &mut [Numbers; 3],
) {
    for (column, &factor) in columns.iter().zip(factors) {
        instructions.run(Take {
            links,
            factor,
            column,
            from,
        });
    }
}

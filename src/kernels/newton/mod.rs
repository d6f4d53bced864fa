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
use gather::{Along, FindLevers, GatherBorder, Take};
use links::{EliminateLinks, LinkInertia, LinkTerms, SolveFree, TakeHinges};
use ring::{FactoriseRing, Ring, SolveRing};
use teeth::{AddTeeth, BushingLevers, ToothTerms};

use super::layout::{ChainArrays, FIRST, LinkConstants};
use super::slopes::ContactSlopes;
use super::teeth::SprocketPose;
use crate::contact::Candidates;
use crate::model::Model;
use crate::vector::{InstructionSet, Numbers, WIDTH, padded_zeros};

/// The slopes that evaluations write, the matrix and its factors.
#[derive(Debug, Clone)]
pub(super) struct NewtonMatrix {
    /// Of the hinges.
    pub(super) hinge_slopes: ContactSlopes,
    /// Of each sprocket's candidates, slot by slot.
    pub(super) tooth_slopes: Vec<ContactSlopes>,
    inertia: LinkInertia,
    motions: Vec<SprocketMotions>,
    spin: Numbers,
    levers: BushingLevers,
    hinges: HingeTerms,
    teeth: ToothTerms,
    links: LinkTerms,
    ring: Ring,
    /// Rows of the border and, solved by the links' part, its columns; link by link.
    rows: Vec<[Numbers; 3]>,
    columns: Vec<[Numbers; 3]>,
    corner: Corner,
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
            spin: padded_zeros(n + WIDTH),
            levers: BushingLevers::new(n),
            hinges: HingeTerms::new(n),
            teeth: ToothTerms::new(n, border),
            links: LinkTerms::new(n),
            ring: Ring::new(n),
            rows: (0..border).map(|_| three()).collect(),
            columns: (0..border).map(|_| three()).collect(),
            corner: Corner::new(border),
            unknowns: three(),
        }
    }

    /// Makes and factorises the matrix for links that turn with `spin`; false when it is singular.
    pub(super) fn factorise(
        &mut self,
        model: &Model,
        evaluated: &Evaluated,
        spin: &[f64],
        gamma: f64,
    ) -> bool {
        let n = model.links;
        let instructions = evaluated.instructions;
        self.spin[..n].copy_from_slice(spin);
        self.spin[n] = spin[0];
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
            spin: &self.spin,
            front_force: [front_x, front_y],
            rear_force: [&rear_x[FIRST..], &rear_y[FIRST..]],
            hinges: &self.hinges,
            teeth: &self.teeth,
            terms: &mut self.links,
        });
        let hinges = &self.hinges;
        let regular = instructions.run(FactoriseRing {
            ring: &mut self.ring,
            blocks: self.links.ring_blocks(),
            closed: |k| hinges.is_closed(k),
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
            spin: &self.spin,
            levers: &mut self.levers,
        });
        self.teeth.clear(n, overhang);
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
                for (j, &entry) in row.iter().enumerate().take(motions.len()) {
                    self.corner.add(first + i, first + j, entry);
                }
            }
        }
        self.teeth.take_back(n, overhang);
    }

    /// Solves the border's columns by the links' part and takes that part off the corner.
    fn eliminate_border(&mut self, instructions: InstructionSet, links: usize) -> bool {
        for j in 0..self.columns.len() {
            let gather = |from, to| GatherBorder {
                links,
                inertia: &self.inertia,
                from,
                to,
            };
            instructions.run(gather(&self.teeth.column[j], &mut self.unknowns));
            instructions.run(gather(&self.teeth.row[j], &mut self.rows[j]));
            self.solve_links(instructions, links, false);
            std::mem::swap(&mut self.columns[j], &mut self.unknowns);
        }
        for (i, row) in self.rows.iter().enumerate() {
            for (j, column) in self.columns.iter().enumerate() {
                let product = instructions.run(Along { links, row, column });
                self.corner.add(i, j, -product);
            }
        }
        self.corner.factorise()
    }

    /// Solves the links' part for `unknowns`, in place.
    fn solve_links(&mut self, instructions: InstructionSet, links: usize, by_mass: bool) {
        instructions.run(SolveFree {
            links,
            right: &self.unknowns,
            by_mass: by_mass.then_some(&self.inertia),
            hinges: &self.hinges,
            terms: &mut self.links,
        });
        let unknowns = self.links.gather_pushes(links);
        instructions.run(SolveRing {
            ring: &self.ring,
            unknowns,
        });
        self.links.close_ring(links);
        instructions.run(TakeHinges {
            links,
            terms: &self.links,
            solution: &mut self.unknowns,
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
        for (unknowns, residual) in self.unknowns.iter_mut().zip(links.chunks_exact(n)) {
            unknowns[..n].copy_from_slice(residual);
        }
        self.solve_links(instructions, n, true);
        if !border.is_empty() {
            for sprocket in &model.sprockets {
                sprocket.for_each_inertia(|index, inertia| border[index - 3 * n] *= inertia);
            }
            for (row, entry) in self.rows.iter().zip(border.iter_mut()) {
                *entry -= instructions.run(Along {
                    links: n,
                    row,
                    column: &self.unknowns,
                });
            }
            self.corner.solve(border);
            for (column, &factor) in self.columns.iter().zip(border.iter()) {
                instructions.run(Take {
                    links: n,
                    factor,
                    column,
                    from: &mut self.unknowns,
                });
            }
        }
        for (unknowns, residual) in self.unknowns.iter().zip(links.chunks_exact_mut(n)) {
            residual.copy_from_slice(&unknowns[..n]);
        }
    }
}

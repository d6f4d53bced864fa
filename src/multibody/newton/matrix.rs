//! What the implicit corrector asks of a mechanism: the linear system of 1 - γ ∂a/∂v - γ² ∂a/∂q with its constraints.
//!
//! With corrections x of the velocities and γ x of the coordinates, the equations of motion and the constraints change by
//!
//! ```text
//! (M - γ ∂f/∂v - γ² ∂f/∂q + γ² Σ λ ∂²c/∂q²) x + Gᵀ μ = M r
//! (G + 2 γ ∂²c/∂q² v + γ² (∂(v ∂²c/∂q² v)/∂q + ∂²c/∂q² a)) x = G r
//! ```
//!
//! for a residual r of the velocities: all derivatives are exact but those of callables and of how a place of contact fades.

use std::ops::Range;

use nalgebra::{DMatrix, DVectorViewMut, Dyn, LU};

use super::sparse_system::{PairPlaces, Pattern, RowPlaces, Saddle};
use crate::integrator::{SPEED_PER_LENGTH, SecondOrderSystem};
use crate::multibody::constraints::relative_kinematics::{Block, Pair, PairForce, PairTorque};
use crate::multibody::constraints::sparse_kkt::SparseKkt;
use crate::multibody::contact::contact_state::CompiledContact;
use crate::multibody::contact::impact_memory::Touch;
use crate::multibody::description::tribology::FrictionLaw;
use crate::multibody::dynamics::{MechanismDynamics, Stabilisation};
use crate::multibody::forces::force_slopes::add_twist;

/// Change of a velocity that differences are taken over \[m/s\]; of an angular one over its arm.
const CHANGE: f64 = 1e-6;

/// Softness of a constraint beside what it holds: far below rounding of the iteration, above that of the factors.
const SOFT: f64 = 1e-11;

/// Deflection at break-away of bristles whose error weighs as that of a length \[m\]: at an accuracy of 1e-10 m a thousandth of
/// it is allowed, as in chain drives. What they get wrong is a share of a force, and not a place.
const WHOLE_DEFLECTION: f64 = 1e-7;

/// Near singular positions, where accelerations come from both sides, the matrix is made of differences up to so many coordinates.
const MOST_BY_DIFFERENCES: usize = 150;

/// The corrector's matrix, its places and factors.
#[derive(Debug, Clone)]
pub(crate) struct ImplicitMatrix {
    saddle: Saddle,
    joints: Vec<(PairPlaces, RowPlaces)>,
    forces: Vec<PairPlaces>,
    contacts: Vec<PairPlaces>,
    /// Softness of each constraint.
    soft: Vec<f64>,
    /// Factors by differences, where they stand in.
    by_differences: Option<LU<f64, Dyn, Dyn>>,
}

impl MechanismDynamics {
    /// The length that turns each coordinate into one: for angles the farthest point of the body.
    fn lengths(&self, lengths: &mut [f64]) {
        lengths.fill(1.0);
        for angle in lengths.iter_mut().skip(2).step_by(3) {
            *angle = 0.0;
        }
        let model = &self.model;
        let joints = model.equations.iter().flat_map(|e| [e.a, e.b]);
        let contacts = model.contacts.iter().flat_map(|c| [c.a, c.b]);
        for end in joints.chain(contacts) {
            if let Some(first) = model.first[end.body] {
                lengths[first + 2] = end.point.norm().max(lengths[first + 2]);
            }
        }
        for angle in lengths.iter_mut().skip(2).step_by(3) {
            if *angle == 0.0 {
                *angle = 1.0;
            }
        }
    }

    /// Room and places for the matrix.
    fn implicit_matrix(&self) -> Option<Box<ImplicitMatrix>> {
        let model = &self.model;
        let (n, first) = (model.coordinates(), &model.first);
        let mut pattern = Pattern::new(first, n, model.constraints());
        let pairs = || {
            let forces = model.forces.iter().map(|f| (f.a.body, f.b.body));
            forces.chain(model.contacts.iter().map(|c| (c.a.body, c.b.body)))
        };
        for (a, b) in pairs().chain(model.equations.iter().map(|e| (e.a.body, e.b.body))) {
            pattern.couple(a, b);
        }
        for (i, equation) in model.equations.iter().enumerate() {
            pattern.constrain(i, [equation.a.body, equation.b.body, equation.carrier]);
        }
        let saddle = pattern.finish()?;
        let mut places = pairs().map(|(a, b)| saddle.pair_places(first, a, b));
        let forces = places.by_ref().take(model.forces.len()).collect();
        let contacts = places.collect();
        let joints = model.equations.iter().enumerate().map(|(i, e)| {
            let bodies = [e.a.body, e.b.body, e.carrier];
            let pair = saddle.pair_places(first, e.a.body, e.b.body);
            (pair, saddle.row_places(first, n + i, bodies))
        });
        Some(Box::new(ImplicitMatrix {
            joints: joints.collect(),
            forces,
            contacts,
            soft: vec![0.0; model.constraints()],
            by_differences: None,
            saddle,
        }))
    }

    /// Writes and factorises the matrix where everything was evaluated last.
    fn linearise(&self, matrix: &mut ImplicitMatrix, gamma: f64) -> bool {
        let model = &self.model;
        let (by_velocity, by_place) = (-gamma, -gamma * gamma);
        matrix.saddle.clear();
        for (k, mass) in model.mass.iter().enumerate() {
            matrix.saddle.add_diagonal(k, *mass);
        }
        for (force, places) in model.forces.iter().zip(&matrix.forces) {
            let mut block = Block::default();
            force.add_slopes(self.time, &self.frames, by_velocity, by_place, &mut block);
            matrix.saddle.add_pair(places, &block);
        }
        let contacts = model.contacts.iter().zip(&model.sides_of_contact);
        for ((contact, sides), places) in contacts.zip(&matrix.contacts) {
            let touches = &self.touches[sides.clone()];
            let apart = |touch: &Touch| touch.contact.penetration <= 0.0;
            if contact.film.is_none() && touches.iter().all(apart) {
                continue;
            }
            let pair = Pair::new(contact.a, contact.b, &self.frames, true);
            let mut block = Block::default();
            contact.slopes(&self.frames, &self.memory[sides.clone()], |_, force| {
                pair.add(force, by_velocity, by_place, &mut block);
            });
            self.tangential_slopes(contact, sides, |force, torque| {
                pair.add(force, by_velocity, by_place, &mut block);
                pair.add_torque(torque, by_velocity, by_place, &mut block);
            });
            matrix.saddle.add_pair(places, &block);
        }
        self.linearise_joints(matrix, gamma);
        self.linearise_pins(matrix, gamma);
        matrix.saddle.factorise()
    }

    fn linearise_joints(&self, matrix: &mut ImplicitMatrix, gamma: f64) {
        let model = &self.model;
        let n = model.coordinates();
        let pulled = match self.stabilisation {
            Stabilisation::Baumgarte(w) => 2.0 * w * gamma + (w * gamma).powi(2),
            Stabilisation::Projection => 0.0,
        };
        for (i, equation) in model.equations.iter().enumerate() {
            let row = &self.rows[i];
            let mut across = row.jacobian.map(|part| part.map(|j| (1.0 + pulled) * j));
            let (pair_places, row_places) = &matrix.joints[i];
            if let Some(slopes) = equation.slopes(&self.frames) {
                let pair = Pair::new(equation.a, equation.b, &self.frames, false);
                let acceleration = self.pair_accelerations([equation.a.body, equation.b.body]);
                for k in 0..6 {
                    let line = slopes.second[k].iter();
                    let along = |v: &[f64; 6]| line.clone().zip(v).map(|(a, b)| a * b).sum::<f64>();
                    let by_rate = along(&pair.v);
                    let by_place = slopes.third[k] + along(&acceleration);
                    across[k / 3][k % 3] += 2.0 * gamma * by_rate + gamma * gamma * by_place;
                }
                let weight = gamma * gamma * self.multipliers[i];
                let block = slopes.second.map(|line| line.map(|entry| weight * entry));
                matrix.saddle.add_pair(pair_places, &block);
            }
            matrix.saddle.add_row(row_places, &row.jacobian, &across);
            let mut held = 0.0;
            for (body, part) in row.bodies.iter().zip(&row.jacobian) {
                if let Some(first) = model.first[*body] {
                    for (k, j) in part.iter().enumerate() {
                        let mass = model.mass[first + k];
                        held += if mass > 0.0 { j * j / mass } else { 0.0 };
                    }
                }
            }
            matrix.soft[i] = SOFT * held;
            matrix.saddle.add_diagonal(n + i, -matrix.soft[i]);
        }
    }

    /// Shows `visit` how friction of each side of a contact and its film change.
    fn tangential_slopes(
        &self,
        contact: &CompiledContact,
        sides: &Range<usize>,
        mut visit: impl FnMut(&PairForce, &PairTorque),
    ) {
        if let Some(law) = &contact.friction {
            let memory = &self.memory[sides.clone()];
            for k in sides.clone().filter(|&k| self.touches[k].force > 0.0) {
                let mut push = PairForce::default();
                contact.slopes(&self.frames, memory, |side, part| {
                    if sides.start + side == k {
                        push.add(part);
                    }
                });
                let bent = self.model.bristle_of_side[k].map(|i| self.bristles.bent(i));
                let (force, torque) = contact.friction_slopes(law, &self.frames, &push, bent);
                visit(&force, &torque);
            }
        }
        if let Some(film) = &contact.film {
            let (force, torque) = contact.film_slopes(film, &self.frames);
            visit(&force, &torque);
        }
    }

    /// The friction of pins: with the angular velocity, and with the multipliers, whose corrections are γ times as large.
    fn linearise_pins(&self, matrix: &mut ImplicitMatrix, gamma: f64) {
        for pin in &self.model.pins {
            let torque = pin.torque(&self.frames, &self.multipliers);
            let mut block = Block::default();
            add_twist(-gamma * torque.by_spin, &mut block);
            matrix.saddle.add_pair(&matrix.joints[pin.row].0, &block);
            for (i, slope) in torque.by_multiplier.into_iter().enumerate() {
                let places = &matrix.joints[pin.row + i].1;
                let down = [[0.0, 0.0, slope], [0.0, 0.0, -slope], [0.0; 3]];
                matrix.saddle.add_row(places, &down, &[[0.0; 3]; 3]);
            }
        }
    }

    /// Accelerations of two bodies.
    fn pair_accelerations(&self, bodies: [usize; 2]) -> [f64; 6] {
        let mut found = [0.0; 6];
        for (part, body) in found.chunks_exact_mut(3).zip(bodies) {
            if let Some(first) = self.model.first[body] {
                part.copy_from_slice(&self.accelerations[first..first + 3]);
            }
        }
        found
    }

    /// The dense matrix by differences of whole evaluations at `y`, where everything was evaluated last.
    fn matrix_by_differences(&mut self, y: &[f64], gamma: f64) -> LU<f64, Dyn, Dyn> {
        let n = self.model.coordinates();
        let mut lengths = vec![1.0; n];
        self.lengths(&mut lengths);
        let mut state = vec![0.0; 2 * n];
        self.read(y, &mut state);
        self.add_shift(self.time, &mut state);
        let mut matrix = DMatrix::identity(n, n);
        for i in 0..n {
            let change = CHANGE / lengths[i];
            let kept = (state[i], state[n + i]);
            let mut at = |sign: f64| {
                state[i] = kept.0 + sign * gamma * change;
                state[n + i] = kept.1 + sign * change;
                self.evaluate(self.time, &state);
                self.accelerations.clone()
            };
            let (up, down) = (at(1.0), at(-1.0));
            (state[i], state[n + i]) = kept;
            for (k, (up, down)) in up.iter().zip(&down).enumerate() {
                matrix[(k, i)] -= 0.5 * gamma * (up - down) / change;
            }
        }
        matrix.lu()
    }

    /// Overwrites a residual of velocities by the correction of the dense matrix by differences at `y`, where the derivative
    /// was just evaluated; false when the matrix is singular. What the sparse matrix is held against.
    pub fn correct_by_differences(&mut self, y: &[f64], gamma: f64, residual: &mut [f64]) -> bool {
        let n = self.model.coordinates();
        let matrix = self.matrix_by_differences(y, gamma);
        residual[n..].fill(0.0);
        matrix.solve_mut(&mut DVectorViewMut::from_slice(&mut residual[..n], n))
    }
}

impl SecondOrderSystem for MechanismDynamics {
    fn coordinates(&self) -> usize {
        self.model.unknowns()
    }

    fn local_unknowns(&self) -> Range<usize> {
        self.model.coordinates()..self.model.unknowns()
    }

    fn begin_implicit_stage(&mut self, step: Option<(&[f64], f64)>) {
        self.bristles.begin_implicit_stage(step);
    }

    fn write_local_solution(&self, velocities: &mut [f64]) {
        velocities.copy_from_slice(&self.bristles.deflection);
    }

    fn oscillates_at_order_two(&self) -> bool {
        self.model
            .contacts
            .iter()
            .any(|contact| contact.film.is_some())
    }

    fn factorise(&mut self, y: &[f64], gamma: f64) -> bool {
        let taken = self.corrector.take();
        let Some(mut matrix) = taken.or_else(|| self.implicit_matrix()) else {
            return false;
        };
        let nearness = self
            .kkt
            .as_ref()
            .map_or(f64::INFINITY, SparseKkt::independence);
        let singular = nearness < self.near_singular;
        let regular = if singular && self.model.coordinates() <= MOST_BY_DIFFERENCES {
            let factors = self.matrix_by_differences(y, gamma);
            let regular = factors.is_invertible();
            matrix.by_differences = Some(factors);
            regular
        } else {
            matrix.by_differences = None;
            self.linearise(&mut matrix, gamma)
        };
        self.corrector = Some(matrix);
        regular
    }

    fn correct(&mut self, residual: &mut [f64]) {
        let n = self.model.coordinates();
        // Evaluations have solved for the bristles.
        let (residual, bristles) = residual.split_at_mut(n);
        bristles.fill(0.0);
        let Some(matrix) = &mut self.corrector else {
            return;
        };
        if let Some(factors) = &matrix.by_differences {
            if !factors.solve_mut(&mut DVectorViewMut::from_slice(residual, n)) {
                residual.fill(f64::NAN);
            }
            return;
        }
        let model = &self.model;
        let right = &mut matrix.saddle.right;
        for ((right, r), mass) in right.iter_mut().zip(&*residual).zip(&model.mass) {
            *right = mass * r;
        }
        for (right, row) in right[n..].iter_mut().zip(&self.rows) {
            *right = 0.0;
            for (body, part) in row.bodies.iter().zip(&row.jacobian) {
                if let Some(first) = model.first[*body] {
                    *right += (0..3).map(|k| part[k] * residual[first + k]).sum::<f64>();
                }
            }
        }
        matrix.saddle.solve();
        residual.copy_from_slice(&matrix.saddle.right[..n]);
    }

    fn scale(&self, lengths: &mut [f64]) {
        let (bodies, bristles) = lengths.split_at_mut(self.model.coordinates());
        self.lengths(bodies);
        let contacts = self.model.contacts.iter().zip(&self.model.sides_of_contact);
        for (contact, sides) in contacts {
            if let Some(FrictionLaw::LuGre(law)) = &contact.friction {
                for bristle in self.model.bristle_of_side[sides.clone()].iter().flatten() {
                    bristles[*bristle] = SPEED_PER_LENGTH * WHOLE_DEFLECTION / law.breakaway();
                }
            }
        }
    }
}

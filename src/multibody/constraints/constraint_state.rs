//! Constraints at the last evaluation: rows, factors, multipliers, and their rank away from singular positions.

use std::sync::Arc;

use super::equation::EquationRow;
use super::jacobian::{Group, Jacobian};
use super::pin::PinTorques;
use super::sparse_kkt::SparseKkt;
use crate::geometry::Vec2;
use crate::multibody::description::body::Frame;
use crate::multibody::model::MechanismModel;

/// With redundant constraints: independence below which a constraint is always left out, over the near-singular threshold.
const FAINT: f64 = 0.1;

/// Rows, factors and multipliers of all constraints at one state.
#[derive(Debug, Clone)]
pub(crate) struct ConstraintState {
    pub(crate) rows: Vec<EquationRow>,
    jacobian: Arc<Jacobian>,
    /// Factors of the constraints; `None` without constraints.
    pub(crate) kkt: Option<SparseKkt>,
    pub(crate) multipliers: Vec<f64>,
    pub(crate) pin_torques: PinTorques,
    /// Independence of the constraints below which a position counts as near-singular.
    pub(crate) near_singular: f64,
    /// Number of independent constraints away from singular positions.
    pub(crate) rank: usize,
    /// Whether the evaluation is at an interpolation point or a trial position, where no interpolation takes place.
    pub(crate) aside: bool,
    /// Start of the last step \[s\], which decides on the side of a jump of a prescribed acceleration.
    pub(crate) step_start: f64,
    /// Work arrays of projections: residuals, changes.
    pub(crate) projecting: [Vec<f64>; 2],
}

impl ConstraintState {
    /// Return the constraints of a model, not yet evaluated.
    pub(crate) fn new(model: &MechanismModel) -> Self {
        let (n, m) = (model.coordinates(), model.constraints());
        let frames = model.start_frames();
        let equations = model.equations.iter();
        let jacobian = Arc::new(Jacobian::of(model));
        Self {
            rows: equations
                .map(|equation| equation.evaluate(0.0, &frames))
                .collect(),
            kkt: (m > 0).then(|| SparseKkt::new(model, Arc::clone(&jacobian))),
            jacobian,
            multipliers: vec![0.0; m],
            pin_torques: PinTorques::new(model.pins.len(), n),
            near_singular: 0.0,
            rank: 0,
            aside: false,
            step_start: 0.0,
            projecting: [vec![0.0; m], vec![0.0; n]],
        }
    }

    /// Evaluate the constraint equations at the body frames; a prescribed acceleration that jumps at `t` is that before a jump in the step.
    pub(crate) fn find_rows(&mut self, model: &MechanismModel, t: f64, frames: &[Frame]) {
        for group in &self.jacobian.groups {
            match group {
                Group::Point(point) => point.evaluate(frames, &mut self.rows),
                Group::Single(row) => {
                    let equation = &model.equations[*row];
                    let motion = equation.motion.as_ref();
                    let t = motion.map_or(t, |motion| motion.one_sided(t, self.step_start));
                    self.rows[*row] = equation.evaluate(t, frames);
                }
            }
        }
    }

    /// Return the independence below which a constraint is always left out: zero without redundant constraints, a part of the
    /// near-singular threshold with them. Residuals of joints make redundant constraints appear independent to about that extent.
    pub(crate) fn faint(&self) -> f64 {
        if self.rank < self.rows.len() {
            FAINT * self.near_singular
        } else {
            0.0
        }
    }

    /// Factorise without nearly dependent constraints. Return whether the rank is that away from singular positions.
    pub(crate) fn hold(&mut self) -> bool {
        let (part, faint) = (self.near_singular, self.faint());
        let Some(kkt) = &mut self.kkt else {
            return true;
        };
        kkt.factorise(&self.rows, part);
        if kkt.rank() < self.rank && faint > 0.0 {
            // Many joints together may have little independence without being singular.
            kkt.factorise(&self.rows, faint);
        }
        kkt.rank() >= self.rank
    }

    /// Factorise all constraints except those always left out.
    pub(crate) fn factorise_whole(&mut self) {
        let part = self.faint();
        if let Some(kkt) = &mut self.kkt {
            kkt.factorise(&self.rows, part);
        }
    }

    /// Return the power of the drivers \[W\]: Σ λ ∂c/∂t.
    pub(crate) fn driver_power(&self) -> f64 {
        let rows = self.rows.iter().zip(&self.multipliers);
        rows.map(|(row, lambda)| lambda * row.time_rate).sum()
    }

    /// Return the non-zero entries (constraint, coordinate, value) of the Jacobian.
    pub(crate) fn jacobian(&self) -> Vec<(usize, usize, f64)> {
        let mut entries = Vec::new();
        for (i, row) in self.rows.iter().enumerate() {
            for (first, part) in self.jacobian.parts(row) {
                entries.extend((0..3).map(|k| (i, first + k, part[k])));
            }
        }
        entries.retain(|entry| entry.2 != 0.0);
        entries
    }

    /// Return force and torque of a joint on its body b, about the joint's point b \[N, N, N m\].
    pub(crate) fn reaction(
        &self,
        model: &MechanismModel,
        frames: &[Frame],
        joint: usize,
    ) -> [f64; 3] {
        let mut load = [0.0; 3];
        // Generalised force -λ `c_q` on body b; its moment is moved from the centre of mass to point b.
        for i in model.equations_of_joint[joint].clone() {
            let end = model.equations[i].b;
            let arm = frames[end.body].turned(end.point);
            let [x, y, torque] = self.rows[i].jacobian[1].map(|j| -self.multipliers[i] * j);
            load[0] += x;
            load[1] += y;
            load[2] += torque - arm.perp(&Vec2::new(x, y));
        }
        for (pin, torque) in model.pins.iter().zip(&self.pin_torques.values) {
            if pin.joint == joint {
                load[2] += torque;
            }
        }
        load
    }

    /// Return the joint of each constraint that depends on those described before it, in the order of description.
    pub(crate) fn redundant(&mut self, model: &MechanismModel) -> Vec<String> {
        let Some(kkt) = self.kkt.as_mut().filter(|kkt| kkt.rank() < self.rows.len()) else {
            return Vec::new();
        };
        let joint = |row: usize| model.equations[row].joint;
        let name = |row: usize| model.joints[joint(row)].name.clone();
        kkt.dependent().into_iter().map(name).collect()
    }
}

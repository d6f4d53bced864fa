//! Products with the Jacobian G of the constraints. Both equations of a point between free bodies are taken at once.

use super::equation::EquationRow;
use crate::geometry::turned_left;
use crate::multibody::description::body::{End, Frame};
use crate::multibody::model::MechanismModel;

/// Both equations of a point of two free bodies a and b.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    /// Number of the first equation.
    pub(crate) row: usize,
    pub(crate) ends: [End; 2],
    /// Numbers of the bodies among the free ones: their first coordinates over three.
    pub(crate) places: [usize; 2],
}

/// Constraints that are taken at once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Group {
    Point(Point),
    /// Number of any other constraint.
    Single(usize),
}

/// Constraints in groups, with the coordinates of their bodies.
#[derive(Debug, Clone)]
pub(crate) struct Jacobian {
    pub(crate) groups: Vec<Group>,
    first: Vec<Option<usize>>,
}

impl Point {
    /// Evaluate both equations at the state of the bodies. The rows have been evaluated before: only numbers that change with the state
    /// are written.
    pub(crate) fn evaluate(&self, frames: &[Frame], rows: &mut [EquationRow]) {
        let [fa, fb] = self.ends.map(|end| &frames[end.body]);
        let (arm_a, arm_b) = (fa.turned(self.ends[0].point), fb.turned(self.ends[1].point));
        let d = (fb.origin - fa.origin) + (arm_b - arm_a);
        let (left_a, left_b) = (turned_left(arm_a), turned_left(arm_b));
        // The centripetal terms, as in [`Equation::evaluate`].
        let centripetal = fa.spin * fa.spin * arm_a - fb.spin * fb.spin * arm_b;
        for (axis, row) in rows[self.row..self.row + 2].iter_mut().enumerate() {
            row.value = d[axis];
            row.jacobian[0][2] = -left_a[axis];
            row.jacobian[1][2] = left_b[axis];
            row.gamma = -centripetal[axis];
        }
    }

    /// Return the derivatives of both equations with respect to the angles of the bodies.
    pub(crate) fn slopes(&self, rows: &[EquationRow]) -> [[f64; 2]; 2] {
        let [one, other] = [&rows[self.row].jacobian, &rows[self.row + 1].jacobian];
        [[one[0][2], one[1][2]], [other[0][2], other[1][2]]]
    }
}

impl Jacobian {
    /// Return the groups of the constraints of `model`.
    pub(crate) fn of(model: &MechanismModel) -> Self {
        let mut groups = Vec::new();
        for range in &model.equations_of_joint {
            let mut rows = range.clone();
            if let [one, _, ..] = &model.equations[range.clone()]
                && one.begins_point()
                && let [Some(a), Some(b)] = [one.a.body, one.b.body].map(|body| model.first[body])
            {
                let (row, ends, places) = (range.start, [one.a, one.b], [a / 3, b / 3]);
                groups.push(Group::Point(Point { row, ends, places }));
                rows.start += 2;
            }
            groups.extend(rows.map(Group::Single));
        }
        Self {
            groups,
            first: model.first.clone(),
        }
    }

    /// Return the coordinates of the free bodies of a row, each with its part of the row.
    pub(crate) fn parts<'a>(
        &'a self,
        row: &'a EquationRow,
    ) -> impl Iterator<Item = (usize, &'a [f64; 3])> {
        let parts = row.bodies.iter().zip(&row.jacobian);
        parts.filter_map(|(&body, part)| self.first[body].map(|first| (first, part)))
    }

    /// Write the product G x, one number per constraint.
    pub(crate) fn multiply(&self, rows: &[EquationRow], x: &[f64], product: &mut [f64]) {
        let x = by_body(x);
        for group in &self.groups {
            match group {
                Group::Point(point) => {
                    let [one, other] = point.slopes(rows);
                    let [[xa, ya, turn_a], [xb, yb, turn_b]] = point.places.map(|body| x[body]);
                    product[point.row] = xb - xa + (one[0] * turn_a + one[1] * turn_b);
                    product[point.row + 1] = yb - ya + (other[0] * turn_a + other[1] * turn_b);
                }
                Group::Single(row) => {
                    let sums = self.parts(&rows[*row]).map(|(first, part)| {
                        let x = x[first / 3];
                        (0..3).map(|k| part[k] * x[k]).sum::<f64>()
                    });
                    product[*row] = sums.sum();
                }
            }
        }
    }

    /// Add W Gᵀ λ to `x` with a diagonal matrix W of these `weights`.
    pub(crate) fn add_transposed(
        &self,
        rows: &[EquationRow],
        lambda: impl Fn(usize) -> f64,
        weights: &[f64],
        x: &mut [f64],
    ) {
        let (weights, x) = (by_body(weights), x.as_chunks_mut::<3>().0);
        for group in &self.groups {
            match group {
                Group::Point(point) => {
                    let [one, other] = point.slopes(rows);
                    let (along, across) = (lambda(point.row), lambda(point.row + 1));
                    for (k, sign) in [-1.0, 1.0].into_iter().enumerate() {
                        let body = point.places[k];
                        let (weight, sum) = (weights[body], &mut x[body]);
                        sum[0] += sign * weight[0] * along;
                        sum[1] += sign * weight[1] * across;
                        sum[2] += weight[2] * (one[k] * along + other[k] * across);
                    }
                }
                Group::Single(row) => {
                    let lambda = lambda(*row);
                    for (first, part) in self.parts(&rows[*row]) {
                        let (weight, sum) = (weights[first / 3], &mut x[first / 3]);
                        (0..3).for_each(|k| sum[k] += weight[k] * part[k] * lambda);
                    }
                }
            }
        }
    }
}

/// Return the numbers of each free body.
pub(crate) fn by_body(x: &[f64]) -> &[[f64; 3]] {
    x.as_chunks().0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::multibody::constraints::constraint_state::ConstraintState;
    use crate::multibody::{Body, Joint, JointKind, Marker, Mechanism};

    /// Return a chain of two free bars on the ground: a point of one free body, a point of two, and a slide, with the ground behind all.
    fn chain() -> MechanismModel {
        let at = |body: &str, x: f64, y: f64| Marker::new(body, x, y);
        let bar = |name: &str, x: f64| Body::new(name, 2.0, 0.5).at(x, 0.3, 0.7);
        let revolute = |name: &str, a, b| Joint::new(name, a, b, JointKind::Revolute);
        let weld = Joint::new(
            "weld",
            at("b", 0.3, 0.2),
            at("c", -0.1, 0.4),
            JointKind::Fixed { angle: None },
        );
        MechanismModel::compile(&Mechanism {
            bodies: vec![bar("a", 0.1), bar("b", 1.2), bar("c", 1.9)],
            joints: vec![
                revolute("ground", at("ground", 0.0, 0.0), at("a", -0.4, 0.1)),
                revolute("between", at("a", 0.5, 0.2), at("b", -0.6, -0.3)),
                weld,
            ],
            ..Mechanism::default()
        })
        .unwrap()
    }

    #[test]
    fn products_are_those_of_all_entries() {
        let model = chain();
        let mut state = ConstraintState::new(&model);
        let frames: Vec<_> = (0..4)
            .map(|k| {
                Frame::new(
                    [0.1, 0.3, 0.7].map(|x| f64::from(k) * x),
                    [0.2, 0.6, -1.1].map(|v| f64::from(k) * v),
                )
            })
            .collect();
        state.find_rows(&model, 0.0, &frames);
        for (row, equation) in state.rows.iter().zip(&model.equations) {
            assert_eq!(*row, equation.evaluate(0.0, &frames));
        }
        let jacobian = Jacobian::of(&model);
        let points: Vec<_> = jacobian
            .groups
            .iter()
            .map(|g| matches!(g, Group::Point(_)))
            .collect();
        // Both equations of the ground's point alone, two points of free bodies, and an angle.
        assert_eq!(points, [false, false, true, true, false]);
        let (n, m) = (model.coordinates(), model.constraints());
        let x: Vec<f64> = (0..n).map(|k| (1.0 + k as f64).sin()).collect();
        let lambda: Vec<f64> = (0..m).map(|i| (2.0 + i as f64).cos()).collect();
        let weights: Vec<f64> = (0..n).map(|k| 1.0 / (1.0 + k as f64)).collect();
        let (mut along, mut pushed) = (vec![0.0; m], x.clone());
        for (row, k, value) in state.jacobian() {
            along[row] += value * x[k];
            pushed[k] += weights[k] * value * lambda[row];
        }
        let (mut product, mut sum) = (vec![f64::NAN; m], x.clone());
        jacobian.multiply(&state.rows, &x, &mut product);
        jacobian.add_transposed(&state.rows, |i| lambda[i], &weights, &mut sum);
        let apart = |a: &[f64], b: &[f64]| {
            a.iter()
                .zip(b)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max)
        };
        assert!(
            apart(&product, &along) < 1e-15 && apart(&sum, &pushed) < 1e-15,
            "{product:?} {along:?}"
        );
    }
}

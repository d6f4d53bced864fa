//! Second derivatives of the quantity of a constraint equation, and its third derivatives along the velocities.

use super::equation::{Equation, Quantity};
use super::relative_kinematics::{CoordinateBlock, Pair};
use crate::geometry::{Vec2, turned_left};
use crate::multibody::description::body::Frame;

/// Derivatives of a quantity c with respect to the coordinates of bodies a and b.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct JointSlopes {
    /// ∂²c/∂q².
    pub(crate) second: CoordinateBlock,
    /// ∂(v · ∂²c/∂q² v)/∂q.
    pub(crate) third: [f64; 6],
}

impl Equation {
    /// Return the second derivatives, and the third ones along the velocities; `None` for a linear equation.
    pub(crate) fn slopes(&self, frames: &[Frame]) -> Option<JointSlopes> {
        let mut found = JointSlopes::default();
        let pair = Pair::new(self.a, self.b, frames, false);
        match self.quantity {
            Quantity::Angle | Quantity::Gear(_) => return None,
            Quantity::Coincident(axis) => {
                // Only angles enter non-linearly, each by its own arm: ∂²d/∂θ² and ∂d''/∂θ.
                for k in [2, 5] {
                    found.second[k][k] = pair.second(k, k)[axis];
                    found.third[k] = pair.second_rate_by(k)[axis];
                }
            }
            Quantity::Along(direction) | Quantity::Rack(direction, _) => {
                let u = frames[self.a.body].turned(direction);
                // u rotates with body a, so ∂²(u·d)/∂q² = u·∂²d/∂q² for d relative to the frame of a.
                let seen = Pair::new(self.a, self.b, frames, true);
                found.second = fill(|k, l| u.dot(&seen.second(k, l)));
                found.third = std::array::from_fn(|k| along_third(&pair, u, k));
            }
            Quantity::Distance(length) => {
                // c = (d·d - L²) / 2L: L ∂²c/∂q² = `d_k`·`d_l` + d·`d_kl`, and L ∂c''/∂q = ∂(d'·d' + d·d'')/∂q.
                let (d, rate) = (pair.d, pair.rate());
                found.second = fill(|k, l| {
                    (pair.plain_first(k).dot(&pair.plain_first(l)) + d.dot(&pair.second(k, l)))
                        / length
                });
                found.third = std::array::from_fn(|k| {
                    let turning = 2.0 * rate.dot(&pair.rate_by(k)) + d.dot(&pair.second_rate_by(k));
                    (turning + pair.plain_first(k).dot(&pair.second_rate())) / length
                });
            }
        }
        Some(found)
    }
}

/// Return the matrix with the entries of a function of row and column.
fn fill(entry: impl Fn(usize, usize) -> f64) -> CoordinateBlock {
    std::array::from_fn(|k| std::array::from_fn(|l| entry(k, l)))
}

/// Return ∂(u''·d + 2 u'·d' + u·d'')/∂q for a direction u that rotates with body a.
fn along_third(pair: &Pair, u: Vec2, k: usize) -> f64 {
    let (spin, left) = (pair.v[2], turned_left(u));
    let (u_rate, u_second) = (spin * left, -spin * spin * u);
    let mut found = u_second.dot(&pair.plain_first(k))
        + 2.0 * u_rate.dot(&pair.rate_by(k))
        + u.dot(&pair.second_rate_by(k));
    // Terms of the rotation of u with body a: ∂u/∂`θ_a` = left(u).
    if k == 2 {
        found += -spin * spin * left.dot(&pair.d) - 2.0 * spin * u.dot(&pair.rate())
            + left.dot(&pair.second_rate());
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::multibody::description::body::End;

    /// Return three bodies with fixed coordinates and velocities; coordinate number `moved` is changed by `change`.
    fn frames(moved: usize, change: f64) -> Vec<Frame> {
        let mut q = [[0.1, -0.2, 0.3], [0.7, 0.4, -1.1], [0.2, 0.9, 2.0]];
        let v = [[0.5, 0.2, 1.3], [-0.4, 0.8, -0.7], [0.3, 0.1, 0.9]];
        q[moved / 3][moved % 3] += change;
        (0..3).map(|i| Frame::new(q[i], v[i])).collect()
    }

    #[test]
    fn second_and_third_derivatives_are_those_of_the_rows() {
        let direction = Vec2::new(0.6, 0.8);
        let end = |body, x, y| End {
            body,
            point: Vec2::new(x, y),
        };
        for quantity in [
            Quantity::Coincident(0),
            Quantity::Coincident(1),
            Quantity::Along(direction),
            Quantity::Distance(0.4),
            Quantity::Rack(direction, 0.15),
        ] {
            let equation = Equation {
                joint: 0,
                quantity,
                a: end(0, 0.3, 0.1),
                b: end(1, -0.2, 0.25),
                carrier: 2,
                offset: 0.0,
                motion: None,
            };
            let slopes = equation.slopes(&frames(0, 0.0)).unwrap();
            let h = 1e-6;
            for l in 0..6 {
                let at = |change: f64| equation.evaluate(0.0, &frames(l, change));
                let (up, down) = (at(h), at(-h));
                for k in 0..6 {
                    let entry =
                        |row: &super::super::equation::EquationRow| row.jacobian[k / 3][k % 3];
                    let expected = (entry(&up) - entry(&down)) / (2.0 * h);
                    let found = slopes.second[k][l];
                    assert!(
                        (found - expected).abs() < 1e-8,
                        "{quantity:?} {k} {l}: {found} {expected}"
                    );
                }
                // γ = -v · ∂²c/∂q² v, as it stands on the right-hand side.
                let expected = -(up.gamma - down.gamma) / (2.0 * h);
                let found = slopes.third[l];
                assert!(
                    (found - expected).abs() < 1e-7,
                    "{quantity:?} {l}: {found} {expected}"
                );
            }
        }
        assert!(
            Equation {
                quantity: Quantity::Gear(2.0),
                joint: 0,
                a: end(0, 0.0, 0.0),
                b: end(1, 0.0, 0.0),
                carrier: 2,
                offset: 0.0,
                motion: None,
            }
            .slopes(&frames(0, 0.0))
            .is_none()
        );
    }
}

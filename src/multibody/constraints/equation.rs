//! One scalar constraint equation c(q, t) = 0: its value, its row of the Jacobian, and its right-hand side γ for accelerations.

use crate::geometry::{Vec2, turned_left};
use crate::multibody::description::body::{End, Frame};
use crate::multibody::description::driver::PrescribedMotion;

/// Quantity that an equation constrains. Points a and b are the joint's ends; directions are in the frame of body a.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Quantity {
    /// x (0) or y (1) of point b less that of point a.
    Coincident(usize),
    /// Displacement of point b from point a along a direction.
    Along(Vec2),
    /// Angle of body b less that of body a.
    Angle,
    /// (|d|² - L²) / 2L for the vector d from point a to point b.
    Distance(f64),
    /// (`θ_b` - `θ_c`) - ratio (`θ_a` - `θ_c`).
    Gear(f64),
    /// Displacement along a direction less radius · (`θ_b` - `θ_a`).
    Rack(Vec2, f64),
}

/// A scalar constraint: quantity - offset - motion(t) = 0.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Equation {
    /// Number of the joint that the equation belongs to.
    pub(crate) joint: usize,
    pub(crate) quantity: Quantity,
    pub(crate) a: End,
    pub(crate) b: End,
    /// Carrier of a gear; the ground (0) otherwise.
    pub(crate) carrier: usize,
    pub(crate) offset: f64,
    pub(crate) motion: Option<PrescribedMotion>,
}

/// An equation at one state: c, its row of `Φ_q` for up to three bodies, `∂c/∂t` and γ of `Φ_q` q'' = γ.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct EquationRow {
    pub(crate) value: f64,
    pub(crate) bodies: [usize; 3],
    pub(crate) jacobian: [[f64; 3]; 3],
    pub(crate) time_rate: f64,
    pub(crate) gamma: f64,
}

impl EquationRow {
    /// Return dc/dt for the velocities of the bodies.
    pub(crate) fn rate(&self, frames: &[Frame]) -> f64 {
        let parts = self.bodies.iter().zip(&self.jacobian);
        parts.fold(self.time_rate, |sum, (&body, j)| {
            let frame = &frames[body];
            sum + j[0] * frame.velocity.x + j[1] * frame.velocity.y + j[2] * frame.spin
        })
    }
}

impl Equation {
    /// Return whether the residual is an angle.
    pub(crate) fn is_angle(&self) -> bool {
        matches!(self.quantity, Quantity::Angle | Quantity::Gear(_))
    }

    /// Return the residual as reported: a length or an angle.
    ///
    /// The equation of a distance L at the actual distance d is (d² - L²) / 2L, which is smooth where the points coincide. The
    /// residual reported is d - L.
    pub(crate) fn residual(&self, row: &EquationRow) -> f64 {
        match self.quantity {
            Quantity::Distance(length) => {
                // d² = L (L + 2c), and d - L = (d² - L²) / (d + L) without cancellation.
                let found = (length * (length + 2.0 * row.value)).max(0.0).sqrt();
                2.0 * length * row.value / (found + length)
            }
            _ => row.value,
        }
    }

    /// Return the rate of the residual as reported.
    pub(crate) fn residual_rate(&self, row: &EquationRow, frames: &[Frame]) -> f64 {
        match self.quantity {
            Quantity::Distance(length) => {
                let found = length + self.residual(row);
                // c' = d d' / L, so d' = c' L / d.
                let part = if found > 0.0 { length / found } else { 1.0 };
                row.rate(frames) * part
            }
            _ => row.rate(frames),
        }
    }

    /// Return the quantity without offset and prescribed motion.
    pub(crate) fn quantity(&self, frames: &[Frame]) -> f64 {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let d = fb.place(self.b.point) - fa.place(self.a.point);
        match self.quantity {
            Quantity::Coincident(axis) => d[axis],
            Quantity::Along(direction) => fa.turned(direction).dot(&d),
            Quantity::Angle => fb.angle - fa.angle,
            Quantity::Distance(length) => (d.norm_squared() - length * length) / (2.0 * length),
            Quantity::Gear(ratio) => {
                let carrier = frames[self.carrier].angle;
                (fb.angle - carrier) - ratio * (fa.angle - carrier)
            }
            Quantity::Rack(direction, radius) => {
                fa.turned(direction).dot(&d) - radius * (fb.angle - fa.angle)
            }
        }
    }

    /// Return whether this equation and the next one keep two points together, without offset and motion.
    pub(crate) fn begins_point(&self) -> bool {
        self.quantity == Quantity::Coincident(0) && self.offset == 0.0 && self.motion.is_none()
    }

    /// Evaluate the equation at time `t` and the state of the bodies.
    pub(crate) fn evaluate(&self, t: f64, frames: &[Frame]) -> EquationRow {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let (arm_a, arm_b) = (fa.turned(self.a.point), fb.turned(self.b.point));
        let d = (fb.origin - fa.origin) + (arm_b - arm_a);
        let mut row = EquationRow {
            bodies: [self.a.body, self.b.body, self.carrier],
            ..EquationRow::default()
        };
        // d'' = (terms in the accelerations) + `ω_a`² `arm_a` - `ω_b`² `arm_b`: the centripetal terms.
        let centripetal = fa.spin * fa.spin * arm_a - fb.spin * fb.spin * arm_b;
        let rate = |frame: &Frame, arm: Vec2| frame.velocity + frame.spin * turned_left(arm);
        match self.quantity {
            Quantity::Coincident(axis) => {
                row.value = d[axis];
                row.jacobian[0][axis] = -1.0;
                row.jacobian[0][2] = -turned_left(arm_a)[axis];
                row.jacobian[1][axis] = 1.0;
                row.jacobian[1][2] = turned_left(arm_b)[axis];
                row.gamma = -centripetal[axis];
            }
            Quantity::Along(direction) | Quantity::Rack(direction, _) => {
                let n = fa.turned(direction);
                let left = turned_left(n);
                let d_rate = rate(fb, arm_b) - rate(fa, arm_a);
                row.value = n.dot(&d);
                row.jacobian[0] = [-n.x, -n.y, left.dot(&d) - n.dot(&turned_left(arm_a))];
                row.jacobian[1] = [n.x, n.y, n.dot(&turned_left(arm_b))];
                // (n·d)'' = n·d'' + 2 n'·d' + n''·d with n' = ω left(n) and n'' = ω' left(n) - ω² n.
                row.gamma = -(n.dot(&centripetal) + 2.0 * fa.spin * left.dot(&d_rate)
                    - fa.spin * fa.spin * n.dot(&d));
                if let Quantity::Rack(_, radius) = self.quantity {
                    row.value -= radius * (fb.angle - fa.angle);
                    row.jacobian[0][2] += radius;
                    row.jacobian[1][2] -= radius;
                }
            }
            Quantity::Angle => {
                row.value = fb.angle - fa.angle;
                row.jacobian[0][2] = -1.0;
                row.jacobian[1][2] = 1.0;
            }
            Quantity::Distance(length) => {
                let d_rate = rate(fb, arm_b) - rate(fa, arm_a);
                let n = d / length;
                row.value = (d.norm_squared() - length * length) / (2.0 * length);
                row.jacobian[0] = [-n.x, -n.y, -n.dot(&turned_left(arm_a))];
                row.jacobian[1] = [n.x, n.y, n.dot(&turned_left(arm_b))];
                // ((d·d - L²) / 2L)'' = (d'·d' + d·d'') / L.
                row.gamma = -(d_rate.norm_squared() / length + n.dot(&centripetal));
            }
            Quantity::Gear(ratio) => {
                let carrier = frames[self.carrier].angle;
                row.value = (fb.angle - carrier) - ratio * (fa.angle - carrier);
                row.jacobian[0][2] = -ratio;
                row.jacobian[1][2] = 1.0;
                row.jacobian[2][2] = ratio - 1.0;
            }
        }
        row.value -= self.offset;
        if let Some(motion) = &self.motion {
            let [value, rate, acceleration] = motion.derivatives(t);
            row.value -= value;
            row.time_rate = -rate;
            row.gamma += acceleration;
        }
        row
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Signal;

    /// Return bodies that move with constant accelerations, given for each coordinate.
    fn frames(t: f64, acceleration: [[f64; 3]; 3]) -> Vec<Frame> {
        let starts = [[0.1, -0.2, 0.3], [0.7, 0.4, -1.1], [0.2, 0.9, 2.0]];
        let rates = [[0.5, 0.2, 1.3], [-0.4, 0.8, -0.7], [0.3, 0.1, 0.9]];
        (0..3)
            .map(|i| {
                let at = |k: usize| starts[i][k] + t * (rates[i][k] + 0.5 * t * acceleration[i][k]);
                let speed = |k: usize| rates[i][k] + t * acceleration[i][k];
                Frame::new([at(0), at(1), at(2)], [speed(0), speed(1), speed(2)])
            })
            .collect()
    }

    #[test]
    fn a_distance_is_missed_by_a_length() {
        let end = |body, x| End {
            body,
            point: Vec2::new(x, 0.0),
        };
        let equation = Equation {
            joint: 0,
            quantity: Quantity::Distance(0.5),
            a: end(0, 0.0),
            b: end(1, 0.0),
            carrier: 0,
            offset: 0.0,
            motion: None,
        };
        for found in [0.5 + 1e-12, 0.7, 3.0, 0.1] {
            let frames = [
                Frame::new([0.0; 3], [0.0; 3]),
                Frame::new([0.6 * found, 0.8 * found, 0.0], [0.6, 0.8, 0.0]),
            ];
            let row = equation.evaluate(0.0, &frames);
            assert!((equation.residual(&row) - (found - 0.5)).abs() < 1e-15);
            assert!((equation.residual_rate(&row, &frames) - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn rates_and_second_derivatives_are_those_of_the_value() {
        let accelerations = [[0.3, -0.6, 1.1], [0.9, 0.2, -0.5], [-0.8, 0.4, 0.7]];
        let direction = Vec2::new(0.6, 0.8);
        for quantity in [
            Quantity::Coincident(0),
            Quantity::Coincident(1),
            Quantity::Along(direction),
            Quantity::Angle,
            Quantity::Distance(0.4),
            Quantity::Gear(-1.7),
            Quantity::Rack(direction, 0.15),
        ] {
            let equation = Equation {
                joint: 0,
                quantity,
                a: End {
                    body: 0,
                    point: Vec2::new(0.3, 0.1),
                },
                b: End {
                    body: 1,
                    point: Vec2::new(-0.2, 0.25),
                },
                carrier: 2,
                offset: 0.05,
                motion: Some(PrescribedMotion::Position(Signal::Sines {
                    offset: 0.0,
                    terms: vec![[0.3, 2.0, 0.1]],
                })),
            };
            let at = |t: f64| equation.evaluate(t, &frames(t, accelerations));
            let (t, h) = (0.2, 1e-5);
            let here = frames(t, accelerations);
            let row = at(t);
            let rate = row.rate(&here);
            let difference = (at(t + h).value - at(t - h).value) / (2.0 * h);
            assert!((rate - difference).abs() < 1e-8, "{quantity:?}");
            let rate_at = |t: f64| at(t).rate(&frames(t, accelerations));
            let second = (rate_at(t + h) - rate_at(t - h)) / (2.0 * h);
            let linear: f64 = (0..3)
                .map(|i| {
                    (0..3)
                        .map(|k| row.jacobian[i][k] * accelerations[i][k])
                        .sum::<f64>()
                })
                .sum();
            assert!(
                (linear - row.gamma - second).abs() < 1e-7,
                "{quantity:?}: {linear} {} {second}",
                row.gamma
            );
            assert!(
                (equation.quantity(&here) - 0.05 - 0.3 * (0.5f64).sin() - row.value).abs() < 1e-15
            );
        }
    }
}

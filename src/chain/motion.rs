//! Positions and velocities of all bodies, one array per quantity.

use crate::chain::model::{Model, Rotation, SprocketModel, Support};
use crate::geometry::Vec2;

/// Positions and velocities of all bodies: links first, then rollers, then sprockets and guides.
#[derive(Debug, Clone, Default)]
pub struct Motion {
    /// x \[m\]
    pub x: Vec<f64>,
    /// y \[m\]
    pub y: Vec<f64>,
    /// θ \[rad\]
    pub angle: Vec<f64>,
    /// dx/dt \[m/s\]
    pub vx: Vec<f64>,
    /// dy/dt \[m/s\]
    pub vy: Vec<f64>,
    /// dθ/dt \[rad/s\]
    pub spin: Vec<f64>,
    /// cos θ of links at the last evaluation of their hinges
    pub cos: Vec<f64>,
    /// sin θ of links at the last evaluation of their hinges
    pub sin: Vec<f64>,
}

impl Motion {
    /// Create arrays of zeros for `bodies` bodies.
    #[must_use]
    pub fn new(bodies: usize) -> Self {
        let zeros = || vec![0.0; bodies];
        Self {
            x: zeros(),
            y: zeros(),
            angle: zeros(),
            vx: zeros(),
            vy: zeros(),
            spin: zeros(),
            cos: zeros(),
            sin: zeros(),
        }
    }

    /// Read the state `y` = [q, dq/dt, ...] at time `t` \[s\].
    pub fn read(&mut self, model: &Model, t: f64, y: &[f64]) {
        let n = model.links;
        // q = [all link x, all link y, all link θ, sprockets and guides, all roller x, all roller y, all roller θ, bristles, padding]
        let (q, v) = (
            &y[..model.coordinates],
            &y[model.coordinates..2 * model.coordinates],
        );
        self.x[..n].copy_from_slice(&q[..n]);
        self.y[..n].copy_from_slice(&q[n..2 * n]);
        self.angle[..n].copy_from_slice(&q[2 * n..3 * n]);
        self.vx[..n].copy_from_slice(&v[..n]);
        self.vy[..n].copy_from_slice(&v[n..2 * n]);
        self.spin[..n].copy_from_slice(&v[2 * n..3 * n]);
        if let Some(rollers) = &model.rollers {
            let (q, v) = (&q[rollers.first..], &v[rollers.first..]);
            self.x[n..2 * n].copy_from_slice(&q[..n]);
            self.y[n..2 * n].copy_from_slice(&q[n..2 * n]);
            self.angle[n..2 * n].copy_from_slice(&q[2 * n..3 * n]);
            self.vx[n..2 * n].copy_from_slice(&v[..n]);
            self.vy[n..2 * n].copy_from_slice(&v[n..2 * n]);
            self.spin[n..2 * n].copy_from_slice(&v[2 * n..3 * n]);
        }
        for (i, sprocket) in model.sprockets.iter().enumerate() {
            let ((center, velocity), (angle, spin)) =
                sprocket_motion(sprocket, t, |j| (q[j], v[j]));
            let body = model.wheel_body(i);
            (self.x[body], self.y[body]) = (center.x, center.y);
            (self.vx[body], self.vy[body]) = (velocity.x, velocity.y);
            (self.angle[body], self.spin[body]) = (angle, spin);
        }
    }

    /// Set positions and velocities of all bodies.
    pub fn set(&mut self, positions: &[[f64; 3]], velocities: &[[f64; 3]]) {
        for (i, (p, v)) in positions.iter().zip(velocities).enumerate() {
            [self.x[i], self.y[i], self.angle[i]] = *p;
            [self.vx[i], self.vy[i], self.spin[i]] = *v;
        }
    }

    /// Return (x, y, θ) of every body \[m, m, rad\].
    #[must_use]
    pub fn positions(&self) -> Vec<[f64; 3]> {
        self.each_position().collect()
    }

    /// Return (dx/dt, dy/dt, dθ/dt) of every body \[m/s, m/s, rad/s\].
    #[must_use]
    pub fn velocities(&self) -> Vec<[f64; 3]> {
        self.each_velocity().collect()
    }

    /// Go through (x, y, θ) of every body \[m, m, rad\].
    pub(crate) fn each_position(&self) -> impl Iterator<Item = [f64; 3]> {
        triples([&self.x, &self.y, &self.angle])
    }

    /// Go through (dx/dt, dy/dt, dθ/dt) of every body \[m/s, m/s, rad/s\].
    pub(crate) fn each_velocity(&self) -> impl Iterator<Item = [f64; 3]> {
        triples([&self.vx, &self.vy, &self.spin])
    }

    /// Write the generalized coordinates and velocities of these motions into the state `y`.
    pub fn write(&self, model: &Model, y: &mut [f64]) {
        let n = model.links;
        let (q, v) = y.split_at_mut(model.coordinates);
        q[..n].copy_from_slice(&self.x[..n]);
        q[n..2 * n].copy_from_slice(&self.y[..n]);
        q[2 * n..3 * n].copy_from_slice(&self.angle[..n]);
        v[..n].copy_from_slice(&self.vx[..n]);
        v[n..2 * n].copy_from_slice(&self.vy[..n]);
        v[2 * n..3 * n].copy_from_slice(&self.spin[..n]);
        if let Some(rollers) = &model.rollers {
            let (q, v) = (&mut q[rollers.first..], &mut v[rollers.first..]);
            q[..n].copy_from_slice(&self.x[n..2 * n]);
            q[n..2 * n].copy_from_slice(&self.y[n..2 * n]);
            q[2 * n..3 * n].copy_from_slice(&self.angle[n..2 * n]);
            v[..n].copy_from_slice(&self.vx[n..2 * n]);
            v[n..2 * n].copy_from_slice(&self.vy[n..2 * n]);
            v[2 * n..3 * n].copy_from_slice(&self.spin[n..2 * n]);
        }
        for (i, sprocket) in model.sprockets.iter().enumerate() {
            let body = model.wheel_body(i);
            let center = Vec2::new(self.x[body], self.y[body]);
            let velocity = Vec2::new(self.vx[body], self.vy[body]);
            match sprocket.support {
                Support::Fixed => {}
                Support::Slide {
                    index,
                    direction,
                    guide,
                    ..
                } => {
                    let s = guide.place(direction, center - sprocket.center);
                    q[index] = s;
                    v[index] = velocity.dot(&guide.tangent(direction, s));
                }
                Support::Floating { x, y } => {
                    (q[x], q[y]) = (center.x, center.y);
                    (v[x], v[y]) = (velocity.x, velocity.y);
                }
            }
            if let Rotation::Free { index, .. } = sprocket.rotation {
                (q[index], v[index]) = (self.angle[body], self.spin[body]);
            }
        }
    }
}

/// Return the vectors of these arrays.
fn triples([x, y, angle]: [&[f64]; 3]) -> impl Iterator<Item = [f64; 3]> {
    let triples = x.iter().zip(y).zip(angle);
    triples.map(|((&x, &y), &angle)| [x, y, angle])
}

/// Return ((centre, velocity), (angle, angular speed)) of one sprocket at time `t` \[s\].
///
/// `value` returns a generalized coordinate and its velocity.
pub(crate) fn sprocket_motion(
    sprocket: &SprocketModel,
    t: f64,
    value: impl Fn(usize) -> (f64, f64),
) -> ((Vec2, Vec2), (f64, f64)) {
    let at = match sprocket.support {
        Support::Fixed => (sprocket.center, Vec2::zeros()),
        Support::Slide {
            index,
            direction,
            guide,
            ..
        } => {
            let (s, speed) = value(index);
            (
                sprocket.center + guide.offset(direction, s),
                speed * guide.tangent(direction, s),
            )
        }
        Support::Floating { x, y } => {
            let ((x, vx), (y, vy)) = (value(x), value(y));
            (Vec2::new(x, y), Vec2::new(vx, vy))
        }
    };
    let turn = match &sprocket.rotation {
        Rotation::Free { index, .. } => value(*index),
        Rotation::Prescribed(speed) => (sprocket.phase + speed.integral(t), speed.value(t)),
    };
    (at, turn)
}

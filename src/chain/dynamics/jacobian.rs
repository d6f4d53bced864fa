//! Exact derivatives of the loads, contact by contact, in the chain's own pattern.
//!
//! Every contact is a force between two points: F on the one, a function of their offset e and its rate. A coordinate moves the
//! offset by g = de/dq and its rate by h = d(de/dt)/dq; its generalized force is g·F. The matrix of Newton's method for
//! velocities, M - γ dQ/dv - γ² dQ/dq, gets `-g_i·[(γ² K + γ D) g_j + γ² D h_j]` with K = dF/de and D = dF/d(de/dt), and on its
//! diagonal what comes of the bend d²e/dq². On a tooth the second point is the centre of curvature, at rest in the sprocket.

use nalgebra::{Matrix2, Matrix3, RowVector3, Vector3};

use super::chain_solver::ChainMatrix;
use crate::chain::model::{Model, Rotation, Support};
use crate::geometry::{Vec2, turned_left};

/// Distance that stands for the centre of curvature of a flat \[m\].
pub(super) const FAR: f64 = 1e3;

/// A contact's force and how it changes.
pub(super) struct PointForce {
    /// On the first point \[N\].
    pub(super) force: Vec2,
    /// γ² dF/de + γ dF/d(de/dt).
    stiffness: Matrix2<f64>,
    /// γ² dF/d(de/dt).
    damping: Matrix2<f64>,
    /// γ²
    gamma_squared: f64,
}

/// Numbers of a contact that its derivatives need.
pub(super) struct Pressed {
    /// Direction in which the penetration grows.
    pub(super) normal: Vec2,
    /// Offset over its distance is this times the normal: 1 inside, -1 outside.
    pub(super) side: f64,
    /// |e| \[m\].
    pub(super) distance: f64,
    /// de/dt \[m/s\].
    pub(super) velocity: Vec2,
    /// Normal force \[N\], and its slopes with penetration \[N/m\] and rate \[N s/m\].
    pub(super) force: f64,
    pub(super) stiffness: f64,
    pub(super) damping: f64,
}

impl PointForce {
    pub(super) fn new(contact: &Pressed, gamma: f64) -> Self {
        let n = contact.normal;
        let across = Matrix2::identity() - n * n.transpose();
        let curvature = contact.side / contact.distance;
        // d(rate)/de
        let rate_slope = curvature * (across * contact.velocity);
        let by_offset = contact.stiffness * n * n.transpose()
            + contact.damping * n * rate_slope.transpose()
            + contact.force * curvature * across;
        let by_velocity = contact.damping * n * n.transpose();
        let gamma_squared = gamma * gamma;
        Self {
            force: -contact.force * n,
            stiffness: -(gamma_squared * by_offset + gamma * by_velocity),
            damping: -gamma_squared * by_velocity,
            gamma_squared,
        }
    }

    /// The change of force that goes with coordinate `j`.
    fn change(&self, j: &Lever) -> Vec2 {
        self.stiffness * j.offset + self.damping * j.velocity
    }
}

/// How a coordinate moves the offset of a contact.
#[derive(Clone, Copy)]
pub(super) struct Lever {
    /// de/dq
    offset: Vec2,
    /// d(de/dt)/dq
    velocity: Vec2,
    /// d²e/dq²
    bend: Vec2,
}

/// The three coordinates of a link whose end on one side of a contact lies at `along` from its centre.
pub(super) fn link_levers(sign: f64, along: Vec2, spin: f64) -> [Lever; 3] {
    let straight = |offset| Lever {
        offset,
        velocity: Vec2::zeros(),
        bend: Vec2::zeros(),
    };
    [
        straight(Vec2::new(sign, 0.0)),
        straight(Vec2::new(0.0, sign)),
        Lever {
            offset: turned_left(along),
            velocity: -spin * along,
            bend: -along,
        },
    ]
}

/// Rotation of a sprocket whose point lies at `from_center`.
pub(super) fn turning_lever(from_center: Vec2, spin: f64) -> Lever {
    Lever {
        offset: -turned_left(from_center),
        velocity: spin * from_center,
        bend: from_center,
    }
}

/// A sprocket's centre moving along `direction`.
pub(super) fn moving_lever(direction: Vec2) -> Lever {
    Lever {
        offset: -direction,
        velocity: Vec2::zeros(),
        bend: Vec2::zeros(),
    }
}

/// The sprocket's own coordinates among those of the border, with their levers.
pub(super) fn sprocket_levers(
    model: &Model,
    s: usize,
    center: Vec2,
    from_center: Vec2,
    spin: f64,
    mut take: impl FnMut(usize, Lever),
) {
    let first = 3 * model.links;
    let sprocket = &model.sprockets[s];
    match sprocket.support {
        Support::Fixed => {}
        Support::Slide {
            index,
            direction,
            guide,
            ..
        } => {
            // An arm turns its way; the bend of the way itself is slight against the teeth's stiffness.
            let s = guide.place(direction, center - sprocket.center);
            take(index - first, moving_lever(guide.tangent(direction, s)));
        }
        Support::Floating { x, y } => {
            take(x - first, moving_lever(Vec2::x()));
            take(y - first, moving_lever(Vec2::y()));
        }
    }
    if let Rotation::Free { index, .. } = sprocket.rotation {
        take(index - first, turning_lever(from_center, spin));
    }
}

/// The entry of levers i and j.
fn entry(force: &PointForce, i: &Lever, j: &Lever) -> f64 {
    -i.offset.dot(&force.change(j))
}

/// What a coordinate's own bend adds to its diagonal entry.
fn bend(force: &PointForce, i: &Lever) -> f64 {
    -force.gamma_squared * i.bend.dot(&force.force)
}

/// What columns' coordinates do to the generalized forces of rows'.
pub(super) fn block(force: &PointForce, rows: &[Lever; 3], columns: &[Lever; 3]) -> Matrix3<f64> {
    let changes = columns.map(|lever| force.change(&lever));
    Matrix3::from_fn(|i, j| -rows[i].offset.dot(&changes[j]))
}

impl ChainMatrix {
    /// Adds what a contact with these levers does to body `k` by itself.
    pub(super) fn add_body(&mut self, k: usize, force: &PointForce, levers: &[Lever; 3]) {
        self.diagonal[k] += block(force, levers, levers);
        self.diagonal[k][(2, 2)] += bend(force, &levers[2]);
    }

    /// Adds hinge `k` between the ends with these levers.
    pub(super) fn add_hinge(
        &mut self,
        k: usize,
        force: &PointForce,
        front: &[Lever; 3],
        rear: &[Lever; 3],
    ) {
        let next = (k + 1) % self.diagonal.len();
        self.add_body(k, force, front);
        self.add_body(next, force, rear);
        self.upper[k] += block(force, front, rear);
        self.lower[k] += block(force, rear, front);
    }

    /// Adds a bushing of `link` on a sprocket with these coordinates.
    pub(super) fn add_tooth(
        &mut self,
        link: usize,
        force: &PointForce,
        bushing: &[Lever; 3],
        sprocket: &[(usize, Lever)],
    ) {
        let m = self.border();
        self.add_body(link, force, bushing);
        for (j, lever) in sprocket {
            let change = force.change(lever);
            self.column[link * m + j] += Vector3::from_fn(|i, _| -bushing[i].offset.dot(&change));
            self.row[link * m + j] += RowVector3::from_fn(|_, i| entry(force, lever, &bushing[i]));
            for (i, other) in sprocket {
                self.corner[i * m + j] += entry(force, other, lever);
            }
            self.corner[j * m + j] += bend(force, lever);
        }
    }

    /// Adds the tensioner's spring and stops.
    pub(super) fn add_springs(&mut self, model: &Model, pawls: &[f64], y: &[f64], gamma: f64) {
        let (first, m) = (3 * model.links, self.border());
        for (sprocket, &pawl) in model.sprockets.iter().zip(pawls) {
            if let Support::Slide { index, guide, .. } = sprocket.support {
                let j = index - first;
                self.corner[j * m + j] += gamma * gamma * guide.stiffness_at(y[index], pawl);
            }
            if let (Some(swing), Rotation::Free { index, .. }) =
                (sprocket.swing, &sprocket.rotation)
            {
                let j = index - first;
                let stiffness = swing.stiffness_at(y[*index] - sprocket.phase, pawl);
                self.corner[j * m + j] += gamma * gamma * stiffness;
            }
        }
    }

    /// Adds masses, and the tensioner's dashpot.
    pub(super) fn add_masses(&mut self, model: &Model, gamma: f64) {
        for (i, block) in self.diagonal.iter_mut().enumerate() {
            block[(0, 0)] += model.mass[i];
            block[(1, 1)] += model.mass[i];
            block[(2, 2)] += model.inertia[i];
        }
        let (first, m) = (3 * model.links, self.border());
        let mut add = |index: usize, value: f64| {
            let j = index - first;
            self.corner[j * m + j] += value;
        };
        for sprocket in &model.sprockets {
            match sprocket.support {
                Support::Fixed => {}
                Support::Slide {
                    index,
                    guide,
                    damping,
                    ..
                } => {
                    add(index, sprocket.mass + guide.extra_mass + gamma * damping);
                }
                Support::Floating { x, y } => {
                    add(x, sprocket.mass);
                    add(y, sprocket.mass);
                }
            }
            if let Rotation::Free { index, .. } = sprocket.rotation {
                let dashpot = sprocket.swing.map_or(0.0, |swing| {
                    let [back, forth] = swing.dashpots;
                    back.max(forth)
                });
                add(index, sprocket.inertia + gamma * dashpot);
            }
        }
    }
}

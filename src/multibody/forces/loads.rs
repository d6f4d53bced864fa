//! Resultant force and torque of each body, with stored energies, dissipated power and power of applied forces.

use crate::geometry::Vec2;
use crate::multibody::description::body::Frame;

/// Sum of all forces at one state, with their energies and powers.
#[derive(Debug, Clone, Default)]
pub(crate) struct BodyLoads {
    /// Force and torque about the centre of mass of each body \[N, N, N m\].
    pub(crate) on: Vec<[f64; 3]>,
    /// Loads on the free coordinates, once all are summed.
    pub(crate) free: Vec<f64>,
    /// Energy stored in springs and contacts \[J\].
    pub(crate) elastic: f64,
    /// Energy stored in bristles \[J\].
    pub(crate) bristles: f64,
    /// Power dissipated in dampers and contacts, including the power stored in bristles \[W\].
    pub(crate) dissipated: f64,
    /// Power of applied forces, whose integral is the external work \[W\].
    pub(crate) external_work: f64,
}

impl BodyLoads {
    pub(crate) fn new(bodies: usize, coordinates: usize) -> Self {
        Self {
            on: vec![[0.0; 3]; bodies],
            free: vec![0.0; coordinates],
            ..Self::default()
        }
    }

    /// Set all loads, energies and powers to zero.
    pub(crate) fn clear(&mut self) {
        self.on.fill([0.0; 3]);
        (self.elastic, self.bristles) = (0.0, 0.0);
        (self.dissipated, self.external_work) = (0.0, 0.0);
    }

    /// Add a force \[N\] on a body at a point \[m\]; both are in the ground's frame.
    pub(crate) fn push(&mut self, body: usize, frame: &Frame, place: Vec2, force: Vec2) {
        let arm = place - frame.origin;
        let load = &mut self.on[body];
        load[0] += force.x;
        load[1] += force.y;
        load[2] += arm.perp(&force);
    }

    /// Add a torque on a body \[N m\].
    pub(crate) fn twist(&mut self, body: usize, torque: f64) {
        self.on[body][2] += torque;
    }

    /// Copy the loads of all bodies that are not fixed. `first`: number of each body's first coordinate.
    pub(crate) fn gather_free(&mut self, first: &[Option<usize>]) {
        for (load, first) in self.on.iter().zip(first) {
            if let Some(i) = *first {
                self.free[i..i + 3].copy_from_slice(load);
            }
        }
    }
}

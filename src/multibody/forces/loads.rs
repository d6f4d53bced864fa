//! Forces and torques gathered per body, with the energy stored and the powers that go with them.

use crate::geometry::Vec2;
use crate::multibody::description::body::Frame;

/// What all forces together do at one state.
#[derive(Debug, Clone, Default)]
pub(crate) struct Loads {
    /// Force and torque about the centre of mass of each body \[N, N, N m\].
    pub(crate) on: Vec<[f64; 3]>,
    /// Energy stored in springs and contacts \[J\].
    pub(crate) elastic: f64,
    /// Energy stored in bristles \[J\].
    pub(crate) bristles: f64,
    /// Power lost in dampers and contacts, with the work that bristles store \[W\].
    pub(crate) dissipated: f64,
    /// Power of applied forces \[W\].
    pub(crate) worked_in: f64,
}

impl Loads {
    pub(crate) fn new(bodies: usize) -> Self {
        Self {
            on: vec![[0.0; 3]; bodies],
            ..Self::default()
        }
    }

    /// Begins with nothing.
    pub(crate) fn clear(&mut self) {
        self.on.fill([0.0; 3]);
        (self.elastic, self.bristles) = (0.0, 0.0);
        (self.dissipated, self.worked_in) = (0.0, 0.0);
    }

    /// A force on a body at a place of the ground's frame.
    pub(crate) fn push(&mut self, body: usize, frame: &Frame, place: Vec2, force: Vec2) {
        let arm = place - frame.origin;
        let load = &mut self.on[body];
        load[0] += force.x;
        load[1] += force.y;
        load[2] += arm.x * force.y - arm.y * force.x;
    }

    /// A torque on a body.
    pub(crate) fn twist(&mut self, body: usize, torque: f64) {
        self.on[body][2] += torque;
    }
}

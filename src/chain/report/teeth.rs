//! Tooth contacts of bushings or rollers, from the last evaluation of the kernels.

use crate::chain::contact::SprocketCandidates;
use crate::chain::model::Model;
use crate::chain::rhs::ToothReadings;
use crate::geometry::{Surface, Vec2, turned_left};

/// Contacts of all bushings with all sprockets; pair `sprocket * links + bushing`.
#[derive(Debug, Clone)]
pub struct ToothContacts {
    /// Penetration δ \[m\]; -inf for a pair out of reach.
    pub penetration: Vec<f64>,
    /// Pairs within reach, sprocket by sprocket; the arrays below are valid for these pairs only.
    pub near: Vec<u32>,
    /// Penetration rate dδ/dt \[m/s\].
    pub rate: Vec<f64>,
    /// Direction of increasing penetration, x.
    pub normal_x: Vec<f64>,
    /// Direction of increasing penetration, y.
    pub normal_y: Vec<f64>,
    /// Centre of the bushing relative to that of the sprocket, x \[m\].
    pub arm_x: Vec<f64>,
    /// Centre of the bushing relative to that of the sprocket, y \[m\].
    pub arm_y: Vec<f64>,
    /// Number of the surface.
    pub surface: Vec<Surface>,
    /// Region from 1.
    pub region: Vec<u8>,
    /// Tooth gap of the bushing.
    pub gap: Vec<u32>,
    /// Normal force \[N\].
    pub force: Vec<f64>,
    /// Friction on the sprocket, along the normal turned left \[N\]; zero without a law of friction.
    pub friction: Vec<f64>,
}

impl ToothContacts {
    /// Create arrays for every pair.
    #[must_use]
    pub fn new(links: usize, sprockets: usize) -> Self {
        let pairs = links * sprockets;
        let zeros = || vec![0.0; pairs];
        Self {
            penetration: vec![f64::NEG_INFINITY; pairs],
            near: Vec::with_capacity(pairs),
            rate: zeros(),
            normal_x: zeros(),
            normal_y: zeros(),
            arm_x: zeros(),
            arm_y: zeros(),
            surface: vec![Surface::SEATING; pairs],
            region: vec![0; pairs],
            gap: vec![0; pairs],
            force: zeros(),
            friction: zeros(),
        }
    }

    /// Return the force of the sprocket on the bushing of a pair within reach, with friction \[N\].
    #[must_use]
    pub fn force_on_bushing(&self, pair: usize) -> Vec2 {
        let normal = Vec2::new(self.normal_x[pair], self.normal_y[pair]);
        -self.force[pair] * normal - self.friction[pair] * turned_left(normal)
    }

    /// Mark all pairs as out of reach.
    pub(crate) fn clear(&mut self) {
        for &pair in &self.near {
            self.penetration[pair as usize] = f64::NEG_INFINITY;
            self.force[pair as usize] = 0.0;
            self.friction[pair as usize] = 0.0;
        }
        self.near.clear();
    }

    /// Copy the candidates of sprocket `s` within reach of its teeth from `readings` of an evaluation.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // pairs and surfaces are few
    pub(crate) fn read(
        &mut self,
        model: &Model,
        s: usize,
        candidates: &SprocketCandidates,
        readings: &ToothReadings,
    ) {
        let sprocket = &model.sprockets[s];
        let reach_squared = sprocket.reach * sprocket.reach;
        for (slot, k) in candidates.bushings(model.links) {
            if !model.bushing_is_there(k) {
                continue;
            }
            let arm = Vec2::new(readings.arm[0][slot], readings.arm[1][slot]);
            if arm.norm_squared() >= reach_squared {
                continue;
            }
            let pair = s * model.links + k;
            let surface = Surface(readings.surface[slot] as u8);
            self.near.push(pair as u32);
            self.penetration[pair] = readings.penetration[slot];
            self.rate[pair] = readings.rate[slot];
            (self.arm_x[pair], self.arm_y[pair]) = (arm.x, arm.y);
            self.normal_x[pair] = readings.normal[0][slot];
            self.normal_y[pair] = readings.normal[1][slot];
            self.surface[pair] = surface;
            self.region[pair] = sprocket.profile.region(surface, readings.left[slot] > 0.0);
            self.gap[pair] = candidates.gap[slot];
            self.force[pair] = candidates.force[slot];
            self.friction[pair] = candidates.friction[slot];
        }
    }
}

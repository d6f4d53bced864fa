//! Tooth contacts of bushings or rollers, from the last evaluation of the kernels.

use crate::chain::contact::SprocketCandidates;
use crate::chain::model::Model;
use crate::chain::rhs::ToothReadings;
use crate::geometry::{Surface, ToothProfile};

/// Contacts of all bushings with all sprockets; pair `sprocket * links + bushing`.
#[derive(Debug, Clone)]
pub struct ToothContacts {
    links: usize,
    /// Penetration δ \[m\]; -inf for a pair out of reach.
    pub penetration: Vec<f64>,
    /// Pairs within reach, sprocket by sprocket; the arrays below are valid for these pairs only.
    pub near: Vec<u32>,
    /// Penetration rate dδ/dt \[m/s\].
    pub rate: Vec<f64>,
    /// Number of the surface, and one on a left flank, zero on a right one; as the kernels write them.
    surface: Vec<f64>,
    left: Vec<f64>,
    /// Tooth gap of the bushing.
    pub gap: Vec<u32>,
    /// Normal force \[N\].
    pub force: Vec<f64>,
    /// Force of the sprocket on the bushing, with friction, x and y \[N\].
    pub on_bushing: [Vec<f64>; 2],
}

impl ToothContacts {
    /// Create arrays for every pair.
    #[must_use]
    pub fn new(links: usize, sprockets: usize) -> Self {
        let pairs = links * sprockets;
        let zeros = || vec![0.0; pairs];
        Self {
            links,
            penetration: vec![f64::NEG_INFINITY; pairs],
            near: Vec::with_capacity(pairs),
            rate: zeros(),
            surface: zeros(),
            left: zeros(),
            gap: vec![0; pairs],
            force: zeros(),
            on_bushing: [zeros(), zeros()],
        }
    }

    /// Return (pair, sprocket, bushing) of all pairs within reach.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, usize, usize)> {
        // `near` is in the order of the sprockets: counted on, without a division.
        let (mut sprocket, mut first) = (0, 0);
        self.near.iter().map(move |&pair| {
            let pair = pair as usize;
            while pair >= first + self.links {
                (sprocket, first) = (sprocket + 1, first + self.links);
            }
            (pair, sprocket, pair - first)
        })
    }

    /// Return the surface of a pair within reach.
    #[must_use]
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // surfaces are few
    pub fn surface(&self, pair: usize) -> Surface {
        Surface(self.surface[pair] as u8)
    }

    /// Return the region from 1 of a pair within reach, on a sprocket of this profile.
    #[must_use]
    pub fn region(&self, profile: &ToothProfile, pair: usize) -> u8 {
        profile.region(self.surface(pair), self.left[pair] > 0.0)
    }

    /// Mark all pairs as out of reach.
    pub(crate) fn clear(&mut self) {
        for &pair in &self.near {
            self.penetration[pair as usize] = f64::NEG_INFINITY;
            self.force[pair as usize] = 0.0;
        }
        self.near.clear();
    }

    /// Copy the candidates of sprocket `s` from `readings` of an evaluation.
    #[allow(clippy::cast_possible_truncation)] // pairs are few
    pub(crate) fn read(
        &mut self,
        model: &Model,
        s: usize,
        candidates: &SprocketCandidates,
        readings: &ToothReadings,
    ) {
        let [force_x, force_y] = &mut self.on_bushing;
        let mut copies = [
            (&mut self.penetration, &readings.penetration),
            (&mut self.rate, &readings.rate),
            (&mut self.surface, &readings.surface),
            (&mut self.left, &readings.left),
            (&mut self.force, &candidates.force),
            (force_x, &readings.on_bushing[0]),
            (force_y, &readings.on_bushing[1]),
        ];
        for (first, slots) in candidates.pieces(self.links) {
            let pair = s * self.links + first;
            let pairs = pair..pair + slots.len();
            for (to, from) in &mut copies {
                to[pairs.clone()].copy_from_slice(&from[slots.clone()]);
            }
            self.gap[pairs].copy_from_slice(&candidates.gap[slots]);
        }
        let penetration = &mut *copies[0].0;
        for (first, slots) in candidates.pieces(self.links) {
            let pair = s * self.links + first;
            let depths = &mut penetration[pair..pair + slots.len()];
            for ((pair, k), depth) in (pair..).zip(first..).zip(depths) {
                if model.ends.is_some() && !model.bushing_is_there(k) {
                    *depth = f64::NEG_INFINITY;
                }
                if *depth != f64::NEG_INFINITY {
                    self.near.push(pair as u32);
                }
            }
        }
    }
}

//! Deviations of the link lengths from the nominal pitch: wear and manufacturing spread.

use serde::{Deserialize, Serialize};

use super::Chain;
use crate::error::{Error, Result, check};

/// Number of uniform variates in a sum: twelve have the variance one.
const SUMMANDS: u32 = 12;

/// Deviations of the link lengths from the pitch.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Variation {
    /// Elongation of links by wear as a share of the pitch: none, one for all, or one for each.
    pub elongation: Vec<f64>,
    /// Standard deviation of the link lengths, as a share of the pitch.
    pub pitch_spread: f64,
    /// Seed of the random deviations.
    pub seed: u64,
}

impl Variation {
    pub(super) fn validate(&self, links: u32) -> Result<()> {
        for &elongation in &self.elongation {
            check::within("Chain.elongation", elongation, -0.02, 0.1)?;
        }
        if self.elongation.len() > 1 && self.elongation.len() != links as usize {
            return Err(Error::invalid(
                "Chain.elongation",
                format!("{} numbers", self.elongation.len()),
                format!("must be one number, or one for each of the {links} links"),
            ));
        }
        check::within("Chain.pitch_spread", self.pitch_spread, 0.0, 0.01)
    }

    /// Return whether all links are as long as the pitch.
    pub(crate) fn is_none(&self) -> bool {
        self.elongation.iter().all(|&elongation| elongation == 0.0) && self.pitch_spread == 0.0
    }
}

impl Chain {
    /// Return the distance of the hinges of each link \[m\].
    ///
    /// The spread is the sum of twelve uniform variates, which is normal within a few per cent up to three standard
    /// deviations and never exceeds six. The result is the same on every machine.
    #[must_use]
    pub fn link_pitches(&self) -> Vec<f64> {
        let Variation {
            elongation,
            pitch_spread,
            seed,
        } = &self.variation;
        let mut noise = SplitMix(*seed);
        let worn = |i: usize| match elongation[..] {
            [] => 0.0,
            [all] => all,
            _ => elongation[i],
        };
        (0..self.links as usize)
            .map(|i| {
                let deviation = if *pitch_spread > 0.0 {
                    pitch_spread * noise.normal()
                } else {
                    0.0
                };
                self.pitch * (1.0 + worn(i) + deviation)
            })
            .collect()
    }

    /// Return the mean distance of the hinges of a link \[m\].
    #[must_use]
    pub fn mean_pitch(&self) -> f64 {
        if self.variation.is_none() {
            return self.pitch;
        }
        self.link_pitches().iter().sum::<f64>() / f64::from(self.links)
    }
}

/// The generator `SplitMix64` of Steele, Lea and Flood.
struct SplitMix(u64);

impl SplitMix {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Return a uniform variate between 0 and 1.
    fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Return a variate of mean 0 and variance 1.
    fn normal(&mut self) -> f64 {
        (0..SUMMANDS).map(|_| self.uniform()).sum::<f64>() - 0.5 * f64::from(SUMMANDS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_noise_is_that_of_its_authors_and_has_mean_0_and_variance_1() {
        // First numbers of the published generator from the seed 1234567.
        let mut noise = SplitMix(1_234_567);
        assert_eq!(noise.next(), 6_457_827_717_110_365_317);
        assert_eq!(noise.next(), 3_203_168_211_198_807_973);
        let mut noise = SplitMix(7);
        let drawn: Vec<f64> = (0..20_000).map(|_| noise.normal()).collect();
        let mean = drawn.iter().sum::<f64>() / 20_000.0;
        let variance = drawn.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 20_000.0;
        // Five standard errors, 1/sqrt(20000) and sqrt(2/20000).
        assert!(
            mean.abs() < 0.036 && (variance - 1.0).abs() < 0.05,
            "{mean} {variance}"
        );
    }
}

//! Where a tensioner lets a sprocket's centre go: a straight line or a circle about a pivot, a spring, and stops.

use crate::geometry::Vec2;
use crate::geometry::path::guide_path;

/// The way of a centre, by its distance s along it \[m\] from the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guide {
    /// 1/radius of the way \[1/m\], positive where it bends to the left; 0: straight.
    pub curvature: f64,
    /// What holds the centre back \[N/m\].
    pub stiffness: f64,
    /// Where the stops are: least and greatest s \[m\].
    pub stops: [f64; 2],
    /// Stiffness of the stops \[N/m\].
    pub stop_stiffness: f64,
    /// Dashpots against a centre that moves back and forth \[N s/m\].
    pub dashpots: [f64; 2],
    /// Mass that moves along besides the sprocket's own \[kg\].
    pub extra_mass: f64,
    /// What lets it move one way only.
    pub ratchet: Option<Ratchet>,
}

/// A rack and its pawl: a stop that follows what moves forward, tooth by tooth.
///
/// How far the pawl has come is remembered between steps (`ImpactMemory::pawls`). It falls behind a tooth only when that has passed, so
/// that the stop is never loaded where it moves: neither force nor energy jumps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ratchet {
    /// Distance of the teeth along the way \[m\]; 0: the pawl holds anywhere.
    pub step: f64,
    /// 1 where it lets s grow, -1 where it lets it fall.
    pub forward: f64,
}

impl Ratchet {
    /// How far forward the pawl stands, which was at `pawl` before, when what it holds is at s.
    #[must_use]
    pub fn follow(&self, pawl: f64, s: f64) -> f64 {
        let way = self.forward * s;
        let tooth = if self.step > 0.0 {
            (way / self.step).floor() * self.step
        } else {
            way
        };
        pawl.max(tooth)
    }
}

impl Guide {
    /// Displacement of the centre at s.
    #[must_use]
    pub fn offset(&self, direction: Vec2, s: f64) -> Vec2 {
        guide_path::along(direction, self.curvature, s).0
    }

    /// Unit vector along the way at s.
    #[must_use]
    pub fn tangent(&self, direction: Vec2, s: f64) -> Vec2 {
        guide_path::along(direction, self.curvature, s).1
    }

    /// s of a centre that is displaced by `offset`.
    #[must_use]
    pub fn place(&self, direction: Vec2, offset: Vec2) -> f64 {
        guide_path::place(direction, self.curvature, offset)
    }

    /// Force of spring and stops along the way \[N\], the pawl of a ratchet where it stands.
    #[must_use]
    pub fn force(&self, s: f64, pawl: f64) -> f64 {
        -self.stiffness * s - self.stop_stiffness * self.past_stop(s, pawl)
    }

    /// How it falls with s \[N/m\].
    #[must_use]
    pub fn stiffness_at(&self, s: f64, pawl: f64) -> f64 {
        let stopped = if self.past_stop(s, pawl) == 0.0 {
            0.0
        } else {
            self.stop_stiffness
        };
        self.stiffness + stopped
    }

    /// Dashpot at a speed along the way \[N s/m\].
    #[must_use]
    pub fn dashpot(&self, speed: f64) -> f64 {
        self.dashpots[usize::from(speed >= 0.0)]
    }

    /// Energy in spring and stops \[J\].
    #[must_use]
    pub fn energy(&self, s: f64, pawl: f64) -> f64 {
        let past = self.past_stop(s, pawl);
        0.5 * self.stiffness * s * s + 0.5 * self.stop_stiffness * past * past
    }

    fn past_stop(&self, s: f64, pawl: f64) -> f64 {
        let [mut least, mut greatest] = self.stops;
        match self.ratchet {
            Some(ratchet) if ratchet.forward > 0.0 => least = least.max(pawl),
            Some(_) => greatest = greatest.min(-pawl),
            None => {}
        }
        (s - greatest).max(0.0) + (s - least).min(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::STOP_STIFFNESS;

    #[test]
    fn spring_and_stops_push_back_with_the_slope_of_their_energy() {
        let guide = Guide {
            curvature: 0.0,
            stiffness: 800.0,
            stops: [-0.002, 0.005],
            stop_stiffness: STOP_STIFFNESS,
            extra_mass: 0.0,
            dashpots: [0.0; 2],
            ratchet: None,
        };
        let no_pawl = f64::NEG_INFINITY;
        for s in [-0.003, -0.001, 0.004, 0.0052] {
            let h = 1e-7;
            let slope = (guide.energy(s + h, no_pawl) - guide.energy(s - h, no_pawl)) / (2.0 * h);
            assert!((slope + guide.force(s, no_pawl)).abs() < 1e-5 * slope.abs());
            let stiffness = (guide.force(s - h, no_pawl) - guide.force(s + h, no_pawl)) / (2.0 * h);
            assert!((stiffness - guide.stiffness_at(s, no_pawl)).abs() < 1e-6 * stiffness);
        }
    }

    #[test]
    fn a_ratchet_holds_behind_the_last_tooth_passed_and_lets_go_forward() {
        for forward in [1.0, -1.0] {
            let ratchet = Ratchet {
                step: 0.5e-3,
                forward,
            };
            let guide = Guide {
                curvature: 0.0,
                stiffness: 0.0,
                stops: [-1.0, 1.0],
                stop_stiffness: STOP_STIFFNESS,
                extra_mass: 0.0,
                dashpots: [0.0; 2],
                ratchet: Some(ratchet),
            };
            let mut pawl = ratchet.follow(f64::NEG_INFINITY, 0.0);
            assert_eq!(pawl, 0.0);
            for way in [0.3e-3, 0.7e-3, 1.2e-3, 0.9e-3, 0.1e-3] {
                let before = guide.energy(forward * way, pawl);
                let next = ratchet.follow(pawl, forward * way);
                // Where the pawl moves on, nothing presses on it, behind its old tooth or its new one.
                if next > pawl {
                    assert_eq!(before, 0.0);
                    assert_eq!(guide.energy(forward * way, next), 0.0);
                }
                pawl = next;
            }
            assert!((pawl - 1e-3).abs() < 1e-18);
            assert_eq!(guide.force(forward * 1.1e-3, pawl), 0.0);
            let push = forward * guide.force(forward * 0.99e-3, pawl);
            assert!((push - 1e-5 * STOP_STIFFNESS).abs() < 1e-9 * push);
        }
    }
}

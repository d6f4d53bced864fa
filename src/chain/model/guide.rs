//! Guide path of a tensioner: a straight line or a circle about a pivot, with spring, stops, dashpots and ratchet.

use crate::geometry::Vec2;
use crate::geometry::path::guide_path;

/// Guide path of a centre and the forces along it, as functions of the displacement s along the slide \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guide {
    /// Curvature of the guide path \[1/m\], positive for a bend to the left; 0: straight.
    pub curvature: f64,
    /// Stiffness of the spring \[N/m\]; its force is zero at s = 0.
    pub stiffness: f64,
    /// Positions of the stops: smallest and largest s without a stop force \[m\].
    pub stops: [f64; 2],
    /// Stiffness of the stops \[N/m\].
    pub stop_stiffness: f64,
    /// Dashpot coefficients for ds/dt < 0 and for ds/dt >= 0 \[N s/m\].
    pub dashpots: [f64; 2],
    /// Additional moving mass besides that of the sprocket \[kg\].
    pub extra_mass: f64,
    /// Ratchet that permits motion in one direction only.
    pub ratchet: Option<Ratchet>,
}

/// Rack and pawl: a stop that follows the forward motion tooth by tooth.
///
/// The position of the pawl is stored between steps (`ImpactMemory::pawls`). The pawl engages behind a tooth only after that tooth has
/// passed: the stop carries no load when it moves, and neither force nor energy is discontinuous.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ratchet {
    /// Pitch of the rack along the guide path \[m\]; 0: the pawl holds at any position.
    pub step: f64,
    /// 1 if s can only increase, -1 if s can only decrease.
    pub forward: f64,
}

impl Ratchet {
    /// Return the new forward position of a pawl at `pawl` for a displacement s.
    ///
    /// With way = ± s and the pitch p of the rack: max(pawl, p floor(way/p)).
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
    /// Return the displacement vector of the centre at s \[m\].
    #[must_use]
    pub fn offset(&self, direction: Vec2, s: f64) -> Vec2 {
        guide_path::along(direction, self.curvature, s).0
    }

    /// Return the tangent of the guide path at s.
    #[must_use]
    pub fn tangent(&self, direction: Vec2, s: f64) -> Vec2 {
        guide_path::along(direction, self.curvature, s).1
    }

    /// Return s of a centre displaced by `offset` \[m\].
    #[must_use]
    pub fn place(&self, direction: Vec2, offset: Vec2) -> f64 {
        guide_path::place(direction, self.curvature, offset)
    }

    /// Return the force of spring and stops along the guide path \[N\], for a pawl at `pawl`.
    #[must_use]
    pub fn force(&self, s: f64, pawl: f64) -> f64 {
        -self.stiffness * s - self.stop_stiffness * self.past_stop(s, pawl)
    }

    /// Return the stiffness -dF/ds of spring and stops \[N/m\].
    #[must_use]
    pub fn stiffness_at(&self, s: f64, pawl: f64) -> f64 {
        let stopped = if self.past_stop(s, pawl) == 0.0 {
            0.0
        } else {
            self.stop_stiffness
        };
        self.stiffness + stopped
    }

    /// Return the dashpot coefficient for a speed ds/dt along the guide path \[N s/m\].
    #[must_use]
    pub fn dashpot(&self, speed: f64) -> f64 {
        self.dashpots[usize::from(speed >= 0.0)]
    }

    /// Return the energy stored in spring and stops \[J\].
    #[must_use]
    pub fn energy(&self, s: f64, pawl: f64) -> f64 {
        let past = self.past_stop(s, pawl);
        0.5 * self.stiffness * s * s + 0.5 * self.stop_stiffness * past * past
    }

    /// Return the displacement beyond the stops \[m\]: positive beyond the greatest s, negative beyond the least s, else zero.
    ///
    /// The pawl of a ratchet replaces the stop behind it where it is nearer.
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
                // The pawl carries no load when it moves, neither behind its previous tooth nor behind its new one.
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

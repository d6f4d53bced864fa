//! Where a tensioner lets a sprocket's centre go: a straight line or a circle about a pivot, a spring, and stops.

use crate::geometry::{Vec2, way};

/// Stiffness of a stop \[N/m\]: 0.1 mm under 1 kN.
pub(super) const STOP_STIFFNESS: f64 = 1e7;

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
}

impl Guide {
    /// Displacement of the centre at s.
    #[must_use]
    pub fn offset(&self, direction: Vec2, s: f64) -> Vec2 {
        way::along(direction, self.curvature, s).0
    }

    /// Unit vector along the way at s.
    #[must_use]
    pub fn tangent(&self, direction: Vec2, s: f64) -> Vec2 {
        way::along(direction, self.curvature, s).1
    }

    /// s of a centre that is displaced by `offset`.
    #[must_use]
    pub fn place(&self, direction: Vec2, offset: Vec2) -> f64 {
        way::place(direction, self.curvature, offset)
    }

    /// Force of spring and stops along the way \[N\].
    #[must_use]
    pub fn force(&self, s: f64) -> f64 {
        -self.stiffness * s - self.stop_stiffness * self.past_stop(s)
    }

    /// How it falls with s \[N/m\].
    #[must_use]
    pub fn stiffness_at(&self, s: f64) -> f64 {
        let stopped = if self.past_stop(s) == 0.0 {
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
    pub fn energy(&self, s: f64) -> f64 {
        0.5 * self.stiffness * s * s + 0.5 * self.stop_stiffness * self.past_stop(s).powi(2)
    }

    fn past_stop(&self, s: f64) -> f64 {
        let [least, greatest] = self.stops;
        (s - greatest).max(0.0) + (s - least).min(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spring_and_stops_push_back_with_the_slope_of_their_energy() {
        let guide = Guide {
            curvature: 0.0,
            stiffness: 800.0,
            stops: [-0.002, 0.005],
            stop_stiffness: STOP_STIFFNESS,
            extra_mass: 0.0,
            dashpots: [0.0; 2],
        };
        for s in [-0.003, -0.001, 0.004, 0.0052] {
            let h = 1e-7;
            let slope = (guide.energy(s + h) - guide.energy(s - h)) / (2.0 * h);
            assert!((slope + guide.force(s)).abs() < 1e-5 * slope.abs());
            let stiffness = (guide.force(s - h) - guide.force(s + h)) / (2.0 * h);
            assert!((stiffness - guide.stiffness_at(s)).abs() < 1e-6 * stiffness);
        }
    }
}

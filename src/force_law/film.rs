//! Lubricant film between a pin and its bushing: squeeze and wedge of a long bearing, half film, transition to dry contact.
//!
//! In a frame that rotates with the mean spin of both surfaces, the film depends only on the velocity u of the eccentricity. The Reynolds
//! equation of an infinitely long bearing is `d/dθ (h³ dp/dθ) = -12 μ R² u·n(θ)`, h = c (1 - ε cos θ), θ from the eccentricity. One of its
//! periodic solutions vanishes at two opposite places,
//!
//! `p = 6 μ R²/c³ (2 - ε cos θ)/(1 - ε cos θ)² g·n(θ)`, `g = (u_r, 2 u_t/(2 + ε²))`,
//!
//! and its positive half is the film (Gümbel). Its integral is exact:
//!
//! `F_r = -6 μ L R³/c³ (J g_r + 2 ε |g|)/(1 - ε²)`, `F_t = -6 μ L R³/c³ J g_t`,
//! `J = (π + 2 arctan(ε g_r/(|g| √(1 - ε²))))/√(1 - ε²)`.
//!
//! At low pressures no cavity forms and the other half carries load too. The share b of its force, that of -g with opposite sign, is added:
//! `b = g₀/√(g² + g₀²)`, where g₀ is the speed at which 6 μ R² g/c³ equals the tension that the film sustains. Without this share the film
//! would be up to a hundred times softer in tension than in compression, a kink at rest.
//!
//! For the wedge alone, the forces are those of the half Sommerfeld film. For the squeeze alone, they are those of Pinkus and Sternlicht,
//! Theory of Hydrodynamic Lubrication, 1961. The dissipated power is that of the pressure, -F·u, and that of shear around the whole pin
//! (Petroff, with the eccentricity). The shear torque on one body is S times the difference of the spins, `S = 2π μ L R³/(c √(1 - ε²))`.
//! Neither power is ever negative.
//!
//! From ε = `handover` to 1 film force and shear are multiplied by a polynomial of order five in ε, whose first and second derivatives
//! vanish at both ends. The onset of dry contact is at ε = 1. Flores, Ambrósio, Claro, Lankarani and Koshy (Mechanism and Machine Theory 41
//! (2006) 247) weight film and contact linearly, within a band outside the clearance.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, check};
use crate::math::simd::arc_tangent;
use crate::math::{Real, Truth};

/// Lower bound of √(g² + g₀²) \[m/s\], far below rounding of any velocity. At rest without tension any change of the velocity changes the slopes.
const LEAST_REACH: f64 = 1e-100;

/// Lubricant film of the hinges.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Film {
    /// Dynamic viscosity μ \[Pa s\].
    pub viscosity: f64,
    /// Length L of the film along the pin, of one strand \[m\]; none: the contact length.
    pub length: Option<f64>,
    /// Ratio of eccentricity to clearance at the start of the transition to dry contact.
    pub handover: f64,
    /// Tension, the pressure below ambient that the film sustains before it cavitates \[Pa\]; zero: Gümbel's half film.
    pub tension: f64,
}

impl Film {
    /// Check all numbers.
    ///
    /// # Errors
    /// The error has the field, its value and the permitted range.
    pub fn check(&self, name: &str) -> Result<()> {
        if !(self.viscosity > 0.0 && self.viscosity.is_finite()) {
            return Err(Error::invalid(
                format!("{name}.viscosity"),
                self.viscosity,
                "must be a positive number; for dry hinges, leave the film out",
            ));
        }
        if let Some(length) = self.length {
            check::positive(&format!("{name}.length"), length, "m")?;
        }
        check::not_negative(&format!("{name}.tension"), self.tension, "Pa")?;
        if !(0.1..=0.99).contains(&self.handover) {
            return Err(Error::invalid(
                format!("{name}.handover"),
                self.handover,
                "must be from 0.1 to 0.99, an eccentricity over the clearance",
            ));
        }
        Ok(())
    }

    /// Return the film of several parallel strands as one: a given length is that of one strand.
    #[must_use]
    pub fn of_strands(self, strands: u32) -> Self {
        let length = self.length.map(|length| f64::from(strands) * length);
        Self { length, ..self }
    }

    /// Return the film in hinges of this pin radius, radial clearance and contact length \[m\].
    #[must_use]
    pub fn between(&self, pin_radius: f64, clearance: f64, length: f64) -> HingeFilm {
        let length = self.length.unwrap_or(length);
        let viscous = self.viscosity * length * pin_radius.powi(3);
        HingeFilm {
            viscosity: self.viscosity,
            clearance,
            pressure: 6.0 * viscous / clearance.powi(3),
            shear: 2.0 * PI * viscous / clearance,
            handover: self.handover,
            speed: self.tension * clearance.powi(3) / (6.0 * self.viscosity * pin_radius.powi(2)),
        }
    }
}

/// Constants of the film of one kind of hinge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HingeFilm {
    /// μ \[Pa s\]
    pub viscosity: f64,
    /// c \[m\]
    pub clearance: f64,
    /// 6 μ L R³/c³ \[N s/m\]
    pub pressure: f64,
    /// 2π μ L R³/c \[N m s\]
    pub shear: f64,
    /// Ratio of [`Film::handover`].
    pub handover: f64,
    /// g₀ \[m/s\]
    pub speed: f64,
}

/// Derivatives of the film's force and shear with the length of the eccentricity, the velocity along it and the velocity to its left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FilmGradient {
    /// Derivatives of both components of the force \[N/m, N s/m, N s/m\].
    pub(crate) force: [[f64; 3]; 2],
    /// Derivative of the shear coefficient with the eccentricity \[N s\].
    pub(crate) shear: f64,
}

/// Force and shear coefficient of a film.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmForce<R = f64> {
    /// Force on the eccentric body, along the eccentricity and to its left \[N\].
    pub force: [R; 2],
    /// S, torque on one body per relative spin of the other \[N m s\].
    pub shear: R,
}

impl HingeFilm {
    /// Return the film at an eccentricity of this length \[m\]. `velocity` has the components along it and to its left \[m/s\], in a frame
    /// that rotates with the mean spin.
    #[must_use]
    pub fn at(&self, eccentricity: f64, velocity: [f64; 2]) -> FilmForce {
        FilmLaw::new((), self).at(eccentricity, velocity, 1.0).film
    }

    /// Return the film with its derivatives.
    pub(crate) fn slopes(
        &self,
        eccentricity: f64,
        velocity: [f64; 2],
    ) -> (FilmForce, FilmGradient) {
        let law = FilmLaw::new((), self);
        let filled = law.at(eccentricity, velocity, 1.0);
        let found = law.gradient(&filled);
        let [[xx, xy], [yx, yy]] = found.by_g;
        let (most, s) = (found.most, &filled.state);
        let gradient = FilmGradient {
            force: [
                [-found.longer[0], -(most * xx), -(most * s.slant * xy)],
                [-found.longer[1], -(most * yx), -(most * s.slant * yy)],
            ],
            // S = 2π μ L R³/c w/√(1 - ε²)
            shear: law.shear
                * law.inverse_clearance
                * s.over_root
                * (s.weight * s.ratio).mul_add(s.over_rest, found.weight_slope),
        };
        (filled.film, gradient)
    }
}

/// The film law with precomputed constants, for one hinge or a vector of hinges.
#[derive(Clone, Copy)]
pub(crate) struct FilmLaw<R> {
    inverse_clearance: R,
    pressure: R,
    shear: R,
    /// 1/(1 - handover)
    over_band: R,
    /// g₀
    speed: R,
}

/// Film forces and their intermediate quantities.
#[derive(Clone, Copy)]
pub(crate) struct Filled<R> {
    pub(crate) film: FilmForce<R>,
    /// Intermediate quantities for [`FilmLaw::slopes`].
    state: State<R>,
}

#[derive(Clone, Copy)]
struct State<R> {
    ratio: R,
    part: R,
    weight: R,
    /// 1/(1 - ε²)
    over_rest: R,
    /// 2/(2 + ε²)
    slant: R,
    velocity: [R; 2],
    /// g, its magnitude and its direction.
    g: [R; 2],
    size: R,
    direction: [R; 2],
    /// b
    other: R,
    /// 1/√(g² + g₀²), zero without a film.
    inverse_reach: R,
    /// π - 2 arctan(...)
    rest_of_turn: R,
    over_root: R,
    /// J, including the share of the other half.
    turn: R,
    /// Force over the weight and -6 μ L R³/c³.
    shape: [R; 2],
}

/// Negative derivatives of the force along the eccentricity and to its left.
struct Gradient<R> {
    /// Factor of `by_g`, w 6 μ L R³/c³ \[N s/m\].
    most: R,
    /// Derivatives of both components with g, over `most`; with `u_t` they are `slant` times those with `g_t`.
    by_g: [[R; 2]; 2],
    /// Derivatives of both with the length of the eccentricity \[N/m\].
    longer: [R; 2],
    /// dw/dε, with its own sign.
    weight_slope: R,
}

/// Symmetric parts of the slopes of film forces: xx along the eccentricity, yy across it, xy the mean of both mixed slopes.
#[derive(Clone, Copy)]
pub(crate) struct FilmSlopes<R> {
    /// Negative slopes with the velocity, -∂F/∂u \[N s/m\].
    pub(crate) damping: [R; 3],
    /// Negative slopes with the displacement, -∂F/∂e \[N/m\].
    pub(crate) stiffness: [R; 3],
    /// 1/√(g² + g₀²), one over the change of the velocity that changes the slopes \[s/m\].
    pub(crate) inverse_speed: R,
}

impl<R: Real> FilmLaw<R> {
    #[inline(always)]
    pub(crate) fn new(context: R::Context, film: &HingeFilm) -> Self {
        let splat = |value| R::splat(context, value);
        Self {
            inverse_clearance: splat(1.0 / film.clearance),
            pressure: splat(film.pressure),
            shear: splat(film.shear),
            over_band: splat(1.0 / (1.0 - film.handover)),
            speed: splat(film.speed),
        }
    }

    /// Return the film as [`HingeFilm::at`]; `there` is a factor, zero for hinges without a film and one for all others.
    #[inline(always)]
    pub(crate) fn at(&self, eccentricity: R, velocity: [R; 2], there: R) -> Filled<R> {
        let constant = |value| there.constant(value);
        let (zero, one, two) = (constant(0.0), constant(1.0), constant(2.0));
        let ratio = eccentricity * self.inverse_clearance;
        let left = one - ratio;
        let wet = left.greater(zero);
        let ratio = wet.select(ratio, zero);
        let part = left.positive_part() * self.over_band;
        let part = part.greater(one).select(one, part);
        let cube = part * part * part;
        let bend = constant(6.0).mul_add(part, constant(-15.0));
        let weight = there * (cube * bend.mul_add(part, constant(10.0)));
        // Equations of the module documentation: g, b, J and the force.
        let rest = (one - ratio) * (one + ratio);
        let over_root = one / rest.sqrt();
        let over_rest = over_root * over_root;
        let slant = two / ratio.mul_add(ratio, two);
        let g = [velocity[0], slant * velocity[1]];
        let squares = g[0].mul_add(g[0], g[1] * g[1]);
        let size = squares.sqrt();
        let reach = self.speed.mul_add(self.speed, squares).sqrt();
        let wetted = wet.select(there, zero);
        let inverse_reach = wetted / reach.max(constant(LEAST_REACH));
        let other = reach.greater(zero).select(self.speed / reach, zero);
        let lost = one - other;
        let over_size = size.greater(zero).select(one / size, zero);
        let direction = [g[0] * over_size, g[1] * over_size];
        let angle = arc_tangent(ratio * direction[0] * over_root);
        let twice_angle = angle + angle;
        let turn = lost.mul_add(twice_angle, constant(PI) * (one + other)) * over_root;
        let shape = [
            turn.mul_add(g[0], two * ratio * (lost * size)) * over_rest,
            turn * g[1],
        ];
        let most = self.pressure * weight;
        Filled {
            film: FilmForce {
                force: [-(most * shape[0]), -(most * shape[1])],
                shear: self.shear * weight * over_root,
            },
            state: State {
                ratio,
                part,
                weight,
                over_rest,
                slant,
                velocity,
                g,
                size,
                direction,
                other,
                inverse_reach,
                rest_of_turn: constant(PI) - twice_angle,
                over_root,
                turn,
                shape,
            },
        }
    }

    /// Return the derivatives of these forces in the frame of the eccentricity.
    ///
    /// That with g of the half film alone is `∫ (2 - ε cos θ)/(1 - ε cos θ)² n n^T dθ` over the half.
    #[inline(always)]
    fn gradient(&self, filled: &Filled<R>) -> Gradient<R> {
        let s = &filled.state;
        let constant = |value| s.ratio.constant(value);
        let (one, two) = (constant(1.0), constant(2.0));
        let [c, n] = s.direction;
        let [g, h] = s.g;
        let [fr, ft] = s.shape;
        let squared = s.ratio * s.ratio;
        let nn = n * n;
        let over_other = one / squared.negate_mul_add(nn, one);
        let lost = one - s.other;
        // Slopes of J with the direction of g, and with its magnitude through b, both times the magnitude.
        let by_direction = two * lost * s.ratio * over_other * n;
        let by_size = s.other * (lost * (one + s.other)) * s.rest_of_turn * s.over_root;
        let turn_along = by_direction.mul_add(n, -(by_size * c));
        let turn_across = -(by_direction.mul_add(c, by_size * n));
        let grown = two * s.ratio * lost * (one + s.other).mul_add(s.other, one);
        let xx = turn_along.mul_add(c, grown.mul_add(c, s.turn)) * s.over_rest;
        let xy = turn_across.mul_add(c, grown * n) * s.over_rest;
        let yx = turn_along * n;
        let yy = turn_across.mul_add(n, s.turn);
        // d(shape)/dε at constant u; g_t depends on ε through 2/(2 + ε²).
        let turn_slope = s.ratio.mul_add(s.turn, two * lost * c * over_other) * s.over_rest;
        let slower = -(s.ratio * s.slant * h);
        let along = (turn_slope.mul_add(g, two * lost * s.size) + two * s.ratio * fr)
            .mul_add(s.over_rest, xy * slower);
        let across = turn_slope.mul_add(h, yy * slower);
        let fall = constant(-30.0) * self.over_band * (s.part * s.part);
        let weight_slope = fall * (one - s.part) * (one - s.part);
        let softest = self.pressure * self.inverse_clearance;
        Gradient {
            most: self.pressure * s.weight,
            by_g: [[xx, xy], [yx, yy]],
            longer: [
                softest * weight_slope.mul_add(fr, s.weight * along),
                softest * weight_slope.mul_add(ft, s.weight * across),
            ],
            weight_slope,
        }
    }

    /// Return the negative slopes of these forces with the eccentricity and its velocity.
    ///
    /// The slope with the eccentricity has two parts: its length, and its direction, which is the frame of force and velocity.
    #[inline(always)]
    pub(crate) fn slopes(&self, filled: &Filled<R>) -> FilmSlopes<R> {
        let s = &filled.state;
        let Gradient {
            most, by_g, longer, ..
        } = self.gradient(filled);
        let [[xx, xy], [yx, yy]] = by_g;
        let ([fr, ft], [ur, ut]) = (s.shape, s.velocity);
        let half = s.ratio.constant(0.5);
        let damping = [
            most * xx,
            most * (s.slant * yy),
            most * (half * s.slant.mul_add(xy, yx)),
        ];
        // The length is bounded below by 0.05 c: near the centre the direction is undefined and the slopes with it cancel.
        let over_length = self.inverse_clearance / s.ratio.max(s.ratio.constant(0.05));
        let by_turn = most * over_length;
        let turned_along = by_turn * (xx.mul_add(ut, -(s.slant * xy * ur)) - ft);
        let turned_across = by_turn * (yx.mul_add(ut, -(s.slant * yy * ur)) + fr);
        FilmSlopes {
            damping,
            stiffness: [longer[0], turned_across, half * (longer[1] + turned_along)],
            inverse_speed: s.inverse_reach,
        }
    }
}

#[cfg(test)]
mod tests;

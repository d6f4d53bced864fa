//! Lubricant film of a clearance joint.
//!
//! The frame of the film rotates with the mean of both angular velocities. The film force depends on u = v - ½ ω × d. Here v and ω
//! are velocity and angular velocity of the pin relative to the bore's body, and d is the eccentricity. Force and reaction act
//! half-way between the two centres. About the pin's centre this is a torque -½ |d| `F_t` on the pin, in addition to the shear
//! torque -S ω. Chain drives have the same equations over vectors (`chain/rhs/chain/losses.rs`).

use nalgebra::Matrix2;

use super::compiled_contact::CompiledContact;
use super::impact_memory::SideState;
use crate::force_law::HingeFilm;
use crate::geometry::{Vec2, turned_left};
use crate::multibody::constraints::relative_kinematics::{PairForce, PairTorque};
use crate::multibody::description::body::Frame;
use crate::multibody::forces::loads::BodyLoads;

/// Ratio of eccentricity to clearance below which the direction is lost in rounding. Slopes below it are those at this ratio.
const LEAST_RATIO: f64 = 1e-7;

/// Kinematic state of a film.
struct Wet {
    /// Unit vectors along the eccentricity and left of it.
    axes: [Vec2; 2],
    /// |d| \[m\].
    eccentricity: f64,
    /// v along both axes \[m/s\].
    velocity: [f64; 2],
    /// ω \[rad/s\].
    spin: f64,
}

impl Wet {
    /// Return u along both axes \[m/s\].
    fn seen(&self) -> [f64; 2] {
        let [along, across] = self.velocity;
        [along, across - 0.5 * self.spin * self.eccentricity]
    }
}

impl CompiledContact {
    fn wet(&self, fa: &Frame, fb: &Frame) -> Wet {
        let d = fb.place(self.b.point) - fa.place(self.a.point);
        let eccentricity = d.norm();
        // The direction is arbitrary if pin and bore are concentric.
        let along = if eccentricity > 0.0 {
            d / eccentricity
        } else {
            Vec2::new(1.0, 0.0)
        };
        let axes = [along, turned_left(along)];
        let approach = self.approach(fa, fb);
        Wet {
            axes,
            eccentricity,
            velocity: axes.map(|axis| axis.dot(&approach)),
            spin: fb.spin - fa.spin,
        }
    }

    /// Add force, torque and dissipated power of the film.
    pub(crate) fn add_film(
        &self,
        film: &HingeFilm,
        frames: &[Frame],
        loads: &mut BodyLoads,
        side_state: &mut SideState,
    ) {
        let wet = self.wet(&frames[self.a.body], &frames[self.b.body]);
        let seen = wet.seen();
        let found = film.at(wet.eccentricity, seen);
        let [push, drag] = found.force;
        let force = push * wet.axes[0] + drag * wet.axes[1];
        let shear = found.shear * wet.spin;
        self.add_wrench(frames, force, -0.5 * wet.eccentricity * drag - shear, loads);
        side_state.friction += force;
        // Dissipated power: S ω² - F·u.
        loads.dissipated += shear * wet.spin - (push * seen[0] + drag * seen[1]);
    }

    /// Return force and torque of the film on the pin with their slopes.
    pub(crate) fn film_slopes(
        &self,
        film: &HingeFilm,
        frames: &[Frame],
    ) -> (PairForce, PairTorque) {
        let wet = self.wet(&frames[self.a.body], &frames[self.b.body]);
        let [x, y] = wet.axes;
        let length = wet.eccentricity.max(LEAST_RATIO * film.clearance);
        let (found, slopes) = film.slopes(wet.eccentricity, wet.seen());
        let [push, drag] = found.force;
        // Gradients of |d|, u_r and u_t with respect to the position of the pin.
        let [along, across] = wet.velocity;
        let turn = y / length;
        let by_place = [x, across * turn, -along * turn - 0.5 * wet.spin * x];
        let chain = |row: [f64; 3]| {
            let by_place: Vec2 = (0..3).map(|i| row[i] * by_place[i]).sum();
            let by_velocity = row[1] * x + row[2] * y;
            let by_spin = -0.5 * wet.eccentricity * row[2];
            (by_place, by_velocity, by_spin)
        };
        let [
            (push_place, push_velocity, push_spin),
            (drag_place, drag_velocity, drag_spin),
        ] = slopes.force.map(chain);
        // The axes rotate with the direction of d: F_r dx̂ + F_t dŷ = (F_r ŷ - F_t x̂) dθ, dθ = ŷ·dd/|d|.
        let turned: Matrix2<f64> = (push * y - drag * x) * turn.transpose();
        let half = 0.5 * wet.eccentricity;
        let force = PairForce {
            force: push * x + drag * y,
            by_place: x * push_place.transpose() + y * drag_place.transpose() + turned,
            by_velocity: x * push_velocity.transpose() + y * drag_velocity.transpose(),
        };
        let torque = PairTorque {
            force_by_spin: push_spin * x + drag_spin * y,
            by_place: -half * drag_place - (0.5 * drag + wet.spin * slopes.shear) * x,
            by_velocity: -half * drag_velocity,
            by_spin: -half * drag_spin - found.shear,
        };
        (force, torque)
    }
}

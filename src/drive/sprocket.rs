//! A sprocket and what drives it.

use std::f64::consts::PI;

use super::{AnsiTooth, Chain, TimeTable};
use crate::error::{Error, Result, check};
use crate::geometry::belt::Side;
use crate::geometry::{ToothProfile, Vec2};

/// Density of the disc whose mass a sprocket has when none is given \[kg/m³\].
const STEEL_DENSITY: f64 = 7850.0;

/// What a sprocket's rotation obeys. Counterclockwise is positive.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    /// Turns at this speed \[rad/s\], whatever it takes.
    PrescribedSpeed(TimeTable),
    /// Is turned by this torque \[N m\].
    AppliedTorque(TimeTable),
    /// Is turned by a torque of time \[N m\] and one that its own speed sets: a motor's or a load's curve, rows
    /// (speed \[rad/s\], torque \[N m\]).
    TorqueCurve {
        /// Against time.
        torque: TimeTable,
        /// Against the sprocket's speed.
        curve: TimeTable,
    },
    /// Turned by the chain alone.
    Free,
}

/// What holds a sprocket's centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bearing {
    /// A bearing at rest (a tensioner may move it).
    Fixed,
    /// Nothing.
    Floating,
}

/// A sprocket.
#[derive(Debug, Clone, PartialEq)]
pub struct Sprocket {
    /// Number of teeth.
    pub teeth: u32,
    /// Centre at the start \[m\].
    pub center: Vec2,
    /// What its rotation obeys.
    pub motion: Motion,
    /// Tooth form.
    pub profile: AnsiTooth,
    /// Mass \[kg\]; `None`: a steel disc.
    pub mass: Option<f64>,
    /// Moment of inertia \[kg m²\]; `None`: a steel disc.
    pub inertia: Option<f64>,
    /// Speed at the start \[rad/s\]; `None`: its prescribed speed, or as the chain turns it.
    pub initial_speed: Option<f64>,
    /// What holds its centre.
    pub bearing: Bearing,
    /// On which side of the chain it stands.
    pub side: Side,
    /// Moment of inertia of all that turns with it: shaft, load, motor \[kg m²\].
    pub load_inertia: f64,
}

impl Sprocket {
    /// Checks every field.
    ///
    /// # Errors
    /// Names the field, its value and what is allowed.
    pub fn validate(&self) -> Result<()> {
        if !(5..=1000).contains(&self.teeth) {
            return Err(Error::invalid(
                "Sprocket.teeth",
                self.teeth,
                "must be between 5 and 1000; the tooth form holds from 5 on",
            ));
        }
        for (name, value) in [("x", self.center.x), ("y", self.center.y)] {
            check::finite(&format!("Sprocket.center ({name})"), value, "m")?;
        }
        for (name, value, unit) in [
            ("mass", self.mass, "kg"),
            ("inertia", self.inertia, "kg m^2"),
        ] {
            if let Some(value) = value {
                check::positive(&format!("Sprocket.{name}"), value, unit)?;
            }
        }
        if let Some(speed) = self.initial_speed {
            check::finite("Sprocket.initial_speed", speed, "rad/s")?;
            if matches!(self.motion, Motion::PrescribedSpeed(_)) {
                return Err(Error::invalid(
                    "Sprocket.initial_speed",
                    speed,
                    "must be absent when the motion is a PrescribedSpeed, which has its own",
                ));
            }
        }
        check::not_negative("Sprocket.load_inertia", self.load_inertia, "kg m^2")?;
        self.profile.validate()
    }

    /// Checks that the teeth suit `chain`.
    ///
    /// # Errors
    /// Names the field, its value and what is allowed.
    pub fn check_against(&self, chain: &Chain) -> Result<()> {
        let bushing = 2.0 * chain.bushing_radius;
        let roller = self.profile.roller_diameter.unwrap_or(bushing);
        let seat = self.tooth_profile(chain).seating.radius;
        if seat <= chain.bushing_radius || roller >= chain.pitch {
            return Err(Error::invalid(
                "AnsiTooth.roller_diameter",
                roller,
                format!(
                    "must be below the pitch, {} m, and give a seat wider than the bushing of {bushing} m (this one's is \
                     {:.6} m): take {bushing} m",
                    chain.pitch,
                    2.0 * seat
                ),
            ));
        }
        Ok(())
    }

    /// The tooth profile for `chain`.
    #[must_use]
    pub fn tooth_profile(&self, chain: &Chain) -> ToothProfile {
        let roller = self
            .profile
            .roller_diameter
            .unwrap_or(2.0 * chain.bushing_radius);
        ToothProfile::ansi(chain.pitch, roller, self.teeth, self.profile.seat)
    }

    /// Mass \[kg\] and moment of inertia \[kg m²\]: as given, or those of a steel disc with the pitch circle's radius, as
    /// thick as the chain's contact with the tooth is long; what turns with it is added.
    #[must_use]
    pub fn mass_properties(&self, chain: &Chain) -> (f64, f64) {
        let radius = crate::geometry::wrap::pitch_radius(chain.pitch, self.teeth);
        let disc = STEEL_DENSITY * PI * radius * radius * chain.tooth_contact_length;
        let mass = self.mass.unwrap_or(disc);
        let own = self.inertia.unwrap_or(0.5 * mass * radius * radius);
        (mass, own + self.load_inertia)
    }
}

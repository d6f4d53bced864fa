//! A sprocket and its drive.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::material::STEEL_DENSITY;
use super::{Chain, ToothForm};
use crate::error::{Error, Result, check};
use crate::geometry::path::belt::Side;
use crate::geometry::path::wrap::pitch_radius;
use crate::geometry::{AnsiCurves, Damage, ToothProfile, Vec2, unit};
use crate::math::{Signal, Table};

/// Condition on a sprocket's rotation; counterclockwise is positive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum SprocketMotion {
    /// Prescribed angular velocity \[rad/s\].
    PrescribedSpeed(Signal),
    /// Applied torque \[N m\].
    AppliedTorque(Signal),
    /// Torque as a function of time plus a torque as a function of angular velocity (curve of a motor or load), rows
    /// (angular velocity \[rad/s\], torque \[N m\]).
    TorqueCurve {
        /// Torque over time.
        torque: Signal,
        /// Torque over angular velocity.
        curve: Table,
    },
    /// No torque but that of the chain.
    Free,
}

/// Support of a sprocket's centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Bearing {
    /// A fixed bearing; a tensioner may move it.
    Fixed,
    /// No support.
    Floating,
}

/// Defects of a sprocket's teeth.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Faults {
    /// Eccentricity of the teeth \[m\]: half the full radial runout.
    pub eccentricity: f64,
    /// Direction of the eccentricity from that of gap 0 \[rad\].
    pub eccentricity_angle: f64,
    /// Damaged teeth.
    pub damage: Vec<Damage>,
}

impl Faults {
    /// Return the centre of the teeth in the frame of the sprocket \[m\].
    #[must_use]
    pub fn offset(&self) -> Vec2 {
        self.eccentricity * unit(self.eccentricity_angle)
    }
}

/// A sprocket.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sprocket {
    /// Number of teeth.
    pub teeth: u32,
    /// Centre at the start \[m\].
    #[serde(with = "crate::geometry::components")]
    pub center: Vec2,
    /// Condition on its rotation.
    pub motion: SprocketMotion,
    /// Tooth form.
    pub profile: ToothForm,
    /// Mass \[kg\]; `None`: a steel disc.
    pub mass: Option<f64>,
    /// Moment of inertia \[kg m²\]; `None`: a steel disc.
    pub inertia: Option<f64>,
    /// Angular velocity at the start \[rad/s\]; `None`: the prescribed one, or the one that follows from the chain.
    pub initial_speed: Option<f64>,
    /// Support of its centre.
    pub bearing: Bearing,
    /// Side of the chain.
    pub side: Side,
    /// Additional moment of inertia of shaft, load and motor \[kg m²\].
    pub load_inertia: f64,
    /// Defects of its teeth.
    pub faults: Faults,
}

impl Sprocket {
    /// Check every field.
    ///
    /// # Errors
    /// When a field is out of range: names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        let [fewest, most] = self.profile.teeth();
        if !(fewest..=most).contains(&self.teeth) {
            return Err(Error::invalid(
                "Sprocket.teeth",
                self.teeth,
                format!(
                    "must be between {fewest} and {most}, the range of {}",
                    self.profile.name()
                ),
            ));
        }
        check::point("Sprocket.center", self.center)?;
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
            if matches!(self.motion, SprocketMotion::PrescribedSpeed(_)) {
                return Err(Error::invalid(
                    "Sprocket.initial_speed",
                    speed,
                    "must be absent when the motion is a PrescribedSpeed, which has its own",
                ));
            }
        }
        check::not_negative("Sprocket.load_inertia", self.load_inertia, "kg m^2")?;
        self.validate_faults()?;
        self.profile.validate()
    }

    fn validate_faults(&self) -> Result<()> {
        let faults = &self.faults;
        check::finite(
            "Sprocket.eccentricity_angle",
            faults.eccentricity_angle,
            "rad",
        )?;
        check::within("Sprocket.eccentricity", faults.eccentricity, 0.0, 1.0)?;
        for (i, damage) in faults.damage.iter().enumerate() {
            check::within("Sprocket.damaged_teeth", damage.height, 0.0, 1.0)?;
            let again = faults.damage[..i].iter().any(|d| d.tooth == damage.tooth);
            if damage.tooth >= self.teeth || again {
                return Err(Error::invalid(
                    "Sprocket.damaged_teeth",
                    damage.tooth,
                    format!("must name each tooth once, 0 to {}", self.teeth - 1),
                ));
            }
        }
        Ok(())
    }

    /// Check the teeth against `chain`.
    ///
    /// # Errors
    /// When a field is out of range: names the field, its value and the range.
    pub fn check_against(&self, chain: &Chain) -> Result<()> {
        let largest = 0.5 * chain.pitch;
        if self.faults.eccentricity >= largest {
            return Err(Error::invalid(
                "Sprocket.eccentricity",
                self.faults.eccentricity,
                format!("must be below half the pitch, {largest} m"),
            ));
        }
        if let ToothForm::Ansi(tooth) = &self.profile {
            let bushing = 2.0 * chain.contact_radius();
            let roller = tooth.roller_diameter.unwrap_or(bushing);
            let seat = AnsiCurves::new(roller, self.teeth).seating.radius;
            if seat <= chain.contact_radius() || roller >= chain.pitch {
                return Err(Error::invalid(
                    "AnsiTooth.roller_diameter",
                    roller,
                    format!(
                        "must be below the pitch, {} m, and give a seat wider than the bushing of {bushing} m (this one's \
                         is {:.6} m): take {bushing} m",
                        chain.pitch,
                        2.0 * seat
                    ),
                ));
            }
        }
        self.tooth_profile(chain).map(|_| ())
    }

    /// Return the tooth profile for `chain`.
    ///
    /// # Errors
    /// When the form gives no teeth for this chain.
    pub fn tooth_profile(&self, chain: &Chain) -> Result<ToothProfile> {
        let profile = self.profile.profile(chain, self.teeth)?;
        if self.faults.damage.is_empty() {
            return Ok(profile);
        }
        let edge = self.profile.edge_radius(chain);
        profile
            .with_damage(&self.faults.damage, edge)
            .ok_or_else(|| {
                Error::invalid(
                    "Sprocket.damaged_teeth",
                    format!("{} teeth", self.faults.damage.len()),
                    "too many different heights: at most about 40",
                )
            })
    }

    /// Return mass \[kg\] and moment of inertia \[kg m²\]: as given, or those of a steel disc with the pitch radius and the
    /// length of the contact as its thickness. The additional inertia is included.
    #[must_use]
    pub fn mass_properties(&self, chain: &Chain) -> (f64, f64) {
        let radius = pitch_radius(chain.pitch, self.teeth);
        let disc = STEEL_DENSITY * PI * radius * radius * chain.teeth_contact_length();
        let mass = self.mass.unwrap_or(disc);
        let own = self.inertia.unwrap_or(0.5 * mass * radius * radius);
        (mass, own + self.load_inertia)
    }
}

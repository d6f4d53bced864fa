//! Smooth guides of the chain: rails, blades on arms, idlers without teeth; the bushings slide on them.

use serde::{Deserialize, Serialize};

use super::Material;
use crate::error::{Error, Result, check};
use crate::geometry::{ToothProfile, Vec2, turned_left};

/// A guide.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Rail {
    /// Outline.
    pub shape: RailShape,
    /// Middle \[m\]; of a rail, half-way between its two faces.
    #[serde(with = "crate::geometry::components")]
    pub center: Vec2,
    /// Outward normal of the face in contact with the chain.
    #[serde(with = "crate::geometry::components")]
    pub direction: Vec2,
    /// Support.
    pub mount: Mount,
    /// Material; `None`: that of the chain. Its restitution is not used.
    pub material: Option<Material>,
    /// Height of the link plates about the hinges, where plates and not bushings are in contact \[m\].
    pub plate_height: Option<f64>,
}

/// Outline of a guide.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum RailShape {
    /// A bar with round ends and straight, convex or concave faces.
    Bar {
        /// Length \[m\].
        length: f64,
        /// Radius of the face \[m\], negative for a concave one; `None`: straight.
        radius: Option<f64>,
        /// Radius of the ends \[m\].
        end_radius: f64,
    },
    /// A wheel without teeth.
    Wheel {
        /// Radius \[m\].
        radius: f64,
    },
}

/// Support of a guide.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Mount {
    /// Fixed.
    Fixed,
    /// A bearing in the middle; the guide rotates freely.
    Turning {
        /// Moment of inertia \[kg m²\].
        inertia: f64,
    },
    /// An arm with a plunger, which presses on the rail's middle along the outward normal of its face.
    Arm(Arm),
}

/// A pivoted arm and its plunger: force, spring, dashpot and stops along the plunger's displacement.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Arm {
    /// Pivot \[m\].
    #[serde(with = "crate::geometry::components")]
    pub pivot: Vec2,
    /// Full force of the plunger at the described position \[N\].
    pub force: f64,
    /// Duration of the force's linear ramp \[s\].
    pub ramp_time: f64,
    /// Stiffness of the spring: decrease of the force with outward displacement \[N/m\].
    pub stiffness: f64,
    /// Damping coefficient \[N s/m\].
    pub damping: f64,
    /// Damping coefficient for backward motion of the arm \[N s/m\]; `None`: the same in both directions.
    pub damping_back: Option<f64>,
    /// Largest backward and outward displacement of the plunger \[m\]; infinite without a stop.
    pub travel: [f64; 2],
    /// Moment of inertia of arm and rail about the pivot \[kg m²\].
    pub inertia: f64,
    /// Pitch of a ratchet along the plunger's displacement \[m\], which permits outward motion only; 0: it locks anywhere.
    pub ratchet: Option<f64>,
}

impl Rail {
    /// Check every field.
    ///
    /// # Errors
    /// When a field is out of range: names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        let kind = self.kind();
        check::point(&format!("{kind}.center"), self.center)?;
        check::direction("GuideRail.direction", self.direction)?;
        if let Some(material) = &self.material {
            material.validate()?;
        }
        if let Some(height) = self.plate_height {
            check::positive(&format!("{kind}.plate_height"), height, "m")?;
        }
        match self.mount {
            Mount::Fixed => {}
            Mount::Turning { inertia } => {
                check::positive("SmoothIdler.inertia", inertia, "kg m^2")?;
            }
            Mount::Arm(arm) => {
                arm.validate()?;
                if self.lever(&arm).abs() < LEAST_LEVER * (self.center - arm.pivot).norm()
                    || self.center == arm.pivot
                {
                    return Err(Error::invalid(
                        "GuideArm.pivot",
                        format!("({}, {})", arm.pivot.x, arm.pivot.y),
                        "must lie beside the line through the rail's middle along its direction, on which the plunger presses",
                    ));
                }
            }
        }
        self.profile().map(|_| ())
    }

    /// Return the outline as a profile of two gaps.
    ///
    /// # Errors
    /// When the dimensions give no outline.
    pub fn profile(&self) -> Result<ToothProfile> {
        match self.shape {
            RailShape::Wheel { radius } => {
                check::positive("SmoothIdler.radius", radius, "m")?;
                Ok(ToothProfile::smooth_wheel(radius))
            }
            RailShape::Bar {
                length,
                radius,
                end_radius,
            } => {
                check::positive("GuideRail.length", length, "m")?;
                check::positive("GuideRail.end_radius", end_radius, "m")?;
                if end_radius >= 0.5 * length {
                    return Err(Error::invalid(
                        "GuideRail.end_radius",
                        end_radius,
                        format!(
                            "must be below half the length, {} m: take {} m",
                            0.5 * length,
                            0.05 * length
                        ),
                    ));
                }
                if let Some(radius) = radius {
                    check::finite("GuideRail.radius", radius, "m")?;
                }
                ToothProfile::bar(length, radius, end_radius).ok_or_else(|| {
                    Error::invalid(
                        "GuideRail.radius",
                        radius.unwrap_or(f64::INFINITY),
                        format!(
                            "must be above half the length, {} m, or, for a hollow face, below {} m: take {length} m or more, either \
                             way, or none for a straight face",
                            0.5 * length,
                            -0.5 * length
                        ),
                    )
                })
            }
        }
    }

    /// Return the rail for bushings: where plates are in contact, larger by the height of the plates beyond the bushings.
    #[must_use]
    pub fn for_bushings(&self, radius: f64) -> Self {
        let Some(height) = self.plate_height else {
            return *self;
        };
        let more = 0.5 * height - radius;
        let shape = match self.shape {
            RailShape::Wheel { radius } => RailShape::Wheel {
                radius: radius + more,
            },
            RailShape::Bar {
                length,
                radius,
                end_radius,
            } => RailShape::Bar {
                length: length + 2.0 * more,
                radius: radius.map(|radius| radius + more),
                end_radius: end_radius + more,
            },
        };
        Self { shape, ..*self }
    }

    /// Check the dimensions against the chain.
    ///
    /// # Errors
    /// When the plates are lower than the bushings, or too high for a hollow face.
    pub(crate) fn validate_for(&self, bushing_radius: f64) -> Result<()> {
        let Some(height) = self.plate_height else {
            return Ok(());
        };
        if height < 2.0 * bushing_radius {
            return Err(Error::invalid(
                format!("{}.plate_height", self.kind()),
                height,
                format!(
                    "must be the diameter of the bushings, {} m, or more: else they bear on the guide, not the plates",
                    2.0 * bushing_radius
                ),
            ));
        }
        let enlarged = self.for_bushings(bushing_radius).profile();
        if let RailShape::Bar {
            length,
            radius: Some(radius),
            ..
        } = self.shape
            && radius < 0.0
            && enlarged.is_err()
        {
            // Of the enlarged rail the radius is smaller by `more`, half the length larger: the limit of the described one.
            let more = 0.5 * height - bushing_radius;
            let limit = 0.5 * length + 2.0 * more;
            return Err(Error::invalid(
                "GuideRail.radius",
                radius,
                format!(
                    "must, for a hollow face with plate_height = {height} m, be below {:.6} m: take {:.6} m or less, or lower plates",
                    -limit,
                    -2.0 * limit
                ),
            ));
        }
        enlarged.map(|_| ())
    }

    /// Return the class that describes this guide.
    fn kind(&self) -> &'static str {
        match self.shape {
            RailShape::Bar { .. } => "GuideRail",
            RailShape::Wheel { .. } => "SmoothIdler",
        }
    }

    /// Return the depth of the middle of the outline below the line through the centres of its ends \[m\], for a concave
    /// bar.
    #[must_use]
    pub fn depth(&self) -> f64 {
        match self.shape {
            RailShape::Bar {
                length,
                radius: Some(radius),
                end_radius,
            } => ToothProfile::hollow_depth(length, radius, end_radius),
            _ => 0.0,
        }
    }

    /// Return the lever of the plunger's force about the pivot \[m\]; positive where the force turns the arm counterclockwise.
    #[must_use]
    pub fn lever(&self, arm: &Arm) -> f64 {
        turned_left(self.center - arm.pivot).dot(&self.direction.normalize())
    }

    /// Return the pivot, or the point where the guide is fixed \[m\].
    #[must_use]
    pub fn bearing(&self) -> Vec2 {
        match self.mount {
            Mount::Arm(arm) => arm.pivot,
            _ => self.center,
        }
    }

    /// Return the described angle of the face's normal \[rad\].
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.direction.y.atan2(self.direction.x)
    }

    /// Return the middle of the outline in the rotating frame at the bearing \[m\].
    #[must_use]
    pub fn offset(&self) -> Vec2 {
        let along = self.direction.normalize();
        let from_bearing = self.center - self.depth() * along - self.bearing();
        Vec2::new(
            from_bearing.dot(&along),
            from_bearing.dot(&turned_left(along)),
        )
    }
}

/// Smallest lever of a plunger, over the distance from the pivot.
const LEAST_LEVER: f64 = 0.05;

impl Arm {
    /// Check every field.
    ///
    /// # Errors
    /// When a field is out of range: names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        check::point("GuideArm.pivot", self.pivot)?;
        check::not_negative("GuideArm.force", self.force, "N")?;
        check::not_negative("GuideArm.ramp_time", self.ramp_time, "s")?;
        check::not_negative("GuideArm.stiffness", self.stiffness, "N/m")?;
        check::not_negative("GuideArm.damping", self.damping, "N s/m")?;
        if let Some(back) = self.damping_back {
            check::not_negative("GuideArm.damping_back", back, "N s/m")?;
        }
        check::positive("GuideArm.inertia", self.inertia, "kg m^2")?;
        if let Some(step) = self.ratchet {
            check::not_negative("GuideArm.ratchet", step, "m")?;
        }
        let [back, out] = self.travel;
        if !(back >= 0.0 && out >= 0.0 && back + out > 0.0) {
            return Err(Error::invalid(
                "GuideArm.travel",
                format!("({back}, {out})"),
                "must be the travel of the plunger back and out in m: two numbers, not negative and not both zero",
            ));
        }
        Ok(())
    }
}

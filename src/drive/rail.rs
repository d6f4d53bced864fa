//! Smooth guides of the chain: rails, blades on arms, idlers without teeth. The chain's bushings bear on them.

use super::Material;
use crate::error::{Error, Result, check};
use crate::geometry::{ToothProfile, Vec2, turned_left};

/// What a chain slides along.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rail {
    /// Its outline.
    pub shape: RailShape,
    /// Its middle \[m\]: of a rail, half-way between its two faces.
    pub center: Vec2,
    /// Out of the face on which the chain runs.
    pub direction: Vec2,
    /// What holds it.
    pub mount: Mount,
    /// What it is made of; `None`: what the chain is made of. Of its restitution nothing is used.
    pub material: Option<Material>,
    /// Height of the link plates where these bear on it, round the hinges, in place of the bushings \[m\].
    pub plate_height: Option<f64>,
}

/// The outline of a guide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RailShape {
    /// A bar with round ends, its two faces straight, arched or hollow.
    Bar {
        /// \[m\]
        length: f64,
        /// Of the arch \[m\], negative where it is hollow; `None`: straight.
        radius: Option<f64>,
        /// Of the ends \[m\].
        end_radius: f64,
    },
    /// A wheel without teeth.
    Wheel {
        /// \[m\]
        radius: f64,
    },
}

/// What holds a guide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mount {
    /// Nothing moves it.
    Fixed,
    /// A bearing in its middle, in which the chain's forces may turn it.
    Turning {
        /// Moment of inertia \[kg m²\].
        inertia: f64,
    },
    /// An arm that a plunger swings; it presses on the rail's middle, out of its face.
    Arm(Arm),
}

/// An arm, and the plunger that swings it: force, spring, dashpot and stops along the plunger's way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arm {
    /// Where it turns \[m\].
    pub pivot: Vec2,
    /// Full force of the plunger where the arm is described \[N\].
    pub force: f64,
    /// Time in which it grows \[s\].
    pub ramp_time: f64,
    /// What the force loses as the plunger moves out \[N/m\].
    pub stiffness: f64,
    /// Dashpot \[N s/m\].
    pub damping: f64,
    /// Dashpot against an arm that gives way \[N s/m\]; `None`: the same both ways.
    pub damping_back: Option<f64>,
    /// How far the plunger can go back and out \[m\]; infinite without a stop.
    pub travel: [f64; 2],
    /// Moment of inertia of arm and rail about the pivot \[kg m²\].
    pub inertia: f64,
    /// Distance of the teeth of a ratchet along the plunger's way \[m\], which lets it move out only; 0: it holds anywhere.
    pub ratchet: Option<f64>,
}

impl Rail {
    /// Checks every field.
    ///
    /// # Errors
    /// Names the field, its value and what is allowed.
    pub fn validate(&self) -> Result<()> {
        let kind = match self.shape {
            RailShape::Bar { .. } => "GuideRail",
            RailShape::Wheel { .. } => "SmoothIdler",
        };
        check::finite(&format!("{kind}.center (x)"), self.center.x, "m")?;
        check::finite(&format!("{kind}.center (y)"), self.center.y, "m")?;
        let along = self.direction.norm();
        if !(along.is_finite() && along > 0.0) {
            return Err(Error::invalid(
                "GuideRail.direction",
                format!("({}, {})", self.direction.x, self.direction.y),
                "must be a direction: two finite numbers, not both zero",
            ));
        }
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

    /// Its outline as a profile of two gaps.
    ///
    /// # Errors
    /// When there is no such outline.
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

    /// The same rail as the chain's bushings feel it: where plates bear on it, as much larger as they reach beyond the bushings.
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

    /// Checks what depends on the chain.
    ///
    /// # Errors
    /// When its plates are lower than the bushings.
    pub(crate) fn validate_for(&self, bushing_radius: f64) -> Result<()> {
        match self.plate_height {
            Some(height) if height < 2.0 * bushing_radius => Err(Error::invalid(
                "GuideRail.plate_height",
                height,
                format!(
                    "must be the diameter of the bushings, {} m, or more: else they bear on the rail, not the plates",
                    2.0 * bushing_radius
                ),
            )),
            _ => self.for_bushings(bushing_radius).profile().map(|_| ()),
        }
    }

    /// How far the middle of its outline lies below the line through the centres of its ends \[m\]: a hollow bar is as deep as it
    /// needs to be.
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

    /// Arm of the plunger's force about the pivot \[m\]: positive where pressing turns the arm counterclockwise.
    #[must_use]
    pub fn lever(&self, arm: &Arm) -> f64 {
        turned_left(self.center - arm.pivot).dot(&self.direction.normalize())
    }

    /// Where it turns or is fixed \[m\].
    #[must_use]
    pub fn bearing(&self) -> Vec2 {
        match self.mount {
            Mount::Arm(arm) => arm.pivot,
            _ => self.center,
        }
    }

    /// Angle of the face's direction where it is described \[rad\].
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.direction.y.atan2(self.direction.x)
    }

    /// The middle of its outline in a frame at its bearing that turns with it \[m\].
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

/// Least lever of a plunger, over the distance of the pivot.
const LEAST_LEVER: f64 = 0.05;

impl Arm {
    /// Checks every field.
    ///
    /// # Errors
    /// Names the field, its value and what is allowed.
    pub fn validate(&self) -> Result<()> {
        check::finite("GuideArm.pivot (x)", self.pivot.x, "m")?;
        check::finite("GuideArm.pivot (y)", self.pivot.y, "m")?;
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
                "must be how far the plunger can go back and out in m: two numbers, not negative and not both zero",
            ));
        }
        Ok(())
    }
}

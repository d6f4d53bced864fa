//! Tooth forms of a description.

mod teeth;

use serde::{Deserialize, Serialize};

use super::Chain;
use crate::error::{Result, check};
use crate::geometry::{OutlinePiece, Seat};

/// Default radius of the edge of a tooth tip, over the roller diameter.
const EDGE_SHARE: f64 = 0.025;
/// Smallest and largest number of teeth of a form whose standard names none: the layout is generated and tested for these.
pub const TEETH: [u32; 2] = [5, 1000];

/// Tooth form.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum ToothForm {
    /// ANSI/ASME B29.1.
    Ansi(AnsiTooth),
    /// ISO 606.
    Iso(IsoTooth),
    /// Straight flanks.
    Straight(StraightTooth),
    /// Arcs and lines of a custom outline.
    Custom(CustomTooth),
}

impl From<AnsiTooth> for ToothForm {
    fn from(tooth: AnsiTooth) -> Self {
        Self::Ansi(tooth)
    }
}

/// Shape of the tooth tip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Tip {
    /// The flanks continue to the middle of the tooth.
    Full,
    /// The tooth ends at the outside diameter with a rounded edge.
    Cut,
}

/// Tooth form of ANSI/ASME B29.1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AnsiTooth {
    /// Position of the seating curve's centre.
    pub seat: Seat,
    /// Roller diameter Dr of the form \[m\]; `None`: the chain's bushing diameter.
    pub roller_diameter: Option<f64>,
    /// Shape of the tip.
    pub tip: Tip,
    /// Radius of the edge of a cut tip \[m\]; `None`: 0.025 Dr.
    pub edge_radius: Option<f64>,
}

impl Default for AnsiTooth {
    fn default() -> Self {
        Self {
            seat: Seat::BottomDiameter,
            roller_diameter: None,
            tip: Tip::Full,
            edge_radius: None,
        }
    }
}

/// Tooth form of ISO 606.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct IsoTooth {
    /// Tooth gap form, from the standard's minimum (0) to its maximum (1).
    pub gap: f64,
    /// Position of the seating curve's centre.
    pub seat: Seat,
    /// Roller diameter d1 of the form \[m\]; `None`: the chain's bushing diameter.
    pub roller_diameter: Option<f64>,
    /// Tip diameter \[m\]; `None`: the middle of the standard's range, or its minimum where the middle gives a pointed tooth.
    pub tip_diameter: Option<f64>,
    /// Radius of the edge at the tip \[m\]; `None`: 0.025 d1.
    pub edge_radius: Option<f64>,
}

/// Tooth form with a circular seat and straight flanks.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StraightTooth {
    /// Angle between flank and middle of the tooth gap \[rad\].
    pub flank_angle: f64,
    /// Radius of the seat \[m\]; `None`: 0.505 roller diameters.
    pub seat_radius: Option<f64>,
    /// Position of the seat's centre.
    pub seat: Seat,
    /// Roller diameter of the form \[m\]; `None`: the chain's bushing diameter.
    pub roller_diameter: Option<f64>,
    /// Tip diameter \[m\]; `None`: as for an ISO tooth.
    pub tip_diameter: Option<f64>,
    /// Radius of the edge at the tip \[m\]; `None`: 0.025 roller diameters.
    pub edge_radius: Option<f64>,
}

/// Tooth form of arcs and lines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CustomTooth {
    /// Pieces from the middle of the tooth gap outward along the right flank.
    pub pieces: Vec<OutlinePiece>,
    /// Outside diameter \[m\]; `None`: the pieces continue to the middle of the tooth.
    pub tip_diameter: Option<f64>,
    /// Radius of the edge of a cut tip \[m\]; `None`: 0.025 bushing diameters.
    pub edge_radius: Option<f64>,
}

fn check_lengths(form: &str, lengths: &[(&str, Option<f64>)]) -> Result<()> {
    lengths.iter().try_for_each(|(name, length)| {
        length.map_or(Ok(()), |length| {
            check::positive(&format!("{form}.{name}"), length, "m")
        })
    })
}

impl ToothForm {
    /// Return the name of the form's class.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Ansi(_) => "AnsiTooth",
            Self::Iso(_) => "IsoTooth",
            Self::Straight(_) => "StraightTooth",
            Self::Custom(_) => "CustomTooth",
        }
    }

    /// Return the smallest and the largest number of teeth of the form.
    #[must_use]
    pub fn teeth(&self) -> [u32; 2] {
        match self {
            Self::Iso(_) => [9, 150],
            _ => TEETH,
        }
    }

    /// Check every field.
    ///
    /// # Errors
    /// When a field is out of range: names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        let form = self.name();
        match self {
            Self::Ansi(tooth) => check_lengths(
                form,
                &[
                    ("roller_diameter", tooth.roller_diameter),
                    ("edge_radius", tooth.edge_radius),
                ],
            ),
            Self::Iso(tooth) => {
                check::within("IsoTooth.gap", tooth.gap, 0.0, 1.0)?;
                check_lengths(
                    form,
                    &[
                        ("roller_diameter", tooth.roller_diameter),
                        ("tip_diameter", tooth.tip_diameter),
                        ("edge_radius", tooth.edge_radius),
                    ],
                )
            }
            Self::Straight(tooth) => {
                check::within("StraightTooth.flank_angle", tooth.flank_angle, 0.0, 1.2)?;
                check_lengths(
                    form,
                    &[
                        ("seat_radius", tooth.seat_radius),
                        ("roller_diameter", tooth.roller_diameter),
                        ("tip_diameter", tooth.tip_diameter),
                        ("edge_radius", tooth.edge_radius),
                    ],
                )
            }
            Self::Custom(tooth) => {
                for (i, piece) in tooth.pieces.iter().enumerate() {
                    let points = [Some(piece.start), Some(piece.end), piece.center];
                    for point in points.into_iter().flatten() {
                        let name = format!("CustomTooth.pieces.{}", i + 1);
                        check::finite(&name, point.x, "m")?;
                        check::finite(&name, point.y, "m")?;
                    }
                }
                check_lengths(
                    form,
                    &[
                        ("tip_diameter", tooth.tip_diameter),
                        ("edge_radius", tooth.edge_radius),
                    ],
                )
            }
        }
    }

    /// Return the roller diameter \[m\] of the form.
    fn roller_diameter(&self, chain: &Chain) -> f64 {
        let given = match self {
            Self::Ansi(tooth) => tooth.roller_diameter,
            Self::Iso(tooth) => tooth.roller_diameter,
            Self::Straight(tooth) => tooth.roller_diameter,
            Self::Custom(_) => None,
        };
        given.unwrap_or(2.0 * chain.contact_radius())
    }

    /// Return the radius of the tip's edge \[m\].
    pub(super) fn edge_radius(&self, chain: &Chain) -> f64 {
        let given = match self {
            Self::Ansi(tooth) => tooth.edge_radius,
            Self::Iso(tooth) => tooth.edge_radius,
            Self::Straight(tooth) => tooth.edge_radius,
            Self::Custom(tooth) => tooth.edge_radius,
        };
        given.unwrap_or(EDGE_SHARE * self.roller_diameter(chain))
    }
}

//! Tooth profiles of the described forms, and the errors of those that are impossible.

use super::{CustomTooth, Tip, ToothForm};
use crate::drive::Chain;
use crate::error::{Error, Result};
use crate::geometry::path::wrap;
use crate::geometry::{
    Blank, IsoGap, Misfit, SEAT_OVER_ROLLER, Seat, SurfaceCurve, ToothProfile, iso_tip_diameters,
};

/// Smallest room of a bushing in a concave arc, over its radius. The distance from an arc is a quotient with this room, and is good for
/// penetrations that are small beside it. ISO 606 and ASME B29.1 have 0.01 and 0.005.
const SEAT_ROOM: f64 = 1e-4;

impl ToothForm {
    /// Return the profile of undamaged teeth for `chain`.
    ///
    /// # Errors
    /// When the flanks meet below the tip, pieces do not fit together, or a bushing cannot roll along the tooth gap.
    pub(in crate::drive) fn profile(&self, chain: &Chain, teeth: u32) -> Result<ToothProfile> {
        let roller = self.roller_diameter(chain);
        let edge = self.edge_radius(chain);
        let profile = match self {
            Self::Ansi(tooth) => {
                let full = ToothProfile::ansi(chain.pitch, roller, teeth, tooth.seat);
                if tooth.tip == Tip::Full {
                    return Ok(full);
                }
                let outside = full.outside_radius;
                full.cut(outside, edge).map_err(|meets| {
                    let expected = format!(
                        "the tooth's flanks meet at a diameter of {:.6} m, and its tip is to be at {:.6} m: take \
                         tip=\"full\" or a smaller edge_radius",
                        2.0 * meets,
                        2.0 * outside
                    );
                    Error::invalid("AnsiTooth.tip", "\"cut\"", expected)
                })?
            }
            Self::Iso(tooth) => {
                let gap = IsoGap::new(roller, teeth, tooth.gap);
                let form = |blank: &Blank| ToothProfile::iso(blank, &gap);
                self.cut_off(chain, teeth, tooth.seat, tooth.tip_diameter, &form)?
            }
            Self::Straight(tooth) => {
                let seat = tooth.seat_radius.unwrap_or(SEAT_OVER_ROLLER * roller);
                let form = |blank: &Blank| ToothProfile::straight(blank, seat, tooth.flank_angle);
                self.cut_off(chain, teeth, tooth.seat, tooth.tip_diameter, &form)?
            }
            Self::Custom(tooth) => {
                let tip = tooth.tip_diameter.map(|diameter| (0.5 * diameter, edge));
                ToothProfile::custom(chain.pitch, teeth, &tooth.pieces, tip)
                    .map_err(|misfit| misfit_error(misfit, tooth))?
            }
        };
        let radius = chain.contact_radius();
        let refuse = |number: usize, why: String| {
            let name = profile.surfaces()[number].name;
            Err(Error::invalid(
                self.name(),
                format!("{name}, number {} of the flank", number + 1),
                why,
            ))
        };
        if let Some((surface, depth)) = profile.pinch(radius) {
            return refuse(
                surface.index(),
                format!(
                    "a bushing of radius {radius} m that touches it would be {depth:.3e} m inside another surface: must leave room \
                     for the bushing"
                ),
            );
        }
        let least = (1.0 + SEAT_ROOM) * radius;
        let is_tight = |curve: &SurfaceCurve| matches!(curve, SurfaceCurve::Concave(arc) if arc.radius < least);
        if let Some(number) = profile
            .surfaces()
            .iter()
            .position(|piece| is_tight(&piece.curve))
        {
            return refuse(
                number,
                format!(
                    "its radius must be at least {least:.5e} m, for a bushing of radius {radius} m"
                ),
            );
        }
        Ok(profile)
    }

    /// Return a tooth of this `form` with the given tip diameter; by default the middle of the standard's range, or its
    /// minimum where the middle gives a pointed tooth.
    fn cut_off(
        &self,
        chain: &Chain,
        teeth: u32,
        seat: Seat,
        tip_diameter: Option<f64>,
        form: &dyn Fn(&Blank) -> std::result::Result<ToothProfile, f64>,
    ) -> Result<ToothProfile> {
        let [least, most] = iso_tip_diameters(chain.pitch, self.roller_diameter(chain), teeth);
        let is_given = tip_diameter.is_some();
        let with_tip = |tip: f64| {
            let blank = self.blank(chain, teeth, seat, tip, is_given)?;
            form(&blank).map_err(|meets| self.pointed(&blank, meets, is_given))
        };
        match tip_diameter {
            Some(tip) => with_tip(tip),
            None => with_tip(0.5 * (least + most)).or_else(|_| with_tip(least)),
        }
    }

    /// Return the dimensions of a tooth with the tip diameter `tip` \[m\], which is given or that of the standard.
    fn blank(
        &self,
        chain: &Chain,
        teeth: u32,
        seat: Seat,
        tip: f64,
        is_given: bool,
    ) -> Result<Blank> {
        let roller_diameter = self.roller_diameter(chain);
        let [least, most] = iso_tip_diameters(chain.pitch, roller_diameter, teeth);
        let pitch_diameter = 2.0 * wrap::pitch_radius(chain.pitch, teeth);
        let given_seat = match self {
            Self::Straight(tooth) => tooth.seat_radius,
            _ => None,
        };
        if let Some(seat_radius) = given_seat
            && seat_radius <= chain.contact_radius()
        {
            return Err(Error::invalid(
                format!("{}.seat_radius", self.name()),
                seat_radius,
                format!(
                    "must give a seat wider than the bushing: be above {} m, its radius",
                    chain.contact_radius()
                ),
            ));
        }
        let seat_radius = given_seat.unwrap_or(SEAT_OVER_ROLLER * roller_diameter);
        if roller_diameter >= chain.pitch || seat_radius <= chain.contact_radius() {
            return Err(Error::invalid(
                format!("{}.roller_diameter", self.name()),
                roller_diameter,
                format!(
                    "must be below the pitch, {} m, and give a seat wider than the bushing of {} m (this one's is {:.6} m)",
                    chain.pitch,
                    2.0 * chain.contact_radius(),
                    2.0 * seat_radius
                ),
            ));
        }
        if tip <= pitch_diameter && !is_given {
            return Err(Error::invalid(
                format!("{}.roller_diameter", self.name()),
                roller_diameter,
                format!(
                    "leaves no tooth: the smallest tip diameter of ISO 606 is then {tip:.6} m, not above the pitch diameter, \
                     {pitch_diameter:.6} m; must be below {:.6} m, or give a tip_diameter",
                    roller_diameter + least - pitch_diameter
                ),
            ));
        }
        if tip <= pitch_diameter || tip > pitch_diameter + 2.0 * chain.pitch {
            return Err(Error::invalid(
                format!("{}.tip_diameter", self.name()),
                tip,
                format!(
                    "must be above the pitch diameter, {pitch_diameter:.6} m, by at most two pitches; ISO 606 has {least:.6} m \
                     to {most:.6} m"
                ),
            ));
        }
        Ok(Blank {
            pitch: chain.pitch,
            roller_diameter,
            teeth,
            seat,
            outside_radius: 0.5 * tip,
            edge_radius: self.edge_radius(chain),
        })
    }

    fn pointed(&self, blank: &Blank, meets: f64, is_given: bool) -> Error {
        let tip = 2.0 * blank.outside_radius;
        let (value, at) = if is_given {
            (tip.to_string(), String::new())
        } else {
            let at = format!(" even at the smallest tip diameter of ISO 606, {tip:.6} m");
            ("None".to_string(), at)
        };
        Error::invalid(
            format!("{}.tip_diameter", self.name()),
            value,
            format!(
                "the tooth is pointed{at}: its flanks meet at a diameter of {:.6} m; must be less than that by what the edge \
                 of radius {} m takes, or the gap narrower",
                2.0 * meets,
                blank.edge_radius
            ),
        )
    }
}

fn misfit_error(misfit: Misfit, tooth: &CustomTooth) -> Error {
    let piece = |number: usize| format!("CustomTooth.pieces.{number}");
    let joint = |number: usize| format!("joint of CustomTooth.pieces.{} and .{number}", number - 1);
    let whole = "CustomTooth.pieces".to_string();
    let shown = |length: f64| format!("{length:.3e} m");
    let degrees = |angle: f64| format!("{:.4} degrees", angle.to_degrees());
    let (field, value, expected) = match misfit {
        Misfit::Nothing => (whole, "()".to_string(), "needs at least one piece".to_string()),
        Misfit::NoCurve(number, first, last) => (
            piece(number),
            format!("{first} m and {last} m from centre to ends"),
            "must have two ends, those of an arc equally far from its centre to 1e-7 m".to_string(),
        ),
        Misfit::Apart(number, gap) => (
            joint(number),
            format!("a gap of {}", shown(gap)),
            "must begin where the piece before ends, to 1e-7 m".to_string(),
        ),
        Misfit::Corner(number, angle) => (
            joint(number),
            format!("a turn of {}", degrees(angle)),
            "must be tangent to 0.0057 degrees (1e-4 rad): put an arc between them".to_string(),
        ),
        Misfit::Beside(distance) => (
            piece(1),
            format!("begins at u = {}", shown(distance)),
            "must begin in the middle of the gap, at u = 0 to 1e-7 m".to_string(),
        ),
        Misfit::Leans(angle) => (
            piece(1),
            format!("begins at {} from level", degrees(angle)),
            "must be level where it meets its mirror image, to 0.0057 degrees (1e-4 rad)".to_string(),
        ),
        Misfit::Open(distance) => (
            piece(tooth.pieces.len()),
            format!("ends {} from the middle of the tooth", shown(distance)),
            "must end there, to 1e-7 m, where no tip_diameter is given".to_string(),
        ),
        Misfit::Point(angle) => (
            piece(tooth.pieces.len()),
            format!("ends at {} from level", degrees(angle)),
            "the tooth is pointed: must be level in the middle of the tooth, to 0.0057 degrees, where no tip_diameter is \
             given"
                .to_string(),
        ),
        Misfit::Pointed(radius) => (
            "CustomTooth.tip_diameter".to_string(),
            tooth
                .tip_diameter
                .map_or_else(String::new, |diameter| format!("{diameter} m")),
            format!(
                "the circle meets the flank nowhere, or the tooth is pointed there: the flanks meet at a diameter of \
                 {:.6} m",
                2.0 * radius
            ),
        ),
    };
    Error::invalid(field, value, expected)
}

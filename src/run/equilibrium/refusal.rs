//! Reasons why a drive has no static equilibrium, or why none was found, in words.

use crate::drive::{ChainEnd, Drive, Sprocket, SprocketMotion};
use crate::layout::{Layout, USUAL_SAG};

/// Smallest ratio of a strand's tension to its weight for an equilibrium near the initial configuration: the strand then sags by a quarter
/// of its span. A smaller tension moves the tensioner far back, which takes 10,000 iterations and more.
const LEAST_TENSION: f64 = 0.5;

/// Return the causes shown by the drive itself; otherwise the remaining possible causes.
pub(super) fn causes(drive: &Drive, layout: &Layout) -> String {
    let shown = [
        low_tension(drive, layout),
        light_strand(drive, layout),
        loose_torque(drive),
        loose_chain(drive),
    ];
    let shown: Vec<String> = shown.into_iter().flatten().collect();
    if !shown.is_empty() {
        return shown.join("; ");
    }
    let begin = "begin nearer to rest, with fewer links";
    if drive.tensioner.is_some() {
        format!(
            "nothing stops the tensioner, or it has so much slack to take up that the chain skips teeth: {begin}, or with the \
             tensioner's sprocket where it will stand"
        )
    } else {
        format!("the initial configuration is far from static equilibrium: {begin}")
    }
}

/// Return a description of a pretension below the weight of the strands, if it is too low.
fn low_tension(drive: &Drive, layout: &Layout) -> Option<String> {
    let (tensioner, chain) = (drive.tensioner.as_ref()?, &drive.chain);
    let longest = f64::from(*layout.strand_pitches.iter().max()?);
    let links = chain.links as usize;
    let mass: f64 = (0..links).map(|i| chain.strand_link(i).mass).sum();
    let weight = drive.gravity.norm() * mass * longest / f64::from(chain.links);
    let tension = tensioner.pretension;
    (tension < LEAST_TENSION * weight).then(|| {
        format!(
            "the longest strand weighs {weight:.1} N and would sag by more than a quarter of its span under a \
             Tensioner.pretension of {tension:.1} N; expected at least {:.0} N, for a sag of 6 % {:.0} N: raise the pretension",
            LEAST_TENSION * weight,
            weight / (8.0 * USUAL_SAG)
        )
    })
}

/// Return whether any sprocket has a prescribed speed.
fn has_prescribed_speed(drive: &Drive) -> bool {
    let mut motions = drive.sprockets.iter().map(|sprocket| &sprocket.motion);
    motions.any(|motion| matches!(motion, SprocketMotion::PrescribedSpeed(_)))
}

/// Return a description of an open chain that runs off over its sprockets, if nothing holds it.
fn loose_chain(drive: &Drive) -> Option<String> {
    let ends = drive.ends.as_ref()?;
    let anchored = (ends.iter()).any(|end| matches!(end, ChainEnd::Anchored { .. }));
    (!anchored && !has_prescribed_speed(drive)).then(|| {
        "nothing holds the chain: both ends can move, and no sprocket has a prescribed speed; prescribe the speed of a sprocket \
         (PrescribedSpeed(0.0) holds it), or anchor an end"
            .to_string()
    })
}

/// Return a description of a torque in a drive without a prescribed speed, if there is one.
fn loose_torque(drive: &Drive) -> Option<String> {
    let mut motions = drive.sprockets.iter().map(|sprocket| &sprocket.motion);
    let turned = motions.position(|motion| match motion {
        SprocketMotion::AppliedTorque(torque) => torque.value(0.0) != 0.0,
        SprocketMotion::TorqueCurve { .. } => true,
        _ => false,
    })?;
    (drive.ends.is_none() && !has_prescribed_speed(drive)).then(|| {
        format!(
            "nothing holds the torque on sprocket {}: no sprocket has a prescribed speed",
            turned + 1
        )
    })
}

/// Return the ratio of tensions that frictionless bushings transmit from one tooth to the next. The tensions of both links and the force of
/// a tooth at its pressure angle \[rad\] are in balance. `teeth` is the number of teeth of the sprocket.
fn passed_on(pressure_angle: f64, teeth: u32) -> f64 {
    let turn = std::f64::consts::TAU / f64::from(teeth);
    pressure_angle.sin() / (pressure_angle + turn).sin()
}

/// Return a description of an open chain whose light strand cannot hold its load on the teeth, if it is too light. The pressure angle 35° -
/// 120°/N is that of a new chain of ANSI B29.1; other forms have similar angles.
fn light_strand(drive: &Drive, layout: &Layout) -> Option<String> {
    let (ends, chain) = (drive.ends.as_ref()?, &drive.chain);
    // Without sprockets there are no teeth.
    drive.sprockets.first()?;
    let (first, last) = (
        *layout.strand_pitches.first()?,
        *layout.strand_pitches.last()?,
    );
    let links = chain.links as usize;
    let weight = |end: usize| {
        let strand = if end == 0 {
            0..first as usize
        } else {
            links - last as usize..links
        };
        let own: f64 = strand.map(|i| chain.strand_link(i).mass).sum();
        let load = match ends[end] {
            ChainEnd::Loaded { mass, .. } => mass,
            _ => 0.0,
        };
        drive.gravity.norm() * (own + load)
    };
    let share = |(sprocket, &seated): (&Sprocket, &u32)| {
        let angle = (35.0 - 120.0 / f64::from(sprocket.teeth)).to_radians();
        passed_on(angle, sprocket.teeth).powi(i32::try_from(seated).unwrap_or(i32::MAX))
    };
    let wraps = drive.sprockets.iter().zip(&layout.seated);
    let shares: f64 = wraps.map(share).product();
    let (light, heavy) = if weight(0) < weight(1) {
        (0, 1)
    } else {
        (1, 0)
    };
    let needed = shares * weight(heavy);
    let or_a_load = match ends[light] {
        ChainEnd::Anchored { .. } => "",
        _ => " or a load",
    };
    (weight(light) < needed).then(|| {
        format!(
            "the strand at end {} weighs {:.2} N, and without friction the teeth take the {:.1} N at end {} only where about {needed:.2} N \
             hold the chain down there: hang more links{} at end {}",
            light + 1,
            weight(light),
            weight(heavy),
            heavy + 1,
            or_a_load,
            light + 1
        )
    })
}

/// Return a description of an open chain that slides over held teeth until a strand is taut, if it does.
pub(super) fn slid(
    drive: &Drive,
    layout: &Layout,
    laid: &[[f64; 3]],
    rest: &[[f64; 3]],
) -> Option<String> {
    let held = |sprocket: &Sprocket| matches!(sprocket.motion, SprocketMotion::PrescribedSpeed(_));
    if drive.tensioner.is_some() || !drive.sprockets.iter().all(held) {
        return None;
    }
    let light = light_strand(drive, layout)?;
    // The link in the middle of the first wrap.
    let link = *layout.strand_pitches.first()? as usize + *layout.seated.first()? as usize / 2;
    let ([x, y, _], [to_x, to_y, _]) = (laid.get(link)?, rest.get(link)?);
    let pitches = (to_x - x).hypot(to_y - y) / drive.chain.pitch;
    (pitches > 0.5)
        .then(|| format!("the chain slides over its teeth before it comes to rest; {light}"))
}

#[cfg(test)]
mod tests {
    use super::{causes, passed_on};
    use crate::chain::contact::tests::drive;
    use crate::drive::{Chain, ChainEnd, Drive};
    use crate::geometry::Vec2;
    use crate::layout::InitialConfiguration;

    #[test]
    fn a_chain_without_sprockets_has_no_cause_on_teeth() {
        let closed = drive();
        let drive = Drive {
            chain: Chain {
                links: 6,
                ..closed.chain
            },
            sprockets: Vec::new(),
            ends: Some([
                ChainEnd::anchored(Vec2::zeros()),
                ChainEnd::loaded(5.0, 1e-3),
            ]),
            ..closed
        };
        let (_, layout) = InitialConfiguration::generate(&drive).unwrap();
        let said = causes(&drive, &layout);
        assert!(said.contains("far from static equilibrium"), "{said}");
    }

    #[test]
    fn a_tooth_of_seventeen_passes_on_three_fifths_of_a_tension() {
        let angle = (35.0_f64 - 120.0 / 17.0).to_radians();
        assert!((passed_on(angle, 17) - 0.62).abs() < 1e-3);
        // For a tooth force perpendicular to the mean of both strands, the tensions are equal.
        let half = std::f64::consts::PI / 17.0;
        assert!((passed_on(std::f64::consts::FRAC_PI_2 - half, 17) - 1.0).abs() < 1e-12);
    }
}

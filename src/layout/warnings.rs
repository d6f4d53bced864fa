//! Warnings about a layout.

use super::report::{Layout, USUAL_SAG, given_speed};
use super::tightness::{Tightness, tightness};
use crate::drive::{Bearing, Drive, HingeKind, Sprocket, SprocketMotion};
use crate::geometry::path::wrap;

/// Least usual wrap of a sprocket \[degrees\], less rounding: a third of its teeth is not below.
const LEAST_WRAP: f64 = 120.0 - 1e-9;
/// Difference of the chain speeds of two sprockets, over the larger one, above which a warning is given.
const SPEED_MISMATCH: f64 = 0.01;
/// Least chain speed to which a difference is compared, over the largest one: at a change of direction both speeds are small.
const LEAST_COMPARED: f64 = 0.1;
/// Rows and ends of ramps at which prescribed speeds are compared.
const MOST_KNOTS: usize = 10_000;
/// Quarters of periods at which prescribed speeds by sines are compared.
const MOST_QUARTERS: u32 = 1000;

/// Return the reason why the drive's tensioner does not reach its tension, if any.
fn tensioner_warning(drive: &Drive) -> Option<String> {
    let tensioner = drive.tensioner.as_ref()?;
    let line = tensioner.line(drive).ok()?;
    let way = match line.taut_at {
        None => "anywhere on its way".to_string(),
        Some(s) if s > tensioner.travel[1] => format!(
            "before its stop: it would move by {:.3} mm and can by {:.3} mm",
            1e3 * s,
            1e3 * tensioner.travel[1]
        ),
        Some(_) => return None,
    };
    Some(format!(
        "the tensioner does not take up the chain's slack {way}"
    ))
}

/// Shortage that is told of an ideal chain \[m\]: as far as bushings begin off their seats.
const LEAST_SHORTAGE: f64 = 1e-6;

/// Ideal hinges that leave the chain too short somewhere on its way round. A tensioner or a floating sprocket gives way; so does a chain
/// with clearance in its hinges.
fn tightness_warning(drive: &Drive) -> Option<String> {
    let fixed = |sprocket: &Sprocket| sprocket.bearing == Bearing::Fixed;
    let stiff = drive.hinge_kind == HingeKind::Ideal
        && drive.ends.is_none()
        && drive.tensioner.is_none()
        && drive.sprockets.iter().all(fixed);
    if !stiff {
        return None;
    }
    let Tightness { shortage, tension } = tightness(drive).ok()?;
    (shortage >= LEAST_SHORTAGE).then(|| {
        format!(
            "ideal hinges do not open: where the polygon effect tightens it most, the chain is {:.1} um too short for these \
             centres, and its tension is about {tension:.0} N, more at speed; move a centre in \
             until the strands have so much more length, or take a tensioner, hinges='clearance', or sprockets with room in \
             their seats (AnsiTooth(seat='pitch-circle'))",
            1e6 * shortage
        )
    })
}

/// Largest displacement of a tensioner on a spring under load, in pitches, at which the chain counts as seated. Half a pitch is about the
/// height of a tooth; in runs of 17:25 teeth the chain jumps at 1.4 pitches.
const GIVES_WAY: f64 = 0.5;

/// Return the warning about a load with which the chain jumps teeth: it needs a larger difference of strand tensions than the
/// tensioner keeps as their sum.
fn overload_warning(drive: &Drive, layout: &Layout) -> Option<String> {
    let tensioner = drive.tensioner.as_ref().filter(|_| drive.ends.is_none())?;
    // A ratchet or a stop holds the centre at any load.
    if tensioner.ratchet.is_some() || tensioner.travel[0].is_finite() {
        return None;
    }
    // With more sprockets, strands away from the tensioner may be tight.
    let loaded = match drive.sprockets.len() {
        2 => 0..2,
        _ => tensioner.sprocket - 1..tensioner.sprocket,
    };
    let pulls = largest_pulls(drive, layout);
    let (i, needed) = loaded
        .map(|i| (i, pulls[i]))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    let torque = needed * pitch_radius(drive, i);
    let sum = 2.0 * tensioner.pretension + GIVES_WAY * drive.chain.pitch * tensioner.stiffness;
    (needed > sum).then(|| {
        format!(
            "the load of {torque:.4} N m on sprocket {} needs {needed:.1} N more in one strand than in the other, and the tensioner \
             maintains a sum of {sum:.1} N: the chain will jump teeth; at a pretension of {:.1} N the slack strand has no tension: take \
             clearly more, or a stop (travel=(0.0, ...))",
            i + 1,
            tensioner.pretension + 0.5 * (needed - sum)
        )
    })
}

/// Displacement of a tensioner against its force during its ramp, in pitches, from which on a warning is given. In runs of 19:57 teeth with
/// friction of 0.1 the chain jumps at 0.43 pitches, and not at 0.29; without friction it jumps at 0.60, and not at 0.53.
const PUSHED_BACK: f64 = 0.35;
/// Steps of the integration of that displacement over the ramp. A heavy shaft may move on for as long again.
const RAMP_STEPS: u32 = 1000;

/// Return the warning about a load that acts while the force of the tensioner still grows: it pushes the sprocket back until the chain jumps.
///
/// The tensioner is on one of two sprockets, the load on the one without a prescribed speed. The strand tensions push the centre with the
/// share of the load that the tensioner's full force has of its strand tensions. The loaded shaft turns as the tight strand yields: its inertia
/// moves with the centre.
fn ramp_warning(drive: &Drive, layout: &Layout) -> Option<String> {
    let tensioner = drive.tensioner.as_ref()?;
    let held = tensioner.ratchet.is_some() || tensioner.travel[0].is_finite();
    if held || tensioner.ramp_time <= 0.0 || tensioner.pretension <= 0.0 {
        return None;
    }
    if !tensioner.separates_two_sprockets(drive) {
        return None;
    }
    let driven = |i: &usize| {
        matches!(
            drive.sprockets[*i].motion,
            SprocketMotion::PrescribedSpeed(_)
        )
    };
    let loaded = 1 - (0..2).find(driven)?;
    let torque = |t: f64| match &drive.sprockets[loaded].motion {
        SprocketMotion::AppliedTorque(torque) => torque.value(t),
        SprocketMotion::TorqueCurve { torque, curve } => {
            torque.value(t) + curve.value(layout.speeds[loaded])
        }
        SprocketMotion::PrescribedSpeed(_) | SprocketMotion::Free => 0.0,
    };
    let line = tensioner.line(drive).ok()?;
    let stiffness = tensioner.stiffness;
    let of_strands = line.pull - stiffness * line.taut_at.unwrap_or(0.0);
    let share = of_strands / (2.0 * tensioner.pretension) / pitch_radius(drive, loaded);
    let properties = |i: usize| drive.sprockets[i].mass_properties(&drive.chain);
    let mass = properties(tensioner.sprocket - 1).0 + share.powi(2) * properties(loaded).1;
    let damping = tensioner.damping_back.unwrap_or(tensioner.damping);
    let step = tensioner.ramp_time / f64::from(RAMP_STEPS);
    let (mut displacement, mut velocity, mut largest) = (0.0_f64, 0.0_f64, 0.0_f64);
    for i in 1..=2 * RAMP_STEPS {
        if i > RAMP_STEPS && velocity <= 0.0 {
            break;
        }
        let t = f64::from(i) * step;
        let pull = line.pull * (t / tensioner.ramp_time).min(1.0);
        let push = share * torque(t).abs() - pull;
        // Backward Euler: stable for a stiff spring.
        let push = push - stiffness * displacement;
        velocity = (mass * velocity + step * push) / (mass + step * (damping + step * stiffness));
        displacement += step * velocity;
        if displacement < 0.0 {
            (displacement, velocity) = (0.0, 0.0);
        }
        largest = largest.max(displacement);
    }
    (largest > PUSHED_BACK * drive.chain.pitch).then(|| {
        format!(
            "the load on sprocket {} acts while the tensioner force still grows, over {:.4} s, and pushes sprocket {} back by about \
             {:.1} mm: the chain may jump teeth; begin with start='static', or take a shorter ramp_time, more damping or a stop \
             (travel=(0.0, ...))",
            loaded + 1,
            tensioner.ramp_time,
            tensioner.sprocket,
            1e3 * largest
        )
    })
}

fn pitch_radius(drive: &Drive, sprocket: usize) -> f64 {
    wrap::pitch_radius(drive.chain.pitch, drive.sprockets[sprocket].teeth)
}

/// Return the largest force of the chain on each sprocket, along the chain \[N\]; zero where its speed is prescribed.
///
/// With a prescribed speed in the drive it is torque over pitch radius: mean speeds are taken as constant. So are they with a torque that
/// depends on the speed, which the drive reaches. Without both, torques accelerate the masses m of shafts and chain together by a, and it
/// is torque over pitch radius less m a of its own shaft.
fn largest_pulls(drive: &Drive, layout: &Layout) -> Vec<f64> {
    let count = drive.sprockets.len();
    let sign = |i: usize| layout.sides[i].sign();
    // Speed of the chain, in teeth times angular velocity.
    let chain_speeds = (0..count).find_map(|i| match &drive.sprockets[i].motion {
        SprocketMotion::PrescribedSpeed(speed) => {
            let teeth = sign(i) * f64::from(drive.sprockets[i].teeth);
            Some(speed.range().map(|speed| teeth * speed))
        }
        _ => None,
    });
    let pulls: Vec<[f64; 2]> = (0..count)
        .map(|i| {
            let sprocket = &drive.sprockets[i];
            let follows = |speed: f64| sign(i) * speed / f64::from(sprocket.teeth);
            let [mut least, mut most] = [layout.speeds[i]; 2];
            for speed in chain_speeds.into_iter().flatten().map(follows) {
                (least, most) = (least.min(speed), most.max(speed));
            }
            let torques = torque_range(&sprocket.motion, [least, most]);
            let [a, b] = torques.map(|torque| sign(i) * torque / pitch_radius(drive, i));
            [a.min(b), a.max(b)]
        })
        .collect();
    let mut shares = vec![0.0; count];
    let mut motions = drive.sprockets.iter().map(|sprocket| &sprocket.motion);
    let settles = motions.any(|motion| matches!(motion, SprocketMotion::TorqueCurve { .. }));
    if chain_speeds.is_none() && !settles {
        let links = 0..drive.chain.links as usize;
        let chain: f64 = links.map(|i| drive.chain.link(i).mass).sum();
        for (i, share) in shares.iter_mut().enumerate() {
            let (_, inertia) = drive.sprockets[i].mass_properties(&drive.chain);
            *share = inertia / pitch_radius(drive, i).powi(2);
        }
        let all = chain + shares.iter().sum::<f64>();
        for share in &mut shares {
            *share /= all;
        }
    }
    let total = |which: usize| pulls.iter().map(|pull| pull[which]).sum::<f64>();
    let (least, most) = (total(0), total(1));
    (pulls.iter().zip(&shares))
        .map(|([low, high], share)| {
            // The other torques are at their other limit.
            let lowest = (1.0 - share) * low - share * (most - high);
            let highest = (1.0 - share) * high - share * (least - low);
            lowest.abs().max(highest.abs())
        })
        .collect()
}

/// Return the least and the largest torque on a sprocket between these angular velocities \[N m\]; zeros without torque.
fn torque_range(motion: &SprocketMotion, [slowest, fastest]: [f64; 2]) -> [f64; 2] {
    match motion {
        SprocketMotion::AppliedTorque(torque) => torque.range(),
        SprocketMotion::TorqueCurve { torque, curve } => {
            let rows = curve.rows().into_iter();
            let between = rows.filter(|(speed, _)| (slowest..=fastest).contains(speed));
            let ends = [slowest, fastest].map(|speed| curve.value(speed));
            let torques = between.map(|(_, torque)| torque).chain(ends);
            let start = [f64::INFINITY, f64::NEG_INFINITY];
            let [least, most] = torques.fold(start, |[least, most], torque| {
                [least.min(torque), most.max(torque)]
            });
            let [lowest, highest] = torque.range();
            [lowest + least, highest + most]
        }
        SprocketMotion::PrescribedSpeed(_) | SprocketMotion::Free => [0.0; 2],
    }
}

/// Number of pitches in mesh below which a warning is given.
const FEW_IN_MESH: u32 = 3;

impl Layout {
    /// Return the warnings about these choices.
    pub(super) fn warn(&mut self, drive: &Drive) {
        let mut warnings = Vec::new();
        // The ends determine the sag of an open chain.
        let closed = if drive.ends.is_none() {
            self.strands.len()
        } else {
            0
        };
        for i in 0..closed {
            let share = self.sag[i] / self.spans[i];
            if share > USUAL_SAG {
                warnings.push(format!(
                    "the {} strand sags by {:.1} % of its span; 4 to 6 % is usual",
                    self.strand_name(i),
                    100.0 * share
                ));
            }
        }
        for (i, sprocket) in drive.sprockets.iter().enumerate() {
            let gap = std::f64::consts::TAU / f64::from(sprocket.teeth);
            let wrap = (f64::from(self.seated[i]) * gap).to_degrees();
            // Idlers transmit no power: few teeth are sufficient.
            if drive.sprockets.len() == 2 || !matches!(sprocket.motion, SprocketMotion::Free) {
                if wrap < LEAST_WRAP {
                    warnings.push(format!(
                        "sprocket {} is wrapped by {wrap:.0} degrees only; 120 is usual",
                        i + 1
                    ));
                }
            } else if self.seated[i] < FEW_IN_MESH {
                let plural = if self.seated[i] == 1 { "" } else { "es" };
                warnings.push(format!(
                    "sprocket {} has {} pitch{plural} in mesh; {FEW_IN_MESH} are usual for an idler",
                    i + 1,
                    self.seated[i]
                ));
            }
        }
        self.warn_of_speeds(drive, &mut warnings);
        warnings.extend(tensioner_warning(drive));
        let overload = overload_warning(drive, self);
        warnings.extend(overload.or_else(|| ramp_warning(drive, self)));
        warnings.extend(tightness_warning(drive));
        self.warnings = warnings;
    }

    /// Return a warning where the prescribed speeds of two sprockets agree at the start, and not later. They are compared at rows and ends
    /// of ramps, and three times between. Speeds without these are compared at quarters of the shortest period. Beside a
    /// table they are not: it holds its last value after its last row, where a run may have ended.
    fn later_mismatch(&self, drive: &Drive, [i, k]: [usize; 2]) -> Option<String> {
        let speed = |i: usize| match &drive.sprockets[i].motion {
            SprocketMotion::PrescribedSpeed(speed) => Some(speed),
            _ => None,
        };
        let (one, two) = (speed(i)?, speed(k)?);
        let scale = [i, k].map(|i| self.sides[i].sign() * f64::from(drive.sprockets[i].teeth));
        let largest =
            [(scale[0], one), (scale[1], two)].map(|(scale, of)| scale.abs() * of.largest());
        let least = LEAST_COMPARED * largest[0].max(largest[1]);
        let differ = |t: f64| {
            let speeds = [scale[0] * one.value(t), scale[1] * two.value(t)];
            let larger = speeds[0].abs().max(speeds[1].abs()).max(least);
            (speeds[0] - speeds[1]).abs() > SPEED_MISMATCH * larger
        };
        if differ(0.0) {
            return None;
        }
        let next =
            |t: &f64| Some(one.next_knot(*t).min(two.next_knot(*t))).filter(|t| t.is_finite());
        let knots = std::iter::successors(next(&0.0), next).take(MOST_KNOTS);
        let quarter = match next(&0.0) {
            None => (one.longest_step_between_knots(0.0)).min(two.longest_step_between_knots(0.0)),
            Some(_) => f64::INFINITY,
        };
        let quarters = (1..=MOST_QUARTERS).map(|i| f64::from(i) * quarter);
        let ends = knots.chain(quarters.take_while(|t| t.is_finite()));
        let times = ends.scan(0.0, |before, end| {
            let since = std::mem::replace(before, end);
            Some([0.25, 0.5, 0.75, 1.0].map(|part| since + part * (end - since)))
        });
        let at = times.flatten().find(|&t| differ(t))?;
        Some(format!(
            "sprockets {} and {} have {:.4} and {:.4} rad/s at {} s, which move the chain at different speeds",
            i + 1,
            k + 1,
            one.value(at),
            two.value(at),
            (1e9 * at).round() / 1e9
        ))
    }

    fn warn_of_speeds(&self, drive: &Drive, warnings: &mut Vec<String>) {
        let mut prescribed = (0..drive.sprockets.len()).filter(|&i| {
            matches!(
                drive.sprockets[i].motion,
                SprocketMotion::PrescribedSpeed(_)
            )
        });
        if let Some(first) = prescribed.next() {
            warnings.extend(prescribed.filter_map(|i| self.later_mismatch(drive, [first, i])));
        }
        // Given speeds must agree; the others follow.
        let given: Vec<usize> = (0..drive.sprockets.len())
            .filter(|&i| given_speed(drive, i).is_some())
            .collect();
        let chain_speed =
            |i: usize| self.sides[i].sign() * self.speeds[i] * f64::from(drive.sprockets[i].teeth);
        if let [first, others @ ..] = given.as_slice() {
            for other in others {
                let (one, two) = (chain_speed(*first), chain_speed(*other));
                if (one - two).abs() > SPEED_MISMATCH * one.abs().max(two.abs()) {
                    warnings.push(format!(
                        "sprockets {} and {} start at {:.4} and {:.4} rad/s, which move the chain at different speeds",
                        first + 1,
                        other + 1,
                        self.speeds[*first],
                        self.speeds[*other]
                    ));
                }
            }
        }
    }
}

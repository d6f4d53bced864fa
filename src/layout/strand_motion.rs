//! Initial velocities of sprockets and hinges of a drive of many sprockets: the links keep their lengths.
//!
//! One given angular velocity determines all others by the numbers of teeth: the mean values, from which the polygon action deviates
//! by a little. Given angular velocities are not changed.

use super::many_sprockets::ClosedLayout;
use super::report::given_speed;
use crate::drive::{BeltLine, Drive};
use crate::geometry::{Vec2, turned_left};

/// Regularisation ε: permitted elongation rate of slack links over the change of their hinges' velocities. Without it a nearly straight
/// strand gets large transverse velocities.
const GIVE: f64 = 1e-4;

/// Return the angular velocities of the sprockets in the described order \[rad/s\], and the velocities of all hinges \[m/s\].
pub(super) fn of(drive: &Drive, line: &BeltLine, found: &ClosedLayout) -> (Vec<f64>, Vec<Vec2>) {
    let polygon = &found.polygon;
    let n = line.order.len();
    let speeds = wheel_speeds(drive, line);
    let center = |place: usize| found.course.wheels[place].center;
    let turned =
        |k: usize, place: usize| speeds[place] * turned_left(polygon.hinges[k] - center(place));
    let mut velocities = linear_between_seats(&polygon.seat_of, turned);
    let first = (polygon.seat_of.iter()).position(|&seat| seat == Some(found.slack));
    let from = first.unwrap_or(0) + polygon.seated[found.slack] as usize;
    let count = polygon.strands[found.slack] as usize;
    if count > 1 {
        keep_lengths_from(from, count, &polygon.hinges, &mut velocities);
    }
    let mut listed = vec![0.0; n];
    for (place, &i) in line.order.iter().enumerate() {
        listed[i] = speeds[place];
    }
    (listed, velocities)
}

/// Return the first hinge of each strand and its number of links: from the last seat on one wheel to the first on the next.
fn strands(seat_of: &[Option<usize>]) -> impl Iterator<Item = (usize, usize)> {
    let n = seat_of.len();
    let seated = move |k: usize| seat_of[k % n].is_some();
    let ends = (0..n).filter(move |&k| seated(k) && !seated(k + 1));
    ends.map(move |from| (from, (1..=n).find(|&k| seated(from + k)).unwrap_or(n)))
}

/// Return the velocities of all hinges: those of seated hinges by `turned` (hinge, wheel), of others linear between the seats.
pub(super) fn linear_between_seats(
    seat_of: &[Option<usize>],
    turned: impl Fn(usize, usize) -> Vec2,
) -> Vec<Vec2> {
    let n = seat_of.len();
    let seated =
        |(k, seat): (usize, &Option<usize>)| seat.map_or(Vec2::zeros(), |at| turned(k, at));
    let mut velocities: Vec<Vec2> = seat_of.iter().enumerate().map(seated).collect();
    for (from, count) in strands(seat_of) {
        let ends = [velocities[from], velocities[(from + count) % n]];
        for k in 1..count {
            let share = k as f64 / count as f64;
            velocities[(from + k) % n] = ends[0] + share * (ends[1] - ends[0]);
        }
    }
    velocities
}

/// Change the velocities of all hinges that are not seated so that the links keep their lengths.
pub(super) fn keep_all_lengths(
    seat_of: &[Option<usize>],
    hinges: &[Vec2],
    velocities: &mut [Vec2],
) {
    for (from, count) in strands(seat_of) {
        keep_lengths_from(from, count, hinges, velocities);
    }
}

/// Change the velocities of the hinges between both ends of `count` links from hinge `from` on so that these keep their lengths.
pub(super) fn keep_lengths_from(
    from: usize,
    count: usize,
    hinges: &[Vec2],
    velocities: &mut [Vec2],
) {
    let at = |k: usize| (from + k) % hinges.len();
    let links: Vec<Vec2> = (0..count)
        .map(|k| (hinges[at(k + 1)] - hinges[at(k)]).normalize())
        .collect();
    let lengthening = (0..count)
        .map(|k| links[k].dot(&(velocities[at(k + 1)] - velocities[at(k)])))
        .collect();
    for (k, change) in keep_lengths(&links, lengthening).iter().enumerate() {
        velocities[at(k + 1)] += change;
    }
}

/// Return the angular velocities of the wheels in the chain's order \[rad/s\].
fn wheel_speeds(drive: &Drive, line: &BeltLine) -> Vec<f64> {
    let turn = |i: usize| {
        let sprocket = &drive.sprockets[i];
        sprocket.side.sign() / f64::from(sprocket.teeth)
    };
    let first = (0..drive.sprockets.len())
        .find_map(|i| given_speed(drive, i).map(|speed| speed / turn(i)))
        .unwrap_or(0.0);
    let speed = |&i: &usize| given_speed(drive, i).unwrap_or_else(|| first * turn(i));
    line.order.iter().map(speed).collect()
}

/// Return the smallest changes of the inner hinges' velocities for links along these directions with these elongation rates, so that they
/// keep their lengths except for [`GIVE`].
///
/// With A the matrix of elongation rates by velocities, the changes are -Aᵀ λ with (A Aᵀ + ε) λ = rates: one row per link, tridiagonal.
fn keep_lengths(links: &[Vec2], lengthening: Vec<f64>) -> Vec<Vec2> {
    let n = links.len();
    let ends = |k: usize| if k == 0 || k == n - 1 { 1.0 } else { 2.0 };
    let beside = |k: usize| -links[k].dot(&links[k + 1]);
    let mut diagonal: Vec<f64> = (0..n).map(|k| ends(k) + GIVE).collect();
    let mut lambda = lengthening;
    for k in 1..n {
        let factor = beside(k - 1) / diagonal[k - 1];
        diagonal[k] -= factor * beside(k - 1);
        lambda[k] -= factor * lambda[k - 1];
    }
    for k in (0..n).rev() {
        if k + 1 < n {
            lambda[k] -= beside(k) * lambda[k + 1];
        }
        lambda[k] /= diagonal[k];
    }
    (0..n - 1)
        .map(|k| lambda[k + 1] * links[k + 1] - lambda[k] * links[k])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::unit;

    #[test]
    fn a_bow_whose_ends_part_keeps_its_links_lengths() {
        let links: Vec<Vec2> = (0..12).map(|k| unit(-0.6 + 0.1 * f64::from(k))).collect();
        // Linear from end to end: every link lengthens by its share.
        let lengthening: Vec<f64> = links.iter().map(|along| 0.01 * along.x).collect();
        let changes = keep_lengths(&links, lengthening.clone());
        for (k, link) in links.iter().enumerate() {
            let before = if k == 0 {
                Vec2::zeros()
            } else {
                changes[k - 1]
            };
            let after = changes.get(k).copied().unwrap_or_default();
            let rate = lengthening[k] + link.dot(&(after - before));
            assert!(rate.abs() < 0.05 * 0.01, "{rate}");
        }
    }
}

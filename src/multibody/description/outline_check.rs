//! Checks of an outline: a path without gaps that does not cross itself, does not reverse on itself and encloses an area.

use super::outline_piece::Piece;
use crate::error::{Error, Result};
use crate::geometry::{Vec2, distance_from_segment};

/// Number of chords that replace a quarter turn of an arc in the search for crossings.
const CHORDS: f64 = 8.0;

/// Distance over the length of a piece below which two points are the same.
const SAME_POINT: f64 = 1e-9;

/// Check that each piece begins at the end of the previous one, that the path is simple and that a closed one encloses an area.
pub(crate) fn check_path(field: &str, pieces: &[Piece], closed: bool) -> Result<()> {
    let next = pieces.iter().enumerate().skip(1);
    let next = next.chain(pieces.iter().enumerate().take(usize::from(closed)));
    for (piece, (number, after)) in pieces.iter().zip(next) {
        let size = (piece.to - piece.from)
            .norm()
            .max((after.to - after.from).norm());
        let gap = (after.from - piece.to).norm();
        if gap > SAME_POINT * size {
            return Err(Error::invalid(
                format!("piece {} of {field}", number + 1),
                format!("a beginning {gap:.3e} m away from where the piece before ends"),
                "must begin there",
            ));
        }
    }
    let chords = chords(pieces);
    check_turns(field, &chords, closed)?;
    let crossing = first_pair(&chords, closed, |[a, b], [c, d]| cross(a, b, c, d));
    refuse(
        field,
        crossing,
        "cross each other: give the points in the order in which the outline passes through them",
    )?;
    check_area(field, &chords, closed)?;
    let touching = first_pair(&chords, closed, |first, second| {
        distance(first, second) <= SAME_POINT * length(first).max(length(second))
    });
    refuse(
        field,
        touching,
        "touch each other: move one of them aside, or make two outlines of it",
    )
}

/// Return the length of a chord \[m\].
fn length([from, to]: [Vec2; 2]) -> f64 {
    (to - from).norm()
}

/// Return the pieces of the first two chords that are no neighbours and `meet`.
fn first_pair(
    chords: &[(usize, [Vec2; 2])],
    closed: bool,
    meet: impl Fn([Vec2; 2], [Vec2; 2]) -> bool,
) -> Option<[usize; 2]> {
    for (i, &(first, before)) in chords.iter().enumerate() {
        for (j, &(second, after)) in chords.iter().enumerate().skip(i + 2) {
            // An open path may end where it begins.
            let size = length(before).max(length(after));
            let ends_meet = closed || (after[1] - before[0]).norm() <= SAME_POINT * size;
            let neighbours = i == 0 && j == chords.len() - 1 && ends_meet;
            if !neighbours && meet(before, after) {
                return Some([first, second]);
            }
        }
    }
    None
}

/// Return an error on two pieces with a `fault`, where there are any.
fn refuse(field: &str, pieces: Option<[usize; 2]>, fault: &str) -> Result<()> {
    let Some([first, second]) = pieces else {
        return Ok(());
    };
    let numbers = format!("{} and {}", first + 1, second + 1);
    Err(Error::invalid(format!("pieces of {field}"), numbers, fault))
}

/// Angle \[rad\] between two chords below which they count as parallel; also the least area of a closed path over its squared length.
const ALONG: f64 = 1e-9;

/// Check that no piece reverses along the previous one, which would be a spike without width.
fn check_turns(field: &str, chords: &[(usize, [Vec2; 2])], closed: bool) -> Result<()> {
    let next = chords.iter().cycle().skip(1);
    let pairs = chords.len() - usize::from(!closed);
    for ((first, [a, b]), (second, [_, c])) in chords.iter().zip(next).take(pairs) {
        let (on, back) = (b - a, c - b);
        if on.dot(&back) < 0.0 && on.perp(&back).abs() <= ALONG * on.norm() * back.norm() {
            return Err(Error::invalid(
                format!("pieces of {field}"),
                format!("{} and {}", first + 1, second + 1),
                format!(
                    "go to ({}, {}) and back the same way, a spike of no width: leave the point out, or give the \
                     spike two sides",
                    b.x, b.y
                ),
            ));
        }
    }
    Ok(())
}

/// Check that a closed path encloses an area.
fn check_area(field: &str, chords: &[(usize, [Vec2; 2])], closed: bool) -> Result<()> {
    // Shoelace formula relative to the first point, which avoids cancellation far from the origin.
    let start = chords[0].1[0];
    let twice = |[a, b]: &[Vec2; 2]| (a - start).perp(&(b - start));
    let area = 0.5 * chords.iter().map(|(_, chord)| twice(chord)).sum::<f64>();
    let length: f64 = chords.iter().map(|(_, [a, b])| (b - a).norm()).sum();
    if closed && area.abs() <= ALONG * length * length {
        return Err(Error::invalid(
            format!("points of {field}"),
            format!("an area of {area:.3e} m^2 within a length of {length:.3e} m"),
            "enclose nothing: a closed outline needs points on three sides of its material; closed=False makes a line",
        ));
    }
    Ok(())
}

/// Return chords along the path, each with the number of its piece.
fn chords(pieces: &[Piece]) -> Vec<(usize, [Vec2; 2])> {
    let mut found = Vec::new();
    for (number, piece) in pieces.iter().enumerate() {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most 32
        let count = (piece.span() / std::f64::consts::FRAC_PI_2 * CHORDS)
            .ceil()
            .max(1.0) as usize;
        let parts = piece.split(count);
        found.extend(parts.iter().map(|part| (number, [part.from, part.to])));
    }
    found
}

/// Return whether two line segments cross: the ends of each are on opposite sides of the other.
fn cross(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> bool {
    let side = |p: Vec2, q: Vec2, r: Vec2| (q - p).perp(&(r - p));
    let (to_c, to_d) = (side(a, b, c), side(a, b, d));
    let (to_a, to_b) = (side(c, d, a), side(c, d, b));
    to_c * to_d < 0.0 && to_a * to_b < 0.0
}

/// Return the distance of two line segments that do not cross: that of an end of one of them from the other.
fn distance(first: [Vec2; 2], second: [Vec2; 2]) -> f64 {
    let ends_of_first = first.map(|point| distance_from_segment(point, second));
    let ends_of_second = second.map(|point| distance_from_segment(point, first));
    let ends = ends_of_first.into_iter().chain(ends_of_second);
    ends.fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::multibody::Profile;

    #[test]
    fn a_way_that_crosses_itself_or_has_gaps_is_refused() {
        let points = |rows: &[(f64, f64)]| {
            rows.iter()
                .map(|&(x, y)| Vec2::new(x, y))
                .collect::<Vec<_>>()
        };
        let bow_tie = points(&[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)]);
        let error = Profile::polyline("bow", &bow_tie, true)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("1 and 3") && error.contains("cross each other"),
            "{error}"
        );
        let square = points(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        assert!(Profile::polyline("square", &square, true).is_ok());
        let Ok(Profile::Outline { mut pieces, .. }) = Profile::polyline("square", &square, true)
        else {
            panic!("no outline");
        };
        pieces[2].from.x += 0.1;
        let error = check_path("square", &pieces, true).unwrap_err().to_string();
        assert!(
            error.contains("piece 3 of square") && error.contains("1.000e-1 m away"),
            "{error}"
        );
    }

    fn told(points: &[(f64, f64)], closed: bool) -> String {
        let points: Vec<Vec2> = points.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
        let made = Profile::polyline("cam", &points, closed);
        made.map_or_else(|error| error.to_string(), |_| String::new())
    }

    #[test]
    fn a_spike_of_no_width_is_refused_with_its_point() {
        let spike = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (2.0, 1.0), (1.0, 1.0)];
        let error = told(&[&spike[..], &[(0.0, 1.0)]].concat(), true);
        assert!(
            error.contains("pieces of cam = 3 and 4") && error.contains("(2, 1)"),
            "{error}"
        );
        let error = told(&[(0.0, 0.0), (1.0, 0.0), (0.5, 0.0)], false);
        assert!(
            error.contains("1 and 2") && error.contains("spike"),
            "{error}"
        );
        // The last piece of a closed path reverses along the first.
        let error = told(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (2.0, 0.0)], true);
        assert!(error.contains("4 and 1"), "{error}");
        // A sharp point is not a spike, and neither is a straight line in two parts.
        let sharp = [(0.0, 0.0), (1.0, 1e-4), (0.0, 2e-4), (0.0, 1e-4)];
        assert_eq!(told(&sharp, true), "");
    }

    #[test]
    fn an_outline_that_touches_itself_is_refused_and_one_that_comes_near_is_not() {
        // A corner on another side, and two corners at one point.
        let notch = |height: f64| {
            [
                (0.0, 0.0),
                (2.0, 0.0),
                (2.0, 1.0),
                (1.0, height),
                (0.0, 1.0),
            ]
        };
        let error = told(&notch(0.0), true);
        assert!(
            error.contains("1 and 3") && error.contains("touch each other"),
            "{error}"
        );
        assert_eq!(told(&notch(1e-6), true), "");
        let pinched = [
            (0.0, 0.0),
            (1.0, 0.5),
            (2.0, 0.0),
            (2.0, 1.0),
            (1.0, 0.5),
            (0.0, 1.0),
        ];
        let error = told(&pinched, true);
        assert!(error.contains("touch each other"), "{error}");
        // An open line may end where it begins, and may not end on another of its pieces.
        let ring = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)];
        assert_eq!(told(&ring, false), "");
        let hook = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 0.0)];
        let error = told(&hook, false);
        assert!(
            error.contains("1 and 3") && error.contains("touch each other"),
            "{error}"
        );
    }

    #[test]
    fn points_in_one_line_are_said_to_enclose_nothing() {
        let error = told(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)], true);
        assert!(
            error.contains("spike") && !error.contains("clockwise"),
            "{error}"
        );
        let thin = [(0.0, 0.0), (1.0, 0.0), (1.0, 1e-12), (0.0, 1e-12)];
        let error = told(&thin, true);
        assert!(error.contains("enclose nothing"), "{error}");
    }

    #[test]
    fn an_arc_that_bulges_through_another_side_is_refused() {
        let arc = |from: (f64, f64), to: (f64, f64), center: Option<(f64, f64)>| Piece {
            from: Vec2::new(from.0, from.1),
            to: Vec2::new(to.0, to.1),
            center: center.map(|(x, y)| Vec2::new(x, y)),
            convex: false,
        };
        // A flat box with an arc as its floor that may reach above its lid.
        let pieces = |height: f64| {
            let center = (height * height - 1.0) / (2.0 * height);
            [
                arc((-1.0, 0.0), (1.0, 0.0), Some((0.0, center))),
                arc((1.0, 0.0), (1.0, 0.3), None),
                arc((1.0, 0.3), (-1.0, 0.3), None),
                arc((-1.0, 0.3), (-1.0, 0.0), None),
            ]
        };
        assert!(check_path("box", &pieces(0.2), true).is_ok());
        assert!(check_path("box", &pieces(0.5), true).is_err());
    }
}

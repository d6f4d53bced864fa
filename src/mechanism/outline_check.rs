//! What an outline must be: one way without gaps that does not cross itself.

use super::piece::Piece;
use crate::error::{Error, Result};
use crate::geometry::Vec2;

/// Chords that stand for a quarter turn of an arc where crossings are looked for.
const CHORDS: f64 = 8.0;

/// Checks that pieces follow each other and that the way does not cross itself.
pub(super) fn check_way(field: &str, pieces: &[Piece], closed: bool) -> Result<()> {
    let next = pieces.iter().enumerate().skip(1);
    let next = next.chain(pieces.iter().enumerate().take(usize::from(closed)));
    for (piece, (number, after)) in pieces.iter().zip(next) {
        let size = (piece.to - piece.from)
            .norm()
            .max((after.to - after.from).norm());
        let gap = (after.from - piece.to).norm();
        if gap > 1e-9 * size {
            return Err(Error::invalid(
                format!("piece {} of {field}", number + 1),
                format!("a beginning {gap:.3e} m away from where the piece before ends"),
                "must begin there",
            ));
        }
    }
    let chords = chords(pieces);
    for (i, (first, [a, b])) in chords.iter().enumerate() {
        for (j, (second, [c, d])) in chords.iter().enumerate().skip(i + 2) {
            let neighbours = closed && i == 0 && j == chords.len() - 1;
            if !neighbours && cross(*a, *b, *c, *d) {
                return Err(Error::invalid(
                    format!("pieces of {field}"),
                    format!("{} and {}", first + 1, second + 1),
                    "cross each other: give the points in the order in which the outline passes through them",
                ));
            }
        }
    }
    Ok(())
}

/// Straight lines along the way, each with the number of its piece.
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

/// Whether two lines without a common end cross or touch.
fn cross(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> bool {
    let side = |p: Vec2, q: Vec2, r: Vec2| (q - p).perp(&(r - p));
    let (to_c, to_d) = (side(a, b, c), side(a, b, d));
    let (to_a, to_b) = (side(c, d, a), side(c, d, b));
    to_c * to_d < 0.0 && to_a * to_b < 0.0
}

#[cfg(test)]
mod tests {
    use super::super::Profile;
    use super::*;

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
        let error = check_way("square", &pieces, true).unwrap_err().to_string();
        assert!(
            error.contains("piece 3 of square") && error.contains("1.000e-1 m away"),
            "{error}"
        );
    }

    #[test]
    fn an_arc_that_bulges_through_another_side_is_refused() {
        let arc = |from: (f64, f64), to: (f64, f64), center: Option<(f64, f64)>| Piece {
            from: Vec2::new(from.0, from.1),
            to: Vec2::new(to.0, to.1),
            center: center.map(|(x, y)| Vec2::new(x, y)),
            convex: false,
        };
        // A flat box whose floor is an arc that reaches above its lid.
        let pieces = |height: f64| {
            let center = (height * height - 1.0) / (2.0 * height);
            [
                arc((-1.0, 0.0), (1.0, 0.0), Some((0.0, center))),
                arc((1.0, 0.0), (1.0, 0.3), None),
                arc((1.0, 0.3), (-1.0, 0.3), None),
                arc((-1.0, 0.3), (-1.0, 0.0), None),
            ]
        };
        assert!(check_way("box", &pieces(0.2), true).is_ok());
        assert!(check_way("box", &pieces(0.5), true).is_err());
    }
}

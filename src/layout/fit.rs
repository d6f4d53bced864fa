//! Fit of hinges to links of different lengths, with the smallest displacements.

use std::f64::consts::PI;

use super::laid_chain::LARGEST_STRETCH;
use crate::drive::Chain;
use crate::geometry::Vec2;
use crate::geometry::path::polygon::bow_angle;

/// Part of two links by which a belt line may be longer than an even number of links; a longer one takes two links more.
const MISSING_PART_OF_TWO: f64 = 0.05;
/// Largest angle at the ends of a slack strand's bow \[rad\]: nearly vertical ends.
const LARGEST_BOW: f64 = 0.45 * PI;
/// Share of the hinge clearance below which a stretched chain counts as taut.
pub(super) const TAUT_STRETCH: f64 = 0.02;

/// Stretch of each hinge, over its clearance, above which a chain counts as too short: three times the limit of a layout.
const HOPELESS_STRETCH: f64 = 3.0 * LARGEST_STRETCH;
/// Shortage per link in pitches that is permitted beside it: the belt line is not the polygon of the links.
const SHORTAGE_MARGIN: f64 = 0.01;
/// Difference of link pitches that counts as none \[m\]: rounding of their mean.
const EQUAL_PITCH: f64 = 1e-15;

/// Misfit of a link that counts as zero, over the largest coordinate of its hinges. A length is the difference of two
/// coordinates, each rounded by half an epsilon: a smaller misfit is not reachable.
const FITTING: f64 = 4.0 * f64::EPSILON;

/// Shares of the length differences that the hinges take, tried in this order. One half serves chains with nearly all
/// clearance in use; finer shares gain hardly any more chains.
const SHARES: [f64; 3] = [1.0, 0.0, 0.5];

/// Return hinges for links of their own lengths, from those laid with one pitch; the best fit first.
///
/// Hinges move until every clearance is as open as it was. Where the teeth leave no room for that, they move half as far or not at
/// all, and every link lies in the middle between its hinges: each clearance takes half of the difference.
fn for_own_lengths(chain: &Chain, hinges: Vec<Vec2>) -> Vec<Vec<Vec2>> {
    let (pitches, mean) = (chain.link_pitches(), chain.mean_pitch());
    if pitches
        .iter()
        .all(|&pitch| (pitch - mean).abs() <= EQUAL_PITCH)
    {
        return vec![hinges];
    }
    let n = pitches.len();
    let moved = |share: f64| {
        let lengths: Vec<f64> = (0..n)
            .map(|i| (hinges[i] - hinges[(i + n - 1) % n]).norm() + share * (pitches[i] - mean))
            .collect();
        let mut moved = hinges.clone();
        fit(&mut moved, &lengths).then_some(moved)
    };
    SHARES.into_iter().filter_map(moved).collect()
}

/// Return hinges of [`for_own_lengths`] without a `fault`; the first fault is stored in `why`.
pub(super) fn without_fault(
    chain: &Chain,
    hinges: Vec<Vec2>,
    why: &mut Option<String>,
    fault: impl Fn(&[Vec2]) -> Option<String>,
) -> Option<Vec<Vec2>> {
    for_own_lengths(chain, hinges).into_iter().find(|own| {
        let fault = fault(own);
        let fits = fault.is_none();
        *why = why.take().or(fault);
        fits
    })
}

/// Return why a chain is too short for a belt line of `needed` pitches, if even open hinges do not make up for it.
pub(super) fn shortage(chain: &Chain, needed: f64) -> Option<String> {
    let (pitch, clearance) = (chain.mean_pitch(), chain.hinge.clearance());
    let missing = needed - f64::from(chain.links);
    let stretch = missing * pitch / f64::from(chain.links);
    (stretch > HOPELESS_STRETCH * clearance + SHORTAGE_MARGIN * pitch).then(|| {
        format!(
            "it is {:.3} mm too short, {:.1} um a hinge, and a hinge's clearance gives {:.1} um",
            1e3 * missing * pitch,
            1e6 * stretch,
            1e6 * clearance
        )
    })
}

/// Return the fault of a slack strand that bows out too far, if any; it does not depend on the lengths of single links.
pub(super) fn bow_fault(strand: &str, slack: f64, span: f64, sag: f64) -> Option<String> {
    (bow_angle(sag, span) > LARGEST_BOW).then(|| {
        format!(
            "the {strand} strand has {:.3} mm of slack over {:.3} mm and would bow out by {:.3} mm",
            1e3 * slack,
            1e3 * span,
            1e3 * sag
        )
    })
}

/// Return the remedy for a chain that cannot be laid round centres that take `fewest` links.
pub(super) fn remedy(chain: &Chain, fewest: u32) -> String {
    if fewest != chain.links {
        return format!("these centres take {fewest} links: set Chain.links = {fewest}");
    }
    let lengths = if chain.variation.is_none() {
        ""
    } else {
        "a smaller Chain.pitch_spread or Chain.elongation, another Chain.seed, "
    };
    // Of 44 random drives that were refused so, 19 could be laid with two links more, and 17 with a sprocket half a pitch farther in.
    format!(
        "these centres take this number of links, but no position of the seats that was tried is possible: take {lengths}{} links \
         (Chain.links), move a sprocket by up to half a pitch (Sprocket.center), or change its tooth form (Sprocket.profile)",
        fewest + 2
    )
}

/// Move `hinges` of a closed chain until link i, from hinge i - 1 to hinge i, is `lengths[i]` \[m\] long; return false where this is
/// impossible.
///
/// Gauss-Newton steps of least norm: with the links' directions e, a step is `Jᵀ λ`, and `J Jᵀ` has 2 on the diagonal and
/// -e·e' beside it, with the corner entry of a ring.
fn fit(hinges: &mut [Vec2], lengths: &[f64]) -> bool {
    let n = hinges.len();
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    let farthest = hinges.iter().map(Vec2::amax).fold(0.0, f64::max);
    for _ in 0..50 {
        let links: Vec<Vec2> = (0..n)
            .map(|i| hinges[i] - hinges[(i + n - 1) % n])
            .collect();
        let misfit: Vec<f64> = links
            .iter()
            .zip(lengths)
            .map(|(d, l)| l - d.norm())
            .collect();
        let worst = misfit.iter().fold(0.0, |most: f64, m| most.max(m.abs()));
        if worst <= FITTING * farthest {
            return true;
        }
        let along: Vec<Vec2> = links.iter().map(Vec2::normalize).collect();
        let beside: Vec<f64> = (0..n).map(|i| -along[i].dot(&along[(i + 1) % n])).collect();
        let Some(push) = solve_ring(&beside, misfit) else {
            return false;
        };
        for i in 0..n {
            let next = (i + 1) % n;
            hinges[i] += push[i] * along[i] - push[next] * along[next];
        }
        if worst > longest || worst.is_nan() {
            return false;
        }
    }
    false
}

/// Solve the symmetric system with 2 on the diagonal and `beside[i]` between i and i + 1, the last one with the first.
///
/// The corner entry is a change of rank one (Sherman and Morrison).
fn solve_ring(beside: &[f64], mut right: Vec<f64>) -> Option<Vec<f64>> {
    let n = right.len();
    let corner = beside[n - 1];
    let shift = -2.0;
    let mut diagonal = vec![2.0; n];
    diagonal[0] -= shift;
    diagonal[n - 1] -= corner * corner / shift;
    let mut column = vec![0.0; n];
    column[0] = shift;
    column[n - 1] = corner;
    for i in 1..n {
        let factor = beside[i - 1] / diagonal[i - 1];
        diagonal[i] -= factor * beside[i - 1];
        right[i] -= factor * right[i - 1];
        column[i] -= factor * column[i - 1];
    }
    for values in [&mut right, &mut column] {
        values[n - 1] /= diagonal[n - 1];
        for i in (0..n - 1).rev() {
            values[i] = (values[i] - beside[i] * values[i + 1]) / diagonal[i];
        }
    }
    let weight = |values: &[f64]| values[0] + corner / shift * values[n - 1];
    let share = weight(&right) / (1.0 + weight(&column));
    let solution: Vec<f64> = right
        .iter()
        .zip(&column)
        .map(|(r, c)| r - share * c)
        .collect();
    solution.iter().all(|x| x.is_finite()).then_some(solution)
}

/// Return the smallest even number of links not below `pitches`, except for [`MISSING_PART_OF_TWO`].
#[must_use]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a count of links
pub(super) fn even_links(pitches: f64) -> u32 {
    2 * (0.5 * pitches - MISSING_PART_OF_TWO).ceil().max(2.0) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::unit;

    #[test]
    fn a_polygon_takes_other_lengths_and_moves_little() {
        let n: usize = 40;
        let angle = 2.0 * std::f64::consts::PI / n as f64;
        let radius = 0.5 / (0.5 * angle).sin();
        let polygon: Vec<Vec2> = (0..n).map(|i| radius * unit(i as f64 * angle)).collect();
        let lengths: Vec<f64> = (0..n)
            .map(|i| 1.0 + 1e-3 * ((i % 3) as f64 - 1.0))
            .collect();
        let mut fitted = polygon.clone();
        assert!(fit(&mut fitted, &lengths));
        for i in 0..n {
            let link = fitted[i] - fitted[(i + n - 1) % n];
            assert!((link.norm() - lengths[i]).abs() < 1e-14);
        }
        let moved = polygon.iter().zip(&fitted).map(|(a, b)| (a - b).norm());
        assert!(moved.fold(0.0, f64::max) < 2e-3);
    }

    #[test]
    fn lengths_are_met_to_the_rounding_of_coordinates_far_from_the_origin() {
        let n: usize = 182;
        let angle = 2.0 * std::f64::consts::PI / n as f64;
        let far = Vec2::new(1e3, -2e3);
        let mut hinges: Vec<Vec2> = (0..n).map(|i| far + 0.5 * unit(i as f64 * angle)).collect();
        let link = (hinges[1] - hinges[0]).norm();
        let lengths: Vec<f64> = (0..n)
            .map(|i| link * (1.0 + 1e-7 * ((i % 5) as f64 - 2.0)))
            .collect();
        assert!(fit(&mut hinges, &lengths));
    }

    #[test]
    fn a_link_longer_than_all_others_together_does_not_fit() {
        let mut square =
            [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Vec2::new(x, y));
        assert!(!fit(&mut square, &[9.0, 1.0, 1.0, 1.0]));
    }
}

//! Stiffness of hinges with lubricant: contact, friction and film in parallel, one symmetric 2x2 block per hinge.
//!
//! γ times the force of a film changes by `-(γ D + γ² K)` per unit change of the velocities, where D and K are its slopes. Their asymmetric
//! parts are neglected. The rotation of the film's frame with the ends is neglected too; its relative size is the eccentricity over
//! a lever.

use pulp::{Simd, WithSimd};

use super::contacts::{FrictionArms, HingeRoots, LEAST, scaled};
use super::power_change::CorrectedEnds;
use super::ring::hinge_vectors;
use crate::chain::arrays::slopes::{ContactSlopes, FilmGroup};
use crate::math::simd::{Lanes, Pack, Vectors, packs, part_of, parts, read_rounded};

/// Upper bound of xy²/(xx yy) in a block. Larger off-diagonal entries are set to zero, which keeps the block positive definite.
const MOST_BESIDE: f64 = 0.9;

/// Change of the velocity of a film over √(g² + g₀²) above which its slopes have changed.
///
/// From separation to approach the slope grows up to a hundred times. A correction with the slope before it then leaves a film force up to a
/// hundred times too large.
const MOST_CHANGE: f64 = 0.1;

/// Write the roots of the stiffness of each hinge, as `assemble_roots` does. Any hinge may transmit force: a film does so without contact.
#[inline(always)]
pub(super) fn assemble_film_roots<S: Vectors>(
    simd: S,
    gamma: f64,
    hinges: &ContactSlopes,
    films: &[FilmGroup],
    to: &mut HingeRoots<S::Number>,
    arms: &mut FrictionArms<S::Number>,
) {
    let slopes = &hinges.normal;
    let splat = |value| Lanes::splat(simd, value);
    let (zero, least) = (splat(0.0), splat(LEAST));
    let (once, twice) = (splat(gamma), splat(gamma * gamma));
    to.any = true;
    let count = parts::<S>().len();
    let mut roots = hinge_vectors::<S>(&mut to.roots, slopes.len() * count);
    let each = slopes.iter().zip(films).zip(&hinges.friction);
    for (number, ((slopes, film), friction)) in each.enumerate() {
        for part in parts::<S>() {
            let i = number * count + part;
            let [dxx, dyy, dxy] = read_rounded(simd, &film.damping, part);
            let [kxx, kyy, kxy] = read_rounded(simd, &film.stiffness, part);
            let touches = slopes.force.rounded(simd, part).greater(zero);
            let bears = dxx.greater(zero).or(touches);
            let [alpha, eta] = scaled(gamma, simd, slopes, part);
            let tau = once * friction.slope.rounded(simd, part);
            // Stiffness in the frame (n, t): α + γ D_xx + γ² K_xx and η + τ + γ D_yy + γ² K_yy; negative K_xx and K_yy are set to
            // zero.
            let film_xx = once.mul_add(dxx, (twice * kxx).positive_part());
            let film_yy = once.mul_add(dyy, (twice * kyy).positive_part());
            let xx = bears.select((alpha + film_xx).positive_part(), zero);
            let yy = bears.select((eta + tau + film_yy).positive_part(), zero);
            let xy = once.mul_add(dxy, twice * kxy);
            let definite = (xy * xy).less(splat(MOST_BESIDE) * xx * yy);
            let xy = definite.select(xy, zero);
            let [nx, ny] = read_rounded(simd, &film.normal, part);
            let places = read_rounded(simd, &friction.places, part);
            arms.put(i, [nx, ny], tau / yy.max(least), places);
            // Root of a 2x2 block A: (A + √det A)/√(trace A + 2 √det A), rotated to the frame of the scene.
            let root = xx.mul_add(yy, -(xy * xy)).sqrt();
            let over = zero.constant(1.0) / (xx + yy + (root + root)).max(least).sqrt();
            let (along, across, beside) = ((xx + root) * over, (yy + root) * over, xy * over);
            let crossed = (beside + beside) * (nx * ny);
            let entries = [
                along.mul_add(nx * nx, across * (ny * ny)) - crossed,
                along.mul_add(ny * ny, across * (nx * nx)) + crossed,
                (along - across).mul_add(nx * ny, beside * nx.mul_add(nx, -(ny * ny))),
            ];
            for (roots, entry) in roots.iter_mut().zip(entries) {
                roots[i] = entry.values();
            }
        }
    }
}

/// Kernel: return whether the last correction changes the velocity of a film so much that its slopes change. The corrections of the links'
/// ends must be written.
pub(super) struct FilmSlopesChange<'a> {
    pub(super) films: &'a [FilmGroup],
    pub(super) ends: &'a CorrectedEnds,
}

impl WithSimd for FilmSlopesChange<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let count = self.films.len();
        let [front_x, front_y, rear_x, rear_y, _] = &self.ends.links;
        let (front_x, front_y) = (packs(front_x, count), packs(front_y, count));
        // Hinge k joins the front of link k to the rear of link k + 1.
        let (rear_x, rear_y) = (packs(&rear_x[1..], count), packs(&rear_y[1..], count));
        let mut most = Lanes::splat(simd, 0.0);
        for (number, film) in self.films.iter().enumerate() {
            for part in parts::<S>() {
                let at = |array: &[Pack]| part_of(simd, &array[number], part);
                let (x, y) = (at(front_x) - at(rear_x), at(front_y) - at(rear_y));
                let inverse_speed = film.inverse_speed.at(simd, part);
                most = most.max(x.mul_add(x, y * y) * (inverse_speed * inverse_speed));
            }
        }
        most.exceeds(Lanes::splat(simd, MOST_CHANGE * MOST_CHANGE))
            .any()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::simd::InstructionSet;

    #[test]
    fn slopes_change_where_one_film_changes_its_velocity_by_a_share_of_its_own() {
        let links = 11usize;
        let changes = |hinge: usize, change: [f64; 2], set: InstructionSet| {
            let mut films = vec![FilmGroup::default(); links.div_ceil(8)];
            for (i, film) in films.iter_mut().enumerate() {
                for k in 8 * i..links.min(8 * i + 8) {
                    film.inverse_speed.0[k % 8] = 1.0 / (1.0 + k as f64);
                }
            }
            let mut ends = CorrectedEnds::new(links);
            // Links that move as one change no film.
            for end in &mut ends.links[..4] {
                end[..=links].fill(5.0);
            }
            // Hinge k joins the front of link k to the rear of link k + 1.
            for (axis, change) in change.into_iter().enumerate() {
                ends.links[axis][hinge] += 0.5 * change;
                ends.links[2 + axis][hinge + 1] -= 0.5 * change;
            }
            set.run(FilmSlopesChange {
                films: &films,
                ends: &ends,
            })
        };
        for set in InstructionSet::available() {
            for hinge in 0..links {
                let own = 1.0 + hinge as f64;
                // A change of 5/13 and 12/13 of its size along both axes.
                let by = |size: f64| [5.0 / 13.0 * size * own, -12.0 / 13.0 * size * own];
                assert!(changes(hinge, by(1.001 * MOST_CHANGE), set), "{hinge}");
                assert!(!changes(hinge, by(0.999 * MOST_CHANGE), set), "{hinge}");
            }
        }
    }
}

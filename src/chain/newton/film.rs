//! Stiffness of hinges with lubricant: contact, friction and film in parallel, one symmetric 2x2 block per hinge.
//!
//! γ times the force of a film changes by `-(γ D + γ² K)` per unit change of the velocities, where D and K are its slopes. Their asymmetric
//! parts are neglected. The rotation of the film's frame with the ends is neglected too; its relative size is the eccentricity over
//! a lever.

use super::contacts::{FrictionArms, HingeRoots, LEAST, scaled};
use super::ring::hinge_vectors;
use crate::chain::arrays::slopes::{ContactSlopes, FilmGroup};
use crate::math::simd::{Lanes, Vectors, parts, read_rounded};

/// Upper bound of xy²/(xx yy) in a block. Larger off-diagonal entries are set to zero, which keeps the block positive definite.
const MOST_BESIDE: f64 = 0.9;

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

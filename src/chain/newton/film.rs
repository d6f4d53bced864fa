//! Compliances of hinges with lubricant: contact, friction and film in parallel, one symmetric 2x2 block per hinge.
//!
//! γ times the force of a film changes by `-(γ D + γ² K)` per unit change of the velocities, where D and K are its slopes. Their asymmetric
//! parts are neglected. The rotation of the film's frame with the ends is neglected too; its relative size is the eccentricity over
//! a lever.

use pulp::Simd;

use super::contacts::{FrictionArms, LEAST, LEAST_SHARE, LoadedHinges, scaled};
use super::ring::{BASE, HingeBlocks, hinge_vectors};
use crate::chain::arrays::slopes::{ContactSlopes, FilmGroup};
use crate::math::simd::{Lanes, parts, read, vectors_mut};

/// Upper bound of xy²/(xx yy) in a block. Larger off-diagonal entries are set to zero, which keeps the block positive definite.
const MOST_BESIDE: f64 = 0.9;

/// Initialise the ring's blocks with the compliance of each hinge, as `assemble_compliance` does. Any hinge may transmit force: a
/// film does so without contact.
#[inline(always)]
pub(super) fn assemble_film_compliance<S: Simd>(
    simd: S,
    gamma: f64,
    hinges: &ContactSlopes,
    films: &[FilmGroup],
    loaded: &mut LoadedHinges,
    blocks: &mut HingeBlocks,
    arms: &mut FrictionArms,
) {
    let slopes = &hinges.normal;
    let splat = |value| Lanes::splat(simd, value);
    let (zero, one) = (splat(0.0), splat(1.0));
    let (least, least_share) = (splat(LEAST), splat(LEAST_SHARE));
    let (once, twice) = (splat(gamma), splat(gamma * gamma));
    loaded.any = true;
    let count = parts::<S>().len();
    let bearing = vectors_mut::<S>(&mut loaded.hinges[BASE..], slopes.len() * count);
    let mut own = hinge_vectors::<S>(&mut blocks.compliance, slopes.len() * count);
    let each = slopes.iter().zip(films).zip(&hinges.friction);
    for (number, ((slopes, film), friction)) in each.enumerate() {
        for part in parts::<S>() {
            let i = number * count + part;
            let [dxx, dyy, dxy] = read(simd, &film.damping, part);
            let [kxx, kyy, kxy] = read(simd, &film.stiffness, part);
            let touches = slopes.force.at(simd, part).greater(zero);
            let bears = dxx.greater(zero).or(touches);
            bearing[i] = bears.select(one, zero).values();
            let [alpha, eta] = scaled(gamma, simd, slopes, part);
            let tau = once * friction.slope.at(simd, part);
            // Stiffness in the frame (n, t): α + γ D_xx + γ² K_xx and η + τ + γ D_yy + γ² K_yy; negative K_xx and K_yy are set to
            // zero.
            let film_xx = once.mul_add(dxx, (twice * kxx).positive_part());
            let film_yy = once.mul_add(dyy, (twice * kyy).positive_part());
            let xx = bears.select((alpha + film_xx).max(least), one);
            let yy = bears.select((eta + tau + film_yy).max(xx * least_share), one);
            let xy = once.mul_add(dxy, twice * kxy);
            let definite = (xy * xy).less(splat(MOST_BESIDE) * xx * yy);
            let xy = definite.select(xy, zero);
            let (nx, ny) = (film.normal[0].at(simd, part), film.normal[1].at(simd, part));
            let places = read(simd, &friction.places, part);
            arms.put(i, [nx, ny], tau / yy, places);
            // Inverse of the block in the frame (n, t), rotated to the frame of the scene.
            let over = one / xx.mul_add(yy, -(xy * xy));
            let (along, across, beside) = (yy * over, xx * over, -(xy * over));
            let crossed = (beside + beside) * (nx * ny);
            let entries = [
                bears.select(along.mul_add(nx * nx, across * (ny * ny)) - crossed, one),
                bears.select(along.mul_add(ny * ny, across * (nx * nx)) + crossed, one),
                bears.select(
                    (along - across).mul_add(nx * ny, beside * nx.mul_add(nx, -(ny * ny))),
                    zero,
                ),
            ];
            for (own, entry) in own.iter_mut().zip(entries) {
                own[i] = entry.values();
            }
        }
    }
}

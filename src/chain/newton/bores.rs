//! Stiffness of the contacts between bushings and the bores of rollers, with and without friction.

use super::blocks::Symmetric;
use super::contacts::scaled;
use super::spatial::Spatial;
use crate::chain::arrays::slopes::{FrictionGroup, SlopeGroup};
use crate::math::simd::{Lanes, Mask, Pack8, Vectors, read_rounded};

/// Return the stiffness of bores without friction, α n n^T + η t t^T: xx, yy, xy; zero without contact.
#[inline(always)]
pub(super) fn bore<S: Vectors>(
    simd: S,
    gamma: f64,
    slopes: &SlopeGroup,
    part: usize,
) -> Symmetric<S> {
    let zero = Lanes::splat(simd, 0.0);
    let bears = slopes.force.rounded(simd, part).greater(zero);
    let [alpha, eta] = scaled(gamma, simd, slopes, part);
    let (alpha, eta) = (bears.select(alpha, zero), bears.select(eta, zero));
    let [nx, ny] = read_rounded(simd, &slopes.normal, part);
    Symmetric([
        alpha.mul_add(nx * nx, eta * (ny * ny)),
        alpha.mul_add(ny * ny, eta * (nx * nx)),
        (alpha - eta) * (nx * ny),
    ])
}

/// Friction of bushings in bores: τ along `across` at the contact, with its positions along the normal from both centres.
pub(super) struct BoreFriction<S: Vectors> {
    tau: Lanes<S>,
    across: [Lanes<S>; 2],
    pub(super) of_roller: Lanes<S>,
    pub(super) of_bushing: Lanes<S>,
}

impl<S: Vectors> BoreFriction<S> {
    /// Return the friction of vector `part` of bores.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        gamma: f64,
        normal: &[Pack8; 2],
        slopes: &FrictionGroup,
        part: usize,
    ) -> Self {
        let [nx, ny] = read_rounded(simd, normal, part);
        let [of_roller, of_bushing] = read_rounded(simd, &slopes.places, part);
        Self {
            tau: Lanes::splat(simd, gamma) * slopes.slope.rounded(simd, part),
            across: [-ny, nx],
            of_roller,
            of_bushing,
        }
    }

    /// Return the same with zeros where no contact exists.
    #[inline(always)]
    pub(super) fn where_it(self, bears: Mask<S>) -> Self {
        let zero = self.tau.constant(0.0);
        Self {
            tau: bears.select(self.tau, zero),
            across: self.across,
            of_roller: bears.select(self.of_roller, zero),
            of_bushing: bears.select(self.of_bushing, zero),
        }
    }

    /// Return the block of the bore on one body with arms `first` and `second`.
    ///
    /// With t = `across` and the arm a of the body: B + τ t t^T for translation, τ a t for the coupling, τ a² for rotation.
    #[inline(always)]
    pub(super) fn block(
        &self,
        bore: &Symmetric<S>,
        first: Lanes<S>,
        second: Lanes<S>,
    ) -> Spatial<S> {
        let ([xx, yy, xy], [tx, ty]) = (bore.0, self.across);
        let tau = self.tau;
        Spatial([
            (tau * tx).mul_add(tx, xx),
            (tau * tx).mul_add(ty, xy),
            (tau * tx) * first,
            (tau * ty).mul_add(ty, yy),
            (tau * ty) * first,
            (tau * first) * second,
        ])
    }

    /// Return C: rows of the roller, columns of the bushing.
    #[inline(always)]
    pub(super) fn coupling(&self, bore: &Symmetric<S>) -> [Lanes<S>; 9] {
        let ([xx, yy, xy], [tx, ty]) = (bore.0, self.across);
        let tau = self.tau;
        let (roller, bushing) = (tau * self.of_roller, tau * self.of_bushing);
        let crossed = (tau * tx).mul_add(ty, xy);
        [
            (tau * tx).mul_add(tx, xx),
            crossed,
            bushing * tx,
            crossed,
            (tau * ty).mul_add(ty, yy),
            bushing * ty,
            roller * tx,
            roller * ty,
            roller * self.of_bushing,
        ]
    }
}

//! Contacts of bushings with teeth under changes of the sprocket's coordinates: derivatives of penetration, position and normal.

use crate::math::simd::{Lanes, Vectors};

/// Coordinate of a sprocket.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum BorderMotion {
    /// Displacement of its centre along this direction.
    Along([f64; 2]),
    /// Rotation.
    Turn,
}

/// Maximum number of coordinates of a sprocket: two of its centre and its angle.
pub(super) const MOST: usize = 3;

/// Geometry of one SIMD vector of bushings on teeth.
pub(super) struct ToothMotion<S: Vectors> {
    /// Stiffness along the normal, and across it with friction, as in [`contacts`](super::contacts).
    pub(super) alpha: Lanes<S>,
    pub(super) eta: Lanes<S>,
    /// Share of friction in η; zero without.
    pub(super) tau: Lanes<S>,
    pub(super) normal: [Lanes<S>; 2],
    /// Position of the bushing's centre relative to the sprocket's \[m\].
    pub(super) arm: [Lanes<S>; 2],
    pub(super) curvature: Lanes<S>,
    /// γ² f
    pub(super) turn: Lanes<S>,
    /// Radius of the bushings \[m\].
    pub(super) radius: Lanes<S>,
}

/// Derivatives of the contact geometry with respect to a coordinate of the sprocket.
#[derive(Clone, Copy)]
pub(super) struct Moved<S: Vectors> {
    /// Penetration.
    pub(super) closes: Lanes<S>,
    /// Position of the bushing relative to the sprocket, along t.
    pub(super) across: Lanes<S>,
    /// Angle of the normal.
    pub(super) turns: Lanes<S>,
    /// Position of the bushing's contact point relative to the sprocket's, along t.
    pub(super) slides: Lanes<S>,
}

impl<S: Vectors> ToothMotion<S> {
    /// Return the stiffness at the bushing, α n n^T + η t t^T: xx, yy, xy.
    #[inline(always)]
    pub(super) fn stiff(&self) -> [Lanes<S>; 3] {
        let ([nx, ny], [alpha, eta]) = (self.normal, [self.alpha, self.eta]);
        [
            alpha.mul_add(nx * nx, eta * (ny * ny)),
            alpha.mul_add(ny * ny, eta * (nx * nx)),
            (alpha - eta) * (nx * ny),
        ]
    }

    /// Return the derivatives for each of these coordinates.
    #[inline(always)]
    pub(super) fn all_moved(&self, motions: &[BorderMotion]) -> [Moved<S>; MOST] {
        let mut moved = [self.still(); MOST];
        for (moved, &motion) in moved.iter_mut().zip(motions) {
            *moved = self.moved(motion);
        }
        moved
    }

    /// Return n·arm.
    #[inline(always)]
    pub(super) fn outward(&self) -> Lanes<S> {
        self.arm[0].mul_add(self.normal[0], self.arm[1] * self.normal[1])
    }

    /// Return zero derivatives.
    #[inline(always)]
    fn still(&self) -> Moved<S> {
        let zero = self.turn.constant(0.0);
        Moved {
            closes: zero,
            across: zero,
            turns: zero,
            slides: zero,
        }
    }

    /// Return the derivatives for one coordinate.
    #[inline(always)]
    fn moved(&self, motion: BorderMotion) -> Moved<S> {
        let [nx, ny] = self.normal;
        match motion {
            BorderMotion::Along(direction) => {
                let [x, y] = [nx.constant(direction[0]), nx.constant(direction[1])];
                let across = ny.mul_add(x, -(nx * y));
                Moved {
                    closes: -(nx.mul_add(x, ny * y)),
                    across,
                    turns: self.curvature * across,
                    slides: across,
                }
            }
            BorderMotion::Turn => {
                let [x, y] = self.arm;
                let one = nx.constant(1.0);
                Moved {
                    closes: y.mul_add(nx, -(x * ny)),
                    across: nx.constant(0.0),
                    turns: self.curvature.negate_mul_add(self.outward(), one),
                    slides: -(self.outward() + self.radius),
                }
            }
        }
    }
}

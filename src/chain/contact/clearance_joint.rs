//! Clearance joint: a cylinder in the bore of another, pin in bushing or bushing in roller (paper's Eqs. 2 and 3).
//!
//! The kernels have the same equations over vectors (chain/rhs/chain/hinges.rs). This form serves event location, which must not run the
//! kernels: they would overwrite the arrays of the last evaluation.

use crate::geometry::{Contact, Vec2, direction};

/// Return the contact of a cylinder in a bore with radial `clearance` c \[m\]: δ = |e| - c, dδ/dt = n · de/dt.
///
/// `offset` e \[m\] and `velocity` de/dt \[m/s\]: centre of the inner cylinder relative to that of the outer one. The normal n = e/|e| is
/// zero where the centres coincide.
#[must_use]
pub(super) fn pin_in_bushing(offset: Vec2, velocity: Vec2, clearance: f64) -> Contact {
    let distance = offset.norm();
    let normal = direction(offset, distance);
    Contact {
        normal,
        penetration: distance - clearance,
        penetration_rate: normal.dot(&velocity),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_contact_up_to_the_edge_of_the_clearance() {
        let contact = pin_in_bushing(Vec2::new(0.0, 25e-6), Vec2::new(3.0, 0.5), 25e-6);
        assert!(contact.penetration <= 0.0);
        assert!((contact.penetration_rate - 0.5).abs() < 1e-15);
    }

    #[test]
    fn coincident_centres_are_one_clearance_apart_and_have_no_direction() {
        let contact = pin_in_bushing(Vec2::zeros(), Vec2::new(1.0, 1.0), 25e-6);
        assert_eq!(contact.penetration, -25e-6);
        assert_eq!(contact.normal, Vec2::zeros());
    }
}

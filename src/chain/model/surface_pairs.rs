//! Pairs of surfaces that touch: pins, bushings and rollers, and the surfaces of sprockets and guides.

use super::sprocket::SprocketModel;
use crate::drive::Drive;
use crate::force_law::{SurfacePair, tooth_surfaces};

/// Surface pairs of all contacts.
pub(super) struct SurfacePairs {
    /// Pin and bushing.
    pub(super) hinges: SurfacePair,
    /// Bushing and roller, where rollers are bodies of their own.
    pub(super) rollers: Option<SurfacePair>,
    /// Bushings and every surface of all sprockets and guides.
    pub(super) teeth: Vec<SurfacePair>,
}

impl SurfacePairs {
    /// Return the pairs of `drive`.
    pub(super) fn of(drive: &Drive, wheels: &[SprocketModel]) -> Self {
        let (chain, hinge) = (&drive.chain, &drive.chain.hinge);
        let modulus = chain.material.contact_modulus();
        Self {
            hinges: SurfacePair::internal(
                hinge.pin_radius,
                hinge.bore_radius,
                chain.hinge_contact_length(),
                modulus,
            ),
            rollers: chain.roller.map(|roller| {
                let length = f64::from(chain.strands) * roller.length;
                SurfacePair::internal(chain.bushing_radius, roller.bore_radius, length, modulus)
            }),
            teeth: tooth_pairs(drive, wheels),
        }
    }
}

/// Return the surface pairs of bushings and every surface of all sprockets and guides.
fn tooth_pairs(drive: &Drive, wheels: &[SprocketModel]) -> Vec<SurfacePair> {
    let chain = &drive.chain;
    let of_teeth = (drive.sprockets.iter()).map(|_| chain.material.contact_modulus());
    let of_guides = drive.guides.iter().map(|guide| {
        let other = guide.material.as_ref().unwrap_or(&chain.material);
        chain.material.contact_modulus_with(other)
    });
    let moduli = of_teeth.chain(of_guides);
    let mut pairs = Vec::new();
    for (s, (wheel, modulus)) in wheels.iter().zip(moduli).enumerate() {
        let guide = s.checked_sub(drive.sprockets.len());
        // On a rail that supports the plates, the contact is between the plate ends (radius plate_height/2) and the rail's own outline.
        let plates = guide.and_then(|g| {
            let rail = &drive.guides[g];
            Some((rail.profile().ok()?, 0.5 * rail.plate_height?))
        });
        let (profile, radius) = match &plates {
            Some((outline, radius)) => (outline, *radius),
            None => (&wheel.profile, chain.contact_radius()),
        };
        pairs.extend(tooth_surfaces(
            profile,
            radius,
            chain.teeth_contact_length(),
            modulus,
        ));
    }
    pairs
}

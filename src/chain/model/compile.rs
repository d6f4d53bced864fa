//! Compilation of a drive and its initial configuration to a `Model`: inertias, wheels, laws with the constants of surface pairs.

use super::coordinates::Coordinates;
use super::rail::place_rail;
use super::range_notes::range_notes;
use super::sprocket::{SprocketModel, place_sprocket};
use super::surface_pairs::SurfacePairs;
use super::{
    ChainBodies, CompiledContactLaw, EndKind, ForceLaws, HingeModel, IMMOVABLE, Model, OpenEnds,
    RollerModel, ToothModel,
};
use crate::drive::{ChainEnd, Drive, HingeKind, Link};
use crate::error::Result;
use crate::force_law::{ForceLaw, PairTable, SurfacePair};
use crate::layout::{InitialConfiguration, check_places, strands};
use crate::math::simd::padded;

impl Model {
    /// Compile a drive with the initial configuration `start`.
    ///
    /// # Errors
    /// When a description is invalid, or a law does not apply to a pair of surfaces.
    pub fn compile(drive: &Drive, laws: &ForceLaws, start: &InitialConfiguration) -> Result<Self> {
        drive.validate()?;
        laws.check(drive.chain.material.restitution)?;
        let chain = &drive.chain;
        let links = drive.hinges();
        check_places(drive, start)?;
        let mut coordinates = Coordinates(3 * links);
        let sprockets = place_wheels(drive, start, &mut coordinates)?;

        let pairs = SurfacePairs::of(drive, &sprockets);
        let ready = |law: ForceLaw, pairs: &[SurfacePair]| CompiledContactLaw {
            elastic: law.elastic,
            pairs: PairTable::prepare(law.elastic, pairs),
            lambda: law.damping.lambda(chain.material.restitution),
            regions: law.regions,
        };
        let rollers = chain.roller.zip(pairs.rollers).map(|(roller, pair)| {
            let count = f64::from(chain.strands);
            RollerModel {
                first: coordinates.0,
                mass: count * roller.mass,
                inertia: count * roller.inertia,
                clearance: roller.clearance(chain.bushing_radius),
                bushing_radius: chain.bushing_radius,
                law: ready(laws.hinge, &[pair]),
            }
        });
        coordinates.0 += 3 * drive.rollers();
        let counts = [links, drive.rollers(), sprockets.len()];
        let bristles = laws.place_bristles(&mut coordinates, counts);
        let ends = OpenEnds::of(drive, start);
        let (pin, clearance) = (chain.hinge.pin_radius, chain.hinge.clearance());
        Ok(Self {
            links,
            coordinates: padded(coordinates.0),
            used_coordinates: coordinates.0,
            half_pitch: 0.5 * chain.pitch,
            chain: ChainBodies::of(drive, ends.as_ref()),
            hinges: HingeModel {
                ideal: drive.hinge_kind == HingeKind::Ideal,
                clearance,
                pin_radius: pin,
                law: ready(laws.hinge, &[pairs.hinges]),
                friction: laws.hinge_friction,
                bristles: laws.hinge_bristles,
                compliance: (chain.link_compliance())
                    .map(|whole| plates_at_hinges(whole, links, ends.as_ref())),
                film: laws.hinge_film.map(|film| {
                    film.of_strands(chain.strands).between(
                        pin,
                        clearance,
                        chain.hinge_contact_length(),
                    )
                }),
            },
            teeth: ToothModel {
                contact_radius: chain.contact_radius(),
                law: ready(laws.tooth, &pairs.teeth),
                friction: laws.tooth_friction,
                bristles: laws.tooth_bristles,
            },
            rollers,
            bristles,
            min_impact_velocity: laws.min_impact_velocity,
            ends,
            gravity: drive.gravity,
            strands: strands(drive),
            guides: drive.guides.len(),
            range_notes: range_notes(drive, laws, &pairs, &sprockets),
            sprockets,
        })
    }
}

impl ChainBodies {
    /// Return the links of `drive`, followed by the bodies at its `ends`.
    fn of(drive: &Drive, ends: Option<&OpenEnds>) -> Self {
        let (bodies, arms) = ring(drive, ends);
        let mass: Vec<f64> = bodies.iter().map(|body| body.mass).collect();
        let inertia: Vec<f64> = bodies.iter().map(|body| body.inertia).collect();
        // The inverse is exactly zero for a body with prescribed motion: no force accelerates it.
        let inverse = |value: &f64| if *value < IMMOVABLE { 1.0 / value } else { 0.0 };
        Self {
            arms,
            inverse_mass: mass.iter().map(inverse).collect(),
            inverse_inertia: inertia.iter().map(inverse).collect(),
            mass,
            inertia,
        }
    }
}

/// Return mass properties and half lengths of the links, followed by those of the two bodies at the ends of an open chain.
fn ring(drive: &Drive, ends: Option<&OpenEnds>) -> (Vec<Link>, Vec<f64>) {
    let chain = &drive.chain;
    let links = 0..chain.links as usize;
    let mut arms: Vec<f64> = chain.link_pitches().iter().map(|p| 0.5 * p).collect();
    let (Some(ends), Some(described)) = (ends, &drive.ends) else {
        return (links.map(|i| chain.link(i)).collect(), arms);
    };
    let mut bodies: Vec<Link> = links.map(|i| chain.strand_link(i)).collect();
    // Order of the bodies in the ring: links, body at the end of the last link, body at the end of the first link.
    for (end, described) in ends.bodies.iter().zip(described).rev() {
        bodies.push(match described {
            ChainEnd::Loaded { mass, inertia, .. } if end.kind == EndKind::Loaded => Link {
                mass: *mass,
                inertia: *inertia,
            },
            _ => Link {
                mass: IMMOVABLE,
                inertia: IMMOVABLE,
            },
        });
        arms.push(described.arm());
    }
    (bodies, arms)
}

/// Return the compliance of the plates at each hinge \[m/N\].
///
/// Each of the two links of a hinge contributes half of its compliance `whole`; the body at an end of an open chain is rigid.
fn plates_at_hinges(whole: f64, hinges: usize, ends: Option<&OpenEnds>) -> Vec<f64> {
    let mut compliance = vec![whole; hinges];
    for end in ends.iter().flat_map(|ends| &ends.bodies) {
        compliance[end.hinge] = 0.5 * whole;
    }
    compliance
}

/// Return the models of the sprockets, followed by those of the guides.
fn place_wheels(
    drive: &Drive,
    start: &InitialConfiguration,
    coordinates: &mut Coordinates,
) -> Result<Vec<SprocketModel>> {
    let mut wheels: Vec<SprocketModel> = Vec::new();
    let mut add = |wheel: SprocketModel| {
        let first_pair = wheels
            .last()
            .map_or(0, |last| last.first_pair + last.profile.surfaces().len());
        wheels.push(SprocketModel {
            first_pair,
            ..wheel
        });
    };
    for (number, sprocket) in drive.sprockets.iter().enumerate() {
        add(place_sprocket(drive, number, sprocket, start, coordinates)?);
    }
    let first = drive.first_wheel() + drive.sprockets.len();
    for (guide, [_, _, angle]) in drive.guides.iter().zip(&start.positions[first..]) {
        add(place_rail(guide, &drive.chain, *angle, || {
            coordinates.take()
        })?);
    }
    Ok(wheels)
}

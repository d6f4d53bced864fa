//! Compilation of a drive and its initial configuration to a `Model`: inertias, coordinates, constants of surface pairs.

use super::bristles::{BristlePlaces, doubts};
use super::rail::place_rail;
use super::{
    ContactLaw, EndKind, Guide, IMMOVABLE, Model, OpenEnds, Ratchet, RollerModel, Rotation,
    SprocketModel, Support,
};
use crate::drive::{
    Bearing, ChainEnd, Drive, InputBounds, Link, STOP_STIFFNESS, Sprocket, SprocketMotion,
};
use crate::error::{Error, Result, check};
use crate::force_law::{
    Elastic, Film, ForceLaw, Friction, LuGre, PairTable, SurfacePair, range_note, tooth_surfaces,
};
use crate::geometry::Vec2;
use crate::layout::{InitialConfiguration, check_places, strands};

/// Force laws of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceLaws {
    /// Normal force of pins in bushings.
    pub hinge: ForceLaw,
    /// Normal force of bushings on teeth.
    pub tooth: ForceLaw,
    /// Friction of pins in bushings; `None`: no friction.
    pub hinge_friction: Option<Friction>,
    /// Friction of bushings on teeth; `None`: no friction.
    pub tooth_friction: Option<Friction>,
    /// Bristle friction of pins in bushings, instead of `hinge_friction`; `None`: no bristles.
    pub hinge_bristles: Option<LuGre>,
    /// Bristle friction of bushings on teeth, instead of `tooth_friction`; `None`: no bristles.
    pub tooth_bristles: Option<LuGre>,
    /// Lubricant film between pins and bushings; `None`: no film.
    pub hinge_film: Option<Film>,
    /// Minimum impact velocity \[m/s\].
    pub min_approach_speed: f64,
}

impl ForceLaws {
    /// Check all laws, for the coefficient of restitution `restitution`.
    fn check(&self, restitution: f64) -> Result<()> {
        check::positive("min_impact_velocity", self.min_approach_speed, "m/s")?;
        for (friction, name) in [
            (&self.hinge_friction, "hinge_friction"),
            (&self.tooth_friction, "tooth_friction"),
        ] {
            friction
                .as_ref()
                .map_or(Ok(()), |friction| friction.check(name))?;
        }
        for (friction, bristles, place) in [
            (&self.hinge_friction, &self.hinge_bristles, "hinge"),
            (&self.tooth_friction, &self.tooth_bristles, "tooth"),
        ] {
            let Some(law) = bristles else { continue };
            law.check(&format!("{place}_bristles"))?;
            if let Some(friction) = friction {
                return Err(Error::invalid(
                    format!("{place}_friction"),
                    friction.coefficient,
                    format!(
                        "must be absent where there are {place}_bristles: a contact has one friction"
                    ),
                ));
            }
        }
        if let Some(film) = &self.hinge_film {
            film.check("hinge_film")?;
        }
        self.hinge.check("Material.restitution", restitution)?;
        self.tooth.check("Material.restitution", restitution)
    }
}

impl ForceLaws {
    /// Allocate the coordinates of the bristles for the given numbers of hinges, rollers, and sprockets with guides.
    fn place_bristles(
        &self,
        coordinates: &mut Coordinates,
        [hinges, rollers, wheels]: [usize; 3],
    ) -> BristlePlaces {
        let many = |law: Option<LuGre>, count: usize| law.map_or(0, |_| count);
        let in_hinges = |count: usize| many(self.hinge_bristles, count);
        let counts = [
            in_hinges(hinges),
            in_hinges(rollers),
            many(self.tooth_bristles, hinges * wheels),
        ];
        let places = BristlePlaces::from(coordinates.0, counts);
        coordinates.0 = places.all().end;
        places
    }
}

impl Default for ForceLaws {
    fn default() -> Self {
        Self {
            hinge: ForceLaw::default(),
            tooth: ForceLaw::default(),
            hinge_friction: None,
            tooth_friction: None,
            hinge_bristles: None,
            tooth_bristles: None,
            hinge_film: None,
            min_approach_speed: 1e-3,
        }
    }
}

/// Counter that allocates generalized coordinates.
struct Coordinates(usize);

impl Coordinates {
    /// Return the next free coordinate.
    fn take(&mut self) -> usize {
        self.0 += 1;
        self.0 - 1
    }
}

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

        let modulus = chain.material.contact_modulus();
        let hinge = &chain.hinge;
        let hinge_pairs = [SurfacePair::internal(
            hinge.pin_radius,
            hinge.bore_radius,
            chain.hinge_contact_length(),
            modulus,
        )];
        let tooth_pairs = tooth_pairs(drive, &sprockets);
        let roller_pairs = chain.roller.map(|roller| {
            [SurfacePair::internal(
                chain.bushing_radius,
                roller.bore_radius,
                f64::from(chain.strands) * roller.length,
                modulus,
            )]
        });
        let mut range_notes = range_notes(
            laws,
            &hinge_pairs,
            &tooth_pairs,
            &sprockets,
            drive.sprockets.len(),
        );
        for pair in roller_pairs.iter().flatten() {
            range_notes.extend(roller_note(laws.hinge.elastic, pair));
        }
        let ready = |law: ForceLaw, pairs: &[SurfacePair]| ContactLaw {
            elastic: law.elastic,
            pairs: PairTable::prepare(law.elastic, pairs),
            lambda: law.damping.lambda(chain.material.restitution),
            regions: law.regions,
        };
        let count = f64::from(chain.strands);
        let rollers = chain.roller.zip(roller_pairs);
        let rollers = rollers.map(|(roller, pairs)| RollerModel {
            first: coordinates.0,
            mass: count * roller.mass,
            inertia: count * roller.inertia,
            clearance: roller.clearance(chain.bushing_radius),
            bushing_radius: chain.bushing_radius,
            law: ready(laws.hinge, &pairs),
        });
        coordinates.0 += 3 * drive.rollers();
        let counts = [links, drive.rollers(), sprockets.len()];
        let bristles = laws.place_bristles(&mut coordinates, counts);
        let ends = OpenEnds::of(drive, start);
        let (bodies, arms) = ring(drive, ends.as_ref());
        let mass: Vec<f64> = bodies.iter().map(|body| body.mass).collect();
        let inertia: Vec<f64> = bodies.iter().map(|body| body.inertia).collect();
        // The inverse is exactly zero for a body with prescribed motion: no force accelerates it.
        let inverse = |value: &f64| if *value < IMMOVABLE { 1.0 / value } else { 0.0 };
        Ok(Self {
            links,
            coordinates: coordinates.0,
            half_pitch: 0.5 * chain.pitch,
            arms,
            inverse_mass: mass.iter().map(inverse).collect(),
            inverse_inertia: inertia.iter().map(inverse).collect(),
            mass,
            inertia,
            clearance: hinge.clearance(),
            pin_radius: hinge.pin_radius,
            contact_radius: chain.contact_radius(),
            rollers,
            hinge_friction: laws.hinge_friction,
            tooth_friction: laws.tooth_friction,
            hinge_bristles: laws.hinge_bristles,
            tooth_bristles: laws.tooth_bristles,
            bristles,
            link_compliance: (chain.link_compliance())
                .map(|whole| plates_at_hinges(whole, links, ends.as_ref())),
            hinge_film: laws.hinge_film.map(|film| {
                let length = chain.hinge_contact_length();
                film.between(hinge.pin_radius, hinge.clearance(), length)
            }),
            hinge_law: ready(laws.hinge, &hinge_pairs),
            tooth_law: ready(laws.tooth, &tooth_pairs),
            min_approach_speed: laws.min_approach_speed,
            ends,
            gravity: drive.gravity,
            strands: strands(drive),
            guides: drive.guides.len(),
            sprockets,
            range_notes,
        })
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
            ChainEnd::Load { mass, inertia, .. } if end.kind == EndKind::Load => Link {
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

/// Return a warning if the law of bushings in rollers is outside its range of validity.
fn roller_note(law: Elastic, pair: &SurfacePair) -> Option<String> {
    let note = range_note(law, pair)?;
    Some(format!("{} law, bushing and roller: {note}", law.name()))
}

/// Return warnings on laws outside their range of validity, one line for each pair of surfaces.
fn range_notes(
    laws: &ForceLaws,
    hinge_pairs: &[SurfacePair],
    tooth_pairs: &[SurfacePair],
    sprockets: &[SprocketModel],
    toothed: usize,
) -> Vec<String> {
    let mut notes: Vec<String> = doubts([laws.hinge_bristles, laws.tooth_bristles]).collect();
    for (law, pairs, name) in [
        (laws.hinge, hinge_pairs, "pin and bushing"),
        (laws.tooth, tooth_pairs, "bushing and"),
    ] {
        for (i, pair) in pairs.iter().enumerate() {
            let Some(note) = range_note(law.elastic, pair) else {
                continue;
            };
            let surface = if pairs.len() > 1 {
                let owner = sprockets.iter().rposition(|s| s.first_pair <= i);
                let number = owner.unwrap_or_default();
                let SprocketModel {
                    profile,
                    first_pair,
                    ..
                } = &sprockets[number];
                let name = profile.surfaces()[i - first_pair].name;
                match number.checked_sub(toothed) {
                    None => format!(" {name} of sprocket {}", number + 1),
                    Some(guide) => format!(" {name} of guide {}", guide + 1),
                }
            } else {
                String::new()
            };
            notes.push(format!(
                "{} law, {name}{surface}: {note}",
                law.elastic.name()
            ));
        }
    }
    notes
}

/// Return the model of sprocket `number` (from 0): profile, mass properties, support and rotation.
fn place_sprocket(
    drive: &Drive,
    number: usize,
    sprocket: &Sprocket,
    start: &InitialConfiguration,
    coordinates: &mut Coordinates,
) -> Result<SprocketModel> {
    let chain = &drive.chain;
    let profile = sprocket.tooth_profile(chain)?;
    let (mass, inertia) = sprocket.mass_properties(chain);
    let [x, y, angle] = start.positions[drive.first_wheel() + number];
    let mut center = Vec2::new(x, y);
    let tensioner = drive.tensioner.filter(|t| t.sprocket == number + 1);
    let support = match (&tensioner, sprocket.bearing) {
        (Some(tensioner), _) => {
            let line = tensioner.line(drive)?;
            let [back, forth] = tensioner.travel;
            // Spring and stops have their origin at the described centre, whatever the initial configuration. A straight guide path
            // passes through the initial centre: its origin is the described centre, shifted across the path.
            let moved = center - sprocket.center;
            center = if line.curvature == 0.0 {
                center - moved.dot(&line.direction) * line.direction
            } else {
                sprocket.center
            };
            Support::Slide {
                index: coordinates.take(),
                direction: line.direction,
                guide: Guide {
                    curvature: line.curvature,
                    stiffness: tensioner.stiffness,
                    stops: [-back, forth],
                    stop_stiffness: STOP_STIFFNESS,
                    extra_mass: tensioner.arm_inertia * line.curvature * line.curvature,
                    ratchet: tensioner.ratchet.map(|step| Ratchet { step, forward: 1.0 }),
                    dashpots: [
                        tensioner.damping_back.unwrap_or(tensioner.damping),
                        tensioner.damping,
                    ],
                },
                pull: line.pull,
                ramp_time: tensioner.ramp_time,
                // Newton's method converges with the larger coefficient, whichever direction the centre moves in.
                damping: tensioner.damping.max(tensioner.damping_back.unwrap_or(0.0)),
            }
        }
        (None, Bearing::Fixed) => Support::Fixed,
        (None, Bearing::Floating) => Support::Floating {
            x: coordinates.take(),
            y: coordinates.take(),
        },
    };
    let rotation = match &sprocket.motion {
        SprocketMotion::PrescribedSpeed(table) => Rotation::Prescribed(table.clone()),
        SprocketMotion::AppliedTorque(table) => Rotation::Free {
            index: coordinates.take(),
            torque: (!table.is_zero()).then(|| table.clone()),
            curve: None,
        },
        SprocketMotion::TorqueCurve { torque, curve } => Rotation::Free {
            index: coordinates.take(),
            torque: (!torque.is_zero()).then(|| torque.clone()),
            curve: Some(curve.clone()),
        },
        SprocketMotion::Free => Rotation::Free {
            index: coordinates.take(),
            torque: None,
            curve: None,
        },
    };
    let gap_directions = (0..profile.teeth)
        .map(|gap| {
            let (sin, cos) = (f64::from(gap) * profile.gap_angle()).sin_cos();
            (cos, sin)
        })
        .collect();
    Ok(SprocketModel {
        side: sprocket.side,
        reach: profile.reach(chain.contact_radius()) + sprocket.faults.eccentricity,
        offset: sprocket.faults.offset(),
        profile,
        first_pair: 0,
        gap_directions,
        mass,
        inertia,
        center,
        phase: angle,
        support,
        rotation,
        swing: None,
        input_bounds: Some(InputBounds::of(chain, sprocket.teeth)),
    })
}

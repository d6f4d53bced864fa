//! Slopes of the contact forces, written by an evaluation for Newton's matrix.
//!
//! n is the normal, t the direction left of it, and e the offset of the two points of a contact. The force is -f n. Its change has
//! two parts: the change of f with penetration, n·de, and rate, and the rotation of n by κ t·de.

use pulp::Simd;

use crate::chain::contact::Candidates;
use crate::chain::model::Model;
use crate::math::simd::{Lanes, Pack8, WIDTH, write};

/// Slopes of the forces of eight contacts; all zero without contact.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SlopeGroup {
    /// n, x and y.
    pub(crate) normal: [Pack8; 2],
    /// Normal force f \[N\].
    pub(crate) force: Pack8,
    /// Slope of f with penetration \[N/m\].
    pub(crate) stiffness: Pack8,
    /// Slope of f with the penetration rate \[N s/m\].
    pub(crate) damping: Pack8,
    /// κ, rotation of the normal per displacement across it \[1/m\].
    pub(crate) curvature: Pack8,
    /// Slopes of the power dissipated by damping with penetration \[W/m\] and penetration rate \[W s/m\], where energy is kept.
    pub(crate) power: [Pack8; 2],
}

/// Slopes of the friction of eight contacts with their sliding velocity, the contact points, and these velocities.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FrictionGroup {
    /// Slope of the friction with the sliding velocity \[N s/m\].
    pub(crate) slope: Pack8,
    /// Position of a hinge's contact point along the normal, relative to the centres of its front and rear ends \[m\].
    pub(crate) places: [Pack8; 2],
    /// Sliding velocity \[m/s\]; not written where no contact of a vector is possible.
    pub(crate) slip: Pack8,
}

/// Slopes of the films of eight hinges, as components along the eccentricity, across it, and mixed; all zero without a film.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FilmGroup {
    /// Direction of the eccentricity, x and y.
    pub(crate) normal: [Pack8; 2],
    /// Slopes with the velocity \[N s/m\].
    pub(crate) damping: [Pack8; 3],
    /// Slopes with the eccentricity \[N/m\].
    pub(crate) stiffness: [Pack8; 3],
    /// One over the change of the velocity that changes the slopes \[s/m\].
    pub(crate) inverse_speed: Pack8,
}

/// Slopes of the contacts of one kind, slot by slot.
#[derive(Debug, Clone)]
pub(crate) struct ContactSlopes {
    /// Slopes of the normal forces.
    pub(crate) normal: Vec<SlopeGroup>,
    /// Slopes of friction; empty where links have no moments.
    pub(crate) friction: Vec<FrictionGroup>,
}

impl ContactSlopes {
    /// Allocate the slopes of `contacts`, `with_friction` or without.
    fn new(contacts: usize, with_friction: bool) -> Self {
        let groups = contacts.div_ceil(WIDTH);
        let with_friction = if with_friction { groups } else { 0 };
        Self {
            normal: vec![SlopeGroup::default(); groups],
            friction: vec![FrictionGroup::default(); with_friction],
        }
    }

    /// Return the groups from `slot` on; those of friction are empty where there are none.
    pub(crate) fn at_slot(&mut self, slot: usize) -> (&mut [SlopeGroup], &mut [FrictionGroup]) {
        let first = slot / WIDTH;
        let friction = self.friction.get_mut(first..).unwrap_or_default();
        (&mut self.normal[first..], friction)
    }
}

/// All slopes that an evaluation writes.
#[derive(Debug, Clone)]
pub(crate) struct Slopes {
    /// Hinges.
    pub(crate) hinges: ContactSlopes,
    /// Contacts between bushings and rollers; empty where rollers are no bodies.
    pub(crate) rollers: ContactSlopes,
    /// Candidates of each sprocket.
    pub(crate) teeth: Vec<ContactSlopes>,
    /// Lubricant films in hinges; empty without lubricant.
    pub(crate) films: Vec<FilmGroup>,
}

impl Slopes {
    /// Allocate the slopes of `model`.
    pub(crate) fn new(model: &Model) -> Self {
        let of = |contacts| ContactSlopes::new(contacts, model.has_moments());
        let slots = Candidates::most_slots(model);
        let films = model.hinges.film.map_or(0, |_| model.links.div_ceil(WIDTH));
        Self {
            hinges: of(model.links),
            rollers: of(model.roller_count()),
            teeth: model.sprockets.iter().map(|_| of(slots)).collect(),
            films: vec![FilmGroup::default(); films],
        }
    }
}

/// Return the group that contains vector `i` of contacts, and the vector's number in the group.
#[inline(always)]
pub(crate) fn group_of<S: Simd, T>(groups: &mut [T], i: usize) -> (&mut T, usize) {
    let parts = WIDTH / S::F64_LANES;
    (&mut groups[i / parts], i % parts)
}

impl SlopeGroup {
    /// Write vector `part`: n, force, slopes with penetration and rate, κ.
    #[inline(always)]
    pub(crate) fn put<S: Simd>(
        &mut self,
        part: usize,
        [nx, ny, force, stiffness, damping, curvature]: [Lanes<S>; 6],
    ) {
        self.normal[0].put(part, nx);
        self.normal[1].put(part, ny);
        self.force.put(part, force);
        self.stiffness.put(part, stiffness);
        self.damping.put(part, damping);
        self.curvature.put(part, curvature);
    }

    /// Write vector `part` of the slopes of the power dissipated.
    #[inline(always)]
    pub(crate) fn put_power<S: Simd>(&mut self, part: usize, power: [Lanes<S>; 2]) {
        write(&mut self.power, part, power);
    }
}

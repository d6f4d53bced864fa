//! Hinges in SIMD vectors: contacts, penetrations and normal forces. The loop serves the hinges between links and the rollers on
//! their bushings.

use pulp::Simd;

use super::ChainFound;
use super::ends::LinkEnd;
use crate::chain::arrays::layout::{ChainArrays, FIRST, LinkConstants};
use crate::chain::arrays::slopes::{ContactSlopes, FilmGroup, FrictionGroup, SlopeGroup, group_of};
use crate::chain::rhs::bristles::{BristleLanes, Bristling};
use crate::force_law::{
    ContactLane, ElasticLaw, FilmLaw, Form, Friction, HingeFilm, RegularizedFriction,
    RestitutionDamping, depth_in_series,
};
use crate::math::simd::{
    Lanes, Mask, Numbers, PartialSums, both, both_mut, load, no_lane, splat_two, vectors,
    vectors_from_mut, vectors_mut,
};

/// Friction in hinges.
#[derive(Clone, Copy)]
pub(crate) struct HingeFriction<'a> {
    pub(crate) law: &'a Friction,
    pub(crate) pin_radius: f64,
}

/// Lubricant in hinges.
pub(crate) struct Lubricant<'a> {
    pub(crate) film: &'a HingeFilm,
    /// Output for its slopes, if requested.
    pub(crate) slopes: Option<&'a mut [FilmGroup]>,
}

/// Input for all hinges of one loop.
pub(crate) struct Joints<'a> {
    /// Form of the elastic law.
    pub(crate) form: Form,
    /// Constants of the elastic law.
    pub(crate) law_constants: [f64; 2],
    /// Radial clearance \[m\].
    pub(crate) clearance: f64,
    /// λ of the damping factor 1 + λ δ'/δ'₀; zero without damping.
    pub(crate) lambda: f64,
    /// Minimum impact velocity \[m/s\].
    pub(crate) minimum: f64,
    /// 1/initial impact velocity of every hinge \[s/m\]; zero without memory.
    pub(crate) inverse_impact_velocity: &'a [f64],
    /// Centres of the bushings, or of the rollers, at the last refresh of the candidates, x and y \[m\].
    pub(crate) reference: &'a [Numbers; 2],
    /// Whether the dissipated powers and their slopes are requested.
    pub(crate) powers: bool,
    /// Output for the slopes of the forces and of friction, if requested.
    pub(crate) slopes: Option<&'a mut ContactSlopes>,
    /// Friction for `FRICTION`; for rollers, the bushings are the pins.
    pub(crate) friction: Option<HingeFriction<'a>>,
    /// Bristles for `BRISTLED`.
    pub(crate) bristles: Option<Bristling<'a>>,
}

/// Hinges of one loop in SIMD vectors.
pub(super) struct Hinges<
    'a,
    S: Simd,
    const DAMPED: bool,
    const FRICTION: bool,
    const BRISTLED: bool,
    const EXTRA: bool,
> {
    form: Form,
    law_constants: [Lanes<S>; 2],
    pub(super) clearance: Lanes<S>,
    damping: RestitutionDamping<Lanes<S>>,
    /// Squared radial clearance \[m²\]; infinite where an open chain is open.
    clearance_squared: &'a [S::f64s],
    /// 1/δ'₀ \[s/m\]; zero without memory.
    inverse_impact_velocity: &'a [S::f64s],
    /// One where the bushing is on the front of its link, else zero.
    pub(super) on_front: &'a [S::f64s],
    /// One for every hinge, zero in the padding and where an open chain is open.
    pub(super) exists: &'a [S::f64s],
    /// Centres of the bushings at the last refresh of the candidates \[m\].
    reference: [&'a [S::f64s]; 2],
    /// Penetration \[m\].
    pub(super) depth: &'a mut [S::f64s],
    /// Normal force \[N\].
    force: &'a mut [S::f64s],
    /// Friction \[N\]; empty without `FRICTION`.
    pub(super) friction: &'a mut [S::f64s],
    /// Force of lubricant on the front ends \[N\]; empty without `EXTRA`.
    pub(super) film_force: [&'a mut [S::f64s]; 2],
    /// Size of the whole force \[N\]; empty without `EXTRA`.
    pub(super) lubricated_force: &'a mut [S::f64s],
    distance_squared: &'a mut [S::f64s],
    along: &'a mut [S::f64s],
    pub(super) front_force: [&'a mut [S::f64s]; 2],
    pub(super) rear_force: [&'a mut [S::f64s]; 2],
    bushing: [&'a mut [S::f64s]; 2],
    bushing_velocity: [&'a mut [S::f64s]; 2],
    moved_squared: Lanes<S>,
    speed_squared: Lanes<S>,
    /// Hinges whose contact state differs from the impact velocity memory. (A sum over masks costs less than one over flags.)
    changed: Mask<S>,
    /// Whether powers are requested.
    pub(super) powers: bool,
    /// Power dissipated by damping \[W\].
    pub(super) power: PartialSums,
    /// Power dissipated by friction \[W\].
    pub(super) friction_power: PartialSums,
    slopes: Option<&'a mut [SlopeGroup]>,
    pub(super) friction_slopes: Option<&'a mut [FrictionGroup]>,
    /// Friction and the pins' radius; `Some` for `FRICTION` without bristles.
    pub(super) regularized: Option<(RegularizedFriction<Lanes<S>>, Lanes<S>)>,
    /// `Some` for `BRISTLED`.
    pub(super) bristles: Option<BristleLanes<'a, S>>,
    /// Moments on fronts and rears \[N m\].
    pub(super) moments: [&'a mut [S::f64s]; 2],
    /// Power dissipated by lubricant \[W\].
    pub(super) film_power: PartialSums,
    pub(super) film_slopes: Option<&'a mut [FilmGroup]>,
    /// `Some` for `EXTRA` with lubricant.
    pub(super) film: Option<FilmLaw<Lanes<S>>>,
    /// `Some` for `EXTRA` with elastic plates.
    pub(super) compliance: Option<&'a [S::f64s]>,
}

impl<'a, S: Simd, const DAMPED: bool, const FRICTION: bool, const BRISTLED: bool, const EXTRA: bool>
    Hinges<'a, S, DAMPED, FRICTION, BRISTLED, EXTRA>
{
    /// Return the hinges of these joints, and cosines and sines of the links, which are borrowed apart from the other arrays.
    /// [`Self::attach_optional_forces`] adds lubricant and elastic plates.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        joints: Joints<'a>,
        constants: &'a LinkConstants,
        arrays: &'a mut ChainArrays,
        blocks: usize,
    ) -> (Self, [&'a [f64]; 2]) {
        let splat = |value| Lanes::splat(simd, value);
        let (slopes, friction_slopes) = joints.slopes.map(|slopes| slopes.at_slot(0)).unzip();
        let mut hinges = Self {
            form: joints.form,
            law_constants: splat_two(simd, joints.law_constants),
            clearance: splat(joints.clearance),
            damping: RestitutionDamping {
                lambda: splat(joints.lambda),
                minimum: splat(joints.minimum),
            },
            clearance_squared: vectors::<S>(&constants.clearance_squared, blocks),
            inverse_impact_velocity: vectors::<S>(joints.inverse_impact_velocity, blocks),
            on_front: vectors::<S>(&constants.bushing_on_front, blocks),
            exists: vectors::<S>(&constants.exists, blocks),
            reference: both::<S>(joints.reference, 0, blocks),
            depth: vectors_mut::<S>(&mut arrays.depth, blocks),
            force: vectors_mut::<S>(&mut arrays.force, blocks),
            distance_squared: vectors_mut::<S>(&mut arrays.distance_squared, blocks),
            along: vectors_mut::<S>(&mut arrays.along, blocks),
            moments: [&mut [], &mut []],
            friction: &mut [],
            film_force: [&mut [], &mut []],
            lubricated_force: &mut [],
            front_force: both_mut::<S>(&mut arrays.front_force, 0, blocks),
            rear_force: both_mut::<S>(&mut arrays.rear_force, FIRST + 1, blocks),
            bushing: both_mut::<S>(&mut arrays.bushing, 0, blocks),
            bushing_velocity: both_mut::<S>(&mut arrays.bushing_velocity, 0, blocks),
            moved_squared: splat(0.0),
            speed_squared: splat(0.0),
            changed: no_lane(simd),
            powers: joints.powers,
            power: PartialSums::default(),
            friction_power: PartialSums::default(),
            slopes,
            friction_slopes: None,
            regularized: None,
            bristles: None,
            film_power: PartialSums::default(),
            film_slopes: None,
            film: None,
            compliance: None,
        };
        if EXTRA {
            hinges.film_force = both_mut::<S>(&mut arrays.film, 0, blocks);
            hinges.lubricated_force = vectors_mut::<S>(&mut arrays.lubricated_force, blocks);
        }
        if FRICTION {
            hinges.friction = vectors_mut::<S>(&mut arrays.friction, blocks);
            hinges.moments = [
                vectors_mut::<S>(&mut arrays.front_moment, blocks),
                vectors_from_mut::<S>(&mut arrays.rear_moment, FIRST + 1, blocks),
            ];
        }
        if BRISTLED && let Some(bristles) = joints.bristles {
            hinges.friction_slopes = friction_slopes;
            hinges.bristles = Some(bristles.into_lanes(simd, blocks));
        } else if FRICTION && let Some(friction) = joints.friction {
            hinges.friction_slopes = friction_slopes;
            hinges.regularized = Some((
                RegularizedFriction::new(simd, friction.law),
                splat(friction.pin_radius),
            ));
        }
        (hinges, [&arrays.cos, &arrays.sin])
    }

    /// Attach lubricant and elastic plates, where there are any.
    #[inline(always)]
    pub(super) fn attach_optional_forces(
        &mut self,
        lubricant: Option<Lubricant<'a>>,
        compliance: Option<&'a [f64]>,
    ) {
        let simd = self.clearance.simd();
        if EXTRA && let Some(compliance) = compliance {
            self.compliance = Some(vectors::<S>(compliance, self.inverse_impact_velocity.len()));
        }
        if EXTRA && let Some(lubricant) = lubricant {
            self.film = Some(FilmLaw::new(simd, lubricant.film));
            self.film_slopes = lubricant.slopes;
        }
    }

    /// Return the results besides the forces.
    #[inline(always)]
    pub(super) fn found(&self) -> ChainFound {
        let powers = self.powers;
        ChainFound {
            moved_squared: self.moved_squared.greatest(),
            speed_squared: self.speed_squared.greatest(),
            changed: self.changed.any(),
            dissipated: self.power.total_if(powers && DAMPED),
            friction_power: self.friction_power.total_if(powers && FRICTION),
            film_power: self.film_power.total_if(powers && EXTRA),
        }
    }

    /// Evaluate one vector of hinges; return whether contact is possible in any of them.
    #[inline(always)]
    pub(super) fn evaluate(&mut self, i: usize, front: &LinkEnd<S>, rear: &LinkEnd<S>) -> bool {
        let simd = self.clearance.simd();
        let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
        self.place_bushings(i, front, rear);
        // Offset e of the front end of link k from the rear end of link k + 1; contact for |e| > clearance. It is plus or minus the
        // eccentricity of the pin; δ, δ' and the forces on the two ends are the same for both signs.
        let (ex, ey) = (front.x - rear.x, front.y - rear.y);
        let distance_squared = ex.mul_add(ex, ey * ey);
        let velocity = [front.vx - rear.vx, front.vy - rear.vy];
        self.distance_squared[i] = distance_squared.values();
        self.along[i] = ex.mul_add(velocity[0], ey * velocity[1]).values();
        let near = distance_squared.exceeds(load(simd, &self.clearance_squared[i]));
        let inverse_impact_velocity = load(simd, &self.inverse_impact_velocity[i]);
        let has_memory = inverse_impact_velocity.greater(zero);
        if !near.any() {
            self.changed = self.changed.or(has_memory);
            self.write_apart(i, zero);
            if EXTRA {
                self.add_film(i, [front, rear], [ex, ey], velocity, distance_squared);
            }
            return false;
        }
        let distance = distance_squared.sqrt();
        let inverse_distance = near.select(one / distance, zero);
        let depth = near.select((distance - self.clearance).positive_part(), zero);
        let (nx, ny) = (ex * inverse_distance, ey * inverse_distance);
        let touching = depth.exceeds(zero);
        // A contact without memory begins in this step, a memory without contact ends: finish_step looks for the event. Forces of this
        // step use the present rate (ContactLane::damped).
        self.changed = self.changed.or(touching.differs(has_memory));
        let mut contact_depth = depth;
        // Contact and plates in series: the contact's own penetration.
        if EXTRA && let Some(compliance) = self.compliance {
            let compliance = load(simd, &compliance[i]);
            contact_depth = depth_in_series(self.form, self.law_constants, compliance, depth);
        }
        let [elastic, root] = self
            .form
            .elastic_and_root(self.law_constants, contact_depth);
        // f = f_e(δ) max(0, 1 + λ δ'/δ'₀).
        let contact = if DAMPED {
            let rate = nx.mul_add(velocity[0], ny * velocity[1]);
            ContactLane::damped(
                elastic,
                touching,
                rate,
                inverse_impact_velocity,
                self.damping,
            )
        } else {
            ContactLane::undamped(elastic)
        };
        let force = contact.force;
        if DAMPED && self.powers {
            self.power.add(i, contact.power());
        }
        if let Some(slopes) = &mut self.slopes {
            let mut elastic_slope =
                self.form
                    .slope(self.law_constants, contact_depth, [elastic, root]);
            if EXTRA && let Some(compliance) = self.compliance {
                // Series of stiffness k and compliance c: k/(1 + c k).
                let compliance = load(simd, &compliance[i]);
                elastic_slope = elastic_slope / compliance.mul_add(elastic_slope, one);
            }
            let [stiffness, damping] = contact.slopes(elastic_slope);
            let entries = [nx, ny, force, stiffness, damping, inverse_distance];
            let (group, part) = group_of::<S, _>(slopes, i);
            group.put(part, entries);
            if self.powers {
                let power = contact.power_slopes(elastic_slope, [stiffness, damping]);
                group.put_power(part, power);
            }
        }
        let mut pull = [force * nx, force * ny];
        if FRICTION {
            pull = self.add_friction(i, [front, rear], ([nx, ny], depth), velocity, force);
        }
        self.write_contact(i, [depth, force, pull[0], pull[1]]);
        if EXTRA {
            self.add_film(i, [front, rear], [ex, ey], velocity, distance_squared);
        }
        true
    }

    /// Write penetration, normal force, and the force vector, which acts on the rear ends and with opposite sign on the front ends.
    #[inline(always)]
    fn write_contact(&mut self, i: usize, [depth, force, x, y]: [Lanes<S>; 4]) {
        self.depth[i] = depth.values();
        self.force[i] = force.values();
        self.front_force[0][i] = (-x).values();
        self.front_force[1][i] = (-y).values();
        self.rear_force[0][i] = x.values();
        self.rear_force[1][i] = y.values();
    }

    /// Write `zero` for a vector of hinges without contact.
    #[inline(always)]
    fn write_apart(&mut self, i: usize, zero: Lanes<S>) {
        self.write_contact(i, [zero; 4]);
        if let Some(slopes) = &mut self.slopes {
            let (group, part) = group_of::<S, _>(slopes, i);
            group.put(part, [zero; 6]);
            if self.powers {
                group.put_power(part, [zero; 2]);
            }
        }
        if FRICTION {
            self.friction[i] = zero.values();
            if let Some(slopes) = &mut self.friction_slopes {
                let (group, part) = group_of::<S, _>(slopes, i);
                group.slope.put(part, zero);
            }
        }
        if BRISTLED && let Some(bristles) = &mut self.bristles {
            bristles.clear_rates(i);
        }
    }

    /// Write centres and velocities of the bushings of these hinges; update their largest squared distance from the references,
    /// and their largest squared speed. Lanes behind the last hinge have neither.
    #[inline(always)]
    fn place_bushings(&mut self, i: usize, front: &LinkEnd<S>, rear: &LinkEnd<S>) {
        let simd = self.clearance.simd();
        let on_front = load(simd, &self.on_front[i]).greater(Lanes::splat(simd, 0.0));
        let x = on_front.select(front.x, rear.x);
        let y = on_front.select(front.y, rear.y);
        self.bushing[0][i] = x.values();
        self.bushing[1][i] = y.values();
        let dx = x - load(simd, &self.reference[0][i]);
        let dy = y - load(simd, &self.reference[1][i]);
        self.moved_squared = self.moved_squared.max(dx.mul_add(dx, dy * dy));
        let vx = on_front.select(front.vx, rear.vx);
        let vy = on_front.select(front.vy, rear.vy);
        self.bushing_velocity[0][i] = vx.values();
        self.bushing_velocity[1][i] = vy.values();
        self.speed_squared = self.speed_squared.max(vx.mul_add(vx, vy * vy));
    }
}

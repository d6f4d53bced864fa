//! The right-hand side of the kernels beside the scalar reference implementation, difference by difference over its rounding.
//!
//! A depth is a small difference of large numbers: its error counts in units in the last place of the largest coordinate it
//! comes from, called the grain of the contact. Directions are wrong by grain over distance of centres, rates by that times
//! the speed, forces by what depth and rate make of them; the rest is counted in units of the quantity itself. All sums below are
//! those of first order with every rounding taken as one unit; the ratios say how many units it were.

use rustchain::chain::dynamics::Dynamics;
use rustchain::chain::model::{Rotation, Support};
use rustchain::force_law::PairTable;
use rustchain::geometry::{SurfaceCurve, Vec2};
use rustchain::integrator::OdeSystem;
use rustchain::system::System;

use super::checks::{elastic, impact_velocity};
use super::scalar_reference::{Contact, Reference, ToothContact};

const UNIT: f64 = f64::EPSILON;

/// How many roundings lie between kernels and reference, the most of all contacts or bodies.
#[derive(Debug, Clone, Copy, Default)]
pub struct Agreement {
    /// Contacts that touch.
    pub touching: usize,
    /// Depths of hinges and of teeth, in grains.
    pub hinge_depth: f64,
    pub tooth_depth: f64,
    /// Elastic forces at the depths that the kernels found, in units of their own; undamped laws only.
    pub elastic: f64,
    /// Normal forces, over their first-order error.
    pub force: f64,
    /// Accelerations of links and loads on sprockets, over theirs.
    pub link: f64,
    pub sprocket: f64,
    /// Power dissipated in contacts, over its.
    pub power: f64,
}

impl Agreement {
    pub fn values(&self) -> [f64; 7] {
        [
            self.hinge_depth,
            self.tooth_depth,
            self.elastic,
            self.force,
            self.link,
            self.sprocket,
            self.power,
        ]
    }
}

/// Error of `force` at `depth` \[N\]: that of the two roundings of a law, with fused multiply-add and without; steep near the end of
/// a law's range.
fn law_error(table: &PairTable, pair: usize, depth: f64, force: f64) -> f64 {
    let to_end = (1.0 - depth / table.pair(pair).range_end()).max(UNIT);
    UNIT * force * (1.0 + 0.5 / to_end.sqrt())
}

/// One contact of the reference, and its first-order errors for one unit each.
#[derive(Debug, Clone, Copy)]
struct Errors {
    grain: f64,
    force: f64,
    /// Of the normal force \[N\].
    force_error: f64,
    /// Of any of its components \[N\].
    vector_error: f64,
    /// Of the power that it dissipates \[W\].
    power_error: f64,
}

struct Found {
    depth: f64,
    rate: f64,
    force: f64,
    /// Distance of the centres.
    distance: f64,
    /// Largest coordinate and speed.
    size: f64,
    speed: f64,
    onset: f64,
    lambda: f64,
}

impl Found {
    fn errors(&self, law: impl Fn(f64) -> f64) -> Errors {
        let grain = UNIT * self.size;
        let direction = UNIT + grain / self.distance.max(grain);
        let rate_error = 2.0 * self.speed * direction;
        let factor = (1.0 + self.lambda * self.rate / self.onset).max(0.0);
        // The floor of the factor hides errors of rates beside it.
        let factor_error = self.lambda * rate_error / self.onset
            + UNIT * (1.0 + (self.lambda * self.rate / self.onset).abs());
        let at = law(self.depth.max(0.0));
        let steep = law(self.depth.max(0.0) + grain) - law((self.depth - grain).max(0.0));
        let force_error =
            steep * (factor + factor_error) + (at + steep) * factor_error + UNIT * self.force;
        let elastic_error = steep + UNIT * at;
        Errors {
            grain,
            force: self.force,
            force_error,
            vector_error: force_error + self.force * direction,
            power_error: (force_error + elastic_error) * (self.rate.abs() + rate_error)
                + (self.force - at).abs() * rate_error
                + UNIT * (self.force + at) * self.rate.abs(),
        }
    }
}

/// |a - b| in units of `error`; equal numbers, also infinite ones, differ by none.
fn ratio(a: f64, b: f64, error: f64) -> f64 {
    if a == b || (a.is_nan() && b.is_nan()) {
        0.0
    } else if a.is_nan() || b.is_nan() {
        f64::INFINITY
    } else {
        (a - b).abs() / error.max(f64::MIN_POSITIVE)
    }
}

/// Evaluates kernels and reference at one state.
pub fn compare(dynamics: &mut Dynamics, t: f64, y: &[f64]) -> Agreement {
    let mut dydt = vec![0.0; y.len()];
    dynamics.derivative(t, y, &mut dydt);
    let found = dynamics.powers(t, y).losses.values();
    let reference = Reference::of(dynamics, t, y);
    dynamics.evaluate(t, y);
    let model = dynamics.model().clone();
    let (n, nq) = (model.links, model.coordinates);
    assert_eq!(dydt[..nq], y[nq..2 * nq]);
    let mut all = Agreement::default();

    let hinges: Vec<Errors> = (0..n)
        .map(|k| hinge_errors(dynamics, &reference, k))
        .collect();
    for (k, ((depth, force), errors)) in dynamics.hinge_contacts().zip(&hinges).enumerate() {
        let expected = reference.hinges[k].penetration.max(0.0);
        all.touching += usize::from(depth > 0.0);
        all.hinge_depth = all.hinge_depth.max(ratio(depth, expected, errors.grain));
        all.force = all
            .force
            .max(ratio(force, errors.force, errors.force_error));
        if model.hinges.law.lambda == 0.0 {
            let law = elastic(&model.hinges.law.pairs, 0, 0.0, depth);
            let error = law_error(&model.hinges.law.pairs, 0, depth, law);
            all.elastic = all.elastic.max(ratio(force, law, error));
        }
    }

    let rollers: Vec<Errors> = (0..model.roller_count())
        .map(|k| roller_errors(dynamics, &reference, k))
        .collect();
    assert_eq!(dynamics.roller_contacts().count(), rollers.len());
    for (k, ((depth, force), errors)) in dynamics.roller_contacts().zip(&rollers).enumerate() {
        let expected = reference.rollers[k].penetration.max(0.0);
        all.touching += usize::from(depth > 0.0);
        all.hinge_depth = all.hinge_depth.max(ratio(depth, expected, errors.grain));
        all.force = all
            .force
            .max(ratio(force, errors.force, errors.force_error));
    }

    let near = reference.teeth.iter().enumerate();
    let teeth: Vec<Option<Errors>> = near
        .map(|(pair, tooth)| tooth.map(|tooth| tooth_errors(dynamics, &reference, pair, &tooth)))
        .collect();
    let mut seen = vec![false; teeth.len()];
    for (s, k, depth, force) in dynamics.candidates() {
        let pair = s * n + k;
        seen[pair] = true;
        let Some(errors) = teeth[pair] else {
            assert!(
                depth == 0.0 && force == 0.0,
                "beyond reach: {depth:e} m, {force:e} N"
            );
            continue;
        };
        let expected = depth_of(&reference, pair).max(0.0);
        all.touching += usize::from(depth > 0.0);
        all.tooth_depth = all.tooth_depth.max(ratio(depth, expected, errors.grain));
        all.force = all
            .force
            .max(ratio(force, errors.force, errors.force_error));
        if model.teeth.law.lambda == 0.0 {
            let surface = reference.teeth[pair].unwrap().stiffness_surface;
            let number = model.tooth_pair(s, surface);
            let law = elastic(&model.teeth.law.pairs, number, 0.0, depth);
            let error = law_error(&model.teeth.law.pairs, number, depth, law);
            all.elastic = all.elastic.max(ratio(force, law, error));
        }
    }
    for (pair, seen) in seen.into_iter().enumerate() {
        let looked_at = seen || depth_of(&reference, pair) <= 0.0;
        assert!(looked_at, "pair {pair} was not looked at");
    }

    compare_links(
        dynamics,
        &reference,
        &hinges,
        &rollers,
        &teeth,
        &dydt[nq..],
        &mut all,
    );
    compare_rollers(
        dynamics,
        &reference,
        &rollers,
        &teeth,
        &dydt[nq..2 * nq],
        &mut all,
    );
    compare_sprockets(dynamics, &reference, &teeth, &dydt[nq..2 * nq], &mut all);
    if dynamics.keeps_energy() {
        let dissipated = reference.losses.values().iter().sum::<f64>();
        let mut error = UNIT * dissipated.abs();
        for errors in hinges.iter().chain(&rollers).chain(teeth.iter().flatten()) {
            error += errors.power_error;
        }
        all.power = ratio(found.iter().sum(), dissipated, error);
    }
    all
}

fn hinge_errors(dynamics: &Dynamics, reference: &Reference, k: usize) -> Errors {
    let (model, motion) = (dynamics.model(), &reference.motion);
    let Contact {
        penetration,
        rate,
        force,
        ..
    } = reference.hinges[k];
    let next = (k + 1) % model.links;
    let size = [k, next].map(|i| motion.x[i].abs().max(motion.y[i].abs()));
    let speed = [k, next].map(|i| {
        motion.vx[i].abs().max(motion.vy[i].abs()) + model.half_pitch * motion.spin[i].abs()
    });
    Found {
        depth: penetration,
        rate,
        force,
        distance: penetration + model.hinges.clearance,
        size: size[0].max(size[1]) + model.half_pitch,
        speed: speed[0].max(speed[1]),
        onset: impact_velocity(model, dynamics.memory.hinge_impact_velocity()[k], rate),
        lambda: model.hinges.law.lambda,
    }
    .errors(|depth| elastic(&model.hinges.law.pairs, 0, 0.0, depth))
}

fn roller_errors(dynamics: &Dynamics, reference: &Reference, k: usize) -> Errors {
    let (model, motion) = (dynamics.model(), &reference.motion);
    let Contact {
        penetration,
        rate,
        force,
        ..
    } = reference.rollers[k];
    let rollers = model.rollers.as_ref().unwrap();
    let bodies = [model.link_of_bushing(k), model.links + k];
    let size = bodies.map(|i| motion.x[i].abs().max(motion.y[i].abs()));
    let speed = bodies.map(|i| {
        motion.vx[i].abs().max(motion.vy[i].abs()) + model.half_pitch * motion.spin[i].abs()
    });
    Found {
        depth: penetration,
        rate,
        force,
        distance: penetration + rollers.clearance,
        size: size[0].max(size[1]) + model.half_pitch,
        speed: speed[0].max(speed[1]),
        onset: impact_velocity(model, dynamics.memory.roller_impact_velocity()[k], rate),
        lambda: rollers.law.lambda,
    }
    .errors(|depth| elastic(&rollers.law.pairs, 0, 0.0, depth))
}

fn depth_of(reference: &Reference, pair: usize) -> f64 {
    reference.teeth[pair].map_or(f64::NEG_INFINITY, |tooth| tooth.contact.penetration)
}

fn tooth_errors(
    dynamics: &Dynamics,
    reference: &Reference,
    pair: usize,
    tooth: &ToothContact,
) -> Errors {
    let (model, motion) = (dynamics.model(), &reference.motion);
    let (s, k) = (pair / model.links, pair % model.links);
    let profile = &model.sprockets[s].profile;
    let ([bushing, velocity], turning) = reference.on_teeth(model, k);
    let body = model.wheel_body(s);
    let Contact {
        penetration: depth,
        rate,
        force,
        ..
    } = tooth.contact;
    let radius = model.teeth.contact_radius;
    let distance = match profile.surfaces()[tooth.surface.index()].curve {
        SurfaceCurve::Concave(arc) => depth + arc.radius - radius,
        SurfaceCurve::Straight(_) => f64::INFINITY,
        SurfaceCurve::Convex(arc) => arc.radius + radius - depth,
    };
    let number = model.tooth_pair(s, tooth.stiffness_surface);
    let reach = model.sprockets[s].reach;
    Found {
        depth,
        rate,
        force,
        distance,
        size: bushing
            .amax()
            .max(motion.x[body].abs())
            .max(motion.y[body].abs())
            + reach,
        speed: velocity.amax()
            + motion.vx[body].abs().max(motion.vy[body].abs())
            + reach * motion.spin[body].abs()
            + model.half_pitch * motion.spin[turning].abs(),
        onset: impact_velocity(model, dynamics.memory.tooth_impact_velocity[pair], rate),
        lambda: model.teeth.law.lambda,
    }
    .errors(|depth| elastic(&model.teeth.law.pairs, number, 0.0, depth))
}

fn compare_links(
    dynamics: &Dynamics,
    reference: &Reference,
    hinges: &[Errors],
    rollers: &[Errors],
    teeth: &[Option<Errors>],
    accelerations: &[f64],
    all: &mut Agreement,
) {
    let (model, [x, y, angle]) = (dynamics.model(), &reference.accelerations);
    let n = model.links;
    for i in 0..n {
        let before = (i + n - 1) % n;
        let mut error = 0.0;
        for k in [i, before] {
            let contact = hinges[k];
            error += contact.vector_error + UNIT * contact.force;
            if model.link_of_bushing(k) != i {
                continue;
            }
            if let Some(roller) = rollers.get(k) {
                error += roller.vector_error + UNIT * roller.force;
            } else {
                for errors in (0..model.sprockets.len()).filter_map(|s| teeth[s * n + k]) {
                    error += errors.vector_error + UNIT * errors.force;
                }
            }
        }
        let linear = error * model.chain.inverse_mass[i] + UNIT * model.gravity.amax();
        let angular = error * 2.0 * model.half_pitch * model.chain.inverse_inertia[i];
        all.link = all
            .link
            .max(ratio(accelerations[i], x[i], linear))
            .max(ratio(accelerations[n + i], y[i], linear))
            .max(ratio(accelerations[2 * n + i], angle[i], angular));
    }
}

fn compare_rollers(
    dynamics: &Dynamics,
    reference: &Reference,
    rollers: &[Errors],
    teeth: &[Option<Errors>],
    accelerations: &[f64],
    all: &mut Agreement,
) {
    let (model, [x, y, angle]) = (dynamics.model(), &reference.accelerations);
    let Some(of) = &model.rollers else {
        return;
    };
    let n = model.links;
    for (k, roller) in rollers.iter().enumerate() {
        let mut error = roller.vector_error + UNIT * roller.force;
        for errors in (0..model.sprockets.len()).filter_map(|s| teeth[s * n + k]) {
            error += errors.vector_error + UNIT * errors.force;
        }
        let linear = error / of.mass + UNIT * model.gravity.amax();
        let (at_x, at_y) = (of.first + k, of.first + n + k);
        all.link = all
            .link
            .max(ratio(accelerations[at_x], x[n + k], linear))
            .max(ratio(accelerations[at_y], y[n + k], linear));
        // Without friction nothing turns them.
        assert_eq!(accelerations[of.first + 2 * n + k], angle[n + k]);
    }
}

/// Errors of the force \[N\] and of the moment \[N m\] on sprocket `s`.
fn sprocket_errors(dynamics: &Dynamics, teeth: &[Option<Errors>], s: usize) -> (f64, f64) {
    let model = dynamics.model();
    let n = model.links;
    let (mut force_error, mut moment_error, mut sum) = (0.0, 0.0, 0.0);
    for errors in teeth[s * n..(s + 1) * n].iter().flatten() {
        // Each sum so far is rounded once more.
        sum += errors.force;
        force_error += errors.vector_error + UNIT * sum;
        moment_error += errors.force * errors.grain;
    }
    (
        force_error,
        moment_error + force_error * model.sprockets[s].reach,
    )
}

/// What readers are given of the sprockets, and the accelerations of their coordinates, which follow from it.
fn compare_sprockets(
    dynamics: &Dynamics,
    reference: &Reference,
    teeth: &[Option<Errors>],
    accelerations: &[f64],
    all: &mut Agreement,
) {
    let (model, found) = (dynamics.model(), &dynamics.evaluated.accelerations);
    // Sums over the same teeth, perhaps in another order.
    let same = |index: usize, expected: f64, error: f64| {
        let error = error + 1e2 * UNIT * expected.abs();
        let off = ratio(accelerations[index], expected, error);
        assert!(off <= 1.0, "{} for {expected}", accelerations[index]);
    };
    for (s, sprocket) in model.sprockets.iter().enumerate() {
        let body = model.wheel_body(s);
        let (force_error, moment_error) = sprocket_errors(dynamics, teeth, s);
        let (load, expected) = (found.chain[s], reference.loads[s]);
        for (own, other) in [
            (load.force.x, expected.force.x),
            (load.force.y, expected.force.y),
        ] {
            all.sprocket = all.sprocket.max(ratio(own, other, force_error));
        }
        all.sprocket = (all.sprocket).max(ratio(load.moment, expected.moment, moment_error));
        let linear = force_error / sprocket.mass;
        let along = |direction: Vec2| direction.x * found.x[body] + direction.y * found.y[body];
        match sprocket.support {
            Support::Fixed => {}
            Support::Slide { index, .. } => {
                let center = Vec2::new(reference.motion.x[body], reference.motion.y[body]);
                same(index, along(sprocket.slide_at(center).unwrap().1), linear);
            }
            Support::Floating { x, y } => {
                same(x, found.x[body], linear);
                same(y, found.y[body], linear);
            }
        }
        if let Rotation::Free { index, .. } = sprocket.rotation {
            same(index, found.angle[body], moment_error / sprocket.inertia);
        }
    }
}

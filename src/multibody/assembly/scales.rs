//! Numbers whose sizes do not go together, as after a change of units by 1000: inertia beside mass and size, masses, points
//! and radii beside each other.
//!
//! A body whose points are r from its centre of mass has about m r²/3, as a bar; what is off by a factor that only a unit
//! explains is told with the body, the value, what would be expected, and the factor.

use super::load_scales::odd_loads;
use crate::multibody::description::profile::Profile;
use crate::multibody::model::MechanismModel;

/// Inertia over m r² above which a body is too large for its mechanism, and below which too compact for its points.
const WIDE: f64 = 30.0;
const COMPACT: f64 = 1e-3;
/// Radius of gyration that a body may have beside the size of the mechanism.
const OF_SIZE: f64 = 0.3;
/// How far a body may be from the typical other one: in inertia over m r², in mass, in its points.
const BESIDE_INERTIA: f64 = 100.0;
const BESIDE_MASS: f64 = 300.0;
const BESIDE_POINTS: f64 = 200.0;
/// Radii of circles beside the size of the mechanism.
const RADII: [f64; 2] = [1e-4, 30.0];
/// Gravity on bodies of this world \[m/s²\].
const GRAVITY: [f64; 2] = [0.05, 100.0];

/// All that seems to be in another unit than the rest.
pub(crate) fn odd_scales(model: &MechanismModel) -> Vec<String> {
    let scales = Scales::of(model);
    let bodies = (1..model.bodies.len()).filter(|&i| !model.bodies[i].fixed);
    let of_bodies = bodies.filter_map(|i| {
        scales
            .odd_points(model, i)
            .or_else(|| scales.odd_inertia(model, i))
            .or_else(|| scales.odd_mass(model, i))
    });
    let of_contacts = (0..model.contacts.len()).filter_map(|k| scales.odd_radii(model, k));
    of_gravity(model)
        .into_iter()
        .chain(scales.odd_masses(model))
        .chain(of_bodies)
        .chain(of_contacts)
        .chain(odd_loads(model, scales.size, |k| {
            scales.odd_radii(model, k).is_none()
        }))
        .collect()
}

fn of_gravity(model: &MechanismModel) -> Option<String> {
    let gravity = model.gravity.norm();
    (gravity > 0.0 && !(GRAVITY[0]..GRAVITY[1]).contains(&gravity)).then(|| {
        format!(
            "gravity is {gravity:.4e} m/s^2, about 9.81 would be expected: {}",
            factor(gravity / 9.81)
        )
    })
}

/// Sizes that others are held against.
struct Scales {
    /// Farthest point of each body from its centre of mass \[m\]; zero where all are at it.
    reach: Vec<f64>,
    /// Inertia over m r²; NaN where one of them is zero.
    compactness: Vec<f64>,
    /// Farthest point of the mechanism from another \[m\].
    size: f64,
}

impl Scales {
    fn of(model: &MechanismModel) -> Self {
        let frames = model.start_frames();
        let mut reach = vec![0.0f64; model.bodies.len()];
        let mut ends = Vec::new();
        for equation in &model.equations {
            ends.extend([equation.a, equation.b]);
        }
        for force in &model.forces {
            ends.extend([force.a, force.b]);
        }
        for contact in &model.contacts {
            ends.extend([contact.a, contact.b]);
        }
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for end in ends {
            reach[end.body] = reach[end.body].max(end.point.norm());
            let place = frames[end.body].place(end.point);
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis]);
            }
        }
        let compactness = model.bodies.iter().zip(&reach).map(|(body, r)| {
            let ratio = body.inertia / (body.mass * r * r);
            if ratio.is_finite() && ratio > 0.0 {
                ratio
            } else {
                f64::NAN
            }
        });
        let size = (high[0] - low[0]).hypot(high[1] - low[1]);
        let widest = reach.iter().copied().fold(0.0, f64::max);
        Self {
            compactness: compactness.collect(),
            size: if size.is_finite() {
                size.max(widest)
            } else {
                0.0
            },
            reach,
        }
    }

    /// A body whose inertia does not belong to its mass and its points.
    fn odd_inertia(&self, model: &MechanismModel, i: usize) -> Option<String> {
        let (body, reach, ratio) = (&model.bodies[i], self.reach[i], self.compactness[i]);
        let typical = median(model, i, ratio, |k| self.compactness[k]);
        let gyration = (body.inertia / body.mass).sqrt();
        let wide =
            ratio > WIDE && (gyration > OF_SIZE * self.size || ratio > BESIDE_INERTIA * typical);
        let compact = ratio < COMPACT && (typical.is_nan() || ratio < typical / BESIDE_INERTIA);
        // Beside the other bodies it may show that it is the mass, which is told instead.
        let by_mass = self.mass_ratio(model, i);
        let is_mass = if wide {
            by_mass < 1.0 / BESIDE_MASS
        } else {
            by_mass > BESIDE_MASS
        };
        (!is_mass && (wide || compact)).then(|| {
            let expected = body.mass * reach * reach / 3.0;
            let mass = if wide { "small" } else { "large" };
            format!(
                "inertia of body {:?} is {:.4e} kg m^2: with its mass of {:.4e} kg and points up to {reach:.4e} m from \
                 its centre of mass, about {expected:.1e} kg m^2 would be expected: is it {}, or the mass as many times \
                 too {mass}, in another unit?",
                body.name,
                body.inertia,
                body.mass,
                times(body.inertia / expected)
            )
        })
    }

    /// Masses that are all too large for inertias and points: of each body alone the others would say that it is as they are.
    fn odd_masses(&self, model: &MechanismModel) -> Option<String> {
        let known = (1..model.bodies.len()).filter(|&i| !model.bodies[i].fixed);
        let ratios: Vec<f64> = known
            .map(|i| self.compactness[i])
            .filter(|ratio| ratio.is_finite())
            .collect();
        let most = ratios.iter().copied().fold(0.0, f64::max);
        (ratios.len() > 1 && most < COMPACT).then(|| {
            format!(
                "inertias of all bodies are below {most:.1e} of mass times the square of their farthest points' distance \
                 from the centre of mass, a third would be expected: are the masses 1000 times too large, in another \
                 unit, or the inertias 1000 times too small?"
            )
        })
    }

    /// Mass over the square of the size \[kg/m²\]; NaN for a body whose points are all at its centre of mass.
    fn density(&self, model: &MechanismModel, i: usize) -> f64 {
        let (body, reach) = (&model.bodies[i], self.reach[i]);
        let density = if reach > 0.0 {
            body.mass / (reach * reach)
        } else {
            f64::NAN
        };
        if density > 0.0 && density.is_finite() {
            density
        } else {
            f64::NAN
        }
    }

    /// Mass over what other bodies of its size have; NaN where there are none. Where its size, or that of all but one of the
    /// others, is not to be told from points, it is held against the masses of the others as they are.
    fn mass_ratio(&self, model: &MechanismModel, i: usize) -> f64 {
        let density = self.density(model, i);
        let sized = (1..model.bodies.len())
            .filter(|&k| k != i && self.density(model, k) > 0.0 && !model.bodies[k].fixed);
        if density > 0.0 && sized.count() > 1 {
            return density / median(model, i, density, |k| self.density(model, k));
        }
        let mass = model.bodies[i].mass;
        mass / median(model, i, mass, |k| model.bodies[k].mass)
    }

    /// A body that is lighter or heavier for its size than others.
    fn odd_mass(&self, model: &MechanismModel, i: usize) -> Option<String> {
        let body = &model.bodies[i];
        let ratio = self.mass_ratio(model, i);
        let expected = body.mass / ratio;
        (ratio > BESIDE_MASS || ratio < 1.0 / BESIDE_MASS && ratio > 0.0).then(|| {
            format!(
                "mass of body {:?} is {:.4e} kg, beside the other bodies about {expected:.1e} kg would be expected for \
                 its size: {}",
                body.name,
                body.mass,
                factor(ratio)
            )
        })
    }

    /// A body whose points are much farther or nearer than those of others.
    fn odd_points(&self, model: &MechanismModel, i: usize) -> Option<String> {
        let reach = self.reach[i];
        let typical = median(model, i, reach, |k| {
            if self.reach[k] > 0.0 {
                self.reach[k]
            } else {
                f64::NAN
            }
        });
        let ratio = reach / typical;
        (ratio > BESIDE_POINTS || ratio < 1.0 / BESIDE_POINTS && ratio > 0.0).then(|| {
            format!(
                "points of body {:?} are up to {reach:.4e} m from its centre of mass, those of other bodies about \
                 {typical:.1e} m: {}",
                model.bodies[i].name,
                factor(ratio)
            )
        })
    }

    /// A contact whose radii do not belong to each other or to the mechanism.
    fn odd_radii(&self, model: &MechanismModel, k: usize) -> Option<String> {
        let (contact, name) = (&model.contacts[k], &model.contact_names[k]);
        let radius = contact.radius;
        let other = match contact.profile() {
            Profile::Bore { radius } | Profile::Disc { radius } => Some(*radius),
            _ => None,
        };
        if let Some(bore) = other.filter(|_| matches!(contact.profile(), Profile::Bore { .. }))
            && bore > 100.0 * radius
        {
            return Some(format!(
                "bore_radius of contact {name:?} is {bore:.4e} m, a little more than its pin's radius, {radius:.4e} m, \
                 would be expected: {}",
                factor(bore / radius)
            ));
        }
        if let Some(disc) = other
            && !(1.0 / 300.0..300.0).contains(&(disc / radius))
        {
            return Some(format!(
                "radii of contact {name:?} are {disc:.4e} m and {radius:.4e} m: {}",
                factor(disc / radius)
            ));
        }
        // All that is apart may be a shaft within the play of its bearing, which says nothing of a size.
        let play = other.map_or(0.0, |other| (other - radius).abs());
        let ratio = radius / self.size;
        (self.size > play && !(RADII[0]..RADII[1]).contains(&ratio)).then(|| {
            format!(
                "radius of contact {name:?} is {radius:.4e} m in a mechanism of {:.1e} m: {}",
                self.size,
                factor(if ratio > 1.0 { ratio.max(1e3) } else { ratio })
            )
        })
    }
}

/// Median over the other bodies that can move of what is a number above zero; NaN without any. Of two in the middle it is the one
/// nearer to the body's own, so that what is odd of three is told of the odd one alone.
fn median(model: &MechanismModel, i: usize, own: f64, value: impl Fn(usize) -> f64) -> f64 {
    let others = (1..model.bodies.len()).filter(|&k| k != i && !model.bodies[k].fixed);
    let mut values: Vec<f64> = others
        .map(value)
        .filter(|v| v.is_finite() && *v > 0.0)
        .collect();
    values.sort_by(f64::total_cmp);
    let apart = |v: &f64| (v / own).ln().abs();
    match (values.len(), values.len() / 2) {
        (0, _) => f64::NAN,
        (count, half) if count % 2 == 1 => values[half],
        (_, half) if apart(&values[half]) < apart(&values[half - 1]) => values[half],
        (_, half) => values[half - 1],
    }
}

/// The power of 1000 that a ratio is nearest to, in words.
pub(crate) fn times(ratio: f64) -> String {
    let thousands = (ratio.log10() / 3.0).round();
    let direction = if ratio > 1.0 { "large" } else { "small" };
    let times = 1000f64.powf(thousands.abs().max(1.0));
    format!("{times:.0} times too {direction}")
}

pub(crate) fn factor(ratio: f64) -> String {
    format!("is it {}, in another unit?", times(ratio))
}

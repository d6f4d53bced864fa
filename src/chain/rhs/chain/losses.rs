//! Friction and lubricant of a SIMD vector of hinges, evaluated after the normal forces.

use pulp::Simd;

use super::ends::LinkEnd;
use super::hinges::Hinges;
use crate::chain::arrays::slopes::group_of;
use crate::force_law::FilmForce;
use crate::math::simd::{Lanes, load, write};

impl<S: Simd, const DAMPED: bool, const FRICTION: bool, const BRISTLED: bool, const EXTRA: bool>
    Hinges<'_, S, DAMPED, FRICTION, BRISTLED, EXTRA>
{
    /// Add the film to the forces and moments of these hinges.
    ///
    /// The same equations for one contact of a mechanism: multibody/contact/film.rs.
    #[inline(always)]
    pub(super) fn add_film(
        &mut self,
        i: usize,
        [front, rear]: [&LinkEnd<S>; 2],
        [ex, ey]: [Lanes<S>; 2],
        velocity: [Lanes<S>; 2],
        distance_squared: Lanes<S>,
    ) {
        let simd = self.clearance.simd();
        let splat = |value| Lanes::splat(simd, value);
        let (zero, one, half) = (splat(0.0), splat(1.0), splat(0.5));
        let Some(film) = self.film else { return };
        let distance = distance_squared.sqrt();
        // At zero eccentricity the direction is arbitrary.
        let apart = distance.greater(zero);
        let over_distance = one / apart.select(distance, one);
        let (nx, ny) = (
            apart.select(ex * over_distance, one),
            apart.select(ey * over_distance, zero),
        );
        let along = nx.mul_add(velocity[0], ny * velocity[1]);
        // Velocity of the eccentricity along and across it, in a frame that rotates with the mean angular velocity.
        let mean_spin = half * (front.spin + rear.spin);
        let across = nx.mul_add(velocity[1], -(ny * velocity[0]));
        let across = mean_spin.negate_mul_add(distance, across);
        let turning = rear.spin - front.spin;
        let exists = load(simd, &self.exists[i]);
        let filled = film.at(distance, [along, across], exists);
        let FilmForce {
            force: [push, drag],
            shear,
        } = filled.film;
        let shear = shear * turning;
        if self.powers {
            // Dissipated power: S Δω² - F · v.
            let film_on_eccentricity = push.mul_add(along, drag * across);
            self.film_power
                .add(i, shear.mul_add(turning, -film_on_eccentricity));
        }
        let force = [push.mul_add(nx, -(drag * ny)), push.mul_add(ny, drag * nx)];
        let mut whole = [zero; 2];
        for (axis, force) in force.into_iter().enumerate() {
            self.film_force[axis][i] = force.values();
            let front = &mut self.front_force[axis][i];
            whole[axis] = load(simd, front) + force;
            *front = whole[axis].values();
            let rear = &mut self.rear_force[axis][i];
            *rear = (load(simd, rear) - force).values();
        }
        let [x, y] = whole;
        self.lubricated_force[i] = x.mul_add(x, y * y).sqrt().values();
        // The forces on the two ends act at a distance: each end takes half of their moment.
        let lever = half * distance * drag;
        let moments = [shear - lever, -(shear + lever)];
        for (all, moment) in self.moments.iter_mut().zip(moments) {
            all[i] = (load(simd, &all[i]) + moment).values();
        }
        if let Some(groups) = &mut self.film_slopes {
            let slopes = film.slopes(&filled);
            let (group, part) = group_of::<S, _>(groups, i);
            write(&mut group.normal, part, [nx, ny]);
            write(&mut group.damping, part, slopes.damping);
            write(&mut group.stiffness, part, slopes.stiffness);
            group.inverse_speed.put(part, slopes.inverse_speed);
        }
    }

    /// Return the force on the rear ends with friction; write the moments of friction.
    ///
    /// The same equations for one contact of a mechanism: multibody/contact/friction.rs.
    #[inline(always)]
    pub(super) fn add_friction(
        &mut self,
        i: usize,
        [front, rear]: [&LinkEnd<S>; 2],
        ([nx, ny], depth): ([Lanes<S>; 2], Lanes<S>),
        velocity: [Lanes<S>; 2],
        force: Lanes<S>,
    ) -> [Lanes<S>; 2] {
        let simd = force.simd();
        let zero = force.constant(0.0);
        let radius = if BRISTLED {
            self.bristles.as_ref().map(|bristles| bristles.radius)
        } else {
            self.regularized.map(|(_, radius)| radius)
        };
        let Some(pin_radius) = radius else {
            return [force * nx, force * ny];
        };
        // The contact point is the point of the pin on the bushing, whichever link carries the pin. Its position along the normal
        // is relative to the centre of each end.
        let on_front = load(simd, &self.on_front[i]).greater(zero);
        let distance = depth + self.clearance;
        let from_front = on_front.select(-(pin_radius + distance), pin_radius);
        let from_rear = from_front + distance;
        // Sliding velocity: t · de/dt + from_front ω_front - from_rear ω_rear.
        let across = nx.mul_add(velocity[1], -(ny * velocity[0]));
        let turning = from_front.mul_add(front.spin, -(from_rear * rear.spin));
        let slip = across + turning;
        let [friction, slope] = if BRISTLED && let Some(bristles) = &mut self.bristles {
            bristles.bend(i, depth.exceeds(zero), force, slip)
        } else if let Some((friction, _)) = &self.regularized {
            friction.force(force, slip)
        } else {
            [zero; 2]
        };
        if self.powers {
            self.friction_power.add(i, friction * slip);
        }
        self.friction[i] = friction.values();
        self.moments[0][i] = (-(from_front * friction)).values();
        self.moments[1][i] = (from_rear * friction).values();
        if let Some(slopes) = &mut self.friction_slopes {
            let (group, part) = group_of::<S, _>(slopes, i);
            group.slope.put(part, slope);
            group.places[0].put(part, from_front);
            group.places[1].put(part, from_rear);
            group.slip.put(part, slip);
        }
        [
            force.mul_add(nx, -(friction * ny)),
            force.mul_add(ny, friction * nx),
        ]
    }
}

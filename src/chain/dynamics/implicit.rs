//! What Newton's method asks of the dynamics, and the exact matrix that the one it gets is held against.

use std::ops::Range;

use super::Dynamics;
use super::chain_solver::ChainMatrix;
use super::jacobian::{FAR, Lever, PointForce, Pressed, link_levers, sprocket_levers};
use super::roller_matrix::RollerMatrix;
use crate::chain::contact::bushing_on_sprocket;
use crate::chain::model::RollerModel;
use crate::force_law::{ElasticLaw, Regions, depth_in_series, with_law};
use crate::geometry::{SurfaceCurve, Vec2, turned_left};
use crate::integrator::{SPEED_PER_LENGTH, SecondOrderSystem};

/// The error allowed to lengths is the share of it that is allowed to bristles bent to break-away \[m\]: 1e-10 m and a
/// thousandth. What they get wrong is a force, that of their share, and not a place.
const WHOLE_DEFLECTION: f64 = 1e-7;

/// How much faster than before corrections of a step in which a contact begins or ends are taken to grow with their size. In the published
/// drive at 0, 25 and 100 N, with rollers and without, one step in a thousand of those let go by this would have been measured otherwise.
const WHERE_CHANGED: f64 = 10.0;

/// Force \[N\] and its slopes with penetration \[N/m\] and rate \[N s/m\].
fn slopes<L: ElasticLaw>(
    pair: &[f64; 2],
    (depth, rate): (f64, f64),
    lambda: f64,
    compliance: Option<f64>,
    remembered: f64,
    floor: f64,
) -> (f64, f64, f64) {
    let pressed = compliance.map_or(depth, |c| depth_in_series::<f64, L>(*pair, c, depth));
    let (elastic, alone) = (L::force(pair, pressed), L::stiffness(pair, pressed));
    let stiffness = alone / compliance.unwrap_or(0.0).mul_add(alone, 1.0);
    // Without memory the present rate is the onset speed: the factor is a constant, above the floor.
    let onset = if remembered > 0.0 {
        remembered
    } else {
        rate.max(floor)
    };
    let factor = 1.0 + lambda * rate / onset;
    if factor <= 0.0 {
        return (0.0, 0.0, 0.0);
    }
    let fresh_and_fast = remembered == 0.0 && rate > floor;
    let damping = if fresh_and_fast {
        0.0
    } else {
        elastic * lambda / onset
    };
    (elastic * factor, stiffness * factor, damping)
}

impl Dynamics {
    fn add_hinges(&self, matrix: &mut ChainMatrix, y: &[f64], gamma: f64) {
        let model = &self.model;
        let n = model.links;
        let (q, v) = y.split_at(model.coordinates);
        for (k, &depth) in self.kernels.hinge_depths(model).iter().enumerate() {
            if depth <= 0.0 {
                continue;
            }
            let next = (k + 1) % n;
            let end = |i: usize, side: f64| {
                let along = side * model.arms[i] * self.kernels.link_direction(i);
                (
                    Vec2::new(q[i], q[n + i]) + along,
                    Vec2::new(v[i], v[n + i]) + v[2 * n + i] * turned_left(along),
                    along,
                )
            };
            let ((front, front_v, front_arm), (rear, rear_v, rear_arm)) =
                (end(k, 1.0), end(next, -1.0));
            let (offset, velocity) = (front - rear, front_v - rear_v);
            let distance = offset.norm();
            let normal = offset / distance;
            let law = &model.hinge_law;
            let (force, stiffness, damping) = with_law!(&law.pairs, Law, pairs => {
                slopes::<Law>(&pairs[0], (depth, normal.dot(&velocity)), law.lambda, model.compliance_at(k),
                    self.memory.hinge_speed()[k], model.min_approach_speed)
            });
            let contact = PointForce::new(
                &Pressed {
                    normal,
                    side: 1.0,
                    distance,
                    velocity,
                    force,
                    stiffness,
                    damping,
                },
                gamma,
            );
            let front = link_levers(1.0, front_arm, v[2 * n + k]);
            let rear = link_levers(-1.0, -rear_arm, v[2 * n + next]);
            matrix.add_hinge(k, &contact, &front, &rear);
        }
    }

    /// Bushing `k`: its centre seen from that of its link, its centre, and that's velocity.
    fn bushing_at(&self, k: usize, y: &[f64]) -> (Vec2, Vec2, Vec2) {
        let model = &self.model;
        let (n, link) = (model.links, model.link_of_bushing(k));
        let (q, v) = y.split_at(model.coordinates);
        let along = model.bushing_arm(k) * self.kernels.link_direction(link);
        (
            along,
            Vec2::new(q[link], q[n + link]) + along,
            Vec2::new(v[link], v[n + link]) + v[2 * n + link] * turned_left(along),
        )
    }

    /// Centre of roller `k` and its velocity.
    fn roller_at(&self, first: usize, k: usize, y: &[f64]) -> (Vec2, Vec2) {
        let (q, v) = y.split_at(self.model.coordinates);
        let (x, y) = (first + k, first + self.model.links + k);
        (Vec2::new(q[x], q[y]), Vec2::new(v[x], v[y]))
    }

    fn add_rollers(
        &self,
        of: &RollerModel,
        matrix: &mut ChainMatrix,
        rollers: &mut RollerMatrix,
        y: &[f64],
        gamma: f64,
    ) {
        let model = &self.model;
        let (n, v) = (model.links, &y[model.coordinates..]);
        for (k, &depth) in self.kernels.roller_depths(model).iter().enumerate() {
            if depth <= 0.0 {
                continue;
            }
            let (along, bushing, bushing_v) = self.bushing_at(k, y);
            let (roller, roller_v) = self.roller_at(of.first, k, y);
            let (offset, velocity) = (bushing - roller, bushing_v - roller_v);
            let distance = offset.norm();
            let normal = offset / distance;
            let (force, stiffness, damping) = with_law!(&of.law.pairs, Law, pairs => {
                slopes::<Law>(&pairs[0], (depth, normal.dot(&velocity)), of.law.lambda, None,
                    self.memory.roller_speed()[k], model.min_approach_speed)
            });
            let contact = PointForce::new(
                &Pressed {
                    normal,
                    side: 1.0,
                    distance,
                    velocity,
                    force,
                    stiffness,
                    damping,
                },
                gamma,
            );
            let bushing = link_levers(1.0, along, v[2 * n + model.link_of_bushing(k)]);
            let roller = link_levers(-1.0, Vec2::zeros(), 0.0);
            rollers.add_joint(matrix, k, &contact, &bushing, &roller);
        }
    }

    fn add_teeth(
        &self,
        matrix: &mut ChainMatrix,
        mut rollers: Option<&mut RollerMatrix>,
        y: &[f64],
        gamma: f64,
    ) {
        let model = &self.model;
        let (n, v) = (model.links, &y[model.coordinates..]);
        for (s, k, depth, _) in self.kernels.tooth_contacts(model) {
            if depth <= 0.0 {
                continue;
            }
            let sprocket = &model.sprockets[s];
            let frame = self.kernels.sprocket_frame(s);
            let link = model.link_of_bushing(k);
            let (along, point, velocity) = match &model.rollers {
                Some(of) => {
                    let (point, velocity) = self.roller_at(of.first, k, y);
                    (Vec2::zeros(), point, velocity)
                }
                None => self.bushing_at(k, y),
            };
            let Some(found) =
                bushing_on_sprocket(sprocket, &frame, point, velocity, model.contact_radius)
            else {
                continue;
            };
            let surface = &sprocket.profile.surfaces()[found.surface.index()];
            let (side, distance) = match surface.curve {
                SurfaceCurve::Concave(arc) => (1.0, depth + arc.radius - model.contact_radius),
                SurfaceCurve::Straight(_) => (1.0, FAR),
                SurfaceCurve::Convex(arc) => (-1.0, arc.radius + model.contact_radius - depth),
            };
            let normal = found.contact.normal;
            let from_center = point - frame.center - side * distance * normal;
            let velocity = velocity - frame.velocity - frame.spin * turned_left(from_center);
            let pair = s * n + k;
            let remembered = self.memory.tooth_speed[pair];
            let law = &model.tooth_law;
            let surface = if law.regions == Regions::Kept && remembered > 0.0 {
                self.memory.tooth_surface[pair]
            } else {
                found.surface
            };
            let (force, stiffness, damping) = with_law!(&law.pairs, Law, pairs => {
                let rate = found.contact.penetration_rate;
                slopes::<Law>(&pairs[model.tooth_pair(s, surface)], (depth, rate), law.lambda, None,
                    remembered, model.min_approach_speed)
            });
            let contact = PointForce::new(
                &Pressed {
                    normal,
                    side,
                    distance,
                    velocity,
                    force,
                    stiffness,
                    damping,
                },
                gamma,
            );
            // A roller's centre does not feel it turn.
            let bushing = link_levers(1.0, along, v[2 * n + link]);
            let mut levers = [(0, bushing[0]); 4];
            let mut count = 0;
            sprocket_levers(
                model,
                s,
                frame.center,
                from_center,
                frame.spin,
                |j, lever: Lever| {
                    levers[count] = (j, lever);
                    count += 1;
                },
            );
            match &mut rollers {
                Some(rollers) => rollers.add_tooth(k, &contact, &bushing, &levers[..count]),
                None => matrix.add_tooth(link, &contact, &bushing, &levers[..count]),
            }
        }
    }
}

impl Dynamics {
    /// Makes the room that the implicit corrector needs.
    pub fn make_room_for_newton(&mut self) {
        self.kernels.make_room_for_newton(&self.model);
    }

    /// Overwrites a residual of velocities by the correction of the exact matrix, M - γ dQ/dv - γ² dQ/dq, at `y`, where the
    /// derivative was just evaluated; false when the matrix is singular.
    ///
    /// Friction has no part in it: for drives without. Written out contact by contact, in scalars: what the kernels' matrix, which leaves out two small terms, is held against.
    pub fn correct_exactly(&self, y: &[f64], gamma: f64, residual: &mut [f64]) -> bool {
        let model = &self.model;
        let (n, border) = (model.links, model.wheel_coordinates());
        let mut matrix = ChainMatrix::new(n, border);
        matrix.add_masses(model, gamma);
        matrix.add_springs(model, &self.memory.pawls, y, gamma);
        self.add_hinges(&mut matrix, y, gamma);
        let mut rollers = model.rollers.as_ref().map(|of| {
            let links = (0..n).map(|k| model.link_of_bushing(k)).collect();
            let mut rollers = RollerMatrix::new(of, links, border);
            self.add_rollers(of, &mut matrix, &mut rollers, y, gamma);
            rollers
        });
        self.add_teeth(&mut matrix, rollers.as_mut(), y, gamma);
        if let Some(rollers) = &mut rollers
            && !rollers.eliminate(&mut matrix)
        {
            return false;
        }
        if !matrix.factorise() {
            return false;
        }
        for i in 0..n {
            residual[i] *= model.mass[i];
            residual[n + i] *= model.mass[i];
            residual[2 * n + i] *= model.inertia[i];
        }
        for sprocket in &model.sprockets {
            sprocket.for_each_inertia(|index, inertia| residual[index] *= inertia);
        }
        if let (Some(rollers), Some(of)) = (rollers, &model.rollers) {
            for (i, residual) in residual[of.first..].iter_mut().enumerate() {
                *residual *= if i < 2 * n { of.mass } else { of.inertia };
            }
            rollers.solve(&mut matrix, residual);
        } else {
            matrix.solve(residual);
        }
        true
    }
}

impl SecondOrderSystem for Dynamics {
    fn coordinates(&self) -> usize {
        self.model.coordinates
    }

    fn accelerations(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        self.accelerate(t, y, &mut dydt[self.model.coordinates..]);
    }

    fn accelerations_with_slopes(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) {
        self.make_room_for_newton();
        self.kernels.write_slopes(true);
        self.accelerations(t, y, dydt);
        self.kernels.write_slopes(false);
    }

    fn contraction_safety_factor(&self) -> f64 {
        if self.kernels.changed() && self.oscillates_at_order_two() {
            f64::INFINITY
        } else if self.kernels.changed() {
            WHERE_CHANGED
        } else {
            1.0
        }
    }

    fn oscillates_at_order_two(&self) -> bool {
        self.model.hinge_film.is_some()
    }

    fn local_unknowns(&self) -> Range<usize> {
        self.model.bristles.all()
    }

    fn begin_implicit_stage(&mut self, step: Option<(&[f64], f64)>) {
        self.kernels.solve_for_bristles(step);
    }

    fn write_local_solution(&self, velocities: &mut [f64]) {
        velocities.copy_from_slice(self.kernels.solved_bristles());
    }

    fn factorise(&mut self, _y: &[f64], gamma: f64) -> bool {
        self.kernels.factorise(&self.model, gamma)
    }

    fn correct(&mut self, residual: &mut [f64]) {
        let places = self.model.bristles.all();
        if places.is_empty() {
            self.kernels.correct(&self.model, residual);
            return;
        }
        // Evaluations have solved for the bristles.
        let (bodies, bristles) = residual.split_at_mut(places.start);
        self.kernels.correct(&self.model, bodies);
        bristles.fill(0.0);
    }

    fn scale(&self, lengths: &mut [f64]) {
        let model = &self.model;
        let n = model.links;
        lengths.fill(1.0);
        lengths[2 * n..3 * n].fill(model.half_pitch);
        if let Some(rollers) = &model.rollers {
            // What a roller's error passes on is its momentum: it may be larger than a link's as the roller is lighter.
            let chain = model.ends.as_ref().map_or(n, |ends| ends.links);
            let share = rollers.mass * chain as f64 / model.mass[..chain].iter().sum::<f64>();
            lengths[rollers.first..].fill(share);
            lengths[rollers.first + 2 * n..].fill(share * model.contact_radius);
        }
        let places = &model.bristles;
        for (range, law) in [
            (places.hinges.clone(), &model.hinge_bristles),
            (places.rollers.clone(), &model.hinge_bristles),
            (places.teeth.clone(), &model.tooth_bristles),
        ] {
            if let Some(law) = law {
                lengths[range].fill(SPEED_PER_LENGTH * WHOLE_DEFLECTION / law.breakaway());
            }
        }
        for sprocket in &model.sprockets {
            if let crate::chain::model::Rotation::Free { index, .. } = sprocket.rotation {
                lengths[index] = sprocket.profile.pitch_radius;
            }
        }
    }
}

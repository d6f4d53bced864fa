//! The equations of a chain drive written out contact by contact, in scalars: what the kernels are held against.
//!
//! Every contact is a normal force F(δ) max(0, 1 + λ dδ/dt / v₀), friction along the normal turned left, and in hinges the force of a
//! film; the forces and moments on each link and roller over its mass and inertia are its accelerations.

use std::ops::Range;

use super::checks::{elastic, impact_velocity};
use rustchain::chain::contact::{SprocketFrame, bushing_on_sprocket};
use rustchain::chain::dynamics::{Dynamics, Losses, SprocketLoad};
use rustchain::chain::model::Model;
use rustchain::chain::motion::Motion;
use rustchain::drive::bushing_on_front;
use rustchain::force_law::{Friction, LuGre, Regions};
use rustchain::geometry::{Surface, Vec2, turned_left};

/// Laws of friction of one kind of contact.
type FrictionLaws<'a> = (&'a Option<Friction>, &'a Option<LuGre>);

/// One contact; of a hinge seen from the rear end of link k + 1, of a roller from the roller, of a tooth from the sprocket.
#[derive(Debug, Clone, Copy, Default)]
pub struct Contact {
    /// Direction in which the penetration grows.
    pub normal: Vec2,
    /// Negative when apart \[m\].
    pub penetration: f64,
    /// \[m/s\]
    pub rate: f64,
    /// Normal force \[N\].
    pub force: f64,
    /// Friction along the normal turned left, on the body that the contact is seen from \[N\].
    pub friction: f64,
    /// dz/dt of its bristles \[m/s\].
    pub bristle_rate: f64,
    /// Moments of friction and film on the body that is seen, and on the one that it is seen from \[N m\].
    moments: [f64; 2],
    /// Force of lubricant on the body that is seen \[N\].
    film: Vec2,
    /// Powers dissipated by damping, friction and film \[W\].
    dissipated: [f64; 3],
}

impl Contact {
    fn new(normal: Vec2, penetration: f64, rate: f64) -> Self {
        Self {
            normal,
            penetration,
            rate,
            ..Self::default()
        }
    }

    /// Two centres in a bore: of the one `offset` from the other.
    fn in_bore(offset: Vec2, velocity: Vec2, clearance: f64) -> Self {
        let distance = offset.norm();
        let normal = offset.try_normalize(0.0).unwrap_or_default();
        Self::new(normal, distance - clearance, normal.dot(&velocity))
    }

    /// The normal force, where its penetration is not negative.
    fn press(&mut self, elastic: impl Fn(f64) -> f64, lambda: f64, onset: f64) {
        if self.penetration <= 0.0 {
            return;
        }
        let elastic = elastic(self.penetration);
        // Not negative; a rate that is no number comes out.
        let factor = 1.0 + lambda * self.rate / onset;
        self.force = if factor < 0.0 { 0.0 } else { elastic * factor };
        self.dissipated[0] = (self.force - elastic) * self.rate;
    }

    /// Friction, which acts at `arms` along the normal from the centres of both bodies, for the relative velocity of these and `spins`.
    fn rub(
        &mut self,
        ((law, bristles), deflection): (FrictionLaws, f64),
        velocity: Vec2,
        [spins, arms]: [[f64; 2]; 2],
    ) {
        if self.penetration <= 0.0 {
            return;
        }
        let across = turned_left(self.normal).dot(&velocity);
        let slip = across + arms[0] * spins[0] - arms[1] * spins[1];
        if let Some(law) = bristles {
            let bent = law.bent(deflection, slip);
            self.friction = self.force * bent.share;
            self.bristle_rate = bent.rate;
        } else if let Some(law) = law {
            self.friction = law.coefficient * self.force * law.share(slip).0;
        }
        self.moments = [-arms[0] * self.friction, arms[1] * self.friction];
        self.dissipated[1] = self.friction * slip;
    }

    /// Force on the body that is seen \[N\].
    fn on_seen(&self) -> Vec2 {
        self.film - self.force * self.normal - self.friction * turned_left(self.normal)
    }
}

/// A bushing or roller near a sprocket.
#[derive(Debug, Clone, Copy)]
pub struct ToothContact {
    pub contact: Contact,
    pub surface: Surface,
    /// The surface that its stiffness is that of.
    pub stiffness_surface: Surface,
    /// Seen from the sprocket's centre \[m\].
    arm: Vec2,
}

/// Place \[m\] and velocity \[m/s\] of a point of a body.
type Point = [Vec2; 2];

/// Contacts, accelerations and powers of one state.
#[derive(Debug, Clone)]
pub struct Reference {
    pub motion: Motion,
    /// By number of the hinge.
    pub hinges: Vec<Contact>,
    /// By number of the roller; empty where rollers are no bodies.
    pub rollers: Vec<Contact>,
    /// By pair `sprocket * links + bushing`, where it is within reach.
    pub teeth: Vec<Option<ToothContact>>,
    /// Of links and rollers: x, y \[m/s²\] and θ \[rad/s²\].
    pub accelerations: [Vec<f64>; 3],
    /// What the chain does to each sprocket.
    pub loads: Vec<SprocketLoad>,
    pub losses: Losses,
}

impl Reference {
    /// Evaluates the drive of `dynamics`, with the memory of its contacts, at (`t`, `y`).
    pub fn of(dynamics: &Dynamics, t: f64, y: &[f64]) -> Self {
        let model = dynamics.model();
        let mut motion = Motion::new(model.bodies());
        motion.read(model, t, y);
        let deflections = &y[model.coordinates..];
        let mut found = Self {
            motion,
            hinges: Vec::new(),
            rollers: Vec::new(),
            teeth: Vec::new(),
            accelerations: [0; 3].map(|_| vec![0.0; model.wheel_body(0)]),
            loads: vec![SprocketLoad::default(); model.sprockets.len()],
            losses: Losses::default(),
        };
        for k in 0..model.links {
            let contact = found.hinge(dynamics, k, deflections);
            found.hinges.push(contact);
        }
        for k in 0..model.roller_count() {
            let contact = found.roller(dynamics, k, deflections);
            found.rollers.push(contact);
        }
        for pair in 0..model.links * model.sprockets.len() {
            let contact = found.tooth(dynamics, pair, deflections);
            found.teeth.push(contact);
        }
        found.accelerate(model, t);
        found.sum_losses();
        found
    }

    /// dz/dt of all bristles, as the state has them \[m/s\].
    pub fn bristle_rates(&self, model: &Model) -> Vec<f64> {
        let places = &model.bristles;
        let teeth = |tooth: &Option<ToothContact>| tooth.map(|tooth| tooth.contact);
        let teeth = self.teeth.iter().map(teeth).take(places.teeth.len());
        let joints = [
            (&self.hinges, &places.hinges),
            (&self.rollers, &places.rollers),
        ];
        let joints = joints.map(|(all, places)| all[..places.len()].iter().copied().map(Some));
        let all = joints.into_iter().flatten().chain(teeth);
        all.map(|contact| contact.map_or(0.0, |c| c.bristle_rate))
            .collect()
    }

    fn body(&self, i: usize) -> Point {
        let m = &self.motion;
        [Vec2::new(m.x[i], m.y[i]), Vec2::new(m.vx[i], m.vy[i])]
    }

    /// The front end of link `i`, or with a `side` of -1 its rear end.
    fn end(&self, model: &Model, i: usize, side: f64) -> Point {
        let (sin, cos) = self.motion.angle[i].sin_cos();
        let along = side * model.chain.arms[i] * Vec2::new(cos, sin);
        let [place, velocity] = self.body(i);
        let turning = self.motion.spin[i] * turned_left(along);
        [place + along, velocity + turning]
    }

    fn bushing(&self, model: &Model, k: usize) -> Point {
        if bushing_on_front(k, model.links) {
            self.end(model, k, 1.0)
        } else {
            self.end(model, (k + 1) % model.links, -1.0)
        }
    }

    fn hinge(&self, dynamics: &Dynamics, k: usize, deflections: &[f64]) -> Contact {
        let (model, law) = (dynamics.model(), &dynamics.model().hinges.law);
        if model.hinge_is_open(k) {
            return Contact::new(Vec2::zeros(), -model.hinges.clearance, 0.0);
        }
        let next = (k + 1) % model.links;
        let [front, rear] = [self.end(model, k, 1.0), self.end(model, next, -1.0)];
        let (offset, velocity) = (front[0] - rear[0], front[1] - rear[1]);
        let mut contact = Contact::in_bore(offset, velocity, model.hinges.clearance);
        let remembered = dynamics.memory.hinge_impact_velocity()[k];
        let onset = impact_velocity(model, remembered, contact.rate);
        let compliance = model.hinges.compliance_at(k).unwrap_or(0.0);
        let elastic = |depth| elastic(&law.pairs, 0, compliance, depth);
        contact.press(elastic, law.lambda, onset);
        let deflection = deflection(deflections, &model.bristles.hinges, k);
        let law = (&model.hinges.friction, &model.hinges.bristles);
        // The contact is the pin's outermost point, whichever link has the pin.
        let distance = contact.penetration + model.hinges.clearance;
        let from_front = if bushing_on_front(k, model.links) {
            -(model.hinges.pin_radius + distance)
        } else {
            model.hinges.pin_radius
        };
        let arms = [from_front, from_front + distance];
        let [spin, next_spin] = [self.motion.spin[k], self.motion.spin[next]];
        contact.rub((law, deflection), velocity, [[spin, next_spin], arms]);
        if let Some(film) = &model.hinges.film {
            let distance = offset.norm();
            let along = offset.try_normalize(0.0).unwrap_or(Vec2::x());
            let across = turned_left(along);
            let turning = 0.5 * (spin + next_spin) * distance;
            let seen = [along.dot(&velocity), across.dot(&velocity) - turning];
            let filled = film.at(distance, seen);
            let [push, drag] = filled.force;
            let shear = filled.shear * (next_spin - spin);
            contact.film = push * along + drag * across;
            contact.moments[0] += shear - 0.5 * distance * drag;
            contact.moments[1] -= shear + 0.5 * distance * drag;
            contact.dissipated[2] = shear * (next_spin - spin) - (push * seen[0] + drag * seen[1]);
        }
        contact
    }

    fn roller(&self, dynamics: &Dynamics, k: usize, deflections: &[f64]) -> Contact {
        let model = dynamics.model();
        let of = model.rollers.as_ref().unwrap();
        if !model.bushing_is_there(k) {
            return Contact::new(Vec2::zeros(), -of.clearance, 0.0);
        }
        let [bushing, roller] = [self.bushing(model, k), self.body(model.links + k)];
        let velocity = bushing[1] - roller[1];
        let mut contact = Contact::in_bore(bushing[0] - roller[0], velocity, of.clearance);
        let remembered = dynamics.memory.roller_impact_velocity()[k];
        let onset = impact_velocity(model, remembered, contact.rate);
        let elastic = |depth| elastic(&of.law.pairs, 0, 0.0, depth);
        contact.press(elastic, of.law.lambda, onset);
        let deflection = deflection(deflections, &model.bristles.rollers, k);
        let law = (&model.hinges.friction, &model.hinges.bristles);
        let radius = of.bushing_radius;
        let arms = [radius, radius + contact.penetration + of.clearance];
        let spins = [model.link_of_bushing(k), model.links + k].map(|i| self.motion.spin[i]);
        contact.rub((law, deflection), velocity, [spins, arms]);
        contact
    }

    /// What meets the teeth at hinge `k`, roller or bushing, and the body that it turns with.
    pub fn on_teeth(&self, model: &Model, k: usize) -> (Point, usize) {
        if model.rollers.is_some() {
            (self.body(model.links + k), model.links + k)
        } else {
            (self.bushing(model, k), model.link_of_bushing(k))
        }
    }

    fn tooth(&self, dynamics: &Dynamics, pair: usize, deflections: &[f64]) -> Option<ToothContact> {
        let (model, memory) = (dynamics.model(), &dynamics.memory);
        let (s, k) = (pair / model.links, pair % model.links);
        let (sprocket, wheel) = (&model.sprockets[s], model.wheel_body(s));
        let ([place, velocity], body) = self.on_teeth(model, k);
        let center = self.body(wheel);
        let (angle, spin) = (self.motion.angle[wheel], self.motion.spin[wheel]);
        let frame = SprocketFrame::new(center[0], center[1], angle, spin);
        let found = bushing_on_sprocket(
            sprocket,
            &frame,
            place,
            velocity,
            model.teeth.contact_radius,
        );
        let found = found.filter(|_| model.bushing_is_there(k))?;
        let arm = place - center[0];
        let at = found.contact;
        let mut contact = Contact::new(at.normal, at.penetration, at.penetration_rate);
        let remembered = memory.tooth_impact_velocity[pair];
        let kept = model.teeth.law.regions == Regions::Kept && remembered > 0.0;
        let stiffness_surface = [found.surface, memory.tooth_surface[pair]][usize::from(kept)];
        let number = model.tooth_pair(s, stiffness_surface);
        let onset = impact_velocity(model, remembered, contact.rate);
        let elastic = |depth| elastic(&model.teeth.law.pairs, number, 0.0, depth);
        contact.press(elastic, model.teeth.law.lambda, onset);
        let deflection = deflection(deflections, &model.bristles.teeth, pair);
        let law = (&model.teeth.friction, &model.teeth.bristles);
        let seen = velocity - center[1] - spin * turned_left(arm);
        let spins = [self.motion.spin[body], spin];
        contact.rub(
            (law, deflection),
            seen,
            [spins, [model.teeth.contact_radius; 2]],
        );
        Some(ToothContact {
            contact,
            surface: found.surface,
            stiffness_surface,
            arm,
        })
    }

    /// Forces and moments of hinges, rollers and teeth on every link and roller, and of teeth on sprockets.
    fn accelerate(&mut self, model: &Model, t: f64) {
        let n = model.links;
        let mut force = vec![Vec2::zeros(); 2 * n];
        let mut moment = vec![0.0; 2 * n];
        let mut loads = self.loads.clone();
        let mut push = |body: usize, by: Vec2, arm: Vec2, twist: f64| {
            force[body] += by;
            moment[body] += arm.perp(&by) + twist;
        };
        let arm = |body: usize, place: Vec2| place - self.body(body)[0];
        for (k, hinge) in self.hinges.iter().enumerate() {
            let next = (k + 1) % n;
            let (front, rear) = (self.end(model, k, 1.0), self.end(model, next, -1.0));
            let by = hinge.on_seen();
            push(k, by, arm(k, front[0]), hinge.moments[0]);
            push(next, -by, arm(next, rear[0]), hinge.moments[1]);
        }
        for (k, roller) in self.rollers.iter().enumerate() {
            let (link, by) = (model.link_of_bushing(k), roller.on_seen());
            let lever = arm(link, self.bushing(model, k)[0]);
            push(link, by, lever, roller.moments[0]);
            push(n + k, -by, Vec2::zeros(), roller.moments[1]);
        }
        for (pair, tooth) in self.teeth.iter().enumerate() {
            let (Some(tooth), s, k) = (tooth, pair / n, pair % n) else {
                continue;
            };
            let ([place, _], body) = self.on_teeth(model, k);
            let (by, twist) = (tooth.contact.on_seen(), tooth.contact.moments[0]);
            push(body, by, arm(body, place), twist);
            loads[s].force -= by;
            loads[s].moment -= tooth.arm.perp(&by) + twist;
        }
        self.loads = loads;
        let [x, y, angle] = &mut self.accelerations;
        for i in 0..n {
            x[i] = force[i].x * model.chain.inverse_mass[i] + model.gravity.x;
            y[i] = force[i].y * model.chain.inverse_mass[i] + model.gravity.y;
            angle[i] = moment[i] * model.chain.inverse_inertia[i];
        }
        if let Some(rollers) = &model.rollers {
            for k in (0..n).filter(|&k| model.bushing_is_there(k)) {
                x[n + k] = force[n + k].x / rollers.mass + model.gravity.x;
                y[n + k] = force[n + k].y / rollers.mass + model.gravity.y;
                angle[n + k] = moment[n + k] / rollers.inertia;
            }
        }
        // Ends of an open chain move as they are told.
        for end in model.ends.iter().flat_map(|ends| &ends.bodies) {
            if let Some(given) = end.given_acceleration(t, f64::INFINITY) {
                (x[end.body], y[end.body], angle[end.body]) = (given.x, given.y, 0.0);
            }
        }
    }

    fn sum_losses(&mut self) {
        let sum = |contacts: &[Contact], i: usize| contacts.iter().map(|c| c.dissipated[i]).sum();
        let teeth: Vec<Contact> = self.teeth.iter().flatten().map(|t| t.contact).collect();
        self.losses = Losses {
            hinge_contact: sum(&self.hinges, 0),
            tooth_contact: sum(&teeth, 0),
            hinge_friction: sum(&self.hinges, 1),
            tooth_friction: sum(&teeth, 1),
            roller_contact: sum(&self.rollers, 0),
            roller_friction: sum(&self.rollers, 1),
            hinge_film: sum(&self.hinges, 2),
        };
    }
}

/// The deflection of bristle `number` among those of one kind of contact; zero where that has none.
fn deflection(all: &[f64], places: &Range<usize>, number: usize) -> f64 {
    places.clone().nth(number).map_or(0.0, |place| all[place])
}

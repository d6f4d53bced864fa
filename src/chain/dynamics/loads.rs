//! Contact, gravity, tensioner and drive loads gathered per body, and the accelerations that follow.

use super::Powers;
use crate::chain::contact::{HingeContacts, RollerContacts, ToothContacts};
use crate::chain::model::{Model, Rotation, SprocketModel, Support};
use crate::chain::motion::Motion;
use crate::drive::bushing_on_front;
use crate::geometry::{Vec2, turned_left};

/// What the chain does to a sprocket.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SprocketLoad {
    /// Force \[N\].
    pub force: Vec2,
    /// Moment about the sprocket's centre \[N m\].
    pub moment: f64,
}

/// Accelerations of all bodies, and what the chain does to the sprockets.
#[derive(Debug, Clone)]
pub struct Accelerations {
    /// d²x/dt² \[m/s²\]
    pub x: Vec<f64>,
    /// d²y/dt² \[m/s²\]
    pub y: Vec<f64>,
    /// d²θ/dt² \[rad/s²\]
    pub angle: Vec<f64>,
    /// What the chain does to each sprocket.
    pub chain: Vec<SprocketLoad>,
    /// Force of the chain on both ends of an open one \[N\].
    pub on_ends: [Vec2; 2],
    /// Tooth force on each bushing or roller, x \[N\].
    tooth_x: Vec<f64>,
    /// Tooth force on each bushing, y \[N\].
    tooth_y: Vec<f64>,
    /// Moment of teeth about each bushing \[N m\].
    tooth_moment: Vec<f64>,
}

impl Accelerations {
    pub(super) fn new(bodies: usize, sprockets: usize) -> Self {
        let zeros = || vec![0.0; bodies];
        Self {
            x: zeros(),
            y: zeros(),
            angle: zeros(),
            chain: vec![SprocketLoad::default(); sprockets],
            on_ends: [Vec2::zeros(); 2],
            tooth_x: zeros(),
            tooth_y: zeros(),
            tooth_moment: zeros(),
        }
    }

    pub(super) fn gather(
        &mut self,
        model: &Model,
        motion: &Motion,
        (hinges, rollers, teeth): (&HingeContacts, &RollerContacts, &ToothContacts),
        pawls: &[f64],
        t: f64,
    ) {
        self.gather_teeth(model, teeth);
        self.accelerate_rollers(model, rollers);
        self.accelerate_links(model, motion, hinges);
        self.move_ends(model, hinges, t);
        self.accelerate_sprockets(model, motion, pawls, t);
    }

    /// Tooth forces by bushing and by sprocket.
    pub(super) fn gather_teeth(&mut self, model: &Model, teeth: &ToothContacts) {
        self.tooth_x.fill(0.0);
        self.tooth_y.fill(0.0);
        self.tooth_moment.fill(0.0);
        self.chain.fill(SprocketLoad::default());
        for &pair in &teeth.near {
            let pair = pair as usize;
            let force = teeth.force[pair];
            if force == 0.0 {
                continue;
            }
            let (s, k) = (pair / model.links, pair % model.links);
            let normal = Vec2::new(teeth.normal_x[pair], teeth.normal_y[pair]);
            let mut push = force * normal;
            if model.teeth_rub() {
                push += teeth.friction[pair] * turned_left(normal);
                let moment = model.contact_radius * teeth.friction[pair];
                self.tooth_moment[k] -= moment;
                self.chain[s].moment += moment;
            }
            self.tooth_x[k] -= push.x;
            self.tooth_y[k] -= push.y;
            self.chain[s].force += push;
            self.chain[s].moment += teeth.arm_x[pair] * push.y - teeth.arm_y[pair] * push.x;
        }
    }

    /// Rollers, where they are bodies: what the teeth do to them; then the bushings have what they do in the teeth's place.
    fn accelerate_rollers(&mut self, model: &Model, rollers: &RollerContacts) {
        let Some(of) = &model.rollers else {
            return;
        };
        for k in 0..model.links {
            let push = rollers.force_on_roller(k);
            let [on_bushing, on_roller] = rollers.moments[k];
            let body = model.links + k;
            self.x[body] = (self.tooth_x[k] + push.x) / of.mass + model.gravity.x;
            self.y[body] = (self.tooth_y[k] + push.y) / of.mass + model.gravity.y;
            self.angle[body] = (self.tooth_moment[k] + on_roller) / of.inertia;
            [self.tooth_x[k], self.tooth_y[k]] = (-push).into();
            self.tooth_moment[k] = on_bushing;
        }
        for k in model.absent_rollers() {
            (self.x[model.links + k], self.y[model.links + k]) = (0.0, 0.0);
        }
    }

    /// Each link: the hinge at its front, the one at its rear, and its bushings' teeth where it is an inner one.
    fn accelerate_links(&mut self, model: &Model, motion: &Motion, hinges: &HingeContacts) {
        let n = model.links;
        for i in 0..n {
            let before = if i == 0 { n - 1 } else { i - 1 };
            let mut front = hinges.force_on_front(i);
            let mut rear = -hinges.force_on_front(before);
            if bushing_on_front(i, n) {
                front += Vec2::new(self.tooth_x[i], self.tooth_y[i]);
            }
            if !bushing_on_front(before, n) {
                rear += Vec2::new(self.tooth_x[before], self.tooth_y[before]);
            }
            let mut moment = model.arms[i]
                * (motion.cos[i] * (front.y - rear.y) - motion.sin[i] * (front.x - rear.x));
            if model.has_moments() {
                moment += hinges.moments[i][0] + hinges.moments[before][1];
                for k in [before, i] {
                    if model.link_of_bushing(k) == i {
                        moment += self.tooth_moment[k];
                    }
                }
            }
            self.x[i] = (front.x + rear.x) * model.inverse_mass[i] + model.gravity.x;
            self.y[i] = (front.y + rear.y) * model.inverse_mass[i] + model.gravity.y;
            self.angle[i] = moment * model.inverse_inertia[i];
        }
    }

    /// Ends of an open chain that move as they are told.
    fn move_ends(&mut self, model: &Model, hinges: &HingeContacts, t: f64) {
        let Some(ends) = &model.ends else { return };
        let n = model.links;
        for (force, end) in self.on_ends.iter_mut().zip(&ends.bodies) {
            let (i, before) = (end.body, (end.body + n - 1) % n);
            *force = hinges.force_on_front(i) - hinges.force_on_front(before);
            for k in [before, i] {
                if model.bushing_is_there(k) && model.link_of_bushing(k) == i {
                    *force += Vec2::new(self.tooth_x[k], self.tooth_y[k]);
                }
            }
            if let Some(given) = end.given_acceleration(t) {
                (self.x[i], self.y[i], self.angle[i]) = (given.x, given.y, 0.0);
            }
        }
    }

    fn accelerate_sprockets(&mut self, model: &Model, motion: &Motion, pawls: &[f64], t: f64) {
        for (s, sprocket) in model.sprockets.iter().enumerate() {
            let body = model.wheel_body(s);
            let moves = Moves::of(motion, body);
            let chain = &self.chain[s];
            let (center, angle) =
                sprocket_acceleration(sprocket, model.gravity, &moves, chain, pawls[s], t);
            self.x[body] = center.x;
            self.y[body] = center.y;
            self.angle[body] = angle;
        }
    }

    /// Torque on sprocket `s`, which turns at `spin` \[rad/s\], from its motor or load \[N m\]: what it takes to move it as it moves.
    #[must_use]
    pub fn shaft_torque(&self, model: &Model, s: usize, t: f64, spin: f64) -> f64 {
        let sprocket = &model.sprockets[s];
        match &sprocket.rotation {
            Rotation::Prescribed(speed) => sprocket.inertia * speed.slope(t) - self.chain[s].moment,
            Rotation::Free { .. } => sprocket.applied_torque(t, spin),
        }
    }
}

/// Where a sprocket's centre is \[m\], its velocity \[m/s\], the sprocket's angle \[rad\] and its rate \[rad/s\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moves {
    pub(crate) center: Vec2,
    pub(crate) velocity: Vec2,
    pub(crate) angle: f64,
    pub(crate) spin: f64,
}

impl Moves {
    pub(super) fn of(motion: &Motion, body: usize) -> Self {
        Self {
            center: Vec2::new(motion.x[body], motion.y[body]),
            velocity: Vec2::new(motion.vx[body], motion.vy[body]),
            angle: motion.angle[body],
            spin: motion.spin[body],
        }
    }
}

/// Acceleration of a sprocket's centre \[m/s²\] and of its angle \[rad/s²\].
pub(crate) fn sprocket_acceleration(
    sprocket: &SprocketModel,
    gravity: Vec2,
    moves: &Moves,
    chain: &SprocketLoad,
    pawl: f64,
    t: f64,
) -> (Vec2, f64) {
    let center = match sprocket.support {
        Support::Fixed => Vec2::zeros(),
        Support::Slide { guide, .. } => {
            let (s, tangent) = sprocket.slide_at(moves.center).unwrap_or_default();
            let speed = moves.velocity.dot(&tangent);
            let along = chain.force.dot(&tangent) + sprocket.pull(t) - guide.dashpot(speed) * speed
                + guide.force(s, pawl);
            let mass = sprocket.mass + guide.extra_mass;
            let weight = gravity.dot(&tangent) * (sprocket.mass / mass);
            let bend = guide.curvature * speed * speed;
            (along / mass + weight) * tangent + bend * turned_left(tangent)
        }
        Support::Floating { .. } => chain.force / sprocket.mass + gravity,
    };
    let angle = match &sprocket.rotation {
        Rotation::Prescribed(speed) => speed.slope(t),
        Rotation::Free { .. } => {
            let held = sprocket.swing.map_or(0.0, |swing| {
                swing.force(moves.angle - sprocket.phase, pawl)
                    - swing.dashpot(moves.spin) * moves.spin
            });
            (chain.moment + sprocket.applied_torque(t, moves.spin) + held) / sprocket.inertia
        }
    };
    (center, angle)
}

/// Powers of a sprocket's motor, applied torque and tensioner.
///
/// A sprocket of prescribed speed is a support: its own kinetic energy stays out of the balance, and the work done on the
/// drive is that of its teeth on the chain.
pub(crate) fn outside_powers(
    sprocket: &SprocketModel,
    moves: &Moves,
    chain: &SprocketLoad,
    t: f64,
) -> Powers {
    let spin = moves.spin;
    let mut powers = Powers {
        dissipated: 0.0,
        worked_in: match &sprocket.rotation {
            Rotation::Prescribed(_) => -chain.moment * spin,
            Rotation::Free { .. } => sprocket.applied_torque(t, spin) * spin,
        },
        ..Powers::default()
    };
    if let Some(swing) = sprocket.swing {
        powers.dissipated += swing.dashpot(spin) * spin * spin;
    }
    if let Support::Slide { guide, .. } = sprocket.support {
        let (_, tangent) = sprocket.slide_at(moves.center).unwrap_or_default();
        let speed = moves.velocity.dot(&tangent);
        powers.worked_in += sprocket.pull(t) * speed;
        powers.dissipated += guide.dashpot(speed) * speed * speed;
    }
    powers
}

//! What a run of a mechanism records: a row of each channel at every report time.

use super::peaks::Peaks;
use crate::chain::dynamics::Energy;
use crate::multibody::dynamics::MechanismDynamics;
use crate::run::recorder::{Balance, OpenBalance, Passed};

/// The rows of a run, one array a channel, time first.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MechanismRecording {
    /// Report times \[s\].
    pub time: Vec<f64>,
    /// (times, bodies, 3) \[m, m, rad\].
    pub positions: Vec<f64>,
    /// (times, bodies, 3) \[m/s, m/s, rad/s\].
    pub velocities: Vec<f64>,
    /// (times, bodies, 3) \[m/s², m/s², rad/s²\].
    pub accelerations: Vec<f64>,
    /// Force and torque of each joint on its body b about its point b, (times, joints, 3) \[N, N, N m\].
    pub reactions: Vec<f64>,
    /// Largest residual of each joint's equations, (times, joints) \[m or rad\].
    pub position_residual: Vec<f64>,
    /// Largest rate of each joint's equations, (times, joints) \[m/s or rad/s\].
    pub velocity_residual: Vec<f64>,
    /// Force of each contact, of all sides together, (times, contacts) \[N\].
    pub contact_force: Vec<f64>,
    /// The same on its circle, (times, contacts, 2) \[N\].
    pub contact_force_vector: Vec<f64>,
    /// Penetration of each contact, negative when apart, (times, contacts) \[m\].
    pub penetration: Vec<f64>,
    /// Gap of the teeth that each contact is near, from 0; -1: none, (times, contacts).
    pub contact_gap: Vec<i32>,
    /// Region of the tooth that each contact is near, 1 to 7; 0: none, (times, contacts).
    pub contact_region: Vec<i32>,
    /// Largest force of each joint since the row before, (times, joints) \[N\].
    pub peak_joint_force: Vec<f64>,
    /// Impulse of each joint since the row before, (times, joints) \[N s\].
    pub peak_joint_impulse: Vec<f64>,
    /// Largest normal force of each contact since the row before, (times, contacts) \[N\].
    pub peak_contact_force: Vec<f64>,
    /// Impulse of each contact since the row before, (times, contacts) \[N s\].
    pub peak_contact_impulse: Vec<f64>,
    /// Largest initial impact velocity of each contact that began since the row before; 0: none did, (times, contacts) \[m/s\].
    pub impact_velocity: Vec<f64>,
    /// Kinetic, gravity, elastic, dissipated, worked in, residual, (times, 6) \[J\].
    pub energy: Vec<f64>,
    /// Sums at the first row, and the energy that was there.
    reference: Option<[f64; 3]>,
    joints: Peaks,
    contacts: Peaks,
    /// Onsets that no row has yet: time, contact, initial impact velocity.
    onsets: Vec<(f64, usize, f64)>,
    balance: Balance,
}

impl MechanismRecording {
    /// Sets aside the forces at the end of a step, before reports inside it are evaluated; what is exchanged between two reports,
    /// as in a bounce, counts.
    pub(crate) fn arrive(&mut self, dynamics: &MechanismDynamics) {
        let (kinetic, gravity) = dynamics.energy();
        self.balance.take_in(Energy {
            kinetic,
            gravity,
            elastic: dynamics.loads.elastic + dynamics.loads.bristles,
        });
        self.joints.arrive(joint_forces(dynamics));
        self.contacts.arrive(contact_forces(dynamics));
    }

    /// Notes the onset of a contact at `t`, for the first row from then on.
    pub(crate) fn begin_contact(&mut self, t: f64, contact: usize, velocity: f64) {
        self.onsets.push((t, contact, velocity));
    }

    /// Writes the largest initial impact velocities up to a row at `t`.
    fn write_impact_velocities(&mut self, t: f64, contacts: usize) {
        let first = self.impact_velocity.len();
        self.impact_velocity.resize(first + contacts, 0.0);
        let row = &mut self.impact_velocity[first..];
        self.onsets.retain(|&(begun, contact, velocity)| {
            if begun <= t {
                row[contact] = row[contact].max(velocity);
            }
            begun > t
        });
    }

    /// Takes the forces set aside into the peaks: they belong to `t`.
    pub(crate) fn take_arrived(&mut self, t: f64) {
        self.joints.take_arrived(t);
        self.contacts.take_arrived(t);
    }

    /// Adds a row: the dynamics as evaluated at `t`, and the sums of the energy balance.
    pub(crate) fn report(&mut self, t: f64, dynamics: &MechanismDynamics, sums: [f64; 2]) {
        for (body, first) in dynamics.model.first.iter().enumerate().skip(1) {
            let frame = &dynamics.frames[body];
            self.positions
                .extend([frame.origin.x, frame.origin.y, frame.angle]);
            let velocity = [frame.velocity.x, frame.velocity.y, frame.spin];
            if let Some(i) = *first {
                self.velocities.extend(velocity);
                self.accelerations.extend(&dynamics.accelerations[i..i + 3]);
            } else {
                self.velocities.extend([0.0; 3]);
                self.accelerations.extend([0.0; 3]);
            }
        }
        for joint in 0..dynamics.model.joints.len() {
            self.reactions.extend(dynamics.reaction(joint));
        }
        let first = self.position_residual.len();
        let joints = dynamics.model.joints.len();
        self.position_residual.resize(first + joints, 0.0);
        self.velocity_residual.resize(first + joints, 0.0);
        for (equation, row) in dynamics.model.equations.iter().zip(&dynamics.rows) {
            let i = first + equation.joint;
            self.position_residual[i] = self.position_residual[i].max(equation.residual(row).abs());
            let rate = equation.residual_rate(row, &dynamics.frames).abs();
            self.velocity_residual[i] = self.velocity_residual[i].max(rate);
        }
        self.contact_force.extend(contact_forces(dynamics));
        let pushes = dynamics.pushes().flat_map(<[f64; 2]>::from);
        self.contact_force_vector.extend(pushes);
        self.write_impact_velocities(t, dynamics.model.contacts.len());
        let contacts = dynamics.model.contacts.iter();
        for (contact, sides) in contacts.zip(&dynamics.model.sides_of_contact) {
            let touches = &dynamics.touches[sides.clone()];
            let depth = touches.iter().map(|touch| touch.contact.penetration);
            let depth = depth.fold(f64::NEG_INFINITY, f64::max);
            self.penetration.push(if depth > 0.0 {
                depth
            } else {
                contact.penetration(&dynamics.frames, &dynamics.memory[sides.clone()])
            });
            let near = touches[0].tooth.map(|tooth| (tooth.gap, tooth.region));
            // A sprocket has few teeth.
            self.contact_gap
                .push(near.map_or(-1, |(gap, _)| gap.cast_signed()));
            self.contact_region
                .push(near.map_or(0, |(_, region)| i32::from(region)));
        }
        self.joints.close(
            t,
            joint_forces(dynamics),
            [&mut self.peak_joint_force, &mut self.peak_joint_impulse],
        );
        self.contacts.close(
            t,
            contact_forces(dynamics),
            [&mut self.peak_contact_force, &mut self.peak_contact_impulse],
        );
        let (kinetic, gravity) = dynamics.energy();
        let elastic = dynamics.loads.elastic + dynamics.loads.bristles;
        // Friction's work is what is lost and what bristles store.
        let sums = [sums[0] - dynamics.loads.bristles, sums[1]];
        let total = kinetic + gravity + elastic;
        let [dissipated, worked_in, start] =
            *self.reference.get_or_insert([sums[0], sums[1], total]);
        let (dissipated, worked_in) = (sums[0] - dissipated, sums[1] - worked_in);
        let residual = total - start + dissipated - worked_in;
        self.energy
            .extend([kinetic, gravity, elastic, dissipated, worked_in, residual]);
        let energy = Energy {
            kinetic,
            gravity,
            elastic,
        };
        let passed = Passed {
            dissipated,
            worked_in,
            residual,
        };
        self.balance.report(t, energy, passed);
        // Last of all: a row that a panic has cut short does not count.
        self.time.push(t);
    }

    /// The energy balance of the rows so far, when its residual is larger than it may be.
    pub(crate) fn open_balance(&self) -> Option<OpenBalance> {
        self.balance.open(0.0)
    }
}

/// Magnitude of each joint's force \[N\].
fn joint_forces(dynamics: &MechanismDynamics) -> impl Iterator<Item = f64> {
    (0..dynamics.model.joints.len()).map(|joint| {
        let [x, y, _] = dynamics.reaction(joint);
        x.hypot(y)
    })
}

fn contact_forces(dynamics: &MechanismDynamics) -> impl Iterator<Item = f64> {
    dynamics.pushes().map(|push| push.norm())
}

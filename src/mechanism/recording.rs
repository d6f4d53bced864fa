//! What a run of a mechanism records: a row of each channel at every report time.

use super::dynamics::MechanismDynamics;

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
    /// Normal force of each contact, (times, contacts) \[N\].
    pub contact_force: Vec<f64>,
    /// Penetration of each contact, negative when apart, (times, contacts) \[m\].
    pub penetration: Vec<f64>,
    /// Kinetic, gravity, elastic, dissipated, worked in, residual, (times, 6) \[J\].
    pub energy: Vec<f64>,
    /// Sums at the first row, and the energy that was there.
    reference: Option<[f64; 3]>,
}

impl MechanismRecording {
    /// Adds a row: the dynamics as evaluated at `t`, and the sums of the energy balance.
    pub(super) fn report(&mut self, t: f64, dynamics: &MechanismDynamics, sums: [f64; 2]) {
        self.time.push(t);
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
            self.position_residual[i] = self.position_residual[i].max(row.value.abs());
            let rate = row.rate(&dynamics.frames).abs();
            self.velocity_residual[i] = self.velocity_residual[i].max(rate);
        }
        for touch in &dynamics.touches {
            self.contact_force.push(touch.force);
            self.penetration.push(touch.contact.penetration);
        }
        let (kinetic, gravity) = dynamics.energy();
        let elastic = dynamics.loads.elastic;
        let total = kinetic + gravity + elastic;
        let [dissipated, worked_in, start] =
            *self.reference.get_or_insert([sums[0], sums[1], total]);
        let (dissipated, worked_in) = (sums[0] - dissipated, sums[1] - worked_in);
        let residual = total - start + dissipated - worked_in;
        self.energy
            .extend([kinetic, gravity, elastic, dissipated, worked_in, residual]);
    }
}

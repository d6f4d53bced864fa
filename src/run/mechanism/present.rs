//! A run at one instant: at its present time, inside its last step, or at a state of one's own.

use super::recording::MechanismRecording;
use super::simulation::{ITERATIONS, MechanismSimulation};
use crate::error::{Error, Result};
use crate::integrator::OdeSystem;
use crate::multibody::assembly::projection::AtHand;
use crate::multibody::contact::impact_memory::Memory;
use crate::multibody::description::body::{Body, Frame};
use crate::multibody::dynamics::{MechanismDynamics, Stabilisation};

impl MechanismSimulation {
    /// The dynamics at the present time, evaluated.
    pub fn present(&mut self) -> &MechanismDynamics {
        self.look_at(self.now);
        &self.dynamics
    }

    /// A recording of the present time alone.
    pub fn row(&mut self) -> MechanismRecording {
        self.look_at(self.now);
        let mut recording = MechanismRecording::default();
        recording.report(self.now, &self.dynamics, [0.0; 2]);
        recording
    }

    /// Positions (false) or velocities (true) of all bodies at the present time, ground left out.
    pub fn motion(&mut self, velocities: bool) -> Vec<[f64; 3]> {
        self.look_at(self.now);
        let of = |frame: &Frame| {
            if velocities {
                [frame.velocity.x, frame.velocity.y, frame.spin]
            } else {
                [frame.origin.x, frame.origin.y, frame.angle]
            }
        };
        self.dynamics.frames[1..].iter().map(of).collect()
    }

    /// Largest residual of positions and of velocities where the last step ended.
    pub fn drift(&mut self) -> [f64; 2] {
        let t = self.adams.time();
        self.read(t);
        let inside = std::mem::take(&mut self.inside);
        self.dynamics.place(&inside);
        self.inside = inside;
        self.dynamics.find_rows(t);
        let (rows, frames) = (&self.dynamics.rows, &self.dynamics.frames);
        [
            rows.iter().map(|row| row.value.abs()).fold(0.0, f64::max),
            rows.iter()
                .map(|row| row.rate(frames).abs())
                .fold(0.0, f64::max),
        ]
    }

    /// The dynamics at another state, evaluated; the run stays as it is. What is given replaces the present value.
    ///
    /// Three numbers a body, the ground left out; bodies that are held stay where they are. The state is taken as it is, on
    /// the constraints or not. With positions given, no contact has a memory.
    ///
    /// # Errors
    /// When there are not as many rows as bodies, or a number is not finite.
    pub fn evaluate_elsewhere(
        &mut self,
        positions: Option<&[[f64; 3]]>,
        velocities: Option<&[[f64; 3]]>,
        time: Option<f64>,
    ) -> Result<MechanismDynamics> {
        self.look_at(self.now);
        let (mut dynamics, mut state) = (self.dynamics.clone(), self.inside.clone());
        let n = dynamics.model.coordinates();
        for (field, given, begin) in [("positions", positions, 0), ("velocities", velocities, n)] {
            let Some(given) = given else { continue };
            check_rows(&dynamics.model.bodies[1..], field, given)?;
            for (row, first) in given.iter().zip(&dynamics.model.first[1..]) {
                if let Some(i) = *first {
                    state[begin + i..begin + i + 3].copy_from_slice(row);
                }
            }
        }
        if positions.is_some() {
            dynamics.memory.fill(Memory::default());
            dynamics.bristles.deflection.fill(0.0);
        }
        let time = time.unwrap_or(self.now);
        dynamics.evaluate(time, &state);
        Ok(dynamics)
    }

    /// Reads the state at `t` inside the last step: the dense output and the part of the shift that belongs there.
    pub(crate) fn read(&mut self, t: f64) {
        let end = self.adams.time();
        self.inside.resize(self.dynamics.dimension(), 0.0);
        if t == end {
            self.inside.copy_from_slice(self.adams.y());
        } else {
            self.adams.interpolate(t, &mut self.inside);
        }
        self.dynamics.take_bristles(&mut self.inside);
        let part = part_of_step(self.step_start, end, t);
        let n = self.dynamics.model.coordinates();
        let (length, since) = (end - self.step_start, t - self.step_start);
        let (before, after) = (&self.shift_before, &self.dynamics.shift);
        for (i, (x, after)) in self.inside.iter_mut().zip(after).enumerate() {
            // The shift of coordinates grows by that of their velocities; projection has changed what it came to.
            let growth = if i < n { before[n + i] } else { 0.0 };
            let change = after - (before[i] + length * growth);
            *x += before[i] + since * growth + part * change;
        }
    }

    /// Evaluates the dynamics at `t` inside the last step, on the constraints.
    pub(crate) fn look_at(&mut self, t: f64) {
        self.read(t);
        let mut inside = std::mem::take(&mut self.inside);
        if self.dynamics.stabilisation == Stabilisation::Projection {
            self.dynamics
                .project(t, &mut inside, ITERATIONS, AtHand::Nothing);
        }
        // What came out from behind in this step was still there before its end.
        let out = |k: usize| self.was_behind(k) && t < self.adams.time();
        let out: Vec<usize> = (0..self.dynamics.memory.len())
            .filter(|&k| out(k))
            .collect();
        let kept: Vec<Memory> = out.iter().map(|&k| self.dynamics.memory[k]).collect();
        for &k in &out {
            self.dynamics.memory[k] = Memory::BEHIND;
        }
        self.dynamics.evaluate(t, &inside);
        for (k, memory) in out.into_iter().zip(kept) {
            self.dynamics.memory[k] = memory;
        }
        self.inside = inside;
    }
}

impl MechanismDynamics {
    /// A recording of the last state evaluated, without its time.
    #[must_use]
    pub fn row(&self) -> MechanismRecording {
        let mut recording = MechanismRecording::default();
        recording.report(f64::NAN, self, [0.0; 2]);
        recording
    }

    /// Force of each contact on its circle \[N\].
    #[must_use]
    pub fn contact_forces(&self) -> Vec<[f64; 2]> {
        self.pushes().map(<[f64; 2]>::from).collect()
    }
}

fn part_of_step(start: f64, end: f64, t: f64) -> f64 {
    if end > start {
        ((t - start) / (end - start)).clamp(0.0, 1.0)
    } else {
        1.0
    }
}

/// One row of finite numbers for each body.
fn check_rows(bodies: &[Body], field: &str, rows: &[[f64; 3]]) -> Result<()> {
    if rows.len() != bodies.len() {
        return Err(Error::invalid(
            field,
            format!("{} rows", rows.len()),
            format!(
                "needs one row (3 numbers) for each of the {} bodies",
                bodies.len()
            ),
        ));
    }
    for (body, row) in bodies.iter().zip(rows) {
        if let Some(bad) = row.iter().find(|value| !value.is_finite()) {
            let field = format!("{field} of {}", body.name);
            return Err(Error::invalid(field, bad, "must be finite numbers"));
        }
    }
    Ok(())
}

//! The complete state of a run of a mechanism, as a value and as bytes: a run set to it goes on to the same bits.

use serde::{Deserialize, Serialize};

use super::simulation::MechanismSimulation;
use crate::error::{Error, Result};
use crate::integrator::{Adams, Progress};
use crate::multibody::contact::event_screening::ContactEnd;
use crate::multibody::contact::impact_memory::Memory;
use crate::multibody::model::MechanismModel;

/// What the bytes begin with: a name and a version, another one for every change of what they hold.
const MAGIC: &[u8; 24] = b"rustchain mechanism  006";

/// All that decides how a run goes on, and what it is of.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct MechanismSnapshot {
    /// Hash over all numbers of the model.
    model: u64,
    stabilisation: String,
    now: f64,
    step_start: f64,
    shift: Vec<f64>,
    shift_before: Vec<f64>,
    memory: Vec<Memory>,
    starts: Vec<ContactEnd>,
    onsets: u64,
    integrator: Adams,
}

impl MechanismSnapshot {
    /// The state as bytes, for [`Self::from_bytes`]: magic, content, checksum.
    ///
    /// # Errors
    /// None that a state can give; the encoder has them for other types.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let content = postcard::to_allocvec(self)
            .map_err(|error| Error::Impossible(format!("the state cannot be encoded: {error}")))?;
        let mut bytes = [MAGIC, content.as_slice()].concat();
        let sum = hash(&bytes);
        bytes.extend(sum.to_le_bytes());
        Ok(bytes)
    }

    /// The state that [`Self::to_bytes`] wrote.
    ///
    /// # Errors
    /// When the bytes hold no state of this version, or were damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let refuse = |expected: &str| {
            let value = format!("{} bytes", bytes.len());
            Error::invalid("state", value, expected)
        };
        let rest = bytes.strip_prefix(MAGIC).ok_or_else(|| {
            refuse("hold no state of a mechanism that this rustchain reads: pass what `state` gave")
        })?;
        let damaged = || refuse("are damaged: take the state, or copy its file, once more");
        let (content, sum) = rest.split_last_chunk().ok_or_else(damaged)?;
        if hash(&bytes[..bytes.len() - sum.len()]) != u64::from_le_bytes(*sum) {
            return Err(damaged());
        }
        match postcard::take_from_bytes(content) {
            Ok((snapshot, [])) => Ok(snapshot),
            _ => Err(damaged()),
        }
    }
}

impl MechanismSimulation {
    /// The complete state: [`restore`](Self::restore) goes on from it to the same bits.
    #[must_use]
    pub fn snapshot(&self) -> MechanismSnapshot {
        let dynamics = &self.dynamics;
        MechanismSnapshot {
            model: fingerprint(&dynamics.model),
            stabilisation: format!("{:?}", dynamics.stabilisation),
            now: self.now,
            step_start: self.step_start,
            shift: dynamics.shift.clone(),
            shift_before: self.shift_before.clone(),
            memory: dynamics.memory.clone(),
            starts: dynamics.starts.clone(),
            onsets: self.onsets,
            integrator: self.adams.clone(),
        }
    }

    /// Goes on from `snapshot`, as the simulation did that it was taken of.
    ///
    /// # Errors
    /// When the state is of another mechanism, solver or stabilisation, or while a recording is under way; the simulation is
    /// then what it was.
    pub fn restore(&mut self, snapshot: &MechanismSnapshot) -> Result<()> {
        if self.reports.is_some() {
            return Err(Error::Impossible(
                "state: a recording is under way: take it before a state is set".to_string(),
            ));
        }
        let own = self.snapshot();
        let same = |field: &str, same: bool, expected: &str| {
            let of = format!("of another {field}");
            same.then_some(())
                .ok_or_else(|| Error::invalid(format!("state, {field}"), of, expected))
        };
        same(
            "mechanism",
            snapshot.model == own.model && snapshot.memory.len() == own.memory.len(),
            "make the simulation with the mechanism of the state, described the same, in the same order",
        )?;
        same(
            "stabilisation",
            snapshot.stabilisation == own.stabilisation,
            "make the simulation with the stabilisation of the state",
        )?;
        same(
            "Solver",
            snapshot.integrator.control() == own.integrator.control(),
            "make the simulation with the solver of the state",
        )?;
        let whole = snapshot.integrator.is_like(&own.integrator)
            && snapshot.shift.len() == own.shift.len()
            && snapshot.shift_before.len() == own.shift_before.len()
            && snapshot.starts.len() == own.starts.len()
            && snapshot.now <= snapshot.integrator.time();
        if !whole {
            return Err(Error::invalid(
                "state",
                "its content",
                "contradicts itself: take the state once more",
            ));
        }
        let mut adams = snapshot.integrator.clone();
        adams.use_instructions(self.adams.instructions());
        self.adams = adams;
        self.defect = None;
        self.progress = Progress::from(self.adams.counts(), self.adams.time());
        self.forget_accepted();
        (self.now, self.step_start) = (snapshot.now, snapshot.step_start);
        self.onsets = snapshot.onsets;
        self.dynamics.shift.clone_from(&snapshot.shift);
        // A shift is written where a step ends.
        self.dynamics.shift_time = self.adams.time();
        self.shift_before.clone_from(&snapshot.shift_before);
        self.dynamics.memory.clone_from(&snapshot.memory);
        self.dynamics.starts.clone_from(&snapshot.starts);
        Ok(())
    }
}

/// Hash over all that a run of `model` depends on: debug text has every bit of its numbers.
fn fingerprint(model: &MechanismModel) -> u64 {
    let bodies = (&model.bodies, &model.gravity, &model.equations, &model.pins);
    hash(format!("{:?}", (bodies, &model.forces, &model.contacts)).as_bytes())
}

/// FNV-1a, 64 bits (Fowler, Noll, Vo): the same on every machine.
fn hash(bytes: &[u8]) -> u64 {
    let step = |hash: u64, &byte: &u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, step)
}

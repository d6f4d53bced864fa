//! Complete state of a run, as a value and as bytes: restored in another process, the run continues with the same bits.

use serde::{Deserialize, Serialize};

use super::Simulation;
use crate::chain::dynamics::Dynamics;
use crate::error::{Error, Result};
use crate::integrator::{Adams, Progress, StepControl};
use crate::system::{Identity, System, hash};

/// First bytes of a state.
const MAGIC: &[u8; 16] = b"rustchain state\n";

/// Version of the format; every change of the content has a new version.
const VERSION: u32 = 24;

/// Complete state of a run, with the integrator's history, the impact velocity memory and the identity of its model.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Snapshot<S: System = Dynamics> {
    /// Kind of the system; first, so that it can be read from a state of another kind.
    kind: String,
    /// Properties that identify the model: name and value.
    identity: Vec<(String, String)>,
    now: f64,
    integrator: Adams,
    system: S::Checkpoint,
}

impl<S: System> Snapshot<S> {
    /// Return the state as bytes, for [`Self::from_bytes`]: magic, version, content, checksum.
    ///
    /// # Errors
    /// None for a state; the encoder has errors for other types.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let content = postcard::to_allocvec(self)
            .map_err(|error| Error::Impossible(format!("the state cannot be encoded: {error}")))?;
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(content);
        let sum = hash(&bytes);
        bytes.extend(sum.to_le_bytes());
        Ok(bytes)
    }

    /// Return the state written by [`Self::to_bytes`].
    ///
    /// # Errors
    /// If the bytes contain no state, a state of an unknown version, or a damaged one.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let refuse = |expected: &str| {
            let value = format!("{} bytes", bytes.len());
            Error::invalid("state", value, expected)
        };
        let rest = bytes.strip_prefix(MAGIC);
        let (version, rest) = rest
            .and_then(<[u8]>::split_first_chunk)
            .ok_or_else(|| refuse("hold no state of rustchain; expected the value of `state()`"))?;
        let version = u32::from_le_bytes(*version);
        if version != VERSION {
            return Err(Error::invalid(
                "version of the state",
                version,
                format!("this rustchain reads version {VERSION}: use the one that wrote the state"),
            ));
        }
        let damaged = || refuse("are damaged: take the state, or copy its file, once more");
        let (content, sum) = rest.split_last_chunk().ok_or_else(damaged)?;
        if hash(&bytes[..bytes.len() - sum.len()]) != u64::from_le_bytes(*sum) {
            return Err(damaged());
        }
        let (kind, _): (String, _) = postcard::take_from_bytes(content).map_err(|_| damaged())?;
        same(
            "kind",
            kind.as_str(),
            S::KIND,
            "make the simulation with what the state is of",
        )?;
        match postcard::take_from_bytes(content) {
            Ok((snapshot, [])) => Ok(snapshot),
            _ => Err(damaged()),
        }
    }
}

impl<S: System> Simulation<S> {
    /// Return the complete state, from which [`restore`](Self::restore) continues with the same bits.
    ///
    /// It excludes an active recording and wall times. Both machines must fuse products and sums, or neither: the bits differ between the
    /// instruction set `plain` and the others (decision 18).
    #[must_use]
    pub fn snapshot(&self) -> Snapshot<S> {
        let identity = self.system.identity().into_iter();
        Snapshot {
            kind: S::KIND.to_string(),
            identity: identity
                .map(|Identity { field, value, .. }| (field.to_string(), value))
                .collect(),
            now: self.now,
            integrator: self.adams.clone(),
            system: self.system.checkpoint(),
        }
    }

    /// Continue from `snapshot` as the original simulation did; wall times continue from their present values.
    ///
    /// # Errors
    /// If the state belongs to another model or another control, or a recording is active; the simulation is then unchanged.
    pub fn restore(&mut self, snapshot: &Snapshot<S>) -> Result<()> {
        if self.recorder.is_some() {
            return Err(Error::Impossible(
                "state: a recording is under way: take it before a state is set".to_string(),
            ));
        }
        for (own, (_, state)) in self.system.identity().iter().zip(&snapshot.identity) {
            same(own.field, state, &own.value, own.remedy)?;
        }
        check_control(&snapshot.integrator.control(), &self.adams.control())?;
        let mut adams = snapshot.integrator.clone();
        adams.use_instructions(self.adams.instructions());
        let sound =
            adams.is_like(&self.adams) && snapshot.now.is_finite() && snapshot.now <= adams.time();
        let system = sound.then(|| self.system.restored(&snapshot.system, &adams));
        let Some(mut system) = system.flatten() else {
            return Err(Error::invalid(
                "state",
                "its content",
                "is inconsistent: take the state once more",
            ));
        };
        self.defect = None;
        system.resume_metering(&adams);
        (self.system, self.adams, self.now) = (system, adams, snapshot.now);
        self.progress = Progress::from(self.adams.counts(), self.adams.time());
        Ok(())
    }
}

fn check_control(state: &StepControl, own: &StepControl) -> Result<()> {
    let remedy = "make the simulation with the solver of the state";
    let (method, own_method) = (state.corrector.name(), own.corrector.name());
    same("Solver.method", method, own_method, remedy)?;
    for (field, state, own) in [
        ("Solver.accuracy", state.accuracy, own.accuracy),
        ("Solver.rtol", state.rtol, own.rtol),
        ("Solver.atol", state.atol, own.atol),
        ("Solver.max_step", state.max_step, own.max_step),
    ] {
        // With an exponent: 1e-10 in place of 0.0000000001.
        same(field, &format!("{state:e}"), &format!("{own:e}"), remedy)?;
    }
    same("Solver.max_order", &state.max_order, &own.max_order, remedy)
}

fn same<T: PartialEq + ToString + ?Sized>(
    field: &str,
    state: &T,
    own: &T,
    remedy: &str,
) -> Result<()> {
    if state == own {
        return Ok(());
    }
    let expected = format!("the simulation has {}: {remedy}", own.to_string());
    Err(Error::invalid(
        format!("state, {field}"),
        state.to_string(),
        expected,
    ))
}

//! The complete state of a run, as a value and as bytes: set in another process, the run goes on to the same bits.

use std::fmt::Write;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::Simulation;
use crate::chain::dynamics::Carried;
use crate::chain::model::{ContactLaw, Input, Model};
use crate::error::{Error, Result};
use crate::force_law::{Friction, LuGre};
use crate::integrator::{Adams, Progress, StepControl};

/// What the bytes begin with.
const MAGIC: &[u8; 16] = b"rustchain state\n";

/// Version of the bytes; another one for every change of what they hold.
const VERSION: u32 = 10;

/// All that decides how a run goes on, the integrator's history and the contacts' memory included; which model it is of.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Snapshot {
    scene: Scene,
    now: f64,
    inputs: Vec<Input>,
    integrator: Adams,
    dynamics: Carried,
}

/// What a state is of: enough to know it again, and to say what differs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Scene {
    links: usize,
    teeth: Vec<u32>,
    hinge_law: String,
    tooth_law: String,
    min_approach_speed: f64,
    /// Hash over all numbers of the model.
    model: u64,
}

impl Snapshot {
    /// The state as bytes, for [`Self::from_bytes`]: magic, version, content, checksum.
    ///
    /// # Errors
    /// None that a state can give; the encoder has them for other types.
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

    /// The state that [`Self::to_bytes`] wrote.
    ///
    /// # Errors
    /// When the bytes hold no state, one of an unknown version, or one that was damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let refuse = |expected: &str| {
            let value = format!("{} bytes", bytes.len());
            Error::invalid("state", value, expected)
        };
        let rest = bytes.strip_prefix(MAGIC);
        let (version, rest) = rest
            .and_then(<[u8]>::split_first_chunk)
            .ok_or_else(|| refuse("hold no state of rustchain: pass what `state` gave"))?;
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
        match postcard::take_from_bytes(content) {
            Ok((snapshot, [])) => Ok(snapshot),
            _ => Err(damaged()),
        }
    }
}

impl Simulation {
    /// The complete state: [`restore`](Self::restore) goes on from it to the same bits.
    ///
    /// Not in it: a recording under way and wall times.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            scene: Scene::of(&self.compiled),
            now: self.now,
            inputs: self.inputs.clone(),
            integrator: self.adams.clone(),
            dynamics: self.dynamics.carried(),
        }
    }

    /// Goes on from `snapshot`, as the simulation did that it was taken of; wall times go on from where they are.
    ///
    /// # Errors
    /// When the state is of another drive, other laws or another control, or while a recording is under way; the simulation
    /// is then what it was.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<()> {
        if self.recorder.is_some() {
            return Err(Error::Impossible(
                "state: a recording is under way: take it before a state is set".to_string(),
            ));
        }
        snapshot.scene.check(&Scene::of(&self.compiled))?;
        check_control(&snapshot.integrator.control(), &self.adams.control())?;
        let mut adams = snapshot.integrator.clone();
        adams.use_instructions(self.adams.instructions());
        let model = self.compiled.with_inputs(&snapshot.inputs).map(Arc::new);
        let dynamics = model.and_then(|model| self.dynamics.carrying(model, &snapshot.dynamics));
        let dynamics = dynamics.filter(|_| {
            adams.is_like(&self.adams) && snapshot.now.is_finite() && snapshot.now <= adams.time()
        });
        let Some(mut dynamics) = dynamics else {
            return Err(Error::invalid(
                "state",
                "its content",
                "contradicts itself: take the state once more",
            ));
        };
        self.defect = None;
        dynamics.resume_metering(&adams);
        (self.dynamics, self.adams, self.now) = (dynamics, adams, snapshot.now);
        self.inputs.clone_from(&snapshot.inputs);
        self.progress = Progress::from(self.adams.counts(), self.adams.time());
        self.kink = f64::NEG_INFINITY;
        Ok(())
    }
}

impl Scene {
    fn of(model: &Model) -> Self {
        let law = |law: &ContactLaw, friction: Option<Friction>, bristles: Option<LuGre>| {
            let damping = if law.lambda > 0.0 {
                "damped"
            } else {
                "undamped"
            };
            let regions = format!("{:?}", law.regions).to_lowercase();
            let friction = friction.map_or(String::new(), |friction| {
                let name = friction.regularization.name();
                format!(", friction {} ({name})", friction.coefficient)
            });
            let bristles = bristles.map_or(String::new(), |law: LuGre| {
                let (most, least) = (law.static_coefficient, law.kinetic_coefficient);
                format!(", bristles {most} to {least}")
            });
            let elastic = law.elastic.name();
            format!("{elastic}, {damping}, regions {regions}{friction}{bristles}")
        };
        Self {
            links: model.links,
            teeth: model.sprockets.iter().map(|s| s.profile.teeth).collect(),
            hinge_law: law(&model.hinge_law, model.hinge_friction, model.hinge_bristles)
                + &model.hinge_film.map_or(String::new(), |film| {
                    format!(", film of {} Pa s", film.viscosity)
                }),
            tooth_law: law(&model.tooth_law, model.tooth_friction, model.tooth_bristles),
            min_approach_speed: model.min_approach_speed,
            model: fingerprint(model),
        }
    }

    /// Names the first thing in which `self`, of a state, is not what the simulation has.
    fn check(&self, simulation: &Self) -> Result<()> {
        let drive = "make the simulation with the drive of the state";
        let law = "make the simulation with the laws of the state";
        let (state, own) = (self, simulation);
        same("links", state.links, own.links, drive)?;
        let teeth = |scene: &Self| format!("{:?}", scene.teeth);
        same("teeth", teeth(state), teeth(own), drive)?;
        same("hinge law", &state.hinge_law, &own.hinge_law, law)?;
        same("tooth law", &state.tooth_law, &own.tooth_law, law)?;
        same(
            "min_impact_velocity",
            state.min_approach_speed,
            own.min_approach_speed,
            law,
        )?;
        let model = |scene: &Self| format!("model {:016x}", scene.model);
        same(
            "drive",
            model(state),
            model(own),
            "some number of drive, start or laws differs, or the version of rustchain: make the simulation with those of \
             the state",
        )
    }
}

fn check_control(state: &StepControl, own: &StepControl) -> Result<()> {
    let remedy = "make the simulation with the solver of the state";
    let (method, own_method) = (state.corrector.name(), own.corrector.name());
    same("Solver.method", method, own_method, remedy)?;
    same("Solver.accuracy", state.accuracy, own.accuracy, remedy)?;
    same("Solver.rtol", state.rtol, own.rtol, remedy)?;
    same("Solver.atol", state.atol, own.atol, remedy)?;
    same("Solver.max_step", state.max_step, own.max_step, remedy)?;
    same("Solver.max_order", state.max_order, own.max_order, remedy)
}

#[allow(clippy::needless_pass_by_value)] // numbers and text alike
fn same<T: PartialEq + ToString>(field: &str, state: T, own: T, remedy: &str) -> Result<()> {
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

/// Hash over all numbers of `model`. Its debug text has every field, also one that is added later, and every bit of its numbers.
fn fingerprint(model: &Model) -> u64 {
    let mut text = Hash::default();
    // A hash takes any text.
    let _ = write!(text, "{model:?}");
    text.0
}

/// FNV-1a, 64 bits (Fowler, Noll, Vo): the same on every machine; a single byte that is changed always changes it.
struct Hash(u64);

impl Default for Hash {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Hash {
    fn take(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

impl Write for Hash {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.take(text.as_bytes());
        Ok(())
    }
}

fn hash(bytes: &[u8]) -> u64 {
    let mut hash = Hash::default();
    hash.take(bytes);
    hash.0
}

//! Instance of an FMU: the variables, the phases and the steps of a co-simulation.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::contents::{Contents, GROUPS};
use crate::error::{Error, Result, check};
use crate::math::Signal;
use crate::run::simulation::{Simulation, Snapshot};
use crate::system::hash;

/// Largest distance between the time of the master and that of the instance, over the step size: accumulated rounding of the master.
/// It excludes a step that is repeated or left out, and may be doubled or halved.
const TIME_MISMATCH: f64 = 1e-3;

/// The same over the rounding of the time itself, for steps that are short beside it: master and instance add a start time in another order.
/// At most half of the step is allowed, so that none is repeated.
const ROUNDINGS_OF_TIME: f64 = 4.0;

/// Phase of an instance, the state machine of the standards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum Phase {
    Instantiated,
    Initialization,
    Step,
    Terminated,
    Failed,
}

impl Phase {
    fn name(self) -> &'static str {
        match self {
            Self::Instantiated => "instantiated, before its initialization",
            Self::Initialization => "in initialization mode",
            Self::Step => "in step mode",
            Self::Terminated => "terminated",
            Self::Failed => "in error",
        }
    }
}

/// Drive in a co-simulation.
///
/// Value references: 0 the time, then the inputs, then the outputs. An input acts from the communication point on at which it was set; an
/// input that was never set follows the description. Outputs are those of the last communication point.
#[derive(Debug, Clone)]
pub struct Instance {
    contents: Contents,
    /// Instantiation token of the contents.
    token: String,
    simulation: Simulation,
    phase: Phase,
    /// Time of the master at the time zero of the simulation \[s\].
    offset: f64,
    /// Time of the master past which there are no steps \[s\].
    stop: Option<f64>,
    inputs: Vec<f64>,
    /// Inputs that were set since the last step.
    set: Vec<bool>,
    outputs: Vec<f64>,
}

/// State of an instance: of its simulation and of its variables.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct InstanceState {
    /// Instantiation token of the FMU.
    token: String,
    simulation: Vec<u8>,
    phase: Phase,
    offset: f64,
    inputs: Vec<f64>,
    set: Vec<bool>,
    outputs: Vec<f64>,
    stop: Option<f64>,
}

impl InstanceState {
    /// Return the state as bytes, for [`Self::from_bytes`].
    ///
    /// # Errors
    /// None for a state; the encoder has errors for other types.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let mut bytes = postcard::to_allocvec(self).map_err(|error| {
            Error::Impossible(format!("the state of the FMU cannot be encoded: {error}"))
        })?;
        let sum = hash(&bytes);
        bytes.extend(sum.to_le_bytes());
        Ok(bytes)
    }

    /// Return the state that [`Self::to_bytes`] encoded.
    ///
    /// # Errors
    /// If the bytes hold no state, or a damaged one.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let intact = (bytes.split_last_chunk())
            .filter(|(content, sum)| hash(content) == u64::from_le_bytes(**sum));
        let state = intact.and_then(|(content, _)| postcard::from_bytes(content).ok());
        state.ok_or_else(|| {
            let value = format!("{} bytes", bytes.len());
            let expected = "are no state of this FMU, or a damaged one: serialize it once more";
            Error::invalid("state", value, expected)
        })
    }
}

impl Instance {
    /// Return an instance at the start of the scene.
    ///
    /// # Errors
    /// If the scene is invalid, or an input or output does not exist in it.
    pub fn new(contents: Contents) -> Result<Self> {
        let simulation = contents.simulation()?;
        let (model, time) = (simulation.model(), simulation.time());
        let mut inputs = Vec::new();
        for input in &contents.inputs {
            let (sprocket, quantity) = (input.sprocket, input.quantity);
            let value = model.input_value(sprocket, quantity, time);
            inputs.push(value.unwrap_or_default());
            // The error says why there is no such input.
            let signal = Signal::Constant(value.unwrap_or_default());
            model.input(sprocket, quantity, signal, time)?;
        }
        let mut instance = Self {
            simulation,
            phase: Phase::Instantiated,
            offset: 0.0,
            stop: None,
            set: vec![false; inputs.len()],
            inputs,
            outputs: Vec::new(),
            token: contents.to_bytes()?.1,
            contents,
        };
        instance.advance_to(time)?;
        Ok(instance)
    }

    /// Return the time of the master \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.simulation.time() + self.offset
    }

    /// Return the values of all variables, in the order of the value references.
    #[must_use]
    pub fn values(&self) -> Vec<f64> {
        [&[self.time()], &*self.inputs, &*self.outputs].concat()
    }

    /// Return the value of the variable with this value reference.
    ///
    /// # Errors
    /// If there is no such variable.
    pub fn value(&self, reference: u32) -> Result<f64> {
        let value = self.values().get(reference as usize).copied();
        value.ok_or_else(|| {
            Error::invalid("value reference", reference, "is of no variable of the FMU")
        })
    }

    /// Set the input with this value reference; it acts from the next step on.
    ///
    /// # Errors
    /// If there is no such input, the value is out of its range, or the instance is terminated or in error.
    pub fn set_value(&mut self, reference: u32, value: f64) -> Result<()> {
        self.expect(
            &[Phase::Instantiated, Phase::Initialization, Phase::Step],
            "set an input",
        )?;
        let number = (reference as usize).checked_sub(1);
        let input = number.and_then(|number| Some((number, self.contents.inputs.get(number)?)));
        let Some((number, input)) = input else {
            self.value(reference)?;
            let expected = "is no input and cannot be set";
            return Err(Error::invalid("value reference", reference, expected));
        };
        let (model, time) = (self.simulation.model(), self.simulation.time());
        model.input(
            input.sprocket,
            input.quantity,
            Signal::Constant(value),
            time,
        )?;
        self.inputs[number] = value;
        self.set[number] = true;
        Ok(())
    }

    /// Set the time of the master at the start, and the one past which it makes no step, if there is one \[s\], before the initialization.
    ///
    /// # Errors
    /// If a time is not finite, the stop lies before the start, or the initialization has begun.
    pub fn set_times(&mut self, start: f64, stop: Option<f64>) -> Result<()> {
        self.expect(&[Phase::Instantiated], "set the start time")?;
        check::finite("start time", start, "s")?;
        if let Some(stop) = stop {
            check::finite("stop time", stop, "s")?;
            if stop < start {
                let expected = format!("must not lie before the start time, {start} s");
                return Err(Error::invalid("stop time", stop, expected));
            }
        }
        self.offset = start - self.simulation.time();
        self.stop = stop;
        Ok(())
    }

    /// Begin the initialization.
    ///
    /// # Errors
    /// If it has begun already.
    pub fn enter_initialization(&mut self) -> Result<()> {
        self.expect(&[Phase::Instantiated], "enter the initialization mode")?;
        self.phase = Phase::Initialization;
        Ok(())
    }

    /// End the initialization; steps may follow.
    ///
    /// # Errors
    /// If it has not begun.
    pub fn exit_initialization(&mut self) -> Result<()> {
        self.expect(&[Phase::Initialization], "exit the initialization mode")?;
        self.phase = Phase::Step;
        Ok(())
    }

    /// Advance from the communication point `time` by `size` \[s\], with the inputs that were set.
    ///
    /// # Errors
    /// If the instance is not in step mode or at another time, `size` is not positive, the step ends past the stop time, or the integrator
    /// cannot continue; in the last case the instance is in error until it is reset or another state is set.
    pub fn step(&mut self, time: f64, size: f64) -> Result<()> {
        self.expect(&[Phase::Step], "make a step")?;
        check::positive("communication step size", size, "s")?;
        check::finite("communication point", time, "s")?;
        let own = self.time();
        if (time - own).abs() > mismatch(size, own) {
            let expected =
                format!("the instance is at {own} s: continue from there, or set a state");
            return Err(Error::invalid("communication point", time, expected));
        }
        // Both standards: a computation past the stop time that the master defined is an error.
        let end = time + size;
        if let Some(stop) = self.stop.filter(|&stop| end - stop > mismatch(size, stop)) {
            let expected = format!(
                "is past the stop time, {stop} s: take a smaller step from {own} s, or reset the instance and give a later stop time"
            );
            return Err(Error::invalid("end of the step", end, expected));
        }
        let stepped = self.apply_inputs().and_then(|()| {
            let target = end - self.offset;
            check::finite("end of the step", target, "s")?;
            self.advance_to(target)
        });
        stepped.inspect_err(|_| self.phase = Phase::Failed)
    }

    /// End the co-simulation; values can still be read.
    ///
    /// # Errors
    /// If the instance is not in step mode.
    pub fn terminate(&mut self) -> Result<()> {
        self.expect(&[Phase::Step], "terminate")?;
        self.phase = Phase::Terminated;
        Ok(())
    }

    /// Return to the instance as it was made.
    ///
    /// # Errors
    /// As of [`Self::new`].
    pub fn reset(&mut self) -> Result<()> {
        *self = Self::new(self.contents.clone())?;
        Ok(())
    }

    /// Return the state.
    ///
    /// # Errors
    /// If the instance is in error.
    pub fn state(&self) -> Result<InstanceState> {
        if self.phase == Phase::Failed {
            return Err(self.refusal("get its state"));
        }
        self.simulation.check_intact()?;
        Ok(InstanceState {
            token: self.token.clone(),
            simulation: self.simulation.snapshot().to_bytes()?,
            phase: self.phase,
            offset: self.offset,
            inputs: self.inputs.clone(),
            set: self.set.clone(),
            outputs: self.outputs.clone(),
            stop: self.stop,
        })
    }

    /// Continue from `state` of this instance or of another one of the same FMU.
    ///
    /// # Errors
    /// If the state belongs to another FMU; the instance is then unchanged.
    pub fn set_state(&mut self, state: &InstanceState) -> Result<()> {
        if state.token != self.token {
            let expected = format!("belongs to another FMU: this one has {}", self.token);
            return Err(Error::invalid("state", &state.token, expected));
        }
        self.simulation
            .restore(&Snapshot::from_bytes(&state.simulation)?)?;
        self.phase = state.phase;
        self.offset = state.offset;
        self.inputs.clone_from(&state.inputs);
        self.set.clone_from(&state.set);
        self.outputs.clone_from(&state.outputs);
        self.stop = state.stop;
        Ok(())
    }

    fn apply_inputs(&mut self) -> Result<()> {
        for (number, input) in self.contents.inputs.iter().enumerate() {
            if std::mem::take(&mut self.set[number]) {
                let value = Signal::Constant(self.inputs[number]);
                self.simulation
                    .set_input(input.sprocket, input.quantity, value)?;
            }
        }
        Ok(())
    }

    /// Advance to `target` \[s\] and read the outputs there. The recording has the largest forces since the present time.
    fn advance_to(&mut self, target: f64) -> Result<()> {
        let simulation = &mut self.simulation;
        let whole = (target - simulation.time()).max(f64::MIN_POSITIVE);
        simulation.start_recording_until(target, whole, GROUPS);
        let advanced = simulation.advance(target, Duration::MAX);
        let recording = simulation.take_recording();
        advanced?;
        let outputs = self.contents.outputs.iter();
        self.outputs = outputs
            .map(|output| output.value_in(&recording))
            .collect::<Result<_>>()?;
        Ok(())
    }

    fn expect(&self, phases: &[Phase], action: &str) -> Result<()> {
        if phases.contains(&self.phase) {
            return Ok(());
        }
        Err(self.refusal(action))
    }

    fn refusal(&self, action: &str) -> Error {
        Error::Impossible(format!(
            "cannot {action}: the instance is {}; call the functions in the order of the standard, or reset it",
            self.phase.name()
        ))
    }
}

/// Return the difference of two times near `time` that counts as none beside a step of `size` \[s\].
fn mismatch(size: f64, time: f64) -> f64 {
    let rounding = ROUNDINGS_OF_TIME * f64::EPSILON * time.abs();
    (TIME_MISMATCH * size + rounding).min(0.5 * size)
}

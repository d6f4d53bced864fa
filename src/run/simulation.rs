//! The run: steps, onsets, reports.

mod balance;
mod inputs;
mod snapshot;
mod wall;

use std::sync::Arc;
use std::time::{Duration, Instant};

pub(crate) use balance::{describe_open_balance, tighter_accuracy};
pub use snapshot::Snapshot;
use wall::Wall;

use crate::chain::contact::ToothJump;
use crate::chain::dynamics::Dynamics;
use crate::chain::model::{Input, Model, Rotation, Support};
use crate::chain::motion::Motion;
use crate::drive::MOST_CHAIN_SPEED;
use crate::error::{Error, Result, check};
use crate::force_law::Regions;
use crate::geometry::Vec2;
use crate::integrator::{
    Adams, Corrector, Counts, MOST_STEPS, OdeSystem, Progress, StepControl, StepFailure,
};
use crate::layout::InitialConfiguration;
use crate::panics::guarded;
use crate::run::recorder::{Groups, OpenBalance, Recorder, Recording};

/// A drive being run.
#[derive(Debug, Clone)]
pub struct Simulation {
    /// The model as it was compiled.
    compiled: Arc<Model>,
    /// Speeds and torques that were set since, one a sprocket.
    inputs: Vec<Input>,
    dynamics: Dynamics,
    adams: Adams,
    start: InitialConfiguration,
    /// Present time of the user \[s\]; the integrator may be ahead by a part of a step.
    now: f64,
    recorder: Option<Recorder>,
    /// Scratch: state at a time inside the last step.
    inside: Vec<f64>,
    wall: Wall,
    /// The first recording whose energy balance did not close, in words.
    balance_note: Option<String>,
    progress: Progress,
    /// Next kink of a speed or torque \[s\], once it is known.
    kink: f64,
    /// The panic that the run ended with.
    defect: Option<Error>,
}

/// What a run has cost so far.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Statistics {
    /// Steps, rejected steps, evaluations.
    pub counts: Counts,
    /// Evaluations that metering the energy took, which are not among those of the counts.
    pub meter_evaluations: u64,
    /// Contacts begun.
    pub onsets: u64,
    /// Those that began slower than the floor of the approach speed.
    pub onsets_at_floor: u64,
    /// Contacts that closed and opened again inside a step, within the accuracy, and were let pass.
    pub unseen_touches: u64,
    /// Wall time in steps \[s\]; its share is that in the steps that were timed, one of 16.
    pub wall_stepping: f64,
    /// Wall time in finding onsets and metering energy, likewise \[s\].
    pub wall_onsets: f64,
    /// Wall time in reports \[s\].
    pub wall_reports: f64,
}

/// How often the wall clock is looked at, in steps.
const STEPS_BETWEEN_CLOCK_READINGS: u32 = 64;

/// A step in so many is timed.
const STEPS_FOR_ONE_TIMED: u32 = 16;

/// Speed of links that counts as rest, over the error allowed to speeds: drives that rest in static equilibrium move at up to 1.3 times
/// that error. At twice this number, drives that move at six times the error would not be judged by their energy.
const SPEEDS_AT_REST: f64 = 3.0;

/// A kink nearer than this is not stepped to \[s\].
const SHORTEST_TO_KINK: f64 = 1e-10;

impl Simulation {
    /// A run of `model` from `start` at time zero.
    ///
    /// # Errors
    /// When a control or the start does not fit.
    pub fn new(
        model: Arc<Model>,
        start: &InitialConfiguration,
        control: StepControl,
    ) -> Result<Self> {
        control.validate()?;
        check_start(&model, start)?;
        let compiled = Arc::clone(&model);
        let mut dynamics = Dynamics::new(model);
        let dimension = dynamics.dimension();
        let mut y = vec![0.0; dimension];
        let mut motion = Motion::new(dynamics.model().bodies());
        motion.set(&start.positions, &start.velocities);
        motion.write(dynamics.model(), &mut y);
        dynamics.remember_present_contacts(0.0, &y);
        check_hinges(&dynamics)?;
        check_rollers(&dynamics)?;
        if control.corrector != Corrector::Pece {
            // Makes the room for the matrix, which a run that changes correctors would otherwise make under way.
            dynamics.make_room_for_newton();
        }
        let mut adams = Adams::new(dimension, control);
        adams.restart(0.0, &y);
        let mut simulation = Self {
            compiled,
            inputs: Vec::new(),
            dynamics,
            adams,
            start: start.clone(),
            now: 0.0,
            recorder: None,
            inside: y,
            wall: Wall::default(),
            balance_note: None,
            progress: Progress::default(),
            kink: f64::NEG_INFINITY,
            defect: None,
        };
        simulation.limit_step();
        Ok(simulation)
    }

    /// The model, with the speeds and torques that hold now.
    #[must_use]
    pub fn model(&self) -> &Arc<Model> {
        self.dynamics.model()
    }

    /// Present time \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.now
    }

    /// The dynamics, evaluated at the present time.
    pub fn present(&mut self) -> &Dynamics {
        self.adams.interpolate(self.now, &mut self.inside);
        self.dynamics.evaluate(self.now, &self.inside);
        &self.dynamics
    }

    /// Where the run began.
    #[must_use]
    pub fn start(&self) -> &InitialConfiguration {
        &self.start
    }

    /// The integrator.
    #[must_use]
    pub fn integrator(&self) -> &Adams {
        &self.adams
    }

    /// Positions and velocities of all bodies at the present time.
    #[must_use]
    pub fn motion(&self) -> Motion {
        let mut motion = Motion::new(self.model().bodies());
        let mut y = vec![0.0; self.inside.len()];
        self.adams.interpolate(self.now, &mut y);
        motion.read(self.model(), self.now, &y);
        motion
    }

    /// The dynamics as they were last evaluated, with the contacts' memory.
    #[must_use]
    pub fn dynamics(&self) -> &Dynamics {
        &self.dynamics
    }

    /// What the run has cost so far.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        let onsets = self.dynamics.memory.counts();
        let [wall_stepping, wall_onsets] = self.wall.steps();
        Statistics {
            counts: self.adams.counts(),
            meter_evaluations: self.dynamics.meter_evaluations(),
            onsets: onsets.onsets,
            onsets_at_floor: onsets.at_floor,
            unseen_touches: self.dynamics.unseen_touches(),
            wall_stepping,
            wall_onsets,
            wall_reports: self.wall.reports.as_secs_f64(),
        }
    }

    /// Teeth that the chain has jumped up to the present time, in the order of time.
    #[must_use]
    pub fn tooth_jumps(&self) -> &[ToothJump] {
        let jumps = self.dynamics.tooth_jumps();
        // The integrator may be ahead of the present time.
        &jumps[..jumps.partition_point(|jump| jump.time <= self.now)]
    }

    /// Which laws left their range, a line each.
    #[must_use]
    pub fn range_notes(&self) -> Vec<String> {
        let model = self.model().range_notes.iter();
        model.chain(self.dynamics.past_range()).cloned().collect()
    }

    /// What the energy balance misses, in the first recording that has ended with more than it may, and what helps.
    ///
    /// The largest residual at a report may be a twentieth of the energy dissipated. Where less was dissipated than a hundredth of the
    /// energy exchanged, or 2e-4 of the kinetic and elastic energy, it may be a twentieth of that. Energy exchanged is the largest of
    /// the energies dissipated, worked in, and moved in and out of kinetic, gravitational and elastic energy.
    #[must_use]
    pub fn balance_note(&self) -> Option<&str> {
        self.balance_note.as_deref()
    }

    /// Dynamics evaluated at other positions and velocities, or another time, without touching the run.
    ///
    /// Positions that are just given have no contact memory.
    #[must_use]
    pub fn evaluate_elsewhere(
        &self,
        positions: Option<&[[f64; 3]]>,
        velocities: Option<&[[f64; 3]]>,
        time: Option<f64>,
    ) -> Dynamics {
        let mut dynamics = self.dynamics.clone();
        if positions.is_some() {
            dynamics.memory.clear();
            dynamics.bristles.clear();
        } else {
            let mut y = vec![0.0; self.inside.len()];
            self.adams.interpolate(self.now, &mut y);
            dynamics.bristles.read(self.model(), &y);
        }
        let present = self.motion();
        let (present_positions, present_velocities) = (present.positions(), present.velocities());
        dynamics.motion.set(
            positions.unwrap_or(&present_positions),
            velocities.unwrap_or(&present_velocities),
        );
        dynamics.evaluate_motion(time.unwrap_or(self.now));
        dynamics
    }

    /// Begins a recording at the present time.
    pub fn start_recording(&mut self, duration: f64, report_step: f64, groups: Groups) {
        if !groups.energy {
            self.dynamics.keep_energy(false);
        } else if !self.dynamics.keeps_energy() {
            self.dynamics.begin_metering(&self.adams);
        }
        let mut recorder = Recorder::new(self.model(), groups, self.now, duration, report_step);
        if groups.hinges || groups.teeth {
            // The present time may lie inside the last step, whose end then belongs to the first interval.
            self.dynamics
                .differentiate(self.adams.time(), self.adams.y());
            recorder.keep_step_forces(&self.dynamics);
        }
        self.recorder = Some(recorder);
    }

    /// Meters the energy balance in each step by `fineness` panels of four points, one at first, and in steps in which contacts
    /// begin or end by twice as many: what changes with it is the meter's own error.
    pub fn refine_meter(&mut self, fineness: usize) {
        self.dynamics.refine_meter(fineness);
    }

    /// Ends the recording and hands it over, with all rows made so far.
    pub fn take_recording(&mut self) -> Recording {
        let Some(recorder) = self.recorder.take() else {
            return Recording::default();
        };
        if self.balance_note.is_none() {
            let open = recorder.open_balance(self.kinetic_energy_at_rest());
            self.balance_note = open.map(|open| self.describe_balance(&open));
        }
        recorder.into_recording()
    }

    /// Kinetic energy of links that move by no more than steps may be wrong \[J\].
    fn kinetic_energy_at_rest(&self) -> f64 {
        let speed = SPEEDS_AT_REST * self.adams.control().speed_error();
        let model = self.model();
        let links = (0..model.links).filter(|&i| !model.is_held(i));
        let mass: f64 = links.map(|i| model.mass[i]).sum();
        0.5 * mass * speed * speed
    }

    fn describe_balance(&self, open: &OpenBalance) -> String {
        if self.model().tooth_law.regions == Regions::Sharp {
            describe_open_balance(open, balance::KEPT_REGIONS)
        } else {
            let finer = tighter_accuracy(&self.adams.control(), open);
            describe_open_balance(open, &finer)
        }
    }

    /// Goes on with the recording for as long as `budget` of wall time allows; true when its end is reached.
    ///
    /// # Errors
    /// When the integrator cannot go on: time, step size, body and contact.
    pub fn record(&mut self, budget: Duration) -> Result<bool> {
        let Some(end) = self.recorder.as_ref().map(Recorder::end) else {
            return Ok(true);
        };
        self.advance(end, budget)
    }

    /// Steps to exactly `target` \[s\] for as long as `budget` of wall time allows; true when it is reached.
    ///
    /// # Errors
    /// When the integrator cannot go on: time, step size, body and contact.
    pub fn advance(&mut self, target: f64, budget: Duration) -> Result<bool> {
        if self.recorder.is_none() {
            // Nobody reads the sums: a run that goes on without a recording does not make them.
            self.dynamics.keep_energy(false);
        }
        self.check_intact()?;
        let begin = Instant::now();
        let ended = guarded(|| self.advance_from(begin, target, budget));
        self.wall.runs += begin.elapsed();
        ended.unwrap_or_else(|message| {
            self.now = self.adams.time();
            let time = Some(self.now);
            self.defect = Some(Error::Panicked { time, message });
            self.check_intact().map(|()| false)
        })
    }

    /// After a panic in a step the state is that of no time.
    ///
    /// # Errors
    /// The panic that [`advance`](Self::advance) ended with, until another state is restored.
    pub fn check_intact(&self) -> Result<()> {
        self.defect.clone().map_or(Ok(()), Err)
    }

    fn advance_from(&mut self, begin: Instant, target: f64, budget: Duration) -> Result<bool> {
        let mut steps = 0u32;
        loop {
            if !self.report(begin, budget) {
                return Ok(false);
            }
            if target <= self.adams.time() {
                self.now = target.max(self.now);
                return Ok(true);
            }
            if steps.is_multiple_of(STEPS_BETWEEN_CLOCK_READINGS)
                && steps > 0
                && begin.elapsed() >= budget
            {
                self.now = self.adams.time();
                return Ok(false);
            }
            self.step(steps.is_multiple_of(STEPS_FOR_ONE_TIMED))?;
            self.watch_progress(target)?;
            steps += 1;
        }
    }

    fn step(&mut self, timed: bool) -> Result<()> {
        let begin = timed.then(Instant::now);
        self.dynamics.follow_with_pawls(self.adams.y());
        self.dynamics.unbend_parted(&mut self.adams);
        self.dynamics.begin_step();
        self.begin_anew_where_an_end_kinks();
        self.place_ends_on_their_curves();
        let step = self.adams.step_second_order(&mut self.dynamics);
        let step = match step {
            Ok(step) => step,
            Err(failure) => {
                self.now = self.adams.time();
                return Err(self.explain(failure));
            }
        };
        let stepped = timed.then(Instant::now);
        self.dynamics.finish_step(&self.adams, &step);
        self.limit_step();
        if let Some(recorder) = &mut self.recorder {
            recorder.keep_step_forces(&self.dynamics);
        }
        self.dynamics.meter_step(&self.adams, &step);
        if let (Some(begin), Some(stepped)) = (begin, stepped) {
            self.wall.take_in(stepped - begin, stepped.elapsed());
        }
        Ok(())
    }

    /// At a row of the velocity of an open chain's end, where its acceleration jumps: forgets the history, and puts the end where it
    /// should be. Its path is exact between two rows; what the step that ends there misses would be a velocity for good. A row is met by
    /// the step that ends at it or just before: those that end behind it have it behind them, however short they are.
    fn begin_anew_where_an_end_kinks(&mut self) {
        if self.model().ends.is_none() {
            return;
        }
        let model = Arc::clone(self.model());
        let Some(ends) = &model.ends else { return };
        let t = self.adams.time();
        let row = ends.next_knot(t * (1.0 - 2.0 * f64::EPSILON));
        if row - t <= SHORTEST_TO_KINK && t > 0.0 {
            self.adams.interpolate(t, &mut self.inside);
            let (n, coordinates) = (model.links, model.coordinates);
            for end in &ends.bodies {
                if let Some((place, velocity)) = end.given_motion(row) {
                    let i = end.body;
                    (self.inside[i], self.inside[n + i]) = (place.x, place.y);
                    self.inside[coordinates + i] = velocity.x;
                    self.inside[coordinates + n + i] = velocity.y;
                }
            }
            self.adams.restart_with_corrector(row, &self.inside);
            self.limit_step();
        }
    }

    /// Puts ends whose acceleration changes where they should be: what steps miss of their paths would add up.
    fn place_ends_on_their_curves(&mut self) {
        if self.model().ends.is_none() {
            return;
        }
        let model = Arc::clone(self.model());
        let (n, coordinates) = (model.links, model.coordinates);
        let ends = model.ends.iter().flat_map(|ends| &ends.bodies);
        for end in ends.filter(|end| end.follows_a_curve()) {
            let Some((place, velocity)) = end.given_motion(self.adams.time()) else {
                continue;
            };
            let x = end.body;
            let y = n + end.body;
            self.adams.set_component(x, place.x);
            self.adams.set_component(y, place.y);
            self.adams.set_component(coordinates + x, velocity.x);
            self.adams.set_component(coordinates + y, velocity.y);
        }
    }

    /// How long the next step may be: bodies that are fast, and the next kink of a speed or torque, where steps end.
    fn limit_step(&mut self) {
        let t = self.adams.time();
        // A kink that was met but for rounding is behind.
        if self.kink <= t + SHORTEST_TO_KINK {
            self.kink = self.model().next_kink(t + SHORTEST_TO_KINK);
        }
        let between = self.model().longest_step_between_kinks(t);
        let longest = self.dynamics.longest_step().min(self.kink - t);
        self.adams.limit_step(longest.min(between));
    }

    /// Makes the recording pause after each report, so that its caller can look at the state there: [`record`](Self::record) then
    /// returns, and goes on when it is called again.
    pub fn pause_at_reports(&mut self) {
        if let Some(recorder) = &mut self.recorder {
            recorder.pauses = true;
        }
    }

    /// The recording under way, if any.
    #[must_use]
    pub fn recording(&self) -> Option<&Recording> {
        self.recorder.as_ref().map(Recorder::recording)
    }

    /// Makes the reports that lie inside the last step; false when the budget ended before all were made, or at a pause.
    fn report(&mut self, start: Instant, budget: Duration) -> bool {
        let Self {
            recorder: Some(recorder),
            adams,
            dynamics,
            inside,
            ..
        } = self
        else {
            return true;
        };
        let end = adams.time();
        let mut paused = false;
        if recorder.next_report().is_some_and(|t| t <= end) {
            let begin = Instant::now();
            let needs = recorder.needs(dynamics.model());
            while let Some(t) = recorder.next_report().filter(|&t| t <= end) {
                adams.interpolate(t, inside);
                dynamics.evaluate_for(needs, t, inside);
                dynamics.watch_reported_ranges(needs);
                let sums = dynamics.energies_passed(t);
                recorder.report(t, dynamics, sums);
                self.now = t;
                paused = recorder.pauses;
                if paused || start.elapsed() >= budget {
                    break;
                }
            }
            self.wall.reports += begin.elapsed();
        }
        let complete = !paused && recorder.next_report().is_none_or(|t| t > end);
        if complete {
            recorder.take_step_forces(end);
        }
        complete
    }

    /// An error where the way to `target` \[s\] would take more steps than are worth waiting for.
    fn watch_progress(&mut self, target: f64) -> Result<()> {
        let (counts, time) = (self.adams.counts(), self.adams.time());
        let Some(step_size) = self.progress.stalled(counts, time, target) else {
            return Ok(());
        };
        self.now = time;
        let contact = self.dynamics.busiest_contact(self.model().links);
        Err(Error::Standstill {
            time,
            step_size,
            most_steps: MOST_STEPS,
            culprit: contact.unwrap_or_else(|| "nothing in contact".to_string()),
        })
    }

    fn explain(&mut self, failure: StepFailure) -> Error {
        failure.into_error(|time, component| self.culprit(time, component))
    }

    /// The body that a component of the state belongs to, and the hardest pressed of its contacts.
    fn culprit(&mut self, time: f64, component: usize) -> String {
        let model = Arc::clone(self.model());
        let body = model.body_of_coordinate(component % model.coordinates);
        // The last evaluation was that of the step that failed; failing that, what was there before it.
        let contact = self.dynamics.busiest_contact(body).or_else(|| {
            self.adams.interpolate(time, &mut self.inside);
            self.dynamics.differentiate(time, &self.inside);
            self.dynamics.busiest_contact(body)
        });
        format!(
            "{} ({})",
            model.body_names()[body],
            contact.unwrap_or_else(|| "not in contact".to_string())
        )
    }
}

/// A recording of `duration` \[s\] with rows `report_step` \[s\] apart.
///
/// # Errors
/// Names the field, its value and what is allowed.
pub fn check_reports(duration: f64, report_step: f64) -> Result<()> {
    check::positive("duration", duration, "s")?;
    check::positive("report_step", report_step, "s")?;
    if duration / report_step > 1e9 {
        return Err(Error::invalid(
            "report_step",
            report_step,
            "gives more than 1e9 reports: make it larger, or the duration shorter",
        ));
    }
    Ok(())
}

/// One row of finite numbers a body.
///
/// # Errors
/// Names the body and the number.
pub fn check_rows(model: &Model, field: &str, rows: &[[f64; 3]]) -> Result<()> {
    let bodies = model.bodies();
    if rows.len() != bodies {
        return Err(Error::invalid(
            field,
            format!("{} rows", rows.len()),
            format!("needs one row (3 numbers) for each of the {bodies} bodies"),
        ));
    }
    for (body, row) in rows.iter().enumerate() {
        if let Some(bad) = row.iter().find(|v| !v.is_finite()) {
            let name = &model.body_names()[body];
            return Err(Error::invalid(
                format!("{field} of {name}"),
                bad,
                "must be finite numbers",
            ));
        }
    }
    Ok(())
}

/// A pin may be pressed into its bushing, but must be in it.
fn check_hinges(dynamics: &Dynamics) -> Result<()> {
    let model = dynamics.model();
    // Where an open chain is open, the centres count as one.
    let apart = |k: usize| dynamics.hinges.penetration[k] + model.clearance;
    let Some(k) = (0..model.links).find(|&k| apart(k) > 0.1 * model.half_pitch) else {
        return Ok(());
    };
    Err(Error::invalid(
        "positions",
        format!(
            "{} and {}",
            model.link_name(k),
            model.link_name((k + 1) % model.links)
        ),
        format!(
            "hinge {} is torn: its pin and bushing are {:.3e} m apart, with a clearance of {:.3e} m",
            k + 1,
            apart(k),
            model.clearance
        ),
    ))
}

/// A bushing may be pressed into its roller, but must be in it.
fn check_rollers(dynamics: &Dynamics) -> Result<()> {
    let model = dynamics.model();
    let Some(rollers) = &model.rollers else {
        return Ok(());
    };
    let apart = |k: usize| dynamics.rollers.penetration[k] + rollers.clearance;
    let Some(k) = (0..model.links).find(|&k| apart(k) > 0.1 * model.half_pitch) else {
        return Ok(());
    };
    Err(Error::invalid(
        "positions",
        format!("roller_{}", k + 1),
        format!(
            "it is off its bushing: their centres are {:.3e} m apart, with a clearance of {:.3e} m",
            apart(k),
            rollers.clearance
        ),
    ))
}

/// What ends of an open chain are told must agree with the velocities.
fn check_ends(model: &Model, start: &InitialConfiguration) -> Result<()> {
    for end in model.ends.iter().flat_map(|ends| &ends.bodies) {
        let Some(given) = end.given_velocity(0.0) else {
            continue;
        };
        let [vx, vy, spin] = start.velocities[end.body];
        if (Vec2::new(vx, vy) - given).norm() > 1e-9 * given.norm().max(1.0) || spin != 0.0 {
            return Err(Error::invalid(
                format!("velocities of {}", model.link_name(end.body)),
                format!("({vx}, {vy}, {spin})"),
                format!(
                    "it moves as it is told: must be ({}, {}, 0) at the start",
                    given.x, given.y
                ),
            ));
        }
    }
    Ok(())
}

/// No body may begin faster than a drive may be described to run.
fn check_speeds(model: &Model, start: &InitialConfiguration) -> Result<()> {
    let field = |body: usize| format!("velocities of {}", model.body_names()[body]);
    for (body, [vx, vy, _]) in start.velocities.iter().enumerate() {
        if vx.hypot(*vy) > MOST_CHAIN_SPEED {
            return Err(Error::invalid(
                field(body),
                format!("({vx}, {vy})"),
                format!(
                    "expected at most {MOST_CHAIN_SPEED} m/s where real chains run below 50 m/s; check the unit"
                ),
            ));
        }
    }
    for (s, sprocket) in model.sprockets.iter().enumerate() {
        if let Some(bounds) = &sprocket.input_bounds {
            let body = model.wheel_body(s);
            bounds.check_speed(&field(body), start.velocities[body][2])?;
        }
    }
    Ok(())
}

/// Numbers, and what the supports and motors hold must agree with them.
fn check_start(model: &Model, start: &InitialConfiguration) -> Result<()> {
    check_rows(model, "positions", &start.positions)?;
    check_rows(model, "velocities", &start.velocities)?;
    check_ends(model, start)?;
    check_speeds(model, start)?;
    for (s, sprocket) in model.sprockets.iter().enumerate() {
        let body = model.wheel_body(s);
        let [vx, vy, spin] = start.velocities[body];
        let [x, y, _] = start.positions[body];
        let refuse = |value: String, expected: String| {
            Err(Error::invalid(
                format!("velocities of {}", model.body_names()[body]),
                value,
                expected,
            ))
        };
        match sprocket.support {
            Support::Fixed if vx != 0.0 || vy != 0.0 => {
                return refuse(
                    format!("({vx}, {vy})"),
                    "its bearing is fixed: must be (0, 0)".to_string(),
                );
            }
            Support::Slide { .. } => {
                // An arm turns its way: what counts is where the centre begins, not where it is described.
                let way = sprocket.slide_at(Vec2::new(x, y));
                let tangent = way.map_or(Vec2::zeros(), |(_, tangent)| tangent);
                let across = tangent.x * vy - tangent.y * vx;
                if across.abs() > 1e-9 * vx.hypot(vy) {
                    return refuse(
                        format!("({vx}, {vy})"),
                        format!(
                            "its tensioner lets it slide along ({}, {}) only, where it begins",
                            tangent.x, tangent.y
                        ),
                    );
                }
            }
            _ => {}
        }
        if let Rotation::Prescribed(speed) = &sprocket.rotation {
            let prescribed = speed.value(0.0);
            if (spin - prescribed).abs() > 1e-9 * prescribed.abs().max(1.0) {
                return refuse(
                    spin.to_string(),
                    format!("its speed is prescribed: must be {prescribed} rad/s at the start"),
                );
            }
        }
    }
    Ok(())
}

//! Chosen channels at the report times.

mod ends;
mod strands;

use crate::contact::ToothContacts;
use crate::dynamics::{Dynamics, Energy, Needs, Powers, Want};
use crate::geometry::Vec2;
use crate::model::{Model, Rotation};

/// Which groups of channels are recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[allow(clippy::struct_excessive_bools)] // independent switches
pub struct Groups {
    /// Force, penetration and eccentricity of every hinge, and of rollers on bushings, with peaks; strand tensions.
    pub hinges: bool,
    /// Deepest tooth contact of every bushing, with peaks.
    pub teeth: bool,
    /// Angle, speed, torque and centre of every sprocket.
    pub sprockets: bool,
    /// Positions and velocities of all bodies.
    pub bodies: bool,
    /// The energy balance.
    pub energy: bool,
}

/// Values of one channel, row after row.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Real numbers.
    Real(Vec<f64>),
    /// Whole numbers.
    Whole(Vec<i32>),
}

/// One recorded quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Its name.
    pub name: &'static str,
    /// Shape of one row; empty for a number.
    pub row_shape: Vec<usize>,
    /// All rows.
    pub values: Values,
}

/// What was recorded: one row of each channel at each time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recording {
    /// Report times \[s\].
    pub time: Vec<f64>,
    /// The channels.
    pub channels: Vec<Channel>,
}

/// Channels being written.
#[derive(Debug, Clone)]
pub(crate) struct Recorder {
    /// Whether the run pauses after each report.
    pub(crate) pauses: bool,
    groups: Groups,
    report_step: f64,
    begin: f64,
    end: f64,
    /// Index of the next report.
    next: u64,
    /// The energy balance at the first report.
    energy_at_start: Option<EnergyAtStart>,
    balance: Balance,
    recording: Recording,
    hinge_peaks: Peaks,
    tooth_peaks: Peaks,
    /// Of bushings in rollers, where those are bodies.
    roller_peaks: Peaks,
    tooth_forces: Vec<f64>,
}

/// Energy stored, and the sums of energy dissipated and worked in, when a recording begins \[J\].
#[derive(Debug, Clone, Copy)]
struct EnergyAtStart {
    total: f64,
    sums: Powers,
}

impl Recorder {
    pub(crate) fn new(
        model: &Model,
        groups: Groups,
        begin: f64,
        duration: f64,
        report_step: f64,
    ) -> Self {
        let mut recording = Recording::default();
        let mut add = |name: &'static str, row_shape: &[usize], whole: bool| {
            recording.channels.push(Channel {
                name,
                row_shape: row_shape.to_vec(),
                values: if whole {
                    Values::Whole(Vec::new())
                } else {
                    Values::Real(Vec::new())
                },
            });
        };
        let (n, s, bodies) = (model.links, model.sprockets.len(), model.bodies());
        if groups.hinges {
            add("hinge_force", &[n], false);
            add("hinge_force_vector", &[n, 2], false);
            add("hinge_penetration", &[n], false);
            add("hinge_eccentricity", &[n, 2], false);
            add("strand_tension", &[model.strands.len()], false);
            add("peak_hinge_force", &[n], false);
            add("peak_hinge_impulse", &[n], false);
            if model.hinge_film.is_some() {
                add("hinge_film_force", &[n], false);
            }
            if model.ends.is_some() {
                add("end_force", &[2, 2], false);
                add("end_position", &[2, 2], false);
                add("end_velocity", &[2, 2], false);
            }
        }
        if groups.hinges && model.rollers.is_some() {
            add("roller_force", &[n], false);
            add("roller_force_vector", &[n, 2], false);
            add("roller_penetration", &[n], false);
            add("roller_eccentricity", &[n, 2], false);
            add("peak_roller_force", &[n], false);
            add("peak_roller_impulse", &[n], false);
        }
        if groups.teeth {
            add("tooth_force", &[n], false);
            add("tooth_penetration", &[n], false);
            add("tooth_sprocket", &[n], true);
            add("tooth_index", &[n], true);
            add("tooth_region", &[n], true);
            add("peak_tooth_force", &[n], false);
            add("peak_tooth_impulse", &[n], false);
        }
        if groups.sprockets {
            add("sprocket_angle", &[s], false);
            add("sprocket_speed", &[s], false);
            add("sprocket_torque", &[s], false);
            add("sprocket_center", &[s, 2], false);
        }
        if groups.bodies {
            add("positions", &[bodies, 3], false);
            add("velocities", &[bodies, 3], false);
        }
        if groups.energy {
            for name in [
                "energy_kinetic",
                "energy_gravity",
                "energy_elastic",
                "energy_dissipated",
                "energy_worked_in",
                "energy_residual",
                "energy_hinge_contact",
                "energy_tooth_contact",
                "energy_hinge_friction",
                "energy_tooth_friction",
            ] {
                add(name, &[], false);
            }
            if model.rollers.is_some() {
                add("energy_roller_contact", &[], false);
                add("energy_roller_friction", &[], false);
            }
            if model.hinge_film.is_some() {
                add("energy_hinge_film", &[], false);
            }
        }
        Self {
            pauses: false,
            groups,
            report_step,
            begin,
            end: begin + duration,
            next: 0,
            energy_at_start: None,
            balance: Balance::default(),
            recording,
            hinge_peaks: Peaks::new(n, begin),
            tooth_peaks: Peaks::new(n, begin),
            roller_peaks: Peaks::new(model.roller_count(), begin),
            tooth_forces: vec![0.0; n],
        }
    }

    /// Time of the next report \[s\]; `None` when all are made. The last one lies exactly at the end.
    pub(crate) fn next_report(&self) -> Option<f64> {
        let t = self.begin + self.next as f64 * self.report_step;
        let rounding = 1e-9 * self.report_step;
        if t < self.end - rounding {
            Some(t)
        } else if self
            .recording
            .time
            .last()
            .is_none_or(|&last| last < self.end)
        {
            Some(self.end)
        } else {
            None
        }
    }

    /// What a row needs to know of the dynamics.
    pub(crate) fn needs(&self, model: &Model) -> Needs {
        let groups = self.groups;
        // A motor's torque is what the teeth leave to it; an applied one is known without them.
        let prescribed = |rotation: &Rotation| matches!(rotation, Rotation::Prescribed(_));
        let sprocket_loads =
            groups.sprockets && model.sprockets.iter().any(|s| prescribed(&s.rotation));
        let want = |forces: bool| match (forces, groups.energy) {
            (true, _) => Want::Forces,
            (false, true) => Want::Depths,
            (false, false) => Want::Nothing,
        };
        // What bristles store goes by the normal force.
        let stored = |law: bool| groups.energy && law;
        Needs {
            hinges: want(groups.hinges || stored(model.hinge_bristles.is_some())),
            teeth: want(groups.teeth || sprocket_loads || stored(model.tooth_bristles.is_some())),
            sprocket_loads,
        }
    }

    /// The energy balance at the last report, when more is missing than may be.
    pub(crate) fn open_balance(&self) -> Option<OpenBalance> {
        self.balance.open
    }

    pub(crate) fn end(&self) -> f64 {
        self.end
    }

    pub(crate) fn recording(&self) -> &Recording {
        &self.recording
    }

    pub(crate) fn into_recording(self) -> Recording {
        self.recording
    }

    /// Sets aside the forces at the end of a step, before reports inside it are evaluated.
    pub(crate) fn keep_step_forces(&mut self, dynamics: &Dynamics) {
        if self.groups.hinges {
            dynamics.write_hinge_forces(&mut self.hinge_peaks.arriving);
            dynamics.write_roller_forces(&mut self.roller_peaks.arriving);
        }
        if self.groups.teeth {
            dynamics.write_tooth_forces(&mut self.tooth_peaks.arriving);
        }
    }

    /// Takes the set-aside forces into the peaks.
    pub(crate) fn take_step_forces(&mut self, t: f64) {
        if self.groups.hinges {
            self.hinge_peaks.arrive(t);
            self.roller_peaks.arrive(t);
        }
        if self.groups.teeth {
            self.tooth_peaks.arrive(t);
        }
    }

    /// Writes a row for `dynamics` as evaluated at `t` for what [`Self::needs`] says; `sums` are its energies dissipated and worked
    /// in \[J\].
    pub(crate) fn report(&mut self, t: f64, dynamics: &Dynamics, sums: Powers) {
        let model = dynamics.model();
        let groups = self.groups;
        let energy = groups.energy.then(|| dynamics.energy());
        let first = self.recording.time.is_empty();
        self.recording.time.push(t);
        self.next += 1;
        let mut row = Row {
            channels: self.recording.channels.iter_mut(),
        };
        if groups.hinges {
            write_hinges(&mut row, dynamics);
            self.hinge_peaks
                .close(t, &dynamics.hinges.force, first, &mut row);
            if model.hinge_film.is_some() {
                row.real(dynamics.hinges.film.iter().map(Vec2::norm));
            }
            if let Some(ends) = &model.ends {
                ends::write(&mut row, dynamics, ends);
            }
        }
        if groups.hinges && model.rollers.is_some() {
            write_rollers(&mut row, dynamics);
            self.roller_peaks
                .close(t, &dynamics.rollers.force, first, &mut row);
        }
        if groups.teeth {
            write_teeth(
                &mut row,
                &dynamics.teeth,
                model.links,
                model.sprockets.len(),
            );
            gather_by_bushing(&dynamics.teeth, model.links, &mut self.tooth_forces);
            self.tooth_peaks
                .close(t, &self.tooth_forces, first, &mut row);
        }
        if groups.sprockets {
            let sprockets = model.wheel_body(0)..model.bodies();
            row.real(dynamics.motion.angle[sprockets.clone()].iter().copied());
            row.real(dynamics.motion.spin[sprockets.clone()].iter().copied());
            row.real((0..model.sprockets.len()).map(|s| {
                dynamics.accelerations.shaft_torque(
                    model,
                    s,
                    t,
                    dynamics.motion.spin[model.wheel_body(s)],
                )
            }));
            row.real(sprockets.flat_map(|body| [dynamics.motion.x[body], dynamics.motion.y[body]]));
        }
        if groups.bodies {
            row.real(dynamics.motion.positions().into_iter().flatten());
            row.real(dynamics.motion.velocities().into_iter().flatten());
        }
        if let Some(energy) = energy {
            let sums = dissipated_alone(sums, dynamics);
            let residual = write_energy(&mut row, model, energy, sums, &mut self.energy_at_start);
            let stored = OF_STORED * (energy.kinetic + energy.elastic);
            self.balance.watch(energy, residual, stored);
        }
    }
}

/// Channels of one row, in the order in which they were added.
struct Row<'a> {
    channels: std::slice::IterMut<'a, Channel>,
}

impl Row<'_> {
    fn real(&mut self, values: impl IntoIterator<Item = f64>) {
        if let Some(Channel {
            values: Values::Real(all),
            ..
        }) = self.channels.next()
        {
            all.extend(values);
        }
    }

    fn whole(&mut self, values: impl IntoIterator<Item = i32>) {
        if let Some(Channel {
            values: Values::Whole(all),
            ..
        }) = self.channels.next()
        {
            all.extend(values);
        }
    }
}

fn write_hinges(row: &mut Row, dynamics: &Dynamics) {
    let hinges = &dynamics.hinges;
    let n = hinges.force.len();
    row.real(hinges.force.iter().copied());
    row.real((0..n).flat_map(|k| <[f64; 2]>::from(hinges.force_on_pin(k))));
    row.real(hinges.penetration.iter().copied());
    row.real((0..n).flat_map(|k| <[f64; 2]>::from(hinges.eccentricity(k))));
    if dynamics.model().ends.is_some() {
        row.real(ends::tensions(dynamics));
    } else if dynamics.model().strands.len() == 2 {
        row.real(two_strand_tensions(dynamics));
    } else {
        row.real(strands::tensions(dynamics));
    }
}

fn write_rollers(row: &mut Row, dynamics: &Dynamics) {
    let rollers = &dynamics.rollers;
    let n = rollers.force.len();
    row.real(rollers.force.iter().copied());
    row.real((0..n).flat_map(|k| <[f64; 2]>::from(rollers.force_on_roller(k))));
    row.real(rollers.penetration.iter().copied());
    row.real(
        rollers
            .eccentricity
            .iter()
            .flat_map(|&e| <[f64; 2]>::from(e)),
    );
}

/// Mean pull along the chain of the hinges between the two sprockets: upper strand (left of the line from the first to the
/// second centre), lower strand \[N\].
fn two_strand_tensions(dynamics: &Dynamics) -> [f64; 2] {
    let (model, motion, hinges) = (dynamics.model(), &dynamics.motion, &dynamics.hinges);
    let n = model.links;
    let center = |s: usize| {
        let body = model.wheel_body(s);
        Vec2::new(motion.x[body], motion.y[body])
    };
    let line = center(1) - center(0);
    let distance = line.norm();
    let axis = line / distance;
    let [r1, r2] = [0, 1].map(|s| model.sprockets[s].profile.pitch_radius);
    // A common tangent leaves each pitch circle where its normal does.
    let cos = (r1 - r2) / distance;
    let between = (r1 * cos)..=(distance + r2 * cos);
    let (mut sums, mut counts) = ([0.0; 2], [0.0; 2]);
    for k in 0..n {
        let offset = hinges.bushing(k).0 - center(0);
        if !between.contains(&offset.dot(&axis)) {
            continue;
        }
        let next = (k + 1) % n;
        let along =
            Vec2::new(motion.x[next] - motion.x[k], motion.y[next] - motion.y[k]).normalize();
        let strand = usize::from(axis.x * offset.y - axis.y * offset.x < 0.0);
        sums[strand] += hinges.force_on_front(k).dot(&along);
        counts[strand] += 1.0;
    }
    [0, 1].map(|i| {
        if counts[i] > 0.0 {
            sums[i] / counts[i]
        } else {
            0.0
        }
    })
}

/// The deepest contact of every bushing.
#[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)] // few sprockets, gaps and regions
fn write_teeth(row: &mut Row, teeth: &ToothContacts, links: usize, sprockets: usize) {
    let deepest: Vec<(usize, f64)> = (0..links)
        .map(|k| {
            (0..sprockets)
                .map(|s| (s * links + k, teeth.penetration[s * links + k]))
                .fold((k, f64::NEG_INFINITY), |a, b| if b.1 > a.1 { b } else { a })
        })
        .collect();
    row.real(
        deepest
            .iter()
            .map(|&(pair, depth)| if depth > 0.0 { teeth.force[pair] } else { 0.0 }),
    );
    row.real(deepest.iter().map(|&(_, depth)| depth));
    row.whole(deepest.iter().map(|&(pair, depth)| {
        if depth > 0.0 {
            (pair / links + 1) as i32
        } else {
            0
        }
    }));
    row.whole(deepest.iter().map(|&(pair, depth)| {
        if depth > 0.0 {
            teeth.gap[pair] as i32
        } else {
            -1
        }
    }));
    row.whole(deepest.iter().map(|&(pair, depth)| {
        if depth > 0.0 {
            i32::from(teeth.region[pair])
        } else {
            0
        }
    }));
}

/// What passed since the first report, and what is missing \[J\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Passed {
    pub(crate) dissipated: f64,
    pub(crate) worked_in: f64,
    pub(crate) residual: f64,
}

/// `sums` without what bristles store of the work of friction.
fn dissipated_alone(mut sums: Powers, dynamics: &Dynamics) -> Powers {
    if !dynamics.model().bristles.is_empty() {
        let stored = dynamics.stored();
        sums.dissipated -= stored.total();
        sums.losses = stored.taken_off(sums.losses);
    }
    sums
}

fn write_energy(
    row: &mut Row,
    model: &Model,
    energy: Energy,
    sums: Powers,
    begin: &mut Option<EnergyAtStart>,
) -> Passed {
    let begin = begin.get_or_insert(EnergyAtStart {
        total: energy.total(),
        sums,
    });
    let since = sums + -1.0 * begin.sums;
    let (dissipated, worked_in) = (since.dissipated, since.worked_in);
    let residual = energy.total() - begin.total + dissipated - worked_in;
    for value in [
        energy.kinetic,
        energy.gravity,
        energy.elastic,
        dissipated,
        worked_in,
        residual,
    ] {
        row.real([value]);
    }
    let [
        hinges,
        teeth,
        hinges_rubbed,
        teeth_rubbed,
        rollers,
        rollers_rubbed,
        film,
    ] = since.losses.values();
    for loss in [hinges, teeth, hinges_rubbed, teeth_rubbed] {
        row.real([loss]);
    }
    // Places that this drive does not have have no channel.
    if model.rollers.is_some() {
        row.real([rollers]);
        row.real([rollers_rubbed]);
    }
    if model.hinge_film.is_some() {
        row.real([film]);
    }
    Passed {
        dissipated,
        worked_in,
        residual,
    }
}

/// Share of the energy dissipated that may be missing.
const OF_DISSIPATED: f64 = 0.05;

/// Share of the energy exchanged that may be missing besides.
const OF_EXCHANGED: f64 = 0.01;

/// Share of the kinetic and elastic energy there is that may be missing besides. In a short run that happens to be quiet, what steps
/// leave is more than was dissipated meanwhile: measured over 1200 runs of the published drive of 0.2 to 1 ms at the default accuracy,
/// the balances need up to 8e-6 besides the shares above; at ten times that accuracy a quarter of those without pretension need more
/// than this.
const OF_STORED: f64 = 1e-5;

/// An energy balance in which more is missing than may be \[J\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OpenBalance {
    pub(crate) missing: f64,
    pub(crate) dissipated: f64,
    pub(crate) exchanged: f64,
    pub(crate) allowed: f64,
}

/// Whether the energy balance closes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Balance {
    /// Least and largest kinetic energy at the reports so far \[J\].
    kinetic: Option<[f64; 2]>,
    /// Largest elastic energy \[J\].
    elastic: f64,
    /// The balance at the last report, where more is missing than may be.
    pub(crate) open: Option<OpenBalance>,
}

impl Balance {
    /// Takes in a report; `besides` may be missing whatever has passed \[J\].
    pub(crate) fn watch(&mut self, energy: Energy, passed: Passed, besides: f64) {
        let [least, most] = self.kinetic.unwrap_or([energy.kinetic; 2]);
        let (least, most) = (least.min(energy.kinetic), most.max(energy.kinetic));
        self.kinetic = Some([least, most]);
        self.elastic = self.elastic.max(energy.elastic);
        let exchanged = passed.dissipated + passed.worked_in.abs() + (most - least) + self.elastic;
        let allowed = OF_DISSIPATED * passed.dissipated + OF_EXCHANGED * exchanged + besides;
        self.open = (passed.residual.abs() > allowed).then_some(OpenBalance {
            missing: passed.residual,
            dissipated: passed.dissipated,
            exchanged,
            allowed,
        });
    }
}

/// Tooth force on every bushing \[N\], over all sprockets.
fn gather_by_bushing(teeth: &ToothContacts, links: usize, forces: &mut [f64]) {
    forces.fill(0.0);
    for &pair in &teeth.near {
        forces[pair as usize % links] += teeth.force[pair as usize];
    }
}

/// Largest force and impulse of every contact since the last report, from the forces at the ends of the steps.
#[derive(Debug, Clone)]
struct Peaks {
    time: f64,
    last: Vec<f64>,
    arriving: Vec<f64>,
    force: Vec<f64>,
    impulse: Vec<f64>,
}

impl Peaks {
    fn new(contacts: usize, t: f64) -> Self {
        let zeros = || vec![0.0; contacts];
        Self {
            time: t,
            last: zeros(),
            arriving: zeros(),
            force: zeros(),
            impulse: zeros(),
        }
    }

    /// Takes in the forces that have been set aside for time `t`.
    fn arrive(&mut self, t: f64) {
        let forces = std::mem::take(&mut self.arriving);
        self.account(t, &forces);
        self.arriving = forces;
    }

    fn account(&mut self, t: f64, forces: &[f64]) {
        let half = 0.5 * (t - self.time);
        for (i, &force) in forces.iter().enumerate() {
            self.force[i] = self.force[i].max(force);
            self.impulse[i] += half * (self.last[i] + force);
        }
        self.last.copy_from_slice(forces);
        self.time = t;
    }

    /// Ends an interval at a report with the forces there, writes it and begins the next.
    fn close(&mut self, t: f64, forces: &[f64], first: bool, row: &mut Row) {
        self.account(t, forces);
        if first {
            self.force.fill(0.0);
            self.impulse.fill(0.0);
        }
        row.real(self.force.iter().copied());
        row.real(self.impulse.iter().copied());
        self.force.copy_from_slice(forces);
        self.impulse.fill(0.0);
    }
}
